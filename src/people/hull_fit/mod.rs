//! Convex hulls that match a skinned mesh.
//!
//! Hulls around all skin that a joint moves bulge: they fill knees, crotch and armpits (Jaccard
//! index 0.95 at best). So this fit moves hull points until the silhouettes of posed hulls agree
//! with those of the posed mesh, over random poses and cameras, and leaves out the points that
//! cost least. No recorded motion is needed: the poses are those of synthetic walkers, with noise.

mod cached;
mod descent;
mod outline;
mod poses;
mod start;
mod view;

pub(crate) use self::cached::kept_body;
use self::poses::RiggedMesh;
use super::{Body, HullFit};
use crate::error::{Error, Result};
use crate::import::Motion;
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3, Vec3};

/// Points of all hulls of a fitted body by default: a third more add 0.001 to the Jaccard index.
pub(crate) const USUAL_POINTS: usize = 384;
/// Range of points of a fitted body that can be requested.
pub(crate) const POINTS: std::ops::RangeInclusive<usize> = 96..=512;
/// Numbers of points whose match is reported beside the requested number.
const LEVELS: [usize; 6] = [512, 384, 256, 192, 128, 96];
/// Number of progress calls.
pub(crate) const STEPS: usize = 100;
/// Images that hulls are fitted to. Our choice: twice as many bring no gain.
const VIEWS: usize = 400;
/// Random poses, half of them to measure with.
const POSES: usize = 400;

/// Fits a body to a skinned mesh: at most 24 hulls of at most 32 points, `points` in all. Calls
/// `progress` [`STEPS`] times; takes about half a minute on two cores.
///
/// # Errors
/// For a mesh without the joints that gait needs, and for a number of points outside [`POINTS`].
pub(crate) fn fitted_body(
    mesh: &Motion,
    points: usize,
    seed: u64,
    progress: &(dyn Fn() -> Result<()> + Sync),
) -> Result<Body> {
    if !POINTS.contains(&points) {
        return Err(Error::Usage(format!(
            "{points} points of hulls that are fitted to a mesh: expected {} to {}",
            POINTS.start(),
            POINTS.end()
        )));
    }
    let figure = RiggedMesh::from_motion(mesh).map_err(Error::Mesh)?;
    let examples = figure.examples(POSES, seed)?;
    let mut budgets: Vec<usize> = LEVELS.to_vec();
    budgets.push(points);
    budgets.sort_unstable_by(|a, b| b.cmp(a));
    budgets.dedup();
    let mut found = descent::fit(
        &figure.skinned(),
        &examples,
        &budgets,
        VIEWS,
        seed,
        progress,
    )?;
    let frontier = found.iter().map(|level| (level.points, level.jaccard));
    let frontier = frontier.collect();
    let asked = budgets.iter().position(|budget| *budget == points);
    let level = found.swap_remove(asked.unwrap_or(0));
    Ok(Body {
        offsets: figure.offsets,
        hulls: level.hulls,
        draped: Vec::new(),
        clothes: None,
        fit: Some(HullFit {
            jaccard: level.jaccard,
            frontier,
        }),
    })
}

/// A mesh in one pose with the joints of the canonical skeleton, metres.
#[derive(Clone, Debug)]
struct PosedMesh {
    /// Positions of the joints, by [`Joint::index`].
    positions: [DVec3; JOINTS],
    /// Rotations from a joint's frame to the world's.
    rotations: [DQuat; JOINTS],
    /// Vertices of the mesh.
    mesh: Vec<DVec3>,
}

/// A mesh with the joint that moves each vertex most.
#[derive(Clone, Debug)]
struct Skinned {
    /// Vertex indices of the triangles' corners.
    triangles: Vec<[u32; 3]>,
    /// Joint of each vertex.
    joints: Vec<Joint>,
    /// The mesh at rest.
    rest: PosedMesh,
}

impl Skinned {
    /// Returns a vertex of the mesh at rest in a joint's frame.
    fn local(&self, joint: Joint, vertex: usize) -> DVec3 {
        let from = self.rest.mesh[vertex] - self.rest.positions[joint.index()];
        self.rest.rotations[joint.index()].inverse() * from
    }
}

/// Hulls during the fit.
#[derive(Clone, Debug)]
struct FittedHulls {
    hulls: Vec<HullPart>,
}

/// A hull in its joint's frame.
#[derive(Clone, Debug)]
struct HullPart {
    joint: Joint,
    points: Vec<Vec3>,
}

impl FittedHulls {
    fn points(&self) -> usize {
        self.hulls.iter().map(|hull| hull.points.len()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::{MotionFormat, Skin, SourceFrame, SourceJoint};
    use crate::people::cohort::Person;
    use edgegait_core::pack::Sex;
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    /// A figure of boxes, one to a joint, on the average man's skeleton.
    fn boxes() -> Motion {
        let body = Person::average(Sex::Male).body;
        let mut at = [DVec3::ZERO; JOINTS];
        let mut skin = Skin {
            vertices: Vec::new(),
            triangles: Vec::new(),
            weights: Vec::new(),
            root: DVec3::Y,
        };
        at[0] = skin.root;
        for joint in Joint::ALL {
            let index = joint.index();
            if let Some(parent) = joint.parent() {
                at[index] = at[parent.index()] + body.offsets[index];
            }
            let hull = body.hulls.iter().find(|hull| hull.joint == joint);
            let points = &hull.expect("a hull of each joint").points;
            let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
            let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
            let first = u32::try_from(skin.vertices.len()).expect("few");
            for corner in 0..8 {
                let side = |axis: usize| {
                    if corner >> axis & 1 == 0 {
                        low[axis]
                    } else {
                        high[axis]
                    }
                };
                skin.vertices
                    .push(at[index] + DVec3::new(side(0), side(1), side(2)));
                skin.weights.push(vec![(index, 1.0)]);
            }
            // The six sides by their corners' numbers.
            for [a, b, c, d] in [
                [0, 1, 3, 2],
                [4, 5, 7, 6],
                [0, 1, 5, 4],
                [2, 3, 7, 6],
                [0, 2, 6, 4],
                [1, 3, 7, 5],
            ] {
                skin.triangles.push([first + a, first + b, first + c]);
                skin.triangles.push([first + a, first + c, first + d]);
            }
        }
        Motion {
            format: MotionFormat::Gltf,
            joints: Joint::ALL
                .into_iter()
                .map(|joint| SourceJoint {
                    name: format!("{joint:?}"),
                    parent: joint.parent().map(Joint::index),
                    offset: body.offsets[joint.index()],
                    end: None,
                })
                .collect(),
            sample_rate_hz: 30.0,
            frames: vec![SourceFrame {
                root: skin.root,
                rotations: vec![DQuat::IDENTITY; JOINTS],
                offsets: None,
            }],
            unit_m: Some(1.0),
            skin: Some(skin),
            warnings: Vec::new(),
        }
    }

    #[test]
    fn hulls_of_a_figure_of_boxes_are_nearly_those_boxes() {
        let boxes = boxes();
        let figure = RiggedMesh::from_motion(&boxes).expect("a figure");
        let examples = figure.examples(40, 1).expect("poses");
        let fit = || descent::fit(&figure.skinned(), &examples, &[128, 96], 40, 1, &|| Ok(()));
        let levels = fit().expect("hulls");
        assert_eq!(
            levels.iter().map(|level| level.points).collect::<Vec<_>>(),
            [128, 96]
        );
        // Pelvis and spine are two boxes but one hull, and so are thorax and clavicles: the hull
        // also fills the space between them.
        assert!(levels[0].jaccard > 0.93, "{}", levels[0].jaccard);
        assert!(levels[1].jaccard > 0.88, "{}", levels[1].jaccard);
        assert!(levels[0].hulls.len() <= 24);
        assert!(levels[0].hulls.iter().all(|hull| hull.points.len() <= 32));
        let one = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .build()
            .expect("a thread");
        let alone = one.install(fit).expect("hulls");
        assert_eq!(alone[1].hulls[0].points, levels[1].hulls[0].points);
    }

    /// A seeded sample of numbers and triangles that files may state. What fits are like is seen
    /// with four pictures as with four hundred.
    #[test]
    fn a_mesh_with_impossible_parts_is_fitted_or_refused() {
        const EXTREMES: [f64; 9] = [0.0, -0.0, -1.0, 3.0, 1e-30, 1e5, -1e9, 1e20, 3e38];
        let (mut fitted, mut refused) = (0, 0);
        for seed in 0..24 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut mesh = boxes();
            let skin = mesh.skin.as_mut().expect("a skin");
            for _ in 0..rng.random_range(1..6) {
                let extreme = EXTREMES[rng.random_range(0..EXTREMES.len())];
                let (joint, axis) = (rng.random_range(0..JOINTS), rng.random_range(0..3));
                let vertex = rng.random_range(0..skin.vertices.len());
                let triangle = rng.random_range(0..skin.triangles.len());
                match rng.random_range(0..7) {
                    0 => skin.vertices[vertex][axis] = extreme,
                    1 => skin.vertices[vertex] *= extreme,
                    2 => skin.vertices.fill(DVec3::splat(extreme)),
                    3 => skin.triangles[triangle] = [u32::try_from(vertex).expect("few"); 3],
                    4 => skin.triangles.truncate(triangle + 1),
                    5 => mesh.joints[joint].offset[axis] = extreme,
                    _ => skin.weights.fill(vec![(joint, 1.0)]),
                }
            }
            let fit = || {
                let figure = RiggedMesh::from_motion(&mesh).map_err(Error::Mesh)?;
                let examples = figure.examples(4, seed)?;
                descent::fit(&figure.skinned(), &examples, &[96], 4, seed, &|| Ok(()))
            };
            match fit() {
                Ok(levels) => {
                    fitted += 1;
                    let hulls = levels.iter().flat_map(|level| &level.hulls);
                    let mut points = hulls.flat_map(|hull| &hull.points);
                    assert!(points.all(|point| point.is_finite()), "seed {seed}");
                }
                Err(_) => refused += 1,
            }
        }
        assert!(
            fitted > 5 && refused > 5,
            "{fitted} fitted, {refused} refused"
        );
    }

    #[test]
    fn a_number_of_points_out_of_range_is_refused() {
        for points in [0, 95, 513] {
            let error = fitted_body(&boxes(), points, 1, &|| Ok(())).expect_err("out of range");
            assert!(error.to_string().contains("expected 96 to 512"), "{error}");
        }
    }
}
