//! Readers of motion capture files, each in its own units, axes and names.
//!
//! Readers keep the units, axes and names of a file. A frame rate that the user gives replaces the
//! file's, and `warnings` say what was assumed or repaired. [`crate::people::retarget`] finds the up
//! axis, the unit and the joints' roles.

use std::collections::HashSet;
use std::fmt;
use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};

use crate::error::{Error, Remedy, Result};

mod amc;
mod asf;
mod bvh;
mod c3d;
mod files;
mod gltf;
mod lines;
pub(crate) mod obj;
mod time_column;
mod trc;

/// The extensions of motion files, lower case.
pub const EXTENSIONS: [&str; 6] = ["bvh", "amc", "c3d", "trc", "glb", "gltf"];

/// Accepted frame rates, Hz.
const RATE_HZ: std::ops::RangeInclusive<f64> = 1.0..=10_000.0;

/// The maximum number of marker positions of a file. Our choice: 29 minutes of 40 markers at 120
/// Hz, 270 MB in memory.
const MAX_POSITIONS: usize = 1 << 23;

/// The contents of a motion file.
#[derive(Clone, Debug)]
pub enum FileContents {
    /// A skeleton that moves.
    Motion(Motion),
    /// Markers on a body.
    Markers(Markers),
}

/// The trajectories of markers as the file states them: source names, units and axes.
#[derive(Clone, Debug)]
pub struct Markers {
    /// The format of the file.
    pub format: MotionFormat,
    /// The markers' names as spelled in the file, prefixes included.
    pub names: Vec<String>,
    /// The frame rate, Hz.
    pub sample_rate_hz: f64,
    /// The frames, at least one: a position for each name, source units and axes, if the marker was
    /// seen.
    pub frames: Vec<Vec<Option<DVec3>>>,
    /// Metres in one source unit, if the file states it.
    pub unit_m: Option<f64>,
    /// Warnings about what was assumed or repaired.
    pub warnings: Vec<String>,
}

/// A mesh that joints move by linear blending.
#[derive(Clone, Debug)]
pub struct Skin {
    /// The vertices in the rest pose (all rotations identity, the root at [`Skin::root`]), source
    /// units, world axes.
    pub vertices: Vec<DVec3>,
    /// The triangles, as numbers of their vertices.
    pub triangles: Vec<[u32; 3]>,
    /// For each vertex, the joints that move it and their weights, which sum to 1.
    pub weights: Vec<Vec<(usize, f64)>>,
    /// The position of joint 0 in the rest pose.
    pub root: DVec3,
}

/// A motion as the file states it: source names, units and axes.
#[derive(Clone, Debug)]
pub struct Motion {
    /// The format of the file.
    pub format: MotionFormat,
    /// The joints, parents first; the root is joint 0.
    pub joints: Vec<SourceJoint>,
    /// The frame rate, Hz.
    pub sample_rate_hz: f64,
    /// The frames, at least one.
    pub frames: Vec<SourceFrame>,
    /// Metres in one source unit, if the file states it (ASF does, BVH cannot).
    pub unit_m: Option<f64>,
    /// The mesh that the joints move, if the file has one.
    pub skin: Option<Skin>,
    /// Warnings about what was assumed or repaired.
    pub warnings: Vec<String>,
}

/// The format of a motion file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionFormat {
    /// Biovision hierarchy.
    Bvh,
    /// Acclaim skeleton and motion: two files.
    AsfAmc,
    /// Coordinate 3D: markers, binary.
    C3d,
    /// Track row column: markers, text.
    Trc,
    /// glTF 2.0, text or binary: metres, Y up, facing +Z.
    Gltf,
    /// Wavefront OBJ: a mesh.
    Obj,
}

impl MotionFormat {
    /// Returns whether files of this format state their axes: a floor at y = 0, Y up, people who
    /// face +Z.
    #[must_use]
    pub const fn states_axes(self) -> bool {
        matches!(self, Self::Gltf)
    }

    /// Returns whether motions of this format are made or cleaned by hand, not measured.
    #[must_use]
    pub const fn is_authored(self) -> bool {
        matches!(self, Self::Gltf)
    }
}

impl fmt::Display for MotionFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Bvh => "bvh",
            Self::AsfAmc => "asf/amc",
            Self::C3d => "c3d",
            Self::Trc => "trc",
            Self::Gltf => "gltf",
            Self::Obj => "obj",
        })
    }
}

/// A joint of a source skeleton.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceJoint {
    /// The joint's name as spelled in the file.
    pub name: String,
    /// Index of the parent, smaller than the joint's own; `None` for the root.
    pub parent: Option<usize>,
    /// Offset from the parent at rest (all rotations identity), source units, world axes.
    pub offset: DVec3,
    /// End site or tip of a leaf, as an offset from the joint at rest.
    pub end: Option<DVec3>,
}

/// A pose of a source skeleton.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceFrame {
    /// Position of joint 0, source units and axes.
    pub root: DVec3,
    /// Local rotations, about a rest pose in which every joint frame is parallel to the world.
    pub rotations: Vec<DQuat>,
    /// This frame's offsets from the parents, which replace [`SourceJoint::offset`], if the file
    /// moves joints (a BVH with position channels beyond the root's).
    pub offsets: Option<Vec<DVec3>>,
}

/// Information from the user that the file lacks or states wrongly.
#[derive(Clone, Debug, Default)]
pub struct ImportOptions {
    /// The frame rate, Hz, instead of the file's. Without it, an AMC, which states none, gets 120,
    /// CMU's usual rate.
    pub sample_rate_hz: Option<f64>,
    /// The skeleton file of an AMC, instead of the one found beside it.
    pub asf: Option<PathBuf>,
    /// The name of the animation of a glTF, which may hold several.
    pub clip: Option<String>,
    /// The name of one of several people: the prefix of their markers in a C3D or a TRC (`Anna` of
    /// `Anna:LASI`), or the node above their skeleton in a glTF.
    pub person: Option<String>,
}

impl Skin {
    /// Returns the vertices in a frame of the skin's own motion, by linear blending, source units.
    ///
    /// # Panics
    /// If there is no such frame, or the motion has other joints.
    #[must_use]
    pub fn posed(&self, motion: &Motion, frame: usize) -> Vec<DVec3> {
        let (positions, rotations) = motion.globals(frame);
        let mut rest: Vec<DVec3> = Vec::with_capacity(motion.joints.len());
        for joint in &motion.joints {
            rest.push(
                joint
                    .parent
                    .map_or(self.root, |parent| rest[parent] + joint.offset),
            );
        }
        let vertices = self.vertices.iter().zip(&self.weights);
        vertices
            .map(|(vertex, weights)| {
                weights
                    .iter()
                    .map(|&(joint, weight)| {
                        let moved = positions[joint] + rotations[joint] * (*vertex - rest[joint]);
                        weight * moved
                    })
                    .sum()
            })
            .collect()
    }
}

impl Markers {
    /// Drops all markers without this prefix.
    fn keep_person(&mut self, person: &str) -> std::result::Result<(), String> {
        let is_theirs: Vec<bool> = (self.names.iter())
            .map(|name| person_of(name) == Some(person))
            .collect();
        if !is_theirs.contains(&true) {
            let mut known: Vec<&str> = self
                .names
                .iter()
                .filter_map(|name| person_of(name))
                .collect();
            known.sort_unstable();
            known.dedup();
            return Err(match known.as_slice() {
                [] => format!(
                    "no person {person}: expected markers such as {person}:LASI, found none with a prefix"
                ),
                known => format!("no person {person}; there are: {}", known.join(", ")),
            });
        }
        let mut kept = is_theirs.iter().copied();
        self.names.retain(|_| kept.next() == Some(true));
        for frame in &mut self.frames {
            let mut kept = is_theirs.iter().copied();
            frame.retain(|_| kept.next() == Some(true));
        }
        Ok(())
    }
}

/// Returns the prefix of a marker's name, which names the person who wears it.
pub(crate) fn person_of(marker: &str) -> Option<&str> {
    marker.rsplit_once(':').map(|(person, _)| person)
}

impl FileContents {
    /// Reads a `.bvh`, `.c3d`, `.trc`, `.glb` or `.gltf`, or an `.amc` with the `.asf` beside it.
    /// That is the file of the same name, else of the name before the last `_` (`02_01.amc`:
    /// `02.asf`), else the only one in the folder.
    ///
    /// # Errors
    /// If the file cannot be read or is not a complete, finite motion.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        Self::read_with(path, &ImportOptions::default())
    }

    /// Reads a file like [`FileContents::read`], with options from the user.
    ///
    /// # Errors
    /// If the file cannot be read or is not a complete, finite motion, or an option is out of
    /// range.
    pub fn read_with(path: impl AsRef<Path>, options: &ImportOptions) -> Result<Self> {
        let path = path.as_ref();
        if let Some(rate) = options.sample_rate_hz
            && !RATE_HZ.contains(&rate)
        {
            return Err(Error::Usage(format!(
                "the sample rate must be 1 to 10000 Hz, not {rate}"
            )));
        }
        let extension = path
            .extension()
            .map(|e| e.to_string_lossy().to_ascii_lowercase())
            .unwrap_or_default();
        if let (Some(clip), false) = (&options.clip, is_gltf(path)) {
            return Err(Error::input(
                path,
                format!("no clip {clip}: only .glb and .gltf hold named animations"),
            ));
        }
        let mut source = match extension.as_str() {
            "glb" | "gltf" => {
                let clip = options.clip.as_deref();
                let clip = clip.map_or(gltf::WantedAnimation::Only, gltf::WantedAnimation::Named);
                Self::Motion(gltf::read(path, clip, options.person.as_deref())?)
            }
            "bvh" => Self::Motion(bvh::read(
                lines::Lines::open(path)?,
                options.sample_rate_hz,
            )?),
            "amc" => {
                let asf = match &options.asf {
                    Some(asf) => asf.clone(),
                    None => find_asf(path)?,
                };
                let skeleton = asf::read(lines::Lines::open(&asf)?)?;
                Self::Motion(amc::read(lines::Lines::open(path)?, skeleton)?)
            }
            "asf" => {
                return Err(Error::input(
                    path,
                    "a skeleton without motion; give the .amc",
                ));
            }
            "c3d" => Self::Markers(c3d::read(path, options.sample_rate_hz)?),
            "trc" => Self::Markers(trc::read(
                lines::Lines::open(path)?,
                options.sample_rate_hz,
            )?),
            _ => {
                return Err(Error::input(
                    path,
                    format!(
                        "unknown kind of motion; expected .{}",
                        EXTENSIONS.join(", .")
                    ),
                ));
            }
        };
        match (&mut source, &options.person) {
            (Self::Markers(markers), Some(person)) => markers
                .keep_person(person)
                .map_err(|problem| Error::input(path, problem).with_remedy(Remedy::NamePerson))?,
            (Self::Motion(motion), Some(person)) if motion.format != MotionFormat::Gltf => {
                let problem =
                    format!("no person {person}: .{extension} files hold one, without a name");
                return Err(Error::input(path, problem));
            }
            _ => {}
        }
        if let Self::Markers(markers) = &mut source {
            let distinct: HashSet<&String> = markers.names.iter().collect();
            let repeated = markers.names.len() - distinct.len();
            if repeated > 0 {
                // Names are not listed: a prefix may be a person's name.
                let warning = format!("{repeated} markers share their name with another");
                markers.warnings.push(warning);
            }
        }
        let (stated_hz, format, warnings) = match &mut source {
            Self::Motion(motion) => (
                &mut motion.sample_rate_hz,
                motion.format,
                &mut motion.warnings,
            ),
            Self::Markers(markers) => (
                &mut markers.sample_rate_hz,
                markers.format,
                &mut markers.warnings,
            ),
        };
        if let Some(rate) = options.sample_rate_hz {
            *stated_hz = rate;
        } else if format == MotionFormat::AsfAmc {
            warnings.push(format!(
                "an AMC states no frame rate: {stated_hz} Hz assumed"
            ));
        }
        Ok(source)
    }
}

impl Motion {
    /// Reads a file with a skeleton, like [`FileContents::read`].
    ///
    /// # Errors
    /// As [`FileContents::read`], and if the file holds markers.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        Self::read_with(path, &ImportOptions::default())
    }

    /// Reads a file like [`Motion::read`], with options from the user.
    ///
    /// # Errors
    /// As [`FileContents::read_with`], and if the file holds markers.
    pub fn read_with(path: impl AsRef<Path>, options: &ImportOptions) -> Result<Self> {
        match FileContents::read_with(&path, options)? {
            FileContents::Motion(motion) => Ok(motion),
            FileContents::Markers(_) => Err(Error::input(
                path,
                "expected a skeleton that moves, found markers",
            )),
        }
    }

    /// Returns the positions (source units) and world orientations of all joints in a frame, by
    /// forward kinematics in f64.
    ///
    /// # Panics
    /// If there is no such frame.
    #[must_use]
    pub fn globals(&self, frame: usize) -> (Vec<DVec3>, Vec<DQuat>) {
        let frame = &self.frames[frame];
        let mut positions: Vec<DVec3> = Vec::with_capacity(self.joints.len());
        let mut rotations: Vec<DQuat> = Vec::with_capacity(self.joints.len());
        for (index, (joint, local)) in self.joints.iter().zip(&frame.rotations).enumerate() {
            let Some(parent) = joint.parent else {
                positions.push(frame.root);
                rotations.push(*local);
                continue;
            };
            let offset = frame
                .offsets
                .as_ref()
                .map_or(joint.offset, |all| all[index]);
            positions.push(positions[parent] + rotations[parent] * offset);
            rotations.push((rotations[parent] * *local).normalize());
        }
        (positions, rotations)
    }
}

/// Returns whether a file has the extension of a glTF file.
#[must_use]
pub fn is_gltf(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    extension == "glb" || extension == "gltf"
}

/// Reads the skeleton and the mesh of a `.glb` or `.gltf` at rest: a motion of one frame.
///
/// # Errors
/// If the file cannot be read or holds no skinned mesh.
pub fn skinned_body(path: &Path) -> Result<Motion> {
    let motion = gltf::read(path, gltf::WantedAnimation::Nothing, None)?;
    match motion.skin {
        Some(_) => Ok(motion),
        None => Err(Error::input(
            path,
            "expected a mesh that its joints move, found none",
        )),
    }
}

/// Finds the skeleton file of an AMC.
fn find_asf(amc: &Path) -> Result<PathBuf> {
    let stem = amc
        .file_stem()
        .map(|s| s.to_string_lossy().into_owned())
        .unwrap_or_default();
    let subject = stem
        .rsplit_once('_')
        .map_or(stem.as_str(), |(head, _)| head);
    for name in [stem.as_str(), subject] {
        let candidate = amc.with_file_name(format!("{name}.asf"));
        if candidate.is_file() {
            return Ok(candidate);
        }
    }
    let folder = match amc.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let entries = std::fs::read_dir(folder).map_err(|source| Error::io(folder, source))?;
    let mut found: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| {
            path.extension()
                .is_some_and(|e| e.eq_ignore_ascii_case("asf"))
        })
        .collect();
    match (found.pop(), found.pop()) {
        (Some(only), None) => Ok(only),
        (Some(_), Some(_)) => Err(Error::input(
            amc,
            format!("several .asf files beside it and none is {subject}.asf; name the skeleton"),
        )),
        (None, _) => Err(Error::input(
            amc,
            format!("no {subject}.asf beside it; name the skeleton"),
        )),
    }
}

/// Returns the metres in a unit of length by its name in marker files; none, with a warning, if it
/// is unknown.
fn metres(unit: &str, warnings: &mut Vec<String>) -> Option<f64> {
    let metres = match unit.to_ascii_lowercase().as_str() {
        "m" | "meter" | "meters" | "metre" | "metres" => 1.0,
        "dm" => 0.1,
        "cm" => 0.01,
        "mm" => 0.001,
        "in" | "inch" | "inches" => 0.0254,
        "ft" | "feet" => 0.3048,
        _ => {
            warnings.push(format!("unknown unit of length `{}`", lines::shown(unit)));
            return None;
        }
    };
    Some(metres)
}
