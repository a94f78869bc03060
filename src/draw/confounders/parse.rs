//! Parsing and writing of strengths, as in conditions and results.

use super::catalogue::{CATALOGUE, ConfounderKind, DoseUnit, named};
use super::dose::Dose;
use super::random_strength::{Per, RandomDose, RandomDoses, StrengthSpread, range};
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, Deserializer, MapAccess, Visitor};
use serde::ser::SerializeMap as _;
use serde::{Deserialize, Serialize, Serializer};
use std::fmt;

/// Parses a dose from `NAME=STRENGTH`, where the strength may be an amount: `roll=5deg`.
///
/// # Errors
/// If the confounder is unknown, or the strength is out of its range.
pub fn dose(text: &str) -> Result<Dose, String> {
    let (name, amount) = text
        .split_once('=')
        .ok_or("expected NAME=STRENGTH, as in backpack=0.5")?;
    let kind = kind(name.trim())?;
    let amount = amount.trim();
    let amount = match amount.parse() {
        Ok(strength) => Amount::Share(strength),
        Err(_) => Amount::Quantity(amount.to_owned()),
    };
    let strength = amount.strength(kind)?;
    Ok(Dose { kind, strength })
}

fn kind(name: &str) -> Result<ConfounderKind, String> {
    let found = named(name).map(|confounder| confounder.kind);
    found.ok_or_else(|| {
        let names: Vec<&str> = CATALOGUE.iter().map(|known| known.name).collect();
        format!(
            "there is no confounder {name:?}: expected {}",
            names.join(", ")
        )
    })
}

/// A strength as the user wrote it.
#[derive(Clone, Debug)]
enum Amount {
    /// A share of the amount in the catalogue.
    Share(f64),
    /// An amount with its unit, such as `5 deg`.
    Quantity(String),
}

impl Amount {
    /// Returns the share of the amount in the catalogue, without a check of its range.
    fn share(&self, kind: ConfounderKind) -> Result<f64, String> {
        let name = kind.confounder().name;
        let text = match self {
            Self::Share(share) => return Ok(*share),
            Self::Quantity(text) => text.trim(),
        };
        let Some(DoseUnit { name: unit, full }) = kind.confounder().unit else {
            return Err(format!(
                "{name}: expected a strength without a unit, found {text:?}"
            ));
        };
        let number = text.strip_suffix(unit).map(str::trim_end);
        let number = number.and_then(|number| number.parse::<f64>().ok());
        number.map(|amount| amount / full).ok_or_else(|| {
            format!(
                "{name}: expected a strength, or an amount such as \"{full} {unit}\", found {text:?}"
            )
        })
    }

    /// Returns the share, which must be in the confounder's range.
    fn strength(&self, kind: ConfounderKind) -> Result<f64, String> {
        let share = self.share(kind)?;
        let (least, most) = range(kind);
        // NaN is in no range.
        if (least..=most).contains(&share) {
            return Ok(share);
        }
        let name = kind.confounder().name;
        Err(match (self, kind.confounder().unit) {
            (Self::Quantity(text), Some(DoseUnit { name: unit, full })) => format!(
                "{name}: expected {} to {full} {unit}, found {:?}",
                least * full,
                text.trim()
            ),
            _ => format!("{name}: expected a strength of {least} to 1, found {share}"),
        })
    }
}

impl<'de> Deserialize<'de> for Amount {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match WrittenDose::deserialize(deserializer)? {
            WrittenDose::Amount(amount) => Ok(amount),
            WrittenDose::Table(_) => Err(de::Error::custom(
                "expected a strength such as 0.5, or an amount such as \"5 deg\", found a table",
            )),
        }
    }
}

/// The value of a confounder's key in a condition.
enum WrittenDose {
    Amount(Amount),
    Table(Box<Distribution>),
}

/// A TOML table that states how to sample a strength.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Distribution {
    p: Option<f64>,
    strength: Option<Amount>,
    uniform: Option<[Amount; 2]>,
    normal: Option<[Amount; 2]>,
    choice: Option<Vec<Amount>>,
    #[serde(default)]
    per: Per,
}

impl WrittenDose {
    fn draw(self, kind: ConfounderKind) -> Result<RandomDose, String> {
        let written = match self {
            Self::Amount(amount) => {
                return Ok(RandomDose {
                    kind,
                    chance: 1.0,
                    spread: StrengthSpread::Fixed(amount.strength(kind)?),
                    per: Per::default(),
                });
            }
            Self::Table(written) => *written,
        };
        let name = kind.confounder().name;
        let chance = written.p.unwrap_or(1.0);
        if !(0.0..=1.0).contains(&chance) {
            return Err(format!("{name}: expected p from 0 to 1, found {chance}"));
        }
        let spread = match (
            written.strength,
            written.uniform,
            written.normal,
            written.choice,
        ) {
            (Some(strength), None, None, None) => StrengthSpread::Fixed(strength.strength(kind)?),
            (None, Some([low, high]), None, None) => {
                let [low, high] = [low.strength(kind)?, high.strength(kind)?];
                if low > high {
                    return Err(format!(
                        "{name}: expected uniform = [LOW, HIGH], found {low} above {high}"
                    ));
                }
                StrengthSpread::Uniform([low, high])
            }
            (None, None, Some([mean, sd]), None) => {
                let [mean, sd] = [mean.strength(kind)?, sd.share(kind)?];
                // NaN is no spread.
                if !(0.0..=2.0).contains(&sd) {
                    return Err(format!(
                        "{name}: expected normal = [MEAN, SD] with a standard deviation of 0 to 2 (as a strength), found {sd}"
                    ));
                }
                StrengthSpread::Normal([mean, sd])
            }
            (None, None, None, Some(choice)) if !choice.is_empty() => {
                let strengths = choice.iter().map(|amount| amount.strength(kind));
                StrengthSpread::Choice(strengths.collect::<Result<_, _>>()?)
            }
            _ => {
                return Err(format!(
                    "{name}: expected one of strength = 1, uniform = [0.2, 1], normal = [0, 0.1] or choice = [0.5, 1]"
                ));
            }
        };
        Ok(RandomDose {
            kind,
            chance,
            spread,
            per: written.per,
        })
    }
}

impl<'de> Deserialize<'de> for WrittenDose {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(WrittenVisitor)
    }
}

struct WrittenVisitor;

impl<'de> Visitor<'de> for WrittenVisitor {
    type Value = WrittenDose;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a strength such as 0.5, an amount such as \"5 deg\", or a distribution such as { p = 0.3, uniform = [0.2, 1] }")
    }

    fn visit_f64<E>(self, strength: f64) -> Result<WrittenDose, E> {
        Ok(WrittenDose::Amount(Amount::Share(strength)))
    }

    fn visit_i64<E>(self, strength: i64) -> Result<WrittenDose, E> {
        Ok(WrittenDose::Amount(Amount::Share(strength as f64)))
    }

    fn visit_str<E>(self, amount: &str) -> Result<WrittenDose, E> {
        Ok(WrittenDose::Amount(Amount::Quantity(amount.to_owned())))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<WrittenDose, A::Error> {
        let table = Distribution::deserialize(MapAccessDeserializer::new(map))?;
        Ok(WrittenDose::Table(Box::new(table)))
    }
}

impl<'de> Deserialize<'de> for RandomDoses {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(DrawsVisitor)
    }
}

struct DrawsVisitor;

impl<'de> Visitor<'de> for DrawsVisitor {
    type Value = RandomDoses;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "a table of confounders with their strengths, such as { backpack = 0.5, roll = \"5 deg\" }",
        )
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<RandomDoses, A::Error> {
        let mut draws = Vec::new();
        while let Some((name, written)) = map.next_entry::<String, WrittenDose>()? {
            let draw = kind(&name).and_then(|kind| written.draw(kind));
            draws.push(draw.map_err(de::Error::custom)?);
        }
        Ok(RandomDoses::new(draws))
    }
}

impl Serialize for RandomDoses {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(
            self.list()
                .iter()
                .map(|draw| (draw.kind.confounder().name, draw)),
        )
    }
}

/// Writes the same form as conditions use.
impl Serialize for RandomDose {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if let (StrengthSpread::Fixed(strength), true) = (&self.spread, self.is_fixed()) {
            return serializer.serialize_f64(*strength);
        }
        let mut map = serializer.serialize_map(Some(3))?;
        map.serialize_entry("p", &self.chance)?;
        match &self.spread {
            StrengthSpread::Fixed(strength) => map.serialize_entry("strength", strength)?,
            StrengthSpread::Uniform(ends) => map.serialize_entry("uniform", ends)?,
            StrengthSpread::Normal(numbers) => map.serialize_entry("normal", numbers)?,
            StrengthSpread::Choice(strengths) => map.serialize_entry("choice", strengths)?,
        }
        map.serialize_entry("per", &self.per)?;
        map.end()
    }
}
