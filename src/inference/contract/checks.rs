//! Checks of the values in a contract.

use super::Contract;
use crate::draw::template::{Template, TemplateShape};
use crate::error::{Error, Result};
use crate::inference::InputLayout;
use std::path::Path;

/// The maximum number of rows, columns or frames of an input.
const MAX_SIDE: usize = 4096;
/// The maximum number of equal channels of an input.
const MAX_CHANNELS: usize = 16;

impl Contract {
    /// Checks all values; `path` is only for messages.
    ///
    /// # Errors
    /// If a value is invalid, or does not fit another one.
    pub fn check(&self, path: &Path) -> Result<()> {
        for (key, side) in [("rows", self.rows), ("columns", self.columns)] {
            if !(1..=MAX_SIDE).contains(&side) {
                return Err(Error::input(
                    path,
                    format!("{key}: expected 1 to {MAX_SIDE}, found {side}"),
                ));
            }
        }
        if !self.layout.holds(self.template) {
            let fitting = InputLayout::ALL
                .iter()
                .filter(|layout| layout.holds(self.template));
            let names: Vec<_> = fitting.map(|layout| layout.name()).collect();
            return Err(Error::input(
                path,
                format!(
                    "layout: template {:?} comes as {}, found {} (the default is {})",
                    self.template.name(),
                    names.join(", "),
                    self.layout.name(),
                    InputLayout::default().name()
                ),
            ));
        }
        self.check_channels()
            .map_err(|problem| Error::input(path, problem))?;
        if let Some(frames) = self.frames {
            let problem = match self.template {
                Template::Silhouettes => format!("expected 1 to {MAX_SIDE}"),
                template => format!("template {:?} has none", template.name()),
            };
            let is_sequence = self.template == Template::Silhouettes;
            if !is_sequence || !(1..=MAX_SIDE).contains(&frames) {
                return Err(Error::input(
                    path,
                    format!("frames: {problem}, found {frames}"),
                ));
            }
        }
        let angles = self.training.viewpoints.iter().flatten();
        if let Some(angle) = angles.copied().find(|angle| !angle.is_finite()) {
            return Err(Error::input(
                path,
                format!("viewpoints: expected degrees, found {angle}"),
            ));
        }
        self.check_view_distance()
            .map_err(|problem| Error::input(path, problem))?;
        if let Some(twice) = first_repeated(&self.classes) {
            return Err(Error::input(
                path,
                format!("classes: {twice:?} appears twice"),
            ));
        }
        Ok(())
    }
}

impl Contract {
    /// Checks the number of equal channels, and `mean` and `std` of each.
    pub(in crate::inference) fn check_channels(&self) -> std::result::Result<(), String> {
        let channels = self.channels;
        if !(1..=MAX_CHANNELS).contains(&channels) {
            return Err(format!(
                "channels: expected 1 to {MAX_CHANNELS}, found {channels}"
            ));
        }
        if channels > 1 && !self.layout.has_channels() {
            return Err(format!(
                "channels: layout {} has none, found {channels} (NCHW, NHWC, NTCHW and NCTHW have)",
                self.layout.name()
            ));
        }
        let is_one_image = matches!(self.shape(), TemplateShape::Image { planes: 1, .. });
        if channels > 1 && !is_one_image {
            return Err(format!(
                "channels: template {:?} has its own, found {channels}",
                self.template.name()
            ));
        }
        for (key, numbers) in [("mean", &self.mean), ("std", &self.std)] {
            if numbers.len() > 1 && numbers.len() != channels {
                return Err(format!(
                    "{key}: expected one number, or one for each of {channels} channels, found {}",
                    numbers.len()
                ));
            }
            let is_bad = |number: &&f32| !number.is_finite() || key == "std" && **number <= 0.0;
            if let Some(bad) = numbers.iter().find(is_bad) {
                let expected = if key == "std" {
                    "numbers above 0"
                } else {
                    "finite numbers"
                };
                return Err(format!("{key}: expected {expected}, found {bad}"));
            }
        }
        Ok(())
    }
}

fn first_repeated(names: &[String]) -> Option<&String> {
    let mut seen = std::collections::HashSet::new();
    names.iter().find(|name| !seen.insert(*name))
}
