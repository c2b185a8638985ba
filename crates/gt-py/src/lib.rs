//! The Python package `gtfdi`: the facade and gt-log for NumPy arrays.
//!
//! Nothing is computed here: a file wraps a Rust module, arguments become its types, and its
//! errors become exceptions. The documentation of classes and functions is numpydoc, because
//! Python shows it.

#![allow(
    clippy::doc_markdown,
    clippy::doc_link_with_quotes,
    reason = "the docs are read by Python users, in numpydoc"
)]
#![allow(
    clippy::needless_pass_by_value,
    reason = "pyo3 hands extracted arguments over by value"
)]

mod array;
mod arx;
mod arx_model;
mod bank;
mod dataset;
mod detector;
mod error;
mod observer;
mod plant;
mod scenario;
mod state_space;

/// The compiled half of the package.
#[pyo3::pymodule]
mod _gtfdi {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::arx::{PyArx, PyOrderTable, arx, py_order_table};
    #[pymodule_export]
    use crate::arx_model::{PyArxModel, PyFreeRun, PyOutputModel};
    #[pymodule_export]
    use crate::bank::{PyBank, PyDetection, design};
    #[pymodule_export]
    use crate::dataset::{PyDataset, read};
    #[pymodule_export]
    use crate::detector::{PyDetector, PyVerdict, PyVerdictSeries};
    #[pymodule_export]
    use crate::observer::{PyObserver, observer};
    #[pymodule_export]
    use crate::plant::{PyRun, simulate, steady_state, units};
    #[pymodule_export]
    use crate::state_space::PyStateSpace;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
