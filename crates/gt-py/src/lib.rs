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
mod arx_fit;
mod arx_model;
mod arx_options;
mod arx_structure;
mod bank;
mod campaign;
mod campaign_desk;
mod campaign_task;
mod choice;
mod constrained_arx;
mod data_check;
mod dataset;
mod dataset_view;
mod detection;
mod detector;
mod eiv;
mod eiv_kalman;
mod eiv_model;
mod eiv_order_table;
mod error;
mod fault_effects;
mod fault_model;
mod filter_run;
mod fleet;
mod free_run;
mod frequency_response;
mod frisch_order_table;
mod index_table;
mod interop;
mod interrupt;
mod isolation_monitor;
mod isolator;
mod kalman;
mod linear_residual;
mod linearise;
mod log;
mod noise_covariance;
mod observer;
mod observer_design;
mod order;
mod order_table;
mod output_error;
mod output_key;
mod output_model;
mod pickle;
mod placement;
mod plant;
mod pole_zero;
mod poles;
mod reading;
mod record;
mod report;
mod reproduction;
mod residual_report;
mod riccati;
mod robustness;
mod run_length;
mod sample_clock;
mod scenario;
mod scheduled_arx;
mod scheduled_generators;
mod scheduled_model;
mod signature;
mod simulated_runs;
mod state_space;
mod statistics;
mod table;
mod time_varying_kalman;
mod trend;
mod unified_filter;
mod unknown_input_observer;
mod verdict;
mod warning;

/// The compiled half of the package.
#[pyo3::pymodule]
mod _gtfdi {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::arx::{PyArx, arx};
    #[pymodule_export]
    use crate::arx_fit::PyArxFit;
    #[pymodule_export]
    use crate::arx_model::PyArxModel;
    #[pymodule_export]
    use crate::bank::{PyBank, design};
    #[pymodule_export]
    use crate::campaign::{campaign_compare, campaign_rows, campaign_run};
    #[pymodule_export]
    use crate::campaign_desk::PyCampaignDesk;
    #[pymodule_export]
    use crate::campaign_task::PyCampaignTask;
    #[pymodule_export]
    use crate::constrained_arx::{PyConstrainedArx, PyConstrainedFit};
    #[pymodule_export]
    use crate::data_check::check;
    #[pymodule_export]
    use crate::dataset::PyDataset;
    #[pymodule_export]
    use crate::detection::PyDetection;
    #[pymodule_export]
    use crate::detector::PyDetector;
    #[pymodule_export]
    use crate::eiv::{eiv, frisch};
    #[pymodule_export]
    use crate::eiv_kalman::PyEivKalman;
    #[pymodule_export]
    use crate::eiv_model::PyEivModel;
    #[pymodule_export]
    use crate::eiv_order_table::{PyEivOrderTable, py_eiv_order_table};
    #[pymodule_export]
    use crate::fault_effects::{fault_effects, lag_limit};
    #[pymodule_export]
    use crate::fault_model::PyFaultModel;
    #[pymodule_export]
    use crate::filter_run::PyFilterRun;
    #[pymodule_export]
    use crate::fleet::PyFleet;
    #[pymodule_export]
    use crate::free_run::PyFreeRun;
    #[pymodule_export]
    use crate::frequency_response::PyFrequencyResponse;
    #[pymodule_export]
    use crate::frisch_order_table::{PyFrischOrderTable, py_frisch_order_table};
    #[pymodule_export]
    use crate::index_table::{PyIndexTable, py_index_table};
    #[pymodule_export]
    use crate::isolation_monitor::PyIsolationMonitor;
    #[pymodule_export]
    use crate::isolator::{PyIsolation, PyIsolator, design_isolator};
    #[pymodule_export]
    use crate::kalman::{PyKalmanFilter, kalman};
    #[pymodule_export]
    use crate::linear_residual::PyLinearResidual;
    #[pymodule_export]
    use crate::linearise::linearise;
    #[pymodule_export]
    use crate::log::{log_attachment, log_export, log_info, log_messages, log_recover, log_verify};
    #[pymodule_export]
    use crate::noise_covariance::PyNoiseCovariance;
    #[pymodule_export]
    use crate::observer::{PyObserver, observer};
    #[pymodule_export]
    use crate::observer_design::{PyObserverDesign, optimise_observer};
    #[pymodule_export]
    use crate::order_table::{PyOrderTable, py_order_table};
    #[pymodule_export]
    use crate::output_error::{PyOutputErrorRefinement, PyRefined};
    #[pymodule_export]
    use crate::output_model::PyOutputModel;
    #[pymodule_export]
    use crate::pickle::restore;
    #[pymodule_export]
    use crate::placement::place;
    #[pymodule_export]
    use crate::plant::{PyRun, simulate, steady_state, units};
    #[pymodule_export]
    use crate::reading::read;
    #[pymodule_export]
    use crate::report::write_report;
    #[pymodule_export]
    use crate::reproduction::reproduce;
    #[pymodule_export]
    use crate::residual_report::PyResidualReport;
    #[pymodule_export]
    use crate::riccati::{PyRiccati, riccati};
    #[pymodule_export]
    use crate::robustness::{peak_gain, robustness};
    #[pymodule_export]
    use crate::run_length::{
        cusum_run_length, cusum_threshold, exceedance_limit, exceedance_run_length,
        mean_delay_bound, run_sum_run_length, run_sum_width, shiryaev_roberts_run_length,
        shiryaev_roberts_threshold,
    };
    #[pymodule_export]
    use crate::scheduled_arx::PyScheduledArx;
    #[pymodule_export]
    use crate::scheduled_generators::PyScheduledGenerators;
    #[pymodule_export]
    use crate::scheduled_model::PyScheduledModel;
    #[pymodule_export]
    use crate::signature::{PySignatureMatrix, feature, signature};
    #[pymodule_export]
    use crate::simulated_runs::PySimulatedRuns;
    #[pymodule_export]
    use crate::state_space::PyStateSpace;
    #[pymodule_export]
    use crate::statistics::{
        PyAdaptiveThreshold, PyCusum, PyCusumFleet, PyGlr, PyGrowingChiSquare, PyGrowingVariance,
        PyMovingAverage, PyRunSum, PyShiryaevRoberts, PySprt, PyWhiteness, PyWindowedChiSquare,
        PyWindowedVariance,
    };
    #[pymodule_export]
    use crate::time_varying_kalman::PyTimeVaryingKalman;
    #[pymodule_export]
    use crate::trend::PyTrend;
    #[pymodule_export]
    use crate::unified_filter::PyUnifiedFilter;
    #[pymodule_export]
    use crate::unknown_input_observer::PyUnknownInputObserver;
    #[pymodule_export]
    use crate::verdict::{PyVerdict, PyVerdictSeries};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
