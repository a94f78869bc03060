//! Contracts of recognizers that take the viewpoint of each input besides its images.

use super::Contract;
use crate::error::{InferenceError, Result};
use crate::inference::Distance;
use std::borrow::Cow;

/// Azimuth and elevation of the side view, degrees.
const SIDE_DEG: [f64; 2] = [90.0, 0.0];
/// Viewpoints whose angles both differ by less than this are the same, degrees.
pub(crate) const SAME_VIEW_DEG: f64 = 0.05;

impl Contract {
    /// Appends the viewpoint (azimuth and elevation, degrees) of the input that [`Self::feed`]
    /// wrote before, if the recognizer takes viewpoints.
    ///
    /// # Errors
    /// If the recognizer takes viewpoints, and this one is unknown or was not in its training.
    pub fn feed_view(&self, seen_from: Option<(f64, f64)>, into: &mut Vec<f32>) -> Result<()> {
        if self.view_input.is_none() {
            return Ok(());
        }
        let model = || self.name.clone();
        let Some((azimuth, elevation)) = seen_from else {
            return Err(InferenceError::ViewUnknown { model: model() }.into());
        };
        if !self.training.viewpoints.is_empty() && self.view_number(seen_from).is_none() {
            let known = { self.training.viewpoints.iter() }
                .map(|[azimuth, elevation]| format!("{azimuth},{elevation}"));
            return Err(InferenceError::ViewUntrained {
                model: model(),
                found: format!("{azimuth},{elevation}"),
                known: known.collect::<Vec<_>>().join(" "),
            }
            .into());
        }
        into.extend([azimuth as f32, elevation as f32]);
        Ok(())
    }

    /// Returns the viewpoints to try the recognizer with, azimuth and elevation in degrees: the
    /// side view or, if it takes viewpoints, those of its training, nearest to the side first.
    pub(crate) fn usual_views(&self) -> Vec<[f64; 2]> {
        if self.view_input.is_none() || self.training.viewpoints.is_empty() {
            return vec![SIDE_DEG];
        }
        let from_side = |at: &[f64; 2]| (at[0] - SIDE_DEG[0]).hypot(at[1] - SIDE_DEG[1]);
        let mut views = self.training.viewpoints.clone();
        views.sort_by(|a, b| from_side(a).total_cmp(&from_side(b)));
        views
    }

    /// Returns the number of a viewpoint among the training viewpoints.
    pub(crate) fn view_number(&self, seen_from: Option<(f64, f64)>) -> Option<usize> {
        let (azimuth, elevation) = seen_from?;
        let is_near = |known: &[f64; 2]| {
            (known[0] - azimuth).abs() < SAME_VIEW_DEG
                && (known[1] - elevation).abs() < SAME_VIEW_DEG
        };
        self.training.viewpoints.iter().position(is_near)
    }

    /// Separates inputs that lie one after another from their viewpoints.
    #[must_use]
    pub fn apart<'a>(&self, input: &'a [f32], batch: usize) -> (Cow<'a, [f32]>, Vec<f32>) {
        if self.view_input.is_none() || batch == 0 {
            return (Cow::Borrowed(input), Vec::new());
        }
        let each = input.len() / batch;
        let (mut numbers, mut views) = (Vec::with_capacity(input.len()), Vec::new());
        for one in input.chunks_exact(each.max(self.view_numbers())) {
            let (own, view) = one.split_at(one.len() - self.view_numbers());
            numbers.extend_from_slice(own);
            views.extend_from_slice(view);
        }
        (Cow::Owned(numbers), views)
    }

    /// Returns the numbers of the viewpoint in an input: 2, or 0 if the recognizer takes none.
    pub(crate) fn view_numbers(&self) -> usize {
        match self.view_input {
            Some(_) => 2,
            None => 0,
        }
    }

    /// Checks that distance `view` has viewpoints, and that viewpoints of an input differ.
    pub(super) fn check_view_distance(&self) -> std::result::Result<(), String> {
        let has_both = self.view_input.is_some() && !self.training.viewpoints.is_empty();
        if self.distance == Distance::View && !has_both {
            return Err(
                "distance: \"view\" compares the part of the probe's viewpoint: expected view_input and training.viewpoints, in the order of the parts"
                    .into(),
            );
        }
        let viewpoints = &self.training.viewpoints;
        let twice = { viewpoints.iter().enumerate() }.find_map(|(at, &[azimuth, elevation])| {
            let first = self.view_number(Some((azimuth, elevation)))?;
            (first != at).then(|| (viewpoints[first], viewpoints[at]))
        });
        match twice {
            Some((one, other)) if self.view_input.is_some() => Err(format!(
                "viewpoints: expected them at least {SAME_VIEW_DEG} degrees apart, as the model takes them, found {one:?} and {other:?}"
            )),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::Training;

    fn contract() -> Contract {
        Contract {
            name: "m".into(),
            view_input: Some("seen".into()),
            rows: 1,
            columns: 3,
            training: Training {
                viewpoints: vec![[0.0, 0.0], [75.0, 0.0], [90.0, 30.0]],
                ..Training::default()
            },
            ..Contract::default()
        }
    }

    #[test]
    fn an_input_ends_with_its_viewpoint() {
        let contract = contract();
        let mut input = Vec::new();
        for (bytes, from) in [([0, 51, 255], (75.0, 0.0)), ([255, 0, 0], (90.0, 30.0))] {
            contract.feed(&bytes, &mut input);
            contract
                .feed_view(Some(from), &mut input)
                .expect("a trained one");
        }
        assert_eq!(input, [0.0, 0.2, 1.0, 75.0, 0.0, 1.0, 0.0, 0.0, 90.0, 30.0]);
        assert_eq!(contract.frames_in(10, 2).ok(), Some(1));
        let said = contract
            .frames_in(6, 2)
            .expect_err("without viewpoints")
            .to_string();
        assert!(said.contains("= 5 numbers"), "{said}");
        let (numbers, views) = contract.apart(&input, 2);
        assert_eq!(*numbers, [0.0, 0.2, 1.0, 1.0, 0.0, 0.0]);
        assert_eq!(views, [75.0, 0.0, 90.0, 30.0]);
        // Without that input, nothing is added or separated.
        let plain = Contract {
            view_input: None,
            ..contract
        };
        let mut input = vec![0.5; 3];
        plain.feed_view(None, &mut input).expect("nothing to know");
        assert_eq!(
            plain.apart(&input, 1),
            (Cow::Borrowed(&[0.5; 3][..]), Vec::new())
        );
    }

    #[test]
    fn viewpoints_are_those_of_training_up_to_rounding() {
        let contract = contract();
        assert_eq!(contract.view_number(Some((75.000_01, -0.000_01))), Some(1));
        assert_eq!(contract.view_number(Some((75.1, 0.0))), None);
        assert_eq!(contract.view_number(None), None);
        // A contract without training viewpoints takes any.
        let mut any = contract.clone();
        any.training.viewpoints.clear();
        let mut input = Vec::new();
        any.feed_view(Some((33.0, 7.0)), &mut input).expect("any");
        assert_eq!(input, [33.0, 7.0]);
        assert_eq!(any.usual_views(), [[90.0, 0.0]]);
        let mut near = contract.clone();
        assert!(near.check_view_distance().is_ok());
        near.training.viewpoints.push([75.03, 0.0]);
        let said = near.check_view_distance().expect_err("two of one");
        assert!(
            said.ends_with("found [75.0, 0.0] and [75.03, 0.0]"),
            "{said}"
        );
        // The nearest to the side comes first.
        assert_eq!(
            contract.usual_views(),
            [[75.0, 0.0], [90.0, 30.0], [0.0, 0.0]]
        );
    }
}
