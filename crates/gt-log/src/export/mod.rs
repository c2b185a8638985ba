//! Topics of logs into tables.

mod block;
mod csv;
mod json;
mod order;
mod parquet;
mod protobuf;

use std::ops::Range;
use std::path::Path;

use serde::Serialize;

use gt_core::Signal;

use crate::LogError;
use crate::import::{Columns, DEFAULT_TOPIC, Selection};
use crate::reader::fields_of_topic;
use block::{Block, Head};
use order::Order;

/// What to export of a log.
///
/// | name | default | purpose |
/// |---|---|---|
/// | `topic` | [`DEFAULT_TOPIC`](crate::DEFAULT_TOPIC) | the topic |
/// | `tags` | all | columns, or patterns such as `t*`; of JSON numbers within objects too, as `a.b` |
/// | `rows` | all | rows in the order of time `start..end`, 0-based, half open |
/// | `time` | ISO 8601 | how a CSV file has the time |
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ExportOptions {
    /// The topic.
    pub topic: Option<String>,
    /// Tags or patterns of the columns; none means all.
    pub tags: Vec<String>,
    /// The rows, which must be there.
    pub rows: Option<Range<usize>>,
    /// How a CSV file has the time.
    pub time: ExportTime,
}

/// How a CSV file has the time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ExportTime {
    /// ISO 8601 in UTC with nine decimals: `2006-01-18T00:00:00.080000000Z`.
    #[default]
    Iso,
    /// Seconds since the topic's first message, with nine decimals: `0.080000000`.
    Seconds,
}

/// What was exported.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Exported {
    /// The topic.
    pub topic: String,
    /// The name of the column of the time.
    pub time: String,
    /// The other columns.
    pub columns: Vec<ExportedColumn>,
    /// The rows.
    pub rows: usize,
}

/// A column that was exported.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ExportedColumn {
    /// Its name.
    pub name: String,
    /// Its unit; empty where the log tells none.
    pub unit: String,
    /// What it holds: `number`, `integer`, `truth` or `text`.
    pub kind: &'static str,
    /// How many of its rows have no value.
    pub absent: usize,
}

/// Writes the messages of a topic to a table, in the order of their publish times (of their log times
/// where the writer left those at zero): `out` ends in `.csv` or `.parquet`.
///
/// The first column is the time, called `time` or, where a field has that name, `timestamp` or
/// `log_time`. Of Protobuf each number, truth value or enumeration is a column, as in
/// [`columns`](crate::columns); of JSON each key of the messages is one, and what lies deeper is its
/// JSON text.
///
/// **CSV**: an absent value is an empty cell, an invalid one `NaN`; numbers have as many digits as
/// bring the same bits back (a NaN other than the usual one comes back as the usual one). An empty
/// text and none look alike.
/// **Parquet**: an absent value is null, an invalid one NaN, to the bit. Time is a timestamp in
/// nanoseconds, UTC.
///
/// The log is read several times, and a block of rows is in memory at a time, as well as rows that stand
/// before their turn in a log that is not in the order of time. The file appears when it is whole.
///
/// # Errors
/// [`LogError::ExportExtension`] for another file; [`LogError::UnknownTopic`],
/// [`LogError::NoMessages`], [`LogError::Rows`], [`LogError::Message`] and those of a selection; a
/// log that is broken; a file that cannot be written.
pub fn export(path: &Path, out: &Path, options: &ExportOptions) -> Result<Exported, LogError> {
    let extension = out
        .extension()
        .map(|text| text.to_string_lossy().to_ascii_lowercase());
    let is_csv = match extension.as_deref() {
        Some("csv") => true,
        Some("parquet") => false,
        _ => {
            return Err(LogError::ExportExtension {
                path: out.to_owned(),
            });
        }
    };
    let topic = options.topic.as_deref().unwrap_or(DEFAULT_TOPIC);
    let channels = fields_of_topic(path, topic)?;
    let is_text = channels.iter().any(|(_, fields)| fields.is_json());
    let tags = &options.tags;
    let order;
    let rows;
    let mut numbers;
    let mut texts;
    let (source, columns): (&mut dyn Rows, _) = if is_text {
        order = Order::read(path, topic)?;
        rows = selected(path, options, order.total)?;
        texts = json::Texts::new((path, topic), tags, &channels, &order, &rows)?;
        let columns = texts.columns();
        (&mut texts, columns)
    } else {
        numbers = protobuf::Numbers::new(path, topic, tags, &channels)?;
        order = Order::read(path, topic)?;
        rows = selected(path, options, order.total)?;
        let columns = numbers.columns();
        (&mut numbers, columns)
    };
    let taken = |name: &&str| !columns.iter().any(|own| own.0.name == **name);
    let time = ["time", "timestamp", "log_time", "message_log_time"];
    let time = time
        .into_iter()
        .find(taken)
        .unwrap_or("time_of_the_message");
    let head = Head {
        topic: topic.to_owned(),
        time: time.to_owned(),
        first_ns: order.first_ns,
        columns,
    };
    let mut table: Box<dyn TableWriter> = if is_csv {
        Box::new(csv::Csv::create(out, &head, options.time)?)
    } else {
        Box::new(parquet::Parquet::create(out, &head)?)
    };
    let mut block = Block::new(&head);
    let most = head.block_rows();
    source.write((path, topic), &order, &rows, &mut |push| {
        push(&mut block);
        if block.len() == most {
            table.write(&block)?;
            block.clear();
        }
        Ok(())
    })?;
    if block.len() > 0 {
        table.write(&block)?;
    }
    table.finish()?;
    let columns = head.columns.into_iter().zip(&block.absent);
    Ok(Exported {
        topic: head.topic,
        time: head.time,
        columns: columns
            .map(|((signal, kind), absent)| ExportedColumn {
                name: signal.name,
                unit: signal.unit,
                kind: kind.name(),
                absent: *absent,
            })
            .collect(),
        rows: rows.len(),
    })
}

/// A table that takes its rows in blocks.
trait TableWriter {
    /// Adds rows.
    fn write(&mut self, block: &Block) -> Result<(), LogError>;

    /// Gives the file its name.
    fn finish(self: Box<Self>) -> Result<(), LogError>;
}

/// The rows of a topic.
trait Rows {
    /// Calls `sink` for each row of `rows` in order with what adds it to a block.
    #[expect(clippy::type_complexity, reason = "a callback that takes another")]
    fn write(
        &mut self,
        of: (&Path, &str),
        order: &Order,
        rows: &Range<usize>,
        sink: &mut dyn FnMut(&mut dyn FnMut(&mut Block)) -> Result<(), LogError>,
    ) -> Result<(), LogError>;
}

/// The rows that are asked for.
fn selected(path: &Path, options: &ExportOptions, total: usize) -> Result<Range<usize>, LogError> {
    let selection = Selection {
        rows: options.rows.clone(),
        ..Selection::default()
    };
    selection.rows_of(path, total)
}

/// The places of the selected ones of `available`; without tags those of the first `usual`.
fn select(
    path: &Path,
    available: &[Signal],
    tags: &[String],
    usual: usize,
) -> Result<Vec<usize>, LogError> {
    if tags.is_empty() {
        return Ok((0..usual).collect());
    }
    let selection = Selection {
        outputs: tags.to_vec(),
        ..Selection::default()
    };
    Ok(Columns::resolve(path, available, None, &selection)?.outputs)
}
