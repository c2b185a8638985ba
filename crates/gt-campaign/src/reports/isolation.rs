//! What an isolator found in a record.

use gtfdi::core::{Dataset, Stop};
use gtfdi::fdi::{
    FdiError, IsolationAlarm, IsolationRun, Isolator, MeanTime, NamedAlarm, NamedHypothesis,
};

use super::clock::Clock;
use super::detection::fold;
use super::provenance::Provenance;
use super::signals::{extent, figure_id, record_figures};
use crate::report::chart::{Chart, Mark, Series};
use crate::report::page::{Cell, Page};
use crate::report::text::digits;
use crate::report::{Document, Figure};

/// Alarms that are shown with all hypotheses; the log has all.
const MOST_DIAGNOSES: usize = 50;

/// The report of an isolator's run over a record: alarms with what explains them, the evidence for
/// each fault over time, the record itself.
///
/// # Errors
/// As [`Isolator::run`]; [`FdiError::Stopped`] where `stop` wants the run to end.
pub fn isolation_report(
    isolator: &Isolator,
    data: &Dataset,
    provenance: &Provenance,
    stop: &dyn Stop,
) -> Result<Document, FdiError> {
    let names = isolator.statistic_names();
    let mut statistics = vec![Vec::with_capacity(data.len()); names.len()];
    let run = isolator.run_until(data, stop, |verdict| {
        for (series, value) in statistics.iter_mut().zip(&verdict.statistics) {
            series.push(if verdict.settling { f64::NAN } else { *value });
        }
    })?;
    let clock = Clock::of(data);
    let alarms: Vec<NamedAlarm> = run
        .alarms
        .iter()
        .map(|alarm| isolator.named_alarm(alarm))
        .collect();
    let lead = format!(
        "Isolator `{}`: {} faults on {}.",
        isolator.name,
        isolator.hypotheses().len(),
        extent(data)
    );
    let mut page = Page::new("Diagnosis", &lead);
    page.facts(&facts(isolator, &alarms, clock));
    provenance.warn(&mut page);
    alarm_section(&mut page, &alarms, clock);
    limits_section(&mut page, isolator, &run);
    page.section("evidence", "Evidence over time");
    page.paragraph(
        "For each fault, and for a change in any direction: the logarithm of the likelihood ratio \
         of that fault, at its likeliest onset, to health. Dashed: its limit. The statistic that \
         leads an alarm says that something has changed; the diagnosis above says what.",
    );
    let marks = marks(&run.alarms, &alarms, clock);
    let evidence = names
        .iter()
        .zip(isolator.limits())
        .zip(statistics)
        .enumerate();
    let mut figures: Vec<Figure> = Vec::new();
    let mut quiet: Vec<Figure> = Vec::new();
    for (place, ((name, limit), values)) in evidence {
        let above = values.iter().any(|value| value > limit);
        let chart = Chart {
            id: figure_id("evidence", place, name),
            title: format!("evidence for {name}"),
            x_label: clock.label(),
            y_label: "log likelihood ratio".to_owned(),
            x: clock.times_s(data),
            series: vec![Series::line("statistic", values)],
            limits: vec![*limit],
            marks: marks.clone(),
            ..Chart::default()
        };
        let figure = Figure::new(chart, format!("Evidence for {name}, with its limit."));
        if above {
            page.figure(&figure);
        } else {
            quiet.push(figure.clone());
        }
        figures.push(figure);
    }
    fold(
        &mut page,
        "Statistics that stay within their limits",
        &quiet,
    );
    page.section("record", "Record");
    let used = data.select(&isolator.inputs(), &isolator.outputs());
    let record = used.map_or_else(|_| Vec::new(), |used| record_figures(&used, clock, &marks));
    fold(
        &mut page,
        "Inputs and outputs that the isolator reads",
        &record,
    );
    figures.extend(record);
    Ok(Document {
        html: provenance.finish(page),
        figures,
    })
}

/// The name that stands, in words.
fn named(alarm: &NamedAlarm) -> String {
    let found = &alarm.diagnosis;
    found.fault.clone().unwrap_or_else(|| {
        match found.finding {
            "none_of_these" => "none of these",
            _ => "not decided",
        }
        .to_owned()
    })
}

/// A value with its interval.
fn interval(value: f64, [low, high]: [f64; 2], unit: &str) -> String {
    let text = format!(
        "{} ({} .. {}) {unit}",
        digits(value, 4),
        digits(low, 3),
        digits(high, 3)
    );
    text.trim_end().to_owned()
}

/// The rate of all statistics together.
fn rate(mean_times: &[MeanTime], hours: fn(&MeanTime) -> Option<f64>) -> String {
    let rates = mean_times.iter().map(|own| Some(1.0 / hours(own)?));
    let sum: Option<f64> = rates.sum();
    sum.map_or_else(|| "-".to_owned(), |own| digits(own, 3))
}

fn facts(isolator: &Isolator, alarms: &[NamedAlarm], clock: Clock) -> Vec<(String, String)> {
    let last = alarms.last();
    let name = last.map_or_else(|| "none".to_owned(), named);
    let since = last.map_or_else(
        || ("-".to_owned(), "first alarm".to_owned()),
        |last| {
            let first = alarms.first().unwrap_or(last);
            (
                format!("{:.2} s", clock.shown_s(first.time_s)),
                "first alarm".to_owned(),
            )
        },
    );
    let times = isolator.mean_times();
    vec![
        (alarms.len().to_string(), "alarms".to_owned()),
        (name, "name of the last alarm".to_owned()),
        since,
        (
            format!(
                "{} ({} .. {})",
                rate(times, |own| own.hours),
                rate(times, |own| own.hours_high),
                rate(times, |own| own.hours_low)
            ),
            "false alarms an hour of all statistics together, from the tails of the healthy \
             records, with a 95 % interval"
                .to_owned(),
        ),
    ]
}

fn alarm_section(page: &mut Page, alarms: &[NamedAlarm], clock: Clock) {
    page.section("alarms", "Alarms");
    if alarms.is_empty() {
        page.paragraph("No alarm.");
        return;
    }
    let time = |time_s: f64| format!("{:.2}", clock.shown_s(time_s));
    for (place, alarm) in alarms.iter().take(MOST_DIAGNOSES).enumerate() {
        let end = alarm.end_s.map_or_else(
            || "open at the end".to_owned(),
            |end| format!("until {} s", time(end)),
        );
        page.heading(&format!(
            "{}. {}: from {} s, {end}",
            place + 1,
            named(alarm),
            time(alarm.time_s)
        ));
        let found = &alarm.diagnosis;
        page.paragraph(&format!(
            "{} led with {} at a limit of {}. Diagnosed last at {} s.",
            alarm.tag,
            digits(alarm.statistic, 4),
            digits(alarm.threshold, 4),
            time(found.diagnosed_s)
        ));
        let mut hypotheses: Vec<&NamedHypothesis> = found.hypotheses.iter().collect();
        hypotheses.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        let mut rows: Vec<Vec<Cell>> = hypotheses
            .into_iter()
            .map(|own| {
                let onsets = own.onset_interval_s.map(|end| clock.shown_s(end));
                vec![
                    Cell::plain(own.fault.clone()),
                    Cell::shaded(digits(100.0 * own.probability, 3), own.probability),
                    Cell::plain(interval(own.magnitude, own.magnitude_interval, &own.unit)),
                    Cell::plain(interval(clock.shown_s(own.onset_s), onsets, "s")),
                ]
            })
            .collect();
        rows.push(vec![
            Cell::plain("none of these"),
            Cell::shaded(digits(100.0 * found.none_of_these, 3), found.none_of_these),
            Cell::plain("-"),
            Cell::plain("-"),
        ]);
        page.table(
            &["explanation", "probability %", "size if it is", "since"],
            &rows,
        );
        if let Some(pair) = &found.pair {
            page.note(&format!(
                "Two at once: {} and {}, probability {} %.",
                pair.faults[0],
                pair.faults[1],
                digits(100.0 * pair.probability, 3)
            ));
        }
    }
    if alarms.len() > MOST_DIAGNOSES {
        page.note(&format!(
            "The first {MOST_DIAGNOSES} of {} alarms.",
            alarms.len()
        ));
    }
    if let Some(note) = clock.note() {
        page.note(&note);
    }
    page.note(
        "Probabilities are given that there is a fault; sizes are at the time of the diagnosis; \
         intervals are 95 %.",
    );
}

fn limits_section(page: &mut Page, isolator: &Isolator, run: &IsolationRun) {
    page.section("limits", "Limits and their promises");
    let limits = isolator.limits().iter().zip(isolator.mean_times());
    let names = isolator.statistic_names().into_iter();
    let rows: Vec<Vec<Cell>> = names
        .zip(limits)
        .enumerate()
        .map(|(place, (name, (limit, time)))| {
            let led = run.alarms.iter().filter(|alarm| alarm.leading == place);
            let optional =
                |own: Option<f64>| own.map_or_else(|| "-".to_owned(), |own| digits(own, 3));
            let cells = [
                name.to_owned(),
                digits(*limit, 4),
                led.count().to_string(),
                digits(time.asked_hours, 3),
                format!(
                    "{} ({} .. {})",
                    optional(time.hours),
                    optional(time.hours_low),
                    optional(time.hours_high)
                ),
                format!(
                    "{} of {}",
                    digits(time.healthy_hours, 3),
                    digits(time.healthy_hours_needed, 3)
                ),
            ];
            cells.into_iter().map(Cell::plain).collect()
        })
        .collect();
    page.table(
        &[
            "statistic",
            "limit",
            "alarms it led",
            "asked hours between false alarms",
            "found, 95 % interval",
            "healthy hours given of needed",
        ],
        &rows,
    );
    page.note(&format!("{} samples were judged.", run.judged));
}

/// The lines of alarms and of the onsets of what they are named.
fn marks(alarms: &[IsolationAlarm], named_alarms: &[NamedAlarm], clock: Clock) -> Vec<Mark> {
    let mut marks: Vec<Mark> = Vec::new();
    for (alarm, words) in alarms.iter().zip(named_alarms) {
        marks.push(Mark {
            at: clock.shown_s(alarm.time_s),
            label: "alarm".to_owned(),
        });
        if let Some(onset_s) = words.diagnosis.onset_s {
            marks.push(Mark {
                at: clock.shown_s(onset_s),
                label: format!("onset, {}", named(words)),
            });
        }
    }
    marks.sort_by(|a, b| a.at.total_cmp(&b.at));
    marks
}
