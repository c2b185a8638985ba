//! Pickles: what `__reduce__` gives, and what makes an object of it again.
//!
//! A pickle names the class, the form that this version writes, the package's version and a digest
//! of what follows, so that one of another version or with broken bytes is refused by name.

use gt_log::sha256_hex;
use pyo3::PyClass;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::Failure;

/// The form of the pickles; another number whenever a class stores something else.
const FORM: u32 = 1;

/// The package's version, named where a pickle is refused.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// A class whose objects can be pickled.
pub trait Pickled: PyClass + Into<PyClassInitializer<Self>> {
    /// What a pickle holds.
    type Stored: Serialize + DeserializeOwned;

    /// What is to be kept.
    fn stored(&self) -> Result<Self::Stored, Failure>;

    /// The object of what was kept.
    fn restored(stored: Self::Stored) -> Result<Self, Failure>;
}

/// Makes pickles of a class that only wraps a value `inner`, which is checked where it is read.
macro_rules! pickle_inner {
    ($class:ty, $inner:ty) => {
        impl $crate::pickle::Pickled for $class {
            type Stored = $inner;

            fn stored(&self) -> Result<$inner, $crate::error::Failure> {
                Ok(self.inner.clone())
            }

            fn restored(inner: $inner) -> Result<Self, $crate::error::Failure> {
                Ok(Self { inner })
            }
        }
    };
}
pub(crate) use pickle_inner;

/// The arguments of `_restore`: class, form, version, digest and bytes.
type Arguments<'py> = (&'static str, u32, &'static str, String, Bound<'py, PyBytes>);

/// What `__reduce__` returns.
pub type Reduced<'py> = (Bound<'py, PyAny>, Arguments<'py>);

/// The pickle of an object.
pub fn reduce<'py, T: Pickled>(py: Python<'py>, object: &T) -> Result<Reduced<'py>, Failure> {
    let name = class_name::<T>();
    let bytes = rmp_serde::to_vec_named(&object.stored()?).map_err(|cause| Failure::Pickle {
        name: name.to_owned(),
        expected: "an object with a stored form".to_owned(),
        found: cause.to_string(),
    })?;
    let restore = py.import("gtfdi._gtfdi")?.getattr("_restore")?;
    let digest = sha256_hex(&bytes);
    let arguments = (name, FORM, VERSION, digest, PyBytes::new(py, &bytes));
    Ok((restore, arguments))
}

/// The name that Python shows of a class.
fn class_name<T: Pickled>() -> &'static str {
    <T as PyClass>::NAME
}

/// The object of the bytes of a pickle.
fn restored<T: Pickled>(py: Python<'_>, bytes: &[u8]) -> Result<Py<PyAny>, Failure> {
    let stored = rmp_serde::from_slice(bytes).map_err(|cause| Failure::Pickle {
        name: class_name::<T>().to_owned(),
        expected: format!("what gtfdi {VERSION} writes"),
        found: cause.to_string(),
    })?;
    Ok(Py::new(py, T::restored(stored)?)?.into_any())
}

/// What makes an object of a class.
type Restore = fn(Python<'_>, &[u8]) -> Result<Py<PyAny>, Failure>;

/// The entries of [`CLASSES`].
macro_rules! classes {
    ($($class:path),* $(,)?) => {
        &[$((<$class as pyo3::PyClass>::NAME, restored::<$class>)),*]
    };
}

/// All classes whose objects can be pickled.
const CLASSES: &[(&str, Restore)] = classes![
    crate::arx::PyArx,
    crate::arx_fit::PyArxFit,
    crate::arx_model::PyArxModel,
    crate::bank::PyBank,
    crate::detection::PyDetection,
    crate::constrained_arx::PyConstrainedArx,
    crate::constrained_arx::PyConstrainedFit,
    crate::dataset::PyDataset,
    crate::detector::PyDetector,
    crate::eiv_kalman::PyEivKalman,
    crate::eiv_model::PyEivModel,
    crate::eiv_order_table::PyEivOrderTable,
    crate::fault_model::PyFaultModel,
    crate::filter_run::PyFilterRun,
    crate::free_run::PyFreeRun,
    crate::frequency_response::PyFrequencyResponse,
    crate::frisch_order_table::PyFrischOrderTable,
    crate::index_table::PyIndexTable,
    crate::isolation_monitor::PyIsolationMonitor,
    crate::isolator::PyIsolation,
    crate::isolator::PyIsolator,
    crate::kalman::PyKalmanFilter,
    crate::linear_residual::PyLinearResidual,
    crate::noise_covariance::PyNoiseCovariance,
    crate::observer::PyObserver,
    crate::observer_design::PyObserverDesign,
    crate::order_table::PyOrderTable,
    crate::output_error::PyOutputErrorRefinement,
    crate::output_error::PyRefined,
    crate::output_model::PyOutputModel,
    crate::plant::PyRun,
    crate::residual_report::PyResidualReport,
    crate::riccati::PyRiccati,
    crate::scheduled_arx::PyScheduledArx,
    crate::scheduled_generators::PyScheduledGenerators,
    crate::scheduled_model::PyScheduledModel,
    crate::signature::PySignatureMatrix,
    crate::simulated_runs::PySimulatedRuns,
    crate::state_space::PyStateSpace,
    crate::statistics::PyAdaptiveThreshold,
    crate::statistics::PyCusum,
    crate::statistics::PyGlr,
    crate::statistics::PyGrowingChiSquare,
    crate::statistics::PyGrowingVariance,
    crate::statistics::PyMovingAverage,
    crate::statistics::PyRunSum,
    crate::statistics::PyShiryaevRoberts,
    crate::statistics::PySprt,
    crate::statistics::PyWhiteness,
    crate::statistics::PyWindowedChiSquare,
    crate::statistics::PyWindowedVariance,
    crate::time_varying_kalman::PyTimeVaryingKalman,
    crate::trend::PyTrend,
    crate::unified_filter::PyUnifiedFilter,
    crate::unknown_input_observer::PyUnknownInputObserver,
    crate::verdict::PyVerdict,
    crate::verdict::PyVerdictSeries,
];

/// The object of a pickle; what ``__reduce__`` of every class names.
#[pyfunction(name = "_restore")]
pub fn restore(
    py: Python<'_>,
    name: &str,
    form: u32,
    version: &str,
    digest: &str,
    payload: &[u8],
) -> Result<Py<PyAny>, Failure> {
    let refuse = |expected: String, found: String| Failure::Pickle {
        name: name.to_owned(),
        expected,
        found,
    };
    if form != FORM {
        return Err(refuse(
            format!("form {FORM}, which gtfdi {VERSION} writes"),
            format!("form {form} of gtfdi {version}"),
        ));
    }
    let known = CLASSES.iter().find(|(class, _)| *class == name);
    let Some((_, restore)) = known else {
        return Err(refuse(
            format!("a class of gtfdi {VERSION} that can be pickled"),
            format!("one of gtfdi {version}"),
        ));
    };
    let found = sha256_hex(payload);
    if found != digest {
        return Err(refuse(
            format!("bytes whose SHA-256 is {digest}"),
            format!("{found}: they were changed"),
        ));
    }
    restore(py, payload)
}
