//! `edgegait study`: compares real silhouettes with those of synthetic twins.

use super::args::{Common, FileArgs};
use super::outputs::{Output, OutputKind};
use super::progress::Progress;
use crate::error::{Error, Result};
use crate::evaluate::study::{
    Choices, Findings, Paths, StudyPlan, run as run_study, run_synthetic, steps,
};
use crate::files::{InputFile, ResultHeader, write_bytes};
use crate::report::{study_tables, write_study};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Azimuths of the synthetic part without a manifest, degrees.
const AZIMUTHS_DEG: [f32; 3] = [90.0, 45.0, 0.0];

/// Compare real silhouettes with those of synthetic twins: their similarity, and how well
/// recognizers trained on one work on the other
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait study people mocap --manifest people.csv          # real silhouettes and recordings\n  edgegait study people mocap --manifest people.csv --full   # all masks, framings, flips, crops\n  edgegait study                                             # the synthetic part alone\n\nThe manifest is a CSV file with a row for each take and view: id, take, view and source, and, where known, azimuth, elevation, fps, cycles (a-b;c-d, frames from 0), lhs (left contacts), source_root, source_frames_30fps and distance_m. Measurements of the people are read from bodies.csv beside it."
)]
pub(super) struct StudyArgs {
    /// A tree of real silhouettes, <person>/<take>/<view>/ [default: none; only the synthetic part,
    /// with the built-in cohort]
    #[arg(value_name = "REAL", requires = "manifest")]
    real: Option<PathBuf>,
    /// Folders of motion recordings of the same walks
    #[arg(value_name = "MOTION")]
    motions: Vec<PathBuf>,
    /// Manifest that pairs takes with recordings
    #[arg(long, value_name = "FILE.csv", requires = "real")]
    manifest: Option<PathBuf>,
    /// Measurements of the people [default: bodies.csv beside the manifest, if it is there]
    #[arg(long, value_name = "FILE.csv", requires = "real")]
    bodies: Option<PathBuf>,
    /// Measurements of the people with clothes and hair, to measure their effect [default:
    /// bodies_dressed.csv beside the manifest, if it is there]
    #[arg(long, value_name = "FILE.csv", requires = "real")]
    dressed: Option<PathBuf>,
    /// Only these people, by name
    #[arg(
        long,
        value_name = "NAME[,NAME..]",
        value_delimiter = ',',
        requires = "real"
    )]
    subjects: Vec<String>,
    /// Only these views, by name [default: 090,045,000, or all if none of these is there]
    #[arg(
        long,
        value_name = "NAME[,NAME..]",
        value_delimiter = ',',
        requires = "real"
    )]
    views: Vec<String>,
    /// Metres from the camera to the walker, if the manifest does not state it
    #[arg(long, value_name = "M", default_value_t = 6.0)]
    distance_m: f64,
    /// Number of random splits
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=100))]
    splits: u32,
    /// Use all masks (given, segmented, degraded) and both framings (height, box), with and without
    /// the paper's flips and crops
    #[arg(long)]
    full: bool,
    /// Folder of the report: index.html, study.json and figures
    #[arg(long, value_name = "FOLDER", default_value = "edgegait-study")]
    out: PathBuf,
    #[command(flatten)]
    pub common: Common,
}

/// The results of the command.
#[derive(Serialize)]
struct StudyResults {
    #[serde(flatten)]
    header: ResultHeader,
    #[serde(flatten)]
    findings: Findings,
}

impl StudyArgs {
    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        let tables = [&self.real, &self.manifest, &self.bodies, &self.dressed];
        let tables = tables.into_iter().flatten().cloned();
        FileArgs {
            inputs: tables.chain(self.motions.iter().cloned()).collect(),
            outputs: vec![Output::new("--out", &self.out, OutputKind::Study)],
        }
    }

    fn choices(&self) -> Choices {
        if self.full {
            Choices::full(self.common.seed, self.splits)
        } else {
            Choices::usual(self.common.seed, self.splits)
        }
    }
}

/// Runs the subcommand.
pub(super) fn run(args: &StudyArgs) -> Result<()> {
    if !(0.1..=1e6).contains(&args.distance_m) {
        return Err(Error::Usage(
            "--distance-m: expected 0.1 to 1,000,000 metres".into(),
        ));
    }
    args.check_figures()?;
    let choices = args.choices();
    let header = ResultHeader::new("study", args.common.seed)
        .with("splits", args.splits)
        .with("full", args.full)
        .with("distance_m", args.distance_m);
    let (mut header, findings) = match (&args.real, &args.manifest) {
        (Some(real), Some(manifest)) => args.of_real(real, manifest, &choices, header)?,
        _ => args.of_cohort(&choices, header)?,
    };
    header.warnings.extend(findings.warnings.iter().cloned());
    let results = StudyResults { header, findings };
    args.common.say(study_tables(&results.findings));
    args.common.say_warnings(&results.header.warnings);
    write_study(&args.out, &results.header, &results.findings)?;
    let mut json = serde_json::to_string_pretty(&results)?;
    json.push('\n');
    write_bytes(args.out.join("study.json"), json.as_bytes())?;
    args.common.say(format_args!(
        "wrote {}, with study.json and figures beside it",
        args.out.join("index.html").display()
    ));
    args.common.write_json(&results)
}

impl StudyArgs {
    /// Rejects a folder for figures that may contain other files.
    fn check_figures(&self) -> Result<()> {
        let figures = self.out.join("figures");
        let is_own = self.common.overwrite || self.out.join("study.json").is_file();
        if is_own || !figures.exists() {
            return Ok(());
        }
        Err(Error::Usage(format!(
            "--out {}: figures already exists, without study.json beside it (name another, or use --overwrite)",
            self.out.display()
        )))
    }

    fn of_real(
        &self,
        real: &Path,
        manifest: &Path,
        choices: &Choices,
        header: ResultHeader,
    ) -> Result<(ResultHeader, Findings)> {
        let paths = Paths {
            real: real.to_path_buf(),
            motions: self.motions.clone(),
            manifest: manifest.to_path_buf(),
            bodies: self.bodies.clone(),
            dressed: self.dressed.clone(),
        };
        let plan = StudyPlan::new(&paths, &self.views, &self.subjects, self.distance_m)?;
        let progress = Progress::new(
            &self.common,
            ("comparing in", "steps"),
            steps(&plan, choices),
        );
        let findings = run_study(&plan, choices, &|| progress.step())?;
        drop(progress);
        let mut header = header
            .with("real", real.display().to_string())
            .with("subjects", plan.people.join(","));
        header.inputs.extend(plan.inputs.iter().cloned());
        for source in &plan.sources {
            header.inputs.push(InputFile::read(&source.path)?);
        }
        Ok((header, findings))
    }

    /// Runs the synthetic part alone, with a warning about the missing real silhouettes.
    fn of_cohort(
        &self,
        choices: &Choices,
        header: ResultHeader,
    ) -> Result<(ResultHeader, Findings)> {
        let mut header = header.with("pack", "built-in");
        header.warnings.push(
            "no real silhouettes: this is only the synthetic part, with the built-in cohort. A comparison needs a tree of silhouettes, motion recordings of its walks, and a manifest that pairs them (REAL, MOTION and --manifest)"
                .into(),
        );
        let progress = Progress::new(&self.common, ("comparing in", "steps"), None);
        let findings = run_synthetic(&AZIMUTHS_DEG, self.distance_m, choices, &|| progress.step())?;
        Ok((header, findings))
    }
}
