//! What healthy residuals look like: their mean, their covariance and their colour.

use gt_core::stored_matrix;
use nalgebra::{Cholesky, DMatrix, DVector};
use serde::{Deserialize, Serialize};

use crate::FdiError;
use crate::runtime;

/// The longest autoregression that is tried.
pub const MAX_WHITENING_ORDER: usize = 30;
/// Samples needed for each coefficient of an autoregression and each residual of a covariance.
const SAMPLES_A_COEFFICIENT: usize = 4;
/// Share of the diagonal that is added to correlations: two channels that hold the same number to
/// printing accuracy would otherwise make the digits after it the most telling residual of all.
const CORRELATION_FLOOR: f64 = 1e-3;

/// How `m` residuals become white with unit variance while the plant is healthy:
/// `v = W (r - mean)` with `W W' = L^-1` of their covariance `L`, lower triangular; then, for each
/// component, `z(t) = (v(t) + a_1 v(t-1) + ... + a_p v(t-p)) / s`.
///
/// A bias of the model stands in the mean and its errors in the colour: after whitening, what is
/// computed for white residuals holds for real ones, as far as the healthy records go. A lasting
/// deviation `d` of a residual becomes `d (1 + a_1 + ... + a_p) / s`, which is less than the
/// residual's own standard deviation says where the residual wanders by itself, and rightly so.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct Whitening {
    mean: DVector<f64>,
    factor: DMatrix<f64>,
    coefficients: Vec<Vec<f64>>,
    scale: DVector<f64>,
}

/// The fields of a [`Whitening`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    mean: DVector<f64>,
    #[serde(deserialize_with = "stored_matrix")]
    factor: DMatrix<f64>,
    coefficients: Vec<Vec<f64>>,
    scale: DVector<f64>,
}

impl TryFrom<Unchecked> for Whitening {
    type Error = FdiError;

    fn try_from(raw: Unchecked) -> Result<Self, FdiError> {
        let size = raw.mean.len();
        if size == 0 {
            return Err(FdiError::NoHealthyData);
        }
        let sizes = [
            ("rows of factor", raw.factor.nrows()),
            ("columns of factor", raw.factor.ncols()),
            ("components with coefficients", raw.coefficients.len()),
            ("scales", raw.scale.len()),
        ];
        for (what, found) in sizes {
            gt_core::DimensionError::check(&format!("whitening, {what}"), size, found)?;
        }
        let order = raw.coefficients.first().map_or(0, Vec::len);
        let orders = raw.coefficients.iter().map(Vec::len);
        let odd = orders
            .into_iter()
            .find(|&own| own != order || own > MAX_WHITENING_ORDER);
        if let Some(found) = odd {
            return Err(FdiError::Option {
                option: "whitening coefficients",
                expected: "as many for each component, at most 30",
                found: found as f64,
            });
        }
        let numbers = raw.mean.iter().chain(&raw.factor).chain(&raw.scale);
        let mut numbers = numbers.chain(raw.coefficients.iter().flatten());
        if let Some(&found) = numbers.find(|value| !value.is_finite()) {
            return Err(FdiError::Option {
                option: "whitening",
                expected: "finite numbers",
                found,
            });
        }
        let diagonal = raw.factor.diagonal();
        let mut scales = diagonal.iter().chain(&raw.scale);
        if let Some(&found) = scales.find(|&&value| value <= 0.0) {
            return Err(FdiError::Option {
                option: "whitening scale",
                expected: "a number above 0",
                found,
            });
        }
        Ok(Self {
            mean: raw.mean,
            factor: raw.factor,
            coefficients: raw.coefficients,
            scale: raw.scale,
        })
    }
}

impl Whitening {
    /// The whitening of healthy residuals: a matrix (m x N) a record, a column a sample.
    ///
    /// Correlations between residuals get a floor of 1e-3 on their diagonal. Without `colour` the
    /// order is 0; with it each component has the autoregression of the order that the Bayesian
    /// information criterion chooses, up to [`MAX_WHITENING_ORDER`], by the Yule-Walker equations
    /// over all records (Levinson's recursion), so that the polynomial's zeros lie inside the unit
    /// circle.
    ///
    /// # Errors
    /// [`FdiError::NoHealthyData`] without a sample, [`FdiError::HealthySamples`] with fewer than
    /// four for each residual, [`FdiError::ConstantResidual`] of one that does not move.
    pub fn estimate(records: &[&DMatrix<f64>], colour: bool) -> Result<Self, FdiError> {
        let samples: usize = records.iter().map(|record| record.ncols()).sum();
        let size = records.first().map_or(0, |record| record.nrows());
        if samples == 0 || size == 0 {
            return Err(FdiError::NoHealthyData);
        }
        let needed = SAMPLES_A_COEFFICIENT * (size + 1);
        if samples < needed {
            return Err(FdiError::HealthySamples {
                record: 0,
                needed,
                found: samples,
            });
        }
        let mut mean = DVector::zeros(size);
        for record in records {
            mean += record.column_sum();
        }
        mean /= samples as f64;
        let mut covariance = DMatrix::zeros(size, size);
        let centred: Vec<DMatrix<f64>> = records.iter().map(|record| less(record, &mean)).collect();
        for record in &centred {
            covariance += record * record.transpose();
        }
        covariance /= samples as f64;
        let factor = inverse_root(&covariance)?;
        if !colour {
            return Ok(Self {
                mean,
                factor,
                coefficients: vec![Vec::new(); size],
                scale: DVector::from_element(size, 1.0),
            });
        }
        let highest = MAX_WHITENING_ORDER.min(samples / SAMPLES_A_COEFFICIENT / 5);
        let components: Vec<DMatrix<f64>> = centred.iter().map(|record| &factor * record).collect();
        let mut coefficients = Vec::with_capacity(size);
        let mut scale = DVector::zeros(size);
        for row in 0..size {
            let (own, deviation) = autoregression(&components, row, highest, samples);
            coefficients.push(own);
            scale[row] = deviation;
        }
        let longest = coefficients.iter().map(Vec::len).max().unwrap_or(0);
        for own in &mut coefficients {
            own.resize(longest, 0.0);
        }
        Ok(Self {
            mean,
            factor,
            coefficients,
            scale,
        })
    }

    /// The healthy means (m) in the residuals' units.
    pub fn mean(&self) -> &DVector<f64> {
        &self.mean
    }

    /// `W (m x m)`, in inverse units of the residuals.
    pub fn factor(&self) -> &DMatrix<f64> {
        &self.factor
    }

    /// For each component the coefficients `a_1 .. a_p`.
    pub fn coefficients(&self) -> &[Vec<f64>] {
        &self.coefficients
    }

    /// The standard deviations `s` (m) of what the autoregressions leave.
    pub fn scale(&self) -> &DVector<f64> {
        &self.scale
    }

    /// The order `p` of the autoregressions, the same for all components.
    pub fn order(&self) -> usize {
        self.coefficients.first().map_or(0, Vec::len)
    }

    /// The lasting deviation of a single residual, in its unit, that moves `z` by one standard
    /// deviation; of several residuals it has no meaning.
    pub fn unit(&self) -> f64 {
        let sum: f64 = self.coefficients[0].iter().sum();
        self.scale[0] / (self.factor[(0, 0)] * (1.0 + sum))
    }

    pub(crate) fn runtime(&self) -> runtime::Whitener {
        runtime::Whitener::new(runtime::Whitening {
            mean: self.mean.as_slice().to_vec(),
            factor: self.factor.transpose().as_slice().to_vec(),
            coefficients: self.coefficients.clone(),
            scale: self.scale.as_slice().to_vec(),
        })
    }
}

fn less(record: &DMatrix<f64>, mean: &DVector<f64>) -> DMatrix<f64> {
    let mut centred = record.clone();
    for mut column in centred.column_iter_mut() {
        column -= mean;
    }
    centred
}

/// The lower triangular `W` with `W L W' = I` for the covariance with the floor on its diagonal.
fn inverse_root(covariance: &DMatrix<f64>) -> Result<DMatrix<f64>, FdiError> {
    let size = covariance.nrows();
    let deviations = covariance.diagonal().map(f64::sqrt);
    let still = |deviation: &f64| !(*deviation > 0.0 && deviation.is_finite());
    if let Some(index) = deviations.iter().position(still) {
        return Err(FdiError::ConstantResidual {
            index,
            found: deviations[index],
        });
    }
    let correlations = DMatrix::from_fn(size, size, |row, column| {
        let correlation = covariance[(row, column)] / deviations[row] / deviations[column];
        if row == column || size == 1 {
            1.0
        } else {
            (1.0 - CORRELATION_FLOOR) * correlation
        }
    });
    let scaled = Cholesky::new(correlations)
        .and_then(|factor| {
            factor
                .l()
                .solve_lower_triangular(&DMatrix::identity(size, size))
        })
        .ok_or(FdiError::ConstantResidual {
            index: 0,
            found: 0.0,
        })?;
    Ok(DMatrix::from_fn(size, size, |row, column| {
        scaled[(row, column)] / deviations[column]
    }))
}

/// The autoregression of one component with the standard deviation of what it leaves.
fn autoregression(
    components: &[DMatrix<f64>],
    row: usize,
    highest: usize,
    samples: usize,
) -> (Vec<f64>, f64) {
    let lagged = |lag: usize| -> f64 {
        let sums = components.iter().map(|record| {
            let own = record.row(row);
            (lag..own.len()).map(|t| own[t] * own[t - lag]).sum::<f64>()
        });
        sums.sum::<f64>() / samples as f64
    };
    let covariances: Vec<f64> = (0..=highest).map(lagged).collect();
    let penalty = (samples as f64).ln() / samples as f64;
    let mut coefficients: Vec<f64> = Vec::new();
    let mut variance = covariances[0];
    let mut best = (variance.ln(), Vec::new(), variance);
    for order in 1..=highest {
        let terms = coefficients.iter().enumerate();
        let ahead = terms.fold(covariances[order], |sum, (index, coefficient)| {
            sum + coefficient * covariances[order - 1 - index]
        });
        let reflection = -ahead / variance;
        let reversed: Vec<f64> = coefficients.iter().rev().copied().collect();
        for (own, other) in coefficients.iter_mut().zip(reversed) {
            *own += reflection * other;
        }
        coefficients.push(reflection);
        variance *= 1.0 - reflection * reflection;
        if variance.is_nan() || variance <= f64::EPSILON * covariances[0] {
            break;
        }
        let criterion = variance.ln() + order as f64 * penalty;
        if criterion < best.0 {
            best = (criterion, coefficients.clone(), variance);
        }
    }
    (best.1, best.2.sqrt())
}
