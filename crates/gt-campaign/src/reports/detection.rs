//! What a bank found in a record.

use gtfdi::core::Dataset;
use gtfdi::fdi::{
    Alarm, Bank, BankRun, FalseAlarmRate, ResidualGenerator, ResidualTest, StatisticKind,
};

use super::clock::Clock;
use super::provenance::Provenance;
use super::signals::{axis_label, extent, figure_id, record_figures, row};
use super::statistic::words;
use crate::report::chart::{Chart, Mark, Series};
use crate::report::page::{Cell, Page};
use crate::report::text::digits;
use crate::report::{Document, Figure};

/// Charts of a test that are shown open: its statistic and the first residuals.
const OPEN: usize = 5;
/// Rows of the table of alarms; the log has all.
const MOST_ALARMS: usize = 200;

/// The report of a bank's run over a record: alarms, tests with their promises, residuals and
/// statistics with their limits, the record itself.
pub fn detection_report(
    bank: &Bank,
    data: &Dataset,
    run: &BankRun,
    provenance: &Provenance,
) -> Document {
    let clock = Clock::of(data);
    let lead = format!(
        "Bank `{}`: {} tests on {}.",
        bank.name,
        bank.tests().len(),
        extent(data)
    );
    let mut page = Page::new("Detection", &lead);
    page.facts(&facts(bank, run, clock));
    provenance.warn(&mut page);
    alarms(&mut page, run, clock);
    tests(&mut page, bank, run);
    let mut figures = Vec::new();
    page.section("evidence", "Residuals and statistics");
    page.paragraph(
        "Dashed: limits. An alarm is marked where it came up, and the onset that the statistic finds \
         likeliest where it finds one. Samples that were not judged, because a generator settles \
         after the start or after a missing sample, leave a gap in the statistic.",
    );
    let mut quiet = Vec::new();
    for (place, test) in bank.tests().iter().enumerate() {
        let own = test_figures(bank, data, run, clock, place, test);
        if run.alarms.iter().any(|alarm| alarm.tag == test.name) {
            let (open, more) = own.split_at(own.len().min(OPEN));
            for figure in open {
                page.figure(figure);
            }
            fold(&mut page, &format!("More residuals of {}", test.name), more);
        } else {
            quiet.extend(own.iter().cloned());
        }
        figures.extend(own);
    }
    fold(&mut page, "Tests without an alarm", &quiet);
    page.section("record", "Record");
    let used = data.select(&bank.inputs(), &bank.outputs());
    let record = used.map_or_else(
        |_| Vec::new(),
        |used| record_figures(&used, clock, &marks(run.alarms.iter(), clock)),
    );
    fold(&mut page, "Inputs and outputs that the bank reads", &record);
    figures.extend(record);
    Document {
        html: provenance.finish(page),
        figures,
    }
}

/// Charts that the reader may open.
pub(super) fn fold(page: &mut Page, summary: &str, figures: &[Figure]) {
    if figures.is_empty() {
        return;
    }
    let summary = format!("{summary} ({} charts)", figures.len());
    page.fold(&summary, false, |page| {
        for figure in figures {
            page.figure(figure);
        }
    });
}

/// A rate of false alarms with its interval.
fn rate(rate: &FalseAlarmRate) -> String {
    format!(
        "{} ({} .. {})",
        digits(rate.per_hour, 3),
        digits(rate.per_hour_low, 3),
        digits(rate.per_hour_high, 3)
    )
}

fn facts(bank: &Bank, run: &BankRun, clock: Clock) -> Vec<(String, String)> {
    let open = run.alarms.iter().filter(|alarm| alarm.end_s.is_none());
    let mut tags: Vec<&str> = run.alarms.iter().map(|alarm| alarm.tag.as_str()).collect();
    tags.sort_unstable();
    tags.dedup();
    let first = run.alarms.first().map_or_else(
        || ("none".to_owned(), "first alarm".to_owned()),
        |alarm| {
            (
                format!("{:.2} s", clock.shown_s(alarm.time_s)),
                format!("first alarm, {}", alarm.tag),
            )
        },
    );
    vec![
        (
            run.alarms.len().to_string(),
            format!("alarms, {} of them open at the end", open.count()),
        ),
        first,
        (
            format!("{} of {}", tags.len(), bank.tests().len()),
            "tests with an alarm".to_owned(),
        ),
        (
            rate(&bank.false_alarms()),
            "false alarms an hour of all tests on healthy records, cross-validated, with the 95 % \
             interval"
                .to_owned(),
        ),
    ]
}

fn alarms(page: &mut Page, run: &BankRun, clock: Clock) {
    page.section("alarms", "Alarms");
    if run.alarms.is_empty() {
        page.paragraph("No alarm.");
        return;
    }
    let time = |time_s: f64| format!("{:.2}", clock.shown_s(time_s));
    let optional = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |own| digits(own, 4));
    let rows: Vec<Vec<Cell>> = run
        .alarms
        .iter()
        .take(MOST_ALARMS)
        .map(|alarm| {
            let cells = [
                alarm.tag.clone(),
                time(alarm.time_s),
                time(alarm.first_exceedance_s),
                alarm.onset_s.map_or_else(|| "-".to_owned(), time),
                alarm.end_s.map_or_else(|| "open".to_owned(), time),
                digits(alarm.statistic, 4),
                digits(alarm.threshold, 4),
                optional(alarm.deviation),
            ];
            cells.into_iter().map(Cell::plain).collect()
        })
        .collect();
    page.table(
        &[
            "test",
            "alarm s",
            "above limit from s",
            "likeliest onset s",
            "until s",
            "statistic",
            "limit",
            "deviation of the residual",
        ],
        &rows,
    );
    if run.alarms.len() > MOST_ALARMS {
        page.note(&format!(
            "The first {MOST_ALARMS} of {} alarms.",
            run.alarms.len()
        ));
    }
    if let Some(note) = clock.note() {
        page.note(&note);
    }
}

fn tests(page: &mut Page, bank: &Bank, run: &BankRun) {
    page.section("tests", "Tests and their promises");
    let judged = run.judged.iter().zip(&run.share_above_limit);
    let rows: Vec<Vec<Cell>> = bank
        .tests()
        .iter()
        .zip(judged)
        .map(|(test, (judged, share))| {
            let mean_time = test.false_alarms.mean_time;
            let hours = mean_time.and_then(|own| {
                let (low, high) = (own.hours_low?, own.hours_high);
                let high = high.map_or_else(|| "-".to_owned(), |own| digits(own, 3));
                Some(format!(
                    "{} ({} .. {high})",
                    digits(own.hours?, 3),
                    digits(low, 3)
                ))
            });
            let cells = [
                test.name.clone(),
                words(&test.evaluation.statistic),
                digits(test.threshold.limit, 4),
                test.threshold.consecutive.to_string(),
                judged.to_string(),
                digits(100.0 * share, 3),
                rate(&test.false_alarms.cross_validated),
                hours.unwrap_or_else(|| "-".to_owned()),
            ];
            cells.into_iter().map(Cell::plain).collect()
        })
        .collect();
    page.table(
        &[
            "test",
            "statistic",
            "limit",
            "in a row",
            "judged samples",
            "above limit %",
            "false alarms an hour",
            "hours between false alarms",
        ],
        &rows,
    );
    page.note(
        "False alarms an hour: counted on healthy records by limits that the other healthy records \
         set, with the exact 95 % Poisson interval. Hours between false alarms: extrapolated from \
         the peaks of the statistic on the healthy records, with a 95 % interval, for limits that \
         were set by a mean time.",
    );
}

/// The lines of alarms and of their onsets.
fn marks<'a>(alarms: impl Iterator<Item = &'a Alarm>, clock: Clock) -> Vec<Mark> {
    let mut marks = Vec::new();
    for alarm in alarms {
        if let Some(onset_s) = alarm.onset_s {
            marks.push(Mark {
                at: clock.shown_s(onset_s),
                label: "onset".to_owned(),
            });
        }
        marks.push(Mark {
            at: clock.shown_s(alarm.time_s),
            label: format!("alarm {}", alarm.tag),
        });
    }
    marks.sort_by(|a, b| a.at.total_cmp(&b.at));
    marks
}

/// The statistic of a test and its residuals; no statistic where it is the modulus of one residual,
/// whose chart then has the limits.
fn test_figures(
    bank: &Bank,
    data: &Dataset,
    run: &BankRun,
    clock: Clock,
    place: usize,
    test: &ResidualTest,
) -> Vec<Figure> {
    let own = run.alarms.iter().filter(|alarm| alarm.tag == test.name);
    let marks = marks(own, clock);
    let limit = test.threshold.limit;
    let statistic = words(&test.evaluation.statistic);
    let x = clock.times_s(data);
    // Only a modulus without a whitening is on the residual's own scale.
    let plain = test.evaluation.whitening.is_none()
        && matches!(test.evaluation.statistic, StatisticKind::Modulus);
    let settle = bank.settle_samples(test);
    let one = plain && test.outputs.len() == 1;
    let residuals = run
        .outputs
        .iter()
        .enumerate()
        .filter(|(_, tag)| test.outputs.contains(tag))
        .enumerate()
        .map(|(number, (output, tag))| {
            let mut values = row(&run.residuals, output);
            // The start is the generator settling, which would flatten all that follows.
            let settling = settle.min(values.len());
            values[..settling].fill(f64::NAN);
            let signals = bank
                .generators()
                .iter()
                .flat_map(ResidualGenerator::outputs);
            let unit = signals.into_iter().find(|own| own.name == *tag);
            let unit = unit.map_or("", |own| own.unit.as_str());
            let chart = Chart {
                id: figure_id(&format!("residual_{:02}", place + 1), number, tag),
                title: format!("residual of {tag}"),
                x_label: clock.label(),
                y_label: axis_label("residual", unit),
                x: x.clone(),
                series: vec![Series::line(format!("residual of {tag}"), values)],
                limits: if one { vec![-limit, limit] } else { vec![] },
                marks: marks.clone(),
                ..Chart::default()
            };
            let caption = format!("Residual of {tag}: measured less expected.");
            Figure::new(chart, caption)
        });
    let mut figures = Vec::new();
    if !one {
        let chart = Chart {
            id: figure_id("statistic", place, &test.name),
            title: format!("{}: {statistic}", test.name),
            x_label: clock.label(),
            y_label: "statistic".to_owned(),
            x: x.clone(),
            series: vec![Series::line("statistic", row(&run.statistics, place))],
            limits: vec![limit],
            marks: marks.clone(),
            ..Chart::default()
        };
        let caption = format!("Test {}: {statistic}.", test.name);
        figures.push(Figure::new(chart, caption));
    }
    figures.extend(residuals);
    figures
}
