//! Limits on values of results, which decide whether a build passes.
//!
//! A file of limits ([`limits`]) names values by their paths in the JSON ([`figure`]). Each value
//! has an interval ([`estimate`]), from several runs or from fields next to it. [`judge`] decides
//! whether a limit holds, is missed, or is undecided ("cannot tell"), so that noise neither fails a
//! build nor passes one. Results that are not comparable are rejected ([`results`]).

mod bencher;
mod estimate;
mod figure;
mod judge;
mod junit;
mod limits;
mod markdown;
mod report;
mod results;
mod starter;

pub(crate) use judge::GateOutcome;
pub(crate) use junit::JUNIT_START;
pub(crate) use limits::GateLimits;
pub(crate) use markdown::MARKDOWN_START;
pub(crate) use report::{GateLine, GateReport};
pub(crate) use results::ResultFile;
pub(crate) use starter::starter;

use crate::error::{Error, FilePlace as Where, Result};
use crate::evaluate::paired::{PairedRates, paired_rates};
use crate::evaluate::paired_results::PersonResult;
use crate::evaluate::wilson::Interval;
use crate::files::ResultHeader;
use estimate::{Estimate, FigureKind, disturbance};
use figure::ResultFigure;
use judge::{BaselineChange, absolute, relative};
use limits::{Bound, GateLimit};
use serde::Deserialize as _;
use std::path::Path;

/// The results to judge, and those of a baseline.
#[derive(Debug)]
pub(crate) struct JudgedRuns<'a> {
    /// The runs to judge, at least one.
    pub runs: &'a [ResultFile],
    /// The runs of the baseline; empty if there is none.
    pub baselines: &'a [ResultFile],
    /// Whether limits relative to a baseline are left out, because there is none.
    pub without_baseline: bool,
}

/// Judges all limits of a file; its path is for messages.
///
/// # Errors
/// If results cannot be compared, or lack a value with a limit. That is never a pass.
pub(crate) fn gate(
    path: &Path,
    limits: &GateLimits,
    judged: &JudgedRuns<'_>,
    header: ResultHeader,
) -> Result<GateReport> {
    let Some(first) = judged.runs.first() else {
        return Err(Error::Missing("results to judge"));
    };
    for run in &judged.runs[1..] {
        first.require_run_of(run)?;
    }
    if let Some((baseline, more)) = judged.baselines.split_first() {
        first.require_like(baseline)?;
        for run in more {
            baseline.require_run_of(run)?;
        }
    }
    let all = || judged.runs.iter().chain(judged.baselines);
    let is_one_board = all().all(|one| all().all(|other| one.is_same_board(other)));
    let mut lines = Vec::new();
    let mut left_out = 0;
    for limit in &limits.limits {
        let mut limit = limit.clone();
        if judged.without_baseline {
            let all = limit.bounds.len();
            limit.bounds.retain(|bound| !bound.is_relative());
            left_out += all - limit.bounds.len();
        }
        let refuse = |problem: String| Error::at(path, Where::Line(limit.line), problem);
        let of_results = |problem: String| refuse(format!("{}: {problem}", first.path.display()));
        for place in limit.figure.places(&first.value).map_err(of_results)? {
            lines.extend(lines_of(&limit, &place, judged, is_one_board).map_err(refuse)?);
        }
    }
    let mut header = header;
    if left_out > 0 {
        let limits = if left_out == 1 { "limit" } else { "limits" };
        header.warnings.push(format!(
            "{left_out} {limits} relative to a baseline left out, because there is none"
        ));
    }
    let mut versions: Vec<&str> = all().map(|file| file.header.version.as_str()).collect();
    versions.sort_unstable();
    versions.dedup();
    if let [one, other, ..] = versions[..] {
        header.warnings.push(format!(
            "results of EdgeGait {one} and {other} are compared: their renderings may differ"
        ));
    }
    Ok(GateReport::new(header, lines))
}

/// Judges each bound of a limit on one value.
fn lines_of(
    limit: &GateLimit,
    place: &ResultFigure<'_>,
    judged: &JudgedRuns<'_>,
    is_one_board: bool,
) -> std::result::Result<Vec<GateLine>, String> {
    let measure = FigureKind::of(&place.key);
    let new = KnownFigure::of(place, limit, judged.runs, measure)?;
    let is_relative = limit.bounds.iter().any(|bound| bound.is_relative());
    let old = match judged.baselines {
        [] if is_relative => {
            return Err(format!(
                "{}: expected a baseline for this limit, found none",
                place.path
            ));
        }
        [] => None,
        baselines => match KnownFigure::of(place, limit, baselines, measure) {
            Ok(known) => Some(known),
            Err(problem) if is_relative => return Err(problem),
            Err(_) => None,
        },
    };
    let mut lines = Vec::new();
    for &bound in &limit.bounds {
        if bound == Bound::NotWorse && measure.better().is_none() {
            return Err(format!(
                "{}: not_worse: expected a value that has a better direction, found {:?} (use ratio_at_most or another bound)",
                place.path, place.key
            ));
        }
        let (outcome, between, unsure) = match old.as_ref().filter(|_| bound.is_relative()) {
            None => {
                let found = new.judged(measure);
                let outcome = absolute(found, bound, measure, limit.judge);
                (outcome, None, new.unsure.clone())
            }
            Some(old) => {
                let seed = judged.runs[0].header.seed;
                let (outcome, between, unsure) = beside(
                    limit,
                    place,
                    bound,
                    measure,
                    &BesideBaseline {
                        new: &new,
                        old,
                        seed,
                        is_one_board,
                    },
                )?;
                (outcome, Some(between), unsure)
            }
        };
        let why = (outcome == GateOutcome::CannotTell).then(|| {
            unsure.unwrap_or_else(|| {
                let more = match measure {
                    FigureKind::Steady(_) => "people, viewpoints or probes",
                    _ => "windows or runs",
                };
                format!("the limit is within the interval (more {more} make it narrower)")
            })
        });
        lines.push(GateLine {
            name: limit.name.clone().unwrap_or_else(|| place.path.clone()),
            figure: place.path.clone(),
            reason: limit.reason.clone(),
            limit: bound.to_string(),
            outcome,
            why,
            found: new.estimate,
            baseline: old.as_ref().map(|old| old.estimate),
            ratio: between.map(|between| between.ratio),
            difference: between.map(|between| between.difference),
        });
    }
    Ok(lines)
}

/// The outcome of a bound, the comparison with the baseline, and why it is undecided.
type Beside = (GateOutcome, BaselineChange, Option<String>);

/// A value, and the baseline that it is compared with.
struct BesideBaseline<'a> {
    new: &'a KnownFigure,
    old: &'a KnownFigure,
    /// What the intervals are resampled with.
    seed: u64,
    /// Whether both were measured on one machine.
    is_one_board: bool,
}

/// Judges a bound relative to a baseline.
fn beside(
    limit: &GateLimit,
    place: &ResultFigure<'_>,
    bound: Bound,
    measure: FigureKind,
    compared: &BesideBaseline<'_>,
) -> std::result::Result<Beside, String> {
    let &BesideBaseline {
        new,
        old,
        seed,
        is_one_board,
    } = compared;
    let is_cut = new.is_cut || old.is_cut;
    let paired = match new.paired(old, &place.key, seed) {
        // With viewpoints cut for lack of time, the probes differ.
        Some(Err(_)) if is_cut => None,
        other => other.transpose()?,
    };
    let between =
        paired.unwrap_or_else(|| BaselineChange::apart(new.judged(measure), old.judged(measure)));
    let of_baseline = |why: &String| format!("in the baseline: {why}");
    let unsure = new.unsure.clone().or(old.unsure.as_ref().map(of_baseline));
    let is_ratio = matches!(bound, Bound::RatioAtMost(_) | Bound::RatioAtLeast(_));
    let (outcome, unsure) = if measure.is_timed() && !is_one_board {
        let why = "the results are not all from one machine and number of threads";
        (GateOutcome::CannotTell, Some(why.to_owned()))
    } else if is_cut {
        (GateOutcome::CannotTell, unsure)
    } else {
        let outcome = relative(between, bound, measure, limit.judge, paired.is_some());
        let below_0 =
            "a ratio of values below 0 is meaningless (use difference_at_most or another bound)";
        let is_untold = is_ratio && between.ratio.value.is_nan();
        (
            outcome,
            if is_untold {
                Some(below_0.to_owned())
            } else {
                unsure
            },
        )
    };
    Ok((outcome, between, unsure))
}

/// The estimate of one value, and its reliability.
struct KnownFigure {
    estimate: Estimate,
    /// Why the estimate is unreliable.
    unsure: Option<String>,
    /// Whether other processes kept the machine busy in every run.
    is_disturbed: bool,
    /// Whether some viewpoints were left out for lack of time.
    is_cut: bool,
    /// Hits by person, if the value is a rate of hits.
    by_person: Option<Vec<PersonResult>>,
}

impl KnownFigure {
    /// Returns the estimate from all runs; each must have the value. Disturbed runs count only if
    /// there are no quiet ones.
    fn of(
        place: &ResultFigure<'_>,
        limit: &GateLimit,
        runs: &[ResultFile],
        measure: FigureKind,
    ) -> std::result::Result<Self, String> {
        let path = figure::FigurePath::parse(&place.path)?;
        let mut places = Vec::new();
        for run in runs {
            let said = |problem: String| format!("{}: {problem}", run.path.display());
            let exact = path.places(&run.value);
            // The model has another name in this run: use the path in the limit.
            let meant = || match limit.figure.places(&run.value) {
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
        Ok(Self {
            estimate: Estimate::of(&places, measure),
            is_disturbed,
            is_cut: cut.is_some(),
            unsure: unsure.or(cut),
            by_person: people.and_then(|people| Vec::deserialize(people).ok()),
        })
    }

    /// Returns the estimate that decides.
    fn judged(&self, measure: FigureKind) -> Estimate {
        if self.is_disturbed {
            self.estimate.disturbed(measure)
        } else {
            self.estimate
        }
    }

    /// Compares two rates of hits on the same people; none if the values are not such rates.
    fn paired(
        &self,
        old: &Self,
        key: &str,
        seed: u64,
    ) -> Option<std::result::Result<BaselineChange, String>> {
        let (mine, its) = self.by_person.as_ref().zip(old.by_person.as_ref())?;
        if key != "rank1" || mine.is_empty() || its.is_empty() {
            return None;
        }
        let Some(PairedRates { ratio, difference }) = paired_rates([mine, its], seed) else {
            return Some(Err(
                "expected a baseline with the same people and probes, found others".into(),
            ));
        };
        // With one person there is no interval.
        let estimate = |(value, interval): (f64, Option<Interval>)| match interval {
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
        }))
    }
}

/// Returns a remark if a rate of hits does not cover all planned viewpoints.
fn cut_of(place: &ResultFigure<'_>) -> Option<String> {
    let (made, planned) = (
        place.beside("viewpoints")?,
        place.beside("viewpoints_planned")?,
    );
    (made < planned).then(|| format!("there was time for only {made} of {planned} viewpoints"))
}

#[cfg(test)]
mod tests;
