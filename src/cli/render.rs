//! `edgegait render`: draws walks to look at.

mod terminal;

use super::args::{Common, FileArgs, ViewArgs};
use super::conditions::ConditionArgs;
use super::drawing::DrawArgs;
use super::outputs::{Output, OutputKind};
use super::walks::SourceArgs;
use crate::dataset::write_npy;
use crate::draw::sweep::{Job, Moments, Settings, Shot, View, is_uncut, silhouettes, walk_name};
use crate::draw::template::{Builder, Template, TemplateShape};
use crate::error::{Error, Result};
use crate::files::{ResultHeader, write_bytes};
use crate::report::{SheetRow, cells, contact_sheet, gif, write_png};
#[cfg(feature = "plots")]
use crate::report::{condition_gallery, template_gallery};
use edgegait_core::pack::Pack;
use edgegait_core::silhouette::{AnySilhouette, Size};
use serde::Serialize;
use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};
use terminal::{text_art, walk_on};

/// Render silhouettes or templates of walks: on the terminal, as PNG or GIF, or as npy
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait render                          # the first person walks on the terminal\n  edgegait render --views side --out walk.png\n  edgegait render --azimuth-deg 0,45,90 --size 64x64 --scale 4 --out walk.gif\n  edgegait render cohort.egp --subjects M03 --walks run-10kmh --azimuth-deg 0,45,90 --out run.npy\n  edgegait render turn.egp --start-s 1.5 --fps 25 --frames 50 --out turn.png\n  edgegait render --template gei,mei,mhi,msi,ghi,geni,frequency,kfd,row-width --out templates.png"
)]
pub(super) struct RenderArgs {
    #[command(flatten)]
    source: SourceArgs,
    /// File to write. A .png has a row for each walk, condition and viewpoint, and a column for
    /// each frame; with one template, a row for each walk and condition, and a column for each
    /// viewpoint; with several, a column for each template, three for frequency, and bars for
    /// vectors. Rows wider than a screen are broken. A .gif moves: a row for each walk and
    /// condition, and a column for each viewpoint, all at the first walk's pace. A .npy has one
    /// walk: u8 [T,50,30]; [V,T,50,30] for several viewpoints or conditions (the viewpoints of each
    /// condition in turn); [V,50,30] for a template, [V,150,30] for frequency, [V,D] for vectors;
    /// --size changes 50 and 30 [default: a moving figure on a terminal, or two moments as text]
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
    /// Side of a silhouette's pixel in the PNG or GIF, in pixels
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
    Gif(&'a Path),
    Npy(&'a Path),
}

impl RenderArgs {
    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        let (pack, conditions) = (self.source.pack.clone(), self.conditions.file());
        let inputs = pack.into_iter().chain(conditions).chain(self.views.file());
        let output = self.out.as_deref().and_then(|path| {
            let kinds = [
                ("png", OutputKind::Png),
                ("gif", OutputKind::Gif),
                ("npy", OutputKind::Npy),
            ];
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
        } else if walks.len() > 1 && !matches!(target, RenderTarget::Png(_) | RenderTarget::Gif(_))
        {
            return Err(Error::Usage(format!(
                "{} walks are chosen: expected one, or --out with a .png or .gif (choose with --subjects and --walks)",
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
            Some(path) if has_extension(path, "gif") && !templates.is_empty() => {
                Err(Error::Usage(format!(
                    "--out {}: a template does not move (use .png, or --template silhouettes)",
                    path.display()
                )))
            }
            Some(path) if has_extension(path, "gif") => Ok(RenderTarget::Gif(path)),
            Some(path) if has_extension(path, "npy") && templates.len() > 1 => {
                Err(Error::Usage(format!(
                    "--out {}: a .npy holds one template, found {} (use .png, or one --template)",
                    path.display(),
                    templates.len()
                )))
            }
            Some(path) if has_extension(path, "npy") => Ok(RenderTarget::Npy(path)),
            Some(path) => Err(Error::Usage(format!(
                "--out {}: expected a name that ends in .png, .gif or .npy",
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
    let mut left_out = 0;
    match &target {
        RenderTarget::Terminal => {
            if let Some(shot) = shots.first()
                && !args.common.quiet
                && std::io::stdout().is_terminal()
            {
                let each_s = frame_s(&pack, *shot, frames[0].len());
                walk_on(
                    &mut std::io::stdout(),
                    &frames[0],
                    each_s,
                    &args.common.stop,
                )?;
            }
            args.common.say(text_art(&pack, &shots, &frames));
        }
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
            let rows = labelled(rows, templates, &pack, &shots);
            let sheet = contact_sheet(&rows, settings.size, args.scale)?;
            write_png(path, &sheet.picture)?;
            left_out = sheet.left_out;
        }
        RenderTarget::Gif(path) => {
            let at = |moment: usize| {
                let at = |frames: &Vec<AnySilhouette>| pixels(&frames[moment]);
                let row = |views: &[Vec<AnySilhouette>]| views.iter().map(at).collect();
                let rows = frames.chunks(per_walk).map(row).collect();
                // Labelled as the viewpoints of one template are.
                let rows = labelled(rows, &[Template::Gei], &pack, &shots);
                contact_sheet(&rows, settings.size, args.scale)
            };
            let moments = frames.first().map_or(0, Vec::len);
            let sheets = (0..moments).map(at).collect::<Result<Vec<_>>>()?;
            left_out = sheets.first().map_or(0, |sheet| sheet.left_out);
            let pictures: Vec<_> = sheets.into_iter().map(|sheet| sheet.picture).collect();
            let each_s = shots
                .first()
                .map_or(1.0, |shot| frame_s(&pack, *shot, moments));
            write_bytes(path, &gif(&pictures, each_s)?)?;
        }
        RenderTarget::Npy(path) => {
            write_array(path, templates.first().copied(), &frames, settings.size)?;
        }
    }
    if let Some(path) = &args.out {
        let others = args.source.choose(&pack)?.len() - walks.len();
        let chosen = match others {
            0 => String::new(),
            _ => format!(
                ": {}; {others} other walks are left out (--subjects, --walks)",
                who(&pack, walks[0])
            ),
        };
        args.common
            .say(format_args!("wrote {}{chosen}", path.display()));
        if left_out > 0 {
            args.common.say(format_args!(
                "{left_out} images did not fit and are left out (draw fewer, or a smaller --scale)"
            ));
        }
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

/// Returns the names of a walk's person and of the walk.
fn who(pack: &Pack<'_>, walk: usize) -> String {
    let Some(walk) = pack.walk(walk) else {
        return String::new();
    };
    let subject = pack.subject(walk.subject);
    format!(
        "{}, {}",
        subject.map_or("", |subject| subject.name),
        walk.name
    )
}

/// Labels the rows of a contact sheet: by walk, condition and viewpoint; for one template, by walk
/// and condition.
fn labelled(
    rows: Vec<Vec<Vec<u8>>>,
    templates: &[Template],
    pack: &Pack<'_>,
    shots: &[Shot<'_>],
) -> Vec<SheetRow> {
    let from = |views: &[View]| {
        let is_level = views.iter().all(|view| view.elevation_deg == 0.0);
        let angles = views.iter().map(|view| match is_level {
            true => view.azimuth_deg.to_string(),
            false => format!("{}/{}", view.azimuth_deg, view.elevation_deg),
        });
        let what = if is_level {
            "azimuth"
        } else {
            "azimuth/elevation"
        };
        format!("{what} {}", angles.collect::<Vec<_>>().join(", "))
    };
    let of_shot = |shot: &Shot<'_>| {
        let under = shot
            .job
            .condition
            .map(|condition| format!(", {}", condition.name));
        let who = who(pack, shot.job.walk) + &under.unwrap_or_default();
        let each = if templates.len() == 1 {
            shot.views.len()
        } else {
            1
        };
        let label = |views| format!("{who}, {}", from(views));
        shot.views
            .chunks(each.max(1))
            .map(label)
            .collect::<Vec<_>>()
    };
    let labels = shots.iter().flat_map(of_shot);
    let row = |(images, label)| SheetRow { label, images };
    rows.into_iter().zip(labels).map(row).collect()
}

/// Returns how long a frame is shown, seconds.
fn frame_s(pack: &Pack<'_>, shot: Shot<'_>, frames: usize) -> f64 {
    let clip = pack
        .walk(shot.job.walk)
        .and_then(|walk| pack.clip(walk.clip));
    match shot.moments {
        Moments::Seconds { fps, .. } => 1.0 / fps,
        Moments::Cycle => clip.map_or(1.0, |clip| clip.duration_s()) / frames.max(1) as f64,
    }
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
