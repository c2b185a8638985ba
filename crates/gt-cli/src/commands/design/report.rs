//! What `gtfdi design` says of a bank.

use std::path::Path;

use gtfdi::fdi::{Bank, FalseAlarmRate, MeanTime, ResidualTest, SUPPORTED_FACTOR, StatisticKind};
use nalgebra::Complex;
use serde::Serialize;

use super::optimisation::{self, OutputReport};
use crate::cli::{GeneratorKind, Statistic};
use crate::output::{number, table};

/// One test of the bank.
#[derive(Serialize)]
pub struct TestReport<'a> {
    /// The test's name: that of the output where it watches one.
    output: &'a str,
    outputs: &'a [String],
    /// Poles of its observer; empty where some are complex, or it reads several generators, or
    /// Kalman filters.
    poles: &'a [f64],
    /// Poles of its observer where some are complex, else empty.
    complex_poles: Vec<Complex<f64>>,
    statistic: &'a StatisticKind,
    /// Order of the autoregression that whitens the residual; null where it is not whitened.
    whitening_order: Option<usize>,
    limit: f64,
    consecutive: usize,
    settle_samples: usize,
    exceedance_share_cross_validated: f64,
    false_alarms_in_sample: FalseAlarmRate,
    false_alarms_cross_validated: FalseAlarmRate,
    /// What the healthy records promise; null unless the limit is by mean time between false
    /// alarms and the statistic has memory.
    mean_time_between_false_alarms: Option<MeanTime>,
}

/// The result of the verb.
#[derive(Serialize)]
pub struct Report<'a> {
    pub schema_version: u32,
    pub generator: GeneratorKind,
    pub statistic: Statistic,
    pub healthy_records: usize,
    /// The channels whose errors the filter does not feel.
    pub unknown: &'a [String],
    pub outputs: Vec<OutputReport<'a>>,
    pub detectors: Vec<TestReport<'a>>,
    pub warnings: Vec<String>,
    pub out: &'a Path,
}

/// The tests of a bank.
pub fn test_reports(bank: &Bank) -> Vec<TestReport<'_>> {
    bank.tests()
        .iter()
        .map(|test| {
            let own = bank.generator_of(test);
            let rates = &test.false_alarms;
            let whitening = test.evaluation.whitening.as_ref();
            TestReport {
                output: &test.name,
                outputs: &test.outputs,
                poles: own.map_or(&[], |generator| generator.poles()),
                complex_poles: own
                    .filter(|generator| generator.poles().is_empty())
                    .map_or_else(Vec::new, gtfdi::fdi::ResidualGenerator::complex_poles),
                statistic: &test.evaluation.statistic,
                whitening_order: whitening.map(gtfdi::fdi::Whitening::order),
                limit: test.threshold.limit,
                consecutive: test.threshold.consecutive,
                settle_samples: bank.settle_samples(test),
                exceedance_share_cross_validated: rates.cross_validated_exceedance_share,
                false_alarms_in_sample: rates.in_sample,
                false_alarms_cross_validated: rates.cross_validated,
                mean_time_between_false_alarms: rates.mean_time,
            }
        })
        .collect()
}

/// What to say of a promise that the healthy records do not support.
pub fn unsupported(test: &ResidualTest) -> Option<String> {
    let mean_time = test.false_alarms.mean_time?;
    if mean_time.supported() {
        return None;
    }
    let found = match (mean_time.hours, mean_time.hours_low, mean_time.hours_high) {
        (Some(hours), Some(low), Some(high)) => format!(
            "they say {} h, 95 % interval {} .. {}",
            number(Some(hours)),
            number(Some(low)),
            number(Some(high))
        ),
        _ => "they are too few to say any, so the limit is that for white residuals".to_owned(),
    };
    Some(format!(
        "`{}`: {} h of healthy running do not support a mean time between false alarms of {} h: \
         {found}; {} h would, to within a factor of {SUPPORTED_FACTOR}",
        test.name,
        number(Some(mean_time.healthy_hours)),
        number(Some(mean_time.asked_hours)),
        number(Some(mean_time.healthy_hours_needed)),
    ))
}

/// The hours between false alarms that healthy records promise, with their interval.
pub fn promised(time: &MeanTime) -> String {
    let interval = || {
        Some(format!(
            "{} ({} .. {})",
            number(Some(time.hours?)),
            number(Some(time.hours_low?)),
            number(Some(time.hours_high?))
        ))
    };
    interval().unwrap_or_else(|| "-".to_owned())
}

/// The result for people.
pub fn text(report: &Report) -> String {
    let rows: Vec<Vec<String>> = report
        .detectors
        .iter()
        .map(|test| {
            let rate = &test.false_alarms_cross_validated;
            let promise = test.mean_time_between_false_alarms;
            vec![
                test.output.to_owned(),
                number(Some(test.limit)),
                test.consecutive.to_string(),
                number(Some(100.0 * test.exceedance_share_cross_validated)),
                format!("{} in {} h", rate.alarms, number(Some(rate.hours))),
                format!(
                    "{} ({} .. {})",
                    number(Some(rate.per_hour)),
                    number(Some(rate.per_hour_low)),
                    number(Some(rate.per_hour_high))
                ),
                promise.map_or_else(|| "-".to_owned(), |time| promised(&time)),
            ]
        })
        .collect();
    let tests = format!(
        "{}: {} tests from {} healthy records; rates are cross-validated, with 95 % intervals\n{}",
        report.out.display(),
        report.detectors.len(),
        report.healthy_records,
        table(
            &[
                "test",
                "limit",
                "in a row",
                "above limit %",
                "false alarms",
                "per hour",
                "hours between, by tail"
            ],
            &rows
        )
    );
    let unknown = match report.unknown {
        [] => String::new(),
        tags => format!("feels no error of {}\n", tags.join(", ")),
    };
    [tests, unknown, optimisation::text(&report.outputs)].concat()
}
