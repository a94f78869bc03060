//! Cells of the tables of results: numbers with their units.

use super::board::{Clock, MachineState};
use super::conditions::MachineConditions;
use crate::report::{grouped, microseconds};

/// A row of a table: its label, and the function that gives a column's cell.
pub(super) type ResultRow<T> = (&'static str, fn(&T) -> Option<String>);

/// Returns the clocks at start and end.
pub(super) fn of_clocks(conditions: &MachineConditions) -> Option<String> {
    let both = [&conditions.start, &conditions.end].into_iter();
    some_of(both.filter_map(clock))
}

/// Returns the temperatures at start and end, with the highest between them.
pub(super) fn degrees(conditions: &MachineConditions) -> Option<String> {
    let (start, end) = (&conditions.start, &conditions.end);
    let all = [start.temperature_c, conditions.hottest_c, end.temperature_c];
    let all = all.into_iter().flatten();
    some_of(all.map(|celsius| format!("{celsius:.1}")))
}

pub(super) fn us(us: f64) -> Option<String> {
    Some(microseconds(us, ","))
}

pub(super) fn per_second(rate: f64) -> String {
    if rate < 100.0 {
        return format!("{rate:.2}");
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive, and far below 2^64"
    )]
    grouped(rate.round() as u64, ",")
}

pub(super) fn megabytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 * 1e-6)
}

/// Returns governors and frequencies, without repeated neighbours.
pub(super) fn clock(state: &MachineState) -> Option<String> {
    let of = |clock: &Clock| {
        let mhz = clock.current_khz.map(|khz| format!("{} MHz", khz / 1000));
        let parts = [clock.governor.clone(), mhz].into_iter().flatten();
        parts.collect::<Vec<_>>().join(" ")
    };
    let mut clocks: Vec<String> = state.clocks.iter().map(of).collect();
    clocks.dedup();
    (!clocks.is_empty()).then(|| clocks.join(" + "))
}

/// Joins the parts with commas; none if there are none.
pub(super) fn some_of(parts: impl Iterator<Item = String>) -> Option<String> {
    let parts: Vec<String> = parts.collect();
    (!parts.is_empty()).then(|| parts.join(", "))
}
