//! A gait cycle of real or synthetic silhouettes.

use edgegait_core::silhouette::{Silhouette, Size};

/// The size of all images in a study, as in the paper.
pub(crate) const SIZE: Size = Size::S50x30;

/// One gait cycle of one person, seen from one viewpoint.
#[derive(Clone, Debug)]
pub(crate) struct Example {
    /// The number of the person.
    pub person: usize,
    /// The number of the take among the takes of all people.
    pub take: usize,
    /// The number of the cycle in the take, from 0.
    pub position: usize,
    /// The start and the end of the cycle, seconds of the recording.
    pub span_s: (f64, f64),
    /// The phase of each silhouette in the gait cycle, 0..1 with 0 at the left contact, and the
    /// silhouette.
    pub frames: Vec<(f64, Silhouette)>,
    /// The Gait Energy Image (GEI) of the cycle, 0..=255.
    pub gei: Vec<u8>,
}

impl Example {
    /// Returns the middle of the cycle, seconds.
    pub(crate) fn middle_s(&self) -> f64 {
        f64::midpoint(self.span_s.0, self.span_s.1)
    }

    /// Returns the example with each silhouette changed by `of`, and with the GEI of these.
    pub(crate) fn with_frames(&self, of: impl Fn(&Silhouette) -> Silhouette) -> Self {
        let frames = self.frames.iter();
        let frames: Vec<_> = frames.map(|(phase, frame)| (*phase, of(frame))).collect();
        Self {
            gei: gei(frames.iter().map(|(_, frame)| frame)),
            frames,
            ..self.clone()
        }
    }

    /// Returns the nearest silhouette at each of `count` even phases.
    pub(crate) fn at_phases(&self, count: usize) -> Vec<Silhouette> {
        let nearest = |at: usize| {
            let phase = at as f64 / count as f64;
            let apart = |other: f64| {
                let apart = (phase - other).rem_euclid(1.0);
                apart.min(1.0 - apart)
            };
            let frames = self.frames.iter();
            let found = frames.min_by(|a, b| apart(a.0).total_cmp(&apart(b.0)));
            found.map_or(Silhouette::empty(SIZE), |(_, silhouette)| *silhouette)
        };
        (0..count).map(nearest).collect()
    }
}

/// Returns the rounded mean of silhouettes, 0..=255; all 0 if there are none.
pub(crate) fn gei<'a>(frames: impl Iterator<Item = &'a Silhouette> + Clone) -> Vec<u8> {
    let count = frames.clone().count() as u32;
    let mut sums = vec![0_u32; SIZE.pixels()];
    for frame in frames {
        for (sums, bits) in sums.chunks_exact_mut(SIZE.columns()).zip(frame.rows()) {
            for (column, sum) in sums.iter_mut().enumerate() {
                *sum += u32::from(bits >> column & 1 == 1);
            }
        }
    }
    let byte = |sum: u32| (255 * sum + count / 2).checked_div(count).unwrap_or(0);
    #[expect(clippy::cast_possible_truncation, reason = "at most 255")]
    sums.into_iter().map(|sum| byte(sum) as u8).collect()
}

/// The gait cycles of real people and of their synthetic twins, from one viewpoint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RealAndSynthetic<'a> {
    /// The cycles of recorded silhouettes.
    pub real: &'a [Example],
    /// The cycles of the twins.
    pub synthetic: &'a [Example],
}

/// The names of the settings of one result.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StudySetting<'a> {
    /// The name of the viewpoint.
    pub view: &'a str,
    /// The name of the masks.
    pub masks: &'static str,
    /// The name of the framing.
    pub framing: &'static str,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dot(row: usize, column: usize) -> Silhouette {
        let mut rows = vec![0; SIZE.rows()];
        rows[row] = 1 << column;
        Silhouette::from_rows(SIZE, &rows)
    }

    #[test]
    fn a_gei_is_the_mean_of_its_frames_rounded() {
        let frames = [dot(3, 4), dot(3, 4), dot(49, 29)];
        let gei = gei(frames.iter());
        assert_eq!((gei[3 * 30 + 4], gei[1499], gei[0]), (170, 85, 0));
        assert_eq!(super::gei([].iter()), vec![0; 1500]);
    }

    #[test]
    fn phases_take_the_nearest_frame_round_the_cycle() {
        let frames = vec![(0.2, dot(1, 1)), (0.6, dot(2, 2)), (0.95, dot(3, 3))];
        let example = Example {
            person: 0,
            take: 0,
            position: 0,
            span_s: (1.0, 2.0),
            gei: Vec::new(),
            frames,
        };
        let found = example.at_phases(4);
        assert_eq!(found, [dot(3, 3), dot(1, 1), dot(2, 2), dot(2, 2)]);
        assert_eq!(example.middle_s(), 1.5);
    }
}
