//! Limits on values of results, which decide whether a build passes.
//!
//! A file of limits ([`limits`]) names values by their paths in the JSON ([`figure`]). Each value
//! has an interval ([`estimate`]), from several runs or from fields next to it. [`judge`] decides
//! whether a limit holds, is missed, or is undecided ("cannot tell"), so that noise neither fails a
//! build nor passes one. Results that are not comparable are rejected ([`results`]), as are those
//! of [`criterion`] that are too old ([`freshness`]).

mod bencher;
mod criterion;
mod estimate;
mod figure;
mod freshness;
mod judge;
mod junit;
mod known_figure;
mod limits;
mod markdown;
mod need;
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
use crate::files::ResultHeader;
use estimate::FigureKind;
use figure::ResultFigure;
use judge::{absolute, relative};
use known_figure::KnownFigure;
use limits::{Bound, GateLimit};
use std::path::Path;
use std::time::SystemTime;

/// The results to judge, and those of a baseline.
#[derive(Debug)]
pub(crate) struct JudgedRuns<'a> {
    /// The runs to judge, at least one.
    pub runs: &'a [ResultFile],
    /// The runs of the baseline; empty if there is none.
    pub baselines: &'a [ResultFile],
    /// Whether limits relative to a baseline are left out, because there is none.
    pub without_baseline: bool,
    /// Whether other work ran during the measurement.
    pub is_busy: bool,
    /// The current time.
    pub now: SystemTime,
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
    let is_one_board = all().all(|result| all().all(|other| result.is_same_board(other)));
    let mut header = header;
    let mut lines = Vec::new();
    let mut left_out = 0;
    for limit in &limits.limits {
        let mut limit = limit.clone();
        if let Some(need) = limit.needs.filter(|need| !need.is_met(judged.is_busy)) {
            let name = limit.name.unwrap_or_else(|| format!("line {}", limit.line));
            let warning = format!("{name}: skipped: this machine has no {need}");
            header.warnings.push(warning);
            continue;
        }
        // What has a bound of its own is judged by it where there is no baseline.
        let has_own = limit.bounds.iter().any(|bound| !bound.is_relative());
        if judged.without_baseline || (judged.baselines.is_empty() && has_own) {
            let all = limit.bounds.len();
            limit.bounds.retain(|bound| !bound.is_relative());
            left_out += all - limit.bounds.len();
        }
        let refuse = |problem: String| Error::at(path, Where::Line(limit.line), problem);
        let of_results = |problem: String| refuse(format!("{}: {problem}", first.path.display()));
        let places = limit.figure.places(&first.value).map_err(of_results)?;
        if let Some(freshness) = &limits.criterion {
            let folder = path.parent().unwrap_or(path);
            for run in judged.runs {
                let used = limit.places(&run.value).map_err(of_results)?;
                freshness
                    .require(folder, judged.now, &used)
                    .map_err(of_results)?;
            }
        }
        for place in places {
            lines.extend(lines_of(&limit, &place, judged, is_one_board).map_err(refuse)?);
        }
    }
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
    let measure = FigureKind::from_key(&place.key);
    let new = KnownFigure::of_limit(place, limit, judged.runs)?;
    let is_relative = limit.bounds.iter().any(|bound| bound.is_relative());
    let old = match judged.baselines {
        [] if is_relative => {
            return Err(format!(
                "{}: expected a baseline for this limit, found none",
                place.path
            ));
        }
        [] => None,
        baselines => match KnownFigure::of_limit(place, limit, baselines) {
            Err(problem) if is_relative => return Err(problem),
            known => known.ok(),
        },
    };
    let change = match &old {
        Some(old) if is_relative => {
            Some(new.change_from(old, &place.key, judged.runs[0].header.seed)?)
        }
        _ => None,
    };
    let per = limit.per_text();
    let path = match &per {
        Some(per) => format!("{} per {per}", place.path),
        None => place.path.clone(),
    };
    let mut lines = Vec::new();
    for &bound in &limit.bounds {
        if bound == Bound::NotWorse && measure.better().is_none() {
            return Err(format!(
                "{}: not_worse: expected a value that has a better direction, found {:?} (use ratio_at_most or another bound)",
                place.path, place.key
            ));
        }
        let change = change.as_ref().filter(|_| bound.is_relative());
        let (outcome, unsure) = match change {
            None => {
                let outcome = absolute(new.judged, bound, measure, limit.judge);
                (outcome, new.unsure.clone())
            }
            Some(_) if measure.is_timed() && !is_one_board => {
                let why = "the results are not all from one machine and number of threads";
                (GateOutcome::CannotTell, Some(why.to_owned()))
            }
            Some(change) if change.is_cut => (GateOutcome::CannotTell, change.unsure.clone()),
            Some(change) => {
                let is_ratio = matches!(bound, Bound::RatioAtMost(_) | Bound::RatioAtLeast(_));
                let below_0 = "a ratio of values below 0 is meaningless (use difference_at_most or another bound)";
                let unsure = match is_ratio && change.between.ratio.value.is_nan() {
                    true => Some(below_0.to_owned()),
                    false => change.unsure.clone(),
                };
                (
                    relative(change.between, bound, measure, limit.judge),
                    unsure,
                )
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
            name: limit.name.clone().unwrap_or_else(|| path.clone()),
            figure: place.path.clone(),
            per: per.clone(),
            reason: limit.reason.clone(),
            limit: bound.to_string(),
            outcome,
            why,
            found: new.estimate,
            baseline: old.as_ref().map(|old| old.estimate),
            ratio: change.map(|change| change.between.ratio),
            difference: change.map(|change| change.between.difference),
        });
    }
    Ok(lines)
}

#[cfg(test)]
mod tests;
