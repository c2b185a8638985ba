//! One output of an errors-in-variables model: its lags, its relation, its noise.

use nalgebra::DVector;

use crate::IdentError;

/// The lags of one output's relation: its own `1..=order`, and `nk_j..=order` of each input.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EivLags {
    order: usize,
    nk: Vec<usize>,
}

impl EivLags {
    /// Lags of the given order, with the smallest lag of each input.
    ///
    /// # Errors
    /// [`IdentError::EivOrder`] for an order of 0, [`IdentError::EivLag`] for a smallest lag above
    /// the order.
    pub fn new(order: usize, nk: Vec<usize>) -> Result<Self, IdentError> {
        if order == 0 {
            return Err(IdentError::EivOrder);
        }
        if let Some(input) = nk.iter().position(|&lag| lag > order) {
            let found = nk[input];
            return Err(IdentError::EivLag {
                input,
                order,
                found,
            });
        }
        Ok(Self { order, nk })
    }

    /// The order `n`.
    pub fn order(&self) -> usize {
        self.order
    }

    /// The smallest lag of each input (`nu` entries).
    pub fn nk(&self) -> &[usize] {
        &self.nk
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.nk.len()
    }

    /// Number of coefficients of an input: `n + 1 - nk_j`.
    pub fn input_terms(&self, input: usize) -> usize {
        self.order + 1 - self.nk[input]
    }

    /// Number of coefficients, `n + sum_j (n + 1 - nk_j)`.
    pub fn parameters(&self) -> usize {
        let inputs = (0..self.inputs()).map(|input| self.input_terms(input));
        self.order + inputs.sum::<usize>()
    }
}

/// The noise-free relation of one output,
/// `y*(t) + sum_k a_k y*(t-k) = sum_j sum_k b_jk u_j*(t-k)`, `k` from 1 (outputs) and `nk_j`
/// (inputs) to `n`.
#[derive(Debug, Clone, PartialEq)]
pub struct EivRow {
    lags: EivLags,
    theta: DVector<f64>,
}

impl EivRow {
    /// The relation with coefficients `theta = (a_1..a_n, b_1, b_2, ..)`.
    ///
    /// # Errors
    /// [`IdentError::Dimension`] where their number is not [`EivLags::parameters`].
    pub fn new(lags: EivLags, theta: DVector<f64>) -> Result<Self, IdentError> {
        gt_core::DimensionError::check(
            "coefficients of an errors-in-variables row",
            lags.parameters(),
            theta.len(),
        )?;
        Ok(Self { lags, theta })
    }

    /// The lags.
    pub fn lags(&self) -> &EivLags {
        &self.lags
    }

    /// All coefficients, `(a_1..a_n, b_1, b_2, ..)`.
    pub fn theta(&self) -> &DVector<f64> {
        &self.theta
    }

    /// `a_1..a_n`.
    pub fn a(&self) -> &[f64] {
        &self.theta.as_slice()[..self.lags.order]
    }

    /// The coefficients of an input, at lags `nk_j..=n`.
    pub fn b(&self, input: usize) -> &[f64] {
        let terms = |input| self.lags.input_terms(input);
        let start = self.lags.order + (0..input).map(terms).sum::<usize>();
        &self.theta.as_slice()[start..start + terms(input)]
    }
}

/// Variances of the white noise on one output and on the inputs, in squared units of the channels.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseVariances {
    /// Of the output.
    pub output: f64,
    /// Of each input (`nu`).
    pub inputs: DVector<f64>,
}
