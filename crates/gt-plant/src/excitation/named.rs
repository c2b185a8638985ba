//! The named profiles of each variant: every number of theirs stands here.

use super::profile::Profile;
use crate::{PlantError, Variant};

/// The names for the prototype, from none to wide.
const PROTOTYPE: &[&str] = &["steady", "gentle", "standard", "lively", "wide"];
/// The names for the machine on the mains.
const COGENERATION: &[&str] = &[
    "steady",
    "standard",
    "load_reduction_igv",
    "load_reduction_fuel",
];

/// Around this share of design fuel the guide vanes have room both ways.
const STANDARD_SCHEDULE: &[[f64; 2]] = &[[0.0, 0.92]];
/// Load reduction by fuel and guide vanes, which close to hold the exhaust temperature.
const LOAD_REDUCTION_IGV: &[[f64; 2]] = &[[20.0, 0.98], [80.0, 0.84]];
/// Load reduction by fuel alone, after the guide vanes have reached their closed stop.
const LOAD_REDUCTION_FUEL: &[[f64; 2]] = &[[20.0, 0.70], [80.0, 0.60]];

impl Profile {
    /// The names of a variant's profiles.
    pub fn names(variant: Variant) -> &'static [&'static str] {
        match variant {
            Variant::Prototype => PROTOTYPE,
            Variant::Cogeneration => COGENERATION,
        }
    }

    /// A profile of a variant by name.
    ///
    /// Prototype: `steady` excites nothing; `gentle`, `standard`, `lively` and `wide` move the
    /// valve within 0.75, 1.0, 1.5 and 2.5 degrees and the speed reference within 0.5, 0.67, 1 and
    /// 1 percent, and dither the fuel with a standard deviation of 2 percent.
    ///
    /// Cogeneration: `steady` excites nothing, at design fuel; `standard` moves the fuel within 3
    /// percent around 92 percent of design fuel and dithers it with a standard deviation of 0.5
    /// percent, and moves the grid's frequency within 0.05 percent; `load_reduction_igv` and
    /// `load_reduction_fuel` are the two manoeuvres of section 3.1 and nothing else: the fuel is
    /// held for 20 s, falls within 60 s, from 98 to 84 percent of design fuel while the guide vanes
    /// close or from 70 to 60 percent with the vanes at their closed stop, and is held again.
    ///
    /// # Errors
    /// [`PlantError::UnknownName`] with the names of the variant.
    pub fn named(variant: Variant, name: &str) -> Result<Self, PlantError> {
        let standard = Self::standard(variant);
        let prototype = |valve_amplitude_deg, speed_amplitude_fraction, dither_fraction| Self {
            valve_amplitude_deg,
            speed_amplitude_fraction,
            dither_fraction,
            ..Self::standard(Variant::Prototype)
        };
        let scheduled = |fuel_schedule: &[[f64; 2]]| Self {
            speed_amplitude_fraction: 0.0,
            fuel_amplitude_fraction: 0.0,
            dither_fraction: 0.0,
            fuel_schedule: fuel_schedule.to_vec(),
            ..Self::standard(Variant::Cogeneration)
        };
        Ok(match (variant, name) {
            (_, "standard") => standard,
            (Variant::Prototype, "steady") => prototype(0.0, 0.0, 0.0),
            (Variant::Prototype, "gentle") => prototype(0.75, 0.005, 0.02),
            (Variant::Prototype, "lively") => prototype(1.5, 0.01, 0.02),
            (Variant::Prototype, "wide") => prototype(2.5, 0.01, 0.02),
            (Variant::Cogeneration, "steady") => scheduled(&[]),
            (Variant::Cogeneration, "load_reduction_igv") => scheduled(LOAD_REDUCTION_IGV),
            (Variant::Cogeneration, "load_reduction_fuel") => scheduled(LOAD_REDUCTION_FUEL),
            _ => {
                return Err(PlantError::UnknownName {
                    what: "profile",
                    expected: Self::names(variant),
                    found: name.to_owned(),
                });
            }
        })
    }

    /// The profile `standard` of a variant, from which a table takes what it leaves out.
    pub fn standard(variant: Variant) -> Self {
        let prototype = Self {
            valve_amplitude_deg: 1.0,
            valve_hold_s: [3.0, 12.0],
            valve_slew_deg_s: 5.0,
            speed_amplitude_fraction: 0.0067,
            speed_hold_s: [4.0, 15.0],
            speed_slew_fraction_s: 0.01,
            fuel_amplitude_fraction: 0.0,
            fuel_hold_s: [20.0, 60.0],
            fuel_slew_fraction_s: 0.005,
            fuel_schedule: Vec::new(),
            dither_fraction: 0.02,
            dither_pole: 0.97,
        };
        match variant {
            Variant::Prototype => prototype,
            Variant::Cogeneration => Self {
                valve_amplitude_deg: 0.0,
                // The grid's frequency: 0.025 Hz of 50 Hz, at most 0.05 Hz a second.
                speed_amplitude_fraction: 0.0005,
                speed_slew_fraction_s: 0.001,
                fuel_amplitude_fraction: 0.03,
                fuel_schedule: STANDARD_SCHEDULE.to_vec(),
                dither_fraction: 0.005,
                ..prototype
            },
        }
    }
}

impl Default for Profile {
    /// `standard` of the prototype.
    fn default() -> Self {
        Self::standard(Variant::Prototype)
    }
}
