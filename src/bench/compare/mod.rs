//! Comparing the results of several boards: which results are comparable, and the ratios of their
//! times.

mod chart;

pub(crate) use chart::chart;

use super::results::{BenchResults, ModelResult};
use super::table::{ResultColumn, TableFormat, named, render, side_by_side};
use super::timing::Timing;
use crate::error::{Error, Result};
use crate::evaluate::median::median_interval;
use crate::evaluate::wilson::Interval;
use crate::files::ResultHeader;

/// The settings that affect rank-1. Other settings concern models, the board, or timing.
const OF_ACCURACY: [&str; 7] = [
    "views",
    "raster",
    "jitter",
    "lens",
    "frames_per_cycle",
    "subjects",
    "walks",
];

/// Results that are compared side by side.
pub(crate) struct Compared {
    /// The name and the results of each board; at least two.
    pub boards: Vec<(String, BenchResults)>,
}

/// A model in the results of a board.
struct Met<'a> {
    board: &'a str,
    /// The model's name, with its number of threads if it was measured with several.
    name: String,
    model: &'a ModelResult,
}

impl Met<'_> {
    /// Returns whether this is the same model with the same number of threads.
    fn is_like(&self, other: &Self) -> bool {
        (&self.model.name, self.model.threads) == (&other.model.name, other.model.threads)
    }
}

impl Compared {
    /// Checks that the results are comparable: the same protocol, viewpoints and people for rank-1,
    /// unless it is left out, and the same input for each model.
    ///
    /// # Errors
    /// If two results differ; the error names the first two and the difference.
    pub(crate) fn check(&self) -> Result<()> {
        let has_rank1 =
            |results: &BenchResults| results.models.iter().any(|model| model.accuracy.is_some());
        let mut with_rank1 = self.boards.iter().filter(|(_, results)| has_rank1(results));
        if let Some((first, results)) = with_rank1.next() {
            for (name, other) in with_rank1 {
                Self::check_rank1(first, results, name, other)?;
            }
        }
        self.check_models()
    }

    /// Checks that the rank-1 of two results is comparable.
    fn check_rank1(
        first: &str,
        results: &BenchResults,
        name: &str,
        other: &BenchResults,
    ) -> Result<()> {
        let refuse = |what: &str, [checked, baseline]: [String; 2]| {
            Err(Error::Failed(format!(
                "{first} and {name} cannot be compared: rank-1, {what}: {checked} and {baseline} (leave rank-1 out, or \
                 measure it with the same settings)"
            )))
        };
        for key in OF_ACCURACY {
            let of = |results: &BenchResults| match results.header.settings.get(key) {
                Some(value) => value.to_string(),
                None => "not stated".to_owned(),
            };
            let both = [of(results), of(other)];
            if both[0] != both[1] {
                return refuse(&format!("{key:?}"), both);
            }
        }
        if results.header.seed != other.header.seed {
            return refuse(
                "the seed",
                [results, other].map(|file| file.header.seed.to_string()),
            );
        }
        let packs = [results, other].map(|file| pack_of(&file.header));
        if packs[0] != packs[1] {
            return refuse("the people", packs);
        }
        Ok(())
    }

    /// Checks that models of one name have the same input, and the same protocol and viewpoints of
    /// rank-1.
    fn check_models(&self) -> Result<()> {
        let all: Vec<Met<'_>> = self.met().collect();
        for (at, met) in all.iter().enumerate() {
            let Some(first) = all[..at]
                .iter()
                .find(|file| file.model.name == met.model.name)
            else {
                continue;
            };
            let refuse = |what: &str, [checked, baseline]: [String; 2]| {
                Err(Error::Failed(format!(
                    "{} of {} and of {} cannot be compared: {what}: {checked} and {baseline}",
                    met.model.name, first.board, met.board
                )))
            };
            let both = [first.model, met.model];
            if both[0].input != both[1].input {
                return refuse("inputs", both.map(|model| format!("{:?}", model.input)));
            }
            let [Some(checked), Some(baseline)] = both.map(|model| model.accuracy.as_ref()) else {
                continue;
            };
            if checked.protocol != baseline.protocol {
                return refuse(
                    "protocols of rank-1",
                    [checked.protocol.clone(), baseline.protocol.clone()],
                );
            }
            if checked.viewpoints != baseline.viewpoints {
                let both = [checked, baseline].map(|file| file.viewpoints.to_string());
                return refuse("viewpoints of rank-1", both);
            }
        }
        Ok(())
    }

    /// Removes rank-1 from all results.
    pub(crate) fn without_accuracy(mut self) -> Self {
        for (_, results) in &mut self.boards {
            for model in &mut results.models {
                model.accuracy = None;
            }
        }
        self
    }

    fn met(&self) -> impl Iterator<Item = Met<'_>> {
        self.boards.iter().flat_map(|(board, results)| {
            let models = results.models.iter();
            models.map(move |model| Met {
                board,
                name: named(model, results),
                model,
            })
        })
    }

    /// Renders the tables, and each model's costs relative to the first board that has it.
    pub(crate) fn render(&self, format: TableFormat) -> String {
        let columns: Vec<ResultColumn<'_>> = self
            .boards
            .iter()
            .map(|(name, results)| ResultColumn { name, results })
            .collect();
        let mut text = render(&columns, format);
        let ratios = self.ratios();
        if !ratios.is_empty() {
            let columns = ratios.iter().map(|ratio| (ratio.heading.clone(), ratio));
            text += "\n";
            text += &side_by_side(columns, &RATIO_ROWS, format);
        }
        text
    }

    /// Returns the ratios of each model that an earlier board has.
    fn ratios(&self) -> Vec<Ratios> {
        let all: Vec<Met<'_>> = self.met().collect();
        let of = |(at, met): (usize, &Met<'_>)| {
            let mut before = all[..at].iter();
            let first = before.find(|file| file.is_like(met))?;
            Some(Ratios {
                heading: format!("{} {}", met.name, met.board),
                against: first.board.to_owned(),
                single: ratio(&met.model.single, &first.model.single),
                batch: met
                    .model
                    .offline
                    .as_ref()
                    .zip(first.model.offline.as_ref())
                    .filter(|(checked, baseline)| checked.batch == baseline.batch)
                    .and_then(|(checked, baseline)| ratio(&checked.timing, &baseline.timing)),
                load: exact(met.model.load_ms, first.model.load_ms),
                peak: met
                    .model
                    .peak_rss_over_baseline_bytes
                    .zip(first.model.peak_rss_over_baseline_bytes)
                    .and_then(|(checked, baseline)| exact(checked as f64, baseline as f64)),
            })
        };
        all.iter().enumerate().filter_map(of).collect()
    }
}

/// A model's costs relative to the first board that has it.
struct Ratios {
    heading: String,
    against: String,
    single: Option<String>,
    batch: Option<String>,
    load: Option<String>,
    peak: Option<String>,
}

const RATIO_ROWS: [crate::bench::cells::ResultRow<Ratios>; 5] = [
    ("relative to", |of| Some(of.against.clone())),
    ("one at a time: p50", |of| of.single.clone()),
    ("a batch: p50", |of| of.batch.clone()),
    ("load", |of| of.load.clone()),
    ("peak memory of runtime and model", |of| of.peak.clone()),
];

/// Returns the range of the median time that the windows allow; none without windows.
fn p50_range(timing: &Timing) -> Option<(f64, f64)> {
    let (median, Interval { low, high }) = median_interval(&timing.window_mean_us)?;
    let scale = timing.times.p50_us / median;
    (median > 0.0).then_some((low * scale, high * scale))
}

/// Returns the ratio of two p50, and its range.
fn ratio(checked: &Timing, baseline: &Timing) -> Option<String> {
    let (checked_range, baseline_range) = (p50_range(checked)?, p50_range(baseline)?);
    let value = checked.times.p50_us / baseline.times.p50_us;
    let (low, high) = (
        checked_range.0 / baseline_range.1,
        checked_range.1 / baseline_range.0,
    );
    value
        .is_finite()
        .then(|| format!("{value:.2} ({low:.2} - {high:.2})"))
}

fn exact(checked: f64, baseline: f64) -> Option<String> {
    let ratio = checked / baseline;
    ratio.is_finite().then(|| format!("{ratio:.2}"))
}

/// Returns the checksums of the data that a header names besides models, or else its `pack`
/// setting.
fn pack_of(header: &ResultHeader) -> String {
    let data = header.data();
    if data.is_empty() {
        let pack = header.settings.get("pack").and_then(|pack| pack.as_str());
        return pack.unwrap_or("not stated").to_owned();
    }
    let sums = data.iter().map(|file| format!("{:.8}", file.sha256));
    sums.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests;
