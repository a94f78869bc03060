//! Strengths in conditions: fixed, or sampled from a distribution.

use super::catalogue::ConfounderKind;
use super::dose::{Dose, Doses};
use crate::people::cohort::normal;
use rand::{Rng, RngExt as _};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Steps from 0 to 1 to which sampled strengths are rounded, so that results state them exactly.
const STEPS: f64 = 1000.0;

/// The distribution of a confounder's strength.
#[derive(Clone, Debug, PartialEq)]
pub enum StrengthSpread {
    /// A fixed strength.
    Fixed(f64),
    /// A uniform distribution between two strengths.
    Uniform([f64; 2]),
    /// A normal distribution: mean and standard deviation, sampled again outside the confounder's
    /// range.
    Normal([f64; 2]),
    /// One of these strengths, each with the same chance.
    Choice(Vec<f64>),
}

/// The unit for which a strength is sampled anew.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Per {
    /// Each person: the same strength in all of their walks.
    Person,
    /// Each take: eight cycles of a walk.
    Take,
    /// Each gait cycle: the same strength from all viewpoints.
    #[default]
    Cycle,
}

/// A confounder with the chance that it acts and the distribution of its strength.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomDose {
    /// The confounder that may act.
    pub kind: ConfounderKind,
    /// The chance that it acts, 0..=1.
    pub chance: f64,
    /// The distribution of the strength where it acts.
    pub spread: StrengthSpread,
    /// The unit for which action and strength are sampled anew.
    pub per: Per,
}

impl RandomDose {
    /// Returns whether the confounder always acts, at a fixed strength.
    #[must_use]
    pub fn is_fixed(&self) -> bool {
        matches!(self.spread, StrengthSpread::Fixed(_)) && self.chance >= 1.0
    }

    /// Returns whether the confounder can change anything.
    #[must_use]
    pub fn can_act(&self) -> bool {
        let strengths: &[f64] = match &self.spread {
            StrengthSpread::Fixed(strength) => &[*strength],
            StrengthSpread::Uniform(ends) | StrengthSpread::Normal(ends) => ends,
            StrengthSpread::Choice(strengths) => strengths,
        };
        self.chance > 0.0 && strengths.iter().any(|&strength| strength != 0.0)
    }

    /// Samples a dose; its strength is 0 where the confounder does not act.
    pub(super) fn dose(&self, rng: &mut impl Rng) -> Dose {
        let acts = rng.random::<f64>() < self.chance;
        let strength = match &self.spread {
            StrengthSpread::Fixed(strength) => *strength,
            StrengthSpread::Uniform([low, high]) => {
                rounded(low + (high - low) * rng.random::<f64>())
            }
            StrengthSpread::Normal([mean, sd]) => {
                let (least, most) = range(self.kind);
                loop {
                    let strength = mean + sd * normal(rng);
                    if (least..=most).contains(&strength) {
                        break rounded(strength);
                    }
                }
            }
            StrengthSpread::Choice(strengths) => strengths[rng.random_range(0..strengths.len())],
        };
        Dose {
            kind: self.kind,
            strength: if acts { strength } else { 0.0 },
        }
    }
}

fn rounded(strength: f64) -> f64 {
    (strength * STEPS).round() / STEPS
}

/// The random confounders of a condition, in the order of application.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RandomDoses(Vec<RandomDose>);

impl RandomDoses {
    pub(super) fn new(mut draws: Vec<RandomDose>) -> Self {
        draws.retain(RandomDose::can_act);
        draws.sort_by_key(|draw| draw.kind);
        Self(draws)
    }

    /// Returns the draws in the order of application.
    #[must_use]
    pub fn list(&self) -> &[RandomDose] {
        &self.0
    }
}

impl From<Doses> for RandomDoses {
    fn from(doses: Doses) -> Self {
        let draw = |dose: &Dose| RandomDose {
            kind: dose.kind,
            chance: 1.0,
            spread: StrengthSpread::Fixed(dose.strength),
            per: Per::default(),
        };
        Self::new(doses.list().iter().map(draw).collect())
    }
}

/// Writes `backpack=0.5,roll=0.1 to 0.2`.
impl fmt::Display for RandomDoses {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for draw in &self.0 {
            write!(f, "{separator}{}=", draw.kind.confounder().name)?;
            match &draw.spread {
                StrengthSpread::Fixed(strength) => write!(f, "{strength}")?,
                StrengthSpread::Uniform([low, high]) => write!(f, "{low} to {high}")?,
                StrengthSpread::Normal([mean, sd]) => write!(f, "{mean} +-{sd}")?,
                StrengthSpread::Choice(strengths) => {
                    let strengths: Vec<String> = strengths.iter().map(f64::to_string).collect();
                    f.write_str(&strengths.join(" or "))?;
                }
            }
            if draw.chance < 1.0 {
                write!(f, " ({} %)", 100.0 * draw.chance)?;
            }
            separator = ",";
        }
        Ok(())
    }
}

/// Returns the least and the greatest strength of a confounder.
pub(super) fn range(kind: ConfounderKind) -> (f64, f64) {
    let is_signed = kind.confounder().is_signed;
    (if is_signed { -1.0 } else { 0.0 }, 1.0)
}

#[cfg(test)]
mod tests {
    use super::super::{Condition, Conditions};
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;
    use std::path::Path;

    fn parsed(confounders: &str) -> Result<Condition, String> {
        let text = format!("[[conditions]]\nname = 'a'\nconfounders = {{ {confounders} }}");
        let conditions = Conditions::parse(Path::new("c.toml"), &text);
        let conditions = conditions.map_err(|error| error.to_string())?;
        Ok(conditions.list[0].clone())
    }

    /// Samples 20,000 strengths of a confounder from its TOML.
    fn strengths(written: &str) -> Vec<f64> {
        let condition = parsed(written).expect(written);
        let draw = condition.draws(0)[0].clone();
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        (0..20_000).map(|_| draw.dose(&mut rng).strength).collect()
    }

    fn mean_and_sd(values: &[f64]) -> (f64, f64) {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares = values.iter().map(|value| (value - mean).powi(2));
        (mean, (squares.sum::<f64>() / count).sqrt())
    }

    #[test]
    fn strengths_are_as_often_and_as_strong_as_is_written() {
        let packs = strengths("backpack = { p = 0.3, uniform = [0.2, 1] }");
        let acting: Vec<f64> = packs.iter().copied().filter(|&s| s > 0.0).collect();
        let share = acting.len() as f64 / packs.len() as f64;
        assert!((share - 0.3).abs() < 0.01, "{share}");
        // A uniform distribution's deviation is its width over the square root of 12.
        let (mean, sd) = mean_and_sd(&acting);
        assert!((mean - 0.6).abs() < 0.01 && (sd - 0.8 / 12f64.sqrt()).abs() < 0.005);
        assert!(acting.iter().all(|s| (0.2..=1.0).contains(s)));
        // Results state strengths exactly, in at most three decimals.
        assert!(acting.iter().all(|s| format!("{s}").len() <= 5));

        // 3 of 20 degrees. `normal` samples deviates beyond 2.5 again, which leaves 0.95 of the
        // deviation.
        let (mean, sd) = mean_and_sd(&strengths("roll = { normal = ['0 deg', '3 deg'] }"));
        assert!(
            mean.abs() < 0.005 && (sd - 0.95 * 0.15).abs() < 0.005,
            "{mean} {sd}"
        );
        let cut = strengths("coat = { normal = [0.9, 0.5] }");
        assert!(cut.iter().all(|s| (0.0..=1.0).contains(s)));

        let choice = strengths("hat = { choice = [0.25, 0.5, 1] }");
        for wanted in [0.25, 0.5, 1.0] {
            let share = choice.iter().filter(|&&s| s == wanted).count() as f64 / 20_000.0;
            assert!((share - 1.0 / 3.0).abs() < 0.01, "{wanted}: {share}");
        }
        let half = strengths("hair = { p = 0.5, strength = 0.75 }");
        let (mean, _) = mean_and_sd(&half);
        assert!((mean - 0.375).abs() < 0.01 && half.iter().all(|&s| s == 0.0 || s == 0.75));
    }

    #[test]
    fn what_is_written_is_stated_and_read_again() {
        let all = "coat = 0.5, hat = { p = 0.25, strength = 1 }, roll = { uniform = ['-5 deg', 0.5], per = 'person' }, hair = { choice = [0.2, 1] }, light = { p = 0, strength = 1 }, speed = { normal = [0, 0.2], per = 'take' }";
        let condition = parsed(all).expect("a condition");
        assert_eq!(
            condition.confounders.to_string(),
            "coat=0.5,hair=0.2 or 1,hat=1 (25 %),speed=0 +-0.2,roll=-0.25 to 0.5"
        );
        assert!(!condition.is_fixed() && !condition.is_clean());
        assert!(parsed("coat = 0.5").expect("a condition").is_fixed());
        assert!(
            parsed("coat = { p = 0, strength = 1 }")
                .expect("one")
                .is_clean()
        );
        let json = serde_json::to_string(&condition).expect("JSON");
        assert_eq!(
            serde_json::from_str::<Condition>(&json).expect("a condition"),
            condition
        );
    }

    #[test]
    fn impossible_distributions_are_refused_with_the_line_and_what_was_expected() {
        for (written, expected) in [
            (
                "roll = { normal = [0, -0.1] }",
                "deviation of 0 to 2 (as a strength), found -0.1",
            ),
            ("roll = { normal = ['0 deg', '-3 deg'] }", "found -0.15"),
            ("roll = { normal = [0, nan] }", "found NaN"),
            (
                "roll = { normal = ['30 deg', '1 deg'] }",
                "expected -20 to 20 deg",
            ),
            (
                "coat = { uniform = [0.2, 1.5] }",
                "a strength of 0 to 1, found 1.5",
            ),
            ("coat = { uniform = [0.8, 0.2] }", "found 0.8 above 0.2"),
            ("coat = { uniform = [0.8] }", "2"),
            (
                "coat = { p = 1.5, strength = 1 }",
                "p from 0 to 1, found 1.5",
            ),
            ("coat = { p = 0.5 }", "expected one of strength"),
            (
                "coat = { strength = 1, choice = [1] }",
                "expected one of strength",
            ),
            ("coat = { choice = [] }", "expected one of strength"),
            ("coat = { gauss = [0, 1] }", "gauss"),
            ("coat = { strength = 1, per = 'frame' }", "frame"),
            ("coat = { choice = [{ p = 1 }] }", "found a table"),
        ] {
            let error = parsed(written).expect_err(written);
            assert!(error.contains(expected), "{written}: {error}");
            assert!(error.contains("c.toml:3: "), "{written}: {error}");
        }
    }
}
