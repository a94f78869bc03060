//! Extensions that a glTF file requires: which do not matter here, and which are refused.

use gltf::json::Root;

/// Extensions that change neither nodes nor skins nor triangles, by the beginnings of their names:
/// materials, textures, lights, and data about a character.
const IGNORED: [&str; 9] = [
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_lights_",
    "EXT_lights_",
    "KHR_xmp",
    "VRM",
    // It permits integers, which are decoded.
    "KHR_mesh_quantization",
];

/// Extensions that pack the numbers, which other tools unpack.
const PACKED: [&str; 3] = [
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
];

/// Removes required extensions that do not matter here.
///
/// # Errors
/// A sentence that names the first one that matters.
pub(super) fn settle(root: &mut Root) -> Result<(), String> {
    let is_ignored = |name: &String| IGNORED.iter().any(|known| name.starts_with(known));
    root.extensions_required.retain(|name| !is_ignored(name));
    match root.extensions_required.first() {
        None => Ok(()),
        Some(packed) if PACKED.contains(&packed.as_str()) => Err(format!(
            "the file is compressed by {packed}, which is not read: decompress it first (gltf-transform copy IN OUT, or gltfpack -noq -i IN -o OUT)"
        )),
        Some(other) => Err(format!(
            "the file requires the extension {other}, which is not read: export it without"
        )),
    }
}
