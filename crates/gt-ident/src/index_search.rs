//! The choice of the canonical indices.

use std::collections::HashMap;
use std::ops::RangeInclusive;

use gt_core::Dataset;
use serde::{Deserialize, Serialize};

use crate::factor::{RowFit, WindowFactor};
use crate::order::Criteria;
use crate::{ArxStructure, IdentError, Regressor, generic_indices};

/// The largest number of index sets that [`index_table`] compares.
pub const INDEX_SET_LIMIT: usize = 5000;

/// One set of indices of an [`IndexTable`]. The criteria are those of [`crate::OrderRow`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IndexRow {
    /// `v_i`, one per output.
    pub indices: Vec<usize>,
    /// The order: their sum.
    pub order: usize,
    /// Number of parameters `d` of the whole model.
    pub parameters: usize,
    /// `ln det` of the covariance of the equation errors.
    pub ln_det: f64,
    /// Akaike's information criterion.
    pub aic: f64,
    /// Minimum description length.
    pub mdl: f64,
    /// The largest condition of the rows' column-scaled regressors; beyond
    /// [`crate::CONDITION_LIMIT`] the indices are never best.
    pub condition: f64,
}

/// The criteria of several index sets, all on the same window.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IndexTable {
    /// Rows of the window.
    pub window_rows: usize,
    /// Ascending by order; within an order the generic indices come first, then by distance.
    pub rows: Vec<IndexRow>,
    best_aic: usize,
    best_mdl: usize,
}

impl IndexTable {
    /// The row of the smallest AIC.
    pub fn best_aic(&self) -> &IndexRow {
        &self.rows[self.best_aic]
    }

    /// The row of the smallest MDL.
    pub fn best_mdl(&self) -> &IndexRow {
        &self.rows[self.best_mdl]
    }
}

/// The criteria of canonical structures of all `orders` (the sum of the indices), for all index
/// sets that differ from the [`generic_indices`] of their order by at most `spread` in each index.
///
/// One factorisation of the record serves all, on one window: the rows from the longest lag of any
/// set on. Rows that several sets have in common are fitted once.
///
/// # Errors
/// [`IdentError::OrderRange`], [`IdentError::OrderTooSmall`], [`IdentError::TooManyIndexSets`], and
/// for the largest set what [`crate::Arx::fit`] refuses; linearly dependent regressors
/// ([`IdentError::RankDeficient`]) only where no set is free of them.
pub fn index_table(
    data: &Dataset,
    orders: RangeInclusive<usize>,
    spread: usize,
    feedthrough: bool,
) -> Result<IndexTable, IdentError> {
    let (first, last) = (*orders.start(), *orders.end());
    if first == 0 || first > last {
        return Err(IdentError::OrderRange { first, last });
    }
    let (nu, ny) = (data.nu(), data.ny());
    // Before anything is allocated: the highest order alone must fit the record.
    let canonical = |indices: Vec<usize>| ArxStructure::Canonical {
        indices,
        feedthrough,
    };
    canonical(generic_indices(last, ny)?).check_rows(nu, ny, 0, data.len())?;
    let mut sets: Vec<Vec<usize>> = Vec::new();
    for order in orders {
        let generic = generic_indices(order, ny)?;
        near(&generic, spread, &mut sets)?;
    }
    let structures: Vec<ArxStructure> = sets.iter().cloned().map(canonical).collect();
    let longest = structures.iter().map(|each| each.max_lag(nu)).max();
    for structure in &structures {
        structure.check_rows(nu, ny, longest.unwrap_or(0), data.len())?;
    }
    let factor = WindowFactor::new(data, &structures)?;
    let mut known: HashMap<(usize, Vec<Regressor>), RowFit> = HashMap::new();
    let mut rows = Vec::with_capacity(sets.len());
    let mut refused = None;
    for (indices, structure) in sets.into_iter().zip(&structures) {
        let keys = (0..ny)
            .map(|output| Ok((output, structure.regressors(output, nu, ny)?)))
            .collect::<Result<Vec<_>, IdentError>>()?;
        for key in &keys {
            if !known.contains_key(key) {
                known.insert(key.clone(), factor.fit(key.0, &key.1));
            }
        }
        let model: Vec<&RowFit> = keys.iter().filter_map(|key| known.get(key)).collect();
        if let Some(error) = model.iter().find_map(|row| row.refused.as_ref()) {
            refused.get_or_insert_with(|| error.clone());
        }
        let spread = factor.spread(&model);
        let parameters = structure.parameters(nu, ny);
        let criteria = Criteria::new(&spread, parameters, factor.rows);
        rows.push(IndexRow {
            order: indices.iter().sum(),
            indices,
            parameters,
            ln_det: spread.ln_det,
            aic: criteria.aic,
            mdl: criteria.mdl,
            condition: spread.condition,
        });
    }
    let best = |criterion: fn(&IndexRow) -> f64| {
        let usable = rows
            .iter()
            .enumerate()
            .filter(|(_, row)| row.condition <= crate::CONDITION_LIMIT);
        usable
            .min_by(|a, b| criterion(a.1).total_cmp(&criterion(b.1)))
            .map(|(position, _)| position)
    };
    match (best(|row| row.aic), best(|row| row.mdl), refused) {
        (Some(best_aic), Some(best_mdl), _) => Ok(IndexTable {
            window_rows: factor.rows,
            rows,
            best_aic,
            best_mdl,
        }),
        (.., Some(error)) => Err(error),
        // Not reached: without a usable set each of them has been refused.
        _ => Err(IdentError::OrderRange { first, last }),
    }
}

/// Appends the sets of the same sum within `spread` of `generic`, nearest first.
fn near(generic: &[usize], spread: usize, sets: &mut Vec<Vec<usize>>) -> Result<(), IdentError> {
    let order: usize = generic.iter().sum();
    let mut partial: Vec<Vec<usize>> = vec![Vec::new()];
    for (position, &index) in generic.iter().enumerate() {
        let mut longer = Vec::new();
        let left = generic.len() - position - 1;
        for set in &partial {
            let used: usize = set.iter().sum();
            let low = index.saturating_sub(spread).max(1);
            let high = index
                .saturating_add(spread)
                .min(order.saturating_sub(used + left));
            for value in low..=high {
                let mut next = set.clone();
                next.push(value);
                longer.push(next);
            }
            if sets.len() + longer.len() > INDEX_SET_LIMIT {
                return Err(IdentError::TooManyIndexSets {
                    limit: INDEX_SET_LIMIT,
                    spread,
                });
            }
        }
        partial = longer;
    }
    partial.retain(|set| set.iter().sum::<usize>() == order);
    let distance = |set: &Vec<usize>| -> usize {
        let pairs = set.iter().zip(generic);
        pairs.map(|(&a, &b)| a.abs_diff(b)).sum()
    };
    partial.sort_by_key(|set| distance(set));
    sets.extend(partial);
    Ok(())
}
