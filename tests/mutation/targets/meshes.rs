//! Meshes. Fitting bodies to them takes minutes: tests of `hull_fit` do that with few pictures.

use super::motions::check_motion;
use super::{Target, target};
use crate::chance::Chance;
use crate::data::fixtures;
use crate::mutators::{structure, text};
use edgegait::import::skinned_body;
use edgegait::people::rigging::from_obj;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

pub fn targets(folder: &Path) -> Vec<Target> {
    let skinned = fixtures().join("truth/avatars/F_slim.glb");
    let figure = fs::read(&skinned).expect("a mesh");
    let obj = obj(&skinned);
    let at = |name: &str| crate::run::fresh(&folder.join(name)).join(name);
    let obj_at = at("a.obj");
    let read_obj = move |bytes: &[u8], _: &mut Chance| {
        fs::write(&obj_at, bytes)?;
        check_motion(&from_obj(&obj_at, None)?);
        Ok(())
    };
    let glb_at = at("a.glb");
    let read_skin = move |bytes: &[u8], _: &mut Chance| {
        fs::write(&glb_at, bytes)?;
        check_motion(&skinned_body(&glb_at)?);
        Ok(())
    };
    let own = [
        structure::glb_numbers,
        structure::glb_numbers,
        structure::glb,
    ];
    vec![
        target("obj", 2, vec![obj], &text::ALL, &[], read_obj),
        target("skin", 2, vec![figure], &own, &[], read_skin),
    ]
}

/// The mesh of a glTF as an OBJ.
fn obj(path: &Path) -> Vec<u8> {
    let skin = skinned_body(path).expect("a figure").skin.expect("a skin");
    let mut text = String::new();
    for vertex in &skin.vertices {
        let _ = writeln!(text, "v {:.4} {:.4} {:.4}", vertex.x, vertex.y, vertex.z);
    }
    for [a, b, c] in &skin.triangles {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    text.into_bytes()
}
