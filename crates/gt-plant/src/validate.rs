//! What parameters are physically possible.

use crate::components::governor::Governor;
use crate::{PlantError, PlantParameters};

/// What a value must be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Rule {
    Positive,
    NotNegative,
    Finite,
    /// Above 0 and at most 1.
    Efficiency,
    /// Above 1.
    AboveOne,
    /// Above 0 and at most 90.
    Angle,
}

impl Rule {
    fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Positive => value > 0.0,
                Self::NotNegative => value >= 0.0,
                Self::Finite => true,
                Self::Efficiency => value > 0.0 && value <= 1.0,
                Self::AboveOne => value > 1.0,
                Self::Angle => value > 0.0 && value <= 90.0,
            }
    }

    fn expected(self) -> &'static str {
        match self {
            Self::Positive => "a finite number above 0",
            Self::NotNegative => "a finite number of at least 0",
            Self::Finite => "a finite number",
            Self::Efficiency => "a number above 0 and at most 1",
            Self::AboveOne => "a finite number above 1",
            Self::Angle => "a number above 0 and at most 90",
        }
    }
}

/// Name, value and rule of fields of a struct, grouped by rule.
macro_rules! numbers {
    ($of:expr; $($rule:ident { $($first:ident $(. $rest:ident)*),+ $(,)? })+) => {
        [$($((
            concat!(stringify!($first) $(, ".", stringify!($rest))*),
            $of.$first $(.$rest)*,
            Rule::$rule,
        )),+),+]
    };
}

impl PlantParameters {
    /// Refuses what is physically impossible.
    ///
    /// # Errors
    /// [`PlantError::Parameter`] with the first impossible value.
    pub fn validate(&self) -> Result<(), PlantError> {
        let pressures = self
            .design
            .pressures_pa
            .map(|p| ("design.pressures_pa", p, Rule::Positive));
        for (name, found, rule) in self.numbers().into_iter().chain(pressures) {
            if !rule.holds(found) {
                return Err(PlantError::Parameter {
                    name,
                    expected: rule.expected(),
                    found,
                });
            }
        }
        let Governor {
            design_fuel_kg_s,
            minimum_fuel_kg_s,
            maximum_fuel_kg_s,
            ..
        } = self.governor;
        if minimum_fuel_kg_s > design_fuel_kg_s {
            return Err(PlantError::Parameter {
                name: "governor.minimum_fuel_kg_s",
                expected: "at most governor.design_fuel_kg_s",
                found: minimum_fuel_kg_s,
            });
        }
        if maximum_fuel_kg_s < design_fuel_kg_s {
            return Err(PlantError::Parameter {
                name: "governor.maximum_fuel_kg_s",
                expected: "at least governor.design_fuel_kg_s",
                found: maximum_fuel_kg_s,
            });
        }
        Ok(())
    }

    /// All numbers but the pressures of the design point.
    fn numbers(&self) -> [(&'static str, f64, Rule); 54] {
        numbers! { self;
            Positive {
                design.ambient_pa,
                design.ambient_k,
                design.speed_rad_s,
                design.intake_flow_kg_s,
                design.combustor_flow_kg_s,
                design.exhaust_flow_kg_s,
                intake.duct.inertance_per_m,
                intake.plenum.volume_m3,
                intake.plenum_temperature_ratio,
                intake.inlet_temperature_ratio,
                compressor.design_flow_kg_s,
                compressor.design_corrected_speed,
                compressor.exit_temperature_ratio,
                compressor_exit.volume_m3,
                diffuser.inertance_per_m,
                combustor_inlet.volume_m3,
                liner.inertance_per_m,
                combustor.effective_heating_value_j_kg,
                combustor_exit.volume_m3,
                turbine.flow_constant,
                turbine.design_velocity_ratio,
                exhaust.turbine_exit.volume_m3,
                exhaust.duct_volume.volume_m3,
                exhaust.duct.inertance_per_m,
                valve.full_area_m2,
                shaft.inertia_kg_m2,
                governor.integral_gain,
                governor.design_fuel_kg_s,
                governor.maximum_fuel_kg_s,
                actuator.shortest_lag_s,
            }
            NotNegative {
                intake.duct.loss_pa_s2_kg2,
                intake.inlet_loss_pa_s2_kg2,
                compressor.pressure_exponent,
                compressor.flow_exponent,
                compressor.line_slope,
                compressor.efficiency_speed_curvature,
                compressor.efficiency_pressure_curvature,
                diffuser.loss_pa_s2_kg2,
                turbine_bleed.flow_function,
                exhaust_bleed.flow_function,
                liner.loss_pa_s2_kg2,
                turbine.efficiency_curvature,
                exhaust.duct.loss_pa_s2_kg2,
                shaft.loss_n_m_s2,
                governor.proportional_gain,
                governor.minimum_fuel_kg_s,
            }
            Finite { intake.duct.head_pa, diffuser.head_pa, liner.head_pa, exhaust.duct.head_pa }
            Efficiency { compressor.design_efficiency, turbine.design_efficiency }
            AboveOne { compressor.design_pressure_ratio }
            Angle { design.valve_deg }
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;
    use crate::MapSet;

    /// Pointers (`/intake/duct/head_pa`) to all numbers of a tree.
    fn leaves(tree: &Value, path: &str, found: &mut Vec<String>) {
        match tree {
            Value::Object(fields) => {
                fields
                    .iter()
                    .for_each(|(name, of)| leaves(of, &format!("{path}/{name}"), found));
            }
            Value::Array(items) => {
                items
                    .iter()
                    .enumerate()
                    .for_each(|(i, of)| leaves(of, &format!("{path}/{i}"), found));
            }
            _ => found.push(path.to_owned()),
        }
    }

    #[test]
    fn every_number_but_a_head_must_not_be_negative() {
        let tree = serde_json::to_value(PlantParameters::for_maps(MapSet::Paper)).unwrap();
        let mut paths = Vec::new();
        leaves(&tree, "", &mut paths);
        assert_eq!(paths.len(), 60, "54 numbers and 6 pressures: {paths:?}");
        for path in paths.iter().filter(|path| !path.ends_with("head_pa")) {
            let mut changed = tree.clone();
            *changed.pointer_mut(path).unwrap() = Value::from(-1.0);
            let parameters: PlantParameters = serde_json::from_value(changed).unwrap();
            let Err(PlantError::Parameter { name, found, .. }) = parameters.validate() else {
                panic!("{path} = -1 was accepted");
            };
            assert!(
                path.replace('/', ".")[1..].starts_with(name),
                "{path}: {name}"
            );
            assert_eq!(found.to_bits(), (-1.0f64).to_bits());
        }
    }

    #[test]
    fn impossible_values_are_named() {
        let mut parameters = PlantParameters::for_maps(MapSet::Axial);
        assert_eq!(parameters.validate(), Ok(()));
        parameters.turbine.design_efficiency = 1.2;
        assert_eq!(
            parameters.validate().unwrap_err().to_string(),
            "plant parameter turbine.design_efficiency: expected a number above 0 and at most 1, \
             found 1.2"
        );
        parameters = PlantParameters::for_maps(MapSet::Paper);
        parameters.exhaust.duct.head_pa = f64::NAN;
        assert_eq!(
            parameters.validate().unwrap_err().to_string(),
            "plant parameter exhaust.duct.head_pa: expected a finite number, found NaN"
        );
        parameters = PlantParameters::for_maps(MapSet::Paper);
        parameters.governor.maximum_fuel_kg_s = 0.2;
        assert_eq!(
            parameters.validate().unwrap_err().to_string(),
            "plant parameter governor.maximum_fuel_kg_s: expected at least \
             governor.design_fuel_kg_s, found 0.2"
        );
    }
}
