//! Sweeps a tree of silhouettes into a dataset with the templates of each gait cycle.

use super::{MadeDataset, SweepArgs};
use crate::cli::args::Common;
use crate::cli::layout::none_chosen;
use crate::cli::progress::Progress;
use crate::cli::tree_cycles::CuttingArgs;
use crate::dataset::sequences::{Form, SequenceSource, ShownCounts, ViewLabel};
use crate::dataset::{Contents, DatasetFormat, DatasetRun, DatasetWriter, IndexRow, Item, Tree};
use crate::draw::sweep::{Settings, Wanted};
use crate::draw::template::Template;
use crate::draw::template::augment::{Variant, varied};
use crate::error::{Error, Result};
use crate::files::ResultHeader;
use rayon::prelude::*;
use std::path::Path;
use std::time::Instant;

/// Number of sequences whose templates are held in memory, for each thread.
const AT_ONCE: usize = 16;

/// The templates of a sequence, in the requested order, and statistics of the images in one of
/// them.
struct SequenceTemplates {
    templates: Vec<Vec<u8>>,
    shown: ShownCounts,
}

/// Sweeps the tree at `path`.
pub(super) fn run(args: &SweepArgs, path: &Path) -> Result<()> {
    args.refuse_for_tree()?;
    let (settings, wanted) = args.wanted()?;
    Tree::require_framing(settings.framing)?;
    let augmentation = args.augment.augmentation()?;
    for &template in &wanted.templates {
        augmentation.check(template, settings.size)?;
    }
    let other = || {
        Error::input(
            path,
            "expected a pack or a tree of silhouettes (<person>/<take>/<view>/ with frames), found another folder (a dataset has been swept already)",
        )
    };
    if !Tree::is_at(path) {
        return Err(other());
    }
    let source = SequenceSource::open(path, &[], &args.layout.layout())?;
    let mut views = source.sequences().views.iter();
    if let Some(name) = views.find_map(ViewLabel::name) {
        return Err(Error::input(
            path,
            format!(
                "expected views named by angles, as the index of a dataset needs them, found {name:?} (rename the folders of views, or give the tree itself to `train` and `score`)"
            ),
        ));
    }
    let SequenceSource::Tree(recordings) = source else {
        return Err(other());
    };
    let views = args.views.given()?;
    let selection = args.source.selection.selection(false);
    let recordings = recordings.chosen(&selection, views.as_ref())?;
    if recordings.is_empty() {
        return Err(none_chosen(path));
    }
    let progress = Progress::new(&args.common, ("reading", "folders"), recordings.len());
    recordings.check_sizes(&[], &|| progress.step())?;
    drop(progress);
    let started = Instant::now();
    let name = path.display().to_string();
    let mut header = ResultHeader::new("sweep", args.common.seed)
        .with("tree", name)
        .with("size", settings.size.name())
        .with("framing", settings.framing.name())
        .augmented(augmentation);
    header.warnings.extend(recordings.doubts());
    if settings.template != Template::Gei {
        header = header.with("template", settings.template.name());
    }
    let cutting = CuttingArgs::new(args.fps.map(|fps| fps as f32), args.whole_recordings);
    let recordings = cutting.cut(recordings, &mut header, &args.common)?;
    let starts: Vec<usize> = (0..recordings.len())
        .map(|at| recordings.first_frame(at))
        .collect();
    let source = SequenceSource::Tree(Box::new(recordings));
    let run = DatasetRun {
        header: header.clone(),
        contents: Contents {
            templates: wanted.templates.clone(),
            size: settings.size,
            joints: false,
        },
        format: args.export.format,
        units: source.sequences().list.len(),
        shard: None,
        is_recorded: true,
    };
    let Some(mut writer) = args.export.begin(&args.out, run, args.common.overwrite)? else {
        return Ok(());
    };
    let variants = augmentation.variants();
    let shown = stored(
        (&source, &starts),
        settings,
        &wanted,
        &variants,
        &mut writer,
        &args.common,
    )?;
    if shown.empty > 0 {
        header.warnings.push(format!(
            "{} frames without a figure were left out",
            shown.empty
        ));
    }
    let made = MadeDataset {
        rows: writer.rows(),
        silhouettes: shown.silhouettes,
        clipped: shown.clipped.unwrap_or(0.0),
        said: format!("wrote {}", args.out.display()),
        raster: None,
        digest: None,
    };
    writer.finish()?;
    args.common.say_warnings(&header.warnings);
    args.report(header, &settings, &wanted, made, started)
}

/// Makes the templates of all sequences, on all cores, writes them, and returns statistics of the
/// images.
fn stored(
    (source, starts): (&SequenceSource<'_>, &[usize]),
    settings: Settings,
    wanted: &Wanted,
    variants: &[Variant],
    writer: &mut DatasetWriter,
    common: &Common,
) -> Result<ShownCounts> {
    let sequences = source.sequences();
    let all: Vec<usize> = (0..sequences.list.len()).collect();
    let progress = Progress::new(common, ("reading", "sequences"), all.len());
    let mut shown = ShownCounts {
        clipped: Some(0.0),
        ..ShownCounts::default()
    };
    for numbers in all.chunks(AT_ONCE * rayon::current_num_threads().max(1)) {
        let templates = |&number: &usize| {
            let templates = templates(source, number, settings, wanted);
            progress.step()?;
            Ok(templates)
        };
        let made = numbers.par_iter().map(templates);
        let made: Vec<Result<SequenceTemplates>> = made.collect::<Result<_>>()?;
        for (&number, made) in numbers.iter().zip(made) {
            let SequenceTemplates {
                templates,
                shown: of_one,
            } = made?;
            shown = shown.and(of_one);
            let (azimuth_deg, elevation_deg) = sequences
                .view_label(number)
                .angles_deg()
                .ok_or(Error::Missing("angles"))?;
            let origin = sequences.origin(number);
            let row = IndexRow {
                subject: sequences.subjects[sequences.subject(number)].clone(),
                walk: origin.walk.clone(),
                cycle: origin.cycle.unwrap_or(0),
                variation: 0,
                speed_kmh: 0.0,
                azimuth_deg,
                elevation_deg,
                condition: String::new(),
                alternative: String::new(),
                frames: u32::try_from(of_one.silhouettes).unwrap_or(u32::MAX),
                seed: 0,
                first_frame: Some(starts[number] as u32),
                last_frame: Some(of_one.last_frame(starts[number]) as u32),
            };
            for &variant in variants {
                let row = IndexRow {
                    condition: variant.condition(&row.condition),
                    ..row.clone()
                };
                let varied = |bytes: &Vec<u8>| varied(bytes, settings.size, variant);
                let varied: Vec<Vec<u8>> = if variant == Variant::default() {
                    templates.clone()
                } else {
                    templates.iter().map(varied).collect()
                };
                writer.push(Item {
                    row: &row,
                    take: &row.walk,
                    templates: &varied,
                    joints: [&[], &[]],
                })?;
            }
            writer.end_unit()?;
        }
    }
    Ok(shown)
}

/// Makes the templates of one sequence.
fn templates(
    source: &SequenceSource<'_>,
    number: usize,
    settings: Settings,
    wanted: &Wanted,
) -> Result<SequenceTemplates> {
    let (mut templates, mut shown) = (Vec::new(), ShownCounts::default());
    for &template in &wanted.templates {
        let form = Form {
            settings: Settings {
                template,
                ..settings
            },
            frames: None,
        };
        shown = source.show(&[number], &form, &mut |_, bytes| {
            templates.push(bytes.to_vec());
            Ok(())
        })?;
    }
    Ok(SequenceTemplates { templates, shown })
}

impl SweepArgs {
    /// Rejects flags about drawing walks, as the silhouettes exist.
    fn refuse_for_tree(&self) -> Result<()> {
        let export = &self.export;
        let flags = [
            ("--digest", self.digest),
            ("--cycles", self.cycles.is_some()),
            ("--first-cycle", self.first_cycle.is_some()),
            ("--max-gei-rmse", self.max_gei_rmse.is_some()),
            ("--joints", self.joints),
            ("--shard", export.shard.is_some()),
            ("--resume", export.resume),
        ];
        if let Some((flag, _)) = flags.iter().find(|(_, is_given)| *is_given) {
            return Err(Error::Usage(format!("{flag}: expected a pack")));
        }
        if !matches!(export.format, DatasetFormat::Folder | DatasetFormat::Npz) {
            return Err(Error::Usage(format!(
                "--format {}: the silhouettes are in a tree already (use folder or npz)",
                export.format.name()
            )));
        }
        self.conditions.refuse_for_folders()?;
        self.draw.refuse_for_trees()
    }
}
