//! The state of the machine while a model was measured.

use super::board::MachineState;
use serde::{Deserialize, Serialize};

/// The state of the machine while a model was measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct MachineConditions {
    /// The state before the model was loaded.
    pub start: MachineState,
    /// The state after the last window.
    pub end: MachineState,
    /// The highest temperature between windows, degrees Celsius.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hottest_c: Option<f64>,
}

impl MachineConditions {
    /// Summarises states in time order, the first before and the last after the measurement.
    #[must_use]
    pub(super) fn from_states(states: &[MachineState]) -> Self {
        let temperatures = states.iter().filter_map(|state| state.temperature_c);
        Self {
            hottest_c: temperatures.reduce(f64::max),
            start: states.first().cloned().unwrap_or_default(),
            end: states.last().cloned().unwrap_or_default(),
        }
    }
}
