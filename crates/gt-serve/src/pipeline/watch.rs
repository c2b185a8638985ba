//! A bank or an isolator at work, with what both say in one form.

use gt_log::DetectorFile;
use gtfdi::core::Signal;
use gtfdi::fdi::{
    Bank, Detector, DetectorState, IsolationEvent, IsolationMonitor, Isolator, MonitorState,
    NamedDiagnosis, ResidualGenerator, ResumeError, StepError,
};
use serde::{Deserialize, Serialize};

/// What happened at a sample.
#[derive(Debug, Clone, PartialEq)]
pub enum WatchEvent {
    /// An alarm came up.
    Raised {
        /// Which of those that can be up at once.
        key: usize,
        /// Place of the statistic.
        statistic: usize,
        /// Its value.
        value: f64,
        /// Its limit.
        limit: f64,
        /// When it began, as far as the statistic tells, in seconds of the grid.
        onset_s: Option<f64>,
    },
    /// What is known of the fault, anew.
    Diagnosed {
        /// The alarm's key.
        key: usize,
        /// In seconds of the grid.
        diagnosis: Box<NamedDiagnosis>,
    },
    /// The alarm ended.
    Ended {
        /// The alarm's key.
        key: usize,
    },
}

/// All that a [`Watch`] remembers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum WatchState {
    /// Of a bank.
    Bank(DetectorState),
    /// Of an isolator.
    Isolator(MonitorState),
}

impl WatchState {
    fn last_time_s(&self) -> Option<f64> {
        match self {
            Self::Bank(state) => state.last_time_s(),
            Self::Isolator(state) => state.last_time_s(),
        }
    }
}

enum Kind {
    Bank(Box<Detector>),
    Isolator(Box<Isolator>, Box<IsolationMonitor>),
}

/// A detector at work.
pub struct Watch {
    kind: Kind,
    name: String,
    sample_time_s: f64,
    inputs: Vec<Signal>,
    outputs: Vec<Signal>,
    statistic_names: Vec<String>,
    limits: Vec<f64>,
    residuals: Vec<f64>,
    statistics: Vec<f64>,
    settling: bool,
    events: Vec<WatchEvent>,
    /// Tests whose alarm is up.
    up: Vec<bool>,
    /// Time of the last diagnosis that was passed on.
    diagnosed_s: f64,
}

impl Watch {
    /// The detector of a file in its initial state.
    ///
    /// # Errors
    /// [`FdiError`](gtfdi::fdi::FdiError) when an isolator cannot be set to work.
    pub fn new(file: &DetectorFile) -> Result<Self, gtfdi::fdi::FdiError> {
        match file {
            DetectorFile::Bank(bank) => Ok(Self::of_bank(bank)),
            DetectorFile::Isolator(isolator) => Self::of_isolator(isolator),
        }
    }

    fn of_bank(bank: &Bank) -> Self {
        let signals = |tags| signals(bank.generators(), tags);
        let limits = bank.tests().iter().map(|test| test.threshold.limit);
        Self::with(
            Kind::Bank(Box::new(Detector::new(bank))),
            &bank.name,
            bank.sample_time_s(),
            [signals(bank.inputs()), signals(bank.outputs())],
            bank.test_names(),
            limits.collect(),
        )
    }

    fn of_isolator(isolator: &Isolator) -> Result<Self, gtfdi::fdi::FdiError> {
        let signals = |tags| signals(isolator.generators(), tags);
        let names = isolator.statistic_names().into_iter();
        let monitor = IsolationMonitor::new(isolator)?;
        Ok(Self::with(
            Kind::Isolator(Box::new(isolator.clone()), Box::new(monitor)),
            &isolator.name,
            isolator.sample_time_s(),
            [signals(isolator.inputs()), signals(isolator.outputs())],
            names.map(str::to_owned).collect(),
            isolator.limits().to_vec(),
        ))
    }

    fn with(
        kind: Kind,
        name: &str,
        sample_time_s: f64,
        [inputs, outputs]: [Vec<Signal>; 2],
        statistic_names: Vec<String>,
        limits: Vec<f64>,
    ) -> Self {
        Self {
            kind,
            name: name.to_owned(),
            sample_time_s,
            residuals: vec![f64::NAN; outputs.len()],
            statistics: vec![f64::NAN; limits.len()],
            up: vec![false; limits.len()],
            inputs,
            outputs,
            statistic_names,
            limits,
            settling: true,
            events: Vec::new(),
            diagnosed_s: f64::NEG_INFINITY,
        }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// `bank` or `isolator`.
    pub fn kind(&self) -> &'static str {
        match self.kind {
            Kind::Bank(_) => "bank",
            Kind::Isolator(..) => "isolator",
        }
    }

    /// Sample time in seconds.
    pub fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// The inputs (nu), in the order of a sample.
    pub fn inputs(&self) -> &[Signal] {
        &self.inputs
    }

    /// The outputs (ny), in the order of a sample.
    pub fn outputs(&self) -> &[Signal] {
        &self.outputs
    }

    /// Names of the statistics.
    pub fn statistic_names(&self) -> &[String] {
        &self.statistic_names
    }

    /// Limits of the statistics.
    pub fn limits(&self) -> &[f64] {
        &self.limits
    }

    /// Residuals of the last sample (ny), in the units of the outputs; NaN where there is none.
    pub fn residuals(&self) -> &[f64] {
        &self.residuals
    }

    /// Statistics of the last sample; NaN where there is none.
    pub fn statistics(&self) -> &[f64] {
        &self.statistics
    }

    /// Whether nothing is judged yet.
    pub fn is_settling(&self) -> bool {
        self.settling
    }

    /// Takes a sample: inputs `u` (nu) and outputs `y` (ny), NaN where there is none; `t_s` in
    /// seconds of the grid. Gives what happened, mostly nothing.
    ///
    /// # Errors
    /// As [`Detector::step`].
    pub fn step(&mut self, t_s: f64, u: &[f64], y: &[f64]) -> Result<&[WatchEvent], StepError> {
        self.events.clear();
        match &mut self.kind {
            Kind::Bank(detector) => {
                let verdict = detector.step(t_s, u, y)?;
                self.residuals.copy_from_slice(&verdict.residuals);
                self.settling = verdict.channels.iter().all(|channel| channel.settling);
                let own = self.statistics.iter_mut().zip(&mut self.up);
                for (key, (channel, (statistic, up))) in
                    verdict.channels.iter().zip(own).enumerate()
                {
                    *statistic = channel.statistic;
                    if channel.new_alarm {
                        let onset_s = channel.onset_age.map_or(channel.first_exceedance_s, |age| {
                            Some(t_s - age.saturating_sub(1) as f64 * self.sample_time_s)
                        });
                        self.events.push(WatchEvent::Raised {
                            key,
                            statistic: key,
                            value: channel.statistic,
                            limit: self.limits[key],
                            onset_s,
                        });
                    } else if *up && !channel.alarm {
                        self.events.push(WatchEvent::Ended { key });
                    }
                    *up = channel.alarm;
                }
            }
            Kind::Isolator(isolator, monitor) => {
                let events = monitor.step(t_s, u, y)?;
                for event in events {
                    match *event {
                        IsolationEvent::Alarm {
                            leading,
                            statistic,
                            limit,
                            ..
                        } => self.events.push(WatchEvent::Raised {
                            key: 0,
                            statistic: leading,
                            value: statistic,
                            limit,
                            onset_s: None,
                        }),
                        IsolationEvent::End { .. } => {
                            self.events.push(WatchEvent::Ended { key: 0 });
                        }
                        IsolationEvent::Name { .. } => {}
                    }
                }
                let verdict = monitor.verdict();
                self.statistics.copy_from_slice(&verdict.statistics);
                self.settling = verdict.settling;
                self.residuals.copy_from_slice(monitor.residuals());
                if let (Some(name), Some((time_s, diagnosis))) =
                    (monitor.name(), monitor.diagnosis())
                    && *time_s > self.diagnosed_s
                {
                    self.diagnosed_s = *time_s;
                    self.events.push(WatchEvent::Diagnosed {
                        key: 0,
                        diagnosis: Box::new(isolator.named(*time_s, name, diagnosis)),
                    });
                }
            }
        }
        Ok(&self.events)
    }

    /// Forgets all samples; alarms that were up are no longer, without an event.
    pub fn reset(&mut self) {
        match &mut self.kind {
            Kind::Bank(detector) => detector.reset(),
            Kind::Isolator(_, monitor) => monitor.reset(),
        }
        self.up.fill(false);
        self.residuals.fill(f64::NAN);
        self.statistics.fill(f64::NAN);
        self.settling = true;
        self.diagnosed_s = f64::NEG_INFINITY;
    }

    /// The keys of the alarms that are up.
    pub fn up(&self) -> Vec<usize> {
        match &self.kind {
            Kind::Bank(_) => (0..self.up.len()).filter(|key| self.up[*key]).collect(),
            Kind::Isolator(_, monitor) => monitor.name().map(|_| 0).into_iter().collect(),
        }
    }

    /// All that it remembers.
    pub fn state(&self) -> WatchState {
        match &self.kind {
            Kind::Bank(detector) => WatchState::Bank(detector.state()),
            Kind::Isolator(_, monitor) => WatchState::Isolator(monitor.state()),
        }
    }

    /// Goes on from a state of the same detector, bit for bit. `up` are the keys of the alarms that
    /// were up.
    ///
    /// # Errors
    /// [`ResumeError`] when the state is not one of this detector; it is then as it was.
    pub fn resume(&mut self, state: &WatchState, up: &[usize]) -> Result<(), ResumeError> {
        match (&mut self.kind, state) {
            (Kind::Bank(detector), WatchState::Bank(state)) => detector.resume(state)?,
            (Kind::Isolator(_, monitor), WatchState::Isolator(state)) => monitor.resume(state)?,
            _ => return Err(ResumeError::Bank),
        }
        self.diagnosed_s = state.last_time_s().unwrap_or(f64::NEG_INFINITY);
        for (key, own) in self.up.iter_mut().enumerate() {
            *own = up.contains(&key);
        }
        self.settling = false;
        Ok(())
    }
}

/// The signals of tags, with the units that generators have for them.
fn signals(generators: &[ResidualGenerator], tags: Vec<String>) -> Vec<Signal> {
    let known = generators.iter();
    let known: Vec<&Signal> = known
        .flat_map(|own| own.inputs().iter().chain(own.outputs()))
        .collect();
    let signal = |tag: String| {
        let own = known.iter().find(|signal| signal.name == tag);
        own.map_or_else(|| Signal::new(tag, ""), |own| (*own).clone())
    };
    tags.into_iter().map(signal).collect()
}
