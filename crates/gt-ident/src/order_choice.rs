//! What the order of a model shall be.

use std::ops::RangeInclusive;

use gt_core::Dataset;

use crate::{ArxStructure, IdentError, OrderKind, OrderTable, generic_indices, order_table};

/// Orders of ARX models that [`OrderChoice::Automatic`] looks at.
const AUTOMATIC_ORDERS: RangeInclusive<usize> = 1..=12;

/// An order that is known, or the orders to choose from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum OrderChoice {
    /// This one.
    Given(usize),
    /// The best of these.
    Search(RangeInclusive<usize>),
    /// The best of those that the method looks at by itself, as far as the record bears them.
    Automatic,
}

/// The structure of an order, and what that was chosen by.
#[derive(Debug, Clone, PartialEq)]
pub struct ChosenStructure {
    /// The structure.
    pub structure: ArxStructure,
    /// What the orders were compared by, where they were.
    pub orders: Option<OrderTable>,
    /// The orders that were looked at, where the record is too short for all of an automatic
    /// choice.
    pub shortened: Option<RangeInclusive<usize>>,
}

impl OrderKind {
    /// The orders of a range that have a structure for so many outputs: canonical ones from the number
    /// of outputs on, of the others all.
    ///
    /// # Errors
    /// [`IdentError::OrderTooSmall`] where none has.
    pub fn searched(
        &self,
        orders: RangeInclusive<usize>,
        outputs: usize,
    ) -> Result<RangeInclusive<usize>, IdentError> {
        match self {
            Self::Canonical { .. } => {
                generic_indices(*orders.end(), outputs)?;
                Ok((*orders.start()).max(outputs)..=*orders.end())
            }
            Self::Diagonal { .. } | Self::Full { .. } => Ok(orders),
        }
    }

    /// The structure of an order, or of the one with the smallest MDL on a record; an automatic
    /// choice looks at the orders 1 to 12. Canonical orders below the number of outputs, which
    /// leave an output without a row of its own, are left out of a search.
    ///
    /// # Errors
    /// [`IdentError::OrderTooSmall`] for a canonical order, or highest order, below the number of
    /// outputs; as [`order_table`].
    pub fn choose(
        &self,
        data: &Dataset,
        order: &OrderChoice,
    ) -> Result<ChosenStructure, IdentError> {
        let outputs = data.ny();
        let (orders, shrinks) = match order {
            OrderChoice::Given(order) => {
                return Ok(ChosenStructure {
                    structure: self.structure(*order, outputs)?,
                    orders: None,
                    shortened: None,
                });
            }
            OrderChoice::Search(orders) => (orders.clone(), false),
            OrderChoice::Automatic => (AUTOMATIC_ORDERS, true),
        };
        let orders = self.searched(orders, outputs)?;
        let (low, mut high) = orders.clone().into_inner();
        let table = loop {
            match order_table(data, low..=high, self) {
                Err(IdentError::TooFewRows { .. }) if shrinks && high > low => high -= 1,
                result => break result?,
            }
        };
        Ok(ChosenStructure {
            structure: self.structure(table.best_mdl(), outputs)?,
            orders: Some(table),
            shortened: (high < *orders.end()).then_some(low..=high),
        })
    }
}
