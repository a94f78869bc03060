//! Dense linear algebra on row-major `ndarray` matrices: the only file that names `faer`.
//!
//! Every call asks for [`Par::Seq`], so a result depends on the machine's
//! instruction set but never on its number of threads.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Mat, MatMut, MatRef, Par, Spec};
use ndarray::{Array2, ArrayView2};

use crate::error::{Error, Result};

/// Eigenvalues, largest first, and the unit eigenvectors that belong to them.
pub(super) struct Eigen {
    /// Largest first.
    pub values: Vec<f64>,
    /// One eigenvector a row, in the order of `values`.
    pub vectors: Array2<f64>,
}

/// The matrix product `a b`.
pub(super) fn multiply(a: ArrayView2<'_, f64>, b: ArrayView2<'_, f64>) -> Array2<f64> {
    assert_eq!(a.ncols(), b.nrows(), "inner dimensions of a product agree");
    let (a, b) = (a.as_standard_layout(), b.as_standard_layout());
    let mut product = Array2::zeros((a.nrows(), b.ncols()));
    matmul(
        view_mut(&mut product),
        Accum::Replace,
        view(&a.view()),
        view(&b.view()),
        1.0,
        Par::Seq,
    );
    product
}

/// Adds `a^T a` to the lower triangle of `sum`; the upper one is left alone.
pub(super) fn add_products_of_columns(a: ArrayView2<'_, f64>, sum: &mut Array2<f64>) {
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
        1.0,
        Par::Seq,
    );
}

/// Eigenvalues and eigenvectors of a symmetric matrix, of which only the lower triangle is read.
///
/// # Errors
/// If the matrix is not finite, or the iteration does not converge.
pub(super) fn eigen(symmetric: &Array2<f64>) -> Result<Eigen> {
    let n = symmetric.nrows();
    assert_eq!(n, symmetric.ncols(), "a symmetric matrix is square");
    if n == 0 {
        return Ok(Eigen {
            values: Vec::new(),
            vectors: Array2::zeros((0, 0)),
        });
    }
    let mut diagonal = faer::diag::Diag::<f64>::zeros(n);
    let mut columns = Mat::<f64>::zeros(n, n);
    let scratch =
        self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, Spec::default());
    self_adjoint_evd(
        view(&symmetric.view()),
        diagonal.as_mut(),
        Some(columns.as_mut()),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(scratch)),
        Spec::default(),
    )
    .map_err(|_| Error::Failed(format!("no eigenvalues found for a {n} x {n} matrix")))?;
    let values: Vec<f64> = (0..n).rev().map(|i| diagonal.column_vector()[i]).collect();
    if values.iter().any(|value| !value.is_finite()) {
        return Err(Error::Failed(format!(
            "a {n} x {n} matrix has eigenvalues that are not finite numbers"
        )));
    }
    let vectors = Array2::from_shape_fn((n, n), |(row, i)| columns[(i, n - 1 - row)]);
    Ok(Eigen { values, vectors })
}

/// `value`, if it is a finite number; `row` and `column` say where it was found.
pub(super) fn finite(value: f64, row: usize, column: usize) -> Result<f64> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(Error::Failed(format!(
        "sample {row} has a value at {column} that is not a finite number"
    )))
}

/// Turns a direction so that its largest component by magnitude is positive.
///
/// Components within one part in 10^9 of the largest count as ties, of which
/// the first decides: rounding cannot flip the sign of `(0.7071, -0.7071)`.
pub(super) fn fix_sign(mut direction: ndarray::ArrayViewMut1<'_, f64>) {
    let largest = direction.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    let leading = direction
        .iter()
        .copied()
        .find(|c| c.abs() >= largest * (1.0 - 1e-9))
        .unwrap_or(0.0);
    if leading < 0.0 {
        direction.mapv_inplace(|c| -c);
    }
}

fn view<'a>(a: &'a ArrayView2<'_, f64>) -> MatRef<'a, f64> {
    let slice = a.as_slice().expect("rows lie one after another");
    MatRef::from_row_major_slice(slice, a.nrows(), a.ncols())
}

fn view_mut(a: &mut Array2<f64>) -> MatMut<'_, f64> {
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
        let eigen = eigen(&array![[2.0, 0.0], [1.0, 2.0]]).expect("a finite matrix");
        assert!((eigen.values[0] - 3.0).abs() < 1e-14 && (eigen.values[1] - 1.0).abs() < 1e-14);
        assert!((eigen.vectors[[0, 0]].abs() - 0.5_f64.sqrt()).abs() < 1e-14);
    }

    #[test]
    fn a_single_number_is_its_own_eigenvalue() {
        let eigen = eigen(&array![[7.0]]).expect("a finite matrix");
        assert_eq!((eigen.values[0], eigen.vectors[[0, 0]].abs()), (7.0, 1.0));
    }

    #[test]
    fn a_matrix_that_is_not_finite_is_refused() {
        assert!(eigen(&array![[f64::NAN, 0.0], [0.0, 1.0]]).is_err());
    }
}
