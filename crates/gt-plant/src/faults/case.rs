//! The four fault cases of section 3.2 of the paper.

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::PlantError;

/// The fault cases of the paper.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema,
)]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_back() {
        for (index, case) in FaultCase::ALL.into_iter().enumerate() {
            assert_eq!(case.number(), index + 1);
            assert_eq!(case.name().parse(), Ok(case));
        }
    }
}
