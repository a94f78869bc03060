//! The visible facets of a figure, for all hulls and several cameras together.

use super::RenderView;
use super::image_points::{dot, part, splat, store};
use crate::body::clearance::CLEAR_REACH_M;
use crate::body::plane::{ALWAYS, Facets16};
use crate::body::{Figure, JointPlaces};
use crate::budget::{MAX_HULLS, VIEWS_AT_ONCE};
use crate::camera::Camera;
use crate::simd::{LANES, Lanes, Wide};

/// The facets of a figure that cameras see. 7 kB.
#[derive(Clone, Debug)]
pub struct VisibleFacets {
    /// The eyes in the frames of hulls: their positions, or their directions if they are infinitely
    /// far away.
    eyes: [[[f32; MAX_HULLS]; 3]; VIEWS_AT_ONCE],
    /// The visible facets of hulls, a bit each.
    facing: [[u64; MAX_HULLS]; VIEWS_AT_ONCE],
    /// The facets of hulls that are not beyond their clearances, a bit each; only with `CLEAR`.
    unclear: [[u64; MAX_HULLS]; VIEWS_AT_ONCE],
}

impl VisibleFacets {
    /// The state before any figure.
    pub const NONE: Self = Self {
        eyes: [[[0.0; MAX_HULLS]; 3]; VIEWS_AT_ONCE],
        facing: [[0; MAX_HULLS]; VIEWS_AT_ONCE],
        unclear: [[0; MAX_HULLS]; VIEWS_AT_ONCE],
    };

    /// Returns the facets of a hull that a camera sees, a bit each.
    pub const fn facing(&self, view: usize, hull: usize) -> u64 {
        self.facing[view % VIEWS_AT_ONCE][hull % MAX_HULLS]
    }

    /// Returns the facets of a hull along which its outline may not be clear, a bit each
    /// ([`crate::body::clearance`]).
    pub const fn unclear(&self, view: usize, hull: usize) -> u64 {
        self.unclear[view % VIEWS_AT_ONCE][hull % MAX_HULLS]
    }
}

/// Finds the visible facets: those with the eye on their outer side. For an eye infinitely far away
/// only the direction counts. With `CLEAR`, finds unclear facets, too: all where clearances do not
/// hold, for near eyes, far figures and hulls without them.
#[inline(always)]
pub fn look<L: Wide, const CLEAR: bool>(
    l: L,
    looks: &mut VisibleFacets,
    figure: &Figure<'_>,
    views: &[RenderView],
) {
    let VisibleFacets {
        eyes,
        facing,
        unclear,
    } = looks;
    let is_far_away = CLEAR && !figure.places.is_within(CLEAR_REACH_M);
    let views = views.get(..VIEWS_AT_ONCE).unwrap_or(views);
    for (view, eyes) in views.iter().zip(&mut *eyes) {
        turn_eye(l, &figure.places, &view.camera, eyes);
    }
    for (number, hull) in figure.hull_parts().enumerate() {
        let number = number % MAX_HULLS;
        let seen = views.iter().zip(&*eyes).zip(&mut *facing);
        for (((view, [x, y, z]), facing), unclear) in seen.zip(&mut *unclear) {
            let eye = [x[number], y[number], z[number]];
            let is_near = view.camera.eye().is_some();
            let is_doubtful = is_near || is_far_away || hull.clearances.is_empty();
            let mut bits = [ALWAYS, if is_doubtful { u64::MAX } else { 0 }];
            for (chunk, facets) in hull.facets.iter().enumerate() {
                let facets = (facets, hull.clearances.get(chunk).unwrap_or(&[-1.0; LANES]));
                let found = if L::IS_ONE {
                    seen_by::<_, _, CLEAR>(l, facets, 0, eye, is_near)
                } else {
                    let (half, middle) = (l.half(), LANES / 2);
                    let first = seen_by::<_, _, CLEAR>(half, facets, 0, eye, is_near);
                    let last = seen_by::<_, _, CLEAR>(half, facets, middle, eye, is_near);
                    [first[0] | last[0] << middle, first[1] | last[1] << middle]
                };
                for (bits, found) in bits.iter_mut().zip(found) {
                    *bits |= u64::from(found) << (LANES * chunk);
                }
            }
            facing[number] = bits[0];
            if CLEAR {
                unclear[number] = bits[1];
            }
        }
    }
}

/// Returns the facets from number `first` on that an eye sees, a bit each, and with `CLEAR` those
/// that are not beyond their clearances.
#[inline(always)]
fn seen_by<const N: usize, L: Lanes<N>, const CLEAR: bool>(
    l: L,
    (facets, clearances): (&Facets16, &[f32; LANES]),
    first: usize,
    [x, y, z]: [f32; 3],
    is_near: bool,
) -> [u32; 2] {
    let eye = [l.splat(x), l.splat(y), l.splat(z)];
    let normals = [
        part(l, &facets.x, first),
        part(l, &facets.y, first),
        part(l, &facets.z, first),
    ];
    let threshold = if is_near {
        part(l, &facets.offsets, first)
    } else {
        l.splat(0.0)
    };
    let product = dot(l, eye, normals);
    let seen = l.bits(l.less(threshold, product));
    if !CLEAR {
        return [seen, 0];
    }
    let size = l.max(product, l.sub(l.splat(0.0), product));
    [seen, l.bits(l.not_less(part(l, clearances, first), size))]
}

/// Converts an eye to the frames of all hulls.
#[inline(always)]
fn turn_eye<L: Wide>(
    l: L,
    places: &JointPlaces,
    camera: &Camera,
    eyes: &mut [[f32; MAX_HULLS]; 3],
) {
    let toward = camera.viewpoint().toward();
    let (eye, is_near) = match camera.eye() {
        Some((aim, distance_m)) => (aim + toward * distance_m, true),
        None => (toward, false),
    };
    for hulls in (0..MAX_HULLS).step_by(LANES) {
        let mut eye = splat(l, eye);
        if is_near {
            for (eye, offsets) in eye.iter_mut().zip(&places.offsets) {
                *eye = l.sub(*eye, part(l, offsets, hulls));
            }
        }
        for (eyes, [x, y, z]) in eyes.iter_mut().zip(places.turns.as_chunks().0) {
            let axis = [part(l, x, hulls), part(l, y, hulls), part(l, z, hulls)];
            store(l, dot(l, axis, eye), eyes, hulls);
        }
    }
}
