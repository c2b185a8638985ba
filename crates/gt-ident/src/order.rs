//! The choice of the order: criteria of several orders on one window.

use std::ops::RangeInclusive;

use gt_core::Dataset;
use serde::{Deserialize, Serialize};

use crate::factor::{RowFit, Spread, WindowFactor};
use crate::{ArxStructure, IdentError, generic_indices};

/// How an order becomes a structure.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum OrderKind {
    /// Own-output lags only: `na = order`, and for each input `order` lags from `nk`, one more
    /// where `nk = 0`, so that a direct term does not cost a delayed one.
    Diagonal {
        /// Smallest input lag, one entry or one per input.
        nk: Vec<usize>,
    },
    /// All outputs' lags, input lags as for `Diagonal`.
    Full {
        /// Smallest input lag, one entry or one per input.
        nk: Vec<usize>,
    },
    /// Canonical with the [`generic_indices`] of the total order.
    Canonical {
        /// Whether `u(t)` acts on `y(t)`.
        feedthrough: bool,
    },
}

impl OrderKind {
    /// The structure of the given order for `ny` outputs.
    ///
    /// # Errors
    /// [`IdentError::OrderTooSmall`] for a canonical order below the number of outputs.
    pub fn structure(&self, order: usize, ny: usize) -> Result<ArxStructure, IdentError> {
        let lags = |nk: &[usize]| -> Vec<usize> {
            nk.iter()
                .map(|nk| order.saturating_add(usize::from(*nk == 0)))
                .collect()
        };
        Ok(match self {
            Self::Diagonal { nk } => ArxStructure::Diagonal {
                na: order,
                nb: lags(nk),
                nk: nk.clone(),
            },
            Self::Full { nk } => ArxStructure::Full {
                na: order,
                nb: lags(nk),
                nk: nk.clone(),
            },
            Self::Canonical { feedthrough } => ArxStructure::Canonical {
                indices: generic_indices(order, ny)?,
                feedthrough: *feedthrough,
            },
        })
    }
}

/// One order of an [`OrderTable`].
///
/// With `T` window rows, `d` parameters, `m` outputs and the residual covariance `S = E E' / T`:
/// AIC `= T ln det S + 2 d`, MDL `= T ln det S + d ln T`,
/// FPE `= det S ((T + d/m) / (T - d/m))^m`, which for one output is Akaike's final prediction
/// error and for several its multivariate form (Luetkepohl 2005, eq. 4.3.2).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OrderRow {
    /// The order: lags for diagonal and full structures, the sum of the indices for canonical.
    pub order: usize,
    /// Number of parameters `d` of the whole model.
    pub parameters: usize,
    /// Residual sum of squares over T, one per output, in squared units of the output.
    pub residual_variance: Vec<f64>,
    /// `ln det S`; minus infinity where the residuals are linearly dependent.
    pub ln_det: f64,
    /// Akaike's information criterion.
    pub aic: f64,
    /// Minimum description length.
    pub mdl: f64,
    /// Final prediction error.
    pub fpe: f64,
    /// `100 std(e) / std(y)` one step ahead over the window; for several outputs the root mean
    /// square of theirs.
    pub ppcre_percent: f64,
    /// The largest condition of the rows' column-scaled regressors. Beyond
    /// [`crate::CONDITION_LIMIT`] the order cannot be fitted and is never best; its residuals are
    /// those without the dependent regressors.
    pub condition: f64,
}

/// The criteria of several orders, all on the same window.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OrderTable {
    /// Rows of the window: the samples from the longest lag of the highest order on.
    pub window_rows: usize,
    /// One entry per order, ascending.
    pub rows: Vec<OrderRow>,
    best_aic: usize,
    best_mdl: usize,
    best_fpe: usize,
}

impl OrderTable {
    /// The order of the smallest AIC.
    pub fn best_aic(&self) -> usize {
        self.best_aic
    }

    /// The order of the smallest MDL.
    pub fn best_mdl(&self) -> usize {
        self.best_mdl
    }

    /// The order of the smallest FPE.
    pub fn best_fpe(&self) -> usize {
        self.best_fpe
    }
}

/// The criteria of all `orders` on one window, `t = L..N` with `L` the longest lag of the highest
/// order; the means of the whole record are removed.
///
/// The record is factorised once, in blocks of rows, with every lag of the highest order as a
/// column. Orders whose regressors contain those of the order before then share a second, small
/// factorisation, of which each takes a leading block. Conditions of more than 64 regressors are
/// estimates from below, to a few per cent.
///
/// # Errors
/// [`IdentError::OrderRange`], and for the highest order what [`crate::Arx::fit`] refuses; linearly
/// dependent regressors ([`IdentError::RankDeficient`]) only where no order is free of them.
pub fn order_table(
    data: &Dataset,
    orders: RangeInclusive<usize>,
    kind: &OrderKind,
) -> Result<OrderTable, IdentError> {
    let (first, last) = (*orders.start(), *orders.end());
    if first == 0 || first > last {
        return Err(IdentError::OrderRange { first, last });
    }
    let (nu, ny) = (data.nu(), data.ny());
    kind.structure(first, ny)?.validate(nu, ny)?;
    kind.structure(last, ny)?
        .check_rows(nu, ny, 0, data.len())?;
    let structures = orders
        .clone()
        .map(|order| kind.structure(order, ny))
        .collect::<Result<Vec<_>, _>>()?;
    let factor = WindowFactor::new(data, &structures)?;
    let mut fits = Vec::with_capacity(ny);
    for output in 0..ny {
        let steps = structures
            .iter()
            .map(|structure| structure.regressors(output, nu, ny))
            .collect::<Result<Vec<_>, _>>()?;
        fits.push(factor.fit_steps(output, &steps));
    }
    let mut refused = None;
    let mut rows = Vec::with_capacity(structures.len());
    for (step, (order, structure)) in orders.zip(&structures).enumerate() {
        let model: Vec<&RowFit> = fits.iter().filter_map(|rows| rows.get(step)).collect();
        if let Some(error) = model.iter().find_map(|row| row.refused.as_ref()) {
            refused.get_or_insert_with(|| error.clone());
        }
        let parameters = structure.parameters(nu, ny);
        let spread = factor.spread(&model);
        rows.push(OrderRow::new(order, parameters, factor.rows, spread));
    }
    let usable = |row: &&OrderRow| row.condition <= crate::CONDITION_LIMIT;
    let best = |criterion: fn(&OrderRow) -> f64| {
        let candidates = rows.iter().filter(usable);
        candidates
            .min_by(|a, b| criterion(a).total_cmp(&criterion(b)))
            .map(|row| row.order)
    };
    match (
        best(|row| row.aic),
        best(|row| row.mdl),
        best(|row| row.fpe),
        refused,
    ) {
        (Some(best_aic), Some(best_mdl), Some(best_fpe), _) => {
            let window_rows = factor.rows;
            Ok(OrderTable {
                window_rows,
                rows,
                best_aic,
                best_mdl,
                best_fpe,
            })
        }
        (.., Some(error)) => Err(error),
        // Not reached: without a usable order each of them has been refused.
        _ => Err(IdentError::OrderRange { first, last }),
    }
}

impl OrderRow {
    fn new(order: usize, parameters: usize, window_rows: usize, spread: Spread) -> Self {
        let criteria = Criteria::new(&spread, parameters, window_rows);
        Self {
            order,
            parameters,
            residual_variance: spread.residual_variance,
            ln_det: spread.ln_det,
            aic: criteria.aic,
            mdl: criteria.mdl,
            fpe: criteria.fpe,
            ppcre_percent: 100.0 * spread.relative_variance.max(0.0).sqrt(),
            condition: spread.condition,
        }
    }
}

/// The criteria of one model, as [`OrderRow`] defines them.
pub(crate) struct Criteria {
    pub aic: f64,
    pub mdl: f64,
    pub fpe: f64,
}

impl Criteria {
    pub fn new(spread: &Spread, parameters: usize, window_rows: usize) -> Self {
        let (t, d) = (window_rows as f64, parameters as f64);
        let m = spread.residual_variance.len() as f64;
        Self {
            aic: t * spread.ln_det + 2.0 * d,
            mdl: t * spread.ln_det + d * t.ln(),
            fpe: (spread.ln_det + m * ((t + d / m) / (t - d / m)).ln()).exp(),
        }
    }
}
