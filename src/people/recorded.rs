//! Recorded motions as subjects: from files to walking bodies.

use super::cleaning::bridges::bridge_flips;
use super::cleaning::flips::MotionEnds;
use super::cohort::anthropometry::{DIMENSIONS, Dimensions, PopulationNorms};
use super::cohort::body;
use super::cutting::events::{CutTake, cut};
use super::cutting::flat_feet::{lifts, stand_flat};
use super::cutting::floor::level_floor;
use super::cutting::stance::{FeetMotion, FootSlide};
use super::leg::LEG_SHARE;
use super::markers::people;
use super::measured::{MeasuredPeople, MeasuredPerson};
pub use super::renamings::Renamings;
use super::retarget::{DEFAULT_CUT_OFF_HZ, RetargetedMotion, has_known_joints, leg_length_m};
use super::trunk_lean::stand_upright;
use super::unsure_joints::steady;
use super::{Body, Subject, Track, UncutMotion, Walk};
use crate::error::{Error, RefusedWalk, Remedy, Result};
use crate::import::{FileContents, ImportOptions, Motion, MotionFormat};
use edgegait_core::pack::{Gait, Sex};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::DVec3;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Froude number v^2 / (g L) above which people run (Alexander 1989, Physiol. Rev.
/// 69:1199-1227: walking changes to running near 0.5).
const RUNNING_FROUDE: f64 = 0.5;

/// Distance from their recorded places, mm, up to which feet count as reaching them. Our choice:
/// twice the usual error of encoding.
const NEARLY_REACHED_MM: f64 = 10.0;

/// Where a subject's name is read from.
#[derive(Clone, Debug)]
pub enum SubjectName {
    /// The file's name up to its last `_`; the whole name if there is no `_` or the file holds a
    /// body.
    File,
    /// The folder that the file is in.
    Folder,
    /// This name, for all files.
    Given(String),
}

/// The part of a take that is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// All its gait cycles, each closed.
    Cycles,
    /// The mean of its gait cycles.
    MeanCycle,
    /// The first of its gait cycles.
    FirstCycle,
    /// The uncut motion.
    Uncut,
}

/// The low-pass filter of motions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Smoothing {
    /// At [`DEFAULT_CUT_OFF_HZ`] for measured motion, none for authored motion.
    Usual,
    /// At this cut-off, Hz.
    At(f64),
    /// No filter: the motion stays as it is in the file.
    Off,
}

impl Smoothing {
    /// Returns the cut-off for motions of a format, Hz.
    const fn cut_off_hz(self, format: MotionFormat) -> Option<f64> {
        match self {
            Self::Usual if format.is_authored() => None,
            Self::Usual => Some(DEFAULT_CUT_OFF_HZ),
            Self::At(cut_off_hz) => Some(cut_off_hz),
            Self::Off => None,
        }
    }
}

/// Options for reading files.
#[derive(Clone, Debug)]
pub struct ReadOptions {
    /// The part of each take that is kept.
    pub keep: Keep,
    /// Where the subject's name is read from.
    pub subject: SubjectName,
    /// The skeleton of an AMC file; by default the one beside it.
    pub asf: Option<PathBuf>,
    /// The animation of a glTF file.
    pub clip: Option<String>,
    /// One of several people in a file, as in [`ImportOptions::person`].
    pub person: Option<String>,
    /// Known names for joints or markers that the importer does not know.
    pub renamings: Option<Renamings>,
    /// Frames a second; overrides the file's rate.
    pub sample_rate_hz: Option<f64>,
    /// The low-pass filter of motions.
    pub smoothing: Smoothing,
    /// Whether to mend what captures measure badly: feet that stand tilted, elbows that bend
    /// backwards, hands, collar bones and heads, and tilted floors of uncut motions.
    pub mend: bool,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            keep: Keep::Cycles,
            subject: SubjectName::File,
            asf: None,
            clip: None,
            person: None,
            renamings: None,
            sample_rate_hz: None,
            smoothing: Smoothing::Usual,
            mend: true,
        }
    }
}

/// One file: a take on the canonical skeleton, and its gait cycles.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Path of the file.
    pub path: PathBuf,
    /// Format of the file.
    pub format: MotionFormat,
    /// Name of the walker.
    pub subject: String,
    /// Name of the take: its clip's name, or else the file's name without its extension.
    pub name: String,
    /// The motion on the canonical skeleton.
    pub take: RetargetedMotion,
    /// Gait cycles of the take; `None` if it is kept uncut.
    pub cut: Option<CutTake>,
    /// Heights of the ankles while the feet stand flat, metres, left first. `None` if the feet
    /// never do or not always at one height, for authored motion, and without mending.
    pub standing_m: Option<[f64; 2]>,
    /// The skeleton with its mesh, if the file has one.
    pub mesh: Option<Motion>,
}

impl Recording {
    /// Reads, retargets and cuts one file.
    ///
    /// # Errors
    /// When the file cannot be read, lacks joints or markers, or holds no gait cycle although
    /// cycles are kept.
    pub fn read(path: &Path, options: &ReadOptions) -> Result<Self> {
        let mut source = FileContents::read_with(
            path,
            &ImportOptions {
                sample_rate_hz: options.sample_rate_hz,
                asf: options.asf.clone(),
                clip: options.clip.clone(),
                person: options.person.clone(),
            },
        )?;
        if let Some(renamings) = &options.renamings {
            let renamed = renamings.apply(&mut source);
            renamed.map_err(|problem| Error::input(path, problem))?;
        }
        let (format, has_skin, read_warnings) = match &source {
            FileContents::Motion(motion) => {
                (motion.format, motion.skin.is_some(), &motion.warnings)
            }
            FileContents::Markers(markers) => (markers.format, false, &markers.warnings),
        };
        if let FileContents::Markers(markers) = &source
            && let people @ [_, _, ..] = people(markers).as_slice()
        {
            let problem = format!(
                "markers of several people, expected the name of one; there are: {}",
                people.join(", ")
            );
            return Err(Error::input(path, problem).with_remedy(Remedy::NamePerson));
        }
        let cut_off_hz = options.smoothing.cut_off_hz(format);
        let take = match &source {
            FileContents::Motion(motion) => RetargetedMotion::from_motion(motion, cut_off_hz),
            FileContents::Markers(markers) => RetargetedMotion::from_markers(markers, cut_off_hz),
        };
        let mut take =
            take.map_err(
                |problem| match (&source, refusal(path, &problem, read_warnings)) {
                    (FileContents::Motion(motion), refused) if !has_known_joints(motion) => {
                        refused.with_remedy(Remedy::RenameJoints)
                    }
                    (_, refused) => refused,
                },
            )?;
        let mut standing_m = None;
        if options.mend && !format.is_authored() {
            if options.keep == Keep::Uncut {
                level_floor(&mut take);
            }
            standing_m = stand_flat(&mut take);
            steady(&mut take);
            if matches!(source, FileContents::Motion(_)) && options.keep != Keep::Uncut {
                stand_upright(&mut take);
            }
        }
        let mut cut = match options.keep {
            Keep::Uncut => None,
            _ => Some(cut(&take).map_err(|problem| refusal(path, &problem, &take.warnings))?),
        };
        match (&mut cut, options.keep) {
            (Some(cut), Keep::MeanCycle) => cut.cycles = vec![cut.mean()],
            (Some(cut), Keep::FirstCycle) => cut.cycles.truncate(1),
            _ => {}
        }
        match &mut cut {
            Some(cut) => {
                for one in &mut cut.cycles {
                    let cycle = &mut one.cycle;
                    let rate_hz = cycle.rotations.len() as f64 / cycle.period_s;
                    let bridged = bridge_flips(&mut cycle.rotations, MotionEnds::Meet, rate_hz);
                    let at = |what| format!("the cycle at {:.2} s: {what}", one.start_s);
                    cut.warnings.extend(bridged.into_iter().map(at));
                }
            }
            None => {
                let bridged =
                    bridge_flips(&mut take.rotations, MotionEnds::Open, take.sample_rate_hz);
                take.warnings.extend(bridged);
            }
        }
        let stem = path
            .file_stem()
            .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let subject = match &options.subject {
            SubjectName::Given(subject) => subject.clone(),
            SubjectName::File => match stem.rsplit_once('_') {
                // A file with a skin is a body, not one of its takes.
                Some((before, _)) if !before.is_empty() && !has_skin => before.to_owned(),
                _ => stem.clone(),
            },
            SubjectName::Folder => path.parent().and_then(Path::file_name).map_or_else(
                || stem.clone(),
                |folder| folder.to_string_lossy().into_owned(),
            ),
        };
        let name = options.clip.clone().unwrap_or(stem);
        Ok(Self {
            path: path.to_path_buf(),
            format,
            subject,
            name,
            take,
            cut,
            standing_m,
            mesh: match source {
                FileContents::Motion(motion) if has_skin => Some(motion),
                _ => None,
            },
        })
    }

    /// Returns the number of walks: the gait cycles, or 1 for an uncut take.
    #[must_use]
    pub fn walks(&self) -> usize {
        self.cut.as_ref().map_or(1, |cut| cut.cycles.len())
    }

    /// Returns the speed, m/s: horizontal travel over time as the mean over the cycles, or the
    /// speed along an uncut take's path.
    #[must_use]
    pub fn speed_mps(&self) -> f64 {
        match &self.cut {
            Some(cut) => cut.speed_mps,
            None => UncutMotion::from_take(&self.take).speed_mps(),
        }
    }

    /// Returns how far standing feet would slide on a body whose legs moved like the recorded ones,
    /// for each walk with a stance: the sliding that the recording itself causes.
    #[must_use]
    pub fn own_skates(&self, body: &Body) -> Vec<FootSlide> {
        let offsets = &self.take.offsets;
        match &self.cut {
            Some(cut) => {
                let cycles = cut.cycles.iter().map(|cut| &cut.cycle);
                let skate = |cycle| FeetMotion::of_cycle(cycle, offsets).own_skate(body);
                cycles.filter_map(skate).collect()
            }
            None => {
                let skate = FeetMotion::of_take(&self.take).own_skate(body);
                skate.into_iter().collect()
            }
        }
    }

    /// Returns a sentence with the frame and millimetres if the legs of a body do not reach the
    /// places of the recorded feet.
    #[must_use]
    pub fn out_of_reach(&self, body: &Body) -> Option<String> {
        let (own, target, lifts) = (
            &self.take.offsets,
            &body.offsets,
            lifts(self.standing_m, &self.take.offsets, body),
        );
        let (second, short) = match &self.cut {
            Some(cut) => {
                let shorts = cut.cycles.iter().map(|cut| {
                    let short = cut.cycle.moved(own, target, lifts).too_short;
                    let share = short.frame as f64 / cut.cycle.root.len() as f64;
                    (cut.start_s + share * cut.cycle.period_s, short.mm)
                });
                shorts.max_by(|a, b| a.1.total_cmp(&b.1))?
            }
            None => {
                let span = UncutMotion::from_take(&self.take);
                let short = span.moved(own, target, lifts).too_short;
                (short.frame as f64 / self.take.sample_rate_hz, short.mm)
            }
        };
        let frame = (second * self.take.sample_rate_hz).round();
        (short > NEARLY_REACHED_MM).then(|| {
            format!("the legs of this body are up to {short:.0} mm short of where the feet were (frame {frame}): they reach as far as they can")
        })
    }

    /// Returns sentences on what was assumed, repaired or dropped.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let cut = self.cut.iter().flat_map(|cut| &cut.warnings);
        self.take.warnings.iter().chain(cut).cloned().collect()
    }
}

/// Returns the error of a file that gives no walk, with its first warnings: a recording cut short,
/// doubtful names.
fn refusal(path: &Path, problem: &str, warnings: &[String]) -> Error {
    const SHOWN: usize = 2;
    let more = match warnings.len().saturating_sub(SHOWN) {
        0 => String::new(),
        more => format!("; and {more} more"),
    };
    match &warnings[..warnings.len().min(SHOWN)] {
        [] => Error::input(path, problem),
        shown => Error::input(path, format!("{problem} ({}{more})", shown.join("; "))),
    }
}

/// Options for the bodies that recordings are put onto.
#[derive(Clone, Debug, Default)]
pub struct BodyOptions {
    /// Stature, metres; otherwise the skeleton's own segments are kept.
    pub stature_m: Option<f64>,
    /// Mass, kg; otherwise from the mean body mass index.
    pub mass_kg: Option<f64>,
    /// Sex; otherwise dimensions are the mean of both sexes'.
    pub sex: Option<Sex>,
    /// Measured people; their values take precedence over all of the above.
    pub measured: MeasuredPeople,
    /// Ready bodies by subject, fitted to a mesh.
    pub given: BTreeMap<String, Body>,
}

/// Returns one subject for each name among the recordings, with the cycles of all takes or the
/// uncut takes. Subjects and takes are sorted by name, whatever the order of the files.
///
/// Without a stature, a subject keeps the segment lengths of the first take except the neck's,
/// and gets the hulls of a person with legs of that length. With a measured or given stature,
/// the joints lie where its dimensions put them. Measured dimensions of hulls count in either
/// case.
///
/// # Errors
/// If bodies are implausible (the error names their people), or if two takes of a subject have the
/// same name.
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
                "take {:?} of subject {:?} was read from {} already: expected one file for each",
                pair[1].name,
                pair[1].subject,
                pair[0].path.display()
            ),
        )
        .with_remedy(Remedy::FolderIsSubject));
    }
    let mut subjects: Vec<Subject> = Vec::new();
    let mut refused: Vec<RefusedWalk> = Vec::new();
    for recording in recordings.iter().copied() {
        if refused
            .iter()
            .any(|refusal| refusal.subject == recording.subject)
        {
            continue;
        }
        let known = subjects
            .iter()
            .position(|subject| subject.name == recording.subject);
        let index = match known {
            Some(index) => index,
            None => match new_subject(recording, options) {
                Ok(subject) => {
                    subjects.push(subject);
                    subjects.len() - 1
                }
                Err(error) => {
                    refused.push(RefusedWalk {
                        subject: recording.subject.clone(),
                        walk: None,
                        problem: error.to_string(),
                    });
                    continue;
                }
            },
        };
        let subject = &mut subjects[index];
        let own = &recording.take.offsets;
        let lifts = lifts(recording.standing_m, own, &subject.body);
        // People of other sizes walk the same way at other speeds: the gait is the recorded one's.
        let mut add = |cycle, recorded_mps, speed_mps, motion| {
            subject.walks.push(Walk {
                name: recording.name.clone(),
                cycle,
                gait: gait(recorded_mps, leg_length_m(own)),
                speed_mps,
                worn: None,
                motion,
            });
        };
        match &recording.cut {
            Some(cut) => {
                for (number, cut) in (0u16..).zip(&cut.cycles) {
                    let cycle = cut.cycle.onto(own, &subject.body.offsets, lifts);
                    let speed_mps = cycle.drift_m / cycle.period_s;
                    add(number, cut.speed_mps, speed_mps, Track::Loop(cycle));
                }
            }
            None => {
                let span = UncutMotion::from_take(&recording.take);
                let moved = span.onto(own, &subject.body.offsets, lifts);
                add(0, span.speed_mps(), moved.speed_mps(), Track::Uncut(moved));
            }
        }
    }
    if refused.is_empty() {
        Ok(subjects)
    } else {
        Err(Error::Refused(refused))
    }
}

/// Returns a subject with a body and no walks yet.
fn new_subject(recording: &Recording, options: &BodyOptions) -> Result<Subject> {
    let own = recording.take.offsets;
    let row = options.measured.person(&recording.subject);
    let measured = row.unwrap_or(&MeasuredPerson::NOTHING);
    let known_stature_m = measured.stature_m.or(options.stature_m);
    let known_mass_kg = measured.mass_kg.or(options.mass_kg);
    let sex = measured.sex.or(options.sex);
    if let Some(body) = options.given.get(&recording.subject) {
        return Ok(Subject {
            name: recording.subject.clone(),
            sex,
            age_years: None,
            stature_m: known_stature_m.unwrap_or(0.0),
            mass_kg: known_mass_kg.unwrap_or(0.0),
            body: body.clone(),
            walks: Vec::new(),
        });
    }
    let stature_m = known_stature_m.unwrap_or_else(|| leg_length_m(&own) / LEG_SHARE);
    let mass_kg = known_mass_kg.unwrap_or_else(|| {
        let bmi = |sex| PopulationNorms::for_sex(sex).bmi.0;
        let mean = 0.5 * (bmi(Sex::Female) + bmi(Sex::Male));
        sex.map_or(mean, bmi) * stature_m * stature_m
    });
    let dimensions = Dimensions::expected(stature_m, mass_kg, sex, &[0.0; DIMENSIONS])?
        .with(&measured.dimensions_m);
    let offsets = match known_stature_m {
        Some(_) => body::offsets(&dimensions),
        None => with_head_at_its_height(own, &dimensions),
    };
    Ok(Subject {
        name: recording.subject.clone(),
        sex,
        age_years: None,
        stature_m,
        mass_kg,
        body: body::body(&dimensions, offsets),
        walks: Vec::new(),
    })
}

/// Returns the offsets with a neck length that puts the ears where a person of these dimensions
/// has them: files place a joint called head anywhere between the seventh cervical vertebra and
/// the crown.
fn with_head_at_its_height(
    mut offsets: [DVec3; JOINTS],
    dimensions: &Dimensions,
) -> [DVec3; JOINTS] {
    let trunk = [Joint::Spine, Joint::Thorax, Joint::Neck];
    let neck: f64 = trunk.iter().map(|joint| offsets[joint.index()].y).sum();
    let hips = dimensions.trochanterion_height;
    let ears = dimensions.stature - dimensions.tragion_to_vertex;
    let head = &mut offsets[Joint::Head.index()];
    // Between 4 cm and 12 % of the stature, whatever the trunk's length.
    head.y = (ears - hips - neck).clamp(0.04, 0.12 * dimensions.stature);
    offsets
}

/// Returns the gait at this speed, by the Froude number.
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
