//! The free run of an ARX model: it sees only the inputs.

use gt_core::Dataset;
use nalgebra::{DMatrix, DVector};

use crate::regressor::Deviations;
use crate::{ArxModel, Channel, IdentError, Term};

/// A free run has diverged where an output leaves the model's operating point by more than this
/// many times the range that it has in the record.
pub const DIVERGENCE_FACTOR: f64 = 1e6;

/// The outputs of a model that sees only the inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeRun {
    /// Outputs in the record's units (`ny x N`); the first `max_lag` columns are the measured
    /// ones, and an output that diverged is NaN from there on.
    pub y: DMatrix<f64>,
    /// For each output, the sample from which the run is not finite or further than
    /// [`DIVERGENCE_FACTOR`] times the output's range in the record from the operating point.
    /// An output that is driven by a diverged one diverges with it.
    pub diverges_at: Vec<Option<usize>>,
}

/// Where a free run starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Start {
    /// The first `max_lag` measured outputs: right where they carry little noise.
    #[default]
    Measured,
    /// The first `max_lag` outputs with which the run comes closest to the record (least squares,
    /// each output in units of its deviation; of those that come equally close, the ones nearest to
    /// the measured ones). Noise on the first samples then does not ring through the run.
    Fitted,
}

/// Responses of the outputs that are below this share of their largest are over.
const RESPONSE_END: f64 = 1e-9;
/// Directions of the start that move the outputs less than this, relative to the most that one does,
/// stay as measured.
const START_TOLERANCE: f64 = 1e-9;
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
    /// record; `None` where nothing can be said.
    fn start_change(&self, record: &Deviations, run: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let (lags, outputs) = (self.max_lag(), record.y.ncols());
        let unknowns = lags * outputs;
        if unknowns == 0 {
            return None;
        }
        let deviations = record.y.column_iter().map(|y| y.variance().sqrt());
        let units: Vec<f64> = deviations
            .map(|unit| if unit.is_normal() { unit } else { 1.0 })
            .collect();
        let rows = record
            .y
            .nrows()
            .min(RESPONSE_ENTRIES / (outputs * unknowns));
        let mut responses = DMatrix::zeros(rows * outputs, unknowns);
        for (unknown, mut column) in responses.column_iter_mut().enumerate() {
            let mut y = DMatrix::zeros(rows, outputs);
            y[(unknown % lags, unknown / lags)] = units[unknown / lags];
            self.respond(&mut y);
            for (index, value) in column.iter_mut().enumerate() {
                *value = y[(index / outputs, index % outputs)] / units[index % outputs];
            }
        }
        if !responses.iter().all(|value| value.is_finite()) {
            return None;
        }
        let floor = RESPONSE_END * responses.amax();
        let last = (0..responses.nrows()).rfind(|&row| responses.row(row).amax() > floor)?;
        let responses = responses.remove_rows(last + 1, rows * outputs - last - 1);
        if responses.nrows() < unknowns {
            return None;
        }
        let target = DVector::from_fn(last + 1, |index, _| {
            let (t, output) = (index / outputs, index % outputs);
            (record.y[(t, output)] - run[(t, output)]) / units[output]
        });
        let factor = responses.qr();
        let mut projected = target;
        factor.q_tr_mul(&mut projected);
        let inner = factor.r().svd(true, true);
        let tolerance = START_TOLERANCE * inner.singular_values.amax();
        let projected = projected.rows(0, unknowns).into_owned();
        let change = inner.solve(&projected, tolerance).ok()?;
        Some(DMatrix::from_fn(lags, outputs, |lag, output| {
            change[output * lags + lag] * units[output]
        }))
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
