//! The inlet guide vanes: what closing them does to the compressor, and the controller that closes
//! them to hold the exhaust temperature.

use serde::{Deserialize, Serialize};

use crate::real::Real;

/// Inlet guide vanes in front of the compressor and their controller (paper, section 3.1 and
/// figure 2: a PID controller on the turbine outlet temperature).
///
/// The angle counts from fully open: 0 is open, [`GuideVanes::closed_deg`] the closed stop.
/// Closing turns the flow towards the rotation, which lowers flow and pressure rise of every speed
/// line about alike, and costs efficiency with the square of the angle. The paper prints no number
/// of these; all are assumed, so that the range of the vanes covers a load reduction to about three
/// quarters of the fuel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GuideVanes {
    /// Angle of the closed stop, degrees from fully open (assumed).
    pub closed_deg: f64,
    /// Loss of flow a degree, share (assumed).
    pub flow_loss_per_deg: f64,
    /// Loss of pressure rise a degree, share (assumed).
    pub pressure_loss_per_deg: f64,
    /// Loss of efficiency a squared degree, share (assumed).
    pub efficiency_loss_per_deg2: f64,
    /// Exhaust temperature that is held, K (assumed).
    pub set_point_k: f64,
    /// Proportional gain, deg/K (assumed).
    pub proportional_deg_k: f64,
    /// Integral gain, deg/(K s) (assumed).
    pub integral_deg_k_s: f64,
    /// Derivative gain, deg s/K (assumed).
    pub derivative_deg_s_k: f64,
    /// Time constant of the thermocouple that the controller reads, s (assumed); it filters the
    /// derivative too.
    pub thermocouple_s: f64,
    /// Time constant with which the integral is led back from a stop, s (assumed).
    pub tracking_s: f64,
    /// Time constant of the positioner, s (assumed).
    pub positioner_s: f64,
    /// Fastest motion, deg/s (assumed).
    pub slew_deg_s: f64,
}

/// What a vane angle does to a speed line: factors on flow, pressure rise and efficiency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VaneEffect<R = f64> {
    /// Factor on the corrected flow.
    pub flow: R,
    /// Factor on the pressure rise.
    pub pressure_rise: R,
    /// Factor on the efficiency.
    pub efficiency: R,
}

impl GuideVanes {
    /// The effect of an angle, degrees from open.
    #[inline(always)]
    pub fn effect<R: Real>(&self, angle_deg: R) -> VaneEffect<R> {
        VaneEffect {
            flow: -angle_deg * self.flow_loss_per_deg + 1.0,
            pressure_rise: -angle_deg * self.pressure_loss_per_deg + 1.0,
            efficiency: -angle_deg.squared() * self.efficiency_loss_per_deg2 + 1.0,
        }
    }

    /// Mechanical stops: open and closed, degrees.
    #[inline(always)]
    pub fn stops_deg(&self) -> [f64; 2] {
        [0.0, self.closed_deg]
    }

    /// Rate of change of the thermocouple's reading, K/s.
    #[inline(always)]
    pub fn reading_rate<R: Real>(&self, exhaust_k: R, reading_k: R) -> R {
        (exhaust_k - reading_k) / self.thermocouple_s
    }

    /// The demanded angle within the stops, degrees, and the rate of change of the integral, K:
    /// an exhaust colder than the set point closes the vanes. At a stop the integral is led back
    /// (see [`super::governor`]).
    #[inline(always)]
    pub fn demand<R: Real>(&self, reading_k: R, reading_rate: R, integral_k_s: R) -> (R, R) {
        let error = -reading_k + self.set_point_k;
        let wanted = error * self.proportional_deg_k + integral_k_s * self.integral_deg_k_s
            - reading_rate * self.derivative_deg_s_k;
        let demand = wanted
            .at_most(error.like(self.closed_deg))
            .at_least(error.like(0.0));
        let back = (demand - wanted) / (self.integral_deg_k_s * self.tracking_s);
        (demand, error + back)
    }

    /// The angle beyond the stop `stop_deg` at which the controller rests while the reading stands
    /// at `reading_k`, degrees.
    pub fn resting_demand_deg(&self, stop_deg: f64, reading_k: f64) -> f64 {
        stop_deg + self.integral_deg_k_s * self.tracking_s * (self.set_point_k - reading_k)
    }

    /// Rate of change of the angle, deg/s; a fault adds `lag_s` to the positioner's time constant.
    #[inline(always)]
    pub fn angle_rate<R: Real>(&self, commanded_deg: R, angle_deg: R, lag_s: R) -> R {
        let rate = (commanded_deg - angle_deg) / (lag_s + self.positioner_s);
        rate.at_most(rate.like(self.slew_deg_s))
            .at_least(rate.like(-self.slew_deg_s))
    }

    /// The integral of the controller, K s, that demands an angle while the reading stands at
    /// `reading_k`.
    #[inline(always)]
    pub fn integral_for<R: Real>(&self, angle_deg: R, reading_k: R) -> R {
        let error = -reading_k + self.set_point_k;
        (angle_deg - error * self.proportional_deg_k) / self.integral_deg_k_s
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "these values are exact")]

    use crate::{MapSet, PlantParameters, Variant};

    #[test]
    fn a_cold_exhaust_closes_the_vanes_and_the_stops_hold_the_integral() {
        let vanes = PlantParameters::new(Variant::Cogeneration, MapSet::Paper).guide_vanes;
        let set = vanes.set_point_k;
        let (angle, rate) = vanes.demand(set - 10.0, 0.0, 0.0);
        assert!(angle > 0.0 && rate == 10.0);
        let beyond = |demand_deg: f64, reading_k: f64| {
            let integral = vanes.integral_for(demand_deg, reading_k);
            vanes.demand(reading_k, 0.0, integral)
        };
        // Beyond a stop the demand stands there, and the integral comes to rest where it says.
        for (stop, reading) in [(vanes.closed_deg, set - 10.0), (0.0, set + 10.0)] {
            let rest = vanes.resting_demand_deg(stop, reading);
            let (angle, rate) = beyond(rest, reading);
            assert_eq!(angle, stop);
            assert!(rate.abs() < 1e-12, "{rate}");
            // From further out it comes back within the tracking time.
            let outwards = if stop == 0.0 { -8.0 } else { 8.0 };
            let (angle, rate) = beyond(rest + outwards, reading);
            assert_eq!(angle, stop);
            let degrees_s = rate * vanes.integral_deg_k_s;
            assert!((degrees_s + outwards / vanes.tracking_s).abs() < 1e-12);
        }
        // A rising temperature opens them ahead of time.
        let half = vanes.integral_for(10.0, set);
        assert!(vanes.demand(set, 1.0, half).0 < 10.0);
    }
}
