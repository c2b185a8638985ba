//! `design` and `Bank`: observers with thresholds over whole records.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use gt_campaign::{
    StatisticChoice, StatisticName, TestPlan, Watch, kalman_generator, paper,
    unknown_input_generator,
};
use gt_log::{RunMetadata, read_json, write_json, write_verdicts};
use gtfdi::core::{Dataset, index_of};
use gtfdi::fdi::{
    Bank, FalseAlarmSummary, ResidualGenerator, ResidualTest, StatisticKind, ThresholdRule,
    Waveform, Whitening,
};
use gtfdi::ident::ArxModel;
use gtfdi::ident::eiv::EivModel;
use nalgebra::Complex;
use pyo3::prelude::*;
use pyo3::types::PyType;
use serde::Serialize;

use crate::array::{json_out, json_text, json_value};
use crate::arx_model::PyArxModel;
use crate::detection::PyDetection;
use crate::detector::PyDetector;
use crate::eiv_model::PyEivModel;
use crate::error::Failure;
use crate::interrupt::interruptible;
use crate::pickle::{Pickled, Reduced, reduce};
use crate::poles::Poles;
use crate::record::Given;

/// A bank of residual generators and of tests on their residuals; ``gtfdi.design`` makes one.
#[pyclass(frozen, eq, name = "Bank", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyBank {
    pub inner: Arc<Bank>,
}

impl PyBank {
    /// A record as it is given.
    fn data(
        &self,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
    ) -> Result<Arc<Dataset>, Failure> {
        Given::new(u, y)?.by_name(
            &self.inner.inputs(),
            &self.inner.outputs(),
            self.inner.sample_time_s(),
        )
    }

    fn new(inner: Bank) -> Self {
        let inner = Arc::new(inner);
        Self { inner }
    }
}

impl Pickled for PyBank {
    type Stored = Bank;

    fn stored(&self) -> Result<Bank, Failure> {
        Ok(Bank::clone(&self.inner))
    }

    fn restored(inner: Bank) -> Result<Self, Failure> {
        Ok(Self::new(inner))
    }
}

/// What `Bank.detectors` says of each.
#[derive(Serialize)]
struct DetectorReport<'a> {
    output: &'a str,
    outputs: &'a [String],
    poles: &'a [f64],
    complex_poles: Vec<Complex<f64>>,
    statistic: &'a StatisticKind,
    whitening_order: Option<usize>,
    limit: f64,
    consecutive: usize,
    settle_samples: usize,
    false_alarms: FalseAlarmSummary,
}

#[pymethods]
impl PyBank {
    /// The bank's name.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    /// Tags of all inputs that a generator reads and that are no output of the bank.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        self.inner.inputs()
    }

    /// Tags of the outputs, in the order of the generators.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        self.inner.outputs()
    }

    /// Units of the outputs, in the same order; empty where none was given.
    #[getter]
    fn output_units(&self) -> Vec<&str> {
        let generators = self.inner.generators().iter();
        let signals = generators.flat_map(ResidualGenerator::outputs);
        signals.map(|signal| signal.unit.as_str()).collect()
    }

    /// Names of the tests: that of the output where a test watches one.
    #[getter]
    fn tests(&self) -> Vec<String> {
        self.inner.test_names()
    }

    /// The false alarms of all tests together, counted by cross-validation when their limits were
    /// set: a dictionary with ``alarms``, ``hours``, ``per_hour``, ``per_hour_low`` and
    /// ``per_hour_high``.
    #[getter]
    fn false_alarms_per_hour<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json_out(py, "rate", &self.inner.false_alarms())
    }

    /// Sample time in seconds.
    #[getter]
    fn sample_time_s(&self) -> f64 {
        self.inner.sample_time_s()
    }

    /// A dictionary for each test: ``output`` (its name), ``outputs``, ``poles`` (empty where some
    /// are complex, or it reads several generators, or Kalman filters), ``complex_poles`` (``[re,
    /// im]`` each, where some are complex), ``statistic``, ``whitening_order``, ``limit``,
    /// ``consecutive``, ``settle_samples`` and ``false_alarms``, which were counted when the limit
    /// was set.
    #[getter]
    fn detectors<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        let report = |test: &ResidualTest| {
            let whitening = test.evaluation.whitening.as_ref();
            let own = self.inner.generator_of(test);
            json_out(
                py,
                "detector",
                &DetectorReport {
                    output: &test.name,
                    outputs: &test.outputs,
                    poles: own.map_or(&[], ResidualGenerator::poles),
                    complex_poles: own
                        .filter(|generator| generator.poles().is_empty())
                        .map_or_else(Vec::new, ResidualGenerator::complex_poles),
                    statistic: &test.evaluation.statistic,
                    whitening_order: whitening.map(Whitening::order),
                    limit: test.threshold.limit,
                    consecutive: test.threshold.consecutive,
                    settle_samples: self.inner.settle_samples(test),
                    false_alarms: test.false_alarms,
                },
            )
        };
        let reports: Vec<Bound<'py, PyAny>> = self
            .inner
            .tests()
            .iter()
            .map(report)
            .collect::<Result<_, Failure>>()?;
        Ok(reports.into_pyobject(py)?)
    }

    /// Runs the bank over a record: a Dataset, or arrays ``u`` and ``y`` with the channels of
    /// ``inputs`` and ``outputs``.
    ///
    /// Examples
    /// --------
    /// >>> bank.detect(run.measured).alarms
    /// []
    #[pyo3(signature = (u, y=None))]
    fn detect(
        &self,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
    ) -> Result<PyDetection, Failure> {
        let data = self.data(u, y)?;
        let bank = Arc::clone(&self.inner);
        let inner = interruptible(u.py(), move |abandoned| {
            Ok(bank.run_until(&data, abandoned)?)
        })?;
        Ok(PyDetection { inner })
    }

    /// Runs the bank over a record, as ``detect``, and writes residuals, statistics, limits and
    /// alarms as an MCAP log, as ``gtfdi detect --out`` does. The bank is attached.
    ///
    /// Parameters
    /// ----------
    /// path : path_like
    ///     The log; it appears only when it is whole.
    /// u, y
    ///     The record.
    ///
    /// Examples
    /// --------
    /// >>> from gtfdi import log
    /// >>> bank.write_verdicts("verdicts.mcap", run.measured)
    /// >>> log.verify("verdicts.mcap")["problems"]
    /// []
    #[pyo3(signature = (path, u, y=None))]
    fn write_verdicts(
        &self,
        path: PathBuf,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
    ) -> Result<(), Failure> {
        let data = self.data(u, y)?;
        let bank = Arc::clone(&self.inner);
        interruptible(u.py(), move |abandoned| {
            let data = data.select(&bank.inputs(), &bank.outputs())?;
            let run = bank.run_until(&data, abandoned)?;
            Ok(write_verdicts(
                &path,
                &bank,
                &data,
                &run,
                &RunMetadata::default(),
            )?)
        })
    }

    /// The online detector of the bank, with every generator in its initial state (Detector).
    fn detector(&self) -> PyDetector {
        PyDetector::new(Arc::clone(&self.inner))
    }

    /// Writes a bank file, as ``gtfdi design --out`` does.
    fn save(&self, py: Python<'_>, path: PathBuf) -> Result<(), Failure> {
        Ok(py.detach(|| write_json(&path, &*self.inner))?)
    }

    /// Reads a bank file; it is checked.
    #[classmethod]
    fn load(class: &Bound<'_, PyType>, path: PathBuf) -> Result<Self, Failure> {
        let inner: Bank = class.py().detach(|| read_json(&path))?;
        Ok(Self::new(inner))
    }

    /// The bank as JSON.
    fn to_json(&self) -> Result<String, Failure> {
        json_text("bank", &*self.inner)
    }

    /// A bank from the JSON that ``to_json`` gave; it is checked.
    #[classmethod]
    fn from_json(_class: &Bound<'_, PyType>, text: &str) -> Result<Self, Failure> {
        Ok(Self::new(json_value("bank", text)?))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        format!(
            "Bank({}, inputs: {}, outputs: {}, sample time {} s)",
            self.inner.name,
            self.inner.inputs().join(", "),
            self.inner.outputs().join(", "),
            self.inner.sample_time_s()
        )
    }
}

/// What a bank is designed for.
#[derive(FromPyObject)]
pub enum Model<'py> {
    /// A model of measured channels.
    #[pyo3(annotation = "ArxModel")]
    Arx(Bound<'py, PyArxModel>),
    /// A relation between noise-free channels.
    #[pyo3(annotation = "EivModel")]
    Eiv(Bound<'py, PyEivModel>),
}

impl Model<'_> {
    pub fn noise(&self) -> Option<&EivModel> {
        match self {
            Self::Arx(_) => None,
            Self::Eiv(model) => Some(&model.get().inner),
        }
    }

    pub fn equations(&self) -> &ArxModel {
        match self {
            Self::Arx(model) => &model.get().inner,
            Self::Eiv(model) => model.get().inner.relation(),
        }
    }
}

/// The poles of all observers, or by tag.
#[derive(FromPyObject)]
pub enum Placement {
    /// For every output.
    #[pyo3(annotation = "float or list of float or complex")]
    Common(Poles),
    /// By tag; outputs that are not named keep the default.
    #[pyo3(annotation = "dict")]
    ByTag(HashMap<String, Poles>),
}

fn rule(
    exceedance: Option<f64>,
    margin: Option<f64>,
    arl0_h: Option<f64>,
    consecutive: Option<usize>,
    statistic: StatisticName,
) -> Result<ThresholdRule, Failure> {
    let given = |default: usize| consecutive.unwrap_or(default);
    match (exceedance, margin, arl0_h) {
        (Some(share), None, None) => Ok(ThresholdRule::Exceedance {
            share,
            consecutive: given(6),
        }),
        (None, None, None) => Ok(statistic.default_rule(given(1))),
        (None, Some(factor), None) => Ok(ThresholdRule::Margin {
            factor,
            consecutive: given(1),
        }),
        (None, None, Some(hours)) => Ok(ThresholdRule::MeanTimeBetweenFalseAlarms {
            hours,
            consecutive: given(1),
        }),
        _ => Err(Failure::Option {
            option: "exceedance",
            expected: "one of exceedance, margin and arl0_h".to_owned(),
            found: "several".to_owned(),
        }),
    }
}

/// One of some words.
fn word<T: Copy>(
    option: &'static str,
    text: &str,
    words: &[(&'static str, T)],
) -> Result<T, Failure> {
    let found = words.iter().find(|(word, _)| *word == text);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let words: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
        Failure::Option {
            option,
            expected: format!("one of {}", words.join(", ")),
            found: text.to_owned(),
        }
    })
}

/// Which generators: observers or, `true`, Kalman filters.
pub fn is_kalman(generator: &str) -> Result<bool, Failure> {
    word(
        "generator",
        generator,
        &[("observer", false), ("kalman", true)],
    )
}

/// Refuses poles that no generator takes.
pub fn check_poles(
    model: &ArxModel,
    kalman: bool,
    poles: Option<&Placement>,
) -> Result<(), Failure> {
    if kalman && poles.is_some() {
        return Err(Failure::Option {
            option: "poles",
            expected: "none with the generator kalman, which chooses its own".to_owned(),
            found: "some".to_owned(),
        });
    }
    if let Some(Placement::ByTag(by_tag)) = poles {
        for tag in by_tag.keys() {
            index_of(model.outputs(), tag)?;
        }
    }
    Ok(())
}

/// Refuses unknown channels that no filter can do without.
fn check_unknown(
    model: &ArxModel,
    kalman: bool,
    noise: Option<&EivModel>,
    unknown: &[String],
) -> Result<(), Failure> {
    let Some(first) = unknown.first() else {
        return Ok(());
    };
    if !kalman || noise.is_none() {
        return Err(Failure::Option {
            option: "unknown",
            expected: "none without the generator kalman and an errors-in-variables model"
                .to_owned(),
            found: first.clone(),
        });
    }
    let channels = [model.inputs(), model.outputs()].concat();
    for tag in unknown {
        index_of(&channels, tag)?;
    }
    Ok(())
}

/// Records with the channels of a model.
pub fn known_records(
    model: &ArxModel,
    records: &[Bound<'_, PyAny>],
) -> Result<Vec<Dataset>, Failure> {
    let known = |record: &Bound<'_, PyAny>| {
        let given = Given::new(record, None)?;
        let data = given.known(model.inputs(), model.outputs(), model.sample_time_s())?;
        Ok(Arc::unwrap_or_clone(data))
    };
    records.iter().map(known).collect()
}

/// A generator for each output of a model.
pub fn generators(
    model: &ArxModel,
    noise: Option<&EivModel>,
    kalman: bool,
    poles: Option<&Placement>,
) -> Result<Vec<ResidualGenerator>, Failure> {
    let mut generators = Vec::with_capacity(model.outputs().len());
    for (index, output) in model.outputs().iter().enumerate() {
        let part = model.output_model(index)?;
        if kalman {
            generators.push(kalman_generator(model, noise, index, part)?);
            continue;
        }
        let nx = part.model.nx();
        let places = match poles {
            Some(Placement::Common(poles)) => Some(poles),
            Some(Placement::ByTag(by_tag)) => by_tag.get(&output.name),
            None => None,
        };
        let places = places.map_or_else(
            || vec![Complex::from(paper::default_pole(&output.name)); nx],
            |poles| poles.of(nx),
        );
        let observer = ResidualGenerator::observer_complex(part.model, part.point, &places)?;
        generators.push(observer);
    }
    Ok(generators)
}

/// Designs a bank: a residual generator for each output of a model, and tests on their residuals
/// with limits set on healthy records and false alarms counted by cross-validation.
///
/// Parameters
/// ----------
/// model : ArxModel or EivModel
///     The model; of an errors-in-variables model its relation, and its noise for ``"kalman"``.
/// healthy : list of Dataset, or of tuples (u, y)
///     Healthy records; tuples have the model's channels and sample time.
/// generator : str, optional
///     ``"observer"``: output observers with the given poles. ``"kalman"``: Kalman filters for the
///     noise of an errors-in-variables model; of an ARX model its one-step errors.
/// statistic : str, optional
///     ``"threshold"`` (the residual's modulus), ``"moving-average"``, ``"cusum"``, ``"glr"``,
///     ``"chi2"``, ``"shiryaev-roberts"``, ``"variance"`` or ``"whiteness"``; all but the first are
///     of the whitened residual, and only the first and ``"chi2"`` of several together.
/// watch : str, optional
///     ``"outputs"``: a test an output. ``"joint"``: one test on the norm of all residuals whitened
///     among themselves. ``"both"``.
/// unknown : list of str, optional
///     Inputs or outputs that may read anything, with ``"kalman"`` and an errors-in-variables model:
///     one filter whose residuals feel no error of theirs, and one test of them all. An input must
///     act at once or one sample later.
/// poles : float, list of float or complex, or dict, optional
///     Of observers: one pole for all states, one a state, or either by tag; complex ones together
///     with their conjugates. By default the paper's 0.7, 0.3, 0.4, 0.4 for q_c, t3, p7, m9 and 0.5
///     for any other tag. ``optimise_observer`` finds better ones.
/// window : int, optional
///     Samples: of ``"moving-average"`` and ``"variance"`` (125), ``"chi2"`` (25) or
///     ``"whiteness"`` (1125), the longest of ``"glr"`` (4096).
/// allowance : float, optional
///     Of ``"cusum"`` and ``"shiryaev-roberts"``: half the deviation to be found, in standard
///     deviations; 0.5.
/// waveform : str, optional
///     What ``"glr"`` looks for: ``"ramp"`` or ``"step"``.
/// sizes : tuple of float, optional
///     Its smallest and largest size: standard deviations a sample of ramps (1e-4, 1e-2), standard
///     deviations of steps (0.1, 10).
/// exceedance : float, optional
///     Limit by the share of healthy samples above it.
/// margin : float, optional
///     Limit as a multiple of the largest healthy value; 1.2 for ``"threshold"`` where no rule is
///     given.
/// arl0_h : float, optional
///     Limit by the mean time between false alarms of all tests together, in hours; 24 for the
///     other statistics where no rule is given.
/// consecutive : int, optional
///     Samples in a row above the limit that make an alarm; 6 with ``exceedance``, else 1.
/// in_sample : bool, optional
///     Whether the model was identified from these records: their residuals are then smaller than
///     those of any other, and count more.
///
/// Returns
/// -------
/// Bank
///
/// Raises
/// ------
/// DesignError
///     A pole or an option is out of its range, or the healthy records are too short.
///
/// Examples
/// --------
/// >>> healthy = [gtfdi.simulate(60.0, seed=seed).measured for seed in (2, 3)]
/// >>> gtfdi.design(model, healthy, poles={"q_c": 0.7}, margin=1.2).save("bank.json")
#[pyfunction]
#[pyo3(signature = (model, healthy, *, generator="observer", statistic="threshold",
    watch="outputs", unknown=None, poles=None, window=None, allowance=None, waveform=None, sizes=None,
    exceedance=None, margin=None, arl0_h=None, consecutive=None, in_sample=false),
    text_signature = "(model, healthy, *, generator='observer', statistic='threshold', \
    watch='outputs', unknown=None, poles=None, window=None, allowance=None, waveform=None, sizes=None, \
    exceedance=None, margin=None, arl0_h=None, consecutive=None, in_sample=False)")]
#[allow(clippy::too_many_arguments)] // Python names them
pub fn design(
    py: Python<'_>,
    model: Model<'_>,
    healthy: Vec<Bound<'_, PyAny>>,
    generator: &str,
    statistic: &str,
    watch: &str,
    unknown: Option<Vec<String>>,
    poles: Option<Placement>,
    window: Option<usize>,
    allowance: Option<f64>,
    waveform: Option<&str>,
    sizes: Option<(f64, f64)>,
    exceedance: Option<f64>,
    margin: Option<f64>,
    arl0_h: Option<f64>,
    consecutive: Option<usize>,
    in_sample: bool,
) -> Result<PyBank, Failure> {
    let kalman = is_kalman(generator)?;
    let name = word("statistic", statistic, &StatisticName::ALL)?;
    let waveforms = [("ramp", Waveform::Ramp), ("step", Waveform::Step)];
    let choice = StatisticChoice {
        name,
        window,
        allowance,
        waveform: waveform
            .map(|text| word("waveform", text, &waveforms))
            .transpose()?,
        sizes,
    };
    let watches = [
        ("outputs", Watch::Outputs),
        ("joint", Watch::Joint),
        ("both", Watch::Both),
    ];
    let plan = TestPlan {
        statistic: choice.kind().map_err(|refusal| Failure::Refusal {
            option: refusal.option,
            reason: refusal.reason,
        })?,
        rule: rule(exceedance, margin, arl0_h, consecutive, name)?,
        watch: word("watch", watch, &watches)?,
    };
    let (noise, model) = (model.noise().cloned(), model.equations().clone());
    check_poles(&model, kalman, poles.as_ref())?;
    let unknown = unknown.unwrap_or_default();
    check_unknown(&model, kalman, noise.as_ref(), &unknown)?;
    let healthy = known_records(&model, &healthy)?;
    let inner = interruptible(py, move |_| {
        let generators = match &noise {
            Some(noise) if !unknown.is_empty() => vec![unknown_input_generator(noise, &unknown)?],
            noise => generators(&model, noise.as_ref(), kalman, poles.as_ref())?,
        };
        let in_sample = vec![in_sample; healthy.len()];
        let tests = plan
            .tests(&model, &generators, &healthy, &in_sample)
            .map_err(|(_, error)| error)?;
        // The names of the command line, part of a bank's topics in a log.
        let name = if kalman { "filters" } else { "observers" };
        Ok(Bank::new(name, generators, tests)?)
    })?;
    Ok(PyBank::new(inner))
}
