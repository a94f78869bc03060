//! Figures that pages of the guide publish: each file names its page.
//!
//! `.ci/full` makes all of them. Tests in modules `with_data` also check bounds and take seconds, so
//! `.ci/run` runs them too. Those in modules `slow_of_data` need the same folder, and optimisation.

#[expect(dead_code, reason = "other targets also refuse and list")]
#[path = "../helpers/command.rs"]
mod command;
#[path = "../helpers/data.rs"]
mod data;
#[path = "../helpers/npy.rs"]
mod npy;
#[path = "../helpers/parts.rs"]
mod parts;
#[path = "../helpers/people.rs"]
mod people;
#[path = "../helpers/steps.rs"]
mod steps;

mod beside;
mod calipers;
mod cycles;
mod encoding_error;
mod framing;
mod likeness;
mod means;
mod populations;
mod posture;
mod rows;
mod skinned;
mod twins;
mod walker;
mod widths;
