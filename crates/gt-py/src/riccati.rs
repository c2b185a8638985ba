//! `riccati` and `Riccati`: the discrete algebraic Riccati equation of a steady filter.

use gtfdi::fdi::Riccati;
use nalgebra::DMatrix;
use numpy::PyArray2;
use pyo3::prelude::*;

use crate::array::{matrix, matrix_out};
use crate::error::Failure;
use crate::pickle::{Pickled, Reduced, reduce};

/// The stabilising solution of a discrete algebraic Riccati equation; ``gtfdi.riccati`` makes one.
#[pyclass(frozen, eq, name = "Riccati", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyRiccati {
    inner: Riccati,
}

#[pymethods]
impl PyRiccati {
    /// The solution, a symmetric array (nx, nx).
    #[getter(P)]
    fn p<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, &self.inner.p)
    }

    /// What the two sides of the equation are apart, relative to the largest of their terms.
    #[getter]
    fn relative_residual(&self) -> f64 {
        self.inner.relative_residual
    }

    /// Largest modulus of the eigenvalues of ``A - K C``.
    #[getter]
    fn spectral_radius(&self) -> f64 {
        self.inner.spectral_radius
    }

    /// Doublings spent.
    #[getter]
    fn iterations(&self) -> usize {
        self.inner.iterations
    }

    fn __repr__(&self) -> String {
        format!(
            "Riccati({} states, spectral radius {:?}, relative residual {:e})",
            self.inner.p.nrows(),
            self.inner.spectral_radius,
            self.inner.relative_residual
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

impl Pickled for PyRiccati {
    type Stored = (DMatrix<f64>, f64, f64, usize);

    fn stored(&self) -> Result<Self::Stored, Failure> {
        let own = &self.inner;
        let (residual, radius) = (own.relative_residual, own.spectral_radius);
        Ok((own.p.clone(), residual, radius, own.iterations))
    }

    fn restored(
        (p, relative_residual, spectral_radius, iterations): Self::Stored,
    ) -> Result<Self, Failure> {
        let inner = Riccati {
            p,
            relative_residual,
            spectral_radius,
            iterations,
        };
        Ok(Self { inner })
    }
}

/// Solves ``P = A P A' - (A P C' + S)(C P C' + R)^-1 (A P C' + S)' + Q`` for the P that stabilises
/// ``A - K C``, by structured doubling and Newton's steps.
///
/// The equation of a regulator is that of ``A.T`` and ``B.T``.
///
/// Parameters
/// ----------
/// A, C, Q, R : array_like, shapes (nx, nx), (ny, nx), (nx, nx), (ny, ny)
///     The model and the covariances of the noise of its states and outputs, symmetric; R may be
///     singular.
/// S : array_like, shape (nx, ny), optional
///     The covariance between the two; zero where left out.
///
/// Returns
/// -------
/// Riccati
///
/// Raises
/// ------
/// DimensionError
///     Sizes disagree.
/// DesignError
///     An entry is not finite, a covariance is not symmetric, or there is no stabilising solution.
///
/// Examples
/// --------
/// >>> solution = gtfdi.riccati([[1.0]], [[1.0]], [[1.0]], [[1.0]])
/// >>> bool(abs(solution.P[0, 0] - (1 + 5**0.5) / 2) < 1e-14)  # P^2 = P + 1
/// True
#[pyfunction]
#[pyo3(signature = (A, C, Q, R, S=None))]
#[allow(non_snake_case)] // the field's notation
pub fn riccati(
    A: &Bound<'_, PyAny>,
    C: &Bound<'_, PyAny>,
    Q: &Bound<'_, PyAny>,
    R: &Bound<'_, PyAny>,
    S: Option<&Bound<'_, PyAny>>,
) -> Result<PyRiccati, Failure> {
    let (a, c, q, r) = (
        matrix(A, "A")?,
        matrix(C, "C")?,
        matrix(Q, "Q")?,
        matrix(R, "R")?,
    );
    let s = match S {
        Some(s) => matrix(s, "S")?,
        None => DMatrix::zeros(a.nrows(), c.nrows()),
    };
    let inner = Riccati::solve(&a, &c, &q, &r, &s)?;
    Ok(PyRiccati { inner })
}
