//! Reader of glTF 2.0, as text (.gltf) or binary (.glb): a skinned mesh, its joints and an
//! animation.
//!
//! The rest pose is the bind pose, which the inverse bind matrices state (nodes may hold any frame
//! of any animation), turned upright in the scene. A joint's rotation is relative to its node's
//! global transform in that pose, so joint frames are parallel to the world at rest.

use std::path::Path;

use glam::{DAffine3, DMat3, DQuat, DVec3, DVec4};
use gltf::Document;
use gltf::scene::Transform;

use self::buffers::Buffers;
use self::checks::{check_length, check_targets};
use self::clip::{GltfAnimation, Moves};
use self::skin::SkinJoints;
use super::files::read_file;
use super::{Motion, MotionFormat, SourceFrame, SourceJoint};
use crate::error::{Error, Remedy, Result};

mod buffers;
mod checks;
mod clip;
mod extensions;
mod people;
mod skin;
#[cfg(test)]
mod tests;

/// The maximum number of nodes accepted. Our choice: a scene with an avatar has some hundreds.
const MAX_NODES: usize = 65_536;

/// The maximum number of joints accepted, as for BVH.
const MAX_JOINTS: usize = 4096;

/// Largest deviation of a transform from a rotation, apart from a common scale. Our choice: the
/// noise of exporters is below 1e-4, and 1e-3 moves points of a body by less than 2 mm.
const RIGID: f64 = 1e-3;

/// Distance of a joint from its place on the parent beyond which offsets are stored frame by frame,
/// metres.
const STRAY_M: f64 = 1e-5;

/// Frame rate of a file without an animation, whose one frame is the rest pose.
const STILL_RATE_HZ: f64 = 30.0;

/// The animation to read from a file.
#[derive(Clone, Copy, Debug)]
pub(super) enum WantedAnimation<'a> {
    /// The animation of this name.
    Named(&'a str),
    /// The only animation, or the rest pose of a file without any.
    Only,
    /// No animation: the rest pose.
    Nothing,
}

/// Reads a file.
///
/// # Errors
/// If the file is not a complete glTF with one skinned skeleton (or one of this name) that only
/// rotates and moves, or has no such animation.
pub(super) fn read(path: &Path, clip: WantedAnimation<'_>, person: Option<&str>) -> Result<Motion> {
    let bytes = read_file(path)?;
    let fail = |problem: String| Error::input(path, problem);
    check_length(&bytes).map_err(fail)?;
    let incomplete = |error: gltf::Error| fail(format!("not a complete glTF 2.0 file: {error}"));
    let gltf::Gltf { document, blob } =
        gltf::Gltf::from_slice_without_validation(&bytes).map_err(incomplete)?;
    drop(bytes);
    let mut root = document.into_json();
    check_targets(&root).map_err(fail)?;
    extensions::settle(&mut root).map_err(fail)?;
    let document = Document::from_json(root).map_err(incomplete)?;
    if let (WantedAnimation::Only, count @ 2..) = (clip, document.animations().count()) {
        let names = names(&document);
        let problem = format!("{count} animations, expected the name of one: {names}");
        return Err(fail(problem).with_remedy(Remedy::NameAnimation));
    }
    let graph = NodeGraph::from_document(&document).map_err(fail)?;
    let skins = people::chosen(&document, &graph, used_skins(&document), person)
        .map_err(|problem| fail(problem).with_remedy(Remedy::NamePerson))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    Buffers::load(&document, blob, folder)
        .and_then(|buffers| motion(&document, &buffers, &graph, &skins, clip))
        .map_err(fail)
}

fn motion(
    document: &Document,
    buffers: &Buffers,
    graph: &NodeGraph,
    skins: &[gltf::Skin],
    clip: WantedAnimation<'_>,
) -> std::result::Result<Motion, String> {
    let order = graph.skeleton(skins)?;
    let mut warnings = Vec::new();
    let mut numbers = vec![None; graph.nodes.len()];
    for (number, &node) in order.iter().enumerate() {
        numbers[node] = Some(number);
    }
    let carriers = graph.path_to_top(order[0]);
    let binds = binds(graph, &order, &numbers, skins, buffers)?;
    let upright = upright(graph.global(&carriers) * binds[0].inverse());
    let joints = SkinJoints {
        numbers,
        rest: binds.iter().map(|bind| upright * *bind).collect(),
    };
    if !joints.rest.iter().all(DAffine3::is_finite) {
        return Err("the nodes' scales are too large".into());
    }
    let others = |skin: &gltf::Skin| skins.iter().all(|own| own.index() != skin.index());
    let mesh = skin::read(document, buffers, &joints, &others, &mut warnings)?;
    let rest: Vec<DVec3> = joints.rest.iter().map(|m| m.translation).collect();
    let mut skeleton: Vec<SourceJoint> = Vec::with_capacity(order.len());
    for (number, &node) in order.iter().enumerate() {
        let parent = match number {
            0 => None,
            _ => graph.parents[node].and_then(|parent| joints.numbers[parent]),
        };
        let name = document.nodes().nth(node).and_then(|n| n.name());
        skeleton.push(SourceJoint {
            name: name.map_or_else(|| format!("node {node}"), str::to_owned),
            parent,
            offset: parent.map_or(DVec3::ZERO, |parent| rest[number] - rest[parent]),
            end: None,
        });
    }
    let (frames, sample_rate_hz) = match find_clip(document, clip)? {
        None => {
            let still = SourceFrame {
                root: rest[0],
                rotations: vec![DQuat::IDENTITY; skeleton.len()],
                offsets: None,
            };
            (vec![still], STILL_RATE_HZ)
        }
        Some(animation) => {
            let mut moved = carriers[1..].to_vec();
            moved.extend(&order);
            let clip = GltfAnimation::read(&animation, buffers, &moved)?;
            let frames = frames(graph, &order, &clip, &skeleton, &joints)?;
            warnings.extend(clip.warnings);
            (frames, clip.sample_rate_hz)
        }
    };
    Ok(Motion {
        format: MotionFormat::Gltf,
        joints: skeleton,
        sample_rate_hz,
        frames,
        unit_m: Some(1.0),
        skin: mesh,
        warnings,
    })
}

/// Returns the skins of the meshes, or all skins if no mesh has one.
fn used_skins(document: &Document) -> Vec<gltf::Skin<'_>> {
    let mut used = vec![false; document.skins().count()];
    for node in document.nodes().filter(|node| node.mesh().is_some()) {
        if let Some(skin) = node.skin() {
            used[skin.index()] = true;
        }
    }
    let all = !used.contains(&true);
    document
        .skins()
        .filter(|skin| all || used[skin.index()])
        .collect()
}

/// Returns the names of the first 50 animations.
fn names(document: &Document) -> String {
    let names = document.animations().map(|a| a.name().unwrap_or(""));
    names.take(50).collect::<Vec<_>>().join(", ")
}

/// Returns the animation that is wanted; none for the rest pose.
fn find_clip<'a>(
    document: &'a Document,
    clip: WantedAnimation<'_>,
) -> std::result::Result<Option<gltf::Animation<'a>>, String> {
    match (clip, document.animations().count()) {
        (WantedAnimation::Nothing, _) => Ok(None),
        (WantedAnimation::Only, _) => Ok(document.animations().next()),
        (WantedAnimation::Named(clip), 0) => Err(format!("no animation {clip}: the file has none")),
        (WantedAnimation::Named(clip), _) => {
            let mut found = document.animations().filter(|a| a.name() == Some(clip));
            match (found.next(), found.next()) {
                (Some(only), None) => Ok(Some(only)),
                (Some(_), _) => Err(format!("several animations are called {clip}: rename them")),
                (None, _) => Err(format!(
                    "no animation {clip}; there are: {}",
                    names(document)
                )),
            }
        }
    }
}

/// The local transform of a node.
#[derive(Clone, Copy)]
enum Local {
    Matrix(DAffine3),
    Parts {
        translation: DVec3,
        rotation: DQuat,
        scale: DVec3,
    },
}

impl Local {
    fn affine(&self) -> DAffine3 {
        match *self {
            Self::Matrix(matrix) => matrix,
            Self::Parts {
                translation,
                rotation,
                scale,
            } => DAffine3::from_scale_rotation_translation(scale, rotation, translation),
        }
    }
}

/// The nodes, their parents and transforms.
struct NodeGraph {
    nodes: Vec<Local>,
    parents: Vec<Option<usize>>,
}

impl NodeGraph {
    fn from_document(document: &Document) -> std::result::Result<Self, String> {
        let count = document.nodes().count();
        if count > MAX_NODES {
            return Err(format!("expected at most {MAX_NODES} nodes, found {count}"));
        }
        let mut parents = vec![None; count];
        let mut nodes = Vec::with_capacity(count);
        for node in document.nodes() {
            let index = node.index();
            for child in node.children() {
                if parents[child.index()].replace(index).is_some() {
                    return Err(format!("node {} has two parents", child.index()));
                }
            }
            let local = match node.transform() {
                Transform::Matrix { matrix: m } => {
                    let cols = [m[0], m[1], m[2], m[3]]
                        .map(|c| DVec3::new(c[0].into(), c[1].into(), c[2].into()));
                    let turn = DMat3::from_cols(cols[0], cols[1], cols[2]);
                    Local::Matrix(DAffine3::from_mat3_translation(turn, cols[3]))
                }
                Transform::Decomposed {
                    translation,
                    rotation,
                    scale,
                } => Local::Parts {
                    translation: DVec3::from_array(translation.map(f64::from)),
                    rotation: DQuat::from_vec4(
                        DVec4::from_array(rotation.map(f64::from)).normalize(),
                    ),
                    scale: DVec3::from_array(scale.map(f64::from)),
                },
            };
            if !local.affine().is_finite() {
                return Err(format!("node {index} has no finite transform"));
            }
            nodes.push(local);
        }
        Ok(Self { nodes, parents })
    }

    /// Returns the path from a node (first) to the top. The path of a node that is its own ancestor
    /// has more nodes than there are.
    fn path_to_top(&self, node: usize) -> Vec<usize> {
        std::iter::successors(Some(node), |&at| self.parents[at])
            .take(self.nodes.len() + 1)
            .collect()
    }

    /// Returns the product of the transforms of a path to the top.
    fn global(&self, path: &[usize]) -> DAffine3 {
        let locals = path.iter().map(|&node| self.nodes[node].affine());
        locals.fold(DAffine3::IDENTITY, |below, local| local * below)
    }

    /// Returns the nodes that join the skins' joints into one skeleton, parents first: their lowest
    /// common ancestor and all nodes between it and them.
    fn skeleton(&self, skins: &[gltf::Skin]) -> std::result::Result<Vec<usize>, String> {
        let mut joints: Vec<usize> = skins
            .iter()
            .flat_map(|skin| skin.joints().map(|joint| joint.index()))
            .collect();
        joints.sort_unstable();
        joints.dedup();
        let too_many = |found| format!("expected at most {MAX_JOINTS} joints, found {found}");
        if joints.len() > MAX_JOINTS {
            return Err(too_many(joints.len()));
        }
        // From the top down, as far as all paths agree.
        let mut common: Option<Vec<usize>> = None;
        let mut depths = vec![0; self.nodes.len()];
        for joint in joints {
            let mut path = self.path_to_top(joint);
            if path.len() > self.nodes.len() {
                return Err(format!("node {joint} is its own ancestor"));
            }
            path.reverse();
            for (depth, &node) in path.iter().enumerate() {
                depths[node] = depth + 1;
            }
            if let Some(known) = common {
                let same = known.iter().zip(&path).take_while(|(a, b)| a == b).count();
                path.truncate(same);
            }
            common = Some(path);
        }
        let common = common.ok_or("no skin: expected a mesh that joints move")?;
        let root = *common
            .last()
            .ok_or("several skeletons: expected one walker per file")?;
        let mut order: Vec<usize> = (0..self.nodes.len())
            .filter(|&node| depths[node] >= depths[root])
            .collect();
        order.sort_by_key(|&node| depths[node]);
        if order.len() > MAX_JOINTS {
            return Err(too_many(order.len()));
        }
        Ok(order)
    }
}

/// Returns the global transforms of the joints in the bind pose. Joints of no skin get theirs from
/// a child, and joints of skins that state no bind pose from their nodes.
fn binds(
    graph: &NodeGraph,
    order: &[usize],
    numbers: &[Option<usize>],
    skins: &[gltf::Skin],
    buffers: &Buffers,
) -> std::result::Result<Vec<DAffine3>, String> {
    let mut binds: Vec<Option<DAffine3>> = vec![None; order.len()];
    for skin in skins
        .iter()
        .filter(|it| it.inverse_bind_matrices().is_some())
    {
        for (joint, inverse) in skin.joints().zip(skin::inverse_binds(skin, buffers)?) {
            if let Some(number) = numbers[joint.index()] {
                binds[number].get_or_insert(inverse.inverse());
            }
        }
    }
    for (number, &node) in order.iter().enumerate().skip(1).rev() {
        let parent = graph.parents[node].and_then(|parent| numbers[parent]);
        if let (Some(bind), Some(parent)) = (binds[number], parent) {
            let local = graph.nodes[node].affine();
            binds[parent].get_or_insert(bind * local.inverse());
        }
    }
    let mut known: Vec<DAffine3> = Vec::with_capacity(order.len());
    for (bind, &node) in binds.into_iter().zip(order) {
        let parent = graph.parents[node].and_then(|parent| numbers[parent]);
        let placed = match parent.and_then(|parent| known.get(parent)) {
            Some(parent) => *parent * graph.nodes[node].affine(),
            None => graph.global(&graph.path_to_top(node)),
        };
        known.push(bind.unwrap_or(placed));
    }
    match known.iter().all(DAffine3::is_finite) {
        true => Ok(known),
        false => Err("a joint has no bind pose".into()),
    }
}

/// Returns the transform from the space of the bind pose to the world, given its placement in the
/// scene: the scale, and the quarter turns nearest to the rotation.
fn upright(placed: DAffine3) -> DAffine3 {
    let m = placed.matrix3;
    let scale = libm::cbrt(m.determinant().abs());
    let nearest = |v: DVec3| {
        let a = v.abs();
        let axis = if a.x >= a.y && a.x >= a.z {
            0
        } else if a.y >= a.z {
            1
        } else {
            2
        };
        DVec3::AXES[axis] * v[axis].signum()
    };
    let y = nearest(m.y_axis);
    let x = nearest(m.x_axis.normalize_or_zero().reject_from_normalized(y));
    let turn = DMat3::from_cols(x, y, x.cross(y));
    DAffine3::from_mat3(turn * scale)
}

/// Returns the poses of a clip.
fn frames(
    graph: &NodeGraph,
    order: &[usize],
    clip: &GltfAnimation,
    skeleton: &[SourceJoint],
    joints: &SkinJoints,
) -> std::result::Result<Vec<SourceFrame>, String> {
    let from_rest: Vec<DAffine3> = joints.rest.iter().map(DAffine3::inverse).collect();
    let mut moved = NodeGraph {
        nodes: graph.nodes.clone(),
        parents: graph.parents.clone(),
    };
    let carriers = graph.path_to_top(order[0]);
    let mut frames = Vec::with_capacity(clip.len);
    let mut strays = false;
    for frame in 0..clip.len {
        for (node, moves, value) in clip.sample(frame) {
            let Local::Parts {
                translation,
                rotation,
                scale,
            } = &mut moved.nodes[node]
            else {
                return Err(format!("node {node} has a matrix and is animated"));
            };
            match moves {
                Moves::Translation => *translation = value.truncate(),
                Moves::Rotation => *rotation = DQuat::from_vec4(value).normalize(),
                Moves::Scale => *scale = value.truncate(),
            }
        }
        let mut globals: Vec<DAffine3> = Vec::with_capacity(order.len());
        let mut turns: Vec<DQuat> = Vec::with_capacity(order.len());
        let mut rotations = Vec::with_capacity(order.len());
        let mut offsets = Vec::with_capacity(order.len());
        for (number, (joint, &node)) in skeleton.iter().zip(order).enumerate() {
            let global = match joint.parent {
                None => moved.global(&carriers),
                Some(parent) => globals[parent] * moved.nodes[node].affine(),
            };
            let turn = rotation_of((global * from_rest[number]).matrix3).ok_or_else(|| {
                format!(
                    "joint {} is scaled or sheared in frame {frame}: expected rotations and translations (apply the scales)",
                    joint.name
                )
            })?;
            let (local, offset) = match joint.parent {
                None => (turn, joint.offset),
                Some(parent) => {
                    let back = turns[parent].inverse();
                    let stride = global.translation - globals[parent].translation;
                    ((back * turn).normalize(), back * stride)
                }
            };
            strays |= offset.distance(joint.offset) > STRAY_M;
            globals.push(global);
            turns.push(turn);
            rotations.push(local);
            offsets.push(offset);
        }
        frames.push(SourceFrame {
            root: globals[0].translation,
            rotations,
            offsets: Some(offsets),
        });
    }
    if !strays {
        for frame in &mut frames {
            frame.offsets = None;
        }
    }
    Ok(frames)
}

/// Returns the rotation of a matrix, if it only rotates.
fn rotation_of(m: DMat3) -> Option<DQuat> {
    let gram = m.transpose() * m;
    let is_rotation = gram.abs_diff_eq(DMat3::IDENTITY, 2.0 * RIGID) && m.determinant() > 0.0;
    is_rotation.then(|| DQuat::from_mat3(&m).normalize())
}
