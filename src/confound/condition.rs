//! Conditions: confounders that act together, as users name and write them.

use super::catalogue::{CATALOGUE, Confounder, Kind, Unit, named};
use crate::error::{Error, Result};
use crate::named::toml_of;
use serde::de::{self, Deserializer, MapAccess, Visitor};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;

/// Names of the sets of conditions that are built in; `each` has every confounder alone, at
/// strength 1.
pub const NAMES: [&str; 3] = ["casia-b", "tum-iitkgp", EACH];

const EACH: &str = "each";

/// What a walk is called on which nothing acts.
pub const NORMAL: &str = "normal";

const BUILT_IN: [&str; 2] = [
    include_str!("conditions/casia-b.toml"),
    include_str!("conditions/tum-iitkgp.toml"),
];

/// A confounder and its strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dose {
    /// Which.
    pub kind: Kind,
    /// 0 changes nothing, 1 (or -1) is what [`CATALOGUE`] says.
    pub strength: f64,
}

/// Confounders that act together, in the order in which they are applied.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Doses(Vec<Dose>);

impl Doses {
    /// The doses that change something.
    pub fn new(doses: impl IntoIterator<Item = Dose>) -> Self {
        let changes = |dose: &Dose| dose.strength != 0.0;
        let mut doses: Vec<Dose> = doses.into_iter().filter(changes).collect();
        doses.sort_by_key(|dose| dose.kind);
        Self(doses)
    }

    /// In the order in which they are applied.
    #[must_use]
    pub fn list(&self) -> &[Dose] {
        &self.0
    }

    /// The strength of a confounder; none if it changes nothing.
    #[must_use]
    pub fn strength(&self, kind: Kind) -> Option<f64> {
        let found = self.0.iter().find(|dose| dose.kind == kind);
        found.map(|dose| dose.strength)
    }
}

/// `backpack=0.5,roll=0.2`.
impl fmt::Display for Doses {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for Dose { kind, strength } in &self.0 {
            write!(f, "{separator}{}={strength}", kind.confounder().name)?;
            separator = ",";
        }
        Ok(())
    }
}

/// Under which circumstances somebody walks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Condition {
    /// What it is called in results, such as `BG`.
    pub name: String,
    /// Another number draws other holes, occluders and choices.
    #[serde(default)]
    pub seed: u64,
    /// What acts on everybody.
    #[serde(default)]
    pub confounders: Doses,
    /// Alternatives, one for each person, drawn from the seed.
    #[serde(default)]
    pub one_of: Vec<Doses>,
}

impl Condition {
    /// A condition of its own: what acts on everybody, called by it.
    #[must_use]
    pub fn of(confounders: Doses) -> Self {
        Self {
            name: confounders.to_string(),
            seed: 0,
            confounders,
            one_of: Vec::new(),
        }
    }

    /// What acts where alternative number `choice` (any number) is taken.
    #[must_use]
    pub fn doses(&self, choice: usize) -> Doses {
        let own = self.confounders.list().iter().copied();
        let chosen = self.alternative(choice);
        let chosen = chosen.into_iter().flat_map(Doses::list).copied();
        Doses::new(own.chain(chosen))
    }

    /// Alternative number `choice` (any number); none if there are none.
    #[must_use]
    pub fn alternative(&self, choice: usize) -> Option<&Doses> {
        let at = choice.checked_rem(self.one_of.len())?;
        self.one_of.get(at)
    }

    /// Whether nothing acts, whatever it is called.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        let mut all = std::iter::once(&self.confounders).chain(&self.one_of);
        all.all(|doses| doses.list().is_empty())
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
                "condition {NORMAL:?} is what a walk is called on which nothing acts (use another name)"
            ));
        }
        let twice = self
            .one_of
            .iter()
            .flat_map(Doses::list)
            .find(|dose| own.iter().any(|other| other.kind == dose.kind));
        twice.map(|dose| {
            format!(
                "condition {:?}: {} is among confounders and one_of (leave it out of one of them)",
                self.name,
                dose.kind.confounder().name
            )
        })
    }
}

/// Conditions, not empty, told apart by their names.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Conditions {
    /// In the file's order.
    #[serde(rename = "conditions", default)]
    pub list: Vec<Condition>,
}

impl Conditions {
    /// Those that are built in under a name, or those of a `.toml` file.
    ///
    /// # Errors
    /// If there are none of this name, or the file cannot be used.
    pub fn named(name: &str) -> Result<Self> {
        if name == EACH {
            return Ok(Self::each());
        }
        let text = toml_of(name, "set of conditions", &NAMES, &BUILT_IN)?;
        Self::parse(Path::new(name), &text)
    }

    /// Nothing, then every confounder alone, at strength 1, called by its name.
    fn each() -> Self {
        let alone = |confounder: &Confounder| Condition {
            name: confounder.name.to_owned(),
            ..Condition::of(Doses::new([Dose {
                kind: confounder.kind,
                strength: 1.0,
            }]))
        };
        let mut all: Vec<&Confounder> = CATALOGUE.iter().collect();
        all.sort_by_key(|confounder| confounder.class);
        let nothing = Condition {
            name: NORMAL.to_owned(),
            ..Condition::of(Doses::default())
        };
        let each = all.into_iter().map(alone);
        Self {
            list: std::iter::once(nothing).chain(each).collect(),
        }
    }

    /// Conditions from TOML; `path` is for messages.
    ///
    /// # Errors
    /// If the text is not TOML, a key is unknown, or a strength is out of range.
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let conditions: Self =
            toml::from_str(text).map_err(|error| Error::toml(path, text, &error))?;
        let names = conditions.list.iter().enumerate();
        let twice = names.filter(|(at, condition)| {
            let before = &conditions.list[..*at];
            before.iter().any(|other| other.name == condition.name)
        });
        let twice = twice.map(|(_, c)| format!("condition {:?} is there twice", c.name));
        let empty = conditions.list.is_empty();
        let empty = empty.then(|| "expected at least one [[conditions]]".to_owned());
        let problems = conditions.list.iter().filter_map(Condition::problem);
        match empty.into_iter().chain(problems).chain(twice).next() {
            Some(problem) => Err(Error::input(path, problem)),
            None => Ok(conditions),
        }
    }

    /// The condition of this name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Condition> {
        self.list.iter().find(|condition| condition.name == name)
    }
}

/// A dose from `NAME=STRENGTH`, where the strength may be an amount: `roll=5deg`.
///
/// # Errors
/// If there is no such confounder, or the strength is out of its range.
pub fn dose(text: &str) -> std::result::Result<Dose, String> {
    let (name, amount) = text
        .split_once('=')
        .ok_or("expected NAME=STRENGTH, as in backpack=0.5")?;
    let kind = kind(name.trim())?;
    let amount = amount.trim();
    match amount.parse() {
        Ok(strength) => checked(kind, strength),
        Err(_) => amount_of(kind, amount),
    }
}

fn kind(name: &str) -> std::result::Result<Kind, String> {
    let found = named(name).map(|confounder| confounder.kind);
    found.ok_or_else(|| {
        let names: Vec<&str> = CATALOGUE.iter().map(|known| known.name).collect();
        format!(
            "there is no confounder {name:?}: expected {}",
            names.join(", ")
        )
    })
}

fn checked(kind: Kind, strength: f64) -> std::result::Result<Dose, String> {
    let confounder = kind.confounder();
    let least = if confounder.is_signed { -1.0 } else { 0.0 };
    // A NaN is in no range.
    if (least..=1.0).contains(&strength) {
        return Ok(Dose { kind, strength });
    }
    Err(format!(
        "{}: expected a strength of {least} to 1, found {strength}",
        confounder.name
    ))
}

/// A strength from an amount with its unit, such as `5 deg`.
fn amount_of(kind: Kind, text: &str) -> std::result::Result<Dose, String> {
    let name = kind.confounder().name;
    let Some(Unit { name: unit, full }) = kind.confounder().unit else {
        return Err(format!(
            "{name}: expected a strength without a unit, found {text:?}"
        ));
    };
    let number = text.strip_suffix(unit).map(str::trim_end);
    let number = number.and_then(|number| number.parse::<f64>().ok());
    let Some(amount) = number else {
        return Err(format!(
            "{name}: expected a strength, or an amount such as \"{full} {unit}\", found {text:?}"
        ));
    };
    checked(kind, amount / full).map_err(|_| {
        let least = if kind.confounder().is_signed {
            -full
        } else {
            0.0
        };
        format!("{name}: expected {least} to {full} {unit}, found {text:?}")
    })
}

impl<'de> Deserialize<'de> for Doses {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        deserializer.deserialize_map(DosesVisitor)
    }
}

impl Serialize for Doses {
    fn serialize<S: serde::Serializer>(
        &self,
        serializer: S,
    ) -> std::result::Result<S::Ok, S::Error> {
        serializer.collect_map(
            self.0
                .iter()
                .map(|dose| (dose.kind.confounder().name, dose.strength)),
        )
    }
}

struct DosesVisitor;

/// A strength as TOML has it.
enum Strength {
    Number(f64),
    Amount(String),
}

impl<'de> Deserialize<'de> for Strength {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        deserializer.deserialize_any(StrengthVisitor)
    }
}

struct StrengthVisitor;

impl Visitor<'_> for StrengthVisitor {
    type Value = Strength;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a strength such as 0.5, or an amount such as \"5 deg\"")
    }

    fn visit_f64<E>(self, strength: f64) -> std::result::Result<Strength, E> {
        Ok(Strength::Number(strength))
    }

    fn visit_i64<E>(self, strength: i64) -> std::result::Result<Strength, E> {
        Ok(Strength::Number(strength as f64))
    }

    fn visit_str<E>(self, amount: &str) -> std::result::Result<Strength, E> {
        Ok(Strength::Amount(amount.to_owned()))
    }
}

impl<'de> Visitor<'de> for DosesVisitor {
    type Value = Doses;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "a table of confounders with their strengths, as { backpack = 0.5, roll = \"5 deg\" }",
        )
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<Doses, A::Error> {
        let mut doses = Vec::new();
        while let Some((name, strength)) = map.next_entry::<String, Strength>()? {
            let of = |kind| match strength {
                Strength::Number(strength) => checked(kind, strength),
                Strength::Amount(text) => amount_of(kind, text.trim()),
            };
            doses.push(kind(&name).and_then(of).map_err(de::Error::custom)?);
        }
        Ok(Doses::new(doses))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            assert_eq!(first.doses(0), Doses::default());
        }
    }

    #[test]
    fn strengths_are_numbers_or_amounts_and_nothing_is_none() {
        let text = "[[conditions]]\nname = 'a'\nconfounders = { roll = '5 deg', coat = 0.25, hat = 0 }\none_of = [{ backpack = 1 }, { suitcase = 0.5 }]";
        let [condition] = &parsed(text).expect("a condition")[..] else {
            panic!("expected one");
        };
        assert_eq!(condition.confounders.strength(Kind::Roll), Some(0.25));
        assert_eq!(condition.confounders.strength(Kind::Hat), None);
        assert_eq!(
            condition.doses(2).to_string(),
            "coat=0.25,backpack=1,roll=0.25"
        );
        assert_eq!(
            condition.doses(7).to_string(),
            "coat=0.25,suitcase=0.5,roll=0.25"
        );
        assert_eq!(dose("roll=-10deg").map(|dose| dose.strength), Ok(-0.5));
        assert_eq!(dose(" coat = 1").map(|dose| dose.kind), Ok(Kind::Coat));
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
