//! Silhouettes, templates and confounders, as the command and the library draw them.

#[path = "../helpers/command.rs"]
mod command;
#[path = "../helpers/limits.rs"]
mod limits;
#[path = "../helpers/npy.rs"]
mod npy;
#[path = "../helpers/parts.rs"]
mod parts;
#[path = "../helpers/two.rs"]
mod two;

mod board;
mod columns;
mod confounders;
mod leave_out;
mod pictures;
mod seams;
mod skia;
mod templates;
