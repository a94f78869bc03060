//! The guide: a page for each topic.
//!
//! Begin with [first steps](first_steps). `--help` of a command describes its flags.

#[doc = include_str!("architecture.md")]
pub mod architecture {}
#[doc = include_str!("boards.md")]
pub mod boards {}
#[doc = include_str!("changelog.md")]
pub mod changelog {}
#[doc = include_str!("confounders.md")]
pub mod confounders {}
#[doc = include_str!("contributing.md")]
pub mod contributing {}
#[doc = include_str!("cycles.md")]
pub mod cycles {}
#[doc = include_str!("datasets.md")]
pub mod datasets {}
#[doc = include_str!("designs.md")]
pub mod designs {}
#[doc = include_str!("drawing.md")]
pub mod drawing {}
#[doc = include_str!("encoding.md")]
pub mod encoding {}
#[doc = include_str!("first-steps.md")]
pub mod first_steps {}
#[doc = include_str!("formats.md")]
pub mod formats {}
#[doc = include_str!("gates.md")]
pub mod gates {}
#[doc = include_str!("importing.md")]
pub mod importing {}
#[doc = include_str!("literature.md")]
pub mod literature {}
#[doc = include_str!("models.md")]
pub mod models {}
#[doc = include_str!("networks.md")]
pub mod networks {}
#[doc = include_str!("people.md")]
pub mod people {}
#[doc = include_str!("protocols.md")]
pub mod protocols {}
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
