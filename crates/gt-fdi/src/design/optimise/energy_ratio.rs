//! The criteria by which poles are chosen.

use gt_core::{OperatingPoint, StateSpace};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

use super::equation_error::EquationError;
use super::error::SearchError;
use super::record_pair::RecordPair;
use super::sections::Sections;
use crate::FdiError;

/// What poles are chosen by: a ratio of sums of squares, the smaller the better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Criterion {
    /// `V = sum r_h^2 / sum r_f^2`, the healthy over the faulty residual of one pair of records
    /// (the paper's eq. 24). `r_f` holds what is there without the fault too, and poles may exploit
    /// that it happens to go with the fault's effect.
    Paper,
    /// `V' = sum ||r_h||^2 / sum ||delta||^2` over one pair or several, where `delta` is the
    /// generator's answer to `(u_f - u_h, y_f - y_h)`: all that the fault adds, exactly, because
    /// the generator is linear.
    FaultEnergy,
}

/// A criterion as a function of the poles of an observer with one output.
///
/// For one output `r = eps / P(z^-1)` and the equation error `eps` of the model's ARX form does not
/// depend on the poles, so that it is computed once and the gradient is exact:
/// `d r / d a_j = -z^-j r / S` for the section `S` that `a_j` belongs to.
#[derive(Debug, Clone)]
pub struct EnergyRatio {
    order: usize,
    /// Equation errors of the healthy records.
    pub(super) healthy: Vec<Vec<f64>>,
    /// Those of the faulty records, or of the differences.
    pub(super) effect: Vec<Vec<f64>>,
    /// Samples at the start of each record that are filtered but do not count.
    pub(super) skip: usize,
}

impl EnergyRatio {
    /// The criterion on these pairs, residuals from rest at the operating point; the first
    /// `skip_samples` of each record are filtered but not counted.
    ///
    /// # Errors
    /// [`FdiError::OutputCount`], [`FdiError::Dimension`], [`FdiError::Unobservable`] of the model;
    /// [`FdiError::MissingTags`], [`FdiError::SampleTime`] of a record; [`SearchError`] of a model
    /// without states, no pairs, more than one for [`Criterion::Paper`], records of a pair that
    /// differ in length or are too short, samples that are not finite and a side without energy.
    pub fn new(
        criterion: Criterion,
        model: &StateSpace,
        point: &OperatingPoint,
        pairs: &[RecordPair],
        skip_samples: usize,
    ) -> Result<Self, FdiError> {
        if criterion == Criterion::Paper && pairs.len() > 1 {
            let found = pairs.len();
            return Err(SearchError::PairCount { found }.into());
        }
        Self::of("training", criterion, model, point, pairs, skip_samples)
    }

    /// As [`EnergyRatio::new`] of any number of pairs, which errors call `set`.
    pub(super) fn of(
        set: &'static str,
        criterion: Criterion,
        model: &StateSpace,
        point: &OperatingPoint,
        pairs: &[RecordPair],
        skip: usize,
    ) -> Result<Self, FdiError> {
        if pairs.is_empty() {
            return Err(SearchError::NoRecords.into());
        }
        let equation = EquationError::of(model, point)?;
        let order = model.nx();
        let (mut healthy, mut effect) = (Vec::new(), Vec::new());
        for (pair, &records) in pairs.iter().enumerate() {
            let errors = equation.pair(set, pair, records)?;
            let (needed, found) = (skip.saturating_add(order + 1), errors.healthy.len());
            if found < needed {
                return Err(SearchError::TooShort {
                    set,
                    pair,
                    needed,
                    found,
                }
                .into());
            }
            healthy.push(errors.healthy);
            effect.push(match criterion {
                Criterion::Paper => errors.faulty,
                Criterion::FaultEnergy => errors.difference,
            });
        }
        let side = match criterion {
            Criterion::Paper => "faulty residuals",
            Criterion::FaultEnergy => "difference that the fault makes",
        };
        for (side, errors) in [("healthy residuals", &healthy), (side, &effect)] {
            let found: f64 = errors.iter().map(|error| energy(&error[skip..])).sum();
            if !(found.is_finite() && found > 0.0) {
                return Err(SearchError::Energy { set, side, found }.into());
            }
        }
        Ok(Self {
            order,
            healthy,
            effect,
            skip,
        })
    }

    /// Poles of the observer, the states of the model.
    pub fn order(&self) -> usize {
        self.order
    }

    /// The ratio for these poles; with another number of them than [`EnergyRatio::order`], that of a
    /// filter which no observer is.
    pub fn value(&self, sections: &Sections) -> f64 {
        let sum = |errors: &[Vec<f64>]| -> f64 {
            let of_record = |error: &Vec<f64>| energy(&sections.filter(error)[self.skip..]);
            errors.iter().map(of_record).sum()
        };
        sum(&self.healthy) / sum(&self.effect)
    }

    /// The ratio and its derivatives by the coefficients of the sections (n):
    /// `2 (<r_h, dr_h> - V <r_f, dr_f>) / ||r_f||^2`.
    pub fn value_and_gradient(&self, sections: &Sections) -> (f64, DVector<f64>) {
        let (healthy, of_healthy) = self.energy_and_half_gradient(sections, &self.healthy);
        let (effect, of_effect) = self.energy_and_half_gradient(sections, &self.effect);
        let value = healthy / effect;
        (value, (of_healthy - of_effect * value) * (2.0 / effect))
    }

    /// `sum ||r||^2` and `sum <r, dr>`.
    fn energy_and_half_gradient(
        &self,
        sections: &Sections,
        errors: &[Vec<f64>],
    ) -> (f64, DVector<f64>) {
        let (mut sum, mut gradient) = (0.0, DVector::zeros(sections.order()));
        for error in errors {
            let residual = sections.filter(error);
            sum += energy(&residual[self.skip..]);
            for section in 0..sections.count() {
                let mut sensitivity = residual.clone();
                sections.filter_by(section, &mut sensitivity);
                let coefficients = (2 * section..sections.order()).take(2);
                for (delay, coefficient) in (1..).zip(coefficients) {
                    let from = self.skip.max(delay);
                    let pairs = residual[from..].iter().zip(&sensitivity[from - delay..]);
                    gradient[coefficient] -= pairs.map(|(r, s)| r * s).sum::<f64>();
                }
            }
        }
        (sum, gradient)
    }
}

/// The sum of squares.
pub(super) fn energy(signal: &[f64]) -> f64 {
    signal.iter().map(|value| value * value).sum()
}
