//! Tests of the command: arguments, output, files and errors.

#[path = "../helpers/command.rs"]
mod command;
#[path = "../helpers/figure.rs"]
mod figure;
#[path = "../helpers/npy.rs"]
mod npy;
#[path = "../helpers/recording.rs"]
mod recording;
#[path = "../helpers/rows.rs"]
mod rows;
#[path = "../helpers/signals.rs"]
mod signals;
#[path = "../helpers/two.rs"]
mod two;

mod clip_command;
mod commands;
mod designs;
mod digest;
mod exports;
mod faults;
mod guide;
mod keep_going;
mod kills;
mod looking;
mod made;
mod outputs;
mod people;
mod refusals;
mod resume;
