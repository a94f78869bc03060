//! Templates: images that stand for a gait cycle, built frame by frame.
//!
//! Builders receive frames, and give bytes row by row from the top:
//!
//! | builder | builds | of | RAM |
//! |---|---|---|--:|
//! | [`TemplateBuilder`] | any [`TemplateKind`] | any frames | 82 kB |
//! | [`GeiBuilder`], its alias | the GEI | any frames | 16 kB |
//! | [`GeiInPlace`] | the GEI | 255 silhouettes | a byte a pixel |
//! | [`GeiTally`] | GEIs at many elevations | `raster::columns` | 259 kB |

mod builder;
mod elevation_tally;
mod entropy;
mod error;
mod frame_sums;
mod frequency;
mod gei;
mod history;
mod in_place;
mod memory;

pub use builder::{GeiBuilder, TemplateBuilder};
pub use elevation_tally::GeiTally;
pub use error::FrameError;
pub use gei::Gei;
pub use in_place::{BufferTooSmall, GeiInPlace};

use crate::budget::FREQUENCIES;
use crate::silhouette::Size;

/// The kind of template. "-style" marks a template whose publication leaves details open, which we
/// chose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum TemplateKind {
    /// Gait Energy Image, the mean: Han & Bhanu 2006, "Individual recognition using gait energy
    /// image", equation 1.
    Gei,
    /// Motion Energy Image, where anything moved: Bobick & Davis 2001, "The
    /// recognition of human movement using temporal templates", with the difference of consecutive
    /// silhouettes as motion, from the first frame to the last, without a step back to the first.
    Mei,
    /// Motion History Image, how recently anything moved: Bobick & Davis 2001,
    /// with motion as in the Motion Energy Image, divided by tau, the number of steps.
    Mhi,
    /// Motion Silhouette Image, how recently the figure covered a pixel: Lam & Lee 2006, "Human
    /// identification by using the motion and static characteristic of gait".
    Msi,
    /// Gait History Image-style: white where the figure always is, grey where it changes, brighter
    /// for later changes. After Liu & Zheng 2007, "Gait history image: a novel temporal template
    /// for gait recognition"; a last change in step t of P gives t/P (1 - 1/P), which is ours.
    Ghi,
    /// Gait Entropy Image, Shannon's entropy of each pixel, scaled from its least to its largest
    /// value: Bashir, Xiang & Gong 2009, "Gait recognition using gait entropy image".
    Geni,
    /// Amplitudes of the frequencies 0, 1 and 2 of a cycle, one below the other, times 255:
    /// Makihara et al. 2006, "Gait recognition using a view transformation model in the frequency
    /// domain".
    Frequency,
}

impl TemplateKind {
    /// All kinds.
    pub const ALL: [Self; 7] = [
        Self::Gei,
        Self::Mei,
        Self::Mhi,
        Self::Msi,
        Self::Ghi,
        Self::Geni,
        Self::Frequency,
    ];

    /// Returns the name that results use for it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gei => "gei",
            Self::Mei => "mei",
            Self::Mhi => "mhi",
            Self::Msi => "msi",
            Self::Ghi => "ghi",
            Self::Geni => "geni",
            Self::Frequency => "frequency",
        }
    }

    /// Returns the number of images of the silhouettes' size, one below the other.
    #[must_use]
    pub const fn planes(self) -> usize {
        match self {
            Self::Frequency => FREQUENCIES,
            _ => 1,
        }
    }

    /// Returns its size, bytes.
    #[must_use]
    pub const fn bytes(self, size: Size) -> usize {
        self.planes() * size.pixels()
    }
}
