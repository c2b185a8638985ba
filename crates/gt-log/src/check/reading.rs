//! What is read of a tag, on its way to a check.

use std::collections::BTreeMap;
use std::path::Path;

use gt_core::Signal;
use gtfdi::ident::Missing;

use super::{Damage, DamageKind, TagCheck, TagKind, tag};
use crate::Place;
use crate::import::{Cell, Conversion, Numerals, Sample, cell_error};
use crate::time::Clock;

/// What is read of a tag.
pub(super) struct Reading {
    pub(super) check: TagCheck,
    pub(super) values: Vec<f64>,
    pub(super) places: Vec<Place>,
    /// The times of a tag that has its own.
    pub(super) clock: Option<Clock>,
    /// Cells that are neither numbers nor words for missing ones.
    texts: Vec<Damage>,
}

impl Reading {
    /// A tag of which nothing is read yet.
    pub(super) fn new(signal: &Signal, clock: Option<Clock>) -> Self {
        Self {
            check: TagCheck {
                name: signal.name.clone(),
                unit: signal.unit.clone(),
                kind: TagKind::Empty,
                values: 0,
                missing: 0,
                words: BTreeMap::new(),
                minimum: None,
                maximum: None,
                constant: false,
                longest_run: None,
                usual_run: None,
                frozen: false,
                at_minimum_share: None,
                at_maximum_share: None,
                quantisation_step: None,
                outliers: Vec::new(),
                excitation_order: None,
            },
            values: Vec::new(),
            places: Vec::new(),
            clock,
            texts: Vec::new(),
        }
    }

    /// Takes a cell for what it is; a damage is one of the tag.
    pub(super) fn take(
        &mut self,
        path: &Path,
        place: Place,
        cell: Cell<'_>,
        numerals: &Numerals,
    ) -> f64 {
        let signal = Signal::new(&*self.check.name, "");
        let problem = |problem| Damage::of_cell(place, &cell_error(path, place, &signal, problem));
        match numerals.sample(cell) {
            Ok(Sample::Number(value)) => {
                self.check.kind = TagKind::Number;
                value
            }
            Ok(sample @ Sample::Missing(word)) => {
                let damage = sample.allowed(Missing::Refuse).err().map(problem);
                self.miss(word, damage);
                f64::NAN
            }
            Err(found) => {
                self.texts.push(problem(found));
                f64::NAN
            }
        }
    }

    /// A value in the record's unit; NaN where it is out of range, which counts as missing.
    pub(super) fn convert(&mut self, conversion: &Conversion, value: f64) -> f64 {
        conversion.of(value).unwrap_or_else(|| {
            self.miss("out of range", None);
            f64::NAN
        })
    }

    /// Counts a missing value under the word that stands for it.
    pub(super) fn miss(&mut self, word: &str, damage: Option<Damage>) {
        self.check.missing += 1;
        *self.check.words.entry(word.to_owned()).or_default() += 1;
        self.texts.extend(damage);
    }

    /// Takes a sample that is a number for what it is; another is NaN.
    pub(super) fn push_number(&mut self, place: Place, value: f64) {
        if value.is_finite() {
            self.check.kind = TagKind::Number;
        }
        self.push(place, value);
    }

    /// Appends a sample.
    pub(super) fn push(&mut self, place: Place, value: f64) {
        self.values.push(value);
        self.places.push(place);
    }

    /// Keeps a damage of the tag.
    pub(super) fn refuse(&mut self, damage: Damage) {
        self.texts.push(damage);
    }

    /// The tag, its damages and its values. Texts where nothing is a number are a column of texts: no
    /// damage, unless the tag is selected.
    pub(super) fn finish(mut self, is_selected: bool) -> (TagCheck, Vec<Damage>, Vec<f64>) {
        tag::describe(&mut self.check, &self.values, &self.places);
        let numbers = self
            .texts
            .iter()
            .filter(|damage| damage.kind == DamageKind::Number);
        let mut others = numbers.map(|damage| damage.mended_by == Some("--bad-values"));
        let is_text = others.next() == Some(true) && others.all(|is_other| is_other);
        if self.check.kind == TagKind::Empty && is_text {
            self.check.kind = TagKind::Text;
            if !is_selected {
                self.texts.clear();
            }
        }
        (self.check, self.texts, self.values)
    }
}
