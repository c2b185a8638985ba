//! `Detector`, `Verdict` and `VerdictSeries`: a bank sample by sample.

use std::sync::Arc;

use gtfdi::core::Signal;
use gtfdi::fdi::{ChannelVerdict, Detector, DetectorState, Verdict};
use numpy::{Element, PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::array::{json_text, json_value, table_out, vector};
use crate::error::Failure;
use crate::record::Given;
use crate::sample_clock::SampleClock;

/// The online detector of a bank; ``Bank.detector`` makes one.
///
/// Fed the samples of a record with their times, it gives the statistics of ``Bank.detect`` bit for
/// bit. One detector serves one thread at a time.
#[pyclass(name = "Detector", module = "gtfdi")]
pub struct PyDetector {
    inner: Detector,
    tests: Arc<[String]>,
    clock: SampleClock,
}

impl PyDetector {
    pub fn new(inner: Detector) -> Self {
        let tests = inner.tests().into();
        Self {
            inner,
            tests,
            clock: SampleClock::default(),
        }
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

    /// Names of the tests, in the order of a verdict's arrays.
    #[getter]
    fn tests(&self) -> Vec<String> {
        self.tests.to_vec()
    }

    /// Sample time in seconds.
    #[getter]
    fn sample_time_s(&self) -> f64 {
        self.inner.sample_time_s()
    }

    /// All that the detector remembers, as JSON for ``resume``.
    fn state(&self) -> Result<String, Failure> {
        json_text("state", &self.inner.state())
    }

    /// Goes on from the ``state`` of a detector of the same bank: from then on the verdicts are
    /// those that it would have given, bit for bit.
    ///
    /// Raises
    /// ------
    /// StepError
    ///     The state is not one of this bank; the detector is then as it was.
    ///
    /// Examples
    /// --------
    /// >>> detector = bank.detector()
    /// >>> _ = detector.step(u[0], y[0], t_s=0.0)
    /// >>> other = bank.detector()
    /// >>> other.resume(detector.state())
    fn resume(&mut self, state: &str) -> Result<(), Failure> {
        let state: DetectorState = json_value("state", state)?;
        self.inner.resume(&state)?;
        self.clock = SampleClock::at(state.last_time_s(), self.inner.sample_time_s());
        Ok(())
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
        let clock = self.clock.next(t_s);
        let t_s = clock.time_s(self.inner.sample_time_s());
        let verdict = self.inner.step(t_s, u.as_slice(), y.as_slice())?.clone();
        self.clock = clock;
        Ok(PyVerdict {
            inner: verdict,
            tests: Arc::clone(&self.tests),
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
                    (true, ..) => SampleClock::at(Some(data.time_s(k)), self.inner.sample_time_s()),
                    (false, 0, given_s) => self.clock.next(given_s),
                    (false, ..) => self.clock.next(None),
                };
                let t_s = clock.time_s(self.inner.sample_time_s());
                let (u, y) = (u.clone_owned(), y.clone_owned());
                verdicts.push(self.inner.step(t_s, u.as_slice(), y.as_slice())?.clone());
                self.clock = clock;
            }
            Ok(())
        })?;
        Ok(PyVerdictSeries {
            verdicts,
            tests: Arc::clone(&self.tests),
        })
    }

    /// Forgets all samples: the next one may have any time, and every generator settles again.
    fn reset(&mut self) {
        self.inner.reset();
        self.clock = SampleClock::default();
    }
}

/// What the detector says of one sample; each array has an entry for every test.
#[pyclass(frozen, name = "Verdict", module = "gtfdi")]
pub struct PyVerdict {
    inner: Verdict,
    tests: Arc<[String]>,
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
    /// Names of the tests, in the order of the arrays.
    #[getter]
    fn tests(&self) -> Vec<String> {
        self.tests.to_vec()
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

    /// Residuals: in the output's unit where a test watches one output as it is, in standard
    /// deviations where it is whitened, the norm where it watches several; NaN where one is missing.
    #[getter]
    fn residual<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.array(py, |channel| channel.residual)
    }

    /// The statistics, which are compared with the limits; NaN where nothing is judged.
    #[getter]
    fn statistic<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.array(py, |channel| channel.statistic)
    }

    /// The likeliest deviations of the residuals' means, in the outputs' units; NaN where the
    /// statistic does not tell or is within its limit.
    #[getter]
    fn deviation<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.array(py, |channel| channel.deviation.unwrap_or(f64::NAN))
    }

    /// Whether the residual is above the limit.
    #[getter]
    fn exceeds<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.array(py, |channel| channel.exceeds)
    }

    /// Samples above the limit in a row, this one included.
    #[getter]
    fn run_length<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<usize>> {
        self.array(py, |channel| channel.run_length)
    }

    /// Whether an alarm is up.
    #[getter]
    fn alarm<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.array(py, |channel| channel.alarm)
    }

    /// Whether the alarm came up with this sample.
    #[getter]
    fn new_alarm<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.array(py, |channel| channel.new_alarm)
    }

    /// Time of the first sample of the present run above the limit; NaN outside a run.
    #[getter]
    fn first_exceedance_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.array(py, |channel| channel.first_exceedance_s.unwrap_or(f64::NAN))
    }

    /// Whether the generator has not yet forgotten its initial state.
    #[getter]
    fn settling<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.array(py, |channel| channel.settling)
    }

    fn __repr__(&self) -> String {
        let up = self.tests.iter().zip(&self.inner.channels);
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

/// What the detector says of many samples; arrays have a row a sample and a column a test.
#[pyclass(frozen, name = "VerdictSeries", module = "gtfdi")]
pub struct PyVerdictSeries {
    verdicts: Vec<Verdict>,
    tests: Arc<[String]>,
}

impl PyVerdictSeries {
    fn table<'py, T: Element>(
        &self,
        py: Python<'py>,
        value: impl Fn(&ChannelVerdict) -> T,
    ) -> PyResult<Bound<'py, PyArray2<T>>> {
        let channels = self.verdicts.iter().flat_map(|verdict| &verdict.channels);
        table_out(py, channels.map(value).collect(), self.tests.len())
    }
}

#[pymethods]
impl PyVerdictSeries {
    /// Names of the tests, in the order of the arrays.
    #[getter]
    fn tests(&self) -> Vec<String> {
        self.tests.to_vec()
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

    /// Residuals, as those of one ``Verdict``.
    #[getter]
    fn residual<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.table(py, |channel| channel.residual)
    }

    /// The statistics, which are compared with the limits; NaN where nothing is judged.
    #[getter]
    fn statistic<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.table(py, |channel| channel.statistic)
    }

    /// Whether the residual is above the limit (a column a test).
    #[getter]
    fn exceeds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<bool>>> {
        self.table(py, |channel| channel.exceeds)
    }

    /// Whether an alarm is up (a column a test).
    #[getter]
    fn alarm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<bool>>> {
        self.table(py, |channel| channel.alarm)
    }

    /// Whether the alarm came up with the sample (a column a test).
    #[getter]
    fn new_alarm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<bool>>> {
        self.table(py, |channel| channel.new_alarm)
    }

    /// Time of the first sample of the present run above the limit (a column a test); NaN outside a run.
    #[getter]
    fn first_exceedance_s<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.table(py, |channel| channel.first_exceedance_s.unwrap_or(f64::NAN))
    }

    /// Whether the generator has not yet forgotten its initial state (a column a test).
    #[getter]
    fn settling<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<bool>>> {
        self.table(py, |channel| channel.settling)
    }

    fn __len__(&self) -> usize {
        self.verdicts.len()
    }
}
