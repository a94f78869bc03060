//! Flags that make more images of each.

use crate::error::{Error, Result};
use crate::template::augment::{Augmentation, Crops};

/// What is made of each image besides itself.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct AugmentArgs {
    /// Add variants of each image: mirrored; without its lowest rows, enlarged (Han & Bhanu's
    /// synthetic templates); both together. Each has its own condition, as in normal+flip+crop2
    #[arg(long, value_name = "NAME[,NAME..]", value_delimiter = ',')]
    augment: Vec<Way>,
    /// How many crops are made of each image
    /// [default: 4]
    #[arg(long, value_name = "K")]
    crop_steps: Option<u16>,
    /// Rows that each crop cuts off the bottom, and the next one as many more
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
    /// Whether any is made.
    pub(super) const fn is_given(&self) -> bool {
        !self.augment.is_empty()
    }

    /// How crops are made, if any are.
    pub(super) fn crops(&self) -> Crops {
        let default = Crops::default();
        Crops {
            steps: self.crop_steps.map_or(default.steps, usize::from),
            rows: self.crop_rows.map_or(default.rows, usize::from),
        }
    }

    /// What is asked for where a method makes crops by itself.
    ///
    /// # Errors
    /// For crops besides.
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

    /// What is asked for.
    ///
    /// # Errors
    /// For numbers of crops without crops.
    pub(super) fn augmentation(&self) -> Result<Augmentation> {
        let is_cropped = self.augment.contains(&Way::Crop);
        if !is_cropped && (self.crop_steps.is_some() || self.crop_rows.is_some()) {
            return Err(Error::Usage(
                "--crop-steps and --crop-rows say how --augment crop is done: it is not asked for"
                    .into(),
            ));
        }
        Ok(Augmentation {
            flip: self.augment.contains(&Way::Flip),
            crops: is_cropped.then(|| self.crops()),
        })
    }
}
