//! Renders the gait cycles of a tree, or the images of a dataset.

use super::groups::{ShownCycle, ShownGroup, count};
use super::{RenderArgs, RenderTarget, names};
use crate::cli::args::ViewArgs;
use crate::cli::layout::{none_chosen, refuse_without_tree};
use crate::cli::tree_cycles::CuttingArgs;
use crate::cli::walks::SelectionArgs;
use crate::dataset::sequences::{
    Form, Recordings, SequenceSource, Sequences, ViewLabel, silhouettes,
};
use crate::dataset::{Dataset, IndexRow, Tree};
use crate::draw::sweep::{Settings, UNCUT_FPS, Views};
use crate::draw::template::Template;
use crate::error::{Error, Result};
use crate::files::ResultHeader;
use crate::report::{SheetRow, cells, contact_sheet, write_png};
use edgegait_core::silhouette::AnySilhouette;
use std::collections::BTreeSet;
use std::path::Path;

/// The maximum number of gait cycles, or images of a dataset, that are read: more than a picture
/// has room for.
const MOST: usize = 4_096;
/// The number of frames after which no further gait cycle is read: 100 MB of 50x30.
const MOST_FRAMES: usize = 1 << 16;

/// Runs the subcommand for a folder.
pub(super) fn run(args: &RenderArgs, path: &Path, target: &RenderTarget<'_>) -> Result<()> {
    args.refuse_for_folders()?;
    match SequenceSource::open(path, &[], &args.layout.layout())? {
        SequenceSource::Tree(recordings) => of_tree(args, path, *recordings, target),
        SequenceSource::Dataset(templates) => of_dataset(args, path, templates.dataset(), target),
        SequenceSource::Walks(_) => Err(Error::Missing("a tree or a dataset")),
    }
}

/// Renders the gait cycles of a tree.
fn of_tree(
    args: &RenderArgs,
    path: &Path,
    recordings: Recordings,
    target: &RenderTarget<'_>,
) -> Result<()> {
    let templates = args.templates()?;
    let settings = Settings {
        template: Template::Silhouettes,
        ..args.draw.without_template().settings(args.common.seed)?
    };
    Tree::require_framing(settings.framing)?;
    args.draw.refuse_for_trees()?;
    let views = args.views.given()?;
    let recordings = recordings.chosen(&args.source.selection.selection(false), views.as_ref())?;
    if recordings.is_empty() {
        return Err(none_chosen(path));
    }
    let Sequences { takes, views, .. } = recordings.sequences();
    let (takes, viewpoints) = (takes.len(), views.len());
    let name = path.display().to_string();
    let mut header = ResultHeader::new("render", args.common.seed)
        .with("tree", name)
        .with("size", settings.size.name())
        .with("framing", settings.framing.name())
        .with("template", names(templates));
    let recordings = args.cutting().cut(recordings, &mut header, &args.common)?;
    // A template needs all frames; of more than these, evenly spaced ones are shown.
    let most = match templates {
        [] => settings.frames_per_cycle as usize,
        _ => usize::MAX,
    };
    let each_s = 1.0 / args.fps.unwrap_or(UNCUT_FPS);
    let (groups, left) = groups(recordings, settings, most, each_s)?;
    if matches!(target, RenderTarget::Npy(_)) && groups.len() > 1 {
        return Err(Error::Usage(format!(
            "{} recordings are chosen: expected one for a .npy, which `sweep` writes of all (choose with --subjects, --walks and --views)",
            groups.len()
        )));
    }
    let left_out = args.write(target, &groups, templates, settings.size)?;
    args.common.say_warnings(&header.warnings);
    let others = match left {
        0 => String::new(),
        _ => format!("; {left} other gait cycles are left out (--subjects, --walks, --views)"),
    };
    args.say(&others, left_out);
    args.report(header, takes, viewpoints, count(&groups))
}

/// Reads the gait cycles of each recording, at most `most` frames of each. Returns how many cycles
/// were left out, too.
fn groups(
    recordings: Recordings,
    settings: Settings,
    most: usize,
    each_s: f64,
) -> Result<(Vec<ShownGroup>, usize)> {
    let form = Form {
        settings,
        frames: None,
    };
    let starts: Vec<usize> = { 0..recordings.len() }
        .map(|at| recordings.first_frame(at))
        .collect();
    let source = SequenceSource::Tree(Box::new(recordings));
    let sequences = source.sequences();
    let mut groups: Vec<ShownGroup> = Vec::new();
    let (mut shown, mut kept) = (0, 0);
    for (number, &first) in starts.iter().enumerate().take(MOST) {
        if kept >= MOST_FRAMES {
            break;
        }
        let origin = sequences.origin(number);
        let view = match sequences.view_label(number) {
            ViewLabel::Named(name) => name.clone(),
            angles @ ViewLabel::Angles(..) => format!("azimuth {angles}"),
        };
        let subject = &sequences.subjects[sequences.subject(number)];
        let name = format!("{subject}, {}, {view}", origin.walk);
        let mut frames = Vec::new();
        let counts = source.show(&[number], &form, &mut |_, bytes| {
            let all: Vec<AnySilhouette> = silhouettes(bytes, settings.size).collect();
            let kept = all.len().min(most);
            frames = (0..kept).map(|at| all[at * all.len() / kept]).collect();
            Ok(())
        })?;
        let read = (counts.silhouettes + counts.empty) as usize;
        let cycle = format!("{first} to {}", counts.last_frame(first));
        shown += 1;
        kept += frames.len();
        if let Some(group) = groups.last_mut().filter(|group| group.name == name) {
            group.together += &format!(", {cycle}");
            let name = format!("frames {cycle}");
            group.members.push(ShownCycle { name, frames });
            continue;
        }
        let what = match origin.cycle {
            Some(_) => format!("frames {cycle}"),
            None => "whole".to_owned(),
        };
        groups.push(ShownGroup {
            name,
            together: what.clone(),
            each_s: each_s * read as f64 / frames.len().max(1) as f64,
            later: (frames.len() / 4, format!("{what}; phases 0 and 0.25")),
            members: vec![ShownCycle { name: what, frames }],
        });
    }
    Ok((groups, sequences.list.len() - shown))
}

/// Renders the images of a dataset: a row for each walk, condition and variation.
fn of_dataset(
    args: &RenderArgs,
    path: &Path,
    dataset: &Dataset,
    target: &RenderTarget<'_>,
) -> Result<()> {
    let cutting = args.cutting().given().into_iter();
    refuse_without_tree(cutting.chain(args.layout.given()))?;
    let none = SelectionArgs::default();
    args.draw
        .refuse_for_folders(&none, None, &ViewArgs::default())?;
    let RenderTarget::Png(out) = target else {
        return Err(Error::Usage(
            "a dataset holds finished images: expected --out with a .png".into(),
        ));
    };
    let selection = args.source.selection.selection(false);
    let views = args.views.given()?;
    let is_chosen = |row: &IndexRow| {
        let is_seen = |views: &Views| views.has((row.azimuth_deg, row.elevation_deg));
        selection.has(&row.subject, &row.walk) && views.as_ref().is_none_or(is_seen)
    };
    let (template, size) = (dataset.template(), dataset.size());
    let (mut rows, mut left): (Vec<(SheetRow, Vec<String>)>, usize) = (Vec::new(), 0);
    let (mut shown, mut silhouettes) = (0, 0);
    let (mut walks, mut viewpoints) = (BTreeSet::new(), BTreeSet::new());
    for (row, bytes) in dataset.index().iter().zip(dataset.templates()) {
        if !is_chosen(row) {
            continue;
        }
        let images = match template {
            Template::Silhouettes => bytes
                .chunks_exact(size.pixels())
                .map(<[u8]>::to_vec)
                .collect(),
            _ => cells(bytes, template.shape(size), size),
        };
        if shown + images.len() > MOST {
            left += images.len();
            continue;
        }
        shown += images.len();
        silhouettes += row.frames as usize;
        walks.insert((&row.subject, &row.walk));
        let condition = [&row.condition, &row.alternative].map(String::as_str);
        let words = [row.subject.as_str(), &row.walk]
            .into_iter()
            .chain(condition);
        let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
        let which = match (row.first_frame.zip(row.last_frame), row.variation) {
            (Some((first, last)), _) => format!("frames {first} to {last}"),
            (None, 0) => format!("cycle {}", row.cycle),
            (None, variation) => format!("cycle {}, variation {variation}", row.cycle),
        };
        let label = format!("{}, {which}", words.join(", "));
        let view = ViewLabel::Angles(row.azimuth_deg, row.elevation_deg).to_string();
        viewpoints.insert(view.clone());
        match rows.last_mut().filter(|(row, _)| row.label == label) {
            Some((row, views)) => {
                row.images.extend(images);
                views.push(view);
            }
            None => rows.push((SheetRow { label, images }, vec![view])),
        }
    }
    if rows.is_empty() {
        return Err(none_chosen(path));
    }
    let labelled = |(row, views): (SheetRow, Vec<String>)| SheetRow {
        label: format!("{}, azimuth {}", row.label, views.join(", ")),
        ..row
    };
    let rows: Vec<SheetRow> = rows.into_iter().map(labelled).collect();
    let sheet = contact_sheet(&rows, size, args.scale)?;
    write_png(out, &sheet.picture)?;
    args.say("", sheet.left_out + left);
    let mut header = ResultHeader::new("render", args.common.seed)
        .with("dataset", path.display().to_string())
        .with("template", template.name());
    header.inputs = Dataset::inputs(path)?;
    args.report(header, walks.len(), viewpoints.len(), silhouettes)
}

impl RenderArgs {
    /// Returns the flags that choose how a tree is cut.
    fn cutting(&self) -> CuttingArgs {
        CuttingArgs::new(self.fps.map(|fps| fps as f32), self.whole_recordings)
    }

    /// Rejects flags about drawing walks, as the silhouettes exist.
    fn refuse_for_folders(&self) -> Result<()> {
        let flags = [
            ("--cycle", self.cycle > 0),
            ("--start-s", self.start_s > 0.0),
            ("--frames", self.frames.is_some()),
            ("--gallery", self.gallery),
        ];
        if let Some((flag, _)) = flags.iter().find(|(_, is_given)| *is_given) {
            return Err(Error::Usage(format!("{flag}: expected a pack")));
        }
        self.conditions.refuse_for_folders()
    }
}
