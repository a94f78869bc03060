//! `edgegait import`: recorded walks as a pack.

use super::args::Common;
use super::encoding::EncodingArgs;
use super::inspect::{optional, summary};
use super::progress::Progress;
use crate::dataset::{Header, InputFile, write_atomically};
use crate::error::{Error, Result};
use crate::scene::recorded::{BodyOptions, Keep, ReadOptions, Recording, SubjectName, subjects};
use clap::ValueEnum;
use edgegait_core::clip::Clip;
use edgegait_core::pack::{Pack, Sex};
use serde::Serialize;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Import recorded motions (BVH, ASF/AMC): retarget, cut into gait cycles or keep whole, encode
/// as a pack
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait import clips/cmu_amc/s07/*.amc --out s07.egp\n  edgegait import turn.bvh --track clip --out turn.egp\n  edgegait import walk.bvh --subject anna --stature-m 1.68 --mass-kg 61 --sex female --out anna.egp\n\nA take is named after its file, and its subject after what stands before the last \"_\" of\nthat name (07_01.amc is take 07_01 of subject 07). An .amc file is read with the .asf file\nbeside it."
)]
pub struct Args {
    /// Files, or folders of them
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// Where to write the pack
    #[arg(long, value_name = "PATH", default_value = "import.egp")]
    out: PathBuf,
    /// What to store of each file: its gait cycles, each closed, or the take as it is
    #[arg(long, value_name = "TRACK", default_value = "loop")]
    track: Track,
    /// Name of the subject of all files
    #[arg(long, value_name = "NAME", conflicts_with = "subject_from")]
    subject: Option<String>,
    /// What the subjects are named after: their files, up to the last "_", or their folders
    #[arg(long, value_name = "WHAT", default_value = "file")]
    subject_from: SubjectFrom,
    /// Skeleton of the .amc files [default: the .asf file beside each]
    #[arg(long, value_name = "FILE")]
    asf: Option<PathBuf>,
    /// Stature of the body that walks [default: from the skeleton's own segment lengths]
    #[arg(long, value_name = "M")]
    stature_m: Option<f64>,
    /// Mass of the body that walks [default: the mean body mass index of ANSUR II]
    #[arg(long, value_name = "KG")]
    mass_kg: Option<f64>,
    /// Sex of the body that walks [default: between both]
    #[arg(long, value_name = "SEX")]
    sex: Option<SexArg>,
    /// Cut-off of the zero-lag low-pass in Hz; 0 leaves the motion as recorded
    #[arg(long, value_name = "HZ", default_value_t = 10.0)]
    low_pass_hz: f64,
    /// Frames a second of the files, where they do not say (AMC) or say it wrongly
    #[arg(long, value_name = "HZ")]
    fps: Option<f64>,
    #[command(flatten)]
    encoding: EncodingArgs,
    /// Leave out files that cannot be imported, with a warning
    #[arg(long)]
    keep_going: bool,
    #[command(flatten)]
    pub common: Common,
}

/// What subjects are named after.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum SubjectFrom {
    File,
    Folder,
}

/// What is stored of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Track {
    /// Closed gait cycles
    Loop,
    /// The take as it is: starts, turns, standing
    Clip,
}

impl Track {
    const fn name(self) -> &'static str {
        match self {
            Self::Loop => "loop",
            Self::Clip => "clip",
        }
    }
}

/// Sexes on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum SexArg {
    Female,
    Male,
}

/// What was imported.
#[derive(Serialize)]
struct Results {
    #[serde(flatten)]
    header: Header,
    bytes: usize,
    subjects: usize,
    clips: Vec<ClipResult>,
}

/// What became of one file.
#[derive(Serialize)]
struct ClipResult {
    file: String,
    format: String,
    fps: f64,
    frames: usize,
    cycles: usize,
    /// Of cycles, as is the residual; a take has neither.
    cadence_spm: Option<f64>,
    speed_mps: f64,
    residual_mm: Option<f64>,
    bytes: usize,
    max_error_mm: f64,
    mean_error_mm: f64,
    warnings: Vec<String>,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    for (flag, value) in [
        ("--low-pass-hz", Some(args.low_pass_hz)),
        ("--fps", args.fps),
    ] {
        if value.is_some_and(|value| !(0.0..=1e6).contains(&value)) {
            return Err(Error::Usage(format!("{flag}: expected 0 or more")));
        }
    }
    args.encoding.check()?;
    let files = expand(&args.files)?;
    let options = ReadOptions {
        keep: match args.track {
            Track::Loop => Keep::Cycles,
            Track::Clip => Keep::Take,
        },
        subject: match (&args.subject, args.subject_from) {
            (Some(name), _) => SubjectName::Given(name.clone()),
            (None, SubjectFrom::File) => SubjectName::File,
            (None, SubjectFrom::Folder) => SubjectName::Folder,
        },
        asf: args.asf.clone(),
        sample_rate_hz: args.fps,
        low_pass_hz: (args.low_pass_hz > 0.0).then_some(args.low_pass_hz),
    };
    let (recordings, refused) = read_all(&files, &options);
    let mut header = Header::new("import", args.common.seed)
        .with("track", args.track.name())
        .with("low_pass_hz", args.low_pass_hz);
    if !refused.is_empty() && (!args.keep_going || recordings.is_empty()) {
        let list: Vec<String> = refused.iter().map(ToString::to_string).collect();
        return Err(Error::Failed(format!(
            "{} of {} files cannot be imported (--keep-going leaves them out):\n{}",
            refused.len(),
            files.len(),
            list.join("\n")
        )));
    }
    header.warnings = refused
        .iter()
        .map(|error| format!("left out: {error}"))
        .collect();
    for recording in &recordings {
        header.inputs.push(InputFile::of(&recording.path)?);
    }
    let body = BodyOptions {
        stature_m: args.stature_m,
        mass_kg: args.mass_kg,
        sex: args.sex.map(|sex| match sex {
            SexArg::Female => Sex::Female,
            SexArg::Male => Sex::Male,
        }),
    };
    let people = subjects(&recordings, &body)?;
    let encoded = args.encoding.encode("encoding", &people)?;
    let bytes = &encoded.bytes;
    header = args.encoding.stated(header, &encoded);
    header.warnings.extend(encoded.missed_errors()?);
    write_atomically(&args.out, |file| {
        file.write_all(bytes)
            .map_err(|error| Error::io(&args.out, error))
    })?;
    let mut results = Results {
        clips: clip_results(&recordings, bytes)?,
        header,
        bytes: bytes.len(),
        subjects: people.len(),
    };
    encoded.say_choice(&args.common);
    args.common.say(table(&results));
    for clip in &results.clips {
        let named = |warning: &String| format!("{}: {warning}", clip.file);
        results
            .header
            .warnings
            .extend(clip.warnings.iter().map(named));
    }
    args.common
        .say(format_args!("wrote {}", args.out.display()));
    args.common.say(summary(
        Header::new("import", args.common.seed),
        &args.out,
        bytes,
    )?);
    args.common.write_json(&results)
}

/// The files to import: folders stand for the .bvh and .amc files in them and in the folders
/// below, by name. Links to folders are not followed.
fn expand(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in paths {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let before = files.len();
        let mut folders = vec![path.clone()];
        while let Some(folder) = folders.pop() {
            let entries = std::fs::read_dir(&folder).map_err(|error| Error::io(&folder, error))?;
            for entry in entries {
                let entry = entry.map_err(|error| Error::io(&folder, error))?;
                let kind = entry
                    .file_type()
                    .map_err(|error| Error::io(entry.path(), error))?;
                let extension = entry
                    .path()
                    .extension()
                    .unwrap_or_default()
                    .to_ascii_lowercase();
                if kind.is_dir() {
                    folders.push(entry.path());
                } else if extension == "bvh" || extension == "amc" {
                    files.push(entry.path());
                }
            }
        }
        if files.len() == before {
            return Err(Error::input(
                path,
                "no .bvh or .amc file in this folder or below",
            ));
        }
        files[before..].sort();
    }
    Ok(files)
}

/// Reads every file, and collects those that cannot be used.
fn read_all(files: &[PathBuf], options: &ReadOptions) -> (Vec<Recording>, Vec<Error>) {
    let progress = Progress::new("files", files.len());
    let (mut recordings, mut refused) = (Vec::new(), Vec::new());
    for file in files {
        match Recording::read(file, options) {
            Ok(recording) => recordings.push(recording),
            Err(error) => refused.push(error),
        }
        progress.step();
    }
    (recordings, refused)
}

/// One row a file, with the bytes and errors of its cycles.
fn clip_results(recordings: &[Recording], bytes: &[u8]) -> Result<Vec<ClipResult>> {
    let pack = Pack::parse(bytes).map_err(|error| Error::Failed(error.to_string()))?;
    let names: Vec<&str> = pack.subjects().map(|subject| subject.name).collect();
    let rows = recordings.iter().map(|recording| {
        let clips: Vec<_> = pack
            .walks()
            .filter(|walk| walk.name == recording.name && names[walk.subject] == recording.subject)
            .filter_map(|walk| pack.clip(walk.clip))
            .collect();
        let most = |errors: &mut dyn Iterator<Item = f32>| f64::from(errors.fold(0.0, f32::max));
        let cut = recording.cut.as_ref();
        let closures = cut.map(|cut| cut.cycles.iter().map(|cut| cut.cycle.closure_mm));
        ClipResult {
            file: recording.path.display().to_string(),
            format: recording.format.to_string(),
            fps: recording.take.sample_rate_hz,
            frames: recording.take.len(),
            cycles: cut.map_or(0, |cut| cut.cycles.len()),
            cadence_spm: cut.map(|cut| cut.cadence_spm),
            speed_mps: recording.speed_mps(),
            residual_mm: closures.map(|closures| closures.fold(0.0, f64::max)),
            bytes: clips.iter().map(Clip::len_bytes).sum(),
            max_error_mm: most(&mut clips.iter().map(Clip::max_error_mm)),
            mean_error_mm: most(&mut clips.iter().map(Clip::mean_error_mm)),
            warnings: recording.warnings(),
        }
    });
    Ok(rows.collect())
}

/// The same for a terminal.
fn table(results: &Results) -> String {
    let mut text = format!(
        "{:<18} {:<8} {:>6} {:>6} {:>6} {:>9} {:>6} {:>9}\n",
        "file", "format", "fps", "frames", "cycles", "steps/min", "m/s", "loop mm"
    );
    for clip in &results.clips {
        let name = Path::new(&clip.file).file_name().unwrap_or_default();
        let _ = writeln!(
            text,
            "{:<18} {:<8} {:>6.1} {:>6} {:>6} {:>9} {:>6.2} {:>9}",
            name.to_string_lossy(),
            clip.format,
            clip.fps,
            clip.frames,
            clip.cycles,
            optional(clip.cadence_spm, 1),
            clip.speed_mps,
            optional(clip.residual_mm, 0)
        );
        for warning in &clip.warnings {
            let _ = writeln!(text, "    warning: {warning}");
        }
    }
    for warning in &results.header.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    text.push_str("(loop mm: how far joints were moved to close the cycle)\n");
    text
}
