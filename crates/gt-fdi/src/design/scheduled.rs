//! Residual generators at several operating points, blended along a scheduling channel.

use gt_core::{Dataset, Signal};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::channels::{Channels, check_sample_time};
use super::generator::ResidualGenerator;
use crate::FdiError;

/// How the generators share the range of the scheduling channel.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Blend {
    /// Weights that are linear between neighbouring breakpoints (hat functions): the residual is
    /// continuous in the channel.
    #[default]
    Interpolated,
    /// The generator of the nearest breakpoint alone. Where two generators disagree, the residual
    /// jumps by as much when they change places.
    Switched {
        /// How far beyond the middle between two breakpoints the channel has to go before the other
        /// one takes over, in the unit of the channel, 0 or above: more than its noise.
        hysteresis: f64,
    },
}

/// Why generators cannot be scheduled.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ScheduleError {
    /// There is no operating point.
    #[error("operating points of a schedule: expected at least one, found none")]
    Empty,
    /// Breakpoints do not ascend, or one is not finite.
    #[error("breakpoint {index}: expected a finite number above {previous}, found {found}")]
    Breakpoint {
        /// 0-based position.
        index: usize,
        /// The breakpoint before; minus infinity for the first.
        previous: f64,
        /// The value found.
        found: f64,
    },
    /// A generator has other channels than the first.
    #[error(
        "generator {index}, {side}: expected those of the first, {}, found {}",
        expected.join(", "), found.join(", ")
    )]
    Signals {
        /// 0-based position.
        index: usize,
        /// `inputs` or `outputs`.
        side: &'static str,
        /// Tags of the first generator.
        expected: Vec<String>,
        /// Tags found.
        found: Vec<String>,
    },
    /// The hysteresis is negative, not finite or wider than half of the narrowest interval.
    #[error("hysteresis: expected 0 to {largest} (half of the narrowest interval), found {found}")]
    Hysteresis {
        /// The largest accepted; infinite for one operating point.
        largest: f64,
        /// The value found.
        found: f64,
    },
}

/// A generator with the value of the scheduling channel at which its model holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScheduledPoint {
    /// The value of the scheduling channel, in its unit.
    pub breakpoint: f64,
    /// The generator of the model there.
    pub generator: ResidualGenerator,
}

/// Residual generators of the same channels at several operating points: all of them run all the
/// time, each round its own point, and the residual is the weighted sum of theirs, with weights
/// that follow a scheduling channel and sum to 1. So no state is lost or set when the point
/// changes. Beyond the first and the last breakpoint, the generator there stands alone.
///
/// Source: multiple models, R. Murray-Smith, T. A. Johansen (eds.), *Multiple model approaches to
/// modelling and control*, Taylor & Francis 1997. Construction and deserialisation both
/// check breakpoints, channels and sample times.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct ScheduledGenerators {
    channel: String,
    blend: Blend,
    points: Vec<ScheduledPoint>,
}

/// The fields of [`ScheduledGenerators`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    channel: String,
    blend: Blend,
    points: Vec<ScheduledPoint>,
}

impl TryFrom<Unchecked> for ScheduledGenerators {
    type Error = FdiError;

    fn try_from(raw: Unchecked) -> Result<Self, FdiError> {
        Self::new(raw.channel, raw.points, raw.blend)
    }
}

/// The residuals of a record with the weights that made them.
#[derive(Debug, Clone, PartialEq)]
pub struct ScheduledRun {
    /// Residuals (ny x N) in the units of the outputs; NaN where a channel is missing.
    pub residuals: DMatrix<f64>,
    /// Weights (points x N), each column summing to 1; NaN where the scheduling channel is missing.
    pub weights: DMatrix<f64>,
}

impl ScheduledGenerators {
    /// Generators along `channel`, any input or output of the records, by ascending breakpoints.
    ///
    /// # Errors
    /// [`ScheduleError`]; [`FdiError::SampleTime`] when sample times differ.
    pub fn new(
        channel: impl Into<String>,
        points: Vec<ScheduledPoint>,
        blend: Blend,
    ) -> Result<Self, FdiError> {
        let Some(first) = points.first() else {
            return Err(ScheduleError::Empty.into());
        };
        let mut previous = f64::NEG_INFINITY;
        let mut narrowest = f64::INFINITY;
        for (index, point) in points.iter().enumerate() {
            let found = point.breakpoint;
            if !(found.is_finite() && found > previous) {
                return Err(ScheduleError::Breakpoint {
                    index,
                    previous,
                    found,
                }
                .into());
            }
            narrowest = narrowest.min(found - previous);
            previous = found;
            let (own, expected) = (&point.generator, &first.generator);
            for (side, expected, found) in [
                ("inputs", expected.inputs(), own.inputs()),
                ("outputs", expected.outputs(), own.outputs()),
            ] {
                let (expected, found) = (tags(expected), tags(found));
                if expected != found {
                    return Err(ScheduleError::Signals {
                        index,
                        side,
                        expected,
                        found,
                    }
                    .into());
                }
            }
            let what = format!("generator {index} of the schedule");
            check_sample_time(&what, expected.sample_time_s(), own.sample_time_s())?;
        }
        if let Blend::Switched { hysteresis } = blend {
            let largest = 0.5 * narrowest;
            if !(hysteresis.is_finite() && (0.0..=largest).contains(&hysteresis)) {
                return Err(ScheduleError::Hysteresis {
                    largest,
                    found: hysteresis,
                }
                .into());
            }
        }
        let channel = channel.into();
        Ok(Self {
            channel,
            blend,
            points,
        })
    }

    /// Tag of the scheduling channel.
    pub fn channel(&self) -> &str {
        &self.channel
    }

    /// How the generators share the range.
    pub fn blend(&self) -> Blend {
        self.blend
    }

    /// The generators with their breakpoints, ascending.
    pub fn points(&self) -> &[ScheduledPoint] {
        &self.points
    }

    /// Samples after which all generators have forgotten a wrong initial state.
    pub fn settle_samples(&self) -> usize {
        let all = self
            .points
            .iter()
            .map(|point| point.generator.settle_samples());
        all.max().unwrap_or(0)
    }

    /// The weights (one a point, summing to 1) at a value of the scheduling channel that comes from
    /// nowhere: without the memory of a hysteresis. NaN at NaN.
    pub fn weights(&self, value: f64) -> Vec<f64> {
        let mut weights = vec![0.0; self.points.len()];
        self.weigh(value, &mut None, &mut weights);
        weights
    }

    /// The residuals of a record that has the channels, by name, in any order and among others:
    /// every generator runs over it from its initial state 0, as [`ResidualGenerator::residuals`].
    ///
    /// # Errors
    /// [`FdiError::MissingTags`] and [`FdiError::SampleTime`] when the record does not fit.
    pub fn run(&self, data: &Dataset) -> Result<ScheduledRun, FdiError> {
        let none: [&str; 0] = [];
        let first = &self.points[0].generator;
        let ts = first.sample_time_s();
        let mut scheduling = Channels::of(data, ts, &[&self.channel], &none)?;
        let local = self.points.iter();
        let local = local
            .map(|point| point.generator.residuals(data))
            .collect::<Result<Vec<_>, _>>()?;
        let mut residuals = DMatrix::zeros(first.outputs().len(), data.len());
        let mut weights = DMatrix::zeros(self.points.len(), data.len());
        let mut active = None;
        for (sample, mut residual) in residuals.column_iter_mut().enumerate() {
            let value = scheduling.at(sample).0[0];
            let mut own = weights.column_mut(sample);
            self.weigh(value, &mut active, own.as_mut_slice());
            // One generator alone is passed on as it is, and what has no weight cannot be NaN's way
            // into the sum.
            for (local, &weight) in local.iter().zip(own.iter()) {
                if weight != 0.0 {
                    residual.axpy(weight, &local.column(sample), 1.0);
                }
            }
        }
        Ok(ScheduledRun { residuals, weights })
    }

    /// The residuals (ny x N) of [`ScheduledGenerators::run`].
    ///
    /// # Errors
    /// As [`ScheduledGenerators::run`].
    pub fn residuals(&self, data: &Dataset) -> Result<DMatrix<f64>, FdiError> {
        Ok(self.run(data)?.residuals)
    }

    /// Writes the weights at `value`; `active` is the generator that stands alone, where they are
    /// switched.
    fn weigh(&self, value: f64, active: &mut Option<usize>, weights: &mut [f64]) {
        weights.fill(0.0);
        if value.is_nan() {
            weights.fill(f64::NAN);
            return;
        }
        let at = |index: usize| self.points[index].breakpoint;
        let last = self.points.len() - 1;
        let above = self
            .points
            .partition_point(|point| point.breakpoint <= value);
        // Between these two, or beyond the end where both are one.
        let (low, high) = (above.saturating_sub(1), above.min(last));
        match self.blend {
            Blend::Interpolated if low == high => weights[low] = 1.0,
            Blend::Interpolated => {
                let share = (value - at(low)) / (at(high) - at(low));
                weights[low] = 1.0 - share;
                weights[high] = share;
            }
            Blend::Switched { hysteresis } => {
                let middle = |left: usize| f64::midpoint(at(left), at(left + 1));
                let nearest = if low < high && value >= middle(low) {
                    high
                } else {
                    low
                };
                let keeps = |index: usize| {
                    (index == 0 || value >= middle(index - 1) - hysteresis)
                        && (index == last || value <= middle(index) + hysteresis)
                };
                let chosen = active.filter(|&index| keeps(index)).unwrap_or(nearest);
                *active = Some(chosen);
                weights[chosen] = 1.0;
            }
        }
    }
}

fn tags(signals: &[Signal]) -> Vec<String> {
    signals.iter().map(|signal| signal.name.clone()).collect()
}
