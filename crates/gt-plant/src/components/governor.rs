//! The speed governor: proportional and integral action on the fuel, with limits.

use serde::{Deserialize, Serialize};

/// The governor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Governor {
    /// Proportional gain, kg/s per rad/s (assumed).
    pub proportional_gain: f64,
    /// Integral gain, kg/s per rad (assumed).
    pub integral_gain: f64,
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

/// What the governor asks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand {
    /// Demanded fuel flow within the limits, kg/s.
    pub fuel_kg_s: f64,
    /// Rate of change of the integral, rad/s.
    pub integral_rate: f64,
    /// The limit that holds, if any.
    pub limit: Option<FuelLimit>,
}

impl Governor {
    /// The demand for a speed error, its integral and an added dither.
    ///
    /// At a limit the integral stops where it would push further out (clamping), so that the
    /// speed does not overshoot when the demand comes back.
    pub fn demand(&self, error_rad_s: f64, integral_rad: f64, dither_kg_s: f64) -> Demand {
        let wanted = self.design_fuel_kg_s
            + self.proportional_gain * error_rad_s
            + self.integral_gain * integral_rad
            + dither_kg_s;
        let (fuel_kg_s, limit, winds_up) = if wanted > self.maximum_fuel_kg_s {
            (
                self.maximum_fuel_kg_s,
                Some(FuelLimit::Maximum),
                error_rad_s > 0.0,
            )
        } else if wanted < self.minimum_fuel_kg_s {
            (
                self.minimum_fuel_kg_s,
                Some(FuelLimit::Minimum),
                error_rad_s < 0.0,
            )
        } else {
            (wanted, None, false)
        };
        let integral_rate = if winds_up { 0.0 } else { error_rad_s };
        Demand {
            fuel_kg_s,
            integral_rate,
            limit,
        }
    }

    /// The integral of the speed error that holds `fuel_kg_s` at zero error, rad.
    pub fn integral_for(&self, fuel_kg_s: f64) -> f64 {
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
        design_fuel_kg_s: 0.2,
        minimum_fuel_kg_s: 0.05,
        maximum_fuel_kg_s: 0.35,
    };

    #[test]
    fn integral_stops_only_where_it_winds_up() {
        let above = GOVERNOR.demand(10.0, 100.0, 0.0);
        assert_eq!(
            (above.fuel_kg_s, above.limit),
            (0.35, Some(FuelLimit::Maximum))
        );
        assert_eq!(above.integral_rate, 0.0);
        assert_eq!(GOVERNOR.demand(-10.0, 200.0, 0.0).integral_rate, -10.0);
        let below = GOVERNOR.demand(-10.0, -100.0, 0.0);
        assert_eq!(
            (below.fuel_kg_s, below.limit),
            (0.05, Some(FuelLimit::Minimum))
        );
        assert_eq!(below.integral_rate, 0.0);
        assert_eq!(GOVERNOR.demand(3.0, 0.0, 0.0).integral_rate, 3.0);
    }

    #[test]
    fn integral_for_inverts_the_demand() {
        let demand = GOVERNOR.demand(0.0, GOVERNOR.integral_for(0.23), 0.0);
        assert!((demand.fuel_kg_s - 0.23).abs() < 1e-16);
    }
}
