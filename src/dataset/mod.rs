//! A dataset: a folder of Gait Energy Images (GEI) or other templates that any tool can read.
//!
//! `geis.npy` holds the images (u8, `[N, 50, 30]`, or of another size), `index.csv` says for each of
//! them who walked, how, and from where it was seen, and `manifest.json` says
//! what made them and which bytes they are. NumPy and a spreadsheet open the
//! first two without us; the third lets a result be traced and repeated.
//!
//! Where the command `generate` made it, `walkers.csv` says of each walk of each person who that is:
//! sex, age, stature, mass, and what is worn.
//!
//! Other templates are in a file of their name, such as `mhi.npy` (`frequency.npy` is
//! `[N, 150, 30]`, three images one below the other; vectors are `[N, D]`), and the manifest names
//! them.

mod arrays;
mod checked_file;
mod contents;
mod existing;
mod header;
mod index;
mod items;
mod merge;
mod npy;
mod npz;
mod order;
mod partition;
mod reader;
mod sequences;
mod stated;
mod tree;
mod unfinished;
mod writer;

pub use super::files::{
    grey_png, hex, sha256_of_bytes, sha256_of_file, write_atomically, write_bytes,
};
pub use contents::{Array, Contents, DatasetFormat, Shard};
pub use existing::{Existing, check_replaceable};
pub use header::{InputFile, ResultHeader, SCHEMA};
pub use index::{IndexRow, WalkerRow, kmh};
pub use items::{DrawnItem, Items, PackBytes, PackItems};
pub use merge::merge;
pub use npy::write_npy;
pub use order::ItemOrder;
pub use partition::Partition;
pub use reader::Dataset;
pub(crate) use sequences::PARTITION as TREE_PARTITION;
pub use sequences::check_folder_name;
pub use tree::{Modality, Silhouettes, Tree, TreeLayout, TreeSequence, check_view_name, framed};
pub use unfinished::{check_unfinished, unfinished_work};
pub use writer::{DatasetRun, DatasetWriter, Item, UnfinishedRun, standing};

use crate::template::Template;
use serde::{Deserialize, Serialize};

const INDEX: &str = "index.csv";
const MANIFEST: &str = "manifest.json";
const WALKERS: &str = "walkers.csv";

/// What `manifest.json` says of a dataset: what made it, and which bytes it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// The command, its version, seed, inputs and settings.
    #[serde(flatten)]
    pub header: ResultHeader,
    /// Which template it holds; GEIs if it does not say.
    #[serde(default, skip_serializing_if = "is_gei")]
    pub template: Template,
    /// The others of the same silhouettes, each in the file of its name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub besides: Vec<Template>,
    /// Whether `joints.npy` and `keypoints.npy` are there.
    #[serde(default, skip_serializing_if = "is_false")]
    pub joints: bool,
    /// How it is written; a folder of arrays if it does not say.
    #[serde(default, skip_serializing_if = "is_folder")]
    pub format: DatasetFormat,
    /// Which part of the whole it is; the whole if it does not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<Shard>,
    /// GEIs in `geis.npy`, or templates in the file of their name, which is also the number of
    /// rows of `index.csv`.
    pub geis: usize,
    /// The other files with their SHA-256. A dataset made elsewhere may
    /// leave them out: then its bytes are not checked.
    #[serde(default)]
    pub files: Vec<InputFile>,
}

/// The name of the file that holds the templates.
fn file_of(template: Template) -> String {
    format!("{}.npy", contents::name_of(template))
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde calls it with a reference"
)]
const fn is_false(it: &bool) -> bool {
    !*it
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde calls it with a reference"
)]
fn is_folder(format: &DatasetFormat) -> bool {
    *format == DatasetFormat::Folder
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde calls it with a reference"
)]
fn is_gei(template: &Template) -> bool {
    *template == Template::Gei
}
