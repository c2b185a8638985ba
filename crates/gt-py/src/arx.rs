//! `Arx`, `arx` and `order_table`: from a record to a model.

use std::ops::RangeInclusive;

use gtfdi::core::Dataset;
use gtfdi::ident::{Arx, ArxStructure, OrderKind, OrderTable, order_table};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator};

use crate::array::json_out;
use crate::arx_model::PyArxModel;
use crate::dataset::{Given, Names};
use crate::error::Failure;

/// Orders that `order="auto"` looks at, as on the command line.
const AUTO_ORDERS: RangeInclusive<usize> = 1..=12;

/// A number, or one for each input.
#[derive(FromPyObject, Clone)]
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

/// What `order` may be.
#[derive(FromPyObject, Clone)]
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

/// An order, or the orders of a search by MDL.
enum Orders {
    One(usize),
    Search(RangeInclusive<usize>),
}

impl Order {
    fn read(&self) -> Result<Orders, Failure> {
        let bad = |found: String| Failure::Option {
            option: "order",
            expected: "a number from 1, a pair such as (1, 12), or \"auto\"".to_owned(),
            found,
        };
        let number = |value: i64| usize::try_from(value).ok().filter(|&value| value >= 1);
        match self {
            Self::One(order) => number(*order)
                .map(Orders::One)
                .ok_or_else(|| bad(order.to_string())),
            Self::Search((low, high)) => match (number(*low), number(*high)) {
                (Some(first), Some(last)) if first <= last => Ok(Orders::Search(first..=last)),
                _ => Err(bad(format!("({low}, {high})"))),
            },
            Self::Name(name) if name == "auto" => Ok(Orders::Search(AUTO_ORDERS)),
            Self::Name(name) => Err(bad(format!("{name:?}"))),
        }
    }
}

/// The names of the structures.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Canonical,
    Full,
    Diagonal,
}

impl Kind {
    fn read(name: &str) -> Result<Self, Failure> {
        match name {
            "canonical" => Ok(Self::Canonical),
            "full" => Ok(Self::Full),
            "diag" | "diagonal" => Ok(Self::Diagonal),
            _ => Err(Failure::Option {
                option: "structure",
                expected: "canonical, full or diag".to_owned(),
                found: format!("{name:?}"),
            }),
        }
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

fn family(kind: Kind, nk: Vec<usize>) -> Result<OrderKind, Failure> {
    Ok(match kind {
        Kind::Canonical => OrderKind::Canonical {
            feedthrough: feedthrough(&nk)?,
        },
        Kind::Full => OrderKind::Full { nk },
        Kind::Diagonal => OrderKind::Diagonal { nk },
    })
}

/// The options of an identification, as given.
#[derive(Clone, Default)]
struct Options {
    order: Option<Order>,
    na: Option<usize>,
    nb: Option<Numbers>,
    nk: Option<Numbers>,
    indices: Option<Vec<usize>>,
    structure: Option<String>,
}

/// The options as a structure, or as a family of structures to search.
enum Wish {
    Structure(ArxStructure),
    Search(OrderKind, RangeInclusive<usize>),
}

impl Options {
    fn nk(&self) -> Vec<usize> {
        self.nk.clone().map_or_else(|| vec![1], Into::into)
    }

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
        let nk = self.nk();
        let orders = self.order.as_ref().map(Order::read).transpose()?;
        match (orders, &self.indices, self.na, self.nb.clone()) {
            (Some(Orders::One(order)), ..) => Ok(Wish::Structure(
                family(kind, nk)?.structure(order, outputs)?,
            )),
            (Some(Orders::Search(orders)), ..) => {
                let orders = reachable(kind, &orders, outputs);
                Ok(Wish::Search(family(kind, nk)?, orders))
            }
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

    fn fit(&self, data: &Dataset) -> Result<PyArxModel, Failure> {
        let structure = match self.wish(data.ny())? {
            Wish::Structure(structure) => structure,
            Wish::Search(kind, orders) => {
                let table = order_table(data, orders, &kind)?;
                kind.structure(table.best_mdl(), data.ny())?
            }
        };
        Ok(PyArxModel {
            inner: Arx::new(structure).fit(data)?,
        })
    }
}

/// The orders of a family that exist: fewer states than outputs leave an output without a row.
fn reachable(kind: Kind, orders: &RangeInclusive<usize>, outputs: usize) -> RangeInclusive<usize> {
    if kind != Kind::Canonical {
        return orders.clone();
    }
    let low = (*orders.start()).max(outputs);
    low..=(*orders.end()).max(low)
}

/// An ARX model that is still to be fitted.
///
/// Parameters
/// ----------
/// order : int, tuple of int or "auto", optional
///     Order n: output lags up to n and input lags up to n; for a canonical structure the sum of
///     the indices. A pair ``(low, high)`` searches by MDL, ``"auto"`` is ``(1, 12)``.
/// na, nb : int, optional
///     Number of output lags and of input lags (one number, or one an input), in place of an order.
/// nk : int or list of int, default 1
///     Smallest input lag; 0 adds a direct term to a canonical structure.
/// indices : list of int, optional
///     Canonical indices, one an output, in place of an order.
/// structure : {"full", "diag", "canonical"}, optional
///     ``full``; ``canonical`` with indices, or with an order and several outputs.
///
/// Examples
/// --------
/// >>> gtfdi.Arx(order=2, nk=0).fit(u, y).structure
/// {'full': {'na': 2, 'nb': [3], 'nk': [0]}}
#[pyclass(frozen, name = "Arx", module = "gtfdi")]
pub struct PyArx {
    options: Options,
}

#[pymethods]
impl PyArx {
    #[new]
    #[pyo3(signature = (*, order=None, na=None, nb=None, nk=None, indices=None, structure=None),
        text_signature = "(*, order=None, na=None, nb=None, nk=1, indices=None, structure=None)")]
    fn py_new(
        order: Option<Order>,
        na: Option<usize>,
        nb: Option<Numbers>,
        nk: Option<Numbers>,
        indices: Option<Vec<usize>>,
        structure: Option<String>,
    ) -> Self {
        Self {
            options: Options {
                order,
                na,
                nb,
                nk,
                indices,
                structure,
            },
        }
    }

    /// Fits by least squares; arguments and errors as for ``gtfdi.arx``.
    #[pyo3(signature = (u, y=None, *, sample_time_s=None, inputs=None, outputs=None))]
    fn fit(
        &self,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
        sample_time_s: Option<f64>,
        inputs: Option<Names>,
        outputs: Option<Names>,
    ) -> Result<PyArxModel, Failure> {
        let data = Given::new(u, y)?.unknown(inputs, outputs, sample_time_s)?;
        u.py().detach(|| self.options.fit(&data))
    }
}

/// Identifies an ARX model by ordinary least squares.
///
/// The means of the record are removed first and kept as the operating point. The lock on the
/// interpreter is released meanwhile.
///
/// Parameters
/// ----------
/// u : array_like, shape (N, nu), or Dataset
///     Inputs, or a whole record (then without ``y``).
/// y : array_like, shape (N, ny), optional
///     Outputs.
/// order, na, nb, nk, indices, structure
///     As for ``gtfdi.Arx``.
/// sample_time_s : float, optional
///     Sample time of the arrays, 1 where left out.
/// inputs, outputs : list of str, optional
///     Tags of the arrays' channels; of a Dataset, the channels to use.
///
/// Returns
/// -------
/// ArxModel
///
/// Raises
/// ------
/// IdentError
///     The record does not determine the model; the message says why.
/// OptionError
///     Options exclude each other or are out of range.
/// DimensionError, DataError, ArrayTypeError
///     The record cannot be used.
///
/// Examples
/// --------
/// >>> run = gtfdi.simulate(600.0, seed=1)
/// >>> model = gtfdi.arx(run.measured, order=8, nk=0, inputs=["a_v", "M_f"], outputs=["q_c"])
/// >>> model.validate(run.measured)[0]["fit_prediction_percent"] > 90.0
/// True
#[pyfunction]
#[pyo3(signature = (u, y=None, *, order=None, na=None, nb=None, nk=None, indices=None,
    structure=None, sample_time_s=None, inputs=None, outputs=None),
    text_signature = "(u, y=None, *, order=None, na=None, nb=None, nk=1, indices=None, \
    structure=None, sample_time_s=None, inputs=None, outputs=None)")]
#[allow(clippy::too_many_arguments)] // Python names them
pub fn arx(
    u: &Bound<'_, PyAny>,
    y: Option<&Bound<'_, PyAny>>,
    order: Option<Order>,
    na: Option<usize>,
    nb: Option<Numbers>,
    nk: Option<Numbers>,
    indices: Option<Vec<usize>>,
    structure: Option<String>,
    sample_time_s: Option<f64>,
    inputs: Option<Names>,
    outputs: Option<Names>,
) -> Result<PyArxModel, Failure> {
    PyArx::py_new(order, na, nb, nk, indices, structure).fit(u, y, sample_time_s, inputs, outputs)
}

/// The criteria of several orders on one window; a sequence of dictionaries with the keys
/// ``order``, ``parameters``, ``residual_variance``, ``ln_det``, ``aic``, ``mdl``, ``fpe``,
/// ``ppcre_percent`` and ``condition``.
#[pyclass(frozen, sequence, name = "OrderTable", module = "gtfdi")]
pub struct PyOrderTable {
    inner: OrderTable,
}

#[pymethods]
impl PyOrderTable {
    /// Rows of the window that all orders share.
    #[getter]
    fn window_rows(&self) -> usize {
        self.inner.window_rows
    }

    /// The best order by each criterion: a dictionary with ``aic``, ``mdl`` and ``fpe``.
    #[getter]
    fn best<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let best = PyDict::new(py);
        best.set_item("aic", self.inner.best_aic())?;
        best.set_item("mdl", self.inner.best_mdl())?;
        best.set_item("fpe", self.inner.best_fpe())?;
        Ok(best)
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyIterator>, Failure> {
        Ok(json_out(py, "order table", &self.inner.rows)?.try_iter()?)
    }

    fn __len__(&self) -> usize {
        self.inner.rows.len()
    }

    fn __getitem__<'py>(
        &self,
        py: Python<'py>,
        index: isize,
    ) -> Result<Bound<'py, PyAny>, Failure> {
        let count = self.inner.rows.len();
        let row = usize::try_from(index)
            .ok()
            .and_then(|index| self.inner.rows.get(index));
        let Some(row) = row else {
            return Err(PyIndexError::new_err(format!(
                "row of the order table: expected an index below {count}, found {index}"
            ))
            .into());
        };
        json_out(py, "order table", row)
    }
}

/// The criteria of several orders, all on the same rows.
///
/// Parameters
/// ----------
/// u, y, structure, nk, sample_time_s, inputs, outputs
///     As for ``gtfdi.arx``.
/// orders : tuple of int
///     Lowest and highest order; a canonical one is at least the number of outputs.
///
/// Returns
/// -------
/// OrderTable
///
/// Examples
/// --------
/// >>> gtfdi.order_table(u, y, orders=(1, 12)).best["mdl"]
/// 5
#[pyfunction]
#[pyo3(name = "order_table", signature = (u, y=None, orders=(1, 12), *, structure=None, nk=None,
    sample_time_s=None, inputs=None, outputs=None),
    text_signature = "(u, y=None, orders=(1, 12), *, structure=None, nk=1, sample_time_s=None, \
    inputs=None, outputs=None)")]
#[allow(clippy::too_many_arguments)] // Python names them
pub fn py_order_table(
    u: &Bound<'_, PyAny>,
    y: Option<&Bound<'_, PyAny>>,
    orders: (i64, i64),
    structure: Option<&str>,
    nk: Option<Numbers>,
    sample_time_s: Option<f64>,
    inputs: Option<Names>,
    outputs: Option<Names>,
) -> Result<PyOrderTable, Failure> {
    let data = Given::new(u, y)?.unknown(inputs, outputs, sample_time_s)?;
    let kind = match structure {
        Some(name) => Kind::read(name)?,
        None if data.ny() > 1 => Kind::Canonical,
        None => Kind::Full,
    };
    let family = family(kind, nk.map_or_else(|| vec![1], Into::into))?;
    let orders = match Order::Search(orders).read()? {
        Orders::Search(orders) => reachable(kind, &orders, data.ny()),
        Orders::One(order) => order..=order,
    };
    let inner = u.py().detach(|| order_table(&data, orders, &family))?;
    Ok(PyOrderTable { inner })
}
