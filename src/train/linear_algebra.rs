//! Dense linear algebra on row-major `ndarray` matrices: the only file that names `faer`.
//!
//! Every call asks for [`Par::Seq`], so a result depends on the machine's
//! instruction set but never on its number of threads.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{
    LltRegularization, cholesky_in_place, cholesky_in_place_scratch,
};
use faer::linalg::cholesky::llt::solve::{solve_in_place, solve_in_place_scratch};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Mat, MatMut, MatRef, Par, Spec};
use ndarray::{Array1, Array2, ArrayView2, NdFloat};

use crate::error::{Result, TrainError};

/// The numbers that a fit computes in: `f64`, or `f32` to test whether that suffices.
pub trait Real: NdFloat + faer::traits::RealField + From<f32> + Into<f64> {
    /// The share of the largest value below which values count as zero.
    ///
    /// Our choice. In f64: 8-bit quantisation alone leaves more variance than this in any pixel
    /// that changes (1e-7 of a GEI's largest), and above it directions found through the Gram
    /// matrix are orthogonal to about 1e-5. In f32: some 10 units of rounding.
    const TOLERANCE: Self;

    /// The share of its objective within which an iteration has converged. Our choice: weights are
    /// then right to about 5 digits in f64, and to 2 in f32, where rounding allows no more.
    const GAP: f64;

    /// Returns the nearest number to `value`.
    fn nearest(value: f64) -> Self;

    /// Returns the nearest number in the precision that is exported.
    fn exported(self) -> f32;
}

impl Real for f64 {
    const TOLERANCE: Self = 1e-10;
    const GAP: f64 = 1e-10;

    fn nearest(value: f64) -> Self {
        value
    }

    fn exported(self) -> f32 {
        self as f32
    }
}

impl Real for f32 {
    const TOLERANCE: Self = 1e-6;
    const GAP: f64 = 1e-4;

    fn nearest(value: f64) -> Self {
        value as Self
    }

    fn exported(self) -> f32 {
        self
    }
}

/// Eigenvalues, largest first, and the unit eigenvectors that belong to them.
pub(crate) struct Eigen<F> {
    /// The eigenvalues, largest first.
    pub values: Vec<F>,
    /// One eigenvector a row, in the order of `values`.
    pub vectors: Array2<F>,
}

/// Computes the matrix product `a b`.
pub(crate) fn multiply<F: Real>(a: ArrayView2<'_, F>, b: ArrayView2<'_, F>) -> Array2<F> {
    assert_eq!(a.ncols(), b.nrows(), "inner dimensions of a product agree");
    let (a, b) = (a.as_standard_layout(), b.as_standard_layout());
    let mut product = Array2::zeros((a.nrows(), b.ncols()));
    matmul(
        view_mut(&mut product),
        Accum::Replace,
        view(&a.view()),
        view(&b.view()),
        F::one(),
        Par::Seq,
    );
    product
}

/// Adds `a^T a` to the lower triangle of `sum`; the upper one is left alone.
pub(crate) fn add_products_of_columns<F: Real>(a: ArrayView2<'_, F>, sum: &mut Array2<F>) {
    assert_eq!(
        sum.dim(),
        (a.ncols(), a.ncols()),
        "one row and column of the sum per column"
    );
    let a = a.as_standard_layout();
    let a = a.view();
    let a = view(&a);
    triangular::matmul(
        view_mut(sum),
        BlockStructure::TriangularLower,
        Accum::Add,
        a.transpose(),
        BlockStructure::Rectangular,
        a,
        BlockStructure::Rectangular,
        F::one(),
        Par::Seq,
    );
}

/// Computes the eigenvalues and eigenvectors of a symmetric matrix, of which only the lower
/// triangle is read.
///
/// # Errors
/// If the matrix is not finite, or the iteration does not converge.
pub(crate) fn eigen<F: Real>(symmetric: &Array2<F>) -> Result<Eigen<F>> {
    let n = symmetric.nrows();
    assert_eq!(n, symmetric.ncols(), "a symmetric matrix is square");
    if n == 0 {
        return Ok(Eigen {
            values: Vec::new(),
            vectors: Array2::zeros((0, 0)),
        });
    }
    let mut diagonal = faer::diag::Diag::<F>::zeros(n);
    let mut columns = Mat::<F>::zeros(n, n);
    let scratch =
        self_adjoint_evd_scratch::<F>(n, ComputeEigenvectors::Yes, Par::Seq, Spec::default());
    self_adjoint_evd(
        view(&symmetric.view()),
        diagonal.as_mut(),
        Some(columns.as_mut()),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(scratch)),
        Spec::default(),
    )
    .map_err(|_| TrainError::NoEigenvalues(n))?;
    let values: Vec<F> = (0..n).rev().map(|i| diagonal.column_vector()[i]).collect();
    if values.iter().any(|value| !value.is_finite()) {
        return Err(TrainError::NoEigenvalues(n).into());
    }
    let vectors = Array2::from_shape_fn((n, n), |(row, i)| columns[(i, n - 1 - row)]);
    Ok(Eigen { values, vectors })
}

/// Solves `a x = b` for a symmetric positive definite `a`, of which only the lower triangle is
/// read. Returns `None` if rounding leaves it not positive definite.
pub(super) fn solve_positive<F: Real>(a: &Array2<F>, mut b: Array1<F>) -> Option<Array1<F>> {
    let n = a.nrows();
    let mut factor = view(&a.view()).to_owned();
    let scratch = cholesky_in_place_scratch::<F>(n, Par::Seq, Spec::default());
    cholesky_in_place(
        factor.as_mut(),
        LltRegularization::default(),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(scratch)),
        Spec::default(),
    )
    .ok()?;
    let slice = b.as_slice_mut()?;
    let column = MatMut::from_column_major_slice_mut(slice, n, 1);
    let scratch = solve_in_place_scratch::<F>(n, 1, Par::Seq);
    let stack = &mut MemBuffer::new(scratch);
    solve_in_place(factor.as_ref(), column, Par::Seq, MemStack::new(stack));
    b.iter().all(|v| v.is_finite()).then_some(b)
}

/// Returns `value` if it is finite; `row` and `column` are its place, for the error.
pub(super) fn finite<F: Real>(value: F, row: usize, column: usize) -> Result<F> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(TrainError::NotFinite { row, column }.into())
}

/// Turns a direction so that its largest component by magnitude is positive.
///
/// Components within one part in 10^9 (10^5 in f32) of the largest count as ties, and the first of
/// them decides: rounding cannot flip the sign of `(0.7071, -0.7071)`.
pub(crate) fn fix_sign<F: Real>(mut direction: ndarray::ArrayViewMut1<'_, F>) {
    let largest = direction.iter().fold(F::zero(), |m, c| m.max(c.abs()));
    let tie = F::TOLERANCE * F::nearest(10.0);
    let leading = direction
        .iter()
        .copied()
        .find(|c| c.abs() >= largest * (F::one() - tie))
        .unwrap_or_else(F::zero);
    if leading < F::zero() {
        direction.mapv_inplace(|c| -c);
    }
}

fn view<'a, F: Real>(a: &'a ArrayView2<'_, F>) -> MatRef<'a, F> {
    let slice = a.as_slice().expect("rows lie one after another");
    MatRef::from_row_major_slice(slice, a.nrows(), a.ncols())
}

fn view_mut<F: Real>(a: &mut Array2<F>) -> MatMut<'_, F> {
    let (rows, columns) = a.dim();
    let slice = a.as_slice_mut().expect("rows lie one after another");
    MatMut::from_row_major_slice_mut(slice, rows, columns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    #[test]
    fn a_product_of_two_small_matrices_is_right() {
        let product = multiply(
            array![[1.0, 2.0], [3.0, 4.0]].view(),
            array![[5.0], [6.0]].view(),
        );
        assert_eq!(product, array![[17.0], [39.0]]);
    }

    #[test]
    fn a_transposed_view_multiplies_like_its_copy() {
        let a = array![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
        assert_eq!(
            multiply(a.t(), a.view()),
            array![[17.0, 22.0, 27.0], [22.0, 29.0, 36.0], [27.0, 36.0, 45.0]]
        );
    }

    #[test]
    fn products_of_columns_fill_the_lower_triangle_only() {
        let mut sum = Array2::zeros((2, 2));
        add_products_of_columns(array![[1.0, 2.0], [3.0, 4.0]].view(), &mut sum);
        assert_eq!(sum, array![[10.0, 0.0], [14.0, 20.0]]);
    }

    #[test]
    fn a_two_by_two_matrix_has_the_eigenvalues_3_and_1() {
        let eigen = eigen::<f64>(&array![[2.0, 0.0], [1.0, 2.0]]).expect("a finite matrix");
        assert!((eigen.values[0] - 3.0).abs() < 1e-14 && (eigen.values[1] - 1.0).abs() < 1e-14);
        assert!((eigen.vectors[[0, 0]].abs() - 0.5_f64.sqrt()).abs() < 1e-14);
    }

    #[test]
    fn a_positive_definite_system_is_solved_and_another_is_not() {
        // 2x + y = 4 and x + 2y = 5; the upper triangle is not read.
        let x = solve_positive::<f64>(&array![[2.0, 9.0], [1.0, 2.0]], array![4.0, 5.0])
            .expect("definite");
        assert!((x[0] - 1.0).abs() < 1e-14 && (x[1] - 2.0).abs() < 1e-14);
        assert!(solve_positive(&array![[1.0, 0.0], [2.0, 1.0]], array![1.0, 1.0]).is_none());
    }

    #[test]
    fn a_single_number_is_its_own_eigenvalue() {
        let eigen = eigen::<f64>(&array![[7.0]]).expect("a finite matrix");
        assert_eq!((eigen.values[0], eigen.vectors[[0, 0]].abs()), (7.0, 1.0));
    }

    #[test]
    fn a_matrix_that_is_not_finite_is_refused() {
        assert!(eigen(&array![[f64::NAN, 0.0], [0.0, 1.0]]).is_err());
    }
}
