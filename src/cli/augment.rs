//! Flags that add augmented variants of each image.

use crate::draw::template::augment::{Augmentation, Crops};
use crate::error::{Error, Result};

/// The flags that choose the variants.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct AugmentArgs {
    /// Add variants of each image: mirrored; with its lowest rows cut off and the rest enlarged
    /// (Han & Bhanu's synthetic templates); or both. Each has its own condition, as in
    /// normal+flip+crop2
    #[arg(long, value_name = "NAME[,NAME..]", value_delimiter = ',')]
    augment: Vec<Way>,
    /// Number of crops of each image
    /// [default: 4]
    #[arg(long, value_name = "K")]
    crop_steps: Option<u16>,
    /// Rows that the first crop cuts off the bottom, and each further crop cuts off in addition
    /// [default: 1]
    #[arg(long, value_name = "N")]
    crop_rows: Option<u16>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Way {
    Flip,
    Crop,
}

impl AugmentArgs {
    /// Returns whether any variant is requested.
    pub(super) const fn is_given(&self) -> bool {
        !self.augment.is_empty()
    }

    /// Returns how crops are made, if any are.
    pub(super) fn crops(&self) -> Crops {
        let default = Crops::default();
        Crops {
            steps: self.crop_steps.map_or(default.steps, usize::from),
            rows: self.crop_rows.map_or(default.rows, usize::from),
        }
    }

    /// Returns the augmentation for a method that makes crops by itself.
    ///
    /// # Errors
    /// If crops are requested as well.
    #[cfg(feature = "train")]
    pub(super) fn without_crops(&self) -> Result<Augmentation> {
        if self.augment.contains(&Way::Crop) {
            return Err(Error::Usage(
                "--augment crop: --method real-synthetic crops by itself".into(),
            ));
        }
        Ok(Augmentation {
            flip: self.augment.contains(&Way::Flip),
            crops: None,
        })
    }

    /// Returns the requested augmentation.
    ///
    /// # Errors
    /// If `--crop-steps` or `--crop-rows` is given without crops.
    pub(super) fn augmentation(&self) -> Result<Augmentation> {
        let is_cropped = self.augment.contains(&Way::Crop);
        if !is_cropped && (self.crop_steps.is_some() || self.crop_rows.is_some()) {
            return Err(Error::Usage(
                "--crop-steps and --crop-rows need --augment crop, which was not given".into(),
            ));
        }
        Ok(Augmentation {
            flip: self.augment.contains(&Way::Flip),
            crops: is_cropped.then(|| self.crops()),
        })
    }
}
