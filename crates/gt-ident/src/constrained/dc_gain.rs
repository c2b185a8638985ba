//! What is known of a steady-state gain.

use nalgebra::DVector;
use serde::{Deserialize, Serialize};

use super::fit::ActiveConstraint;
use super::nearest::Constraint;

/// What is known of the steady-state gain `B(1) / A(1)` of an input on an output, in units of the
/// output per unit of the input.
///
/// A stable `A` has `A(1) > 0`, so that each is linear in the coefficients: the sign is that of
/// `B(1)`, a value `g` is `B(1) = g A(1)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DcGain {
    /// Not below 0.
    Positive,
    /// Not above 0.
    Negative,
    /// Known exactly.
    Equal(f64),
    /// Between a lower and an upper value, both allowed.
    Between(f64, f64),
}

impl DcGain {
    /// Lower and upper gain; infinite where there is none.
    pub(crate) fn range(self) -> (f64, f64) {
        match self {
            Self::Positive => (0.0, f64::INFINITY),
            Self::Negative => (f64::NEG_INFINITY, 0.0),
            Self::Equal(gain) => (gain, gain),
            Self::Between(lower, upper) => (lower, upper),
        }
    }
}

/// A gain range for the row of one output.
#[derive(Debug, Clone)]
pub(crate) struct RowGain {
    /// The input's name.
    pub input: String,
    /// Positions of the input's coefficients in the row.
    pub terms: Vec<usize>,
    pub lower: f64,
    pub upper: f64,
}

impl RowGain {
    /// The linear constraints; the first `na` of the `p` coefficients are the output's own lags.
    pub fn constraints(&self, na: usize, p: usize) -> Vec<Constraint> {
        // B(1) - g A(1) = sum of beta + g (sum of alpha) - g.
        let row = |gain: f64, lower: f64, upper: f64| {
            let mut gradient = DVector::zeros(p);
            gradient.rows_mut(0, na).fill(gain);
            for &term in &self.terms {
                gradient[term] = 1.0;
            }
            Constraint {
                gradient,
                lower: lower + gain,
                upper: upper + gain,
                exact: true,
                origin: ActiveConstraint::DcGain {
                    input: self.input.clone(),
                },
            }
        };
        if self.lower >= self.upper {
            return vec![row(self.lower, 0.0, 0.0)];
        }
        let mut rows = Vec::new();
        if self.lower.is_finite() {
            rows.push(row(self.lower, 0.0, f64::INFINITY));
        }
        if self.upper.is_finite() {
            rows.push(row(self.upper, f64::NEG_INFINITY, 0.0));
        }
        rows
    }
}
