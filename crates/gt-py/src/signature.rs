//! `signature`, `SignatureMatrix` and `feature`: which residual answers to which fault.

use gtfdi::fdi::{Feature, SignatureMatrix, feature as of_series, signature as of_residuals};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::{samples, table_out, vector};
use crate::choice::named;
use crate::dataset::Names;
use crate::error::Failure;
use crate::pickle::{Reduced, pickle_inner, reduce};

/// Which residual answers to which fault; ``gtfdi.signature`` makes one.
#[pyclass(frozen, eq, name = "SignatureMatrix", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PySignatureMatrix {
    inner: SignatureMatrix,
}

impl PySignatureMatrix {
    fn table<'py>(
        &self,
        py: Python<'py>,
        rows: &[Vec<f64>],
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table_out(py, rows.concat(), self.inner.columns.len())
    }
}

#[pymethods]
impl PySignatureMatrix {
    /// Names of the faults, the rows.
    #[getter]
    fn faults(&self) -> Vec<String> {
        self.inner.rows.clone()
    }

    /// Names of the residuals, the columns.
    #[getter]
    fn residuals(&self) -> Vec<String> {
        self.inner.columns.clone()
    }

    /// The matrix, an array (faults, residuals), each column divided by its largest entry; a column
    /// of zeros stays so.
    #[getter]
    fn matrix<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.table(py, &self.inner.matrix)
    }

    /// The same before the division, an array (faults, residuals) in the residuals' units: root
    /// mean squares of the differences that the faults make.
    #[getter]
    fn raw<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.table(py, &self.inner.raw)
    }

    /// The definition in words, with the window and the features.
    #[getter]
    fn definition(&self) -> String {
        self.inner.definition.clone()
    }

    /// Whether there are as many residuals as faults and each peaks, alone, at the fault of its own
    /// position.
    #[getter]
    fn is_diagonal(&self) -> bool {
        self.inner.is_diagonal()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        format!(
            "SignatureMatrix(faults: {}, residuals: {})",
            self.inner.rows.join(", "),
            self.inner.columns.join(", ")
        )
    }
}

pickle_inner!(PySignatureMatrix, SignatureMatrix);

/// One feature by its name and window, or one a residual.
#[derive(FromPyObject)]
pub enum Features {
    /// The same of all residuals.
    #[pyo3(annotation = "str or tuple")]
    One(FeatureArgument),
    /// One a residual.
    #[pyo3(annotation = "list of str or tuple")]
    Many(Vec<FeatureArgument>),
}

/// A feature by its name, with a window where it has one.
#[derive(FromPyObject, Clone)]
pub enum FeatureArgument {
    /// Without a window.
    #[pyo3(annotation = "str")]
    Plain(String),
    /// With a window in seconds.
    #[pyo3(annotation = "tuple")]
    Windowed(String, f64),
}

impl FeatureArgument {
    fn checked(self) -> Result<Feature, Failure> {
        match self {
            Self::Plain(name) => kind("features", &name, None),
            Self::Windowed(name, window_s) => kind("features", &name, Some(window_s)),
        }
    }
}

/// The feature of a name and a window.
fn kind(option: &'static str, name: &str, window_s: Option<f64>) -> Result<Feature, Failure> {
    let known = [("plain", 0), ("moving_mean", 1), ("high_pass", 2)];
    match (named(option, name, &known)?, window_s) {
        (0, None) => Ok(Feature::Plain),
        (1, Some(window_s)) => Ok(Feature::MovingMean { window_s }),
        (2, Some(window_s)) => Ok(Feature::HighPass { window_s }),
        (_, window_s) => Err(Failure::Option {
            option,
            expected: format!(
                "{name:?} with{} a window in seconds",
                if window_s.is_some() { "out" } else { "" }
            ),
            found: format!("one with{}", if window_s.is_some() { "" } else { "out" }),
        }),
    }
}

/// Which residual answers to which fault: root mean squares of the differences that faults make to
/// the residuals, each residual divided by its largest.
///
/// Parameters
/// ----------
/// faulty : dict of str to array_like, shape (N, nr)
///     The residuals of a run with each fault, by the fault's name.
/// healthy : array_like, shape (N, nr)
///     Those of a healthy run of the same operation and noise.
/// sample_time_s : float
///     Sample time in seconds.
/// window : tuple of int, optional
///     First sample that counts and the one after the last; all where left out.
/// features : str or tuple, or list of them, default "plain"
///     What is taken of the residuals first, of all or of each: ``"plain"``, ``("moving_mean",
///     seconds)`` or ``("high_pass", seconds)``, see ``gtfdi.feature``.
/// residuals : list of str, optional
///     Names of the residuals; ``r1, r2, ...`` where left out.
///
/// Returns
/// -------
/// SignatureMatrix
///
/// Raises
/// ------
/// DimensionError
///     Numbers of residuals or samples differ.
/// DesignError
///     The window does not fit, or a sample is not finite.
/// OptionError
///     There is no such feature.
///
/// Examples
/// --------
/// >>> rest, step = np.zeros((50, 2)), np.ones((50, 1))
/// >>> faulty = {"leak": np.hstack([step, 0.0 * step]), "drift": np.hstack([0.5 * step, step])}
/// >>> signature = gtfdi.signature(faulty, rest, 0.1, residuals=["level", "flow"])
/// >>> signature.matrix, signature.is_diagonal
/// (array([[1. , 0. ],
///        [0.5, 1. ]]), True)
#[pyfunction]
#[pyo3(signature = (faulty, healthy, sample_time_s, *, window=None, features=None, residuals=None),
    text_signature = "(faulty, healthy, sample_time_s, *, window=None, features='plain', \
        residuals=None)")]
pub fn signature(
    faulty: &Bound<'_, PyDict>,
    healthy: &Bound<'_, PyAny>,
    sample_time_s: f64,
    window: Option<(usize, usize)>,
    features: Option<Features>,
    residuals: Option<Names>,
) -> Result<PySignatureMatrix, Failure> {
    let healthy = columns(healthy, "healthy")?;
    let count = healthy.len();
    let residuals: Vec<String> = match residuals {
        Some(names) => names.into(),
        None => (1..=count).map(|index| format!("r{index}")).collect(),
    };
    let features = match features {
        None => vec![Feature::Plain; residuals.len()],
        Some(Features::One(one)) => vec![one.checked()?; residuals.len()],
        Some(Features::Many(many)) => {
            let many = many.into_iter().map(FeatureArgument::checked);
            many.collect::<Result<_, _>>()?
        }
    };
    gtfdi::core::DimensionError::check("features", residuals.len(), features.len())?;
    let mut names = Vec::with_capacity(faulty.len());
    let mut runs = Vec::with_capacity(faulty.len());
    for (name, run) in faulty {
        names.push(name.extract::<String>()?);
        runs.push(columns(&run, "faulty")?);
    }
    let faulty: Vec<(&str, &[Vec<f64>])> = (names.iter().zip(&runs))
        .map(|(name, run)| (name.as_str(), run.as_slice()))
        .collect();
    let described: Vec<(&str, Feature)> = (residuals.iter().zip(features))
        .map(|(name, feature)| (name.as_str(), feature))
        .collect();
    let samples = healthy.first().map_or(0, Vec::len);
    let window = window.map_or(0..samples, |(first, end)| first..end);
    let inner = of_residuals(&faulty, &healthy, &described, sample_time_s, window)?;
    Ok(PySignatureMatrix { inner })
}

/// The residuals of a run, one after the other.
fn columns(run: &Bound<'_, PyAny>, what: &'static str) -> Result<Vec<Vec<f64>>, Failure> {
    let run = samples(run, what)?;
    let of_residual = |row: usize| run.row(row).iter().copied().collect();
    Ok((0..run.nrows()).map(of_residual).collect())
}

/// What is taken of a series before its size is measured, sample by sample.
///
/// A window has as many samples as fit, rounded, at least one; at the start of the series it holds
/// those there are. Samples that are not finite are left out of a mean.
///
/// Parameters
/// ----------
/// series : array_like, shape (N,)
///     The series.
/// sample_time_s : float
///     Sample time in seconds.
/// kind : {"moving_mean", "high_pass", "plain"}
///     The mean over the trailing window, the series less that mean, or the series itself.
/// window_s : float, optional
///     Length of the window in seconds.
///
/// Returns
/// -------
/// ndarray, shape (N,)
///
/// Raises
/// ------
/// DesignError
///     The window is not positive.
/// OptionError
///     There is no such kind, or a window is missing or not needed.
///
/// Examples
/// --------
/// >>> gtfdi.feature([1.0, 3.0, 5.0, 5.0], 0.1, "moving_mean", window_s=0.2)
/// array([1., 2., 4., 5.])
#[pyfunction]
#[pyo3(signature = (series, sample_time_s, kind, window_s=None))]
pub fn feature<'py>(
    series: &Bound<'py, PyAny>,
    sample_time_s: f64,
    kind: &str,
    window_s: Option<f64>,
) -> Result<Bound<'py, PyArray1<f64>>, Failure> {
    let kind = self::kind("kind", kind, window_s)?;
    kind.validate()?;
    if !(sample_time_s.is_finite() && sample_time_s > 0.0) {
        return Err(Failure::Option {
            option: "sample_time_s",
            expected: "a positive finite number of seconds".to_owned(),
            found: sample_time_s.to_string(),
        });
    }
    let values = vector(series, "series")?;
    let found = of_series(values.as_slice(), sample_time_s, kind);
    Ok(PyArray1::from_vec(series.py(), found))
}
