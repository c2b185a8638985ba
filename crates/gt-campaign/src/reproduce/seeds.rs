//! Table 6 for many seeds: how much of it is luck.

use gtfdi::core::Dataset;
use gtfdi::plant::{MapSet, PlantParameters, Profile, Scenario, Variant};

use super::models::{Identified, within};
use super::records::{IDENTIFICATION_PROFILE, IDENTIFICATION_S, SIGNATURE_PROFILE};
use super::tables::{Table6Seeds, WorstRow};
use crate::error::{CampaignError, During as _};
use crate::progress::{Progress, report_or_stop};
use crate::{paper, parallel};

/// Seeds that are looked at, from that of the run on.
const SEEDS: u64 = 10;
/// Records of a seed: identification, first and second validation, by their run indices.
const RECORDS: usize = 3;

/// How the table is computed, for whoever reads the numbers.
const DEFINITION: &str = "\
The models and errors of Table 6 again, each seed with its own identification record and two \
validation records of 600 s. Worst: the largest free-run SSE of any seed; met: seeds with which \
all three errors are within the paper's bounds.";

/// Table 6 with each profile, over the seeds from `seed` on.
pub fn table6(seed: u64, progress: &dyn Progress) -> Result<Vec<Table6Seeds>, CampaignError> {
    let seeds: Vec<u64> = (0..SEEDS).map(|step| seed.wrapping_add(step)).collect();
    let mut tables = Vec::new();
    for (done, profile) in [IDENTIFICATION_PROFILE, SIGNATURE_PROFILE]
        .iter()
        .enumerate()
    {
        report_or_stop(progress, "Table 6 for many seeds", done, 2)?;
        tables.push(with_profile(profile, &seeds)?);
    }
    progress.report("Table 6 for many seeds", 2, 2);
    Ok(tables)
}

fn with_profile(profile: &str, seeds: &[u64]) -> Result<Table6Seeds, CampaignError> {
    let what = format!("Table 6 with the profile {profile}");
    let excitation = Profile::named(Variant::Prototype, profile).during(&what)?;
    let scenarios: Vec<Scenario> = seeds
        .iter()
        .flat_map(|&seed| (0..RECORDS as u64).map(move |run_index| (seed, run_index)))
        .map(|(seed, run_index)| Scenario {
            duration_s: IDENTIFICATION_S,
            profile: excitation.clone(),
            seed,
            run_index,
            ..Scenario::default()
        })
        .collect();
    let plant = PlantParameters::for_maps(MapSet::Paper);
    let runs = parallel::simulate(&plant, &scenarios, |_| what.clone(), |_, run| Ok(run))?;
    let rows = parallel::map(&paper::MONITORED, |monitored| {
        let mut errors = Vec::with_capacity(seeds.len());
        for records in runs.chunks(RECORDS) {
            let data = records
                .iter()
                .map(|run| run.measured.select(&paper::INPUTS, &[monitored.tag]))
                .collect::<Result<Vec<Dataset>, _>>()
                .during(&what)?;
            errors.push(Identified::new(*monitored, &data)?.simulated());
        }
        let met = errors
            .iter()
            .filter(|&&errors| within(errors, monitored.sse))
            .count();
        Ok::<_, CampaignError>(WorstRow {
            output: monitored.tag.to_owned(),
            label: monitored.label.to_owned(),
            identification: worst(errors.iter().map(|errors| errors[0])),
            validation1: worst(errors.iter().map(|errors| errors[1])),
            validation2: worst(errors.iter().map(|errors| errors[2])),
            paper: monitored.sse,
            met,
        })
    })?;
    Ok(Table6Seeds {
        profile: profile.to_owned(),
        valve_amplitude_deg: excitation.valve_amplitude_deg,
        seeds: seeds.to_vec(),
        rows,
        definition: DEFINITION.to_owned(),
    })
}

/// The largest error; none where one free run diverges.
pub(super) fn worst(errors: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    errors
        .reduce(|worst, error| Some(worst?.max(error?)))
        .flatten()
}
