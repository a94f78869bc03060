//! Loss of resolution: a sensor with coarse pixels.

use super::fine::Fine;
use super::picture::BitPicture;
use glam::DVec2;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

/// The number of rows of a figure at strength 1. Our choice.
const ROWS: f64 = 10.0;

/// Replaces samples by cells, which are on if at least half of their samples are. Cells are as
/// large as samples at strength 0, and a figure has ten rows of cells at strength 1; the size is
/// linear between, and the cells' origin random.
pub(crate) fn coarsen(picture: &mut BitPicture, fine: &Fine, strength: f64, rng: &mut ChaCha8Rng) {
    let most = (fine.figure().size.y / ROWS).max(1.0);
    to_cells(picture, fine, 1.0 + strength * (most - 1.0), rng);
}

/// Replaces samples by cells of this height in samples, at least 1, with a random origin.
pub(crate) fn to_cells(picture: &mut BitPicture, fine: &Fine, height: f64, rng: &mut ChaCha8Rng) {
    let phase = DVec2::new(rng.random(), rng.random());
    let scale = fine.samples_per_metre();
    let width = (height * scale.x / scale.y).max(1.0);
    let Some(bounds) = picture.bounds() else {
        return;
    };
    let rows = borders(phase.y, height, picture.rows());
    let columns = borders(phase.x, width, picture.columns());
    let first = columns.partition_point(|&at| at <= bounds.left);
    let last = columns.partition_point(|&at| at < bounds.right);
    let columns = &columns[first.saturating_sub(1)..=last.min(columns.len() - 1)];
    // The word of each border, and the bits before the border in it.
    let places = columns.iter().map(|at| (at / 64, !(u64::MAX << (at % 64))));
    let places: Vec<(usize, u64)> = places.collect();
    let mut before = Vec::new();
    for rows in rows.windows(2) {
        let rows = rows[0]..rows[1];
        if rows.end <= bounds.top || rows.start >= bounds.bottom {
            continue;
        }
        before.clear();
        before.resize(columns.len(), 0);
        for row in rows.clone() {
            add_counts(picture.row(row), &places, &mut before);
        }
        let first = rows.start;
        picture.row_mut(first).fill(0);
        for (cell, before) in columns.windows(2).zip(before.windows(2)) {
            let on = (before[1] - before[0]) as usize;
            if 2 * on >= rows.len() * (cell[1] - cell[0]) {
                picture.fill(first, cell[0].cast_signed(), cell[1].cast_signed(), true);
            }
        }
        for row in first + 1..rows.end {
            picture.copy_row(first, row);
        }
    }
}

/// Adds to each sum how many columns of a row before this border are on; borders increase.
fn add_counts(row: &[u64], borders: &[(usize, u64)], sums: &mut [u32]) {
    let (mut word, mut before) = (0, 0);
    for (&(border, bits), sum) in borders.iter().zip(sums) {
        while word < border {
            before += row[word].count_ones();
            word += 1;
        }
        *sum += before + row.get(word).map_or(0, |row| (row & bits).count_ones());
    }
}

/// Returns the distinct borders of cells, from 0 to `end`.
fn borders(phase: f64, size: f64, end: usize) -> Vec<usize> {
    let mut borders = vec![0];
    for number in 0.. {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "samples of a picture"
        )]
        let at = libm::floor((phase + f64::from(number)) * size) as usize;
        if at >= end {
            break;
        }
        if borders.last().is_some_and(|&last| at > last) {
            borders.push(at);
        }
    }
    borders.push(end);
    borders
}

#[cfg(test)]
mod tests {
    use super::super::picture::FigureSamples;
    use super::super::tests::side_view;
    use super::*;
    use rand::SeedableRng as _;

    #[test]
    fn a_figure_has_ten_rows_of_cells_at_strength_1() {
        for seed in 0..9_u8 {
            let (fine, before, FigureSamples { bounds, .. }) = side_view(usize::from(seed));
            let mut picture = before.clone();
            let mut rng = ChaCha8Rng::seed_from_u64(seed.into());
            coarsen(&mut picture, &fine, 1.0, &mut rng);
            let now = picture.bounds().expect("a figure");
            assert!(now.top + 15 > bounds.top && now.bottom < bounds.bottom + 15);
            let changes: Vec<usize> = (now.top + 1..now.bottom)
                .filter(|&row| picture.row(row) != picture.row(row - 1))
                .collect();
            assert!(
                changes
                    .iter()
                    .all(|at| (at - changes[0]).is_multiple_of(15)),
                "{changes:?}"
            );
            // Checks cells against counts of single samples.
            let (top, left) = (changes[0], now.left);
            for (row, column) in (0..3).flat_map(|row| (0..3).map(move |c| (row, c))) {
                let (row, column) = (top + 15 * row, left + 15 * column);
                let cell = (row..row + 15).flat_map(|r| (column..column + 15).map(move |c| (r, c)));
                let on = cell.filter(|&(r, c)| before.is_on(r, c)).count();
                assert_eq!(picture.is_on(row, column), 2 * on >= 225, "{on}");
            }
        }
    }

    #[test]
    fn cells_have_any_size_on_average() {
        let borders = borders(0.3, 1.6, 160);
        assert_eq!((borders[0], borders[borders.len() - 1]), (0, 160));
        assert!(
            borders
                .windows(2)
                .all(|cell| (1..=2).contains(&(cell[1] - cell[0])))
        );
        assert!((99..=102).contains(&borders.len()));
    }
}
