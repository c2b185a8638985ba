//! The profile: how a run is excited.

use serde::Serialize;

use super::schedule;
use crate::interval::within;
use crate::{PlantError, SAMPLE_TIME_S, Variant};

/// How the plant is excited. In a scenario's file it is a name of [`Profile::names`] or a table of
/// fields; fields that are left out are those of `standard` of the scenario's variant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Profile {
    /// Levels of the valve are uniform within plus or minus this, degrees.
    pub valve_amplitude_deg: f64,
    /// Shortest and longest hold of a level of the valve, s.
    pub valve_hold_s: [f64; 2],
    /// Fastest motion of the valve, deg/s.
    pub valve_slew_deg_s: f64,
    /// Levels of the speed reference (on the mains: of the grid's frequency) are uniform within
    /// plus or minus this share of design speed.
    pub speed_amplitude_fraction: f64,
    /// Shortest and longest hold of a level of the speed reference, s.
    pub speed_hold_s: [f64; 2],
    /// Fastest motion of the speed reference, share of design speed a second.
    pub speed_slew_fraction_s: f64,
    /// Levels of the fuel are uniform within plus or minus this share of the design fuel flow, on
    /// top of the schedule. Zero in the prototype, whose governor sets the fuel.
    pub fuel_amplitude_fraction: f64,
    /// Shortest and longest hold of a level of the fuel, s.
    pub fuel_hold_s: [f64; 2],
    /// Fastest motion between levels of the fuel, share of the design fuel flow a second.
    pub fuel_slew_fraction_s: f64,
    /// Points of (time in s, share of the design fuel flow) with straight lines between, constant
    /// before the first and after the last; none means design fuel throughout. None in the
    /// prototype, whose governor sets the fuel.
    pub fuel_schedule: Vec<[f64; 2]>,
    /// Stationary standard deviation of the fuel dither, share of the design fuel flow.
    pub dither_fraction: f64,
    /// Both poles of the filter that shapes the dither from white noise.
    pub dither_pole: f64,
}

impl Profile {
    /// Whether anything moves: levels, dither, or a schedule that is not constant.
    pub fn excites(&self) -> bool {
        self.valve_amplitude_deg != 0.0
            || self.speed_amplitude_fraction != 0.0
            || self.fuel_amplitude_fraction != 0.0
            || self.dither_fraction != 0.0
            || schedule::varies(&self.fuel_schedule)
    }

    /// Refuses numbers that make no sense, or none for this variant.
    ///
    /// # Errors
    /// [`PlantError::NotInVariant`] for fuel levels or a schedule in the prototype, and for levels
    /// of the valve above 5 degrees or of the speed above 2 percent in cogeneration;
    /// [`PlantError::Scenario`] with the first number that is out of its limits.
    pub fn validate_for(&self, variant: Variant) -> Result<(), PlantError> {
        let amplitude = |what, found, most, expected| within(what, found, [0.0, most], expected);
        let hold = |what, [shortest, longest]: [f64; 2]| {
            let expected = "at least one sample time and finite";
            within(what, shortest, [SAMPLE_TIME_S, f64::MAX], expected)?;
            let expected = "at least the shortest hold and finite";
            within(what, longest, [shortest, f64::MAX], expected)
        };
        let slew = |what, found| {
            let above_zero = [f64::MIN_POSITIVE, f64::MAX];
            within(what, found, above_zero, "above 0 and finite")
        };
        amplitude(
            "valve_amplitude_deg",
            self.valve_amplitude_deg,
            20.0,
            "between 0 and 20",
        )?;
        hold("valve_hold_s", self.valve_hold_s)?;
        slew("valve_slew_deg_s", self.valve_slew_deg_s)?;
        amplitude(
            "speed_amplitude_fraction",
            self.speed_amplitude_fraction,
            0.1,
            "between 0 and 0.1",
        )?;
        hold("speed_hold_s", self.speed_hold_s)?;
        slew("speed_slew_fraction_s", self.speed_slew_fraction_s)?;
        amplitude(
            "fuel_amplitude_fraction",
            self.fuel_amplitude_fraction,
            0.2,
            "between 0 and 0.2",
        )?;
        hold("fuel_hold_s", self.fuel_hold_s)?;
        slew("fuel_slew_fraction_s", self.fuel_slew_fraction_s)?;
        schedule::validate(&self.fuel_schedule)?;
        amplitude(
            "dither_fraction",
            self.dither_fraction,
            0.2,
            "between 0 and 0.2",
        )?;
        within(
            "dither_pole",
            self.dither_pole,
            [0.0, 0.999],
            "between 0 and 0.999",
        )?;
        self.validate_variant(variant)
    }

    /// Refuses what another variant would accept.
    fn validate_variant(&self, variant: Variant) -> Result<(), PlantError> {
        let refuse = |what, expected, found| {
            Err(PlantError::NotInVariant {
                what,
                variant,
                expected,
                found,
            })
        };
        match variant {
            Variant::Prototype => {
                let expected = "none, as the governor sets the fuel";
                if self.fuel_amplitude_fraction != 0.0 {
                    let found = self.fuel_amplitude_fraction.to_string();
                    return refuse("fuel_amplitude_fraction", expected, found);
                }
                if !self.fuel_schedule.is_empty() {
                    let found = format!("{} points", self.fuel_schedule.len());
                    return refuse("fuel_schedule", expected, found);
                }
            }
            Variant::Cogeneration => {
                if self.valve_amplitude_deg > 5.0 {
                    let expected = "between 0 and 5, as the valve stands open";
                    let found = self.valve_amplitude_deg.to_string();
                    return refuse("valve_amplitude_deg", expected, found);
                }
                // 1 Hz of 50 Hz.
                if self.speed_amplitude_fraction > 0.02 {
                    let expected = "between 0 and 0.02, as the mains hold the speed";
                    let found = self.speed_amplitude_fraction.to_string();
                    return refuse("speed_amplitude_fraction", expected, found);
                }
            }
        }
        Ok(())
    }
}
