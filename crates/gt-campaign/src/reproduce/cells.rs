//! The tables cell by cell, as text and page both show them.

use gtfdi::fdi::FalseAlarmRate;

use super::tables::{Table9, Tables};
use crate::report::text::digits;

/// Why some entries of Table 3 cannot be met, beside the table.
pub(super) const TABLE3_NOTE: &str = "\
Zeros are calibration, not validation: the pressures and the temperatures before the turbine exit \
are what the parameters were solved for, and the mass flows were reconciled with the table's own. \
Independent checks are t7, the torques and the powers, as far as the table agrees with itself. The \
paper's table contradicts itself in places: P_c exceeds P_t although nothing else drives the shaft, \
t2 lies below t1 in an adiabatic duct, and t2, t3 and the pressure ratio imply e_c = 0.839 with \
real specific heats (0.857 with a constant ratio of 1.4), not 0.8767. m1 is read as one of two \
equal intake legs.";

/// How far Table 9 carries.
pub(super) const TABLE9_NOTE: &str = "\
The paper shows the identity. These maps were chosen by people who knew that pattern, so the matrix \
says that a plausible plant exists that shows it, not that every plant does: the axial maps, with \
the slopes usual for an axial machine, are there to show how much rests on that choice.";

/// Head of Table 3.
pub(super) const TABLE3_HEAD: [&str; 4] = ["variable", "paper", "model", "error %"];
/// Head of Table 6.
pub(super) const TABLE6_HEAD: [&str; 5] = [
    "output",
    "identification ours / paper",
    "validation 1 ours / paper",
    "validation 2 ours / paper",
    "one step ahead",
];
/// Head of the table of observers.
pub(super) const OBSERVER_HEAD: [&str; 6] = [
    "output",
    "pole",
    "model error ours / paper",
    "limit",
    "false alarms, cross-validated",
    "false alarms, test record",
];
/// Head of the table of detections.
pub(super) const DETECTION_HEAD: [&str; 7] = [
    "case",
    "q_c alarms after",
    "t3",
    "p7",
    "m9",
    "first",
    "the paper's",
];

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

impl Tables {
    pub(super) fn table3_cells(&self) -> Vec<Vec<String>> {
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

    pub(super) fn table6_cells(&self) -> Vec<Vec<String>> {
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

    pub(super) fn observer_cells(&self) -> Vec<Vec<String>> {
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

    pub(super) fn detection_cells(&self) -> Vec<Vec<String>> {
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

pub(super) fn signature_cells(table: &Table9) -> Vec<Vec<String>> {
    let rows = table.rows.iter().zip(&table.matrix);
    rows.map(|(name, row)| {
        let entries = row.iter().map(|entry| format!("{entry:.2}"));
        std::iter::once(name.clone()).chain(entries).collect()
    })
    .collect()
}
