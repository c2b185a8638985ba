//! The four fault cases of section 3.2 of the paper, each a ramp that may end at a limit.

use std::fmt;
use std::str::FromStr;

use gt_core::Signal;
use serde::{Deserialize, Serialize};

use crate::PlantError;

const SECONDS_PER_HOUR: f64 = 3600.0;
/// The paper's development rate of cases 1 to 3, percent per hour.
const NOMINAL_RATE_PERCENT_PER_H: f64 = 5.0;
/// The paper's largest size of cases 1 and 3, percent.
const NOMINAL_LIMIT_PERCENT: f64 = 5.0;
/// Growth of the fuel actuator's lag, seconds per hour: the paper prints none (assumed).
const NOMINAL_RATE_S_PER_H: f64 = 5.0;

/// The fault cases of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultCase {
    /// Case 1: the compressor passes less mass flow at given pressure ratio.
    CompressorFouling,
    /// Case 2: the thermocouple t3 reads too high or too low.
    ThermocoupleDrift,
    /// Case 3: the turbine loses isentropic efficiency.
    TurbineDamage,
    /// Case 4: the fuel follows the demand with a first-order lag. With the default maps the
    /// speed loop is unstable above 3.05 s and swings between the limits of the fuel.
    FuelActuatorLag,
}

impl FaultCase {
    /// All cases, in the paper's order.
    pub const ALL: [Self; 4] = [
        Self::CompressorFouling,
        Self::ThermocoupleDrift,
        Self::TurbineDamage,
        Self::FuelActuatorLag,
    ];

    /// The names, in the paper's order.
    pub const NAMES: &[&str] = &[
        "compressor_fouling",
        "thermocouple_drift",
        "turbine_damage",
        "fuel_actuator_lag",
    ];

    /// The paper's number, 1 to 4.
    pub fn number(self) -> usize {
        match self {
            Self::CompressorFouling => 1,
            Self::ThermocoupleDrift => 2,
            Self::TurbineDamage => 3,
            Self::FuelActuatorLag => 4,
        }
    }

    /// The name, as in a scenario file.
    pub fn name(self) -> &'static str {
        Self::NAMES[self.number() - 1]
    }

    /// Unit of the magnitude: percent, or seconds for case 4.
    pub fn unit(self) -> &'static str {
        match self {
            Self::FuelActuatorLag => "s",
            _ => "%",
        }
    }
}

impl fmt::Display for FaultCase {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

impl FromStr for FaultCase {
    type Err = PlantError;

    fn from_str(name: &str) -> Result<Self, PlantError> {
        Self::ALL
            .into_iter()
            .find(|case| case.name() == name)
            .ok_or_else(|| PlantError::UnknownName {
                what: "fault case",
                expected: Self::NAMES,
                found: name.to_owned(),
            })
    }
}

/// A fault: nothing before its onset, then a ramp, then its limit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "case", rename_all = "snake_case", deny_unknown_fields)]
pub enum Fault {
    /// Case 1, in percent of the mass flow at given pressure ratio.
    CompressorFouling {
        /// When it begins, in seconds.
        onset_s: f64,
        /// How fast it grows, percent per hour; not negative.
        rate_percent_per_h: f64,
        /// Where it stops, percent; nowhere when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        limit_percent: Option<f64>,
    },
    /// Case 2, in percent of the absolute temperature t3.
    ThermocoupleDrift {
        /// When it begins, in seconds.
        onset_s: f64,
        /// How fast it grows, percent per hour; negative for a reading that falls.
        rate_percent_per_h: f64,
        /// The absolute value at which it stops, percent; nowhere when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        limit_percent: Option<f64>,
    },
    /// Case 3, in percent of the isentropic efficiency.
    TurbineDamage {
        /// When it begins, in seconds.
        onset_s: f64,
        /// How fast it grows, percent per hour; not negative.
        rate_percent_per_h: f64,
        /// Where it stops, percent; nowhere when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        limit_percent: Option<f64>,
    },
    /// Case 4, the time constant of the lag in seconds.
    FuelActuatorLag {
        /// When it begins, in seconds.
        onset_s: f64,
        /// How fast the time constant grows, seconds per hour; not negative.
        rate_s_per_h: f64,
        /// Where it stops, seconds; nowhere when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        limit_s: Option<f64>,
    },
}

impl Fault {
    /// A fault of the given rate per hour and limit, both in the case's own unit (percent; seconds
    /// in case 4).
    pub fn growing(case: FaultCase, onset_s: f64, rate_per_h: f64, limit: Option<f64>) -> Self {
        let (rate_percent_per_h, limit_percent) = (rate_per_h, limit);
        match case {
            FaultCase::CompressorFouling => Self::CompressorFouling {
                onset_s,
                rate_percent_per_h,
                limit_percent,
            },
            FaultCase::ThermocoupleDrift => Self::ThermocoupleDrift {
                onset_s,
                rate_percent_per_h,
                limit_percent,
            },
            FaultCase::TurbineDamage => Self::TurbineDamage {
                onset_s,
                rate_percent_per_h,
                limit_percent,
            },
            FaultCase::FuelActuatorLag => Self::FuelActuatorLag {
                onset_s,
                rate_s_per_h: rate_per_h,
                limit_s: limit,
            },
        }
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

    /// Which case it is.
    pub fn case(&self) -> FaultCase {
        match self {
            Self::CompressorFouling { .. } => FaultCase::CompressorFouling,
            Self::ThermocoupleDrift { .. } => FaultCase::ThermocoupleDrift,
            Self::TurbineDamage { .. } => FaultCase::TurbineDamage,
            Self::FuelActuatorLag { .. } => FaultCase::FuelActuatorLag,
        }
    }

    /// When it begins, in seconds.
    pub fn onset_s(&self) -> f64 {
        self.ramp().0
    }

    /// Unit of the magnitude.
    pub fn unit(&self) -> &'static str {
        self.case().unit()
    }

    /// Name and unit of the magnitude as a signal.
    pub fn signal(&self) -> Signal {
        Signal::new(self.case().name(), self.unit())
    }

    /// The magnitude at a time, in percent, or in seconds for case 4.
    pub fn magnitude(&self, t_s: f64) -> f64 {
        let (onset_s, rate_per_h, limit) = self.ramp();
        // An infinite time on a zero rate would be NaN: `<=` also keeps the zero exact.
        if t_s <= onset_s || rate_per_h == 0.0 {
            return 0.0;
        }
        let ramp = rate_per_h * (t_s - onset_s) / SECONDS_PER_HOUR;
        limit.map_or(ramp, |limit| ramp.clamp(-limit, limit))
    }

    /// Onset in seconds, rate per hour and limit.
    fn ramp(&self) -> (f64, f64, Option<f64>) {
        match *self {
            Self::CompressorFouling {
                onset_s,
                rate_percent_per_h,
                limit_percent,
            }
            | Self::ThermocoupleDrift {
                onset_s,
                rate_percent_per_h,
                limit_percent,
            }
            | Self::TurbineDamage {
                onset_s,
                rate_percent_per_h,
                limit_percent,
            } => (onset_s, rate_percent_per_h, limit_percent),
            Self::FuelActuatorLag {
                onset_s,
                rate_s_per_h,
                limit_s,
            } => (onset_s, rate_s_per_h, limit_s),
        }
    }

    /// Refuses numbers that make no sense.
    ///
    /// # Errors
    /// [`PlantError::Scenario`]: the onset is finite and not negative, the rate is finite and
    /// negative in case 2 only, the limit is finite, not negative and below 100 percent.
    pub fn validate(&self) -> Result<(), PlantError> {
        let (onset_s, rate, limit) = self.ramp();
        let refuse = |what, expected, found| {
            Err(PlantError::Scenario {
                what,
                expected,
                found,
            })
        };
        if !(onset_s.is_finite() && onset_s >= 0.0) {
            return refuse(
                "onset of a fault [s]",
                "a finite number of at least 0",
                onset_s,
            );
        }
        if self.case() == FaultCase::ThermocoupleDrift {
            if !rate.is_finite() {
                return refuse(
                    "rate of the thermocouple drift [%/h]",
                    "a finite number",
                    rate,
                );
            }
        } else if !(rate.is_finite() && rate >= 0.0) {
            return refuse(
                "rate of a fault [per h]",
                "a finite number of at least 0",
                rate,
            );
        }
        match limit {
            Some(limit) if !(limit.is_finite() && limit >= 0.0) => {
                refuse("limit of a fault", "a finite number of at least 0", limit)
            }
            Some(limit) if self.unit() == "%" && limit >= 100.0 => {
                refuse("limit of a fault [%]", "below 100", limit)
            }
            _ => Ok(()),
        }
    }

    /// Refuses a ramp that leaves what the plant can be in a run of `duration_s` seconds: 100 % of
    /// the flow, the reading or the efficiency, or a lag that is not finite.
    ///
    /// # Errors
    /// [`PlantError::Scenario`].
    pub fn validate_by(&self, duration_s: f64) -> Result<(), PlantError> {
        let size = self.magnitude(duration_s);
        let (what, bound) = match self.case() {
            FaultCase::CompressorFouling => ("size of compressor_fouling at the end [%]", 100.0),
            FaultCase::ThermocoupleDrift => ("size of thermocouple_drift at the end [%]", 100.0),
            FaultCase::TurbineDamage => ("size of turbine_damage at the end [%]", 100.0),
            FaultCase::FuelActuatorLag => ("size of fuel_actuator_lag at the end [s]", f64::MAX),
        };
        if size.abs() < bound {
            return Ok(());
        }
        Err(PlantError::Scenario {
            what,
            expected: "a size below 100 % (or finite, for a lag): set a limit or a lower rate",
            found: size,
        })
    }
}

/// Sizes of the faults at one moment, as the plant's laws use them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaultSizes {
    /// Share of the compressor's mass flow that is lost (case 1).
    pub compressor_flow_loss: f64,
    /// Relative error of the thermocouple t3 (case 2); touches the sensor only.
    pub t3_reading_error: f64,
    /// Share of the turbine's efficiency that is lost (case 3).
    pub turbine_efficiency_loss: f64,
    /// Time constant of the fuel actuator, s (case 4).
    pub fuel_lag_s: f64,
}

impl FaultSizes {
    /// No fault.
    pub const HEALTHY: Self = Self {
        compressor_flow_loss: 0.0,
        t3_reading_error: 0.0,
        turbine_efficiency_loss: 0.0,
        fuel_lag_s: 0.0,
    };

    /// The sizes at a time.
    pub fn at(faults: &[Fault], t_s: f64) -> Self {
        let mut sizes = Self::HEALTHY;
        for fault in faults {
            let magnitude = fault.magnitude(t_s);
            match fault.case() {
                FaultCase::CompressorFouling => sizes.compressor_flow_loss += magnitude / 100.0,
                FaultCase::ThermocoupleDrift => sizes.t3_reading_error += magnitude / 100.0,
                FaultCase::TurbineDamage => sizes.turbine_efficiency_loss += magnitude / 100.0,
                FaultCase::FuelActuatorLag => sizes.fuel_lag_s += magnitude,
            }
        }
        sizes
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "these values are exact")]

    use super::*;
    use proptest::prelude::*;

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
        let fault = Fault::ThermocoupleDrift {
            onset_s: 0.0,
            rate_percent_per_h: -3600.0,
            limit_percent: Some(2.0),
        };
        assert_eq!(
            [0.5, 1.0, 9.0].map(|t| fault.magnitude(t)),
            [-0.5, -1.0, -2.0]
        );
    }

    #[test]
    fn impossible_numbers_are_refused() {
        let fouling = |onset_s, rate_percent_per_h, limit_percent| {
            Fault::CompressorFouling {
                onset_s,
                rate_percent_per_h,
                limit_percent,
            }
            .validate()
        };
        let message = |result: Result<(), PlantError>| result.unwrap_err().to_string();
        assert_eq!(fouling(0.0, 0.0, Some(0.0)), Ok(()));
        assert_eq!(
            message(fouling(-1.0, 5.0, None)),
            "onset of a fault [s]: expected a finite number of at least 0, found -1"
        );
        assert_eq!(
            message(fouling(0.0, -5.0, None)),
            "rate of a fault [per h]: expected a finite number of at least 0, found -5"
        );
        assert_eq!(
            message(fouling(0.0, 5.0, Some(100.0))),
            "limit of a fault [%]: expected below 100, found 100"
        );
        assert!(fouling(f64::NAN, 5.0, None).is_err());
        assert!(fouling(0.0, 5.0, Some(f64::NAN)).is_err());
    }

    #[test]
    fn names_come_back() {
        for (index, case) in FaultCase::ALL.into_iter().enumerate() {
            assert_eq!(case.number(), index + 1);
            assert_eq!(case.name().parse(), Ok(case));
        }
    }

    proptest! {
        #[test]
        fn prop_ramp_is_linear_then_constant(
            onset in 0.0..1e3f64, rate in 0.1..1e3f64, limit in 0.1..50.0f64, after in 0.0..1e5f64
        ) {
            let fault = Fault::TurbineDamage {
                onset_s: onset, rate_percent_per_h: rate, limit_percent: Some(limit),
            };
            let expected = (rate * after / 3600.0).min(limit);
            // Rounding of onset + after - onset.
            prop_assert!((fault.magnitude(onset + after) - expected).abs() < 1e-9);
            prop_assert_eq!(fault.magnitude(onset - after), 0.0);
        }
    }
}
