//! `edgegait render`: draws walks to look at.

mod folder;
mod groups;
mod terminal;

use super::args::{Common, FileArgs, ViewArgs};
use super::conditions::ConditionArgs;
use super::drawing::DrawArgs;
use super::layout::{LayoutArgs, refuse_without_tree};
use super::outputs::{Output, OutputKind};
use super::walks::SourceArgs;
use crate::dataset::write_npy;
use crate::draw::sweep::{Job, Moments, Shot, is_uncut, walk_name};
use crate::draw::template::{Template, TemplateShape};
use crate::error::{Error, Result};
use crate::files::{ResultHeader, write_bytes};
#[cfg(feature = "plots")]
use crate::report::{condition_gallery, template_gallery};
use crate::report::{contact_sheet, gif, write_png};
use edgegait_core::pack::Pack;
use edgegait_core::silhouette::{AnySilhouette, Size};
use groups::{ShownGroup, count, made, pixels, rows};
use serde::Serialize;
use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};
use terminal::{text_art, walk_on};

/// Render silhouettes or templates of walks: on the terminal, as PNG or GIF, or as npy
#[derive(Debug, clap::Args)]
#[command(
    mut_arg("pack", |arg| arg.value_name("PACK|TREE|DATASET").help("A pack, a tree of silhouettes (<person>/<take>/<view>/), which is cut into gait cycles, or a dataset [default: the built-in cohort of 26 people]")),
    after_help = "Examples:\n  edgegait render                          # the first person walks on the terminal\n  edgegait render --views side --out walk.png\n  edgegait render --azimuth-deg 0,45,90 --size 64x64 --scale 4 --out walk.gif\n  edgegait render cohort.egp --subjects M03 --walks run-10kmh --azimuth-deg 0,45,90 --out run.npy\n  edgegait render turn.egp --start-s 1.5 --fps 25 --frames 50 --out turn.png\n  edgegait render silhouettes --fps 30 --template gei --out cycles.png   # the gait cycles of a tree\n  edgegait render --template gei,mei,mhi,msi,ghi,geni,frequency,kfd,row-width --out templates.png"
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
    /// Frames a second, with --frames, instead of --frames-per-cycle. For a tree, the frame rate of
    /// its recordings, to find gait cycles [default for trees: 25]
    #[arg(long, value_name = "F", conflicts_with = "frames_per_cycle")]
    fps: Option<f64>,
    /// Show each whole recording of a tree, not its gait cycles
    #[arg(long, conflicts_with = "fps")]
    whole_recordings: bool,
    #[command(flatten)]
    layout: LayoutArgs,
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
        let (fps, frames) = match (self.fps, self.frames) {
            (Some(fps), Some(frames)) => (fps, frames),
            (Some(_), None) => return Err(Error::Usage("--fps: expected --frames too".into())),
            _ => return Ok(Moments::Cycle),
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
        if !templates.is_empty() && self.frames.is_some() {
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
    if let Some(path) = args.source.pack.as_deref().filter(|path| path.is_dir()) {
        return folder::run(args, path, &target);
    }
    let trees = [("--whole-recordings", args.whole_recordings)];
    refuse_without_tree(trees.into_iter().chain(args.layout.given()))?;
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
    let drawn = |job| ShownGroup::of_shot(&pack, shot(job), settings);
    let groups: Vec<ShownGroup> = jobs.iter().copied().map(drawn).collect::<Result<_>>()?;
    let left_out = match &target {
        #[cfg(feature = "plots")]
        RenderTarget::Png(path) if args.gallery && templates.is_empty() => {
            let gallery = condition_gallery(&pack, &jobs, &views.list[0], settings)?;
            write_png(path, &gallery)?;
            0
        }
        RenderTarget::Png(_) if args.gallery && jobs.len() > 1 => {
            return Err(Error::Usage(format!(
                "--gallery with --template: expected one walk under one condition, found {}",
                jobs.len()
            )));
        }
        #[cfg(feature = "plots")]
        RenderTarget::Png(path) if args.gallery => {
            let frames = &groups[0].members[0].frames;
            let of = |&template| Ok((template, made(template, frames, settings.size)?));
            let made = templates.iter().map(of).collect::<Result<Vec<_>>>()?;
            write_png(path, &template_gallery(&made, settings)?)?;
            0
        }
        _ => args.write(&target, &groups, templates, settings.size)?,
    };
    let others = args.source.choose(&pack)?.len() - walks.len();
    let chosen = match (others, groups.first()) {
        (1.., Some(group)) => format!(
            ": {}; {others} other walks are left out (--subjects, --walks)",
            group.name
        ),
        _ => String::new(),
    };
    args.say(&chosen, left_out);
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
    args.report(header, walks.len(), views.list.len(), count(&groups))
}

impl RenderArgs {
    /// Writes the groups to the target. Returns the number of images for which it had no room.
    fn write(
        &self,
        target: &RenderTarget<'_>,
        groups: &[ShownGroup],
        templates: &[Template],
        size: Size,
    ) -> Result<usize> {
        let first = groups.first();
        let shown = first.and_then(|group| Some((group, group.members.first()?)));
        match target {
            RenderTarget::Terminal => {
                let Some((group, member)) = shown else {
                    return Ok(0);
                };
                if !self.common.quiet && std::io::stdout().is_terminal() {
                    let out = &mut std::io::stdout();
                    walk_on(out, &member.frames, group.each_s, &self.common.stop)?;
                }
                self.common.say(text_art(group, member));
                Ok(0)
            }
            RenderTarget::Png(path) => {
                let sheet = contact_sheet(&rows(groups, templates, size)?, size, self.scale)?;
                write_png(path, &sheet.picture)?;
                Ok(sheet.left_out)
            }
            RenderTarget::Gif(path) => {
                let moments = shown.map_or(0, |(_, member)| member.frames.len());
                let at = |moment: usize| {
                    let rows: Vec<_> = groups.iter().map(|group| group.at(moment)).collect();
                    contact_sheet(&rows, size, self.scale)
                };
                let sheets = (0..moments).map(at).collect::<Result<Vec<_>>>()?;
                let left_out = sheets.first().map_or(0, |sheet| sheet.left_out);
                let pictures: Vec<_> = sheets.into_iter().map(|sheet| sheet.picture).collect();
                let each_s = first.map_or(1.0, |group| group.each_s);
                write_bytes(path, &gif(&pictures, each_s)?)?;
                Ok(left_out)
            }
            RenderTarget::Npy(path) => {
                let members = groups.iter().flat_map(|group| &group.members);
                let frames: Vec<_> = members.map(|member| member.frames.as_slice()).collect();
                write_array(path, templates.first().copied(), &frames, size)?;
                Ok(0)
            }
        }
    }

    /// Says what was written.
    fn say(&self, chosen: &str, left_out: usize) {
        let Some(path) = &self.out else {
            return;
        };
        self.common
            .say(format_args!("wrote {}{chosen}", path.display()));
        if left_out > 0 {
            self.common.say(format_args!(
                "{left_out} images did not fit and are left out (draw fewer, or a smaller --scale)"
            ));
        }
    }

    /// Writes the results.
    fn report(
        &self,
        header: ResultHeader,
        walks: usize,
        viewpoints: usize,
        silhouettes: usize,
    ) -> Result<()> {
        self.common.write_json(&Rendered {
            header,
            out: self.out.as_ref().map(|path| path.display().to_string()),
            walks,
            viewpoints,
            silhouettes,
        })
    }
}

pub(super) fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension()
        .is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

/// Returns the names of templates; none without templates.
fn names(templates: &[Template]) -> Option<String> {
    let names: Vec<&str> = templates.iter().map(|template| template.name()).collect();
    (!names.is_empty()).then(|| names.join(","))
}

/// Writes the frames of several viewpoints as `[V,T,rows,columns]`, of one viewpoint as
/// `[T,rows,columns]`; templates as `[V,rows,columns]`, or `[V,numbers]` if they are vectors.
fn write_array(
    path: &Path,
    template: Option<Template>,
    frames: &[&[AnySilhouette]],
    size: Size,
) -> Result<()> {
    let views = frames.len();
    let (height, width) = (size.rows(), size.columns());
    let Some(template) = template else {
        let all = frames.iter().copied().flatten();
        let bytes: Vec<u8> = all.flat_map(pixels).collect();
        let count = frames.first().map_or(0, |frames| frames.len());
        return match views {
            1 => write_npy(path, &[count, height, width], &bytes),
            _ => write_npy(path, &[views, count, height, width], &bytes),
        };
    };
    let of = |frames: &&[AnySilhouette]| made(template, frames, size);
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
