//! The free run of an ARX model: it sees only the inputs.

use gt_core::Dataset;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use crate::regressor::Deviations;
use crate::{ArxModel, Channel, IdentError, Term};

/// A free run has diverged where an output leaves the model's operating point by more than this
/// many times the range that it has in the record.
pub const DIVERGENCE_FACTOR: f64 = 1e6;

/// The outputs of a model that sees only the inputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FreeRun {
    /// Outputs in the record's units (`ny x N`); the first `max_lag` columns are those of the
    /// [`Start`], and an output that diverged is NaN from there on.
    pub y: DMatrix<f64>,
    /// For each output, the sample from which the run is not finite or further than
    /// [`DIVERGENCE_FACTOR`] times the output's range in the record from the operating point.
    /// An output that is driven by a diverged one diverges with it.
    pub diverges_at: Vec<Option<usize>>,
}

/// Where a free run starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// The first `max_lag` measured outputs: right where they carry little noise.
    #[default]
    Measured,
    /// The first `max_lag` outputs with which the run comes closest to the record, those samples
    /// included (least squares, each output in units of its deviation). Noise on the first samples
    /// then does not ring through the run. It spends as many degrees of freedom of the record as
    /// samples are fitted. A run that diverges from the measured start, or that more than
    /// [`START_LIMIT`] samples have a part in, starts as measured.
    Fitted,
}

/// The largest number of first samples, over all outputs, that [`Start::Fitted`] fits.
pub const START_LIMIT: usize = 512;

/// Responses of the outputs that are below this share of their largest are over.
const RESPONSE_END: f64 = 1e-9;
/// A response that grows beyond this cannot be squared.
const RESPONSE_LIMIT: f64 = 1e100;
/// Entries of the matrix of responses at most (128 MB): a start is fitted to fewer samples sooner
/// than with more memory.
const RESPONSE_ENTRIES: usize = 1 << 24;

impl ArxModel {
    /// The outputs of a free run over the record's inputs, started from its first `max_lag`
    /// measured outputs.
    ///
    /// # Errors
    /// As [`ArxModel::predict`].
    pub fn simulate(&self, data: &Dataset) -> Result<FreeRun, IdentError> {
        self.simulate_from(data, Start::Measured)
    }

    /// The outputs of a free run over the record's inputs from a given start. A run that diverges
    /// from the measured start is not fitted.
    ///
    /// # Errors
    /// As [`ArxModel::predict`].
    pub fn simulate_from(&self, data: &Dataset, start: Start) -> Result<FreeRun, IdentError> {
        let mut record = self.deviations(data)?;
        let outputs = record.y.column_iter();
        let limits: Vec<f64> = outputs.map(|y| divergence_limit(y.iter())).collect();
        let mut run = self.run(&record, &limits);
        if start == Start::Fitted
            && run.converges()
            && let Some(change) = self.start_change(&record, &run.y)
        {
            let mut first = record.y.rows_mut(0, self.max_lag());
            first += change;
            let fitted = self.run(&record, &limits);
            if fitted.converges() {
                run = fitted;
            }
        }
        let mut y = run.y.transpose();
        for mut column in y.column_iter_mut() {
            column += &self.operating_point().y;
        }
        if start == Start::Measured {
            y.columns_mut(0, self.max_lag())
                .copy_from(&data.y().columns(0, self.max_lag()));
        }
        Ok(FreeRun {
            y,
            diverges_at: run.diverges_at,
        })
    }

    /// The run from the first `max_lag` outputs of `record` on, until it leaves the limits.
    fn run(&self, record: &Deviations, limits: &[f64]) -> Run {
        let mut y = record.y.clone();
        let mut diverges_at = vec![None; y.ncols()];
        for t in self.max_lag()..y.nrows() {
            for (output, row) in self.rows().iter().enumerate() {
                let value: f64 = if diverges_at[output].is_some() {
                    f64::NAN
                } else {
                    row.terms
                        .iter()
                        .map(|term| contribution(term, &y, &record.u, t))
                        .sum()
                };
                if value.abs() <= limits[output] {
                    y[(t, output)] = value;
                } else {
                    y[(t, output)] = f64::NAN;
                    diverges_at[output].get_or_insert(t);
                }
            }
        }
        Run { y, diverges_at }
    }

    /// What to add to the first outputs (`max_lag x ny`) so that the run comes closest to the
    /// record; `None` where they are too many or move the run beyond all numbers.
    fn start_change(&self, record: &Deviations, run: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let (lags, outputs) = (self.max_lag(), record.y.ncols());
        let unknowns = self.samples_in_use(outputs);
        if unknowns.is_empty() || unknowns.len() > START_LIMIT {
            return None;
        }
        let deviations = record.y.column_iter().map(|y| y.variance().sqrt());
        let units: Vec<f64> = deviations
            .map(|unit| if unit.is_normal() { unit } else { 1.0 })
            .collect();
        let most = RESPONSE_ENTRIES / (outputs * unknowns.len());
        let rows = record.y.nrows().min(most);
        if rows <= lags {
            return None;
        }
        let mut responses = DMatrix::zeros(rows * outputs, unknowns.len());
        for (&(t, output), mut column) in unknowns.iter().zip(responses.column_iter_mut()) {
            let mut y = DMatrix::zeros(rows, outputs);
            y[(t, output)] = units[output];
            self.respond(&mut y);
            for (index, value) in column.iter_mut().enumerate() {
                *value = y[(index / outputs, index % outputs)] / units[index % outputs];
            }
        }
        let largest = responses.amax();
        // NaN is not below either.
        if !(largest < RESPONSE_LIMIT && responses.iter().all(|value| value.is_finite())) {
            return None;
        }
        let moves = |row: &usize| responses.row(*row).amax() > RESPONSE_END * largest;
        let used = (lags * outputs).max((0..responses.nrows()).rev().find(moves)? + 1);
        let responses = responses.rows(0, used).into_owned();
        let mut target = DVector::from_fn(used, |index, _| {
            let (t, output) = (index / outputs, index % outputs);
            (record.y[(t, output)] - run[(t, output)]) / units[output]
        });
        // Every unknown is a sample of the target itself: the columns are independent.
        let factor = responses.qr();
        factor.q_tr_mul(&mut target);
        let target = target.rows(0, unknowns.len());
        let change = factor.r().solve_upper_triangular(&target)?;
        let mut all = DMatrix::zeros(lags, outputs);
        for (&(t, output), change) in unknowns.iter().zip(&change) {
            all[(t, output)] = change * units[output];
        }
        Some(all)
    }

    /// The samples before the run, as (time, output), that some row looks back at.
    fn samples_in_use(&self, outputs: usize) -> Vec<(usize, usize)> {
        let lags = self.max_lag();
        let longest = |output: usize| {
            let terms = self.rows().iter().flat_map(|row| &row.terms);
            let own = terms.filter(|term| term.channel == Channel::Output(output));
            own.map(|term| term.lag).max().unwrap_or(0)
        };
        (0..outputs)
            .flat_map(|output| (lags - longest(output)..lags).map(move |t| (t, output)))
            .collect()
    }

    /// The outputs (`rows x ny`) without inputs from the first `max_lag` on.
    fn respond(&self, y: &mut DMatrix<f64>) {
        for t in self.max_lag()..y.nrows() {
            for (output, row) in self.rows().iter().enumerate() {
                let terms = row.terms.iter().filter_map(|term| match term.channel {
                    Channel::Output(index) => Some(term.coefficient * y[(t - term.lag, index)]),
                    Channel::Input(_) => None,
                });
                y[(t, output)] = terms.sum();
            }
        }
    }
}

/// A run in deviations (`N x ny`).
struct Run {
    y: DMatrix<f64>,
    diverges_at: Vec<Option<usize>>,
}

impl Run {
    fn converges(&self) -> bool {
        self.diverges_at.iter().all(Option::is_none)
    }
}

/// The value of one term at `t` (`y` and `u` are `N x channels`).
pub(crate) fn contribution(term: &Term, y: &DMatrix<f64>, u: &DMatrix<f64>, t: usize) -> f64 {
    let value = match term.channel {
        Channel::Output(index) => y[(t - term.lag, index)],
        Channel::Input(index) => u[(t - term.lag, index)],
    };
    term.coefficient * value
}

/// The deviation beyond which a free run counts as diverged; 1 stands for the range of an output
/// that neither moves nor leaves the operating point.
pub(crate) fn divergence_limit<'a>(deviations: impl Iterator<Item = &'a f64>) -> f64 {
    let (low, high, most) = deviations.fold(
        (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64),
        |(low, high, most), &x| (low.min(x), high.max(x), most.max(x.abs())),
    );
    let range = if high > low { high - low } else { most };
    DIVERGENCE_FACTOR * if range > 0.0 { range } else { 1.0 }
}
