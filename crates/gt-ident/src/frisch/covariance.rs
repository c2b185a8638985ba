//! Covariances of lagged channels on one window, kept as a square root.

use std::ops::Range;

use gt_core::{Dataset, DimensionError};
use nalgebra::DMatrix;

use crate::least_squares::{scaled_norm, triangular_factor};
use crate::regressor::{Deviations, check_varies};
use crate::symmetric::upper_root;
use crate::{Channel, IdentError, Regressor};

/// The covariances of one output and the inputs at lags `0..=max_lag`, each channel scaled to unit
/// deviation.
///
/// Channel 0 is the output, channel `j + 1` is input `j`. What is kept is a square root `R` with
/// `covariance = R' R`: from a record the triangular factor of the lagged samples over `sqrt T`, so
/// that the condition of the samples is never squared.
#[derive(Debug, Clone, PartialEq)]
pub struct LaggedCovariance {
    /// `K x (1 + nu)(max_lag + 1)`, columns channel by channel, lags ascending.
    root: DMatrix<f64>,
    scales: Vec<f64>,
    names: Vec<String>,
    max_lag: usize,
    window_rows: usize,
}

impl LaggedCovariance {
    /// The covariances of `output` and all inputs of a record on the window `t = max_lag..N`.
    ///
    /// The means of the whole record are removed, and the deviations over the whole record are the
    /// scales.
    ///
    /// # Errors
    /// [`IdentError::NoSuchOutput`]; [`IdentError::TooFewRows`] where the window is empty;
    /// [`IdentError::Data`] for a sample that is not finite; [`IdentError::ConstantChannel`];
    /// [`IdentError::CoefficientNotFinite`] where the size of a channel overflows.
    pub fn of_record(data: &Dataset, output: usize, max_lag: usize) -> Result<Self, IdentError> {
        Self::of_scaled(&ScaledRecord::new(data, output)?, max_lag)
    }

    /// The same of a record that is scaled already.
    pub(crate) fn of_scaled(record: &ScaledRecord, max_lag: usize) -> Result<Self, IdentError> {
        let samples = record.samples.y.nrows();
        if max_lag >= samples {
            return Err(IdentError::TooFewRows {
                structure: format!("covariances up to lag {max_lag}"),
                needed: max_lag.saturating_add(1),
                found: samples,
            });
        }
        let window = max_lag..samples;
        let columns: Vec<Regressor> = (0..record.scales.len())
            .flat_map(|index| (0..=max_lag).map(move |lag| record_column(index, lag)))
            .collect();
        let design = record.samples.design(&columns, &window);
        let root = triangular_factor(&design) / (window.len() as f64).sqrt();
        Ok(Self {
            root,
            scales: record.scales.clone(),
            names: record.names.clone(),
            max_lag,
            window_rows: window.len(),
        })
    }

    /// The covariances of a stationary process: `autocovariance[k]` is `E z(t) z(t-k)'` with
    /// `z = (y, u_1, .., u_nu)`, each `(1 + nu) x (1 + nu)`, in squared units of the channels.
    ///
    /// # Errors
    /// [`IdentError::Dimension`] where there is no matrix or their sizes differ;
    /// [`IdentError::NotPositiveDefinite`] where no process has these covariances, or a process
    /// that some of its channels at some lags determine.
    pub fn of_process(autocovariance: &[DMatrix<f64>]) -> Result<Self, IdentError> {
        let channels = autocovariance.first().map_or(0, DMatrix::nrows);
        DimensionError::check("covariance matrices", 1, autocovariance.len().min(1))?;
        DimensionError::check("channels of a covariance", channels.max(1), channels)?;
        for matrix in autocovariance {
            DimensionError::check("rows of a covariance", channels, matrix.nrows())?;
            DimensionError::check("columns of a covariance", channels, matrix.ncols())?;
        }
        let lags = autocovariance.len();
        let scales: Vec<f64> = autocovariance[0]
            .diagonal()
            .iter()
            .map(|v| v.sqrt())
            .collect();
        let full = DMatrix::from_fn(channels * lags, channels * lags, |row, column| {
            let (i, a) = (row / lags, row % lags);
            let (j, b) = (column / lags, column % lags);
            // E z_i(t-a) z_j(t-b)
            let value = if b >= a {
                autocovariance[b - a][(i, j)]
            } else {
                autocovariance[a - b][(j, i)]
            };
            value / (scales[i] * scales[j])
        });
        Ok(Self {
            root: upper_root(full)?,
            scales,
            names: (0..channels).map(channel_name).collect(),
            max_lag: lags - 1,
            window_rows: 0,
        })
    }

    /// The largest lag.
    pub fn max_lag(&self) -> usize {
        self.max_lag
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.scales.len() - 1
    }

    /// The deviation of each channel, in its unit; the output comes first.
    pub fn scales(&self) -> &[f64] {
        &self.scales
    }

    /// Rows of the window; 0 for the covariances of a process.
    pub fn window_rows(&self) -> usize {
        self.window_rows
    }

    /// `E z_i(t-a) z_j(t-b)` for `first = (i, a)`, `second = (j, b)`, of the scaled channels;
    /// `None` where there is no such channel or lag.
    pub fn at(&self, first: (usize, usize), second: (usize, usize)) -> Option<f64> {
        let known = |(channel, lag)| channel < self.scales.len() && lag <= self.max_lag;
        (known(first) && known(second)).then(|| self.column(first).dot(&self.column(second)))
    }

    /// The names of the channels, the output first.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// The columns of the square root for lagged channels (`K x columns`).
    pub(crate) fn columns(&self, columns: &[(usize, usize)]) -> DMatrix<f64> {
        let indices: Vec<usize> = columns.iter().map(|&column| self.index(column)).collect();
        self.root.select_columns(&indices)
    }

    fn column(&self, at: (usize, usize)) -> nalgebra::DVectorView<'_, f64> {
        self.root.column(self.index(at))
    }

    fn index(&self, (channel, lag): (usize, usize)) -> usize {
        channel * (self.max_lag + 1) + lag
    }
}

/// One output and the inputs of a record without their means, each over its deviation.
pub(crate) struct ScaledRecord {
    /// The output alone is `y`.
    pub samples: Deviations,
    /// Deviations, the output first.
    pub scales: Vec<f64>,
    /// Names, the output first.
    pub names: Vec<String>,
}

impl ScaledRecord {
    pub fn new(data: &Dataset, output: usize) -> Result<Self, IdentError> {
        if output >= data.ny() {
            return Err(IdentError::NoSuchOutput {
                found: output,
                outputs: data.ny(),
            });
        }
        data.check_finite()?;
        check_varies(
            &data.outputs()[output],
            data.y().row(output).iter().copied(),
        )?;
        for (index, signal) in data.inputs().iter().enumerate() {
            check_varies(signal, data.u().row(index).iter().copied())?;
        }
        let mut samples = Deviations::new(data, &data.mean())?;
        samples.y = samples.y.columns(output, 1).into_owned();
        let mut scales = Vec::with_capacity(1 + data.nu());
        let columns = samples.y.column_iter_mut();
        for mut column in columns.chain(samples.u.column_iter_mut()) {
            let scale = scaled_norm(column.as_slice().iter().copied()) / (data.len() as f64).sqrt();
            if !(scale.is_finite() && scale > 0.0) {
                return Err(IdentError::CoefficientNotFinite {
                    output: data.outputs()[output].name.clone(),
                    found: scale,
                });
            }
            column.apply(|value| *value /= scale);
            scales.push(scale);
        }
        let names = std::iter::once(&data.outputs()[output]).chain(data.inputs());
        Ok(Self {
            samples,
            scales,
            names: names.map(|signal| signal.name.clone()).collect(),
        })
    }

    /// `sum_t z(t) z(t-k)' / N` of the scaled channels for `k = 0..=max_lag`, the output first:
    /// as a sequence positive semidefinite, whatever the record.
    pub fn autocovariance(&self, max_lag: usize) -> Vec<DMatrix<f64>> {
        let samples = self.samples.y.nrows();
        let channels = self.scales.len();
        let lagged = |channel: usize, lag: usize, window: &Range<usize>| {
            self.samples.lagged(record_column(channel, lag), window)
        };
        let product = |i: usize, j: usize, k: usize| -> f64 {
            let window = k.min(samples)..samples;
            if window.is_empty() {
                return 0.0;
            }
            let pairs = lagged(i, 0, &window).iter().zip(lagged(j, k, &window));
            pairs.map(|(a, b)| a * b).sum::<f64>() / samples as f64
        };
        (0..=max_lag)
            .map(|k| DMatrix::from_fn(channels, channels, |i, j| product(i, j, k)))
            .collect()
    }
}

/// Channel 0 is the output, the others are the inputs.
pub(crate) fn channel(index: usize) -> Channel {
    match index.checked_sub(1) {
        None => Channel::Output(0),
        Some(input) => Channel::Input(input),
    }
}

/// The name of a channel that has none.
pub(crate) fn channel_name(index: usize) -> String {
    if index == 0 {
        "y".to_owned()
    } else {
        format!("u{index}")
    }
}

fn record_column(index: usize, lag: usize) -> Regressor {
    Regressor {
        channel: channel(index),
        lag,
    }
}
