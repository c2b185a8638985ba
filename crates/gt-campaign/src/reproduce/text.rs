//! The tables on a terminal.

use std::fmt::Write as _;

use super::Reproduction;
use super::cells::{
    DETECTION_HEAD, OBSERVER_HEAD, TABLE3_HEAD, TABLE3_NOTE, TABLE6_HEAD, signature_cells,
};
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
                wrap(note, WIDTH)
            );
        };
        section(
            "Table 3: steady state",
            &TABLE3_HEAD,
            &tables.table3_cells(),
            TABLE3_NOTE,
        );
        section(
            "Table 6: errors of the ARX models (free run; SSE)",
            &TABLE6_HEAD,
            &tables.table6_cells(),
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
        text
    }
}
