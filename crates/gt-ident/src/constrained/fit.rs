//! Identification under constraints.

use std::collections::BTreeMap;

use gt_core::{Dataset, index_of};
use serde::{Deserialize, Serialize};

use super::cost::RowCost;
use super::dc_gain::{DcGain, RowGain};
use super::row::{RowFailure, denominator, fit_row};
use crate::regressor::Deviations;
use crate::{Arx, ArxModel, ArxRow, ArxStructure, Channel, IdentError, Regressor, Term};

/// The largest modulus of a pole unless another is asked for.
pub const MAX_RADIUS: f64 = 0.999;

/// An ARX model that is to be fitted with stable poles and known steady-state gains.
///
/// | Name | Default | Purpose | Range |
/// |---|---|---|---|
/// | `max_radius` | [`MAX_RADIUS`] | largest modulus of a pole | above 0, at most 1 |
/// | `dc_gain` | none | what is known of a gain, by output and input | finite, lower <= upper |
///
/// It takes diagonal structures only: with lags of other outputs in a row, the poles of the model
/// are not those of its rows.
#[derive(Debug, Clone, PartialEq)]
pub struct ConstrainedArx {
    structure: ArxStructure,
    max_radius: f64,
    gains: BTreeMap<(String, String), DcGain>,
}

/// A fit with its account.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConstrainedFit {
    /// The model, in the same form as an unconstrained fit's.
    pub model: ArxModel,
    /// One entry per output.
    pub rows: Vec<ConstrainedRow>,
}

/// What the constraints cost one output.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConstrainedRow {
    /// The output's name.
    pub output: String,
    /// Residual sum of squares over that of least squares, at least 1; infinite where least
    /// squares leaves no residual at all.
    pub cost_ratio: f64,
    /// The same ratio after reflecting the unstable poles and refitting the inputs' coefficients;
    /// `None` where least squares has its poles inside.
    pub reflected_cost_ratio: Option<f64>,
    /// Largest modulus of a pole of the least-squares row.
    pub least_squares_radius: f64,
    /// Largest modulus of a pole of the fitted row.
    pub radius: f64,
    /// The constraints that hold the fit away from least squares.
    pub active: Vec<ActiveConstraint>,
    /// Centres of the convex set that lowered the cost; 0 where least squares meets everything.
    pub iterations: usize,
}

/// A constraint that binds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ActiveConstraint {
    /// The poles may not come closer to the circle of the largest radius at this angle.
    Stability {
        /// Angle in rad per sample, 0 to pi.
        angle_rad: f64,
    },
    /// The steady-state gain of this input is at a limit.
    DcGain {
        /// The input's name.
        input: String,
    },
}

impl ConstrainedArx {
    /// A model of the given structure, stable, without anything known of its gains.
    pub fn new(structure: ArxStructure) -> Self {
        Self {
            structure,
            max_radius: MAX_RADIUS,
            gains: BTreeMap::new(),
        }
    }

    /// The same model with another largest modulus of a pole.
    #[must_use]
    pub fn max_radius(mut self, max_radius: f64) -> Self {
        self.max_radius = max_radius;
        self
    }

    /// The same model with what is known of the gain of `input` on `output` (names); replaces what
    /// was known of it before.
    #[must_use]
    pub fn dc_gain(
        mut self,
        output: impl Into<String>,
        input: impl Into<String>,
        gain: DcGain,
    ) -> Self {
        self.gains.insert((output.into(), input.into()), gain);
        self
    }

    /// Fits each row by least squares under the constraints, on the rows that [`Arx::fit`] uses.
    ///
    /// # Errors
    /// [`IdentError::NotDiagonal`] for another structure; [`IdentError::OptionRange`] for the
    /// radius; [`IdentError::GainRange`] or [`IdentError::GainWithoutTerms`] for a gain;
    /// [`gt_core::DataError::UnknownChannel`] for its names; what [`Arx::fit`] refuses;
    /// [`IdentError::Programme`] when the quadratic programme cannot be solved.
    pub fn fit(&self, data: &Dataset) -> Result<ConstrainedFit, IdentError> {
        let ArxStructure::Diagonal { na, .. } = &self.structure else {
            return Err(IdentError::NotDiagonal {
                method: "stability-constrained least squares",
                structure: self.structure.to_string(),
            });
        };
        if !(self.max_radius > 0.0 && self.max_radius <= 1.0) {
            return Err(IdentError::OptionRange {
                option: "max_radius",
                expected: "above 0 and at most 1",
                found: self.max_radius,
            });
        }
        let free = Arx::new(self.structure.clone()).fit(data)?;
        let gains = self.row_gains(&free)?;
        let record = Deviations::new(data, free.operating_point())?;
        let window = free.max_lag()..data.len();
        let (mut rows, mut reports) = (Vec::new(), Vec::new());
        for (output, row) in free.rows().iter().enumerate() {
            let name = free.outputs()[output].name.clone();
            let regressors: Vec<Regressor> = row.terms.iter().map(Term::regressor).collect();
            let target = Regressor {
                channel: Channel::Output(output),
                lag: 0,
            };
            let cost = RowCost::new(
                &record.design(&regressors, &window),
                &record.design(&[target], &window),
            )
            .ok_or_else(|| IdentError::CoefficientNotFinite {
                output: name.clone(),
                found: f64::NAN,
            })?;
            let solution =
                fit_row(&cost, *na, &gains[output], self.max_radius).map_err(|failure| {
                    match failure {
                        RowFailure::Poles(error) => IdentError::Model(error),
                        RowFailure::Programme(source) => IdentError::Programme {
                            output: name.clone(),
                            source,
                        },
                    }
                })?;
            let total = cost.rss + cost.excess(&solution.theta);
            let ratio = |excess: f64| {
                if excess == 0.0 {
                    1.0
                } else {
                    1.0 + excess / cost.rss
                }
            };
            reports.push(ConstrainedRow {
                output: name,
                cost_ratio: ratio(cost.excess(&solution.theta)),
                reflected_cost_ratio: solution.reflected_excess.map(ratio),
                least_squares_radius: denominator(&cost.least_squares, *na).radius()?,
                radius: denominator(&solution.theta, *na).radius()?,
                active: solution.active,
                iterations: solution.centres,
            });
            rows.push(ArxRow {
                terms: (regressors.iter().zip(solution.theta.iter()))
                    .map(|(regressor, &value)| Term::new(*regressor, value))
                    .collect(),
                residual_variance: total / window.len() as f64,
            });
        }
        Ok(ConstrainedFit {
            model: free.with_rows(rows)?,
            rows: reports,
        })
    }

    /// The gains by output, with the positions of their coefficients.
    fn row_gains(&self, model: &ArxModel) -> Result<Vec<Vec<RowGain>>, IdentError> {
        let mut gains = vec![Vec::new(); model.outputs().len()];
        for ((output, input), gain) in &self.gains {
            let row = index_of(model.outputs(), output)?;
            let channel = Channel::Input(index_of(model.inputs(), input)?);
            let (lower, upper) = gain.range();
            let one_sided = matches!(gain, DcGain::Positive | DcGain::Negative);
            if !(one_sided || (lower.is_finite() && upper.is_finite() && lower <= upper)) {
                return Err(IdentError::GainRange {
                    output: output.clone(),
                    input: input.clone(),
                    lower,
                    upper,
                });
            }
            let terms: Vec<usize> = (model.rows()[row].terms.iter())
                .enumerate()
                .filter(|(_, term)| term.channel == channel)
                .map(|(position, _)| position)
                .collect();
            if terms.is_empty() {
                return Err(IdentError::GainWithoutTerms {
                    output: output.clone(),
                    input: input.clone(),
                });
            }
            gains[row].push(RowGain {
                input: input.clone(),
                terms,
                lower,
                upper,
            });
        }
        Ok(gains)
    }
}
