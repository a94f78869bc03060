//! Encoding of gait cycles and uncut motions into packs, and decoding.

#[path = "../helpers/command.rs"]
mod command;
#[path = "../helpers/data.rs"]
mod data;
#[path = "../helpers/limits.rs"]
mod limits;
#[path = "../helpers/recording.rs"]
mod recording;
#[path = "../helpers/two.rs"]
mod two;

mod chain;
mod frontier;
mod golden;
mod recorded;
mod tracks;
mod truth;
mod uncut;
mod uncut_oracle;
