//! `edgegait bench --video`: the cost of the whole path from the frames of a video to answers.

use super::{BenchArgs, elsewhere, one_or_all, warn};
use crate::bench::board::{Board, load_of_others};
use crate::bench::{
    BenchResults, CheckedVideo, MADE_FPS, MADE_SIZE, PathResult, PathTask, check, check_model,
    measure_path, write_made,
};
use crate::cli::args::Common;
use crate::cli::progress::Progress;
use crate::cli::trial::try_out;
use crate::dataset::sequences::is_pack_or_folder;
use crate::draw::sweep::{UNCUT_FPS, jobs};
use crate::error::{Error, Result};
use crate::files::{ResultHeader, Staging};
use crate::inference::Model;
use crate::report::write_png;
use crate::segment::{SegmentSettings, Segmenter, Video};
use edgegait_core::pack::Pack;
use std::ffi::OsStr;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::Builder;
use std::time::{Duration, SystemTime};

/// The name that stands for a synthetic video.
const MADE: &str = "made";

/// The flags.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct PathArgs {
    /// Measure the whole path instead, from the frames of a video to answers: "made" for a
    /// synthetic video (a walker of the pack, 320x240, 25 frames a second), or your own: a folder
    /// of frames (.png, .jpg), or a file (Y4M; other formats need an installed ffmpeg)
    #[arg(long, value_name = "made|VIDEO", conflicts_with_all = ["batch", "warm_up", "window_s", "windows", "mlperf", "max_seconds", "frames", "bare", "compare", "views", "azimuth_deg", "elevation_deg"])]
    video: Option<PathBuf>,
    /// The empty scene of the video: a picture, or a folder of several, whose median is used
    /// [default: the median of frames of the video]
    #[arg(long, value_name = "FILE|FOLDER", requires = "video")]
    background: Option<PathBuf>,
    /// Frames a second of the video [default: as the file states, else 25]
    #[arg(long, value_name = "F", requires = "video")]
    fps: Option<f32>,
    /// Minutes to measure; the video is repeated
    #[arg(long, value_name = "M", default_value_t = 1.0, requires = "video", value_parser = minutes)]
    minutes: f64,
    /// Folder with the files that the process with this flag needs
    #[arg(long, value_name = "PATH", hide = true)]
    path_at: Option<PathBuf>,
}

fn minutes(text: &str) -> std::result::Result<f64, String> {
    let found = text.parse().ok();
    let found = found.filter(|minutes: &f64| *minutes > 0.0 && *minutes <= 1440.0);
    found.ok_or_else(|| "expected more than 0 and at most 1440 minutes".to_owned())
}

/// An existing video.
struct GivenVideo {
    video: PathBuf,
    background: Option<PathBuf>,
    fps: f32,
}

impl PathArgs {
    /// Returns whether the path is measured.
    pub(super) const fn is_given(&self) -> bool {
        self.video.is_some()
    }

    /// Returns the folder with the files that this process needs to measure a model alone.
    pub(super) fn at(&self) -> Option<&Path> {
        self.path_at.as_deref()
    }

    /// Returns the files that the measurement reads.
    pub(super) fn files(&self) -> impl Iterator<Item = PathBuf> {
        let video = self.video.iter().filter(|video| !is_made(video));
        video.chain(&self.background).cloned()
    }

    fn duration(&self) -> Duration {
        Duration::from_secs_f64(60.0 * self.minutes)
    }

    /// Opens the requested video: the user's, or the synthetic one in `folder`.
    fn given(&self, folder: &Path) -> Result<(GivenVideo, Video)> {
        let video = self.video.clone().ok_or(Error::Missing("a video"))?;
        if video == Path::new("-") {
            return Err(Error::Usage(
                "--video -: expected a video that can be read repeatedly, found standard input (write it to a file)".into(),
            ));
        }
        let (path, background) = if is_made(&video) {
            (folder.join("frames"), Some(folder.join(BACKGROUND)))
        } else {
            (video, self.background.clone())
        };
        let video = Video::open(&path)?;
        let fps = self.fps.or(video.fps().map(|fps| fps as f32));
        let given = GivenVideo {
            fps: fps.unwrap_or(UNCUT_FPS as f32),
            video: path,
            background,
        };
        Ok((given, video))
    }
}

/// The file name of the background in the folder.
const BACKGROUND: &str = "background.png";

fn is_made(video: &Path) -> bool {
    video == Path::new(MADE)
}

/// Measures the path with each model, in a process of its own.
pub(super) fn run(args: &BenchArgs, models: &[Model], pack: Option<PathBuf>) -> Result<()> {
    let path_args = &args.path;
    let asked = path_args.video.as_deref().unwrap_or(Path::new(MADE));
    args.draw.refuse_for_video()?;
    refuse_flags(args, asked, pack.as_deref())?;
    models.iter().try_for_each(check_model)?;
    let runtime = args.runtime.runtime()?;
    models
        .iter()
        .try_for_each(|model| try_out(model, &runtime))?;
    let root = Path::new("/");
    let load_of_others = load_of_others(root);
    let folder = Staging::temporary()?;
    let mut header = header(args, models, asked).with("runtime", runtime.name().name);
    if is_made(asked) {
        let source_args = args.source(pack);
        let source = source_args.load(&args.common)?;
        let pack = Pack::parse(&source.bytes)?;
        let walks = source_args.choose(&pack)?;
        jobs(&pack, &walks, 0..1)?;
        let walk = *walks.first().ok_or(Error::Missing("a walk"))?;
        write_made(&pack, walk, args.common.seed, folder.path())?;
        header = header.with("pack", source.name);
        header.inputs.extend(source.inputs);
    }
    let (checked, mut inputs) = checked(path_args, folder.path(), &args.common)?;
    if is_made(asked) {
        // Its files are temporary, and follow from pack and seed.
        inputs.clear();
    }
    header.inputs.extend(inputs);
    let mut results = BenchResults {
        header,
        date: humantime::format_rfc3339_seconds(SystemTime::now()).to_string(),
        board: Board::read(root),
        load_of_others,
        models: Vec::new(),
        paths: Vec::new(),
    };
    warn(&mut results);
    let seconds = path_args.duration().as_secs_f64();
    let progress = Progress::new(
        &args.common,
        ("measuring", "seconds"),
        (seconds.ceil() as usize) * models.len(),
    );
    let flags: [&OsStr; 2] = ["--path-at".as_ref(), folder.path().as_os_str()];
    for (index, model) in models.iter().enumerate() {
        let measured: PathResult = ticking(&progress, seconds, || {
            elsewhere(args, model, index, &flags, &|_| Ok(()))
        })?;
        let measured = PathResult {
            video: checked.clone(),
            ..measured
        };
        results.header.warnings.extend(
            measured
                .warnings
                .iter()
                .map(|warning| format!("{}: {warning}", measured.name)),
        );
        results.paths.push(measured);
    }
    drop(progress);
    args.show(&results)
}

/// Measures the path with one model in this process.
pub(super) fn alone(
    args: &BenchArgs,
    open: &dyn Fn() -> Result<Model>,
    folder: &Path,
) -> Result<PathResult> {
    let (given, video) = args.path.given(folder)?;
    drop(video);
    measure_path(&PathTask {
        open,
        start: &|| args.runtime.runtime(),
        threads: args.common.one_thread_count()?.unwrap_or(1),
        video: &given.video,
        background: &folder.join(BACKGROUND),
        fps: given.fps,
        duration: args.path.duration(),
        root: Path::new("/"),
    })
}

/// Segments the video once, and writes its background into the folder.
fn checked(
    args: &PathArgs,
    folder: &Path,
    common: &Common,
) -> Result<(CheckedVideo, Vec<crate::files::InputFile>)> {
    let (given, video) = args.given(folder)?;
    let background = given.background.as_deref();
    let settings = SegmentSettings::default();
    let (segmenter, mut inputs) =
        Segmenter::open(&given.video, video.size(), background, settings)?;
    let progress = Progress::new(common, ("reading", "frames"), video.frames());
    let path = args.video.as_deref().unwrap_or(Path::new(MADE));
    let (checked, input) = check(video, path, given.fps, &segmenter, &|| progress.step())?;
    inputs.insert(0, input);
    write_png(folder.join(BACKGROUND), segmenter.background())?;
    Ok((checked, inputs))
}

/// Rejects flags that have no meaning with this video.
fn refuse_flags(args: &BenchArgs, video: &Path, pack: Option<&Path>) -> Result<()> {
    if let Some(folder) = pack.filter(|path| path.is_dir()) {
        return Err(Error::input(
            folder,
            "expected a pack with a walker to draw, found a folder (if it is the video, name it after --video)",
        ));
    }
    let path = &args.path;
    let selection = &args.selection;
    let flags: &[(&str, bool)] = if is_made(video) {
        &[
            ("--background", path.background.is_some()),
            ("--fps", path.fps.is_some_and(|fps| fps != MADE_FPS)),
        ]
    } else {
        &[
            ("PACK", pack.is_some()),
            ("--subjects", !selection.subjects.is_empty()),
            ("--walks", !selection.walks.is_empty()),
        ]
    };
    if let Some((flag, _)) = flags.iter().find(|(_, is_given)| *is_given) {
        let found = if is_made(video) {
            "the synthetic one, which has its own"
        } else {
            "one with its own walker"
        };
        return Err(Error::Usage(format!(
            "{flag}: does not apply to this video, {found}"
        )));
    }
    if !is_made(video) && video.is_file() && is_pack_or_folder(video)? {
        return Err(Error::input(video, "expected a video, found a pack"));
    }
    Ok(())
}

/// Returns a header with the requested settings.
fn header(args: &BenchArgs, models: &[Model], video: &Path) -> ResultHeader {
    let path = &args.path;
    let mut header = ResultHeader::new("bench", args.common.seed)
        .with("video", video.display().to_string())
        .with("minutes", path.minutes)
        .with("threads", one_or_all(args.threads()))
        .with("path_threads", 1)
        .with(
            "cycles",
            "while frames come in; the video is one recording, again and again",
        )
        .with(
            "timed",
            "decode, segment, framing, cycle, template, network",
        )
        .with(
            "not_timed",
            "load, background, frames until the first answer, reading the machine between windows",
        )
        .with("build", super::build());
    if is_made(video) {
        let (columns, rows) = MADE_SIZE;
        header = header.with("made", format!("{columns}x{rows} at {MADE_FPS}, JPEG"));
    }
    if let Some(background) = &path.background {
        header = header.with("background", background.display().to_string());
    }
    if let Some(cpus) = &args.cpus {
        header = header.with("cpus", cpus.to_string());
    }
    header.inputs = models.iter().map(Model::input).collect();
    header
}

/// Does the work, and counts the expected seconds in the meantime.
fn ticking<T>(progress: &Progress, seconds: f64, work: impl FnOnce() -> Result<T>) -> Result<T> {
    let expected = seconds.ceil() as usize;
    std::thread::scope(|scope| {
        let (done, is_done) = channel::<()>();
        let ticks = move || -> Result<()> {
            let mut left = expected;
            while is_done.recv_timeout(Duration::from_secs(1)) == Err(RecvTimeoutError::Timeout) {
                if left > 0 {
                    left -= 1;
                    progress.step()?;
                }
            }
            (0..left).try_for_each(|_| progress.step())
        };
        let ticks = Builder::new().spawn_scoped(scope, ticks);
        let ticks = ticks.map_err(Error::Threads)?;
        let found = work();
        drop(done);
        ticks.join().unwrap_or_else(|panic| resume_unwind(panic))?;
        found
    })
}
