//! The chart of latency against rank-1 (SVG): a mark for each model and board.

use super::{Compared, Met, p50_range};
use crate::error::{Error, Result};
use crate::report::{SpeedError, SpeedErrorPlot};

/// Draws the chart of all models whose rank-1 was measured.
///
/// # Errors
/// If fewer than two models have a rank-1.
pub(crate) fn chart(compared: &Compared) -> Result<String> {
    let boards = || compared.boards.iter().map(|(name, _)| name.as_str());
    let of = |Met { board, name, model }: Met<'_>| {
        let accuracy = model.accuracy.as_ref()?;
        Some(SpeedError {
            name: format!("{name} {board}"),
            board: boards().position(|other| other == board)?,
            us: model.single.times.p50_us,
            us_range: p50_range(&model.single),
            rank1: accuracy.rank1,
            rank1_range: accuracy.intervals.shown(),
            is_baseline: false,
        })
    };
    let axis = "one inference, µs (median, range)";
    let plot = SpeedErrorPlot::of(compared.met().filter_map(of).collect(), axis);
    plot.map(|plot| plot.file()).ok_or_else(|| {
        Error::Failed(
            "expected two results with rank-1 to draw latency against it, found fewer (measure \
             rank-1 as well)"
                .into(),
        )
    })
}
