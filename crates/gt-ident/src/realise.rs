//! Between the canonical input-output form and the state space (eq. 13-21).

use gt_core::{OperatingPoint, Signal, StateSpace};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::structure::shared_index;
use crate::{ArxModel, ArxStructure, CanonicalForm, Channel, IdentError, Term};

/// Entries of `A` and `C` that the canonical form fixes may be off by this much times the largest
/// entry of `A` (at least 1): rounding, not structure.
const PATTERN_TOLERANCE: f64 = 1e-12;

/// A realisation with more states is refused: its `A` alone would take 200 MB.
pub const STATE_LIMIT: usize = 5000;

/// The realisation of one row of an ARX model: a single output, driven by the model's inputs and
/// by the other outputs that the row uses, as measured inputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OutputModel {
    /// The observable canonical form of the row; its inputs are those of the model followed by
    /// the other outputs in use.
    pub model: StateSpace,
    /// The operating point, in the order of the inputs and output of `model`.
    pub point: OperatingPoint,
}

impl CanonicalForm {
    /// The minimal canonical state-space model of eq. 13-18.
    ///
    /// The rows of `B` are Markov parameters, found from `M B = B_bar` by substitution. With
    /// feedthrough `D = L^-1 [beta_{i, v_i + 1}]`, and `B_bar` loses what `D` explains.
    ///
    /// # Errors
    /// [`IdentError::Model`] when names do not fit or an entry overflows.
    pub fn to_state_space(
        &self,
        sample_time_s: f64,
        inputs: Vec<Signal>,
        outputs: Vec<Signal>,
    ) -> Result<StateSpace, IdentError> {
        let (n, ny, nu) = (self.order(), self.ny(), self.nu());
        let offsets = self.offsets();
        let mut a = DMatrix::zeros(n, n);
        let mut c = DMatrix::zeros(ny, n);
        for (i, &index) in self
            .indices()
            .iter()
            .enumerate()
            .filter(|(_, index)| **index > 0)
        {
            c[(i, offsets[i])] = 1.0;
            for k in 1..index {
                a[(offsets[i] + k - 1, offsets[i] + k)] = 1.0;
            }
            for (j, coefficients) in self.alpha()[i].iter().enumerate() {
                for (k, &value) in coefficients.iter().enumerate() {
                    a[(offsets[i] + index - 1, offsets[j] + k)] = value;
                }
            }
        }
        let d = if self.feedthrough() {
            let leading = DMatrix::from_fn(ny, nu, |i, j| self.beta()[i][self.indices()[i]][j]);
            self.solve_l(&leading)
        } else {
            DMatrix::zeros(ny, nu)
        };
        let mut b_bar = self.direct_part(&d);
        for i in 0..ny {
            for k in 0..self.indices()[i] {
                for j in 0..nu {
                    b_bar[(offsets[i] + k, j)] += self.beta()[i][k][j];
                }
            }
        }
        let b = self.solve_m(&b_bar);
        Ok(StateSpace::new(
            [a, b, c, d],
            sample_time_s,
            inputs,
            outputs,
        )?)
    }

    /// The input-output form of a state-space model that is in canonical form already: the
    /// inverse of [`CanonicalForm::to_state_space`]. It has feedthrough where `D` has an entry
    /// that is not zero.
    ///
    /// # Errors
    /// [`IdentError::NotCanonical`] at the first entry of `A` or `C` that is not as eq. 13-16 ask,
    /// [`IdentError::IndexZero`] for an output without a state.
    pub fn from_state_space(model: &StateSpace) -> Result<Self, IdentError> {
        let indices = indices_from_c(model)?;
        let mut form = Self::from_rows(indices, model.nu(), false, &[]);
        let offsets = form.offsets();
        check_pattern(model, form.indices(), &offsets)?;
        let mut alpha = form.alpha().to_vec();
        for i in 0..form.ny() {
            let last = offsets[i] + form.indices()[i] - 1;
            for (j, coefficients) in alpha[i].iter_mut().enumerate() {
                for (k, value) in coefficients.iter_mut().enumerate() {
                    *value = model.a()[(last, offsets[j] + k)];
                }
            }
        }
        form = Self::new(form.indices().to_vec(), alpha, form.beta().to_vec())?;
        form.with_inputs(model.b(), model.d())
    }

    /// The same outputs with the input coefficients that give `B (n x nu)` and `D (ny x nu)` in
    /// canonical coordinates: `B_bar = M B`, plus what `D` adds.
    pub(crate) fn with_inputs(
        &self,
        b: &DMatrix<f64>,
        d: &DMatrix<f64>,
    ) -> Result<Self, IdentError> {
        let feedthrough = d.iter().any(|&value| value != 0.0);
        let offsets = self.offsets();
        let rows = self.m_matrix() * b - self.direct_part(d);
        let leading = self.l_matrix() * d;
        let mut beta = Vec::with_capacity(self.ny());
        for (i, &index) in self.indices().iter().enumerate() {
            let mut list: Vec<Vec<f64>> = (0..index)
                .map(|k| rows.row(offsets[i] + k).iter().copied().collect())
                .collect();
            if feedthrough {
                list.push(leading.row(i).iter().copied().collect());
            }
            beta.push(list);
        }
        Self::new(self.indices().to_vec(), self.alpha().to_vec(), beta)
    }

    /// The gain `K (n x ny)` of the innovations form of an equation-error model,
    /// `x(t+1) = A x + B u + K e`, `y = C x + D u + L^-1 e` with `e` the equation error of eq. 7.
    /// The output estimator that it gives has all its poles at zero.
    pub fn equation_error_gain(&self) -> DMatrix<f64> {
        self.solve_m(&self.direct_part(&self.equation_error_direct()))
    }

    /// `L^-1 (ny x ny)`: how the equation errors enter the outputs at once.
    pub fn equation_error_direct(&self) -> DMatrix<f64> {
        self.solve_l(&DMatrix::identity(self.ny(), self.ny()))
    }

    /// Row `(i, k)`: `-sum_j p_ij[k - 1] direct_j`, what a direct term takes from `B_bar`.
    fn direct_part(&self, direct: &DMatrix<f64>) -> DMatrix<f64> {
        let offsets = self.offsets();
        let mut part = DMatrix::zeros(self.order(), direct.ncols());
        for i in 0..self.ny() {
            for k in 0..self.indices()[i] {
                for column in 0..direct.ncols() {
                    part[(offsets[i] + k, column)] = -(0..self.ny())
                        .map(|j| self.p(i, j, k) * direct[(j, column)])
                        .sum::<f64>();
                }
            }
        }
        part
    }
}

/// The indices that the ones of `C` mark (eq. 16).
fn indices_from_c(model: &StateSpace) -> Result<Vec<usize>, IdentError> {
    let (c, nx, ny) = (model.c(), model.nx(), model.ny());
    if ny == 0 {
        return Err(IdentError::NoOutputs);
    }
    let fault = |row, column, expected, found| {
        Err(IdentError::NotCanonical {
            matrix: 'C',
            row,
            column,
            expected,
            found,
        })
    };
    let mut starts: Vec<usize> = Vec::with_capacity(ny + 1);
    for row in 0..ny {
        // The first output starts at the first state, the others further right.
        let first = starts.last().map_or(0, |&previous| previous + 1);
        let last = if row == 0 { nx.min(1) } else { nx };
        let one = |&column: &usize| (c[(row, column)] - 1.0).abs() <= PATTERN_TOLERANCE;
        match (first..last).find(one) {
            Some(start) => starts.push(start),
            None if first < nx => return fault(row, first, 1.0, c[(row, first)]),
            None => return Err(IdentError::IndexZero { output: row }),
        }
    }
    starts.push(nx);
    for row in 0..ny {
        for column in 0..nx {
            let expected = if column == starts[row] { 1.0 } else { 0.0 };
            let found = c[(row, column)];
            if (found - expected).abs() > PATTERN_TOLERANCE {
                return fault(row, column, expected, found);
            }
        }
    }
    Ok(starts.windows(2).map(|pair| pair[1] - pair[0]).collect())
}

/// The shifts and zeros of eq. 14-15.
fn check_pattern(
    model: &StateSpace,
    indices: &[usize],
    offsets: &[usize],
) -> Result<(), IdentError> {
    let tolerance = PATTERN_TOLERANCE * model.a().amax().max(1.0);
    for i in 0..indices.len() {
        for k in 0..indices[i] {
            let row = offsets[i] + k;
            for j in 0..indices.len() {
                let free = if k + 1 == indices[i] {
                    shared_index(indices, i, j)
                } else {
                    0
                };
                for s in free..indices[j] {
                    let column = offsets[j] + s;
                    let shift = k + 1 < indices[i] && column == row + 1;
                    let expected = if shift { 1.0 } else { 0.0 };
                    let found = model.a()[(row, column)];
                    if (found - expected).abs() > tolerance {
                        return Err(IdentError::NotCanonical {
                            matrix: 'A',
                            row,
                            column,
                            expected,
                            found,
                        });
                    }
                }
            }
        }
    }
    Ok(())
}

impl ArxModel {
    /// The model in the form of eq. 7.
    ///
    /// A canonical structure keeps its indices. A diagonal or full one is written with the longest
    /// lag as the common index of all outputs and zeros for the coefficients that it lacks.
    ///
    /// # Errors
    /// [`IdentError::IndexZero`] for a model without any lag, which has no state;
    /// [`IdentError::TooManyStates`] beyond [`STATE_LIMIT`].
    pub fn canonical_form(&self) -> Result<CanonicalForm, IdentError> {
        let form = self.form()?;
        CanonicalForm::new(
            form.indices().to_vec(),
            form.alpha().to_vec(),
            form.beta().to_vec(),
        )
    }

    /// The whole model as a state-space model of the deviations from [`ArxModel::operating_point`].
    ///
    /// - Canonical: the canonical form of eq. 13-18, of order `sum v_i`.
    /// - Diagonal: a block per output, of order `max_lag` each.
    /// - Full: the canonical form with all indices `max_lag`, of order `ny * max_lag`. It may have
    ///   states that cannot be reached: it is minimal only where the longest lags of all channels
    ///   play along.
    /// - A model without any lag has no state, only `D`.
    ///
    /// # Errors
    /// [`IdentError::Model`] when an entry overflows, [`IdentError::TooManyStates`] beyond
    /// [`STATE_LIMIT`].
    pub fn state_space(&self) -> Result<StateSpace, IdentError> {
        let (inputs, outputs) = (self.inputs().to_vec(), self.outputs().to_vec());
        self.form()?
            .to_state_space(self.sample_time_s(), inputs, outputs)
    }

    /// The row of one output as a single-output model in observable canonical form.
    ///
    /// Other outputs that the row uses become measured inputs after the model's own; those at lag
    /// 0 act through `D`. The order is the longest lag of the row.
    ///
    /// # Errors
    /// [`IdentError::NoSuchOutput`], and as [`ArxModel::state_space`].
    pub fn output_model(&self, output: usize) -> Result<OutputModel, IdentError> {
        let (nu, ny) = (self.inputs().len(), self.outputs().len());
        let Some(row) = self.rows().get(output) else {
            return Err(IdentError::NoSuchOutput {
                found: output,
                outputs: ny,
            });
        };
        let measured: Vec<usize> = (0..ny)
            .filter(|&other| other != output)
            .filter(|&other| {
                row.terms
                    .iter()
                    .any(|term| term.channel == Channel::Output(other))
            })
            .collect();
        let local = |term: &Term| {
            let channel = match term.channel {
                Channel::Output(j) if j == output => Channel::Output(0),
                Channel::Output(j) => {
                    Channel::Input(nu + measured.iter().take_while(|&&other| other < j).count())
                }
                input @ Channel::Input(_) => input,
            };
            Term { channel, ..*term }
        };
        let terms: Vec<Term> = row.terms.iter().map(local).collect();
        let order = terms.iter().map(|term| term.lag).max().unwrap_or(0);
        check_states(&[order])?;
        let feedthrough = terms.iter().any(|term| term.lag == 0);
        let width = nu + measured.len();
        let form = CanonicalForm::from_rows(vec![order], width, feedthrough, &[&terms]);

        let mut inputs = self.inputs().to_vec();
        inputs.extend(measured.iter().map(|&other| self.outputs()[other].clone()));
        let outputs = vec![self.outputs()[output].clone()];
        let model = form.to_state_space(self.sample_time_s(), inputs, outputs)?;
        let all = self.operating_point();
        let mut point = OperatingPoint::zero(width, 1);
        point.u.rows_mut(0, nu).copy_from(&all.u);
        for (position, &other) in measured.iter().enumerate() {
            point.u[nu + position] = all.y[other];
        }
        point.y[0] = all.y[output];
        Ok(OutputModel { model, point })
    }

    /// As [`ArxModel::canonical_form`], with zero indices for a model without any lag.
    fn form(&self) -> Result<CanonicalForm, IdentError> {
        let (nu, ny) = (self.inputs().len(), self.outputs().len());
        let rows: Vec<&[Term]> = self.rows().iter().map(|row| row.terms.as_slice()).collect();
        let (indices, feedthrough) = match self.structure() {
            ArxStructure::Canonical {
                indices,
                feedthrough,
            } => (indices.clone(), *feedthrough),
            ArxStructure::Diagonal { .. } | ArxStructure::Full { .. } => {
                let direct = rows
                    .iter()
                    .any(|terms| terms.iter().any(|term| term.lag == 0));
                (vec![self.max_lag(); ny], direct)
            }
        };
        check_states(&indices)?;
        Ok(CanonicalForm::from_rows(indices, nu, feedthrough, &rows))
    }
}

fn check_states(indices: &[usize]) -> Result<(), IdentError> {
    let found = indices
        .iter()
        .fold(0_usize, |sum, &index| sum.saturating_add(index));
    if found > STATE_LIMIT {
        let max_lag = indices.iter().copied().max().unwrap_or(0);
        return Err(IdentError::TooManyStates {
            limit: STATE_LIMIT,
            found,
            max_lag,
        });
    }
    Ok(())
}
