//! Tables as Parquet.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, TimeUnit, Type as PhysicalType};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};

use super::ExportTime;
use super::columns::{Cells, Sheet, place};
use crate::LogError;
use crate::atomic::Part;

/// Rows of a group.
const GROUP: usize = 1 << 17;

type Sink = BufWriter<File>;

/// Writes a table. Time is an instant, however a CSV file would have it.
pub(super) fn write(out: &Path, table: &Sheet, _: ExportTime) -> Result<(), LogError> {
    let mut times = Vec::with_capacity(table.times_ns.len());
    for (row, time_ns) in table.times_ns.iter().enumerate() {
        let time = i64::try_from(*time_ns).map_err(|_| LogError::TimeOutOfRange {
            path: out.to_owned(),
            place: place(row),
            found_ns: *time_ns,
        })?;
        times.push(time);
    }
    let (part, file) = Part::create(out)?;
    let failed = |cause: ParquetError| LogError::io(out, "write", std::io::Error::other(cause));
    let sink = write_all(BufWriter::new(file), table, &times).map_err(failed)?;
    let file = sink
        .into_inner()
        .map_err(|cause| LogError::io(out, "write", cause.into_error()))?;
    part.publish(file)
}

fn write_all(sink: Sink, table: &Sheet, times: &[i64]) -> Result<Sink, ParquetError> {
    let units = table
        .columns
        .iter()
        .filter(|own| !own.signal.unit.is_empty());
    let units = units.map(|own| {
        let (name, unit) = (&own.signal.name, own.signal.unit.clone());
        KeyValue::new(format!("unit:{name}"), unit)
    });
    let topic = KeyValue::new("topic".to_owned(), table.topic.clone());
    let properties = WriterProperties::builder()
        .set_created_by(format!("gtfdi {}", env!("CARGO_PKG_VERSION")))
        .set_key_value_metadata(Some([topic].into_iter().chain(units).collect()))
        .build();
    let mut writer = SerializedFileWriter::new(sink, schema(table)?, Arc::new(properties))?;
    for start in (0..times.len()).step_by(GROUP) {
        let rows = start..(start + GROUP).min(times.len());
        let mut group = writer.next_row_group()?;
        if let Some(mut column) = group.next_column()? {
            let own = &times[rows.clone()];
            column.typed::<Int64Type>().write_batch(own, None, None)?;
            column.close()?;
        }
        for column in &table.columns {
            match &column.cells {
                Cells::Numbers(cells) => {
                    write_cells::<DoubleType, _>(&mut group, &cells[rows.clone()], |own| *own)
                }
                Cells::Integers(cells) => {
                    write_cells::<Int64Type, _>(&mut group, &cells[rows.clone()], |own| *own)
                }
                Cells::Truths(cells) => {
                    write_cells::<BoolType, _>(&mut group, &cells[rows.clone()], |own| *own)
                }
                Cells::Texts(cells) => {
                    let text = |own: &String| ByteArray::from(own.as_str());
                    write_cells::<ByteArrayType, _>(&mut group, &cells[rows.clone()], text)
                }
            }?;
        }
        group.close()?;
    }
    writer.into_inner()
}

/// Writes the next column of a group: a level says of every row whether it has a value.
fn write_cells<T: DataType, C>(
    group: &mut SerializedRowGroupWriter<'_, Sink>,
    cells: &[Option<C>],
    value: impl Fn(&C) -> T::T,
) -> Result<(), ParquetError> {
    let levels: Vec<i16> = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
    let values: Vec<T::T> = cells.iter().flatten().map(value).collect();
    if let Some(mut column) = group.next_column()? {
        column
            .typed::<T>()
            .write_batch(&values, Some(&levels), None)?;
        column.close()?;
    }
    Ok(())
}

fn schema(table: &Sheet) -> Result<TypePtr, ParquetError> {
    let time = Type::primitive_type_builder(&table.time, PhysicalType::INT64)
        .with_repetition(Repetition::REQUIRED)
        .with_logical_type(Some(LogicalType::timestamp(true, TimeUnit::NANOS)))
        .build()?;
    let mut fields = vec![Arc::new(time)];
    for column in &table.columns {
        let (kind, logical) = match column.cells {
            Cells::Numbers(_) => (PhysicalType::DOUBLE, None),
            Cells::Integers(_) => (PhysicalType::INT64, None),
            Cells::Truths(_) => (PhysicalType::BOOLEAN, None),
            Cells::Texts(_) => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let field = Type::primitive_type_builder(&column.signal.name, kind)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical)
            .build()?;
        fields.push(Arc::new(field));
    }
    let schema = Type::group_type_builder("row")
        .with_fields(fields)
        .build()?;
    Ok(Arc::new(schema))
}
