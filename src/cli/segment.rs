//! `edgegait segment`: segments video frames into silhouettes.

use super::args::{Common, FileArgs};
use super::outputs::{Output, OutputKind};
use super::progress::Progress;
use crate::error::{Error, Result, visible};
use crate::files::ResultHeader;
use crate::report::write_png;
use crate::segment::{
    FollowedFigure, Follower, Mask, Part, SegmentSettings, Segmented, Segmenter, SequenceNames,
    SequenceWriter, Sheet, Video, check_replaceable, warning,
};
use rayon::prelude::*;
use serde::Serialize;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The maximum number of frames in a sequence that `score` and `train` read.
const MOST_READ: usize = 10_000;
/// The least number of frames in which a walker is seen; half of a shorter video.
const LEAST_SEEN: usize = 10;
/// The number of silhouettes that are written at a time.
const WRITTEN: usize = 64;

/// Segment a video of one walker into silhouettes, by background subtraction in LAB and two
/// clusters of differences
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait segment frames --out silhouettes --contact-sheet look.png\n  edgegait segment walk.mp4 --background empty.png --out silhouettes --person 007 --take bg-01 --view 054\n  ffmpeg -i walk.mp4 -f yuv4mpegpipe - | edgegait segment - --background empty --out silhouettes --person 008"
)]
pub(super) struct SegmentArgs {
    /// A folder of frames (.png, .jpg), a video (Y4M; other formats need an installed ffmpeg), or
    /// "-": Y4M on standard input, which needs --background
    #[arg(value_name = "FRAMES")]
    frames: PathBuf,
    /// Tree to write into, as <person>/<take>/<view>/<person>-<take>-<view>-<NNN>.png
    #[arg(long, value_name = "TREE")]
    out: PathBuf,
    /// The empty scene: a picture, or a folder of several, whose median is used
    /// [default: the median of frames of the video, at least 10]
    #[arg(long, value_name = "FILE|FOLDER")]
    background: Option<PathBuf>,
    /// Name of the person
    #[arg(long, value_name = "P", default_value = "001")]
    person: String,
    /// Name of the take: the kind of walk, and a number
    #[arg(long, value_name = "T", default_value = "nm-01")]
    take: String,
    /// Viewpoint: the azimuth in degrees, and the elevation if it is not 0, as in 090e15
    #[arg(long, value_name = "V", default_value = "090")]
    view: String,
    /// Follow this one of several walkers, as the error that asks for it numbers them
    #[arg(long, value_name = "N", conflicts_with = "all_parts", value_parser = clap::value_parser!(u16).range(1..))]
    walker: Option<u16>,
    /// Look only into this rectangle of the picture, pixels from its upper left corner
    #[arg(long, value_name = "X,Y,WIDTH,HEIGHT", value_parser = rectangle)]
    region: Option<[u32; 4]>,
    /// Use only frames A to B-1, counted from 0
    #[arg(long = "frames", value_name = "A..B", value_parser = frame_range)]
    span: Option<Range<usize>>,
    /// Keep all parts that differ from the background, and follow nobody
    #[arg(long)]
    all_parts: bool,
    /// Half the side of the square that closes gaps, pixels; 0 closes none
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(0..=32))]
    closing_px: u8,
    /// Write an image of at most 32 frames with the outlines of their silhouettes
    #[arg(long, value_name = "FILE.png")]
    contact_sheet: Option<PathBuf>,
    #[command(flatten)]
    pub common: Common,
}

#[derive(Serialize)]
struct SegmentResults {
    #[serde(flatten)]
    header: ResultHeader,
    out: String,
    columns: u32,
    rows: u32,
    frames: usize,
    empty_frames: usize,
    /// Thresholds of the frames, in LAB.
    threshold: Spread,
    /// Noise of the frames, in LAB.
    noise: Spread,
    /// Gains of red, green and blue.
    gain: Spread,
    /// Areas of the silhouettes that are not empty, pixels.
    area_px: Spread,
    /// The figures that were followed, the walker first.
    walkers: Vec<WalkerFound>,
    seconds: f64,
    frames_per_second: f64,
}

/// The least, mean and greatest of several numbers; 0 without numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
struct Spread {
    least: f64,
    mean: f64,
    greatest: f64,
    #[serde(skip)]
    count: usize,
}

impl Spread {
    fn add(&mut self, value: f64) {
        if self.count == 0 {
            (self.least, self.greatest) = (value, value);
        }
        self.count += 1;
        self.least = self.least.min(value);
        self.greatest = self.greatest.max(value);
        self.mean += (value - self.mean) / self.count as f64;
    }
}

impl SegmentArgs {
    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        let folder = self
            .out
            .join(&self.person)
            .join(&self.take)
            .join(&self.view);
        let mut outputs = vec![Output::new("--out", &folder, OutputKind::Sequence)];
        if let Some(path) = &self.contact_sheet {
            outputs.push(Output::new("--contact-sheet", path, OutputKind::Png));
        }
        let video = (self.frames != Path::new("-")).then(|| self.frames.clone());
        FileArgs {
            inputs: video.into_iter().chain(self.background.clone()).collect(),
            outputs,
        }
    }
}

/// A figure that was followed, in the results.
#[derive(Clone, Debug, Serialize)]
struct WalkerFound {
    /// Its first frame, and the one after its last; the first frame of all is 0.
    frames: [usize; 2],
    /// Number of frames in which it is seen.
    seen: usize,
    /// Whether it moves on.
    moves: bool,
    /// Mean area, pixels.
    area_px: usize,
}

impl WalkerFound {
    fn of(track: &FollowedFigure) -> Self {
        Self {
            frames: [track.first, track.end()],
            seen: track.frames(),
            moves: track.moves(),
            area_px: track.total() / track.frames().max(1),
        }
    }
}

/// Returns the figures that may be the walker: those that are seen for long enough and are at least
/// half as large in sum as the largest; only those that move, if one does.
fn candidates(tracks: &[FollowedFigure], frames: usize) -> Vec<&FollowedFigure> {
    let least = LEAST_SEEN.min(frames.div_ceil(2));
    let mut long: Vec<&FollowedFigure> = { tracks.iter() }
        .filter(|track| track.frames() >= least)
        .collect();
    if let Some(first) = long.first() {
        let (moves, most) = (first.moves(), first.total());
        long.retain(|track| track.moves() == moves && 2 * track.total() >= most);
    }
    long
}

impl SegmentArgs {
    /// Returns the walker among the candidates; none if there is none.
    ///
    /// # Errors
    /// If there are several, of which none was chosen, or the chosen one is not there.
    fn chosen<'t>(&self, candidates: &[&'t FollowedFigure]) -> Result<Option<&'t FollowedFigure>> {
        let count = candidates.len();
        let refuse = |problem| Err(Error::input(&self.frames, problem));
        match self.walker {
            None if count > 1 => {
                let each = candidates.iter().zip(1..).map(|(track, number)| {
                    let last = track.end().saturating_sub(1);
                    format!("{number} in frames {} to {last}", track.first)
                });
                let each = each.collect::<Vec<_>>().join(", ");
                refuse(format!(
                    "expected one walker, found {count}: {each} (choose one with --walker N, --frames A..B or --region)"
                ))
            }
            None => Ok(candidates.first().copied()),
            Some(number) => match candidates.get(usize::from(number) - 1) {
                Some(track) => Ok(Some(track)),
                None => refuse(format!("--walker {number}: expected 1 to {count}")),
            },
        }
    }

    /// Returns the region of the picture, if one is given.
    ///
    /// # Errors
    /// If it is empty or reaches out of the picture.
    fn region(&self, (columns, rows): (u32, u32)) -> Result<Option<Region>> {
        let Some([left, top, width, height]) = self.region else {
            return Ok(None);
        };
        let is_in = |from: u32, length: u32, all: u32| {
            length > 0 && from.checked_add(length).is_some_and(|end| end <= all)
        };
        if !is_in(left, width, columns) || !is_in(top, height, rows) {
            return Err(Error::Usage(format!(
                "--region {left},{top},{width},{height}: expected a rectangle within {columns}x{rows} pixels"
            )));
        }
        Ok(Some(Region {
            columns: left as usize..(left + width) as usize,
            rows: top as usize..(top + height) as usize,
        }))
    }
}

/// A rectangle of a picture.
struct Region {
    columns: Range<usize>,
    rows: Range<usize>,
}

impl Region {
    /// Returns a mask without what lies outside.
    fn of(&self, mask: &Mask) -> Mask {
        let columns = mask.columns();
        let is_in = |at: usize| {
            self.columns.contains(&(at % columns)) && self.rows.contains(&(at / columns))
        };
        let pixels = mask.pixels().iter().enumerate();
        Mask::new(columns, pixels.map(|(at, on)| *on && is_in(at)).collect())
    }
}

/// Parses a rectangle.
fn rectangle(text: &str) -> std::result::Result<[u32; 4], String> {
    let numbers = text.split(',').map(|part| part.trim().parse().ok());
    let numbers: Option<Vec<u32>> = numbers.collect();
    { numbers.and_then(|numbers| numbers.try_into().ok()) }
        .ok_or_else(|| "expected X,Y,WIDTH,HEIGHT in pixels, as in 0,40,640,360".to_owned())
}

/// Parses a range of frames.
fn frame_range(text: &str) -> std::result::Result<Range<usize>, String> {
    let ends = text
        .split_once("..")
        .and_then(|(from, to)| Some(from.parse().ok()?..to.parse().ok()?));
    ends.filter(|span| !span.is_empty())
        .ok_or_else(|| "expected A..B, for frames A to B-1, as in 30..120".to_owned())
}

/// Runs the subcommand.
pub(super) fn run(args: &SegmentArgs) -> Result<()> {
    let started = Instant::now();
    let names = SequenceNames::new(&args.person, &args.take, &args.view)?;
    check_replaceable(&args.out, &names, args.common.overwrite)?;
    // All parts, of which those of the walker are chosen when all frames are known.
    let settings = SegmentSettings {
        largest_part: false,
        closing_px: args.closing_px.into(),
    };
    let mut video = Video::open(&args.frames)?;
    let size = video.size();
    let background = args.background.as_deref();
    let (segmenter, inputs) = Segmenter::open(&args.frames, size, background, settings)?;
    let mut writer = SequenceWriter::new(&args.out, &names)?;
    let region = args.region(size)?;
    let mut sheet = args.contact_sheet.as_ref().map(|_| Sheet::default());
    let progress = Progress::new(&args.common, ("segmenting", "frames"), video.frames());
    let span = args.span.clone().unwrap_or(0..usize::MAX);
    let (mut read, mut frames) = (0, 0);
    let [mut threshold, mut noise, mut gain, mut area] = [Spread::default(); 4];
    let mut follower = Follower::default();
    let mut elsewhere = Vec::new();
    while read < span.end {
        let mut batch = video.batch()?;
        if batch.is_empty() {
            break;
        }
        let first = read;
        read += batch.len();
        batch.truncate(span.end.saturating_sub(first));
        batch.drain(..span.start.saturating_sub(first).min(batch.len()));
        let segment = |frame| {
            let mut found = segmenter.segment(frame);
            if let Some(region) = &region {
                found.mask = region.of(&found.mask);
            }
            let parts = Segmenter::parts(&found);
            progress.step()?;
            Ok((found, parts))
        };
        let found: Vec<(Segmented, Vec<Part>)> =
            batch.par_iter().map(segment).collect::<Result<_>>()?;
        for (frame, (found, parts)) in batch.iter().zip(found) {
            frames += 1;
            threshold.add(found.threshold);
            noise.add(f64::from(found.noise));
            if found.is_elsewhere {
                elsewhere.push(frames - 1);
            }
            for of in found.gain {
                gain.add(f64::from(of));
            }
            if args.all_parts {
                follower.push_whole(parts);
            } else {
                follower.push(parts, segmenter.least_area());
            }
            if let Some(sheet) = &mut sheet {
                sheet.push(frame);
            }
        }
    }
    drop(progress);
    if frames == 0 {
        return Err(Error::Usage(format!(
            "--frames {}..{}: the video has {read} frames",
            span.start, span.end
        )));
    }
    let moved = warning(
        &elsewhere,
        span.start,
        "show another place than the background (the camera moves, or the video is cut)",
    );
    if let Some(moved) = moved.as_ref().filter(|_| 2 * elsewhere.len() > frames) {
        let expected = "expected a camera that stands still before the scene of the background";
        return Err(Error::input(
            &args.frames,
            format!(
                "{expected}, found that {moved} (use --frames A..B for a part, or masks of a segmentation network)"
            ),
        ));
    }
    let shape = (size.0 as usize, size.1 as usize);
    let tracks = follower.finish();
    let candidates = candidates(&tracks, frames);
    let mut track = args.chosen(&candidates)?.cloned();
    if let Some(track) = track.as_mut().filter(|_| !args.all_parts) {
        let columns = region.as_ref().map(|region| region.columns.clone());
        track.leave_out_cut(&columns.unwrap_or(0..shape.0));
    }
    let none = || Mask::new(shape.0, vec![false; shape.0 * shape.1]);
    let mask =
        |frame: usize| { track.as_ref() }.map_or_else(none, |track| track.mask(frame, shape));
    let mut empty = 0;
    for first in (0..frames).step_by(WRITTEN) {
        let masks: Vec<Mask> = (first..frames.min(first + WRITTEN)).map(mask).collect();
        for mask in &masks {
            match mask.area() {
                0 => empty += 1,
                pixels => area.add(pixels as f64),
            }
        }
        writer.push(&masks.iter().collect::<Vec<_>>())?;
    }
    let mut header = ResultHeader::new("segment", args.common.seed)
        .with(
            "background",
            background.map_or("median".into(), |path| path.display().to_string()),
        )
        .with("person", args.person.as_str())
        .with("take", args.take.as_str())
        .with("view", args.view.as_str())
        .with("all_parts", args.all_parts)
        .with("walker", args.walker)
        .with("region", args.region)
        .with(
            "frames",
            args.span.as_ref().map(|span| [span.start, span.end]),
        )
        .with("closing_px", args.closing_px);
    let doubts = video.doubts();
    header.inputs.push(video.input()?);
    header.inputs.extend(inputs);
    header.warnings = warnings(frames, empty);
    header.warnings.extend(moved);
    let doubts_of = |track: &FollowedFigure| track.doubts(span.start);
    header.warnings.extend(track.iter().flat_map(doubts_of));
    header.warnings.extend(doubts);
    let folder = writer.finish()?;
    if let (Some(path), Some(picture)) = (
        &args.contact_sheet,
        sheet.and_then(|sheet| sheet.picture(mask)),
    ) {
        write_png(path, &picture)?;
    }
    let seconds = started.elapsed().as_secs_f64();
    for warning in header.warnings.iter().filter(|_| !args.common.quiet) {
        eprintln!("warning: {}", visible(warning));
    }
    args.common.say(format_args!(
        "wrote {}: {frames} silhouettes of {}x{} pixels, {empty} of them empty; {:.0} pixels on average; {:.0} frames a second",
        folder.display(),
        size.0,
        size.1,
        area.mean,
        frames as f64 / seconds
    ));
    if let Some(path) = &args.contact_sheet {
        args.common.say(format_args!("wrote {}", path.display()));
    }
    args.common.write_json(&SegmentResults {
        header,
        out: folder.display().to_string(),
        columns: size.0,
        rows: size.1,
        frames,
        empty_frames: empty,
        threshold,
        noise,
        gain,
        area_px: area,
        walkers: candidates.into_iter().map(WalkerFound::of).collect(),
        seconds,
        frames_per_second: frames as f64 / seconds,
    })
}

/// Returns warnings about a sequence with this number of frames.
fn warnings(frames: usize, empty: usize) -> Vec<String> {
    let mut warnings = Vec::new();
    if empty == frames {
        warnings.push("nobody was found in any frame".to_owned());
    }
    if frames > MOST_READ {
        warnings.push(format!(
            "score and train read sequences of at most {MOST_READ} frames, found {frames} (cut the video)"
        ));
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_of_all_numbers() {
        let mut range = Spread::default();
        for value in [4.0, -1.0, 6.0] {
            range.add(value);
        }
        assert_eq!((range.least, range.mean, range.greatest), (-1.0, 3.0, 6.0));
    }
}
