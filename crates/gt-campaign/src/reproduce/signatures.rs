//! Table 9: the signature matrices, computed from the runs.

use gtfdi::core::Dataset;
use gtfdi::fdi::{Feature, IsolatingResiduals, signature};
use gtfdi::plant::{MapSet, SAMPLE_TIME_S};

use super::models::Identified;
use super::records::{
    CASES, Record, Records, SIGNATURE_ONSET_S, SIGNATURE_S, SIGNATURE_SIZES, SIGNATURE_WINDOW_S,
};
use super::tables::Table9;
use crate::error::{CampaignError, During as _};
use crate::parallel;

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
         {SIGNATURE_ONSET_S} s. Columns are then divided by their largest entry. Isolated: the same \
         of a linear combination of the four residuals for each case, which answers most to it and \
         least to the others and to the models' own errors (largest ratio of the energies of the \
         feature), learned on other records with another excitation."
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
    let of =
        |records: &[Record]| parallel::map(records, |record| residuals(residual, &watched, record));
    let (shown, teaching) = (of(&records.signature)?, of(&records.signature_teaching)?);
    let names: Vec<String> = CASES
        .iter()
        .map(|case| format!("case {}", case.number()))
        .collect();
    let columns: Vec<(&str, Feature)> = watched
        .iter()
        .map(|identified| (identified.monitored.tag, watched_feature(identified)))
        .collect();
    let features: Vec<Feature> = columns.iter().map(|(_, feature)| *feature).collect();
    let window = sample(SIGNATURE_WINDOW_S)..shown[0][0].len();
    let what = "signature matrix";
    let matrix = |runs: &[Vec<Vec<f64>>]| {
        let (healthy, faulty) = (&runs[0], faulty(&names, &runs[1..]));
        signature(&faulty, healthy, &columns, SAMPLE_TIME_S, window.clone()).during(what)
    };
    let found = matrix(&shown)?;
    let isolating = IsolatingResiduals::learn(
        &faulty(&names, &teaching[1..]),
        &teaching[0],
        &features,
        SAMPLE_TIME_S,
        window.clone(),
    )
    .during("isolating residuals")?;
    let combined = shown
        .iter()
        .map(|run| isolating.apply(run).during("isolating residuals"))
        .collect::<Result<Vec<_>, _>>()?;
    let isolated = matrix(&combined)?;
    Ok(Table9 {
        map_set: map_set.to_string(),
        diagonal: found.is_diagonal(),
        rows: found.rows,
        columns: found.columns,
        matrix: found.matrix,
        raw: found.raw,
        matrix_isolated: isolated.matrix,
        definition: definition(residual),
    })
}

/// The residuals of each faulty run with its name.
fn faulty<'a>(names: &'a [String], runs: &'a [Vec<Vec<f64>>]) -> Vec<(&'a str, &'a [Vec<f64>])> {
    let names = names.iter().map(String::as_str);
    names.zip(runs.iter().map(Vec::as_slice)).collect()
}

/// The index of the sample at `time_s`.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // small positive constants
fn sample(time_s: f64) -> usize {
    (time_s / SAMPLE_TIME_S).round() as usize
}
