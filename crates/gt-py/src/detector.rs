//! `Detector`, `Verdict` and `VerdictSeries`: a bank sample by sample.

use std::sync::Arc;

use gtfdi::core::Signal;
use gtfdi::fdi::{ChannelVerdict, Detector, Verdict};
use numpy::{Element, PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::array::{table_out, vector};
use crate::error::Failure;
use crate::record::Given;

/// The online detector of a bank; ``Bank.detector`` makes one.
///
/// Fed the samples of a record with their times, it gives the residuals of ``Bank.detect`` bit for
/// bit. One detector serves one thread at a time.
#[pyclass(name = "Detector", module = "gtfdi")]
pub struct PyDetector {
    inner: Detector,
    outputs: Arc<[String]>,
    /// Time of the first sample since the time was last given, and the samples since then.
    clock: Option<(f64, usize)>,
}

impl PyDetector {
    pub fn new(inner: Detector) -> Self {
        let outputs = inner.outputs().into();
        Self {
            inner,
            outputs,
            clock: None,
        }
    }

    /// The time of the next sample: as given, or a sample time after the one before, or 0.
    fn next_clock(&self, given_s: Option<f64>) -> (f64, usize) {
        match (given_s, self.clock) {
            (Some(t_s), _) => (t_s, 0),
            (None, Some((start_s, count))) => (start_s, count + 1),
            (None, None) => (0.0, 0),
        }
    }

    fn time_s(&self, (start_s, count): (f64, usize)) -> f64 {
        start_s + count as f64 * self.inner.sample_time_s()
    }
}

#[pymethods]
impl PyDetector {
    /// Tags of the inputs, in the order that ``step`` expects.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        self.inner.inputs().to_vec()
    }

    /// Tags of the outputs, in the order that ``step`` expects.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        self.inner.outputs().to_vec()
    }

    /// Sample time in seconds.
    #[getter]
    fn sample_time_s(&self) -> f64 {
        self.inner.sample_time_s()
    }

    /// Takes one sample.
    ///
    /// Parameters
    /// ----------
    /// u, y : array_like, shapes (nu,) and (ny,)
    ///     Inputs and outputs; NaN means *no valid sample*.
    /// t_s : float, optional
    ///     Time in seconds; a sample time after the one before where left out, and 0 at first.
    ///
    /// Returns
    /// -------
    /// Verdict
    ///
    /// Raises
    /// ------
    /// StepError
    ///     A size is wrong or the time does not advance; the detector is then as it was.
    ///
    /// Examples
    /// --------
    /// >>> detector = bank.detector()
    /// >>> verdict = detector.step(u[0], y[0], t_s=0.0)
    /// >>> verdict.alarm, verdict.settling
    /// (array([False]), array([ True]))
    #[pyo3(signature = (u, y, t_s=None))]
    fn step(
        &mut self,
        u: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        t_s: Option<f64>,
    ) -> Result<PyVerdict, Failure> {
        let (u, y) = (vector(u, "u")?, vector(y, "y")?);
        let clock = self.next_clock(t_s);
        let t_s = self.time_s(clock);
        let verdict = self.inner.step(t_s, u.as_slice(), y.as_slice())?.clone();
        self.clock = Some(clock);
        Ok(PyVerdict {
            inner: verdict,
            outputs: Arc::clone(&self.outputs),
        })
    }

    /// Takes many samples: a Dataset, whose channels are found by name and which has its own
    /// times, or arrays ``u`` (N, nu) and ``y`` (N, ny), the first at ``t_s``.
    ///
    /// Returns
    /// -------
    /// VerdictSeries
    ///
    /// Raises
    /// ------
    /// StepError
    ///     As for ``step``.
    ///
    /// Examples
    /// --------
    /// >>> bank.detector().process(run.measured).alarm.any(axis=0)
    /// array([False])
    #[pyo3(signature = (u, y=None, t_s=None))]
    fn process(
        &mut self,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
        t_s: Option<f64>,
    ) -> Result<PyVerdictSeries, Failure> {
        let given = Given::new(u, y)?;
        let record = matches!(given, Given::Record(_));
        let data = match given {
            Given::Record(data) => {
                Arc::new(data.select(self.inner.inputs(), self.inner.outputs())?)
            }
            arrays @ Given::Arrays(..) => arrays.known(
                &Signal::named(self.inner.inputs()),
                &Signal::named(self.inner.outputs()),
                self.inner.sample_time_s(),
            )?,
        };
        let mut verdicts = Vec::with_capacity(data.len());
        u.py().detach(|| -> Result<(), Failure> {
            let samples = data.u().column_iter().zip(data.y().column_iter());
            for (k, (u, y)) in samples.enumerate() {
                let clock = match (record, k, t_s) {
                    (true, ..) => (data.time_s(k), 0),
                    (false, 0, given_s) => self.next_clock(given_s),
                    (false, ..) => self.next_clock(None),
                };
                let t_s = self.time_s(clock);
                let (u, y) = (u.clone_owned(), y.clone_owned());
                verdicts.push(self.inner.step(t_s, u.as_slice(), y.as_slice())?.clone());
                self.clock = Some(clock);
            }
            Ok(())
        })?;
        Ok(PyVerdictSeries {
            verdicts,
            outputs: Arc::clone(&self.outputs),
        })
    }

    /// Forgets all samples: the next one may have any time, and every generator settles again.
    fn reset(&mut self) {
        self.inner.reset();
        self.clock = None;
    }
}

/// What the detector says of one sample; each array has an entry for every output.
#[pyclass(frozen, name = "Verdict", module = "gtfdi")]
pub struct PyVerdict {
    inner: Verdict,
    outputs: Arc<[String]>,
}

impl PyVerdict {
    fn array<'py, T: Element>(
        &self,
        py: Python<'py>,
        value: impl Fn(&ChannelVerdict) -> T,
    ) -> Bound<'py, PyArray1<T>> {
        PyArray1::from_vec(py, self.inner.channels.iter().map(value).collect())
    }
}

#[pymethods]
impl PyVerdict {
    /// Tags of the outputs.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        self.outputs.to_vec()
    }

    /// Time of the sample in seconds.
    #[getter]
    fn time_s(&self) -> f64 {
        self.inner.time_s
    }

    /// Whether samples are missing before this one, so that every generator started afresh.
    #[getter]
    fn gap(&self) -> bool {
        self.inner.gap
    }

    /// Residuals (ny,); NaN where an input or the output is missing.
    #[getter]
    fn residual<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.array(py, |channel| channel.residual)
    }

    /// Whether the residual is above the limit (ny,).
    #[getter]
    fn exceeds<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.array(py, |channel| channel.exceeds)
    }

    /// Samples above the limit in a row, this one included (ny,).
    #[getter]
    fn run_length<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<usize>> {
        self.array(py, |channel| channel.run_length)
    }

    /// Whether an alarm is up (ny,).
    #[getter]
    fn alarm<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.array(py, |channel| channel.alarm)
    }

    /// Whether the alarm came up with this sample (ny,).
    #[getter]
    fn new_alarm<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.array(py, |channel| channel.new_alarm)
    }

    /// Time of the first sample of the present run above the limit (ny,); NaN outside a run.
    #[getter]
    fn first_exceedance_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.array(py, |channel| channel.first_exceedance_s.unwrap_or(f64::NAN))
    }

    /// Whether the generator has not yet forgotten its initial state (ny,).
    #[getter]
    fn settling<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.array(py, |channel| channel.settling)
    }

    fn __repr__(&self) -> String {
        let up = self.outputs.iter().zip(&self.inner.channels);
        let up: Vec<&str> = up
            .filter(|(_, channel)| channel.alarm)
            .map(|(tag, _)| tag.as_str())
            .collect();
        let up = if up.is_empty() {
            "none".to_owned()
        } else {
            up.join(", ")
        };
        format!("Verdict(at {} s, alarms: {up})", self.inner.time_s)
    }
}

/// What the detector says of many samples; arrays have a row a sample and a column an output.
#[pyclass(frozen, name = "VerdictSeries", module = "gtfdi")]
pub struct PyVerdictSeries {
    verdicts: Vec<Verdict>,
    outputs: Arc<[String]>,
}

impl PyVerdictSeries {
    fn table<'py, T: Element>(
        &self,
        py: Python<'py>,
        value: impl Fn(&ChannelVerdict) -> T,
    ) -> PyResult<Bound<'py, PyArray2<T>>> {
        let channels = self.verdicts.iter().flat_map(|verdict| &verdict.channels);
        table_out(py, channels.map(value).collect(), self.outputs.len())
    }
}

#[pymethods]
impl PyVerdictSeries {
    /// Tags of the outputs.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        self.outputs.to_vec()
    }

    /// Times of the samples in seconds (N,).
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(
            py,
            self.verdicts.iter().map(|verdict| verdict.time_s).collect(),
        )
    }

    /// Whether samples are missing before each (N,).
    #[getter]
    fn gap<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        PyArray1::from_vec(
            py,
            self.verdicts.iter().map(|verdict| verdict.gap).collect(),
        )
    }

    /// Residuals (N, ny); NaN where an input or the output is missing.
    #[getter]
    fn residual<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.table(py, |channel| channel.residual)
    }

    /// Whether the residual is above the limit (N, ny).
    #[getter]
    fn exceeds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<bool>>> {
        self.table(py, |channel| channel.exceeds)
    }

    /// Whether an alarm is up (N, ny).
    #[getter]
    fn alarm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<bool>>> {
        self.table(py, |channel| channel.alarm)
    }

    /// Whether the alarm came up with the sample (N, ny).
    #[getter]
    fn new_alarm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<bool>>> {
        self.table(py, |channel| channel.new_alarm)
    }

    /// Time of the first sample of the present run above the limit (N, ny); NaN outside a run.
    #[getter]
    fn first_exceedance_s<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.table(py, |channel| channel.first_exceedance_s.unwrap_or(f64::NAN))
    }

    /// Whether the generator has not yet forgotten its initial state (N, ny).
    #[getter]
    fn settling<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<bool>>> {
        self.table(py, |channel| channel.settling)
    }

    fn __len__(&self) -> usize {
        self.verdicts.len()
    }
}
