//! What is refined, and whether a second record agrees.

use gt_core::Dataset;
use serde::{Deserialize, Serialize};

use super::run::RowRun;
use super::search::search;
use crate::denominator::Denominator;
use crate::regressor::Deviations;
use crate::{ArxModel, ArxRow, ArxStructure, IdentError, Term};

/// What a free run over the training record starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum InitialOutputs {
    /// The outputs before the window are parameters, `na` a row: with noisy outputs the measured
    /// ones would pull at the coefficients for as long as the slowest pole remembers them.
    #[default]
    Estimated,
    /// The measured outputs, as in [`ArxModel::simulate`].
    Measured,
}

/// The refinement of a diagonal ARX model on the error of its free run.
///
/// | Name | Default | Purpose | Range |
/// |---|---|---|---|
/// | `initial` | estimated | what the training run starts from | [`InitialOutputs`] |
/// | `max_radius` | 0.9999 | largest modulus of a pole | above 0, below 1 |
/// | `max_iterations` | 60 | most steps for a row | `0..` |
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OutputErrorRefinement {
    initial: InitialOutputs,
    max_radius: f64,
    max_iterations: usize,
}

impl Default for OutputErrorRefinement {
    fn default() -> Self {
        Self::new()
    }
}

/// A refined model and what came of each row.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Refined {
    /// The model: accepted rows are new, refused ones as they were. `residual_variance` stays the
    /// mean square of the equation error, now over the training record, so that it rises.
    pub model: ArxModel,
    /// One entry per output.
    pub outputs: Vec<RefinedOutput>,
}

/// The free-run errors of one output before and after; root mean squares in the output's unit,
/// over all samples but the first `max_lag`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RefinedOutput {
    /// The output's name.
    pub output: String,
    /// Whether the model has the refined row: `hold_out_after` lies below `hold_out_before`.
    pub accepted: bool,
    /// Training record, start model, from measured outputs.
    pub train_before: f64,
    /// Training record, refined row, from the initial outputs that were chosen.
    pub train_after: f64,
    /// Hold-out record, start model, from measured outputs; `None` where it diverges.
    pub hold_out_before: Option<f64>,
    /// Hold-out record, refined row, from measured outputs; `None` where it diverges.
    pub hold_out_after: Option<f64>,
    /// Largest modulus of a pole of the refined row.
    pub radius: f64,
    /// Steps that lowered the training error.
    pub iterations: usize,
}

impl OutputErrorRefinement {
    /// The refinement with its defaults.
    pub fn new() -> Self {
        Self {
            initial: InitialOutputs::Estimated,
            max_radius: 0.9999,
            max_iterations: 60,
        }
    }

    /// The same refinement from other initial outputs.
    #[must_use]
    pub fn initial(mut self, initial: InitialOutputs) -> Self {
        self.initial = initial;
        self
    }

    /// The same refinement with another largest modulus of a pole.
    #[must_use]
    pub fn max_radius(mut self, max_radius: f64) -> Self {
        self.max_radius = max_radius;
        self
    }

    /// The same refinement with another limit of steps.
    #[must_use]
    pub fn max_iterations(mut self, max_iterations: usize) -> Self {
        self.max_iterations = max_iterations;
        self
    }

    /// Refines each row on `train` and keeps it where its free run over `hold_out` is better than
    /// the start's. The operating point stays the model's.
    ///
    /// # Errors
    /// [`IdentError::NotDiagonal`] for another structure; [`IdentError::OptionRange`] for the
    /// radius; records that do not fit the model, are not finite or shorter than
    /// `max_lag + 1 + parameters`; [`IdentError::UnstableStart`] for a row whose poles lie outside
    /// the largest radius (see [`crate::constrained::ConstrainedArx`]).
    pub fn refine(
        &self,
        model: &ArxModel,
        train: &Dataset,
        hold_out: &Dataset,
    ) -> Result<Refined, IdentError> {
        let ArxStructure::Diagonal { na, .. } = *model.structure() else {
            return Err(IdentError::NotDiagonal {
                method: "output-error refinement",
                structure: model.structure().to_string(),
            });
        };
        if !(self.max_radius > 0.0 && self.max_radius < 1.0) {
            return Err(IdentError::OptionRange {
                option: "max_radius",
                expected: "above 0 and below 1",
                found: self.max_radius,
            });
        }
        let estimates = self.initial == InitialOutputs::Estimated;
        let first = model.max_lag();
        for data in [train, hold_out] {
            model.check_record(data)?;
            data.check_finite()?;
            let more = if estimates { na } else { 0 };
            model.structure().check_rows(
                data.nu(),
                data.ny(),
                first.saturating_add(more),
                data.len(),
            )?;
        }
        let record = Deviations::new(train, model.operating_point())?;
        let mut rows = Vec::new();
        let mut outputs = Vec::new();
        for (index, row) in model.rows().iter().enumerate() {
            let output = model.outputs()[index].name.clone();
            let from_measured = RowRun::new(&record, index, &row.terms, first, false);
            let run = RowRun::new(&record, index, &row.terms, first, estimates);
            let start = run.start(&row.terms);
            let radius = Denominator::from_own_lags(run.own_lags(&start)).radius()?;
            if radius > self.max_radius {
                return Err(IdentError::UnstableStart {
                    output,
                    limit: self.max_radius,
                    found: radius,
                });
            }
            let before = root_mean_square(&from_measured.errors(&from_measured.start(&row.terms)));
            let found = search(&run, start, self.max_radius, self.max_iterations)?;
            let terms: Vec<Term> = (row.terms.iter().zip(&found.parameters))
                .map(|(term, &value)| Term::new(term.regressor(), value))
                .collect();
            outputs.push(RefinedOutput {
                output,
                accepted: false,
                train_before: before,
                train_after: root_mean_square(&run.errors(&found.parameters)),
                hold_out_before: None,
                hold_out_after: None,
                radius: Denominator::from_own_lags(run.own_lags(&found.parameters)).radius()?,
                iterations: found.iterations,
            });
            rows.push(ArxRow {
                residual_variance: equation_error(&record, index, &terms, first),
                terms,
            });
        }
        let refined = model.with_rows(rows.clone())?;
        let before = free_run_errors(model, hold_out)?;
        let after = free_run_errors(&refined, hold_out)?;
        for (index, report) in outputs.iter_mut().enumerate() {
            (report.hold_out_before, report.hold_out_after) = (before[index], after[index]);
            let bound = before[index].unwrap_or(f64::INFINITY);
            report.accepted = after[index].is_some_and(|error| error < bound);
            if !report.accepted {
                rows[index] = model.rows()[index].clone();
            }
        }
        // A model that nothing of was accepted keeps its standard errors too.
        let model = if outputs.iter().any(|report| report.accepted) {
            model.with_rows(rows)?
        } else {
            model.clone()
        };
        Ok(Refined { model, outputs })
    }
}

/// Root mean square of the free-run error of each output; `None` where it diverges.
fn free_run_errors(model: &ArxModel, data: &Dataset) -> Result<Vec<Option<f64>>, IdentError> {
    let run = model.simulate(data)?;
    let errors = data.y() - &run.y;
    let window = errors.columns_range(model.max_lag()..);
    Ok((window.row_iter().zip(&run.diverges_at))
        .map(|(row, diverges_at)| {
            let row: Vec<f64> = row.iter().copied().collect();
            diverges_at.is_none().then(|| root_mean_square(&row))
        })
        .collect())
}

/// Mean square of the equation error of a row.
fn equation_error(record: &Deviations, output: usize, terms: &[Term], first: usize) -> f64 {
    let samples = record.y.nrows();
    let mut sum = record
        .y
        .view((first, output), (samples - first, 1))
        .into_owned();
    for term in terms {
        let column = record.lagged(term.regressor(), &(first..samples));
        for (rest, value) in sum.iter_mut().zip(column) {
            *rest -= term.coefficient * value;
        }
    }
    sum.norm_squared() / sum.len() as f64
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}
