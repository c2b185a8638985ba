//! The tables cell by cell, as text and page both show them.

use gtfdi::fdi::FalseAlarmRate;

use super::tables::{Cogeneration, Manoeuvre, Table6Seeds, Table7Row, Table8Row, Table9, Tables};
use super::tables::{IsolationTable, Table10Row};
use crate::report::text::digits;

/// What the origins in Table 3 mean, beside the table.
pub(super) const TABLE3_NOTE: &str = "\
Calibrated: met by construction, because parameters were solved for it; no validation. Reconciled: \
mass flows, changed as little as closes the balances. Check: not used by the calibration, an \
independent check as far as the table agrees with itself; P_t, q_t and e_t rest on an assumed loss \
of the shaft of 10 kW, 0.2 % of them. Defined: e_c, whose definition was chosen for the number, no \
check.";

/// How far Table 9 carries.
pub(super) const TABLE9_NOTE: &str = "\
The paper shows the identity. These maps were chosen by people who knew that pattern, so the matrix \
says that a plausible plant exists that shows it, not that every plant does: the axial maps, with \
the slopes usual for an axial machine, are there to show how much rests on that choice.";

/// Head of Table 3.
pub(super) const TABLE3_HEAD: [&str; 5] = ["variable", "paper", "model", "origin", "error %"];
/// Head of the contradictions of Table 3.
pub(super) const CONTRADICTIONS_HEAD: [&str; 3] = ["entries", "as printed", "in the model"];
/// Head of the effects of the faults in one reading.
pub(super) const EFFECTS_HEAD: [&str; 9] = [
    "output",
    "settled % case 1",
    "settled 2",
    "settled 3",
    "rms % case 1",
    "rms 2",
    "rms 3",
    "rms 4",
    "rms 4, single runs",
];
/// Head of the effects on the monitored outputs.
pub(super) const MONITORED_HEAD: [&str; 6] =
    ["fault", "q_c rms % (share)", "t3", "p7", "m9", "moves most"];
/// Head of the steady loads on the mains.
pub(super) const LOADS_HEAD: [&str; 7] = [
    "maps",
    "fuel %",
    "IGV [deg]",
    "t7 [K]",
    "t5 [K]",
    "m3 [kg/s]",
    "P_e [kW]",
];
/// Head of a load reduction.
pub(super) const MANOEUVRE_HEAD: [&str; 6] = [
    "signal",
    "first",
    "last",
    "change %",
    "standard deviation",
    "settles after [s]",
];
/// Head of Table 10.
pub(super) const TABLE10_HEAD: [&str; 11] = [
    "fault",
    "maps",
    "within [s]",
    "paper % (noisy)",
    "no noise %",
    "Table 8 %",
    "Tables 4, 5 %",
    "effect %",
    "95 % interval, Table 8",
    "paper's scheme %, no noise / Table 8 / 4, 5",
    "mean delay / bound [s], Table 8",
];
/// Head of the naming of faults.
pub(super) const ISOLATION_HEAD: [&str; 10] = [
    "maps",
    "noise",
    "runs",
    "detected %",
    "named right %",
    "ever wrong %",
    "undecided %",
    "size within 15 %",
    "onset in interval %",
    "size in interval %",
];
/// Head of Table 6.
pub(super) const TABLE6_HEAD: [&str; 5] = [
    "output",
    "identification ours / paper",
    "validation 1 ours / paper",
    "validation 2 ours / paper",
    "one step ahead",
];
/// Head of Table 6 over many seeds.
pub(super) const SEEDS_HEAD: [&str; 5] = [
    "output",
    "identification, worst / paper",
    "validation 1, worst / paper",
    "validation 2, worst / paper",
    "met",
];
/// Head of Table 7.
pub(super) const TABLE7_HEAD: [&str; 7] = [
    "output",
    "plant",
    "order",
    "identification ours / paper",
    "validation",
    "identification, worst",
    "validation, worst",
];
/// Head of Table 8.
pub(super) const TABLE8_HEAD: [&str; 6] = [
    "signal",
    "plant",
    "put in = paper",
    "found",
    "error %",
    "worst error %",
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

/// An output's name and its three errors beside the paper's bounds.
fn error_cells(output: &str, label: &str, ours: [Option<f64>; 3], paper: [f64; 3]) -> Vec<String> {
    let pairs = ours
        .into_iter()
        .zip(paper)
        .map(|(ours, paper)| format!("{} / {}", optional(ours, 2, "diverges"), digits(paper, 1)));
    std::iter::once(format!("{output} ({label})"))
        .chain(pairs)
        .collect()
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
                let [paper, model] = [row.paper, row.model].map(|value| digits(value, 6));
                vec![variable, paper, model, row.origin.to_string(), error]
            })
            .collect()
    }

    /// The errors of Table 3 in a sentence, and what `e_c` means.
    pub(super) fn table3_summary(&self) -> String {
        let notes = &self.table3_notes;
        let e_c = self.table3.iter().find(|row| row.variable == "e_c");
        format!(
            "Mean absolute error {:.2} % over all {} entries, {:.2} % over those that are not met \
             by construction; largest {:+.2} % ({}). {} e_c {} against the map's {:.3}.",
            notes.mean_absolute_error_percent,
            self.table3.len(),
            notes.mean_absolute_error_not_calibrated_percent,
            notes.largest_error_percent,
            notes.largest_error_variable,
            notes.e_c_definition,
            e_c.map_or_else(String::new, |row| format!("{:.3}", row.model)),
            notes.map_isentropic_efficiency,
        )
    }

    pub(super) fn contradiction_cells(&self) -> Vec<Vec<String>> {
        let all = self.table3_notes.contradictions.iter();
        all.map(|contradiction| {
            vec![
                contradiction.entries.join(", "),
                contradiction.printed.to_owned(),
                contradiction.model.to_owned(),
            ]
        })
        .collect()
    }

    pub(super) fn table6_cells(&self) -> Vec<Vec<String>> {
        let rows = self.table6.iter().map(|row| {
            let ours = [row.identification, row.validation1, row.validation2];
            let mut cells = error_cells(&row.output, &row.label, ours, row.paper);
            cells.push(digits(row.identification_prediction, 2));
            cells
        });
        rows.collect()
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

pub(super) fn signature_head(table: &Table9) -> Vec<String> {
    let isolated = table.rows.iter().map(|row| format!("isolated: {row}"));
    let own = std::iter::once("fault".to_owned()).chain(table.columns.iter().cloned());
    own.chain(isolated).collect()
}

/// The entries of the signature of each fault, then those of the isolating residuals.
pub(super) fn signature_shares(table: &Table9) -> impl Iterator<Item = Vec<f64>> {
    let rows = table.matrix.iter().zip(&table.matrix_isolated);
    rows.map(|(own, isolated)| own.iter().chain(isolated).copied().collect())
}

pub(super) fn signature_cells(table: &Table9) -> Vec<Vec<String>> {
    let rows = table.rows.iter().zip(signature_shares(table));
    rows.map(|(name, row)| {
        let entries = row.iter().map(|entry| format!("{entry:.2}"));
        std::iter::once(name.clone()).chain(entries).collect()
    })
    .collect()
}

impl Table6Seeds {
    /// The profile and the number of seeds in words.
    pub(super) fn title(&self) -> String {
        let (profile, seeds) = (&self.profile, self.seeds.len());
        let amplitude = self.valve_amplitude_deg;
        format!("{seeds} seeds, profile {profile} (+-{amplitude:.1} deg)")
    }

    pub(super) fn cells(&self) -> Vec<Vec<String>> {
        let rows = self.rows.iter().map(|row| {
            let worst = [row.identification, row.validation1, row.validation2];
            let mut cells = error_cells(&row.output, &row.label, worst, row.paper);
            cells.push(format!("{} of {}", row.met, self.seeds.len()));
            cells
        });
        rows.collect()
    }
}

impl Table7Row {
    pub(super) fn cells(&self) -> Vec<String> {
        let error = |error| optional(error, 2, "diverges");
        vec![
            format!("{} ({})", self.output, self.label),
            self.plant.to_owned(),
            self.order.to_string(),
            format!("{} / {}", error(self.identification), digits(self.paper, 2)),
            error(self.validation),
            error(self.worst_identification),
            error(self.worst_validation),
        ]
    }
}

impl Table8Row {
    pub(super) fn cells(&self) -> Vec<String> {
        let error = self.standard_error.map_or_else(
            || " (not told)".to_owned(),
            |error| format!(" +- {error:.4}"),
        );
        vec![
            format!("{} ({})", self.signal, self.label),
            self.plant.to_owned(),
            format!("{:.4}", self.put_in),
            format!("{:.4}{error}", self.found),
            format!("{:+.1}", self.error_percent),
            format!("{:+.1}", self.worst_error_percent),
        ]
    }
}

impl Cogeneration {
    pub(super) fn load_cells(&self) -> Vec<Vec<String>> {
        let loads = self.steady.iter();
        loads
            .map(|load| {
                vec![
                    load.map_set.clone(),
                    format!("{:.0}", load.fuel_percent),
                    format!("{:.1}", load.guide_vane_deg),
                    format!("{:.1}", load.t7_k),
                    format!("{:.1}", load.t5_k),
                    format!("{:.2}", load.m3_kg_s),
                    format!("{:.0}", 1e-3 * load.electric_power_w),
                ]
            })
            .collect()
    }
}

impl Manoeuvre {
    pub(super) fn cells(&self) -> Vec<Vec<String>> {
        let signals = self.signals.iter();
        signals
            .map(|signal| {
                let (unit, scale) = match signal.unit.as_str() {
                    "W" => ("kW", 1e-3),
                    unit => (unit, 1.0),
                };
                // A change below rounding is that of a signal that stands still.
                let change = signal.change_percent.map_or_else(
                    || "-".to_owned(),
                    |percent| format!("{:+.2}", (100.0 * percent).round() / 100.0 + 0.0),
                );
                vec![
                    format!("{} [{unit}]", signal.signal),
                    digits(scale * signal.initial, 5),
                    digits(scale * signal.last, 5),
                    change,
                    digits(scale * signal.standard_deviation, 3),
                    format!("{:.1}", signal.settles_after_s),
                ]
            })
            .collect()
    }

    /// How well the outlet temperature was held.
    pub(super) fn verdict(&self) -> String {
        let Self {
            set_point_k,
            largest_deviation_k,
            largest_deviation_time_s,
            ..
        } = self;
        if self.vanes_closed {
            return format!(
                "The vanes stand at their closed stop and hold nothing: T_ot goes as far as \
                 {largest_deviation_k:+.1} K from the set point of {set_point_k:.1} K."
            );
        }
        format!(
            "Largest deviation of T_ot from the set point of {set_point_k:.1} K: \
             {largest_deviation_k:+.2} K, at {largest_deviation_time_s:.0} s."
        )
    }
}

impl Table10Row {
    pub(super) fn cells(&self) -> Vec<String> {
        let shown = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |own| digits(own, 2));
        let maps = if self.ambient_varies {
            format!("{}, ambient varies", self.map_set)
        } else {
            self.map_set.clone()
        };
        let paper = self.paper_percent.map_or_else(
            || "-".to_owned(),
            |[clean, noisy]| format!("{clean} ({noisy})"),
        );
        let interval = self.interval[1].map_or_else(
            || "-".to_owned(),
            |[low, high]| format!("{} .. {}", shown(low), shown(high)),
        );
        vec![
            format!("{} {}", self.case, self.name),
            maps,
            format!("{}", self.delay_s),
            paper,
            shown(self.noise_free_percent),
            shown(self.noisy_percent),
            shown(self.noisy_accuracy_percent),
            shown(self.effect_percent),
            interval,
            self.paper_scheme_percent.map(shown).join(" / "),
            format!(
                "{} / {}",
                shown(self.mean_delay_s[1]),
                shown(self.delay_bound_s[1])
            ),
        ]
    }
}

impl IsolationTable {
    pub(super) fn cells(&self) -> Vec<String> {
        let own = &self.summary;
        let shares = [
            own.detected_percent,
            own.accuracy_percent,
            own.wrong_fault_alarm_percent,
            own.undecided_percent,
            own.magnitude_within_15_percent,
            own.onset_in_interval_percent,
            own.magnitude_in_interval_percent,
        ];
        let shares = shares.iter().zip(&own.intervals_percent);
        let mut cells = vec![
            self.map_set.clone(),
            self.noise.clone(),
            own.runs.to_string(),
        ];
        cells.extend(
            shares.map(|(share, [low, high])| format!("{share:.1} ({low:.1} .. {high:.1})")),
        );
        cells
    }
}
