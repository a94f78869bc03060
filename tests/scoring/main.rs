//! Recognizers: training, scoring, quantisation, timing.

#[path = "../helpers/command.rs"]
mod command;
#[expect(dead_code, reason = "other targets also read the folder of more data")]
#[path = "../helpers/data.rs"]
mod data;
#[path = "../helpers/limits.rs"]
mod limits;
#[path = "../helpers/network.rs"]
mod network;
#[path = "../helpers/npy.rs"]
mod npy;
#[path = "../helpers/people.rs"]
mod people;
#[path = "../helpers/rows.rs"]
mod rows;
#[path = "../helpers/signals.rs"]
mod signals;
#[path = "../helpers/two.rs"]
mod two;

mod action;
mod alone;
mod baselines;
mod bench;
mod bench_path;
mod contracts;
mod first_limits;
mod gate;
mod literature;
mod mix;
mod parity;
mod protocols;
mod quantize;
mod score;
mod slow;
mod study;
mod train;
mod tree_sweep;
mod trees;
