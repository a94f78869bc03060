//! `edgegait segment`: segments video frames into silhouettes.

use super::args::{Common, FileArgs};
use super::outputs::{Output, OutputKind};
use super::progress::Progress;
use crate::error::{Result, visible};
use crate::files::ResultHeader;
use crate::report::write_png;
use crate::segment::{
    SegmentSettings, Segmented, Segmenter, SequenceNames, SequenceWriter, Sheet, Video,
    check_replaceable,
};
use rayon::prelude::*;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The maximum number of frames in a sequence that `score` and `train` read.
const MOST_READ: usize = 10_000;

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
    /// Keep all parts that differ from the background, not only the largest
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
    threshold: Range,
    /// Noise of the frames, in LAB.
    noise: Range,
    /// Gains of red, green and blue.
    gain: Range,
    /// Areas of the silhouettes that are not empty, pixels.
    area_px: Range,
    seconds: f64,
    frames_per_second: f64,
}

/// The least, mean and greatest of several numbers; 0 without numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
struct Range {
    least: f64,
    mean: f64,
    greatest: f64,
    #[serde(skip)]
    count: usize,
}

impl Range {
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

/// Runs the subcommand.
pub(super) fn run(args: &SegmentArgs) -> Result<()> {
    let started = Instant::now();
    let names = SequenceNames::new(&args.person, &args.take, &args.view)?;
    check_replaceable(&args.out, &names, args.common.overwrite)?;
    let settings = SegmentSettings {
        largest_part: !args.all_parts,
        closing_px: args.closing_px.into(),
    };
    let mut video = Video::open(&args.frames)?;
    let size = video.size();
    let background = args.background.as_deref();
    let (segmenter, inputs) = Segmenter::open(&args.frames, size, background, settings)?;
    let mut writer = SequenceWriter::new(&args.out, &names)?;
    let mut sheet = args.contact_sheet.as_ref().map(|_| Sheet::default());
    let progress = Progress::new(&args.common, ("segmenting", "frames"), video.frames());
    let (mut frames, mut empty) = (0, 0);
    let [mut threshold, mut noise, mut gain, mut area] = [Range::default(); 4];
    loop {
        let batch = video.batch()?;
        if batch.is_empty() {
            break;
        }
        let segment = |frame| {
            let found = segmenter.segment(frame);
            progress.step()?;
            Ok(found)
        };
        let found: Vec<Segmented> = batch.par_iter().map(segment).collect::<Result<_>>()?;
        let masks: Vec<_> = found.iter().map(|found| &found.mask).collect();
        writer.push(&masks)?;
        for (frame, found) in batch.iter().zip(&found) {
            frames += 1;
            threshold.add(found.threshold);
            noise.add(f64::from(found.noise));
            for of in found.gain {
                gain.add(f64::from(of));
            }
            match found.mask.area() {
                0 => empty += 1,
                pixels => area.add(pixels as f64),
            }
            if let Some(sheet) = &mut sheet {
                sheet.push(frame, &found.mask);
            }
        }
    }
    drop(progress);
    let mut header = ResultHeader::new("segment", args.common.seed)
        .with(
            "background",
            background.map_or("median".into(), |path| path.display().to_string()),
        )
        .with("person", args.person.as_str())
        .with("take", args.take.as_str())
        .with("view", args.view.as_str())
        .with("all_parts", args.all_parts)
        .with("closing_px", args.closing_px);
    let doubts = video.doubts();
    header.inputs.push(video.input()?);
    header.inputs.extend(inputs);
    header.warnings = warnings(frames, empty);
    header.warnings.extend(doubts);
    let folder = writer.finish()?;
    if let (Some(path), Some(picture)) =
        (&args.contact_sheet, sheet.and_then(|sheet| sheet.picture()))
    {
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
        let mut range = Range::default();
        for value in [4.0, -1.0, 6.0] {
            range.add(value);
        }
        assert_eq!((range.least, range.mean, range.greatest), (-1.0, 3.0, 6.0));
    }
}
