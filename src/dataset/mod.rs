//! A dataset: a folder of Gait Energy Images (GEI) that any tool can read.
//!
//! `geis.npy` holds the images (u8, `[N, 50, 30]`, or of another size), `index.csv` says for each of
//! them who walked, how, and from where it was seen, and `manifest.json` says
//! what made them and which bytes they are. NumPy and a spreadsheet open the
//! first two without us; the third lets a result be traced and repeated.

mod file;
mod header;
mod index;
mod npy;
mod reader;
mod tree;
mod writer;

pub use file::{sha256_of_bytes, sha256_of_file, write_atomically};
pub use header::{Header, InputFile, SCHEMA};
pub use index::IndexRow;
pub use npy::write_npy;
pub use reader::Dataset;
pub use tree::{Silhouettes, Tree, TreeSequence};
pub use writer::{DatasetWriter, Existing};

use serde::{Deserialize, Serialize};

const GEIS: &str = "geis.npy";
const INDEX: &str = "index.csv";
const MANIFEST: &str = "manifest.json";

/// What `manifest.json` says of a dataset: what made it, and which bytes it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// The command, its version, seed, inputs and settings.
    #[serde(flatten)]
    pub header: Header,
    /// GEIs in `geis.npy`, which is also the number of rows of `index.csv`.
    pub geis: usize,
    /// The other two files with their SHA-256. A dataset made elsewhere may
    /// leave them out: then its bytes are not checked.
    #[serde(default)]
    pub files: Vec<InputFile>,
}
