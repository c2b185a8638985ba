//! The order of an errors-in-variables relation, from covariances on one window.

use std::ops::RangeInclusive;

use gt_core::{Dataset, Never, Stop};
use serde::{Deserialize, Serialize};

use super::covariance::{LaggedCovariance, ScaledRecord};
use super::criterion::Criterion;
use super::fit::{Frisch, check_rows};
use super::moments::weighted;
use super::search::least_shares;
use super::surface::{AdmissibleSurface, regression_vector};
use crate::IdentError;
use crate::eiv::EivLags;
use crate::symmetric::symmetric_eigen;

/// Lags of the high-order Yule-Walker equations of the highest order.
const LAGS: usize = 5;

/// What the covariances say of one order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrischOrderRow {
    /// The order `n`.
    pub order: usize,
    /// The least part by which the surface of order `n + 1` lies below that of order `n` along a
    /// ray from the origin, 0 to 1: zero from the true order on with exact covariances, where the
    /// surfaces touch at the true variances.
    pub surface_gap: f64,
    /// The least high-order Yule-Walker criterion, for channels of unit deviation: zero from the
    /// true order on with exact covariances.
    pub yule_walker: f64,
    /// Smallest over largest singular value of the high-order Yule-Walker matrix `E z phi'`: zero
    /// from the true order on with exact covariances.
    pub rank_ratio: f64,
    /// The optimally weighted sum of squares of all moments times the window rows, near
    /// `degrees_of_freedom` at the true order; `None` where the moments do not determine the
    /// relation, as beyond the true order.
    pub statistic: Option<f64>,
    /// Moments less unknowns.
    pub degrees_of_freedom: usize,
    /// `statistic - degrees_of_freedom ln T`, the smaller the better (Andrews 1999, "Consistent
    /// moment selection procedures for generalized method of moments estimation", MMSC-BIC).
    pub selection: Option<f64>,
}

/// Several orders on the same window, with the same moments.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrischOrderTable {
    /// Rows of the window: the samples from lag `n + 5` of the highest order on.
    pub window_rows: usize,
    /// One entry per order, ascending.
    pub rows: Vec<FrischOrderRow>,
}

impl FrischOrderTable {
    /// The order of the least [`FrischOrderRow::selection`]; `None` where no order has one.
    pub fn best(&self) -> Option<usize> {
        let candidates = self.rows.iter();
        let selections = candidates.filter_map(|row| Some((row.order, row.selection?)));
        selections
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(order, _)| order)
    }
}

/// What the covariances of a record say of each of `orders` for `output`, input lags from `nk` (one
/// per input) on.
///
/// All orders use the covariances up to lag `n + 5` of the highest, on one window.
///
/// # Errors
/// [`IdentError::OrderRange`]; [`IdentError::EivLag`] where the lowest order is below an `nk`; for
/// the highest order what [`Frisch::fit`] refuses.
pub fn frisch_order_table(
    data: &Dataset,
    output: usize,
    orders: RangeInclusive<usize>,
    nk: &[usize],
) -> Result<FrischOrderTable, IdentError> {
    frisch_order_table_until(data, output, orders, nk, &Never)
}

/// As [`frisch_order_table`], until `stop` wants it to end.
///
/// # Errors
/// As [`frisch_order_table`]; [`IdentError::Stopped`].
pub fn frisch_order_table_until(
    data: &Dataset,
    output: usize,
    orders: RangeInclusive<usize>,
    nk: &[usize],
    stop: &dyn Stop,
) -> Result<FrischOrderTable, IdentError> {
    let (first, last) = (*orders.start(), *orders.end());
    if first == 0 || first > last {
        return Err(IdentError::OrderRange { first, last });
    }
    let criterion = Criterion::HighOrderYuleWalker { lags: LAGS };
    EivLags::new(first, nk.to_vec())?;
    let highest = EivLags::new(last, nk.to_vec())?;
    gt_core::DimensionError::check("inputs of the lags", data.nu(), highest.inputs())?;
    check_rows(&highest, criterion, data.len())?;
    let record = ScaledRecord::new(data, output)?;
    let covariance = LaggedCovariance::of_scaled(&record, criterion.max_lag(last))?;
    let rows = orders.map(|order| row(order, nk, &record, &covariance, stop));
    Ok(FrischOrderTable {
        rows: rows.collect::<Result<_, _>>()?,
        window_rows: covariance.window_rows(),
    })
}

fn row(
    order: usize,
    nk: &[usize],
    record: &ScaledRecord,
    covariance: &LaggedCovariance,
    stop: &dyn Stop,
) -> Result<FrischOrderRow, IdentError> {
    let lags = EivLags::new(order, nk.to_vec())?;
    let longer = EivLags::new(order + 1, nk.to_vec())?;
    let frisch = Frisch::new(lags.clone()).criterion(Criterion::HighOrderYuleWalker { lags: LAGS });
    let (yule_walker, statistic) = match weighted(&frisch, record, covariance, stop) {
        Ok((_, solution)) => (solution.start_value, Some(solution.statistic)),
        // Beyond the true order a cancelling factor may leave the moments singular.
        Err(IdentError::MomentsSingular { .. }) => (frisch.choose(covariance, stop)?.2, None),
        Err(error) => return Err(error),
    };
    let surfaces = (
        AdmissibleSurface::new(&lags, covariance)?,
        AdmissibleSurface::new(&longer, covariance)?,
    );
    let gap = surface_gap(&surfaces.0, &surfaces.1, stop);
    stop.check()?;
    let moments = (1 + lags.inputs()) * (covariance.max_lag() + 1);
    let degrees_of_freedom = moments.saturating_sub(lags.parameters() + 1 + lags.inputs());
    let penalty = degrees_of_freedom as f64 * (covariance.window_rows() as f64).ln();
    Ok(FrischOrderRow {
        order,
        surface_gap: gap,
        yule_walker,
        rank_ratio: rank_ratio(&lags, covariance),
        statistic,
        degrees_of_freedom,
        selection: statistic.map(|statistic| statistic - penalty),
    })
}

/// The least of `1 - |P'| / |P|` over rays, `P` and `P'` on the surfaces of order `n` and `n + 1`.
fn surface_gap(surface: &AdmissibleSurface, longer: &AdmissibleSurface, stop: &dyn Stop) -> f64 {
    let gap = |shares: &[f64]| {
        if stop.is_stopped() {
            return f64::INFINITY;
        }
        let pairs = shares.iter().zip(surface.intercepts());
        let direction: Vec<f64> = pairs.map(|(share, largest)| share * largest).collect();
        let lengths = (
            surface.eigen_along(&direction),
            longer.eigen_along(&direction),
        );
        match lengths {
            (Ok(upper), Ok(lower)) => (1.0 - lower.scale / upper.scale).max(0.0),
            _ => f64::INFINITY,
        }
    };
    least_shares(surface.intercepts().len(), gap).map_or(f64::NAN, |(_, gap)| gap)
}

/// Smallest over largest singular value of `E z phi'`, `z` all channels at lags `n+1..=n+5`.
fn rank_ratio(lags: &EivLags, covariance: &LaggedCovariance) -> f64 {
    let z: Vec<_> = (0..=lags.inputs())
        .flat_map(|channel| (1..=LAGS).map(move |k| (channel, lags.order() + k)))
        .collect();
    let phi = covariance.columns(&regression_vector(lags));
    let cross = covariance.columns(&z).tr_mul(&phi);
    if cross.nrows() < cross.ncols() {
        return 0.0;
    }
    symmetric_eigen(cross.tr_mul(&cross)).map_or(f64::NAN, |(values, _)| {
        let (least, most) = (values[0].max(0.0), values[values.len() - 1]);
        (least / most).sqrt()
    })
}
