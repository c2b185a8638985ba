//! Table 3: the trimmed plant beside the paper's steady state.

use gtfdi::plant::{MapSet, PlantParameters, steady_state};

use super::contradictions::CONTRADICTIONS;
use super::tables::{Origin, Table3Notes, Table3Row};
use crate::error::{CampaignError, During as _};
use crate::paper;

/// What the plant reports as `e_c`.
const E_C_DEFINITION: &str = "\
e_c: isentropic enthalpy rise from ambient (p_a, T_a) to p3 over the specific work P_c / m3, with \
real heat capacities. The map's own isentropic efficiency, between stations 2 and 3, stands beside \
it.";

/// Where the model's value of an entry comes from.
fn origin(variable: &str) -> Origin {
    match variable {
        "m3" | "m4" | "m5" | "m6" | "m8" | "m9" | "m10" => Origin::Reconciled,
        "t7" | "q_c" | "q_t" | "P_c" | "P_t" | "e_t" => Origin::Check,
        "e_c" => Origin::Defined,
        _ => Origin::Calibrated,
    }
}

/// All 30 entries, in the paper's order, and what a reader of them must know.
pub fn table3() -> Result<(Vec<Table3Row>, Table3Notes), CampaignError> {
    let what = "steady state of the prototype";
    let point = steady_state(&PlantParameters::for_maps(MapSet::Paper)).during(what)?;
    let variables = point.variables();
    let rows: Vec<Table3Row> = paper::TABLE3
        .iter()
        .filter_map(|(name, paper)| {
            let (signal, model) = variables.iter().find(|(signal, _)| signal.name == *name)?;
            Some(Table3Row {
                variable: signal.name.clone(),
                unit: signal.unit.clone(),
                paper: *paper,
                model: *model,
                error_percent: 100.0 * (model - paper) / paper,
                origin: origin(name),
            })
        })
        .collect();
    let mean = |rows: &[&Table3Row]| {
        let sum: f64 = rows.iter().map(|row| row.error_percent.abs()).sum();
        sum / rows.len() as f64
    };
    let largest = rows
        .iter()
        .max_by(|a, b| a.error_percent.abs().total_cmp(&b.error_percent.abs()));
    let open: Vec<&Table3Row> = rows
        .iter()
        .filter(|row| row.origin != Origin::Calibrated)
        .collect();
    let notes = Table3Notes {
        mean_absolute_error_percent: mean(&rows.iter().collect::<Vec<_>>()),
        mean_absolute_error_not_calibrated_percent: mean(&open),
        largest_error_percent: largest.map_or(f64::NAN, |row| row.error_percent),
        largest_error_variable: largest.map_or_else(String::new, |row| row.variable.clone()),
        e_c_definition: E_C_DEFINITION,
        map_isentropic_efficiency: point.point.compression.efficiency,
        contradictions: CONTRADICTIONS.to_vec(),
    };
    Ok((rows, notes))
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_entry_of_table_3_has_its_counterpart() {
        let (rows, _) = super::table3().expect("the plant trims");
        let names: Vec<&str> = rows.iter().map(|row| row.variable.as_str()).collect();
        let paper: Vec<&str> = crate::paper::TABLE3.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, paper);
    }
}
