//! Rows in a Parquet file.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::record::Field;
use parquet::schema::types::{Type, TypePtr};

use super::cell::{Cell, ColumnKind};
use super::row::{COLUMNS, Row};
use crate::error::CampaignError;

/// The rows of a file, and what else it says of itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The rows, in their order.
    pub rows: Vec<Row>,
    /// Key and value.
    pub metadata: Vec<(String, String)>,
}

impl Table {
    /// Writes the rows to a file of the name that `name` makes of the bytes' SHA-256, and gives that.
    /// The file appears when it is whole.
    ///
    /// # Errors
    /// [`CampaignError::Table`] and [`CampaignError::Log`] name the file.
    pub fn write(&self, name: impl FnOnce(&str) -> PathBuf) -> Result<String, CampaignError> {
        let bytes = self.to_bytes()?;
        let sha256 = gt_log::sha256_hex(&bytes);
        gt_log::write_atomically(&name(&sha256), &bytes)?;
        Ok(sha256)
    }

    /// The bytes of its file.
    ///
    /// # Errors
    /// [`CampaignError::Table`].
    pub(super) fn to_bytes(&self) -> Result<Vec<u8>, CampaignError> {
        self.bytes().map_err(|error| CampaignError::Table {
            path: PathBuf::from("rows"),
            reason: error.to_string(),
        })
    }

    /// Reads the rows of a file whose bytes have a SHA-256 that begins with `sha256`. Others are not
    /// looked at: the reader of the format panics on some that are broken.
    ///
    /// # Errors
    /// [`CampaignError::Table`]: the file cannot be read, is another one, has other columns or values.
    pub fn read(path: &Path, sha256: &str) -> Result<Self, CampaignError> {
        let bytes = std::fs::read(path).map_err(|error| table_error(path, &error))?;
        let found = gt_log::sha256_hex(&bytes);
        if sha256.is_empty() || !found.starts_with(sha256) {
            return Err(CampaignError::Table {
                path: path.to_owned(),
                reason: format!("expected the bytes with the SHA-256 {sha256}, found {found}"),
            });
        }
        let file = File::open(path).map_err(|error| table_error(path, &error))?;
        let (schema, metadata, rows) = read(file).map_err(|error| table_error(path, &error))?;
        if schema != names() {
            return Err(CampaignError::Table {
                path: path.to_owned(),
                reason: format!("expected the columns {}, found {schema}", names()),
            });
        }
        let rows = rows.into_iter().enumerate().map(|(place, cells)| {
            let mut row = Row::blank();
            for (column, cell) in COLUMNS.iter().zip(cells) {
                (column.set)(&mut row, cell).ok_or_else(|| CampaignError::Table {
                    path: path.to_owned(),
                    reason: format!(
                        "row {place}, column {}: expected {:?}, found another type",
                        column.name, column.kind
                    ),
                })?;
            }
            Ok(row)
        });
        let rows = rows.collect::<Result<_, CampaignError>>()?;
        Ok(Self { rows, metadata })
    }

    fn bytes(&self) -> Result<Vec<u8>, ParquetError> {
        let metadata = self.metadata.iter();
        let metadata = metadata.map(|(key, value)| KeyValue::new(key.clone(), value.clone()));
        let properties = WriterProperties::builder()
            .set_created_by(format!("gtfdi {}", env!("CARGO_PKG_VERSION")))
            .set_key_value_metadata(Some(metadata.collect()))
            .build();
        let mut bytes = Vec::new();
        let mut writer = SerializedFileWriter::new(&mut bytes, schema()?, Arc::new(properties))?;
        let mut group = writer.next_row_group()?;
        for column in COLUMNS.iter() {
            let cells: Vec<Cell> = self.rows.iter().map(column.get).collect();
            match column.kind {
                ColumnKind::Integer => {
                    write_column::<Int64Type>(&mut group, &cells, |cell| match cell {
                        Cell::Integer(value) => Some(*value),
                        _ => None,
                    })
                }
                ColumnKind::Number => {
                    write_column::<DoubleType>(&mut group, &cells, |cell| match cell {
                        Cell::Number(value) => Some(*value),
                        _ => None,
                    })
                }
                ColumnKind::Text => {
                    write_column::<ByteArrayType>(&mut group, &cells, |cell| match cell {
                        Cell::Text(value) => Some(ByteArray::from(value.as_str())),
                        _ => None,
                    })
                }
                ColumnKind::Truth => {
                    write_column::<BoolType>(&mut group, &cells, |cell| match cell {
                        Cell::Truth(value) => Some(*value),
                        _ => None,
                    })
                }
            }?;
        }
        group.close()?;
        writer.close()?;
        Ok(bytes)
    }
}

/// Writes the next column of a group: a level says of every row whether it has a value.
fn write_column<T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, &mut Vec<u8>>,
    cells: &[Cell],
    value: impl Fn(&Cell) -> Option<T::T>,
) -> Result<(), ParquetError> {
    let values: Vec<Option<T::T>> = cells.iter().map(value).collect();
    let levels: Vec<i16> = values
        .iter()
        .map(|value| i16::from(value.is_some()))
        .collect();
    let values: Vec<T::T> = values.into_iter().flatten().collect();
    if let Some(mut column) = group.next_column()? {
        column
            .typed::<T>()
            .write_batch(&values, Some(&levels), None)?;
        column.close()?;
    }
    Ok(())
}

/// The schema of the columns; every one may hold nothing.
fn schema() -> Result<TypePtr, ParquetError> {
    let fields = COLUMNS.iter().map(|column| {
        let (kind, logical) = match column.kind {
            ColumnKind::Integer => (PhysicalType::INT64, None),
            ColumnKind::Number => (PhysicalType::DOUBLE, None),
            ColumnKind::Text => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
            ColumnKind::Truth => (PhysicalType::BOOLEAN, None),
        };
        Type::primitive_type_builder(column.name, kind)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical)
            .build()
            .map(Arc::new)
    });
    let fields = fields.collect::<Result<Vec<_>, _>>()?;
    let schema = Type::group_type_builder("row")
        .with_fields(fields)
        .build()?;
    Ok(Arc::new(schema))
}

/// The names of the columns, for messages and to tell other files.
fn names() -> String {
    let names: Vec<&str> = COLUMNS.iter().map(|column| column.name).collect();
    names.join(", ")
}

/// The names of a file's columns, its metadata and its cells.
type Read = (String, Vec<(String, String)>, Vec<Vec<Cell>>);

fn read(file: File) -> Result<Read, ParquetError> {
    let reader = SerializedFileReader::new(file)?;
    let file = reader.metadata().file_metadata();
    let columns = file.schema_descr().columns().iter();
    let names: Vec<&str> = columns.map(|column| column.name()).collect();
    let names = names.join(", ");
    let pairs = file.key_value_metadata().into_iter().flatten();
    let metadata = pairs.map(|pair| (pair.key.clone(), pair.value.clone().unwrap_or_default()));
    let metadata = metadata.collect();
    let mut rows = Vec::new();
    for row in reader.get_row_iter(None)? {
        let fields = row?.into_columns().into_iter();
        let cells = fields.map(|(_, field)| match field {
            Field::Long(value) => Cell::Integer(value),
            Field::Double(value) => Cell::Number(value),
            Field::Str(value) => Cell::Text(value),
            Field::Bool(value) => Cell::Truth(value),
            _ => Cell::Null,
        });
        rows.push(cells.collect());
    }
    Ok((names, metadata, rows))
}

fn table_error(path: &Path, error: &dyn std::fmt::Display) -> CampaignError {
    CampaignError::Table {
        path: path.to_owned(),
        reason: error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::row::Status;

    fn rows() -> Vec<Row> {
        let full = Row {
            run: 7,
            case: Some(2),
            fault: Some("thermocouple_drift".into()),
            waveform: Some("ramp".into()),
            sign: Some(-1.0),
            size: Some(0.1 + 0.2),
            unit: Some("%".into()),
            onset_s: Some(1.0 / 3.0),
            status: Status::Ok,
            reason: None,
            failed_s: None,
            healthy_s: Some(12.0),
            false_alarms: Some(3),
            peak_before: Some(f64::MIN_POSITIVE),
            peak_after: Some(-0.0),
            detected: Some(true),
            alarm_s: Some(1e300),
            delay_s: Some(0.08),
            alarm_tag: Some("t3".into()),
            alarm_statistic: Some("cusum".into()),
            named: Some("none of these".into()),
            right: Some(false),
            found_size: Some(-0.31),
            ..Row::blank()
        };
        vec![full, Row::blank()]
    }

    #[test]
    fn rows_come_back_bit_for_bit() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("rows.parquet");
        for rows in [rows(), Vec::new()] {
            let metadata = vec![("spec".to_owned(), "ab".to_owned())];
            let table = Table { rows, metadata };
            let sha256 = table.write(|_| path.clone()).expect("written");
            let back = Table::read(&path, &sha256).expect("read");
            assert_eq!(back.rows, table.rows);
            let bits = |rows: &[Row]| {
                rows.iter()
                    .map(|row| row.peak_after.map(f64::to_bits))
                    .collect::<Vec<_>>()
            };
            assert_eq!(bits(&back.rows), bits(&table.rows));
            assert!(
                back.metadata.contains(&table.metadata[0]),
                "{:?}",
                back.metadata
            );
        }
    }

    /// Cut anywhere, or with any byte changed, a file is refused before its format is read.
    #[test]
    fn broken_files_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("rows.parquet");
        let table = Table {
            rows: rows(),
            metadata: Vec::new(),
        };
        let sha256 = table.write(|_| path.clone()).expect("written");
        let bytes = std::fs::read(&path).expect("bytes");
        let refused = |broken: &[u8]| {
            std::fs::write(&path, broken).expect("written");
            let error = Table::read(&path, &sha256[..16]).expect_err("broken");
            let text = error.to_string();
            assert!(
                text.contains("rows.parquet: expected the bytes with the SHA-256"),
                "{text}"
            );
        };
        for length in 0..bytes.len() {
            refused(&bytes[..length]);
        }
        for place in 0..bytes.len() {
            let mut broken = bytes.clone();
            broken[place] ^= 0x55;
            refused(&broken);
        }
    }
}
