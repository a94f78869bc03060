//! The contests that judge recognizers under each class of confounder.

use crate::dataset::kmh;
use crate::dataset::sequences::{BUILT_IN_WALK, Recordings, SequenceSource};
use crate::draw::confounders::{Condition, Conditions};
use crate::draw::sweep::Views;
use crate::encode::{Effort, MAX_ERROR_MM, encode_population};
use crate::error::{Error, Result};
use crate::evaluate::contest::{Contest, ContestOptions, DrawnContest, Entrant};
use crate::evaluate::intervals::Rank1Intervals;
use crate::evaluate::paired_results::PersonResult;
use crate::evaluate::protocol::Protocol;
use crate::evaluate::rank1::Tally;
use crate::evaluate::results::ProbeSetResult;
use crate::people::cohort::{self, CohortOptions};
use edgegait_core::pack::Pack;
use serde::Serialize;
use std::ops::Range;

/// The people and cycles of the contests.
#[derive(Clone, Debug)]
pub(crate) struct ContestPlan {
    /// Numbers of the people that recognizers learn from.
    pub training: Range<usize>,
    /// Numbers of the people that recognizers are judged on.
    pub people: Range<usize>,
    /// Probe cycles under each condition.
    pub cycles: u32,
    /// The seed of all random numbers.
    pub seed: u64,
}

/// A class of confounders.
#[derive(Serialize)]
pub(crate) struct ConfounderClass {
    pub name: &'static str,
    /// The changes of the probes, in words.
    pub what: &'static str,
    #[serde(skip)]
    of: Of,
}

/// The probes of a class.
enum Of {
    /// Probes under each of these confounders alone, from the gallery's viewpoint.
    Conditions(&'static [&'static str]),
    /// Probes from other viewpoints than the gallery's.
    Views,
    /// Probes at these speeds, km/h.
    Speeds(&'static [f64]),
}

/// Classes of confounders, in the order of a table. They use the catalogue's confounders at
/// strength 1, without confounders of the camera and of the body itself.
pub(crate) const COLUMNS: [ConfounderClass; 8] = [
    ConfounderClass {
        name: "normal",
        what: "another cycle",
        of: Of::Conditions(&["normal"]),
    },
    ConfounderClass {
        name: "view",
        what: "seen from 13 azimuths, 0 to 180 degrees, each against each other one",
        of: Of::Views,
    },
    ConfounderClass {
        name: "speed",
        what: "walks at 3, 4, 6 and 7 km/h",
        of: Of::Speeds(&[3.0, 4.0, 6.0, 7.0]),
    },
    ConfounderClass {
        name: "run",
        what: "runs at 8 to 12 km/h",
        of: Of::Speeds(&[8.0, 9.0, 10.0, 11.0, 12.0]),
    },
    ConfounderClass {
        name: "clothes",
        what: "closed and open coat, down jacket, skirt, wide trousers, shoes, hood, hat, long hair",
        of: Of::Conditions(&[
            "coat",
            "open-coat",
            "down-jacket",
            "skirt",
            "wide-trousers",
            "shoes",
            "hood",
            "hat",
            "hair",
        ]),
    },
    ConfounderClass {
        name: "carrying",
        what: "backpack, shoulder bag, suitcase, umbrella, box, stroller",
        of: Of::Conditions(&[
            "backpack",
            "shoulder-bag",
            "suitcase",
            "umbrella",
            "carried-box",
            "stroller",
        ]),
    },
    ConfounderClass {
        name: "occlusion",
        what: "a pillar, a person who crosses",
        of: Of::Conditions(&["static-occluder", "moving-occluder"]),
    },
    ConfounderClass {
        name: "segmentation",
        what: "light, holes, missing parts, merged background, erosion, dilation, waver, noise",
        of: Of::Conditions(&[
            "light",
            "holes",
            "missing-parts",
            "merged-background",
            "erosion",
            "dilation",
            "waver",
            "filtered-noise",
            "salt-and-pepper",
        ]),
    },
];

/// Rank-1 of a recognizer under a class of confounders.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct ClassRank1 {
    /// The class, or the configuration.
    pub class: String,
    /// Probes of all its confounders.
    pub probes: u64,
    /// People who are probed.
    pub people: usize,
    /// Rank-1, 0..1.
    pub rank1: f64,
    #[serde(flatten)]
    pub intervals: Rank1Intervals,
}

/// The protocol of each contest from one viewpoint, without the names of takes.
const PROTOCOL: &str = r#"
name = "literature"
description = "People are enrolled by one cycle of their walk, and probed with others."
decision = "nearest embedding"
gallery_views = "same"
made = [{ take = "enrolled", variation = 0 }, { take = "probe", variation = 1000 }]
"#;

/// The gallery and probes of a protocol that enrols people by one cycle each.
const ONE_CYCLE: &str =
    "[gallery]\norder = \"first\"\n[[probes]]\nname = \"all\"\norder = \"others\"";

impl ContestPlan {
    /// Encodes the people of these numbers, at the ten built-in speeds, as a pack.
    ///
    /// # Errors
    /// As [`encode_population`].
    pub(crate) fn pack(
        &self,
        people: &Range<usize>,
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<Vec<u8>> {
        let options = CohortOptions {
            seed: self.seed,
            first: people.start,
            people: people.len(),
            ..CohortOptions::default()
        };
        let make = |number| cohort::subject(&options, number);
        encode_population(people.clone(), &make, MAX_ERROR_MM, Effort::Quick, progress)
    }
}

/// The number of contests: of conditions, of configurations, of speeds, and of viewpoints.
pub(crate) const CONTESTS: usize = 4;

/// The results of a recognizer.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct JudgedRecognizer {
    /// A cell for each class, in the order of [`COLUMNS`].
    pub cells: Vec<ClassRank1>,
    /// A cell for each configuration of TUM-IITKGP; empty for recorded people.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub configurations: Vec<ClassRank1>,
}

/// Judges recognizers in all contests on the people of a pack, at all speeds. Calls `progress` once
/// for each contest.
///
/// # Errors
/// If a probe cannot be rendered, or a recognizer fails.
pub(crate) fn judge(
    pack: &Pack<'_>,
    entrants: &[Entrant],
    plan: &ContestPlan,
    progress: &dyn Fn() -> Result<()>,
) -> Result<Vec<JudgedRecognizer>> {
    let walks: Vec<_> = pack.walks().collect();
    let all: Vec<usize> = (0..walks.len()).collect();
    let at_known: Vec<usize> = all
        .iter()
        .copied()
        .filter(|&walk| walks[walk].name == BUILT_IN_WALK)
        .collect();
    let conditions = conditions(&COLUMNS.each_ref().map(|column| column.name))?;
    let side = Views::side()?;
    let under = |conditions: &[Condition]| {
        let options = ContestOptions {
            protocol: Some(protocol(ONE_CYCLE)?),
            cycles: Some(plan.cycles),
            views: Some(side.clone()),
            conditions,
        };
        probe_sets(pack, &at_known, entrants, options, plan.seed)
    };
    let of_conditions = under(&conditions)?;
    progress()?;
    let configurations = under(&Conditions::named("tum-iitkgp")?.list)?;
    progress()?;
    let mut names: Vec<&str> = walks.iter().map(|walk| walk.name).collect();
    names.sort_unstable();
    names.dedup();
    names.retain(|name| *name != BUILT_IN_WALK);
    let sets: String = names
        .iter()
        .map(|name| format!("[[probes]]\nname = {name:?}\ntakes = [{name:?}]\n"))
        .collect();
    let of_speeds = probe_sets(
        pack,
        &all,
        entrants,
        ContestOptions {
            protocol: Some(protocol(&format!(
                "[gallery]\ntakes = [{BUILT_IN_WALK:?}]\n{sets}"
            ))?),
            views: Some(side.clone()),
            ..ContestOptions::default()
        },
        plan.seed,
    )?;
    progress()?;
    let of_views = probe_sets(
        pack,
        &at_known,
        entrants,
        ContestOptions {
            protocol: Some(Protocol::named("cross-view")?),
            ..ContestOptions::default()
        },
        plan.seed,
    )?;
    progress()?;
    let judged = |at: usize| -> Result<JudgedRecognizer> {
        let cell = |column: &ConfounderClass| {
            let found = match column.of {
                Of::Conditions(names) => people(&of_conditions[at], |name| names.contains(&name)),
                Of::Speeds(speeds) => people(&of_speeds[at], |name| {
                    let walk = walks.iter().find(|walk| walk.name == name);
                    let speed = walk.map_or(0.0, |walk| kmh(walk.speed_mm_per_s));
                    speeds.iter().any(|other| (other - speed).abs() < 0.05)
                }),
                Of::Views => people(&of_views[at], |_| true),
            };
            ClassRank1::from_people(column.name, &found, plan.seed)
        };
        let of_one =
            |set: &ProbeSetResult| ClassRank1::from_people(&set.name, &set.by_person, plan.seed);
        let configurations = configurations[at].iter().map(of_one);
        Ok(JudgedRecognizer {
            cells: COLUMNS.iter().map(cell).collect::<Result<_>>()?,
            configurations: configurations.collect::<Result<_>>()?,
        })
    };
    (0..entrants.len()).map(judged).collect()
}

/// Judges recognizers on the gait cycles of a tree, each of which is a take of its own
/// ([`Recordings::by_cycle`]). Each person is enrolled by the first cycle, and probed with others
/// from the same viewpoint (class "normal") and from each other one ("view"). Also returns
/// warnings.
///
/// # Errors
/// If no person has several cycles, a frame cannot be read, or a recognizer fails.
pub(crate) fn judge_recorded(
    cycles: Recordings,
    entrants: &[Entrant],
    seed: u64,
) -> Result<(Vec<JudgedRecognizer>, Vec<String>)> {
    let mut warnings: Vec<String> = Vec::new();
    let mut judged = vec![JudgedRecognizer::default(); entrants.len()];
    let mut source = SequenceSource::Tree(Box::new(cycles));
    let same = protocol(ONE_CYCLE)?;
    for (class, protocol) in [("normal", same), ("view", Protocol::named("cross-view")?)] {
        let contest = Contest::new(source, protocol)?;
        let outcome = contest.run(entrants, seed, &mut |_| Ok(()), &mut |_| Ok(()))?;
        warnings.extend(
            outcome
                .warnings
                .iter()
                .map(|warning| format!("{class}: {warning}")),
        );
        // The same for all recognizers.
        let sets = outcome.results.first().map(|first| &first.probe_sets);
        let without_mate: u64 = sets.into_iter().flatten().map(|set| set.without_mate).sum();
        if without_mate > 0 {
            warnings.push(format!(
                "{class}: {without_mate} probes of people who are not in the gallery count as misses"
            ));
        }
        for (judged, result) in judged.iter_mut().zip(outcome.results) {
            let found = people(&result.probe_sets, |_| true);
            judged
                .cells
                .push(ClassRank1::from_people(class, &found, seed)?);
        }
        source = contest.into_source();
    }
    Ok((judged, warnings))
}

impl ClassRank1 {
    /// Makes the cell from results of people, and adds up several entries of a person.
    ///
    /// # Errors
    /// If there are no probes.
    fn from_people(class: &str, found: &[PersonResult], seed: u64) -> Result<Self> {
        let mut people: Vec<(&str, Tally)> = Vec::new();
        for one in found {
            let tally = Tally {
                probes: one.probes,
                hits: one.hits,
                ..Tally::default()
            };
            match people.iter_mut().find(|(name, _)| *name == one.person) {
                Some((_, sum)) => *sum += tally,
                None => people.push((&one.person, tally)),
            }
        }
        let tallies: Vec<Tally> = people.iter().map(|(_, tally)| *tally).collect();
        let all: Tally = tallies.iter().copied().sum();
        Ok(Self {
            class: class.to_owned(),
            probes: all.probes,
            people: people.len(),
            rank1: all.rank1().ok_or(Error::Missing("probes of a class"))?,
            intervals: Rank1Intervals::from_tallies(&tallies, seed),
        })
    }
}

/// Returns the results of people in the probe sets of some names.
fn people(sets: &[ProbeSetResult], is_of: impl Fn(&str) -> bool) -> Vec<PersonResult> {
    let of = sets.iter().filter(|set| is_of(&set.name));
    of.flat_map(|set| set.by_person.clone()).collect()
}

/// Returns the viewpoints of the class "view".
///
/// # Errors
/// Never.
pub(super) fn cross_views() -> Result<Views> {
    let protocol = Protocol::named("cross-view")?;
    let grid = protocol
        .views
        .ok_or(Error::Missing("viewpoints of a protocol"))?;
    Views::grid("cross-view", grid.azimuth_deg, grid.elevation_deg)
}

/// Returns the confounders of the classes of these names, each alone.
///
/// # Errors
/// Never.
pub(super) fn conditions(classes: &[&str]) -> Result<Vec<Condition>> {
    let each = Conditions::named("each")?;
    let is_of = |condition: &Condition| {
        let mut columns = COLUMNS
            .iter()
            .filter(|column| classes.contains(&column.name));
        columns.any(|column| match column.of {
            Of::Conditions(names) => names.contains(&condition.name.as_str()),
            Of::Views | Of::Speeds(_) => false,
        })
    };
    Ok(each.list.into_iter().filter(is_of).collect())
}

fn protocol(parts: &str) -> Result<Protocol> {
    let text = format!("{PROTOCOL}{parts}");
    toml::from_str(&text).map_err(|error| Error::Failed(error.to_string()))
}

fn probe_sets(
    pack: &Pack<'_>,
    walks: &[usize],
    entrants: &[Entrant],
    options: ContestOptions<'_>,
    seed: u64,
) -> Result<Vec<Vec<ProbeSetResult>>> {
    let drawn = DrawnContest::new(pack, walks, entrants, options)?;
    let outcome = drawn
        .contest
        .run(entrants, seed, &mut |_| Ok(()), &mut |_| Ok(()))?;
    let sets = outcome.results.into_iter().map(|result| result.probe_sets);
    Ok(sets.collect())
}
