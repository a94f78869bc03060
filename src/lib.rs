//! The EdgeGait host: everything around `edgegait-core` that needs a computer.
//!
//! Data flows one way, and each module uses only what is upstream of it:
//!
//! ```text
//! import -> scene -> encode -> [pack bytes, core] -> sweep -> dataset -> source -> train, score
//!        -> evaluate -> report
//! ```
//!
//! The [`guide`] has a page for each topic of the command. [`frontier`] measures what the whole chain costs and what it gets wrong, for the command;
//! [`mod@bench`] what a recognizer costs on the machine at hand.

pub mod bench;
pub mod cli;
pub mod confound;
pub mod dataset;
pub mod encode;
pub mod error;
pub mod evaluate;
pub mod frontier;
pub mod guide;
pub mod import;
mod named;
pub mod report;
pub mod scene;
pub mod score;
pub mod source;
pub mod summary;
pub mod sweep;
pub mod template;
pub mod train;
