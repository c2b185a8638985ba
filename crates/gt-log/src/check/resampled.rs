//! A table as the samples that resampling makes of it.

use std::path::Path;

use gt_core::Signal;
use gtfdi::ident::Missing;

use super::reading::Reading;
use super::{Damage, DamageKind, DataCheck, TagKind, TimeCheck};
use crate::import::{ReadingError, Selection, read_dataset};
use crate::{LogError, Place};

/// Puts the samples of a table that was examined in the place of its rows, and takes away the
/// damages that resampling mends. Where it cannot be resampled yet, a damage says why.
pub(super) fn examine(path: &Path, selection: &Selection, report: &mut DataCheck) {
    let numbers = report.tags.iter().filter(|tag| tag.kind == TagKind::Number);
    let names: Vec<String> = numbers.map(|tag| tag.name.clone()).collect();
    if names.is_empty() {
        return;
    }
    let wanted = Selection {
        inputs: Vec::new(),
        outputs: names,
        missing: Missing::Break,
        rows: None,
        ..selection.clone()
    };
    let imported = match read_dataset(path, &wanted) {
        Ok(imported) => imported,
        Err(error) => {
            let known = |damage: &Damage| damage.text == error.to_string();
            if !report.damages.iter().any(known) {
                report.damages.push(Damage::of_file(&error));
            }
            return;
        }
    };
    let data = &imported.dataset;
    let breaks = selection.missing == Missing::Break;
    report.damages.retain(|damage| !is_mended(damage, breaks));
    let column = report.time.take().map(|time| time.column);
    let times = |column| TimeCheck::of_samples(column, data.len(), data.sample_time_s());
    report.time = column.map(times);
    let mut values = Vec::new();
    let mut rows = data.outputs().iter().zip(data.y().row_iter());
    for tag in &mut report.tags {
        // Texts and what is empty have no samples.
        let next = if tag.kind == TagKind::Number {
            rows.next()
        } else {
            None
        };
        let Some((signal, row)) = next else {
            values.push(Vec::new());
            continue;
        };
        let mut reading = Reading::new(signal, None);
        for (sample, &value) in row.iter().enumerate() {
            if value.is_nan() {
                reading.miss("no reading", None);
            }
            reading.push_number(Place::Row(sample), value);
        }
        report.damages.extend(missing(path, signal, &reading));
        let (check, _, own) = reading.finish(true);
        *tag = check;
        values.push(own);
    }
    report.suggest(&values, true);
    report.resampled = imported.resampled;
}

/// Whether the record that is resampled has a damage no more; missing cells are passed over where
/// they break it.
fn is_mended(damage: &Damage, breaks: bool) -> bool {
    match damage.kind {
        DamageKind::Duplicate | DamageKind::Gap | DamageKind::Step => true,
        _ => match damage.mended_by {
            Some("--resample") => true,
            Some("--missing") => breaks,
            _ => false,
        },
    }
}

/// Samples for which there is no reading, one damage a tag.
fn missing(path: &Path, signal: &Signal, reading: &Reading) -> Option<Damage> {
    let first = reading.values.iter().position(|value| value.is_nan())?;
    let cause = ReadingError::NoReading {
        tag: signal.name.clone(),
        missing: reading.check.missing,
        samples: reading.values.len(),
        first,
    };
    let error = LogError::reading(path, cause);
    let (place, tag) = (Place::Row(first), Some(signal.name.as_str()));
    Some(Damage::at(
        DamageKind::Missing,
        place,
        tag,
        &error,
        Some("--missing"),
    ))
}
