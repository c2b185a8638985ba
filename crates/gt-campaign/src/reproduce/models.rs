//! Tables 5 and 6: a MISO ARX model of order 8 for every monitored output.

use gtfdi::core::Dataset;
use gtfdi::fdi::ResidualGenerator;
use gtfdi::ident::{ArxModel, Validation, ValidationOptions, validate_records};

use super::records::Records;
use super::tables::Table6Row;
use crate::error::{CampaignError, During as _};
use crate::paper::{self, Monitored};
use crate::paper_models;
use crate::parallel;

/// How the table is computed, for whoever reads the numbers.
pub const DEFINITION: &str = "\
SSE = mean square error over the variance of the output, noise-free 600 s records of the +-1.0 deg \
profile. One MISO ARX model an output: 8 lags of the output, lags 1 to 8 of the valve angle, lags \
0 to 8 of the demanded fuel (the governor moves it within the sample, so every output has a direct \
term), means removed, least squares by QR. The three columns are free runs (full simulation from \
the first 8 samples); the one-step-ahead error of the identification record is a column of its \
own, because the paper calls its first column model prediction errors.";

/// The model of one output, with its errors on the three records.
#[derive(Debug)]
pub struct Identified {
    /// What the paper says of the output.
    pub monitored: Monitored,
    /// The model.
    pub model: ArxModel,
    /// Errors on the identification record and the two validation records.
    pub validations: [Validation; 3],
}

impl Identified {
    /// The model of an output from the first of three records, with its errors on all of them.
    pub fn new(monitored: Monitored, data: &[Dataset]) -> Result<Self, CampaignError> {
        let what = format!("ARX model of {}", monitored.tag);
        let model = paper_models::model(monitored.tag, &data[0])?;
        let options = ValidationOptions {
            residual_tests: false,
            ..ValidationOptions::default()
        };
        let score = |index: usize| validate_records(&model, &[&data[index]], options).during(&what);
        let validations = [score(0)?, score(1)?, score(2)?];
        Ok(Self {
            monitored,
            model,
            validations,
        })
    }

    /// Free-run errors on the three records; none where one diverges.
    pub fn simulated(&self) -> [Option<f64>; 3] {
        let fits = self.validations.each_ref();
        fits.map(|validation| validation.outputs[0].sse_simulation)
    }

    /// The output observer with all poles at the paper's place for this output.
    pub fn observer(&self) -> Result<ResidualGenerator, CampaignError> {
        paper_models::observer(self.monitored.tag, &self.model)
    }
}

/// Identifies a model for each of the monitored outputs.
pub fn identify(records: &Records) -> Result<Vec<Identified>, CampaignError> {
    parallel::map(&paper::MONITORED, |monitored| {
        let data = records
            .identification
            .iter()
            .map(|record| record.select(&[monitored.tag]))
            .collect::<Result<Vec<Dataset>, _>>()?;
        Identified::new(*monitored, &data)
    })
}

/// Whether all three errors are within the paper's bounds.
pub fn within(simulated: [Option<f64>; 3], paper: [f64; 3]) -> bool {
    let mut pairs = simulated.iter().zip(paper);
    pairs.all(|(ours, paper)| ours.is_some_and(|ours| ours <= paper))
}

/// The rows of Table 6.
pub fn table6(models: &[Identified]) -> Vec<Table6Row> {
    models
        .iter()
        .map(|identified| {
            let simulated = identified.simulated();
            let paper = identified.monitored.sse;
            let met = within(simulated, paper);
            Table6Row {
                output: identified.monitored.tag.to_owned(),
                label: identified.monitored.label.to_owned(),
                identification: simulated[0],
                validation1: simulated[1],
                validation2: simulated[2],
                identification_prediction: identified.validations[0].outputs[0].sse_prediction,
                paper,
                met,
            }
        })
        .collect()
}
