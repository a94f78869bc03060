//! The similarity of silhouettes: the Jaccard index, aligned and unaligned.
//!
//! Frames are compared with a cycle of silhouettes at even phases. Aligned by phase, all frames of
//! a cycle are shifted by the one share of it that makes them most similar. Half a cycle is among
//! these shifts; a side view hardly distinguishes it from none. Fitted, all frames are also moved
//! by whole pixels and scaled about their middle, by one shift and one scale.

use super::example::SIZE;
use edgegait_core::silhouette::Silhouette;
use serde::Serialize;

/// The number of phases of the reference cycle.
pub(crate) const PHASES: usize = 64;
/// The greatest shift of figures to each side, pixels. These limits are ours: a pixel is 35 mm, and
/// statures of clothed people are off by hair and soles, 2 to 6 cm.
const ACROSS: i32 = 2;
/// The greatest shift of figures up and down, pixels.
const DOWN: i32 = 1;
/// The scales of figures that are tried.
const SCALES: [f64; 5] = [0.94, 0.97, 1.0, 1.03, 1.06];

/// The Jaccard indices of the frames of a cycle, 0..1, under three alignments.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Likeness {
    /// The indices at each frame's own phase.
    pub unaligned: Vec<f64>,
    /// The indices at the phase shift that makes the frames most similar.
    pub by_phase: Vec<f64>,
    /// The indices at that phase, after the most similar shift and scale.
    pub fitted: Vec<f64>,
    /// The phase, shift and scale of the fit.
    pub fit: Alignment,
}

/// The alignment that makes frames most similar to a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Alignment {
    /// The share of a cycle by which the frames are earlier than the reference, -0.5..=0.5.
    pub phase: f64,
    /// The shift of the frames to the right, pixels.
    pub across: i32,
    /// The shift of the frames down, pixels.
    pub down: i32,
    /// The scale of the frames.
    pub scale: f64,
}

/// Returns the Jaccard indices of frames with the silhouettes at their phases, `later` silhouettes
/// later.
fn indices(frames: &[(f64, Silhouette)], cycle: &[Silhouette], later: usize) -> Vec<f64> {
    let count = cycle.len();
    let one = |(phase, frame): &(f64, Silhouette)| {
        // The nearest silhouette; phases are 0..1.
        let at = (phase * count as f64).round() as usize + later;
        f64::from(frame.jaccard(&cycle[at % count]))
    };
    frames.iter().map(one).collect()
}

/// Returns the number of silhouettes by which frames are earlier than a cycle when they are most
/// similar, and their Jaccard indices there. Ties go to the smallest shift.
pub(crate) fn aligned(frames: &[(f64, Silhouette)], cycle: &[Silhouette]) -> (usize, Vec<f64>) {
    let count = cycle.len();
    let moved = |offset: usize| offset.min(count - offset);
    let by_offset = (0..count).map(|offset| (offset, indices(frames, cycle, offset)));
    let best = by_offset.max_by(|a, b| {
        let order = mean(&a.1).total_cmp(&mean(&b.1));
        order.then(moved(b.0).cmp(&moved(a.0)))
    });
    best.unwrap_or_default()
}

/// Compares frames at their phases with [`PHASES`] silhouettes at even phases.
pub(crate) fn likeness(frames: &[(f64, Silhouette)], cycle: &[Silhouette]) -> Likeness {
    let (offset, by_phase) = aligned(frames, cycle);
    let share = offset as f64 / cycle.len().max(1) as f64;
    let mut found = Likeness {
        unaligned: indices(frames, cycle, 0),
        fitted: by_phase.clone(),
        fit: Alignment {
            phase: if share > 0.5 { share - 1.0 } else { share },
            scale: 1.0,
            ..Alignment::default()
        },
        by_phase,
    };
    let each = |of: &dyn Fn(&Silhouette) -> Silhouette, frames: &[(f64, Silhouette)]| {
        let moved = frames.iter().map(|(phase, frame)| (*phase, of(frame)));
        moved.collect::<Vec<_>>()
    };
    for scale in SCALES {
        let larger = each(&|frame| scaled(frame, scale), frames);
        for (down, across) in
            (-DOWN..=DOWN).flat_map(|down| (-ACROSS..=ACROSS).map(move |across| (down, across)))
        {
            let moved = each(&|frame| shifted(frame, across, down), &larger);
            let indices = indices(&moved, cycle, offset);
            if mean(&indices) > mean(&found.fitted) {
                found.fitted = indices;
                found.fit = Alignment {
                    across,
                    down,
                    scale,
                    ..found.fit
                };
            }
        }
    }
    found
}

/// Returns the arithmetic mean; 0 for no values.
pub(crate) fn mean(values: &[f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    values.iter().sum::<f64>() / values.len() as f64
}

/// Moves a silhouette right and down; pixels that leave the image are lost.
pub(crate) fn shifted(frame: &Silhouette, across: i32, down: i32) -> Silhouette {
    let rows = frame.rows();
    let row = |at: usize| -> u64 {
        let from = at as i64 - i64::from(down);
        let bits = usize::try_from(from).ok().and_then(|from| rows.get(from));
        let bits = bits.copied().unwrap_or(0);
        if across < 0 {
            bits >> across.unsigned_abs()
        } else {
            bits << across
        }
    };
    let moved: Vec<u64> = (0..rows.len()).map(row).collect();
    Silhouette::from_rows(frame.size(), &moved)
}

/// Scales a silhouette about its middle, sampled at pixel centres.
pub(crate) fn scaled(frame: &Silhouette, by: f64) -> Silhouette {
    if by == 1.0 {
        return *frame;
    }
    let size = frame.size();
    let from = |at: usize, of: usize| {
        let middle = 0.5 * of as f64;
        let place = ((at as f64 + 0.5 - middle) / by + middle).floor();
        (place >= 0.0 && place < of as f64).then_some(place as usize)
    };
    let columns: Vec<Option<usize>> = (0..size.columns())
        .map(|column| from(column, size.columns()))
        .collect();
    let row = |at: usize| -> u64 {
        let Some(from) = from(at, size.rows()) else {
            return 0;
        };
        let on = (0..).zip(&columns);
        let on = on.filter(|(_, column)| column.is_some_and(|column| frame.is_on(from, column)));
        on.fold(0, |bits, (column, _)| bits | 1 << column)
    };
    let rows: Vec<u64> = (0..size.rows()).map(row).collect();
    Silhouette::from_rows(size, &rows)
}

/// The five numbers of a box plot (Tukey, Exploratory Data Analysis, 1977), with count and mean.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct BoxPlot {
    /// The number of values.
    pub count: usize,
    /// The mean.
    pub mean: f64,
    /// The minimum value within 1.5 interquartile ranges of the box.
    pub low: f64,
    /// The first quartile.
    pub q1: f64,
    /// The median.
    pub median: f64,
    /// The third quartile.
    pub q3: f64,
    /// The greatest value within 1.5 interquartile ranges of the box.
    pub high: f64,
}

impl BoxPlot {
    /// Returns the box plot of values; none if there are no values.
    pub(crate) fn from_values(mut values: Vec<f64>) -> Option<Self> {
        values.sort_unstable_by(f64::total_cmp);
        let least = *values.first()?;
        // Linear between order statistics, as NumPy's default (type 7 of Hyndman and Fan 1996).
        let quantile = |share: f64| {
            let place = share * (values.len() - 1) as f64;
            let (low, high) = (place.floor(), place.ceil());
            let [low, high] = [low, high].map(|place| values[place as usize]);
            low + (high - low) * place.fract()
        };
        let [q1, median, q3] = [0.25, 0.5, 0.75].map(quantile);
        let reach = 1.5 * (q3 - q1);
        let mut inside = values
            .iter()
            .copied()
            .filter(|value| (q1 - reach..=q3 + reach).contains(value));
        let low = inside.next().unwrap_or(least);
        let high = inside.next_back().unwrap_or(low);
        Some(Self {
            count: values.len(),
            mean: mean(&values),
            low,
            q1,
            median,
            q3,
            high,
        })
    }
}

/// Returns for each row the pixels that only the first has, and only the second has, as shares of
/// the union of both silhouettes. All shares add up to 1 minus the Jaccard index.
pub(crate) fn lacking(a: &Silhouette, b: &Silhouette) -> Vec<(f64, f64)> {
    let rows = || a.rows().iter().zip(b.rows());
    let union: u32 = rows().map(|(a, b)| (a | b).count_ones()).sum();
    let share = |bits: u64| f64::from(bits.count_ones()) / f64::from(union.max(1));
    let rows = rows().map(|(a, b)| (share(a & !b), share(b & !a)));
    rows.take(SIZE.rows()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(rows: std::ops::Range<usize>, columns: std::ops::Range<usize>) -> Silhouette {
        let bits = columns.fold(0, |bits, column| bits | 1 << column);
        let row = |row| if rows.contains(&row) { bits } else { 0 };
        let rows: Vec<u64> = (0..SIZE.rows()).map(row).collect();
        Silhouette::from_rows(SIZE, &rows)
    }

    /// Draws a bar that moves to the right and jumps back.
    fn cycle() -> Vec<Silhouette> {
        let bar = |at: usize| block(10..40, at / 4..at / 4 + 8);
        (0..PHASES).map(bar).collect()
    }

    #[test]
    fn frames_that_are_late_are_aligned_by_phase() {
        let cycle = cycle();
        let frames: Vec<(f64, Silhouette)> = (0..8)
            .map(|at| (at as f64 / 8.0, cycle[(at * 8 + 16) % PHASES]))
            .collect();
        let found = likeness(&frames, &cycle);
        assert!(mean(&found.unaligned) < 0.5);
        assert_eq!(mean(&found.by_phase), 1.0);
        assert_eq!((found.fit.phase, found.fit.scale), (0.25, 1.0));
        assert_eq!(found.fitted, found.by_phase);
    }

    #[test]
    fn frames_that_are_moved_are_fitted() {
        let cycle = cycle();
        let frames: Vec<(f64, Silhouette)> = (0..8)
            .map(|at| (at as f64 / 8.0, shifted(&cycle[at * 8], 0, 1)))
            .collect();
        let found = likeness(&frames, &cycle);
        assert!((mean(&found.by_phase) - 29.0 / 31.0).abs() < 1e-6);
        assert_eq!(mean(&found.fitted), 1.0);
        assert_eq!((found.fit.across, found.fit.down), (0, -1));
    }

    #[test]
    fn a_square_scaled_by_a_half_is_half_as_wide_and_high() {
        let square = block(15..35, 5..25);
        assert_eq!(scaled(&square, 0.5), block(20..30, 10..20));
        assert_eq!(shifted(&square, -5, 3), block(18..38, 0..20));
    }

    #[test]
    fn a_box_plot_is_tukeys() {
        // The quartiles of 1, 2, 3, 4, 100 are 2, 3, 4, and 100 lies beyond 4 + 3.
        let found = BoxPlot::from_values(vec![100.0, 3.0, 1.0, 2.0, 4.0]).expect("values");
        assert_eq!(
            (found.low, found.q1, found.median, found.q3, found.high),
            (1.0, 2.0, 3.0, 4.0, 4.0)
        );
        assert_eq!((found.count, found.mean), (5, 22.0));
        assert_eq!(
            BoxPlot::from_values(vec![0.5]).map(|plot| plot.high),
            Some(0.5)
        );
        assert_eq!(BoxPlot::from_values(Vec::new()), None);
    }

    #[test]
    fn what_is_lacking_by_rows_adds_up_to_the_jaccard_distance() {
        let (a, b) = (block(10..30, 5..15), block(12..34, 7..15));
        let sum: f64 = lacking(&a, &b).iter().map(|(a, b)| a + b).sum();
        assert!((1.0 - sum - f64::from(a.jaccard(&b))).abs() < 1e-6);
        let (only_a, only_b) = lacking(&a, &b)[10];
        assert!(only_a > 0.0 && only_b == 0.0);
    }
}
