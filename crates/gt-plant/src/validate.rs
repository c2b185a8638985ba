//! What parameters are physically possible.

use crate::components::governor::Governor;
use crate::maps::{CompressorMap, MapKind, TurbineMap};
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

/// Name, value and rule of fields of a struct, grouped by rule; names begin with the prefix.
macro_rules! numbers {
    ($prefix:literal, $of:expr; $($rule:ident { $($first:ident $(. $rest:ident)*),+ $(,)? })+) => {
        [$($((
            concat!($prefix, stringify!($first) $(, ".", stringify!($rest))*),
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
        for (name, found, rule) in self
            .numbers()
            .into_iter()
            .chain(pressures)
            .chain(map_numbers(self))
        {
            if !rule.holds(found) {
                return Err(PlantError::Parameter {
                    name,
                    expected: rule.expected(),
                    found,
                });
            }
        }
        let kinds = [
            (
                "compressor",
                self.compressor.map.kind(),
                MapKind::Compressor,
            ),
            ("turbine", self.turbine.map.kind(), MapKind::Turbine),
        ];
        for (component, found, expected) in kinds {
            if found != expected {
                return Err(PlantError::MapOfOther { component, found });
            }
        }
        self.check_ranges()?;
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

    /// Refuses ranges of maps that are upside down, and vanes that would stop the flow.
    fn check_ranges(&self) -> Result<(), PlantError> {
        let mut ranges = Vec::new();
        if let CompressorMap::Analytic(map) = &self.compressor.map {
            ranges.push(("compressor.map.analytic.range.speed", map.range.speed));
            ranges.push(("compressor.map.analytic.range.load", map.range.load));
        }
        if let TurbineMap::Analytic(map) = &self.turbine.map {
            ranges.push(("turbine.map.analytic.range.speed", map.range.speed));
            ranges.push(("turbine.map.analytic.range.load", map.range.load));
        }
        for (name, [low, high]) in ranges {
            if low >= high {
                return Err(PlantError::Parameter {
                    name,
                    expected: "a lower end below the upper one",
                    found: low,
                });
            }
        }
        let vanes = &self.guide_vanes;
        let closed = vanes.effect(vanes.closed_deg);
        let effects = [
            (
                "guide_vanes.flow_loss_per_deg",
                vanes.flow_loss_per_deg,
                closed.flow,
            ),
            (
                "guide_vanes.pressure_loss_per_deg",
                vanes.pressure_loss_per_deg,
                closed.pressure_rise,
            ),
            (
                "guide_vanes.efficiency_loss_per_deg2",
                vanes.efficiency_loss_per_deg2,
                closed.efficiency,
            ),
        ];
        for (name, found, left) in effects {
            if left <= 0.0 {
                return Err(PlantError::Parameter {
                    name,
                    expected: "a loss that leaves something at the closed stop",
                    found,
                });
            }
        }
        Ok(())
    }

    /// All numbers but the pressures of the design point and those of the maps.
    fn numbers(&self) -> [(&'static str, f64, Rule); 64] {
        numbers! { "", self;
            Positive {
                design.ambient_pa,
                design.ambient_k,
                design.heating_value_j_kg,
                design.speed_rad_s,
                design.intake_flow_kg_s,
                design.combustor_flow_kg_s,
                design.exhaust_flow_kg_s,
                intake.duct.inertance_per_m,
                intake.plenum.volume_m3,
                intake.plenum_temperature_ratio,
                intake.inlet_temperature_ratio,
                compressor.design_corrected_speed,
                compressor.exit_temperature_ratio,
                compressor_exit.volume_m3,
                diffuser.inertance_per_m,
                combustor_inlet.volume_m3,
                liner.inertance_per_m,
                combustor_exit.volume_m3,
                turbine.design_corrected_speed,
                exhaust.turbine_exit.volume_m3,
                exhaust.duct_volume.volume_m3,
                exhaust.duct.inertance_per_m,
                valve.full_area_m2,
                shaft.inertia_kg_m2,
                governor.integral_gain,
                governor.tracking_s,
                governor.design_fuel_kg_s,
                governor.maximum_fuel_kg_s,
                actuator.shortest_lag_s,
                generator.pull_out_power_w,
                generator.electrical_ratio,
                guide_vanes.set_point_k,
                guide_vanes.integral_deg_k_s,
                guide_vanes.thermocouple_s,
                guide_vanes.tracking_s,
                guide_vanes.positioner_s,
                guide_vanes.slew_deg_s,
            }
            NotNegative {
                intake.duct.loss_pa_s2_kg2,
                intake.inlet_loss_pa_s2_kg2,
                diffuser.loss_pa_s2_kg2,
                turbine_bleed.flow_function,
                exhaust_bleed.flow_function,
                liner.loss_pa_s2_kg2,
                exhaust.duct.loss_pa_s2_kg2,
                shaft.loss_n_m_s2,
                governor.proportional_gain,
                governor.minimum_fuel_kg_s,
                generator.damping_n_m_s,
                generator.inertia_kg_m2,
                generator.no_load_loss_w,
                generator.copper_loss_per_w,
                guide_vanes.flow_loss_per_deg,
                guide_vanes.pressure_loss_per_deg,
                guide_vanes.efficiency_loss_per_deg2,
                guide_vanes.proportional_deg_k,
                guide_vanes.derivative_deg_s_k,
            }
            Finite { intake.duct.head_pa, diffuser.head_pa, liner.head_pa, exhaust.duct.head_pa }
            Efficiency { combustor.efficiency, intake.measured_leg_share }
            Angle { design.valve_deg, guide_vanes.closed_deg }
        }
    }
}

/// The numbers of analytic maps; tables are checked when they are made.
fn map_numbers(plant: &PlantParameters) -> Vec<(&'static str, f64, Rule)> {
    let mut found = Vec::new();
    if let CompressorMap::Analytic(map) = &plant.compressor.map {
        found.extend(numbers! { "compressor.map.analytic.", map;
            Positive { design_flow_kg_s }
            AboveOne { design_pressure_ratio }
            Efficiency { design_efficiency }
            NotNegative {
                pressure_exponent,
                flow_exponent,
                line_slope,
                efficiency_speed_curvature,
                efficiency_pressure_curvature,
            }
        });
        let [low, high] = map.range.speed;
        found.push(("compressor.map.analytic.range.speed", low, Rule::Positive));
        found.push(("compressor.map.analytic.range.speed", high, Rule::Positive));
        let [low, high] = map.range.load;
        found.push(("compressor.map.analytic.range.load", low, Rule::Positive));
        found.push(("compressor.map.analytic.range.load", high, Rule::Positive));
    }
    if let TurbineMap::Analytic(map) = &plant.turbine.map {
        found.extend(numbers! { "turbine.map.analytic.", map;
            Positive { flow_constant, design_velocity_ratio }
            Efficiency { design_efficiency }
            NotNegative { efficiency_curvature }
        });
        let [low, high] = map.range.speed;
        found.push(("turbine.map.analytic.range.speed", low, Rule::Positive));
        found.push(("turbine.map.analytic.range.speed", high, Rule::Positive));
        let [low, high] = map.range.load;
        found.push(("turbine.map.analytic.range.load", low, Rule::AboveOne));
        found.push(("turbine.map.analytic.range.load", high, Rule::AboveOne));
    }
    found
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
            Value::Number(_) => found.push(path.to_owned()),
            _ => {}
        }
    }

    #[test]
    fn every_number_but_a_head_must_not_be_negative() {
        let tree = serde_json::to_value(PlantParameters::for_maps(MapSet::Paper)).unwrap();
        let mut paths = Vec::new();
        leaves(&tree, "", &mut paths);
        assert_eq!(paths.len(), 90, "70 numbers, 6 pressures, 14 of maps");
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
        if let TurbineMap::Analytic(map) = &mut parameters.turbine.map {
            map.design_efficiency = 1.2;
        }
        assert_eq!(
            parameters.validate().unwrap_err().to_string(),
            "plant parameter turbine.map.analytic.design_efficiency: expected a number above 0 and at most 1, \
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
