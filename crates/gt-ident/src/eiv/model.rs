//! The identified errors-in-variables model: the relation between the noise-free channels, as an
//! ARX model whose inputs are not exact, and the noise.

use gt_core::{Dataset, DimensionError, Signal};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

use super::{EivEstimate, EivRow, EivVariance, IDENTIFIABLE_DEVIATION};
use crate::frisch::{FrischNoise, SharedFrischEstimate};
use crate::{Arx, ArxModel, ArxStructure, Channel, IdentError, Regressor};

/// White noise of one channel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChannelNoise {
    /// Its variance, in squared units of the channel.
    pub variance: f64,
    /// Standard error of the variance, where the method gives one.
    pub standard_error: Option<f64>,
    /// Whether the estimate says no more than that the variance lies somewhere: it stands at a limit
    /// of what the record admits (a variance of zero), or its standard error is infinite.
    pub at_limit: bool,
}

impl ChannelNoise {
    /// Whether the record tells this variance: not at a limit, with a standard error of at most
    /// [`IDENTIFIABLE_DEVIATION`] of it; `None` where the method gives no standard error.
    pub fn identifiable(&self) -> Option<bool> {
        if self.at_limit {
            return Some(false);
        }
        let error = self.standard_error?;
        Some(error <= IDENTIFIABLE_DEVIATION * self.variance)
    }
}

impl From<&EivVariance> for ChannelNoise {
    fn from(estimate: &EivVariance) -> Self {
        Self {
            variance: estimate.value,
            standard_error: Some(estimate.deviation).filter(|error| error.is_finite()),
            at_limit: estimate.at_lower_bound
                || estimate.at_upper_bound
                || !estimate.deviation.is_finite(),
        }
    }
}

impl EivEstimate {
    /// The model of the estimate, for the record that it was fitted to.
    ///
    /// # Errors
    /// As [`EivModel::from_rows`].
    pub fn model(&self, data: &Dataset) -> Result<EivModel, IdentError> {
        let noise = |channels: &[EivVariance]| channels.iter().map(ChannelNoise::from).collect();
        let (outputs, inputs) = (noise(&self.output_noise), noise(&self.input_noise));
        EivModel::from_rows(
            data,
            &self.rows,
            Some(&self.row_deviations),
            outputs,
            inputs,
        )
    }
}

impl From<&FrischNoise> for ChannelNoise {
    fn from(estimate: &FrischNoise) -> Self {
        let error = estimate.least_standard_error;
        Self {
            variance: estimate.variance,
            standard_error: Some(error).filter(|error| error.is_finite()),
            at_limit: estimate.at_boundary || !error.is_finite(),
        }
    }
}

impl SharedFrischEstimate {
    /// The model of the estimate, for the record that it was fitted to. The standard errors of the
    /// variances are those of the best estimate from the same covariances, a lower bound here.
    ///
    /// # Errors
    /// As [`EivModel::from_rows`].
    pub fn model(&self, data: &Dataset) -> Result<EivModel, IdentError> {
        let mut outputs: Vec<ChannelNoise> = self.channels.iter().map(ChannelNoise::from).collect();
        let inputs = outputs.split_off(self.rows.len().min(outputs.len()));
        EivModel::from_rows(data, &self.rows, None, outputs, inputs)
    }
}

/// An identified errors-in-variables model.
///
/// `relation` is the equation of the noise-free channels, in deviations from the means of the
/// record; everything that takes an [`ArxModel`] takes it. Its one-step prediction from measured
/// channels is not the best there is (the noise passes through it): that is a Kalman filter with
/// these variances.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct EivModel {
    relation: ArxModel,
    output_noise: Vec<ChannelNoise>,
    input_noise: Vec<ChannelNoise>,
}

/// The fields of an [`EivModel`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    relation: ArxModel,
    output_noise: Vec<ChannelNoise>,
    input_noise: Vec<ChannelNoise>,
}

impl TryFrom<Unchecked> for EivModel {
    type Error = IdentError;

    fn try_from(raw: Unchecked) -> Result<Self, IdentError> {
        Self::new(raw.relation, raw.output_noise, raw.input_noise)
    }
}

impl EivModel {
    /// A relation with the noise of its outputs (ny) and inputs (nu).
    ///
    /// # Errors
    /// [`IdentError::Dimension`] for another number of entries, [`IdentError::ModelValue`] for a
    /// variance or standard error that is negative or not finite.
    pub fn new(
        relation: ArxModel,
        output_noise: Vec<ChannelNoise>,
        input_noise: Vec<ChannelNoise>,
    ) -> Result<Self, IdentError> {
        let (ny, nu) = (relation.outputs().len(), relation.inputs().len());
        DimensionError::check("output noise", ny, output_noise.len())?;
        DimensionError::check("input noise", nu, input_noise.len())?;
        let names = relation.outputs().iter().chain(relation.inputs());
        for (signal, noise) in names.zip(output_noise.iter().chain(&input_noise)) {
            for (what, value) in [
                ("variance", Some(noise.variance)),
                ("standard error of the variance", noise.standard_error),
            ] {
                let Some(found) = value else { continue };
                if !(0.0..f64::INFINITY).contains(&found) {
                    return Err(IdentError::ModelValue {
                        what: format!("noise of `{}`, {what}", signal.name),
                        expected: "a finite number of at least 0",
                        found,
                    });
                }
            }
        }
        Ok(Self {
            relation,
            output_noise,
            input_noise,
        })
    }

    /// The model of a record's channels from the relation of each output (ny) and the noise.
    ///
    /// All rows get the lags of the longest; what a shorter one has not is zero. `deviations` are
    /// the standard deviations of each row's coefficients, where there are any. The relation's
    /// residual variances are those of its equation errors on the record, noise and all.
    ///
    /// # Errors
    /// What [`Arx::fit`] refuses of the record with these lags, and as [`EivModel::new`].
    pub fn from_rows(
        data: &Dataset,
        rows: &[EivRow],
        deviations: Option<&[DVector<f64>]>,
        output_noise: Vec<ChannelNoise>,
        input_noise: Vec<ChannelNoise>,
    ) -> Result<Self, IdentError> {
        DimensionError::check("relations (outputs)", data.ny(), rows.len())?;
        for row in rows {
            DimensionError::check("inputs of a relation", data.nu(), row.lags().inputs())?;
        }
        let na = rows.iter().map(|row| row.lags().order()).max().unwrap_or(0);
        let smallest = |input: usize| rows.iter().map(move |row| row.lags().nk()[input]).min();
        let nk: Vec<usize> = (0..data.nu())
            .map(|input| smallest(input).unwrap_or(0))
            .collect();
        let nb = nk.iter().map(|nk| na + 1 - nk).collect();
        // The equation-error model of the same lags has the same channels, rows and condition.
        let fitted = Arx::new(ArxStructure::Diagonal { na, nb, nk }).fit(data)?;
        let deviations = deviations
            .map(|lists| {
                let pairs = rows.iter().zip(lists);
                pairs
                    .map(|(row, list)| EivRow::new(row.lags().clone(), list.clone()))
                    .collect::<Result<Vec<_>, _>>()
            })
            .transpose()?;
        let relation = fitted.with_coefficients(
            data,
            |output, regressor| coefficient(&rows[output], regressor),
            deviations.map(|lists| {
                move |output: usize, regressor| coefficient(&lists[output], regressor).abs()
            }),
        )?;
        Self::new(relation, output_noise, input_noise)
    }

    /// The relation between the noise-free channels.
    pub fn relation(&self) -> &ArxModel {
        &self.relation
    }

    /// The noise of the outputs (ny).
    pub fn output_noise(&self) -> &[ChannelNoise] {
        &self.output_noise
    }

    /// The noise of the inputs (nu).
    pub fn input_noise(&self) -> &[ChannelNoise] {
        &self.input_noise
    }

    /// Outputs, then inputs, each with its noise.
    pub fn noise(&self) -> impl Iterator<Item = (&Signal, &ChannelNoise)> {
        let outputs = self.relation.outputs().iter().zip(&self.output_noise);
        outputs.chain(self.relation.inputs().iter().zip(&self.input_noise))
    }
}

/// The coefficient of a regressor in a relation; zero where it has none.
fn coefficient(row: &EivRow, regressor: Regressor) -> f64 {
    let lag = regressor.lag;
    let found = match regressor.channel {
        Channel::Output(_) => lag.checked_sub(1).and_then(|k| row.a().get(k)).map(|a| -a),
        Channel::Input(input) => lag
            .checked_sub(row.lags().nk()[input])
            .and_then(|k| row.b(input).get(k))
            .copied(),
    };
    found.unwrap_or(0.0)
}
