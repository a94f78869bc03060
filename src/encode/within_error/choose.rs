//! Finds the cheapest choice whose error is small enough.
//!
//! Candidates are ordered by costs that do not depend on the clock. The first that meets the error
//! on a sample of the walks and viewpoints in use is chosen.

use super::configuration::{DrawConfiguration, Encoding, drawings, gei_cost};
use super::reference::{Reference, ReferenceSample, exact_geis, rmse, spread};
use super::spread_views;
use crate::draw::sweep::{FramingMode, Lens, Settings, View};
use crate::encode::encode_subjects;
use crate::error::{ChoiceError, Result, SweepError};
use crate::people::fewer_points::with_thinner_bodies;
use crate::people::{Subject, Track};
use edgegait_core::budget::MAX_POINTS;
use edgegait_core::pack::Pack;
use std::fmt::{self, Display};

/// The maximum number of walks and viewpoints of the sample. Our choice: measuring it takes
/// seconds.
const SAMPLE: (usize, usize) = (6, 12);
/// The errors of walks that are tried, mm.
const ERRORS_MM: [f64; 6] = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0];
/// The numbers of points of a body that are tried.
const HULL_POINTS: [usize; 5] = [160, 240, 320, 400, MAX_POINTS];

/// A choice, and the errors on which it is based.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FrontierChoice<T> {
    /// The cheapest candidate that meets the error.
    pub chosen: T,
    /// The error of the choice: root mean square of the GEIs' pixels, of 255.
    pub gei_rmse: f64,
    /// The next cheaper candidate and its error, unless the choice is the cheapest.
    pub cheaper: Option<(T, f64)>,
    /// The numbers of walks and viewpoints of the sample.
    pub measured_on: (usize, usize),
}

impl<T: Display> Display for FrontierChoice<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (walks, views) = self.measured_on;
        write!(
            f,
            "{}: GEI error {:.2} of 255 (root mean square against exact coverage, walks: {walks}, viewpoints: {views}); ",
            self.chosen, self.gei_rmse
        )?;
        match &self.cheaper {
            Some((cheaper, error)) => write!(f, "the next cheaper, {cheaper}: {error:.2}"),
            None => f.write_str("the cheapest there is"),
        }
    }
}

/// Finds the cheapest way to draw these walks from these views with a GEI error of at most `most`
/// against exact coverage of the pack's own motion.
///
/// # Errors
/// If none meets it (the message states the best), and for framings and lenses for which exact
/// coverage is not defined.
pub(crate) fn drawing(
    pack: &Pack<'_>,
    walks: &[usize],
    views: &[View],
    settings: Settings,
    most: f64,
) -> Result<FrontierChoice<DrawConfiguration>> {
    if settings.framing != FramingMode::Height || settings.lens != Lens::Ortho {
        return Err(ChoiceError::NotMeasured {
            framing: settings.framing.name(),
            lens: settings.lens.name(),
        }
        .into());
    }
    let sample = ReferenceSample::spread(walks, views, SAMPLE);
    let reference = Reference::new(pack, &sample, settings, &|| Ok(()))?;
    let mut candidates: Vec<DrawConfiguration> = drawings().collect();
    candidates.sort_by_key(|&drawing| gei_cost(drawing));
    let measured_on = (sample.jobs.len(), sample.views.len());
    first_within(most, candidates, measured_on, |drawing| {
        let settings = drawing.applied_to(settings);
        Ok(reference.deviation(pack, &sample, settings)?.gei_rmse)
    })
}

/// Finds the encoding of these people in the fewest bytes with a GEI error of at most `most`. The
/// error is that of exact coverage of the encoded people against exact coverage of the finest
/// encoding, over 20 viewpoints.
///
/// # Errors
/// If none meets it (the message states the best); for uncut motions, which have no GEI; and as
/// [`encode_subjects`].
pub(crate) fn encoding(people: &[Subject], most: f64) -> Result<FrontierChoice<Encoding>> {
    let some = some_walks(people)?;
    let finest = encode_subjects(&some, Encoding::FINEST.track_error_mm, &|| Ok(()))?;
    let finest = Pack::parse(&finest)?;
    let walks: Vec<usize> = (0..finest.walks().len()).collect();
    let sample = ReferenceSample::spread(&walks, &spread_views()?.list, SAMPLE);
    let settings = Settings::default();
    let expected = exact_geis(&finest, &sample, settings, &|| Ok(()))?;
    let mut candidates = Vec::new();
    for hull_points in HULL_POINTS {
        let thinner = with_thinner_bodies(&some, hull_points)?;
        for track_error_mm in ERRORS_MM {
            let encoding = Encoding {
                track_error_mm,
                hull_points,
            };
            candidates.push((
                encoding,
                encode_subjects(&thinner, track_error_mm, &|| Ok(()))?,
            ));
        }
    }
    // With equal bytes, the finest comes first.
    candidates.sort_by(|(a, a_bytes), (b, b_bytes)| {
        let by_error = a.track_error_mm.total_cmp(&b.track_error_mm);
        a_bytes.len().cmp(&b_bytes.len()).then(by_error)
    });
    let measured_on = (sample.jobs.len(), sample.views.len());
    let choice = first_within(most, candidates, measured_on, |(_, bytes)| {
        let found = exact_geis(&Pack::parse(bytes)?, &sample, settings, &|| Ok(()))?;
        Ok(rmse(&found, &expected))
    })?;
    Ok(FrontierChoice {
        chosen: choice.chosen.0,
        gei_rmse: choice.gei_rmse,
        cheaper: choice.cheaper.map(|((cheaper, _), error)| (cheaper, error)),
        measured_on,
    })
}

/// Returns the people with only the cycles of the sample.
fn some_walks(people: &[Subject]) -> Result<Vec<Subject>> {
    let mut places = Vec::new();
    for (person, subject) in people.iter().enumerate() {
        for (walk, found) in subject.walks.iter().enumerate() {
            if matches!(found.motion, Track::Uncut(_)) {
                return Err(ChoiceError::UncutHasNoGei {
                    subject: subject.name.clone(),
                    walk: found.name.clone(),
                }
                .into());
            }
            places.push((person, walk));
        }
    }
    let kept = spread(&places, SAMPLE.0);
    let some = people.iter().enumerate().filter_map(|(person, subject)| {
        let own = kept.iter().filter(|place| place.0 == person);
        let walks: Vec<_> = own.map(|&(_, walk)| subject.walks[walk].clone()).collect();
        (!walks.is_empty()).then(|| Subject {
            walks,
            name: subject.name.clone(),
            body: subject.body.clone(),
            ..*subject
        })
    });
    Ok(some.collect())
}

/// Returns the first candidate whose error is at most `most`.
fn first_within<T: Clone>(
    most: f64,
    candidates: Vec<T>,
    measured_on: (usize, usize),
    error: impl Fn(&T) -> Result<f64>,
) -> Result<FrontierChoice<T>> {
    let mut cheaper: Option<(T, f64)> = None;
    let mut best = f64::INFINITY;
    for chosen in candidates {
        let gei_rmse = error(&chosen)?;
        if gei_rmse <= most {
            return Ok(FrontierChoice {
                chosen,
                gei_rmse,
                cheaper,
                measured_on,
            });
        }
        best = best.min(gei_rmse);
        cheaper = Some((chosen, gei_rmse));
    }
    Err(SweepError::GeiError { asked: most, best }.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(most: f64) -> Result<FrontierChoice<char>> {
        let errors = [('a', 9.0), ('b', 11.0), ('c', 4.0), ('d', 6.0)];
        let choice = first_within(most, errors.to_vec(), (6, 12), |&(_, error)| Ok(error))?;
        Ok(FrontierChoice {
            chosen: choice.chosen.0,
            gei_rmse: choice.gei_rmse,
            cheaper: choice.cheaper.map(|((name, _), error)| (name, error)),
            measured_on: choice.measured_on,
        })
    }

    #[test]
    fn the_first_that_meets_the_error_is_chosen_and_the_one_before_it_told() {
        let found = chosen(7.0).expect("c meets it");
        assert_eq!((found.chosen, found.gei_rmse), ('c', 4.0));
        assert_eq!(found.cheaper, Some(('b', 11.0)));
        assert_eq!(
            found.to_string(),
            "c: GEI error 4.00 of 255 (root mean square against exact coverage, walks: 6, viewpoints: 12); the next cheaper, b: 11.00"
        );
        let found = chosen(9.0).expect("a meets it");
        assert_eq!((found.chosen, found.cheaper), ('a', None));
    }

    #[test]
    fn an_error_that_none_meets_is_told_with_the_best() {
        let error = chosen(3.0).expect_err("none").to_string();
        assert_eq!(
            error,
            "expected a GEI error of at most 3, but the best that can be reached here is 4.000"
        );
    }
}
