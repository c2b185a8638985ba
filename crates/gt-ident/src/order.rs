//! The choice of the order (section 2 of the identification specification).

use std::ops::RangeInclusive;

use gt_core::Dataset;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::arx::{check_channels, check_solution};
use crate::least_squares::{LeastSquares, triangular_factor};
use crate::regressor::{Deviations, check_varies};
use crate::{ArxStructure, Channel, IdentError, Regressor, generic_indices};

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
#[derive(Debug, Clone, PartialEq, Serialize)]
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
#[derive(Debug, Clone, PartialEq, Serialize)]
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
/// The record is factorised once, with every lag of the highest order as a column; each order is
/// then a least-squares problem on columns of the small triangular factor.
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
    let highest = kind.structure(last, ny)?;
    highest.check_rows(nu, ny, 0, data.len())?;
    let largest = (0..ny)
        .map(|output| highest.regressors(output, nu, ny))
        .collect::<Result<Vec<_>, _>>()?;
    data.check_finite()?;
    check_channels(data, &largest)?;

    let factor = Factor::new(data, &highest)?;
    let mut rows = Vec::with_capacity(last - first + 1);
    let mut refused = None;
    for order in orders {
        let structure = kind.structure(order, ny)?;
        rows.push(factor.row(data, order, &structure, &mut refused)?);
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
            let window_rows = factor.window_rows;
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

/// The triangular factor of all lagged channels of the window and a column of ones.
struct Factor {
    r: DMatrix<f64>,
    nu: usize,
    ny: usize,
    window_rows: usize,
}

impl Factor {
    fn new(data: &Dataset, highest: &ArxStructure) -> Result<Self, IdentError> {
        let (nu, ny) = (data.nu(), data.ny());
        let longest = highest.max_lag(nu);
        let record = Deviations::new(data, &data.mean())?;
        let window = longest..data.len();
        for (index, signal) in data.outputs().iter().enumerate() {
            check_varies(signal, data.y().row(index).iter().skip(longest).copied())?;
        }
        let mut columns = Vec::with_capacity((longest + 1) * (nu + ny));
        for lag in 0..=longest {
            let outputs = (0..ny).map(Channel::Output);
            let channels = outputs.chain((0..nu).map(Channel::Input));
            columns.extend(channels.map(|channel| Regressor { channel, lag }));
        }
        let mut stacked = record.design(&columns, &window);
        let ones = stacked.ncols();
        stacked = stacked.insert_column(ones, 1.0);
        Ok(Self {
            r: triangular_factor(&stacked),
            nu,
            ny,
            window_rows: window.len(),
        })
    }

    fn column(&self, regressor: Regressor) -> usize {
        let channel = match regressor.channel {
            Channel::Output(index) => index,
            Channel::Input(index) => self.ny + index,
        };
        regressor.lag * (self.nu + self.ny) + channel
    }

    /// The criteria of one order; a refused solution is kept in `refused`.
    fn row(
        &self,
        data: &Dataset,
        order: usize,
        structure: &ArxStructure,
        refused: &mut Option<IdentError>,
    ) -> Result<OrderRow, IdentError> {
        let (t, m) = (self.window_rows as f64, self.ny as f64);
        let ones = self.r.column(self.r.ncols() - 1);
        let mut residuals = DMatrix::zeros(self.r.nrows(), self.ny);
        let mut condition = 1.0_f64;
        let mut relative_variance = 0.0;
        for output in 0..self.ny {
            let mut regressors = structure.regressors(output, self.nu, self.ny)?;
            let chosen: Vec<usize> = regressors.iter().map(|&each| self.column(each)).collect();
            let mut design = self.r.select_columns(&chosen);
            let target = self.r.select_columns(&[output]);
            let mut solution = LeastSquares::new(&design, &target);
            condition = condition.max(solution.condition);
            while let Err(error) = check_solution(data, output, &regressors, &solution) {
                if !matches!(error, IdentError::RankDeficient { .. }) {
                    return Err(error);
                }
                refused.get_or_insert(error);
                // What a dependent column explains, the others explain as well.
                regressors.remove(solution.weakest);
                design = design.remove_column(solution.weakest);
                solution = LeastSquares::new(&design, &target);
            }
            let residual = &target - &design * &solution.coefficients;
            // Inner products in rotated coordinates are those over the window: with the ones, sums.
            let variance = |column: &DMatrix<f64>| {
                column.norm_squared() / t - (column.column(0).dot(&ones) / t).powi(2)
            };
            relative_variance += variance(&residual) / variance(&target);
            residuals.set_column(output, &residual.column(0));
        }
        let residual_variance = residuals
            .column_iter()
            .map(|e| e.norm_squared() / t)
            .collect();
        let triangle = triangular_factor(&residuals);
        let diagonal = triangle.diagonal();
        let ln_det = diagonal
            .iter()
            .map(|value| 2.0 * value.abs().ln() - t.ln())
            .sum::<f64>();
        let parameters = structure.parameters(self.nu, self.ny);
        let d = parameters as f64;
        Ok(OrderRow {
            order,
            parameters,
            residual_variance,
            ln_det,
            aic: t * ln_det + 2.0 * d,
            mdl: t * ln_det + d * t.ln(),
            fpe: (ln_det + m * ((t + d / m) / (t - d / m)).ln()).exp(),
            ppcre_percent: 100.0 * (relative_variance / m).max(0.0).sqrt(),
            condition,
        })
    }
}
