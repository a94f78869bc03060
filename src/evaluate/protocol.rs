//! Protocols as data: who is looked for among whom.
//!
//! A protocol chooses takes by name, condition or order, and knows nothing of how their pictures were
//! made, so that a pack, a dataset and a tree of silhouettes are judged alike. Those of
//! [`NAMES`] are built in; others are TOML files of the same keys.

use std::collections::HashMap;
use std::path::Path;

use serde::Deserialize;

use crate::confounders::{Condition, NORMAL};
use crate::error::{Error, EvaluateError, Result};
use crate::named_or_file::toml_of;
use crate::people::variation::CYCLES_OF_A_TAKE;
use crate::sequences::{MadeTake, SequenceTake};

/// The first variation that no training of this program uses: those that are looked for begin here.
pub const FIRST_UNSEEN: u32 = 1_000;
/// The last variation that there is.
pub const MAX_VARIATION: u32 = 1_000_000;

/// Names of the built-in protocols.
pub const NAMES: [&str; 8] = [
    "closed-set",
    "first-take",
    "leave-one-take-out",
    "cross-view",
    "verification",
    "casia-b",
    "ou-mvlp",
    PARTITION,
];

/// The protocol of a partition that says which sequences are looked for among which.
pub const PARTITION: &str = "partition";

const BUILT_IN: [&str; 8] = [
    include_str!("protocols/closed-set.toml"),
    include_str!("protocols/first-take.toml"),
    include_str!("protocols/leave-one-take-out.toml"),
    include_str!("protocols/cross-view.toml"),
    include_str!("protocols/verification.toml"),
    include_str!("protocols/casia-b.toml"),
    include_str!("protocols/ou-mvlp.toml"),
    include_str!("protocols/partition.toml"),
];

/// Who is looked for among whom.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Protocol {
    /// What it is called in results.
    pub name: String,
    /// What it does, in a sentence.
    pub description: String,
    /// What decides who a probe shows.
    pub decision: Decision,
    /// Which of the gallery's viewpoints a probe is compared with.
    #[serde(default)]
    pub gallery_views: GalleryViews,
    /// Whether a probe is not compared with cycles of its own take.
    #[serde(default)]
    pub exclude_own_take: bool,
    /// The takes that people are known by; none if class scores decide.
    pub gallery: Option<TakeChoice>,
    /// The takes that are looked for, in sets that are reported apart.
    pub probes: Vec<ProbeSet>,
    /// The conditions that made takes name: built in, or a `.toml` file.
    pub conditions: Option<String>,
    /// Takes that a walk stands for where nobody has more than one.
    #[serde(default)]
    pub made: Vec<MadeTake>,
    /// From where walks are drawn unless a user says otherwise; the paper's 703 viewpoints if absent.
    pub views: Option<ViewpointGrid>,
}

/// Viewpoints: every azimuth with every elevation.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewpointGrid {
    /// Degrees.
    pub azimuth_deg: Vec<f32>,
    /// Degrees.
    pub elevation_deg: Vec<f32>,
}

/// What decides who a probe shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Decision {
    /// The class with the highest score.
    #[serde(rename = "class score")]
    ClassScore,
    /// The nearest embedding of the gallery.
    #[serde(rename = "nearest embedding")]
    NearestEmbedding,
}

/// Which of the gallery's viewpoints a probe is compared with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GalleryViews {
    /// All at once.
    #[default]
    All,
    /// The probe's own.
    Same,
    /// Each of them for itself. The probe's own counts in no rate.
    Each,
    /// Those that the recognizer was trained at, all at once; the side view if it does not say.
    Training,
}

/// Which takes are meant.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TakeChoice {
    /// Names, `*` for any characters at the end; all names if empty.
    pub takes: Vec<String>,
    /// Conditions; all if empty.
    pub conditions: Vec<String>,
    /// Which of those of each person.
    pub order: TakeOrder,
}

/// Which of a person's takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TakeOrder {
    /// All of them.
    #[default]
    All,
    /// The first.
    First,
    /// All but the first.
    Others,
}

/// Takes that are looked for and reported together.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProbeSet {
    /// What they are called in results, such as `BG`.
    pub name: String,
    /// Names, as in [`TakeChoice`].
    #[serde(default)]
    pub takes: Vec<String>,
    /// Conditions, as in [`TakeChoice`].
    #[serde(default)]
    pub conditions: Vec<String>,
    /// Which of those of each person.
    #[serde(default)]
    pub order: TakeOrder,
    /// Whether nothing acts on these walks: results lead with such sets, apart from all others.
    #[serde(default)]
    pub clean: bool,
}

/// What part each take has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TakeRoles {
    /// Whether people are known by the take.
    pub gallery: Vec<bool>,
    /// For each set of probes, whether the take is in it.
    pub probes: Vec<Vec<bool>>,
}

impl TakeRoles {
    /// Whether a take is in any set of probes.
    #[must_use]
    pub fn is_probed(&self, take: usize) -> bool {
        self.probes.iter().any(|set| set[take])
    }
}

impl TakeRoles {
    /// The parts of takes that are probed under conditions, as [`Protocol::under`] has them: those
    /// that the same takes have without.
    #[must_use]
    pub fn under(
        &self,
        conditions: &[Condition],
        plain: &[SequenceTake],
        takes: &[SequenceTake],
    ) -> Self {
        let origin = |take: &SequenceTake| {
            let same =
                |other: &SequenceTake| (other.subject, &other.name) == (take.subject, &take.name);
            plain.iter().position(same)
        };
        let parts = |part: &[bool], condition: &str| {
            let has = |take: &SequenceTake| {
                take.condition == condition && origin(take).is_some_and(|take| part[take])
            };
            takes.iter().map(has).collect()
        };
        let under = |set: &Vec<bool>| -> Vec<Vec<bool>> {
            let each = conditions.iter();
            each.map(|condition| parts(set, &condition.name)).collect()
        };
        Self {
            gallery: parts(&self.gallery, NORMAL),
            probes: self.probes.iter().flat_map(under).collect(),
        }
    }
}

impl Protocol {
    /// A built-in protocol by its name, or that of a `.toml` file.
    ///
    /// # Errors
    /// If there is no such protocol, or the file cannot be used.
    pub fn named(name: &str) -> Result<Self> {
        let text = toml_of(name, "protocol", &NAMES, &BUILT_IN)?;
        Self::parse(Path::new(name), &text)
    }

    /// A protocol from TOML; `path` is for messages.
    ///
    /// # Errors
    /// If the text is not TOML, a key is unknown, or the protocol makes no sense.
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let protocol: Self =
            toml::from_str(text).map_err(|error| Error::toml(path, text, &error))?;
        match protocol.problem() {
            Some(problem) => Err(Error::input(path, problem)),
            None => Ok(protocol),
        }
    }

    fn problem(&self) -> Option<String> {
        let by_scores = self.decision == Decision::ClassScore;
        if by_scores != self.gallery.is_none() {
            return Some(
                "expected a [gallery] where the nearest embedding decides, and none where class scores do".into(),
            );
        }
        if by_scores && self.gallery_views != GalleryViews::All {
            return Some("gallery_views: class scores are compared with no gallery".into());
        }
        if self.probes.is_empty() {
            return Some("expected at least one [[probes]]".into());
        }
        let twice = |names: Vec<&str>| {
            let repeated = names.iter().enumerate();
            let repeated = repeated.filter(|(at, name)| names[..*at].contains(name));
            repeated.map(|(_, name)| (*name).to_owned()).next()
        };
        if let Some(name) = twice(self.probes.iter().map(|set| set.name.as_str()).collect()) {
            return Some(format!("probes: {name:?} appears twice"));
        }
        if let Some(name) = twice(self.made.iter().map(|one| one.take.as_str()).collect()) {
            return Some(format!("made: {name:?} appears twice"));
        }
        let named = self.made.iter().any(|one| one.condition.is_some());
        if named != self.conditions.is_some() {
            return Some(
                "expected conditions where takes of made name one, and none elsewhere".into(),
            );
        }
        let out_of_range = self.made.iter().find(|one| {
            let least = if self.is_probed(one) { FIRST_UNSEEN } else { 0 };
            !(least..=MAX_VARIATION).contains(&one.variation)
        });
        if let Some(MadeTake {
            take, variation, ..
        }) = out_of_range
        {
            return Some(format!(
                "made: take {take:?}: expected a variation from 0 to {MAX_VARIATION}, and from {FIRST_UNSEEN} on (which training never uses) where it is looked for, found {variation}"
            ));
        }
        self.made(1).err().map(|error| error.to_string())
    }

    /// What part each of the takes has.
    ///
    /// # Errors
    /// If nobody is enrolled, or nothing is looked for.
    pub fn roles(&self, takes: &[SequenceTake]) -> Result<TakeRoles> {
        let all = |choice: &TakeChoice| choice.of(takes);
        let gallery = match &self.gallery {
            Some(choice) => all(choice),
            None => vec![false; takes.len()],
        };
        let roles = TakeRoles {
            probes: self.probes.iter().map(|set| all(&set.choice())).collect(),
            gallery,
        };
        let part = if self.gallery.is_some() && !roles.gallery.contains(&true) {
            "gallery"
        } else if !roles.probes.iter().flatten().any(|is_in| *is_in) {
            "probes"
        } else {
            return Ok(roles);
        };
        let mut takes: Vec<String> = takes.iter().map(|take| take.name.clone()).collect();
        takes.sort_unstable();
        takes.dedup();
        takes.truncate(12);
        let protocol = self.name.clone();
        Err(EvaluateError::NoTake {
            protocol,
            part,
            takes,
        }
        .into())
    }

    /// What in the protocol means nothing among the takes, or more than it seems to.
    #[must_use]
    pub fn doubts(&self, takes: &[SequenceTake], roles: &TakeRoles) -> Vec<String> {
        let mut doubts = Vec::new();
        let sets = self.probes.iter().zip(&roles.probes);
        let present = sets.clone().filter(|(_, is_in)| is_in.contains(&true));
        let gallery = self.gallery.iter().flat_map(|choice| &choice.takes);
        for name in gallery.chain(present.flat_map(|(set, _)| &set.takes)) {
            if !takes.iter().any(|take| matches(name, &take.name)) {
                doubts.push(format!("no take is called {name:?}"));
            }
        }
        for (set, _) in sets.filter(|(_, is_in)| !is_in.contains(&true)) {
            doubts.push(format!(
                "no take is in the probe set {}: it is not scored",
                set.name
            ));
        }
        for (set, is_in) in self.probes.iter().zip(&roles.probes) {
            let mut pooled: Vec<&str> = Vec::new();
            for (take, _) in takes.iter().zip(is_in).filter(|(_, is_in)| **is_in) {
                if !pooled.contains(&take.condition.as_str()) {
                    pooled.push(&take.condition);
                }
            }
            if let [first, second, ..] = pooled[..] {
                doubts.push(format!(
                    "the probe set {} pools {} conditions ({first}, {second}{}): choose with conditions = [..] in a protocol's [[probes]]",
                    set.name,
                    pooled.len(),
                    if pooled.len() > 2 { ", .." } else { "" }
                ));
            }
        }
        let both = (0..takes.len()).filter(|&take| roles.gallery[take] && roles.is_probed(take));
        let both = both.count();
        if both > 0 && !self.exclude_own_take {
            doubts.push(format!(
                "{both} takes are in the gallery and probes too, and may vouch for themselves (exclude_own_take = true)"
            ));
        }
        doubts
    }

    /// Whether a take that is made of a walk is looked for.
    fn is_probed(&self, made: &MadeTake) -> bool {
        self.probes.iter().any(|set| {
            let names = set.takes.is_empty() || set.takes.iter().any(|p| matches(p, &made.take));
            names && (set.order != TakeOrder::Others || made.take != self.made[0].take)
        })
    }

    /// The takes that are made of a walk, each probed one with `cycles` cycles: those from the
    /// stated variation to the end of its take, and then of every so many-th further take as
    /// there are probed ones.
    ///
    /// # Errors
    /// If two of them would be the same variation, or one would be beyond the last.
    pub fn made(&self, cycles: u32) -> Result<Vec<MadeTake>> {
        let step = self.made.iter().filter(|made| self.is_probed(made)).count();
        let mut all: Vec<MadeTake> = Vec::new();
        let mut owners: HashMap<u32, &str> = HashMap::new();
        for made in &self.made {
            let count = if self.is_probed(made) { cycles } else { 1 };
            for at in 0..count {
                let length = u64::from(CYCLES_OF_A_TAKE);
                let first = u64::from(made.variation);
                let cycle = first % length + u64::from(at);
                let variation =
                    first - first % length + cycle / length * length * step as u64 + cycle % length;
                let variation = u32::try_from(variation)
                    .ok()
                    .filter(|variation| *variation <= MAX_VARIATION)
                    .ok_or_else(|| EvaluateError::VariationTooHigh {
                        protocol: self.name.clone(),
                        take: made.take.clone(),
                        cycle: at + 1,
                        cycles,
                        variation,
                        most: MAX_VARIATION,
                    })?;
                if let Some(other) = owners.insert(variation, &made.take) {
                    return Err(EvaluateError::VariationTwice {
                        protocol: self.name.clone(),
                        take: made.take.clone(),
                        cycle: at + 1,
                        cycles,
                        variation,
                        other: other.to_owned(),
                    }
                    .into());
                }
                all.push(MadeTake {
                    variation,
                    ..made.clone()
                });
            }
        }
        Ok(all)
    }
}

impl Protocol {
    /// The same, of takes that are probed under each of these conditions: a set of probes of each
    /// set under each of them. People stay known by their takes as they are.
    #[must_use]
    pub fn under(self, conditions: &[Condition]) -> Self {
        let alone = self.probes.len() == 1;
        let says_which = self.probes.iter().any(|set| set.clean);
        let set = |set: &ProbeSet, condition: &Condition| ProbeSet {
            name: if alone {
                condition.name.clone()
            } else {
                format!("{}, {}", set.name, condition.name)
            },
            conditions: vec![condition.name.clone()],
            clean: condition.is_clean() && (set.clean || !says_which),
            ..set.clone()
        };
        let sets = self.probes.iter();
        let sets = sets.flat_map(|one| conditions.iter().map(move |condition| set(one, condition)));
        Self {
            probes: sets.collect(),
            ..self
        }
    }
}

impl ProbeSet {
    fn choice(&self) -> TakeChoice {
        TakeChoice {
            takes: self.takes.clone(),
            conditions: self.conditions.clone(),
            order: self.order,
        }
    }
}

impl TakeChoice {
    /// Whether each of the takes is meant.
    fn of(&self, takes: &[SequenceTake]) -> Vec<bool> {
        let named = |take: &SequenceTake| {
            let any = |list: &[String], name: &str| {
                list.is_empty() || list.iter().any(|pattern| matches(pattern, name))
            };
            any(&self.takes, &take.name) && any(&self.conditions, &take.condition)
        };
        let mut seen = std::collections::HashSet::new();
        takes
            .iter()
            .map(|take| {
                named(take) && {
                    let is_first = seen.insert(take.subject);
                    match self.order {
                        TakeOrder::All => true,
                        TakeOrder::First => is_first,
                        TakeOrder::Others => !is_first,
                    }
                }
            })
            .collect()
    }
}

/// Whether a name is meant by a pattern, which may end in `*`.
fn matches(pattern: &str, name: &str) -> bool {
    match pattern.strip_suffix('*') {
        Some(start) => name.starts_with(start),
        None => pattern == name,
    }
}

#[cfg(test)]
mod tests;
