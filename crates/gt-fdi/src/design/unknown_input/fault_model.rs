//! A model with disturbances and faults that are unknown but for where they enter.

use gt_core::{DimensionError, Signal, StateSpace};
use nalgebra::DMatrix;

use super::super::noise::check_finite;
use crate::FdiError;

/// Where signals of which nothing is known enter a model: `E (nx x n)` into the next state, `F
/// (ny x n)` into the output.
#[derive(Debug, Clone, PartialEq)]
pub struct UnknownInput {
    /// `E (nx x n)`: states a unit of the signal.
    pub state: DMatrix<f64>,
    /// `F (ny x n)`: outputs a unit of the signal.
    pub output: DMatrix<f64>,
}

impl UnknownInput {
    /// Signals that enter the state only, for a model with `ny` outputs.
    pub fn of_state(state: DMatrix<f64>, ny: usize) -> Self {
        let output = DMatrix::zeros(ny, state.ncols());
        Self { state, output }
    }

    /// Signals that enter the outputs only, for a model with `nx` states.
    pub fn of_output(nx: usize, output: DMatrix<f64>) -> Self {
        let state = DMatrix::zeros(nx, output.ncols());
        Self { state, output }
    }

    /// Number of signals.
    pub fn count(&self) -> usize {
        self.state.ncols()
    }

    /// `[E; F] ((nx + ny) x n)`.
    pub(super) fn joint(&self) -> DMatrix<f64> {
        let (nx, ny) = (self.state.nrows(), self.output.nrows());
        let mut joint = DMatrix::zeros(nx + ny, self.count());
        joint.rows_mut(0, nx).copy_from(&self.state);
        joint.rows_mut(nx, ny).copy_from(&self.output);
        joint
    }
}

/// `x(t+1) = A x + B u + E_d d + E_f f`, `y(t) = C x + D u + F_d d + F_f f` with unknown
/// disturbances `d` and faults `f` (S. X. Ding, *Model-based fault diagnosis techniques*, 2nd
/// edition, Springer 2013).
///
/// Construction checks that the sizes agree and the entries are finite.
#[derive(Debug, Clone, PartialEq)]
pub struct FaultModel {
    model: StateSpace,
    disturbance: UnknownInput,
    fault: UnknownInput,
}

impl FaultModel {
    /// A checked model.
    ///
    /// # Errors
    /// [`FdiError::Dimension`] for sizes that disagree; [`crate::design::FilterError::NotFinite`].
    pub fn new(
        model: StateSpace,
        disturbance: UnknownInput,
        fault: UnknownInput,
    ) -> Result<Self, FdiError> {
        let names = [["E_d", "F_d"], ["E_f", "F_f"]];
        for (input, [state, output]) in [&disturbance, &fault].into_iter().zip(names) {
            let rows = |name: &str| format!("rows of {name}");
            DimensionError::check(&rows(state), model.nx(), input.state.nrows())?;
            DimensionError::check(&rows(output), model.ny(), input.output.nrows())?;
            let columns = format!("columns of {output}");
            DimensionError::check(&columns, input.state.ncols(), input.output.ncols())?;
            check_finite(state, &input.state)?;
            check_finite(output, &input.output)?;
        }
        Ok(Self {
            model,
            disturbance,
            fault,
        })
    }

    /// The model from `u` to `y`.
    pub fn model(&self) -> &StateSpace {
        &self.model
    }

    /// `E_d (nx x nd)` and `F_d (ny x nd)`.
    pub fn disturbance(&self) -> &UnknownInput {
        &self.disturbance
    }

    /// `E_f (nx x nf)` and `F_f (ny x nf)`.
    pub fn fault(&self) -> &UnknownInput {
        &self.fault
    }
}

/// Signals called `prefix0`, `prefix1`, ..., without units.
pub(super) fn numbered(prefix: &str, count: usize) -> Vec<Signal> {
    (0..count)
        .map(|index| Signal::new(format!("{prefix}{index}"), ""))
        .collect()
}
