//! Motion capture files, each read in its own units, axes and names.
//!
//! Readers state what a file says and change nothing: finding the up axis, the
//! unit and the joints' roles is the work of [`crate::scene::retarget`].

use std::fmt;
use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};

use crate::error::{Error, Result};

mod amc;
mod asf;
mod bvh;
mod lines;

/// A motion as its file states it: source names, units and axes.
#[derive(Clone, Debug)]
pub struct Motion {
    /// The format that it was read from.
    pub format: Format,
    /// The joints, parents first; the root is joint 0.
    pub joints: Vec<SourceJoint>,
    /// Frames a second.
    pub sample_rate_hz: f64,
    /// At least one.
    pub frames: Vec<SourceFrame>,
    /// Metres in one source unit, where the file states it (ASF does, BVH cannot).
    pub unit_m: Option<f64>,
    /// What was assumed or repaired.
    pub warnings: Vec<String>,
}

/// A file format of motions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Biovision hierarchy.
    Bvh,
    /// Acclaim skeleton and motion: two files.
    AsfAmc,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Bvh => "bvh",
            Self::AsfAmc => "asf/amc",
        })
    }
}

/// A joint of a source skeleton.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceJoint {
    /// As the file spells it.
    pub name: String,
    /// Index of the joint that carries it, below its own; `None` for the root.
    pub parent: Option<usize>,
    /// From the parent at rest (all rotations identity), source units, world axes.
    pub offset: DVec3,
    /// End site or tip of a leaf, as an offset from the joint at rest.
    pub end: Option<DVec3>,
}

/// A pose of a source skeleton.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceFrame {
    /// Position of joint 0, source units and axes.
    pub root: DVec3,
    /// Local rotations, about a rest pose in which every joint frame is parallel to
    /// the world.
    pub rotations: Vec<DQuat>,
    /// This frame's offsets from the parents, if the file moves joints (a BVH with
    /// position channels beyond the root's). They replace [`SourceJoint::offset`].
    pub offsets: Option<Vec<DVec3>>,
}

/// What the user knows and the file does not say.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Frames a second, instead of the file's (AMC has none: 120, CMU's usual rate).
    pub sample_rate_hz: Option<f64>,
    /// The skeleton of an AMC, instead of the one found beside it.
    pub asf: Option<PathBuf>,
}

impl Motion {
    /// Reads a `.bvh`, or an `.amc` with the `.asf` found beside it: the file of the
    /// same name, else of the name before the last `_` (`02_01.amc`: `02.asf`), else
    /// the only one in the folder.
    ///
    /// # Errors
    /// The file cannot be read or is not a complete, finite motion.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        Self::read_with(path, &Options::default())
    }

    /// Reads like [`Motion::read`], with what the user knows better.
    ///
    /// # Errors
    /// The file cannot be read or is not a complete, finite motion, or an option is
    /// out of range.
    pub fn read_with(path: impl AsRef<Path>, options: &Options) -> Result<Self> {
        let path = path.as_ref();
        if let Some(rate) = options.sample_rate_hz
            && !(1.0..=10_000.0).contains(&rate)
        {
            return Err(Error::Usage(format!(
                "the sample rate must be 1 to 10000 Hz, not {rate}"
            )));
        }
        let extension = path
            .extension()
            .map(|e| e.to_string_lossy().to_ascii_lowercase())
            .unwrap_or_default();
        let mut motion = match extension.as_str() {
            "bvh" => bvh::read(lines::Lines::open(path)?)?,
            "amc" => {
                let asf = match &options.asf {
                    Some(asf) => asf.clone(),
                    None => find_asf(path)?,
                };
                let skeleton = asf::read(lines::Lines::open(&asf)?)?;
                amc::read(lines::Lines::open(path)?, skeleton)?
            }
            "asf" => {
                return Err(Error::input(
                    path,
                    "a skeleton without motion; give the .amc",
                ));
            }
            _ => {
                return Err(Error::input(
                    path,
                    "unknown kind of motion; expected .bvh or .amc",
                ));
            }
        };
        if let Some(rate) = options.sample_rate_hz {
            motion.sample_rate_hz = rate;
        } else if motion.format == Format::AsfAmc {
            motion
                .warnings
                .push("an AMC states no frame rate: 120 Hz assumed".into());
        }
        Ok(motion)
    }

    /// Positions (source units) and global rotations of all joints in a frame, by
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

/// The skeleton that belongs to an AMC.
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
