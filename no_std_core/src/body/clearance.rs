//! When the outline of a hull in the image is beyond doubt.

use super::plane::{edges_of, exponent};
use crate::budget::{LANES, MAX_HULL_FACETS, MAX_HULL_POINTS};
use crate::facets::Facets;
use glam::{DVec3, Vec3};

/// The clear sine: outlines are clear where each edge has all other points of the hull on one side
/// by more than this angle, seen from an end of the edge.
///
/// The chain of [`crate::outline::convex`] errs by less than 3/2^24 at each of at most 31 turns.
pub(crate) const CLEAR: f32 = 7e-6;
/// The least scale at which clearances hold, pixels per metre: the same along both axes.
pub(crate) const CLEAR_SCALE: f32 = 24.0;
/// The joints' distance from the origin, along each axis, within which they hold, metres.
pub(crate) const CLEAR_REACH_M: f32 = 1.5;
/// How far from the window's corner the origin may be placed, metres.
pub(crate) const CLEAR_PLACE_M: f32 = 5.0;
/// The error of a point in the image, metres: that of f32 within these distances, for points within
/// [`NEAR_JOINT_M`] of their joint along each axis.
const POINT_ERROR_M: f64 = 2e-6;
const NEAR_JOINT_M: f32 = 0.5;
/// An outline that is wider than this is wider than 1/4,096 pixel.
const WIDTH_M: f64 = 1.1e-5;
/// The error of the direction of a facet's normal.
const NORMAL_ERROR: f64 = 4e-6;
/// Facets that meet at less than this sine have the same directions in front of them: no edge
/// between them is part of an outline if their normals' products are beyond this share.
const FLAT: f64 = 1e-5;

/// Writes for each facet how large the products with its normal, which is twice its area long, must
/// be for outlines along its sides to be clear: endless if they never are, below 0 without a facet.
///
/// For a side `u` between facets with normals `F` and `G`, and a point with the products `f` and
/// `g` behind their planes, the side and the point span `|u| (f G.v + g F.v) / |F x G|` in the image
/// in the direction `v`, twice the triangle's area. It must be more than the clear sine of the
/// hull's size, and more than what errors of points can add.
pub(super) fn set_clearances(surface: &Facets, points: &[Vec3], clearances: &mut [[f32; LANES]]) {
    let exact: heapless::Vec<DVec3, MAX_HULL_POINTS> =
        points.iter().map(|point| point.as_dvec3()).collect();
    let at = |corner: u8| exact.get(usize::from(corner)).copied().unwrap_or_default();
    let mut normals = [DVec3::ZERO; MAX_HULL_FACETS];
    let mut clear = [0.0f64; MAX_HULL_FACETS];
    for ((facet, normal), clear) in surface.facets.iter().zip(&mut normals).zip(&mut clear) {
        let [a, b, c] = facet.corners.map(at);
        *normal = (b - a).cross(c - a);
        let slender = 4e-7 * libm::sqrt((b - a).length_squared() * (c - a).length_squared());
        *clear = (FLAT + NORMAL_ERROR) * normal.length() + slender;
    }
    // Between all pairs of points.
    let mut lengths = [[0.0f64; MAX_HULL_POINTS]; MAX_HULL_POINTS];
    let mut size = 0.0f64;
    for (lengths, &from) in lengths.iter_mut().zip(&exact) {
        for (length, &to) in lengths.iter_mut().zip(&exact) {
            *length = libm::sqrt((to - from).length_squared());
            size = size.max(*length);
        }
    }
    let reach = { points.iter() }.fold(NEAR_JOINT_M, |reach, point| {
        reach.max(point.abs().max_element())
    });
    let reach = (CLEAR_REACH_M + reach) / (CLEAR_REACH_M + NEAR_JOINT_M);
    let error = POINT_ERROR_M * f64::from(reach);
    let edges = edges_of(surface).flat_map(|edges| (0..edges.len).map(move |at| edges.get(at)));
    for [[a, b], [first, second]] in edges {
        let [first, second] = [first, second].map(|side| usize::from(side) % MAX_HULL_FACETS);
        let from = at(a);
        let [of_a, of_b] = [a, b].map(|end| lengths[usize::from(end) % MAX_HULL_POINTS]);
        let side = of_a[usize::from(b) % MAX_HULL_POINTS];
        let both = [normals[first], normals[second]];
        let [long, other_long] = both.map(DVec3::length);
        let fold = both[0].cross(both[1]).length();
        if fold <= FLAT * long * other_long {
            continue;
        }
        let least = side * f64::from(CLEAR) * size;
        let width = side * WIDTH_M;
        let [near, far] = both.map(|normal| (normal, normal.dot(from)));
        let mut needed = [0.0f64; MAX_HULL_POINTS];
        let all = needed.iter_mut().zip(&exact).zip(of_a).zip(of_b);
        for (((needed, &DVec3 { x, y, z }), to_a), to_b) in all {
            let area = least + error * (side + to_a + to_b);
            let area = if area > width { area } else { width };
            // A point may lie in front of a plane by what coordinates are rounded.
            let [f, g] = [near, far]
                .map(|(normal, level)| level - (normal.x * x + normal.y * y + normal.z * z));
            let over = |share: f64| if share > 0.0 { share } else { 0.0 };
            let before = over(-f) * other_long + over(-g) * long;
            *needed = (area * fold / side + before) / (over(f) + over(g));
        }
        let others = (0..)
            .zip(needed)
            .filter(|&(number, _)| number != a && number != b);
        let needed = others.fold(
            0.0,
            |most, (_, needed)| if needed > most { needed } else { most },
        );
        for facet in [first, second] {
            clear[facet] = clear[facet].max(needed);
        }
    }
    // Normals are those of scaled points.
    let scale = libm::ldexp(1.0, -2 * exponent(points));
    let places = clearances.as_flattened_mut().iter_mut();
    for (place, clear) in places.zip(clear).take(surface.facets.len()) {
        #[expect(clippy::cast_possible_truncation, reason = "within f32")]
        let clear = (clear * scale) as f32;
        *place = clear;
    }
}
