//! Video to silhouettes: the command on made videos, and Jaccard on rendered ones.

#[path = "../helpers/command.rs"]
mod command;

mod made;
mod videos;
