//! The dynamic Frisch scheme for one output.

use gt_core::{Dataset, DimensionError, Never, Stop};

use super::covariance::{LaggedCovariance, ScaledRecord};
use super::criterion::{Criterion, Objective};
use super::estimate::{FrischEstimate, channel_noise, in_units};
use super::moment_system::MomentSystem;
use super::search::least_shares;
use super::surface::{AdmissibleSurface, SurfacePoint};
use crate::IdentError;
use crate::eiv::EivLags;

/// The dynamic Frisch scheme, still to be fitted: white noise on the inputs and on the output,
/// nothing known of its size.
///
/// | Option | Default | Purpose |
/// |---|---|---|
/// | `lags` | none | order of the relation and smallest lag of each input |
/// | `criterion` | high-order Yule-Walker, 5 lags | which admissible variances are chosen |
#[derive(Debug, Clone, PartialEq)]
pub struct Frisch {
    lags: EivLags,
    criterion: Criterion,
}

impl Frisch {
    /// A relation of the given lags, with the default criterion.
    pub fn new(lags: EivLags) -> Self {
        Self {
            lags,
            criterion: Criterion::default(),
        }
    }

    /// The same with another criterion.
    #[must_use]
    pub fn criterion(mut self, criterion: Criterion) -> Self {
        self.criterion = criterion;
        self
    }

    pub(crate) fn lags(&self) -> &EivLags {
        &self.lags
    }

    pub(crate) fn selection(&self) -> Criterion {
        self.criterion
    }

    /// The relation and the noise of `output` from a record.
    ///
    /// The means of the whole record are removed and the channels scaled to unit deviation; all
    /// covariances are taken on the window `t = L..N` with `L` the longest lag of the criterion
    /// ([`Criterion::max_lag`]). Results are in the units of the channels.
    ///
    /// # Errors
    /// [`IdentError::Dimension`] where the lags are of another number of inputs;
    /// [`IdentError::CriterionLags`]; [`IdentError::TooFewRows`]; [`IdentError::NoSuchOutput`];
    /// [`IdentError::Data`] for a sample that is not finite; [`IdentError::ConstantChannel`];
    /// [`IdentError::RankDeficient`] where the lagged channels depend on each other, as they do
    /// without any noise and with equal channels; [`IdentError::NoRelation`] where no admissible
    /// point has a relation for `y(t)`.
    pub fn fit(&self, data: &Dataset, output: usize) -> Result<FrischEstimate, IdentError> {
        self.check(data)?;
        let record = ScaledRecord::new(data, output)?;
        let max_lag = self.criterion.max_lag(self.lags.order());
        let covariance = LaggedCovariance::of_scaled(&record, max_lag)?;
        let chosen = self.choose(&covariance, &Never)?;
        let errors = noise_errors(&self.lags, &record, &covariance, &chosen.1);
        self.estimate(&covariance, chosen, &errors, output)
    }

    /// The relation and the noise from given covariances, for example the exact ones of a process.
    ///
    /// # Errors
    /// [`IdentError::Dimension`] where the covariances have other inputs or end below
    /// [`Criterion::max_lag`]; [`IdentError::CriterionLags`]; [`IdentError::RankDeficient`];
    /// [`IdentError::NoRelation`].
    pub fn fit_covariance(
        &self,
        covariance: &LaggedCovariance,
    ) -> Result<FrischEstimate, IdentError> {
        let exact = vec![0.0; covariance.scales().len()];
        self.estimate(covariance, self.choose(covariance, &Never)?, &exact, 0)
    }

    fn estimate(
        &self,
        covariance: &LaggedCovariance,
        (surface, point, criterion_value): (AdmissibleSurface, SurfacePoint, f64),
        errors: &[f64],
        output: usize,
    ) -> Result<FrischEstimate, IdentError> {
        let scales = covariance.scales();
        let (row, noise) = in_units(&self.lags, &point, covariance)?;
        Ok(FrischEstimate {
            row,
            noise,
            channels: channel_noise(&point, surface.intercepts(), errors, scales, output),
            criterion_value,
            window_rows: covariance.window_rows(),
        })
    }

    /// The point that the criterion chooses, its surface and the value there.
    pub(crate) fn choose(
        &self,
        covariance: &LaggedCovariance,
        stop: &dyn Stop,
    ) -> Result<(AdmissibleSurface, SurfacePoint, f64), IdentError> {
        let objective = Objective::new(&self.lags, self.criterion, covariance)?;
        let surface = objective.surface();
        let point_at = |shares: &[f64]| {
            let pairs = shares.iter().zip(surface.intercepts());
            let direction: Vec<f64> = pairs.map(|(share, largest)| share * largest).collect();
            surface.along(&direction)
        };
        let value_at = |shares: &[f64]| {
            if stop.is_stopped() {
                return f64::INFINITY;
            }
            point_at(shares).map_or(f64::INFINITY, |point| objective.value(&point))
        };
        let least = least_shares(surface.intercepts().len(), value_at);
        stop.check()?;
        let Some((shares, value)) = least else {
            return Err(IdentError::NoRelation {
                output: covariance.names()[0].clone(),
            });
        };
        let point = point_at(&shares)?;
        Ok((objective.into_surface(), point, value))
    }

    /// Refuses lags and records that do not fit each other, before anything is allocated.
    pub(crate) fn check(&self, data: &Dataset) -> Result<(), IdentError> {
        DimensionError::check("inputs of the lags", data.nu(), self.lags.inputs())?;
        let order = self.lags.order();
        self.criterion.check(order)?;
        check_rows(&self.lags, self.criterion, data.len())
    }
}

/// The least standard errors of the variances at a point, the output first; infinite where the
/// covariances do not determine them.
pub(crate) fn noise_errors(
    lags: &EivLags,
    record: &ScaledRecord,
    covariance: &LaggedCovariance,
    point: &SurfacePoint,
) -> Vec<f64> {
    let errors = MomentSystem::new(lags, record, covariance).errors(point);
    errors.map_or_else(
        || vec![f64::INFINITY; point.variances.len()],
        |errors| errors.iter().skip(lags.parameters()).copied().collect(),
    )
}

/// Refuses a record with fewer window rows than entries of the longest regression vector plus one.
pub(crate) fn check_rows(
    lags: &EivLags,
    criterion: Criterion,
    samples: usize,
) -> Result<(), IdentError> {
    let order = lags.order();
    // Order n + 1 has an entry more for each channel; counted for every criterion.
    let own = order.saturating_add(2);
    let entries = lags.nk().iter().fold(own, |sum, &first| {
        sum.saturating_add(own).saturating_sub(first)
    });
    let needed = criterion
        .max_lag(order)
        .saturating_add(entries)
        .saturating_add(1);
    if samples >= needed {
        return Ok(());
    }
    Err(IdentError::TooFewRows {
        structure: format!("Frisch scheme of order {order}, nk {:?}", lags.nk()),
        needed,
        found: samples,
    })
}
