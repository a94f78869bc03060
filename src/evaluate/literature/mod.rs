//! Compares recognizers of the literature under each class of confounder.
//!
//! All are trained on some people, and judged on others.

mod contests;
mod garments;
mod recognizers;

pub(crate) use contests::{
    COLUMNS, CONTESTS, ClassRank1, ConfounderClass, ContestPlan, JudgedRecognizer, judge,
    judge_recorded,
};
pub(crate) use garments::Garments;
pub(crate) use recognizers::{FITTED, LiteratureRow, PublishedRecognizer};
