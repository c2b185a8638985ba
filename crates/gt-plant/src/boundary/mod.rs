//! Boundary conditions: the courses of ambient temperature, ambient pressure and lower heating
//! value over a run.

mod course;
mod fluctuation;

pub(crate) use course::CourseValues;
pub use course::{Course, Sine};
pub use fluctuation::Fluctuation;
pub(crate) use fluctuation::OrnsteinUhlenbeck;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::PlantError;
use crate::params::DesignPoint;

/// The boundary conditions of a run, as deviations from design; constant over each sample. Left
/// out, they are those of design.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Boundary {
    /// Ambient temperature `T_a`, K; it stays between 233 and 333 K.
    pub temperature_k: Course,
    /// Ambient pressure `p_a`, Pa; it stays between 80 and 110 kPa.
    pub pressure_pa: Course,
    /// Lower heating value, share of the design value; it stays between 0.8 and 1.2.
    pub heating_value_fraction: Course,
}

impl Boundary {
    /// Whether anything moves during a run; an offset does not.
    pub fn moves(&self) -> bool {
        self.temperature_k.moves()
            || self.pressure_pa.moves()
            || self.heating_value_fraction.moves()
    }

    /// Refuses courses that make no sense or that leave their limits within a run of `duration_s`
    /// seconds around the design conditions. A course counts with its whole sine and five standard
    /// deviations of its fluctuation, one in two million independent values lies further out; a
    /// course that is zero throughout is not checked, whatever the design conditions.
    ///
    /// # Errors
    /// [`PlantError::Scenario`] with the first such number.
    pub fn validate(&self, design: &DesignPoint, duration_s: f64) -> Result<(), PlantError> {
        for (course, what, value, limits, expected) in [
            (
                &self.temperature_k,
                "boundary.temperature_k",
                design.ambient_k,
                [233.0, 333.0],
                "between 233 and 333 K throughout, 5 standard deviations included",
            ),
            (
                &self.pressure_pa,
                "boundary.pressure_pa",
                design.ambient_pa,
                [80e3, 110e3],
                "between 80000 and 110000 Pa throughout, 5 standard deviations included",
            ),
            (
                &self.heating_value_fraction,
                "boundary.heating_value_fraction",
                1.0,
                [0.8, 1.2],
                "between 0.8 and 1.2 throughout, 5 standard deviations included",
            ),
        ] {
            course.validate(what)?;
            course.validate_around(value, duration_s, what, limits, expected)?;
        }
        Ok(())
    }
}
