//! Tables as CSV.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use jiff::Timestamp;

use super::block::{Block, Cells, Head};
use super::{ExportTime, TableWriter};
use crate::atomic::Part;
use crate::{LogError, Place};

/// A table that is written.
pub(super) struct Csv {
    out: PathBuf,
    // Dropped before `part`, which removes the file it writes to.
    writer: csv::Writer<BufWriter<File>>,
    part: Part,
    time: ExportTime,
    first_ns: u64,
}

impl Csv {
    /// Writes the header.
    pub(super) fn create(out: &Path, head: &Head, time: ExportTime) -> Result<Self, LogError> {
        let (part, file) = Part::create(out)?;
        let mut writer = csv::Writer::from_writer(BufWriter::new(file));
        let names = head.columns.iter().map(|own| own.0.name.as_str());
        let header = [head.time.as_str()].into_iter().chain(names);
        writer
            .write_record(header)
            .map_err(|cause| failed(out, cause))?;
        Ok(Self {
            out: out.to_owned(),
            part,
            writer,
            time,
            first_ns: head.first_ns,
        })
    }

    /// The time of a row as text.
    fn time(&self, row: usize, time_ns: u64) -> Result<String, LogError> {
        match self.time {
            ExportTime::Iso => iso(time_ns).ok_or_else(|| LogError::TimeOutOfRange {
                path: self.out.clone(),
                place: Place::Message(row),
                found_ns: time_ns,
            }),
            ExportTime::Seconds => {
                let since = time_ns - self.first_ns;
                let (seconds, rest) = (since / 1_000_000_000, since % 1_000_000_000);
                Ok(format!("{seconds}.{rest:09}"))
            }
        }
    }
}

impl TableWriter for Csv {
    fn write(&mut self, block: &Block) -> Result<(), LogError> {
        for (row, time_ns) in block.times_ns.iter().enumerate() {
            let time = self.time(block.first_row + row, *time_ns)?;
            let failed = |cause| failed(&self.out, cause);
            self.writer.write_field(time).map_err(failed)?;
            for column in &block.columns {
                let cell = cell(column, row).unwrap_or_default();
                self.writer.write_field(cell).map_err(failed)?;
            }
            self.writer.write_record(None::<&[u8]>).map_err(failed)?;
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), LogError> {
        let Self {
            out, part, writer, ..
        } = *self;
        let inner = writer
            .into_inner()
            .map_err(|cause| LogError::io(&out, "write", cause.into_error()))?;
        let file = inner
            .into_inner()
            .map_err(|cause| LogError::io(&out, "write", cause.into_error()))?;
        part.publish(file)
    }
}

fn failed(out: &Path, cause: csv::Error) -> LogError {
    LogError::io(out, "write", cause.into())
}

fn iso(time_ns: u64) -> Option<String> {
    let time = Timestamp::from_nanosecond(i128::from(time_ns)).ok()?;
    Some(format!("{time:.9}"))
}

/// The text of a cell; none where there is no value.
fn cell(cells: &Cells, row: usize) -> Option<String> {
    match cells {
        // The shortest digits that bring the same bits back.
        Cells::Numbers(cells) => cells.get(row)?.map(|own| format!("{own:?}")),
        Cells::Integers(cells) => cells.get(row)?.map(|own| own.to_string()),
        Cells::Truths(cells) => cells.get(row)?.map(|own| own.to_string()),
        Cells::Texts(cells) => cells.get(row)?.clone(),
    }
}
