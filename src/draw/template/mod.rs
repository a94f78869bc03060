//! Templates: images and vectors that represent the silhouettes of a gait cycle.

pub mod augment;
mod builder;
pub(crate) mod kfd;
mod outline;
pub(crate) mod row_width;

pub use builder::Builder;
pub use outline::outline;

use edgegait_core::silhouette::Size;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A kind of template. "-style" means that we chose details that the publication leaves open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Template {
    /// The silhouettes themselves, one after another.
    Silhouettes,
    /// Gait Energy Image: the mean (Han & Bhanu 2006).
    #[default]
    Gei,
    /// Motion Energy Image: the pixels that changed (Bobick & Davis 2001).
    Mei,
    /// Motion History Image: how recently each pixel changed (Bobick & Davis 2001).
    Mhi,
    /// Motion Silhouette Image: how recently each pixel was on (Lam & Lee 2006).
    Msi,
    /// Gait History Image-style: the constant part, and when the rest moved last (Liu & Zheng
    /// 2007).
    Ghi,
    /// Gait Entropy Image: the entropy of each pixel (Bashir, Xiang & Gong 2009).
    Geni,
    /// Amplitudes of the frequencies 0, 1 and 2 of a cycle, stacked (Makihara et al. 2006).
    Frequency,
    /// Key Fourier Descriptors-style of the outline, a vector (Yu et al. 2004).
    Kfd,
    /// Row-width-style: the width of each row of the GEnI, a vector (after Nandy et al.).
    RowWidth,
}

/// The shape of a template's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TemplateShape {
    /// One or more images, one below the other.
    Image {
        /// The number of images.
        planes: usize,
        /// The number of rows of each image.
        rows: usize,
        /// The number of columns of each image.
        columns: usize,
    },
    /// A vector of this many numbers.
    Vector(usize),
}

impl TemplateShape {
    /// Returns the total of numbers.
    #[must_use]
    pub const fn numbers(self) -> usize {
        match self {
            Self::Image {
                planes,
                rows,
                columns,
            } => planes * rows * columns,
            Self::Vector(numbers) => numbers,
        }
    }
}

/// Writes the dimensions: `3 x 50 x 30`, `50 x 30` for a single image, or `60` for a vector.
impl fmt::Display for TemplateShape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Image {
                planes: 1,
                rows,
                columns,
            } => write!(f, "{rows} x {columns}"),
            Self::Image {
                planes,
                rows,
                columns,
            } => write!(f, "{planes} x {rows} x {columns}"),
            Self::Vector(numbers) => write!(f, "{numbers}"),
        }
    }
}

impl Template {
    /// All kinds of templates.
    pub const ALL: [Self; 10] = [
        Self::Silhouettes,
        Self::Gei,
        Self::Mei,
        Self::Mhi,
        Self::Msi,
        Self::Ghi,
        Self::Geni,
        Self::Frequency,
        Self::Kfd,
        Self::RowWidth,
    ];

    /// Returns the name in flags, contracts and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Silhouettes => "silhouettes",
            Self::Gei => "gei",
            Self::Mei => "mei",
            Self::Mhi => "mhi",
            Self::Msi => "msi",
            Self::Ghi => "ghi",
            Self::Geni => "geni",
            Self::Frequency => "frequency",
            Self::Kfd => "kfd",
            Self::RowWidth => "row-width",
        }
    }

    /// Returns the plural of the name, for messages.
    #[must_use]
    pub const fn plural(self) -> &'static str {
        match self {
            Self::Silhouettes => "silhouettes",
            Self::Gei => "GEIs",
            Self::Mei => "MEIs",
            Self::Mhi => "MHIs",
            Self::Msi => "MSIs",
            Self::Ghi => "GHI-style images",
            Self::Geni => "GEnIs",
            Self::Frequency => "frequency images",
            Self::Kfd => "KFD-style vectors",
            Self::RowWidth => "row-width-style vectors",
        }
    }

    /// Returns the shape for silhouettes of this size; for [`Self::Silhouettes`], of one frame.
    #[must_use]
    pub const fn shape(self, size: Size) -> TemplateShape {
        self.shape_of(size.rows(), size.columns())
    }

    /// Returns the shape for silhouettes of these rows and columns.
    #[must_use]
    pub const fn shape_of(self, rows: usize, columns: usize) -> TemplateShape {
        let planes = match self {
            Self::Kfd => return TemplateShape::Vector(kfd::NUMBERS),
            Self::RowWidth => return TemplateShape::Vector(rows),
            Self::Frequency => 3,
            _ => 1,
        };
        TemplateShape::Image {
            planes,
            rows,
            columns,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_state_the_same_names() {
        for template in Template::ALL {
            let stated = serde_json::to_value(template).expect("a name");
            assert_eq!(stated, template.name());
        }
    }
}
