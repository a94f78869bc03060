//! View transformation: Makihara, Sagawa, Mukaigawa, Echigo & Yagi 2006, "Gait recognition using a view
//! transformation model in the frequency domain", ECCV.
//!
//! What people look like from each viewpoint is one matrix: a block of rows for each viewpoint, a
//! column for each person. Its singular value decomposition `U S V^T` gives each viewpoint `j` a block
//! `P_j` of `U S`, with which a person `v` looks like `P_j v`. From one viewpoint `j` to another `i` a
//! template becomes `P_i P_j^+ x`.
//!
//! The publication transforms the gallery to the probe's viewpoint and compares it there. The part of a probe
//! that no person of that viewpoint has is equally far from all of the gallery; the rest is at the
//! distance `|R_i (v - w)|` with `R_i^T R_i = P_i^T P_i`, where `v` is of the probe and `w` of the gallery.
//! So an embedding has a part `R_i v` for each viewpoint `i`, of which the probe's is compared
//! ([`crate::score::Distance::View`]). Where both are seen from one viewpoint the publication compares
//! them as they are, and this as far as people differ there.
//!
//! What the publication leaves open: templates are put along the principal components of all people's means
//! from all viewpoints first, which makes a model small; directions with less than 1e-10 of the variance
//! of the first are none.

use super::algebra::{Real, add_products_of_columns, eigen, multiply};
use super::lda::Classes;
use super::onnx::add_input;
use super::onnx_file::{Attribute, OnnxFile};
use super::pca::Pca;
use super::{Components, Samples};
use crate::error::{Result, TrainError};
use crate::score::{Affine, Contract, Distance, EMBEDDING};
use crate::template::Template;
use edgegait_core::silhouette::Size;
use ndarray::{Array1, Array2, Array3, Axis, s};

/// How models call the input that has each template's azimuth and elevation, degrees.
pub const VIEW: &str = "view";

/// What brings templates of people from one viewpoint to another.
pub struct ViewTransformation {
    template: Template,
    size: Size,
    viewpoints: Vec<[f64; 2]>,
    /// A template's numbers to its principal components.
    components: Affine,
    blocks: Vec<Block>,
}

/// What is known of a viewpoint.
struct Block {
    /// `P^+`: from principal components to what a person is from anywhere.
    inverse: Array2<f64>,
    /// `R`: from that to where a person is from this viewpoint, up to a rotation.
    root: Array2<f64>,
}

impl ViewTransformation {
    /// Learns of templates of people, each of them from each viewpoint.
    ///
    /// # Errors
    /// For fewer than two viewpoints or people, a person who is not seen from one of the viewpoints, and
    /// samples that are all the same.
    pub fn fit(samples: &Samples, components: Components) -> Result<Self> {
        let viewpoints = &samples.training.viewpoints;
        if viewpoints.len() < 2 {
            return Err(TrainError::TooFewViews(viewpoints.len()).into());
        }
        let means: Vec<Array2<f64>> = { 0..viewpoints.len() }
            .map(|view| of_people(samples, view))
            .collect::<Result<_>>()?;
        let seen: Vec<_> = means.iter().map(|means| means.view()).collect();
        let pca = Pca::<f64>::fit(ndarray::concatenate(Axis(0), &seen)?.view())?;
        let kept = pca.kept(components)?;
        let points = means.iter().map(|means| pca.project(means.view(), kept));
        let points: Vec<Array2<f64>> = points.map(Array2::reversed_axes).collect();
        let weights = pca.components.slice(s![..kept, ..]).to_owned();
        Ok(Self {
            template: samples.template,
            size: samples.size,
            viewpoints: viewpoints.clone(),
            components: Affine {
                bias: (-weights.dot(&pca.mean)).mapv(f64::exported),
                weights: weights.mapv(f64::exported),
            },
            blocks: blocks(&points)?,
        })
    }

    /// Numbers in an embedding, all parts together.
    #[must_use]
    pub fn dims(&self) -> usize {
        self.blocks.iter().map(|block| block.root.nrows()).sum()
    }

    /// The contract of a model called `name` that was learnt of these samples.
    #[must_use]
    pub fn contract(&self, samples: &Samples, name: String) -> Contract {
        let components = self.components.weights.nrows();
        let how = format!("PCA ({components}) + view transformation");
        Contract {
            distance: Distance::View,
            view_input: Some(VIEW.into()),
            ..samples.contract_of_embeddings(name, &how)
        }
    }

    /// A model file: of templates and their viewpoints an embedding `[N, numbers, viewpoints]`, of which
    /// the probe's part is compared.
    ///
    /// # Guarantees
    /// Equal arguments give equal bytes.
    #[must_use]
    pub fn write(&self, name: &str) -> Vec<u8> {
        let mut file = OnnxFile::default();
        let input = add_input(&mut file, self.template, self.size);
        file.input(VIEW, &[2]);
        file.node("Flatten", &[input], "numbers");
        let transposed = self.components.weights.t();
        let (numbers, components) = transposed.dim();
        file.numbers("component_weights", &[numbers, components], transposed);
        file.numbers("component_bias", &[components], &self.components.bias);
        let gemm = ["numbers", "component_weights", "component_bias"];
        file.node("Gemm", &gemm, "components");

        let views = self.blocks.len();
        let kept = self.dims() / views;
        let angles: Vec<f32> = { self.viewpoints.iter().flatten() }
            .map(|&angle| angle as f32)
            .collect();
        file.numbers("viewpoints", &[views, 2], &angles);
        for (name, axis) in [("axis_1", 1), ("axis_2", 2)] {
            file.integers(name, &[axis]);
        }
        file.node("Unsqueeze", &[VIEW, "axis_1"], "view_alone");
        file.node("Sub", &["view_alone", "viewpoints"], "from_viewpoints");
        file.node("Mul", &["from_viewpoints", "from_viewpoints"], "squares");
        let keep = [("keepdims", Attribute::Integer(0))];
        file.node_with("ReduceSum", &["squares", "axis_2"], "far", &keep);
        let least = [
            ("axis", Attribute::Integer(1)),
            ("keepdims", Attribute::Integer(0)),
        ];
        file.node_with("ArgMin", &["far"], "viewpoint", &least);

        let stacked = |of: fn(&Block) -> &Array2<f64>, columns| {
            let mut all = Array3::zeros((views, kept, columns));
            for (mut at, block) in all.outer_iter_mut().zip(&self.blocks) {
                at.assign(&of(block).mapv(f64::exported));
            }
            all
        };
        let inverses = stacked(|block| &block.inverse, components);
        file.numbers("inverses", &[views, kept, components], &inverses);
        let first = [("axis", Attribute::Integer(0))];
        file.node_with("Gather", &["inverses", "viewpoint"], "inverse", &first);
        file.node("Unsqueeze", &["components", "axis_2"], "column");
        file.node("MatMul", &["inverse", "column"], "person");
        file.node("Unsqueeze", &["person", "axis_1"], "person_alone");
        let roots = stacked(|block| &block.root, kept);
        file.numbers("roots", &[views, kept, kept], &roots);
        file.node("MatMul", &["roots", "person_alone"], "from_each");
        file.integers("from_each_shape", &[0, views as i64, kept as i64]);
        file.node("Reshape", &["from_each", "from_each_shape"], "by_viewpoint");
        let order = [("perm", Attribute::Integers(&[0, 2, 1]))];
        file.node_with("Transpose", &["by_viewpoint"], EMBEDDING, &order);
        file.output(EMBEDDING, &[kept, views]);
        file.bytes(name, &[])
    }
}

/// The mean of each person's samples from a viewpoint, one a row.
fn of_people(samples: &Samples, view: usize) -> Result<Array2<f64>> {
    let own: Vec<usize> = (0..samples.labels.len())
        .filter(|&at| samples.views[at] == Some(view))
        .collect();
    let labels: Vec<usize> = own.iter().map(|&at| samples.labels[at]).collect();
    let people = 0..samples.names.len();
    if let Some(missing) = { people }.find(|person| !labels.contains(person)) {
        let [azimuth, elevation] = samples.training.viewpoints[view];
        return Err(TrainError::ViewMissing {
            person: samples.names[missing].clone(),
            view: format!("azimuth {azimuth}, elevation {elevation}"),
        }
        .into());
    }
    let seen = samples.numbers.select(Axis(0), &own);
    let of = Classes::<f64>::averaged(seen.view(), &labels, samples.names.len())?;
    Ok(of.means)
}

/// What is known of each viewpoint, of what people look like there, one a column.
///
/// # Errors
/// If nobody looks like anything.
fn blocks(people: &[Array2<f64>]) -> Result<Vec<Block>> {
    let count = people.first().map_or(0, Array2::ncols);
    // U S is the matrix times V, whose columns are the eigenvectors of the products of its columns.
    let mut products = Array2::zeros((count, count));
    for of_view in people {
        add_products_of_columns(of_view.view(), &mut products);
    }
    let found = eigen(&products)?;
    let floor = f64::TOLERANCE * found.values.first().copied().unwrap_or_default();
    let is_direction = |value: &&f64| **value > floor;
    let rank = found.values.iter().take_while(is_direction).count();
    if rank == 0 {
        return Err(TrainError::Constant.into());
    }
    let vectors = found.vectors.slice(s![..rank, ..]);
    let block = |of_view: &Array2<f64>| block(multiply(of_view.view(), vectors.t()));
    people.iter().map(block).collect()
}

/// What is known of a viewpoint with this `P`.
fn block(projection: Array2<f64>) -> Result<Block> {
    let rank = projection.ncols();
    let mut products = Array2::zeros((rank, rank));
    add_products_of_columns(projection.view(), &mut products);
    let found = eigen(&products)?;
    let floor = f64::TOLERANCE * found.values.first().copied().unwrap_or_default();
    let lengths: Array1<f64> = { found.values.iter() }
        .map(|&value| if value > floor { value.sqrt() } else { 0.0 })
        .collect();
    let scaled = |of: fn(f64) -> f64| {
        let mut rows = found.vectors.clone();
        for (mut row, &length) in rows.outer_iter_mut().zip(&lengths) {
            row *= if length > 0.0 { of(length) } else { 0.0 };
        }
        rows
    };
    let inverse = multiply(
        found.vectors.t(),
        scaled(|length| 1.0 / (length * length)).view(),
    );
    Ok(Block {
        inverse: multiply(inverse.view(), projection.t()),
        root: scaled(|length| length),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::{Model, Runtime, Training};
    use crate::train::testing::noise;
    use ndarray::{ArrayView1, array};

    /// A template's coordinates brought from one viewpoint to another by the blocks' `P_i P_j^+`, of
    /// which the root gives only lengths: the difference of two is what can be compared.
    fn transformed(
        people: &[Array2<f64>],
        (from, to): (usize, usize),
        x: &Array1<f64>,
    ) -> Array1<f64> {
        let blocks = blocks(people).expect("people");
        // What people have in common with themselves: least squares over the people of `to`.
        let person = blocks[from].inverse.dot(x);
        let roots: Vec<Array1<f64>> = (0..people[to].ncols())
            .map(|at| {
                let own = blocks[to].inverse.dot(&people[to].column(at));
                blocks[to].root.dot(&(own - &person))
            })
            .collect();
        roots
            .iter()
            .map(|difference| difference.dot(difference).sqrt())
            .collect()
    }

    #[test]
    fn the_worked_example_comes_out() {
        // Two people, (1, 0) and (0, 1) from the first viewpoint, (2, 0) and (1, 1) from the second: (3, 4) becomes
        // 3 (2, 0) + 4 (1, 1) = (10, 4), which is (8, 4) and (9, 3) away from them.
        let people = [
            array![[1.0, 0.0], [0.0, 1.0]],
            array![[2.0, 1.0], [0.0, 1.0]],
        ];
        let found = transformed(&people, (0, 1), &array![3.0, 4.0]);
        for (found, expected) in found.iter().zip([80.0_f64.sqrt(), 90.0_f64.sqrt()]) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn more_people_than_numbers_are_decomposed_as_numpy_does() {
        // Three numbers of five people from two viewpoints; numpy.linalg.svd and pinv(rcond=1e-5) of
        // the same numbers.
        let both = noise(6, 5, 11);
        let people = [
            both.slice(s![..3, ..]).to_owned(),
            both.slice(s![3.., ..]).to_owned(),
        ];
        let found = transformed(&people, (0, 1), &array![0.5, -0.25, 1.0]);
        for (found, expected) in found.iter().zip(NUMPY) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }

    const NUMPY: [f64; 5] = [
        2.176571051811704,
        1.5503741816941923,
        1.2769172717247446,
        0.6758277718305609,
        1.5642677344881855,
    ];

    /// Three people from two viewpoints, twice each: from the second one they are mirrored and half
    /// as large.
    fn samples() -> Samples {
        let (own, grain) = (noise(3, 1500, 5), noise(12, 1500, 6));
        let numbers = Array2::from_shape_fn((12, 1500), |(at, pixel)| {
            let (person, view) = (at / 4, at % 2);
            let seen = match view {
                0 => own[[person, pixel]],
                _ => 0.5 * own[[person, 1499 - pixel]],
            };
            (0.5 + 0.2 * seen + 0.01 * grain[[at, pixel]]) as f32
        });
        Samples {
            numbers,
            template: Template::Gei,
            size: Size::S50x30,
            framing: None,
            labels: (0..12).map(|at| at / 4).collect(),
            views: (0..12).map(|at| Some(at % 2)).collect(),
            names: ["ann", "bob", "cy"].map(str::to_owned).to_vec(),
            found: 12,
            training: Training {
                viewpoints: vec![[90.0, 0.0], [0.0, 10.0]],
                ..Training::default()
            },
        }
    }

    #[test]
    fn the_model_file_brings_people_to_the_probes_viewpoint() {
        let samples = samples();
        let fitted = ViewTransformation::fit(&samples, Components::Count(100)).expect("people");
        let contract = fitted.contract(&samples, "views".into());
        let bytes = fitted.write("views");
        assert_eq!(bytes, fitted.write("views"));
        let model = Model::from_bytes("views.onnx", bytes, contract.clone()).expect("a model");
        let recognizer = Runtime::rten().load(&model).expect("rten");
        let mut input = Vec::new();
        for at in 0..12 {
            input.extend(samples.numbers.row(at));
            let [azimuth, elevation] = samples.training.viewpoints[at % 2];
            contract
                .feed_view(Some((azimuth, elevation)), &mut input)
                .expect("a known one");
        }
        let outputs = recognizer.run(&input, 12).expect("an answer");
        assert_eq!(
            (outputs.embedding_dims, outputs.embedding_parts),
            (fitted.dims(), 2)
        );
        // By the definition: components, the viewpoint's inverse, each viewpoint's root.
        for (at, found) in outputs.embedding.chunks(fitted.dims()).enumerate() {
            let numbers = samples.numbers.row(at).mapv(f64::from);
            let person = fitted.blocks[at % 2]
                .inverse
                .dot(&fitted.components.apply_f64(numbers.view()));
            for (view, block) in fitted.blocks.iter().enumerate() {
                let expected = block.root.dot(&person);
                let part = found.iter().skip(view).step_by(2);
                for (found, expected) in part.zip(&expected) {
                    let difference = (f64::from(*found) - expected).abs();
                    assert!(difference < 1e-3, "{found} {expected}");
                }
            }
        }
        // From the other viewpoint each is nearest to himself, in the probe's part.
        let of =
            |at: usize| ArrayView1::from(&outputs.embedding[at * fitted.dims()..][..fitted.dims()]);
        for probe in [1, 5, 9] {
            let view = contract.view_number(Some((0.0, 10.0)));
            let gallery: Vec<_> = [0, 4, 8].map(|at| of(at).to_vec()).into();
            let gallery: Vec<&[f32]> = gallery.iter().map(Vec::as_slice).collect();
            let probe_embedding = of(probe).to_vec();
            let found = contract.distance.over_gallery(
                (&probe_embedding, view),
                &gallery,
                &|entry| entry,
                2,
            );
            let nearest = (0..3).min_by(|&a, &b| found[a].total_cmp(&found[b]));
            assert_eq!(nearest, Some(probe / 4), "{found:?}");
        }
        // Without the viewpoint, and from one that it has not been trained on.
        let mut ignored = Vec::new();
        let said = contract.feed_view(None, &mut ignored).expect_err("unknown");
        assert!(
            said.to_string()
                .starts_with("views takes the viewpoint of each input")
        );
        let said = contract
            .feed_view(Some((45.0, 0.0)), &mut ignored)
            .expect_err("untrained");
        assert_eq!(
            said.to_string(),
            "views has not been trained on viewpoint 45,0: expected one of 90,0 0,10 (azimuth,elevation)"
        );
    }

    #[test]
    fn a_contract_and_a_file_have_to_agree_about_the_viewpoint() {
        let samples = samples();
        let fitted = ViewTransformation::fit(&samples, Components::Count(5)).expect("people");
        let refused = |contract: Contract| {
            let refused = Model::from_bytes("m.onnx", fitted.write("m"), contract);
            refused.expect_err("no agreement").to_string()
        };
        let right = fitted.contract(&samples, "m".into());
        let input = "f32 [N, 1, 50, 30]";
        let both = "\"gei\" f32 [N, 1, 50, 30], \"view\" f32 [N, 2]";
        for (view_input, distance, said) in [
            (
                None,
                Distance::Euclidean,
                format!(
                    "m.onnx: expected one input of {input}, found {both} (export a graph that takes pictures alone; one that takes viewpoints, too, names that input in its .toml: view_input = \"NAME\")"
                ),
            ),
            (
                Some("seen"),
                Distance::View,
                format!(
                    "m.onnx: expected an input \"seen\" of viewpoints as the contract says, found {both}"
                ),
            ),
            (
                Some("gei"),
                Distance::View,
                "m.onnx: expected the viewpoints as f32 [N, 2], found \"gei\" f32 [N, 1, 50, 30]"
                    .to_owned(),
            ),
        ] {
            let contract = Contract {
                view_input: view_input.map(str::to_owned),
                distance,
                ..right.clone()
            };
            assert_eq!(refused(contract), said);
        }
        let without = Contract {
            view_input: None,
            ..right.clone()
        };
        let said = without
            .check(std::path::Path::new("m.toml"))
            .expect_err("no input");
        assert_eq!(
            said.to_string(),
            "m.toml: distance: \"view\" compares the part of the probe's viewpoint: expected view_input and training.viewpoints, in the order of the parts"
        );
        // A part for each viewpoint of training.
        let mut fewer = right.clone();
        fewer.training.viewpoints.pop();
        let model = Model::from_bytes("m.onnx", fitted.write("m"), fewer).expect("a model");
        let recognizer = Runtime::rten().load(&model).expect("rten");
        let mut input = samples.numbers.row(0).to_vec();
        input.extend([90.0, 0.0]);
        let said = recognizer
            .run(&input, 1)
            .expect_err("two parts")
            .to_string();
        assert!(
            said.contains("a part for each of training.viewpoints"),
            "{said}"
        );
        // What is summed: 5 components, 2 or 3 numbers of a person from there, and from 2 viewpoints.
        let rank = (fitted.dims() / 2) as u64;
        let model = Model::from_bytes("m.onnx", fitted.write("m"), right).expect("a model");
        let macs = model.graph().macs(&[3, 1, 50, 30]);
        let components = fitted.components.weights.nrows() as u64;
        assert_eq!(
            macs,
            Ok(3 * (1500 * components + components * rank + 2 * rank * rank))
        );
    }

    #[test]
    fn what_cannot_be_learnt_is_refused() {
        let refused = |samples: &Samples| {
            let refused = ViewTransformation::fit(samples, Components::Count(100));
            refused.err().expect("a refusal").to_string()
        };
        let mut missing = samples();
        for view in missing.views.iter_mut().skip(4).take(4) {
            *view = Some(0);
        }
        assert_eq!(
            refused(&missing),
            "view transformation needs each person from each viewpoint, and bob is not seen from azimuth 0, elevation 10"
        );
        let mut one = samples();
        one.training.viewpoints.truncate(1);
        assert_eq!(
            refused(&one),
            "view transformation needs at least 2 viewpoints whose angles are known, found 1"
        );
        let constant = Samples {
            numbers: Array2::ones((12, 1500)),
            ..samples()
        };
        assert_eq!(
            refused(&constant),
            "all samples have the same features: there is nothing to learn from"
        );
        let alone = Samples {
            labels: vec![0; 12],
            names: vec!["ann".into()],
            ..samples()
        };
        assert!(refused(&alone).contains("at least 2"));
    }
}
