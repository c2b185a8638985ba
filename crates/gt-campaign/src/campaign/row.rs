//! A row: all that is kept of a run.

use gtfdi::plant::PlantError;
use serde::Serialize;

use super::cell::{Cell, ColumnKind, Value};
use super::draw::DrawnFault;
use super::judge::Judgement;

/// All that is kept of a run. In JSON and in a table it is flat, by [`COLUMNS`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// The run's index.
    pub run: u64,
    /// The paper's number of the fault, 1 to 4; `None` of a healthy run.
    pub case: Option<u64>,
    /// The fault's name.
    pub fault: Option<String>,
    /// How it goes with time.
    pub waveform: Option<String>,
    /// 1 or -1.
    pub sign: Option<f64>,
    /// Its size, above 0.
    pub size: Option<f64>,
    /// The unit of that.
    pub unit: Option<String>,
    /// When it begins, in seconds.
    pub onset_s: Option<f64>,
    /// `ok` or `failed`.
    pub status: Status,
    /// Why the run failed.
    pub reason: Option<String>,
    /// When the plant left its range, in seconds.
    pub failed_s: Option<f64>,
    /// See [`Judgement::healthy_s`]; this and all that follows is `None` of a failed run.
    pub healthy_s: Option<f64>,
    /// See [`Judgement::false_alarms`].
    pub false_alarms: Option<u64>,
    /// See [`Judgement::peak_before`].
    pub peak_before: Option<f64>,
    /// See [`Judgement::peak_after`].
    pub peak_after: Option<f64>,
    /// See [`Judgement::detected`].
    pub detected: Option<bool>,
    /// When the first alarm at or after the onset came up, in seconds.
    pub alarm_s: Option<f64>,
    /// How long after the onset, in seconds.
    pub delay_s: Option<f64>,
    /// The output whose residual it is about.
    pub alarm_tag: Option<String>,
    /// The statistic that raised it.
    pub alarm_statistic: Option<String>,
    /// The name that stood five seconds after the alarm; this and what follows is of an isolator, on
    /// a record with a fault.
    pub named: Option<String>,
    /// When it was given, in seconds.
    pub named_s: Option<f64>,
    /// See [`super::Naming::right`].
    pub right: Option<bool>,
    /// See [`super::Naming::ever_wrong`].
    pub ever_wrong: Option<bool>,
    /// The size found at the end of the record with its sign, under the fault's own hypothesis.
    pub found_size: Option<f64>,
    /// Lower end of its 95 % interval.
    pub found_size_low: Option<f64>,
    /// Upper end.
    pub found_size_high: Option<f64>,
    /// The onset found, in seconds, under the same.
    pub found_onset_s: Option<f64>,
    /// Lower end of its 95 % interval.
    pub found_onset_low_s: Option<f64>,
    /// Upper end.
    pub found_onset_high_s: Option<f64>,
}

/// Whether a run is one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// The record is whole.
    Ok,
    /// The plant left the range in which the model means something, or never was in it.
    Failed,
}

impl Status {
    /// As in a table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Failed => "failed",
        }
    }
}

/// Why a run is none, without the numbers that differ from run to run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunFailure {
    /// What happened.
    pub reason: String,
    /// When, in seconds.
    pub time_s: Option<f64>,
}

impl From<&PlantError> for RunFailure {
    fn from(error: &PlantError) -> Self {
        let (reason, time_s) = match error {
            PlantError::OutOfRange {
                time_s,
                quantity,
                low,
                high,
                ..
            } => (format!("{quantity}: left {low} to {high}"), Some(*time_s)),
            PlantError::OutsideMap {
                component, time_s, ..
            } => (format!("{component}: left its map"), Some(*time_s)),
            other => (other.to_string(), None),
        };
        Self { reason, time_s }
    }
}

impl Row {
    /// The row of a run.
    pub fn new(
        run: u64,
        drawn: Option<&DrawnFault>,
        outcome: Result<Judgement, RunFailure>,
    ) -> Self {
        let (status, judgement, failure) = match outcome {
            Ok(judgement) => (Status::Ok, Some(judgement), None),
            Err(failure) => (Status::Failed, None, Some(failure)),
        };
        let found = judgement.as_ref();
        let alarm = found.and_then(|found| found.alarm.as_ref());
        let naming = found.and_then(|found| found.naming.as_ref());
        let size = naming.and_then(|naming| naming.size);
        let onset_s = naming.and_then(|naming| naming.onset_s);
        Self {
            run,
            case: drawn.map(|drawn| drawn.plan.case.number() as u64),
            fault: drawn.map(|drawn| drawn.plan.case.name().to_owned()),
            waveform: drawn.map(|drawn| drawn.plan.shape.name().to_owned()),
            sign: drawn.map(|drawn| drawn.sign),
            size: drawn.map(|drawn| drawn.size),
            unit: drawn.map(|drawn| drawn.plan.case.unit().to_owned()),
            onset_s: drawn.map(|drawn| drawn.onset_s),
            status,
            failed_s: failure.as_ref().and_then(|failure| failure.time_s),
            reason: failure.map(|failure| failure.reason),
            healthy_s: found.map(|found| found.healthy_s),
            false_alarms: found.map(|found| found.false_alarms),
            peak_before: found.and_then(|found| found.peak_before),
            peak_after: found.and_then(|found| found.peak_after),
            detected: found.and_then(|found| found.detected),
            alarm_s: alarm.map(|alarm| alarm.time_s),
            delay_s: alarm.map(|alarm| alarm.delay_s),
            alarm_tag: alarm.map(|alarm| alarm.tag.clone()),
            alarm_statistic: alarm.map(|alarm| alarm.statistic.clone()),
            named: naming.and_then(|naming| naming.named.clone()),
            named_s: naming.and_then(|naming| naming.named_s),
            right: naming.map(|naming| naming.right),
            ever_wrong: naming.map(|naming| naming.ever_wrong),
            found_size: size.map(|found| found.value),
            found_size_low: size.map(|found| found.low),
            found_size_high: size.map(|found| found.high),
            found_onset_s: onset_s.map(|found| found.value),
            found_onset_low_s: onset_s.map(|found| found.low),
            found_onset_high_s: onset_s.map(|found| found.high),
        }
    }
}

/// A column: its name, what it holds, how it is read of a row and written into one. All of a column
/// is here: a new one is a field of [`Row`] and a line of [`COLUMNS`].
pub struct Column {
    /// Its name.
    pub name: &'static str,
    /// What it holds.
    pub kind: ColumnKind,
    /// The cell of a row.
    pub get: fn(&Row) -> Cell,
    /// Takes a cell into a row; `None` where it is none of this column.
    pub set: fn(&mut Row, Cell) -> Option<()>,
}

impl Value for Status {
    const KIND: ColumnKind = ColumnKind::Text;
    fn cell(&self) -> Cell {
        Cell::Text(self.name().to_owned())
    }
    fn of(cell: Cell) -> Option<Self> {
        let name = String::of(cell)?;
        let mut all = [Self::Ok, Self::Failed].into_iter();
        all.find(|status| status.name() == name)
    }
}

fn kind<T: Value>(_: fn(&Row) -> &T) -> ColumnKind {
    T::KIND
}

macro_rules! columns {
    ($($name:ident),* $(,)?) => {
        /// The columns of a table, in their order.
        pub static COLUMNS: std::sync::LazyLock<Vec<Column>> = std::sync::LazyLock::new(|| vec![
            $(Column {
                name: stringify!($name),
                kind: kind(|row| &row.$name),
                get: |row| row.$name.cell(),
                set: |row, cell| {
                    row.$name = Value::of(cell)?;
                    Some(())
                },
            }),*
        ]);
    };
}

columns![
    run,
    case,
    fault,
    waveform,
    sign,
    size,
    unit,
    onset_s,
    status,
    reason,
    failed_s,
    healthy_s,
    false_alarms,
    peak_before,
    peak_after,
    detected,
    alarm_s,
    delay_s,
    alarm_tag,
    alarm_statistic,
    named,
    named_s,
    right,
    ever_wrong,
    found_size,
    found_size_low,
    found_size_high,
    found_onset_s,
    found_onset_low_s,
    found_onset_high_s,
];

impl Row {
    /// A row without anything, to be filled cell by cell.
    pub(super) fn blank() -> Self {
        let failure = RunFailure {
            reason: String::new(),
            time_s: None,
        };
        Self::new(0, None, Err(failure))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_of_a_row_is_a_column_in_the_same_order() {
        let json = serde_json::to_string(&Row::blank()).expect("JSON");
        let names: Vec<String> = COLUMNS
            .iter()
            .map(|column| format!("\"{}\":", column.name))
            .collect();
        assert_eq!(json.matches("\":").count(), COLUMNS.len());
        let places: Vec<Option<usize>> = names.iter().map(|name| json.find(name)).collect();
        assert!(
            places.iter().all(Option::is_some) && places.is_sorted(),
            "{places:?}"
        );
    }

    #[test]
    fn a_cell_of_another_kind_is_refused() {
        let mut row = Row::blank();
        for column in COLUMNS.iter() {
            let wrong = match column.kind {
                ColumnKind::Text => Cell::Truth(true),
                _ => Cell::Text("ok".to_owned()),
            };
            assert_eq!((column.set)(&mut row, wrong), None, "{}", column.name);
            let own = (column.get)(&row);
            assert_eq!((column.set)(&mut row, own), Some(()));
        }
        assert_eq!(Status::of(Cell::Text("fine".to_owned())), None);
    }
}
