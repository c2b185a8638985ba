//! `Order` and `Numbers`: how orders and lags are given.

use std::ops::RangeInclusive;

use gtfdi::ident::OrderChoice;
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

use crate::error::Failure;

/// A number, or one for each input.
#[derive(FromPyObject, Clone, PartialEq, Serialize, Deserialize)]
pub enum Numbers {
    /// One for all.
    #[pyo3(annotation = "int")]
    One(usize),
    /// One each.
    #[pyo3(annotation = "list of int")]
    Many(Vec<usize>),
}

impl From<Numbers> for Vec<usize> {
    fn from(numbers: Numbers) -> Self {
        match numbers {
            Numbers::One(number) => vec![number],
            Numbers::Many(numbers) => numbers,
        }
    }
}

/// The smallest lags of the inputs, 1 where none are given.
pub fn smallest_lags(nk: Option<Numbers>) -> Vec<usize> {
    nk.map_or_else(|| vec![1], Into::into)
}

/// The smallest lag of each of so many inputs.
pub fn lags_of_each(nk: Option<Numbers>, inputs: usize) -> Vec<usize> {
    match smallest_lags(nk)[..] {
        [lag] => vec![lag; inputs],
        ref lags => lags.to_vec(),
    }
}

/// What `order` may be.
#[derive(FromPyObject, Clone, PartialEq, Serialize, Deserialize)]
pub enum Order {
    /// An order.
    #[pyo3(annotation = "int")]
    One(i64),
    /// The lowest and the highest order of a search.
    #[pyo3(annotation = "tuple of two int")]
    Search((i64, i64)),
    /// `auto`.
    #[pyo3(annotation = "\"auto\"")]
    Name(String),
}

impl Order {
    /// The order or the orders that it asks for.
    pub fn read(&self) -> Result<OrderChoice, Failure> {
        match self {
            Self::One(order) => number(*order)
                .map(OrderChoice::Given)
                .ok_or_else(|| bad(order.to_string())),
            Self::Search((low, high)) => ascending(*low, *high)
                .map(OrderChoice::Search)
                .ok_or_else(|| bad(format!("({low}, {high})"))),
            Self::Name(name) if name == "auto" => Ok(OrderChoice::Automatic),
            Self::Name(name) => Err(bad(format!("{name:?}"))),
        }
    }
}

/// The argument `orders`: those from `low` to `high`.
pub fn range((low, high): (i64, i64)) -> Result<RangeInclusive<usize>, Failure> {
    ascending(low, high).ok_or_else(|| Failure::Option {
        option: "orders",
        expected: "the lowest and the highest order, from 1 on, such as (1, 12)".to_owned(),
        found: format!("({low}, {high})"),
    })
}

fn ascending(low: i64, high: i64) -> Option<RangeInclusive<usize>> {
    let (first, last) = (number(low)?, number(high)?);
    (first <= last).then_some(first..=last)
}

fn number(value: i64) -> Option<usize> {
    usize::try_from(value).ok().filter(|&value| value >= 1)
}

fn bad(found: String) -> Failure {
    Failure::Option {
        option: "order",
        expected: "a number from 1, a pair such as (1, 12), or \"auto\"".to_owned(),
        found,
    }
}
