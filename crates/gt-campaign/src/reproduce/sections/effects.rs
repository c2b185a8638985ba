//! The section on what the faults do to the outputs.

use gtfdi::plant::effects::{MONITORED, Reading};

use super::super::Reproduction;
use super::super::cells::{EFFECTS_HEAD, MONITORED_HEAD};
use super::super::html::plain;
use super::super::tables::{Effects, PaperSignature, Tables};
use crate::report::page::{Cell, Page};
use crate::report::text::digits;

impl Reproduction {
    /// The sensitivity matrices and the lag limit.
    pub(in super::super) fn fault_effects(&self, page: &mut Page) {
        let tables = &self.tables;
        page.section("effects", "Fault effects");
        page.paragraph(&tables.effects_verdict());
        for (map_set, effects) in tables.effects_in_order() {
            page.paragraph(&effects.lag_sentence(map_set));
        }
        page.paragraph(&tables.lag_limit_sentence());
        for (map_set, effects) in tables.effects_in_order() {
            for (what, reading, signature) in effects.readings() {
                let pattern = pattern(signature);
                page.heading(&format!(
                    "{what}, {map_set} maps: the monitored outputs ({pattern})"
                ));
                let shares = signature.signature.share.clone();
                let rows: Vec<Vec<Cell>> = effects
                    .monitored_cells(reading, &signature.signature)
                    .into_iter()
                    .enumerate()
                    .map(|(case, cells)| {
                        let cells = cells.into_iter().enumerate();
                        cells
                            .map(|(column, cell)| match column {
                                1..=4 => Cell::shaded(cell, shares[(column - 1, case)]),
                                _ => Cell::plain(cell),
                            })
                            .collect()
                    })
                    .collect();
                page.table(&MONITORED_HEAD, &rows);
            }
        }
        page.note(SHARE_NOTE);
        for (map_set, effects) in tables.effects_in_order() {
            let ranges = [
                &effects.case4_raw_range_percent,
                &effects.case4_inputs_held_range_percent,
            ];
            for ((what, reading, _), range) in effects.readings().into_iter().zip(ranges) {
                let title = format!("All 28 outputs: {what}, {map_set} maps");
                let open = map_set == "paper";
                page.fold(&title, open, |page| {
                    let cells = effects.cells(reading, range);
                    let rows: Vec<Vec<Cell>> = cells.into_iter().map(plain).collect();
                    page.table(&EFFECTS_HEAD, &rows);
                });
            }
        }
        if let Some((_, effects)) = tables.effects_in_order().next() {
            page.note(&effects.definition);
        }
        let files: Vec<(String, String)> = tables
            .effects_in_order()
            .map(|(map_set, _)| {
                let address = format!("tables/fault_effects_{map_set}.csv");
                (address, format!("{map_set} maps"))
            })
            .collect();
        page.files("All numbers as CSV:", &files);
    }
}

/// How to read the tables of the monitored outputs.
pub(in super::super) const SHARE_NOTE: &str = "\
rms in percent of the steady value and, in brackets, over the largest of the four cases on the same \
output. Diagonal: every output is moved most by the case that the paper assigns to it.";

fn pattern(signature: &PaperSignature) -> &'static str {
    if signature.diagonal {
        "diagonal"
    } else {
        "not diagonal"
    }
}

impl Tables {
    /// The effects by map set, the default maps first.
    pub(in super::super) fn effects_in_order(&self) -> impl Iterator<Item = (&str, &Effects)> {
        // The map sets stand in the order of the alphabet, `axial` before `paper`.
        self.fault_effects
            .iter()
            .rev()
            .map(|(map_set, effects)| (map_set.as_str(), effects))
    }

    /// Which of the signatures are the paper's, and what the others do instead.
    pub(in super::super) fn effects_verdict(&self) -> String {
        let mut diagonal = 0;
        let mut others = Vec::new();
        let mut readings = 0;
        for (map_set, effects) in self.effects_in_order() {
            for (what, _, PaperSignature { signature, .. }) in effects.readings() {
                readings += 1;
                let strongest = MONITORED.iter().zip(signature.strongest_case).zip(1..);
                let wrong: Vec<String> = strongest
                    .filter(|((_, case), own)| *case != Some(*own))
                    .map(|((output, case), _)| {
                        let case = case.map_or_else(|| "none".to_owned(), |case| case.to_string());
                        format!("{output} is moved most by case {case}")
                    })
                    .collect();
                if wrong.is_empty() {
                    diagonal += 1;
                } else {
                    let what = what.to_lowercase();
                    others.push(format!("{map_set} maps, {what}: {}", wrong.join(", ")));
                }
            }
        }
        let others = if others.is_empty() {
            String::new()
        } else {
            format!(" ({})", others.join("; "))
        };
        format!(
            "The pattern of Table 2, one output a fault, in plain percentages at the sizes below (5 % \
             and a lag of 2 s): {diagonal} of {readings} readings are diagonal{others}. The effect of \
             a lag grows with its size, which the paper does not print; features that tell slow from \
             fast, as in Table 9 below, separate more than the percentages here."
        )
    }

    /// Where the speed loop loses its stability.
    pub(in super::super) fn lag_limit_sentence(&self) -> String {
        let limits = self.lag_limit.iter().rev();
        let limits: Vec<String> = limits
            .map(|(map_set, limit)| match limit {
                Some(limit) => format!(
                    "{map_set} maps {:.2} s, where a mode of {:.2} rad/s neither decays nor grows",
                    limit.lag_s, limit.frequency_rad_s
                ),
                None => format!("{map_set} maps none up to 1000 s"),
            })
            .collect();
        format!(
            "Lag of the fuel actuator at which the speed loop, linearised at the design point, loses \
             its stability: {}.",
            limits.join("; ")
        )
    }
}

impl Effects {
    /// Both readings, with their names and signatures.
    pub(in super::super) fn readings(&self) -> [(&'static str, &Reading, &PaperSignature); 2] {
        [
            ("Raw outputs", &self.raw, &self.signature_raw),
            (
                "Inputs held",
                &self.inputs_held,
                &self.signature_inputs_held,
            ),
        ]
    }

    /// That case 4 is an effect of the demanded fuel as input.
    pub(in super::super) fn lag_sentence(&self, map_set: &str) -> String {
        let m9 = self
            .row("m9")
            .map_or(f64::NAN, |row| self.inputs_held.rms_percent[(row, 3)]);
        let left = self.largest_delivered_percent();
        format!(
            "Case 4, {map_set} maps: with demanded fuel as input it moves m9 by {m9:.2} % rms; with \
             delivered fuel as input nothing of it is left ({} % in the largest of 28 outputs).",
            digits(left, 1)
        )
    }
}
