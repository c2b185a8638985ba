//! Tables as Parquet.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, TimeUnit, Type as PhysicalType};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};

use super::TableWriter;
use super::block::{Block, Cells, Head, Kind};
use crate::atomic::Part;
use crate::{LogError, Place};

type Sink = BufWriter<File>;

/// A table that is written. Time is an instant, however a CSV file would have it.
pub(super) struct Parquet {
    out: PathBuf,
    // Dropped before `part`, which removes the file it writes to.
    writer: SerializedFileWriter<Sink>,
    part: Part,
}

impl Parquet {
    /// Writes what stands before the rows.
    pub(super) fn create(out: &Path, head: &Head) -> Result<Self, LogError> {
        let units = head.columns.iter().map(|own| &own.0);
        let units = units.filter(|own| !own.unit.is_empty());
        let units = units.map(|own| KeyValue::new(format!("unit:{}", own.name), own.unit.clone()));
        let topic = KeyValue::new("topic".to_owned(), head.topic.clone());
        let properties = WriterProperties::builder()
            .set_created_by(format!("gtfdi {}", env!("CARGO_PKG_VERSION")))
            .set_key_value_metadata(Some([topic].into_iter().chain(units).collect()))
            .build();
        let (part, file) = Part::create(out)?;
        let writer = schema(head)
            .and_then(|schema| {
                SerializedFileWriter::new(BufWriter::new(file), schema, Arc::new(properties))
            })
            .map_err(|cause| failed(out, cause))?;
        Ok(Self {
            out: out.to_owned(),
            writer,
            part,
        })
    }

    /// Writes a row group.
    fn group(&mut self, times: &[i64], columns: &[Cells]) -> Result<(), ParquetError> {
        let mut group = self.writer.next_row_group()?;
        if let Some(mut column) = group.next_column()? {
            column.typed::<Int64Type>().write_batch(times, None, None)?;
            column.close()?;
        }
        for column in columns {
            match column {
                Cells::Numbers(cells) => {
                    write_cells::<DoubleType, _>(&mut group, cells, |own| *own)
                }
                Cells::Integers(cells) => {
                    write_cells::<Int64Type, _>(&mut group, cells, |own| *own)
                }
                Cells::Truths(cells) => write_cells::<BoolType, _>(&mut group, cells, |own| *own),
                Cells::Texts(cells) => {
                    let text = |own: &String| ByteArray::from(own.as_str());
                    write_cells::<ByteArrayType, _>(&mut group, cells, text)
                }
            }?;
        }
        group.close().map(drop)
    }
}

impl TableWriter for Parquet {
    fn write(&mut self, block: &Block) -> Result<(), LogError> {
        let mut times = Vec::with_capacity(block.len());
        for (row, time_ns) in block.times_ns.iter().enumerate() {
            let time = i64::try_from(*time_ns).map_err(|_| LogError::TimeOutOfRange {
                path: self.out.clone(),
                place: Place::Message(block.first_row + row),
                found_ns: *time_ns,
            })?;
            times.push(time);
        }
        let done = self.group(&times, &block.columns);
        done.map_err(|cause| failed(&self.out, cause))
    }

    fn finish(self: Box<Self>) -> Result<(), LogError> {
        let Self { out, writer, part } = *self;
        let sink = writer.into_inner().map_err(|cause| failed(&out, cause))?;
        let file = sink
            .into_inner()
            .map_err(|cause| LogError::io(&out, "write", cause.into_error()))?;
        part.publish(file)
    }
}

fn failed(out: &Path, cause: ParquetError) -> LogError {
    LogError::io(out, "write", std::io::Error::other(cause))
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

fn schema(head: &Head) -> Result<TypePtr, ParquetError> {
    let time = Type::primitive_type_builder(&head.time, PhysicalType::INT64)
        .with_repetition(Repetition::REQUIRED)
        .with_logical_type(Some(LogicalType::timestamp(true, TimeUnit::NANOS)))
        .build()?;
    let mut fields = vec![Arc::new(time)];
    for (signal, kind) in &head.columns {
        let (physical, logical) = match kind {
            Kind::Number => (PhysicalType::DOUBLE, None),
            Kind::Integer => (PhysicalType::INT64, None),
            Kind::Truth => (PhysicalType::BOOLEAN, None),
            Kind::Text | Kind::Json => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let field = Type::primitive_type_builder(&signal.name, physical)
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
