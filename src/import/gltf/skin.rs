//! Joins the skinned meshes of a glTF file into one [`Skin`].

use glam::{DAffine3, DVec3};
use gltf::mesh::{Mode, Primitive};
use gltf::{Document, Semantic};

use super::buffers::Buffers;
use crate::import::Skin;

/// The maximum number of vertices of all meshes. Our choice: bodies have 10 to 100 thousand.
const MAX_VERTICES: usize = 1_000_000;

/// The maximum number of triangles in all meshes.
const MAX_TRIANGLES: usize = 4_000_000;

/// The maximum number of sets of JOINTS_n and WEIGHTS_n of a mesh, four influences each. Our
/// choice: MakeHuman needs 3.
const MAX_SETS: u32 = 8;

/// Largest deviation from 1 of the sum of a vertex's weights: eight weights as bytes, each rounded
/// the same way, are off by 8 / 510.
const SUM_TOLERANCE: f64 = 0.02;

/// The joints in the rest pose.
pub(super) struct SkinJoints {
    /// Number of the joint, by node; `None` for nodes that are not joints.
    pub(super) numbers: Vec<Option<usize>>,
    /// Transform from the joint's frame at rest to the world, by number of the joint.
    pub(super) rest: Vec<DAffine3>,
}

/// Returns the inverse bind matrices of a skin, by its own numbering of joints.
pub(super) fn inverse_binds(skin: &gltf::Skin, buffers: &Buffers) -> Result<Vec<DAffine3>, String> {
    let joints = skin.joints().count();
    let Some(accessor) = skin.inverse_bind_matrices() else {
        return Ok(vec![DAffine3::IDENTITY; joints]);
    };
    let found = buffers.numbers::<16>(&accessor)?;
    if found.len() < joints {
        return Err(format!(
            "skin {}: expected {joints} inverse bind matrices, found {}",
            skin.index(),
            found.len()
        ));
    }
    let affine = |m: &[f64; 16]| {
        DAffine3::from_cols_array(&[
            m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10], m[12], m[13], m[14],
        ])
    };
    let matrices: Vec<DAffine3> = found.iter().take(joints).map(affine).collect();
    match matrices
        .iter()
        .position(|m| m.matrix3.determinant() < 1e-12)
    {
        None => Ok(matrices),
        Some(joint) => Err(format!(
            "skin {}: inverse bind matrix {joint} is singular or mirrors",
            skin.index()
        )),
    }
}

/// Joins all skinned meshes but those of other people's skins; `None` if there are none. Warnings
/// name the meshes that are left out.
pub(super) fn read(
    document: &Document,
    buffers: &Buffers,
    joints: &SkinJoints,
    is_other: &dyn Fn(&gltf::Skin) -> bool,
    warnings: &mut Vec<String>,
) -> Result<Option<Skin>, String> {
    let mut joined = Skin {
        vertices: Vec::new(),
        triangles: Vec::new(),
        weights: Vec::new(),
        root: joints.rest[0].translation,
    };
    for node in document.nodes() {
        let Some(mesh) = node.mesh() else { continue };
        let name = mesh.name().unwrap_or("without a name").to_owned();
        let Some(skin) = node.skin() else {
            warnings.push(format!("mesh {name} has no skin: left out"));
            continue;
        };
        if is_other(&skin) {
            continue;
        }
        if mesh.primitives().any(|part| part.morph_targets().len() > 0) {
            warnings.push(format!("mesh {name}: its morph targets are left out"));
        }
        let inverse_binds = inverse_binds(&skin, buffers)?;
        let to_rest: Vec<(usize, DAffine3)> = skin
            .joints()
            .zip(inverse_binds)
            .map(|(joint, inverse)| {
                let number = joints.numbers[joint.index()].unwrap_or_default();
                (number, joints.rest[number] * inverse)
            })
            .collect();
        for part in mesh.primitives() {
            let added = add(&mut joined, &part, buffers, &to_rest);
            added.map_err(|problem| format!("mesh {name}, part {}: {problem}", part.index()))?;
        }
    }
    Ok((!joined.triangles.is_empty()).then_some(joined))
}

/// Adds one primitive. `to_rest`, by the skin's numbering, holds the joint's own number and the
/// transform from the mesh to the rest pose.
fn add(
    joined: &mut Skin,
    part: &Primitive,
    buffers: &Buffers,
    to_rest: &[(usize, DAffine3)],
) -> Result<(), String> {
    if part.mode() != Mode::Triangles {
        return Err(format!("expected triangles, found {:?}", part.mode()));
    }
    let positions = part.get(&Semantic::Positions).ok_or("no positions")?;
    let positions = buffers.numbers::<3>(&positions)?;
    let base = joined.vertices.len();
    if base + positions.len() > MAX_VERTICES {
        return Err(format!("more than {MAX_VERTICES} vertices"));
    }
    let mut shares: Vec<Vec<(usize, f64)>> = vec![Vec::new(); positions.len()];
    for set in 0..=MAX_SETS {
        let Some(indices) = part.get(&Semantic::Joints(set)) else {
            break;
        };
        if set == MAX_SETS {
            return Err(format!("more than {MAX_SETS} sets of joints a vertex"));
        }
        let weights = part
            .get(&Semantic::Weights(set))
            .ok_or_else(|| format!("JOINTS_{set} without WEIGHTS_{set}"))?;
        let (indices, weights) = (
            buffers.integers::<4>(&indices)?,
            buffers.numbers::<4>(&weights)?,
        );
        if indices.len() != positions.len() || weights.len() != positions.len() {
            return Err(format!(
                "expected JOINTS_{set} and WEIGHTS_{set} of {} vertices, found {} and {}",
                positions.len(),
                indices.len(),
                weights.len()
            ));
        }
        for (shares, (indices, weights)) in shares.iter_mut().zip(indices.iter().zip(&weights)) {
            let all = indices.iter().zip(weights);
            shares.extend(
                all.filter(|(_, weight)| **weight != 0.0)
                    .map(|(index, weight)| (*index as usize, *weight)),
            );
        }
    }
    for (vertex, (position, shares)) in positions.iter().zip(shares).enumerate() {
        let (at, weights) = at_rest(DVec3::from_array(*position), &shares, to_rest)
            .map_err(|problem| format!("vertex {vertex}: {problem}"))?;
        joined.vertices.push(at);
        joined.weights.push(weights);
    }
    let corners: Vec<u32> = match part.indices() {
        Some(indices) => {
            let corners = buffers.integers::<1>(&indices)?;
            corners.into_iter().map(|[corner]| corner).collect()
        }
        None => (0u32..).take(positions.len()).collect(),
    };
    let (triangles, rest) = corners.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(format!(
            "expected three corners per triangle, found {} in all",
            corners.len()
        ));
    }
    if let Some(corner) = corners
        .iter()
        .find(|corner| **corner as usize >= positions.len())
    {
        return Err(format!(
            "a triangle refers to vertex {corner} of {}",
            positions.len()
        ));
    }
    if joined.triangles.len() + triangles.len() > MAX_TRIANGLES {
        return Err(format!("more than {MAX_TRIANGLES} triangles"));
    }
    let base = u32::try_from(base).map_err(|_| "too many vertices")?;
    let moved = triangles.iter().map(|corners| corners.map(|c| base + c));
    joined.triangles.extend(moved);
    Ok(())
}

/// Returns a vertex in the rest pose, and its weights by number of the joint.
fn at_rest(
    position: DVec3,
    shares: &[(usize, f64)],
    to_rest: &[(usize, DAffine3)],
) -> Result<(DVec3, Vec<(usize, f64)>), String> {
    let sum: f64 = shares.iter().map(|(_, weight)| weight).sum();
    let is_negative = shares.iter().any(|(_, weight)| *weight < 0.0);
    if is_negative || (sum - 1.0).abs() > SUM_TOLERANCE {
        return Err(format!(
            "expected weights of 0 or more that sum to 1, found {sum} (normalise them)"
        ));
    }
    let mut at = DVec3::ZERO;
    let mut merged: Vec<(usize, f64)> = Vec::with_capacity(shares.len());
    for (joint, weight) in shares {
        let (number, to_rest) = to_rest
            .get(*joint)
            .ok_or_else(|| format!("refers to joint {joint} of {} in the skin", to_rest.len()))?;
        let weight = weight / sum;
        at += weight * to_rest.transform_point3(position);
        match merged.iter_mut().find(|(known, _)| known == number) {
            Some((_, known)) => *known += weight,
            None => merged.push((*number, weight)),
        }
    }
    Ok((at, merged))
}
