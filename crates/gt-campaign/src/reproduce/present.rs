//! The tables for people: as text on a terminal and as the page.

use std::fmt::Write as _;

use gt_log::build_info;
use gtfdi::fdi::FalseAlarmRate;

use super::Reproduction;
use super::tables::{Table3Row, Table9, Tables};
use crate::report::page::{Cell, Page};

/// Entries of Table 3 may differ by this much, in percent of the paper's value.
const TABLE3_LIMIT_PERCENT: f64 = 2.5;

/// Why some entries of Table 3 cannot be met, beside the table.
const TABLE3_NOTE: &str = "\
Zeros are calibration, not validation: the pressures and the temperatures before the turbine exit \
are what the parameters were solved for. Independent checks are t7, q, P, e and the mass flows. The \
paper's table contradicts itself in places: P_c exceeds P_t although nothing else drives the shaft, \
t2 lies below t1 in an adiabatic duct, and t2, t3 and the pressure ratio imply e_c = 0.839 with \
real specific heats (0.857 with a constant ratio of 1.4), not 0.8767. m1 is read as one of two \
equal intake legs.";

const TABLE9_NOTE: &str = "\
The paper shows the identity. These maps were chosen by people who knew that pattern, so the matrix \
says that a plausible plant exists that shows it, not that every plant does: the axial maps, with \
the slopes usual for an axial machine, are there to show how much rests on that choice.";

/// A fixed number of significant digits, plain where that is readable.
pub(super) fn digits(value: f64, significant: i32) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return "-".to_owned();
    }
    #[allow(clippy::cast_possible_truncation)] // the exponent of a double
    let exponent = value.abs().log10().floor() as i32;
    if (-4..9).contains(&exponent) {
        #[allow(clippy::cast_sign_loss)] // not negative
        let decimals = (significant - 1 - exponent).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        #[allow(clippy::cast_sign_loss)] // not negative
        let decimals = (significant - 1).max(0) as usize;
        format!("{value:.decimals$e}")
    }
}

fn optional(value: Option<f64>, significant: i32, otherwise: &str) -> String {
    value.map_or_else(|| otherwise.to_owned(), |value| digits(value, significant))
}

fn rate(rate: &FalseAlarmRate) -> String {
    format!(
        "{} in {} h: {} per h ({} to {})",
        rate.alarms,
        digits(rate.hours, 2),
        digits(rate.per_hour, 2),
        digits(rate.per_hour_low, 2),
        digits(rate.per_hour_high, 2)
    )
}

fn worst(rows: &[Table3Row]) -> Option<&Table3Row> {
    rows.iter()
        .max_by(|a, b| a.error_percent.abs().total_cmp(&b.error_percent.abs()))
}

/// Rows of equal cells, aligned.
fn aligned(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns)
        .map(|column| {
            rows.iter()
                .filter_map(|row| row.get(column))
                .map(|cell| cell.chars().count())
                .max()
        })
        .map(Option::unwrap_or_default)
        .collect();
    let mut text = String::new();
    for row in rows {
        for (column, cell) in row.iter().enumerate() {
            let pad = " ".repeat(widths[column] - cell.chars().count());
            let _ = if column == 0 {
                write!(text, "  {cell}{pad}")
            } else {
                write!(text, "  {pad}{cell}")
            };
        }
        text.push('\n');
    }
    text
}

fn strings(cells: &[&str]) -> Vec<String> {
    cells.iter().map(|cell| (*cell).to_owned()).collect()
}

impl Tables {
    fn table3_cells(&self) -> Vec<Vec<String>> {
        self.table3
            .iter()
            .map(|row| {
                let variable = if row.unit.is_empty() {
                    row.variable.clone()
                } else {
                    format!("{} [{}]", row.variable, row.unit)
                };
                // Adding zero turns a rounded -0 into 0.
                let error = format!("{:+.2}", (100.0 * row.error_percent).round() / 100.0 + 0.0);
                vec![variable, digits(row.paper, 6), digits(row.model, 6), error]
            })
            .collect()
    }

    fn table6_cells(&self) -> Vec<Vec<String>> {
        self.table6
            .iter()
            .map(|row| {
                let pair = |ours: Option<f64>, paper: f64| {
                    format!("{} / {}", optional(ours, 2, "diverges"), digits(paper, 1))
                };
                vec![
                    format!("{} ({})", row.output, row.label),
                    pair(row.identification, row.paper[0]),
                    pair(row.validation1, row.paper[1]),
                    pair(row.validation2, row.paper[2]),
                    digits(row.identification_prediction, 2),
                ]
            })
            .collect()
    }

    fn observer_cells(&self) -> Vec<Vec<String>> {
        self.observers
            .iter()
            .map(|row| {
                vec![
                    format!("{} [{}]", row.output, row.unit),
                    digits(row.pole, 1),
                    format!(
                        "{} / {}",
                        optional(row.reconstruction_error, 2, "diverges"),
                        optional(row.paper_reconstruction_error, 1, "-")
                    ),
                    digits(row.limit, 3),
                    rate(&row.false_alarms_cross_validated),
                    rate(&row.false_alarms_test),
                ]
            })
            .collect()
    }

    fn detection_cells(&self) -> Vec<Vec<String>> {
        self.detection
            .iter()
            .map(|row| {
                let mut cells = vec![format!("{} {}", row.case, row.name.replace('_', " "))];
                for delay in &row.delays_s {
                    cells.push(match (delay.delay_s, delay.size) {
                        (Some(delay), Some(size)) => {
                            format!("{delay:.0} s ({} {})", digits(size, 2), row.unit)
                        }
                        _ => "-".to_owned(),
                    });
                }
                cells.push(row.first.clone().unwrap_or_else(|| "-".to_owned()));
                cells.push(row.expected.clone());
                cells
            })
            .collect()
    }
}

fn signature_cells(table: &Table9) -> Vec<Vec<String>> {
    let rows = table.rows.iter().zip(&table.matrix);
    rows.map(|(name, row)| {
        let entries = row.iter().map(|entry| format!("{entry:.2}"));
        std::iter::once(name.clone()).chain(entries).collect()
    })
    .collect()
}

const TABLE3_HEAD: [&str; 4] = ["variable", "paper", "model", "error %"];
const TABLE6_HEAD: [&str; 5] = [
    "output",
    "identification ours / paper",
    "validation 1 ours / paper",
    "validation 2 ours / paper",
    "one step ahead",
];
const OBSERVER_HEAD: [&str; 6] = [
    "output",
    "pole",
    "model error ours / paper",
    "limit",
    "false alarms, cross-validated",
    "false alarms, test record",
];
const DETECTION_HEAD: [&str; 7] = [
    "case",
    "q_c alarms after",
    "t3",
    "p7",
    "m9",
    "first",
    "the paper's",
];

impl Reproduction {
    /// The tables as text, each with its definition.
    pub fn text(&self) -> String {
        let tables = &self.tables;
        let mut text = String::new();
        let mut section = |title: &str, head: &[&str], rows: Vec<Vec<String>>, note: &str| {
            let mut all = vec![strings(head)];
            all.extend(rows);
            let _ = writeln!(text, "{title}\n{}  {note}\n", aligned(&all));
        };
        section(
            "Table 3: steady state",
            &TABLE3_HEAD,
            tables.table3_cells(),
            TABLE3_NOTE,
        );
        section(
            "Table 6: errors of the ARX models (free run; SSE)",
            &TABLE6_HEAD,
            tables.table6_cells(),
            &tables.table6_definition,
        );
        for (what, all) in [
            ("free-run residuals", &tables.table9),
            ("observers", &tables.table9_observers),
        ] {
            for table in all {
                let mut head = vec!["fault"];
                head.extend(table.columns.iter().map(String::as_str));
                let title = format!(
                    "Table 9: signature, {what}, {} maps ({})",
                    table.map_set,
                    if table.diagonal {
                        "diagonal"
                    } else {
                        "not diagonal"
                    }
                );
                section(&title, &head, signature_cells(table), &table.definition);
            }
        }
        section(
            "Sections 5.3 to 5.6: observers and thresholds",
            &OBSERVER_HEAD,
            tables.observer_cells(),
            &tables.observers_definition,
        );
        section(
            "Detection of the nominal faults",
            &DETECTION_HEAD,
            tables.detection_cells(),
            &tables.detection_definition,
        );
        text
    }

    /// The self-contained page.
    pub fn page(&self) -> String {
        let tables = &self.tables;
        let mut page = Page::new(
            "Gas-turbine fault diagnosis, reproduced",
            "Simani and Fantuzzi, Mechatronics 16 (2006): what the paper printed beside what this \
             program computed in this run.",
        );
        self.summary(&mut page);

        page.section("table3", "Steady state (Table 3)");
        let rows: Vec<Vec<Cell>> = tables
            .table3
            .iter()
            .zip(tables.table3_cells())
            .map(|(row, cells)| {
                let met = row.error_percent.abs() <= TABLE3_LIMIT_PERCENT;
                judge_last(cells, met)
            })
            .collect();
        page.table(&TABLE3_HEAD, &rows);
        page.note(TABLE3_NOTE);

        page.section("records", "Records");
        page.paragraph(
            "Valve angle and speed setpoint are held for random times at random levels; a small \
             coloured dither is added to the fuel that the governor demands.",
        );
        self.figures_of(&mut page, "record_");

        page.section("table6", "Models (Tables 5 and 6)");
        let rows: Vec<Vec<Cell>> = tables
            .table6
            .iter()
            .zip(tables.table6_cells())
            .map(|(row, cells)| {
                let ours = [row.identification, row.validation1, row.validation2];
                let met = ours
                    .iter()
                    .zip(row.paper)
                    .map(|(ours, paper)| ours.is_some_and(|ours| ours <= paper));
                let judgements: Vec<Option<bool>> = std::iter::once(None)
                    .chain(met.map(Some))
                    .chain(std::iter::once(None))
                    .collect();
                judged(cells, &judgements)
            })
            .collect();
        page.table(&TABLE6_HEAD, &rows);
        page.note(&tables.table6_definition);
        self.figures_of(&mut page, "free_run_");

        page.section("table9", "Signatures (Table 9)");
        page.paragraph(TABLE9_NOTE);
        for (what, all) in [
            ("free-run residuals", &tables.table9),
            ("observers", &tables.table9_observers),
        ] {
            for table in all {
                let verdict = if table.diagonal {
                    "every residual peaks at its own fault"
                } else {
                    "not every residual peaks at its own fault"
                };
                page.heading(&format!("{what}, {} maps: {verdict}", table.map_set));
                let mut head = vec!["fault"];
                head.extend(table.columns.iter().map(String::as_str));
                let rows: Vec<Vec<Cell>> = signature_cells(table)
                    .into_iter()
                    .zip(&table.matrix)
                    .map(|(cells, shares)| {
                        let mut cells = cells.into_iter();
                        let name = cells.next().map(Cell::plain);
                        let entries = cells
                            .zip(shares)
                            .map(|(text, share)| Cell::shaded(text, *share));
                        name.into_iter().chain(entries).collect()
                    })
                    .collect();
                page.table(&head, &rows);
            }
            if let Some(table) = all.first() {
                page.note(&table.definition);
            }
        }

        page.section(
            "detection",
            "Sections 5.3 to 5.6: observers, thresholds, faults",
        );
        let rows: Vec<Vec<Cell>> = tables.observer_cells().into_iter().map(plain).collect();
        page.table(&OBSERVER_HEAD, &rows);
        page.note(&tables.observers_definition);
        let rows: Vec<Vec<Cell>> = tables
            .detection
            .iter()
            .zip(tables.detection_cells())
            .map(|(row, cells)| {
                let right = row.first.as_deref() == Some(row.expected.as_str());
                let last = cells.len() - 2;
                let judgements: Vec<Option<bool>> = (0..cells.len())
                    .map(|column| (column == last).then_some(right))
                    .collect();
                judged(cells, &judgements)
            })
            .collect();
        page.table(&DETECTION_HEAD, &rows);
        page.note(&tables.detection_definition);
        self.figures_of(&mut page, "residual_");

        page.section("open", "Not computed yet");
        page.paragraph(
            "Tables 7 and 8 (errors-in-variables models and their noise variances), Table 10 \
             (minimal detectable faults) and the statistics of isolation are null or empty in the \
             JSON; nothing here stands in for them.",
        );
        let build = build_info();
        page.finish(&format!(
            "gtfdi {} ({}), {}. Seed {}; sample time {} s. Logs of all runs are in logs/, the \
             numbers in tables.json.",
            build.version, build.git, build.rustc, tables.seed, tables.sample_time_s
        ))
    }

    fn summary(&self, page: &mut Page) {
        let tables = &self.tables;
        let met = tables.table6.iter().filter(|row| row.met).count();
        let first_right = tables
            .detection
            .iter()
            .filter(|row| row.first.as_deref() == Some(row.expected.as_str()))
            .count();
        let signatures: Vec<String> = tables
            .table9
            .iter()
            .map(|table| {
                format!(
                    "{}: {}",
                    table.map_set,
                    if table.diagonal {
                        "diagonal"
                    } else {
                        "not diagonal"
                    }
                )
            })
            .collect();
        let mut facts = Vec::new();
        if let Some(row) = worst(&tables.table3) {
            facts.push((
                format!("{:+.2} %", row.error_percent),
                format!(
                    "largest error of Table 3 ({}), of {} entries",
                    row.variable,
                    tables.table3.len()
                ),
            ));
        }
        facts.push((
            format!("{met} of {}", tables.table6.len()),
            "outputs within all of Table 6's bounds, in free run".to_owned(),
        ));
        facts.push((
            signatures.join(", "),
            "signature of the free-run residuals (Table 9)".to_owned(),
        ));
        facts.push((
            format!("{first_right} of {}", tables.detection.len()),
            "nominal faults first seen by the paper's output, fixed thresholds".to_owned(),
        ));
        page.facts(&facts);
    }

    fn figures_of(&self, page: &mut Page, prefix: &str) {
        for figure in self
            .figures
            .iter()
            .filter(|figure| figure.chart.id.starts_with(prefix))
        {
            page.figure(&figure.chart, &figure.caption);
        }
    }
}

fn plain(cells: Vec<String>) -> Vec<Cell> {
    cells.into_iter().map(Cell::plain).collect()
}

fn judged(cells: Vec<String>, judgements: &[Option<bool>]) -> Vec<Cell> {
    cells
        .into_iter()
        .zip(judgements)
        .map(|(cell, judgement)| match judgement {
            Some(met) => Cell::judged(cell, *met),
            None => Cell::plain(cell),
        })
        .collect()
}

fn judge_last(cells: Vec<String>, met: bool) -> Vec<Cell> {
    let last = cells.len().saturating_sub(1);
    let judgements: Vec<Option<bool>> = (0..cells.len())
        .map(|column| (column == last).then_some(met))
        .collect();
    judged(cells, &judgements)
}

#[cfg(test)]
mod tests {
    use super::{aligned, digits};

    #[test]
    fn digits_are_significant() {
        assert_eq!(digits(1_014_989.503, 6), "1014990");
        assert_eq!(digits(0.876_73, 6), "0.876730");
        assert_eq!(digits(3.2e-8, 2), "3.2e-8");
        assert_eq!(digits(f64::NAN, 2), "-");
        assert_eq!(digits(0.01, 1), "0.01");
    }

    #[test]
    fn columns_line_up() {
        let rows = [
            vec!["a".to_owned(), "10".to_owned()],
            vec!["bcd".to_owned(), "7".to_owned()],
        ];
        assert_eq!(aligned(&rows), "  a    10\n  bcd   7\n");
    }
}
