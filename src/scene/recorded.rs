//! Recorded motions as subjects: from files to bodies that walk.

use super::cohort::anthropometry::{DIMENSIONS, Dimensions, Population};
use super::cohort::body;
use super::events::{Cut, cut};
use super::retarget::{DEFAULT_CUT_OFF_HZ, Take, leg_length_m};
use super::{Span, Subject, Track, Walk};
use crate::error::{Error, Result};
use crate::import::{Format, Motion, Options};
use edgegait_core::pack::{Gait, Sex};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::DVec3;
use std::path::{Path, PathBuf};

/// Hip-to-ankle length over stature: (trochanter - malleolus) of ANSUR II's means,
/// (0.513 - 0.042) for men and (0.519 - 0.039) for women.
const LEG_SHARE: f64 = 0.4755;
/// Froude number v^2 / (g L) from which people run (Alexander 1989, Physiol. Rev.
/// 69:1199-1227: walking changes to running near 0.5).
const RUNNING_FROUDE: f64 = 0.5;

/// Where a subject's name is read from.
#[derive(Clone, Debug)]
pub enum SubjectName {
    /// What stands before the last `_` of the file's name, or the whole name.
    File,
    /// The folder that the file is in.
    Folder,
    /// This name, for all files.
    Given(String),
}

/// What of a take is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// Its gait cycles, each closed.
    Cycles,
    /// The take as it is.
    Take,
}

/// How files are read.
#[derive(Clone, Debug)]
pub struct ReadOptions {
    /// What of a take is kept.
    pub keep: Keep,
    /// Where the subject's name is read from.
    pub subject: SubjectName,
    /// The skeleton of an AMC file; otherwise the one beside it.
    pub asf: Option<PathBuf>,
    /// Frames a second, over what the file says.
    pub sample_rate_hz: Option<f64>,
    /// Cut-off of the low-pass; `None` leaves the motion as recorded.
    pub low_pass_hz: Option<f64>,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            keep: Keep::Cycles,
            subject: SubjectName::File,
            asf: None,
            sample_rate_hz: None,
            low_pass_hz: Some(DEFAULT_CUT_OFF_HZ),
        }
    }
}

/// One file: a take on the canonical skeleton, and its gait cycles.
#[derive(Clone, Debug)]
pub struct Recording {
    /// The file.
    pub path: PathBuf,
    /// Its format.
    pub format: Format,
    /// Who walks.
    pub subject: String,
    /// Name of the take: the file's name without its extension.
    pub name: String,
    /// The motion.
    pub take: Take,
    /// Its gait cycles; `None` for a take that is kept as it is.
    pub cut: Option<Cut>,
}

impl Recording {
    /// Reads, retargets and cuts one file.
    ///
    /// # Errors
    /// When the file cannot be read, lacks joints, or holds no gait cycle where those are
    /// kept.
    pub fn read(path: &Path, options: &ReadOptions) -> Result<Self> {
        let motion = Motion::read_with(
            path,
            &Options {
                sample_rate_hz: options.sample_rate_hz,
                asf: options.asf.clone(),
            },
        )?;
        let take = Take::from_motion(&motion, options.low_pass_hz)
            .map_err(|problem| Error::input(path, problem))?;
        let cut = match options.keep {
            Keep::Cycles => Some(cut(&take).map_err(|problem| Error::input(path, problem))?),
            Keep::Take => None,
        };
        let name = path
            .file_stem()
            .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let subject = match &options.subject {
            SubjectName::Given(subject) => subject.clone(),
            SubjectName::File => match name.rsplit_once('_') {
                Some((before, _)) if !before.is_empty() => before.to_owned(),
                _ => name.clone(),
            },
            SubjectName::Folder => path.parent().and_then(Path::file_name).map_or_else(
                || name.clone(),
                |folder| folder.to_string_lossy().into_owned(),
            ),
        };
        Ok(Self {
            path: path.to_path_buf(),
            format: motion.format,
            subject,
            name,
            take,
            cut,
        })
    }

    /// Horizontal travel over time, mean over the cycles, or the speed along a whole take's
    /// path; m/s.
    #[must_use]
    pub fn speed_mps(&self) -> f64 {
        match &self.cut {
            Some(cut) => cut.speed_mps,
            None => Span::of(&self.take).speed_mps(),
        }
    }

    /// What was assumed, repaired or dropped.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let cut = self.cut.iter().flat_map(|cut| &cut.warnings);
        self.take.warnings.iter().chain(cut).cloned().collect()
    }
}

/// The body that recordings are put onto.
#[derive(Clone, Copy, Debug, Default)]
pub struct BodyOptions {
    /// Stature, metres; otherwise the skeleton's own segments are kept.
    pub stature_m: Option<f64>,
    /// Mass, kg; otherwise that of the mean body mass index.
    pub mass_kg: Option<f64>,
    /// Sex; otherwise dimensions between both.
    pub sex: Option<Sex>,
}

/// One subject for each name among the recordings, with the cycles of all their takes or the
/// takes themselves.
/// Subjects and takes are in order of their names, whatever the order of the files.
///
/// Without a stature a subject keeps the segment lengths of their first take but the
/// neck's, and the hulls are those of a person whose legs are as long.
///
/// # Errors
/// For implausible bodies, and two takes of one name of one subject.
pub fn subjects(recordings: &[Recording], options: &BodyOptions) -> Result<Vec<Subject>> {
    let mut recordings: Vec<&Recording> = recordings.iter().collect();
    let key = |recording: &&Recording| (recording.subject.clone(), recording.name.clone());
    recordings.sort_by_key(key);
    if let Some(pair) = recordings
        .windows(2)
        .find(|pair| key(&pair[0]) == key(&pair[1]))
    {
        return Err(Error::input(
            &pair[1].path,
            format!(
                "take {:?} of subject {:?} is {} already: expected one file for each (--subject-from folder takes the folder's name as the subject's)",
                pair[1].name,
                pair[1].subject,
                pair[0].path.display()
            ),
        ));
    }
    let mut subjects: Vec<Subject> = Vec::new();
    for recording in recordings.iter().copied() {
        let known = subjects
            .iter()
            .position(|subject| subject.name == recording.subject);
        let index = match known {
            Some(index) => index,
            None => {
                subjects.push(new_subject(recording, options)?);
                subjects.len() - 1
            }
        };
        let subject = &mut subjects[index];
        let own = &recording.take.offsets;
        let mut add = |cycle, speed_mps, motion| {
            subject.walks.push(Walk {
                name: recording.name.clone(),
                cycle,
                gait: gait(speed_mps, leg_length_m(own)),
                speed_mps,
                motion,
            });
        };
        match &recording.cut {
            Some(cut) => {
                for (number, cut) in (0u16..).zip(&cut.cycles) {
                    let cycle = cut.cycle.onto(own, &subject.body.offsets);
                    add(number, cut.speed_mps, Track::Loop(cycle));
                }
            }
            None => {
                let span = Span::of(&recording.take);
                let moved = span.onto(own, &subject.body.offsets);
                add(0, span.speed_mps(), Track::Take(moved));
            }
        }
    }
    Ok(subjects)
}

/// A subject with a body and no walks yet.
fn new_subject(recording: &Recording, options: &BodyOptions) -> Result<Subject> {
    let own = recording.take.offsets;
    let stature_m = options
        .stature_m
        .unwrap_or_else(|| leg_length_m(&own) / LEG_SHARE);
    let mass_kg = options.mass_kg.unwrap_or_else(|| {
        let bmi = |sex| Population::of(sex).bmi.0;
        let mean = 0.5 * (bmi(Sex::Female) + bmi(Sex::Male));
        options.sex.map_or(mean, bmi) * stature_m * stature_m
    });
    let dimensions = Dimensions::expected(stature_m, mass_kg, options.sex, &[0.0; DIMENSIONS])?;
    let offsets = match options.stature_m {
        Some(_) => body::offsets(&dimensions),
        None => with_head_at_its_height(own, &dimensions),
    };
    Ok(Subject {
        name: recording.subject.clone(),
        sex: options.sex,
        stature_m,
        mass_kg,
        body: body::body(&dimensions, offsets),
        walks: Vec::new(),
    })
}

/// The offsets with the neck as long as it takes to put the ears where a person of these
/// dimensions has them: files place a joint called head anywhere between the seventh
/// cervical vertebra and the crown.
fn with_head_at_its_height(
    mut offsets: [DVec3; JOINTS],
    dimensions: &Dimensions,
) -> [DVec3; JOINTS] {
    let trunk = [Joint::Spine, Joint::Thorax, Joint::Neck];
    let neck: f64 = trunk.iter().map(|joint| offsets[joint.index()].y).sum();
    let hips = dimensions.trochanterion_height;
    let ears = dimensions.stature - dimensions.tragion_to_vertex;
    let head = &mut offsets[Joint::Head.index()];
    // Between 4 cm and 12 % of the stature, whatever the trunk is.
    head.y = (ears - hips - neck).clamp(0.04, 0.12 * dimensions.stature);
    offsets
}

/// Walking or running at this speed, by the Froude number.
fn gait(speed_mps: f64, leg_m: f64) -> Gait {
    const GRAVITY: f64 = 9.81;
    if speed_mps * speed_mps > RUNNING_FROUDE * GRAVITY * leg_m {
        Gait::Run
    } else {
        Gait::Walk
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_run_from_a_froude_number_of_a_half() {
        // 0.9 m legs: sqrt(0.5 * 9.81 * 0.9) = 2.10 m/s.
        assert_eq!(gait(2.05, 0.9), Gait::Walk);
        assert_eq!(gait(2.15, 0.9), Gait::Run);
    }
}
