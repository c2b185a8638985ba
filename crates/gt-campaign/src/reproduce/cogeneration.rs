//! Section 3.1: load reduction of the machine on the mains (figures 4 to 6 of the paper).

use std::fmt::Write as _;

use gtfdi::plant::trim::{Hold, trim};
use gtfdi::plant::{FaultSizes, Inputs, MapSet, PlantParameters, Variant};
use serde::Serialize;

use super::records::{LOAD_REDUCTION_S, LOAD_REDUCTIONS, Record};
use crate::error::{CampaignError, During as _};

/// Fuel of the steady loads, percent of design fuel.
const LOADS_PERCENT: [f64; 9] = [100.0, 95.0, 90.0, 85.0, 80.0, 75.0, 70.0, 65.0, 60.0];
/// When the fuel of both manoeuvres has reached its end, s.
pub const FUEL_HELD_S: f64 = 80.0;
/// When it begins to fall, s.
pub const FUEL_FALLS_S: f64 = 20.0;
/// Band around its last value in which a temperature has settled, K.
const BAND_K: f64 = 0.5;
/// The same for other signals, as a share of the change from first to last value.
const BAND_FRACTION: f64 = 0.01;
/// Vanes this close to their stop stand at it; the positioner approaches it only in the limit.
const CLOSED_WITHIN_DEG: f64 = 0.01;
/// What is shown of a manoeuvre: fuel, guide vanes, exhaust as read and as it is, electric power.
pub const SIGNALS: [&str; 5] = ["M_f", "IGV", "T_ot", "t7", "P_e"];

/// The machine of section 3.1: steady loads and the two load reductions.
#[derive(Debug, Clone, Serialize)]
pub struct Cogeneration {
    /// How everything here is defined.
    pub definition: String,
    /// What of the paper cannot be compared.
    pub not_comparable: &'static str,
    /// Equilibria at falling fuel.
    pub steady: Vec<Load>,
    /// The two manoeuvres, a map set after the other.
    pub manoeuvres: Vec<Manoeuvre>,
}

/// An equilibrium on the mains.
#[derive(Debug, Clone, Serialize)]
pub struct Load {
    /// The plant's maps.
    pub map_set: String,
    /// Share of design fuel.
    pub fuel_percent: f64,
    /// Fuel flow.
    pub fuel_flow_kg_s: f64,
    /// Guide vanes, from fully open.
    pub guide_vane_deg: f64,
    /// Turbine outlet.
    pub t7_k: f64,
    /// Turbine inlet.
    pub t5_k: f64,
    /// Compressor flow.
    pub m3_kg_s: f64,
    /// Electric power at the terminals.
    pub electric_power_w: f64,
}

/// A load reduction.
#[derive(Debug, Clone, Serialize)]
pub struct Manoeuvre {
    /// The plant's maps.
    pub map_set: String,
    /// The profile, and the name of its figures.
    pub profile: String,
    /// What the controller of the guide vanes holds.
    pub set_point_k: f64,
    /// Largest deviation of the thermocouple's reading `T_ot` from the set point, with its sign.
    pub largest_deviation_k: f64,
    /// When it occurs.
    pub largest_deviation_time_s: f64,
    /// Whether the vanes stand at their closed stop throughout and hold nothing.
    pub vanes_closed: bool,
    /// The signals.
    pub signals: Vec<Transition>,
}

/// A signal of a load reduction.
#[derive(Debug, Clone, Serialize)]
pub struct Transition {
    /// Its name.
    pub signal: String,
    /// Its unit.
    pub unit: String,
    /// First value.
    pub initial: f64,
    /// Last value.
    pub last: f64,
    /// Change in percent of the first value; null for an angle, whose zero is a convention.
    pub change_percent: Option<f64>,
    /// Standard deviation over the record: the scale of the paper's figures 4 to 6.
    pub standard_deviation: f64,
    /// Half width of the band around the last value that counts as settled.
    pub settling_band: f64,
    /// From the end of the fuel's fall until the signal stays in that band; zero where it is there
    /// already.
    pub settles_after_s: f64,
}

/// What of the paper cannot be compared.
const NOT_COMPARABLE: &str = "\
Figures 4 to 6 of the paper divide each signal by its own standard deviation and print no absolute \
number of that machine, its fuel schedule, its guide vanes or its controller; its mean-square \
differences (1.1 % for P_e, 0.4 % for T_ot) are between its simulation and measurements that are \
not published. So only the course can be compared: fuel and power fall together while closing vanes \
hold the outlet temperature, and once the vanes stand at their closed stop the temperature falls \
with the fuel.";

/// Equilibria and manoeuvres; `records` are the load reductions of each map set.
pub fn cogeneration(records: &[(MapSet, &[Record])]) -> Result<Cogeneration, CampaignError> {
    let mut steady = Vec::new();
    let mut manoeuvres = Vec::new();
    for (map_set, records) in records {
        steady.extend(loads(*map_set)?);
        for (record, profile) in records.iter().zip(LOAD_REDUCTIONS) {
            manoeuvres.push(manoeuvre(*map_set, profile, record));
        }
    }
    Ok(Cogeneration {
        definition: definition(),
        not_comparable: NOT_COMPARABLE,
        steady,
        manoeuvres,
    })
}

fn definition() -> String {
    format!(
        "Noise-free runs of {LOAD_REDUCTION_S} s on the mains, which hold the speed; the \
         pressurising valve stands open. The fuel is held for {FUEL_FALLS_S} s, falls until \
         {FUEL_HELD_S} s and is held again: from 98 to 84 % of design fuel while a PID controller \
         closes the guide vanes to hold the turbine outlet temperature (load_reduction_igv), from \
         70 to 60 % with the vanes at their closed stop (load_reduction_fuel). IGV counts from \
         fully open; T_ot is the reading of a thermocouple with a lag of 1 s, t7 the gas itself. \
         Settling: from {FUEL_HELD_S} s until a signal stays within {BAND_K} K (temperatures) or \
         {:.0} % of its own change (others) of its last value. Loads, vanes, generator and \
         controller are assumed; so is the set point, close to the exhaust temperature at design \
         fuel with open vanes.",
        100.0 * BAND_FRACTION
    )
}

fn loads(map_set: MapSet) -> Result<Vec<Load>, CampaignError> {
    let plant = PlantParameters::new(Variant::Cogeneration, map_set);
    let design_kg_s = plant.governor.design_fuel_kg_s;
    LOADS_PERCENT
        .iter()
        .map(|percent| {
            let what = format!("cogeneration, {map_set} maps, {percent} % fuel");
            let inputs = Inputs {
                fuel_offset_kg_s: design_kg_s * (percent / 100.0 - 1.0),
                ..Inputs::design(&plant)
            };
            let point = trim(&plant, &inputs, &FaultSizes::HEALTHY, Hold::Control).during(&what)?;
            let value = |name| point.value(name).unwrap_or(f64::NAN);
            Ok(Load {
                map_set: map_set.to_string(),
                fuel_percent: *percent,
                fuel_flow_kg_s: design_kg_s + inputs.fuel_offset_kg_s,
                guide_vane_deg: point.state.guide_vane_deg,
                t7_k: value("t7"),
                t5_k: value("t5"),
                m3_kg_s: value("m3"),
                electric_power_w: value("P_e"),
            })
        })
        .collect()
}

fn manoeuvre(map_set: MapSet, profile: &str, record: &Record) -> Manoeuvre {
    let plant = record.plan.scenario.parameters();
    let set_point_k = plant.guide_vanes.set_point_k;
    let signals = SIGNALS
        .iter()
        .filter_map(|name| record.signal(name))
        .map(|(signal, values)| transition(record, &signal.name, &signal.unit, &values))
        .collect();
    let closed_deg = plant.guide_vanes.closed_deg;
    let vanes_closed = record.signal("IGV").is_some_and(|(_, values)| {
        values
            .iter()
            .all(|angle| closed_deg - angle <= CLOSED_WITHIN_DEG)
    });
    let reading = record.signal("T_ot").map(|(_, values)| values);
    let (at, largest_deviation_k) = reading
        .unwrap_or_default()
        .iter()
        .map(|value| value - set_point_k)
        .enumerate()
        .fold((0, 0.0), |worst: (usize, f64), (k, deviation)| {
            if deviation.abs() > worst.1.abs() {
                (k, deviation)
            } else {
                worst
            }
        });
    Manoeuvre {
        map_set: map_set.to_string(),
        profile: profile.to_owned(),
        set_point_k,
        largest_deviation_k,
        largest_deviation_time_s: record.run.truth.time_s(at),
        vanes_closed,
        signals,
    }
}

fn transition(record: &Record, signal: &str, unit: &str, values: &[f64]) -> Transition {
    let (initial, last) = match values {
        [initial, .., last] => (*initial, *last),
        _ => (f64::NAN, f64::NAN),
    };
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values
        .iter()
        .map(|value| (value - mean).powi(2))
        .sum::<f64>()
        / count;
    let band = if unit == "K" {
        BAND_K
    } else {
        BAND_FRACTION * (last - initial).abs()
    };
    let outside = values.iter().rposition(|value| (value - last).abs() > band);
    let settled_s = outside.map_or(0.0, |k| record.run.truth.time_s(k + 1));
    Transition {
        signal: signal.to_owned(),
        unit: unit.to_owned(),
        initial,
        last,
        change_percent: (unit != "deg").then(|| 100.0 * (last - initial) / initial),
        standard_deviation: variance.sqrt(),
        settling_band: band,
        settles_after_s: (settled_s - FUEL_HELD_S).max(0.0),
    }
}

impl Cogeneration {
    /// The steady loads as CSV.
    pub(super) fn steady_csv(&self) -> String {
        let mut text = String::from(
            "map_set,fuel_percent,fuel_flow_kg_s,guide_vane_deg,t7_k,t5_k,m3_kg_s,electric_power_w\n",
        );
        for load in &self.steady {
            let _ = writeln!(
                text,
                "{},{},{},{},{},{},{},{}",
                load.map_set,
                load.fuel_percent,
                load.fuel_flow_kg_s,
                load.guide_vane_deg,
                load.t7_k,
                load.t5_k,
                load.m3_kg_s,
                load.electric_power_w
            );
        }
        text
    }
}
