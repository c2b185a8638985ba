//! The point around which a linear model holds.

use nalgebra::DVector;
use serde::{Deserialize, Serialize};

/// Values that are subtracted from inputs and outputs before a linear model sees them, and added
/// to its outputs afterwards; usually the means of the training record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OperatingPoint {
    /// Input values (nu).
    pub u: DVector<f64>,
    /// Output values (ny).
    pub y: DVector<f64>,
}

impl OperatingPoint {
    /// The origin: nothing is subtracted.
    pub fn zero(nu: usize, ny: usize) -> Self {
        Self {
            u: DVector::zeros(nu),
            y: DVector::zeros(ny),
        }
    }
}
