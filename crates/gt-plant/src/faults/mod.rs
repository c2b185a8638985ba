//! Faults: what they act on, how they go with time, and what the plant feels of them.

mod case;
mod course;
mod file;
mod shape;
mod sizes;
mod target;
mod validate;

pub use case::FaultCase;
pub(crate) use course::{ActuatorPositions, FaultCourse};
pub use shape::{Exponential, Intermittent, Ramp, Shape, Step};
pub use sizes::{ActuatorFault, FaultSizes};
pub use target::{ActuatorId, Mode, Target};

pub(crate) use course::{Place, repeats, spike_share};

use std::collections::HashMap;

use gt_core::Signal;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::shape::EDGE_S;
use crate::channel::Channel;

/// The paper's development rate of cases 1 to 3, percent per hour.
const NOMINAL_RATE_PERCENT_PER_H: f64 = 5.0;
/// The paper's largest size of cases 1 and 3, percent.
const NOMINAL_LIMIT_PERCENT: f64 = 5.0;
/// Growth of the fuel actuator's lag, seconds per hour: the paper prints none (assumed).
const NOMINAL_RATE_S_PER_H: f64 = 5.0;

/// A fault: nothing before its onset, then its shape until its end, then nothing again.
///
/// In a file it is a table with one of `case`, `sensor` and `actuator`; the last two need a `mode`:
///
/// ```toml
/// [[fault]]
/// case = "turbine_damage"
/// onset_s = 60.0
/// ramp = { rate_per_h = 5.0, limit = 5.0 }        # percent
///
/// [[fault]]
/// sensor = "t3"                                   # any recorded channel
/// mode = "bias"
/// onset_s = 10.0
/// end_s = 20.0                                    # may be left out
/// step = { size = 2.0 }                           # K, the channel's unit
///
/// [[fault]]
/// actuator = "a_v"                                # or M_f, IGV
/// mode = "lag"
/// exponential = { size = 0.8, time_constant_s = 100.0 }
///
/// [[fault]]
/// sensor = "p3"
/// mode = "spike"
/// spikes_per_h = 120.0                            # 60 when left out
/// intermittent = { size = 5e4, period_s = 20.0, on_s = 5.0 }
/// ```
///
/// An `onset_s` that is left out is 0. `stuck` and `dropout` need no shape: they are a step of
/// size 1. The cases also take the flat keys `rate_percent_per_h` and `limit_percent`
/// (`rate_s_per_h` and `limit_s` for `fuel_actuator_lag`) for their ramp.
///
/// Faults on one target add up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "file::FaultTable", into = "file::FaultTable")]
pub struct Fault {
    /// What it acts on.
    pub target: Target,
    /// When it begins, in seconds.
    pub onset_s: f64,
    /// When it is gone again, in seconds; never when absent.
    pub end_s: Option<f64>,
    /// How its magnitude goes with time.
    pub shape: Shape,
}

impl Fault {
    /// A fault that does not end.
    pub fn new(target: Target, onset_s: f64, shape: Shape) -> Self {
        Self {
            target,
            onset_s,
            end_s: None,
            shape,
        }
    }

    /// A fault of a sensor that does not end.
    pub fn sensor(channel: Channel, mode: Mode, onset_s: f64, shape: Shape) -> Self {
        Self::new(Target::Sensor { channel, mode }, onset_s, shape)
    }

    /// A fault of an actuator that does not end.
    pub fn actuator(actuator: ActuatorId, mode: Mode, onset_s: f64, shape: Shape) -> Self {
        Self::new(Target::Actuator { actuator, mode }, onset_s, shape)
    }

    /// The same fault, gone at `end_s` seconds.
    #[must_use]
    pub fn until(mut self, end_s: f64) -> Self {
        self.end_s = Some(end_s);
        self
    }

    /// A ramp of the given rate per hour and limit, both in the case's own unit (percent; seconds
    /// in case 4).
    pub fn growing(case: FaultCase, onset_s: f64, rate_per_h: f64, limit: Option<f64>) -> Self {
        let ramp = Shape::Ramp(Ramp { rate_per_h, limit });
        Self::new(Target::Case(case), onset_s, ramp)
    }

    /// A fault with the paper's rate and limit: 5 % an hour, at most 5 % in cases 1 and 3, no
    /// limit in case 2; case 4 grows by 5 s an hour without limit (assumed).
    pub fn nominal(case: FaultCase, onset_s: f64) -> Self {
        let (rate_per_h, limit) = match case {
            FaultCase::CompressorFouling | FaultCase::TurbineDamage => {
                (NOMINAL_RATE_PERCENT_PER_H, Some(NOMINAL_LIMIT_PERCENT))
            }
            FaultCase::ThermocoupleDrift => (NOMINAL_RATE_PERCENT_PER_H, None),
            FaultCase::FuelActuatorLag => (NOMINAL_RATE_S_PER_H, None),
        };
        Self::growing(case, onset_s, rate_per_h, limit)
    }

    /// Which of the paper's cases it is, if any.
    pub fn case(&self) -> Option<FaultCase> {
        match self.target {
            Target::Case(case) => Some(case),
            _ => None,
        }
    }

    /// Unit of the magnitude; empty for a magnitude that is 0 or 1.
    pub fn unit(&self) -> &'static str {
        self.target.unit()
    }

    /// Name and unit of the magnitude as a signal. Faults on one target share it; see
    /// [`Fault::signals`].
    pub fn signal(&self) -> Signal {
        Signal::new(self.target.name(), self.unit())
    }

    /// The signals of several faults, in their order: the second fault on a target is `t3_bias_2`.
    pub fn signals(faults: &[Self]) -> Vec<Signal> {
        let mut seen = HashMap::new();
        let numbered = |fault: &Self| {
            let Signal { name, unit } = fault.signal();
            let count = seen.entry(name.clone()).or_insert(0_usize);
            *count += 1;
            match *count {
                1 => Signal::new(name, unit),
                count => Signal::new(format!("{name}_{count}"), unit),
            }
        };
        faults.iter().map(numbered).collect()
    }

    /// The magnitude at a time, in [`Fault::unit`]: a share in percent for the paper's cases 1 to 3
    /// and for gains. For spikes and noise it is the nominal size, not what was drawn.
    pub fn magnitude(&self, t_s: f64) -> f64 {
        let ended = self.end_s.is_some_and(|end_s| t_s + EDGE_S >= end_s);
        if t_s + EDGE_S < self.onset_s || ended {
            return 0.0;
        }
        self.shape.magnitude((t_s - self.onset_s).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "these values are exact")]

    use super::*;
    use crate::SAMPLE_TIME_S;
    use proptest::prelude::*;

    fn step(size: f64) -> Shape {
        Shape::Step(Step { size })
    }

    #[test]
    fn published_nominal_ramps() {
        // 5 %/h from 15 s (figures 20 to 23), at most 5 %.
        let fouling = Fault::nominal(FaultCase::CompressorFouling, 15.0);
        assert_eq!(fouling.magnitude(15.0), 0.0);
        assert_eq!(fouling.magnitude(15.0 + 1800.0), 2.5);
        assert_eq!(fouling.magnitude(15.0 + 7200.0), 5.0);
        let drift = Fault::nominal(FaultCase::ThermocoupleDrift, 15.0);
        assert_eq!(drift.magnitude(15.0 + 7200.0), 10.0);
        // The paper's example: 0.008 K/s is 5 %/h of t3 = 577.543 K.
        assert!((drift.magnitude(16.0) / 100.0 * 577.543 - 0.008).abs() < 5e-5);
        let lag = Fault::nominal(FaultCase::FuelActuatorLag, 0.0);
        assert_eq!((lag.magnitude(3600.0), lag.unit()), (5.0, "s"));
    }

    #[test]
    fn a_falling_reading_stops_at_minus_its_limit() {
        let fault = Fault::growing(FaultCase::ThermocoupleDrift, 0.0, -3600.0, Some(2.0));
        assert_eq!(
            [0.5, 1.0, 9.0].map(|t| fault.magnitude(t)),
            [-0.5, -1.0, -2.0]
        );
    }

    #[test]
    fn onset_and_end_lie_on_their_samples() {
        // 3 Ts = 0.24 and 1e5 Ts carry rounding errors.
        for (first, last) in [(3_u32, 7_u32), (100_000, 100_001)] {
            let time = |k: u32| f64::from(k) * SAMPLE_TIME_S;
            let (onset, end) = (f64::from(first * 8) / 100.0, f64::from(last * 8) / 100.0);
            let channel = Channel::named("t3").unwrap();
            let fault = Fault::sensor(channel, Mode::Bias, onset, step(2.0)).until(end);
            assert_eq!(
                [first - 1, first, last - 1, last].map(|k| fault.magnitude(time(k))),
                [0.0, 2.0, 2.0, 0.0]
            );
        }
    }

    #[test]
    fn signals_have_units_and_names_of_their_own() {
        let channel = Channel::named("a_v").unwrap();
        let faults = [
            Fault::sensor(channel, Mode::Bias, 0.0, step(1.0)),
            Fault::sensor(channel, Mode::Bias, 5.0, step(1.0)),
            Fault::actuator(ActuatorId::Valve, Mode::Bias, 5.0, step(1.0)),
            Fault::sensor(channel, Mode::Gain, 5.0, step(1.0)),
            Fault::sensor(channel, Mode::Stuck, 5.0, step(1.0)),
            Fault::nominal(FaultCase::FuelActuatorLag, 1.0),
            Fault::actuator(ActuatorId::Fuel, Mode::Lag, 5.0, step(1.0)),
            Fault::sensor(channel, Mode::Bias, 5.0, step(1.0)),
            Fault::actuator(ActuatorId::Fuel, Mode::Noise, 5.0, step(1.0)),
        ];
        let expected = [
            ("a_v_bias", "deg"),
            ("a_v_bias_2", "deg"),
            ("a_v_actuator_bias", "deg"),
            ("a_v_gain", "%"),
            ("a_v_stuck", ""),
            ("fuel_actuator_lag", "s"),
            ("M_f_actuator_lag", "s"),
            ("a_v_bias_3", "deg"),
            ("M_f_actuator_noise", "kg/s"),
        ]
        .map(|(name, unit)| Signal::new(name, unit));
        assert_eq!(Fault::signals(&faults), expected);
    }

    proptest! {
        #[test]
        fn prop_nothing_before_the_onset_and_after_the_end(
            onset in 0.0..1e3f64, lasts in 0.1..1e3f64, after in 0.0..1e5f64, size in -9.0..9.0f64
        ) {
            let end = onset + lasts;
            let t3 = Channel::named("t3").unwrap();
            let fault = Fault::sensor(t3, Mode::Bias, onset, step(size)).until(end);
            prop_assert_eq!(fault.magnitude(onset - after - 1e-6), 0.0);
            prop_assert_eq!(fault.magnitude(onset + 0.99 * lasts), size);
            prop_assert_eq!(fault.magnitude(end + after), 0.0);
        }

        #[test]
        fn prop_ramp_is_linear_then_constant(
            onset in 0.0..1e3f64, rate in 0.1..1e3f64, limit in 0.1..50.0f64, after in 0.0..1e5f64
        ) {
            let fault = Fault::growing(FaultCase::TurbineDamage, onset, rate, Some(limit));
            let expected = (rate * after / 3600.0).min(limit);
            // Rounding of onset + after - onset.
            prop_assert!((fault.magnitude(onset + after) - expected).abs() < 1e-9);
            prop_assert_eq!(fault.magnitude(onset - after), 0.0);
        }
    }
}
