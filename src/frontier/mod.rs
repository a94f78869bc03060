//! Speed against error: the cost and the error of each choice of rasteriser, frames, hull points
//! and encoding.
//!
//! Errors are relative to [`exact`] coverage of the finest motion. [`FrontierStudy`] measures a
//! list of [`configuration`]s and marks those that no other beats ([`pareto`]). [`choose`] picks
//! the cheapest that meets an error, and [`encoded()`] makes packs with it. Only times differ
//! between two runs.

pub(crate) mod choose;
#[cfg_attr(
    not(feature = "plots"),
    expect(dead_code, reason = "parts are used only by the frontier itself")
)]
pub(crate) mod configuration;
mod encoded;
pub(crate) mod exact;
#[cfg(feature = "plots")]
mod measure;
#[cfg(feature = "plots")]
pub(crate) mod pareto;
#[cfg(feature = "plots")]
pub(crate) mod plot;
#[cfg(feature = "plots")]
mod recognition;
pub(crate) mod reference;
#[cfg(feature = "plots")]
mod timing;

pub(crate) use encoded::{EncodedPack, EncodingGoal, encoded};
#[cfg(feature = "plots")]
pub(crate) use measure::{FrontierPeople, FrontierPoint, FrontierStudy};

use crate::error::Result;
use crate::sweep::Views;

/// Returns the 20 viewpoints that errors are averaged over, from the front to behind and from level
/// to above. Our choice.
///
/// # Errors
/// Never.
pub(crate) fn spread_views() -> Result<Views> {
    let azimuths = [0.0, 45.0, 90.0, 135.0, 180.0];
    Views::grid("spread", azimuths, [0.0, 30.0, 60.0, 90.0])
}
