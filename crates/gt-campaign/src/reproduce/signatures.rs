//! Table 9: the signature matrices, computed from the runs.

use gtfdi::core::Dataset;
use gtfdi::fdi::{Feature, signature};
use gtfdi::plant::{MapSet, SAMPLE_TIME_S};
use rayon::prelude::*;

use super::models::Identified;
use super::records::{
    CASES, Record, Records, SIGNATURE_ONSET_S, SIGNATURE_S, SIGNATURE_SIZES, SIGNATURE_WINDOW_S,
};
use super::tables::Table9;
use crate::error::{CampaignError, During as _};

/// Window of the moving mean in seconds.
const MEAN_S: f64 = 8.0;

/// Which residual a signature is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Residual {
    /// Output minus the model's free run.
    FreeRun,
    /// The observer with the paper's poles.
    Observer,
}

/// The feature of a watched output: slow for torque, temperature and pressure, fast for the mass
/// flow, because a lagging actuator has no steady effect.
fn watched_feature(identified: &Identified) -> Feature {
    match identified.monitored.tag {
        "m9" => Feature::HighPass { window_s: MEAN_S },
        _ => Feature::MovingMean { window_s: MEAN_S },
    }
}

fn definition(residual: Residual) -> String {
    let [flow, sensor, efficiency, lag] = SIGNATURE_SIZES;
    let residual = match residual {
        Residual::FreeRun => "output minus the free run of its ARX model",
        Residual::Observer => "observer with all eight poles at the paper's value",
    };
    format!(
        "Residual: {residual}. Entry (i, j): root mean square over {SIGNATURE_WINDOW_S} to \
         {SIGNATURE_S} s of feature_j with fault i minus feature_j without, one noise-free record \
         of the +-1.5 deg profile that the models did not see, the same excitation for all. \
         Features: {MEAN_S} s moving mean for q_c, t3, p7; m9 minus its {MEAN_S} s moving mean. \
         Sizes: {flow} % flow loss, {sensor} % of the thermocouple's reading, {efficiency} % of \
         the turbine's efficiency, {lag} s of lag, each reached within a second of \
         {SIGNATURE_ONSET_S} s. Columns are then divided by their largest entry."
    )
}

/// The residuals of one record, a series a watched output.
fn residuals(
    residual: Residual,
    models: &[&Identified],
    record: &Record,
) -> Result<Vec<Vec<f64>>, CampaignError> {
    let what = format!("{}, signature", record.plan.name);
    models
        .iter()
        .map(|identified| {
            let data: Dataset = record.select(&[identified.monitored.tag])?;
            match residual {
                Residual::FreeRun => {
                    let run = identified.model.simulate(&data).during(&what)?;
                    Ok(data
                        .y()
                        .iter()
                        .zip(run.y.iter())
                        .map(|(y, run)| y - run)
                        .collect())
                }
                Residual::Observer => {
                    let residual = identified.observer()?.residuals(&data).during(&what)?;
                    Ok(residual.iter().copied().collect())
                }
            }
        })
        .collect()
}

/// The signature matrix of one map set.
pub fn table9(
    map_set: MapSet,
    residual: Residual,
    models: &[Identified],
    records: &Records,
) -> Result<Table9, CampaignError> {
    let watched: Vec<&Identified> = models
        .iter()
        .filter(|identified| identified.monitored.observer_pole.is_some())
        .collect();
    let all = records
        .signature
        .par_iter()
        .map(|record| residuals(residual, &watched, record))
        .collect::<Result<Vec<_>, _>>()?;
    let names: Vec<String> = CASES
        .iter()
        .map(|case| format!("case {}", case.number()))
        .collect();
    let faulty: Vec<(&str, &[Vec<f64>])> = names
        .iter()
        .map(String::as_str)
        .zip(all[1..].iter().map(Vec::as_slice))
        .collect();
    let columns: Vec<(&str, Feature)> = watched
        .iter()
        .map(|identified| (identified.monitored.tag, watched_feature(identified)))
        .collect();
    let window = sample(SIGNATURE_WINDOW_S)..all[0][0].len();
    let found =
        signature(&faulty, &all[0], &columns, SAMPLE_TIME_S, window).during("signature matrix")?;
    Ok(Table9 {
        map_set: map_set.to_string(),
        diagonal: found.is_diagonal(),
        rows: found.rows,
        columns: found.columns,
        matrix: found.matrix,
        raw: found.raw,
        definition: definition(residual),
    })
}

/// The index of the sample at `time_s`.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // small positive constants
fn sample(time_s: f64) -> usize {
    (time_s / SAMPLE_TIME_S).round() as usize
}
