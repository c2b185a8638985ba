//! Which point of the admissible surface is the noise: the selection criteria.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::covariance::LaggedCovariance;
use super::surface::{AdmissibleSurface, SurfacePoint, channel_terms, regression_vector};
use crate::IdentError;
use crate::eiv::EivLags;

/// How the noise variances are chosen among the admissible ones.
///
/// Each criterion is at least zero, and zero at the true variances with exact covariances. With
/// `c = (1, a, -b)` the relation at the point `P`:
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Criterion {
    /// The relation and its copy one sample earlier hold at order `n + 1`: with `P'` where the ray
    /// through `P` meets the surface of order `n + 1` and `V` the two copies,
    /// `tr V' (Sigma_{n+1} - diag(P')) V` (Beghelli, Guidorzi and Soverini 1990).
    ShiftRelation,
    /// The residual `c' phi(t)` has the autocovariances of white noise filtered by `c`, at lags
    /// `1..=lags` (Diversi, Guidorzi and Soverini 2003, "A new criterion in EIV identification and
    /// filtering applications"). Needs more lags than the order.
    CovarianceMatch {
        /// Number of lags.
        lags: usize,
    },
    /// The residual is not correlated with channels older than itself:
    /// `|| E z(t) phi(t)' c ||^2` with `z` all channels at lags `n + 1..=n + lags`.
    HighOrderYuleWalker {
        /// Number of lags.
        lags: usize,
    },
}

impl Default for Criterion {
    /// High-order Yule-Walker with 5 lags.
    fn default() -> Self {
        Self::HighOrderYuleWalker { lags: 5 }
    }
}

impl Criterion {
    /// The largest lag of the covariances that the criterion needs for a relation of order `n`.
    pub fn max_lag(&self, order: usize) -> usize {
        match *self {
            Self::ShiftRelation => order.saturating_add(1),
            Self::CovarianceMatch { lags } | Self::HighOrderYuleWalker { lags } => {
                order.saturating_add(lags)
            }
        }
    }

    /// Refuses too few lags for an order.
    ///
    /// # Errors
    /// [`IdentError::CriterionLags`].
    pub fn check(&self, order: usize) -> Result<(), IdentError> {
        let (criterion, needed, found) = match *self {
            Self::ShiftRelation => return Ok(()),
            Self::CovarianceMatch { lags } => ("covariance_match", order.saturating_add(1), lags),
            Self::HighOrderYuleWalker { lags } => ("high_order_yule_walker", 1, lags),
        };
        if found >= needed {
            return Ok(());
        }
        Err(IdentError::CriterionLags {
            criterion,
            needed,
            found,
        })
    }
}

/// A criterion with everything of it that does not depend on the point.
pub(crate) struct Objective {
    surface: AdmissibleSurface,
    parts: Parts,
}

enum Parts {
    /// The surface of order `n + 1`.
    Shift(AdmissibleSurface),
    /// `E phi(t) phi(t-k)'` for `k = 1..=q`.
    Match(Vec<DMatrix<f64>>),
    /// `E z phi'`.
    YuleWalker(DMatrix<f64>),
}

impl Objective {
    pub fn new(
        lags: &EivLags,
        criterion: Criterion,
        covariance: &LaggedCovariance,
    ) -> Result<Self, IdentError> {
        let order = lags.order();
        criterion.check(order)?;
        let largest = criterion.max_lag(order);
        let known = largest.min(covariance.max_lag());
        gt_core::DimensionError::check("lags of the covariances", largest, known)?;
        let surface = AdmissibleSurface::new(lags, covariance)?;
        let phi = regression_vector(lags);
        let columns = covariance.columns(&phi);
        let parts = match criterion {
            Criterion::ShiftRelation => {
                let longer = EivLags::new(order + 1, lags.nk().to_vec())?;
                Parts::Shift(AdmissibleSurface::new(&longer, covariance)?)
            }
            Criterion::CovarianceMatch { lags: count } => Parts::Match(
                (1..=count)
                    .map(|k| {
                        let late: Vec<_> = phi
                            .iter()
                            .map(|&(channel, lag)| (channel, lag + k))
                            .collect();
                        columns.tr_mul(&covariance.columns(&late))
                    })
                    .collect(),
            ),
            Criterion::HighOrderYuleWalker { lags: count } => {
                let z: Vec<_> = (0..=covariance.inputs())
                    .flat_map(|channel| (order + 1..=order + count).map(move |lag| (channel, lag)))
                    .collect();
                Parts::YuleWalker(covariance.columns(&z).tr_mul(&columns))
            }
        };
        Ok(Self { surface, parts })
    }

    pub fn surface(&self) -> &AdmissibleSurface {
        &self.surface
    }

    pub fn into_surface(self) -> AdmissibleSurface {
        self.surface
    }

    /// The criterion at a point; infinite where it has no value.
    pub fn value(&self, point: &SurfacePoint) -> f64 {
        let value = match &self.parts {
            Parts::Shift(longer) => self.shift(longer, point),
            Parts::Match(covariances) => Some(self.covariance_match(covariances, point)),
            Parts::YuleWalker(cross) => Some((cross * &point.relation).norm_squared()),
        };
        value
            .filter(|value| value.is_finite())
            .unwrap_or(f64::INFINITY)
    }

    fn shift(&self, longer: &AdmissibleSurface, point: &SurfacePoint) -> Option<f64> {
        let ray = longer.eigen_along(&point.variances).ok()?;
        let mut copies = DMatrix::zeros(ray.relative.len(), 2);
        let (mut from, mut to) = (0, 0);
        for channel in 0..point.variances.len() {
            let terms = channel_terms(self.surface.lags(), channel);
            let part = point.relation.rows(from, terms);
            copies.view_mut((to, 0), (terms, 1)).copy_from(&part);
            copies.view_mut((to + 1, 1), (terms, 1)).copy_from(&part);
            from += terms;
            to += terms + 1;
        }
        // A sum of terms that are not negative: nothing cancels where the criterion vanishes.
        let rotated = ray.vectors.tr_mul(&longer.root_times(&copies));
        let terms = rotated.row_iter().zip(ray.relative.iter());
        Some(
            terms
                .map(|(row, &relative)| (1.0 - relative).max(0.0) * row.norm_squared())
                .sum(),
        )
    }

    fn covariance_match(&self, covariances: &[DMatrix<f64>], point: &SurfacePoint) -> f64 {
        let c = &point.relation;
        let matches = covariances.iter().enumerate().map(|(index, covariance)| {
            let noise = residual_covariance(self.surface.lags(), point, index + 1);
            (c.dot(&(covariance * c)) - noise).powi(2)
        });
        matches.sum()
    }
}

/// `sum_j sigma_j^2 sum_l c_{j,l} c_{j,l+k}`: what the noise adds to the residual's autocovariance.
pub(crate) fn residual_covariance(lags: &EivLags, point: &SurfacePoint, k: usize) -> f64 {
    let mut first = 0;
    let mut sum = 0.0;
    for (channel, &variance) in point.variances.iter().enumerate() {
        let terms = channel_terms(lags, channel);
        let part = &point.relation.as_slice()[first..first + terms];
        let products = part.iter().zip(part.iter().skip(k));
        sum += variance * products.map(|(a, b)| a * b).sum::<f64>();
        first += terms;
    }
    sum
}
