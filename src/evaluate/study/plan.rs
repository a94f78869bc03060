//! The inputs of a study, checked before any long work: takes of silhouettes, the recordings that
//! they show, and bodies.

use super::manifest::{self, Pairing, listed};
use super::real_cycles::ShownTake;
use super::twins::{ShownSpan, TwinRecording, find};
use crate::dataset::Tree;
use crate::draw::sweep::View;
use crate::error::{Error, FilePlace, Result};
use crate::files::InputFile;
use crate::people::measured::MeasuredPeople;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The paths of a study's data.
#[derive(Clone, Debug)]
pub(crate) struct Paths {
    /// The tree of real silhouettes.
    pub real: PathBuf,
    /// The folders of recordings.
    pub motions: Vec<PathBuf>,
    /// The manifest, which pairs takes with recordings.
    pub manifest: PathBuf,
    /// The measurements of the people; if not given, `bodies.csv` beside the manifest, if any.
    pub bodies: Option<PathBuf>,
    /// The measurements with clothes and hair; if not given, `bodies_dressed.csv` there.
    pub dressed: Option<PathBuf>,
}

/// A viewpoint of a study.
#[derive(Clone, Debug)]
pub(crate) struct StudyView {
    /// The view's name in the tree.
    pub name: String,
    /// The viewpoint.
    pub view: View,
    /// The distance from the camera to the walker, metres.
    pub distance_m: f64,
}

/// The checked inputs of a study.
pub(crate) struct StudyPlan {
    /// The real silhouettes.
    pub tree: Tree,
    /// The names of the people.
    pub people: Vec<String>,
    /// The names of the takes, as `<person>/<take>`.
    pub takes: Vec<String>,
    /// The takes from each viewpoint.
    pub shown: Vec<ShownTake>,
    /// The viewpoints.
    pub views: Vec<StudyView>,
    /// The recordings.
    pub sources: Vec<TwinRecording>,
    /// The measured bodies of the twins, if any.
    pub bodies: Option<MeasuredPeople>,
    /// The bodies measured with clothes and hair, if any.
    pub dressed: Option<MeasuredPeople>,
    /// The tables that were read.
    pub inputs: Vec<InputFile>,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

/// The default viewpoints; those that the manifest has are used.
const VIEWS: [&str; 3] = ["090", "045", "000"];

impl StudyPlan {
    /// Checks everything that can be checked before silhouettes are read. `views` and `people` are
    /// the wanted ones; if empty, the default viewpoints and all people. `distance_m` applies to
    /// rows that state none.
    ///
    /// # Errors
    /// If the manifest cannot be read or names takes, recordings or people that do not exist, or if
    /// there are fewer than two people.
    pub(crate) fn new(
        paths: &Paths,
        views: &[String],
        people: &[String],
        distance_m: f64,
    ) -> Result<Self> {
        let rows = manifest::read(&paths.manifest)?;
        let tree = Tree::open(&paths.real, &crate::dataset::TreeLayout::default())?;
        let wanted = chosen_views(&rows, views)?;
        check_people(&rows, people)?;
        let rows: Vec<Pairing> = rows
            .into_iter()
            .filter(|row| wanted.contains(&row.view))
            .filter(|row| people.is_empty() || people.contains(&row.person))
            .collect();
        let mut plan = Self {
            tree,
            people: Vec::new(),
            takes: Vec::new(),
            shown: Vec::new(),
            views: Vec::new(),
            sources: Vec::new(),
            bodies: None,
            dressed: None,
            inputs: vec![InputFile::read(&paths.manifest)?],
            warnings: Vec::new(),
        };
        plan.pair(rows, paths)?;
        for name in &wanted {
            plan.add_view(name, distance_m, &paths.manifest)?;
        }
        if plan.people.len() < 2 {
            return Err(Error::input(
                &paths.manifest,
                format!(
                    "expected two people or more to tell apart, found {}",
                    listed(&plan.people)
                ),
            ));
        }
        for shown in &plan.shown {
            plan.tree.check_size(shown.sequence, &[])?;
        }
        plan.bodies = plan.measured(&paths.manifest, paths.bodies.as_deref(), "bodies.csv")?;
        plan.dressed = plan.measured(
            &paths.manifest,
            paths.dressed.as_deref(),
            "bodies_dressed.csv",
        )?;
        if plan.bodies.is_none() {
            plan.warnings.push("no measurements of the people: the bodies of their twins are estimated from their recordings".into());
        }
        Ok(plan)
    }

    /// Finds the silhouettes and recordings of the rows.
    fn pair(&mut self, rows: Vec<Pairing>, paths: &Paths) -> Result<()> {
        let sequences = self.tree.sequences();
        let number = |row: &Pairing| {
            sequences.iter().position(|sequence| {
                sequence.subject == row.person
                    && sequence.take == row.take
                    && sequence.view == row.view
            })
        };
        let lacking: Vec<String> = rows
            .iter()
            .filter(|row| number(row).is_none())
            .map(|row| format!("{}/{}/{}", row.person, row.take, row.view))
            .collect();
        if lacking.len() == rows.len() {
            let names: BTreeSet<String> = sequences
                .iter()
                .map(|sequence| sequence.subject.clone())
                .collect();
            return Err(Error::input(
                &paths.manifest,
                format!(
                    "expected takes that are in {}, found none: it has the people {}, the manifest has {}",
                    paths.real.display(),
                    listed(&names.into_iter().collect::<Vec<_>>()),
                    listed(&each_once(rows.iter().map(|row| row.person.clone())))
                ),
            ));
        }
        if !lacking.is_empty() {
            return Err(Error::input(
                &paths.manifest,
                format!(
                    "expected takes that are in {}, found {} of {} that are not: {}",
                    paths.real.display(),
                    lacking.len(),
                    rows.len(),
                    listed(&lacking)
                ),
            ));
        }
        let unpaired: BTreeSet<&str> = sequences
            .iter()
            .map(|sequence| sequence.subject.as_str())
            .filter(|name| rows.iter().all(|row| row.person != *name))
            .collect();
        if !unpaired.is_empty() {
            self.warnings.push(format!(
                "{} people of {} are left out: no used row of the manifest names them",
                unpaired.len(),
                paths.real.display()
            ));
        }
        for row in rows {
            let sequence = number(&row).ok_or(Error::Missing("a sequence"))?;
            let path = find(&row, &paths.manifest, &paths.motions)?;
            let person = place(&mut self.people, &row.person);
            let take = place(&mut self.takes, &format!("{}/{}", row.person, row.take));
            let source = self
                .sources
                .iter()
                .position(|source| source.person == person && source.path == path);
            let source = source.unwrap_or_else(|| {
                self.sources.push(TwinRecording {
                    person,
                    path,
                    takes: Vec::new(),
                });
                self.sources.len() - 1
            });
            let takes = &mut self.sources[source].takes;
            if takes.iter().all(|known| known.take != take) {
                let start = row.offset / row.fps;
                let last = row.cycles.iter().flatten().map(|cycle| cycle.1);
                let end = last.fold(None, |most: Option<f64>, at| {
                    Some(most.map_or(at, |m| m.max(at)))
                });
                let end = end.map_or(f64::INFINITY, |frame| start + frame / row.fps);
                takes.push(ShownSpan {
                    take,
                    span_s: (start, end),
                });
            }
            self.shown.push(ShownTake {
                pairing: row,
                sequence,
                person,
                take,
            });
        }
        Ok(())
    }

    /// Adds a viewpoint, which all of its rows have to agree about.
    fn add_view(&mut self, name: &str, distance_m: f64, manifest: &Path) -> Result<()> {
        let mut found: Option<(View, f64, usize)> = None;
        for shown in self.shown.iter().filter(|shown| shown.pairing.view == name) {
            let row = &shown.pairing;
            let named = self.tree.sequences()[shown.sequence].angles_deg;
            #[expect(clippy::cast_possible_truncation, reason = "degrees")]
            let angles = row
                .angles_deg
                .or_else(|| named.map(|(azimuth, elevation)| (azimuth as f32, elevation as f32)));
            let refuse = |problem| Err(Error::at(manifest, FilePlace::Line(row.line), problem));
            let Some((azimuth, elevation)) = angles else {
                return refuse(format!(
                    "azimuth: expected degrees, since the view's name {name:?} states none"
                ));
            };
            let view = match View::new(azimuth, elevation) {
                Ok(view) => view,
                Err(error) => return refuse(error.to_string()),
            };
            let distance_m = row.distance_m.unwrap_or(distance_m);
            match found {
                Some((known, metres, line)) if known != view || metres != distance_m => {
                    return refuse(format!(
                        "view {name:?}: expected one camera for all its takes, found another in line {line}"
                    ));
                }
                _ => found = Some((view, distance_m, row.line)),
            }
        }
        if let Some((view, distance_m, _)) = found {
            self.views.push(StudyView {
                name: name.to_owned(),
                view,
                distance_m,
            });
        }
        Ok(())
    }

    /// Reads measurements from a table, or from the file `usual` beside the manifest.
    fn measured(
        &mut self,
        manifest: &Path,
        given: Option<&Path>,
        usual: &str,
    ) -> Result<Option<MeasuredPeople>> {
        let beside = manifest.with_file_name(usual);
        let path = match given {
            Some(path) => path,
            None if beside.is_file() => &beside,
            None => return Ok(None),
        };
        let (measured, unusable) = MeasuredPeople::read_among_others(path)?;
        self.inputs.push(InputFile::read(path)?);
        if let Some(first) = unusable.first() {
            self.warnings.push(format!(
                "{first}: treated as not measured{}",
                match unusable.len() - 1 {
                    0 => String::new(),
                    more => format!(", as are {more} more fields of that table"),
                }
            ));
        }
        let without: Vec<String> = self
            .people
            .iter()
            .filter(|person| measured.person(person).is_none())
            .cloned()
            .collect();
        if !without.is_empty() {
            self.warnings.push(format!(
                "{}: no row for {}: the bodies of their twins are estimated",
                path.display(),
                listed(&without)
            ));
        }
        Ok(Some(measured))
    }
}

/// Returns the wanted views of a manifest, or else the default ones, or else all.
fn chosen_views(rows: &[Pairing], wanted: &[String]) -> Result<Vec<String>> {
    let known = each_once(rows.iter().map(|row| row.view.clone()));
    if let Some(unknown) = wanted.iter().find(|name| !known.contains(name)) {
        return Err(Error::Usage(format!(
            "there is no view {unknown:?} in the manifest: expected one of {}",
            listed(&known)
        )));
    }
    if !wanted.is_empty() {
        return Ok(each_once(wanted.iter().cloned()));
    }
    let usual: Vec<String> = VIEWS.map(str::to_owned).into();
    let usual: Vec<String> = usual
        .into_iter()
        .filter(|name| known.contains(name))
        .collect();
    Ok(if usual.is_empty() { known } else { usual })
}

fn check_people(rows: &[Pairing], wanted: &[String]) -> Result<()> {
    let known = each_once(rows.iter().map(|row| row.person.clone()));
    match wanted.iter().find(|name| !known.contains(name)) {
        Some(unknown) => Err(Error::Usage(format!(
            "there is no person {unknown:?} in the manifest: expected one of {}",
            listed(&known)
        ))),
        None => Ok(()),
    }
}

/// Returns the index of a name in a list, and adds it if needed.
fn place(names: &mut Vec<String>, name: &str) -> usize {
    names
        .iter()
        .position(|known| known == name)
        .unwrap_or_else(|| {
            names.push(name.to_owned());
            names.len() - 1
        })
}

fn each_once(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut seen = BTreeSet::new();
    names.filter(|name| seen.insert(name.clone())).collect()
}
