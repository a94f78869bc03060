//! Logarithmic axes of a chart, and the positions of the points' numbers.

use super::drawing::Tick;

/// Radius of the ring around a point, which numbers must not cover.
pub(crate) const RING: i32 = 9;

/// A logarithmic axis from its least to its greatest value.
pub(crate) struct LogAxis(f64, f64);

impl LogAxis {
    /// Creates an axis with room around the values.
    pub(crate) fn around(values: impl Iterator<Item = f64>) -> Self {
        let (least, most) = values.fold((f64::INFINITY, 0.0), |(least, most), value| {
            (value.min(least), value.max(most))
        });
        Self(least / 1.3, most * 1.3)
    }

    /// Returns the place of a value on the axis, from 0 to 1.
    pub(crate) fn place(&self, value: f64) -> f64 {
        (value / self.0).ln() / (self.1 / self.0).ln()
    }

    /// Returns the ticks: values with one digit and zeros, fewer on a longer axis.
    pub(crate) fn ticks(&self) -> Vec<Tick> {
        let digits: &[f64] = match self.1 / self.0 {
            2e3.. => &[1.0],
            40.0.. => &[1.0, 2.0, 5.0],
            _ => &[1.0, 2.0, 3.0, 5.0, 7.0],
        };
        let all = (-3..8).flat_map(|power| digits.iter().map(move |d| d * 10f64.powi(power)));
        all.filter(|value| (self.0..self.1).contains(value))
            .map(|value| {
                let decimals = if value < 1.0 { 3 } else { 0 };
                Tick::new(self.place(value), format!("{value:.decimals$}"))
            })
            .collect()
    }
}

/// Returns the upper left corners of the points' labels of these sizes, each as near to its point as
/// possible without covering another label or point, on a picture of this size.
pub(crate) fn labels(
    points: &[(i32, i32)],
    sizes: &[(i32, i32)],
    picture: (i32, i32),
) -> Vec<(i32, i32)> {
    let meets = |a: (i32, i32), a_size: (i32, i32), b: (i32, i32), b_size: (i32, i32)| {
        a.0 < b.0 + b_size.0 && b.0 < a.0 + a_size.0 && a.1 < b.1 + b_size.1 && b.1 < a.1 + a_size.1
    };
    let is_outside = |at: (i32, i32), size: (i32, i32)| {
        at.0 < 0 || at.1 < 0 || at.0 + size.0 > picture.0 || at.1 + size.1 > picture.1
    };
    let mut placed: Vec<(i32, i32)> = Vec::new();
    for (&(x, y), &size) in points.iter().zip(sizes) {
        let mut best = (usize::MAX, (x, y));
        for distance in [12, 18, 26, 36, 48] {
            for (right, down) in [
                (1, 0),
                (0, -1),
                (-1, 0),
                (0, 1),
                (1, -1),
                (-1, -1),
                (1, 1),
                (-1, 1),
            ] {
                let centre = (
                    x + right * (distance + size.0 / 2),
                    y + down * (distance + size.1 / 2),
                );
                let at = (centre.0 - size.0 / 2, centre.1 - size.1 / 2);
                let on_labels = placed.iter().enumerate();
                let on_labels = on_labels.filter(|&(i, &other)| meets(at, size, other, sizes[i]));
                let side = (2 * RING, 2 * RING);
                let on_dots = points.iter();
                let on_dots =
                    on_dots.filter(|dot| meets(at, size, (dot.0 - RING, dot.1 - RING), side));
                let outside = usize::from(is_outside(at, size));
                let met = on_labels.count() + on_dots.count() + outside;
                if met < best.0 {
                    best = (met, at);
                }
            }
        }
        placed.push(best.1);
    }
    placed
}

#[cfg(test)]
mod tests {
    use super::*;

    const NUMBER: (i32, i32) = (8, 13);

    #[test]
    fn no_number_covers_a_point_or_another_number() {
        // Three points so close that all would be labelled on their right, and one far away.
        let points = [(100, 100), (104, 100), (100, 103), (300, 100)];
        let found = labels(&points, &[NUMBER; 4], (400, 400));
        assert_eq!(found[3], (312, 94));
        for (index, a) in found.iter().enumerate() {
            let apart = |b: (i32, i32), size: (i32, i32)| {
                a.0 + NUMBER.0 <= b.0
                    || b.0 + size.0 <= a.0
                    || a.1 + NUMBER.1 <= b.1
                    || b.1 + size.1 <= a.1
            };
            assert!(found[..index].iter().all(|&b| apart(b, NUMBER)));
            let dot = |(x, y): (i32, i32)| apart((x - RING, y - RING), (2 * RING, 2 * RING));
            assert!(points.iter().all(|&point| dot(point)));
        }
    }

    #[test]
    fn axes_are_labelled_within_their_range() {
        let axis = LogAxis::around([3.25, 46.0].into_iter());
        let texts: Vec<String> = axis.ticks().into_iter().map(|tick| tick.text).collect();
        assert_eq!(texts, ["3", "5", "7", "10", "20", "30", "50"]);
        assert_eq!(LogAxis(1.0, 100.0).place(10.0), 0.5);
        let small = LogAxis(0.45, 0.6).ticks();
        assert_eq!(small[0].text, "0.500");
        let long = LogAxis(0.9, 2000.0).ticks();
        let texts: Vec<&str> = long.iter().map(|tick| tick.text.as_str()).collect();
        assert_eq!(texts, ["1", "10", "100", "1000"]);
    }
}
