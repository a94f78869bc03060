//! `edgegait render`: draws walks to look at.

use super::args::{Common, FileArgs, ViewArgs};
use super::conditions::ConditionArgs;
use super::drawing::DrawArgs;
use super::outputs::{Output, OutputKind};
use super::walks::SourceArgs;
use crate::dataset::write_npy;
use crate::draw::sweep::{Job, Moments, Settings, Shot, is_uncut, silhouettes, walk_name};
use crate::draw::template::{Builder, Template, TemplateShape};
use crate::error::{Error, Result};
use crate::files::ResultHeader;
use crate::report::{cells, contact_sheet, write_png};
#[cfg(feature = "plots")]
use crate::report::{condition_gallery, template_gallery};
use edgegait_core::pack::Pack;
use edgegait_core::silhouette::{AnySilhouette, Silhouette, Size};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Render silhouettes or templates of walks: text art, a PNG contact sheet, or npy
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait render                          # text art of the first person\n  edgegait render --views side --out walk.png\n  edgegait render cohort.egp --subjects M03 --walks run-10kmh --azimuth-deg 0,45,90 --out run.npy\n  edgegait render turn.egp --start-s 1.5 --fps 25 --frames 50 --out turn.png\n  edgegait render --template gei,mei,mhi,msi,ghi,geni,frequency,kfd,row-width --out templates.png"
)]
pub(super) struct RenderArgs {
    #[command(flatten)]
    source: SourceArgs,
    /// File to write. A .png has a row for each walk, condition and viewpoint, and a column for
    /// each frame; with one template, a row for each walk and condition, and a column for each
    /// viewpoint; with several, a column for each template, three for frequency, and bars for
    /// vectors. A .npy has one walk: u8 [T,50,30]; [V,T,50,30] for several viewpoints or conditions
    /// (the viewpoints of each condition in turn); [V,50,30] for a template, [V,150,30] for
    /// frequency, [V,D] for vectors; --size changes 50 and 30 [default: text art on the terminal]
    #[arg(long, value_name = "PATH")]
    out: Option<PathBuf>,
    /// Variation of the stored cycle; 0 is the cycle itself
    #[arg(long, value_name = "N", default_value_t = 0)]
    cycle: u32,
    /// Time of the first frame, seconds from the clip's first frame
    #[arg(
        long,
        value_name = "S",
        requires = "fps",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    start_s: f64,
    /// Frames a second, instead of --frames-per-cycle
    #[arg(
        long,
        value_name = "F",
        requires = "frames",
        conflicts_with = "frames_per_cycle"
    )]
    fps: Option<f64>,
    /// Number of frames, with --fps
    #[arg(long, value_name = "N", requires = "fps", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: Option<u32>,
    /// Write a labelled figure from one viewpoint: for each walk and condition, the camera's image,
    /// a silhouette and the GEI; with --template, the first walk in each template
    #[arg(long, requires = "out", conflicts_with_all = ["fps", "scale"])]
    gallery: bool,
    /// Side of a silhouette's pixel in the PNG, in pixels
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=16))]
    scale: u32,
    #[command(flatten)]
    conditions: ConditionArgs,
    #[command(flatten)]
    views: ViewArgs,
    #[command(flatten)]
    draw: DrawArgs,
    #[command(flatten)]
    pub common: Common,
}

/// The destination of the images.
enum RenderTarget<'a> {
    Terminal,
    Png(&'a Path),
    Npy(&'a Path),
}

impl RenderArgs {
    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        let (pack, conditions) = (self.source.pack.clone(), self.conditions.file());
        let inputs = pack.into_iter().chain(conditions).chain(self.views.file());
        let output = self.out.as_deref().and_then(|path| {
            let kinds = [("png", OutputKind::Png), ("npy", OutputKind::Npy)];
            let known = kinds.iter().find(|kind| has_extension(path, kind.0));
            known.map(|&(_, kind)| Output::new("--out", path, kind))
        });
        FileArgs {
            inputs: inputs.collect(),
            outputs: output.into_iter().collect(),
        }
    }

    /// Returns the times at which the walks are drawn.
    fn moments(&self) -> Result<Moments> {
        let (Some(fps), Some(frames)) = (self.fps, self.frames) else {
            return Ok(Moments::Cycle);
        };
        if !(fps > 0.0 && fps <= 1e6) {
            return Err(Error::Usage(format!(
                "--fps {fps}: expected more than 0, at most 1,000,000"
            )));
        }
        if !(0.0..=1e6).contains(&self.start_s) {
            return Err(Error::Usage(format!(
                "--start-s {}: expected 0 to 1,000,000 seconds",
                self.start_s
            )));
        }
        Ok(Moments::Seconds {
            start_s: self.start_s,
            fps,
            frames,
        })
    }

    /// Returns the templates to make from each cycle; none for silhouettes.
    fn templates(&self) -> Result<&[Template]> {
        let templates = self.draw.template.as_slice();
        if templates == [Template::Silhouettes] {
            return Ok(&[]);
        }
        if templates.contains(&Template::Silhouettes) {
            return Err(Error::Usage(
                "--template silhouettes: expected it alone, found other templates too".into(),
            ));
        }
        if !templates.is_empty() && self.fps.is_some() {
            return Err(Error::Usage(
                "--template: a template needs a whole cycle, which --fps does not draw".into(),
            ));
        }
        Ok(templates)
    }

    /// Returns the walks to draw.
    fn walks(
        &self,
        pack: &Pack<'_>,
        target: &RenderTarget<'_>,
        moments: Moments,
    ) -> Result<Vec<usize>> {
        let mut walks = self.source.choose(pack)?;
        if self.source.selection.subjects.is_empty() && self.source.selection.walks.is_empty() {
            walks.truncate(1);
        } else if walks.len() > 1 && !matches!(target, RenderTarget::Png(_)) {
            return Err(Error::Usage(format!(
                "{} walks are chosen: expected one, or --out with a .png (choose with --subjects and --walks)",
                walks.len()
            )));
        }
        let take = walks.iter().copied().find(|&walk| is_uncut(pack, walk));
        if let (Moments::Cycle, Some(take)) = (moments, take) {
            return Err(Error::Usage(format!(
                "{} is an uncut motion, not a cycle: choose its frames with --fps F --frames N, and --start-s S for a later start",
                walk_name(pack, take)
            )));
        }
        for &walk in &walks {
            refuse_beyond(pack, walk, moments)?;
        }
        Ok(walks)
    }

    /// Returns the destination, after checking it.
    fn target(&self, templates: &[Template]) -> Result<RenderTarget<'_>> {
        match self.out.as_deref() {
            None if !templates.is_empty() => Err(Error::Usage(
                "--template needs --out: a template is grey, and text art is not".into(),
            )),
            None => Ok(RenderTarget::Terminal),
            Some(path) if has_extension(path, "png") => Ok(RenderTarget::Png(path)),
            Some(path) if has_extension(path, "npy") && templates.len() > 1 => {
                Err(Error::Usage(format!(
                    "--out {}: a .npy holds one template, found {} (use .png, or one --template)",
                    path.display(),
                    templates.len()
                )))
            }
            Some(path) if has_extension(path, "npy") => Ok(RenderTarget::Npy(path)),
            Some(path) => Err(Error::Usage(format!(
                "--out {}: expected a name that ends in .png or .npy",
                path.display()
            ))),
        }
    }
}

/// The results of the command.
#[derive(Serialize)]
struct Rendered {
    #[serde(flatten)]
    header: ResultHeader,
    out: Option<String>,
    walks: usize,
    viewpoints: usize,
    silhouettes: usize,
}

/// Runs the subcommand.
pub(super) fn run(args: &RenderArgs) -> Result<()> {
    let templates = args.templates()?;
    let target = args.target(templates)?;
    let moments = args.moments()?;
    let views = args.views.views("side")?;
    if args.gallery && (views.list.len() > 1 || !matches!(target, RenderTarget::Png(_))) {
        return Err(Error::Usage(
            "--gallery: expected one viewpoint and an --out that ends in .png".into(),
        ));
    }
    if args.gallery && cfg!(not(feature = "plots")) {
        return Err(Error::Usage(
            "--gallery: this command was built without the feature plots".into(),
        ));
    }
    let settings = args.draw.without_template().settings(args.common.seed)?;
    let mut header = ResultHeader::new("render", args.common.seed);
    let conditions = args.conditions.load(None, &mut header)?;
    let source = args.source.load(&args.common)?;
    let pack = Pack::parse(&source.bytes)?;
    let walks = args.walks(&pack, &target, moments)?;
    let jobs = walks.iter().map(|&walk| Job::plain(walk, args.cycle));
    let under = |job| Job::under(&[job], &conditions);
    let shot = |job| Shot {
        job,
        moments,
        views: &views.list,
    };
    let jobs: Vec<Job<'_>> = jobs.flat_map(under).collect();
    let shots: Vec<Shot<'_>> = jobs.iter().copied().map(shot).collect();
    let mut frames: Vec<Vec<AnySilhouette>> = Vec::new();
    for &shot in &shots {
        frames.extend(silhouettes(&pack, shot, settings)?);
    }
    let per_walk = views.list.len();
    match &target {
        RenderTarget::Terminal => args.common.say(text_art(&pack, &shots, &frames)),
        #[cfg(feature = "plots")]
        RenderTarget::Png(path) if args.gallery && templates.is_empty() => {
            let gallery = condition_gallery(&pack, &jobs, &views.list[0], settings)?;
            write_png(path, &gallery)?;
        }
        RenderTarget::Png(_) if args.gallery && jobs.len() > 1 => {
            return Err(Error::Usage(format!(
                "--gallery with --template: expected one walk under one condition, found {}",
                jobs.len()
            )));
        }
        #[cfg(feature = "plots")]
        RenderTarget::Png(path) if args.gallery => {
            let of = |&template| Ok((template, made(template, &frames[0], settings.size)?));
            let made = templates.iter().map(of).collect::<Result<Vec<_>>>()?;
            write_png(path, &template_gallery(&made, settings)?)?;
        }
        RenderTarget::Png(path) => {
            let rows = pictures(templates, &frames, per_walk, settings)?;
            write_png(path, &contact_sheet(&rows, settings.size, args.scale)?)?;
        }
        RenderTarget::Npy(path) => {
            write_array(path, templates.first().copied(), &frames, settings.size)?;
        }
    }
    if let Some(path) = &args.out {
        args.common.say(format_args!("wrote {}", path.display()));
    }
    let mut header = header
        .drawn(&settings)
        .with("cycle", args.cycle)
        .with("start_s", args.fps.map(|_| args.start_s))
        .with("fps", args.fps)
        .with("frames", args.frames)
        .with("pack", source.name.as_str())
        .with("views", views.name.as_str())
        .with("subjects", args.source.selection.subjects.join(","))
        .with("walks", args.source.selection.walks.join(","))
        .with("template", names(templates));
    header.inputs.extend(source.inputs);
    args.common.write_json(&Rendered {
        header,
        out: args.out.as_ref().map(|path| path.display().to_string()),
        walks: walks.len(),
        viewpoints: views.list.len(),
        silhouettes: frames.iter().map(Vec::len).sum(),
    })
}

pub(super) fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension()
        .is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

/// Returns the bytes of a frame.
fn pixels(frame: &AnySilhouette) -> Vec<u8> {
    frame.to_coverage().pixels().to_vec()
}

/// Returns the names of templates; none without templates.
fn names(templates: &[Template]) -> Option<String> {
    let names: Vec<&str> = templates.iter().map(|template| template.name()).collect();
    (!names.is_empty()).then(|| names.join(","))
}

/// Makes a template from the frames of a cycle.
fn made(template: Template, frames: &[AnySilhouette], size: Size) -> Result<Vec<u8>> {
    let mut builder = Builder::new(template, size, frames.len() as u32);
    for frame in frames {
        builder.add(frame)?;
    }
    Ok(builder.finish())
}

/// Returns the images of a contact sheet: a row of frames for each viewpoint of each walk; for one
/// template, a row of viewpoints for each walk; for several, a row of templates for each viewpoint.
fn pictures(
    templates: &[Template],
    frames: &[Vec<AnySilhouette>],
    per_walk: usize,
    settings: Settings,
) -> Result<Vec<Vec<Vec<u8>>>> {
    let size = settings.size;
    let shown = |template: &Template, frames: &Vec<AnySilhouette>| {
        let bytes = made(*template, frames, size)?;
        Ok(cells(&bytes, template.shape(size), size))
    };
    let of_row = |row: Result<Vec<Vec<Vec<u8>>>>| row.map(|cells| cells.concat());
    match templates {
        [] => {
            let of_view = |frames: &Vec<AnySilhouette>| frames.iter().map(pixels).collect();
            Ok(frames.iter().map(of_view).collect())
        }
        [template] => {
            let of_view = |frames: &Vec<AnySilhouette>| shown(template, frames);
            let of_walk =
                |views: &[Vec<AnySilhouette>]| of_row(views.iter().map(of_view).collect());
            frames.chunks(per_walk).map(of_walk).collect()
        }
        several => {
            let of_view = |frames: &Vec<AnySilhouette>| {
                let of = |template| shown(template, frames);
                of_row(several.iter().map(of).collect())
            };
            frames.iter().map(of_view).collect()
        }
    }
}

/// Writes the frames of several viewpoints as `[V,T,rows,columns]`, of one viewpoint as
/// `[T,rows,columns]`; templates as `[V,rows,columns]`, or `[V,numbers]` if they are vectors.
fn write_array(
    path: &Path,
    template: Option<Template>,
    frames: &[Vec<AnySilhouette>],
    size: Size,
) -> Result<()> {
    let views = frames.len();
    let (height, width) = (size.rows(), size.columns());
    let Some(template) = template else {
        let bytes: Vec<u8> = frames.iter().flatten().flat_map(pixels).collect();
        let count = frames.first().map_or(0, Vec::len);
        return match views {
            1 => write_npy(path, &[count, height, width], &bytes),
            _ => write_npy(path, &[views, count, height, width], &bytes),
        };
    };
    let of = |frames: &Vec<AnySilhouette>| made(template, frames, size);
    let bytes = frames.iter().map(of).collect::<Result<Vec<_>>>()?.concat();
    match template.shape(size) {
        TemplateShape::Image {
            planes,
            rows,
            columns,
        } => write_npy(path, &[views, planes * rows, columns], &bytes),
        TemplateShape::Vector(numbers) => write_npy(path, &[views, numbers], &bytes),
    }
}

/// Draws two frames of the first view side by side as text, with two rows of pixels in a line: at
/// phases 0 and 0.25 of a cycle, or the first and last frame.
fn text_art(pack: &Pack<'_>, shots: &[Shot<'_>], frames: &[Vec<AnySilhouette>]) -> String {
    let mut text = String::new();
    let (Some(shot), Some(frames)) = (shots.first(), frames.first()) else {
        return text;
    };
    let walk = pack.walk(shot.job.walk);
    let (Some(walk), Some(view)) = (walk, shot.views.first()) else {
        return text;
    };
    let subject = pack
        .subject(walk.subject)
        .map_or("", |subject| subject.name);
    let later = match shot.moments {
        Moments::Cycle => frames.len() / 4,
        Moments::Seconds { .. } => frames.len() - 1,
    };
    let shown = [0, later].map(|index| frames[index].silhouette());
    let when = match shot.moments {
        Moments::Cycle => "phases 0 and 0.25".to_owned(),
        Moments::Seconds { start_s, fps, .. } => {
            format!("{start_s:.3} and {:.3} s", start_s + later as f64 / fps)
        }
    };
    let _ = writeln!(
        text,
        "{subject}, {}, azimuth {}, elevation {} degrees; {when}",
        walk.name, view.azimuth_deg, view.elevation_deg
    );
    for row in (0..shown[0].size().rows()).step_by(2) {
        let line = shown.map(|silhouette| half_blocks(&silhouette, row));
        let _ = writeln!(text, "{}", line.join("    ").trim_end());
    }
    text
}

/// Rejects times after the end of an uncut motion. A gait cycle repeats for ever.
fn refuse_beyond(pack: &Pack<'_>, walk: usize, moments: Moments) -> Result<()> {
    let Moments::Seconds {
        start_s,
        fps,
        frames,
    } = moments
    else {
        return Ok(());
    };
    let clip = pack.walk(walk).and_then(|walk| pack.clip(walk.clip));
    let Some(take) = clip.and_then(|clip| clip.as_uncut()) else {
        return Ok(());
    };
    let last_s = start_s + f64::from(frames - 1) / fps;
    // The duration is stated in whole microseconds.
    if last_s > take.duration_s() + 1e-6 {
        return Err(Error::Usage(format!(
            "{} ends at {:.3} s: --start-s, --fps and --frames ask for {last_s:.3} s",
            walk_name(pack, walk),
            take.duration_s()
        )));
    }
    Ok(())
}

/// Draws two rows of pixels as one line of half blocks.
fn half_blocks(silhouette: &Silhouette, row: usize) -> String {
    (0..silhouette.size().columns())
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
