//! An audit of people, synthetic or recorded: measures of their decoded gait cycles beside
//! published norms.

mod measure;
mod norms;
#[cfg(test)]
mod tests;

pub use measure::{Measure, Measures};
pub use norms::{PublishedNorm, norm};

use crate::people::extent;
use edgegait_core::pack::{Gait, Pack, Sex};
use measure::Decoded;
use rayon::prelude::*;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt;

/// One measure of the people of one sex at one speed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AuditLine {
    /// Walking or running.
    #[serde(serialize_with = "write_gait")]
    pub gait: Gait,
    /// Speed, km/h, rounded to a whole number.
    pub speed_kmh: u16,
    /// Sex of the people, where it is known.
    #[serde(serialize_with = "write_sex")]
    pub sex: Option<Sex>,
    /// The quantity that is measured.
    #[serde(serialize_with = "write_measure")]
    pub measure: Measure,
    /// Number of people.
    pub people: usize,
    /// Mean over people.
    pub mean: f64,
    /// Standard deviation between people.
    pub sd: f64,
    /// The least and the greatest value of a person.
    pub range: (f64, f64),
    /// Published norm of such people; of either sex where theirs is not known.
    pub norm: Option<PublishedNorm>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde's signature")]
fn write_gait<S: Serializer>(gait: &Gait, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(gait.name())
}

fn write_sex<S: Serializer>(sex: &Option<Sex>, to: S) -> Result<S::Ok, S::Error> {
    sex.map(Sex::name).serialize(to)
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde's signature")]
fn write_measure<S: Serializer>(measure: &Measure, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(measure.name())
}

/// The largest amount by which a spread may differ from the published one, as a share.
const SPREAD: f64 = 0.25;

/// How far a person may be outside the range of means, in published standard deviations: of 999
/// people of a normal distribution, one in 16 populations has one beyond 4. Our choice.
const FARTHEST_SD: f64 = 4.0;

impl AuditLine {
    /// Returns whether the mean lies in the range of healthy people; true if there is no norm.
    #[must_use]
    pub fn mean_holds(&self) -> bool {
        self.norm
            .is_none_or(|norm| (norm.mean.0..=norm.mean.1).contains(&self.mean))
    }

    /// Returns whether the spread is as published within a quarter; true if none is published.
    #[must_use]
    pub fn spread_holds(&self) -> bool {
        let sd = self.norm.and_then(|norm| norm.sd);
        sd.is_none_or(|(low, high)| {
            ((1.0 - SPREAD) * low..=(1.0 + SPREAD) * high).contains(&self.sd)
        })
    }

    /// Returns whether every person is within four published standard deviations of the range of
    /// means; true if no spread is published.
    #[must_use]
    pub fn people_hold(&self) -> bool {
        self.norm.is_none_or(|norm| {
            norm.sd.is_none_or(|(_, sd)| {
                self.range.0 >= norm.mean.0 - FARTHEST_SD * sd
                    && self.range.1 <= norm.mean.1 + FARTHEST_SD * sd
            })
        })
    }
}

/// Measures of all people of a pack.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Audit {
    /// Lines in the order of gait, speed, sex and measure.
    pub lines: Vec<AuditLine>,
}

impl Audit {
    /// Measures the gait cycles of a pack: each person counts once at each speed, with the mean of
    /// the cycles. Uncut motions are not measured.
    #[must_use]
    pub fn measure(pack: &Pack<'_>) -> Self {
        type Group = (Gait, u16, Option<Sex>);
        let walks: Vec<_> = (0..pack.walks().len()).collect();
        let measured: Vec<(Group, usize, Measures)> = walks
            .into_par_iter()
            .filter_map(|index| {
                let walk = pack.walk(index)?;
                let subject = pack.subject(walk.subject)?;
                let clip = pack.clip(walk.clip)?.as_loop()?;
                let avatar = pack.avatar(walk.avatar)?;
                let kmh = (3.6e-3 * f64::from(walk.speed_mm_per_s)).round() as u16;
                let measures = Decoded::new(&avatar, &clip).measures();
                Some(((walk.gait, kmh, subject.sex), walk.subject, measures))
            })
            .collect();
        // Takes each person's mean first, then the people's.
        let mut people: BTreeMap<(Group, usize), Vec<Measures>> = BTreeMap::new();
        for (group, person, measures) in measured {
            people.entry((group, person)).or_default().push(measures);
        }
        let mut groups: BTreeMap<Group, Vec<Measures>> = BTreeMap::new();
        for ((group, _), cycles) in people {
            let mean = std::array::from_fn(|index| {
                cycles.iter().map(|cycle| cycle[index]).sum::<f64>() / cycles.len() as f64
            });
            groups.entry(group).or_default().push(mean);
        }
        let lines = groups.into_iter().flat_map(|((gait, kmh, sex), people)| {
            Measure::ALL
                .into_iter()
                .enumerate()
                .map(move |(index, measure)| {
                    let values: Vec<f64> = people.iter().map(|person| person[index]).collect();
                    let (mean, sd) = mean_and_sd(&values);
                    AuditLine {
                        gait,
                        speed_kmh: kmh,
                        sex,
                        measure,
                        people: values.len(),
                        mean,
                        sd,
                        range: extent(values.iter().copied()),
                        norm: norm(measure, gait, sex, f64::from(kmh) / 3.6),
                    }
                })
                .collect::<Vec<_>>()
        });
        Self {
            lines: lines.collect(),
        }
    }
}

fn mean_and_sd(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values
        .iter()
        .map(|value| (value - mean) * (value - mean))
        .sum();
    (mean, (squares / (count - 1.0).max(1.0)).sqrt())
}

impl fmt::Display for Audit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.lines.is_empty() {
            return writeln!(f, "no cycles to measure (uncut motions are not measured)");
        }
        writeln!(
            f,
            "{:<30} {:<6} {:>4} {:>3} {:>6} {:>8} {:>7} {:>8} {:>8}  published",
            "measure", "", "km/h", "sex", "people", "mean", "sd", "least", "most"
        )?;
        for line in &self.lines {
            let gait = line.gait.name();
            let sex = match line.sex {
                Some(Sex::Female) => "F",
                Some(Sex::Male) => "M",
                None => "",
            };
            write!(
                f,
                "{:<30} {gait:<6} {:>4} {sex:>3} {:>6} {:>8.2} {:>7.2} {:>8.2} {:>8.2}  ",
                line.measure.name(),
                line.speed_kmh,
                line.people,
                line.mean,
                line.sd,
                line.range.0,
                line.range.1,
            )?;
            let Some(norm) = line.norm else {
                writeln!(f, "no norm")?;
                continue;
            };
            write!(f, "{:.1} to {:.1}", norm.mean.0, norm.mean.1)?;
            if let Some((low, high)) = norm.sd {
                write!(f, ", sd {low:.2} to {high:.2}")?;
            }
            write!(f, " ({})", norm.source)?;
            if !line.mean_holds() {
                write!(f, "  MEAN OUTSIDE")?;
            }
            if !line.spread_holds() {
                write!(f, "  SPREAD OUTSIDE")?;
            }
            if !line.people_hold() {
                write!(f, "  PERSON OUTSIDE")?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}
