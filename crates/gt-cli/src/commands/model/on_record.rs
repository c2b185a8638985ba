//! A model on a record: fits, residual tests, cancellations.

use std::path::Path;

use gt_log::ModelFile;
use gtfdi::core::Dataset;
use gtfdi::ident::pole_zero::{CANCELLATION_LIMIT, pole_zero};
use gtfdi::ident::{
    ArxModel, IdentError, OutputFit, RecordOrigin, ResidualOptions, ResidualReport,
    ResidualVerdict, Start, ValidationOptions, parameter_covariance, test_residuals,
    validate_records,
};
use serde::Serialize;

use crate::cli::CheckArgs;
use crate::commands::finding::{Finding, residual_findings};
use crate::failure::Failure;
use crate::output::number;

/// The checks of one record.
#[derive(Serialize)]
pub struct RecordReport {
    data: String,
    rows: usize,
    /// The parts between missing samples, where those break the record; no prediction and no free run
    /// reaches from one into another. The one-step errors are tested on the longest.
    parts: usize,
    input_sha256: String,
    /// Whether it is the record of the fit, which the tests allow for.
    origin: RecordOrigin,
    pub outputs: Vec<OutputFit>,
    /// Where free runs start: at the measured outputs, or where they fit the record best (for models
    /// with noise on the channels).
    pub free_run_start: Start,
    /// When the first free run diverges, in seconds.
    pub diverges_at: Option<f64>,
    /// Null where there is nothing to test.
    pub residual_tests: Option<ResidualReport>,
    pub residuals: Option<ResidualVerdict>,
    /// Why the residuals were not tested.
    pub untested: Option<String>,
    #[serde(skip)]
    pub findings: Vec<Finding>,
}

impl RecordReport {
    /// What the record is, in a line.
    pub fn head(&self) -> String {
        let origin = match self.origin {
            RecordOrigin::Fitted => "the record of the fit",
            RecordOrigin::Fresh => "not the record of the fit",
        };
        let parts = if self.parts > 1 {
            format!(" in {} parts", self.parts)
        } else {
            String::new()
        };
        format!("{}: {} rows{parts}, {origin}\n", self.data, self.rows)
    }
}

/// Checks `file` on the parts of a record, read from `path`.
pub fn on_record(
    file: &ModelFile,
    (path, parts, sha256): (&Path, &[Dataset], &str),
    args: &CheckArgs,
) -> Result<RecordReport, Failure> {
    let model = &file.model;
    let Some(data) = parts.iter().max_by_key(|data| data.len()) else {
        let found = "expected samples of all channels, found none";
        return Err(Failure::in_file(path, found));
    };
    let samples: usize = parts.iter().map(Dataset::len).sum();
    let equations = |data: &Dataset| data.len().saturating_sub(model.max_lag());
    let fitted = file.input_sha256.as_deref() == Some(sha256)
        && model.rows_used() == parts.iter().map(equations).sum::<usize>();
    let origin = if fitted {
        RecordOrigin::Fitted
    } else {
        RecordOrigin::Fresh
    };
    // Noise on the first samples would ring through a run that takes them as they are.
    let start = if file.noise.is_some() {
        Start::Fitted
    } else {
        Start::Measured
    };
    // They are asked for below, with options of their own.
    let without_tests = ValidationOptions {
        origin,
        start,
        residual_tests: false,
    };
    let all: Vec<&Dataset> = parts.iter().collect();
    let scores = validate_records(model, &all, without_tests)
        .map_err(|error| Failure::in_file(path, error))?;
    let mut findings = fits(&scores.outputs);
    let options = options(args, data.len().saturating_sub(model.max_lag()), origin);
    let (tests, untested) = if file.noise.is_some() {
        let why = "the noise on the inputs colours the one-step errors of this kind of model";
        (None, Some(why.to_owned()))
    } else {
        match test_residuals(model, data, &options) {
            Ok(report) => (Some(report), None),
            Err(error) => (None, Some(untested(error, args, path)?)),
        }
    };
    let residuals = tests.as_ref().map(ResidualReport::verdict);
    findings.extend(residuals.iter().flat_map(residual_findings));
    findings.extend(cancellations(model, data));
    Ok(RecordReport {
        data: path.display().to_string(),
        rows: samples,
        parts: parts.len(),
        input_sha256: sha256.to_owned(),
        origin,
        free_run_start: start,
        diverges_at: scores
            .outputs
            .iter()
            .filter_map(|fit| fit.diverges_at_s)
            .reduce(f64::min),
        outputs: scores.outputs,
        residual_tests: tests,
        residuals,
        untested,
        findings,
    })
}

/// The options of the tests: those given, the rest by the length of the record.
fn options(args: &CheckArgs, residuals: usize, origin: RecordOrigin) -> ResidualOptions {
    let defaults = ResidualOptions::for_residuals(residuals);
    ResidualOptions {
        lags: args.lags.unwrap_or(defaults.lags),
        significance: args.significance.unwrap_or(defaults.significance),
        origin,
    }
}

/// Why there is nothing to test; an option that is the reason is refused.
fn untested(error: IdentError, args: &CheckArgs, path: &Path) -> Result<String, Failure> {
    match error {
        IdentError::Significance { found } => Err(Failure::input(format!(
            "--significance: expected a number above 0 and below 1, found {found}"
        ))),
        IdentError::ResidualLags {
            lowest,
            highest,
            found,
        } if args.lags.is_some() => Err(Failure::in_file(
            path,
            format!("--lags: expected {lowest} to {highest}, found {found}"),
        )),
        IdentError::ResidualLags { .. }
        | IdentError::TooFewRows { .. }
        | IdentError::NoResidual { .. } => Ok(error.to_string()),
        error => Err(Failure::in_file(path, error)),
    }
}

/// Free runs that nobody would use.
fn fits(outputs: &[OutputFit]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for fit in outputs {
        let name = &fit.name;
        if let Some(time) = fit.diverges_at_s {
            findings.push(Finding {
                kind: "diverges",
                text: format!(
                    "the free run of `{name}` diverges at {} s",
                    number(Some(time))
                ),
                advice: "the model foretells one step and no more; identify with --stable, or \
                         with another order",
            });
        } else if fit.fit_simulation_percent.is_some_and(|fit| fit <= 0.0) {
            findings.push(Finding {
                kind: "poor_free_run",
                text: format!("the free run of `{name}` is no better than its mean"),
                advice: "check the operating point and the inputs; refine with --refine \
                         output-error, or identify on rows that hold this behaviour",
            });
        }
    }
    findings
}

/// Poles that zeros cancel in every channel, within the errors that a fit to this record has.
fn cancellations(model: &ArxModel, data: &Dataset) -> Option<Finding> {
    let covariance = parameter_covariance(model, data).ok()?;
    let report = pole_zero(model, &covariance).ok()?;
    let superfluous = report.superfluous_poles;
    if superfluous.is_empty() {
        return None;
    }
    let places: Vec<String> = superfluous
        .iter()
        .filter_map(|&index| report.poles.get(index))
        .map(|pole| number(Some(pole.root.value.norm())))
        .collect();
    Some(Finding {
        kind: "order_too_high",
        text: format!(
            "zeros cancel {} of {} poles within {CANCELLATION_LIMIT} standard errors in every \
             channel (moduli {})",
            superfluous.len(),
            report.poles.len(),
            places.join(", ")
        ),
        advice: "the order may be too high by as many",
    })
}
