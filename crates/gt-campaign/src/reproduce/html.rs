//! The page of a reproduction.

use gt_log::build_info;

use super::Reproduction;
use super::cells::{
    CONTRADICTIONS_HEAD, DETECTION_HEAD, ISOLATION_HEAD, OBSERVER_HEAD, SEEDS_HEAD, TABLE3_HEAD,
    TABLE3_NOTE, TABLE6_HEAD, TABLE9_NOTE, TABLE10_HEAD, signature_cells, signature_head,
    signature_shares,
};
use super::tables::Table10Row;
use crate::report::page::{Cell, Page};

/// Entries of Table 3 may differ by this much, in percent of the paper's value: about what its own
/// contradictions amount to.
const TABLE3_LIMIT_PERCENT: f64 = 2.0;

impl Reproduction {
    /// The self-contained page.
    pub fn page(&self) -> String {
        let tables = &self.tables;
        let mut page = Page::new(
            "Gas-turbine fault diagnosis, reproduced",
            "Simani and Fantuzzi, Mechatronics 16 (2006): what the paper printed beside what this \
             program computed in this run.",
        );
        self.summary(&mut page);
        self.steady_state(&mut page);
        self.records_shown(&mut page);
        self.models_section(&mut page);
        self.noise_models(&mut page);
        self.fault_effects(&mut page);
        self.signatures(&mut page);
        self.detection(&mut page);
        self.cogeneration(&mut page);

        self.limits(&mut page);
        let build = build_info();
        page.finish(&format!(
            "gtfdi {} ({}), {}. Seed {}; sample time {} s. Logs of all runs are in logs/, the \
             numbers in tables.json.",
            build.version, build.git, build.rustc, tables.seed, tables.sample_time_s
        ))
    }

    /// Table 3.
    fn steady_state(&self, page: &mut Page) {
        let tables = &self.tables;
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
        page.paragraph(&tables.table3_summary());
        page.table(&TABLE3_HEAD, &rows);
        page.note(TABLE3_NOTE);
        page.heading("Where the table contradicts itself");
        let rows: Vec<Vec<Cell>> = tables
            .contradiction_cells()
            .into_iter()
            .map(plain)
            .collect();
        page.prose_table(&CONTRADICTIONS_HEAD, &rows);
    }

    /// The identification record.
    fn records_shown(&self, page: &mut Page) {
        page.section("records", "Records");
        page.paragraph(
            "Valve angle and speed setpoint are held for random times at random levels; a small \
             coloured dither is added to the fuel that the governor demands.",
        );
        self.figures_of(page, "record_");
    }

    /// Tables 5 and 6.
    fn models_section(&self, page: &mut Page) {
        let tables = &self.tables;
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
        for seeds in &tables.table6_seeds {
            page.heading(&format!("Table 6 with {}", seeds.title()));
            let rows: Vec<Vec<Cell>> = seeds
                .rows
                .iter()
                .zip(seeds.cells())
                .map(|(row, cells)| judge_last(cells, row.met == seeds.seeds.len()))
                .collect();
            page.table(&SEEDS_HEAD, &rows);
            page.note(&seeds.definition);
        }
        self.figures_of(page, "free_run_");
        page.fold("Poles, zeros and frequency responses", false, |page| {
            page.note(
                "With what the identification record says of their errors, to first order: ellipses \
                 and bands hold the truth with probability .95, if the one-step errors are white.",
            );
            for kind in ["poles_", "gain_", "phase_"] {
                self.figures_of(page, kind);
            }
        });
    }

    /// Table 9.
    fn signatures(&self, page: &mut Page) {
        let tables = &self.tables;
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
                let head = signature_head(table);
                let head: Vec<&str> = head.iter().map(String::as_str).collect();
                let rows: Vec<Vec<Cell>> = signature_cells(table)
                    .into_iter()
                    .zip(signature_shares(table))
                    .map(|(cells, shares)| {
                        let mut cells = cells.into_iter();
                        let name = cells.next().map(Cell::plain);
                        let entries = cells
                            .zip(shares)
                            .map(|(text, share)| Cell::shaded(text, share));
                        name.into_iter().chain(entries).collect()
                    })
                    .collect();
                page.table(&head, &rows);
            }
            if let Some(table) = all.first() {
                page.note(&table.definition);
            }
        }
    }

    /// Sections 5.3 to 5.6.
    fn detection(&self, page: &mut Page) {
        let tables = &self.tables;
        page.section("detection", "Detection (sections 5.3 to 5.6)");
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
        self.figures_of(page, "residual_");
    }

    /// Table 10 and the naming of faults.
    fn limits(&self, page: &mut Page) {
        let tables = &self.tables;
        page.section(
            "table10",
            "Minimal detectable faults (Table 10) and their names",
        );
        let rows = tables.table10.iter().map(Table10Row::cells);
        let rows: Vec<Vec<Cell>> = rows.map(plain).collect();
        page.table(&TABLE10_HEAD, &rows);
        let rows = tables.isolation.iter().chain(&tables.isolation_others);
        let rows: Vec<Vec<Cell>> = rows.map(|table| plain(table.cells())).collect();
        page.table(&ISOLATION_HEAD, &rows);
        page.note(&tables.table10_definition);
        self.figures_of(page, "detection_");
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
        let notes = &tables.table3_notes;
        facts.push((
            format!("{:.2} %", notes.mean_absolute_error_percent),
            format!(
                "mean absolute error of Table 3, {} entries; largest {:+.2} % ({})",
                tables.table3.len(),
                notes.largest_error_percent,
                notes.largest_error_variable
            ),
        ));
        facts.push((
            format!("{met} of {}", tables.table6.len()),
            "outputs within all of Table 6's bounds, in free run".to_owned(),
        ));
        let recovered = tables.table8.iter().filter(|row| row.met).count();
        facts.push((
            format!("{recovered} of {}", tables.table8.len()),
            "noise deviations found within 10 % for all seeds (Table 8), two plants".to_owned(),
        ));
        facts.push((
            signatures.join(", "),
            "signature of the free-run residuals (Table 9)".to_owned(),
        ));
        facts.push((
            format!("{first_right} of {}", tables.detection.len()),
            "nominal faults first seen by the paper's output, one run each, fixed thresholds"
                .to_owned(),
        ));
        page.facts(&facts);
    }

    pub(super) fn figures_of(&self, page: &mut Page, prefix: &str) {
        for figure in self
            .figures
            .iter()
            .filter(|figure| figure.chart.id.starts_with(prefix))
        {
            page.figure(figure);
        }
    }
}

pub(super) fn plain(cells: Vec<String>) -> Vec<Cell> {
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

pub(super) fn judge_last(cells: Vec<String>, met: bool) -> Vec<Cell> {
    let last = cells.len().saturating_sub(1);
    let judgements: Vec<Option<bool>> = (0..cells.len())
        .map(|column| (column == last).then_some(met))
        .collect();
    judged(cells, &judgements)
}
