//! The criteria by name.

use serde::{Deserialize, Serialize};

use super::Criterion;

/// Lags beyond the order, of the criteria that look at some.
pub const CRITERION_LAGS: usize = 5;

/// How an order becomes a [`Criterion`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CriterionKind {
    /// [`Criterion::ShiftRelation`].
    Shift,
    /// [`Criterion::CovarianceMatch`] with [`CRITERION_LAGS`] lags more than the order.
    Covariance,
    /// [`Criterion::HighOrderYuleWalker`] with [`CRITERION_LAGS`] lags.
    #[default]
    YuleWalker,
}

impl CriterionKind {
    /// The criterion for a relation of the given order.
    pub fn criterion(self, order: usize) -> Criterion {
        match self {
            Self::Shift => Criterion::ShiftRelation,
            Self::Covariance => Criterion::CovarianceMatch {
                lags: order.saturating_add(CRITERION_LAGS),
            },
            Self::YuleWalker => Criterion::HighOrderYuleWalker {
                lags: CRITERION_LAGS,
            },
        }
    }
}
