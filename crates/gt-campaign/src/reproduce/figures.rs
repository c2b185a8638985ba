//! The figures: records, free runs, residuals with their thresholds.

use gtfdi::fdi::{Bank, BankRun};

use super::models::Identified;
use super::records::{CASES, ONSET_S, Record, Records};
use crate::error::{CampaignError, During as _};
use crate::paper;
use crate::report::chart::{Chart, Mark, Series};

/// A chart with the sentence beneath it.
#[derive(Debug, Clone)]
pub struct Figure {
    /// The drawing.
    pub chart: Chart,
    /// What it shows.
    pub caption: String,
}

fn times(record: &Record) -> Vec<f64> {
    (0..record.run.measured.len())
        .map(|k| record.run.measured.time_s(k))
        .collect()
}

fn series(label: &str, values: Vec<f64>, dashed: bool) -> Series {
    Series {
        label: label.to_owned(),
        values,
        dashed,
    }
}

/// Inputs and watched outputs of the identification record (figures 9 and 10 of the paper).
pub fn record_figures(records: &Records) -> Result<Vec<Figure>, CampaignError> {
    let record = &records.identification[0];
    let tags: Vec<&str> = paper::watched().map(|output| output.tag).collect();
    let data = record.select(&tags)?;
    let signals = data.inputs().iter().zip(data.u().row_iter());
    let signals = signals.chain(data.outputs().iter().zip(data.y().row_iter()));
    Ok(signals
        .map(|(signal, values)| Figure {
            chart: Chart {
                id: format!("record_{}", signal.name),
                title: format!("{}, identification record", signal.name),
                x_label: "time [s]".into(),
                y_label: format!("{} [{}]", signal.name, signal.unit),
                x: times(record),
                series: vec![series(
                    &signal.name,
                    values.iter().copied().collect(),
                    false,
                )],
                limits: vec![],
                marks: vec![],
            },
            caption: format!("{} of the identification record.", signal.name),
        })
        .collect())
}

/// Plant and free run of each model on the first validation record.
pub fn free_run_figures(
    models: &[Identified],
    records: &Records,
) -> Result<Vec<Figure>, CampaignError> {
    let record = &records.identification[1];
    models
        .iter()
        .map(|identified| {
            let tag = identified.monitored.tag;
            let data = record.select(&[tag])?;
            let run = identified
                .model
                .simulate(&data)
                .during(&format!("free run of {tag}"))?;
            let unit = &data.outputs()[0].unit;
            Ok(Figure {
                chart: Chart {
                    id: format!("free_run_{tag}"),
                    title: format!("{tag}: plant and free run, first validation record"),
                    x_label: "time [s]".into(),
                    y_label: format!("{tag} [{unit}]"),
                    x: times(record),
                    series: vec![
                        series("plant", data.y().iter().copied().collect(), false),
                        series("free run", run.y.iter().copied().collect(), true),
                    ],
                    limits: vec![],
                    marks: vec![],
                },
                caption: format!("Full simulation of {tag} from its first samples, no feedback."),
            })
        })
        .collect()
}

/// The residual that the paper watches for each case, healthy and faulty, with its threshold
/// (figures 13, 17 and 19 of the paper).
pub fn residual_figures(
    bank: &Bank,
    records: &Records,
    healthy: &BankRun,
    faulty: &[BankRun],
) -> Vec<Figure> {
    let cases = CASES.into_iter().zip(&records.faults).zip(faulty);
    cases
        .enumerate()
        .filter_map(|(index, ((case, record), run))| {
            let detector = bank.detectors().get(index)?;
            let tag = detector.name();
            let unit = &detector.generator.output().unit;
            let mut marks = vec![Mark {
                at: ONSET_S,
                label: "onset".into(),
            }];
            if let Some(alarm) = run
                .alarms
                .iter()
                .find(|alarm| alarm.tag == tag && alarm.time_s >= ONSET_S)
            {
                marks.push(Mark {
                    at: alarm.time_s,
                    label: format!("alarm at {:.0} s", alarm.time_s),
                });
            }
            // The start is the observer settling, which no threshold judges.
            let settled = detector.generator.settle_samples();
            let judged = |run: &BankRun| {
                let row = run.residuals.row(index);
                row.iter()
                    .enumerate()
                    .map(|(k, value)| if k < settled { f64::NAN } else { *value })
                    .collect::<Vec<f64>>()
            };
            let limit = detector.threshold.limit;
            Some(Figure {
                chart: Chart {
                    id: format!("residual_case{}", case.number()),
                    title: format!("case {}: residual of {tag}", case.number()),
                    x_label: "time [s]".into(),
                    y_label: format!("residual [{unit}]"),
                    x: times(record),
                    series: vec![
                        series("with fault", judged(run), false),
                        series("healthy test record", judged(healthy), false),
                    ],
                    limits: vec![-limit, limit],
                    marks,
                },
                caption: format!(
                    "Observer residual of {tag} with {} at its nominal rate; dashed: threshold.",
                    case.name().replace('_', " ")
                ),
            })
        })
        .collect()
}
