//! The parameters of one person's gait.

use super::anthropometry::Dimensions;
use super::style::Style;
use crate::people::Body;
use edgegait_core::pack::Sex;

/// The parameters of one person's gait.
#[derive(Clone, Copy, Debug)]
pub(super) struct GaitStyle<'a> {
    /// Body dimensions.
    pub dimensions: &'a Dimensions,
    /// The body of these dimensions.
    pub body: &'a Body,
    /// Deviations from the norm.
    pub style: &'a Style,
    /// Sex, on which the walk ratio depends.
    pub sex: Sex,
    /// Age, years.
    pub age_years: f64,
    /// Body mass index, kg/m2.
    pub bmi: f64,
}
