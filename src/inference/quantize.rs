//! Writes affine class scores in 8-bit weights, the files `NAME.egr` that firmware reads.
//!
//! The largest weight of a class becomes 127 (symmetric, a scale for each class: Krishnamoorthi
//! 2018, "Quantizing deep convolutional networks for efficient inference", arXiv:1806.08342,
//! section 2.2). Biases and scales are f32. `no_std_core/FORMAT.md` has the layout.
//!
//! Subtracting the mean weights of all classes from each, which changes no answer, does not help:
//! for LDA the means are 0 already, and for an SVM the mean error of scores rose.

use super::{Affine, Contract};
use crate::draw::sweep::FramingMode;
use crate::draw::template::Template;
use crate::error::{InferenceError, Result};
use edgegait_core::format::{
    FRAMING_BOX, FRAMING_HEIGHT, RECOGNIZER_CRC_AT, RECOGNIZER_MAGIC, RECOGNIZER_VERSION,
    RECOGNIZER_VERSION_AT, crc32,
};
use edgegait_core::silhouette::Size;

/// The greatest magnitude of a weight.
const LARGEST: f64 = 127.0;

/// Size and framing of the GEIs that a recognizer's file takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GeiForm {
    size: Size,
    framing: u8,
}

impl GeiForm {
    /// Returns the form that a contract specifies, if firmware can draw it.
    ///
    /// # Errors
    /// For templates other than GEIs, sizes that cannot be drawn, and framings that need a known
    /// scale.
    pub fn from_contract(contract: &Contract) -> Result<Self> {
        let refuse = |expected, found: &str| {
            Err(InferenceError::NotForFirmware {
                model: contract.name.clone(),
                expected,
                found: found.to_owned(),
            }
            .into())
        };
        if contract.template != Template::Gei {
            return refuse("template gei", contract.template.name());
        }
        let Some(size) = contract.size() else {
            let asked = format!("{}x{}", contract.rows, contract.columns);
            return refuse("50x30, 64x44 or 64x64 pixels", &asked);
        };
        let framing = match contract.framing {
            FramingMode::Height => FRAMING_HEIGHT,
            FramingMode::Box => FRAMING_BOX,
            other => return refuse("framing height or box", other.name()),
        };
        Ok(Self { size, framing })
    }

    /// Returns the file of a recognizer with the scores of `map`. Its classes have these `names`,
    /// or their numbers if there are none.
    ///
    /// # Errors
    /// For a name that is longer than 255 bytes.
    ///
    /// # Panics
    /// If `map` has another number of pixels or names, or more than 255 classes.
    pub fn write(self, map: &Affine, names: &[String]) -> Result<Vec<u8>> {
        let classes = map.bias.len();
        assert_eq!(map.weights.dim(), (classes, self.size.pixels()));
        assert!(names.is_empty() || names.len() == classes);
        let byte = |number: usize| u8::try_from(number).expect("at most 255");
        let mut bytes = RECOGNIZER_MAGIC.to_vec();
        bytes.extend([0; RECOGNIZER_VERSION_AT - RECOGNIZER_CRC_AT]);
        bytes.extend(RECOGNIZER_VERSION.to_le_bytes());
        let sides = [self.size.rows(), self.size.columns()];
        bytes.extend(sides.map(byte));
        bytes.extend([self.framing, byte(classes)]);
        let mut all = Vec::with_capacity(map.weights.len());
        for (row, bias) in map.weights.rows().into_iter().zip(&map.bias) {
            let row: Vec<f32> = row.iter().copied().collect();
            let (scale, weights) = quantized(&row, self.size.columns());
            bytes.extend([scale.to_le_bytes(), bias.to_le_bytes()].as_flattened());
            all.extend(weights);
        }
        bytes.extend(all);
        for class in 0..classes {
            let name = names.get(class).cloned().unwrap_or(class.to_string());
            let Ok(length) = u8::try_from(name.len()) else {
                return Err(InferenceError::ClassName(name).into());
            };
            bytes.push(length);
            bytes.extend(name.into_bytes());
        }
        let crc = crc32(&bytes[RECOGNIZER_VERSION_AT..]);
        bytes[RECOGNIZER_CRC_AT..RECOGNIZER_VERSION_AT].copy_from_slice(&crc.to_le_bytes());
        Ok(bytes)
    }
}

/// Quantises the weights of one class, which are for pixels of 0 to 1, in rows of `columns`.
/// Returns the scale for pixels of 0 to 255, and the 8-bit weights.
///
/// Rounding errors are diffused to the neighbours right and below (Floyd & Steinberg 1976, "An
/// adaptive algorithm for spatial greyscale"): neighbouring pixels of a GEI are similar, so errors
/// in the score cancel.
fn quantized(weights: &[f32], columns: usize) -> (f32, Vec<u8>) {
    let largest = weights.iter().fold(0.0f32, |most, w| most.max(w.abs()));
    let step = f64::from(largest) / LARGEST;
    let steps = |&weight: &f32| {
        if step > 0.0 {
            f64::from(weight) / step
        } else {
            0.0
        }
    };
    let mut wanted: Vec<f64> = weights.iter().map(steps).collect();
    for at in 0..wanted.len() {
        let whole = wanted[at].round().clamp(-LARGEST, LARGEST);
        let error = wanted[at] - whole;
        wanted[at] = whole;
        let column = at % columns;
        let neighbours = [
            (at + 1, 7.0, column + 1 < columns),
            (at + columns - 1, 3.0, column > 0),
            (at + columns, 5.0, true),
            (at + columns + 1, 1.0, column + 1 < columns),
        ];
        for (neighbour, sixteenths, _) in neighbours.into_iter().filter(|(.., is_one)| *is_one) {
            if let Some(neighbour) = wanted.get_mut(neighbour) {
                *neighbour += error * sixteenths / 16.0;
            }
        }
    }
    #[expect(clippy::cast_possible_truncation, reason = "whole numbers within 127")]
    let whole = |steps: f64| (steps as i8).cast_unsigned();
    #[expect(clippy::cast_possible_truncation, reason = "the format's f32")]
    let scale = (step / 255.0) as f32;
    (scale, wanted.into_iter().map(whole).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use edgegait_core::camera;
    use edgegait_core::linear::LinearRecognizer;
    use ndarray::{Array2, array};

    fn form(contract: &Contract) -> GeiForm {
        GeiForm::from_contract(contract).expect("firmware can draw it")
    }

    #[test]
    fn scores_of_whole_steps_are_read_back_exactly() {
        // Steps of 255/64 and 255/4, so that scales are powers of two.
        let mut weights = Array2::<f32>::zeros((3, 1500));
        weights[[0, 0]] = 255.0 * 127.0 / 64.0;
        weights[[0, 1]] = 255.0 * -3.0 / 64.0;
        weights[[1, 1499]] = 255.0 * -127.0 / 4.0;
        let map = Affine {
            weights,
            bias: array![10.0, 0.25, -7.5],
        };
        let names = ["A", "B", "nobody"].map(str::to_owned);
        let bytes = form(&Contract::default())
            .write(&map, &names)
            .expect("a file");
        let read = LinearRecognizer::parse(&bytes).expect("a recognizer");
        assert_eq!((read.classes(), read.size()), (3, Size::S50x30));
        assert_eq!(read.framing(), camera::Framing::Height);
        assert_eq!(
            [0, 1, 2].map(|class| read.name(class)),
            [Some("A"), Some("B"), Some("nobody")]
        );
        let mut pixels = [0; 1500];
        (pixels[0], pixels[1], pixels[1499]) = (2, 64, 8);
        // 127 x 2 / 64 - 3 x 64 / 64 + 10, -127 x 8 / 4 + 0.25.
        let scores = [0, 1, 2].map(|class| read.score(class, &pixels));
        assert_eq!(scores, [Some(10.968_75), Some(-253.75), Some(-7.5)]);
    }

    #[test]
    fn no_score_is_farther_off_than_half_a_step_of_each_pixel() {
        let weights = Array2::from_shape_fn((5, 64 * 44), |(class, pixel)| {
            ((class * 7919 + pixel * 104_729) % 10_007) as f32 / 5003.0 - 1.0
        });
        let map = Affine {
            weights,
            bias: array![1.0, 2.0, 3.0, 4.0, 5.0],
        };
        let contract = Contract {
            rows: 64,
            columns: 44,
            framing: FramingMode::Box,
            ..Contract::default()
        };
        let bytes = form(&contract).write(&map, &[]).expect("a file");
        let read = LinearRecognizer::parse(&bytes).expect("a recognizer");
        assert_eq!(read.framing(), camera::Framing::Box);
        assert_eq!((read.name(0), read.name(4)), (Some("0"), Some("4")));
        let pixels: Vec<u8> = (0..64 * 44).map(|pixel| (pixel * 31 % 256) as u8).collect();
        let unit = pixels.iter().map(|&byte| f64::from(byte) / 255.0).collect();
        let exact = map.apply_f64(ndarray::Array1::from_vec(unit).view());
        for (class, exact) in exact.iter().enumerate() {
            let score = f64::from(read.score(class, &pixels).expect("of its size"));
            let light: f64 = pixels.iter().map(|&byte| f64::from(byte) / 255.0).sum();
            let bound = 0.5 / 127.0 * light + 1e-3;
            assert!((score - exact).abs() < bound, "{score} {exact}");
            // Errors of pixels have both signs: a tighter bound, which a wrong scale would exceed.
            assert!(
                (score - exact).abs() < 4.0 * bound / light.sqrt(),
                "{score} {exact}"
            );
        }
    }

    #[test]
    fn contracts_that_firmware_cannot_draw_are_refused() {
        let of = |contract: Contract| {
            GeiForm::from_contract(&contract)
                .expect_err("not drawn")
                .to_string()
        };
        let default = Contract::default;
        let mhi = of(Contract {
            template: Template::Mhi,
            ..default()
        });
        assert!(
            mhi.contains("expected template gei") && mhi.contains("found mhi"),
            "{mhi}"
        );
        let wide = of(Contract {
            columns: 31,
            ..default()
        });
        assert!(
            wide.contains("64x44 or 64x64") && wide.contains("50x31"),
            "{wide}"
        );
        let cycle = of(Contract {
            framing: FramingMode::Cycle,
            ..default()
        });
        assert!(
            cycle.contains("height or box") && cycle.contains("cycle"),
            "{cycle}"
        );
    }

    #[test]
    fn a_name_longer_than_a_byte_counts_is_refused() {
        let map = Affine {
            weights: Array2::zeros((1, 1500)),
            bias: array![0.0],
        };
        let write = |length| form(&Contract::default()).write(&map, &["x".repeat(length)]);
        assert!(write(255).is_ok_and(|bytes| LinearRecognizer::parse(&bytes).is_ok()));
        let error = write(256).expect_err("too long").to_string();
        assert!(error.contains("at most 255 bytes, found 256"), "{error}");
    }
}
