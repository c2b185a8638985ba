//! A bank of residual generators and of tests on their residuals, and its run over a record.

use gt_core::{Dataset, Never, Stop};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::channels::{Channels, check_sample_time, check_unique};
use super::false_alarm::FalseAlarmRate;
use super::generator::ResidualGenerator;
use super::residual_test::ResidualTest;
use super::whitening::Whitening;
use crate::FdiError;
use crate::runtime::{Channel, ChannelParts, ChannelVerdict, Detector, Parts};

/// The version of the file format of a [`Bank`].
pub const SCHEMA_VERSION: u32 = 2;

/// Residual generators at one sample time, each output with one, and tests on their residuals.
///
/// Construction and deserialisation both check the format's version, the sample times, the
/// tests, that no output has two generators, and that every test finds its outputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct Bank {
    /// The version of the file format, [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// The bank's name.
    pub name: String,
    sample_time_s: f64,
    generators: Vec<ResidualGenerator>,
    tests: Vec<ResidualTest>,
}

/// The fields of a [`Bank`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    schema_version: u32,
    name: String,
    sample_time_s: f64,
    #[serde(default)]
    generators: Vec<ResidualGenerator>,
    #[serde(default)]
    tests: Vec<ResidualTest>,
    /// What version 1 had in the place of both, so that its version is told and not its keys.
    #[serde(default, rename = "detectors")]
    _detectors: Option<serde::de::IgnoredAny>,
}

impl TryFrom<Unchecked> for Bank {
    type Error = FdiError;

    fn try_from(raw: Unchecked) -> Result<Self, FdiError> {
        if raw.schema_version != SCHEMA_VERSION {
            let found = raw.schema_version;
            return Err(FdiError::SchemaVersion {
                expected: SCHEMA_VERSION,
                found,
            });
        }
        let bank = Self::new(raw.name, raw.generators, raw.tests)?;
        check_sample_time("the bank", bank.sample_time_s, raw.sample_time_s)?;
        Ok(bank)
    }
}

impl Bank {
    /// A checked bank; its sample time is that of its generators.
    ///
    /// # Errors
    /// [`FdiError`] when there is no generator or no test, sample times differ, an output has two
    /// generators, two tests have one name, a test watches an output without a generator, or a
    /// limit is out of range.
    pub fn new(
        name: impl Into<String>,
        generators: Vec<ResidualGenerator>,
        tests: Vec<ResidualTest>,
    ) -> Result<Self, FdiError> {
        let name = name.into();
        let (Some(first), false) = (generators.first(), tests.is_empty()) else {
            return Err(FdiError::EmptyBank { name });
        };
        let sample_time_s = first.sample_time_s();
        for generator in &generators {
            let tags = tags(generator).collect::<Vec<_>>().join(", ");
            let what = format!("the generator of `{tags}`");
            check_sample_time(&what, sample_time_s, generator.sample_time_s())?;
        }
        let signals = generators.iter().flat_map(ResidualGenerator::outputs);
        let outputs: Vec<&String> = signals.map(|signal| &signal.name).collect();
        check_unique("outputs of the bank", &outputs)?;
        let names: Vec<&String> = tests.iter().map(|test| &test.name).collect();
        check_unique("tests of the bank", &names)?;
        for test in &tests {
            test.validate()?;
            check_unique(
                "outputs of a test",
                &test.outputs.iter().collect::<Vec<_>>(),
            )?;
            let absent = test.outputs.iter().filter(|tag| !outputs.contains(tag));
            let missing: Vec<String> = absent.cloned().collect();
            if !missing.is_empty() {
                return Err(FdiError::MissingTags {
                    missing,
                    available: outputs.into_iter().cloned().collect(),
                });
            }
        }
        Ok(Self {
            schema_version: SCHEMA_VERSION,
            name,
            sample_time_s,
            generators,
            tests,
        })
    }

    /// Sample time in seconds.
    pub fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// The generators.
    pub fn generators(&self) -> &[ResidualGenerator] {
        &self.generators
    }

    /// The tests.
    pub fn tests(&self) -> &[ResidualTest] {
        &self.tests
    }

    /// Tags of all inputs that a generator reads, each once, in the order of first appearance; those
    /// that are outputs of the bank are read there.
    pub fn inputs(&self) -> Vec<String> {
        let outputs = self.outputs();
        let mut tags: Vec<String> = Vec::new();
        for signal in self.generators.iter().flat_map(ResidualGenerator::inputs) {
            if !tags.contains(&signal.name) && !outputs.contains(&signal.name) {
                tags.push(signal.name.clone());
            }
        }
        tags
    }

    /// Tags of the outputs, in the order of the generators.
    pub fn outputs(&self) -> Vec<String> {
        let all = self.generators.iter().flat_map(tags);
        all.map(str::to_owned).collect()
    }

    /// Names of the tests.
    pub fn test_names(&self) -> Vec<String> {
        self.tests.iter().map(|test| test.name.clone()).collect()
    }

    /// The generator whose outputs are those of a test, in their order, where it reads just one.
    pub fn generator_of(&self, test: &ResidualTest) -> Option<&ResidualGenerator> {
        let generators = self.generators.iter();
        let mut own = generators.filter(|generator| tags(generator).eq(&test.outputs));
        own.next()
    }

    /// Samples before a test judges: until those of the bank's generators that it reads have
    /// settled and its whitening has its past.
    pub fn settle_samples(&self, test: &ResidualTest) -> usize {
        let own = self
            .sources(test)
            .map(|source| self.generators[source].settle_samples());
        let whitening = test.evaluation.whitening.as_ref();
        own.max().unwrap_or(0) + whitening.map_or(0, Whitening::order)
    }

    /// The false alarms of all tests together, as counted by cross-validation when their limits were
    /// set: alarms that several tests raise count several times.
    pub fn false_alarms(&self) -> FalseAlarmRate {
        let rates = self
            .tests
            .iter()
            .map(|test| test.false_alarms.cross_validated);
        // The tests of a bank are calibrated on the same records; the shortest time is the safe one.
        let hours = rates
            .clone()
            .map(|rate| rate.hours)
            .fold(f64::MAX, f64::min);
        let alarms = rates.clone().map(|rate| rate.alarms).sum();
        let fallback = self.tests[0].false_alarms.cross_validated;
        FalseAlarmRate::from_counts(alarms, hours).unwrap_or(fallback)
    }

    /// The generators that a test reads.
    fn sources<'a>(&'a self, test: &'a ResidualTest) -> impl Iterator<Item = usize> + 'a {
        let generators = self.generators.iter().enumerate();
        let read = generators.filter(|(_, generator)| {
            tags(generator).any(|tag| test.outputs.iter().any(|own| own == tag))
        });
        read.map(|(index, _)| index)
    }

    /// Runs the bank over a record that has its channels, by name, in any order and among others:
    /// the online [`Detector`], sample by sample.
    ///
    /// # Errors
    /// [`FdiError::MissingTags`] and [`FdiError::SampleTime`] when the record does not fit.
    pub fn run(&self, data: &Dataset) -> Result<BankRun, FdiError> {
        self.run_until(data, &Never)
    }

    /// As [`Bank::run`], until `stop` wants it to end; it is asked at every sample.
    ///
    /// # Errors
    /// As [`Bank::run`]; [`FdiError::Stopped`].
    pub fn run_until(&self, data: &Dataset, stop: &dyn Stop) -> Result<BankRun, FdiError> {
        let (inputs, outputs) = (self.inputs(), self.outputs());
        let mut channels = Channels::of(data, self.sample_time_s, &inputs, &outputs)?;
        let mut detector = Detector::new(self);
        let mut log = AlarmLog::new(self);
        let mut residuals = DMatrix::zeros(outputs.len(), data.len());
        let mut statistics = DMatrix::zeros(self.tests.len(), data.len());
        let mut time_s = Vec::with_capacity(data.len());
        for sample in 0..data.len() {
            stop.check()?;
            let (u, y) = channels.at(sample);
            let verdict = detector.step(data.time_s(sample), u, y)?;
            time_s.push(verdict.time_s);
            residuals
                .column_mut(sample)
                .copy_from_slice(&verdict.residuals);
            for (index, channel) in verdict.channels.iter().enumerate() {
                statistics[(index, sample)] = channel.statistic;
                log.take(verdict.time_s, index, channel);
            }
        }
        let share_above_limit = log.shares();
        let judged = log.counts.iter().map(|&(judged, _)| judged).collect();
        Ok(BankRun {
            time_s,
            outputs,
            residuals,
            tests: self.test_names(),
            statistics,
            alarms: log.alarms,
            judged,
            share_above_limit,
        })
    }
}

/// Tags of a generator's outputs.
fn tags(generator: &ResidualGenerator) -> impl Iterator<Item = &str> {
    generator
        .outputs()
        .iter()
        .map(|signal| signal.name.as_str())
}

impl Detector {
    /// The online detector of a bank, with every generator in its initial state.
    pub fn new(bank: &Bank) -> Self {
        let (inputs, outputs) = (bank.inputs(), bank.outputs());
        let generators = bank.generators.iter().map(|generator| {
            let own = generator.inputs().iter();
            let places = own
                .filter_map(|signal| {
                    let mut all = inputs.iter().chain(&outputs);
                    all.position(|tag| *tag == signal.name)
                })
                .collect();
            generator.runtime(places)
        });
        let generators = generators.collect();
        let channels = bank.tests.iter().filter_map(|test| {
            let own = test.outputs.iter();
            let places = own.filter_map(|name| outputs.iter().position(|tag| tag == name));
            let whitening = test.evaluation.whitening.as_ref();
            let one = test.outputs.len() == 1;
            // The bank has checked the statistic's numbers; the limit may be 0, which the
            // statistic itself, not compared with its own threshold here, does not take.
            let threshold = test.threshold.limit.max(f64::MIN_POSITIVE);
            let evaluator = test.evaluation.statistic.evaluator(threshold).ok()?;
            Some(Channel::new(ChannelParts {
                sources: bank.sources(test).collect(),
                places: places.collect(),
                whitener: whitening.map(Whitening::runtime),
                evaluator,
                unit: whitening.filter(|_| one).map_or(1.0, Whitening::unit),
                limit: test.threshold.limit,
                persistence: test.persistence(),
                settle_samples: bank.settle_samples(test),
            }))
        });
        let channels = channels.collect();
        Self::from_parts(Parts {
            inputs: inputs.clone(),
            outputs: outputs.clone(),
            tests: bank.test_names(),
            sample_time_s: bank.sample_time_s,
            generators,
            channels,
        })
    }
}

/// An alarm event.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Alarm {
    /// Time at which the alarm came up, in seconds.
    pub time_s: f64,
    /// Time of the first sample of the run above the limit, in seconds.
    pub first_exceedance_s: f64,
    /// The likeliest onset of the fault in seconds, where the statistic tells.
    pub onset_s: Option<f64>,
    /// The test's name: the output's tag where it watches one.
    pub tag: String,
    /// The residual when the alarm came up: see [`ChannelVerdict::residual`].
    pub residual: f64,
    /// The statistic when the alarm came up.
    pub statistic: f64,
    /// The limit that the statistic exceeds.
    pub threshold: f64,
    /// The likeliest deviation of the residual's mean when the alarm came up, in the output's unit,
    /// where the statistic tells.
    pub deviation: Option<f64>,
    /// Time of the sample that ended the alarm: the last of those within the limit that it waits
    /// for, or one without a residual, in seconds; `None` when the record ends before.
    pub end_s: Option<f64>,
}

/// What a bank says of a record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BankRun {
    /// Times of the samples in seconds (N).
    pub time_s: Vec<f64>,
    /// Tags of the outputs, the rows of `residuals`.
    pub outputs: Vec<String>,
    /// Residuals (one row an output, N columns) in the outputs' units, settling included; NaN where
    /// a sample is missing.
    pub residuals: DMatrix<f64>,
    /// Names of the tests, the rows of `statistics`.
    pub tests: Vec<String>,
    /// Statistics (one row a test, N columns); NaN where nothing is judged.
    pub statistics: DMatrix<f64>,
    /// Alarm events in order of time.
    pub alarms: Vec<Alarm>,
    /// For each test the samples that were judged: settled, with a residual.
    pub judged: Vec<usize>,
    /// For each test the share of its judged samples above the limit; NaN when none was judged.
    pub share_above_limit: Vec<f64>,
}

/// Collects alarm events and counts exceedances while a bank runs.
struct AlarmLog<'a> {
    bank: &'a Bank,
    alarms: Vec<Alarm>,
    /// For each test the position of its open alarm.
    open: Vec<Option<usize>>,
    /// For each test the judged samples and those above the limit.
    counts: Vec<(usize, usize)>,
}

impl<'a> AlarmLog<'a> {
    fn new(bank: &'a Bank) -> Self {
        let size = bank.tests.len();
        let (open, counts) = (vec![None; size], vec![(0, 0); size]);
        Self {
            bank,
            alarms: Vec::new(),
            open,
            counts,
        }
    }

    fn take(&mut self, time_s: f64, index: usize, channel: &ChannelVerdict) {
        if !channel.settling && channel.residual.is_finite() {
            self.counts[index].0 += 1;
            self.counts[index].1 += usize::from(channel.exceeds);
        }
        if channel.new_alarm {
            let test = &self.bank.tests[index];
            let age = channel.onset_age;
            self.open[index] = Some(self.alarms.len());
            self.alarms.push(Alarm {
                time_s,
                first_exceedance_s: channel.first_exceedance_s.unwrap_or(time_s),
                onset_s: age.map(|age| time_s - (age as f64 - 1.0) * self.bank.sample_time_s),
                tag: test.name.clone(),
                residual: channel.residual,
                statistic: channel.statistic,
                threshold: test.threshold.limit,
                deviation: channel.deviation,
                end_s: None,
            });
        } else if !channel.alarm
            && let Some(open) = self.open[index].take()
        {
            self.alarms[open].end_s = Some(time_s);
        }
    }

    fn shares(&self) -> Vec<f64> {
        self.counts
            .iter()
            .map(|&(judged, above)| above as f64 / judged as f64)
            .collect()
    }
}
