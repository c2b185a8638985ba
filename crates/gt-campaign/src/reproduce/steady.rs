//! Table 3: the trimmed plant beside the paper's steady state.

use gtfdi::plant::{MapSet, PlantParameters, steady_state};

use super::tables::Table3Row;
use crate::error::{CampaignError, During as _};
use crate::paper;

/// All 30 entries, in the paper's order.
pub fn table3() -> Result<Vec<Table3Row>, CampaignError> {
    let what = "steady state of the prototype";
    let point = steady_state(&PlantParameters::for_maps(MapSet::Paper)).during(what)?;
    let variables = point.variables();
    Ok(paper::TABLE3
        .iter()
        .filter_map(|(name, paper)| {
            let (signal, model) = variables.iter().find(|(signal, _)| signal.name == *name)?;
            Some(Table3Row {
                variable: signal.name.clone(),
                unit: signal.unit.clone(),
                paper: *paper,
                model: *model,
                error_percent: 100.0 * (model - paper) / paper,
            })
        })
        .collect())
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_entry_of_table_3_has_its_counterpart() {
        let rows = super::table3().expect("the plant trims");
        let names: Vec<&str> = rows.iter().map(|row| row.variable.as_str()).collect();
        let paper: Vec<&str> = crate::paper::TABLE3.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, paper);
    }
}
