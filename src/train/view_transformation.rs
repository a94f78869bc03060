//! View transformation: Makihara, Sagawa, Mukaigawa, Echigo & Yagi 2006, "Gait recognition using a
//! view transformation model in the frequency domain", ECCV.
//!
//! The templates of all people from all viewpoints are one matrix: a block of rows for each
//! viewpoint, a column for each person. Its singular value decomposition `U S V^T` gives each
//! viewpoint `j` a block `P_j` of `U S`, so that the template of a person `v` is `P_j v`. A
//! template `x` from viewpoint `j` is transformed to viewpoint `i` as `P_i P_j^+ x`.
//!
//! The publication transforms the gallery to the probe's viewpoint and compares it there. The
//! component of a probe outside the span of that viewpoint's people is equally far from all of the
//! gallery. The rest has the distance `|R_i (v - w)|` with `R_i^T R_i = P_i^T P_i`, for `v` of the
//! probe and `w` of the gallery. So an embedding has a part `R_i v` for each viewpoint `i`, and the
//! part of the probe's viewpoint is compared ([`crate::inference::Distance::View`]). The outside
//! component is left out of the distance. This changes no rank, but makes distances of different
//! probes less comparable. For a probe and a gallery from the same viewpoint, the publication
//! compares the templates themselves; here only their components within that span are compared.
//!
//! Two details differ from the publication. Templates are measured from the mean of all people and
//! viewpoints, along the principal components of people's means, which makes a model small.
//! Directions with less than 1e-10 of the first one's variance are left out.

use super::lda::Classes;
use super::linear_algebra::{Real, add_products_of_columns, eigen, multiply};
use super::onnx::add_input;
use super::onnx_file::{NodeAttribute, OnnxFile};
use super::pca::Pca;
use super::{Components, Samples};
use crate::draw::template::Template;
use crate::error::{Result, TrainError};
use crate::inference::{Affine, Contract, Distance, EMBEDDING, SAME_VIEW_DEG};
use edgegait_core::silhouette::Size;
use ndarray::{Array1, Array2, Array3, Axis, s};

/// The name of the input that takes each template's azimuth and elevation, degrees.
pub const VIEW: &str = "view";

/// A view transformation: it maps templates of people from one viewpoint to another.
pub struct ViewTransformation {
    template: Template,
    size: Size,
    viewpoints: Vec<[f64; 2]>,
    /// The map from a template to its principal components.
    components: Affine,
    blocks: Vec<ViewpointModel>,
}

/// The maps of one viewpoint.
struct ViewpointModel {
    /// `P^+`: from principal components to a person's `v`.
    inverse: Array2<f64>,
    /// `R`: from `v` to an embedding in which distances are those of this viewpoint.
    root: Array2<f64>,
}

impl ViewTransformation {
    /// Learns from templates of people, each person from each viewpoint.
    ///
    /// # Errors
    /// For fewer than two viewpoints or people, a person who is not seen from one of the
    /// viewpoints, and samples that are all the same.
    pub fn fit(samples: &Samples, components: Components) -> Result<Self> {
        let viewpoints = &samples.training.viewpoints;
        if viewpoints.len() < 2 {
            return Err(TrainError::TooFewViews(viewpoints.len()).into());
        }
        for (at, one) in viewpoints.iter().enumerate() {
            if let Some(other) = viewpoints[..at].iter().find(|other| is_same(one, other)) {
                return Err(TrainError::SameViews(format!("{other:?} and {one:?}")).into());
            }
        }
        let unknown = samples.views.iter().filter(|view| view.is_none()).count();
        if unknown > 0 {
            return Err(TrainError::UnknownViews(unknown).into());
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

    /// Returns the length of an embedding, all parts together.
    #[must_use]
    pub fn dims(&self) -> usize {
        self.blocks.iter().map(|block| block.root.nrows()).sum()
    }

    /// Returns the contract of a model called `name` that was learnt from these samples.
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

    /// Returns a model file. From templates and their viewpoints it computes an embedding
    /// `[N, numbers, viewpoints]`, of which the part of the probe's viewpoint is compared. It takes
    /// any viewpoint as the nearest one of its training, so its caller has to reject others
    /// ([`Contract::feed_view`]).
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
        let keep = [("keepdims", NodeAttribute::Integer(0))];
        file.node_with("ReduceSum", &["squares", "axis_2"], "far", &keep);
        let least = [
            ("axis", NodeAttribute::Integer(1)),
            ("keepdims", NodeAttribute::Integer(0)),
        ];
        file.node_with("ArgMin", &["far"], "viewpoint", &least);

        let stacked = |of: fn(&ViewpointModel) -> &Array2<f64>, columns| {
            let mut all = Array3::zeros((views, kept, columns));
            for (mut at, block) in all.outer_iter_mut().zip(&self.blocks) {
                at.assign(&of(block).mapv(f64::exported));
            }
            all
        };
        let inverses = stacked(|block| &block.inverse, components);
        file.numbers("inverses", &[views, kept, components], &inverses);
        let first = [("axis", NodeAttribute::Integer(0))];
        file.node_with("Gather", &["inverses", "viewpoint"], "inverse", &first);
        file.node("Unsqueeze", &["components", "axis_2"], "column");
        file.node("MatMul", &["inverse", "column"], "person");
        file.node("Unsqueeze", &["person", "axis_1"], "person_alone");
        let roots = stacked(|block| &block.root, kept);
        file.numbers("roots", &[views, kept, kept], &roots);
        file.node("MatMul", &["roots", "person_alone"], "from_each");
        file.integers("from_each_shape", &[0, views as i64, kept as i64]);
        file.node("Reshape", &["from_each", "from_each_shape"], "by_viewpoint");
        let order = [("perm", NodeAttribute::Integers(&[0, 2, 1]))];
        file.node_with("Transpose", &["by_viewpoint"], EMBEDDING, &order);
        file.output(EMBEDDING, &[kept, views]);
        file.bytes(name, &[])
    }
}

/// Returns whether two viewpoints are the same, apart from whole turns.
fn is_same(one: &[f64; 2], other: &[f64; 2]) -> bool {
    let turn = (one[0] - other[0]).rem_euclid(360.0);
    turn.min(360.0 - turn) < SAME_VIEW_DEG && (one[1] - other[1]).abs() < SAME_VIEW_DEG
}

/// Returns the mean of each person's samples from a viewpoint, one a row.
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

/// Computes the maps of each viewpoint from the people's templates there, one a column.
///
/// # Errors
/// If all templates are the same.
fn blocks(people: &[Array2<f64>]) -> Result<Vec<ViewpointModel>> {
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

/// Computes the maps of a viewpoint with this `P`.
fn block(projection: Array2<f64>) -> Result<ViewpointModel> {
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
    Ok(ViewpointModel {
        inverse: multiply(inverse.view(), projection.t()),
        root: scaled(|length| length),
    })
}

#[cfg(test)]
mod tests;
