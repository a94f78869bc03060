//! What a tree of silhouettes or a dataset contains.

use super::InspectArgs;
use crate::cli::layout::refuse_without_tree;
use crate::cli::progress::Progress;
use crate::dataset::Dataset;
use crate::dataset::sequences::{Form, RecordingSummary, SequenceSource, Sequences};
use crate::draw::sweep::{FramingMode, Settings};
use crate::draw::template::Template;
use crate::error::{Error, Result};
use crate::files::ResultHeader;
use crate::files::text_table::Column::{Left, Right};
use crate::files::text_table::Table;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// The maximum number of lines in each table of the text; the JSON has all.
const LINES: usize = 40;

/// What a folder contains.
#[derive(Debug, Serialize)]
struct FolderSummary {
    #[serde(flatten)]
    header: ResultHeader,
    /// `tree` or `dataset`.
    kind: &'static str,
    /// The template of a dataset.
    template: Option<&'static str>,
    /// The size of a dataset's images, rows x columns.
    size: Option<String>,
    /// The recordings of a tree, or the rows of a dataset.
    sequences: usize,
    people: Vec<Counted>,
    takes: Vec<Counted>,
    views: Vec<Counted>,
    /// The recordings of a tree.
    recordings: Vec<RecordingSummary>,
    /// Why recordings cannot be used.
    refused: Vec<String>,
    /// Entries of the folder that are not recordings.
    skipped: Vec<String>,
}

/// A name, and how many sequences have it.
#[derive(Debug, Serialize)]
struct Counted {
    name: String,
    sequences: usize,
}

impl Counted {
    /// Counts names, in the order of their first use.
    fn all(names: impl Iterator<Item = String>) -> Vec<Self> {
        let mut places = BTreeMap::new();
        let mut all: Vec<Self> = Vec::new();
        for name in names {
            let place = *places.entry(name.clone()).or_insert(all.len());
            match all.get_mut(place) {
                Some(known) => known.sequences += 1,
                None => all.push(Self { name, sequences: 1 }),
            }
        }
        all
    }
}

/// Summarizes the folder.
pub(super) fn run(args: &InspectArgs) -> Result<()> {
    #[cfg(feature = "import")]
    if args.audit {
        return Err(Error::Usage("--audit: expected a pack".into()));
    }
    let source = SequenceSource::open(&args.path, &[], &args.layout.layout())?;
    let mut header = ResultHeader::new("inspect", args.common.seed);
    let summary = match source {
        SequenceSource::Tree(recordings) => {
            let skipped = recordings.skipped().to_vec();
            header.warnings.extend(recordings.doubts());
            let progress = Progress::new(&args.common, ("reading", "recordings"), recordings.len());
            let form = Form {
                settings: Settings {
                    template: Template::Silhouettes,
                    framing: FramingMode::Height,
                    ..Settings::default()
                },
                frames: None,
            };
            let (recordings, refused) = recordings.readable(&[form], &|| progress.step())?;
            drop(progress);
            let mut summary = FolderSummary::of(header, "tree", recordings.sequences());
            let cut = args
                .cutting
                .cut(recordings, &mut summary.header, &args.common)?;
            FolderSummary {
                recordings: cut.listed()?,
                refused: refused.iter().map(ToString::to_string).collect(),
                skipped,
                ..summary
            }
        }
        SequenceSource::Dataset(templates) => {
            refuse_without_tree(args.cutting.given().into_iter().chain(args.layout.given()))?;
            let dataset = templates.dataset();
            header.inputs = Dataset::inputs(&args.path)?;
            FolderSummary {
                template: Some(dataset.template().name()),
                size: Some(dataset.size().name().to_string()),
                ..FolderSummary::of(
                    header,
                    "dataset",
                    SequenceSource::Dataset(templates).sequences(),
                )
            }
        }
        SequenceSource::Walks(_) => return Err(Error::Missing("a tree or a dataset")),
    };
    args.common.say_warnings(&summary.header.warnings);
    args.common.say(format_args!("{summary}"));
    args.common.write_json(&summary)
}

impl FolderSummary {
    /// Counts sequences by person, take and view.
    fn of(header: ResultHeader, kind: &'static str, sequences: &Sequences) -> Self {
        let all = || 0..sequences.list.len();
        let take = |at: usize| {
            let take = &sequences.takes[sequences.list[at].take];
            match take.condition.as_str() {
                "" => take.name.clone(),
                condition => format!("{}, {condition}", take.name),
            }
        };
        let view = |at: usize| sequences.view_label(at).to_string();
        let person = |at: usize| sequences.subjects[sequences.subject(at)].clone();
        Self {
            header,
            kind,
            template: None,
            size: None,
            sequences: sequences.list.len(),
            people: Counted::all(all().map(person)),
            takes: Counted::all(all().map(take)),
            views: Counted::all(all().map(view)),
            recordings: Vec::new(),
            refused: Vec::new(),
            skipped: Vec::new(),
        }
    }
}

impl fmt::Display for FolderSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match (&self.template, &self.size) {
            (Some(template), Some(size)) => format!("rows ({template}, {size})"),
            _ => "recordings".to_owned(),
        };
        writeln!(
            f,
            "{} {what} of {} people, {} takes and {} views",
            self.sequences,
            self.people.len(),
            self.takes.len(),
            self.views.len()
        )?;
        for (head, counted) in [
            ("person", &self.people),
            ("take", &self.takes),
            ("view", &self.views),
        ] {
            if counted.is_empty() {
                continue;
            }
            let mut table = Table::new(&[Left(20), Right(0)]);
            table.row([head, "sequences"]);
            for one in counted.iter().take(LINES) {
                table.row([one.name.clone(), one.sequences.to_string()]);
            }
            write!(f, "\n{}", table.to_string().trim_end())?;
            left_out(f, counted.len())?;
        }
        if !self.recordings.is_empty() {
            let mut table = Table::new(&[Left(0), Left(0), Left(0), Right(0), Left(0)]).with_gap(2);
            table.row([
                "person",
                "take",
                "view",
                "frames",
                "gait cycles: first to last frame, from 0",
            ]);
            for one in self.recordings.iter().take(LINES) {
                let cycles = one
                    .cycles
                    .iter()
                    .map(|[first, last]| format!("{first}-{last}"));
                let cycles = match &one.no_cycle {
                    Some(reason) => format!("none: {reason}"),
                    None => cycles.collect::<Vec<_>>().join(" "),
                };
                let frames = one
                    .frames
                    .map_or_else(String::new, |frames| frames.to_string());
                table.row([
                    one.subject.clone(),
                    one.take.clone(),
                    one.view.clone(),
                    frames,
                    cycles,
                ]);
            }
            write!(f, "\n\n{}", table.to_string().trim_end())?;
            left_out(f, self.recordings.len())?;
        }
        for (what, lines) in [
            ("cannot be used", &self.refused),
            ("skipped", &self.skipped),
        ] {
            for line in lines.iter().take(LINES) {
                write!(f, "\n{what}: {line}")?;
            }
            left_out(f, lines.len())?;
        }
        Ok(())
    }
}

/// States how many lines were left out.
fn left_out(f: &mut fmt::Formatter<'_>, lines: usize) -> fmt::Result {
    match lines.saturating_sub(LINES) {
        0 => Ok(()),
        more => write!(f, "\n({more} more: --json lists all)"),
    }
}
