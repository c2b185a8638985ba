//! The source paper's tables and figures again, from seeded runs.

mod cells;
mod cogeneration;
mod contradictions;
mod detection;
mod detection_curves;
mod effects;
mod figures;
mod html;
mod limits;
mod models;
mod noise_models;
mod records;
mod sections;
mod seeds;
mod signatures;
mod steady;
pub mod tables;
mod text;
mod twin;
mod write;

use gtfdi::fdi::{Bank, BankRun};
use gtfdi::plant::{MapSet, PlantParameters, SAMPLE_TIME_S, lag_limit};

use self::models::Identified;
use self::records::{FAULT_RUN_S, HEALTHY_RECORDS, Records};
use self::signatures::Residual;
use self::tables::{SCHEMA_VERSION, Tables};
use crate::error::{CampaignError, During as _};
use crate::parallel;
use crate::progress::Progress;
use crate::report::Figure;

pub use limits::Depth;

/// A finished reproduction: the numbers, and what is needed to write them down.
#[derive(Debug)]
pub struct Reproduction {
    /// All numbers.
    pub tables: Tables,
    /// All figures, in the order of the report.
    pub figures: Vec<Figure>,
    records: Vec<Records>,
    models: Vec<Identified>,
    bank: Bank,
    fault_runs: Vec<BankRun>,
    healthy_run: BankRun,
}

/// Computes the tables: simulates the records, identifies, designs, detects.
///
/// `depth` says how many runs are behind Table 10 and the naming of faults. Everything follows from
/// `seed`; the number of threads does not matter to any number.
///
/// # Errors
/// [`CampaignError`] names the run or the model that failed; [`CampaignError::Stopped`] when
/// progress says so.
pub fn reproduce(
    seed: u64,
    depth: Depth,
    progress: &dyn Progress,
) -> Result<Reproduction, CampaignError> {
    let (table3, table3_notes) = steady::table3()?;
    let map_sets = [MapSet::Paper, MapSet::Axial];
    progress.report("fault effects", 0, 1);
    let effects = parallel::map(&map_sets, |map_set| effects::measure(*map_set, seed))?;
    let names = map_sets.iter().map(ToString::to_string);
    let fault_effects = names.zip(effects).collect();
    let lag_limit = map_sets
        .iter()
        .map(|map_set| {
            let limit = lag_limit(&PlantParameters::for_maps(*map_set)).during("lag limit")?;
            Ok((map_set.to_string(), limit))
        })
        .collect::<Result<_, CampaignError>>()?;
    let records = records::simulate_all(&map_sets, seed, progress)?;
    let models = records
        .iter()
        .map(models::identify)
        .collect::<Result<Vec<_>, _>>()?;

    let (paper_records, paper_models) = (&records[0], &models[0]);
    let bank = detection::bank(paper_models, paper_records)?;
    let healthy_run = detection::run(&bank, &paper_records.healthy[HEALTHY_RECORDS])?;
    let fault_runs = parallel::map(&paper_records.faults, |record| {
        detection::run(&bank, record)
    })?;

    let signature = |residual| {
        map_sets
            .iter()
            .zip(&models)
            .zip(&records)
            .map(|((map_set, models), records)| {
                signatures::table9(*map_set, residual, models, records)
            })
            .collect::<Result<Vec<_>, _>>()
    };
    let load_reductions: Vec<_> = map_sets
        .into_iter()
        .zip(&records)
        .map(|(map_set, records)| (map_set, records.load_reduction.as_slice()))
        .collect();
    let (table7, table8) = noise_models::tables(seed, progress)?;
    let limits = limits::compute(seed, depth, progress)?;
    let mut isolation = limits.isolation.into_iter();
    let tables = Tables {
        schema_version: SCHEMA_VERSION,
        version: env!("CARGO_PKG_VERSION"),
        seed,
        sample_time_s: SAMPLE_TIME_S,
        table3,
        table3_notes,
        fault_effects,
        lag_limit,
        cogeneration: cogeneration::cogeneration(&load_reductions)?,
        table6: models::table6(paper_models),
        table6_definition: models::DEFINITION.to_owned(),
        table6_seeds: seeds::table6(seed, progress)?,
        table7,
        table7_definition: noise_models::TABLE7_DEFINITION,
        table8,
        table8_definition: noise_models::TABLE8_DEFINITION,
        table9: signature(Residual::FreeRun)?,
        table9_observers: signature(Residual::Observer)?,
        observers: detection::observer_rows(&bank, paper_models, &healthy_run)?,
        observers_definition: detection::observers_definition(),
        detection: detection::detection_rows(paper_records, &fault_runs),
        detection_definition: detection::detection_definition(FAULT_RUN_S),
        table10: limits.table10,
        isolation: isolation.next(),
        isolation_others: isolation.collect(),
        table10_definition: limits.definition,
    };
    let mut figures = figures::record_figures(paper_records)?;
    figures.extend(figures::free_run_figures(paper_models, paper_records)?);
    figures.extend(figures::model_figures(paper_models, paper_records)?);
    figures.extend(figures::residual_figures(
        &bank,
        paper_records,
        &healthy_run,
        &fault_runs,
    ));
    figures.extend(limits.figures);
    figures.extend(figures::load_reduction_figures(paper_records));
    let models = models.into_iter().next().unwrap_or_default();
    Ok(Reproduction {
        tables,
        figures,
        records,
        models,
        bank,
        fault_runs,
        healthy_run,
    })
}
