//! Cells into times.

use jiff::Timestamp;
use jiff::civil::{DateTime, Time, date};
use jiff::fmt::strtime::BrokenDownTime;
use jiff::tz::{AmbiguousOffset, TimeZone};

use super::number::Numerals;
use super::sheet::Cell;
use super::{Reading, ReadingError, Warning};
use crate::error::CellProblem;
use crate::time::Clock;

/// Microseconds of a day.
const DAY_US: f64 = 86_400e6;
/// Dates that are read unasked; those with a slash or a dash between numbers say neither day nor
/// month by themselves.
const DATES: [&str; 5] = ["%Y/%m/%d", "%d.%m.%Y", "%d-%b-%y", "%d-%b-%Y", "%d %b %Y"];
const DAY_FIRST: [&str; 2] = ["%d/%m/%Y", "%d-%m-%Y"];
const MONTH_FIRST: [&str; 2] = ["%m/%d/%Y", "%m-%d-%Y"];
/// Times of day that follow a date.
const CLOCKS: [&str; 6] = [
    " %H:%M:%S%.f",
    " %H:%M",
    " %I:%M:%S%.f %p",
    " %I:%M %p",
    "T%H:%M:%S%.f",
    "",
];

/// How the times of a file are written.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum TimeForm {
    /// Seconds since an unknown instant.
    Seconds,
    /// Units of so many nanoseconds since 1970.
    Epoch(i128),
    /// ISO 8601.
    Iso,
    /// In the letters of strptime.
    Pattern(String),
    /// Days since the last but one of 1899.
    Excel,
}

/// A time of a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum FileTime {
    /// Seconds since an unknown instant.
    Seconds(f64),
    /// Nanoseconds since 1970.
    Nanoseconds(i128),
}

/// A cell that outlives its row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum OwnCell {
    Text(String),
    Number(f64),
    /// A time that the file knows as such.
    Time,
    Nothing,
}

impl OwnCell {
    pub(crate) fn of(cell: Cell<'_>) -> Self {
        match cell {
            Cell::Text(text) => Self::Text(text.to_owned()),
            Cell::Number(number) => Self::Number(number),
            Cell::Instant(_) | Cell::Local(_) => Self::Time,
            Cell::Nothing => Self::Nothing,
        }
    }
}

/// Reads the times of a file.
#[derive(Debug, Clone)]
pub(crate) struct TimeReader {
    pub(crate) form: TimeForm,
    /// Whether the form was found out rather than given.
    recognised: bool,
    zone: TimeZone,
    zone_name: String,
    numerals: Numerals,
    /// Times that stand twice in their zone and were told apart by their order.
    pub(crate) folded: usize,
}

impl TimeReader {
    /// A reader of times like those in `cells`, of which as many are looked at as it takes.
    pub(crate) fn new(
        column: &str,
        mut cells: impl Iterator<Item = OwnCell>,
        reading: &Reading,
        numerals: &Numerals,
    ) -> Result<Self, ReadingError> {
        let form = match reading.time_format.as_deref() {
            Some(excel) if excel.eq_ignore_ascii_case("excel") => TimeForm::Excel,
            Some(format) => TimeForm::Pattern(format.to_owned()),
            None => match cells.next() {
                Some(OwnCell::Text(first)) => form_of(column, &first, cells, numerals)?,
                Some(OwnCell::Number(first)) => form_of_number(first),
                Some(OwnCell::Time) => TimeForm::Iso,
                Some(OwnCell::Nothing) | None => TimeForm::Seconds,
            },
        };
        Ok(Self {
            form,
            recognised: reading.time_format.is_none(),
            zone: reading.zone()?,
            zone_name: reading.time_zone.clone().unwrap_or_else(|| "UTC".into()),
            numerals: numerals.clone(),
            folded: 0,
        })
    }

    /// What the user should know of the form that was recognised.
    pub(crate) fn taken_as(&self, column: &str) -> Option<Warning> {
        let column = column.to_owned();
        match &self.form {
            TimeForm::Epoch(unit_ns) => Some(Warning::EpochTimes {
                column,
                unit: epoch_unit(*unit_ns),
            }),
            TimeForm::Pattern(format) if self.recognised => Some(Warning::TimesRead {
                column,
                format: format.clone(),
            }),
            _ => None,
        }
    }

    /// A clock for the times.
    pub(crate) fn clock(&self) -> Clock {
        match self.form {
            TimeForm::Seconds => Clock::Seconds(Vec::new()),
            _ => Clock::Nanoseconds(Vec::new()),
        }
    }

    /// The time of a cell that stands after the last one of `clock`.
    pub(crate) fn push(&mut self, cell: Cell<'_>, clock: &mut Clock) -> Result<(), CellProblem> {
        let previous = match clock {
            Clock::Nanoseconds(times) => times.last().copied(),
            Clock::Seconds(_) => None,
        };
        match (self.read(cell, previous)?, clock) {
            (FileTime::Seconds(time), Clock::Seconds(times)) => times.push(time),
            (FileTime::Nanoseconds(time), Clock::Nanoseconds(times)) => times.push(time),
            (_, _) => return Err(self.unlike(cell)),
        }
        Ok(())
    }

    /// The time of a cell; `previous` tells apart what a clock that is put back says twice.
    pub(crate) fn read(
        &mut self,
        cell: Cell<'_>,
        previous: Option<i128>,
    ) -> Result<FileTime, CellProblem> {
        let text = match (cell, &self.form) {
            (Cell::Text("") | Cell::Nothing, _) => return Err(CellProblem::Empty),
            (Cell::Text(text), _) => text,
            (Cell::Number(seconds), TimeForm::Seconds) if seconds.is_finite() => {
                return Ok(FileTime::Seconds(seconds));
            }
            (Cell::Number(number), TimeForm::Epoch(unit_ns)) if number.abs() < 1e21 => {
                return Ok(FileTime::Nanoseconds(units_ns(number, *unit_ns)));
            }
            (Cell::Number(days), TimeForm::Excel) => {
                let civil = excel(days).ok_or_else(|| self.unlike(cell))?;
                return self.instant(civil, previous).map(FileTime::Nanoseconds);
            }
            (Cell::Instant(ns), form) if *form != TimeForm::Seconds => {
                return Ok(FileTime::Nanoseconds(ns));
            }
            (Cell::Local(ns), form) if *form != TimeForm::Seconds => {
                let civil = Timestamp::from_nanosecond(ns).map_err(|_| self.unlike(cell))?;
                let civil = civil.to_zoned(TimeZone::UTC).datetime();
                return self.instant(civil, previous).map(FileTime::Nanoseconds);
            }
            _ => return Err(self.unlike(cell)),
        };
        let unlike = || self.unlike(cell);
        let civil = match &self.form {
            TimeForm::Seconds => {
                let seconds = self.numerals.parse(text).ok_or_else(unlike)?;
                if !seconds.is_finite() {
                    return Err(CellProblem::NotFinite(text.to_owned()));
                }
                return Ok(FileTime::Seconds(seconds));
            }
            TimeForm::Epoch(unit_ns) => {
                let time = epoch_ns(text, *unit_ns).ok_or_else(unlike)?;
                return Ok(FileTime::Nanoseconds(time));
            }
            TimeForm::Iso => match text.parse::<Timestamp>() {
                Ok(instant) => return Ok(FileTime::Nanoseconds(instant.as_nanosecond())),
                Err(_) => text.parse::<DateTime>().ok(),
            },
            TimeForm::Pattern(format) => match parsed(format, text) {
                Some(Parsed::Instant(instant)) => {
                    return Ok(FileTime::Nanoseconds(instant.as_nanosecond()));
                }
                Some(Parsed::Civil(civil)) => Some(civil),
                None => None,
            },
            TimeForm::Excel => self.numerals.parse(text).and_then(excel),
        };
        let civil = civil.ok_or_else(unlike)?;
        self.instant(civil, previous).map(FileTime::Nanoseconds)
    }

    fn unlike(&self, cell: Cell<'_>) -> CellProblem {
        let found = cell.to_string();
        match &self.form {
            TimeForm::Pattern(format) => CellProblem::TimeFormat {
                found,
                expected: format!("a time like `{format}`"),
            },
            TimeForm::Excel => CellProblem::TimeFormat {
                found,
                expected: "a day of a spreadsheet (45000.25), as --time-format says".to_owned(),
            },
            TimeForm::Epoch(unit_ns) => CellProblem::TimeFormat {
                found,
                expected: format!("{} since 1970, as before", epoch_unit(*unit_ns)),
            },
            TimeForm::Seconds | TimeForm::Iso => CellProblem::Time(found),
        }
    }

    /// The instant of a local time.
    fn instant(&mut self, civil: DateTime, previous: Option<i128>) -> Result<i128, CellProblem> {
        let unlike = || CellProblem::Time(civil.to_string());
        let at = |offset: jiff::tz::Offset| {
            let instant = offset.to_timestamp(civil).map_err(|_| unlike())?;
            Ok::<i128, CellProblem>(instant.as_nanosecond())
        };
        match self.zone.to_ambiguous_timestamp(civil).offset() {
            AmbiguousOffset::Unambiguous { offset } => at(offset),
            AmbiguousOffset::Gap { .. } => Err(CellProblem::NoSuchTime {
                found: civil.to_string(),
                zone: self.zone_name.clone(),
            }),
            AmbiguousOffset::Fold { before, after } => {
                self.folded += 1;
                let first = at(before)?;
                if previous.is_some_and(|previous| previous >= first) {
                    at(after)
                } else {
                    Ok(first)
                }
            }
        }
    }
}

/// The name of a unit of so many nanoseconds.
pub(crate) fn epoch_unit(unit_ns: i128) -> &'static str {
    match unit_ns {
        1_000_000_000 => "seconds",
        1_000_000 => "milliseconds",
        1_000 => "microseconds",
        _ => "nanoseconds",
    }
}

/// Numbers as large as those since 1970 are such times.
fn form_of_number(number: f64) -> TimeForm {
    let units = [
        (1e18, 1),
        (1e15, 1_000),
        (1e12, 1_000_000),
        (1e9, 1_000_000_000),
    ];
    let unit = units.into_iter().find(|&(least, _)| number >= least);
    unit.map_or(TimeForm::Seconds, |(_, unit_ns)| TimeForm::Epoch(unit_ns))
}

fn form_of(
    column: &str,
    first: &str,
    rest: impl Iterator<Item = OwnCell>,
    numerals: &Numerals,
) -> Result<TimeForm, ReadingError> {
    if let Some(number) = numerals.parse(first) {
        let units = [
            (1e18, 1),
            (1e15, 1_000),
            (1e12, 1_000_000),
            (1e9, 1_000_000_000),
        ];
        let unit = units.into_iter().find(|&(least, _)| number >= least);
        return Ok(unit.map_or(TimeForm::Seconds, |(_, unit_ns)| TimeForm::Epoch(unit_ns)));
    }
    if first.parse::<Timestamp>().is_ok() || first.parse::<DateTime>().is_ok() {
        return Ok(TimeForm::Iso);
    }
    if let Some(format) = fitting(&DATES, first) {
        return Ok(TimeForm::Pattern(format));
    }
    let both = (fitting(&DAY_FIRST, first), fitting(&MONTH_FIRST, first));
    let (day_first, month_first) = match both {
        (Some(day_first), Some(month_first)) => (day_first, month_first),
        (Some(only), None) | (None, Some(only)) => return Ok(TimeForm::Pattern(only)),
        (None, None) => return Ok(TimeForm::Seconds),
    };
    for cell in rest {
        let OwnCell::Text(cell) = cell else { continue };
        let fits = |format: &str| parsed(format, &cell).is_some();
        match (fits(&day_first), fits(&month_first)) {
            (true, false) => return Ok(TimeForm::Pattern(day_first)),
            (false, true) => return Ok(TimeForm::Pattern(month_first)),
            _ => {}
        }
    }
    Err(ReadingError::DayOrMonth {
        column: column.to_owned(),
        found: first.to_owned(),
        day_first,
        month_first,
    })
}

/// The first format of one of these dates and a time of day that a text has.
fn fitting(dates: &[&str], text: &str) -> Option<String> {
    let formats = dates
        .iter()
        .flat_map(|date| CLOCKS.iter().map(move |clock| format!("{date}{clock}")));
    formats
        .into_iter()
        .find(|format| parsed(format, text).is_some())
}

enum Parsed {
    Instant(Timestamp),
    Civil(DateTime),
}

fn parsed(format: &str, text: &str) -> Option<Parsed> {
    let read = |text: &str| BrokenDownTime::parse(format, text).ok();
    // The fraction of a second may follow a decimal comma.
    let time = read(text).or_else(|| read(&text.replacen(',', ".", 1)))?;
    if time.offset().is_some() {
        return time.to_timestamp().ok().map(Parsed::Instant);
    }
    let whole = time.to_datetime().ok();
    let midnight = |day| DateTime::from_parts(day, Time::midnight());
    let civil = whole.or_else(|| time.to_date().ok().map(midnight))?;
    // `%Y` takes the 26 of 2026 for a year.
    (civil.year() >= 1000).then_some(Parsed::Civil(civil))
}

/// The time of a day of a spreadsheet, to a microsecond. Days before March 1900, which
/// spreadsheets number in two ways, are none.
#[expect(
    clippy::cast_possible_truncation,
    reason = "the range is checked first"
)]
fn excel(days: f64) -> Option<DateTime> {
    if !(61.0..2_958_466.0).contains(&days) {
        return None;
    }
    let span = jiff::SignedDuration::from_micros((days * DAY_US).round() as i64);
    date(1899, 12, 30).at(0, 0, 0, 0).checked_add(span).ok()
}

/// Nanoseconds since 1970 of a number of units, exactly as its digits say.
fn epoch_ns(text: &str, unit_ns: i128) -> Option<i128> {
    let point = text.replacen(',', ".", 1);
    let (whole, fraction) = point.split_once('.').unwrap_or((point.as_str(), ""));
    let is_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let places = u32::try_from(fraction.len()).ok()?;
    if is_digits(whole) && is_digits(fraction) && (1..=21).contains(&whole.len()) && places <= 9 {
        let scale = 10_i128.pow(places);
        let digits: i128 = format!("{whole}{fraction}").parse().ok()?;
        let scaled = digits.checked_mul(unit_ns)?;
        return Some((scaled + scale / 2) / scale);
    }
    let number: f64 = point.parse().ok()?;
    (number.abs() < 1e21).then(|| units_ns(number, unit_ns))
}

/// Nanoseconds of a number of units; whole numbers exactly.
#[expect(
    clippy::cast_possible_truncation,
    reason = "the range is checked first"
)]
fn units_ns(number: f64, unit_ns: i128) -> i128 {
    let whole = number.trunc();
    whole as i128 * unit_ns + ((number - whole) * unit_ns as f64).round() as i128
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::Decimal;
    fn reader(cells: &[&str], reading: &Reading) -> Result<TimeReader, ReadingError> {
        let numerals = Numerals::new(Decimal::Point, reading);
        let cells = cells.iter().map(|&cell| OwnCell::Text(cell.to_owned()));
        TimeReader::new("time", cells, reading, &numerals)
    }

    /// The instants of times in UTC.
    fn read(cells: &[&str], reading: &Reading) -> Vec<String> {
        let mut reader = self::reader(cells, reading).unwrap();
        let mut clock = reader.clock();
        for cell in cells {
            reader.push(Cell::Text(cell), &mut clock).unwrap();
        }
        let Clock::Nanoseconds(times) = clock else {
            panic!("expected instants");
        };
        let shown = |&ns: &i128| Timestamp::from_nanosecond(ns).unwrap().to_string();
        times.iter().map(shown).collect()
    }

    #[test]
    fn common_forms_are_known() {
        let cases = [
            ("2026-04-03T10:20:30Z", "2026-04-03T10:20:30Z"),
            ("2026-04-03 10:20:30.25", "2026-04-03T10:20:30.25Z"),
            ("2026-04-03T10:20:30+02:00", "2026-04-03T08:20:30Z"),
            ("2026/04/03 10:20", "2026-04-03T10:20:00Z"),
            ("03.04.2026 10:20:30", "2026-04-03T10:20:30Z"),
            ("03.04.2026 10:20:30,5", "2026-04-03T10:20:30.5Z"),
            ("03.04.2026", "2026-04-03T00:00:00Z"),
            ("03-Apr-2026 10:20:30.250", "2026-04-03T10:20:30.25Z"),
            ("03-Apr-26 10:20:30", "2026-04-03T10:20:30Z"),
            ("13/04/2026 10:20:30", "2026-04-13T10:20:30Z"),
            ("4/13/2026 1:20:30 PM", "2026-04-13T13:20:30Z"),
            ("4/13/2026 12:20 AM", "2026-04-13T00:20:00Z"),
            ("1775211630", "2026-04-03T10:20:30Z"),
            ("1775211630.000000001", "2026-04-03T10:20:30.000000001Z"),
            ("1775211630250", "2026-04-03T10:20:30.25Z"),
            ("1775211630250000", "2026-04-03T10:20:30.25Z"),
            ("1775211630250000001", "2026-04-03T10:20:30.250000001Z"),
            ("1.77521163025e9", "2026-04-03T10:20:30.25Z"),
        ];
        for (cell, instant) in cases {
            assert_eq!(read(&[cell], &Reading::default()), [instant], "{cell}");
        }
    }

    #[test]
    fn a_later_time_tells_day_from_month() {
        let cells = ["03/04/2026 00:00", "04/04/2026 00:00", "14/04/2026 00:00"];
        assert_eq!(read(&cells, &Reading::default())[0], "2026-04-03T00:00:00Z");
        let cells = ["03/04/2026 00:00", "04/14/2026 00:00"];
        assert_eq!(read(&cells, &Reading::default())[0], "2026-03-04T00:00:00Z");
        let error = reader(&cells[..1], &Reading::default()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "column `time`: expected times that tell day from month, found none from \
             `03/04/2026 00:00` on; give --time-format \"%d/%m/%Y %H:%M\" or --time-format \
             \"%m/%d/%Y %H:%M\""
        );
    }

    /// `python3 -c "import datetime as d; print((d.datetime(2026,4,3,12)-d.datetime(1899,12,30)))"`
    /// says 46115 days, 12:00:00.
    #[test]
    fn published_days_of_spreadsheets() {
        let reading = Reading {
            time_format: Some("Excel".to_owned()),
            ..Reading::default()
        };
        let cells = ["46115.5", "46115.500011574", "61"];
        let found = read(&cells, &reading);
        assert_eq!(found[0], "2026-04-03T12:00:00Z");
        assert_eq!(found[1], "2026-04-03T12:00:00.999994Z");
        assert_eq!(found[2], "1900-03-01T00:00:00Z");
        let mut reader = reader(&cells, &reading).unwrap();
        for bad in ["60", "x", "1e300"] {
            assert!(reader.read(Cell::Text(bad), None).is_err(), "{bad}");
        }
    }

    #[test]
    fn an_hour_that_comes_twice_is_told_apart_by_order() {
        let rome = Reading {
            time_zone: Some("Europe/Rome".to_owned()),
            ..Reading::default()
        };
        let cells = [
            "2026-10-25 01:30",
            "2026-10-25 02:00",
            "2026-10-25 02:30",
            "2026-10-25 02:00",
            "2026-10-25 02:30",
            "2026-10-25 03:00",
        ];
        let expected = [
            "2026-10-24T23:30:00Z",
            "2026-10-25T00:00:00Z",
            "2026-10-25T00:30:00Z",
            "2026-10-25T01:00:00Z",
            "2026-10-25T01:30:00Z",
            "2026-10-25T02:00:00Z",
        ];
        assert_eq!(read(&cells, &rome), expected);
        let mut reader = reader(&cells, &rome).unwrap();
        assert_eq!(
            reader.read(Cell::Text("2026-03-29 02:30"), None),
            Err(CellProblem::NoSuchTime {
                found: "2026-03-29T02:30:00".to_owned(),
                zone: "Europe/Rome".to_owned()
            })
        );
    }
}
