//! Writes linear recognizers as ONNX files.
//!
//! The files pass `onnx.checker.check_model(m, full_check=True)`; the ignored test
//! `writes_a_model_its_probes_and_its_scores` writes a file to check.

use super::onnx_file::OnnxFile;
use super::{Classifier, LinearModel};
use crate::draw::template::{Template, TemplateShape};
use crate::inference::{EMBEDDING, SCORES};
use edgegait_core::silhouette::Size;
use ndarray::Array2;

/// Returns a model file that computes `recognizer`: Flatten, Gemm, Gemm, and a Reshape if the
/// embedding has parts.
///
/// The input has the template's name: f32 `[N, 1, rows, columns]` for a GEI, numbers in 0..1.
/// `name` becomes the graph's name; `properties` are stored as model metadata, in this order.
///
/// # Guarantees
/// Equal arguments give equal bytes.
#[must_use]
pub fn write(recognizer: &LinearModel, name: &str, properties: &[(&str, &str)]) -> Vec<u8> {
    let mut file = OnnxFile::default();
    let input = add_input(&mut file, recognizer.template, recognizer.size);
    let score_weights = match recognizer.classifier {
        Classifier::Centroids(_) => "centroids",
        Classifier::Svm(_) => "scores_weights",
    };
    let parts = recognizer.parts;
    let flat = if parts == 1 { EMBEDDING } else { "numbers" };
    let embedding = ["pixels", "embedding_weights", "embedding_bias"];
    let scores = [flat, score_weights, "scores_bias"];
    file.node("Flatten", &[input], "pixels");
    file.node("Gemm", &embedding, flat);
    file.node("Gemm", &scores, SCORES);
    let layers = [
        (embedding, &recognizer.embedding),
        (scores, &recognizer.score_map()),
    ];
    for ([_, weights, bias], affine) in layers {
        // Gemm multiplies from the right, so the weights are stored transposed.
        let transposed: Array2<f32> = affine.weights.t().as_standard_layout().into_owned();
        let (inputs, outputs) = transposed.dim();
        file.numbers(weights, &[inputs, outputs], &transposed);
        file.numbers(bias, &[outputs], &affine.bias);
    }
    let each = recognizer.dims() / parts;
    if parts == 1 {
        file.output(EMBEDDING, &[each]);
    } else {
        file.node("Reshape", &[flat, "embedding_shape"], EMBEDDING);
        // 0 keeps the size of the first axis: N.
        file.integers("embedding_shape", &[0, each as i64, parts as i64]);
        file.output(EMBEDDING, &[each, parts]);
    }
    file.output(SCORES, &[recognizer.classes()]);
    file.bytes(name, properties)
}

/// Adds the input of templates of silhouettes of this size, and returns its name.
pub(super) fn add_input(file: &mut OnnxFile, template: Template, size: Size) -> &'static str {
    let name = match template {
        // Only this name has a hyphen, which ONNX does not allow.
        Template::RowWidth => "row_width",
        template => template.name(),
    };
    match template.shape(size) {
        TemplateShape::Image {
            planes,
            rows,
            columns,
        } => file.input(name, &[planes, rows, columns]),
        TemplateShape::Vector(numbers) => file.input(name, &[numbers]),
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::testing::small_recognizer;

    #[test]
    fn equal_recognizers_give_equal_bytes() {
        let properties = [("people", "2")];
        let bytes = write(&small_recognizer(), "small", &properties);
        assert_eq!(bytes, write(&small_recognizer(), "small", &properties));
        assert_ne!(bytes, write(&small_recognizer(), "other", &properties));
    }

    #[test]
    fn a_file_is_little_more_than_its_weights() {
        let recognizer = small_recognizer();
        let weights =
            4 * (1500 * recognizer.dims() + recognizer.dims() + 2 * recognizer.dims() + 2);
        let bytes = write(&recognizer, "small", &[]);
        assert!(
            (weights..weights + 600).contains(&bytes.len()),
            "{}",
            bytes.len()
        );
    }
}
