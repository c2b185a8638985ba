//! The section on the machine of section 3.1.

use super::super::Reproduction;
use super::super::cells::{LOADS_HEAD, MANOEUVRE_HEAD};
use super::super::html::plain;
use crate::report::page::{Cell, Page};

impl Reproduction {
    /// Load reductions and steady loads on the mains.
    pub(in super::super) fn cogeneration(&self, page: &mut Page) {
        let cogeneration = &self.tables.cogeneration;
        page.section("cogeneration", "Cogeneration (section 3.1)");
        page.paragraph(cogeneration.not_comparable);
        for manoeuvre in &cogeneration.manoeuvres {
            let title = manoeuvre.profile.replace('_', " ");
            page.heading(&format!("{title}, {} maps", manoeuvre.map_set));
            let rows: Vec<Vec<Cell>> = manoeuvre.cells().into_iter().map(plain).collect();
            page.table(&MANOEUVRE_HEAD, &rows);
            page.paragraph(&manoeuvre.verdict());
            // The figures show the first map set.
            if manoeuvre.map_set == cogeneration.manoeuvres[0].map_set {
                self.figures_of(page, &manoeuvre.profile);
            }
        }
        page.note(&cogeneration.definition);
        page.heading("Steady loads");
        let rows: Vec<Vec<Cell>> = cogeneration.load_cells().into_iter().map(plain).collect();
        page.table(&LOADS_HEAD, &rows);
        page.note(
            "Equilibria at a share of design fuel, with the guide vanes where their controller or \
             their stops put them.",
        );
        let file = ("tables/cogeneration_steady.csv", "steady loads");
        page.files("As CSV:", &[(file.0.to_owned(), file.1.to_owned())]);
    }
}
