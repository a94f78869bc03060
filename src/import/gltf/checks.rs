//! Checks of what the crate panics on.

use gltf::json::validation::Checked;

/// Rejects binary files that state a length which they do not have, on which the crate panics.
pub(super) fn check_length(bytes: &[u8]) -> Result<(), String> {
    // The magic, the version and the length of all, 12 bytes.
    let Some((b"glTF", rest)) = bytes.split_first_chunk() else {
        return Ok(());
    };
    let stated = rest.get(4..8).and_then(|bytes| bytes.try_into().ok());
    match stated.map(u32::from_le_bytes) {
        Some(stated) if (12..=bytes.len()).contains(&(stated as usize)) => Ok(()),
        Some(stated) => Err(format!(
            "not a complete glTF 2.0 file: its header states {stated} bytes, found {} (is it truncated?)",
            bytes.len()
        )),
        None => Err("not a complete glTF 2.0 file: it ends in its header".into()),
    }
}

/// Rejects documents on which the crate's own check panics, or which it leaves to panic later.
pub(super) fn check_targets(root: &gltf::json::Root) -> Result<(), String> {
    let count = root.accessors.len();
    let parts = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let mut used = parts.flat_map(|part| part.attributes.values());
    if let Some(wrong) = used.find(|accessor| accessor.value() >= count) {
        return Err(format!(
            "a mesh refers to accessor {} of {count}",
            wrong.value()
        ));
    }
    let count = root.nodes.len();
    let channels = root.animations.iter().flat_map(|all| &all.channels);
    for target in channels.map(|channel| &channel.target) {
        if target.node.value() >= count {
            return Err(format!(
                "an animation moves node {} of {count}",
                target.node.value()
            ));
        }
        if target.path == Checked::Invalid {
            return Err("expected an animation of translation, rotation, scale or weights".into());
        }
    }
    Ok(())
}
