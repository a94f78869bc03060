//! Why nothing is learnt.

/// What is wrong with samples, labels or settings.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrainError {
    /// A setting is out of its range.
    #[error("expected {expected}, found {found}")]
    OutOfRange {
        /// The setting and its range.
        expected: &'static str,
        /// What was given.
        found: f64,
    },
    /// Samples are no GEIs of a size that can be drawn.
    #[error("expected GEIs of 50 x 30 = 1500, 64 x 44 = 2816 or 64 x 64 = 4096 pixels, found {0}")]
    NoGeis(usize),
    /// Samples have more or fewer numbers than the templates that they are said to be.
    #[error("expected {templates} of {expected} numbers, found {found}")]
    Numbers {
        /// What they are said to be.
        templates: &'static str,
        /// Numbers of one.
        expected: usize,
        /// Numbers of a sample.
        found: usize,
    },
    /// There is too little to find directions in.
    #[error(
        "principal components need at least 2 samples of 1 dimension, found {samples} of {dims}"
    )]
    TooFewSamples {
        /// Samples.
        samples: usize,
        /// Numbers of each.
        dims: usize,
    },
    /// A sample has a value that is not finite.
    #[error("sample {row} has a value at {column} that is not a finite number")]
    NotFinite {
        /// The sample.
        row: usize,
        /// Where in it.
        column: usize,
    },
    /// There are not as many labels as samples.
    #[error("expected a label per sample, found {labels} for {samples}")]
    Labels {
        /// Labels.
        labels: usize,
        /// Samples.
        samples: usize,
    },
    /// A label is none of the classes.
    #[error("sample {row}: expected a label below {classes}, found {label}")]
    Label {
        /// The sample.
        row: usize,
        /// Its label.
        label: usize,
        /// Classes.
        classes: usize,
    },
    /// Samples are all the same.
    #[error("all samples have the same features: there is nothing to learn from")]
    Constant,
    /// No feature can be chosen.
    #[error(
        "no number of the templates varies more between people than within them: there is nothing to choose"
    )]
    NothingChosen,
    /// Everybody has one sample.
    #[error(
        "a choice of features needs several samples of people, to see how these vary within them: found {found} of {people} people"
    )]
    OneSampleEach {
        /// People.
        people: usize,
        /// Their samples.
        found: usize,
    },
    /// More features are chosen than a matrix can hold.
    #[error(
        "{chosen} of {numbers} numbers were chosen: too many for the matrix that chooses them (take a template with fewer numbers, such as row-width, or smaller silhouettes)"
    )]
    TooMuchChosen {
        /// Numbers that were chosen.
        chosen: usize,
        /// Numbers of a template.
        numbers: usize,
    },
    /// Two viewpoints are one.
    #[error("view transformation needs different viewpoints, and {0} (azimuth, elevation) are one")]
    SameViews(String),
    /// The viewpoint of a sample is not known.
    #[error(
        "view transformation needs the viewpoint of each sample, and the angles of {0} are not known"
    )]
    UnknownViews(usize),
    /// A person is not seen from each viewpoint.
    #[error(
        "view transformation needs each person from each viewpoint, and {person} is not seen from {view}"
    )]
    ViewMissing {
        /// The person's name.
        person: String,
        /// The viewpoint.
        view: String,
    },
    /// There are too few viewpoints.
    #[error("view transformation needs at least 2 viewpoints whose angles are known, found {0}")]
    TooFewViews(usize),
    /// A method learns of another template.
    #[error("{method} learns of {expected}, found {found}")]
    OtherTemplate {
        /// The method.
        method: &'static str,
        /// The template that it learns of.
        expected: &'static str,
        /// The template that is there.
        found: &'static str,
    },
    /// A random subspace is larger than the space.
    #[error("expected 1 to {found} eigenvectors of a random subspace, found {each}")]
    Subspace {
        /// Eigenvectors that there are.
        found: usize,
        /// Those that each subspace is to have.
        each: usize,
    },
    /// There is nothing to tell apart.
    #[error("telling classes apart needs at least 2 of them, found {0}")]
    TooFewClasses(usize),
    /// A class has no sample.
    #[error("class {0} has no sample to learn from")]
    EmptyClass(usize),
    /// Two classes cannot be told apart.
    #[error(
        "classes {0} and {1} have the same mean: they cannot be told apart (is one person in the dataset under two names?)"
    )]
    SameMean(usize, usize),
    /// No finite eigenvalues were found.
    #[error("no finite eigenvalues found for a {0} x {0} matrix")]
    NoEigenvalues(usize),
    /// The scatter within classes has directions without any.
    #[error("the scatter within classes cannot be inverted: use a larger ridge")]
    NotInvertible,
    /// A support vector machine did not come close enough to its optimum.
    #[error(
        "class {class} against the rest: expected a duality gap of {expected:.0e} of the objective, found {found:.1e}, which is as far as rounding lets it fall (use a smaller C than {c})"
    )]
    DualityGap {
        /// The class.
        class: usize,
        /// The gap that was asked for.
        expected: f64,
        /// The gap that was reached.
        found: f64,
        /// What errors cost.
        c: f64,
    },
}
