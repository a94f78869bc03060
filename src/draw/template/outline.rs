//! The outline of a silhouette's largest figure, as equally spaced points.

use edgegait_core::silhouette::Silhouette;
use glam::DVec2;

/// The offsets to the eight neighbours, in rows down and columns right, clockwise from the right.
const NEIGHBOURS: [(isize, isize); 8] = [
    (0, 1),
    (1, 1),
    (1, 0),
    (1, -1),
    (0, -1),
    (-1, -1),
    (-1, 0),
    (-1, 1),
];

/// A pixel by its row and column.
type Pixel = (usize, usize);

/// Returns `count` equally spaced points along the outer boundary of the largest figure, in pixels
/// to the right (x) and down (y) of the upper left pixel's centre. The path runs clockwise from the
/// leftmost of the topmost pixels, through the centres of pixels that touch at sides or corners.
/// Returns `None` if no pixel is on.
#[must_use]
pub fn outline(silhouette: &Silhouette, count: usize) -> Option<Vec<DVec2>> {
    let figure = largest_figure(silhouette)?;
    Some(spaced(&boundary(&figure)?, count))
}

/// Returns the largest set of pixels connected by sides or corners; ties go to the set that begins
/// first, row by row.
fn largest_figure(silhouette: &Silhouette) -> Option<Silhouette> {
    let size = silhouette.size();
    let mut rest = silhouette.rows().to_vec();
    let mut largest: Option<Silhouette> = None;
    while let Some(row) = rest.iter().position(|&bits| bits != 0) {
        let mut figure = vec![0u64; rest.len()];
        let mut open = vec![(row, rest[row].trailing_zeros() as usize)];
        while let Some((row, column)) = open.pop() {
            let bit = 1 << column;
            if rest[row] & bit == 0 {
                continue;
            }
            rest[row] &= !bit;
            figure[row] |= bit;
            let found = NEIGHBOURS.iter().filter_map(|&by| moved((row, column), by));
            open.extend(found.filter(|&(row, column)| {
                row < rest.len() && column < size.columns() && rest[row] >> column & 1 == 1
            }));
        }
        let figure = Silhouette::from_rows(size, &figure);
        if largest.is_none_or(|largest| figure.area() > largest.area()) {
            largest = Some(figure);
        }
    }
    largest
}

fn moved((row, column): Pixel, (down, right): (isize, isize)) -> Option<Pixel> {
    row.checked_add_signed(down)
        .zip(column.checked_add_signed(right))
}

/// Returns the pixels of the outer boundary, clockwise, by Moore's neighbour tracing. It ends where
/// it would leave the first pixel in the same direction as at the start (Jacob's criterion).
fn boundary(figure: &Silhouette) -> Option<Vec<Pixel>> {
    let rows = figure.rows();
    let top = rows.iter().position(|&bits| bits != 0)?;
    let start = (top, rows[top].trailing_zeros() as usize);
    let is_on = |(row, column)| figure.is_on(row, column);
    let mut pixels = Vec::new();
    // No pixel is on above the first one or to its left.
    let (mut at, mut search, mut first) = (start, 5, None);
    loop {
        let next = (search..search + 8)
            .map(|turn| turn % 8)
            .find_map(|turn| Some((turn, moved(at, NEIGHBOURS[turn]).filter(|&at| is_on(at))?)));
        let Some((turn, next)) = next else {
            // A single pixel.
            return Some(vec![start]);
        };
        if at == start && first == Some(turn) {
            return Some(pixels);
        }
        first.get_or_insert(turn);
        pixels.push(at);
        // Continues from the last background pixel before the step.
        search = if turn % 2 == 0 { turn + 7 } else { turn + 6 };
        at = next;
    }
}

/// Returns equally spaced points along a closed path, from its first pixel on.
fn spaced(pixels: &[Pixel], count: usize) -> Vec<DVec2> {
    let point = |&(row, column): &Pixel| DVec2::new(column as f64, row as f64);
    let corners: Vec<DVec2> = pixels.iter().chain(pixels.first()).map(point).collect();
    let lengths: Vec<f64> = corners.windows(2).map(|w| (w[1] - w[0]).length()).collect();
    let whole: f64 = lengths.iter().sum();
    let (mut side, mut before) = (0, 0.0);
    (0..count)
        .map(|number| {
            let along = whole * number as f64 / count as f64;
            while side + 1 < lengths.len() && before + lengths[side] <= along {
                before += lengths[side];
                side += 1;
            }
            let share = if whole > 0.0 {
                (along - before) / lengths[side]
            } else {
                0.0
            };
            corners[side].lerp(corners[(side + 1).min(corners.len() - 1)], share)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use edgegait_core::silhouette::Size;

    /// Returns a silhouette from lines of `#` and `.`.
    fn drawn(lines: &[&str]) -> Silhouette {
        let row = |line: &&str| {
            let bits = line.bytes().enumerate();
            bits.map(|(column, byte)| u64::from(byte == b'#') << column)
                .sum()
        };
        let rows: Vec<u64> = lines.iter().map(row).collect();
        Silhouette::from_rows(Size::S50x30, &rows)
    }

    #[test]
    fn the_outline_of_a_square_is_walked_clockwise_from_its_upper_left() {
        let square = drawn(&["....", ".###", ".###", ".###"]);
        let points = outline(&square, 8).expect("a figure");
        let expected = [
            (1, 1),
            (2, 1),
            (3, 1),
            (3, 2),
            (3, 3),
            (2, 3),
            (1, 3),
            (1, 2),
        ];
        assert_eq!(
            points,
            expected.map(|(x, y)| DVec2::new(f64::from(x), f64::from(y)))
        );
        // Twice as many points are half as far apart.
        let points = outline(&square, 16).expect("a figure");
        assert_eq!(points[1], DVec2::new(1.5, 1.0));
        assert_eq!(points[15], DVec2::new(1.0, 1.5));
    }

    #[test]
    fn corners_count_as_the_root_of_two() {
        // A diamond of four pixels: each side is a diagonal.
        let diamond = drawn(&[".#.", "#.#", ".#."]);
        let points = outline(&diamond, 8).expect("a figure");
        assert_eq!(points[0], DVec2::new(1.0, 0.0));
        assert!((points[1] - DVec2::new(1.5, 0.5)).length() < 1e-12);
        assert!((points[2] - DVec2::new(2.0, 1.0)).length() < 1e-12);
        assert!((points[6] - DVec2::new(0.0, 1.0)).length() < 1e-12);
    }

    #[test]
    fn a_line_is_walked_there_and_back_and_a_pixel_is_a_point() {
        let line = drawn(&["###"]);
        let x: Vec<f64> = outline(&line, 4)
            .expect("a figure")
            .iter()
            .map(|p| p.x)
            .collect();
        assert_eq!(x, [0.0, 1.0, 2.0, 1.0]);
        let pixel = outline(&drawn(&["..", ".#"]), 3).expect("a figure");
        assert_eq!(pixel, [DVec2::ONE; 3]);
        assert_eq!(outline(&drawn(&[]), 3), None);
    }

    #[test]
    fn only_the_outer_boundary_of_the_largest_figure_counts() {
        let whole = ["......", ".####.", ".####.", ".####.", ".####."];
        let spoilt = [
            "#.....", ".####.", ".#.##.", ".####.", ".####.", "......", "##....",
        ];
        // In `spoilt`, a speck that touches the figure at a corner is part of it.
        let specks = [
            "......", ".####.", ".####.", ".####.", ".####.", "......", "##....",
        ];
        let of = |lines: &[&str]| outline(&drawn(lines), 24).expect("a figure");
        assert_eq!(of(&whole), of(&specks));
        assert_ne!(of(&whole), of(&spoilt));
        assert_eq!(of(&spoilt)[0], DVec2::ZERO);
    }

    #[test]
    fn a_boundary_that_meets_itself_is_walked_to_its_end() {
        // Two squares that touch at a corner: the path passes the corner's pixels twice.
        let pair = drawn(&["##..", "##..", "..##", "..##"]);
        let pixels = boundary(&pair).expect("a figure");
        assert_eq!(
            pixels,
            [
                (0, 0),
                (0, 1),
                (1, 1),
                (2, 2),
                (2, 3),
                (3, 3),
                (3, 2),
                (2, 2),
                (1, 1),
                (1, 0)
            ]
        );
    }
}
