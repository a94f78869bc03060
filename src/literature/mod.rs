//! Recognizers of the literature beside each other: what each confounder leaves of them.
//!
//! All are trained with some people, and judged on others under each class of confounder.

mod contests;
mod garments;
mod recognizers;

pub(crate) use contests::{
    COLUMNS, CONTESTS, ClassRank1, ConfounderClass, ContestPlan, JudgedRecognizer, judge,
    judge_recorded,
};
pub(crate) use garments::Garments;
pub(crate) use recognizers::{FITTED, LiteratureRow, PublishedRecognizer};
