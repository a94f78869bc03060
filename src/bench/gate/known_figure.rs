//! What is known of a value of results: its estimate from all runs, and whether that is reliable.

use super::estimate::{Estimate, FigureKind, disturbance};
use super::figure::{FigurePath, ResultFigure};
use super::judge::BaselineChange;
use super::limits::GateLimit;
use super::results::ResultFile;
use crate::evaluate::paired::{PairedEstimate, PairedRates, paired_rates};
use crate::evaluate::paired_results::PersonResult;
use crate::evaluate::wilson::Interval;
use serde::Deserialize as _;
use std::mem::discriminant;

/// The maximum of a person's probes in results: sums over people cannot overflow.
const MOST_PROBES: u64 = 1 << 32;

/// The estimate of one value, and its reliability.
pub(super) struct KnownFigure {
    pub estimate: Estimate,
    /// The estimate that decides: without a limit on the better side if other processes kept the
    /// machine busy in every run.
    pub judged: Estimate,
    /// Why the estimate is unreliable.
    pub unsure: Option<String>,
    /// Whether some viewpoints were left out for lack of time.
    is_cut: bool,
    /// Hits by person, if the value is a rate of hits.
    by_person: Option<Vec<PersonResult>>,
}

/// A value beside the baseline's.
pub(super) struct KnownChange {
    pub between: BaselineChange,
    /// Why one of the estimates is unreliable.
    pub unsure: Option<String>,
    /// Whether some viewpoints of one were left out for lack of time.
    pub is_cut: bool,
}

impl KnownFigure {
    /// Returns the estimate of a limit's value, divided by what the limit states.
    pub(super) fn of_limit(
        place: &ResultFigure<'_>,
        limit: &GateLimit,
        runs: &[ResultFile],
    ) -> Result<Self, String> {
        let mut known = Self::from_runs(place, &limit.figure, runs)?;
        let Some(per) = limit.per_text() else {
            return Ok(known);
        };
        let [mut sum, mut judged] = [Estimate::exact(0.0); 2];
        for part in &limit.per {
            let said = |problem| format!("{}: per: {problem}", runs[0].path.display());
            let places = part.figure.places(&runs[0].value).map_err(said)?;
            let [divisor] = &places[..] else {
                let problem = format!("{}: expected one value, found {}", part.text, places.len());
                return Err(said(problem));
            };
            let is_one = limit.per.len() == 1 && part.times == 1;
            require_comparable([place, divisor], is_one)?;
            let divisor = Self::from_runs(divisor, &part.figure, runs)?;
            sum = sum.plus(divisor.estimate, part.times);
            judged = judged.plus(divisor.judged, part.times);
            known.unsure = known.unsure.or(divisor.unsure);
            known.is_cut |= divisor.is_cut;
        }
        let value = known.estimate.value;
        if value < 0.0 || sum.value <= 0.0 {
            return Err(format!(
                "{} per {per}: expected a value of at least 0 and one above 0, found {value} and {}",
                place.path, sum.value
            ));
        }
        known.estimate = BaselineChange::apart(known.estimate, sum).ratio;
        known.judged = BaselineChange::apart(known.judged, judged).ratio;
        known.by_person = None;
        Ok(known)
    }

    /// Returns the estimate from all runs; each must have the value. Disturbed runs count only if
    /// there are no quiet ones. `figure` is the path as written.
    fn from_runs(
        place: &ResultFigure<'_>,
        figure: &FigurePath,
        runs: &[ResultFile],
    ) -> Result<Self, String> {
        let measure = FigureKind::from_key(&place.key);
        let path = FigurePath::parse(&place.path)?;
        let mut places = Vec::new();
        for run in runs {
            let said = |problem: String| format!("{}: {problem}", run.path.display());
            let exact = path.places(&run.value);
            // The model has another name in this run: use the path in the limit.
            let meant = || match figure.places(&run.value) {
                Ok(one) if one.len() == 1 => Some(one),
                _ => None,
            };
            let found = match exact {
                Ok(found) => found,
                Err(problem) => meant().ok_or_else(|| said(problem))?,
            };
            if let Some(bad) = found.iter().find(|place| !place.value.is_finite()) {
                let problem = format!(
                    "{}: expected a finite number, found {}",
                    bad.path, bad.value
                );
                return Err(said(problem));
            }
            places.extend(found);
        }
        let mut unsure = None;
        let mut is_disturbed = false;
        if measure.is_timed() {
            let (quiet, disturbed): (Vec<_>, Vec<_>) = places
                .into_iter()
                .partition(|place| disturbance(place).is_none());
            is_disturbed = quiet.is_empty();
            places = if is_disturbed { disturbed } else { quiet };
            unsure = places.iter().find_map(disturbance);
        }
        let cut = places
            .iter()
            .find_map(cut_of)
            .filter(|_| place.key == "rank1");
        let people = places
            .first()
            .and_then(|place| place.object()?.get("by_person"));
        let estimate = Estimate::from_runs(&places, measure);
        let by_person = people.and_then(|people| Vec::<PersonResult>::deserialize(people).ok());
        let mut everyone = by_person.iter().flatten();
        if let Some(wrong) = everyone.find(|one| one.hits > one.probes || one.probes > MOST_PROBES)
        {
            return Err(format!(
                "{}: {}: by_person: expected at most {MOST_PROBES} probes of {} and no more hits, found {} and {}",
                runs[0].path.display(),
                place.path,
                wrong.person,
                wrong.probes,
                wrong.hits
            ));
        }
        Ok(Self {
            estimate,
            judged: match is_disturbed {
                true => estimate.disturbed(measure),
                false => estimate,
            },
            is_cut: cut.is_some(),
            unsure: unsure.or(cut),
            by_person,
        })
    }

    /// Compares with the baseline's value; intervals are resampled with `seed`.
    ///
    /// # Errors
    /// If rates of hits are not of the same people and probes.
    pub(super) fn change_from(
        &self,
        old: &Self,
        key: &str,
        seed: u64,
    ) -> Result<KnownChange, String> {
        let is_cut = self.is_cut || old.is_cut;
        let paired = match self.paired(old, key, seed) {
            // With viewpoints cut for lack of time, the probes differ.
            Some(Err(_)) if is_cut => None,
            other => other.transpose()?,
        };
        let of_baseline = |why: &String| format!("in the baseline: {why}");
        Ok(KnownChange {
            between: paired.unwrap_or_else(|| BaselineChange::apart(self.judged, old.judged)),
            unsure: self.unsure.clone().or(old.unsure.as_ref().map(of_baseline)),
            is_cut,
        })
    }

    /// Compares two rates of hits on the same people; none if the values are not such rates.
    fn paired(&self, old: &Self, key: &str, seed: u64) -> Option<Result<BaselineChange, String>> {
        let (checked, baseline) = self.by_person.as_ref().zip(old.by_person.as_ref())?;
        if key != "rank1" || checked.is_empty() || baseline.is_empty() {
            return None;
        }
        let Some(PairedRates { ratio, difference }) = paired_rates([checked, baseline], seed)
        else {
            return Some(Err(
                "expected a baseline with the same people and probes, found others".into(),
            ));
        };
        // With one person there is no interval.
        let estimate = |PairedEstimate { value, interval }| match interval {
            Some(Interval { low, high }) => Estimate { value, low, high },
            None => Estimate {
                value,
                low: f64::NEG_INFINITY,
                high: f64::INFINITY,
            },
        };
        Some(Ok(BaselineChange {
            ratio: estimate(ratio),
            difference: estimate(difference),
            is_paired: true,
        }))
    }
}

/// Checks that a value may be divided by another. `is_one` states that it is the only divisor and
/// counts once: then both are of iterations, or of elements.
fn require_comparable(both: [&ResultFigure<'_>; 2], is_one: bool) -> Result<(), String> {
    let [kind, other_kind] = both.map(|side| discriminant(&FigureKind::from_key(&side.key)));
    let [counts, other_counts] = both.map(|side| side.beside("elements").is_some());
    let [is_of_element, other_is_of_element] = both.map(|side| side.key == "per_element_ns");
    let problem = if kind != other_kind {
        "two times, two of throughput, or two others"
    } else if is_one && (counts != other_counts || is_of_element != other_is_of_element) {
        "both or neither to count elements (criterion's Throughput)"
    } else {
        return Ok(());
    };
    let [value, divisor] = both.map(|side| &side.path);
    Err(format!("{value} per {divisor}: expected {problem}"))
}

/// Returns a remark if a rate of hits does not cover all planned viewpoints.
fn cut_of(place: &ResultFigure<'_>) -> Option<String> {
    let (made, planned) = (
        place.beside("viewpoints")?,
        place.beside("viewpoints_planned")?,
    );
    (made < planned).then(|| format!("there was time for only {made} of {planned} viewpoints"))
}
