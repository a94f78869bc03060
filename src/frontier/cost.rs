//! Fixed costs, by which choices are ordered: they must not depend on the clock.

use super::configuration::DrawConfiguration;
use edgegait_core::raster::Rasterizer;

/// Time of a complete silhouette at 50x30 in thousandths of what `skia` takes: `edgegait
/// frontier` on one core of a shared AMD EPYC (AVX-512) virtual machine, 2026-11-21, rounded.
const fn silhouette_cost(rasterizer: Rasterizer) -> u32 {
    match rasterizer {
        Rasterizer::Skia => 1_000,
        Rasterizer::SkiaAa => 2_200,
        Rasterizer::Rows => 55,
        Rasterizer::Rows3x3 => 127,
        // Not measured: tried last.
        _ => 100_000,
    }
}

/// The rasteriser that costs least.
pub(super) fn fastest() -> Rasterizer {
    let all = Rasterizer::ALL.iter().copied();
    let least = all.min_by_key(|&rasterizer| silhouette_cost(rasterizer));
    least.unwrap_or(Rasterizer::Rows)
}

/// What a GEI costs, in the same unit. Jitter costs nothing.
pub(super) const fn gei_cost(drawing: DrawConfiguration) -> u32 {
    silhouette_cost(drawing.rasterizer) * drawing.frames_per_cycle
}
