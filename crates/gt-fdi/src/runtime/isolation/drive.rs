//! What a lagging actuator would do to the residuals.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use super::joint_whitener::JointWhitener;
use super::lag::LagFilter;
use super::recall::{self, Recall};
use crate::runtime::{Generator, Update};

/// What a [`Drive`] is made of.
#[derive(Debug, Clone)]
pub(crate) struct DriveParts {
    /// Where the input stands among the inputs of a sample.
    pub(crate) input: usize,
    /// Inputs of a sample.
    pub(crate) inputs: usize,
    /// Sample time in seconds.
    pub(crate) sample_time_s: f64,
    /// Samples on either side of the one whose rate is taken.
    pub(crate) half_width: usize,
    /// The lags round which the effect is linear, in seconds: the nominal one, then those tried for
    /// the size.
    pub(crate) lags_s: Vec<f64>,
    /// The generators at the operating point 0.
    pub(crate) generators: Vec<Generator>,
    /// The whitener with mean 0.
    pub(crate) whitener: JointWhitener,
}

/// The change of the whitened residuals for a lag of one second of an actuator, as it would be with
/// the present movements of its demand: to first order the actuator is short of its demand by
/// `lag x s / (1 + nominal s)` of it, and the residuals answer as if the measured input were in
/// error by that.
///
/// The rate of the demand is the slope of a line through `2 half_width + 1` samples, which leaves
/// out most of its noise, so the answer is `half_width` samples late.
#[derive(Debug, Clone)]
pub(crate) struct Drive {
    parts: DriveParts,
    /// The last samples of the input, round.
    window: Box<[f64]>,
    next: usize,
    filled: usize,
    /// Slope of a line: weight `k / slope_scale` for the sample `k` from the middle.
    slope_scale: f64,
    /// Generators and whitening are linear, so a lag of the demand is a lag of what they answer.
    lags: Vec<LagFilter>,
    u: Box<[f64]>,
    y: Box<[f64]>,
    residuals: Box<[f64]>,
}

impl Drive {
    pub(crate) fn new(parts: DriveParts) -> Self {
        let outputs: usize = parts.generators.iter().map(Generator::ny).sum();
        let half = parts.half_width as f64;
        let squares = half * (half + 1.0) * (2.0 * half + 1.0) / 3.0;
        let slope_scale = if parts.half_width == 0 { 1.0 } else { squares };
        let lags = parts.lags_s.iter();
        let lags = lags
            .map(|lag_s| LagFilter::new(*lag_s, parts.sample_time_s, outputs))
            .collect();
        let length = (2 * parts.half_width + 1).max(2);
        Self {
            window: vec![0.0; length].into(),
            next: 0,
            filled: 0,
            slope_scale: slope_scale * parts.sample_time_s,
            lags,
            u: vec![0.0; parts.inputs].into(),
            y: vec![0.0; outputs].into(),
            residuals: vec![0.0; outputs].into(),
            parts,
        }
    }

    /// Takes the input of a sample; an input that is missing starts it afresh.
    pub(crate) fn step(&mut self, u: &[f64]) {
        let value = u.get(self.parts.input).copied().unwrap_or(f64::NAN);
        if !value.is_finite() {
            self.reset();
        } else if let Some(place) = self.window.get_mut(self.next) {
            *place = value;
            self.next = (self.next + 1) % self.window.len();
            self.filled = (self.filled + 1).min(self.window.len());
        }
        let slope = if self.filled == self.window.len() {
            self.slope()
        } else {
            0.0
        };
        if let Some(place) = self.u.get_mut(self.parts.input) {
            *place = slope;
        }
        let mut first = 0;
        for generator in &mut self.parts.generators {
            let own = first..first + generator.ny();
            if let Some(residuals) = self.residuals.get_mut(own.clone()) {
                let update = generator.step(&self.u, &self.y, first, residuals);
                if update != Update::Residual {
                    residuals.fill(0.0);
                }
            }
            first = own.end;
        }
        let white = self.parts.whitener.step(&self.residuals);
        for lag in &mut self.lags {
            lag.step(white);
        }
    }

    /// The change round the lag of this number: 0 is the nominal one.
    pub(crate) fn change(&self, lag: usize) -> &[f64] {
        self.lags.get(lag).map_or(&[], LagFilter::state)
    }

    /// Slope in units of the input per second.
    fn slope(&self) -> f64 {
        let (older, newer) = self.window.split_at(self.next);
        let in_order = newer.iter().chain(older);
        let middle = if self.parts.half_width == 0 {
            // The difference of the last two.
            return (in_order.clone().next_back().unwrap_or(&0.0)
                - in_order.clone().next().unwrap_or(&0.0))
                / self.slope_scale;
        } else {
            self.parts.half_width as f64
        };
        let weighted = in_order.enumerate();
        let sum: f64 = weighted.map(|(k, value)| (k as f64 - middle) * value).sum();
        sum / self.slope_scale
    }

    pub(crate) fn reset(&mut self) {
        (self.next, self.filled) = (0, 0);
        for lag in &mut self.lags {
            lag.reset();
        }
        for generator in &mut self.parts.generators {
            generator.reset();
        }
        self.parts.whitener.reset();
    }
}

impl Recall for Drive {
    fn recall(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        recall::numbers(&mut self.window, visit);
        let length = self.window.len();
        recall::count(&mut self.next, length.saturating_sub(1), visit);
        recall::count(&mut self.filled, length, visit);
        for lag in &mut self.lags {
            lag.recall(visit);
        }
        for generator in &mut self.parts.generators {
            recall::numbers(generator.state_mut(), visit);
        }
        self.parts.whitener.recall(visit);
    }
}
