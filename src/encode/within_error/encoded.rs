//! Encodes people as a pack within a limit of error or size.

use super::choose::{self, FrontierChoice};
use super::configuration::Encoding;
use crate::encode::{MAX_ERROR_MM, body_error_mm, check_walks, encode_subjects, encode_within};
use crate::error::Result;
use crate::people::Subject;
use crate::people::fewer_points::with_thinner_bodies;
use edgegait_core::pack::Pack;

/// The default greatest error if a body was fitted to a mesh, mm. 5 mm would cost 0.002 of its
/// Jaccard index, as much as losing a third of its points.
const FITTED_ERROR_MM: f64 = 1.0;

/// The limit within which people are encoded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum EncodingGoal {
    /// The default error: [`MAX_ERROR_MM`], or 1 mm if a body was fitted to a mesh.
    Usual,
    /// The greatest error of a walk, mm; a body has two fifths of it, up to 4 mm.
    ErrorMm(f64),
    /// The maximum number of bytes; the smallest error that fits is chosen, from 0.1 mm on.
    Bytes(usize),
    /// The greatest GEI error against the finest encoding, root mean square of 255; the fewest
    /// bytes are chosen. Takes a minute for a dozen people, because several encodings are tried.
    GeiRmse(f64),
}

/// A pack, and the settings with which it was encoded.
#[derive(Clone, Debug)]
pub(crate) struct EncodedPack {
    /// The pack.
    pub bytes: Vec<u8>,
    /// The requested greatest error of walks, mm.
    pub max_error_mm: f64,
    /// The maximum number of points in a body, if limited.
    pub hull_points: Option<usize>,
    /// The choice for [`EncodingGoal::GeiRmse`].
    pub choice: Option<FrontierChoice<Encoding>>,
}

/// Encodes people. Bodies keep at most `hull_points` points if that is given. `progress` is
/// called each time a walk is encoded.
///
/// # Errors
/// As [`encode_subjects`] and [`encode_within`], and if nothing meets [`EncodingGoal::GeiRmse`].
pub(crate) fn encoded(
    people: &[Subject],
    goal: EncodingGoal,
    hull_points: Option<usize>,
    progress: &(dyn Fn() -> Result<()> + Sync),
) -> Result<EncodedPack> {
    check_walks(people)?;
    let choice = match goal {
        EncodingGoal::GeiRmse(most) => Some(choose::encoding(people, most)?),
        _ => None,
    };
    let chosen = choice.as_ref().map(|choice| choice.chosen);
    let hull_points = chosen.map(|encoding| encoding.hull_points).or(hull_points);
    let people = match hull_points {
        Some(most) => &with_thinner_bodies(people, most)?,
        None => people,
    };
    let is_fitted = people.iter().any(|subject| subject.body.fit.is_some());
    let (bytes, max_error_mm) = match (goal, chosen) {
        (EncodingGoal::Bytes(budget), _) => encode_within(people, budget, progress)?,
        (goal, chosen) => {
            let max_error_mm = match (goal, chosen) {
                (_, Some(encoding)) => encoding.track_error_mm,
                (EncodingGoal::ErrorMm(asked), None) => asked,
                _ if is_fitted => FITTED_ERROR_MM,
                _ => MAX_ERROR_MM,
            };
            let bytes = encode_subjects(people, max_error_mm, progress)?;
            (bytes, max_error_mm)
        }
    };
    Ok(EncodedPack {
        bytes,
        max_error_mm,
        hull_points,
        choice,
    })
}

impl EncodedPack {
    /// Wraps a pack of people whose bodies were not fitted, made with [`EncodingGoal::Usual`].
    #[must_use]
    pub(crate) const fn usual(bytes: Vec<u8>) -> Self {
        Self {
            bytes,
            max_error_mm: MAX_ERROR_MM,
            hull_points: None,
            choice: None,
        }
    }

    /// Returns warnings if walks or bodies exceed the requested error.
    ///
    /// # Errors
    /// If the bytes are not a pack.
    pub(crate) fn missed_errors(&self) -> Result<Vec<String>> {
        let pack = Pack::parse(&self.bytes)?;
        let clips = (0..pack.clip_count()).filter_map(|index| pack.clip(index));
        let clips: Vec<f32> = clips.map(|clip| clip.max_error_mm()).collect();
        let avatars = (0..pack.avatar_count()).filter_map(|index| pack.avatar(index));
        let avatars: Vec<f32> = avatars.map(|avatar| avatar.max_error_mm()).collect();
        let kinds = [
            ("walks", clips, self.max_error_mm),
            ("bodies", avatars, body_error_mm(self.max_error_mm)),
        ];
        Ok(kinds
            .into_iter()
            .filter_map(|(what, errors, asked_mm)| missed(what, &errors, asked_mm))
            .collect())
    }
}

/// Returns a warning if some of these errors exceed the requested one.
fn missed(what: &str, errors: &[f32], asked_mm: f64) -> Option<String> {
    let errors = errors.iter().map(|&error| f64::from(error));
    let (all, most) = (errors.len(), errors.clone().fold(0.0, f64::max));
    // Stored errors are rounded up to 0.01 mm.
    let missed = errors.filter(|&error| error > asked_mm + 0.011).count();
    (missed > 0).then(|| {
        format!(
            "{missed} of {all} {what} exceed the error of {asked_mm:.2} mm, by up to {:.2} mm: the format cannot encode them more finely",
            most - asked_mm
        )
    })
}
