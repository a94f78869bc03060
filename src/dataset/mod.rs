//! Designs, datasets, trees of silhouettes, and the sequences of them that recognizers are shown.
//!
//! A dataset is a folder of Gait Energy Images (GEI) or other templates that any tool can read.
//! `geis.npy` holds the images (u8, `[N, 50, 30]` or another size). `index.csv` states the person,
//! walk and viewpoint of each. `manifest.json` states how they were made and their hashes, so that
//! a result can be traced and repeated. NumPy and a spreadsheet open the first two.
//!
//! The command `generate` also writes `walkers.csv`: sex, age, stature, mass and clothes of the
//! person in each walk.
//!
//! Other templates are in a file of their own name, such as `mhi.npy` (`frequency.npy` is
//! `[N, 150, 30]`, three images one below the other; vectors are `[N, D]`), and the manifest names
//! them.

mod arrays;
mod checked_file;
mod contents;
pub mod design;
mod existing;
pub mod gait_cycles;
mod index;
mod items;
mod manifest;
mod mask_numbers;
mod merge;
mod npy;
mod npz;
mod order;
mod partition;
mod pictures;
mod pixel_check;
mod reader;
pub mod sequences;
mod stated;
mod tree;
mod tree_writer;
mod unfinished;
mod writer;

pub use contents::{Array, Contents, DatasetFormat, Shard};
pub use existing::{Existing, check_replaceable};
pub use index::{IndexRow, WalkerRow, kmh};
pub use items::{DrawnItems, Items, PackBytes, PackItems};
pub use merge::merge;
pub use npy::write_npy;
pub use order::ItemOrder;
pub use partition::Partition;
pub use reader::Dataset;
pub use tree::{Modality, Silhouettes, Tree, TreeLayout, TreeSequence, check_view_name, framed};
pub(crate) use tree_writer::PARTITION as TREE_PARTITION;
pub use tree_writer::check_folder_name;
pub use unfinished::{check_unfinished, unfinished_work};
pub use writer::{DatasetRun, DatasetWriter, Item, UnfinishedRun, standing};

use crate::draw::template::Template;
use crate::files::{InputFile, ResultHeader};
use serde::{Deserialize, Serialize};

const INDEX: &str = "index.csv";
const MANIFEST: &str = "manifest.json";
const WALKERS: &str = "walkers.csv";

/// The contents of `manifest.json`: how a dataset was made, and the hashes of its files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// The command, its version, seed, inputs and settings.
    #[serde(flatten)]
    pub header: ResultHeader,
    /// The template that the dataset holds; GEI if not stated.
    #[serde(default, skip_serializing_if = "is_gei")]
    pub template: Template,
    /// Further templates of the same silhouettes, each in the file of its name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub besides: Vec<Template>,
    /// Whether `joints.npy` and `keypoints.npy` are there.
    #[serde(default, skip_serializing_if = "is_false")]
    pub joints: bool,
    /// The file format of the dataset; a folder of arrays if not stated.
    #[serde(default, skip_serializing_if = "is_folder")]
    pub format: DatasetFormat,
    /// The shard that the dataset is; none for a whole dataset.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<Shard>,
    /// The number of GEIs in `geis.npy`, or of templates in the file of their name, and of rows of
    /// `index.csv`.
    pub geis: usize,
    /// The other files with their SHA-256. A dataset made elsewhere may
    /// leave them out; its bytes are then not checked.
    #[serde(default)]
    pub files: Vec<InputFile>,
}

/// Returns the name of the file that holds a template.
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
