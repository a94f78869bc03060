//! Masks of the figure, with morphology by squares and connected parts.

/// A mask: pixels that are on or off, row by row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    columns: usize,
    on: Vec<bool>,
}

impl Mask {
    /// Makes a mask from pixels, row by row, with this many columns.
    ///
    /// # Panics
    /// If the pixels do not fill whole rows.
    #[must_use]
    pub fn new(columns: usize, on: Vec<bool>) -> Self {
        assert!(
            columns > 0 && on.len().is_multiple_of(columns),
            "whole rows"
        );
        Self { columns, on }
    }

    /// Returns the number of columns.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Returns the number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.on.len() / self.columns
    }

    /// Returns the pixels, row by row.
    #[must_use]
    pub fn pixels(&self) -> &[bool] {
        &self.on
    }

    /// Returns the number of pixels that are on.
    #[must_use]
    pub fn area(&self) -> usize {
        self.on.iter().filter(|on| **on).count()
    }

    /// Returns the pixels as grey levels, 0 or 255.
    #[must_use]
    pub fn grey(&self) -> Vec<u8> {
        self.on.iter().map(|on| if *on { 255 } else { 0 }).collect()
    }

    /// Keeps only pixels that are on in `others` too.
    pub(super) fn keep(&mut self, others: impl IntoIterator<Item = bool>) {
        for (on, other) in self.on.iter_mut().zip(others) {
            *on &= other;
        }
    }

    /// Adds the pixels that are on in `others`.
    pub(super) fn join(&mut self, others: impl IntoIterator<Item = bool>) {
        for (on, other) in self.on.iter_mut().zip(others) {
            *on |= other;
        }
    }

    /// Returns all pixels that are at most `reach` rows and columns from a pixel that is on.
    pub(super) fn dilated(&self, reach: usize) -> Self {
        if reach == 0 {
            return self.clone();
        }
        let (columns, width) = (self.columns, 2 * reach + 1);
        // Room on both sides; then each pixel gathers those before it, and is moved back.
        let wide = columns + 2 * reach;
        let mut on = vec![false; wide * self.rows()];
        let rows = on.chunks_exact_mut(wide).zip(self.on.chunks_exact(columns));
        for (into, row) in rows {
            into[reach..][..columns].copy_from_slice(row);
        }
        let across = gathered(on, 1, width);
        let mut on = vec![false; columns * (self.rows() + 2 * reach)];
        let rows = on.chunks_exact_mut(columns).skip(reach);
        for (into, row) in rows.zip(across.chunks_exact(wide)) {
            into.copy_from_slice(&row[2 * reach..]);
        }
        let mut down = gathered(on, columns, width);
        down.drain(..2 * reach * columns);
        Self::new(columns, down)
    }

    /// Returns all pixels without an off pixel within `reach` rows and columns. Outside the picture
    /// no pixel is off.
    pub(super) fn eroded(&self, reach: usize) -> Self {
        self.inverted().dilated(reach).inverted()
    }

    fn inverted(&self) -> Self {
        Self::new(self.columns, self.on.iter().map(|on| !on).collect())
    }

    /// Closes the mask by a square of `reach` pixels to each side (Serra 1982): gaps that are too
    /// narrow for it are filled. Outside the picture no pixel is on.
    pub(super) fn closed(&self, reach: usize) -> Self {
        if reach == 0 {
            return self.clone();
        }
        // Room for what grows beyond the edges and shrinks again.
        let wide = self.columns + 2 * reach;
        let mut on = vec![false; wide * (self.rows() + 2 * reach)];
        for (row, from) in self.on.chunks_exact(self.columns).enumerate() {
            on[(row + reach) * wide + reach..][..self.columns].copy_from_slice(from);
        }
        let closed = Self::new(wide, on).dilated(reach).eroded(reach);
        let rows = closed.on.chunks_exact(wide).skip(reach).take(self.rows());
        let inner = rows.flat_map(|row| &row[reach..reach + self.columns]);
        Self::new(self.columns, inner.copied().collect())
    }

    /// Returns the parts with a pixel that is on in `others`, and the area of the largest of them.
    pub(super) fn with(&self, others: impl IntoIterator<Item = bool>) -> (Self, usize) {
        let (part_of, parts) = self.parts();
        let mut has = vec![false; parts + 1];
        for (part, other) in part_of.iter().zip(others) {
            has[*part as usize] |= other;
        }
        has[0] = false;
        let on = part_of.iter().map(|part| has[*part as usize]);
        let areas = areas(&part_of, parts);
        let kept = areas.iter().zip(&has).filter(|(_, has)| **has);
        let largest = kept.map(|(area, _)| *area).max().unwrap_or(0);
        (Self::new(self.columns, on.collect()), largest)
    }

    /// Fills holes of at most `most` pixels, which are connected to nothing else that is off.
    pub(super) fn filled(&self, most: usize) -> Self {
        let (part_of, parts) = self.inverted().parts();
        let areas = areas(&part_of, parts);
        let on = part_of.iter().map(|part| areas[*part as usize] <= most);
        Self::new(self.columns, on.collect())
    }

    /// Returns the largest part. Pixels are connected to their eight neighbours and across gaps of
    /// at most `2 * gap` pixels. Of equal parts the first from above is kept.
    pub(super) fn largest(&self, gap: usize) -> Self {
        let wide = self.dilated(gap);
        let (part_of, parts) = wide.parts();
        let mut areas = vec![0_usize; parts];
        for (on, part) in self.on.iter().zip(&part_of) {
            if *on {
                areas[*part as usize - 1] += 1;
            }
        }
        let most = areas.iter().copied().max().unwrap_or(0);
        let first = areas.iter().position(|area| *area == most);
        let kept = first.map_or(0, |at| at as u32 + 1);
        let mut largest = self.clone();
        largest.keep(part_of.iter().map(|part| *part == kept));
        largest
    }

    /// Returns the number of each pixel's part, 0 for pixels that are off, and the number of parts.
    /// Parts are connected by all eight neighbours and numbered from 1 in the order of their first
    /// pixels.
    pub(super) fn parts(&self) -> (Vec<u32>, usize) {
        let columns = self.columns;
        // Runs of pixels in a row. Runs that touch get a common root (union-find).
        let mut roots: Vec<u32> = Vec::new();
        let mut part_of = vec![0_u32; self.on.len()];
        let mut above: Vec<(usize, usize, u32)> = Vec::new();
        for (row, pixels) in self.on.chunks_exact(columns).enumerate() {
            let mut here = Vec::new();
            let mut first = 0;
            let mut column = 0;
            while column < columns {
                if !pixels[column] {
                    column += 1;
                    continue;
                }
                let start = column;
                while column < columns && pixels[column] {
                    column += 1;
                }
                let run = roots.len() as u32;
                roots.push(run);
                // Runs above that end left of this one do not touch later ones either.
                while above.get(first).is_some_and(|run| run.1 < start) {
                    first += 1;
                }
                for &(from, _, other) in above[first..].iter().take_while(|run| run.0 <= column) {
                    debug_assert!(from <= column);
                    let (one, two) = (root(&mut roots, run), root(&mut roots, other));
                    roots[one.max(two) as usize] = one.min(two);
                }
                part_of[row * columns + start..row * columns + column].fill(run + 1);
                here.push((start, column, run));
            }
            above = here;
        }
        let mut numbers = vec![0_u32; roots.len()];
        let mut parts = 0;
        for run in 0..roots.len() as u32 {
            let root = root(&mut roots, run) as usize;
            if numbers[root] == 0 {
                parts += 1;
                numbers[root] = parts;
            }
            numbers[run as usize] = numbers[root];
        }
        for part in part_of.iter_mut().filter(|part| **part > 0) {
            *part = numbers[*part as usize - 1];
        }
        (part_of, parts as usize)
    }
}

/// Returns the pixels for which one of `width` pixels is on: itself and those `unit`, `2 * unit`,
/// ... before it. Each step doubles the number of pixels covered.
fn gathered(mut pixels: Vec<bool>, unit: usize, width: usize) -> Vec<bool> {
    let mut covered = 1;
    while covered < width {
        let step = covered.min(width - covered);
        let mut next = pixels.clone();
        for (next, before) in next[step * unit..].iter_mut().zip(&pixels) {
            *next |= *before;
        }
        pixels = next;
        covered += step;
    }
    pixels
}

/// Returns the area of each part by its number; 0 for what is in none.
fn areas(part_of: &[u32], parts: usize) -> Vec<usize> {
    let mut areas = vec![0; parts + 1];
    for part in part_of {
        areas[*part as usize] += 1;
    }
    areas[0] = 0;
    areas
}

/// Returns the root of the runs that are connected to this one.
fn root(roots: &mut [u32], mut run: u32) -> u32 {
    while roots[run as usize] != run {
        let up = roots[roots[run as usize] as usize];
        roots[run as usize] = up;
        run = up;
    }
    run
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(rows: &[&str]) -> Mask {
        let on = rows
            .iter()
            .flat_map(|row| row.bytes().map(|byte| byte == b'#'));
        Mask::new(rows[0].len(), on.collect())
    }

    /// Returns a mask with about `of` sixteenths of its pixels on at random.
    fn random(seed: u32, columns: usize, rows: usize, of: u32) -> Mask {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 28 < of
        };
        Mask::new(columns, (0..columns * rows).map(|_| next()).collect())
    }

    /// Finds every part by a flood from its first pixel.
    fn flooded(mask: &Mask) -> (Vec<u32>, usize) {
        let (columns, rows) = (mask.columns(), mask.rows());
        let mut part_of = vec![0; columns * rows];
        let mut parts = 0;
        for start in 0..columns * rows {
            if !mask.pixels()[start] || part_of[start] > 0 {
                continue;
            }
            parts += 1;
            let mut waiting = vec![start];
            while let Some(at) = waiting.pop() {
                if !mask.pixels()[at] || part_of[at] > 0 {
                    continue;
                }
                part_of[at] = parts;
                let (row, column) = (at / columns, at % columns);
                for r in row.saturating_sub(1)..(row + 2).min(rows) {
                    for c in column.saturating_sub(1)..(column + 2).min(columns) {
                        waiting.push(r * columns + c);
                    }
                }
            }
        }
        (part_of, parts as usize)
    }

    #[test]
    fn parts_are_those_of_a_flood() {
        for seed in 0..60 {
            let mask = random(seed, 1 + seed as usize % 23, 17, 3 + seed % 9);
            assert_eq!(mask.parts(), flooded(&mask), "{seed}");
        }
    }

    #[test]
    fn the_largest_part_may_have_narrow_gaps() {
        let figure = mask(&["##...", "##...", ".....", "##..#", "....#"]);
        let without = mask(&["##...", "##...", ".....", ".....", "....."]);
        assert_eq!(figure.largest(0), without);
        // Both rows of the gap are within one pixel of a pixel that is on.
        let with = mask(&["##...", "##...", ".....", "##...", "....."]);
        let far = mask(&["##....", "##....", "......", "##...#", ".....#"]);
        assert_eq!(far.largest(1).area(), 6);
        assert_eq!(with.largest(1), with);
        assert_eq!(mask(&["...", "..."]).largest(2).area(), 0);
    }

    #[test]
    fn parts_with_a_seed_stay_and_small_holes_are_filled() {
        let figure = mask(&["##..#", "##..#", ".....", "###..", "#.#..", "###.."]);
        let seeds = mask(&[".....", ".#...", ".....", "...#.", ".....", "....."]);
        let kept = mask(&["##...", "##...", ".....", ".....", ".....", "....."]);
        assert_eq!(figure.with(seeds.on), (kept, 4));
        let filled = mask(&["##..#", "##..#", ".....", "###..", "###..", "###.."]);
        assert_eq!(figure.filled(0), figure);
        assert_eq!(
            [1, 14].map(|most| figure.filled(most)),
            [filled.clone(), filled]
        );
        assert_eq!(figure.filled(15).area(), 30);
    }

    #[test]
    fn dilation_and_erosion_are_those_of_every_square() {
        for seed in 0..30 {
            let (columns, rows) = (9 + seed as usize % 5, 11);
            let reach = seed as usize % 4;
            let kind = |mask: &Mask, at: usize, kind: bool| {
                let (row, column) = (at / columns, at % columns);
                let near =
                    |r: usize, c: usize| r.abs_diff(row) <= reach && c.abs_diff(column) <= reach;
                let mut all = (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c)));
                all.any(|(r, c)| near(r, c) && mask.pixels()[r * columns + c] == kind)
            };
            let sparse = random(seed, columns, rows, 1);
            let dense = random(seed, columns, rows, 15);
            let (dilated, eroded) = (sparse.dilated(reach), dense.eroded(reach));
            for at in 0..columns * rows {
                assert_eq!(dilated.pixels()[at], kind(&sparse, at, true));
                assert_eq!(eroded.pixels()[at], !kind(&dense, at, false));
            }
        }
    }

    #[test]
    fn closing_fills_narrow_gaps_and_nothing_at_the_edge() {
        let open = mask(&["#.###", "#.###", "...##", "...##"]);
        assert_eq!(open.closed(1), mask(&["#####", "#####", "...##", "...##"]));
        assert_eq!(
            mask(&[".#.", "...", "..."]).closed(2),
            mask(&[".#.", "...", "..."])
        );
        for seed in 0..20 {
            let once = random(seed, 13, 12, 4).closed(1);
            assert_eq!(once.closed(1), once);
        }
    }
}
