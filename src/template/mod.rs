//! Templates: what is made of the silhouettes of a gait cycle before a recognizer sees it.

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

/// Which template; "-style" says that the publication leaves details open, which we chose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Template {
    /// The silhouettes themselves, one after another.
    Silhouettes,
    /// Gait Energy Image: the mean (Han & Bhanu 2006).
    #[default]
    Gei,
    /// Motion Energy Image: where anything moved (Bobick & Davis 2001).
    Mei,
    /// Motion History Image: how recently it moved (Bobick & Davis 2001).
    Mhi,
    /// Motion Silhouette Image: how recently the figure was there (Lam & Lee 2006).
    Msi,
    /// Gait History Image-style: what stays, and when the rest moved last (Liu & Zheng 2007).
    Ghi,
    /// Gait Entropy Image: how uncertain each pixel is (Bashir, Xiang & Gong 2009).
    Geni,
    /// Amplitudes of the frequencies 0, 1 and 2 of a cycle, stacked (Makihara et al. 2006).
    Frequency,
    /// Key Fourier Descriptors-style of the outline, a vector (Yu et al. 2004).
    Kfd,
    /// Row-width-style: how wide each row of the GEnI is, a vector (after Nandy et al.).
    RowWidth,
}

/// What the numbers of a template are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TemplateShape {
    /// Images, one below the other.
    Image {
        /// How many.
        planes: usize,
        /// Rows of each.
        rows: usize,
        /// Columns of each.
        columns: usize,
    },
    /// Numbers in a row.
    Vector(usize),
}

impl TemplateShape {
    /// How many numbers.
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

/// Its sides: `3 x 50 x 30`, without the 3 if it is one image, or `60`.
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
    /// All of them.
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

    /// The name under which flags, contracts and results state it.
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

    /// What many of them are called.
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

    /// What it is of silhouettes of this size; of [`Self::Silhouettes`] one of them.
    #[must_use]
    pub const fn shape(self, size: Size) -> TemplateShape {
        self.shape_of(size.rows(), size.columns())
    }

    /// What it is of silhouettes of so many rows and columns.
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
