//! Files with a row for each reading: tag, time, value and, where there is one, quality.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::Path;

use gt_core::Signal;
use gtfdi::ident::Missing;

use super::instant::TimeReader;
use super::number::{Numerals, Sample};
use super::select::names;
use super::sheet::{Cell, Sheet};
use super::tabular::Wanted;
use super::tracks::{Track, Tracks};
use super::wide::{TIME_NAMES, cell_error, check_count, count_word, range_warnings, time_warnings};
use super::{Layout, ReadingError, Selection, Warning};
use crate::LogError;
use crate::error::CellProblem;

const TAG_NAMES: [&str; 4] = ["tag", "tagname", "tag_name", "tag name"];
const VALUE_NAMES: [&str; 1] = ["value"];
const QUALITY_NAMES: [&str; 2] = ["quality", "status"];

/// The columns of a file with a row for each reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Roles {
    pub(crate) tag: usize,
    pub(crate) time: usize,
    pub(crate) value: usize,
    pub(crate) quality: Option<usize>,
}

impl Roles {
    /// The columns, where the header has them and nobody says that it means something else.
    pub(crate) fn of(
        path: &Path,
        header: &[Signal],
        selection: &Selection,
    ) -> Result<Option<Self>, LogError> {
        let layout = selection.reading.layout;
        if layout == Some(Layout::Wide) {
            return Ok(None);
        }
        let find = |wanted: &[&str]| {
            let named = |name: &&str| {
                header
                    .iter()
                    .position(|s| s.name.eq_ignore_ascii_case(name))
            };
            wanted.iter().find_map(named)
        };
        let time = match &selection.time {
            Some(name) => header.iter().position(|signal| signal.name == *name),
            None => find(&TIME_NAMES),
        };
        let found = (find(&TAG_NAMES), time, find(&VALUE_NAMES));
        if let (Some(tag), Some(time), Some(value)) = found {
            let quality = find(&QUALITY_NAMES);
            return Ok(Some(Self {
                tag,
                time,
                value,
                quality,
            }));
        }
        if layout == Some(Layout::Long) {
            let cause = ReadingError::NotLong {
                available: names(header).join(", "),
            };
            return Err(LogError::reading(path, cause));
        }
        Ok(None)
    }
}

impl Roles {
    /// All columns.
    pub(crate) fn all(self) -> Vec<usize> {
        let columns = [
            Some(self.tag),
            Some(self.time),
            Some(self.value),
            self.quality,
        ];
        columns.into_iter().flatten().collect()
    }
}

/// The tags of the rows, in the order of the file.
pub(crate) fn tags(
    path: &Path,
    sheet: &mut impl Sheet,
    roles: Roles,
) -> Result<Vec<Signal>, LogError> {
    let mut seen = HashSet::new();
    let mut tags = Vec::new();
    while sheet.advance()? {
        let tag = match sheet.cell(roles.tag) {
            Cell::Text(tag) => tag,
            Cell::Nothing => continue,
            cell => {
                let problem = CellProblem::NoTag(cell.to_string());
                let header = &sheet.header()[roles.tag];
                return Err(cell_error(path, sheet.place(), header, problem));
            }
        };
        if !tag.is_empty() && !seen.contains(tag) {
            seen.insert(tag.to_owned());
            tags.push(Signal::new(tag, ""));
        }
    }
    if tags.is_empty() {
        return Err(LogError::NoRows {
            path: path.to_owned(),
        });
    }
    Ok(tags)
}

/// What a quality says of a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quality {
    Good,
    Uncertain,
    Bad,
}

impl Quality {
    /// A word, or a number of OPC: 192 and above good, 64 to 127 uncertain, below 64 bad. Nothing is
    /// good.
    pub(crate) fn of(cell: Cell<'_>, numerals: &Numerals) -> Option<Self> {
        let number = match cell {
            Cell::Number(number) => Some(number),
            Cell::Text(text) => text.parse::<f64>().ok(),
            Cell::Nothing => return Some(Self::Good),
            Cell::Instant(_) | Cell::Local(_) => None,
        };
        if let Some(number) = number {
            return match number {
                _ if number.fract() != 0.0 => None,
                0.0..64.0 => Some(Self::Bad),
                64.0..128.0 => Some(Self::Uncertain),
                192.0..256.0 => Some(Self::Good),
                _ => None,
            };
        }
        let Cell::Text(text) = cell else { return None };
        match text.to_lowercase().as_str() {
            "" | "good" | "g" | "ok" => Some(Self::Good),
            "uncertain" | "u" | "questionable" | "substituted" => Some(Self::Uncertain),
            "b" => Some(Self::Bad),
            other if numerals.is_missing(other) => Some(Self::Bad),
            _ => None,
        }
    }
}

/// Reads the readings of the selected tags; `in_file` has all tags under the file's names.
pub(crate) fn read(
    sheet: &mut impl Sheet,
    wanted: &Wanted<'_>,
    roles: Roles,
    in_file: &[Signal],
    mut reader: TimeReader,
) -> Result<Tracks, LogError> {
    let path = wanted.path;
    let header = sheet.header().to_vec();
    let chosen: Vec<usize> = wanted.columns.all().collect();
    let slots = chosen.iter().enumerate();
    let slots: HashMap<&str, usize> = slots
        .map(|(slot, &tag)| (in_file[tag].name.as_str(), slot))
        .collect();
    let mut found = Found {
        tracks: chosen.iter().map(|_| Track::new(reader.clock())).collect(),
        words: BTreeMap::new(),
        uncertain: vec![0; chosen.len()],
        outside: vec![0; chosen.len()],
    };
    while sheet.advance()? {
        let place = sheet.place();
        check_count(path, place, header.len(), sheet.fields())?;
        let at = |(column, problem): (usize, CellProblem)| {
            cell_error(path, place, &header[column], problem)
        };
        let slot = match sheet.cell(roles.tag) {
            Cell::Text("") | Cell::Nothing => {
                let problem = CellProblem::NoTag("an empty cell".to_owned());
                return Err(at((roles.tag, problem)));
            }
            Cell::Text(tag) => slots.get(tag).copied(),
            _ => None,
        };
        let Some(slot) = slot else { continue };
        let last = found.tracks[slot].last_ns();
        let time = reader.read(sheet.cell(roles.time), last);
        let time = time.map_err(|problem| at((roles.time, problem)))?;
        let value = found.value(sheet, wanted, roles, slot).map_err(at)?;
        let value = wanted.conversions[chosen[slot]].of(value);
        found.outside[slot] += usize::from(value.is_none());
        found.tracks[slot].push(time, value.unwrap_or(f64::NAN), place);
    }
    let signals: Vec<Signal> = chosen
        .iter()
        .map(|&tag| wanted.named[tag].clone())
        .collect();
    let mut warnings = time_warnings(&header[roles.time], &reader);
    let counts = signals.iter().zip(&found.uncertain);
    let counts = counts.filter(|&(_, &count)| count > 0);
    warnings.extend(counts.map(|(signal, &count)| Warning::Uncertain {
        column: signal.name.clone(),
        count,
    }));
    warnings.extend(range_warnings(&signals, &found.outside));
    Ok(Tracks {
        signals,
        nu: wanted.columns.inputs.len(),
        readings: found.tracks,
        words: found.words,
        warnings,
    })
}

/// What has been read of the selected tags.
struct Found {
    tracks: Vec<Track>,
    words: BTreeMap<(usize, String), usize>,
    uncertain: Vec<usize>,
    outside: Vec<usize>,
}

impl Found {
    /// The reading of a row; NaN where it is bad or there is none, and that may be. A problem comes
    /// with its column.
    fn value(
        &mut self,
        sheet: &impl Sheet,
        wanted: &Wanted<'_>,
        roles: Roles,
        slot: usize,
    ) -> Result<f64, (usize, CellProblem)> {
        let missing = wanted.selection.missing;
        let mut quality = Quality::Good;
        if let Some(column) = roles.quality {
            let cell = sheet.cell(column);
            quality = Quality::of(cell, wanted.numerals)
                .ok_or_else(|| (column, CellProblem::Quality(cell.to_string())))?;
            if quality == Quality::Bad {
                if missing == Missing::Refuse {
                    return Err((column, CellProblem::BadQuality(cell.to_string())));
                }
                let word = format!("quality {cell}");
                *self.words.entry((slot, word)).or_default() += 1;
                return Ok(f64::NAN);
            }
        }
        let at = |problem| (roles.value, problem);
        let sample = wanted
            .numerals
            .sample(sheet.cell(roles.value))
            .map_err(at)?;
        let value = sample.allowed(missing).map_err(at)?;
        count_word(&mut self.words, slot, sample);
        let is_doubtful = quality == Quality::Uncertain && matches!(sample, Sample::Number(_));
        self.uncertain[slot] += usize::from(is_doubtful);
        Ok(value)
    }
}
