//! The flags that choose gallery and probes, and the contest that they describe.

use super::args::{Common, ViewArgs, file_with};
use super::baselines::WantedBaselines;
use super::conditions::ConditionArgs;
use super::drawing::DrawArgs;
use super::keep_going::{KeepGoing, with_hint};
use super::layout::{LayoutArgs, refuse_without_tree};
use super::progress::Progress;
use super::tree_cycles::CuttingArgs;
use super::walks::{SelectionArgs, SourceArgs};
use crate::dataset::sequences::{Form, PackSource, SequenceSource};
use crate::dataset::{Dataset, Partition, TREE_PARTITION};
use crate::draw::confounders::Condition;
use crate::draw::sweep::Views;
use crate::draw::template::Template;
use crate::error::{Error, Result};
use crate::evaluate::contest::{
    Contest, ContestOptions, DrawnContest, Entrant, StoredTemplates, unlike_protocols, usual,
};
use crate::evaluate::protocol::{PARTITION, Protocol};
use crate::files::{InputFile, ResultHeader};
use crate::people::cohort::CohortOptions;
use edgegait_core::pack::Pack;
use std::path::{Path, PathBuf};

/// The protocol that without a pack has people whom no shipped model has seen, and their conditions.
const SESSIONS: &str = "sessions";
const UNSEEN_CONDITIONS: &str = "bag-coat";

/// The flags that choose gallery, probes and viewpoints.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct ContestArgs {
    #[command(flatten)]
    selection: SelectionArgs,
    /// Protocol: closed-set, first-take, sessions, leave-one-take-out, cross-view, verification,
    /// casia-b, ou-mvlp, partition, or a .toml file with the same keys [default: sessions if neither
    /// walks nor viewpoints are chosen; for these closed-set if every model has classes for all
    /// people, else first-take; partition if --partition names probes or gallery]. Without a pack,
    /// sessions has 30 people whom no shipped model has seen, also with bags and coats
    #[arg(long, value_name = "NAME|FILE")]
    protocol: Option<String>,
    /// Probe cycles of each walk, if they are seeded variations [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    cycles: Option<u32>,
    /// Only the test people of a tree's partition, in OpenGait's format: a JSON file with TRAIN_SET
    /// and TEST_SET; an optional PROBE_SET or GALLERY_SET chooses probes and gallery
    #[arg(long, value_name = "FILE.json")]
    partition: Option<PathBuf>,
    /// Use a tree's images as stored, without framing them again, as OpenGait does
    #[arg(long)]
    as_stored: bool,
    #[command(flatten)]
    cutting: CuttingArgs,
    #[command(flatten)]
    layout: LayoutArgs,
    #[command(flatten)]
    keep_going: KeepGoing,
    #[command(flatten)]
    conditions: ConditionArgs,
    #[command(flatten)]
    views: ViewArgs,
    #[command(flatten)]
    draw: DrawArgs,
    /// A pack held by the program that runs the command in its own process.
    #[arg(skip)]
    pub held: Option<PackSource>,
}

/// How inputs of recognizers are made.
#[derive(Clone, Copy)]
pub(super) struct InputSource<'a> {
    /// The flags with which inputs are drawn.
    pub draw: &'a DrawArgs,
    /// The seed with which inputs are drawn.
    pub seed: u64,
    /// The stored templates that are the inputs, or `None` if inputs are drawn.
    pub stored: Option<StoredTemplates>,
}

/// The recognizers that take part.
pub(super) struct Participants<'a> {
    pub common: &'a Common,
    /// Loads the recognizers, and states their files in the header.
    pub load: &'a dyn Fn(InputSource<'_>, &mut ResultHeader) -> Result<Vec<Entrant>>,
    /// The baselines that take part as well.
    pub baselines: WantedBaselines,
    /// The viewpoints of probes if neither flags nor the protocol state them; without these, the
    /// viewpoints of the paper.
    pub views: Option<Views>,
}

impl ContestArgs {
    /// Returns the files that the flags name.
    pub(super) fn inputs(&self) -> impl Iterator<Item = PathBuf> {
        let protocol = file_with("toml", self.protocol.as_ref());
        let files = [
            protocol,
            self.conditions.file(),
            self.views.file(),
            self.partition.clone(),
        ];
        files.into_iter().flatten()
    }

    /// Returns whether neither walks nor a protocol are chosen.
    pub(super) const fn is_open(&self) -> bool {
        self.protocol.is_none()
            && self.held.is_none()
            && self.cycles.is_none()
            && self.partition.is_none()
            && self.selection.subjects.is_empty()
            && self.selection.walks.is_empty()
    }

    /// Returns the contest of people whom no shipped model has seen, enrolled in one session and
    /// sought in another.
    pub(super) fn of_sessions(&self) -> Self {
        Self {
            protocol: Some(SESSIONS.to_owned()),
            ..self.clone()
        }
    }

    /// Loads the recognizers, opens the pack or folder (or makes the built-in cohort), and passes
    /// them to `work` with a header that states all of it.
    ///
    /// # Errors
    /// If something cannot be used, and the errors of `work`.
    pub(super) fn run<R>(
        &self,
        field: &Participants<'_>,
        data: Option<PathBuf>,
        mut header: ResultHeader,
        work: impl FnOnce(&Contest<'_>, &[Entrant], ResultHeader) -> Result<R>,
    ) -> Result<R> {
        if let (Some(data), Some(held)) = (&data, &self.held) {
            return Err(Error::Usage(format!(
                "expected one source of walks, found {} and a pack of {} bytes",
                data.display(),
                held.bytes.len()
            )));
        }
        let protocol = self.protocol.as_deref().map(Protocol::named).transpose()?;
        if let Some(name) = self
            .protocol
            .as_ref()
            .filter(|name| name.ends_with(".toml"))
        {
            header.inputs.push(InputFile::read(name)?);
        }
        match data {
            Some(folder) if folder.is_dir() => {
                self.run_on_folder(field, &folder, protocol, header, work)
            }
            pack => self.run_on_pack(field, pack, protocol, header, work),
        }
    }

    /// Passes recognizers and a folder to `work`, as [`Self::run`] does.
    fn run_on_folder<R>(
        &self,
        field: &Participants<'_>,
        folder: &Path,
        protocol: Option<Protocol>,
        mut header: ResultHeader,
        work: impl FnOnce(&Contest<'_>, &[Entrant], ResultHeader) -> Result<R>,
    ) -> Result<R> {
        let common = field.common;
        self.conditions.refuse_for_folders()?;
        let (source, stored) = self.folder(folder, protocol.as_ref(), &mut header)?;
        let inputs = InputSource {
            draw: &self.draw,
            seed: common.seed,
            stored,
        };
        let mut entrants = (field.load)(inputs, &mut header)?;
        let is_tree = matches!(source, SequenceSource::Tree(_));
        let hinted = |error| match error {
            // About an image that is read, not about a file that is written.
            Error::Input { ref path, .. } | Error::Io { ref path, .. }
                if is_tree && path.starts_with(folder) =>
            {
                with_hint(error, "--keep-going leaves such sequences out")
            }
            other => other,
        };
        let readable = self.readable(source, &entrants, &mut header, common);
        let cut = readable.and_then(|source| self.cut(source, &entrants, &mut header, common));
        let source = cut.map_err(hinted)?;
        let subjects = &source.sequences().subjects;
        let protocol = match protocol {
            Some(protocol) => protocol,
            None if has_roles(&source) => Protocol::named(PARTITION)?,
            None => {
                header
                    .warnings
                    .extend(unlike_protocols(&entrants, subjects));
                usual(&entrants, subjects)?
            }
        };
        let mut header = header.with("protocol", protocol.name.as_str());
        if let (SequenceSource::Tree(_), Some(entrant)) = (&source, entrants.first()) {
            header = header
                .with("size", entrant.settings.size.name())
                .with("framing", entrant.settings.framing.name());
        }
        let contest = Contest::new(source, protocol)?;
        let baselines = field.baselines;
        baselines.add(&contest, &mut entrants, None, &mut header)?;
        work(&contest, &entrants, header).map_err(hinted)
    }

    /// Passes recognizers and a pack, by default the built-in cohort, to `work`, as [`Self::run`]
    /// does.
    fn run_on_pack<R>(
        &self,
        field: &Participants<'_>,
        pack: Option<PathBuf>,
        protocol: Option<Protocol>,
        mut header: ResultHeader,
        work: impl FnOnce(&Contest<'_>, &[Entrant], ResultHeader) -> Result<R>,
    ) -> Result<R> {
        let seed = field.common.seed;
        self.refuse_without_tree()?;
        let inputs = InputSource {
            draw: &self.draw,
            seed,
            stored: None,
        };
        let mut entrants = (field.load)(inputs, &mut header)?;
        let protocol = match protocol {
            None if pack.is_none() && self.is_open() && !self.views.is_given() => {
                let is_open_set =
                    |entrant: &Entrant| entrant.recognizer.contract().classes.is_empty();
                let is_open_set = entrants.iter().any(is_open_set);
                is_open_set.then(|| Protocol::named(SESSIONS)).transpose()?
            }
            stated => stated,
        };
        let is_unseen = pack.is_none()
            && self.held.is_none()
            && protocol.as_ref().is_some_and(|it| it.name == SESSIONS);
        let usual = protocol
            .as_ref()
            .and_then(|protocol| protocol.conditions.as_deref());
        let usual = usual.or(is_unseen.then_some(UNSEEN_CONDITIONS));
        let conditions = self.conditions.load(usual, &mut header)?;
        let unseen = || PackSource::made(&CohortOptions::unseen(), &|| Ok(()));
        let source_args = SourceArgs {
            held: match &self.held {
                None if is_unseen => Some(unseen()?),
                held => held.clone(),
            },
            ..SourceArgs::new(pack, self.selection.clone())
        };
        let source = source_args.load(field.common)?;
        header.inputs.extend(source.inputs.iter().cloned());
        let pack = Pack::parse(&source.bytes)?;
        let chosen = source_args.choose(&pack)?;
        let header = header.with("pack", source.name.as_str());
        let DrawnContest {
            contest,
            views,
            probes,
            warnings,
        } = DrawnContest::new(
            &pack,
            &chosen,
            &entrants,
            self.options(protocol, field, &conditions)?,
        )?;
        let all: Vec<_> = pack.walks().collect();
        let mut header = header
            .with("protocol", contest.protocol().name.as_str())
            .with("views", views.name.as_str())
            .with("viewpoints", views.list.len())
            .with("walks", walk_names(&chosen, &all))
            .with("subjects", self.selection.subjects.join(","))
            .with("probes", probes);
        header.warnings.extend(warnings);
        let baselines = field.baselines;
        baselines.add(&contest, &mut entrants, Some(&pack), &mut header)?;
        if let Some(entrant) = entrants.first() {
            header = header.drawn(&entrant.settings);
        }
        work(&contest, &entrants, header)
    }

    /// Returns the options of a contest of walks.
    ///
    /// # Errors
    /// If there is no such protocol or viewpoint.
    fn options<'a>(
        &self,
        protocol: Option<Protocol>,
        field: &Participants<'_>,
        conditions: &'a [Condition],
    ) -> Result<ContestOptions<'a>> {
        let says_views = |protocol: &Protocol| protocol.views.is_some();
        let usual = field.views.clone();
        let usual = usual.filter(|_| !protocol.as_ref().is_some_and(says_views));
        Ok(ContestOptions {
            protocol,
            cycles: self.cycles,
            views: self.views.given()?.or(usual),
            conditions,
        })
    }

    /// Returns the sequences of a tree that the flags choose: by people, takes (`--walks`),
    /// viewpoints, and the test people of a partition.
    fn chosen(
        &self,
        source: SequenceSource<'static>,
        header: &mut ResultHeader,
    ) -> Result<SequenceSource<'static>> {
        let SequenceSource::Tree(recordings) = source else {
            self.refuse_without_tree()?;
            return Ok(source);
        };
        let views = self.views.given()?;
        let mut recordings = recordings.chosen(&self.selection.selection(false), views.as_ref())?;
        if let Some(path) = &self.partition {
            let partition = Partition::read(path)?;
            let (parted, warnings) = recordings.tested(&partition, path)?;
            recordings = parted;
            header.inputs.push(InputFile::read(path)?);
            header.warnings.extend(warnings);
        }
        Ok(SequenceSource::Tree(Box::new(if self.as_stored {
            recordings.taken_as_stored()
        } else {
            recordings
        })))
    }

    /// Rejects flags about reading a tree where there is none.
    fn refuse_without_tree(&self) -> Result<()> {
        let flags = [
            ("--as-stored", self.as_stored),
            ("--keep-going", self.keep_going.is_given()),
            ("--partition", self.partition.is_some()),
        ]
        .into_iter();
        refuse_without_tree(flags.chain(self.cutting.given()).chain(self.layout.given()))
    }

    /// Returns the source; with `--keep-going`, without the sequences of a tree that cannot be
    /// shown to all entrants. The choice depends on the sequences alone, not on the protocol.
    fn readable(
        &self,
        source: SequenceSource<'static>,
        entrants: &[Entrant],
        header: &mut ResultHeader,
        common: &Common,
    ) -> Result<SequenceSource<'static>> {
        let recordings = match source {
            SequenceSource::Tree(recordings) if self.keep_going.is_given() => recordings,
            SequenceSource::Tree(recordings) => {
                let progress = Progress::new(common, ("reading", "folders"), recordings.len());
                let sizes: Vec<_> = entrants
                    .iter()
                    .map(|entrant| entrant.settings.size)
                    .collect();
                recordings.check_sizes(&sizes, &|| progress.step())?;
                return Ok(SequenceSource::Tree(recordings));
            }
            other => return Ok(other),
        };
        let mut forms: Vec<Form> = Vec::new();
        for entrant in entrants {
            if !forms.contains(&entrant.form()) {
                forms.push(entrant.form());
            }
        }
        let all = recordings.len();
        let progress = Progress::new(common, ("reading", "folders"), all);
        let (recordings, refused) = recordings.readable(&forms, &|| progress.step())?;
        let warnings = self
            .keep_going
            .leave_out(refused, all, "sequences", "read")?;
        if !warnings.is_empty() {
            let count = warnings.len();
            header.warnings.extend(warnings);
            header
                .warnings
                .push(format!("{count} of {all} sequences were left out"));
        }
        Ok(SequenceSource::Tree(Box::new(recordings)))
    }

    /// Cuts the recordings of a tree into gait cycles for the recognizers that take templates; the
    /// others are shown whole recordings.
    fn cut(
        &self,
        source: SequenceSource<'static>,
        entrants: &[Entrant],
        header: &mut ResultHeader,
        common: &Common,
    ) -> Result<SequenceSource<'static>> {
        let takes_template =
            |entrant: &Entrant| entrant.recognizer.contract().template != Template::Silhouettes;
        let SequenceSource::Tree(mut recordings) = source else {
            return Ok(source);
        };
        if !entrants.iter().any(takes_template) {
            return Ok(SequenceSource::Tree(recordings));
        }
        if !entrants.iter().all(takes_template) {
            *recordings = recordings.keeping_whole();
        }
        let cut = self.cutting.cut(*recordings, header, common)?;
        Ok(SequenceSource::Tree(Box::new(cut)))
    }

    /// Opens a folder; of a dataset, also returns the form of its stored templates.
    fn folder(
        &self,
        path: &Path,
        protocol: Option<&Protocol>,
        header: &mut ResultHeader,
    ) -> Result<(SequenceSource<'static>, Option<StoredTemplates>)> {
        let first_take = Protocol::named("first-take")?;
        let made = protocol.unwrap_or(&first_take).made(1)?;
        let source = SequenceSource::open(path, &made, &self.layout.layout())?;
        let source = self.chosen(source, header)?;
        let is_tree = matches!(source, SequenceSource::Tree(_));
        let draw = if is_tree {
            self.draw.without_size()
        } else {
            self.draw.clone()
        };
        if is_tree {
            let none = SelectionArgs::default();
            draw.refuse_for_folders(&none, self.cycles, &ViewArgs::default())?;
        } else {
            draw.refuse_for_folders(&self.selection, self.cycles, &self.views)?;
        }
        let mut stored = None;
        if let SequenceSource::Dataset(geis) = &source {
            header.inputs.extend(Dataset::inputs(path)?);
            header.warnings.extend(Dataset::said_of_pictures(path));
            let found = StoredTemplates::from_dataset(geis.dataset(), path)?;
            if found.framing.is_none() {
                header.warnings.push(format!(
                    "{} does not state how its figures are framed: the framing may not be the one that the models expect",
                    path.display()
                ));
            }
            *header = header.clone().drawn_as(geis.dataset());
            stored = Some(found);
        }
        if let SequenceSource::Tree(recordings) = &source {
            let skipped = recordings.skipped().iter();
            let skipped =
                skipped.map(|name| format!("{name}: left out: no view is named by an angle"));
            header.warnings.extend(skipped);
            header.warnings.extend(recordings.doubts());
            let partition = path.join(TREE_PARTITION);
            if self.partition.is_none() && partition.is_file() {
                header.warnings.push(format!(
                    "{} splits people into training and test people: without --partition {0}, all of them are scored",
                    partition.display()
                ));
            }
            *header = header.clone().with("as_stored", self.as_stored);
        }
        let kind = if is_tree { "tree" } else { "dataset" };
        *header = header.clone().with(kind, path.display().to_string());
        Ok((source, stored))
    }
}

/// Returns whether a partition of a tree chooses gallery and probes.
fn has_roles(source: &SequenceSource<'_>) -> bool {
    matches!(source, SequenceSource::Tree(recordings) if recordings.has_roles())
}

/// Returns the names of walks, without duplicates; only their number if there are more than 12.
fn walk_names(walks: &[usize], all: &[edgegait_core::pack::WalkEntry<'_>]) -> String {
    let mut names: Vec<&str> = walks.iter().map(|&walk| all[walk].name).collect();
    names.sort_unstable();
    names.dedup();
    if names.len() > 12 {
        return format!("{} names", names.len());
    }
    names.join(",")
}
