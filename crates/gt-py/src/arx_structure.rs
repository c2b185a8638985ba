//! The options that describe the structure of an ARX model.

use std::sync::Arc;

use gtfdi::core::Dataset;
use gtfdi::ident::{ArxStructure, IdentError, OrderChoice, OrderKind};
use serde::{Deserialize, Serialize};

use crate::choice::named;
use crate::error::Failure;
use crate::order::{Numbers, Order, smallest_lags};

/// The names of the structures.
#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    Canonical,
    Full,
    Diagonal,
}

impl Kind {
    /// The structure of that name.
    pub fn read(name: &str) -> Result<Self, Failure> {
        if name == "diagonal" {
            return Ok(Self::Diagonal);
        }
        let names = [
            ("canonical", Self::Canonical),
            ("full", Self::Full),
            ("diag", Self::Diagonal),
        ];
        named("structure", name, &names)
    }

    /// The structures of this name with the smallest lags `nk`.
    pub fn family(self, nk: Vec<usize>) -> Result<OrderKind, Failure> {
        Ok(match self {
            Self::Canonical => OrderKind::Canonical {
                feedthrough: feedthrough(&nk)?,
            },
            Self::Full => OrderKind::Full { nk },
            Self::Diagonal => OrderKind::Diagonal { nk },
        })
    }
}

/// The direct term that `nk` means in a canonical structure.
fn feedthrough(nk: &[usize]) -> Result<bool, Failure> {
    match nk {
        [1] => Ok(false),
        [0] => Ok(true),
        _ => Err(Failure::Option {
            option: "nk",
            expected: "1, or 0 for a direct term, for all inputs of a canonical structure"
                .to_owned(),
            found: format!("{nk:?}"),
        }),
    }
}

/// What a structure is described by, as given.
#[derive(Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct StructureOptions {
    pub order: Option<Order>,
    pub na: Option<usize>,
    pub nb: Option<Numbers>,
    pub nk: Option<Numbers>,
    pub indices: Option<Vec<usize>>,
    pub structure: Option<String>,
}

/// The options as a structure, or as a family of structures with the order to choose.
enum Wish {
    Structure(ArxStructure),
    Order(OrderKind, OrderChoice),
}

impl StructureOptions {
    /// The structure for that many outputs, by the command line's rules.
    fn wish(&self, outputs: usize) -> Result<Wish, Failure> {
        let refuse = |option, expected: &str, found: &str| {
            Err(Failure::Option {
                option,
                expected: expected.to_owned(),
                found: found.to_owned(),
            })
        };
        let lags = self.na.is_some() || self.nb.is_some();
        let ways = [self.order.is_some(), self.indices.is_some(), lags];
        match ways.into_iter().filter(|&way| way).count() {
            0 => return refuse("order", "order, indices, or na and nb", "none of them"),
            1 => {}
            _ => return refuse("order", "one of order, indices and na/nb", "several"),
        }
        let several = self.indices.is_some() || self.order.is_some() && outputs > 1;
        let kind = match &self.structure {
            Some(name) => Kind::read(name)?,
            None if several => Kind::Canonical,
            None => Kind::Full,
        };
        let nk = smallest_lags(self.nk.clone());
        let order = self.order.as_ref().map(Order::read).transpose()?;
        match (order, &self.indices, self.na, self.nb.clone()) {
            (Some(order), ..) => Ok(Wish::Order(kind.family(nk)?, order)),
            (None, Some(indices), ..) if kind == Kind::Canonical => {
                Ok(Wish::Structure(ArxStructure::Canonical {
                    indices: indices.clone(),
                    feedthrough: feedthrough(&nk)?,
                }))
            }
            (None, Some(_), ..) => refuse("structure", "canonical with indices", "full or diag"),
            (None, None, Some(na), Some(nb)) => {
                let nb = nb.into();
                match kind {
                    Kind::Canonical => {
                        refuse("structure", "order or indices with canonical", "na and nb")
                    }
                    Kind::Full => Ok(Wish::Structure(ArxStructure::Full { na, nb, nk })),
                    Kind::Diagonal => Ok(Wish::Structure(ArxStructure::Diagonal { na, nb, nk })),
                }
            }
            (None, None, Some(_), None) => refuse("nb", "nb beside na", "na alone"),
            (None, None, None, _) => refuse("na", "na beside nb", "nb alone"),
        }
    }

    /// The structure to fit to the records, and what the caller should know of the choice. Orders
    /// are compared on one record.
    pub fn choose(
        &self,
        records: &[Arc<Dataset>],
    ) -> Result<(ArxStructure, Option<String>), Failure> {
        let data = records.first().ok_or(IdentError::NoRecords)?;
        let (kind, order) = match self.wish(data.ny())? {
            Wish::Structure(structure) => return Ok((structure, None)),
            Wish::Order(kind, order) => (kind, order),
        };
        if records.len() > 1 && !matches!(order, OrderChoice::Given(_)) {
            return Err(Failure::Option {
                option: "order",
                expected: "a number with several records: orders are compared on one".to_owned(),
                found: "a search".to_owned(),
            });
        }
        let chosen = kind.choose(data, &order)?;
        let warning = chosen.shortened.map(|orders| {
            let (low, high) = (orders.start(), orders.end());
            format!(
                "{} rows bear no order above {high}: order=\"auto\" looked at {low} to {high}",
                data.len()
            )
        });
        Ok((chosen.structure, warning))
    }
}
