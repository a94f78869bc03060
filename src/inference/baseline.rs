//! Baselines that need no model: a template is its own embedding, or is projected at random.
//!
//! Comparing GEIs pixel by pixel (Han & Bhanu 2006, "Individual recognition using gait energy
//! image", IEEE Trans. Pattern Anal. 28:316, "real templates") shows how well the images alone
//! identify people, without learning. A random projection, an untrained linear network, shows how
//! much of that is left in as few numbers as a recognizer's embedding has.

use super::provider::RuntimeName;
use super::{Contract, Distance, InputLayout, Outputs, Recognizer};
use crate::draw::sweep::FramingMode;
use crate::draw::template::Template;
use crate::error::Result;
use edgegait_core::silhouette::Size;
use ndarray::{Array1, Array2, ArrayView2, Axis};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// The name of the pixel baseline among models.
pub(crate) const PIXELS: &str = "pixels";
/// The name of the random projection in results.
pub(crate) const RANDOM: &str = "random";

/// A recognizer whose embedding is the template itself, or a random projection of it.
#[derive(Clone, Debug)]
pub(crate) struct Baseline {
    contract: Contract,
    runtime: RuntimeName,
    /// The projection, one number of the embedding a row.
    projection: Option<Array2<f32>>,
    enrolled: Option<Enrolled>,
}

/// The enrolled templates.
#[derive(Clone, Debug)]
struct Enrolled {
    /// Their embeddings, one a row.
    known: Array2<f32>,
    /// Half of the squared length of each embedding.
    half_squares: Array1<f32>,
    /// The class of each embedding.
    classes: Vec<usize>,
}

impl Baseline {
    /// Returns the baseline that compares templates of this size and framing pixel by pixel.
    #[must_use]
    pub(crate) fn pixels(template: Template, size: Size, framing: FramingMode) -> Self {
        Self::like(Contract {
            name: PIXELS.into(),
            rows: size.rows(),
            columns: size.columns(),
            layout: InputLayout::for_template(template),
            framing,
            template,
            ..Contract::default()
        })
    }

    /// Returns the baseline that compares the inputs of this contract pixel by pixel: templates, or
    /// the means of sequences of silhouettes. It takes no viewpoint.
    #[must_use]
    pub(crate) fn like(contract: Contract) -> Self {
        let distance = match contract.distance {
            Distance::View => Distance::Euclidean,
            other => other,
        };
        Self {
            contract: Contract {
                view_input: None,
                distance,
                ..contract
            },
            runtime: RuntimeName {
                name: "none".into(),
                ..RuntimeName::default()
            },
            projection: None,
            enrolled: None,
        }
    }

    /// Projects the embedding to `dims` numbers. Each is a weighted sum of all pixels, with weights
    /// that `seed` draws from a normal distribution of variance 1 / `dims`, which keeps distances
    /// on average.
    #[must_use]
    pub(crate) fn projected(mut self, dims: usize, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let scale = 1.0 / (dims as f64).sqrt();
        self.projection = Some(Array2::from_shape_simple_fn(
            (dims, self.contract.numbers()),
            || {
                let normal: f64 = StandardNormal.sample(&mut rng);
                (scale * normal) as f32
            },
        ));
        self
    }

    /// Adds class scores: the negative distance to the nearest of the class's enrolled `templates`
    /// (one a row). `classes` has the class of each template.
    #[must_use]
    pub(crate) fn enrolled(mut self, templates: ArrayView2<'_, f32>, classes: Vec<usize>) -> Self {
        let known = self.embedded(templates);
        let half_square = |row: ndarray::ArrayView1<'_, f32>| 0.5 * row.dot(&row);
        self.enrolled = Some(Enrolled {
            half_squares: known.outer_iter().map(half_square).collect(),
            known,
            classes,
        });
        self
    }

    fn embedded(&self, templates: ArrayView2<'_, f32>) -> Array2<f32> {
        match &self.projection {
            Some(projection) => templates.dot(&projection.t()),
            None => templates.to_owned(),
        }
    }
}

impl Enrolled {
    /// Returns the class scores of embeddings, one a row.
    fn scores(&self, embeddings: &Array2<f32>, classes: usize) -> Array2<f32> {
        let products = embeddings.dot(&self.known.t());
        let mut scores = Array2::from_elem((embeddings.nrows(), classes), f32::NEG_INFINITY);
        for (row, (products, mut scores)) in products
            .outer_iter()
            .zip(scores.outer_iter_mut())
            .enumerate()
        {
            let own = embeddings.row(row);
            let half_square = 0.5 * own.dot(&own);
            for ((&class, &product), &known) in
                self.classes.iter().zip(products).zip(&self.half_squares)
            {
                let square = 2.0 * (half_square + known - product);
                scores[class] = scores[class].max(-square.max(0.0).sqrt());
            }
        }
        scores
    }
}

impl Recognizer for Baseline {
    fn runtime(&self) -> &RuntimeName {
        &self.runtime
    }

    fn contract(&self) -> &Contract {
        &self.contract
    }

    fn is_baseline(&self) -> bool {
        true
    }

    fn run(&self, input: &[f32], batch: usize) -> Result<Outputs> {
        let frames = self.contract.frames_in(input.len(), batch)?;
        let numbers = self.contract.numbers();
        let rows = || input.chunks_exact(numbers * frames);
        let mut templates = Array2::zeros((batch, numbers));
        for (sequence, mut template) in rows().zip(templates.axis_iter_mut(Axis(0))) {
            for frame in sequence.chunks_exact(numbers) {
                template += &ndarray::ArrayView1::from(frame);
            }
            if frames > 1 {
                template /= frames as f32;
            }
        }
        let embeddings = self.embedded(templates.view());
        // Where scores decide, they replace the embeddings, which may have many numbers.
        let scores = self.enrolled.as_ref();
        let scores = scores.map(|it| it.scores(&embeddings, self.contract.classes.len()));
        let embeddings = scores.as_ref().unwrap_or(&embeddings);
        let outputs = Outputs {
            embedding: embeddings.iter().copied().collect(),
            embedding_dims: embeddings.ncols(),
            embedding_parts: 1,
            classes: scores.as_ref().map_or(0, Array2::ncols),
            scores: scores
                .as_ref()
                .map(|scores| scores.iter().copied().collect()),
            non_finite: embeddings
                .iter()
                .filter(|number| !number.is_finite())
                .count(),
        };
        Ok(outputs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixels() -> Baseline {
        Baseline::pixels(Template::Gei, Size::S50x30, FramingMode::Height)
    }

    /// Returns a template with these values at a few places, else 0.
    fn template(places: &[(usize, f32)]) -> Vec<f32> {
        let mut template = vec![0.0; 1500];
        for &(at, value) in places {
            template[at] = value;
        }
        template
    }

    #[test]
    fn a_random_projection_is_linear_and_keeps_distances_on_average() {
        let random = pixels().projected(400, 3);
        let run = |input: &[f32]| random.run(input, 1).expect("an answer").embedding;
        let [a, b] = [run(&template(&[(7, 1.0)])), run(&template(&[(9, 1.0)]))];
        let both = run(&template(&[(7, 0.5), (9, 0.25)]));
        for ((a, b), both) in a.iter().zip(&b).zip(&both) {
            assert!((0.5 * a + 0.25 * b - both).abs() < 1e-6);
        }
        // A mean of 400 squares of normal numbers: 1 with a deviation of sqrt(2 / 400), and they
        // are nearly at right angles.
        let length: f32 = a.iter().map(|x| x * x).sum();
        let angle: f32 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
        assert!(
            (length - 1.0).abs() < 0.3 && angle.abs() < 0.2,
            "{length}, {angle}"
        );
        assert_ne!(
            a,
            pixels()
                .projected(400, 4)
                .run(&template(&[(7, 1.0)]), 1)
                .expect("an answer")
                .embedding
        );
    }

    #[test]
    fn class_scores_are_distances_to_the_nearest_that_is_known() {
        // Class 1 has two templates, 3 and 4 from the probe; class 0 has one, 5 from it.
        let known = [
            template(&[(0, 5.0)]),
            template(&[(1, 3.0)]),
            template(&[(2, 4.0)]),
        ];
        let known = Array2::from_shape_vec((3, 1500), known.concat()).expect("three rows");
        let mut of = pixels();
        of.contract.classes = vec!["ann".into(), "bob".into()];
        let outputs = of
            .enrolled(known.view(), vec![0, 1, 1])
            .run(&template(&[]), 1)
            .expect("an answer");
        assert_eq!(outputs.scores, Some(vec![-5.0, -3.0]));
        assert_eq!(
            (outputs.classes, outputs.embedding_dims, outputs.non_finite),
            (2, 2, 0)
        );
    }

    #[test]
    fn sequences_are_compared_by_their_mean() {
        let contract = Contract {
            template: Template::Silhouettes,
            layout: InputLayout::for_template(Template::Silhouettes),
            ..Contract::default()
        };
        let two = [template(&[(0, 1.0), (5, 1.0)]), template(&[(0, 1.0)])].concat();
        let outputs = Baseline::like(contract).run(&two, 1).expect("an answer");
        assert_eq!(outputs.embedding, template(&[(0, 1.0), (5, 0.5)]));
    }
}
