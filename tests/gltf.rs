//! Skinned bodies of glTF files against what Blender makes of them.

use edgegait::import::{Motion, Options};
use edgegait::scene::Span;
use edgegait::scene::figure;
use edgegait::scene::forward_kinematics;
use edgegait::scene::retarget::Take;
use edgegait_core::skeleton::Joint;
use glam::DVec3;
use ndarray::ArrayD;

mod blender;
use blender::{Npz, truth};

fn body(name: &str) -> Option<Motion> {
    let options = Options {
        clip: Some(format!("{name}_007_01")),
        ..Options::default()
    };
    let path = truth(&format!("avatars/{name}.glb"))?;
    Some(Motion::read_with(path, &options).unwrap())
}

/// A point of a `[frames, points, 3]` array, from Blender's axes (Z up, facing -Y) to ours.
fn point(points: &ArrayD<f32>, frame: usize, at: usize) -> DVec3 {
    let [x, y, z] = [0, 1, 2].map(|axis| f64::from(points[[frame, at, axis]]));
    DVec3::new(x, z, -y)
}

const BODIES: [&str; 2] = ["M_avg", "F_slim"];

#[test]
fn joints_and_skin_are_where_blender_has_them_within_a_tenth_of_a_millimetre() {
    for name in BODIES {
        let Some(motion) = body(name) else { continue };
        let pose = Npz::read(&truth(&format!("pose_{name}_007_01.npz")).unwrap());
        let verts = Npz::read(&truth(&format!("verts_{name}_007_01.npz")).unwrap());
        let (heads, verts) = (pose.array::<f32>("joint_head"), verts.array::<f32>("verts"));
        let joints: Vec<usize> = pose
            .strings("bones")
            .iter()
            .map(|bone| motion.joints.iter().position(|j| j.name == *bone).unwrap())
            .collect();
        assert_eq!((joints.len(), motion.frames.len()), (163, 157));
        assert_eq!(motion.sample_rate_hz, 60.0);
        let skin = motion.skin.as_ref().unwrap();
        let (mut joint_mm, mut skin_mm) = (0.0, 0.0);
        for (frame, source) in pose.array::<i64>("src_frames").iter().enumerate() {
            let source = usize::try_from(*source).unwrap();
            let (positions, _) = motion.globals(source);
            for (bone, joint) in joints.iter().enumerate() {
                let miss = positions[*joint].distance(point(&heads, frame, bone));
                joint_mm = f64::max(joint_mm, 1e3 * miss);
            }
            for (vertex, at) in skin.posed(&motion, source).iter().enumerate() {
                let miss = at.distance(point(&verts, frame, vertex));
                skin_mm = f64::max(skin_mm, 1e3 * miss);
            }
        }
        eprintln!("{name}: joints within {joint_mm:.4} mm, skin within {skin_mm:.4} mm");
        assert!(
            joint_mm < 0.1 && skin_mm < 0.1,
            "{name}: {joint_mm} {skin_mm}"
        );
    }
}

/// The canonical joints and the bones of MakeHuman that begin where they do.
const BONES: [(Joint, &str); 16] = [
    (Joint::Spine, "spine05"),
    (Joint::Thorax, "spine03"),
    (Joint::Neck, "neck01"),
    (Joint::Head, "head"),
    (Joint::LeftUpperArm, "upperarm01.L"),
    (Joint::LeftForearm, "lowerarm01.L"),
    (Joint::LeftHand, "wrist.L"),
    (Joint::RightUpperArm, "upperarm01.R"),
    (Joint::RightForearm, "lowerarm01.R"),
    (Joint::RightHand, "wrist.R"),
    (Joint::LeftThigh, "upperleg01.L"),
    (Joint::LeftShank, "lowerleg01.L"),
    (Joint::LeftFoot, "foot.L"),
    (Joint::RightThigh, "upperleg01.R"),
    (Joint::RightShank, "lowerleg01.R"),
    (Joint::RightFoot, "foot.R"),
];

#[test]
fn a_kept_take_is_where_blender_has_it_within_10_mm_and_its_legs_within_0_1() {
    for name in BODIES {
        let Some(motion) = body(name) else { continue };
        let take = Take::from_motion(&motion, None).unwrap();
        assert!(take.warnings.is_empty(), "{:?}", take.warnings);
        let span = Span::of(&take);
        let pose = Npz::read(&truth(&format!("pose_{name}_007_01.npz")).unwrap());
        let heads = pose.array::<f32>("joint_head");
        let bones = pose.strings("bones");
        for (joint, bone) in BONES {
            let bone = bones.iter().position(|b| b == bone).unwrap();
            let misses: Vec<f64> = pose
                .array::<i64>("src_frames")
                .iter()
                .enumerate()
                .map(|(frame, source)| {
                    let source = usize::try_from(*source).unwrap();
                    let pose = &span.rotations[source];
                    let (points, _) = forward_kinematics(&take.offsets, span.roots[source], pose);
                    1e3 * points[joint.index()].distance(point(&heads, frame, bone))
                })
                .collect();
            let most = misses.iter().copied().fold(0.0, f64::max);
            let mean = misses.iter().sum::<f64>() / misses.len() as f64;
            eprintln!("{name} {joint:?}: {mean:.2} mm, at most {most:.2}");
            let is_leg = joint >= Joint::LeftThigh;
            assert!(most < if is_leg { 0.1 } else { 10.0 }, "{name} {joint:?}");
        }
        // From the right to the left hip, seen from above.
        let [left, right] = ["upperleg01.L", "upperleg01.R"]
            .map(|bone| bones.iter().position(|b| b == bone).unwrap());
        let sources = pose.array::<i64>("src_frames");
        let turns = sources.iter().enumerate().map(|(frame, source)| {
            let source = usize::try_from(*source).unwrap();
            let across = point(&heads, frame, left) - point(&heads, frame, right);
            let pelvis = span.rotations[source][Joint::Pelvis.index()];
            let hips =
                take.offsets[Joint::LeftThigh.index()] - take.offsets[Joint::RightThigh.index()];
            let ours = pelvis * hips;
            let turn = across.z.atan2(across.x) - ours.z.atan2(ours.x);
            turn.to_degrees().abs()
        });
        let most = turns.fold(0.0, f64::max);
        eprintln!("{name} heading within {most:.4} degrees");
        assert!(most < 0.01, "{name} {most}");
    }
}

#[test]
fn joints_found_in_a_mesh_are_near_those_that_makehuman_put_there() {
    let Some(path) = truth("avatars/M_avg_rest.obj") else {
        return;
    };
    let figure = figure::from_obj(&path, None).unwrap();
    let skin = figure.skin.as_ref().unwrap();
    assert_eq!(skin.vertices.len(), 13_380);
    for weights in &skin.weights {
        let sum: f64 = weights.iter().map(|(_, weight)| weight).sum();
        assert!((sum - 1.0).abs() < 1e-12);
    }
    let rig = Npz::read(&truth("mesh_M_avg.npz").unwrap());
    let (bones, heads) = (rig.strings("bones"), rig.array::<f32>("bone_head"));
    let own = body("M_avg").unwrap();
    let given = figure::from_obj(&path, Some(&own)).unwrap();
    for (joint, bone) in BONES {
        // At rest: L4/L5 and T12/L1, and not where MakeHuman's walks bend.
        let bone = match joint {
            Joint::Spine => "spine04",
            Joint::Thorax => "spine02",
            _ => bone,
        };
        let bone_at = bones.iter().position(|b| b == bone).unwrap();
        let [x, y, z] = [0, 1, 2].map(|axis| f64::from(heads[[bone_at, axis]]));
        let expected = DVec3::new(x, z, -y);
        let miss = |motion: &Motion| 1e3 * (motion.globals(0).0[joint.index()] - expected);
        let (found, given) = (miss(&figure), miss(&given));
        eprintln!("{joint:?}, {bone}: {:.0} mm {found:.0}", found.length());
        assert!(found.length() < 70.0, "{joint:?} {found}");
        let is_trunk = matches!(joint, Joint::Spine | Joint::Thorax);
        assert!(is_trunk || given.length() < 0.1, "{joint:?} {given}");
    }
    let take = Take::from_motion(&figure, None).unwrap();
    assert!(take.warnings.is_empty(), "{:?}", take.warnings);
}

#[test]
fn a_mesh_in_other_units_and_axes_is_the_same_figure() {
    let Some(path) = truth("avatars/M_avg_rest.obj") else {
        return;
    };
    let text = std::fs::read_to_string(&path).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let other = folder.path().join("other.obj");
    let lines = text.lines().map(|line| {
        let Some(position) = line.strip_prefix("v ") else {
            return line.to_owned();
        };
        let v: Vec<f64> = position.split(' ').map(|v| v.parse().unwrap()).collect();
        // Centimetres, Z up, facing +Y, sunk into the floor.
        format!(
            "v {:.4} {:.4} {:.4}",
            -100.0 * v[0],
            100.0 * v[2],
            100.0 * v[1] - 30.0
        )
    });
    std::fs::write(&other, lines.collect::<Vec<String>>().join("\n")).unwrap();
    let plain = figure::from_obj(&path, None).unwrap().globals(0).0;
    let found = figure::from_obj(&other, None).unwrap().globals(0).0;
    for (a, b) in plain.iter().zip(&found) {
        assert!(a.distance(*b) < 1e-4, "{a} {b}");
    }
}
