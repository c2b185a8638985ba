//! What faults make sense, alone and together.

use std::collections::HashMap;

use super::{Fault, FaultCase, Mode, Ramp, Shape, Target};
use crate::{PlantError, SAMPLE_TIME_S};

impl Fault {
    /// Refuses numbers and combinations that make no sense.
    ///
    /// # Errors
    /// [`PlantError::Scenario`]: every number is finite and times are in order; the cases 1 to 3
    /// stay below 100 percent; cases 1, 3 and 4, noise and lag are not negative.
    /// [`PlantError::FaultShape`]: stuck and dropout are a step or intermittent, of size 1.
    pub fn validate(&self) -> Result<(), PlantError> {
        let check = |holds: bool, what, expected, found: f64| {
            if found.is_finite() && holds {
                return Ok(());
            }
            Err(PlantError::Scenario {
                what,
                expected,
                found,
            })
        };
        let not_negative = "a finite number of at least 0";
        let onset_s = self.onset_s;
        check(
            onset_s >= 0.0,
            "onset of a fault [s]",
            not_negative,
            onset_s,
        )?;
        if let Some(end_s) = self.end_s {
            let after = "a finite number above its onset_s";
            check(end_s > onset_s, "end_s of a fault", after, end_s)?;
        }
        self.shape.validate_times()?;
        if let Some(mode) = self.target.mode() {
            self.validate_mode(mode)?;
        }
        let is_ramp = matches!(self.shape, Shape::Ramp(_));
        let amplitude = self.shape.amplitude();
        let (what, may_fall) = match (self.case(), is_ramp) {
            (Some(FaultCase::ThermocoupleDrift), true) => {
                ("rate of the thermocouple drift [%/h]", true)
            }
            (_, true) => ("rate of a fault [per h]", self.target.takes_negative()),
            (_, false) => ("size of a fault", self.target.takes_negative()),
        };
        if may_fall {
            check(true, what, "a finite number", amplitude)?;
        } else {
            check(amplitude >= 0.0, what, not_negative, amplitude)?;
        }
        let bound = self.target.bound();
        if let Shape::Ramp(Ramp { limit, .. }) = self.shape {
            let limit = limit.unwrap_or(0.0);
            check(limit >= 0.0, "limit of a fault", not_negative, limit)?;
            let (what, expected) = self.target.limit_words();
            check(limit < bound, what, expected, limit)
        } else {
            let (what, expected) = self.target.size_words();
            check(amplitude.abs() < bound, what, expected, amplitude)
        }
    }

    fn validate_mode(&self, mode: Mode) -> Result<(), PlantError> {
        match mode {
            Mode::Spike { spikes_per_h } => {
                if spikes_per_h > 0.0 && spikes_per_h * SAMPLE_TIME_S <= 3600.0 {
                    return Ok(());
                }
                Err(PlantError::Scenario {
                    what: "spikes_per_h of a fault",
                    expected: "a number above 0 and at most 45000, one a sample",
                    found: spikes_per_h,
                })
            }
            Mode::Stuck | Mode::Dropout => {
                let switches = matches!(self.shape, Shape::Step(_) | Shape::Intermittent(_));
                let size = self.shape.amplitude();
                #[expect(clippy::float_cmp, reason = "it is a switch")]
                if switches && size == 1.0 {
                    return Ok(());
                }
                Err(PlantError::FaultShape {
                    mode: mode.name(),
                    found: self.shape.name(),
                    size,
                })
            }
            _ => Ok(()),
        }
    }

    /// Refuses a ramp that leaves what the plant can be in a run of `duration_s` seconds: 100 % of
    /// the flow, the reading or the efficiency, or what is not finite. Faults that only together
    /// go that far are not seen here; the plant then leaves its range.
    ///
    /// # Errors
    /// [`PlantError::Scenario`].
    pub fn validate_by(&self, duration_s: f64) -> Result<(), PlantError> {
        let last_s = self.end_s.map_or(duration_s, |end_s| end_s.min(duration_s));
        let size = self.shape.largest((last_s - self.onset_s).max(0.0));
        if size < self.target.bound() {
            return Ok(());
        }
        Err(PlantError::Scenario {
            what: match self.case() {
                Some(FaultCase::CompressorFouling) => "size of compressor_fouling at the end [%]",
                Some(FaultCase::ThermocoupleDrift) => "size of thermocouple_drift at the end [%]",
                Some(FaultCase::TurbineDamage) => "size of turbine_damage at the end [%]",
                Some(FaultCase::FuelActuatorLag) => "size of fuel_actuator_lag at the end [s]",
                None => "size of a fault at the end",
            },
            expected: "a size below 100 % (or finite, for other units): set a limit or a lower \
                       rate",
            found: self.magnitude(last_s),
        })
    }

    /// Refuses faults that make no sense, or that `also` refuses.
    ///
    /// # Errors
    /// [`PlantError::Fault`] with the number and name of the first such fault.
    pub(crate) fn validate_each(
        faults: &[Self],
        also: impl Fn(&Self) -> Result<(), PlantError>,
    ) -> Result<(), PlantError> {
        for (index, fault) in faults.iter().enumerate() {
            let checked = fault.validate().and_then(|()| also(fault));
            checked.map_err(|cause| PlantError::Fault {
                number: index + 1,
                name: fault.target.name(),
                cause: Box::new(cause),
            })?;
        }
        Ok(())
    }

    /// Refuses faults of a scenario that contradict each other.
    ///
    /// # Errors
    /// [`PlantError::FaultConflict`] where two faults hold one sensor or one actuator.
    pub fn validate_together(faults: &[Self]) -> Result<(), PlantError> {
        let mut holding = HashMap::new();
        for fault in faults {
            let held = match fault.target {
                Target::Sensor {
                    channel,
                    mode: Mode::Stuck,
                } => format!("sensor {channel}"),
                Target::Actuator {
                    actuator,
                    mode: Mode::Stuck | Mode::Dropout,
                } => format!("actuator {actuator}"),
                _ => continue,
            };
            let name = fault.target.name();
            if let Some(first) = holding.insert(held.clone(), name.clone()) {
                return Err(PlantError::FaultConflict {
                    held,
                    first,
                    second: name,
                });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Channel;
    use crate::faults::{ActuatorId, Exponential, Intermittent, Step};

    fn step(size: f64) -> Shape {
        Shape::Step(Step { size })
    }

    fn exponential(time_constant_s: f64) -> Shape {
        Shape::Exponential(Exponential {
            size: 1.0,
            time_constant_s,
        })
    }

    fn intermittent(size: f64, period_s: f64, on_s: f64) -> Shape {
        Shape::Intermittent(Intermittent {
            size,
            period_s,
            on_s,
        })
    }

    fn fouling(onset_s: f64, rate_per_h: f64, limit: Option<f64>) -> Fault {
        Fault::growing(FaultCase::CompressorFouling, onset_s, rate_per_h, limit)
    }

    fn sensor(mode: Mode, shape: Shape) -> Fault {
        Fault::sensor(Channel::named("t3").unwrap(), mode, 1.0, shape)
    }

    fn message(fault: &Fault) -> String {
        match fault.validate() {
            Ok(()) => String::new(),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn impossible_numbers_are_refused() {
        let case = |shape| Fault::new(Target::Case(FaultCase::TurbineDamage), 1.0, shape);
        for (fault, expected) in [
            (fouling(0.0, 0.0, Some(0.0)), ""),
            (sensor(Mode::Gain, step(-200.0)), ""),
            (
                fouling(-1.0, 5.0, None),
                "onset of a fault [s]: expected a finite number of at least 0, found -1",
            ),
            (
                fouling(f64::NAN, 5.0, None),
                "onset of a fault [s]: expected a finite number of at least 0, found NaN",
            ),
            (
                fouling(1.0, 5.0, None).until(1.0),
                "end_s of a fault: expected a finite number above its onset_s, found 1",
            ),
            (
                fouling(0.0, -5.0, None),
                "rate of a fault [per h]: expected a finite number of at least 0, found -5",
            ),
            (
                fouling(0.0, 5.0, Some(100.0)),
                "limit of a fault [%]: expected below 100, found 100",
            ),
            (
                fouling(0.0, 5.0, Some(f64::NAN)),
                "limit of a fault: expected a finite number of at least 0, found NaN",
            ),
            (
                case(step(-1.0)),
                "size of a fault: expected a finite number of at least 0, found -1",
            ),
            (
                case(step(100.0)),
                "size of a fault [%]: expected between -100 and 100, found 100",
            ),
            (
                sensor(Mode::Bias, step(f64::INFINITY)),
                "size of a fault: expected a finite number, found inf",
            ),
            (
                sensor(Mode::Bias, step(1e12)),
                "size of a fault: expected between -1e12 and 1e12, found 1000000000000",
            ),
            (
                sensor(Mode::Lag, step(1e6)),
                "size of a fault [s]: expected below 1e6, found 1000000",
            ),
            (
                sensor(Mode::Gain, step(-1e6)),
                "size of a fault [%]: expected between -1e6 and 1e6, found -1000000",
            ),
            (
                sensor(Mode::Noise, step(-1.0)),
                "size of a fault: expected a finite number of at least 0, found -1",
            ),
            (
                sensor(Mode::Lag, intermittent(-1.0, 2.0, 1.0)),
                "size of a fault: expected a finite number of at least 0, found -1",
            ),
        ] {
            assert_eq!(message(&fault), expected);
        }
    }

    #[test]
    fn impossible_shapes_are_refused() {
        let spike = |spikes_per_h| sensor(Mode::Spike { spikes_per_h }, step(1.0));
        let ramp = Shape::Ramp(Ramp {
            rate_per_h: 1.0,
            limit: None,
        });
        for (fault, expected) in [
            (spike(45000.0), ""),
            (sensor(Mode::Stuck, intermittent(1.0, 2.0, 1.0)), ""),
            (
                sensor(Mode::Bias, exponential(0.0)),
                "exponential.time_constant_s of a fault: expected a finite number above 0, found 0",
            ),
            (
                sensor(Mode::Bias, intermittent(1.0, f64::INFINITY, 1.0)),
                "intermittent.period_s of a fault: expected a finite number above 0, found inf",
            ),
            (
                sensor(Mode::Bias, intermittent(1.0, 2.0, 2.0)),
                "intermittent.on_s of a fault: expected a number above 0 and below period_s, \
                 found 2",
            ),
            (
                spike(0.0),
                "spikes_per_h of a fault: expected a number above 0 and at most 45000, one a \
                 sample, found 0",
            ),
            (
                spike(f64::NAN),
                "spikes_per_h of a fault: expected a number above 0 and at most 45000, one a \
                 sample, found NaN",
            ),
            (
                sensor(Mode::Stuck, ramp),
                "mode stuck of a fault: expected a step or intermittent of size 1, found ramp of \
                 1 an hour",
            ),
            (
                sensor(Mode::Dropout, step(0.5)),
                "mode dropout of a fault: expected a step or intermittent of size 1, found step \
                 of size 0.5",
            ),
        ] {
            assert_eq!(message(&fault), expected);
        }
    }

    #[test]
    fn nothing_is_held_twice() {
        let t3 = Channel::named("t3").unwrap();
        let p3 = Channel::named("p3").unwrap();
        let stuck = |channel| Fault::sensor(channel, Mode::Stuck, 1.0, step(1.0));
        let dropout = |channel| Fault::sensor(channel, Mode::Dropout, 1.0, step(1.0));
        let together = |faults: &[Fault]| match Fault::validate_together(faults) {
            Ok(()) => String::new(),
            Err(error) => error.to_string(),
        };
        assert_eq!(
            together(&[stuck(t3), stuck(p3), dropout(t3), dropout(t3)]),
            ""
        );
        assert_eq!(
            together(&[stuck(t3), stuck(t3)]),
            "faults: expected at most one that holds sensor t3, found t3_stuck and t3_stuck"
        );
        let valve = |mode| Fault::actuator(ActuatorId::Valve, mode, 1.0, step(1.0));
        assert_eq!(
            together(&[valve(Mode::Stuck), valve(Mode::Lag), valve(Mode::Dropout)]),
            "faults: expected at most one that holds actuator a_v, found a_v_actuator_stuck and \
             a_v_actuator_dropout"
        );
    }
}
