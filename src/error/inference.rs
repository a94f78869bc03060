//! Errors about recognizers that cannot be run, or whose answers cannot be used.

use super::Cause;

/// A mismatch between a model, its contract and its inputs.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InferenceError {
    /// A model's contract needs other templates.
    #[error("{model}: the model's contract asks for {setting} {asked}, found {found}")]
    Contract {
        /// The model.
        model: String,
        /// `template`, `size` or `framing`.
        setting: &'static str,
        /// Its value in the contract.
        asked: String,
        /// Its value in the templates.
        found: &'static str,
        /// The origin of the templates.
        origin: TemplateOrigin,
    },
    /// A contract cannot be written down.
    #[error("contract: {0}")]
    ContractText(#[from] toml::ser::Error),
    /// A model is given too few or too many numbers.
    #[error(
        "{model}: expected {batch} {inputs} of {shape} = {numbers} numbers and at least one, found {found} numbers"
    )]
    Input {
        /// The model.
        model: String,
        /// Number of inputs.
        batch: usize,
        /// The kind of inputs.
        inputs: String,
        /// The shape of an input, or of a frame of it.
        shape: String,
        /// Size of that shape.
        numbers: usize,
        /// Number of given values.
        found: usize,
    },
    /// A model's output has an unexpected form.
    #[error("{model}: expected the output {output:?} as {expected}, found {found}")]
    Output {
        /// The model.
        model: String,
        /// The output.
        output: String,
        /// Its expected form.
        expected: String,
        /// Its actual form.
        found: String,
    },
    /// The embedded runtime cannot run a model.
    #[error("{model}: the embedded runtime: {cause}")]
    Embedded {
        /// The model.
        model: String,
        /// The cause.
        #[source]
        cause: Cause,
    },
    /// The embedded runtime's threads belong to another process.
    #[error(
        "the embedded runtime was started before this process forked, and has no threads here (start processes by spawn, or load the first model after the fork)"
    )]
    Forked,
    /// ONNX Runtime cannot run a model.
    #[error("{model}: ONNX Runtime: {cause}")]
    OnnxRuntime {
        /// The model.
        model: String,
        /// The cause.
        #[source]
        cause: Cause,
    },
    /// A model gives embeddings of different lengths.
    #[error(
        "{model}: an embedding of {found} numbers after one of {before}: expected the same length for all sequences"
    )]
    Lengths {
        /// The model.
        model: String,
        /// Length of an embedding.
        before: usize,
        /// Length of a later embedding.
        found: usize,
    },
    /// A model takes the viewpoint, which is unknown for an input.
    #[error(
        "{model} takes the viewpoint of each input, but the angles of one are unknown: use inputs with known azimuths and elevations"
    )]
    ViewUnknown {
        /// The model.
        model: String,
    },
    /// A model takes the viewpoint, but only images are available.
    #[error(
        "{model}: expected a contract without view_input, found {input:?}: only images are available here"
    )]
    TakesViews {
        /// The model.
        model: String,
        /// The input of viewpoints.
        input: String,
    },
    /// A model takes the viewpoint, and was not trained on the viewpoint of an input.
    #[error(
        "{model} has not been trained on viewpoint {found}: expected one of {known} (azimuth,elevation)"
    )]
    ViewUntrained {
        /// The model.
        model: String,
        /// The viewpoint of the input.
        found: String,
        /// The viewpoints of its training.
        known: String,
    },
    /// There are too many embeddings to keep in memory.
    #[error(
        "{model}: more than {most} numbers in all embeddings: choose fewer viewpoints or walks"
    )]
    TooManyNumbers {
        /// The model.
        model: String,
        /// The maximum number of values.
        most: usize,
    },
    /// A model gives no class scores.
    #[error(
        "{0}: expected class scores, found an embedding only (name an output as scores under [outputs] in the .toml)"
    )]
    NoScores(String),
    /// A model has more classes than a firmware file can store.
    #[error("{model}: expected at most {most} classes, found {found}")]
    TooManyClasses {
        /// The model.
        model: String,
        /// Number of its classes.
        found: usize,
        /// The maximum number of classes.
        most: usize,
    },
    /// A model gives a score that is not finite.
    #[error("{model}: expected finite scores, found {score}")]
    NotFinite {
        /// The model.
        model: String,
        /// The score.
        score: f32,
    },
    /// A model gives the same scores for all images.
    #[error(
        "{model}: expected scores that depend on the pixels, found the same scores for {images} random images"
    )]
    Constant {
        /// The model.
        model: String,
        /// Number of images that it was shown.
        images: usize,
    },
    /// A model is not linear.
    #[error(
        "{model}: expected scores that are an affine function of the pixels, found one of {images} random images {found:.3e} away from it, where pixels change scores by up to {change:.3e} (after Softmax they are not affine: export the scores before it; only linear recognizers can be quantised here)"
    )]
    NotAffine {
        /// The model.
        model: String,
        /// Number of images that it was shown.
        images: usize,
        /// The greatest distance of a score from the affine function.
        found: f64,
        /// The greatest change of a score between images.
        change: f64,
    },
    /// Firmware cannot draw the inputs of a contract.
    #[error("{model}: expected {expected} to quantise for, found {found} in the model's contract")]
    NotForFirmware {
        /// The model.
        model: String,
        /// The inputs that can be drawn.
        expected: &'static str,
        /// The inputs of the contract.
        found: String,
    },
    /// A class has a name that is too long for firmware.
    #[error(
        "class {0:?}: expected a name of at most 255 bytes, found {len}",
        len = .0.len()
    )]
    ClassName(String),
}

/// The origin of a recognizer's templates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TemplateOrigin {
    /// Templates drawn for the recognizer.
    Drawn,
    /// Templates of a dataset.
    Dataset,
}
