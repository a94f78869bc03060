//! `edgegait import`: imports recorded walks as a pack.

use super::args::{Common, FileArgs};
use super::body::BodyArgs;
use super::encode_recordings::encoded_people;
use super::encoding::{EncodingArgs, say_choice};
use super::keep_going::KeepGoing;
use super::motion_files::expand;
use super::outputs::{Output, OutputKind};
use super::progress::Progress;
use super::shared_warnings::SharedWarning;
use crate::encode::inspect::{Summary, optional};
use crate::error::{Error, Result};
use crate::files::text_table::Column::{Left, Right};
use crate::files::text_table::Table;
use crate::files::{InputFile, ResultHeader, write_bytes};
use crate::people::cutting::stance::FootSlide;
use crate::people::recorded::{Keep, ReadOptions, Recording, Renamings, Smoothing, SubjectName};
use crate::people::{Subject, Track, Walk};
use clap::ValueEnum;
use edgegait_core::clip::Clip;
use edgegait_core::pack::Pack;
use rayon::prelude::*;
use serde::Serialize;
use std::fmt;
use std::path::{Path, PathBuf};

/// Import recorded motions (BVH, ASF/AMC, C3D, TRC, glTF): retarget, cut into gait cycles or keep
/// whole, encode as a pack
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait import clips/cmu_amc/s07/*.amc --out s07.egp\n  edgegait import turn.bvh --track clip --out turn.egp\n  edgegait import walk.bvh --subject anna --stature-m 1.68 --mass-kg 61 --sex female --out anna.egp\n  edgegait import walks --bodies people.csv --out walks.egp\n  edgegait import anna.glb --clip walk --track clip --out anna.egp\n  edgegait import walks --body anna.glb --hull-points 256 --out as-anna.egp\n\nA take is named after its file, and its subject after the part of that name before the last \"_\" (07_01.amc is take 07_01 of subject 07). An .amc file is read with the .asf file beside it. A .glb or .gltf file is a body: its subject is named after the file, and its take after the clip. With --track clip the body stays where the file places it."
)]
pub(super) struct ImportArgs {
    /// Files, or folders of files
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// Where to write the pack
    #[arg(long, value_name = "PATH", default_value = "import.egp")]
    out: PathBuf,
    /// What to store of each file: its closed gait cycles, or the uncut motion
    #[arg(long, value_name = "TRACK", default_value = "loop")]
    track: StoredTrack,
    /// Which gait cycles to store of each file: all, their mean, or the first
    #[arg(long, value_name = "WHICH", default_value = "all")]
    cycles: CycleSelection,
    /// Subject name for all files
    #[arg(long, value_name = "NAME", conflicts_with = "subject_from")]
    subject: Option<String>,
    /// Source of subject names: files, up to the last "_", or folders
    #[arg(long, value_name = "WHAT", default_value = "file")]
    subject_from: SubjectFrom,
    /// Skeleton of the .amc files [default: the .asf file beside each]
    #[arg(long, value_name = "FILE")]
    asf: Option<PathBuf>,
    /// Animation of the .glb and .gltf files [default: the only one in each]
    #[arg(long, value_name = "NAME")]
    clip: Option<String>,
    /// Person, if files hold several: the prefix of their markers (Anna of Anna:LASI), or the node
    /// above their skeleton [default: the only one in each]
    #[arg(long, value_name = "NAME")]
    person: Option<String>,
    /// Known names for joints or markers with others: a CSV file with the header "name,known" and a
    /// row for each, such as hip.L,LeftUpLeg
    #[arg(long, value_name = "FILE.csv")]
    joints: Option<PathBuf>,
    #[command(flatten)]
    body: BodyArgs,
    /// Cut-off of the zero-lag low-pass filter in Hz; 0 leaves the motion as recorded
    /// [default: 10 for captured motion, none for glTF]
    #[arg(long, value_name = "HZ")]
    low_pass_hz: Option<f64>,
    /// Frame rate of the files in Hz, if they do not state it (AMC) or state it wrongly
    #[arg(long, value_name = "HZ")]
    fps: Option<f64>,
    #[command(flatten)]
    encoding: EncodingArgs,
    #[command(flatten)]
    keep_going: KeepGoing,
    #[command(flatten)]
    pub common: Common,
}

/// The source of subject names.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum SubjectFrom {
    File,
    Folder,
}

/// The form in which a file's motion is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum StoredTrack {
    /// Closed gait cycles
    Loop,
    /// The uncut motion: starts, turns, standing
    Clip,
}

impl StoredTrack {
    const fn name(self) -> &'static str {
        match self {
            Self::Loop => "loop",
            Self::Clip => "clip",
        }
    }
}

/// The cycles of a file that are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum CycleSelection {
    /// All cycles, separately
    All,
    /// One cycle with the mean pose at each phase
    Mean,
    /// The first cycle
    First,
}

/// The results of the command.
#[derive(Serialize)]
struct ImportResults {
    #[serde(flatten)]
    header: ResultHeader,
    bytes: usize,
    subjects: usize,
    /// The bodies that were fitted to a mesh.
    fits: Vec<FitResult>,
    clips: Vec<ClipResult>,
}

/// The match between a body's hulls and its mesh.
#[derive(Serialize)]
struct FitResult {
    subject: String,
    hulls: usize,
    points: usize,
    jaccard: f64,
    /// Points and Jaccard index, most points first.
    frontier: Vec<(usize, f64)>,
}

/// The result of importing one file.
#[derive(Serialize)]
struct ClipResult {
    file: String,
    format: String,
    fps: f64,
    frames: usize,
    /// Cut-off of the low-pass filter that was applied to the motion.
    low_pass_hz: Option<f64>,
    cycles: usize,
    /// Cadence of cycles; an uncut motion has no cadence, stride, duty factor and closure.
    cadence_spm: Option<f64>,
    /// Speed on the walker's body, which the pack stores.
    speed_mps: f64,
    stride_m: Option<f64>,
    duty_factor: Option<f64>,
    /// Mean forward lean of the trunk.
    lean_deg: f64,
    /// Distance between the source's joints and the canonical ones, root mean square.
    residual_mm: f64,
    /// The greatest distance that closing moved a joint of any cycle.
    closure_mm: Option<f64>,
    /// Distance that a standing foot slides on the walking body: mean over the stances, and
    /// maximum.
    skate_mm: Option<f64>,
    skate_max_mm: Option<f64>,
    /// Mean distance that a foot slides if the legs move as recorded: the recording's own sliding.
    own_skate_mm: Option<f64>,
    bytes: usize,
    max_error_mm: f64,
    mean_error_mm: f64,
    warnings: Vec<String>,
}

impl ImportArgs {
    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        let files = expand(&self.files).unwrap_or_default();
        // An .amc is read with an .asf beside it, of any name.
        let mut folders: Vec<&Path> = files.iter().filter_map(|file| file.parent()).collect();
        folders.dedup();
        let beside = folders.into_iter().flat_map(|folder| {
            let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
            let paths = entries.map(|entry| entry.path());
            paths.filter(|path| {
                path.extension()
                    .is_some_and(|it| it.eq_ignore_ascii_case("asf"))
            })
        });
        let beside: Vec<PathBuf> = beside.collect();
        let named = [&self.asf, &self.joints].into_iter().flatten().cloned();
        let others = named.chain(self.body.files());
        FileArgs {
            inputs: files.into_iter().chain(beside).chain(others).collect(),
            outputs: vec![Output::new("--out", &self.out, OutputKind::Pack)],
        }
    }
}

/// Runs the subcommand.
pub(super) fn run(args: &ImportArgs) -> Result<()> {
    for (flag, value) in [("--low-pass-hz", args.low_pass_hz), ("--fps", args.fps)] {
        if value.is_some_and(|value| !(0.0..=1e6).contains(&value)) {
            return Err(Error::Usage(format!("{flag}: expected 0 or more")));
        }
    }
    args.encoding.check()?;
    let (measured, unmeasured) = args.body.measured(args.keep_going)?;
    let files = expand(&args.files)?;
    let options = ReadOptions {
        keep: match (args.track, args.cycles) {
            (StoredTrack::Loop, CycleSelection::All) => Keep::Cycles,
            (StoredTrack::Loop, CycleSelection::Mean) => Keep::MeanCycle,
            (StoredTrack::Loop, CycleSelection::First) => Keep::FirstCycle,
            (StoredTrack::Clip, CycleSelection::All) => Keep::Uncut,
            (StoredTrack::Clip, _) => {
                return Err(Error::Usage(
                    "--cycles chooses among gait cycles, but --track clip stores none".into(),
                ));
            }
        },
        subject: match (&args.subject, args.subject_from) {
            (Some(name), _) => SubjectName::Given(name.clone()),
            (None, SubjectFrom::File) => SubjectName::File,
            (None, SubjectFrom::Folder) => SubjectName::Folder,
        },
        asf: args.asf.clone(),
        clip: args.clip.clone(),
        person: args.person.clone(),
        renamings: args.joints.as_deref().map(Renamings::read).transpose()?,
        sample_rate_hz: args.fps,
        smoothing: match args.low_pass_hz {
            None => Smoothing::Usual,
            Some(hz) if hz > 0.0 => Smoothing::At(hz),
            Some(_) => Smoothing::Off,
        },
        mend: true,
    };
    let (mut recordings, refused) = read_all(&files, &options, &args.common)?;
    let mut header = ResultHeader::new("import", args.common.seed)
        .with("track", args.track.name())
        .with("low_pass_hz", args.low_pass_hz);
    let (keep_going, all) = (args.keep_going, files.len());
    header.warnings = keep_going.leave_out(refused, all, "files", "imported")?;
    header.warnings.extend(unmeasured);
    if let Some(path) = &args.joints {
        header.inputs.push(InputFile::read(path)?);
    }
    for recording in &recordings {
        header.inputs.push(InputFile::read(&recording.path)?);
    }
    let points = args.encoding.hull_points.map(usize::from);
    let body = args.body.options(
        &mut recordings,
        measured,
        points,
        &args.common,
        args.keep_going,
        &mut header,
    )?;
    let (people, encoded) = encoded_people(
        &mut recordings,
        &body,
        &|people| args.encoding.encode(people, &args.common),
        args.keep_going,
        &mut header.warnings,
    )?;
    let bytes = &encoded.bytes;
    header = args.encoding.stated(header, &encoded);
    header.warnings.extend(encoded.missed_errors()?);
    let fits = fits(&people);
    let mut results = ImportResults {
        fits,
        clips: clip_results(&recordings, &people, bytes)?,
        header,
        bytes: bytes.len(),
        subjects: people.len(),
    };
    say_choice(&encoded, &args.common);
    args.common.say(table(&results));
    for fit in &results.fits {
        args.common.say(fit);
    }
    let all = clip_warnings(&results.clips);
    let all: Vec<String> = all.iter().map(ToString::to_string).collect();
    results.header.warnings.extend(all);
    args.common.say(Summary::from_bytes(
        ResultHeader::new("import", args.common.seed),
        &args.out,
        bytes,
    )?);
    write_bytes(&args.out, bytes)?;
    args.common
        .say(format_args!("wrote {}", args.out.display()));
    args.common.write_json(&results)
}

/// Returns the bodies that were fitted to a mesh.
fn fits(people: &[Subject]) -> Vec<FitResult> {
    let fitted = people.iter().filter_map(|subject| {
        let fit = subject.body.fit.as_ref()?;
        let hulls = &subject.body.hulls;
        Some(FitResult {
            subject: subject.name.clone(),
            hulls: hulls.len(),
            points: hulls.iter().map(|hull| hull.points.len()).sum(),
            jaccard: fit.jaccard,
            frontier: fit.frontier.clone(),
        })
    });
    fitted.collect()
}

impl fmt::Display for FitResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: {} hulls of {} points match the mesh with a Jaccard index of {:.4} (in unseen poses and views; by number of points",
            self.subject, self.hulls, self.points, self.jaccard
        )?;
        for (points, jaccard) in &self.frontier {
            write!(f, ", {points}: {jaccard:.4}")?;
        }
        f.write_str(")")
    }
}

/// Reads every file, on all cores, and collects the recordings and the errors, both in the order of
/// files.
fn read_all(
    files: &[PathBuf],
    options: &ReadOptions,
    common: &Common,
) -> Result<(Vec<Recording>, Vec<Error>)> {
    let progress = Progress::new(common, ("importing", "files"), files.len());
    let read: Vec<Result<Recording>> = files
        .par_iter()
        .map(|file| {
            let recording = Recording::read(file, options);
            progress.step()?;
            Ok(recording)
        })
        .collect::<Result<_>>()?;
    let (mut recordings, mut refused) = (Vec::new(), Vec::new());
    for result in read {
        match result {
            Ok(recording) => recordings.push(recording),
            Err(error) => refused.push(error),
        }
    }
    Ok((recordings, refused))
}

/// Returns one row for each file, with the bytes and errors of its cycles.
fn clip_results(
    recordings: &[Recording],
    people: &[Subject],
    bytes: &[u8],
) -> Result<Vec<ClipResult>> {
    let pack = Pack::parse(bytes)?;
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
        let subject = people
            .iter()
            .find(|person| person.name == recording.subject);
        let walks: Vec<&Walk> = subject.map_or_else(Vec::new, |subject| {
            let walks = subject.walks.iter();
            walks.filter(|walk| walk.name == recording.name).collect()
        });
        let skates: Vec<FootSlide> = subject.map_or_else(Vec::new, |subject| {
            let skates = walks.iter().filter_map(|walk| walk.skate(&subject.body));
            skates.collect()
        });
        let travel = Travel::mean(&walks);
        let skates = (!skates.is_empty()).then_some(skates);
        let own = subject.map_or_else(Vec::new, |subject| recording.own_skates(&subject.body));
        let mean = |skates: &[FootSlide]| {
            skates.iter().map(|skate| skate.mean_mm).sum::<f64>() / skates.len() as f64
        };
        let mut warnings = recording.warnings();
        warnings.extend(subject.and_then(|subject| recording.out_of_reach(&subject.body)));
        ClipResult {
            file: recording.path.display().to_string(),
            format: recording.format.to_string(),
            fps: recording.take.sample_rate_hz,
            frames: recording.take.len(),
            low_pass_hz: recording.take.cut_off_hz,
            cycles: cut.map_or(0, |cut| cut.found),
            cadence_spm: cut.map(|cut| cut.cadence_spm),
            speed_mps: travel.map_or_else(|| recording.speed_mps(), |travel| travel.speed_mps),
            stride_m: cut.map(|cut| travel.map_or(cut.stride_m, |travel| travel.stride_m)),
            duty_factor: cut.map(|cut| cut.duty_factor),
            lean_deg: recording.take.lean_deg(),
            residual_mm: recording.take.residual_mm,
            closure_mm: closures.map(|closures| closures.fold(0.0, f64::max)),
            skate_mm: skates.as_deref().map(mean),
            own_skate_mm: (!own.is_empty()).then(|| mean(&own)),
            skate_max_mm: skates.map(|skates| {
                let most = skates.iter().map(|skate| skate.max_mm);
                most.fold(0.0, f64::max)
            }),
            bytes: clips.iter().map(Clip::len_bytes).sum(),
            max_error_mm: most(&mut clips.iter().map(Clip::max_error_mm)),
            mean_error_mm: most(&mut clips.iter().map(Clip::mean_error_mm)),
            warnings,
        }
    });
    Ok(rows.collect())
}

/// The speed of a take on its walker's body, and the length of its strides; of an uncut motion, of
/// the whole.
#[derive(Clone, Copy)]
struct Travel {
    speed_mps: f64,
    stride_m: f64,
}

impl Travel {
    /// Returns the mean over the walks of a take; none without walks.
    fn mean(walks: &[&Walk]) -> Option<Self> {
        let (mut travel_m, mut seconds) = (0.0, 0.0);
        for walk in walks {
            let walk_s = match &walk.motion {
                Track::Loop(cycle) => cycle.period_s,
                Track::Uncut(_) => 1.0,
            };
            travel_m += walk.speed_mps * walk_s;
            seconds += walk_s;
        }
        (!walks.is_empty()).then(|| Self {
            speed_mps: travel_m / seconds,
            stride_m: travel_m / walks.len() as f64,
        })
    }
}

/// Collects the warnings about the files, by their paths.
fn clip_warnings(clips: &[ClipResult]) -> Vec<SharedWarning<'_>> {
    SharedWarning::collect(
        clips
            .iter()
            .map(|clip| (clip.file.as_str(), clip.warnings.as_slice())),
    )
}

/// Formats the results as a table for a terminal.
fn table(results: &ImportResults) -> String {
    let mut table = Table::new(&[Left(32), Left(0), Right(6)]);
    table.row(
        "file|format|fps|frames|cycles|steps/min|m/s|stride|duty|lean°|fit mm|loop mm|skate mm|own skate"
            .split('|'),
    );
    let warnings = clip_warnings(&results.clips);
    for clip in &results.clips {
        table.row([
            with_folder(&clip.file),
            clip.format.clone(),
            format!("{:.1}", clip.fps),
            clip.frames.to_string(),
            clip.cycles.to_string(),
            optional(clip.cadence_spm, 1),
            format!("{:.2}", clip.speed_mps),
            optional(clip.stride_m, 2),
            optional(clip.duty_factor, 2),
            format!("{:.0}", clip.lean_deg),
            format!("{:.1}", clip.residual_mm),
            optional(clip.closure_mm, 0),
            optional(clip.skate_mm, 0),
            optional(clip.own_skate_mm, 0),
        ]);
        let is_own = |one: &&SharedWarning<'_>| !one.is_shared() && one.files[0] == clip.file;
        for own in warnings.iter().filter(is_own) {
            table.note(format!("    warning: {}", own.warning));
        }
    }
    for shared in warnings.iter().filter(|warning| warning.is_shared()) {
        table.note(format!("warning: {shared}"));
    }
    for warning in &results.header.warnings {
        table.note(format!("warning: {warning}"));
    }
    table.note(
        "(lean°: mean forward lean of the trunk; fit mm: distance from the file's joints to ours; loop mm: how far joints were moved to close the cycle;\n\
         skate mm: how far a standing foot slides, mean; own skate: the same in the recording itself)",
    );
    table.to_string()
}

/// Returns a file's name with the name of its folder, which distinguishes takes of several people.
fn with_folder(file: &str) -> String {
    let path = Path::new(file);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    match path.parent().and_then(Path::file_name) {
        Some(folder) => format!("{}/{name}", folder.to_string_lossy()),
        None => name.into_owned(),
    }
}
