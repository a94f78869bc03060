//! Limits on figures of results: whether a build passes.
//!
//! A file of limits ([`limits`]) names figures by where they stand in the JSON ([`figure`]); what is known of
//! each is a value with an interval ([`estimate`]), from several runs or from what stands beside the
//! figure. [`judge`] says whether it holds, is missed, or cannot be told: "cannot tell" is an outcome of its
//! own, so that noise neither fails a build nor passes one. Results that say nothing about each other are
//! not compared ([`results`]).

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

use crate::dataset::Header;
use crate::error::{Error, Place as Where, Result};
use crate::evaluate::paired::{PersonResult, Rates, paired_rates};
use crate::evaluate::wilson::Interval;
use estimate::{Estimate, Measure, disturbance};
use figure::Place;
use judge::{Between, absolute, relative};
use limits::{Bound, GateLimit, Judge};
use serde::Deserialize as _;
use std::path::Path;

/// What is judged.
#[derive(Debug)]
pub(crate) struct Judged<'a> {
    /// The runs of what is judged, at least one.
    pub runs: &'a [ResultFile],
    /// The runs of what it is set against; none if there is nothing.
    pub baselines: &'a [ResultFile],
    /// Whether limits beside a baseline are left out, as there is none.
    pub without_baseline: bool,
}

/// Judges all limits of a file, whose path is for messages.
///
/// # Errors
/// If results cannot be compared, or a limit is on a figure that they lack: never a pass.
pub(crate) fn gate(
    (path, limits): (&Path, &GateLimits),
    judged: &Judged<'_>,
    header: Header,
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
            lines.extend(lines_of(&limit, &place, judged).map_err(refuse)?);
        }
    }
    let mut header = header;
    if left_out > 0 {
        header.warnings.push(format!(
            "{left_out} limits beside a baseline were left out, as there is none"
        ));
    }
    let versions = judged.runs.iter().chain(judged.baselines);
    let mut versions: Vec<&str> = versions.map(|file| file.header.version.as_str()).collect();
    versions.sort_unstable();
    versions.dedup();
    if let [one, other, ..] = versions[..] {
        header.warnings.push(format!(
            "results of EdgeGait {one} and {other} are compared: what is drawn may differ"
        ));
    }
    Ok(GateReport::new(header, lines))
}

/// What became of each bound of a limit on one figure.
fn lines_of(
    limit: &GateLimit,
    place: &Place<'_>,
    judged: &Judged<'_>,
) -> std::result::Result<Vec<GateLine>, String> {
    let measure = Measure::of(&place.key);
    let new = Known::of(&place.path, judged.runs, measure)?;
    let is_relative = limit.bounds.iter().any(|bound| bound.is_relative());
    let old = match judged.baselines {
        [] if is_relative => {
            return Err(format!(
                "{}: expected a baseline for this limit, found none",
                place.path
            ));
        }
        [] => None,
        baselines => match Known::of(&place.path, baselines, measure) {
            Ok(known) => Some(known),
            Err(problem) if is_relative => return Err(problem),
            Err(_) => None,
        },
    };
    let mut lines = Vec::new();
    for &bound in &limit.bounds {
        let how = (measure, limit.judge);
        if bound == Bound::NotWorse && measure.better().is_none() {
            return Err(format!(
                "{}: not_worse: expected a figure that is better one way, found {:?} (use ratio_at_most or another)",
                place.path, place.key
            ));
        }
        let (outcome, between, unsure) = match old.as_ref().filter(|_| bound.is_relative()) {
            None => {
                let found = new.judged(measure);
                (absolute(found, bound, how), None, new.disturbed.clone())
            }
            Some(old) => {
                let is_paired = limit.judge != Some(Judge::Value);
                let between = match is_paired
                    .then(|| new.paired(old, &place.key, judged.runs[0].header.seed))
                {
                    Some(Some(paired)) => paired?,
                    _ => Between::apart(new.judged(measure), old.judged(measure)),
                };
                let mut outcome = relative(between, bound, how);
                let mut unsure = new.disturbed.clone();
                let before = old
                    .disturbed
                    .as_ref()
                    .map(|why| format!("of the baseline: {why}"));
                unsure = unsure.or(before);
                let is_other_board =
                    measure.is_timed() && !judged.runs[0].is_same_board(&judged.baselines[0]);
                if is_other_board {
                    outcome = GateOutcome::CannotTell;
                    unsure = Some("the baseline was measured on another machine".into());
                }
                (outcome, Some(between), unsure)
            }
        };
        let why = match outcome {
            GateOutcome::CannotTell => Some(unsure.unwrap_or_else(|| {
                "the limit is within the interval (more runs make it narrower)".into()
            })),
            _ => None,
        };
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

/// What is known of one figure.
struct Known {
    estimate: Estimate,
    /// Why a time is unsure.
    disturbed: Option<String>,
    /// Hits by person, if it is a rate of them.
    by_person: Option<Vec<PersonResult>>,
}

impl Known {
    /// From all runs; each must have the figure.
    fn of(path: &str, runs: &[ResultFile], measure: Measure) -> std::result::Result<Self, String> {
        let mut places = Vec::new();
        for run in runs {
            let said = |problem: String| format!("{}: {problem}", run.path.display());
            let found = figure::FigurePath::parse(path)?
                .places(&run.value)
                .map_err(said)?;
            let bad = found.iter().find(|place| !place.value.is_finite());
            if let Some(place) = bad {
                return Err(said(format!(
                    "{path}: expected a finite number, found {}",
                    place.value
                )));
            }
            places.extend(found);
        }
        let disturbed = measure
            .is_timed()
            .then(|| places.iter().find_map(disturbance));
        let people = places
            .first()
            .and_then(|place| place.object()?.get("by_person"));
        Ok(Self {
            estimate: Estimate::of(&places, measure),
            disturbed: disturbed.flatten(),
            by_person: people.and_then(|people| Vec::deserialize(people).ok()),
        })
    }

    /// The interval that it is judged by.
    fn judged(&self, measure: Measure) -> Estimate {
        match self.disturbed {
            Some(_) => self.estimate.disturbed(measure),
            None => self.estimate,
        }
    }

    /// What is between two rates of hits of the same people; none if they are no such rates.
    fn paired(
        &self,
        old: &Self,
        key: &str,
        seed: u64,
    ) -> Option<std::result::Result<Between, String>> {
        let (mine, its) = self.by_person.as_ref().zip(old.by_person.as_ref())?;
        if key != "rank1" {
            return None;
        }
        let Some(Rates { ratio, difference }) = paired_rates([mine, its], seed) else {
            return Some(Err(
                "the baseline looked for other people, or for them in other probes".into(),
            ));
        };
        let estimate = |(value, interval): (f64, Option<Interval>)| match interval {
            Some(Interval { low, high }) => Estimate { value, low, high },
            None => Estimate::exact(value),
        };
        Some(Ok(Between {
            ratio: estimate(ratio),
            difference: estimate(difference),
        }))
    }
}

#[cfg(test)]
mod tests;
