//! Rank-1 pooled over bands of azimuth and elevation: 703 viewpoints in 25 cells.

use super::rank1::Tally;
use super::results::ViewpointResult;

/// Names of the azimuth bands, degrees, from the front to the back.
pub(crate) const AZIMUTHS: [&str; 5] = ["0-40", "45-85", "90", "95-135", "140-180"];
/// Names of the elevation bands, degrees, from level to above.
pub(crate) const ELEVATIONS: [&str; 5] = ["0", "5-25", "30-50", "55-75", "80-90"];

// Midway between two viewpoints of the 5-degree grid, so that every viewpoint has a band.
const AZIMUTH_ENDS: [f64; 6] = [-2.5, 42.5, 87.5, 92.5, 137.5, 182.5];
const ELEVATION_ENDS: [f64; 6] = [-2.5, 2.5, 27.5, 52.5, 77.5, 92.5];

/// Hits and probes by band of azimuth and elevation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Bands {
    /// Tallies `[elevation][azimuth]`, in the order of [`ELEVATIONS`] and [`AZIMUTHS`].
    pub cells: [[Tally; 5]; 5],
    /// Viewpoints in no band: below the horizon or on the walker's right.
    pub outside: usize,
    /// Viewpoints in a band whose azimuth or elevation is not a multiple of 5 degrees. They count
    /// as the nearest multiple; of two equally near ones, the higher.
    pub between: usize,
}

impl Bands {
    /// Sums the results of viewpoints by band.
    #[must_use]
    pub(crate) fn sum(viewpoints: &[ViewpointResult]) -> Self {
        let mut bands = Self::default();
        for viewpoint in viewpoints {
            let elevation = band(viewpoint.elevation_deg, &ELEVATION_ENDS);
            let azimuth = band(viewpoint.azimuth_deg, &AZIMUTH_ENDS);
            match (elevation, azimuth) {
                (Some(e), Some(a)) => {
                    bands.cells[e][a] += viewpoint.tally();
                    let angles = [viewpoint.azimuth_deg, viewpoint.elevation_deg];
                    bands.between += usize::from(angles.iter().any(|angle| angle % 5.0 != 0.0));
                }
                _ => bands.outside += 1,
            }
        }
        bands
    }

    /// Returns the tally of an elevation band over all azimuths.
    #[must_use]
    pub(crate) fn elevation(&self, band: usize) -> Tally {
        self.cells[band].iter().copied().sum()
    }

    /// Returns the tally of an azimuth band over all elevations.
    #[must_use]
    pub(crate) fn azimuth(&self, band: usize) -> Tally {
        self.cells.iter().map(|row| row[band]).sum()
    }

    /// Returns the tally of all bands.
    #[must_use]
    pub(crate) fn all(&self) -> Tally {
        self.cells.iter().flatten().copied().sum()
    }
}

fn band(angle_deg: f64, ends: &[f64; 6]) -> Option<usize> {
    ends.windows(2)
        .position(|end| (end[0]..end[1]).contains(&angle_deg))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::results::tests::result_of;

    #[test]
    fn the_grid_falls_into_the_bands_that_their_names_say() {
        let mut grid = Vec::new();
        for azimuth in 0..37 {
            for elevation in 0..19 {
                grid.push((f64::from(azimuth) * 5.0, f64::from(elevation) * 5.0, 0, 1));
            }
        }
        let bands = Bands::sum(&result_of(&grid).by_viewpoint);
        assert_eq!(bands.outside, 0);
        assert_eq!(bands.all().probes, 703);
        // 0-40 is 9 azimuths, 45-85 is 9, 90 is 1; 0 is 1 elevation, then 5, 5, 5, 3.
        assert_eq!(
            [0, 1, 2, 3, 4].map(|a| bands.azimuth(a).probes),
            [171, 171, 19, 171, 171]
        );
        assert_eq!(
            [0, 1, 2, 3, 4].map(|e| bands.elevation(e).probes),
            [37, 185, 185, 185, 111]
        );
        assert_eq!(bands.cells[1][2].probes, 5);
    }

    #[test]
    fn what_is_between_two_names_is_counted_at_the_nearest_and_told() {
        let result = result_of(&[
            (42.0, 0.0, 1, 1),
            (43.0, 0.0, 1, 1),
            (88.0, 2.0, 1, 1),
            (90.0, 90.0, 1, 1),
        ]);
        let bands = Bands::sum(&result.by_viewpoint);
        // 42 is nearest to 40, 43 to 45, 88 to 90, and 2 to 0.
        let level = bands.cells[0].map(|tally| tally.probes);
        assert_eq!(level, [1, 1, 1, 0, 0]);
        assert_eq!(bands.cells[4][2].probes, 1);
        assert_eq!((bands.between, bands.outside), (3, 0));
    }
}
