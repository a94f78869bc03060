//! `edgegait inspect`: what a pack holds, and what it costs.

use super::args::Common;
use super::source::read_pack;
use crate::dataset::Header;
use crate::error::{Error, Result};
use edgegait_core::pack::{Gait, Pack};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

/// Show what a pack holds: people, walks, bytes and errors
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  edgegait inspect cohort.egp --json -")]
pub struct Args {
    /// The pack
    #[arg(value_name = "PACK")]
    pack: PathBuf,
    #[command(flatten)]
    pub common: Common,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let source = read_pack(&args.pack)?;
    let mut header = Header::new("inspect", args.common.seed);
    header.inputs = source.inputs;
    let summary = summary(header, &args.pack, &source.bytes)?;
    args.common.say(&summary);
    args.common.write_json(&summary)
}

/// What a pack holds.
#[derive(Debug, Serialize)]
pub struct Summary {
    #[serde(flatten)]
    header: Header,
    bytes: usize,
    sections: BTreeMap<&'static str, usize>,
    subjects: Vec<SubjectSummary>,
    clips: Vec<ClipSummary>,
}

#[derive(Debug, Serialize)]
struct SubjectSummary {
    name: String,
    sex: Option<&'static str>,
    stature_m: f64,
    mass_kg: f64,
    hulls: usize,
    points: usize,
    avatar_bytes: usize,
}

#[derive(Debug, Serialize)]
struct ClipSummary {
    file: String,
    subject: String,
    walk: String,
    cycle: u16,
    gait: &'static str,
    cadence_spm: f64,
    speed_mps: f64,
    bytes: usize,
    max_error_mm: f64,
    mean_error_mm: f64,
}

/// A warning if walks of a pack miss the error that was asked for.
pub fn missed_error(bytes: &[u8], max_error_mm: f64) -> Result<Option<String>> {
    let pack = Pack::parse(bytes).map_err(|error| Error::Failed(error.to_string()))?;
    let errors = (0..pack.clip_count())
        .filter_map(|index| pack.clip(index))
        .map(|clip| f64::from(clip.max_error_mm()));
    // Stored errors are rounded up to 0.01 mm.
    let missed: Vec<f64> = errors
        .filter(|&error| error > max_error_mm + 0.011)
        .collect();
    let most = missed.iter().copied().fold(0.0, f64::max);
    Ok((!missed.is_empty()).then(|| {
        format!(
            "{} of {} walks miss the error of {max_error_mm} mm, by up to {:.2} mm: the format is not finer for them",
            missed.len(),
            pack.clip_count(),
            most - max_error_mm
        )
    }))
}

/// Sums up a pack that was read from or written to `path`.
pub fn summary(header: Header, path: &Path, bytes: &[u8]) -> Result<Summary> {
    let pack = Pack::parse(bytes).map_err(|error| Error::input(path, error.to_string()))?;
    let names = ["names", "subjects", "walks", "avatars", "clips"];
    let subjects: Vec<SubjectSummary> = pack
        .subjects()
        .filter_map(|subject| {
            let avatar = pack.avatar(subject.avatar)?;
            Some(SubjectSummary {
                name: subject.name.into(),
                sex: subject.sex.map(|sex| match sex {
                    edgegait_core::pack::Sex::Female => "female",
                    edgegait_core::pack::Sex::Male => "male",
                }),
                stature_m: f64::from(subject.stature_mm) * 1e-3,
                mass_kg: f64::from(subject.mass_hg) * 0.1,
                hulls: avatar.hulls().count(),
                points: avatar.hulls().map(|hull| hull.len()).sum(),
                avatar_bytes: avatar.len_bytes(),
            })
        })
        .collect();
    let clips = pack
        .walks()
        .filter_map(|walk| {
            let clip = pack.clip(walk.clip)?;
            Some(ClipSummary {
                file: path.display().to_string(),
                subject: subjects.get(walk.subject)?.name.clone(),
                walk: walk.name.into(),
                cycle: walk.cycle,
                gait: match walk.gait {
                    Gait::Walk => "walk",
                    Gait::Run => "run",
                },
                cadence_spm: rounded(120.0 / f64::from(clip.period_s()), 2),
                speed_mps: f64::from(walk.speed_mm_per_s) * 1e-3,
                bytes: clip.len_bytes(),
                max_error_mm: rounded(f64::from(clip.max_error_mm()), 2),
                mean_error_mm: rounded(f64::from(clip.mean_error_mm()), 2),
            })
        })
        .collect();
    Ok(Summary {
        header,
        bytes: bytes.len(),
        sections: names.into_iter().zip(pack.section_bytes()).collect(),
        subjects,
        clips,
    })
}

/// A number as it is shown, with so many decimals.
fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = 10f64.powi(decimals);
    (value * scale).round() / scale
}

/// Smallest, mean and largest.
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

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bytes:", self.bytes)?;
        for (name, bytes) in &self.sections {
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
        writeln!(f, "bytes a cycle: {least:.0} to {most:.0}, mean {mean:.0}")?;
        let (least, mean, most) = spread(self.clips.iter().map(|clip| clip.max_error_mm));
        writeln!(
            f,
            "greatest error: {least:.2} to {most:.2} mm, mean {mean:.2}"
        )?;
        writeln!(f)?;
        writeln!(
            f,
            "{:<10} {:<14} {:>5} {:>9} {:>7} {:>6} {:>8} {:>8}",
            "subject", "walk", "cycle", "steps/min", "m/s", "bytes", "max mm", "mean mm"
        )?;
        const SHOWN: usize = 30;
        for clip in self.clips.iter().take(SHOWN) {
            writeln!(
                f,
                "{:<10} {:<14} {:>5} {:>9.1} {:>7.3} {:>6} {:>8.2} {:>8.2}",
                clip.subject,
                clip.walk,
                clip.cycle,
                clip.cadence_spm,
                clip.speed_mps,
                clip.bytes,
                clip.max_error_mm,
                clip.mean_error_mm
            )?;
        }
        if self.clips.len() > SHOWN {
            write!(
                f,
                "... and {} more (--json has all)",
                self.clips.len() - SHOWN
            )?;
        }
        Ok(())
    }
}
