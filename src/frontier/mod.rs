//! Speed against error: what each choice of rasteriser, frames, hull points and encoding
//! costs, and what it gets wrong.
//!
//! Errors are those against [`exact`] coverage of the finest motion. [`FrontierStudy`] measures a
//! list of [`configuration`]s and marks those that no other beats ([`pareto`]); [`choose`] picks the
//! cheapest that meets an error, and [`encoded()`] makes packs by it. Nothing but times differs between two runs.

pub(crate) mod choose;
#[cfg_attr(
    not(feature = "plots"),
    expect(dead_code, reason = "what only the frontier itself needs")
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

/// Viewpoints that errors are averaged over: 20, from the front to behind, level to above. Ours.
///
/// # Errors
/// Never.
pub(crate) fn spread_views() -> Result<Views> {
    let azimuths = [0.0, 45.0, 90.0, 135.0, 180.0];
    Views::grid("spread", azimuths, [0.0, 30.0, 60.0, 90.0])
}
