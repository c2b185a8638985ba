//! From a model to the generators and tests of a bank: what the verb `design` and the Python
//! function of the same name share.

use gtfdi::core::{Dataset, Signal};
use gtfdi::fdi::{
    FdiError, NoiseCovariance, ObserverDesign, PoleSearch, RecordPair, ResidualGenerator,
    ResidualTest, StatisticKind, ThresholdRule,
};
use gtfdi::ident::eiv::EivModel;
use gtfdi::ident::{ArxModel, ArxRow, Channel, OutputModel};
use nalgebra::{DMatrix, Dyn, MatrixView, U1};

use crate::parallel;

/// The name of the test that watches all outputs together.
pub const JOINT_TEST: &str = "joint";

/// Which residuals are tested.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Watch {
    /// Each output's by itself, but those of one generator together.
    Outputs,
    /// All of them together.
    Joint,
    /// Each by itself, and all together.
    Both,
}

/// How residuals are tested.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TestPlan {
    /// The statistic of every test.
    pub statistic: StatisticKind,
    /// How limits are set. A mean time between false alarms is that of all tests together: each of
    /// `n` tests gets `n` times as long.
    pub rule: ThresholdRule,
    /// Which residuals.
    pub watch: Watch,
}

/// A row of a matrix.
type RowView<'a> = MatrixView<'a, f64, U1, Dyn, U1, Dyn>;

/// A refusal of a test, with its name, or of an observer, with that of its output.
pub type Refusal = (String, FdiError);

/// The Kalman filter of one output's row of a model, `part`, as a residual generator: for the
/// noise of an errors-in-variables model, or for the equation errors of an ARX model, whose optimal
/// predictor has all poles at zero.
///
/// # Errors
/// As [`ResidualGenerator::kalman`] and [`ResidualGenerator::observer`].
pub fn kalman_generator(
    model: &ArxModel,
    noise: Option<&EivModel>,
    output: usize,
    part: OutputModel,
) -> Result<ResidualGenerator, FdiError> {
    let Some(noise) = noise else {
        let poles = vec![0.0; part.model.nx()];
        return ResidualGenerator::observer(part.model, part.point, &poles);
    };
    let outputs = noise.output_noise();
    // The inputs of a part: those of the model, then the other outputs that its row uses.
    let others = (0..outputs.len()).filter(|&other| {
        let uses = |terms: &[gtfdi::ident::Term]| {
            terms
                .iter()
                .any(|term| term.channel == Channel::Output(other))
        };
        other != output && uses(&model.rows()[output].terms)
    });
    let inputs = noise.input_noise().iter().map(|channel| channel.variance);
    let inputs: Vec<f64> = inputs
        .chain(others.map(|other| outputs[other].variance))
        .collect();
    let own = [outputs[output].variance];
    let covariance = NoiseCovariance::errors_in_variables(&part.model, &inputs, &own)?;
    ResidualGenerator::kalman(part.model, part.point, covariance)
}

/// Searches the poles of the observers of `parts`, one an output of a model, each by the same pairs
/// of records; `None` for an output whose observer reads no channel that a fault of the training
/// pairs changes. Validation pairs do not count where none of them changes such a channel.
///
/// # Errors
/// As [`PoleSearch::design`], with the name of the output.
pub fn search_observers(
    search: &PoleSearch,
    parts: &[OutputModel],
    training: &[RecordPair],
    validation: &[RecordPair],
) -> Result<Vec<Option<ObserverDesign>>, Refusal> {
    let reached = |part: &OutputModel, pairs: &[RecordPair]| {
        let signals = part.model.inputs().iter().chain(part.model.outputs());
        let mut names = signals.map(|signal| signal.name.as_str());
        names.any(|name| pairs.iter().any(|pair| differs(pair, name)))
    };
    parallel::map(parts, |part| {
        if !reached(part, training) {
            return Ok(None);
        }
        let validation = if reached(part, validation) {
            validation
        } else {
            &[]
        };
        let found = search.design(&part.model, &part.point, training, validation);
        let name = || part.model.outputs()[0].name.clone();
        found.map(Some).map_err(|error| (name(), error))
    })
}

/// Whether a channel has other samples in the faulty record of a pair, or is missing in one.
fn differs(pair: &RecordPair, name: &str) -> bool {
    let (healthy, faulty) = (channel(pair.healthy, name), channel(pair.faulty, name));
    let (Some(healthy), Some(faulty)) = (healthy, faulty) else {
        return true;
    };
    let bits = |value: &f64| value.to_bits();
    !healthy.iter().map(bits).eq(faulty.iter().map(bits))
}

/// The samples of a channel.
fn channel<'a>(data: &'a Dataset, name: &str) -> Option<RowView<'a>> {
    let position = |signals: &[Signal]| signals.iter().position(|signal| signal.name == name);
    let input = position(data.inputs()).map(|index| data.u().row(index));
    input.or_else(|| position(data.outputs()).map(|index| data.y().row(index)))
}

/// How much larger the residuals of new records are than those of the record that a model was
/// identified from, for each output: `sqrt((T + p) / (T - p))` with `p` coefficients from `T` rows
/// (Akaike's final prediction error, *Annals of the Institute of Statistical Mathematics* 21, 1969).
/// A model with as many coefficients as rows has no error to go by: the factor then is that of the
/// fewest that leave one.
pub fn in_sample_optimism(model: &ArxModel) -> Vec<f64> {
    let rows = model.rows_used() as f64;
    let factor = |row: &ArxRow| {
        let coefficients = (row.terms.len() as f64).min(rows - 1.0);
        ((rows + coefficients) / (rows - coefficients))
            .sqrt()
            .max(1.0)
    };
    model.rows().iter().map(factor).collect()
}

impl TestPlan {
    /// Tests on the residuals of a model's generators, those of a generator with several outputs
    /// together, calibrated on healthy records; `in_sample` says from which records the model was
    /// identified ([`in_sample_optimism`]).
    ///
    /// # Errors
    /// As [`ResidualTest::calibrate_in_sample`], with the name of the test.
    pub fn tests(
        &self,
        model: &ArxModel,
        generators: &[ResidualGenerator],
        healthy: &[Dataset],
        in_sample: &[bool],
    ) -> Result<Vec<ResidualTest>, Refusal> {
        self.rule
            .validate()
            .map_err(|error| (model.outputs()[0].name.clone(), error))?;
        let factors = in_sample_optimism(model);
        let factor = |generator: &ResidualGenerator| {
            // The rows of all outputs made a filter of several, also of those that it reads.
            let others = match generator.outputs() {
                [_] => &[],
                _ => generator.inputs(),
            };
            let read = || generator.outputs().iter().chain(others);
            let outputs = model.outputs().iter().zip(&factors);
            let own = outputs.filter(|(output, _)| read().any(|signal| signal.name == output.name));
            own.fold(1.0, |largest: f64, (_, factor)| largest.max(*factor))
        };
        let optimism = DMatrix::from_fn(generators.len(), healthy.len(), |index, record| {
            if in_sample.get(record) == Some(&true) {
                factor(&generators[index])
            } else {
                1.0
            }
        });
        let mut groups: Vec<(String, std::ops::Range<usize>)> = Vec::new();
        if self.watch != Watch::Joint {
            for (index, generator) in generators.iter().enumerate() {
                let name = match generator.outputs() {
                    [output] => &output.name,
                    _ => JOINT_TEST,
                };
                groups.push((name.to_owned(), index..index + 1));
            }
        }
        let together = matches!(generators, [one] if one.outputs().len() > 1);
        if self.watch == Watch::Joint || (self.watch == Watch::Both && !together) {
            groups.push((JOINT_TEST.to_owned(), 0..generators.len()));
        }
        let rule = self.rule_for(groups.len());
        parallel::map(&groups, |(name, own)| {
            let optimism = optimism.rows(own.start, own.len()).into_owned();
            let group: Vec<&ResidualGenerator> = generators[own.clone()].iter().collect();
            let statistic = self.statistic;
            ResidualTest::calibrate_in_sample(name, &group, healthy, &optimism, statistic, rule)
                .map_err(|error| (name.clone(), error))
        })
    }

    /// The rule for each of `tests` tests.
    fn rule_for(&self, tests: usize) -> ThresholdRule {
        match self.rule {
            ThresholdRule::MeanTimeBetweenFalseAlarms { hours, consecutive } => {
                ThresholdRule::MeanTimeBetweenFalseAlarms {
                    hours: hours * tests as f64,
                    consecutive,
                }
            }
            rule => rule,
        }
    }
}
