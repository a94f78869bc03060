//! Segmenting videos: the command on synthetic videos, and Jaccard indices on rendered ones.

#[path = "../helpers/command.rs"]
mod command;

mod made;
mod videos;
mod walkers;
