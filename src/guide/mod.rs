//! The guide: a page for each topic, for people who use the command.
//!
//! The README says how to begin, and `--help` what each flag does.

#[doc = include_str!("boards.md")]
pub mod boards {}
#[doc = include_str!("confounders.md")]
pub mod confounders {}
#[doc = include_str!("cycles.md")]
pub mod cycles {}
#[doc = include_str!("datasets.md")]
pub mod datasets {}
#[doc = include_str!("designs.md")]
pub mod designs {}
#[doc = include_str!("encoding.md")]
pub mod encoding {}
#[doc = include_str!("gates.md")]
pub mod gates {}
#[doc = include_str!("importing.md")]
pub mod importing {}
#[doc = include_str!("literature.md")]
pub mod literature {}
#[doc = include_str!("models.md")]
pub mod models {}
#[doc = include_str!("people.md")]
pub mod people {}
#[doc = include_str!("python.md")]
pub mod python {}
#[doc = include_str!("results.md")]
pub mod results {}
#[doc = include_str!("segmenting.md")]
pub mod segmenting {}
#[doc = include_str!("speed.md")]
pub mod speed {}
#[doc = include_str!("study.md")]
pub mod study {}
