//! The figures: records, free runs, residuals with their thresholds.

use gtfdi::fdi::{Bank, BankRun};
use gtfdi::ident::parameter_covariance;

use super::cogeneration::{FUEL_FALLS_S, FUEL_HELD_S};
use super::models::Identified;
use super::records::{CASES, LOAD_REDUCTIONS, ONSET_S, Record, Records};
use crate::error::{CampaignError, During as _};
use crate::paper;
use crate::report::Figure;
use crate::report::chart::{Chart, Mark, Series};
use crate::reports::{Certainty, pole_figures, response_figures};

fn times(record: &Record) -> Vec<f64> {
    (0..record.run.measured.len())
        .map(|k| record.run.measured.time_s(k))
        .collect()
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
                series: vec![Series::line(&signal.name, values.iter().copied().collect())],
                ..Chart::default()
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
                        Series::line("plant", data.y().iter().copied().collect()),
                        Series::dashed("free run", run.y.iter().copied().collect()),
                    ],
                    ..Chart::default()
                },
                caption: format!("Full simulation of {tag} from its first samples, no feedback."),
            })
        })
        .collect()
}

/// Poles, zeros and frequency responses of each model, with the errors that the identification
/// record gives them.
pub fn model_figures(
    models: &[Identified],
    records: &Records,
) -> Result<Vec<Figure>, CampaignError> {
    let record = &records.identification[0];
    let mut figures = Vec::new();
    for identified in models {
        let (tag, model) = (identified.monitored.tag, &identified.model);
        let what = format!("poles and responses of {tag}");
        let data = record.select(&[tag])?;
        let covariances = parameter_covariance(model, &data).during(&what)?;
        let certainty = Certainty::of(model, Some(&covariances));
        figures.extend(pole_figures(model, &certainty).during(&what)?);
        figures.extend(response_figures(model, &certainty).during(&what)?);
    }
    Ok(figures)
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
            let test = bank.tests().get(index)?;
            let tag = &test.name;
            let unit = &bank.generators().get(index)?.outputs()[0].unit;
            let mut marks = vec![Mark {
                at: ONSET_S,
                label: "onset".into(),
            }];
            if let Some(alarm) = run
                .alarms
                .iter()
                .find(|alarm| alarm.tag == *tag && alarm.time_s >= ONSET_S)
            {
                marks.push(Mark {
                    at: alarm.time_s,
                    label: format!("alarm at {:.0} s", alarm.time_s),
                });
            }
            // The start is the observer settling, which no threshold judges.
            let settled = bank.settle_samples(test);
            let judged = |run: &BankRun| {
                let row = run.residuals.row(index);
                row.iter()
                    .enumerate()
                    .map(|(k, value)| if k < settled { f64::NAN } else { *value })
                    .collect::<Vec<f64>>()
            };
            let limit = test.threshold.limit;
            Some(Figure {
                chart: Chart {
                    id: format!("residual_case{}", case.number()),
                    title: format!("case {}: residual of {tag}", case.number()),
                    x_label: "time [s]".into(),
                    y_label: format!("residual [{unit}]"),
                    x: times(record),
                    series: vec![
                        Series::line("with fault", judged(run)),
                        Series::line("healthy test record", judged(healthy)),
                    ],
                    limits: vec![-limit, limit],
                    marks,
                    ..Chart::default()
                },
                caption: format!(
                    "Observer residual of {tag} with {} at its nominal rate; dashed: threshold.",
                    case.name().replace('_', " ")
                ),
            })
        })
        .collect()
}

/// Fuel flow, guide vanes, turbine outlet temperature and electric power of both load reductions
/// (figures 4 to 6 of the paper, in absolute units).
pub fn load_reduction_figures(records: &Records) -> Vec<Figure> {
    let signals = [
        ("T_ot", "turbine outlet temperature"),
        ("M_f", "fuel flow"),
        ("P_e", "electric power"),
        ("IGV", "guide vanes, from fully open"),
    ];
    let manoeuvres = records.load_reduction.iter().zip(LOAD_REDUCTIONS);
    manoeuvres
        .flat_map(|(record, profile)| {
            signals
                .iter()
                .filter_map(move |(name, what)| load_reduction_figure(record, profile, name, what))
        })
        .collect()
}

fn load_reduction_figure(record: &Record, profile: &str, name: &str, what: &str) -> Option<Figure> {
    let (signal, values) = record.signal(name)?;
    let (unit, scale) = match signal.unit.as_str() {
        "W" => ("kW", 1e-3),
        unit => (unit, 1.0),
    };
    let scaled = |values: Vec<f64>| values.iter().map(|value| value * scale).collect();
    let mut curves = vec![Series::line(name, scaled(values))];
    let mut limits = vec![];
    let mut caption = format!("{name}, {what}, {}.", profile.replace('_', " "));
    if name == "T_ot" {
        let (_, gas) = record.signal("t7")?;
        curves.push(Series::dashed("t7 (gas)", gas));
        // Far from the set point the line would only flatten the curves.
        if profile == "load_reduction_igv" {
            let set_point_k = record.plan.scenario.parameters().guide_vanes.set_point_k;
            limits.push(set_point_k);
            caption = format!(
                "{name}, {what} as the thermocouple reads it, and the gas itself; dashed line: \
                 set point."
            );
        }
    }
    Some(Figure {
        chart: Chart {
            id: format!("{profile}_{name}"),
            title: format!("{name}: {what}, {}", profile.replace('_', " ")),
            x_label: "time [s]".into(),
            y_label: format!("{name} [{unit}]"),
            x: times(record),
            series: curves,
            limits,
            marks: [(FUEL_FALLS_S, "fuel falls"), (FUEL_HELD_S, "fuel held")]
                .map(|(at, label)| Mark {
                    at,
                    label: label.into(),
                })
                .to_vec(),
            ..Chart::default()
        },
        caption,
    })
}
