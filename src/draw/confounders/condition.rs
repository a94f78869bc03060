//! Conditions: named sets of confounders that act together, read from TOML files.

use super::catalogue::{CATALOGUE, Confounder};
use super::dose::{Dose, Doses};
use super::random_strength::{RandomDose, RandomDoses};
use crate::error::{Error, Result};
use crate::files::named_or_file::toml_of;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The names of the built-in sets of conditions. `each` has every confounder alone, at strength 1.
pub const NAMES: [&str; 5] = ["casia-b", "bag-coat", "tum-iitkgp", "domain-random", EACH];

const EACH: &str = "each";

/// The name of a walk without confounders.
pub const NORMAL: &str = "normal";

const BUILT_IN: [&str; 4] = [
    include_str!("conditions/casia-b.toml"),
    include_str!("conditions/bag-coat.toml"),
    include_str!("conditions/tum-iitkgp.toml"),
    include_str!("conditions/domain-random.toml"),
];

/// One or more confounders with their strengths, under which people walk.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Condition {
    /// The name of the condition in results, such as `BG`.
    pub name: String,
    /// The seed of random holes, occluders and choices.
    #[serde(default)]
    pub seed: u64,
    /// The confounders that act on every person.
    #[serde(default)]
    pub confounders: RandomDoses,
    /// Alternatives, of which one is chosen at random for each person.
    #[serde(default)]
    pub one_of: Vec<RandomDoses>,
}

impl Condition {
    /// Creates a condition that is named after its confounders, which act on every person.
    #[must_use]
    pub fn from_doses(confounders: Doses) -> Self {
        Self {
            name: confounders.to_string(),
            seed: 0,
            confounders: confounders.into(),
            one_of: Vec::new(),
        }
    }

    /// Returns the confounders of the condition with alternative number `choice` (any number), in
    /// the order of application.
    #[must_use]
    pub fn draws(&self, choice: usize) -> Vec<&RandomDose> {
        let chosen = self.alternative(choice);
        let chosen = chosen.into_iter().flat_map(RandomDoses::list);
        let mut draws: Vec<&RandomDose> = self.confounders.list().iter().chain(chosen).collect();
        draws.sort_by_key(|draw| draw.kind);
        draws
    }

    /// Returns alternative number `choice` (any number), or `None` if there are no alternatives.
    fn alternative(&self, choice: usize) -> Option<&RandomDoses> {
        let at = choice.checked_rem(self.one_of.len())?;
        self.one_of.get(at)
    }

    /// Returns whether the condition has no confounders, whatever its name.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        let mut all = std::iter::once(&self.confounders).chain(&self.one_of);
        all.all(|draws| draws.list().is_empty())
    }

    /// Returns whether the same confounders act on every person, at fixed strengths.
    #[must_use]
    pub fn is_fixed(&self) -> bool {
        self.one_of.is_empty() && self.confounders.list().iter().all(RandomDose::is_fixed)
    }

    fn problem(&self) -> Option<String> {
        if self.name.is_empty() {
            return Some("a condition without a name".into());
        }
        if self.name.chars().any(char::is_control) {
            return Some(format!(
                "condition {:?}: expected a name in one line, without control characters",
                self.name
            ));
        }
        let own = self.confounders.list();
        if self.name == NORMAL && !(own.is_empty() && self.one_of.is_empty()) {
            return Some(format!(
                "condition {NORMAL:?} is the name of a walk without confounders (use another name)"
            ));
        }
        let twice = self
            .one_of
            .iter()
            .flat_map(RandomDoses::list)
            .find(|draw| own.iter().any(|other| other.kind == draw.kind));
        twice.map(|draw| {
            format!(
                "condition {:?}: {} is in both confounders and one_of (remove it from one of them)",
                self.name,
                draw.kind.confounder().name
            )
        })
    }
}

/// A set of at least one condition, with distinct names.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Conditions {
    /// The conditions in the order of the file.
    #[serde(rename = "conditions", default)]
    pub list: Vec<Condition>,
}

impl Conditions {
    /// Returns a built-in set of conditions, or reads one from a `.toml` file.
    ///
    /// # Errors
    /// If there is no set of this name, or the file cannot be used.
    pub fn named(name: &str) -> Result<Self> {
        if name == EACH {
            return Ok(Self::each());
        }
        let text = toml_of(name, "set of conditions", &NAMES, &BUILT_IN)?;
        Self::parse(Path::new(name), &text)
    }

    /// Returns a condition without confounders, then each confounder alone, at strength 1, under
    /// its name.
    fn each() -> Self {
        let alone = |confounder: &Confounder| Condition {
            name: confounder.name.to_owned(),
            ..Condition::from_doses(Doses::new([Dose {
                kind: confounder.kind,
                strength: 1.0,
            }]))
        };
        let mut all: Vec<&Confounder> = CATALOGUE.iter().collect();
        all.sort_by_key(|confounder| confounder.class);
        let nothing = Condition {
            name: NORMAL.to_owned(),
            ..Condition::from_doses(Doses::default())
        };
        let each = all.into_iter().map(alone);
        Self {
            list: std::iter::once(nothing).chain(each).collect(),
        }
    }

    /// Parses conditions from TOML; `path` is for messages.
    ///
    /// # Errors
    /// If the text is not TOML, a key is unknown, or a strength is out of range.
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let conditions: Self =
            toml::from_str(text).map_err(|error| Error::toml(path, text, &error))?;
        match conditions.check() {
            Err(problem) => Err(Error::input(path, problem)),
            Ok(()) => Ok(conditions),
        }
    }

    /// Checks that there are conditions, that each is valid, and that their names are distinct.
    pub(crate) fn check(&self) -> std::result::Result<(), String> {
        let names = self.list.iter().enumerate();
        let twice = names.filter(|(at, condition)| {
            let before = &self.list[..*at];
            before.iter().any(|other| other.name == condition.name)
        });
        let twice = twice.map(|(_, c)| format!("condition {:?} appears twice", c.name));
        let empty = self.list.is_empty();
        let empty = empty.then(|| "expected at least one [[conditions]]".to_owned());
        let problems = self.list.iter().filter_map(Condition::problem);
        match empty.into_iter().chain(problems).chain(twice).next() {
            Some(problem) => Err(problem),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::dose;
    use super::*;
    use crate::draw::confounders::ConfounderKind;
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;

    fn parsed(text: &str) -> std::result::Result<Vec<Condition>, String> {
        let conditions = Conditions::parse(Path::new("c.toml"), text);
        conditions
            .map(|it| it.list)
            .map_err(|error| error.to_string())
    }

    #[test]
    fn built_in_conditions_are_those_of_their_datasets() {
        let names = |set: &str| -> Vec<String> {
            let conditions = Conditions::named(set).expect("built in");
            conditions
                .list
                .iter()
                .map(|condition| condition.name.clone())
                .collect()
        };
        // Yu, Tan & Tan 2006; Hofmann, Sural & Rigoll 2011.
        assert_eq!(names("casia-b"), ["NM", "BG", "CL"]);
        let configurations = [
            "regular",
            "hands-in-pockets",
            "backpack",
            "gown",
            "dynamic-occlusion",
            "static-occlusion",
        ];
        assert_eq!(names("tum-iitkgp"), configurations);
        for set in ["casia-b", "tum-iitkgp"] {
            let first = &Conditions::named(set).expect("built in").list[0];
            assert_eq!(first.draws(0), Vec::<&RandomDose>::new());
        }
    }

    #[test]
    fn strengths_are_numbers_or_amounts_and_nothing_is_none() {
        let text = "[[conditions]]\nname = 'a'\nconfounders = { roll = '5 deg', coat = 0.25, hat = 0 }\none_of = [{ backpack = 1 }, { suitcase = 0.5 }]";
        let [condition] = &parsed(text).expect("a condition")[..] else {
            panic!("expected one");
        };
        let drawn = |choice| {
            let draws = condition.draws(choice);
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            Doses::new(draws.into_iter().map(|draw| draw.dose(&mut rng))).to_string()
        };
        assert_eq!(drawn(2), "coat=0.25,backpack=1,roll=0.25");
        assert_eq!(drawn(7), "coat=0.25,suitcase=0.5,roll=0.25");
        assert_eq!(dose("roll=-10deg").map(|dose| dose.strength), Ok(-0.5));
        assert_eq!(
            dose(" coat = 1").map(|dose| dose.kind),
            Ok(ConfounderKind::Coat)
        );
    }

    #[test]
    fn what_is_no_condition_is_refused_with_what_was_expected() {
        let refused = |text: &str| parsed(text).expect_err(text);
        assert!(refused("").contains("at least one"));
        let truth = refused("[[conditions]]\nname = 'a'\nconfounders = { coat = true }");
        assert!(truth.contains("a strength such as 0.5"), "{truth}");
        assert!(refused("[[conditions]]\nname = \"a\\nb\"").contains("in one line"));
        let normal = "[[conditions]]\nname = 'normal'\nconfounders = { hat = 1 }";
        assert!(refused(normal).contains("another name"));
        assert!(refused("conditions = []").contains("at least one"));
        let fog = refused("[[conditions]]\nname = 'a'\nconfounders = { fog = 1 }");
        assert!(
            fog.contains("no confounder \"fog\"") && fog.contains("backpack"),
            "{fog}"
        );
        let much = refused("[[conditions]]\nname = 'a'\nconfounders = { coat = 1.5 }");
        assert!(
            much.contains("expected a strength of 0 to 1, found 1.5"),
            "{much}"
        );
        let nan = refused("[[conditions]]\nname = 'a'\nconfounders = { coat = nan }");
        assert!(nan.contains("found NaN"), "{nan}");
        let unit = refused("[[conditions]]\nname = 'a'\nconfounders = { roll = '1 rad' }");
        assert!(unit.contains("such as \"20 deg\""), "{unit}");
        let coat = refused("[[conditions]]\nname = 'a'\nconfounders = { coat = '1 cm' }");
        assert!(coat.contains("without a unit"), "{coat}");
        let far = refused("[[conditions]]\nname = 'a'\nconfounders = { roll = '30 deg' }");
        assert!(far.contains("expected -20 to 20 deg"), "{far}");
        assert!(
            refused("[[conditions]]\nname = 'a'\n[[conditions]]\nname = 'a'").contains("twice")
        );
        let both =
            "[[conditions]]\nname = 'a'\nconfounders = { hat = 1 }\none_of = [{ hat = 0.5 }]";
        assert!(refused(both).contains("one_of"));
        assert!(
            Conditions::named("rain").is_err_and(|error| error.to_string().contains("casia-b"))
        );
        assert!(dose("coat").is_err() && dose("coat=x").is_err() && dose("slope=-2").is_err());
    }
}
