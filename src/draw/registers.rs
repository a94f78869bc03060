//! The registers that drawing uses.

use crate::error::{Error, Result};
use edgegait_core::raster::Simd;

/// The variable of the environment that names them.
const VARIABLE: &str = "EDGEGAIT_SIMD";

/// Returns the widest registers of this processor, or those that the variable `EDGEGAIT_SIMD` of the
/// environment names. Images do not depend on them.
///
/// # Errors
/// If the processor has no registers of that name.
pub(crate) fn registers() -> Result<Simd> {
    let Some(stated) = std::env::var_os(VARIABLE) else {
        return Ok(Simd::widest());
    };
    let named = Simd::available().find(|simd| stated == simd.name());
    named.ok_or_else(|| {
        let known: Vec<&str> = Simd::available().map(Simd::name).collect();
        let (known, stated) = (known.join(", "), stated.to_string_lossy());
        Error::Usage(format!(
            "{VARIABLE}: expected registers of this processor ({known}), found {stated:?}"
        ))
    })
}
