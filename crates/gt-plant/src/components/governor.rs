//! The speed governor: proportional and integral action on the fuel, with limits.

use serde::{Deserialize, Serialize};

use crate::real::Real;

/// The governor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Governor {
    /// Proportional gain, kg/s per rad/s (assumed).
    pub proportional_gain: f64,
    /// Integral gain, kg/s per rad (assumed).
    pub integral_gain: f64,
    /// Time constant with which the integral is led back from a limit, s (assumed).
    pub tracking_s: f64,
    /// Fuel flow at zero error and zero integral, kg/s (paper, Table 3).
    pub design_fuel_kg_s: f64,
    /// Smallest fuel flow, kg/s (assumed).
    pub minimum_fuel_kg_s: f64,
    /// Largest fuel flow, kg/s (assumed).
    pub maximum_fuel_kg_s: f64,
}

/// Which limit holds the demanded fuel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FuelLimit {
    /// The smallest fuel flow.
    Minimum,
    /// The largest fuel flow.
    Maximum,
}

/// What a controller asks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand<R = f64> {
    /// Demanded fuel flow within the limits, kg/s.
    pub fuel_kg_s: R,
    /// Rate of change of the integral, rad/s.
    pub integral_rate: R,
}

impl Governor {
    /// The demand for a speed error, its integral and an added dither.
    ///
    /// At a limit the integral is led back with a time constant ([`Governor::tracking_s`]), so that
    /// the speed does not overshoot when the demand comes back (back-calculation: Astrom and
    /// Hagglund, PID Controllers, section 3.5). Clamping the integral instead would make the
    /// derivative jump at the limit, where a run may then slide along the jump.
    #[inline(always)]
    pub fn demand<R: Real>(&self, error_rad_s: R, integral_rad: R, dither_kg_s: R) -> Demand<R> {
        let wanted = error_rad_s * self.proportional_gain
            + integral_rad * self.integral_gain
            + dither_kg_s
            + self.design_fuel_kg_s;
        let fuel_kg_s = self.limited(wanted);
        let back = (fuel_kg_s - wanted) / (self.integral_gain * self.tracking_s);
        Demand {
            fuel_kg_s,
            integral_rate: error_rad_s + back,
        }
    }

    /// A demanded fuel flow within the limits, kg/s.
    #[inline(always)]
    pub fn limited<R: Real>(&self, fuel_kg_s: R) -> R {
        fuel_kg_s
            .at_most(fuel_kg_s.like(self.maximum_fuel_kg_s))
            .at_least(fuel_kg_s.like(self.minimum_fuel_kg_s))
    }

    /// The limit at which a demand stands, if any.
    pub fn limit(&self, demanded_kg_s: f64) -> Option<FuelLimit> {
        if demanded_kg_s >= self.maximum_fuel_kg_s {
            Some(FuelLimit::Maximum)
        } else if demanded_kg_s <= self.minimum_fuel_kg_s {
            Some(FuelLimit::Minimum)
        } else {
            None
        }
    }

    /// The integral of the speed error that holds `fuel_kg_s` at zero error, rad.
    #[inline(always)]
    pub fn integral_for<R: Real>(&self, fuel_kg_s: R) -> R {
        (fuel_kg_s - self.design_fuel_kg_s) / self.integral_gain
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "these values are exact")]

    use super::*;

    const GOVERNOR: Governor = Governor {
        proportional_gain: 1e-3,
        integral_gain: 2e-3,
        tracking_s: 0.5,
        design_fuel_kg_s: 0.2,
        minimum_fuel_kg_s: 0.05,
        maximum_fuel_kg_s: 0.35,
    };

    #[test]
    fn at_a_limit_the_integral_is_led_back() {
        let inside = GOVERNOR.demand(3.0, 10.0, 0.0);
        assert_eq!(inside.integral_rate, 3.0);
        assert_eq!(GOVERNOR.limit(inside.fuel_kg_s), None);
        for (integral, limit) in [(100.0, FuelLimit::Maximum), (-100.0, FuelLimit::Minimum)] {
            let beyond = GOVERNOR.demand(0.0, integral, 0.0);
            assert_eq!(GOVERNOR.limit(beyond.fuel_kg_s), Some(limit));
            // What is beyond the limit, in units of the integral, comes back within 0.5 s.
            let excess = GOVERNOR.integral_for(beyond.fuel_kg_s) - integral;
            assert!((beyond.integral_rate - excess / 0.5).abs() < 1e-9);
        }
    }

    #[test]
    fn integral_for_inverts_the_demand() {
        let demand = GOVERNOR.demand(0.0, GOVERNOR.integral_for(0.23), 0.0);
        assert!((demand.fuel_kg_s - 0.23).abs() < 1e-16);
    }
}
