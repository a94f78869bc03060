//! The cheapest encoding and drawing within an error.
//!
//! Errors are relative to [`exact`] coverage of the finest motion ([`reference`]). [`choose`] picks
//! the cheapest [`configuration`] that meets an error, and [`encoded()`] makes packs with it.

pub(crate) mod choose;
#[cfg_attr(
    not(feature = "plots"),
    expect(dead_code, reason = "parts are used only by the frontier itself")
)]
pub(crate) mod configuration;
mod encoded;
pub(crate) mod exact;
pub(crate) mod reference;

pub(crate) use encoded::{EncodedPack, EncodingGoal, encoded};

use crate::draw::sweep::Views;
use crate::error::Result;

/// Returns the 20 viewpoints that errors are averaged over, from the front to behind and from level
/// to above. Our choice.
///
/// # Errors
/// Never.
pub(crate) fn spread_views() -> Result<Views> {
    let azimuths = [0.0, 45.0, 90.0, 135.0, 180.0];
    Views::grid("spread", azimuths, [0.0, 30.0, 60.0, 90.0])
}
