//! Importing recordings, skeletons and bodies.

#[path = "../helpers/command.rs"]
mod command;
#[path = "../helpers/data.rs"]
mod data;
#[path = "../helpers/figure.rs"]
mod figure;
#[path = "../helpers/npy.rs"]
mod npy;
#[path = "../helpers/npz.rs"]
mod npz;
#[path = "../helpers/steps.rs"]
mod steps;

mod anthropometry;
mod bodies;
mod checksums;
mod clips;
mod faults;
mod feet;
mod floors;
mod formats;
mod gltf;
mod hard;
mod hard_files;
mod manifest;
mod markers;
mod mesh;
mod skeletons;
mod step_width;
