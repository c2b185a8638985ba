//! The named noise levels.

use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

use crate::PlantError;
use crate::channels::Quantity;

/// How noisy the sensors are, by name.
///
/// Noise is normal, added to what is measured and not to what the plant receives. `w_ref` is a set
/// value and `LHV` a property of the fuel: neither is ever noisy by a level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum NoiseLevel {
    /// `none`: no noise.
    #[default]
    None,
    /// `low`: 1 % of each signal's deviation.
    Low,
    /// `table8`: the paper's Table 8, read as standard deviations in units of the signal's. (Its
    /// title says variances, its symbol says deviations.)
    Table8,
    /// `table8_variance`: Table 8 read as variances, so that the deviations are the roots.
    Table8Variance,
    /// `tables4_5`: the accuracies of the paper's Tables 4 and 5, read as three standard
    /// deviations: of a signal in its unit, or of its value at the healthy equilibrium.
    Tables4And5,
}

/// What a standard deviation of noise is measured in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoiseScale {
    /// The channel's unit.
    Unit(f64),
    /// The standard deviation of the true signal over the healthy record with the same excitation,
    /// so that a fault changes no sensor. A channel that does not move carries none.
    SignalShare(f64),
    /// The value of the channel at the healthy equilibrium of the design point.
    DesignShare(f64),
}

impl NoiseScale {
    /// No noise.
    pub const NONE: Self = Self::Unit(0.0);
}

impl NoiseLevel {
    /// All levels.
    pub const ALL: [Self; 5] = [
        Self::None,
        Self::Low,
        Self::Table8,
        Self::Table8Variance,
        Self::Tables4And5,
    ];

    /// The names, in the same order.
    pub const NAMES: &[&str] = &["none", "low", "table8", "table8_variance", "tables4_5"];

    /// The name.
    pub fn name(self) -> &'static str {
        Self::NAMES[match self {
            Self::None => 0,
            Self::Low => 1,
            Self::Table8 => 2,
            Self::Table8Variance => 3,
            Self::Tables4And5 => 4,
        }]
    }

    /// Standard deviation of the noise of a quantity.
    ///
    /// Table 8 prints `a_v`, `M_f` and one pressure, mass flow, torque and temperature, which stand
    /// for all of their kind; ambient conditions have none. It has no powers and no speed: a power
    /// is read from a torque and a speed, of which the torque is by far the noisier, so it takes the
    /// torque's; speed is counted from teeth, the most exact measurement on a turbine, so it takes
    /// the smallest of the table, the temperature's (both assumed). Tables 4 and 5 have no powers
    /// either (assumed as for the torque).
    pub fn scale(self, quantity: Quantity) -> NoiseScale {
        match (self, quantity) {
            (Self::None, _) | (_, Quantity::Known | Quantity::Efficiency) => NoiseScale::NONE,
            (Self::Low, _) => NoiseScale::SignalShare(0.01),
            (Self::Table8, _) => NoiseScale::SignalShare(table_8(quantity)),
            (Self::Table8Variance, _) => NoiseScale::SignalShare(table_8(quantity).sqrt()),
            (Self::Tables4And5, _) => match quantity {
                Quantity::AmbientTemperature => NoiseScale::Unit(14.0 / 3.0),
                Quantity::Temperature => NoiseScale::Unit(15.0 / 3.0),
                Quantity::ValveAngle | Quantity::VaneAngle => NoiseScale::Unit(9.0 / 3.0),
                Quantity::Pressure => NoiseScale::DesignShare(0.15 / 3.0),
                Quantity::AmbientPressure
                | Quantity::FuelDemand
                | Quantity::MassFlow
                | Quantity::Torque
                | Quantity::Power
                | Quantity::Speed => NoiseScale::DesignShare(0.10 / 3.0),
                Quantity::Known | Quantity::Efficiency => NoiseScale::NONE,
            },
        }
    }
}

/// The numbers of the paper's Table 8.
fn table_8(quantity: Quantity) -> f64 {
    match quantity {
        Quantity::ValveAngle | Quantity::VaneAngle => 0.1417,
        Quantity::FuelDemand => 0.2623,
        Quantity::Pressure => 0.2497,
        Quantity::MassFlow => 0.2345,
        Quantity::Torque | Quantity::Power => 0.2909,
        Quantity::Temperature | Quantity::Speed => 0.0941,
        Quantity::Known
        | Quantity::Efficiency
        | Quantity::AmbientPressure
        | Quantity::AmbientTemperature => 0.0,
    }
}

impl fmt::Display for NoiseLevel {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

impl FromStr for NoiseLevel {
    type Err = PlantError;

    fn from_str(name: &str) -> Result<Self, PlantError> {
        Self::ALL
            .into_iter()
            .find(|level| level.name() == name)
            .ok_or_else(|| PlantError::UnknownName {
                what: "noise",
                expected: Self::NAMES,
                found: name.to_owned(),
            })
    }
}

impl TryFrom<String> for NoiseLevel {
    type Error = PlantError;

    fn try_from(name: String) -> Result<Self, PlantError> {
        name.parse()
    }
}

impl From<NoiseLevel> for String {
    fn from(level: NoiseLevel) -> Self {
        level.name().to_owned()
    }
}

impl JsonSchema for NoiseLevel {
    fn schema_name() -> Cow<'static, str> {
        "NoiseLevel".into()
    }

    /// Its names.
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"description": "How noisy the sensors are, by name.", "enum": Self::NAMES})
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Channel;

    #[test]
    fn names_come_back() {
        assert_eq!(NoiseLevel::ALL.map(NoiseLevel::name), NoiseLevel::NAMES);
        for level in NoiseLevel::ALL {
            assert_eq!(level.to_string().parse(), Ok(level));
        }
    }

    #[test]
    fn published_table_8_as_variances() {
        for channel in Channel::all() {
            let [first, second] = [NoiseLevel::Table8, NoiseLevel::Table8Variance]
                .map(|level| level.scale(channel.quantity()));
            match (first, second) {
                (NoiseScale::SignalShare(value), NoiseScale::SignalShare(root)) => {
                    assert!((root * root - value).abs() < 1e-15, "{channel}");
                }
                other => assert_eq!(other, (NoiseScale::NONE, NoiseScale::NONE), "{channel}"),
            }
        }
    }

    #[test]
    fn published_tables_4_and_5() {
        let scale = |name: &str| {
            let quantity = Channel::named(name).unwrap().quantity();
            NoiseLevel::Tables4And5.scale(quantity)
        };
        for (name, accuracy) in [("T_a", 14.0), ("a_v", 9.0), ("t3", 15.0), ("t7", 15.0)] {
            assert_eq!(scale(name), NoiseScale::Unit(accuracy / 3.0), "{name}");
        }
        for (name, percent) in [
            ("p_a", 10.0),
            ("M_f", 10.0),
            ("m9", 10.0),
            ("p7", 15.0),
            ("q_c", 10.0),
            ("w_t", 10.0),
            ("N_t", 10.0),
        ] {
            let NoiseScale::DesignShare(share) = scale(name) else {
                panic!("{name}: {:?}", scale(name));
            };
            assert!((share - percent / 300.0).abs() < 1e-15, "{name}");
        }
        assert_eq!(scale("w_ref"), NoiseScale::NONE);
    }
}
