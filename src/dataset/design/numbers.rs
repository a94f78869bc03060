//! The numbers of a design file: counts, people, speeds and angles.

use super::{Angles, Speeds, Viewpoints};
use crate::draw::sweep::View;
use serde::Deserialize;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use std::fmt;
use std::ops::Range;

/// Largest count in a design: walks of a person, takes, viewpoints of a cycle.
pub(super) const MOST: usize = 1_000;

/// A number from 1 to [`MOST`].
#[derive(Clone, Copy, Deserialize)]
#[serde(try_from = "i64")]
pub(super) struct PositiveNumber(pub usize);

impl TryFrom<i64> for PositiveNumber {
    type Error = String;

    fn try_from(count: i64) -> Result<Self, String> {
        let known = usize::try_from(count).ok();
        let known = known.filter(|count| (1..=MOST).contains(count));
        known
            .map(Self)
            .ok_or_else(|| format!("expected a number from 1 to {MOST}, found {count}"))
    }
}

/// A range of people, written `A..B`.
#[derive(Clone, Deserialize)]
#[serde(try_from = "String")]
pub(super) struct NumberRange(pub Range<usize>);

impl TryFrom<String> for NumberRange {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let number = |text: &str| text.trim().parse::<u32>().ok().map(|it| it as usize);
        let ends = text.split_once("..");
        let ends = ends.and_then(|(from, to)| number(from).zip(number(to)));
        match ends {
            Some((from, to)) if from < to => Ok(Self(from..to)),
            _ => Err(format!(
                "expected people as \"0..100\", which includes 0 and excludes 100, found {text:?}"
            )),
        }
    }
}

/// A list of numbers, or a table `{ uniform = [LOW, HIGH] }` with the other keys of `T`.
enum ListOr<T> {
    List(Vec<f64>),
    Table(T),
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for ListOr<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either<T>(std::marker::PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Either<T> {
            type Value = ListOr<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list such as [0, 90], or a table such as { uniform = [0, 360] }")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<ListOr<T>, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(list)).map(ListOr::List)
            }

            fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<ListOr<T>, A::Error> {
                T::deserialize(MapAccessDeserializer::new(table)).map(ListOr::Table)
            }
        }
        deserializer.deserialize_any(Either(std::marker::PhantomData))
    }
}

/// Checks that two numbers are a finite range.
pub(super) fn check_range([low, high]: [f64; 2]) -> Result<(), String> {
    // Comparisons with NaN are false.
    if low <= high && low.is_finite() && high.is_finite() {
        return Ok(());
    }
    Err(format!(
        "expected uniform = [LOW, HIGH], found {low} and {high}"
    ))
}

#[derive(Deserialize)]
#[serde(try_from = "ListOr<DrawnSpeeds>")]
pub(super) struct WrittenSpeeds(pub Speeds);

impl Default for WrittenSpeeds {
    /// Returns 5 km/h, the speed at which walks are compared.
    fn default() -> Self {
        Self(Speeds::Each(vec![5.0]))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DrawnSpeeds {
    uniform: [f64; 2],
    walks: PositiveNumber,
}

impl TryFrom<ListOr<DrawnSpeeds>> for WrittenSpeeds {
    type Error = String;

    fn try_from(written: ListOr<DrawnSpeeds>) -> Result<Self, String> {
        match written {
            ListOr::List(speeds) if speeds.is_empty() => {
                Err("expected at least one speed, as in [4, 5, 6]".into())
            }
            ListOr::List(speeds) => Ok(Self(Speeds::Each(speeds))),
            ListOr::Table(DrawnSpeeds {
                uniform,
                walks: PositiveNumber(walks),
            }) => {
                check_range(uniform)?;
                let most = Speeds::count(uniform);
                if walks > most {
                    return Err(format!(
                        "expected at most {most} walks, the number of speeds in steps of 0.1 km/h from {} to {}, found {walks}",
                        uniform[0], uniform[1]
                    ));
                }
                let between = uniform;
                Ok(Self(Speeds::Drawn { between, walks }))
            }
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenViews {
    azimuth_deg: WrittenAngles,
    #[serde(default)]
    elevation_deg: WrittenAngles,
    count: Option<PositiveNumber>,
}

#[derive(Deserialize)]
#[serde(try_from = "ListOr<DrawnAngles>")]
struct WrittenAngles(Angles);

impl Default for WrittenAngles {
    fn default() -> Self {
        Self(Angles::Choice(vec![0.0]))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DrawnAngles {
    uniform: [f64; 2],
}

impl TryFrom<ListOr<DrawnAngles>> for WrittenAngles {
    type Error = String;

    fn try_from(written: ListOr<DrawnAngles>) -> Result<Self, String> {
        #[expect(clippy::cast_possible_truncation, reason = "viewpoints are f32")]
        let rounded = |angle: f64| angle as f32;
        match written {
            ListOr::List(angles) if angles.is_empty() => {
                Err("expected at least one angle, as in [0, 90]".into())
            }
            ListOr::List(angles) => Ok(Self(Angles::Choice(
                angles.into_iter().map(rounded).collect(),
            ))),
            ListOr::Table(DrawnAngles { uniform }) => {
                check_range(uniform)?;
                Ok(Self(Angles::Between(uniform.map(rounded))))
            }
        }
    }
}

impl Angles {
    /// Returns the least and the greatest angle, or all.
    fn ends(&self) -> &[f32] {
        match self {
            Self::Choice(angles) => angles,
            Self::Between(ends) => ends,
        }
    }
}

impl WrittenViews {
    pub(super) fn viewpoints(self) -> Result<Viewpoints, String> {
        let (azimuth, elevation) = (self.azimuth_deg.0, self.elevation_deg.0);
        let view = |azimuth, elevation| View::new(azimuth, elevation).map_err(|e| e.to_string());
        let mut grid = Vec::new();
        for &azimuth in azimuth.ends() {
            for &elevation in elevation.ends() {
                grid.push(view(azimuth, elevation)?);
            }
        }
        match (self.count, &azimuth, &elevation) {
            (None, Angles::Choice(_), Angles::Choice(_)) => Ok(Viewpoints::Grid(grid)),
            (None, ..) => {
                Err("expected count = N, the number of viewpoints sampled for each cycle".into())
            }
            (Some(PositiveNumber(count)), ..) => Ok(Viewpoints::Drawn {
                azimuth,
                elevation,
                count,
            }),
        }
    }
}
