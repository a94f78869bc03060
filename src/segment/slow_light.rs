//! What varies slowly over a picture of differences, and its removal.

/// Number of tiles over the height of a picture, and of tiles to each side whose medians' median is
/// what varies slowly. Our choice: squares of two thirds of the height, of which a figure of the
/// whole height covers less than half, and small enough for a lens that flares.
const TILES: usize = 16;
const TILES_NEAR: usize = 5;

/// Removes what varies slowly over the picture: a lens that flares, a lamp on one side, and tones
/// that a camera bends as it changes its exposure. It is the median over tiles near each tile of
/// their medians, of which a figure covers less than half, and linear between the tiles' centres.
pub(super) fn remove_slow(away: &mut [[f32; 3]], columns: usize) {
    let rows = away.len() / columns;
    let side = (rows / TILES).max(4);
    let (across, down) = ((columns / side).max(1), (rows / side).max(1));
    let of_tile = |at: usize| -> [f32; 3] {
        let (row, column) = (at / across, at % across);
        let part = |of: usize, parts: usize, all: usize| of * all / parts..(of + 1) * all / parts;
        let rows = part(row, down, rows).step_by(3);
        let pixels = rows.flat_map(|row| {
            let columns_of = part(column, across, columns);
            &away[row * columns..][columns_of]
        });
        medians(&pixels.step_by(4).collect::<Vec<_>>())
    };
    let tiles: Vec<[f32; 3]> = (0..across * down).map(of_tile).collect();
    // As many at the sides of the picture as in its middle.
    let near = |of: usize, all: usize| {
        let last = all.saturating_sub(2 * TILES_NEAR + 1);
        let from = of.saturating_sub(TILES_NEAR).min(last);
        from..(from + 2 * TILES_NEAR + 1).min(all)
    };
    let slow: Vec<[f32; 3]> = (0..tiles.len())
        .map(|at| {
            let rows = near(at / across, down);
            let columns = near(at % across, across);
            let tiles = rows.flat_map(|row| &tiles[row * across..][columns.clone()]);
            medians(&tiles.collect::<Vec<_>>())
        })
        .collect();
    // The tiles before and after a pixel's centre, and the weight of the one after.
    let between = |at: usize, all: usize, tiles: usize| {
        let place = (at as f32 + 0.5) * tiles as f32 / all as f32 - 0.5;
        let place = place.clamp(0.0, (tiles - 1) as f32);
        let before = place as usize;
        (before, (before + 1).min(tiles - 1), place - before as f32)
    };
    let mix = |from: [f32; 3], to: [f32; 3], weight: f32| -> [f32; 3] {
        std::array::from_fn(|part| from[part] + weight * (to[part] - from[part]))
    };
    let columns_between: Vec<_> = (0..columns)
        .map(|column| between(column, columns, across))
        .collect();
    for (row, pixels) in away.chunks_exact_mut(columns).enumerate() {
        let (above, below, weight) = between(row, rows, down);
        let line: Vec<[f32; 3]> = (0..across)
            .map(|at| mix(slow[above * across + at], slow[below * across + at], weight))
            .collect();
        for (pixel, &(left, right, weight)) in pixels.iter_mut().zip(&columns_between) {
            let slow = mix(line[left], line[right], weight);
            *pixel = std::array::from_fn(|part| pixel[part] - slow[part]);
        }
    }
}

/// Returns the median of each part; 0 for an empty list.
fn medians(of: &[&[f32; 3]]) -> [f32; 3] {
    std::array::from_fn(|part| {
        median(of.iter().map(|values| values[part]).collect()).unwrap_or(0.0)
    })
}

/// Returns the median (the upper of two middle values); none for an empty list.
pub(super) fn median(mut values: Vec<f32>) -> Option<f32> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    let (_, median, _) = values.select_nth_unstable_by(middle, f32::total_cmp);
    Some(*median)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_varies_slowly_is_removed_and_a_figure_is_not() {
        // Twelve of LAB more on the right than on the left, and a figure of five sixths of the
        // height and a fifth of that in width.
        let (columns, rows) = (160, 120);
        let figure = |at: usize| {
            let (x, y) = (at % columns, at / columns);
            (60..84).contains(&x) && (10..110).contains(&y)
        };
        let away = |at: usize| {
            let slow = 12.0 * (at % columns) as f32 / columns as f32;
            [
                if figure(at) { slow + 30.0 } else { slow },
                1.0,
                -slow / 3.0,
            ]
        };
        let mut pixels: Vec<[f32; 3]> = (0..columns * rows).map(away).collect();
        remove_slow(&mut pixels, columns);
        for (at, pixel) in pixels.iter().enumerate() {
            let left = pixel[0] - if figure(at) { 30.0 } else { 0.0 };
            // At the sides the squares reach further inwards than outwards: by up to 5 tiles of 7.5
            // pixels, 2.8 of LAB, and by up to as much again where the figure lies between.
            assert!(left.abs() < 5.6, "{at}: {left}");
            assert!(pixel[1].abs() < 1e-6 && pixel[2].abs() < 5.6 / 3.0);
        }
    }
}
