//! The tables on a terminal.

use std::fmt::Write as _;

use super::Reproduction;
use super::cells::{
    DETECTION_HEAD, ISOLATION_HEAD, LOADS_HEAD, MANOEUVRE_HEAD, MONITORED_HEAD, OBSERVER_HEAD,
    SEEDS_HEAD, TABLE3_HEAD, TABLE3_NOTE, TABLE6_HEAD, TABLE7_HEAD, TABLE8_HEAD, TABLE10_HEAD,
    signature_cells, signature_head,
};
use super::sections::SHARE_NOTE;
use super::tables::{IsolationTable, Table7Row, Table8Row, Table10Row};
use crate::report::text::{table, wrap};

/// Characters in a line of a definition.
const WIDTH: usize = 100;

impl Reproduction {
    /// The tables as text, each with its definition.
    pub fn text(&self) -> String {
        let tables = &self.tables;
        let mut text = String::new();
        let mut section = |title: &str, head: &[&str], rows: &[Vec<String>], note: &str| {
            let _ = writeln!(
                text,
                "{title}\n\n{}\n{}\n",
                table(head, rows),
                paragraphs(note)
            );
        };
        section(
            "Table 3: steady state",
            &TABLE3_HEAD,
            &tables.table3_cells(),
            &self.table3_notes(),
        );
        section(
            "Table 6: errors of the ARX models (free run; SSE)",
            &TABLE6_HEAD,
            &tables.table6_cells(),
            &tables.table6_definition,
        );
        for seeds in &tables.table6_seeds {
            let title = format!("Table 6: {}", seeds.title());
            section(&title, &SEEDS_HEAD, &seeds.cells(), &seeds.definition);
        }
        let rows: Vec<_> = tables.table7.iter().map(Table7Row::cells).collect();
        let title = "Table 7: errors-in-variables models (free run; SSE)";
        section(title, &TABLE7_HEAD, &rows, tables.table7_definition);
        let rows: Vec<_> = tables.table8.iter().map(Table8Row::cells).collect();
        let title = "Table 8: noise deviations over those of the signals";
        section(title, &TABLE8_HEAD, &rows, tables.table8_definition);
        for (what, all) in [
            ("free-run residuals", &tables.table9),
            ("observers", &tables.table9_observers),
        ] {
            for table in all {
                let head = signature_head(table);
                let head: Vec<&str> = head.iter().map(String::as_str).collect();
                let title = format!(
                    "Table 9: signature, {what}, {} maps ({})",
                    table.map_set,
                    if table.diagonal {
                        "diagonal"
                    } else {
                        "not diagonal"
                    }
                );
                section(&title, &head, &signature_cells(table), &table.definition);
            }
        }
        section(
            "Sections 5.3 to 5.6: observers and thresholds",
            &OBSERVER_HEAD,
            &tables.observer_cells(),
            &tables.observers_definition,
        );
        section(
            "Detection of the nominal faults",
            &DETECTION_HEAD,
            &tables.detection_cells(),
            &tables.detection_definition,
        );
        for (map_set, effects) in tables.effects_in_order() {
            for (what, reading, signature) in effects.readings() {
                section(
                    &format!("Fault effects on the monitored outputs: {what}, {map_set} maps"),
                    &MONITORED_HEAD,
                    &effects.monitored_cells(reading, &signature.signature),
                    SHARE_NOTE,
                );
            }
        }
        let _ = writeln!(text, "{}\n", paragraphs(&self.effects_notes()));
        text += &self.limits_text();
        let mut section = |title: &str, head: &[&str], rows: &[Vec<String>], note: &str| {
            let table = table(head, rows);
            let _ = writeln!(text, "{title}\n\n{table}\n{}\n", paragraphs(note));
        };
        let cogeneration = &tables.cogeneration;
        for manoeuvre in &cogeneration.manoeuvres {
            section(
                &format!("{}, {} maps", manoeuvre.profile, manoeuvre.map_set),
                &MANOEUVRE_HEAD,
                &manoeuvre.cells(),
                &manoeuvre.verdict(),
            );
        }
        section(
            "Steady loads on the mains",
            &LOADS_HEAD,
            &cogeneration.load_cells(),
            &format!(
                "{}\n{}",
                cogeneration.definition, cogeneration.not_comparable
            ),
        );
        text
    }

    /// Table 10 and the naming of faults.
    fn limits_text(&self) -> String {
        let tables = &self.tables;
        let limits: Vec<_> = tables.table10.iter().map(Table10Row::cells).collect();
        let named = tables.isolation.iter().chain(&tables.isolation_others);
        let named: Vec<_> = named.map(IsolationTable::cells).collect();
        format!(
            "Table 10: minimal detectable faults\n\n{}\nNaming of faults (95 % intervals)\n\n{}\n{}\n\n",
            table(&TABLE10_HEAD, &limits),
            table(&ISOLATION_HEAD, &named),
            paragraphs(&tables.table10_definition)
        )
    }

    /// What stands beneath Table 3: errors, origins, contradictions.
    fn table3_notes(&self) -> String {
        let mut notes = vec![self.tables.table3_summary(), TABLE3_NOTE.to_owned()];
        for contradiction in &self.tables.table3_notes.contradictions {
            notes.push(format!(
                "- {}: {}. Here: {}.",
                contradiction.entries.join(", "),
                contradiction.printed,
                contradiction.model
            ));
        }
        notes.join("\n")
    }

    /// What stands beneath the effects of the faults.
    fn effects_notes(&self) -> String {
        let tables = &self.tables;
        let mut notes = vec![tables.effects_verdict()];
        for (map_set, effects) in tables.effects_in_order() {
            notes.push(effects.lag_sentence(map_set));
        }
        notes.push(tables.lag_limit_sentence());
        if let Some((_, effects)) = tables.effects_in_order().next() {
            notes.push(effects.definition.clone());
        }
        notes.join("\n")
    }
}

/// Each line of a text as a paragraph of lines of at most [`WIDTH`] characters.
fn paragraphs(text: &str) -> String {
    let paragraphs: Vec<String> = text.lines().map(|line| wrap(line, WIDTH)).collect();
    paragraphs.join("\n")
}
