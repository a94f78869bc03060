//! Wavefront OBJ: a mesh without a skeleton.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use super::files::read_file;
use crate::error::{Error, Result};

/// The maximum number of triangles accepted. Our choice: bodies have 10 to 200 thousand.
const MAX_TRIANGLES: usize = 4_000_000;

/// A surface of triangles, source units and axes.
#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    /// The vertices: finite, and all different.
    pub vertices: Vec<DVec3>,
    /// The triangles, as numbers of their vertices.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Reads the faces of all objects and groups of a `.obj` as one surface. Vertices at the same
    /// place are merged.
    ///
    /// # Errors
    /// If the file cannot be read, is not an OBJ, has no faces, or has numbers that are not finite.
    pub(crate) fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let bytes = read_file(path)?;
        let options = tobj::LoadOptions {
            triangulate: true,
            ignore_points: true,
            ignore_lines: true,
            ..tobj::LoadOptions::default()
        };
        let no_materials = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
        let (models, _) = tobj::load_obj_buf(&mut bytes.as_slice(), &options, no_materials)
            .map_err(|error| Error::input(path, format!("not a Wavefront OBJ: {error}")))?;
        let mut mesh = Self {
            vertices: Vec::new(),
            triangles: Vec::new(),
        };
        let mut known: HashMap<[u32; 3], u32> = HashMap::new();
        for model in models {
            let (positions, _) = model.mesh.positions.as_chunks::<3>();
            let mut numbers = Vec::with_capacity(positions.len());
            for position in positions {
                if !position.iter().all(|value| value.is_finite()) {
                    return Err(Error::input(path, "a vertex is not finite"));
                }
                // Adding 0 turns -0 into 0.
                let next = u32::try_from(mesh.vertices.len())
                    .map_err(|_| Error::input(path, "too many vertices"))?;
                let number = *known
                    .entry(position.map(|value| (value + 0.0).to_bits()))
                    .or_insert(next);
                if number == next {
                    mesh.vertices
                        .push(DVec3::from_array(position.map(f64::from)));
                }
                numbers.push(number);
            }
            let (corners, _) = model.mesh.indices.as_chunks::<3>();
            let joined = corners
                .iter()
                .filter_map(|corners| {
                    let [a, b, c] = corners.map(|corner| numbers.get(corner as usize).copied());
                    Some([a?, b?, c?])
                })
                .filter(|[a, b, c]| a != b && b != c && c != a);
            mesh.triangles.extend(joined);
            if mesh.triangles.len() > MAX_TRIANGLES {
                return Err(Error::input(
                    path,
                    format!("expected at most {MAX_TRIANGLES} triangles"),
                ));
            }
        }
        if mesh.triangles.is_empty() {
            return Err(Error::input(path, "no faces: expected a body's surface"));
        }
        Ok(mesh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Mesh> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.obj");
        std::fs::write(&path, text).unwrap();
        Mesh::read(path)
    }

    #[test]
    fn quads_become_triangles_and_vertices_at_one_place_become_one() {
        let text = "mtllib gone.mtl\no a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv -0 0 0\nv 0 0 1\n\
                    f 1 2 3 4\no b\nf 5//1 -1 2\n"
            .replace("//1", "");
        let mesh = read(&text).unwrap();
        assert_eq!(mesh.vertices.len(), 5);
        assert_eq!(mesh.triangles.len(), 3);
        assert_eq!(mesh.triangles[0], [0, 1, 2]);
        assert_eq!(mesh.triangles[2], [0, 4, 1]);
    }

    #[test]
    fn what_is_no_surface_is_refused() {
        for (text, problem) in [
            ("", "no faces"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no faces"),
            ("v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "not finite"),
            ("v 0 0 0\nf 1 2 9\n", "not a Wavefront OBJ"),
            ("v a b c\n", "not a Wavefront OBJ"),
            ("\u{0}\u{1}\u{2}", "no faces"),
        ] {
            let found = read(text).map(|_| ()).unwrap_err().to_string();
            assert!(found.contains(problem), "{text:?}: {found}");
        }
    }
}
