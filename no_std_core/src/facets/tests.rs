//! Tests of surfaces: by hand, and random integer points against exact integer arithmetic.

use super::*;

fn cube() -> [Vec3; 8] {
    core::array::from_fn(|corner| {
        Vec3::from_array(core::array::from_fn(|axis| (corner >> axis & 1) as f32))
    })
}

/// Asserts that every edge is a side of exactly two triangles, which traverse it in opposite
/// directions.
fn assert_closed(facets: &Facets) {
    for (number, edge) in facets.edges.iter().enumerate() {
        let mut directions = [0; 2];
        for facet in &facets.facets {
            for (side, &of) in facet.edges.iter().enumerate() {
                if usize::from(of) == number {
                    let from = facet.corners[side];
                    let to = facet.corners[(side + 1) % 3];
                    assert_eq!([from.min(to), from.max(to)], *edge);
                    directions[usize::from(from > to)] += 1;
                }
            }
        }
        assert_eq!(directions, [1, 1]);
    }
    // Euler's formula for triangles.
    assert_eq!(3 * facets.facets.len(), 2 * facets.edges.len());
}

#[test]
fn a_cube_has_twelve_triangles_and_no_point_inside() {
    let mut points = [Vec3::splat(0.5); 12];
    points[2..10].copy_from_slice(&cube());
    let facets = Facets::from_points(&points);
    assert_eq!((facets.facets.len(), facets.edges.len()), (12, 18));
    assert_closed(&facets);
    let corners = facets.facets.iter().flat_map(|facet| facet.corners);
    assert!(corners.into_iter().all(|corner| (2..10).contains(&corner)));
}

#[test]
fn a_flat_hull_has_a_border() {
    // Corners 0, 1, 3 and 2 of a slanting square in turn; 4 to 7 lie on them.
    let square = cube().map(|p| Vec3::new(p.x, 0.5 * p.x + 0.5 * p.y, p.y));
    let facets = Facets::from_points(&square);
    assert!(facets.facets.is_empty());
    assert_eq!(facets.edges.len(), 4);
    let ends = |[a, b]: [u8; 2]| [a % 4, b % 4];
    for side in [[0, 1], [1, 3], [3, 2], [2, 0]] {
        let is_side = |edge: &[u8; 2]| ends(*edge) == side || ends(*edge) == [side[1], side[0]];
        assert!(facets.edges.iter().any(is_side), "{side:?}");
    }
}

#[test]
fn lines_points_and_nothing_have_no_surface() {
    let line = [0.0f32, 0.25, 0.5, 1.0].map(|t| Vec3::new(t, 2.0 * t, -t));
    assert_eq!(Facets::from_points(&line), Facets::default());
    assert_eq!(Facets::from_points(&[Vec3::ONE; 7]), Facets::default());
    assert_eq!(Facets::from_points(&[]), Facets::default());
    let mut broken = cube();
    broken[3].y = f32::NAN;
    assert_eq!(Facets::from_points(&broken), Facets::default());
}

#[test]
fn every_point_is_inside_of_every_facet() {
    // 32 points on and in a ball, by a fixed sequence (Roberts 2018).
    let mut points = heapless::Vec::<Vec3, 32>::new();
    for i in 0..32u8 {
        let share = |step: f32| (f32::from(i) * step).fract() - 0.5;
        let point = Vec3::new(share(0.819_172_5), share(0.671_043_6), share(0.549_700_5));
        let radius = if i % 3 == 0 { 0.3 } else { 1.0 };
        points.push(point.normalize() * radius).expect("32 points");
    }
    let facets = Facets::from_points(&points);
    assert_closed(&facets);
    for facet in &facets.facets {
        let [a, b, c] = facet.corners.map(|corner| points[usize::from(corner)]);
        let normal = (b - a).cross(c - a);
        for &point in &points {
            assert!(normal.dot(point - a) < 1e-5, "{facet:?} {point}");
        }
    }
}

/// A point in whole cells.
type Whole = [i128; 3];

fn minus(a: Whole, b: Whole) -> Whole {
    core::array::from_fn(|axis| a[axis] - b[axis])
}

fn times(a: Whole, b: Whole) -> Whole {
    let turned = |u: usize, v: usize| a[u] * b[v] - a[v] * b[u];
    [turned(1, 2), turned(2, 0), turned(0, 1)]
}

fn along(a: Whole, b: Whole) -> i128 {
    (0..3).map(|axis| a[axis] * b[axis]).sum()
}

/// Returns how many dimensions the points span, by trying all combinations.
fn dimensions(points: &[Whole]) -> usize {
    let from_first = || points.iter().map(|&p| minus(p, points[0]));
    let mut most = 0;
    for a in from_first().filter(|&a| a != [0; 3]) {
        most = most.max(1);
        for normal in from_first().map(|b| times(a, b)).filter(|&n| n != [0; 3]) {
            most = most.max(2);
            if from_first().any(|c| along(normal, c) != 0) {
                return 3;
            }
        }
    }
    most
}

/// Returns a random number below `end`, by SplitMix64 (Steele, Lea & Flood 2014).
fn below(state: &mut u64, end: u64) -> i128 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    i128::from((z ^ (z >> 31)) % end)
}

/// Returns whole points whose boxes measure a power of two of cells, so that nothing is rounded: of
/// one kind among spaces, grids, balls, planes, lines and heaps.
fn whole_points(state: &mut u64, kind: usize) -> heapless::Vec<Whole, 32> {
    let len = 2 + below(state, 31) as usize;
    let wide = 1u64 << 16;
    let mut points = heapless::Vec::new();
    for index in 0..len {
        // The corners of the box.
        let corner = match index {
            0 => Some(0),
            1 => Some(1),
            _ => None,
        };
        let mut number = |width: u64| match corner {
            Some(corner) => corner * i128::from(width),
            None => below(state, width + 1),
        };
        let point = match kind {
            0 => [number(wide), number(wide), number(wide)],
            1 => [number(1), number(2), number(4)],
            2 => {
                // A point on the ball in the box.
                let inner = [0; 3].map(|_| number(wide) - i128::from(wide) / 2);
                let reach = along(inner, inner).isqrt().max(1);
                let whole = i128::from(wide) / 2;
                match corner {
                    Some(corner) => [2 * corner * whole; 3],
                    None => inner.map(|c| c * whole / reach + whole),
                }
            }
            3 => {
                let (x, y) = (number(wide), number(wide));
                [x, y, x + y]
            }
            4 => {
                let (x, y) = (number(4), number(4));
                [x, x, y]
            }
            5 => [7, number(wide), number(4)],
            6 => {
                let x = number(wide);
                [x, -2 * x, 4 * x]
            }
            // Nine points in the middle, repeated.
            _ => match corner {
                Some(corner) => [8 * corner; 3],
                None => [2 + number(2), 4, 3 + number(2)],
            },
        };
        points.push(point).expect("at most 32 points");
    }
    points
}

/// Asserts that these edges are one ring around all points of a plane.
fn assert_ring(edges: &[[u8; 2]], points: &[Whole]) {
    let at = |corner: u8| points[usize::from(corner)];
    let mut normals = edges.iter().flat_map(|&[a, b]| {
        let side = minus(at(b), at(a));
        points.iter().map(move |&p| times(side, minus(p, at(a))))
    });
    let normal = normals.find(|&normal| normal != [0; 3]).expect("an area");
    for &[a, b] in edges {
        let side = minus(at(b), at(a));
        let turns = || {
            points
                .iter()
                .map(|&p| along(normal, times(side, minus(p, at(a)))))
        };
        assert!(turns().all(|turn| turn >= 0) || turns().all(|turn| turn <= 0));
        assert!(turns().any(|turn| turn != 0));
    }
    // Walk from edge to edge: the walk returns to the first one after all edges.
    let [start, mut here] = edges[0];
    let mut before = 0;
    let mut steps = 1;
    while here != start {
        let mut next = (0..edges.len()).filter(|&e| e != before && edges[e].contains(&here));
        let edge = next.next().expect("an edge goes on");
        assert!(next.next().is_none());
        here = if edges[edge][0] == here {
            edges[edge][1]
        } else {
            edges[edge][0]
        };
        (before, steps) = (edge, steps + 1);
        assert!(steps <= edges.len());
    }
    assert_eq!(steps, edges.len());
}

#[test]
fn surfaces_of_ten_thousand_sets_of_whole_points_are_their_convex_hulls() {
    let mut state = 61;
    let mut spans = [0; 4];
    for turn in 0..10_000 {
        let points = whole_points(&mut state, turn % 8);
        let floats: heapless::Vec<Vec3, 32> = points
            .iter()
            .map(|point| Vec3::from(point.map(|c| c as f32)))
            .collect();
        let facets = Facets::from_points(&floats);
        let dimensions = dimensions(&points);
        spans[dimensions] += 1;
        if dimensions < 3 {
            assert!(facets.facets.is_empty(), "{points:?}");
        }
        match dimensions {
            3 => {
                assert_closed(&facets);
                let mut is_corner = [false; 32];
                for facet in &facets.facets {
                    let [a, b, c] = facet.corners.map(|corner| points[usize::from(corner)]);
                    let normal = times(minus(b, a), minus(c, a));
                    assert_ne!(normal, [0; 3], "{points:?}");
                    assert!(
                        points.iter().all(|&p| along(normal, minus(p, a)) <= 0),
                        "{points:?}"
                    );
                    for corner in facet.corners {
                        is_corner[usize::from(corner)] = true;
                    }
                }
                // Euler's formula for a sphere.
                let corners = is_corner.iter().filter(|&&is_corner| is_corner).count();
                assert_eq!(corners + facets.facets.len(), facets.edges.len() + 2);
            }
            2 => assert_ring(&facets.edges, &points),
            _ => assert!(facets.edges.is_empty(), "{points:?}"),
        }
    }
    // Each case occurred often enough.
    assert!(
        spans.iter().skip(1).all(|&count| count > 1_000),
        "{spans:?}"
    );
}
