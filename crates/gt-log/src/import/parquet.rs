//! Parquet files: the only file of this crate that names `parquet`.

use std::path::Path;

use bytes::Bytes;
use gt_core::Signal;
use parquet::basic::Compression;
use parquet::errors::ParquetError;
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::schema::types::{SchemaDescriptor, Type};

use super::ReadingError;
use super::parquet_column::{Content, Kind};
use super::parquet_form::{check_footer, check_pages};
use super::quiet::quietly;
use super::sheet::{Cell, Sheet};
use crate::{LogError, Place};

/// The most rows of a file; more are a broken or a malicious one.
const MOST_ROWS: i64 = 1 << 28;

/// The rows of a Parquet file. Only the columns that are asked for are read.
pub(crate) struct ParquetSheet<'a> {
    path: &'a Path,
    bytes: Bytes,
    reader: SerializedFileReader<Bytes>,
    header: Vec<Signal>,
    columns: Vec<Column>,
    rows: usize,
    /// One past the current row.
    next: usize,
}

/// A column of the header.
struct Column {
    /// Its number among the leaves of the schema; none where it is nested.
    leaf: Option<usize>,
    content: Option<Content>,
}

impl<'a> ParquetSheet<'a> {
    /// Reads what a file says of itself.
    pub(crate) fn open(path: &'a Path, bytes: Vec<u8>) -> Result<Self, LogError> {
        let bytes = Bytes::from(bytes);
        let refused = |cause| LogError::reading(path, cause);
        check_footer(&bytes).map_err(|cause| refused(ReadingError::Parquet { cause }))?;
        let reader = guarded(path, || SerializedFileReader::new(bytes.clone()))?;
        let schema = reader.metadata().file_metadata().schema_descr();
        let (header, columns) = columns(schema).map_err(refused)?;
        let mut rows: i64 = 0;
        for group in reader.metadata().row_groups() {
            let found = group.num_rows();
            rows = rows.checked_add(found).unwrap_or(i64::MAX);
            if found < 0 || rows > MOST_ROWS {
                let cause = format!("{found} rows in a group, {rows} in all");
                return Err(refused(ReadingError::Parquet { cause }));
            }
        }
        Ok(Self {
            path,
            bytes,
            rows: usize::try_from(rows).unwrap_or_default(),
            reader,
            header,
            columns,
            next: 0,
        })
    }

    fn load_column(&self, column: usize) -> Result<Content, LogError> {
        let name = &self.header[column].name;
        let refused = |cause| LogError::reading(self.path, cause);
        let unfit = |found: String| {
            refused(ReadingError::ParquetColumn {
                column: name.clone(),
                found,
            })
        };
        let Some(leaf) = self.columns[column].leaf else {
            return Err(unfit("a nested column (flatten it)".to_owned()));
        };
        let schema = self.reader.metadata().file_metadata().schema_descr();
        let descriptor = schema.column(leaf);
        let kind = Kind::of(&descriptor).map_err(|found| unfit(found.to_owned()))?;
        let mut content = Content::new(kind);
        for (index, group) in self.reader.metadata().row_groups().iter().enumerate() {
            let codec = group
                .columns()
                .get(leaf)
                .map(ColumnChunkMetaData::compression);
            if let Some(found) = codec.filter(|&codec| !is_known(codec)) {
                let column = name.clone();
                let found = format!("{found:?}");
                return Err(refused(ReadingError::ParquetCodec { column, found }));
            }
            guarded(self.path, || {
                if let Some(chunk) = group.columns().get(leaf)
                    && let Some(pages) = part(&self.bytes, chunk.byte_range())
                {
                    check_pages(pages).map_err(ParquetError::General)?;
                }
                let group = self.reader.get_row_group(index)?;
                content.read(group.get_column_reader(leaf)?, descriptor.max_def_level())
            })?;
        }
        if content.len() != self.rows {
            let found = format!("{} values in {} rows", content.len(), self.rows);
            return Err(unfit(found));
        }
        Ok(content)
    }
}

impl Sheet for ParquetSheet<'_> {
    fn header(&self) -> &[Signal] {
        &self.header
    }

    fn load(&mut self, columns: &[usize]) -> Result<(), LogError> {
        for &column in columns {
            if self.columns[column].content.is_none() {
                self.columns[column].content = Some(self.load_column(column)?);
            }
        }
        Ok(())
    }

    fn rewind(&mut self) -> Result<(), LogError> {
        self.next = 0;
        Ok(())
    }

    fn advance(&mut self) -> Result<bool, LogError> {
        let is_there = self.next < self.rows;
        self.next += usize::from(is_there);
        Ok(is_there)
    }

    fn place(&self) -> Place {
        Place::Row(self.next.saturating_sub(1))
    }

    fn fields(&self) -> usize {
        self.header.len()
    }

    fn cell(&self, column: usize) -> Cell<'_> {
        let content = self.columns.get(column).and_then(|c| c.content.as_ref());
        content.map_or(Cell::Nothing, |content| {
            content.cell(self.next.saturating_sub(1))
        })
    }
}

/// The columns of a schema by their names.
fn columns(schema: &SchemaDescriptor) -> Result<(Vec<Signal>, Vec<Column>), ReadingError> {
    let mut header: Vec<Signal> = Vec::new();
    let mut columns = Vec::new();
    let fields = match schema.root_schema() {
        group @ Type::GroupType { .. } => group.get_fields(),
        Type::PrimitiveType { .. } => &[],
    };
    for field in fields {
        let name = field.name();
        if header.iter().any(|signal| signal.name == name) {
            let column = name.to_owned();
            return Err(ReadingError::ParquetTwice { column });
        }
        let leaf = schema
            .columns()
            .iter()
            .position(|leaf| leaf.path().parts() == [name.to_owned()] && leaf.max_rep_level() == 0);
        header.push(Signal::new(name, ""));
        let leaf = leaf.filter(|_| field.is_primitive());
        columns.push(Column {
            leaf,
            content: None,
        });
    }
    Ok((header, columns))
}

/// The bytes of a file from an offset on, so many of them.
fn part(bytes: &[u8], (offset, length): (u64, u64)) -> Option<&[u8]> {
    let end = usize::try_from(offset.checked_add(length)?).ok()?;
    bytes.get(usize::try_from(offset).ok()?..end)
}

fn is_known(codec: Compression) -> bool {
    matches!(
        codec,
        Compression::UNCOMPRESSED
            | Compression::SNAPPY
            | Compression::GZIP(_)
            | Compression::ZSTD(_)
    )
}

/// Runs the reader of the format. It panics on some broken files (an index out of bounds, an offset
/// beyond the end), which a test that changes every byte shows; for the caller that is a file that
/// cannot be read, like any other. What it was about is thrown away.
fn guarded<T>(path: &Path, read: impl FnOnce() -> Result<T, ParquetError>) -> Result<T, LogError> {
    let cause = match quietly(read) {
        Some(Ok(value)) => return Ok(value),
        Some(Err(error)) => error.to_string(),
        None => "the reader of the format gave up".to_owned(),
    };
    Err(LogError::reading(path, ReadingError::Parquet { cause }))
}
