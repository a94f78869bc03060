//! The format of design files.

use super::images::WrittenImages;
use super::numbers::{MOST, NumberRange, PositiveNumber, WrittenSpeeds, WrittenViews, check_range};
use super::{CYCLES_OF_A_TAKE, Design, DesignTake, Population, Speeds, Split};
use crate::draw::confounders::{Condition, Conditions};
use crate::error::Error;
use crate::people::cohort::{Dressing, ReferencePopulation};
use crate::people::session::MOST_SESSIONS;
use edgegait_core::pack::Sex;
use serde::Deserialize;
use serde::de::value::SeqAccessDeserializer;
use serde::de::{self, Deserializer, MapAccess, SeqAccess, Visitor};
use std::fmt;
use toml::Spanned;

/// The tables of a design file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenDesign {
    #[serde(default = "first_seed")]
    seed: u64,
    population: Option<Spanned<WrittenPopulation>>,
    walks: Option<Spanned<WrittenWalks>>,
    views: Spanned<WrittenViews>,
    images: Option<Spanned<WrittenImages>>,
    #[serde(default)]
    conditions: WrittenConditions,
    #[serde(default)]
    splits: Splits,
}

const fn first_seed() -> u64 {
    1
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenPopulation {
    people: Option<NumberRange>,
    reference: Option<String>,
    sex: Option<WrittenSex>,
    age_years: Option<[f64; 2]>,
    #[serde(default)]
    dressed: WrittenDressing,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum WrittenSex {
    Female,
    Male,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum WrittenDressing {
    Never,
    /// Closer to people rendered by other software than bare people are: see the guide.
    #[default]
    ForGood,
    PerTake,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenWalks {
    #[serde(default)]
    speeds_kmh: WrittenSpeeds,
    #[serde(default = "one")]
    sessions: PositiveNumber,
    #[serde(default)]
    takes: Takes,
    #[serde(default = "one")]
    cycles: PositiveNumber,
}

impl Default for WrittenWalks {
    fn default() -> Self {
        Self {
            speeds_kmh: WrittenSpeeds::default(),
            sessions: one(),
            takes: Takes::default(),
            cycles: PositiveNumber(1),
        }
    }
}

const fn one() -> PositiveNumber {
    PositiveNumber(1)
}

/// The number of takes, or their names.
enum Takes {
    Count(usize),
    Named(Vec<NamedTake>),
}

impl Default for Takes {
    fn default() -> Self {
        Self::Count(1)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NamedTake {
    name: String,
    condition: Option<Spanned<String>>,
}

impl<'de> Deserialize<'de> for Takes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(TakesVisitor)
    }
}

struct TakesVisitor;

impl<'de> Visitor<'de> for TakesVisitor {
    type Value = Takes;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "a number of takes, or a list such as [{ name = \"bg-01\", condition = \"BG\" }]",
        )
    }

    fn visit_i64<E: de::Error>(self, count: i64) -> Result<Takes, E> {
        let count = PositiveNumber::try_from(count).map_err(de::Error::custom)?;
        Ok(Takes::Count(count.0))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Takes, A::Error> {
        let takes = Vec::<NamedTake>::deserialize(SeqAccessDeserializer::new(list))?;
        let mut names = takes.iter().map(|take| take.name.as_str()).enumerate();
        let wrong = names.find(|(at, name)| {
            name.is_empty() || takes[..*at].iter().any(|other| other.name == *name)
        });
        if let Some((_, name)) = wrong {
            return Err(de::Error::custom(format!(
                "expected takes of different names, found {name:?} twice or empty"
            )));
        }
        if takes.is_empty() || takes.len() > MOST {
            return Err(de::Error::custom(format!("expected 1 to {MOST} takes")));
        }
        Ok(Takes::Named(takes))
    }
}

/// The name of a set of conditions, or conditions as in their files.
#[derive(Default)]
struct WrittenConditions(Vec<Condition>);

impl<'de> Deserialize<'de> for WrittenConditions {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ConditionsVisitor)
    }
}

struct ConditionsVisitor;

impl<'de> Visitor<'de> for ConditionsVisitor {
    type Value = WrittenConditions;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the name of a set of conditions, or [[conditions]]")
    }

    fn visit_str<E: de::Error>(self, name: &str) -> Result<WrittenConditions, E> {
        let named = Conditions::named(name).map_err(de::Error::custom)?;
        Ok(WrittenConditions(named.list))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<WrittenConditions, A::Error> {
        let list = Vec::<Condition>::deserialize(SeqAccessDeserializer::new(list))?;
        let conditions = Conditions { list };
        conditions.check().map_err(de::Error::custom)?;
        Ok(WrittenConditions(conditions.list))
    }
}

/// The splits, by name.
#[derive(Default)]
struct Splits(Vec<Split>);

impl<'de> Deserialize<'de> for Splits {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(SplitsVisitor)
    }
}

struct SplitsVisitor;

impl<'de> Visitor<'de> for SplitsVisitor {
    type Value = Splits;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table of names with their people, such as train = \"0..80\"")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Splits, A::Error> {
        let mut splits: Vec<Split> = Vec::new();
        while let Some((name, NumberRange(people))) = map.next_entry::<String, NumberRange>()? {
            let is_known = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
            if name.is_empty() || !name.chars().all(is_known) {
                return Err(de::Error::custom(format!(
                    "expected the name of a folder, of letters, digits, - and _, found {name:?}"
                )));
            }
            let shares = splits
                .iter()
                .find(|other| other.people.start < people.end && people.start < other.people.end);
            if let Some(Split {
                name: Some(other),
                people: others,
            }) = shares
            {
                let shared = people.start.max(others.start)..people.end.min(others.end);
                return Err(de::Error::custom(format!(
                    "splits {other} and {name} share people {}..{}: expected each person in one",
                    shared.start, shared.end
                )));
            }
            splits.push(Split {
                name: Some(name),
                people,
            });
        }
        Ok(Splits(splits))
    }
}

/// Returns a table and the byte at which it begins; the default and 0 if it is missing.
fn table<T: Default>(written: Option<Spanned<T>>) -> (usize, T) {
    written.map_or_else(
        || (0, T::default()),
        |table| (table.span().start, table.into_inner()),
    )
}

impl WrittenDesign {
    /// Checks the file and converts it to a design.
    ///
    /// # Errors
    /// The byte and the problem.
    pub(super) fn design(self) -> Result<Design, (usize, String)> {
        let (at_population, population) = table(self.population);
        let (at_walks, walks) = table(self.walks);
        let (at_images, images) = table(self.images);
        let (at_views, views) = (self.views.span().start, self.views.into_inner());
        let splits = splits_of(population.people.clone(), self.splits.0)
            .map_err(|problem| (at_population, problem))?;
        let conditions = self.conditions.0;
        let cycles = walks.cycles.0;
        if cycles > CYCLES_OF_A_TAKE as usize {
            let problem = format!(
                "expected at most {CYCLES_OF_A_TAKE} cycles of a take, found {cycles} (ask for more takes)"
            );
            return Err((at_walks, problem));
        }
        let sessions = walks.sessions.0;
        if sessions > MOST_SESSIONS {
            let problem = format!("expected at most {MOST_SESSIONS} sessions, found {sessions}");
            return Err((at_walks, problem));
        }
        let settings = images.settings(self.seed);
        let wanted = images.images();
        let people = population
            .population()
            .map_err(|error| (at_population, error.to_string()))?;
        let design = Design {
            takes: takes_of(walks.takes, &conditions)?,
            cycles: u32::try_from(cycles).unwrap_or(1),
            views: views.viewpoints().map_err(|problem| (at_views, problem))?,
            conditions,
            settings: settings.map_err(|problem| (at_images, problem))?,
            images: wanted.map_err(|problem| (at_images, problem))?,
            splits,
            population: Population {
                speeds: walks.speeds_kmh.0,
                sessions,
                ..people
            },
        };
        let has_names = design.takes.iter().any(|take| take.name.is_some());
        if has_names && design.walks() > 1 {
            let problem = "expected one speed and session if takes have names, which do not distinguish these";
            return Err((at_walks, problem.into()));
        }
        let said = |error: Error| error.to_string();
        let ages = design.population.ages;
        if let Some(ages) = ages {
            check_range(ages)
                .map_err(|problem| (at_population, format!("age_years: {problem}")))?;
        }
        // Sampled values are checked by their bounds.
        for age in ages.map_or(vec![None], |ages| ages.map(Some).to_vec()) {
            let options = design.options_at(0, age, vec![5.0]);
            let checked = options.check().map_err(said);
            checked.map_err(|problem| (at_population, problem))?;
        }
        let options = design.options_at(0, None, design.population.speeds.bounds());
        let checked = options.check().map_err(said);
        checked.map_err(|problem| (at_walks, problem))?;
        let checked = design.settings.check();
        let checked = checked.and_then(|()| design.images.wanted.check(&design.settings));
        let checked = checked.map_err(said);
        checked.map_err(|problem| (at_images, problem))?;
        Ok(design)
    }
}

fn splits_of(people: Option<NumberRange>, splits: Vec<Split>) -> Result<Vec<Split>, String> {
    match (people, splits) {
        (Some(NumberRange(people)), none) if none.is_empty() => {
            Ok(vec![Split { name: None, people }])
        }
        (None, splits) if !splits.is_empty() => Ok(splits),
        (None, _) => {
            Err("expected people = \"0..100\" in [population], or a table [splits]".into())
        }
        (Some(_), _) => {
            Err("expected people in [population] or [splits], found both (leave people out)".into())
        }
    }
}

fn takes_of(takes: Takes, conditions: &[Condition]) -> Result<Vec<DesignTake>, (usize, String)> {
    let named = match takes {
        Takes::Count(count) => return Ok(vec![DesignTake::default(); count]),
        Takes::Named(named) => named,
    };
    let take = |take: NamedTake| {
        let condition = take.condition.map(|name| {
            let at = conditions
                .iter()
                .position(|known| known.name == *name.get_ref());
            at.ok_or_else(|| {
                let known: Vec<&str> = conditions.iter().map(|known| known.name.as_str()).collect();
                let problem = format!(
                    "there is no condition {:?}: expected one of {known:?}",
                    name.get_ref()
                );
                (name.span().start, problem)
            })
        });
        Ok(DesignTake {
            name: Some(take.name),
            condition: condition.transpose()?,
        })
    };
    named.into_iter().map(take).collect()
}

impl WrittenPopulation {
    fn population(&self) -> crate::error::Result<Population> {
        let named = self.reference.as_deref().map(ReferencePopulation::named);
        Ok(Population {
            reference: named.transpose()?.unwrap_or_default(),
            sex: self.sex.map(|sex| match sex {
                WrittenSex::Female => Sex::Female,
                WrittenSex::Male => Sex::Male,
            }),
            ages: self.age_years,
            speeds: Speeds::Each(Vec::new()),
            sessions: 1,
            dressed: match self.dressed {
                WrittenDressing::Never => None,
                WrittenDressing::ForGood => Some(Dressing::ForGood),
                WrittenDressing::PerTake => Some(Dressing::PerTake),
            },
        })
    }
}
