//! The canonical input-output form `P(z) y = Q(z) u` of eq. 7-11.

use gt_core::DimensionError;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::structure::shared_index;
use crate::{Channel, IdentError, Term};

/// The coefficients of eq. 7:
/// `y_i(t + v_i) = sum alpha_ijk y_j(t + k - 1) + sum beta_ijk u_j(t + k - 1)`.
///
/// `alpha[i][j]` holds `v_ij` coefficients (eq. 9), `beta[i]` holds `v_i` rows of `nu`, or
/// `v_i + 1` with feedthrough. Construction and deserialisation check the sizes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct CanonicalForm {
    indices: Vec<usize>,
    alpha: Vec<Vec<Vec<f64>>>,
    beta: Vec<Vec<Vec<f64>>>,
}

/// The fields of a [`CanonicalForm`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    indices: Vec<usize>,
    alpha: Vec<Vec<Vec<f64>>>,
    beta: Vec<Vec<Vec<f64>>>,
}

impl TryFrom<Unchecked> for CanonicalForm {
    type Error = IdentError;

    fn try_from(raw: Unchecked) -> Result<Self, IdentError> {
        Self::new(raw.indices, raw.alpha, raw.beta)
    }
}

impl CanonicalForm {
    /// A checked form: `alpha[i][j][k - 1] = alpha_ijk`, `beta[i][k - 1][j] = beta_ijk`.
    ///
    /// # Errors
    /// [`IdentError::NoOutputs`], [`IdentError::IndexZero`], [`IdentError::Dimension`] where a
    /// list has another length than eq. 9 asks for, [`IdentError::ModelValue`] for a coefficient
    /// that is not finite.
    pub fn new(
        indices: Vec<usize>,
        alpha: Vec<Vec<Vec<f64>>>,
        beta: Vec<Vec<Vec<f64>>>,
    ) -> Result<Self, IdentError> {
        let ny = indices.len();
        if ny == 0 {
            return Err(IdentError::NoOutputs);
        }
        if let Some(output) = indices.iter().position(|&index| index == 0) {
            return Err(IdentError::IndexZero { output });
        }
        DimensionError::check("rows of alpha (outputs)", ny, alpha.len())?;
        DimensionError::check("rows of beta (outputs)", ny, beta.len())?;
        let feedthrough = beta[0].len() > indices[0];
        let nu = beta[0].first().map_or(0, Vec::len);
        for i in 0..ny {
            DimensionError::check(&format!("columns of alpha, row {i}"), ny, alpha[i].len())?;
            for (j, list) in alpha[i].iter().enumerate() {
                let expected = shared_index(&indices, i, j);
                DimensionError::check(&format!("alpha[{i}][{j}]"), expected, list.len())?;
            }
            let expected = indices[i] + usize::from(feedthrough);
            DimensionError::check(&format!("beta[{i}]"), expected, beta[i].len())?;
            for (k, row) in beta[i].iter().enumerate() {
                DimensionError::check(&format!("beta[{i}][{k}] (inputs)"), nu, row.len())?;
            }
        }
        for (what, lists) in [("alpha", &alpha), ("beta", &beta)] {
            let mut values = lists.iter().flatten().flatten();
            if let Some(&found) = values.find(|value| !value.is_finite()) {
                let what = what.to_owned();
                return Err(IdentError::ModelValue {
                    what,
                    expected: "a finite number",
                    found,
                });
            }
        }
        Ok(Self {
            indices,
            alpha,
            beta,
        })
    }

    /// The form of checked ARX rows whose lags fit `indices`; indices that are all zero (a static
    /// model) are allowed here.
    pub(crate) fn from_rows(
        indices: Vec<usize>,
        nu: usize,
        feedthrough: bool,
        rows: &[&[Term]],
    ) -> Self {
        let ny = indices.len();
        let mut alpha: Vec<Vec<Vec<f64>>> = (0..ny)
            .map(|i| {
                (0..ny)
                    .map(|j| vec![0.0; shared_index(&indices, i, j)])
                    .collect()
            })
            .collect();
        let mut beta: Vec<Vec<Vec<f64>>> = indices
            .iter()
            .map(|&index| vec![vec![0.0; nu]; index + usize::from(feedthrough)])
            .collect();
        for (i, terms) in rows.iter().enumerate() {
            for term in *terms {
                // Lag l of the row is k = v_i - l + 1 in eq. 7.
                let k = indices[i] - term.lag;
                match term.channel {
                    Channel::Output(j) => alpha[i][j][k] = term.coefficient,
                    Channel::Input(j) => beta[i][k][j] = term.coefficient,
                }
            }
        }
        Self {
            indices,
            alpha,
            beta,
        }
    }

    /// `v_i` (eq. 7), one per output.
    pub fn indices(&self) -> &[usize] {
        &self.indices
    }

    /// `alpha[i][j][k - 1] = alpha_ijk`.
    pub fn alpha(&self) -> &[Vec<Vec<f64>>] {
        &self.alpha
    }

    /// `beta[i][k - 1][j] = beta_ijk`.
    pub fn beta(&self) -> &[Vec<Vec<f64>>] {
        &self.beta
    }

    /// The order: the sum of the indices (eq. 8).
    pub fn order(&self) -> usize {
        self.indices.iter().sum()
    }

    /// Number of outputs.
    pub fn ny(&self) -> usize {
        self.indices.len()
    }

    /// Number of inputs.
    pub fn nu(&self) -> usize {
        self.beta[0].first().map_or(0, Vec::len)
    }

    /// Whether `u(t)` acts on `y(t)`.
    pub fn feedthrough(&self) -> bool {
        self.beta[0].len() > self.indices[0]
    }

    /// The coefficient of `z^power` in `p_ij(z)` (eq. 11).
    pub(crate) fn p(&self, i: usize, j: usize, power: usize) -> f64 {
        match self.alpha[i][j].get(power) {
            Some(value) => -value,
            None if i == j && power == self.indices[i] => 1.0,
            None => 0.0,
        }
    }

    /// The position of the first state of each output.
    pub(crate) fn offsets(&self) -> Vec<usize> {
        let starts = self.indices.iter().scan(0, |sum, &index| {
            let start = *sum;
            *sum += index;
            Some(start)
        });
        starts.collect()
    }

    /// `M (n x n)` of eq. 19-21 with `alpha_ij` in place of the printed `alpha_ii`:
    /// `M_ij(k, s) = p_ij[k + s - 1]`, so that `M B` are the input coefficients (eq. 17).
    ///
    /// `|det M| = 1` holds whatever the coefficients, which does not make `M` well-conditioned.
    pub fn m_matrix(&self) -> DMatrix<f64> {
        let offsets = self.offsets();
        let mut m = DMatrix::zeros(self.order(), self.order());
        for i in 0..self.ny() {
            for j in 0..self.ny() {
                for k in 0..self.indices[i] {
                    for s in 0..self.indices[j] {
                        m[(offsets[i] + k, offsets[j] + s)] = self.p(i, j, k + s + 1);
                    }
                }
            }
        }
        m
    }

    /// `L (ny x ny)`, the leading coefficients of the rows of `P(z)`: unit lower triangular,
    /// `L_ij = -alpha_{ij, v_i + 1}` where another output enters at lag 0.
    pub fn l_matrix(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.ny(), self.ny(), |i, j| self.p(i, j, self.indices[i]))
    }

    /// `L^-1 rhs` by forward substitution.
    pub(crate) fn solve_l(&self, rhs: &DMatrix<f64>) -> DMatrix<f64> {
        let mut solution = rhs.clone();
        for i in 0..self.ny() {
            for j in 0..i {
                let factor = self.p(i, j, self.indices[i]);
                for column in 0..solution.ncols() {
                    solution[(i, column)] -= factor * solution[(j, column)];
                }
            }
        }
        solution
    }

    /// `M^-1 rhs` by substitution: row `(i, v_i - s + 1)` of `M` holds, besides the state `(i, s)`
    /// that it is solved for, only states of smaller `s`, or of the same `s` and smaller `i`.
    pub(crate) fn solve_m(&self, rhs: &DMatrix<f64>) -> DMatrix<f64> {
        let offsets = self.offsets();
        let longest = self.indices.iter().copied().max().unwrap_or(0);
        let mut solution = DMatrix::zeros(rhs.nrows(), rhs.ncols());
        for s in 0..longest {
            for i in (0..self.ny()).filter(|&i| s < self.indices[i]) {
                let k = self.indices[i] - s - 1;
                for column in 0..rhs.ncols() {
                    let mut value = rhs[(offsets[i] + k, column)];
                    for j in 0..self.ny() {
                        let known = if j < i { s + 1 } else { s };
                        for earlier in 0..known.min(self.indices[j]) {
                            value -= self.p(i, j, k + earlier + 1)
                                * solution[(offsets[j] + earlier, column)];
                        }
                    }
                    solution[(offsets[i] + s, column)] = value;
                }
            }
        }
        solution
    }
}
