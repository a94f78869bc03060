//! `edgegait render`: look at one walk.

use super::args::{Common, DrawArgs, ViewArgs};
use super::source::SourceArgs;
use crate::dataset::{COLUMNS, Header, Pixels, ROWS, write_npy};
use crate::error::{Error, Result};
use crate::report::{contact_sheet, write_png};
use crate::sweep::{Job, View, silhouettes};
use clap::ValueEnum;
use edgegait_core::pack::Pack;
use edgegait_core::silhouette::{Frame, Silhouette};
use edgegait_core::template::GeiBuilder;
use ndarray::{ArrayView3, ArrayView4};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Render silhouettes or templates of walks: text art, a PNG contact sheet, or npy
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait render                          # text art of the first person\n  edgegait render --views side --out walk.png\n  edgegait render cohort.egp --subjects M03 --walks run-10kmh --azimuth-deg 0,45,90 --out run.npy"
)]
pub struct Args {
    #[command(flatten)]
    source: SourceArgs,
    /// Where to write: .png (a row for each walk and viewpoint and a column for each frame; of
    /// templates a row for each walk and a column for each viewpoint) or .npy (one walk: u8
    /// [T,50,30], [V,T,50,30] for several viewpoints, [V,50,30] for templates)
    /// [default: text art on the terminal]
    #[arg(long, value_name = "PATH")]
    out: Option<PathBuf>,
    /// Which variation of the stored cycle; 0 is the cycle itself
    #[arg(long, value_name = "N", default_value_t = 0)]
    cycle: u32,
    /// Average the cycle into a template
    #[arg(long, value_name = "NAME")]
    template: Option<Template>,
    /// Pixels of the PNG for each pixel of a silhouette
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=16))]
    scale: u32,
    #[command(flatten)]
    views: ViewArgs,
    #[command(flatten)]
    draw: DrawArgs,
    #[command(flatten)]
    pub common: Common,
}

/// Names of the templates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Template {
    /// Gait Energy Image
    Gei,
}

/// Where the rendered goes.
enum Output<'a> {
    Terminal,
    Png(&'a Path),
    Npy(&'a Path),
}

impl Args {
    /// Where to write, refused before anything is drawn if it makes no sense.
    fn output(&self) -> Result<Output<'_>> {
        match self.out.as_deref() {
            None if self.template.is_some() => Err(Error::Usage(
                "--template needs --out: a template is grey, and text art is not".into(),
            )),
            None => Ok(Output::Terminal),
            Some(path) if has_extension(path, "png") => Ok(Output::Png(path)),
            Some(path) if has_extension(path, "npy") => Ok(Output::Npy(path)),
            Some(path) => Err(Error::Usage(format!(
                "--out {}: expected a name that ends in .png or .npy",
                path.display()
            ))),
        }
    }
}

/// What was rendered.
#[derive(Serialize)]
struct Rendered {
    #[serde(flatten)]
    header: Header,
    out: Option<String>,
    walks: usize,
    viewpoints: usize,
    silhouettes: usize,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let output = args.output()?;
    let views = args.views.views("side")?;
    let source = args.source.load()?;
    let pack = Pack::parse(&source.bytes).map_err(|error| Error::Failed(error.to_string()))?;
    let mut walks = args.source.choose(&pack)?;
    if args.source.subjects.is_empty() && args.source.walks.is_empty() {
        walks.truncate(1);
    } else if walks.len() > 1 && !matches!(output, Output::Png(_)) {
        return Err(Error::Usage(format!(
            "{} walks are chosen: expected one, or --out with a .png (--subjects and --walks choose)",
            walks.len()
        )));
    }
    let settings = args.draw.settings(args.common.seed);
    let mut frames: Vec<Vec<Frame>> = Vec::new();
    for &walk in &walks {
        let job = Job {
            walk,
            cycle: args.cycle,
        };
        frames.extend(silhouettes(&pack, job, &views.list, settings)?);
    }
    let rows: Vec<Vec<Pixels>> = match args.template {
        None => frames
            .iter()
            .map(|frames| frames.iter().map(Frame::to_pixels).collect())
            .collect(),
        Some(Template::Gei) => frames
            .chunks(views.list.len())
            .map(|views| views.iter().map(|frames| gei(frames)).collect())
            .collect(),
    };
    match &output {
        Output::Terminal => args
            .common
            .say(text_art(&pack, &walks, &views.list, &frames)),
        Output::Png(path) => write_png(path, &contact_sheet(&rows, args.scale)?)?,
        Output::Npy(path) => write_array(path, &rows)?,
    }
    if let Some(path) = &args.out {
        args.common.say(format_args!("wrote {}", path.display()));
    }
    let mut header = args
        .draw
        .describe(Header::new("render", args.common.seed))
        .with("cycle", args.cycle)
        .with("pack", source.name.as_str())
        .with("views", views.name.as_str())
        .with("subjects", args.source.subjects.join(","))
        .with("walks", args.source.walks.join(","))
        .with("template", args.template.map(|_| "gei"));
    header.inputs = source.inputs;
    args.common.write_json(&Rendered {
        header,
        out: args.out.as_ref().map(|path| path.display().to_string()),
        walks: walks.len(),
        viewpoints: views.list.len(),
        silhouettes: frames.iter().map(Vec::len).sum(),
    })
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension()
        .is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

/// The GEI of a cycle's frames.
fn gei(frames: &[Frame]) -> Pixels {
    let mut builder = GeiBuilder::new();
    for frame in frames {
        builder.add(frame);
    }
    builder.finish().pixels
}

/// Writes rows of frames as `[V,T,50,30]`, and a single row as `[T,50,30]`.
fn write_array(path: &Path, rows: &[Vec<Pixels>]) -> Result<()> {
    let bytes = rows.concat().concat();
    let (views, frames) = (rows.len(), rows.first().map_or(0, Vec::len));
    let shape = |error: ndarray::ShapeError| Error::Failed(error.to_string());
    if views == 1 {
        let array = ArrayView3::from_shape((frames, ROWS, COLUMNS), &bytes).map_err(shape)?;
        write_npy(path, &array)
    } else {
        let array =
            ArrayView4::from_shape((views, frames, ROWS, COLUMNS), &bytes).map_err(shape)?;
        write_npy(path, &array)
    }
}

/// Two frames of the first view side by side, two rows of pixels a line.
fn text_art(pack: &Pack<'_>, walks: &[usize], views: &[View], frames: &[Vec<Frame>]) -> String {
    let mut text = String::new();
    let walk = walks.first().and_then(|&index| pack.walks().nth(index));
    let (Some(walk), Some(view), Some(frames)) = (walk, views.first(), frames.first()) else {
        return text;
    };
    let subject = pack
        .subject(walk.subject)
        .map_or("", |subject| subject.name);
    let shown = [0, frames.len() / 4].map(|index| frames[index].silhouette());
    let _ = writeln!(
        text,
        "{subject}, {}, azimuth {}, elevation {} degrees; phases 0 and 0.25",
        walk.name, view.azimuth_deg, view.elevation_deg
    );
    for row in (0..ROWS).step_by(2) {
        let line = shown.map(|silhouette| half_blocks(&silhouette, row));
        let _ = writeln!(text, "{}", line.join("    ").trim_end());
    }
    text
}

/// Two rows of pixels as one line of half blocks.
fn half_blocks(silhouette: &Silhouette, row: usize) -> String {
    (0..COLUMNS)
        .map(|column| {
            match (
                silhouette.is_on(row, column),
                silhouette.is_on(row + 1, column),
            ) {
                (true, true) => '█',
                (true, false) => '▀',
                (false, true) => '▄',
                (false, false) => ' ',
            }
        })
        .collect()
}
