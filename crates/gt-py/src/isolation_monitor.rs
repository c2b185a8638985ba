//! `IsolationMonitor`: an isolator sample by sample.

use std::sync::Arc;

use gtfdi::fdi::{IsolationEvent, IsolationMonitor, Isolator, MonitorState};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::array::{json_out, json_text, json_value, vector};
use crate::error::Failure;
use crate::pickle::{Pickled, Reduced, reduce};
use crate::sample_clock::SampleClock;

/// An isolator that takes samples as they come and diagnoses while an alarm is up;
/// ``Isolator.monitor`` makes one.
///
/// Fed the samples of a record with their times, it finds what ``Isolator.detect`` does. One monitor
/// serves one thread at a time.
#[pyclass(name = "IsolationMonitor", module = "gtfdi")]
pub struct PyIsolationMonitor {
    isolator: Arc<Isolator>,
    inner: IsolationMonitor,
    clock: SampleClock,
}

impl PyIsolationMonitor {
    pub fn new(isolator: Arc<Isolator>, inner: IsolationMonitor) -> Self {
        Self {
            isolator,
            inner,
            clock: SampleClock::default(),
        }
    }
}

#[pymethods]
impl PyIsolationMonitor {
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
    /// list of str
    ///     What happened: ``"alarm"``, ``"name"`` and ``"end"``; mostly nothing.
    ///
    /// Raises
    /// ------
    /// StepError
    ///     A size is wrong or the time does not advance; the monitor is then as it was.
    ///
    /// Examples
    /// --------
    /// >>> monitor = isolator.monitor()
    /// >>> monitor.step(record.u[0], record.y[0], t_s=0.0)
    /// []
    #[pyo3(signature = (u, y, t_s=None))]
    fn step(
        &mut self,
        u: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        t_s: Option<f64>,
    ) -> Result<Vec<&'static str>, Failure> {
        let (u, y) = (vector(u, "u")?, vector(y, "y")?);
        let clock = self.clock.next(t_s);
        let t_s = clock.time_s(self.isolator.sample_time_s());
        let events = self.inner.step(t_s, u.as_slice(), y.as_slice())?;
        self.clock = clock;
        let words = events.iter().map(|event| match event {
            IsolationEvent::Alarm { .. } => "alarm",
            IsolationEvent::Name { .. } => "name",
            IsolationEvent::End { .. } => "end",
        });
        Ok(words.collect())
    }

    /// All that the monitor remembers, as JSON for ``resume``.
    fn state(&self) -> Result<String, Failure> {
        json_text("state", &self.inner.state())
    }

    /// Goes on from the ``state`` of a monitor of the same isolator, bit for bit; an alarm that was
    /// up is not raised again.
    ///
    /// Raises
    /// ------
    /// StepError
    ///     The state is not one of this isolator; the monitor is then as it was.
    fn resume(&mut self, state: &str) -> Result<(), Failure> {
        let state: MonitorState = json_value("state", state)?;
        self.inner.resume(&state)?;
        self.clock = SampleClock::at(state.last_time_s(), self.isolator.sample_time_s());
        Ok(())
    }

    /// The statistics after the last sample, an array in the order of ``Isolator.statistics``.
    #[getter]
    fn statistics<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.inner.verdict().statistics)
    }

    /// Whether an alarm is up.
    #[getter]
    fn alarm(&self) -> bool {
        self.inner.verdict().alarm
    }

    /// Whether the generators have not yet settled, so that nothing is judged.
    #[getter]
    fn settling(&self) -> bool {
        self.inner.verdict().settling
    }

    /// The last diagnosis under the name that stands, a dictionary with the keys of an alarm's in
    /// ``Isolation.alarms``; ``None`` while no alarm is up.
    #[getter]
    fn diagnosis<'py>(&self, py: Python<'py>) -> Result<Option<Bound<'py, PyAny>>, Failure> {
        let (Some(standing), Some((time_s, diagnosis))) =
            (self.inner.name(), self.inner.diagnosis())
        else {
            return Ok(None);
        };
        let named = self.isolator.named(*time_s, standing, diagnosis);
        json_out(py, "diagnosis", &named).map(Some)
    }

    fn __repr__(&self) -> String {
        format!(
            "IsolationMonitor({}, alarm: {})",
            self.isolator.name,
            if self.alarm() { "up" } else { "none" }
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

impl Pickled for PyIsolationMonitor {
    type Stored = (Isolator, MonitorState, SampleClock);

    fn stored(&self) -> Result<Self::Stored, Failure> {
        let isolator = Isolator::clone(&self.isolator);
        Ok((isolator, self.inner.state(), self.clock))
    }

    fn restored((isolator, state, clock): Self::Stored) -> Result<Self, Failure> {
        let mut inner = IsolationMonitor::new(&isolator)?;
        inner.resume(&state)?;
        Ok(Self {
            isolator: Arc::new(isolator),
            inner,
            clock,
        })
    }
}
