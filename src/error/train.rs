//! Errors about training.

/// An error in samples, labels or settings.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrainError {
    /// A setting is out of its range.
    #[error("expected {expected}, found {found}")]
    OutOfRange {
        /// The setting and its range.
        expected: &'static str,
        /// The given value.
        found: f64,
    },
    /// Samples are not GEIs of a size that can be drawn.
    #[error("expected GEIs of 50 x 30 = 1500, 64 x 44 = 2816 or 64 x 64 = 4096 pixels, found {0}")]
    NoGeis(usize),
    /// Samples do not have the size of their templates.
    #[error("expected {templates} of {expected} numbers, found {found}")]
    Numbers {
        /// The kind of templates.
        templates: &'static str,
        /// Size of a template.
        expected: usize,
        /// Size of a sample.
        found: usize,
    },
    /// There are too few samples for principal components.
    #[error(
        "principal components need at least 2 samples of 1 dimension, found {samples} samples of {dims} dimensions"
    )]
    TooFewSamples {
        /// Number of samples.
        samples: usize,
        /// Size of each sample.
        dims: usize,
    },
    /// A sample has a value that is not finite.
    #[error("sample {row} has a value at {column} that is not a finite number")]
    NotFinite {
        /// The number of the sample.
        row: usize,
        /// The position in the sample.
        column: usize,
    },
    /// The numbers of labels and samples differ.
    #[error("expected a label per sample, found {labels} for {samples}")]
    Labels {
        /// Number of labels.
        labels: usize,
        /// Number of samples.
        samples: usize,
    },
    /// A label is none of the classes.
    #[error("sample {row}: expected a label below {classes}, found {label}")]
    Label {
        /// The sample.
        row: usize,
        /// Its label.
        label: usize,
        /// Number of classes.
        classes: usize,
    },
    /// Samples are all the same.
    #[error("all samples have the same features: there is nothing to learn from")]
    Constant,
    /// No feature can be chosen.
    #[error(
        "no value of the templates varies more between people than within them: there is nothing to choose"
    )]
    NothingChosen,
    /// Every person has one sample.
    #[error(
        "a choice of features needs several samples of each person, to measure the variation within them: found {found} of {people} people"
    )]
    OneSampleEach {
        /// Number of people.
        people: usize,
        /// Number of their samples.
        found: usize,
    },
    /// More features are chosen than a matrix can hold.
    #[error(
        "{chosen} of {numbers} values were chosen: too many for the matrix that selects them (use a template with fewer values, such as row-width, or smaller silhouettes)"
    )]
    TooMuchChosen {
        /// Number of chosen values.
        chosen: usize,
        /// Number of values of a template.
        numbers: usize,
    },
    /// Two viewpoints are the same.
    #[error(
        "view transformation needs different viewpoints, but {0} (azimuth, elevation) are the same"
    )]
    SameViews(String),
    /// The viewpoint of a sample is unknown.
    #[error(
        "view transformation needs the viewpoint of each sample, but the angles of {0} are unknown"
    )]
    UnknownViews(usize),
    /// A person has no sample from a viewpoint.
    #[error(
        "view transformation needs each person from each viewpoint, but {person} has no sample from {view}"
    )]
    ViewMissing {
        /// The person's name.
        person: String,
        /// The viewpoint.
        view: String,
    },
    /// There are too few viewpoints.
    #[error("view transformation needs at least 2 viewpoints with known angles, found {0}")]
    TooFewViews(usize),
    /// A method needs another template.
    #[error("{method} learns from {expected}, found {found}")]
    OtherTemplate {
        /// The method.
        method: &'static str,
        /// The template that it learns from.
        expected: &'static str,
        /// The template of the samples.
        found: &'static str,
    },
    /// A random subspace is larger than the space.
    #[error("expected 1 to {found} eigenvectors of a random subspace, found {each}")]
    Subspace {
        /// Number of available eigenvectors.
        found: usize,
        /// Requested eigenvectors of each subspace.
        each: usize,
    },
    /// There are fewer than two classes.
    #[error("training needs at least 2 classes, found {0}")]
    TooFewClasses(usize),
    /// A class has no sample.
    #[error("class {0} has no sample to learn from")]
    EmptyClass(usize),
    /// Two classes cannot be separated.
    #[error(
        "classes {0} and {1} have the same mean: they cannot be separated (is one person in the dataset under two names?)"
    )]
    SameMean(usize, usize),
    /// No finite eigenvalues were found.
    #[error("no finite eigenvalues found for a {0} x {0} matrix")]
    NoEigenvalues(usize),
    /// The scatter within classes is singular.
    #[error("the scatter within classes cannot be inverted: use a larger ridge")]
    NotInvertible,
    /// A support vector machine did not come close enough to its optimum.
    #[error(
        "class {class} against the rest: expected a duality gap of {expected:.0e} of the objective, found {found:.1e}, which is as far as rounding lets it fall (use a smaller C than {c})"
    )]
    DualityGap {
        /// The class.
        class: usize,
        /// The requested gap.
        expected: f64,
        /// The gap that was reached.
        found: f64,
        /// The weight of errors, C.
        c: f64,
    },
}
