//! Optimally weighted moments: the extended compensated least squares.

use gt_core::{Dataset, Never, Stop};
use nalgebra::{Cholesky, DVector};

use super::covariance::{LaggedCovariance, ScaledRecord};
use super::criterion::Criterion;
use super::estimate::{in_units, unscaled, variances};
use super::fit::Frisch;
use super::moment_system::MomentSystem;
use super::surface::SurfacePoint;
use crate::IdentError;
use crate::eiv::{EivLags, EivRow, NoiseVariances};

/// Times that the weight is taken at a new estimate.
const REWEIGHTINGS: usize = 2;
/// Gauss-Newton steps for one weight, and halvings of a step.
const STEPS: usize = 50;
const HALVINGS: usize = 30;
/// A start nearer to zero than this part of the largest variance is moved to it.
const LEAST_SHARE: f64 = 1e-3;

/// Relation and noise variances from all covariances of `z` (all channels at lags `0..=n + lags`)
/// with the residual, weighted by the inverse covariance of their errors: a generalised method of
/// moments, still to be fitted.
///
/// It starts at the Frisch estimate of high-order Yule-Walker and solves for the logarithms of the
/// variances. Asymptotically the best of all estimates that use these covariances (Hansen 1982;
/// Soederstroem 2018, ch. 7, "generalised instrumental variables").
#[derive(Debug, Clone, PartialEq)]
pub struct WeightedMoments {
    lags: EivLags,
    moment_lags: usize,
}

/// A relation, its noise variances and their standard errors.
#[derive(Debug, Clone, PartialEq)]
pub struct MomentsEstimate {
    /// The relation between the noise-free channels.
    pub row: EivRow,
    /// The noise variances, in squared units of the channels.
    pub noise: NoiseVariances,
    /// Standard errors of the coefficients, in their units and order.
    pub coefficient_error: DVector<f64>,
    /// Standard errors of the variances.
    pub noise_error: NoiseVariances,
    /// Window rows times the weighted sum of squares of the moments: for the right lags and
    /// Gaussian white noise chi-square of `degrees_of_freedom` in large records.
    pub statistic: f64,
    /// Moments less unknowns.
    pub degrees_of_freedom: usize,
    /// Rows of the window.
    pub window_rows: usize,
}

impl WeightedMoments {
    /// A relation of the given lags, from covariances up to lag `n + 5`.
    pub fn new(lags: EivLags) -> Self {
        Self {
            lags,
            moment_lags: 5,
        }
    }

    /// The same from covariances up to lag `n + lags`.
    #[must_use]
    pub fn moment_lags(mut self, lags: usize) -> Self {
        self.moment_lags = lags;
        self
    }

    /// The relation and the noise of `output` from a record.
    ///
    /// # Errors
    /// What [`Frisch::fit`] refuses, and [`IdentError::MomentsSingular`] where the moments do not
    /// determine every coefficient and every variance.
    pub fn fit(&self, data: &Dataset, output: usize) -> Result<MomentsEstimate, IdentError> {
        let criterion = Criterion::HighOrderYuleWalker {
            lags: self.moment_lags,
        };
        let frisch = Frisch::new(self.lags.clone()).criterion(criterion);
        frisch.check(data)?;
        let record = ScaledRecord::new(data, output)?;
        let max_lag = criterion.max_lag(self.lags.order());
        let covariance = LaggedCovariance::of_scaled(&record, max_lag)?;
        let (system, solution) = weighted(&frisch, &record, &covariance, &Never)?;
        let singular = || IdentError::MomentsSingular {
            output: record.names[0].clone(),
        };
        let point = &solution.point;
        let errors = system.errors(point).ok_or_else(singular)?;

        let scales = &record.scales;
        let p = self.lags.parameters();
        let coefficient_error = EivRow::new(self.lags.clone(), errors.rows(0, p).into_owned())?;
        let (row, noise) = in_units(&self.lags, point, &covariance)?;
        Ok(MomentsEstimate {
            row,
            noise,
            coefficient_error: unscaled(&coefficient_error, scales)?.theta().clone(),
            noise_error: variances(&errors.as_slice()[p..], scales),
            statistic: solution.statistic,
            degrees_of_freedom: system.surplus(),
            window_rows: covariance.window_rows(),
        })
    }
}

/// A point that weighted moments choose.
pub(crate) struct Solution {
    pub point: SurfacePoint,
    /// Window rows times the weighted sum of squares of the moments.
    pub statistic: f64,
    /// The criterion of the Frisch estimate that it starts from.
    pub start_value: f64,
}

/// The moments at all lags of the covariances and the point that they choose, from the Frisch
/// estimate on.
pub(crate) fn weighted(
    frisch: &Frisch,
    record: &ScaledRecord,
    covariance: &LaggedCovariance,
    stop: &dyn Stop,
) -> Result<(MomentSystem, Solution), IdentError> {
    let (surface, mut point, start_value) = frisch.choose(covariance, stop)?;
    for (variance, largest) in point.variances.iter_mut().zip(surface.intercepts()) {
        *variance = variance.max(LEAST_SHARE * largest);
    }
    let system = MomentSystem::new(frisch.lags(), record, covariance);
    let singular = || IdentError::MomentsSingular {
        output: covariance.names()[0].clone(),
    };
    let mut root = system.weight_root(&point).ok_or_else(singular)?;
    for _ in 0..REWEIGHTINGS {
        stop.check()?;
        point = solve(&system, point, &root).ok_or_else(singular)?;
        root = system.weight_root(&point).ok_or_else(singular)?;
    }
    let whitened = system.whiten(&point, &root).ok_or_else(singular)?;
    let statistic = whitened.moments.norm_squared();
    if !statistic.is_finite() {
        return Err(singular());
    }
    let solution = Solution {
        point,
        statistic,
        start_value,
    };
    Ok((system, solution))
}

/// The least weighted sum of squares for one weight, by Gauss-Newton steps in the coefficients and
/// the logarithms of the variances.
fn solve(
    system: &MomentSystem,
    mut point: SurfacePoint,
    root: &nalgebra::DMatrix<f64>,
) -> Option<SurfacePoint> {
    let parameters = point.relation.len() - 1;
    let own = system.own_terms();
    for _ in 0..STEPS {
        let now = system.whiten(&point, root)?;
        let mut jacobian = now.jacobian;
        for (index, variance) in point.variances.iter().enumerate() {
            let mut column = jacobian.column_mut(parameters + index);
            column *= *variance;
        }
        let mut normal = jacobian.tr_mul(&jacobian);
        for index in 0..normal.nrows() {
            // Enough for a variance that nothing determines to stay where it is.
            normal[(index, index)] *= 1.0 + 1e-9;
        }
        let step = Cholesky::new(normal)?.solve(&jacobian.tr_mul(&now.moments));
        let least = now.moments.norm_squared();
        let mut factor = 1.0;
        let mut moved = None;
        for _ in 0..HALVINGS {
            let next = shifted(&point, &(&step * -factor), own);
            let value = system.whiten(&next, root)?.moments.norm_squared();
            if value < least {
                moved = Some((next, value));
                break;
            }
            factor *= 0.5;
        }
        let Some((next, value)) = moved else { break };
        point = next;
        if least - value <= 1e-12 * (1.0 + least) {
            break;
        }
    }
    Some(point)
}

/// A point moved by a step in `(a, b, ln sigma^2)`.
fn shifted(point: &SurfacePoint, step: &DVector<f64>, own: usize) -> SurfacePoint {
    /// A step in a logarithm beyond it is a variance that leaves the scale.
    const LARGEST_STEP: f64 = 3.0;
    let mut next = point.clone();
    let parameters = point.relation.len() - 1;
    for index in 0..parameters {
        let change = step[index];
        // The coefficients of the inputs enter the relation with a minus.
        next.relation[index + 1] += if index < own { change } else { -change };
    }
    for (variance, change) in next.variances.iter_mut().zip(step.iter().skip(parameters)) {
        *variance *= change.clamp(-LARGEST_STEP, LARGEST_STEP).exp();
    }
    next
}
