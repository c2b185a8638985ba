//! A number with its standard error.

use serde::{Deserialize, Serialize};

use crate::distributions::normal_quantile;

/// An estimate with the standard error that the covariance of the coefficients gives it to first
/// order (Gauss approximation, the delta method).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Its standard error; `None` where the first order says nothing, for example at a double root.
    pub standard_error: Option<f64>,
}

impl Estimate {
    /// The interval that holds the truth with the given probability, 0 to 1, to first order.
    pub fn interval(&self, confidence: f64) -> Option<[f64; 2]> {
        let half = normal_quantile(0.5 * (1.0 + confidence)) * self.standard_error?;
        half.is_finite()
            .then_some([self.value - half, self.value + half])
    }
}
