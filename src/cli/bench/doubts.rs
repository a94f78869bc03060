//! Warnings about the results of `edgegait bench`.

use super::BenchArgs;
use crate::bench::board::LOAD_WARNED_OF;
use crate::bench::{BenchResults, ModelResult};
use crate::cli::progress::time_of;

/// Adds warnings about conditions that are known before measuring.
pub(super) fn warn(results: &mut BenchResults) {
    let warnings = &mut results.header.warnings;
    if cfg!(debug_assertions) {
        warnings.push(
            "this is a debug build: its times are meaningless (use cargo run --release)".into(),
        );
    }
    if let Some(share) = results
        .load_of_others
        .filter(|share| *share > LOAD_WARNED_OF)
    {
        warnings.push(format!(
            "other processes kept {:.0} % of the processors busy before this was measured",
            100.0 * share
        ));
    }
}

/// Returns warnings about what was shortened, and how to measure it in full.
pub(super) fn cut_short(args: &BenchArgs, result: &ModelResult) -> Vec<String> {
    let Some(cut) = &result.cut else {
        return Vec::new();
    };
    // 1.5 times the estimate, in two digits.
    let needed = 1.5 * cut.full_seconds;
    let step = 10_f64.powf((needed.log10().floor() - 1.0).max(0.0));
    let mut warnings = vec![format!(
        "shortened to fit into {} s{}: {}; in full (--max-seconds {}) it takes about {}",
        args.most().map_or(0.0, |most| most.as_secs_f64()),
        if args.frames.is_empty() {
            ""
        } else {
            ", half of the time (the other half is for --frames)"
        },
        cut.what.join("; "),
        (needed / step).ceil() * step,
        time_of(cut.full_seconds)
    )];
    if args.mlperf {
        warnings.push(
            "these are not all of the five windows of 10 s that MLPerf Tiny asks for".to_owned(),
        );
    }
    warnings
}
