//! Tables as CSV.

use std::io::{BufWriter, Write as _};
use std::path::Path;

use jiff::Timestamp;

use super::ExportTime;
use super::columns::{Cells, Sheet, place};
use crate::LogError;
use crate::atomic::Part;

/// Writes a table.
pub(super) fn write(out: &Path, table: &Sheet, time: ExportTime) -> Result<(), LogError> {
    let failed = |cause: csv::Error| LogError::io(out, "write", cause.into());
    let (part, file) = Part::create(out)?;
    let mut writer = csv::Writer::from_writer(BufWriter::new(file));
    let names = table.columns.iter().map(|own| own.signal.name.as_str());
    let header = [table.time.as_str()].into_iter().chain(names);
    writer.write_record(header).map_err(failed)?;
    for (row, time_ns) in table.times_ns.iter().enumerate() {
        let time = match time {
            ExportTime::Iso => iso(*time_ns).ok_or_else(|| LogError::TimeOutOfRange {
                path: out.to_owned(),
                place: place(row),
                found_ns: *time_ns,
            })?,
            ExportTime::Seconds => {
                let since = time_ns - table.first_ns;
                format!("{}.{:09}", since / 1_000_000_000, since % 1_000_000_000)
            }
        };
        writer.write_field(time).map_err(failed)?;
        for column in &table.columns {
            let cell = cell(&column.cells, row);
            writer
                .write_field(cell.unwrap_or_default())
                .map_err(failed)?;
        }
        writer.write_record(None::<&[u8]>).map_err(failed)?;
    }
    let mut inner = writer
        .into_inner()
        .map_err(|cause| LogError::io(out, "write", cause.into_error()))?;
    inner
        .flush()
        .map_err(|cause| LogError::io(out, "write", cause))?;
    let file = inner
        .into_inner()
        .map_err(|cause| LogError::io(out, "write", cause.into_error()))?;
    part.publish(file)
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
