use std::f64::consts::FRAC_1_SQRT_2;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use serde_json::{Value, json};

use crate::import::{ImportOptions, Motion, MotionFormat};

/// Returns a buffer with two joints, the second 1 m above the first, and a triangle whose vertices
/// are at the first, at the second (half of each), and 1 m above the second.
fn bytes() -> Vec<u8> {
    let mut bytes: Vec<u8> = Vec::new();
    let mut put = |values: &[f32]| bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    put(&[0., 0., 0., 0., 1., 0., 0., 2., 0.]);
    put(&[1., 0., 0., 0., 0.5, 0.5, 0., 0., 0., 1., 0., 0.]);
    for up in [0., -1.] {
        put(&[
            1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., up, 0., 1.,
        ]);
    }
    put(&[1., 2.]);
    put(&[0., 0., 0., 1., 0., 0., 0.707_106_77, 0.707_106_77]);
    bytes.extend([0, 1, 0, 0].repeat(3));
    bytes.extend([0, 0, 1, 0, 2, 0, 0, 0]);
    // In-tangent, value, out-tangent of two keys.
    for key in [
        [0., 0., 0., 0., 0., 0., 0., 0., 3.],
        [0., 0., 0., 0., 0., 4., 0., 0., 0.],
    ] {
        bytes.extend(key.iter().flat_map(|v: &f32| v.to_le_bytes()));
    }
    bytes
}

fn scene(bytes: &[u8]) -> Value {
    let view = |offset: usize, length: usize| json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
    let accessor = |view: usize, kind: u32, count: usize, shape: &str| json!({"bufferView": view, "componentType": kind, "count": count, "type": shape});
    json!({
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": bytes.len(), "uri": format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes))}],
        "bufferViews": [
            view(0, 36), view(36, 48), view(84, 128), view(212, 8), view(220, 32), view(252, 12),
            view(264, 6), view(272, 72),
            {"buffer": 0, "byteOffset": 272, "byteLength": 72, "byteStride": 36},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [0, 2, 0]}, accessor(1, 5126, 3, "VEC4"), accessor(2, 5126, 2, "MAT4"),
            accessor(3, 5126, 2, "SCALAR"), accessor(4, 5126, 2, "VEC4"), accessor(5, 5121, 3, "VEC4"),
            accessor(6, 5123, 3, "SCALAR"), accessor(7, 5126, 6, "VEC3"),
            {"bufferView": 8, "byteOffset": 12, "componentType": 5126, "count": 2, "type": "VEC3"},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "WEIGHTS_0": 1, "JOINTS_0": 5}, "indices": 6}]}],
        "skins": [{"joints": [1, 2], "inverseBindMatrices": 2}],
        "nodes": [
            {"name": "rig", "children": [1, 3]},
            {"name": "low", "children": [2]},
            {"name": "high", "translation": [0, 1, 0]},
            {"name": "body", "mesh": 0, "skin": 0},
        ],
        "animations": [{
            "name": "turn",
            "channels": [{"sampler": 0, "target": {"node": 2, "path": "rotation"}}],
            "samplers": [{"input": 3, "output": 4, "interpolation": "LINEAR"}],
        }],
    })
}

fn read(scene: &Value, clip: Option<&str>) -> Result<Motion, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.gltf");
    std::fs::write(&path, scene.to_string()).unwrap();
    let options = ImportOptions {
        clip: clip.map(str::to_owned),
        ..ImportOptions::default()
    };
    let shown = folder.path().display().to_string() + "/";
    Motion::read_with(&path, &options).map_err(|error| error.to_string().replace(&shown, ""))
}

fn skin(motion: &Motion, frame: usize) -> Vec<DVec3> {
    motion.skin.as_ref().unwrap().posed(motion, frame)
}

fn assert_near(found: DVec3, expected: [f64; 3]) {
    let expected = DVec3::from_array(expected);
    assert!(found.distance(expected) < 1e-6, "{found}, not {expected}");
}

#[test]
fn a_joint_that_turns_takes_its_vertices_along() {
    let motion = read(&scene(&bytes()), None).unwrap();
    assert_eq!(motion.format, MotionFormat::Gltf);
    assert_eq!((motion.frames.len(), motion.sample_rate_hz), (31, 30.0));
    assert_eq!(
        motion.warnings,
        ["the keys are at 1.0000 Hz: sampled at 30.0000 Hz"]
    );
    let names: Vec<&str> = motion.joints.iter().map(|j| j.name.as_str()).collect();
    assert_eq!(names, ["low", "high"]);
    assert_eq!(motion.joints[1].offset, DVec3::Y);
    assert_eq!(motion.skin.as_ref().unwrap().triangles, [[0, 1, 2]]);
    assert_eq!(
        motion.skin.as_ref().unwrap().weights[1],
        [(0, 0.5), (1, 0.5)]
    );
    // The first key is frame 0; half way to 90 degrees about Z.
    assert_near(skin(&motion, 0)[2], [0.0, 2.0, 0.0]);
    assert_near(
        skin(&motion, 15)[2],
        [-FRAC_1_SQRT_2, 1.0 + FRAC_1_SQRT_2, 0.0],
    );
    assert_near(skin(&motion, 15)[1], [0.0, 1.0, 0.0]);
    assert_near(skin(&motion, 30)[2], [-1.0, 1.0, 0.0]);
}

/// glTF 2.0, 3.7.3.1: without inverse bind matrices, vertices are in the space of each joint.
#[test]
fn a_skin_without_inverse_bind_matrices_has_its_vertices_in_the_space_of_its_joints() {
    let mut bytes = bytes();
    let local = [0.0_f32, 0., 0., 0., 0.5, 0., 0., 1., 0.];
    let local = local.iter().flat_map(|number| number.to_le_bytes());
    bytes.splice(..36, local);
    let mut scene = scene(&bytes);
    scene["skins"][0] = json!({"joints": [1, 2]});
    let motion = read(&scene, None).unwrap();
    assert_near(skin(&motion, 0)[0], [0.0, 0.0, 0.0]);
    assert_near(skin(&motion, 0)[2], [0.0, 2.0, 0.0]);
    assert_near(skin(&motion, 30)[2], [-1.0, 1.0, 0.0]);
}

/// Returns the scene's motion with the rig moved along Z by the cubic spline's keys.
fn moved(interpolation: &str, output: usize) -> Motion {
    let mut scene = scene(&bytes());
    scene["animations"][0] = json!({
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
        "samplers": [{"input": 3, "output": output, "interpolation": interpolation}],
    });
    read(&scene, None).unwrap()
}

#[test]
fn a_third_of_the_way_is_as_the_interpolation_says() {
    // Hermite: 4 (3 u^2 - 2 u^3) + 3 (u^3 - 2 u^2 + u) at u = 1/3.
    let cubic = 4.0 * 7.0 / 27.0 + 3.0 * 4.0 / 27.0;
    for (motion, expected) in [
        (moved("CUBICSPLINE", 7), cubic),
        (moved("LINEAR", 8), 4.0 / 3.0),
        (moved("STEP", 8), 0.0),
    ] {
        assert_near(motion.frames[10].root, [0.0, 0.0, expected]);
        assert_near(motion.frames[30].root, [0.0, 0.0, 4.0]);
        assert_near(skin(&motion, 30)[2], [0.0, 2.0, 4.0]);
    }
}

#[test]
fn a_joint_that_leaves_its_place_has_offsets_by_frame() {
    let mut scene = scene(&bytes());
    scene["animations"][0]["channels"][0]["target"] = json!({"node": 2, "path": "translation"});
    scene["animations"][0]["samplers"][0]["output"] = json!(8);
    let motion = read(&scene, None).unwrap();
    // The translation replaces the joint's own.
    assert_near(motion.globals(15).0[1], [0.0, 0.0, 2.0]);
    assert_near(skin(&motion, 30)[2], [0.0, 1.0, 4.0]);
    assert!(moved("LINEAR", 8).frames[3].offsets.is_none());
}

#[test]
fn a_rig_in_centimetres_that_lies_is_stood_up_in_metres() {
    let mut scene = scene(&bytes());
    // 90 degrees about X takes Y up to Z ahead; the mesh is then 2 cm long.
    scene["nodes"][0]["rotation"] = json!([FRAC_1_SQRT_2, 0, 0, FRAC_1_SQRT_2]);
    scene["nodes"][0]["scale"] = json!([0.01, 0.01, 0.01]);
    let motion = read(&scene, None).unwrap();
    assert_near(motion.joints[1].offset, [0.0, 0.0, 0.01]);
    assert_near(motion.skin.as_ref().unwrap().vertices[2], [0.0, 0.0, 0.02]);
    assert_near(skin(&motion, 30)[2], [-0.01, 0.0, 0.01]);
    let turn = motion.frames[0].rotations[0];
    assert!(turn.angle_between(glam::DQuat::IDENTITY) < 1e-6, "{turn}");
}

#[test]
fn a_body_without_an_animation_is_one_frame_at_rest() {
    let mut scene = scene(&bytes());
    scene["animations"] = json!([]);
    scene["nodes"][2]["rotation"] = json!([0, 0, 1, 0]);
    let motion = read(&scene, None).unwrap();
    assert_eq!(motion.frames.len(), 1);
    assert_near(skin(&motion, 0)[2], [0.0, 2.0, 0.0]);
}

#[test]
fn several_animations_are_listed_unless_one_is_named() {
    let mut scene = scene(&bytes());
    let mut other = scene["animations"][0].clone();
    other["name"] = json!("stand");
    scene["animations"].as_array_mut().unwrap().push(other);
    assert_eq!(
        read(&scene, None).unwrap_err(),
        "t.gltf: 2 animations, expected the name of one: turn, stand"
    );
    assert_eq!(
        read(&scene, Some("walk")).unwrap_err(),
        "t.gltf: no animation walk; there are: turn, stand"
    );
    assert_eq!(read(&scene, Some("stand")).unwrap().frames.len(), 31);
}

#[test]
fn uneven_keys_are_sampled_at_the_least_distance_with_a_warning() {
    let mut data = bytes();
    data.extend([0.0f32, 0.02, 0.1].iter().flat_map(|v| v.to_le_bytes()));
    let mut scene = scene(&data);
    let view = scene["bufferViews"].as_array_mut().unwrap();
    view.push(json!({"buffer": 0, "byteOffset": data.len() - 12, "byteLength": 12}));
    let accessors = scene["accessors"].as_array_mut().unwrap();
    accessors.push(json!({"bufferView": 9, "componentType": 5126, "count": 3, "type": "SCALAR"}));
    scene["animations"][0]["channels"][0]["target"]["path"] = json!("translation");
    scene["animations"][0]["samplers"][0] = json!({"input": 9, "output": 0});
    let motion = read(&scene, None).unwrap();
    assert_eq!(motion.frames.len(), 6);
    assert_eq!(
        motion.warnings,
        ["the keys are unevenly spaced: sampled at 50.0000 Hz"]
    );
}

/// Returns the scene with the value at a JSON pointer replaced.
fn with(pointer: &str, value: Value) -> Value {
    let mut scene = scene(&bytes());
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    let parent = scene.pointer_mut(parent).unwrap();
    match parent {
        Value::Array(items) => items[key.parse::<usize>().unwrap()] = value,
        other => other[key] = value,
    }
    scene
}

/// Returns the scene with bytes of its buffer replaced.
fn patched(at: usize, new: &[u8]) -> Value {
    let mut data = bytes();
    data[at..at + new.len()].copy_from_slice(new);
    scene(&data)
}

#[test]
fn what_cannot_be_used_is_refused_with_its_reason() {
    let huge = 4_000_000_000u32;
    for (scene, problem) in [
        (
            with("/animations/0/channels/0/target/node", json!(99)),
            "an animation moves node 99 of 4",
        ),
        (
            with("/animations/0/channels/0/target/path", json!("weight")),
            "expected an animation of translation",
        ),
        (
            with("/meshes/0/primitives/0/attributes/POSITION", json!(99)),
            "a mesh refers to accessor 99 of 9",
        ),
        (json!({}), "not a complete glTF 2.0 file"),
        (with("/skins", json!([])), "not a complete glTF 2.0 file"),
        (
            with("/nodes/3/skin", Value::Null),
            "mesh without a name has no skin",
        ),
        (
            with("/buffers/0/uri", json!("gone.bin")),
            "gone.bin: No such file",
        ),
        (
            with("/buffers/0/uri", json!("/dev/zero")),
            "expected a file beside the .gltf",
        ),
        (
            with("/buffers/0/uri", json!("%2Fdev%2Fzero")),
            "expected a file beside the .gltf",
        ),
        (
            with("/buffers/0/uri", json!("a/%2e%2e/../../b.bin")),
            "expected a file beside the .gltf",
        ),
        (
            with("/buffers/0/uri", json!("C%3A%5Cb.bin")),
            "expected a file beside the .gltf",
        ),
        (
            with("/buffers/0/uri", json!("https://x/y.bin")),
            "expected a file beside the .gltf",
        ),
        (
            with("/buffers/0/uri", json!("%ff.bin")),
            "is not a file name",
        ),
        (
            with("/buffers/0/uri", json!("data:;base64,AAAA")),
            "bytes, found 3 (is the file truncated?)",
        ),
        (
            with("/buffers/0/uri", json!("data:;base64,!")),
            "its base64 is broken",
        ),
        (
            with("/accessors/0/count", json!(huge)),
            "expected at most 5333333 items",
        ),
        (
            with("/accessors/0/count", json!(4)),
            "4 items of 12 bytes do not fit into buffer view 0",
        ),
        (
            with("/bufferViews/0/byteOffset", json!(u64::MAX)),
            "do not fit into buffer view 0",
        ),
        (
            with("/accessors/5/componentType", json!(5126)),
            "accessor 5: expected unsigned integers, found F32",
        ),
        (
            with("/meshes/0/primitives/0/mode", json!(0)),
            "expected triangles, found Points",
        ),
        (
            with("/nodes/0/children", json!([1, 2, 3])),
            "node 2 has two parents",
        ),
        (
            with("/nodes/2/children", json!([1])),
            "node 1 has two parents",
        ),
        (
            with("/nodes/1/scale", json!([1, 2, 1])),
            "joint low is scaled or sheared in frame 0",
        ),
        (
            with("/nodes/0/scale", json!([-1, 1, 1])),
            "joint low is scaled or sheared in frame 0",
        ),
        (
            with(
                "/nodes/2/matrix",
                json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1]),
            ),
            "node 2 has a matrix and is animated",
        ),
        (
            with("/animations/0/channels/0/target/node", json!(3)),
            "moves none of the skin's joints",
        ),
        (
            with("/animations/0/samplers/0/output", json!(8)),
            "expected 4 numbers an item, found Vec3",
        ),
        (
            with(
                "/animations/0/samplers/0/interpolation",
                json!("CUBICSPLINE"),
            ),
            "expected 6 values for 2 keys, found 2",
        ),
        (patched(264, &[9]), "a triangle refers to vertex 9 of 3"),
        (patched(252, &[7]), "refers to joint 7 of 2 in the skin"),
        (
            patched(36, &0.5f32.to_le_bytes()),
            "expected weights of 0 or more that sum to 1, found 0.5",
        ),
        (
            patched(36, &f32::NAN.to_le_bytes()),
            "accessor 1: item 0 is not finite",
        ),
        (
            patched(84, &0f32.to_le_bytes()),
            "inverse bind matrix 0 is singular or mirrors",
        ),
        (
            patched(212, &2f32.to_le_bytes()),
            "expected ascending key times",
        ),
        (
            patched(216, &1e9f32.to_le_bytes()),
            "are too many: cut the animation",
        ),
    ] {
        match read(&scene, None) {
            Err(found) => assert!(found.contains(problem), "{found:?}, not {problem:?}"),
            Ok(motion) => assert!(
                motion.skin.is_none() && motion.warnings[0].contains(problem),
                "read, not {problem:?}"
            ),
        }
    }
}

#[test]
fn buffers_are_beside_the_file_or_in_a_folder_there() {
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("in");
    std::fs::create_dir_all(folder.join("b c")).unwrap();
    for path in ["in/b c/a.bin", "in/a.bin", "out.bin"] {
        std::fs::write(outer.path().join(path), bytes()).unwrap();
    }
    let path = folder.join("t.gltf");
    let read = |uri: &str| {
        let scene = with("/buffers/0/uri", json!(uri)).to_string();
        std::fs::write(&path, scene).unwrap();
        Motion::read(&path).map_err(|error| error.to_string())
    };
    for uri in ["a.bin", "./a.bin", "b%20c/a.bin"] {
        assert_eq!(read(uri).unwrap().frames.len(), 31, "{uri}");
    }
    let expected = "expected a file beside the .gltf";
    assert!(read("../out.bin").unwrap_err().contains(expected));
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("../out.bin", folder.join("link.bin")).unwrap();
        std::os::unix::fs::symlink("a.bin", folder.join("inner.bin")).unwrap();
        assert!(read("link.bin").unwrap_err().contains(expected));
        assert_eq!(read("inner.bin").unwrap().frames.len(), 31);
    }
}

#[test]
fn no_truncated_or_changed_binary_file_panics() {
    let data = bytes();
    let mut scene = scene(&data);
    scene["buffers"][0] = json!({"byteLength": data.len()});
    let mut text = scene.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let word = |value: usize| u32::try_from(value).unwrap().to_le_bytes();
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend(word(12 + 8 + text.len() + 8 + data.len()));
    glb.extend(word(text.len()));
    glb.extend(b"JSON");
    glb.extend(&text);
    glb.extend(word(data.len()));
    glb.extend(b"BIN\0");
    glb.extend(&data);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.glb");
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        Motion::read(&path)
    };
    assert_eq!(read(&glb).unwrap().frames.len(), 31);
    for length in (0..glb.len()).step_by(5) {
        assert!(read(&glb[..length]).is_err(), "{length}");
    }
    for stated in [0, 3, 11, glb.len() + 1] {
        let lies = [&glb[..8], &word(stated), &glb[12..]].concat();
        let problem = read(&lies).unwrap_err().to_string();
        let expected = format!("its header states {stated} bytes, found {}", glb.len());
        assert!(problem.contains(&expected), "{problem}");
    }
    for at in 0..glb.len() {
        let change = [0x01, 0x40][at % 2];
        glb[at] ^= change;
        let _ = read(&glb);
        glb[at] ^= change;
    }
}
