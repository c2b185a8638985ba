//! Identification of local models along a scheduling channel.

use gt_core::Dataset;
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

use super::model::{SchedulePoint, ScheduledModel, check_values};
use super::stacked::Stacked;
use crate::model::Fitted;
use crate::{ArxModel, ArxStructure, IdentError};

/// How the points share the samples between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Estimation {
    /// Each point alone, on samples weighted by its membership. Where the load varies among these
    /// samples, the coefficients may vary linearly with it and the model is what they are at the
    /// point (local linear regression, Fan and Gijbels, 1996): without that, the drift of the
    /// equilibrium would pass for a slow pole, and the ends of the range be pulled inwards.
    #[default]
    Local,
    /// All points at once on the error of the blended equation: exact where the coefficients are
    /// linear in the load between points, and needs samples between them.
    Joint,
}

/// Local models that are still to be fitted.
///
/// | Name | Default | Purpose | Range |
/// |---|---|---|---|
/// | `channel` | none | the scheduling channel, an input | a name |
/// | `values` | none | the operating points, in the channel's unit | ascending |
/// | `width` | 1 | part of the way between points that hands over | 0..=1 |
/// | `estimation` | local | how points share samples | [`Estimation`] |
///
/// A slow scheduling channel is best left out of the equations (`nb = 0` for it): the points'
/// constants hold its effect at rest already.
#[derive(Debug, Clone, PartialEq)]
pub struct ScheduledArx {
    pub(super) structure: ArxStructure,
    pub(super) channel: String,
    pub(super) values: Vec<f64>,
    pub(super) width: f64,
    pub(super) estimation: Estimation,
}

impl ScheduledArx {
    /// One model of `structure` at each value of `channel`.
    pub fn new(structure: ArxStructure, channel: impl Into<String>, values: Vec<f64>) -> Self {
        Self {
            structure,
            channel: channel.into(),
            values,
            width: 1.0,
            estimation: Estimation::Local,
        }
    }

    /// The same with another width of the hand-over.
    #[must_use]
    pub fn width(mut self, width: f64) -> Self {
        self.width = width;
        self
    }

    /// The same with another way to share samples.
    #[must_use]
    pub fn estimation(mut self, estimation: Estimation) -> Self {
        self.estimation = estimation;
        self
    }

    /// Fits all points to the records; no regression row reaches from one record into another.
    ///
    /// Each equation has a constant of its own, which becomes the output's operating point: the
    /// equilibrium of the local model at the weighted mean of the inputs.
    ///
    /// # Errors
    /// What [`ScheduledModel::new`] and [`ArxStructure::validate`] refuse;
    /// [`IdentError::NoRecords`]; records that differ in channels or sample time, or are too short;
    /// [`IdentError::SchedulePoint`] for a point without samples enough;
    /// [`IdentError::RankDeficient`] and [`IdentError::CoefficientNotFinite`] as in
    /// [`crate::Arx::fit`]; [`IdentError::NoEquilibrium`] for a local model with a pole at 1.
    pub fn fit(&self, records: &[Dataset]) -> Result<ScheduledModel, IdentError> {
        check_values(self.values.clone(), self.width)?;
        let stacked = Stacked::new(self, records)?;
        let first = &records[0];
        let points = self.values.len();
        let (nu, ny) = (first.nu(), first.ny());
        // Per point: rows, constants, conditions.
        let mut locals = vec![(Vec::new(), DVector::zeros(ny), Vec::new()); points];
        for output in 0..ny {
            let regressors = self.structure.regressors(output, nu, ny)?;
            let solutions = stacked.solve(self, output, first, &regressors)?;
            for (local, solution) in locals.iter_mut().zip(solutions) {
                local.0.push(solution.row);
                local.1[output] = solution.constant;
                local.2.push(solution.condition);
            }
        }
        let models =
            (locals.into_iter().enumerate()).map(|(point, (rows, constants, condition))| {
                let value = self.values[point];
                let operating_point = stacked
                    .equilibrium(point, &rows, &constants)
                    .ok_or(IdentError::NoEquilibrium { value })?;
                let model = ArxModel::new(Fitted {
                    inputs: first.inputs().to_vec(),
                    outputs: first.outputs().to_vec(),
                    sample_time_s: first.sample_time_s(),
                    operating_point,
                    structure: self.structure.clone(),
                    rows,
                    rows_used: stacked.around(point).len(),
                    condition,
                    standard_errors: None,
                })?;
                Ok(SchedulePoint { value, model })
            });
        let models = models.collect::<Result<Vec<_>, IdentError>>()?;
        ScheduledModel::new(self.channel.clone(), models, self.width)
    }
}
