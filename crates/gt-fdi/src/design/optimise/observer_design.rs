//! What a search for poles found.

use gt_core::{OperatingPoint, StateSpace};
use nalgebra::Complex;
use serde::{Deserialize, Serialize};

use super::super::generator::ResidualGenerator;
use super::data_bound::DataBound;
use super::energy_ratio::Criterion;
use super::start::Start;
use crate::FdiError;

/// One descent of a search, or its evolution.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Attempt {
    /// Where it began.
    pub start: Start,
    /// The criterion where it ended.
    pub v: f64,
    /// Evaluations of the criterion, with or without its gradient.
    pub evaluations: usize,
}

/// The poles that a [`PoleSearch`](super::PoleSearch) chose, with what speaks for and against them.
///
/// V on the records that the poles were chosen by falls with the radius allowed, up to filters that
/// ring for as long as the record: what counts is `v_validation`, and whether the bound leaves
/// anything to gain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObserverDesign {
    /// The criterion.
    pub criterion: Criterion,
    /// The largest modulus that a pole could have.
    pub radius: f64,
    /// The poles (nx), complex ones in pairs; `[re, im]` each when written.
    pub poles: Vec<Complex<f64>>,
    /// The criterion on the training records.
    pub v: f64,
    /// The criterion of the same poles on the validation records, if there are any.
    pub v_validation: Option<f64>,
    /// The least that filters of the bound's class reach on the training records.
    pub bound: DataBound,
    /// Evaluations of the criterion in all attempts.
    pub evaluations: usize,
    /// Where the attempt began that found the poles, the first of equally good ones.
    pub start: Start,
    /// All attempts in the order in which they were made.
    pub attempts: Vec<Attempt>,
}

impl ObserverDesign {
    /// The observer with these poles, of the model that they were found for.
    ///
    /// # Errors
    /// As [`ResidualGenerator::observer_complex`].
    pub fn generator(
        &self,
        model: StateSpace,
        point: OperatingPoint,
    ) -> Result<ResidualGenerator, FdiError> {
        ResidualGenerator::observer_complex(model, point, &self.poles)
    }
}
