//! Records as blocks of lagged channels: what every factorisation and every product reads.

use std::ops::Range;

use gt_core::{DataError, Dataset, OperatingPoint, Signal};

use crate::{Channel, IdentError, Missing, Regressor};

/// Most rows of a block unless the lags ask for more.
const BLOCK_ROWS: usize = 1024;
/// Numbers of a block, which fit into a first-level cache.
const BLOCK_NUMBERS: usize = 4096;
/// Sums side by side.
const LANES: usize = 8;

/// Samples of one record without a gap.
#[derive(Debug, Clone)]
struct Stretch<'a> {
    data: &'a Dataset,
    samples: Range<usize>,
}

/// Range and mean of one channel over all stretches.
#[derive(Debug, Clone, Copy)]
struct Extent {
    sum: f64,
    low: f64,
    high: f64,
}

/// Records of one plant as deviations from a common operating point, in units that are powers of
/// two: no sum of squares overflows, and nothing is rounded by the change of units.
///
/// Nothing is copied: blocks are made while they are read.
pub(crate) struct Records<'a> {
    stretches: Vec<Stretch<'a>>,
    extents: Vec<Extent>,
    samples: usize,
    ny: usize,
    centre: Vec<f64>,
    scale: Vec<f64>,
}

impl<'a> Records<'a> {
    /// The stretches of `records`, which have the channels of the first.
    ///
    /// # Errors
    /// [`IdentError::Data`] for an infinite sample, and for NaN unless it breaks the record.
    pub fn new(records: &[&'a Dataset], missing: Missing) -> Result<Self, IdentError> {
        let (nu, ny) = records
            .first()
            .map_or((0, 0), |data| (data.nu(), data.ny()));
        let mut found = Self {
            stretches: Vec::with_capacity(records.len()),
            extents: Vec::new(),
            samples: 0,
            ny,
            centre: vec![0.0; nu + ny],
            scale: vec![1.0; nu + ny],
        };
        found.stretches = records.iter().map(|&data| whole(data)).collect();
        found.measure();
        // A finite sum has finite terms; only where it is not is it worth looking at each.
        if !found.extents.iter().all(|extent| extent.sum.is_finite()) {
            found.stretches.clear();
            for &data in records {
                found.stretches.extend(stretches(data, missing)?);
            }
            found.measure();
        }
        Ok(found)
    }

    fn measure(&mut self) {
        self.samples = self.stretches.iter().map(|each| each.samples.len()).sum();
        self.extents = (0..self.channels())
            .map(|channel| self.extent(channel))
            .collect();
    }

    /// Before [`Records::centre_at`]: of the samples as they are.
    fn extent(&self, channel: usize) -> Extent {
        // Numbers side by side: one alone waits for its own last operation.
        let (mut sums, mut lows) = ([0.0; LANES], [f64::INFINITY; LANES]);
        let mut highs = [f64::NEG_INFINITY; LANES];
        let mut buffer = vec![0.0; BLOCK_ROWS];
        for stretch in &self.stretches {
            let mut sample = stretch.samples.start;
            while sample < stretch.samples.end {
                let count = BLOCK_ROWS.min(stretch.samples.end - sample);
                self.fill(stretch, channel, sample, &mut buffer[..count]);
                let (chunks, rest) = buffer[..count].as_chunks::<LANES>();
                for chunk in chunks {
                    for lane in 0..LANES {
                        let value = chunk[lane];
                        sums[lane] += value;
                        lows[lane] = if value < lows[lane] {
                            value
                        } else {
                            lows[lane]
                        };
                        highs[lane] = if value > highs[lane] {
                            value
                        } else {
                            highs[lane]
                        };
                    }
                }
                for &value in rest {
                    sums[0] += value;
                    lows[0] = lows[0].min(value);
                    highs[0] = highs[0].max(value);
                }
                sample += count;
            }
        }
        Extent {
            sum: sums.iter().sum(),
            low: lows.into_iter().fold(f64::INFINITY, f64::min),
            high: highs.into_iter().fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// The means of all samples.
    pub fn means(&self) -> OperatingPoint {
        let count = self.samples as f64;
        let means: Vec<f64> = self.extents.iter().map(|each| each.sum / count).collect();
        OperatingPoint {
            u: means[self.ny..].to_vec().into(),
            y: means[..self.ny].to_vec().into(),
        }
    }

    /// Takes deviations from `point`, whose size has been checked.
    pub fn centre_at(&mut self, point: &OperatingPoint) {
        let values = point.y.iter().chain(point.u.iter());
        self.centre = values.copied().collect();
        for (channel, extent) in self.extents.iter().enumerate() {
            let centre = self.centre[channel];
            let most = (extent.high - centre)
                .abs()
                .max((extent.low - centre).abs());
            self.scale[channel] = power_of_two(most);
        }
    }

    /// Refuses outputs, and inputs of which `uses` says so, that do not vary.
    pub fn check_vary(
        &self,
        inputs: &[Signal],
        outputs: &[Signal],
        uses: impl Fn(usize) -> bool,
    ) -> Result<(), IdentError> {
        let used = inputs.iter().enumerate().filter(|(input, _)| uses(*input));
        let inputs = used.map(|(input, signal)| (self.ny + input, signal));
        for (channel, signal) in inputs.chain(outputs.iter().enumerate()) {
            let extent = self.extents[channel];
            crate::regressor::check_range(signal, extent.low, extent.high)?;
        }
        Ok(())
    }

    /// Rows `t` of a stretch for which `t - lag` is in the stretch for all lags up to `longest`,
    /// and that are not before sample `first_row` of their record.
    fn stretch_rows(stretch: &Stretch, longest: usize, first_row: usize) -> Range<usize> {
        let start = stretch.samples.start.saturating_add(longest).max(first_row);
        start.min(stretch.samples.end)..stretch.samples.end
    }

    /// Rows of all stretches.
    pub fn rows(&self, longest: usize, first_row: usize) -> usize {
        let rows = |stretch| Self::stretch_rows(stretch, longest, first_row).len();
        self.stretches.iter().map(rows).sum()
    }

    pub fn ny(&self) -> usize {
        self.ny
    }

    pub fn channels(&self) -> usize {
        self.centre.len()
    }

    /// The position of a channel: outputs before inputs.
    pub fn position(&self, channel: Channel) -> usize {
        match channel {
            Channel::Output(index) => index,
            Channel::Input(index) => self.ny + index,
        }
    }

    /// What a deviation of the channel is multiplied by.
    pub fn scale(&self, channel: Channel) -> f64 {
        self.scale[self.position(channel)]
    }

    /// Scaled deviations of one channel from `sample` on.
    fn fill(&self, stretch: &Stretch, channel: usize, sample: usize, out: &mut [f64]) {
        let (matrix, index) = if channel < self.ny {
            (stretch.data.y(), channel)
        } else {
            (stretch.data.u(), channel - self.ny)
        };
        let step = matrix.nrows();
        let values = &matrix.as_slice()[sample * step..(sample + out.len()) * step];
        let (centre, scale) = (self.centre[channel], self.scale[channel]);
        // A step that the compiler knows is several times faster than one that it does not.
        match step {
            1 => copy::<1>(values, index, (centre, scale), out),
            2 => copy::<2>(values, index, (centre, scale), out),
            3 => copy::<3>(values, index, (centre, scale), out),
            4 => copy::<4>(values, index, (centre, scale), out),
            _ => {
                for (out, values) in out.iter_mut().zip(values.chunks_exact(step)) {
                    *out = (values[index] - centre) * scale;
                }
            }
        }
    }

    /// Calls `work` with every block of rows of `window`, in order.
    pub fn for_each_block(&self, window: &Window, mut work: impl FnMut(&Block)) {
        let read = window.uses.iter().filter(|&&each| each).count();
        let most = (BLOCK_NUMBERS / read.max(1))
            .clamp(BLOCK_ROWS / 4, BLOCK_ROWS)
            .max(2 * window.longest)
            .max(window.block_rows);
        let mut block = Block {
            channels: vec![Vec::new(); self.channels()],
            rows: 0,
            longest: window.longest,
        };
        for stretch in &self.stretches {
            let rows = Self::stretch_rows(stretch, window.longest, window.first_row);
            let mut start = rows.start;
            while start < rows.end {
                block.rows = most.min(rows.end - start);
                for (channel, samples) in block.channels.iter_mut().enumerate() {
                    if window.uses[channel] {
                        samples.resize(block.rows + window.longest, 0.0);
                        self.fill(stretch, channel, start - window.longest, samples);
                    }
                }
                work(&block);
                start += block.rows;
            }
        }
    }

    /// Calls `work` for every stretch that has rows, with the `longest` samples of all channels
    /// before its first row and before its end, newest first: `[lag][channel]`.
    pub fn for_each_edge(&self, window: &Window, mut work: impl FnMut(&[f64], &[f64])) {
        let (longest, width) = (window.longest, self.channels());
        for stretch in &self.stretches {
            let rows = Self::stretch_rows(stretch, longest, window.first_row);
            if rows.is_empty() || longest == 0 {
                continue;
            }
            let edges = [rows.start, rows.end].map(|end| {
                let mut edge = vec![0.0; longest * width];
                for channel in (0..width).filter(|&channel| window.uses[channel]) {
                    let mut samples = vec![0.0; longest];
                    self.fill(stretch, channel, end - longest, &mut samples);
                    for (lag, value) in samples.iter().rev().enumerate() {
                        edge[lag * width + channel] = *value;
                    }
                }
                edge
            });
            work(&edges[0], &edges[1]);
        }
    }
}

/// Scaled deviations of channel `index` among `STEP`.
fn copy<const STEP: usize>(
    values: &[f64],
    index: usize,
    (centre, scale): (f64, f64),
    out: &mut [f64],
) {
    for (out, values) in out.iter_mut().zip(values.as_chunks::<STEP>().0) {
        *out = (values[index] - centre) * scale;
    }
}

/// Which rows and channels a pass over the records reads.
#[derive(Debug, Clone)]
pub(crate) struct Window {
    /// The longest lag, in every stretch the first row.
    pub longest: usize,
    /// The first row of a record, where that is later.
    pub first_row: usize,
    /// The channels read, by position.
    pub uses: Vec<bool>,
    /// Rows that a block should have at least.
    pub block_rows: usize,
}

impl Window {
    /// The window of all channels.
    pub fn new(records: &Records, longest: usize, first_row: usize) -> Self {
        Self {
            longest,
            first_row,
            uses: vec![true; records.channels()],
            block_rows: 0,
        }
    }
}

/// Rows of the records, a channel a slice.
pub(crate) struct Block {
    channels: Vec<Vec<f64>>,
    rows: usize,
    longest: usize,
}

impl Block {
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The channel at `t - lag` for all rows.
    pub fn lagged(&self, position: usize, lag: usize) -> &[f64] {
        self.lags(position, lag, lag)
    }

    /// The channel for lags `low..=high`: lag `l` of row `t` is at `high - l + t`.
    pub fn lags(&self, position: usize, low: usize, high: usize) -> &[f64] {
        &self.channels[position][self.longest - high..self.longest - low + self.rows]
    }
}

/// A run of lags of one channel among the regressors: regressor `at` has lag `low`, the next lag
/// one more.
#[derive(Debug, Clone)]
pub(crate) struct Taps {
    pub position: usize,
    pub low: usize,
    /// Positions among the regressors.
    pub at: Vec<usize>,
}

/// Regressors sorted into runs.
pub(crate) fn taps(records: &Records, regressors: &[Regressor]) -> Vec<Taps> {
    let mut sorted: Vec<(usize, usize, usize)> = regressors
        .iter()
        .enumerate()
        .map(|(at, each)| (records.position(each.channel), each.lag, at))
        .collect();
    sorted.sort_unstable();
    let mut runs: Vec<Taps> = Vec::new();
    for (position, lag, at) in sorted {
        match runs.last_mut() {
            Some(run) if run.position == position && run.low + run.at.len() == lag => {
                run.at.push(at);
            }
            _ => runs.push(Taps {
                position,
                low: lag,
                at: vec![at],
            }),
        }
    }
    runs
}

/// The power of two that brings `most` between 1 and 2; 1 where there is none.
fn power_of_two(most: f64) -> f64 {
    if !most.is_normal() {
        return 1.0;
    }
    // Exponents beyond 1000 would make a scale that is not normal.
    let exponent = most.log2().floor().clamp(-1000.0, 1000.0);
    (-exponent).exp2()
}

/// The parts of a record between samples that are NaN in any channel, each at its own time: what
/// [`Missing::Break`] makes of it.
///
/// # Errors
/// [`IdentError::Data`] for an infinite sample.
pub fn unbroken(data: &Dataset) -> Result<Vec<Dataset>, IdentError> {
    let parts = stretches(data, Missing::Break)?.into_iter();
    parts.map(|part| Ok(data.rows(part.samples)?)).collect()
}

fn whole(data: &Dataset) -> Stretch<'_> {
    let samples = 0..data.len();
    Stretch { data, samples }
}

fn stretches(data: &Dataset, missing: Missing) -> Result<Vec<Stretch<'_>>, IdentError> {
    if missing == Missing::Refuse {
        data.check_finite()?;
        return Ok(vec![whole(data)]);
    }
    let mut found = Vec::new();
    let mut start = 0;
    for sample in 0..data.len() {
        let mut gap = false;
        for (signals, matrix) in [(data.inputs(), data.u()), (data.outputs(), data.y())] {
            for (signal, &value) in signals.iter().zip(matrix.column(sample).iter()) {
                if value.is_infinite() {
                    let channel = signal.name.clone();
                    return Err(IdentError::Data(DataError::NotFinite {
                        channel,
                        sample,
                        found: value,
                    }));
                }
                gap |= value.is_nan();
            }
        }
        if gap {
            if start < sample {
                let samples = start..sample;
                found.push(Stretch { data, samples });
            }
            start = sample + 1;
        }
    }
    if start < data.len() {
        let samples = start..data.len();
        found.push(Stretch { data, samples });
    }
    Ok(found)
}
