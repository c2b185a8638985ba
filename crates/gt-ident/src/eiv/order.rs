//! The choice of the order of an errors-in-variables model.

use std::ops::RangeInclusive;

use gt_core::{Dataset, Never, Stop};
use serde::{Deserialize, Serialize};

use super::fit::default_frequencies;
use super::joint::{Joint, estimate};
use super::record::{Record, autoregression_order};
use super::row::EivLags;
use crate::IdentError;

/// One order of an [`EivOrderTable`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EivOrderRow {
    /// The order `n` of every output's relation.
    pub order: usize,
    /// Number of coefficients `d` of all relations; the variances are the same for every order.
    pub parameters: usize,
    /// `f` of [`super::Likelihood`] at the estimate of this order.
    pub criterion: f64,
    /// Akaike's information criterion, `N f + 2 d`.
    pub aic: f64,
    /// The Bayesian information criterion, `N f + d ln N`.
    pub bic: f64,
    /// Whether the descent met its tolerance.
    pub converged: bool,
}

/// The likelihoods of several orders, all from one spectrum of the whole record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EivOrderTable {
    /// Samples of the record, `N`.
    pub samples: usize,
    /// Order of the autoregression behind the spectrum.
    pub autoregression_order: usize,
    /// Frequencies at which the likelihood was taken.
    pub frequencies: usize,
    /// One entry per order, ascending.
    pub rows: Vec<EivOrderRow>,
    best_aic: usize,
    best_bic: usize,
}

impl EivOrderTable {
    /// The order of the smallest AIC. It takes too high an order in about half of all records.
    pub fn best_aic(&self) -> usize {
        self.best_aic
    }

    /// The order of the smallest BIC, the one to use.
    pub fn best_bic(&self) -> usize {
        self.best_bic
    }
}

/// The criteria of `orders` with input lags from `nk` (one entry per input) on, for every output.
///
/// The spectrum is that of the longest order, the same for all, so that the likelihoods can be
/// compared. Each order also starts from the one below it, times factors that cancel; an order can
/// therefore not end above a lower one, but for its tighter bounds on the variances.
///
/// # Errors
/// [`IdentError::OrderRange`]; [`IdentError::EivLag`] where a smallest lag exceeds the first
/// order; and what [`super::Eiv::fit`] refuses.
pub fn eiv_order_table(
    data: &Dataset,
    orders: RangeInclusive<usize>,
    nk: &[usize],
) -> Result<EivOrderTable, IdentError> {
    eiv_order_table_until(data, orders, nk, &Never)
}

/// As [`eiv_order_table`], until `stop` wants it to end.
///
/// # Errors
/// As [`eiv_order_table`]; [`IdentError::Stopped`].
pub fn eiv_order_table_until(
    data: &Dataset,
    orders: RangeInclusive<usize>,
    nk: &[usize],
    stop: &dyn Stop,
) -> Result<EivOrderTable, IdentError> {
    let (first, last) = (*orders.start(), *orders.end());
    if first == 0 || first > last {
        return Err(IdentError::OrderRange { first, last });
    }
    Record::check(data, data.ny(), nk.len())?;
    EivLags::new(first, nk.to_vec())?;
    let (samples, outputs) = (data.len(), data.ny());
    let channels = (outputs + data.nu()).max(1);
    let order = autoregression_order(last, channels, samples);
    let record = Record::new(data, order, default_frequencies(outputs))?;
    let mut below: Option<Joint> = None;
    let mut rows = Vec::new();
    for order in orders {
        let lags = vec![EivLags::new(order, nk.to_vec())?; outputs];
        let joint = estimate(&record.spectrum, &lags, &[], below.as_ref(), 0.0, stop)?;
        let parameters = lags.iter().map(EivLags::parameters).sum::<usize>();
        let (fit, count) = (samples as f64 * joint.together.value, parameters as f64);
        rows.push(EivOrderRow {
            order,
            parameters,
            criterion: joint.together.value,
            aic: fit + 2.0 * count,
            bic: fit + count * (samples as f64).ln(),
            converged: joint.together.converged,
        });
        below = Some(joint);
    }
    let best = |criterion: fn(&EivOrderRow) -> f64| {
        let smallest = rows
            .iter()
            .min_by(|a, b| criterion(a).total_cmp(&criterion(b)));
        smallest.map_or(first, |row| row.order)
    };
    let (best_aic, best_bic) = (best(|row| row.aic), best(|row| row.bic));
    Ok(EivOrderTable {
        samples,
        autoregression_order: order,
        frequencies: record.spectrum.frequencies(),
        rows,
        best_aic,
        best_bic,
    })
}
