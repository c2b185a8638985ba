//! `place`: an observer's gain by the poles that it is to have.

use gtfdi::fdi::SchurPlacement;
use numpy::PyArray2;
use pyo3::prelude::*;

use crate::array::matrix_out;
use crate::error::Failure;
use crate::poles::Poles;
use crate::state_space::PyStateSpace;

/// The gain K (nx, ny) that gives ``A - K C`` of a model the poles asked for, also with several
/// outputs.
///
/// With several outputs the poles do not determine the gain; of all gains the one of Varga's Schur
/// method is taken (IEEE Transactions on Automatic Control 26, 1981): one pole or pair after the
/// other, each by the feedback of least norm.
///
/// Parameters
/// ----------
/// model : StateSpace
///     The model.
/// poles : float, or list of float or complex
///     One pole for all states, or one a state, inside the unit circle; complex ones together with
///     their conjugates.
/// radius : float, default 0
///     Eigenvalues of A with a modulus below it stay as they are; the first poles of the list are
///     then given to the others.
///
/// Returns
/// -------
/// ndarray, shape (nx, ny)
///
/// Raises
/// ------
/// DesignError
///     A pole is outside the unit circle or without its conjugate, there are too few, or the
///     outputs do not reach a state that is to be moved.
///
/// Examples
/// --------
/// >>> model = gtfdi.StateSpace(
/// ...     [[1.1, 0.2], [0.0, 0.9]], [[1.0], [1.0]], np.eye(2), np.zeros((2, 1)), 0.1
/// ... )
/// >>> gain = gtfdi.place(model, [0.3, 0.5])
/// >>> np.sort(np.linalg.eigvals(model.A - gain @ model.C)).round(9)
/// array([0.3, 0.5])
#[pyfunction]
#[pyo3(signature = (model, poles, radius=0.0))]
pub fn place<'py>(
    py: Python<'py>,
    model: &PyStateSpace,
    poles: Poles,
    radius: f64,
) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
    let poles = poles.of(model.inner.nx());
    let placement = SchurPlacement::observer(&model.inner, radius, &poles)?;
    Ok(matrix_out(py, &placement.gain)?)
}
