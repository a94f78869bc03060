//! The summary of a pack: people, walks, bytes, errors and memory.

mod budget;

use crate::error::{Error, Result};
use crate::files::ResultHeader;
use crate::files::text_table::Column::{Left, Right};
use crate::files::text_table::Table;
use budget::BudgetSummary;
use edgegait_core::avatar::Avatar;
use edgegait_core::pack::{Pack, Sex, SubjectEntry, WalkEntry};
use edgegait_core::skeleton::{JOINTS, Joint};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::Path;

/// The names of a pack's sections, in file order.
const SECTIONS: [&str; 7] = [
    "names",
    "subjects",
    "walks",
    "avatars",
    "codebook",
    "templates",
    "clips",
];

/// The summary of a pack, for JSON or text.
#[derive(Debug, Serialize)]
pub(crate) struct Summary {
    #[serde(flatten)]
    header: ResultHeader,
    bytes: usize,
    budget: BudgetSummary,
    sections: BTreeMap<&'static str, usize>,
    subjects: Vec<SubjectSummary>,
    /// The mean over clips of their bits per joint and frame.
    bits_per_joint_frame: f64,
    joints: Vec<JointSummary>,
    clips: Vec<ClipSummary>,
    /// The measurements of the people, if requested.
    #[cfg(feature = "import")]
    #[serde(skip_serializing_if = "Option::is_none")]
    audit: Option<crate::people::audit::Audit>,
}

/// The errors of one joint over all clips.
#[derive(Debug, Serialize)]
struct JointSummary {
    name: String,
    max_error_mm: f64,
    mean_error_mm: f64,
}

#[derive(Debug, Serialize)]
struct SubjectSummary {
    name: String,
    sex: Option<&'static str>,
    age_years: Option<u8>,
    /// The clothes on the first walk, if the person is dressed.
    clothes: Option<String>,
    /// The stature in the pack, or else the height of the standing hulls; `None` without both.
    stature_m: Option<f64>,
    stature_from: Option<&'static str>,
    /// The mass, or `None` if the pack does not state it.
    mass_kg: Option<f64>,
    hulls: usize,
    points: usize,
    avatar_bytes: usize,
    avatar_max_error_mm: f64,
    /// The Jaccard index of the hulls and the mesh that they were fitted to.
    jaccard: Option<f64>,
    walks: usize,
    clip_bytes: usize,
}

#[derive(Debug, Serialize)]
struct ClipSummary {
    file: String,
    subject: String,
    /// The clothes, if the person is dressed.
    clothes: Option<String>,
    walk: String,
    cycle: u16,
    gait: &'static str,
    /// The cadence of a cycle; none for an uncut motion.
    cadence_spm: Option<f64>,
    duration_s: f64,
    speed_mps: f64,
    template: Option<u8>,
    frames: u32,
    /// The distance by which closing the cycle moved a joint; none for an uncut motion.
    closure_mm: Option<f64>,
    bytes: usize,
    bits_per_joint_frame: f64,
    max_error_mm: f64,
    mean_error_mm: f64,
}

/// The source of a stature: the pack.
const FROM_PACK: &str = "pack";
/// The source of a stature: the height of the hulls.
const FROM_HULLS: &str = "hulls";

/// Converts a quantity of a pack to another unit; packs store 0 for unknown ones.
fn known(stored: u16, unit: f64) -> Option<f64> {
    (stored > 0).then(|| f64::from(stored) * unit)
}

/// Returns the height from the lowest to the highest point of a body at rest, metres; `None`
/// without hulls.
fn height_m(avatar: &Avatar<'_>) -> Option<f64> {
    let offsets = avatar.skeleton().offsets;
    // No joint is rotated at rest; parents come first.
    let mut heights = [0.0f32; JOINTS];
    for joint in Joint::ALL {
        if let Some(parent) = joint.parent() {
            heights[joint.index()] = heights[parent.index()] + offsets[joint.index()].y;
        }
    }
    let points = avatar.hulls().flat_map(|hull| {
        let height = heights[hull.joint().index()];
        hull.points()
            .map(move |point| f64::from(height + point.y))
            .collect::<Vec<_>>()
    });
    let (least, most) = points.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), y| {
        (least.min(y), most.max(y))
    });
    (most > least).then_some(most - least)
}

/// Rounds a number to this many decimals.
fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = 10f64.powi(decimals);
    (value * scale).round() / scale
}

/// Formats a number with this many decimals, or a dash for none.
pub(crate) fn optional(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "-".into(), |value| format!("{value:.decimals$}"))
}

/// Returns the smallest value, the mean and the largest value.
fn spread(values: impl Iterator<Item = f64> + Clone) -> (f64, f64, f64) {
    let (mut count, mut sum) = (0.0, 0.0);
    for value in values.clone() {
        count += 1.0;
        sum += value;
    }
    let least = values.clone().fold(f64::INFINITY, f64::min);
    let most = values.fold(f64::NEG_INFINITY, f64::max);
    (least, sum / f64::max(count, 1.0), most)
}

impl SubjectSummary {
    fn is_measured(&self) -> bool {
        self.stature_from == Some(FROM_HULLS)
    }

    /// Formats the stature, with a mark if it was measured from the hulls.
    fn stature(&self) -> String {
        let mark = if self.is_measured() { "~" } else { "" };
        format!("{mark}{}", optional(self.stature_m, 2))
    }
}

impl ClipSummary {
    /// Returns the number of the cycle in its take, or "uncut" for an uncut motion.
    fn cycle_or_uncut(&self) -> String {
        match self.cadence_spm {
            Some(_) => self.cycle.to_string(),
            None => "uncut".into(),
        }
    }
}

/// The maximum number of rows in a table that are shown.
const SHOWN: usize = 30;

/// Writes the summary; the alternate form (`{:#}`) adds the budget, people and joints.
impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bytes:", self.bytes)?;
        for name in SECTIONS {
            let bytes = self.sections.get(name).copied().unwrap_or(0);
            write!(f, " {name} {bytes}")?;
        }
        writeln!(f)?;
        writeln!(
            f,
            "{} people, {} walks",
            self.subjects.len(),
            self.clips.len()
        )?;
        for warning in &self.header.warnings {
            writeln!(f, "warning: {warning}")?;
        }
        if self.clips.is_empty() {
            return Ok(());
        }
        let (least, mean, most) = spread(self.clips.iter().map(|clip| clip.bytes as f64));
        let bits = self.bits_per_joint_frame;
        writeln!(
            f,
            "bytes per clip: {least:.0} to {most:.0}, mean {mean:.0}, {bits:.2} bits per joint and frame"
        )?;
        let (least, mean, most) = spread(self.clips.iter().map(|clip| clip.max_error_mm));
        writeln!(
            f,
            "greatest error: {least:.2} to {most:.2} mm, mean {mean:.2}"
        )?;
        if f.alternate() {
            self.budget.fmt(f)?;
            self.write_people(f)?;
            self.write_joints(f)?;
        }
        self.write_clips(f)?;
        #[cfg(feature = "import")]
        if let Some(audit) = &self.audit {
            write!(f, "\n{audit}")?;
        }
        Ok(())
    }
}

impl SubjectSummary {
    /// Summarises a person, whose clips have these bytes.
    fn from_entry(pack: &Pack<'_>, subject: &SubjectEntry<'_>, clips: &[usize]) -> Option<Self> {
        let avatar = pack.avatar(subject.avatar)?;
        let (stature_m, stature_from) = match known(subject.stature_mm, 1e-3) {
            Some(stated) => (Some(stated), Some(FROM_PACK)),
            None => {
                let measured = height_m(&avatar).map(|height| rounded(height, 3));
                (measured, measured.map(|_| FROM_HULLS))
            }
        };
        Some(Self {
            name: subject.name.into(),
            sex: subject.sex.map(Sex::name),
            age_years: subject.age_years,
            clothes: avatar.clothes().map(|clothes| clothes.to_string()),
            stature_m,
            stature_from,
            mass_kg: known(subject.mass_hg, 0.1),
            hulls: avatar.drawn_hulls(),
            points: avatar.hulls().map(|hull| hull.len()).sum(),
            avatar_bytes: avatar.len_bytes(),
            avatar_max_error_mm: rounded(f64::from(avatar.max_error_mm()), 2),
            jaccard: avatar
                .jaccard()
                .map(|jaccard| rounded(f64::from(jaccard), 4)),
            walks: clips.len(),
            clip_bytes: clips.iter().sum(),
        })
    }
}

impl ClipSummary {
    /// Summarises a walk of this person, in the pack at `path`.
    fn from_entry(
        pack: &Pack<'_>,
        walk: WalkEntry<'_>,
        path: &Path,
        subject: String,
    ) -> Option<Self> {
        let clip = pack.clip(walk.clip)?;
        let samples = f64::from(clip.frames().max(1)) * JOINTS as f64;
        Some(Self {
            file: path.display().to_string(),
            subject,
            clothes: pack
                .avatar(walk.avatar)
                .and_then(|avatar| avatar.clothes())
                .map(|clothes| clothes.to_string()),
            walk: walk.name.into(),
            cycle: walk.cycle,
            gait: walk.gait.name(),
            cadence_spm: clip
                .as_loop()
                .map(|cycle| rounded(120.0 / cycle.period_s(), 2)),
            duration_s: rounded(clip.duration_s(), 3),
            speed_mps: f64::from(walk.speed_mm_per_s) * 1e-3,
            template: clip
                .as_loop()
                .map(|cycle| cycle.template_number())
                .filter(|&number| number > 0),
            frames: clip.frames(),
            closure_mm: clip
                .as_loop()
                .map(|cycle| rounded(f64::from(cycle.closure_mm()), 1)),
            bytes: clip.len_bytes(),
            bits_per_joint_frame: rounded(8.0 * clip.len_bytes() as f64 / samples, 3),
            max_error_mm: rounded(f64::from(clip.max_error_mm()), 2),
            mean_error_mm: rounded(f64::from(clip.mean_error_mm()), 2),
        })
    }
}

impl Summary {
    /// Summarises a pack that was read from or written to `path`.
    ///
    /// # Errors
    /// If the bytes are not a pack.
    pub(crate) fn from_bytes(header: ResultHeader, path: &Path, bytes: &[u8]) -> Result<Self> {
        let pack = Pack::parse(bytes).map_err(|error| Error::input(path, error.to_string()))?;
        // The bytes of each person's clips.
        let mut own: Vec<Vec<usize>> = vec![Vec::new(); pack.subjects().len()];
        for walk in pack.walks() {
            own[walk.subject].extend(pack.clip(walk.clip).map(|clip| clip.len_bytes()));
        }
        let subjects = pack.subjects().zip(&own);
        let subjects: Vec<SubjectSummary> = subjects
            .filter_map(|(subject, clips)| SubjectSummary::from_entry(&pack, &subject, clips))
            .collect();
        let clips: Vec<ClipSummary> = pack
            .walks()
            .filter_map(|walk| {
                let subject = subjects.get(walk.subject)?.name.clone();
                ClipSummary::from_entry(&pack, walk, path, subject)
            })
            .collect();
        Ok(Self {
            header,
            bytes: bytes.len(),
            budget: BudgetSummary::from_pack(&pack),
            sections: SECTIONS.into_iter().zip(pack.section_bytes()).collect(),
            subjects,
            bits_per_joint_frame: rounded(
                spread(clips.iter().map(|clip| clip.bits_per_joint_frame)).1,
                3,
            ),
            joints: Joint::ALL
                .into_iter()
                .map(|joint| {
                    let (most, mean) = pack.codebook().joint_error_mm(joint);
                    JointSummary {
                        name: format!("{joint:?}"),
                        max_error_mm: rounded(f64::from(most), 2),
                        mean_error_mm: rounded(f64::from(mean), 2),
                    }
                })
                .collect(),
            clips,
            #[cfg(feature = "import")]
            audit: None,
        })
    }

    /// Adds measurements of the people, which are compared with published values.
    #[cfg(feature = "import")]
    pub(crate) fn with_audit(mut self, bytes: &[u8]) -> Self {
        self.audit = Pack::parse(bytes)
            .ok()
            .as_ref()
            .map(crate::people::audit::Audit::measure);
        self
    }

    fn write_people(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = Table::new(&[Left(10), Right(6)]);
        let is_dressed = self
            .subjects
            .iter()
            .any(|subject| subject.clothes.is_some());
        let columns =
            "subject|sex|years|m|kg|hulls|points|body bytes|error mm|jaccard|walks|clip bytes";
        table.row(columns.split('|').chain(is_dressed.then_some("clothes")));
        for subject in self.subjects.iter().take(SHOWN) {
            let cells = [
                subject.name.clone(),
                subject.sex.unwrap_or("-").into(),
                subject
                    .age_years
                    .map_or_else(|| "-".into(), |years| years.to_string()),
                subject.stature(),
                optional(subject.mass_kg, 1),
                subject.hulls.to_string(),
                subject.points.to_string(),
                subject.avatar_bytes.to_string(),
                format!("{:.2}", subject.avatar_max_error_mm),
                optional(subject.jaccard, 4),
                subject.walks.to_string(),
                subject.clip_bytes.to_string(),
            ];
            let clothes = is_dressed.then(|| self.clothes_of(subject));
            table.row(cells.into_iter().chain(clothes));
        }
        note_rest(&mut table, self.subjects.len());
        write!(f, "\n{table}")?;
        if self.subjects.iter().any(SubjectSummary::is_measured) {
            writeln!(
                f,
                "(~: the pack does not state the stature; from the lowest to the highest point of the hulls, standing)"
            )?;
        }
        Ok(())
    }

    /// Returns a person's clothes, or the number of different outfits.
    fn clothes_of(&self, subject: &SubjectSummary) -> String {
        let walks = self
            .clips
            .iter()
            .filter(|clip| clip.subject == subject.name);
        let ways: BTreeSet<_> = walks.map(|clip| &clip.clothes).collect();
        match (ways.len(), &subject.clothes) {
            (2.., _) => format!("{} ways", ways.len()),
            (_, Some(clothes)) => clothes.clone(),
            (_, None) => "-".into(),
        }
    }

    fn write_joints(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = Table::new(&[Left(14), Right(0)]);
        table.row(["joint", "max mm", "mean mm"]);
        for joint in &self.joints {
            let errors = [joint.max_error_mm, joint.mean_error_mm];
            let [most, mean] = errors.map(|mm| format!("{mm:.2}"));
            table.row([&joint.name, &most, &mean]);
        }
        write!(f, "\n{table}")
    }

    fn write_clips(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = Table::new(&[Left(10), Left(14), Right(6)]);
        table
            .row("subject|walk|cycle|s|steps/min|m/s|bytes|bits|max mm|mean mm|loop mm".split('|'));
        for clip in self.clips.iter().take(SHOWN) {
            table.row([
                clip.subject.clone(),
                clip.walk.clone(),
                clip.cycle_or_uncut(),
                format!("{:.2}", clip.duration_s),
                optional(clip.cadence_spm, 1),
                format!("{:.3}", clip.speed_mps),
                clip.bytes.to_string(),
                format!("{:.2}", clip.bits_per_joint_frame),
                format!("{:.2}", clip.max_error_mm),
                format!("{:.2}", clip.mean_error_mm),
                optional(clip.closure_mm, 1),
            ]);
        }
        note_rest(&mut table, self.clips.len());
        write!(f, "\n{table}")
    }
}

/// Adds a note of the number of rows that are not shown.
fn note_rest(table: &mut Table<'_>, rows: usize) {
    if rows > SHOWN {
        table.note(format!(
            "... and {} more (the JSON results have all)",
            rows - SHOWN
        ));
    }
}
