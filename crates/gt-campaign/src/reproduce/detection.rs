//! Sections 5.3 to 5.6: observers with the paper's poles, fixed thresholds, nominal faults.

use gtfdi::core::Dataset;
use gtfdi::fdi::{Bank, BankRun, FalseAlarmRate, ResidualTest, StatisticKind, ThresholdRule};

use super::models::Identified;
use super::records::{CASES, HEALTHY_RECORDS, HEALTHY_S, ONSET_S, Record, Records};
use super::tables::{DetectionRow, ObserverRow, OutputDelay};
use crate::error::{CampaignError, During as _};
use crate::{paper, parallel};

/// A residual above this multiple of the largest healthy one is an alarm.
pub const MARGIN: f64 = ThresholdRule::DEFAULT_MARGIN;

/// How the thresholds are set, for whoever reads the numbers.
pub fn observers_definition() -> String {
    format!(
        "One output observer a watched output, from its ARX model, all eight poles at the paper's \
         value. The limit on the modulus of the residual is {MARGIN} times the largest one, after \
         the observer has settled, over {HEALTHY_RECORDS} healthy records of {HEALTHY_S} s; an alarm \
         lasts from the first sample above it to the first one back below. \
         False alarms are counted on records that the limit did not see: each of those records \
         against the limit of the others, and one more record; intervals are exact 95 % Poisson \
         intervals, so what so few hours can promise shows in their width."
    )
}

/// How the detection table is computed.
pub fn detection_definition(duration_s: f64) -> String {
    format!(
        "One noise-free run of {duration_s} s a case on the +-1.0 deg profile, run indices apart from \
         all others, ramp from {ONSET_S} s at the paper's 5 % an hour (case 4: 5 s of lag an hour, \
         assumed), inputs as demanded. Delay: from the onset to the first alarm of each observer; \
         a dash is no alarm by the end of the run. One run a case decides no close race: with \
         another seed another residual may come first."
    )
}

/// The bank of the four observers.
pub fn bank(models: &[Identified], records: &Records) -> Result<Bank, CampaignError> {
    let watched: Vec<&Identified> = models
        .iter()
        .filter(|identified| identified.monitored.observer_pole.is_some())
        .collect();
    let tested = parallel::map(&watched, |identified| {
        let tag = identified.monitored.tag;
        let healthy = records.healthy[..HEALTHY_RECORDS]
            .iter()
            .map(|record| record.select(&[tag]))
            .collect::<Result<Vec<Dataset>, _>>()?;
        let rule = ThresholdRule::Margin {
            factor: MARGIN,
            consecutive: 1,
        };
        let generator = identified.observer()?;
        let statistic = StatisticKind::Modulus;
        let test = ResidualTest::calibrate(tag, &[&generator], &healthy, statistic, rule)
            .during(&format!("threshold of {tag}"))?;
        Ok::<_, CampaignError>((generator, test))
    })?;
    let (generators, tests) = tested.into_iter().unzip();
    Bank::new("observers", generators, tests).during("bank of observers")
}

/// The watched outputs' tags.
pub fn tags() -> Vec<&'static str> {
    paper::watched().map(|output| output.tag).collect()
}

/// Runs the bank over a record.
pub fn run(bank: &Bank, record: &Record) -> Result<BankRun, CampaignError> {
    bank.run(&record.select(&tags())?).during(&record.plan.name)
}

/// The rows that describe the observers; `healthy` is the run over the healthy test record.
pub fn observer_rows(
    bank: &Bank,
    models: &[Identified],
    healthy: &BankRun,
) -> Result<Vec<ObserverRow>, CampaignError> {
    bank.tests()
        .iter()
        .zip(models)
        .zip(&healthy.judged)
        .map(|((test, identified), judged)| {
            let alarms = healthy
                .alarms
                .iter()
                .filter(|alarm| alarm.tag == test.name)
                .count();
            // Settling is not judged, here as in the cross-validation.
            let judged_h = *judged as f64 * bank.sample_time_s() / 3600.0;
            let fit = &identified.validations[0].outputs[0];
            Ok(ObserverRow {
                output: test.name.clone(),
                unit: identified.model.outputs()[0].unit.clone(),
                pole: paper::default_pole(identified.monitored.tag),
                paper_reconstruction_error: identified.monitored.reconstruction_error,
                reconstruction_error: fit.sse_simulation,
                limit: test.threshold.limit,
                false_alarms_cross_validated: test.false_alarms.cross_validated,
                false_alarms_test: FalseAlarmRate::from_counts(alarms, judged_h)
                    .during("false alarms of the test record")?,
            })
        })
        .collect()
}

/// The rows of the detection table; `runs` are the bank's runs over `records.faults`.
pub fn detection_rows(records: &Records, runs: &[BankRun]) -> Vec<DetectionRow> {
    let tags = tags();
    let cases = CASES.into_iter().zip(&records.faults).zip(runs).zip(&tags);
    cases
        .map(|(((case, record), run), expected)| {
            let fault = &record.plan.scenario.faults[0];
            let delays_s: Vec<OutputDelay> = tags
                .iter()
                .map(|tag| {
                    let alarm = run
                        .alarms
                        .iter()
                        .find(|alarm| alarm.tag == *tag && alarm.time_s >= ONSET_S);
                    OutputDelay {
                        output: (*tag).to_owned(),
                        delay_s: alarm.map(|alarm| alarm.time_s - ONSET_S),
                        size: alarm.map(|alarm| fault.magnitude(alarm.time_s)),
                    }
                })
                .collect();
            let first = delays_s
                .iter()
                .filter_map(|delay| Some((delay.delay_s?, &delay.output)))
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .map(|(_, output)| output.clone());
            DetectionRow {
                case: case.number(),
                name: case.name().to_owned(),
                onset_s: ONSET_S,
                final_size: fault.magnitude(record.plan.scenario.duration_s),
                unit: fault.unit().to_owned(),
                delays_s,
                first,
                expected: (*expected).to_owned(),
            }
        })
        .collect()
}
