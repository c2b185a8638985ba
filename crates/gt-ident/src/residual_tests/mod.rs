//! Are the one-step errors of a model white, and independent of past inputs?

mod autocorrelation;
mod chi_square;
mod cross_correlation;
mod options;
mod residuals;
mod verdict;
mod whiteness;

pub use autocorrelation::Autocorrelation;
pub use chi_square::ChiSquareTest;
pub use cross_correlation::CrossCorrelation;
pub use options::{RecordOrigin, ResidualOptions};
pub use verdict::{OutputVerdict, ResidualVerdict, Verdict};

use gt_core::{Dataset, Never, Signal, Stop, index_of};
use serde::{Deserialize, Serialize};

use crate::{ArxModel, Channel, IdentError};
use residuals::Residuals;

/// The tests on the equation errors (one step ahead) of a model on a record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ResidualReport {
    /// Number of residuals of each output, `T`.
    pub rows: usize,
    /// The options used.
    pub options: ResidualOptions,
    /// Autocorrelations, one entry per output.
    pub autocorrelations: Vec<Autocorrelation>,
    /// Whiteness of each output: Ljung and Box.
    pub ljung_box: Vec<Option<ChiSquareTest>>,
    /// Whiteness of all outputs together: Hosking. `None` where the errors of one output follow
    /// from those of the others.
    pub hosking: Option<ChiSquareTest>,
    /// Cross-correlations, all inputs of the first output first.
    pub cross_correlations: Vec<CrossCorrelation>,
    /// Independence of each output's errors from the past of all inputs together.
    pub independence: Vec<Option<ChiSquareTest>>,
}

/// Tests the equation errors of `model` on `data`.
///
/// Past inputs are those at lags `1..=M`, and lag 0 where the model has a term of the inputs at
/// lag 0.
///
/// # Errors
/// As [`ArxModel::predict`]; [`IdentError::TooFewRows`] with fewer than three residuals beyond the
/// coefficients of a row; [`IdentError::ResidualLags`] and [`IdentError::Significance`] for options
/// out of range; [`IdentError::NoResidual`] where an output's errors are zero or rounding.
pub fn test_residuals(
    model: &ArxModel,
    data: &Dataset,
    options: &ResidualOptions,
) -> Result<ResidualReport, IdentError> {
    test_residuals_until(model, data, options, &Never)
}

/// As [`test_residuals`], until `stop` wants it to end; it is asked before each test.
///
/// # Errors
/// As [`test_residuals`]; [`IdentError::Stopped`].
pub fn test_residuals_until(
    model: &ArxModel,
    data: &Dataset,
    options: &ResidualOptions,
    stop: &dyn Stop,
) -> Result<ResidualReport, IdentError> {
    let residuals = Residuals::new(model, data, options)?;
    let significance = options.significance;
    let direct = model
        .rows()
        .iter()
        .flat_map(|row| &row.terms)
        .any(|term| term.lag == 0 && matches!(term.channel, Channel::Input(_)));
    let past = usize::from(!direct)..=options.lags;
    let past_lags: Vec<i64> = past
        .clone()
        .filter_map(|lag| i64::try_from(lag).ok())
        .collect();
    let inputs: Vec<usize> = (0..data.nu()).collect();
    let mut report = ResidualReport {
        rows: residuals.count(),
        options: *options,
        autocorrelations: Vec::with_capacity(data.ny()),
        ljung_box: Vec::with_capacity(data.ny()),
        hosking: whiteness::hosking(&residuals),
        cross_correlations: Vec::with_capacity(data.ny() * data.nu()),
        independence: Vec::with_capacity(data.ny()),
    };
    for (output, signal) in data.outputs().iter().enumerate() {
        stop.check()?;
        let auto = Autocorrelation::new(&residuals, output, &signal.name, significance);
        report
            .ljung_box
            .push(whiteness::ljung_box(&residuals, &auto, output));
        report.autocorrelations.push(auto);
        for (input, other) in data.inputs().iter().enumerate() {
            stop.check()?;
            report.cross_correlations.push(CrossCorrelation::new(
                &residuals,
                (output, input),
                (&signal.name, &other.name),
                past.clone(),
                significance,
            ));
        }
        stop.check()?;
        report.independence.push(cross_correlation::independence(
            &residuals, output, &inputs, &past_lags,
        ));
    }
    Ok(report)
}

impl ResidualReport {
    /// The cross-correlation of an output's errors with an input, by name.
    ///
    /// # Errors
    /// [`IdentError::Data`] with the name that the record does not have.
    pub fn cross_correlation(
        &self,
        output: &str,
        input: &str,
    ) -> Result<&CrossCorrelation, IdentError> {
        let names = |names: &mut dyn Iterator<Item = &String>| -> Vec<Signal> {
            names.map(|name| Signal::new(name, "")).collect()
        };
        let outputs = names(&mut self.autocorrelations.iter().map(|each| &each.output));
        let row = index_of(&outputs, output)?;
        let channels = self.cross_correlations.len() / outputs.len();
        let own = &self.cross_correlations[row * channels..][..channels];
        let inputs = names(&mut own.iter().map(|each| &each.input));
        Ok(&own[index_of(&inputs, input)?])
    }

    /// What the tests say at the significance of the options.
    pub fn verdict(&self) -> ResidualVerdict {
        let significance = self.options.significance;
        let judge = |test: &Option<ChiSquareTest>| Verdict::new(test.as_ref(), significance);
        let outputs = self
            .autocorrelations
            .iter()
            .zip(self.ljung_box.iter().zip(&self.independence))
            .map(|(auto, (white, independent))| OutputVerdict {
                output: auto.output.clone(),
                whiteness: judge(white),
                independence: judge(independent),
            })
            .collect();
        ResidualVerdict {
            lags: self.options.lags,
            significance,
            joint_whiteness: judge(&self.hosking),
            outputs,
        }
    }
}
