//! Protocols as data: which takes are the gallery and which are probes.
//!
//! A protocol selects takes by name, condition or order, independently of how their pictures were
//! made. So it applies to a pack, a dataset and a tree of silhouettes in the same way. The
//! protocols in [`NAMES`] are built in; others are TOML files with the same keys.

use std::collections::HashMap;
use std::path::Path;

use serde::Deserialize;

use crate::dataset::sequences::{MadeTake, SequenceTake};
use crate::draw::confounders::{Condition, Conditions, NORMAL};
use crate::error::{Error, EvaluateError, Result};
use crate::files::named_or_file::toml_of;
use crate::people::session::session_of;
use crate::people::variation::CYCLES_OF_A_TAKE;

/// The first variation that no training of this program uses. Variations of probes begin here.
pub const FIRST_UNSEEN: u32 = 1_000;
/// The last variation.
pub const MAX_VARIATION: u32 = 1_000_000;

/// Names of the built-in protocols.
pub const NAMES: [&str; 9] = [
    "closed-set",
    "first-take",
    "sessions",
    "leave-one-take-out",
    "cross-view",
    "verification",
    "casia-b",
    "ou-mvlp",
    PARTITION,
];

/// Name of the protocol for a partition that lists the sequences of gallery and probes.
pub const PARTITION: &str = "partition";

const BUILT_IN: [&str; 9] = [
    include_str!("protocols/closed-set.toml"),
    include_str!("protocols/first-take.toml"),
    include_str!("protocols/sessions.toml"),
    include_str!("protocols/leave-one-take-out.toml"),
    include_str!("protocols/cross-view.toml"),
    include_str!("protocols/verification.toml"),
    include_str!("protocols/casia-b.toml"),
    include_str!("protocols/ou-mvlp.toml"),
    include_str!("protocols/partition.toml"),
];

/// A protocol: which takes are the gallery, which are probes, and what decides.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Protocol {
    /// Name in results.
    pub name: String,
    /// A sentence about the protocol.
    pub description: String,
    /// The rule that decides the person of a probe.
    pub decision: Decision,
    /// The gallery viewpoints that a probe is compared with.
    #[serde(default)]
    pub gallery_views: GalleryViews,
    /// Whether a probe is excluded from comparison with cycles of its own take.
    #[serde(default)]
    pub exclude_own_take: bool,
    /// The takes that are enrolled; none if class scores decide.
    pub gallery: Option<TakeChoice>,
    /// The probes, in sets that are reported separately.
    pub probes: Vec<ProbeSet>,
    /// The conditions named by the takes in `made`: a built-in set, or a `.toml` file.
    pub conditions: Option<String>,
    /// Takes that are made from a walk if nobody has more than one take.
    #[serde(default)]
    pub made: Vec<MadeTake>,
    /// Default viewpoints of a pack's probes; the paper's 703 viewpoints if absent.
    pub views: Option<ViewpointGrid>,
}

/// Viewpoints: every azimuth with every elevation.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewpointGrid {
    /// Azimuths in degrees.
    pub azimuth_deg: Vec<f32>,
    /// Elevations in degrees.
    pub elevation_deg: Vec<f32>,
}

/// The rule that decides the person of a probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Decision {
    /// The class with the highest score.
    #[serde(rename = "class score")]
    ClassScore,
    /// The nearest embedding of the gallery.
    #[serde(rename = "nearest embedding")]
    NearestEmbedding,
}

/// The gallery viewpoints that a probe is compared with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GalleryViews {
    /// All viewpoints together.
    #[default]
    All,
    /// The probe's own viewpoint.
    Same,
    /// Each viewpoint separately. Comparisons with the probe's own viewpoint count in no rate.
    Each,
    /// The recognizer's training viewpoints together; the side view if its contract states none.
    Training,
}

/// A selection of takes.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TakeChoice {
    /// Names, with `*` for any characters at the end; all names if empty.
    pub takes: Vec<String>,
    /// Sessions, counted from 1; all if empty.
    pub sessions: Vec<usize>,
    /// Conditions; all if empty.
    pub conditions: Vec<String>,
    /// Which of each person's matching takes.
    pub order: TakeOrder,
}

/// Which of a person's matching takes are selected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TakeOrder {
    /// All takes.
    #[default]
    All,
    /// The first take.
    First,
    /// All takes except the first.
    Others,
}

/// A set of probe takes that are reported together.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProbeSet {
    /// Name in results, such as `BG`.
    pub name: String,
    /// Names, as in [`TakeChoice`].
    #[serde(default)]
    pub takes: Vec<String>,
    /// Sessions, as in [`TakeChoice`].
    #[serde(default)]
    pub sessions: Vec<usize>,
    /// Conditions, as in [`TakeChoice`].
    #[serde(default)]
    pub conditions: Vec<String>,
    /// Which of each person's matching takes.
    #[serde(default)]
    pub order: TakeOrder,
    /// Whether no confounder acts on these walks. Headline results are those of the clean sets.
    #[serde(default)]
    pub clean: bool,
}

/// The role of each take: gallery, probe, both or neither.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TakeRoles {
    /// For each take, whether it is in the gallery.
    pub gallery: Vec<bool>,
    /// For each set of probes and each take, whether the take is in the set.
    pub probes: Vec<Vec<bool>>,
}

impl TakeRoles {
    /// Returns whether a take is in any set of probes.
    #[must_use]
    pub fn is_probed(&self, take: usize) -> bool {
        self.probes.iter().any(|set| set[take])
    }
}

impl TakeRoles {
    /// Returns the roles of takes that are probed under conditions, as in [`Protocol::under`]. A
    /// take has the same role as without a condition.
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
    /// Returns the built-in protocol of this name, or reads it from a `.toml` file.
    ///
    /// # Errors
    /// If there is no such protocol, or the file is invalid.
    pub fn named(name: &str) -> Result<Self> {
        let text = toml_of(name, "protocol", &NAMES, &BUILT_IN)?;
        Self::parse(Path::new(name), &text)
    }

    /// Parses a protocol from TOML; `path` is for messages.
    ///
    /// # Errors
    /// If the text is not TOML, a key is unknown, the protocol is inconsistent, or no built-in
    /// conditions have this name.
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let protocol: Self =
            toml::from_str(text).map_err(|error| Error::toml(path, text, &error))?;
        if let Some(problem) = protocol.problem() {
            return Err(Error::input(path, problem));
        }
        // A file of conditions is read where it is used: other conditions may replace it.
        let built_in = protocol.conditions.as_deref();
        let built_in = built_in.filter(|name| !name.ends_with(".toml"));
        match built_in.map(Conditions::named).transpose() {
            Err(error) => Err(Error::input(path, format!("conditions: {error}"))),
            Ok(_) => Ok(protocol),
        }
    }

    fn problem(&self) -> Option<String> {
        let by_scores = self.decision == Decision::ClassScore;
        if by_scores != self.gallery.is_none() {
            return Some(
                "expected a [gallery] if the nearest embedding decides, and none if the class score decides".into(),
            );
        }
        if by_scores && self.gallery_views != GalleryViews::All {
            return Some("gallery_views: class scores are not compared with a gallery".into());
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
        if let Some(name) = twice(self.made.iter().map(|take| take.take.as_str()).collect()) {
            return Some(format!("made: {name:?} appears twice"));
        }
        let named = self.made.iter().any(|take| take.condition.is_some());
        if named != self.conditions.is_some() {
            return Some(
                "expected \"conditions\" if a take of \"made\" names a condition, and only then"
                    .into(),
            );
        }
        let out_of_range = self.made.iter().find(|take| {
            let least = if self.is_probed(take) {
                FIRST_UNSEEN
            } else {
                0
            };
            !(least..=MAX_VARIATION).contains(&take.variation)
        });
        if let Some(MadeTake {
            take, variation, ..
        }) = out_of_range
        {
            return Some(format!(
                "made: take {take:?}: expected a variation from 0 to {MAX_VARIATION}, and from {FIRST_UNSEEN} on (which training never uses) for a probe, found {variation}"
            ));
        }
        self.made(1).err().map(|error| error.to_string())
    }

    /// Returns the role of each take.
    ///
    /// # Errors
    /// If no take is in the gallery, or none is a probe.
    pub fn roles(&self, takes: &[SequenceTake]) -> Result<TakeRoles> {
        let all = |choice: &TakeChoice| choice.selected(takes);
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

    /// Returns warnings about parts of the protocol that match no take, or pool different
    /// conditions.
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
                    "the probe set {} pools {} conditions ({first}, {second}{}): to separate them, set conditions = [..] in the protocol's [[probes]]",
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
                "{both} takes are in the gallery and are probes too, so they may match themselves (set exclude_own_take = true)"
            ));
        }
        doubts
    }

    /// Returns whether a take that is made of a walk is a probe.
    fn is_probed(&self, made: &MadeTake) -> bool {
        self.probes.iter().any(|set| {
            let names = set.takes.is_empty() || set.takes.iter().any(|p| matches(p, &made.take));
            names && (set.order != TakeOrder::Others || made.take != self.made[0].take)
        })
    }

    /// Returns the takes that are made from a walk, each probe take with `cycles` cycles. These
    /// begin at the stated variation and continue to the end of its take, a group of 8 variations.
    /// Further cycles come from every n-th take after it, where n is the number of probe takes.
    ///
    /// # Errors
    /// If two cycles would be the same variation, or one would be beyond the last.
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
    /// Returns the protocol with one probe set for each probe set and condition. The gallery stays
    /// without conditions.
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
        let sets = sets.flat_map(|probe_set| {
            conditions
                .iter()
                .map(move |condition| set(probe_set, condition))
        });
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
            sessions: self.sessions.clone(),
            conditions: self.conditions.clone(),
            order: self.order,
        }
    }
}

impl TakeChoice {
    /// Returns for each take whether it is selected.
    fn selected(&self, takes: &[SequenceTake]) -> Vec<bool> {
        let named = |take: &SequenceTake| {
            let any = |list: &[String], name: &str| {
                list.is_empty() || list.iter().any(|pattern| matches(pattern, name))
            };
            let sessions = &self.sessions;
            any(&self.takes, &take.name)
                && any(&self.conditions, &take.condition)
                && (sessions.is_empty() || sessions.contains(&session_of(&take.name)))
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

/// Returns whether a name matches a pattern, which may end in `*`.
fn matches(pattern: &str, name: &str) -> bool {
    match pattern.strip_suffix('*') {
        Some(start) => name.starts_with(start),
        None => pattern == name,
    }
}

#[cfg(test)]
mod tests;
