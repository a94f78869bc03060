//! The differences between synthetic and real silhouettes: the effect of each on similarity, and on
//! identifying real people after training on their twins.

use super::example::{Example, RealAndSynthetic, SIZE};
use super::likeness::{mean, shifted};
use super::recognition::{AccuracyCurve, AccuracyPoint, Experiment, curve};
use super::similarity::mean_likeness;
use super::splits::SplitUnit;
use crate::draw::template::augment::Augmentation;
use crate::error::Result;
use edgegait_core::silhouette::Silhouette;
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::Range;

/// The parts of a figure by rows, if it fills all 50: the shares of stature of Drillis and Contini,
/// after Winter (Biomechanics and Motor Control of Human Movement, 2009, figure 4.1), for chin
/// (0.870), shoulder (0.818), hip (0.530) and knee (0.285). Hands hang near the hips; the lowest
/// 8 % are feet.
pub(crate) const BANDS: [(&str, Range<usize>); 6] = [
    ("head", 0..7),
    ("shoulders and chest", 7..16),
    ("waist, hips and hands", 16..27),
    ("thighs", 27..36),
    ("shanks", 36..46),
    ("feet", 46..50),
];

/// The rows above the hips, which lean.
const LEANING: Range<usize> = 0..24;

/// Sums the values of rows by [`BANDS`].
pub(crate) fn banded(rows: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let sum = |rows: &[(f64, f64)]| {
        let (real, synthetic) = (rows.iter().map(|row| row.0), rows.iter().map(|row| row.1));
        (real.sum(), synthetic.sum())
    };
    let bands = BANDS.into_iter();
    bands
        .filter_map(|(_, band)| rows.get(band).map(sum))
        .collect()
}

/// The effect of one change of the twins.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ChangeEffect {
    /// The view's name.
    pub view: String,
    /// The change in words.
    pub change: String,
    /// The mean Jaccard index of real frames and their twins', aligned by phase; none if templates
    /// are changed instead of frames.
    pub jaccard: Option<f64>,
    /// The mean Jaccard index of the twins' frames with and without the change; none if the change
    /// is of measurements, lean or means.
    pub own: Option<f64>,
    /// The share of real cycles that are identified after training on twins:
    /// [`Experiment::SyntheticReal`], with the most components.
    pub learnt: AccuracyPoint,
    /// The share of real cycles that are identified by the nearest pixels.
    pub nearest: AccuracyPoint,
}

impl ChangeEffect {
    /// Measures the effect of a change from real and changed synthetic cycles; none if no real
    /// cycle can be tested.
    ///
    /// # Errors
    /// If training fails.
    pub(crate) fn measure(
        view: &str,
        change: impl Into<String>,
        both: RealAndSynthetic<'_>,
        jaccard: Option<f64>,
        seed: u64,
    ) -> Result<Option<Self>> {
        let found = curve(
            Experiment::SyntheticReal,
            both,
            SplitUnit::Cycle,
            &[seed],
            Augmentation::default(),
            &|| Ok(()),
        )?;
        let priced = |curve: AccuracyCurve| {
            Some(Self {
                view: view.to_owned(),
                change: change.into(),
                jaccard,
                own: None,
                learnt: curve.last()?.clone(),
                nearest: curve.nearest,
            })
        };
        Ok(found.and_then(priced))
    }
}

/// Measures the differences that all people share: in each band of rows, in all rows, and in the
/// lean of upper bodies.
///
/// # Errors
/// If training fails.
pub(crate) fn shared(
    view: &str,
    real: &[Example],
    synthetic: &[Example],
    seed: u64,
) -> Result<Vec<ChangeEffect>> {
    let mut prices = Vec::new();
    let difference = difference(real, synthetic);
    let all = std::iter::once(("all rows", 0..SIZE.rows()));
    for (name, rows) in BANDS.into_iter().chain(all) {
        let corrected = with_mean_of(synthetic, &difference, &rows);
        let change = format!("the mean difference of GEIs taken out: {name}");
        prices.extend(ChangeEffect::measure(
            view,
            change,
            RealAndSynthetic {
                real,
                synthetic: &corrected,
            },
            None,
            seed,
        )?);
    }
    let leaning = leaning(synthetic, &offsets(real, synthetic));
    let jaccard = mean_likeness(real, &leaning);
    let change = "rows above the hips moved to where they are on average";
    prices.extend(ChangeEffect::measure(
        view,
        change,
        RealAndSynthetic {
            real,
            synthetic: &leaning,
        },
        jaccard,
        seed,
    )?);
    Ok(prices)
}

/// Returns the mean of GEIs, 0..=255, where each person counts once.
pub(crate) fn mean_gei(examples: &[Example]) -> Vec<f64> {
    let mut people: BTreeMap<usize, Vec<&Example>> = BTreeMap::new();
    for example in examples {
        people.entry(example.person).or_default().push(example);
    }
    let pixel = |at: usize| {
        let own = people.values().map(|own| {
            let values: Vec<f64> = own
                .iter()
                .map(|example| f64::from(example.gei[at]))
                .collect();
            mean(&values)
        });
        mean(&own.collect::<Vec<_>>())
    };
    (0..SIZE.pixels()).map(pixel).collect()
}

/// Returns the mean real GEI minus the mean synthetic one.
fn difference(real: &[Example], synthetic: &[Example]) -> Vec<f64> {
    let pairs = mean_gei(real).into_iter().zip(mean_gei(synthetic));
    pairs.map(|(real, synthetic)| real - synthetic).collect()
}

/// Adds the mean difference to GEIs in these rows.
fn with_mean_of(examples: &[Example], lacking: &[f64], rows: &Range<usize>) -> Vec<Example> {
    let pixels = rows.start * SIZE.columns()..rows.end * SIZE.columns();
    let one = |example: &Example| {
        let gei = example.gei.iter().enumerate().map(|(at, &byte)| {
            if pixels.contains(&at) {
                // Rounded, and limited to a byte.
                (f64::from(byte) + lacking[at]).round().clamp(0.0, 255.0) as u8
            } else {
                byte
            }
        });
        Example {
            gei: gei.collect(),
            ..example.clone()
        }
    };
    examples.iter().map(one).collect()
}

/// Returns the mean offset to the right of real GEIs from synthetic ones in each row, columns; 0 in
/// empty rows.
pub(crate) fn offsets(real: &[Example], synthetic: &[Example]) -> Vec<f64> {
    let middles = |gei: Vec<f64>| -> Vec<Option<f64>> {
        let rows = gei.chunks_exact(SIZE.columns());
        rows.map(|row| {
            let all: f64 = row.iter().sum();
            let moment: f64 = (0..)
                .zip(row)
                .map(|(at, pixel)| f64::from(at) * pixel)
                .sum();
            (all > 0.0).then(|| moment / all)
        })
        .collect()
    };
    let pairs = middles(mean_gei(real))
        .into_iter()
        .zip(middles(mean_gei(synthetic)));
    pairs
        .map(|(real, synthetic)| {
            real.zip(synthetic)
                .map_or(0.0, |(real, synthetic)| real - synthetic)
        })
        .collect()
}

/// Moves the rows above the hips right by these offsets, rounded to whole columns.
fn leaning(examples: &[Example], offsets: &[f64]) -> Vec<Example> {
    let moved = |frame: &Silhouette| {
        let row = |at: usize| {
            let by = if LEANING.contains(&at) {
                offsets[at].round() as i32
            } else {
                0
            };
            shifted(frame, by, 0).rows()[at]
        };
        let rows: Vec<u64> = (0..SIZE.rows()).map(row).collect();
        Silhouette::from_rows(SIZE, &rows)
    };
    let examples = examples.iter();
    examples.map(|example| example.with_frames(moved)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::example::gei;
    use super::*;

    fn block(person: usize, rows: Range<usize>, columns: Range<usize>) -> Example {
        let bits = columns.fold(0, |bits, column| bits | 1 << column);
        let row = |row| if rows.contains(&row) { bits } else { 0 };
        let rows: Vec<u64> = (0..SIZE.rows()).map(row).collect();
        let frame = Silhouette::from_rows(SIZE, &rows);
        Example {
            person,
            take: 0,
            position: 0,
            span_s: (0.0, 1.0),
            gei: gei([&frame].into_iter()),
            frames: vec![(0.0, frame)],
        }
    }

    #[test]
    fn bands_are_all_rows_once() {
        let rows: Vec<usize> = BANDS.into_iter().flat_map(|(_, rows)| rows).collect();
        assert_eq!(rows, (0..SIZE.rows()).collect::<Vec<_>>());
    }

    #[test]
    fn a_person_counts_once_and_what_all_lack_is_added_where_it_was_asked_for() {
        let real = [
            block(0, 0..50, 4..8),
            block(0, 0..50, 4..8),
            block(1, 0..50, 4..10),
        ];
        let mean = mean_gei(&real);
        assert_eq!((mean[5], mean[9]), (255.0, 127.5));
        let synthetic = [block(0, 0..50, 4..6), block(1, 0..50, 4..6)];
        let corrected = with_mean_of(&synthetic, &difference(&real, &synthetic), &(0..1));
        assert_eq!(&corrected[0].gei[4..11], [255, 255, 255, 255, 128, 128, 0]);
        assert_eq!(&corrected[0].gei[34..41], [255, 255, 0, 0, 0, 0, 0]);
    }

    #[test]
    fn upper_bodies_are_moved_to_where_they_are_on_average() {
        let real = [block(0, 0..50, 8..12)];
        let synthetic = [block(0, 0..50, 5..9)];
        assert_eq!(offsets(&real, &synthetic), vec![3.0; 50]);
        let moved = leaning(&synthetic, &offsets(&real, &synthetic));
        assert_eq!(
            moved[0].frames[0].1.rows()[0],
            real[0].frames[0].1.rows()[0]
        );
        assert_eq!(
            moved[0].frames[0].1.rows()[30],
            synthetic[0].frames[0].1.rows()[30]
        );
        assert_eq!(moved[0].gei[8..13], [255, 255, 255, 255, 0]);
    }
}
