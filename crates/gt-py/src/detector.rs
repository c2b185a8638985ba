//! `Detector`: a bank sample by sample.

use std::ops::Range;
use std::sync::Arc;

use gtfdi::core::{Dataset, DimensionError};
use gtfdi::fdi::{Bank, Detector, DetectorState};
use pyo3::prelude::*;

use crate::array::{Samples, json_text, json_value, vector};
use crate::dataset::names;
use crate::error::Failure;
use crate::pickle::{Pickled, Reduced, reduce};
use crate::record::Given;
use crate::sample_clock::SampleClock;
use crate::verdict::{PyVerdict, PyVerdictSeries, Series};

/// Samples between two looks for signals: a tenth of a second for a bank of many filters.
const BLOCK: usize = 10_000;

/// The online detector of a bank; ``Bank.detector`` makes one.
///
/// Fed the samples of a record with their times, it gives the statistics of ``Bank.detect`` bit for
/// bit. One detector serves one thread at a time.
#[pyclass(name = "Detector", module = "gtfdi")]
pub struct PyDetector {
    bank: Arc<Bank>,
    inner: Detector,
    tests: Arc<[String]>,
    clock: SampleClock,
}

impl PyDetector {
    pub fn new(bank: Arc<Bank>) -> Self {
        let inner = Detector::new(&bank);
        let tests = inner.tests().into();
        Self {
            bank,
            inner,
            tests,
            clock: SampleClock::default(),
        }
    }

    /// Takes the samples from `first` on of rows that lie one after the other.
    fn take(
        &mut self,
        series: &mut Series,
        samples: Range<usize>,
        clock_at: impl Fn(usize, SampleClock) -> SampleClock,
        [u, y]: [&[f64]; 2],
    ) -> Result<(), Failure> {
        let sample_time_s = self.inner.sample_time_s();
        let (nu, ny) = (self.inner.inputs().len(), self.inner.outputs().len());
        for k in samples {
            let clock = clock_at(k, self.clock);
            let (u, y) = (&u[k * nu..][..nu], &y[k * ny..][..ny]);
            series.push(self.inner.step(clock.time_s(sample_time_s), u, y)?);
            self.clock = clock;
        }
        Ok(())
    }
}

impl Pickled for PyDetector {
    type Stored = (Bank, DetectorState, SampleClock);

    fn stored(&self) -> Result<Self::Stored, Failure> {
        Ok((Bank::clone(&self.bank), self.inner.state(), self.clock))
    }

    fn restored((bank, state, clock): Self::Stored) -> Result<Self, Failure> {
        let mut detector = Self::new(Arc::new(bank));
        detector.inner.resume(&state)?;
        detector.clock = clock;
        Ok(detector)
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
        Ok(PyVerdict::new(verdict, Arc::clone(&self.tests)))
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
    ///     As for ``step``; the samples before it are taken.
    /// KeyboardInterrupt
    ///     Ctrl-C; the detector is then as it was.
    ///
    /// Notes
    /// -----
    /// C-contiguous float64 arrays are read where they are, without a copy: leave them alone
    /// meanwhile.
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
        let py = u.py();
        let before = (self.inner.clone(), self.clock);
        let outcome = match Given::new(u, y)? {
            Given::Record(data) => {
                let data = self.own_channels(data)?;
                let sample_time_s = self.inner.sample_time_s();
                let clock = |k, _| SampleClock::at(Some(data.time_s(k)), sample_time_s);
                let rows = [data.u().as_slice(), data.y().as_slice()];
                self.blocks(py, data.len(), clock, rows)
            }
            Given::Arrays(u, y) => {
                let (u, y) = (Samples::new(&u, "u")?, Samples::new(&y, "y")?);
                let inputs = self.inner.inputs().len();
                DimensionError::check("channels of u", inputs, u.channels())?;
                DimensionError::check("channels of y", self.inner.outputs().len(), y.channels())?;
                DimensionError::check("samples of y", u.count(), y.count())?;
                let clock = |k, clock: SampleClock| clock.next(t_s.filter(|_| k == 0));
                self.blocks(py, u.count(), clock, [u.values()?, y.values()?])
            }
        };
        if let Err(Failure::Python(_)) = outcome {
            (self.inner, self.clock) = before;
        }
        outcome
    }

    /// Forgets all samples: the next one may have any time, and every generator settles again.
    fn reset(&mut self) {
        self.inner.reset();
        self.clock = SampleClock::default();
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

impl PyDetector {
    /// A record with the channels of the detector, itself where it has just these.
    fn own_channels(&self, data: Arc<Dataset>) -> Result<Arc<Dataset>, Failure> {
        let (inputs, outputs) = (self.inner.inputs(), self.inner.outputs());
        if names(data.inputs()) == inputs && names(data.outputs()) == outputs {
            return Ok(data);
        }
        Ok(Arc::new(data.select(inputs, outputs)?))
    }

    /// Takes many samples without the lock on the interpreter, block by block: in between, Ctrl-C
    /// is heard.
    fn blocks(
        &mut self,
        py: Python<'_>,
        count: usize,
        clock_at: impl Fn(usize, SampleClock) -> SampleClock + Sync,
        rows: [&[f64]; 2],
    ) -> Result<PyVerdictSeries, Failure> {
        let mut series = Series::new(&self.tests, count);
        for first in (0..count).step_by(BLOCK) {
            let block = first..count.min(first + BLOCK);
            py.detach(|| self.take(&mut series, block, &clock_at, rows))?;
            py.check_signals()?;
        }
        Ok(series.into())
    }
}
