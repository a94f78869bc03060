//! The outline of a hull in the image: a 2-D convex hull, without a heap.

use crate::budget::{MAX_HULL_POINTS, MAX_OUTLINE};
use glam::Vec2;

/// A convex polygon in pixel coordinates. All outlines turn the same way, so that
/// overlapping ones never cancel.
pub type Outline = heapless::Vec<Vec2, MAX_OUTLINE>;

/// Returns the convex hull of at most the first 32 `points` (Andrew 1979, monotone chain). Points
/// on one line give fewer than three corners.
#[must_use]
pub fn convex(points: impl IntoIterator<Item = Vec2>) -> Outline {
    let mut sorted: heapless::Vec<Vec2, MAX_HULL_POINTS> =
        points.into_iter().take(MAX_HULL_POINTS).collect();
    sorted.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut outline = Outline::new();
    chain(&mut outline, sorted.iter().copied());
    let turned = outline.len().saturating_sub(1);
    chain_behind(&mut outline, turned, sorted.iter().rev().copied().skip(1));
    // The chain closes on its first corner.
    outline.pop();
    outline
}

/// Adds one half of the chain.
#[inline]
fn chain(outline: &mut Outline, points: impl Iterator<Item = Vec2>) {
    chain_behind(outline, 0, points);
}

/// Adds points after corner `base`, dropping corners that do not turn.
#[inline]
fn chain_behind(outline: &mut Outline, base: usize, points: impl Iterator<Item = Vec2>) {
    for point in points {
        while let [.., before, last] = outline.as_slice() {
            if outline.len() < base + 2 || (*last - *before).perp_dot(point - *last) > 0.0 {
                break;
            }
            outline.pop();
        }
        // At most as many corners as points, which the capacity exceeds by four.
        let _ = outline.push(point);
    }
}

/// Returns the part of a convex `outline` inside `min..=max` (Sutherland & Hodgman 1974).
#[must_use]
pub fn clipped(outline: &Outline, min: Vec2, max: Vec2) -> Outline {
    let inside_all = outline
        .iter()
        .all(|p| p.cmpge(min).all() && p.cmple(max).all());
    if inside_all {
        return outline.clone();
    }
    let outline = cut(outline, Vec2::X, min.x);
    let outline = cut(&outline, -Vec2::X, -max.x);
    let outline = cut(&outline, Vec2::Y, min.y);
    cut(&outline, -Vec2::Y, -max.y)
}

/// Returns the part of a convex outline where `normal . point >= limit`.
fn cut(outline: &Outline, normal: Vec2, limit: f32) -> Outline {
    let mut kept = Outline::new();
    let Some(mut before) = outline.last().copied() else {
        return kept;
    };
    let mut height_before = normal.dot(before) - limit;
    for &corner in outline {
        let height = normal.dot(corner) - limit;
        if (height < 0.0) != (height_before < 0.0) {
            // A convex outline crosses a line at most twice, which adds at most one corner.
            let _ = kept.push(crossing([before, corner], normal, limit));
        }
        if height >= 0.0 {
            let _ = kept.push(corner);
        }
        (before, height_before) = (corner, height);
    }
    kept
}

/// Returns where a line crosses `normal . point = limit`, for a normal along an axis.
pub(crate) fn crossing([from, to]: [Vec2; 2], normal: Vec2, limit: f32) -> Vec2 {
    let [before, after] = [from, to].map(|end| normal.dot(end) - limit);
    let mut crossing = from + (to - from) * (before / (before - after));
    // Exactly on the line, in spite of rounding.
    if normal.x == 0.0 {
        crossing.y = limit * normal.y;
    } else {
        crossing.x = limit * normal.x;
    }
    crossing
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(outline: &Outline) -> f32 {
        let next = outline.iter().cycle().skip(1);
        outline
            .iter()
            .zip(next)
            .map(|(a, b)| a.perp_dot(*b))
            .sum::<f32>()
            * 0.5
    }

    #[test]
    fn inner_points_are_dropped_and_corners_turn_one_way() {
        let points = [
            Vec2::new(0.0, 0.0),
            Vec2::new(2.0, 2.0),
            Vec2::new(2.0, 0.0),
            Vec2::new(1.0, 1.0),
            Vec2::new(0.0, 2.0),
            Vec2::new(1.0, 0.0),
        ];
        let outline = convex(points);
        assert_eq!(outline.len(), 4);
        assert_eq!(area(&outline), 4.0);
        let mirrored = convex(points.map(|p| Vec2::new(-p.x, p.y)));
        assert_eq!(area(&mirrored), 4.0);
    }

    #[test]
    fn points_on_a_line_have_no_area() {
        assert!(convex([Vec2::ZERO; 5]).len() < 3);
        assert!(convex((0..9u8).map(|i| Vec2::splat(f32::from(i)))).len() < 3);
        assert!(convex([]).is_empty());
    }

    #[test]
    fn clipping_keeps_what_is_inside() {
        let square = convex([
            Vec2::ZERO,
            Vec2::new(4.0, 0.0),
            Vec2::new(0.0, 4.0),
            Vec2::new(4.0, 4.0),
        ]);
        let part = clipped(&square, Vec2::new(1.0, -9.0), Vec2::new(3.0, 2.0));
        assert_eq!(area(&part), 4.0);
        let none = clipped(&square, Vec2::splat(5.0), Vec2::splat(6.0));
        assert!(none.len() < 3 || area(&none) == 0.0);
        assert_eq!(clipped(&square, Vec2::ZERO, Vec2::splat(4.0)), square);
    }
}
