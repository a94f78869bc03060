//! Flags that make more images of each.

use crate::dataset::Header;
use crate::error::{Error, Result};
use crate::template::augment::{Augmentation, Crops, varied};
use edgegait_core::silhouette::Size;

/// What is made of each image besides itself.
#[derive(Clone, Debug, clap::Args)]
pub struct AugmentArgs {
    /// Add variants of each image: mirrored; without its lowest rows, enlarged (Han & Bhanu's
    /// synthetic templates); both together. Each has its own condition, as in normal+flip+crop2
    #[arg(long, value_name = "NAME[,NAME..]", value_delimiter = ',')]
    augment: Vec<Way>,
    /// How many crops are made of each image
    /// [default: 4]
    #[arg(long, value_name = "K", requires = "augment")]
    crop_steps: Option<u16>,
    /// Rows that each crop cuts off the bottom, and the next one as many more
    /// [default: 1]
    #[arg(long, value_name = "N", requires = "augment")]
    crop_rows: Option<u16>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Way {
    Flip,
    Crop,
}

impl AugmentArgs {
    /// What is asked for.
    ///
    /// # Errors
    /// For numbers of crops without crops.
    pub fn augmentation(&self) -> Result<Augmentation> {
        let default = Crops::default();
        let is_cropped = self.augment.contains(&Way::Crop);
        if !is_cropped && (self.crop_steps.is_some() || self.crop_rows.is_some()) {
            return Err(Error::Usage(
                "--crop-steps and --crop-rows say how --augment crop is done: it is not asked for"
                    .into(),
            ));
        }
        Ok(Augmentation {
            flip: self.augment.contains(&Way::Flip),
            crops: is_cropped.then(|| Crops {
                steps: self.crop_steps.map_or(default.steps, usize::from),
                rows: self.crop_rows.map_or(default.rows, usize::from),
            }),
        })
    }
}

/// What was added to a model's samples, for its description; nothing if nothing was.
#[must_use]
pub fn described(augmentation: Augmentation) -> String {
    let flip = augmentation.flip.then(|| "flip".to_owned());
    let crop = augmentation
        .crops
        .map(|Crops { steps, rows }| format!("crop ({steps} steps of {rows} of the lowest rows)"));
    let ways: Vec<String> = flip.into_iter().chain(crop).collect();
    match ways.as_slice() {
        [] => String::new(),
        _ => format!(", augmented by {}", ways.join(", ")),
    }
}

/// Appends a template of silhouettes of this size, and its variants, as numbers in 0..1: how many.
pub fn append_varied(
    bytes: &[u8],
    (size, augmentation): (Size, Augmentation),
    numbers: &mut Vec<f32>,
) -> usize {
    let mut append =
        |bytes: &[u8]| numbers.extend(bytes.iter().map(|&byte| f32::from(byte) / 255.0));
    append(bytes);
    let variants = augmentation.variants();
    for &variant in variants.iter().skip(1) {
        append(&varied(bytes, size, variant));
    }
    variants.len()
}

/// A result's header with what was made of each image besides itself, if anything was.
#[must_use]
pub fn stated_augmentation(mut header: Header, augmentation: Augmentation) -> Header {
    if augmentation == Augmentation::default() {
        return header;
    }
    let names = [
        augmentation.flip.then_some("flip"),
        augmentation.crops.map(|_| "crop"),
    ];
    let names: Vec<&str> = names.into_iter().flatten().collect();
    header = header.with("augment", names.join(","));
    if let Some(Crops { steps, rows }) = augmentation.crops {
        header = header.with("crop_steps", steps).with("crop_rows", rows);
    }
    header
}
