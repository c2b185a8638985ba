//! The section on the errors-in-variables models.

use super::super::Reproduction;
use super::super::cells::{TABLE7_HEAD, TABLE8_HEAD};
use super::super::html::{judge_last, plain};
use crate::report::page::{Cell, Page};

impl Reproduction {
    /// Tables 7 and 8.
    pub(in super::super) fn noise_models(&self, page: &mut Page) {
        let tables = &self.tables;
        page.section("table7", "Errors-in-variables models (Tables 7 and 8)");
        page.heading("Table 8: the noise of all channels");
        let rows: Vec<Vec<Cell>> = tables
            .table8
            .iter()
            .map(|row| judge_last(row.cells(), row.met))
            .collect();
        page.table(&TABLE8_HEAD, &rows);
        page.note(tables.table8_definition);
        page.heading("Table 7: reconstruction errors");
        let rows: Vec<Vec<Cell>> = tables.table7.iter().map(|row| plain(row.cells())).collect();
        page.table(&TABLE7_HEAD, &rows);
        page.note(tables.table7_definition);
    }
}
