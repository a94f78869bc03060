//! The effect of each confounder on recognizers, by strength, and its cost.

use super::intervals::Rank1Intervals;
use super::results::RecognizerResult;
use crate::draw::confounders::{Condition, Confounder, NORMAL};
use crate::draw::confounders::{Dose, Doses};
use crate::draw::sweep::{Job, Settings, Swept, View, sweep};
use crate::error::{EvaluateError, Result};
use edgegait_core::pack::Pack;
use serde::Serialize;
use std::time::Instant;

/// A confounder's effects.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct ConfounderResult {
    /// The confounder's name.
    pub name: &'static str,
    /// Name of its class.
    pub class: &'static str,
    /// The confounder at strength 1, in words.
    pub at_full: &'static str,
    /// Effects by rising strength. The first is at 0 or, for a confounder with an opposite, at -1.
    pub by_strength: Vec<StrengthResult>,
    /// Additional time per silhouette at strength 1, ns: one walk seen from the views, one thread.
    /// Negative within the noise.
    pub extra_ns: f64,
}

/// The effects of a confounder at one strength.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct StrengthResult {
    /// The strength; 0 changes nothing.
    pub strength: f64,
    /// Root mean square difference from GEIs without the confounder, of 255.
    pub gei_rmse: f64,
    /// Rank-1 of each recognizer, in order.
    pub recognizers: Vec<Rank1Rate>,
}

/// Rank-1 of one recognizer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Rank1Rate {
    /// The recognizer's name.
    pub name: String,
    /// Share of hits, 0..1.
    pub rank1: f64,
    /// The 95 % intervals of Rank-1.
    #[serde(flatten)]
    pub intervals: Rank1Intervals,
}

impl ConfounderResult {
    /// Returns the mean of a recognizer's Rank-1 over all strengths except 0.
    #[must_use]
    pub(crate) fn mean_rank1(&self, recognizer: usize) -> f64 {
        let changed = self.by_strength.iter().filter(|at| at.strength != 0.0);
        let rates: Vec<f64> = changed.map(|at| at.recognizers[recognizer].rank1).collect();
        rates.iter().sum::<f64>() / rates.len().max(1) as f64
    }
}

/// The conditions in which confounders are measured.
#[derive(Clone, Debug)]
pub(crate) struct StrengthStudy {
    confounders: Vec<&'static Confounder>,
    /// The conditions; the first one is without a confounder.
    conditions: Vec<Condition>,
    /// Confounder and strength of each other condition.
    points: Vec<(usize, f64)>,
}

impl StrengthStudy {
    /// Creates a study with each confounder alone at each of these strengths above 0, and
    /// confounders with an opposite at the negative strengths too.
    #[must_use]
    pub(crate) fn new(confounders: &[&'static Confounder], strengths: &[f64]) -> Self {
        let mut strengths = strengths.to_vec();
        strengths.sort_by(f64::total_cmp);
        let mut study = Self {
            confounders: confounders.to_vec(),
            conditions: vec![Condition {
                name: NORMAL.into(),
                ..Condition::from_doses(Doses::default())
            }],
            points: Vec::new(),
        };
        for (number, confounder) in confounders.iter().enumerate() {
            let opposite = strengths.iter().rev().map(|strength| -strength);
            let opposite = opposite.filter(|_| confounder.is_signed);
            for strength in opposite.chain(strengths.iter().copied()) {
                let dose = Dose {
                    kind: confounder.kind,
                    strength,
                };
                study
                    .conditions
                    .push(Condition::from_doses(Doses::new([dose])));
                study.points.push((number, strength));
            }
        }
        study
    }

    /// Returns the conditions, in the order of the results' sets of probes.
    #[must_use]
    pub(crate) fn conditions(&self) -> &[Condition] {
        &self.conditions
    }

    /// Combines recognizers' results under each condition with [`Self::effects`] and
    /// [`Self::costs`].
    ///
    /// # Errors
    /// If a recognizer was not evaluated under each condition.
    pub(crate) fn results(
        &self,
        recognizers: &[RecognizerResult],
        effects: &[f64],
        costs: &[f64],
    ) -> Result<Vec<ConfounderResult>> {
        let rank1 = |condition: usize| -> Result<Vec<Rank1Rate>> {
            let name = &self.conditions[condition].name;
            let of = |result: &RecognizerResult| {
                let set = result.probe_sets.iter().find(|set| set.name == *name);
                let set = set.ok_or_else(|| EvaluateError::NotAsked {
                    recognizer: result.name.clone(),
                    condition: name.clone(),
                })?;
                Ok(Rank1Rate {
                    name: result.name.clone(),
                    rank1: set.rank1,
                    intervals: set.intervals,
                })
            };
            recognizers.iter().map(of).collect()
        };
        let plain = StrengthResult {
            strength: 0.0,
            gei_rmse: 0.0,
            recognizers: rank1(0)?,
        };
        let mut results = Vec::new();
        for (number, confounder) in self.confounders.iter().enumerate() {
            let mut by_strength = vec![plain.clone()];
            for (at, &(of, strength)) in self.points.iter().enumerate() {
                if of == number {
                    by_strength.push(StrengthResult {
                        strength,
                        gei_rmse: effects[at],
                        recognizers: rank1(1 + at)?,
                    });
                }
            }
            by_strength.sort_by(|a, b| a.strength.total_cmp(&b.strength));
            results.push(ConfounderResult {
                name: confounder.name,
                class: confounder.class.name(),
                at_full: confounder.at_full,
                by_strength,
                extra_ns: costs[number],
            });
        }
        Ok(results)
    }

    /// Returns the root mean square difference between GEIs under each condition and those under
    /// the first one, of 255.
    ///
    /// # Errors
    /// If a figure cannot be rendered.
    pub(crate) fn effects(
        &self,
        pack: &Pack<'_>,
        walks: &[usize],
        views: &[View],
        settings: Settings,
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<Vec<f64>> {
        let plain: Vec<Job<'_>> = walks.iter().map(|&walk| Job::plain(walk, 0)).collect();
        let geis = |jobs: &[Job<'_>]| -> Result<Vec<Vec<u8>>> {
            let mut all = Vec::new();
            let keep = |_: Job<'_>, swept: Swept| Ok(swept.templates);
            sweep(pack, jobs, views, settings, keep, |_, geis| {
                all.extend(geis);
                Ok(())
            })?;
            progress()?;
            Ok(all)
        };
        let known = geis(&plain)?;
        let effect = |condition: &Condition| {
            let found = geis(&Job::under(&plain, std::slice::from_ref(condition)))?;
            Ok(rmse(&known, &found))
        };
        self.conditions[1..].iter().map(effect).collect()
    }

    /// Returns the additional time per silhouette of each confounder at the highest strength, ns:
    /// the least of `rounds` measurements. Each round measures all confounders.
    ///
    /// # Errors
    /// If a figure cannot be rendered.
    pub(crate) fn costs(
        &self,
        pack: &Pack<'_>,
        walk: usize,
        views: &[View],
        settings: Settings,
        rounds: usize,
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<Vec<f64>> {
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        let strongest = |number: usize| {
            let of = self.points.iter().rposition(|&(of, _)| of == number);
            of.map_or(0, |at| 1 + at)
        };
        let measured: Vec<usize> = std::iter::once(0)
            .chain((0..self.confounders.len()).map(strongest))
            .collect();
        let mut least = vec![f64::INFINITY; measured.len()];
        for _ in 0..rounds {
            for (&condition, least) in measured.iter().zip(&mut least) {
                let job = Job {
                    condition: Some(&self.conditions[condition]),
                    ..Job::plain(walk, 0)
                };
                let started = Instant::now();
                let keep = |_: Job<'_>, swept: Swept| Ok(swept.templates.len());
                alone.install(|| sweep(pack, &[job], views, settings, keep, |_, _| Ok(())))?;
                let silhouettes = views.len() as f64 * f64::from(settings.frames_per_cycle);
                *least = least.min(started.elapsed().as_secs_f64() * 1e9 / silhouettes);
                progress()?;
            }
        }
        Ok(least[1..].iter().map(|ns| ns - least[0]).collect())
    }
}

/// Returns the root mean square difference of all bytes.
fn rmse(a: &[Vec<u8>], b: &[Vec<u8>]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    let (sum, count) = pairs.fold((0.0, 0.0), |(sum, count), (&a, &b)| {
        let difference = f64::from(a) - f64::from(b);
        (sum + difference * difference, count + 1.0)
    });
    libm::sqrt(sum / f64::max(count, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::confounders::catalogue::named;

    #[test]
    fn a_study_has_each_confounder_at_each_strength_and_opposites_where_there_are() {
        let confounders = ["roll", "coat"].map(|name| named(name).expect("there is one"));
        let study = StrengthStudy::new(&confounders, &[1.0, 0.5]);
        let names: Vec<&str> = study.conditions().iter().map(|c| c.name.as_str()).collect();
        assert_eq!(
            names,
            [
                "normal",
                "roll=-1",
                "roll=-0.5",
                "roll=0.5",
                "roll=1",
                "coat=0.5",
                "coat=1"
            ]
        );
        assert!(
            study
                .results(&[], &[0.0; 6], &[0.0; 2])
                .is_ok_and(|results| {
                    let strengths = |at: usize| -> Vec<f64> {
                        let points: &[StrengthResult] = &results[at].by_strength;
                        points.iter().map(|point| point.strength).collect()
                    };
                    strengths(0) == [-1.0, -0.5, 0.0, 0.5, 1.0] && strengths(1) == [0.0, 0.5, 1.0]
                })
        );
    }

    #[test]
    fn differences_are_root_mean_squares() {
        // Differences of 3 and 4 in two pixels: the root of 12.5.
        assert!((rmse(&[vec![3, 0]], &[vec![0, 4]]) - 12.5f64.sqrt()).abs() < 1e-12);
        assert_eq!(rmse(&[], &[]), 0.0);
    }
}
