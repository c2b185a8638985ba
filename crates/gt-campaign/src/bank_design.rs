//! From a model to the generators and tests of a bank: what the verb `design` and the Python
//! function of the same name share.

use gtfdi::core::Dataset;
use gtfdi::fdi::{
    FdiError, NoiseCovariance, ResidualGenerator, ResidualTest, StatisticKind, ThresholdRule,
};
use gtfdi::ident::eiv::EivModel;
use gtfdi::ident::{ArxModel, Channel, OutputModel};

/// The name of the test that watches all outputs together.
pub const JOINT_TEST: &str = "joint";

/// Which residuals are tested.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Watch {
    /// Each output's by itself.
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

/// A refusal of a test, with its name.
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

impl TestPlan {
    /// Tests on the residuals of generators, calibrated on healthy records.
    ///
    /// # Errors
    /// As [`ResidualTest::calibrate`], with the name of the test.
    pub fn tests(
        &self,
        generators: &[ResidualGenerator],
        healthy: &[Dataset],
    ) -> Result<Vec<ResidualTest>, Refusal> {
        let mut groups: Vec<(String, Vec<&ResidualGenerator>)> = Vec::new();
        if self.watch != Watch::Joint {
            for generator in generators {
                groups.push((generator.outputs()[0].name.clone(), vec![generator]));
            }
        }
        if self.watch != Watch::Outputs {
            groups.push((JOINT_TEST.to_owned(), generators.iter().collect()));
        }
        let rule = self.rule_for(groups.len());
        groups
            .into_iter()
            .map(|(name, group)| {
                ResidualTest::calibrate(&name, &group, healthy, self.statistic, rule)
                    .map_err(|error| (name, error))
            })
            .collect()
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
