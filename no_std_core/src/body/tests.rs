use super::*;
use crate::pose::ModelPose;
use crate::skeleton::JOINTS;
use glam::{Mat3, Vec3};

/// A pyramid: a square, and an apex above its centre.
const PYRAMID: [[f32; 3]; 5] = [
    [1.0, 0.0, 1.0],
    [-1.0, 0.0, 1.0],
    [-1.0, 0.0, -1.0],
    [1.0, 0.0, -1.0],
    [0.0, 2.0, 0.0],
];

/// Returns a pose in which joint `j` is at (j, 10, 0), rotated by a quarter turn about the
/// vertical.
fn quarter_turns() -> ModelPose {
    let mut pose = ModelPose::new(
        &crate::skeleton::Skeleton {
            offsets: [Vec3::ZERO; JOINTS],
        },
        &crate::pose::Pose::REST,
    );
    for (index, (at, turn)) in (0u8..).zip(pose.positions.iter_mut().zip(&mut pose.orientations)) {
        *at = Vec3::new(f32::from(index), 10.0, 0.0);
        *turn = Mat3::from_cols(-Vec3::Z, Vec3::Y, Vec3::X);
    }
    pose
}

fn body(hulls: &[(Joint, &[[f32; 3]])]) -> UnpackedBody {
    let mut body = UnpackedBody::default();
    for &(joint, points) in hulls {
        body.push(joint, points.iter().copied().map(Vec3::from))
            .expect("within the budget");
    }
    body
}

#[test]
fn hulls_are_carried_by_their_joints() {
    // LeftThigh is joint 13, Head 4; the quarter turn takes (x, y, z) to (z, y, -x).
    let body = body(&[
        (Joint::LeftThigh, &[[0.0, -0.5, 0.25]]),
        (Joint::Head, &[[1.0, 2.0, 3.0], [0.0; 3]]),
    ]);
    let at_rest = Figure::at_rest(&body);
    assert!(
        at_rest
            .points()
            .eq([[0.0, -0.5, 0.25], [1.0, 2.0, 3.0], [0.0; 3]].map(Vec3::from))
    );
    let figure = Figure::new(&body, &quarter_turns());
    let expected = [[13.25, 9.5, 0.0], [7.0, 12.0, -1.0], [4.0, 10.0, 0.0]].map(Vec3::from);
    assert!(figure.points().eq(expected));
    let mut hulls = figure.hulls();
    assert!(hulls.next().is_some_and(|hull| hull.eq([expected[0]])));
    assert!(
        hulls
            .next()
            .is_some_and(|hull| hull.eq([expected[1], expected[2]]))
    );
    assert!(hulls.next().is_none());
    let mut updated = at_rest;
    updated.update(&quarter_turns());
    assert!(updated.points().eq(expected));
}

/// Returns the normals and offsets of all lanes, including lanes without a facet.
fn planes(hull: &FigureHull<'_>) -> impl Iterator<Item = (Vec3, f32)> {
    let lanes = hull.facets.iter().flat_map(|it| {
        let axes = it.x.iter().zip(&it.y).zip(&it.z);
        axes.zip(&it.offsets)
    });
    lanes.map(|(((&x, &y), &z), &offset)| (Vec3::new(x, y, z), offset))
}

fn edges(hull: &FigureHull<'_>) -> usize {
    hull.edges.iter().map(|edges| edges.len).sum()
}

#[test]
fn facets_are_carried_with_their_points() {
    let body = body(&[(Joint::Pelvis, &[[0.5; 3]]), (Joint::RightFoot, &PYRAMID)]);
    let figure = Figure::new(&body, &quarter_turns());
    let parts: heapless::Vec<_, 2> = figure.hull_parts().collect();
    assert_eq!(parts[0].facets.len(), 0);
    // Six triangles, and lanes without a normal.
    let mut facets = 0;
    let place = figure.places.get(1);
    for (normal, offset) in planes(&parts[1]) {
        let distances = parts[1].points.clone().map(|point| {
            let point = figure.points.get(point).expect("a point");
            normal.dot(place.point(point)) - offset
        });
        let on_it = distances
            .clone()
            .filter(|distance| distance.abs() < 1e-4)
            .count();
        assert!(distances.clone().all(|distance| distance < 1e-4));
        if normal != Vec3::ZERO {
            facets += 1;
            assert!(on_it >= 3, "{normal}");
        }
    }
    assert_eq!(facets, 6);
}

#[test]
fn an_edge_lies_between_two_facets() {
    let body = body(&[(Joint::Pelvis, &PYRAMID)]);
    let figure = Figure::at_rest(&body);
    let hull = figure.hull_parts().next().expect("a hull");
    let surface = Facets::from_points(&PYRAMID.map(Vec3::from));
    assert_eq!(edges(&hull), 9);
    for edge in 0..9 {
        let known = &hull.edges[0];
        let sides = [known.sides[0][edge], known.sides[1][edge]];
        assert_ne!(sides[0], sides[1]);
        for side in sides {
            let corners = surface.facets[usize::from(side)].corners;
            assert!(corners.contains(&known.from[edge]) && corners.contains(&known.to[edge]));
        }
    }
}

#[test]
fn facets_look_the_same_way_whatever_their_size() {
    let unit_normals = |size: f32| {
        let hull = PYRAMID.map(|point| point.map(|c| c * size));
        let body = body(&[(Joint::Pelvis, &hull)]);
        let figure = Figure::at_rest(&body);
        let part = figure.hull_parts().next().expect("a hull");
        let all: heapless::Vec<_, 6> = planes(&part).take(6).collect();
        all.into_iter().map(|(normal, _)| normal.normalize())
    };
    for size in [1e-38, 1e-30, 1e-10, 1e10, 1e30, 1.5e38] {
        for (found, expected) in unit_normals(size).zip(unit_normals(1.0)) {
            assert!((found - expected).length() < 1e-5, "{size:e}: {found}");
        }
    }
}

#[test]
fn an_empty_body_is_an_empty_figure() {
    let body = UnpackedBody::default();
    let figure = Figure::new(&body, &quarter_turns());
    assert!(
        figure.is_empty() && figure.points().next().is_none() && figure.hulls().next().is_none()
    );
}

#[test]
fn what_exceeds_the_budget_is_refused_whole() {
    let len = |body: &UnpackedBody| Figure::at_rest(body).len();
    let mut body = UnpackedBody::default();
    let too_many = [Vec3::ZERO; MAX_HULL_POINTS + 1];
    assert_eq!(body.push(Joint::Pelvis, too_many), Err(OverBudget));
    assert_eq!(len(&body), 0);
    for _ in 0..MAX_POINTS / MAX_HULL_POINTS {
        let hull = [Vec3::ZERO; MAX_HULL_POINTS];
        assert_eq!(body.push(Joint::Pelvis, hull), Ok(()));
    }
    assert_eq!(body.push(Joint::Pelvis, [Vec3::ZERO]), Err(OverBudget));
    assert_eq!(len(&body), MAX_POINTS);
    let mut many = UnpackedBody::default();
    for _ in 0..MAX_HULLS {
        assert_eq!(many.push(Joint::Pelvis, [Vec3::ZERO]), Ok(()));
    }
    assert_eq!(many.push(Joint::Pelvis, [Vec3::ZERO]), Err(OverBudget));
    assert_eq!(len(&many), MAX_HULLS);
}

#[test]
fn the_points_of_a_draped_hull_hang_on_a_joint_each() {
    // LeftShank is joint 14, RightShank 17; the quarter turn takes (x, y, z) to (z, y, -x).
    let mut body = body(&[(Joint::Head, &[[0.0; 3]])]);
    let cloth = [
        (Joint::LeftShank, Vec3::ZERO),
        (Joint::RightShank, Vec3::new(1.0, 2.0, 3.0)),
        (Joint::Pelvis, Vec3::Y),
        (Joint::RightShank, Vec3::X),
    ];
    assert_eq!(body.push_draped(cloth), Ok(()));
    let figure = Figure::new(&body, &quarter_turns());
    let expected = [
        [14.0, 10.0, 0.0],
        [20.0, 12.0, -1.0],
        [0.0, 11.0, 0.0],
        [17.0, 10.0, -1.0],
    ];
    let found = figure.hulls().nth(1).expect("the cloth");
    assert!(found.eq(expected.map(Vec3::from)));
    // A tetrahedron in this pose and at rest.
    for figure in [&figure, &Figure::at_rest(&body)] {
        let part = figure.hull_parts().nth(1).expect("the cloth");
        assert_eq!((edges(&part), part.facets.len()), (6, 1));
    }
}

#[test]
fn facets_of_a_draped_hull_are_found_anew_in_each_pose() {
    let corners = PYRAMID.map(Vec3::from).into_iter().zip([
        Joint::LeftThigh,
        Joint::LeftThigh,
        Joint::RightThigh,
        Joint::RightThigh,
        Joint::Spine,
    ]);
    let mut body = UnpackedBody::default();
    assert_eq!(
        body.push_draped(corners.map(|(point, joint)| (joint, point))),
        Ok(())
    );
    let mut pose = quarter_turns();
    pose.positions = [10.0 * Vec3::Y; JOINTS];
    let mut figure = Figure::at_rest(&body);
    // Upright, then upside down: the apex below the square.
    for (apex, sign) in [(12.0, 1.0), (8.0, -1.0)] {
        pose.positions[Joint::Spine.index()].y = apex - 2.0;
        figure.update(&pose);
        let part = figure.hull_parts().next().expect("the cloth");
        let slopes = planes(&part)
            .filter(|(n, _)| n.y * sign > 0.1 * n.length())
            .count();
        assert_eq!(slopes, 4);
    }
    // Flat: a border and no facet.
    pose.positions[Joint::Spine.index()].y = 8.0;
    figure.update(&pose);
    let part = figure.hull_parts().next().expect("the cloth");
    assert_eq!((part.facets.len(), edges(&part)), (0, 4));
}

#[test]
fn draped_hulls_beyond_the_budget_are_refused_whole() {
    let hanging = |points: usize| (0..points).map(|_| (Joint::Head, Vec3::ZERO));
    let mut body = UnpackedBody::default();
    assert_eq!(
        body.push_draped(hanging(MAX_HULL_POINTS + 1)),
        Err(OverBudget)
    );
    for _ in 0..MAX_DRAPED_HULLS {
        assert_eq!(body.push_draped(hanging(MAX_HULL_POINTS)), Ok(()));
    }
    assert_eq!(body.push_draped(hanging(1)), Err(OverBudget));
    assert_eq!(
        Figure::at_rest(&body).len(),
        MAX_DRAPED_HULLS * MAX_HULL_POINTS
    );
    // Rigid hulls still fit, until no points are left.
    for _ in MAX_DRAPED_HULLS..MAX_POINTS / MAX_HULL_POINTS {
        assert_eq!(
            body.push(Joint::Head, [Vec3::ZERO; MAX_HULL_POINTS]),
            Ok(())
        );
    }
    assert_eq!(body.push(Joint::Head, [Vec3::ZERO]), Err(OverBudget));
}

#[test]
fn as_many_hulls_with_as_many_facets_as_there_can_be_fit() {
    // Octahedra have 6 points and 8 facets.
    let octahedron = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    let mut body = UnpackedBody::default();
    for hull in 0..MAX_HULLS {
        let pushed = if hull < MAX_DRAPED_HULLS {
            body.push_draped(octahedron.map(|point| (Joint::Head, point)))
        } else {
            body.push(Joint::Head, octahedron)
        };
        assert_eq!(pushed, Ok(()));
    }
    assert_eq!(body.push(Joint::Head, octahedron), Err(OverBudget));
    let figure = Figure::new(&body, &quarter_turns());
    assert!(figure.hull_parts().all(|part| edges(&part) == 12));
}
