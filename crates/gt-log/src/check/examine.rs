//! A table read to its end, whatever is wrong with it.

use std::collections::BTreeMap;
use std::path::Path;

use gt_core::Signal;

use super::reading::Reading;
use super::{Damage, DamageKind, DataCheck, timing};
use crate::LogError;
use crate::import::{
    Cell, Numerals, Quality, Roles, Selection, Sheet, TimeReader, Tracks, cell_error, check_count,
    chosen_tags, conversions, time_column, time_reader,
};

/// Examines a table.
pub(super) fn examine(
    path: &Path,
    sheet: &mut impl Sheet,
    numerals: &Numerals,
    selection: &Selection,
    report: &mut DataCheck,
) -> Result<(), LogError> {
    let header = sheet.header().to_vec();
    let mut damages = Vec::new();
    if let Some(roles) = Roles::of(path, &header, selection)? {
        report.layout = Some("long");
        let reader = time_reader(path, sheet, roles.time, 0, numerals, &selection.reading)?;
        long(
            path,
            sheet,
            roles,
            (reader, numerals, selection),
            report,
            &mut damages,
        )?;
    } else {
        report.layout = Some("wide");
        wide(path, sheet, numerals, selection, report, &mut damages)?;
    }
    if report.rows == 0 {
        return Err(LogError::NoRows {
            path: path.to_owned(),
        });
    }
    // Those of one place stay in the order in which they were found.
    damages.sort_by_key(|damage| (damage.line, damage.row));
    report.damages.extend(damages);
    Ok(())
}

fn wide(
    path: &Path,
    sheet: &mut impl Sheet,
    numerals: &Numerals,
    selection: &Selection,
    report: &mut DataCheck,
    damages: &mut Vec<Damage>,
) -> Result<(), LogError> {
    let mut header = sheet.header().to_vec();
    let conversions = conversions(path, &mut header, &selection.reading)?;
    let time = time_column(path, &header, selection)?;
    let mut reader = if let Some(column) = time {
        Some(time_reader(
            path,
            sheet,
            column,
            0,
            numerals,
            &selection.reading,
        )?)
    } else {
        None
    };
    let chosen = chosen_tags(path, &header, time, selection)?;
    let mut readings: Vec<Reading> = chosen
        .iter()
        .map(|&tag| Reading::new(&header[tag], None))
        .collect();
    let mut clock = reader.as_ref().map(TimeReader::clock);
    let mut timed = Vec::new();
    while sheet.advance()? {
        report.rows += 1;
        let place = sheet.place();
        if let Err(error) = check_count(path, place, header.len(), sheet.fields()) {
            damages.push(Damage::at(DamageKind::Row, place, None, &error, None));
            continue;
        }
        for (reading, &column) in readings.iter_mut().zip(&chosen) {
            let value = reading.take(path, place, sheet.cell(column), numerals);
            let value = reading.convert(&conversions[column], value);
            reading.push(place, value);
        }
        if let (Some(column), Some(reader), Some(clock)) = (time, &mut reader, &mut clock) {
            match reader.push(sheet.cell(column), clock) {
                Ok(()) => timed.push(place),
                Err(problem) => {
                    let error = cell_error(path, place, &header[column], problem);
                    damages.push(Damage::of_cell(place, &error));
                }
            }
        }
    }
    if let (Some(column), Some(clock)) = (time, &clock) {
        let name = &header[column].name;
        report.time = Some(timing::times(path, name, None, clock, &timed, damages));
    }
    let is_selected = !selection.inputs.is_empty() || !selection.outputs.is_empty();
    let mut values = Vec::new();
    for reading in readings {
        let (check, found, own) = reading.finish(is_selected);
        report.tags.push(check);
        damages.extend(found);
        values.push(own);
    }
    report.suggest(&values, true);
    Ok(())
}

fn long(
    path: &Path,
    sheet: &mut impl Sheet,
    roles: Roles,
    (mut reader, numerals, selection): (TimeReader, &Numerals, &Selection),
    report: &mut DataCheck,
    damages: &mut Vec<Damage>,
) -> Result<(), LogError> {
    let header = sheet.header().to_vec();
    sheet.load(&roles.all())?;
    let mut readings: Vec<Reading> = Vec::new();
    let mut slots: BTreeMap<String, usize> = BTreeMap::new();
    while sheet.advance()? {
        report.rows += 1;
        let place = sheet.place();
        if let Err(error) = check_count(path, place, header.len(), sheet.fields()) {
            damages.push(Damage::at(DamageKind::Row, place, None, &error, None));
            continue;
        }
        let tag = match sheet.cell(roles.tag) {
            Cell::Text(tag) if !tag.is_empty() => tag.to_owned(),
            cell => {
                let problem = crate::CellProblem::NoTag(match cell {
                    Cell::Text(_) | Cell::Nothing => "an empty cell".to_owned(),
                    other => other.to_string(),
                });
                let error = cell_error(path, place, &header[roles.tag], problem);
                damages.push(Damage::of_cell(place, &error));
                continue;
            }
        };
        let slot = *slots.entry(tag.clone()).or_insert_with(|| {
            readings.push(Reading::new(&Signal::new(&*tag, ""), Some(reader.clock())));
            readings.len() - 1
        });
        let reading = &mut readings[slot];
        let quality = roles.quality.map(|column| (column, sheet.cell(column)));
        let bad = quality.is_some_and(|(column, cell)| {
            let problem = match Quality::of(cell, numerals) {
                Some(Quality::Good | Quality::Uncertain) => return false,
                Some(Quality::Bad) => crate::CellProblem::BadQuality(cell.to_string()),
                None => crate::CellProblem::Quality(cell.to_string()),
            };
            let damage = Damage::of_cell(place, &cell_error(path, place, &header[column], problem));
            let tag = Some(tag.clone());
            damages.push(Damage { tag, ..damage });
            true
        });
        let value = if bad {
            reading.check.missing += 1;
            f64::NAN
        } else {
            reading.take(path, place, sheet.cell(roles.value), numerals)
        };
        let Some(clock) = &mut reading.clock else {
            continue;
        };
        match reader.push(sheet.cell(roles.time), clock) {
            Ok(()) => {
                reading.push(place, value);
            }
            Err(problem) => {
                let error = cell_error(path, place, &header[roles.time], problem);
                let tag = Some(tag);
                damages.push(Damage {
                    tag,
                    ..Damage::of_cell(place, &error)
                });
            }
        }
    }
    let aligned = long_times(
        path,
        &header[roles.time].name,
        &mut readings,
        report,
        damages,
    );
    let mut named: Vec<Signal> = readings
        .iter()
        .map(|reading| Signal::new(&*reading.check.name, ""))
        .collect();
    let conversions = conversions(path, &mut named, &selection.reading)?;
    let chosen = chosen_tags(path, &named, None, selection)?;
    let is_selected = !selection.inputs.is_empty() || !selection.outputs.is_empty();
    let mut values = Vec::new();
    for (index, mut reading) in readings.into_iter().enumerate() {
        if !chosen.contains(&index) {
            continue;
        }
        reading.check.name.clone_from(&named[index].name);
        reading.check.unit.clone_from(&named[index].unit);
        for sample in 0..reading.values.len() {
            let value = reading.values[sample];
            reading.values[sample] = reading.convert(&conversions[index], value);
        }
        let (check, found, own) = reading.finish(is_selected);
        report.tags.push(check);
        damages.extend(found);
        values.push(own);
    }
    report.suggest(&values, aligned);
    Ok(())
}

/// Reports the times of the tag that has the most of them; whether all have the same.
fn long_times(
    path: &Path,
    column: &str,
    readings: &mut [Reading],
    report: &mut DataCheck,
    damages: &mut Vec<Damage>,
) -> bool {
    for reading in readings.iter_mut() {
        let Some(clock) = reading.clock.take() else {
            continue;
        };
        let sorted = Tracks::in_order(clock, &mut reading.values, &mut reading.places);
        reading.clock = Some(sorted);
    }
    let Some(first) = readings.first() else {
        return true;
    };
    let odd = readings.iter().find(|reading| reading.clock != first.clock);
    if let Some(odd) = odd {
        let cause = crate::ReadingError::OwnTimes {
            first: first.check.name.clone(),
            first_count: first.values.len(),
            other: odd.check.name.clone(),
            other_count: odd.values.len(),
        };
        damages.push(Damage::of_file(&LogError::reading(path, cause)));
    }
    let is_odd = odd.is_some();
    for reading in readings.iter() {
        let Some(clock) = &reading.clock else {
            continue;
        };
        let mut found = Vec::new();
        let tag = Some(reading.check.name.as_str());
        let check = timing::times(path, column, tag, clock, &reading.places, &mut found);
        let longest = report
            .time
            .as_ref()
            .is_none_or(|time| check.count > time.count);
        if longest {
            report.time = Some(check);
        }
        // Where tags have times of their own, resampling is asked for once, above.
        let is_step =
            |damage: &Damage| matches!(damage.kind, DamageKind::Gap | DamageKind::Step) && is_odd;
        damages.extend(found.into_iter().filter(|damage| !is_step(damage)));
    }
    !is_odd
}
