//! Why a recognizer is not run, or its answers are not used.

use super::Cause;

/// What is wrong between a model, its contract and what it is given.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ScoreError {
    /// A model's contract asks for other templates than there are.
    #[error("{model}: the model's contract asks for {setting} {asked}, found {found}")]
    Contract {
        /// The model.
        model: String,
        /// `template`, `size` or `framing`.
        setting: &'static str,
        /// Its value in the contract.
        asked: String,
        /// Its value.
        found: &'static str,
        /// Where the templates come from.
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
        /// Inputs at once.
        batch: usize,
        /// What they are.
        inputs: String,
        /// The shape of one, or of a frame of one.
        shape: String,
        /// Numbers of that.
        numbers: usize,
        /// Numbers that were given.
        found: usize,
    },
    /// A model answers in another form than it has to.
    #[error("{model}: expected the output {output:?} as {expected}, found {found}")]
    Output {
        /// The model.
        model: String,
        /// The output.
        output: String,
        /// Its form.
        expected: String,
        /// Its form now.
        found: String,
    },
    /// The embedded runtime does not run a model.
    #[error("{model}: the embedded runtime: {cause}")]
    Embedded {
        /// The model.
        model: String,
        /// Why not.
        #[source]
        cause: Cause,
    },
    /// The embedded runtime's threads are those of another process.
    #[error(
        "the embedded runtime was started before this process forked, and its threads stayed behind (start processes by spawn, or load the first model after the fork)"
    )]
    Forked,
    /// ONNX Runtime does not run a model.
    #[error("{model}: ONNX Runtime: {cause}")]
    OnnxRuntime {
        /// The model.
        model: String,
        /// Why not.
        #[source]
        cause: Cause,
    },
    /// A model gives embeddings of different lengths.
    #[error(
        "{model}: an embedding of {found} numbers after one of {before}: expected the same for all sequences"
    )]
    Lengths {
        /// The model.
        model: String,
        /// Numbers of an embedding.
        before: usize,
        /// Numbers of a later one.
        found: usize,
    },
    /// A model takes the viewpoint, and that is not known.
    #[error(
        "{model} takes the viewpoint of each input, and the angles of one are not known: score what is seen from stated azimuths and elevations"
    )]
    ViewUnknown {
        /// The model.
        model: String,
    },
    /// A model takes the viewpoint, where only pictures are given.
    #[error(
        "{model}: expected a contract without view_input, found {input:?}: only pictures are given"
    )]
    TakesViews {
        /// The model.
        model: String,
        /// The input of viewpoints.
        input: String,
    },
    /// A model takes the viewpoint, and was not trained on that of an input.
    #[error(
        "{model} has not been trained on viewpoint {found}: expected one of {known} (azimuth,elevation)"
    )]
    ViewUntrained {
        /// The model.
        model: String,
        /// The viewpoint of the input.
        found: String,
        /// Those that it was trained on.
        known: String,
    },
    /// There are more embeddings than are kept.
    #[error(
        "{model}: more than {most} numbers in all embeddings: choose fewer viewpoints or walks"
    )]
    TooManyNumbers {
        /// The model.
        model: String,
        /// Numbers that are kept.
        most: usize,
    },
    /// A model gives no class scores.
    #[error(
        "{0}: expected class scores, found an embedding only (name an output as scores under [outputs] in the .toml)"
    )]
    NoScores(String),
    /// A model has more classes than a file of firmware holds.
    #[error("{model}: expected at most {most} classes, found {found}")]
    TooManyClasses {
        /// The model.
        model: String,
        /// Its classes.
        found: usize,
        /// How many it may have.
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
    /// A model scores everything alike.
    #[error(
        "{model}: expected scores that depend on the pixels, found the same of {images} random images"
    )]
    Constant {
        /// The model.
        model: String,
        /// Images that it was shown.
        images: usize,
    },
    /// A model is not linear.
    #[error(
        "{model}: expected scores that are an affine function of the pixels, found one of {images} random images {found:.3e} away from it, where pixels change scores by up to {change:.3e} (after Softmax they are not affine: export those before it; and only linear recognizers can be quantised here)"
    )]
    NotAffine {
        /// The model.
        model: String,
        /// Images that it was shown.
        images: usize,
        /// How far a score is from the affine function.
        found: f64,
        /// How far scores are from each other.
        change: f64,
    },
    /// Firmware cannot draw what a contract asks for.
    #[error("{model}: expected {expected} to quantise for, found {found} in the model's contract")]
    NotForFirmware {
        /// The model.
        model: String,
        /// What can be drawn.
        expected: &'static str,
        /// What the contract asks for.
        found: String,
    },
    /// A class has a name that is too long for firmware.
    #[error(
        "class {0:?}: expected a name of at most 255 bytes, found {len}",
        len = .0.len()
    )]
    ClassName(String),
}

/// Where the templates come from that a recognizer is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TemplateOrigin {
    /// They are drawn for it.
    Drawn,
    /// They are in a dataset that was swept before.
    Dataset,
}
