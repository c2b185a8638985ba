//! The paper's own scheme beside ours: observers with fixed poles, fixed thresholds, no averaging.

use gtfdi::core::Dataset;
use gtfdi::fdi::{Bank, ResidualTest, StatisticKind, ThresholdRule};

use super::limit::Watcher;
use super::setting::Setting;
use crate::error::{CampaignError, During as _};
use crate::paper;
use crate::paper_models;

/// One output observer a watched output, each with a limit on the modulus of its residual.
#[derive(Debug, Clone)]
pub struct PaperScheme {
    bank: Bank,
}

impl PaperScheme {
    /// What it is, for whoever reads the numbers.
    pub const DEFINITION: &'static str = "The paper's scheme: for each watched output an ARX model \
        of order 8 from the same record, an observer with all poles at the paper's value, and as \
        limit on the modulus of each sample of the residual the largest in the same healthy \
        hours, which is kinder to it than one false alarm in 24 h.";

    /// Models from the training record, limits from the healthy ones.
    ///
    /// # Errors
    /// [`CampaignError`] when an identification or a design fails.
    pub(super) fn new(
        setting: &Setting,
        training: &Dataset,
        healthy: &[Dataset],
    ) -> Result<Self, CampaignError> {
        let inputs = setting.inputs();
        let one = |data: &Dataset, tag: &str| data.select(&inputs, &[tag]).during(tag);
        let mut generators = Vec::new();
        let mut tests = Vec::new();
        for monitored in paper::watched() {
            let tag = monitored.tag;
            let model = paper_models::model(tag, &one(training, tag)?)?;
            let generator = paper_models::observer(tag, &model)?;
            let healthy = healthy
                .iter()
                .map(|data| one(data, tag))
                .collect::<Result<Vec<_>, _>>()?;
            let rule = ThresholdRule::Margin {
                factor: 1.0,
                consecutive: 1,
            };
            let statistic = StatisticKind::Modulus;
            let test = ResidualTest::calibrate(tag, &[&generator], &healthy, statistic, rule);
            tests.push(test.during(tag)?);
            generators.push(generator);
        }
        let bank = Bank::new("paper's scheme", generators, tests).during("paper's scheme")?;
        Ok(Self { bank })
    }
}

impl Watcher for PaperScheme {
    fn ratios(&self, record: &Dataset) -> Result<Vec<f64>, CampaignError> {
        let run = self.bank.run(record).during("paper's scheme")?;
        let limits: Vec<f64> = self
            .bank
            .tests()
            .iter()
            .map(|test| test.threshold.limit)
            .collect();
        let samples = run.statistics.column_iter();
        Ok(samples
            .map(|column| {
                let statistics = column.iter().zip(&limits);
                // Not a number where nothing is judged, which max leaves out.
                statistics
                    .map(|(own, limit)| own / limit)
                    .fold(0.0, f64::max)
            })
            .collect())
    }
}
