//! A skeleton and a skin for a mesh that has none.
//!
//! Scanners and modelling programs write bodies as surfaces only (OBJ). The surface of a body that
//! stands with its arms away from its trunk, as in an A- or a T-pose, determines its joints well
//! enough for walking: [`from_obj`] finds them and lets each bone move the vertices near it. The
//! mesh is then used like the skinned body of a glTF file.

mod centres;
mod proximity;
mod surface;

use std::path::Path;

use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

use self::centres::Centres;
use super::cohort::anthropometry::{DIMENSIONS, Dimensions, PopulationNorms};
use super::retarget::rest_pose::standing_points;
use crate::error::{Error, Result};
use crate::import::obj::Mesh;
use crate::import::{Motion, MotionFormat, Skin, SourceFrame, SourceJoint};
use edgegait_core::pack::Sex;

/// The plausible statures of a mesh, metres. They span less than a factor of ten, so that only one
/// decimal unit fits.
const STATURE_M: std::ops::Range<f64> = 0.3..3.0;

/// Units of meshes, metres (MakeHuman exports decimetres).
const UNITS_M: [f64; 4] = [1.0, 0.1, 0.01, 0.001];

/// Reads a `.obj` of a person who stands with the arms away from the trunk, and gives it the
/// canonical joints (named after [`Joint`]) and a skin. The motion has one frame, the pose of the
/// mesh, in metres, Y up, facing +Z, whatever the file has (Y or Z up; metres, decimetres,
/// centimetres or millimetres).
///
/// The joints are those of a person of this stature, moved into the middle of the limbs. If a
/// `skeleton` is given, they are those of its rest pose, which must be the mesh's pose. A skeleton
/// with a skin must lie in the mesh; the ankles of one without are put onto the mesh's.
///
/// # Errors
/// If the file cannot be read or is not a figure with two arms and two legs, or if the skeleton
/// lies outside of it.
pub fn from_obj(path: impl AsRef<Path>, skeleton: Option<&Motion>) -> Result<Motion> {
    let path = path.as_ref();
    let mut mesh = Mesh::read(path)?;
    let fail = |problem: String| Error::input(path, problem);
    stand_up(&mut mesh).map_err(fail)?;
    let dimensions = expected_dimensions(&mesh)?;
    let mut centres = Centres::find(&mesh, &dimensions).map_err(fail)?;
    if let Some(skeleton) = skeleton {
        let points = standing_points(skeleton).map_err(fail)?;
        let has_place = skeleton.skin.is_some();
        centres = centres
            .with_joints(points, has_place, &mesh)
            .map_err(fail)?;
    }
    let weights = proximity::weights(&mesh.vertices, &centres, &dimensions);
    Ok(rigged(mesh, &centres, weights))
}

/// Turns a mesh Y up and towards +Z, in metres, with the soles on y = 0.
fn stand_up(mesh: &mut Mesh) -> std::result::Result<(), String> {
    let (low, high) = bounds(&mesh.vertices);
    let size = high - low;
    if size.z > size.y {
        for v in &mut mesh.vertices {
            *v = DVec3::new(v.x, v.z, -v.y);
        }
    }
    let height = size.y.max(size.z);
    let unit = UNITS_M
        .into_iter()
        .find(|unit| STATURE_M.contains(&(height * unit)))
        .ok_or_else(|| {
            format!("no known unit makes a figure of {height} units as tall as a person")
        })?;
    let floor = bounds(&mesh.vertices).0.y;
    for v in &mut mesh.vertices {
        *v = DVec3::new(v.x, v.y - floor, v.z) * unit;
    }
    if faces_back(mesh, height * unit) {
        for v in &mut mesh.vertices {
            *v = DVec3::new(-v.x, v.y, -v.z);
        }
    }
    Ok(())
}

/// Returns whether the feet, below 4 % of the stature, reach farther behind the shanks, from 10
/// to 20 %, than ahead of them.
fn faces_back(mesh: &Mesh, stature_m: f64) -> bool {
    let reach = |heights: std::ops::Range<f64>| {
        let z = mesh
            .vertices
            .iter()
            .filter(|v| heights.contains(&(v.y / stature_m)));
        z.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v.z), high.max(v.z))
        })
    };
    let (feet, shanks) = (reach(0.0..0.04), reach(0.10..0.20));
    shanks.0 - feet.0 > feet.1 - shanks.1
}

fn bounds(points: &[DVec3]) -> (DVec3, DVec3) {
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    points.iter().fold(start, |(low, high), point| {
        (low.min(*point), high.max(*point))
    })
}

/// Returns the dimensions of a person as tall as the mesh, of the mean mass index, of either sex.
fn expected_dimensions(mesh: &Mesh) -> Result<Dimensions> {
    let stature_m = bounds(&mesh.vertices).1.y;
    let bmi = |sex| PopulationNorms::for_sex(sex).bmi.0;
    let mean = 0.5 * (bmi(Sex::Female) + bmi(Sex::Male));
    Dimensions::expected(
        stature_m,
        mean * stature_m * stature_m,
        None,
        &[0.0; DIMENSIONS],
    )
}

fn rigged(mesh: Mesh, centres: &Centres, weights: Vec<Vec<(usize, f64)>>) -> Motion {
    let joints = Joint::ALL.map(|joint| {
        let at = centres.joints[joint.index()];
        SourceJoint {
            name: format!("{joint:?}"),
            parent: joint.parent().map(Joint::index),
            offset: joint
                .parent()
                .map_or(DVec3::ZERO, |parent| at - centres.joints[parent.index()]),
            end: centres.ends[joint.index()].map(|end| end - at),
        }
    });
    let root = centres.joints[Joint::Pelvis.index()];
    Motion {
        format: MotionFormat::Obj,
        joints: joints.to_vec(),
        sample_rate_hz: 30.0,
        frames: vec![SourceFrame {
            root,
            rotations: vec![DQuat::IDENTITY; JOINTS],
            offsets: None,
        }],
        unit_m: Some(1.0),
        skin: Some(Skin {
            vertices: mesh.vertices,
            triangles: mesh.triangles,
            weights,
            root,
        }),
        warnings: Vec::new(),
    }
}
