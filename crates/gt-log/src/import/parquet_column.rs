//! The values of a column of a Parquet file.

use std::collections::HashMap;

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type as PhysicalType};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{ByteArray, DataType, Int96};
use parquet::errors::ParquetError;
use parquet::schema::types::ColumnDescriptor;

use super::sheet::Cell;

/// Rows that are read at a time.
const BATCH: usize = 1 << 16;
const DAY_NS: i128 = 86_400_000_000_000;
/// The Julian day of 1970-01-01.
const EPOCH_JULIAN_DAY: i128 = 2_440_588;
/// Stands for no word.
const NO_WORD: u32 = u32::MAX;

/// What the values of a column mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    Number,
    /// Integers that count from 0.
    Unsigned,
    /// Integers of the last of so many decimal places.
    Decimal(i32),
    Text,
    /// Units of so many nanoseconds since 1970, in UTC or as local clocks show them.
    Time {
        unit_ns: i128,
        local: bool,
    },
}

impl Kind {
    /// The kind of a column, or what it is that it is none.
    pub(crate) fn of(column: &ColumnDescriptor) -> Result<Self, &'static str> {
        use PhysicalType::{BYTE_ARRAY, FIXED_LEN_BYTE_ARRAY, INT96};
        let time = |unit_ns, local| Ok(Self::Time { unit_ns, local });
        match (column.physical_type(), column.logical_type_ref()) {
            (INT96, _) => time(1, false),
            (_, Some(LogicalType::Decimal(decimal))) => Ok(Self::Decimal(decimal.scale)),
            (_, Some(LogicalType::Timestamp(timestamp))) => {
                let local = !timestamp.is_adjusted_to_u_t_c;
                match timestamp.unit {
                    TimeUnit::MILLIS => time(1_000_000, local),
                    TimeUnit::MICROS => time(1_000, local),
                    TimeUnit::NANOS => time(1, local),
                }
            }
            (_, Some(LogicalType::Date)) => time(DAY_NS, true),
            (_, Some(LogicalType::Time(_))) => Err("times of day without a date"),
            (_, Some(LogicalType::Integer(integer))) if !integer.is_signed => Ok(Self::Unsigned),
            (FIXED_LEN_BYTE_ARRAY, Some(_)) => Err("bytes of a fixed length"),
            (physical, _) => match column.converted_type() {
                ConvertedType::DECIMAL => Ok(Self::Decimal(column.type_scale())),
                ConvertedType::TIMESTAMP_MILLIS => time(1_000_000, false),
                ConvertedType::TIMESTAMP_MICROS => time(1_000, false),
                ConvertedType::DATE => time(DAY_NS, true),
                ConvertedType::TIME_MILLIS | ConvertedType::TIME_MICROS => {
                    Err("times of day without a date")
                }
                ConvertedType::UINT_8
                | ConvertedType::UINT_16
                | ConvertedType::UINT_32
                | ConvertedType::UINT_64 => Ok(Self::Unsigned),
                ConvertedType::INTERVAL => Err("intervals"),
                _ if physical == FIXED_LEN_BYTE_ARRAY => Err("bytes of a fixed length"),
                _ if physical == BYTE_ARRAY => Ok(Self::Text),
                _ => Ok(Self::Number),
            },
        }
    }
}

/// The values of a column, row by row.
#[derive(Debug)]
pub(crate) struct Content {
    kind: Kind,
    /// NaN for no value.
    numbers: Vec<f64>,
    /// Nanoseconds since 1970.
    times: Vec<Option<i128>>,
    /// Numbers of words, which repeat in quality and tags.
    texts: Vec<u32>,
    words: Vec<String>,
    numbers_of_words: HashMap<String, u32>,
}

impl Content {
    pub(crate) fn new(kind: Kind) -> Self {
        Self {
            kind,
            numbers: Vec::new(),
            times: Vec::new(),
            texts: Vec::new(),
            words: Vec::new(),
            numbers_of_words: HashMap::new(),
        }
    }

    /// The rows there are.
    pub(crate) fn len(&self) -> usize {
        match self.kind {
            Kind::Text => self.texts.len(),
            Kind::Time { .. } => self.times.len(),
            Kind::Number | Kind::Unsigned | Kind::Decimal(_) => self.numbers.len(),
        }
    }

    /// The cell of a row.
    pub(crate) fn cell(&self, row: usize) -> Cell<'_> {
        match self.kind {
            Kind::Text => {
                let word = self
                    .texts
                    .get(row)
                    .and_then(|&word| self.words.get(word as usize));
                word.map_or(Cell::Nothing, |word| Cell::Text(word.trim()))
            }
            Kind::Time { local, .. } => match self.times.get(row) {
                Some(&Some(ns)) if local => Cell::Local(ns),
                Some(&Some(ns)) => Cell::Instant(ns),
                _ => Cell::Nothing,
            },
            Kind::Number | Kind::Unsigned | Kind::Decimal(_) => match self.numbers.get(row) {
                Some(&value) if !value.is_nan() => Cell::Number(value),
                _ => Cell::Nothing,
            },
        }
    }

    /// Appends the rows of a group.
    pub(crate) fn read(&mut self, reader: ColumnReader, most: i16) -> Result<(), ParquetError> {
        let kind = self.kind;
        match reader {
            ColumnReader::BoolColumnReader(reader) => each(reader, most, |v| {
                self.number(v.map(|&v| f64::from(u8::from(v))))
            }),
            ColumnReader::Int32ColumnReader(reader) => each(reader, most, |value| {
                let value = value.map(|&value| match kind {
                    Kind::Unsigned => i128::from(value.cast_unsigned()),
                    _ => i128::from(value),
                });
                self.integer(value);
                Ok(())
            }),
            ColumnReader::Int64ColumnReader(reader) => each(reader, most, |value| {
                let value = value.map(|&value| match kind {
                    Kind::Unsigned => i128::from(value.cast_unsigned()),
                    _ => i128::from(value),
                });
                self.integer(value);
                Ok(())
            }),
            ColumnReader::Int96ColumnReader(reader) => each(reader, most, |value| {
                self.times.push(value.map(int96_ns));
                Ok(())
            }),
            ColumnReader::FloatColumnReader(reader) => {
                each(reader, most, |v| self.number(v.map(|&v| f64::from(v))))
            }
            ColumnReader::DoubleColumnReader(reader) => {
                each(reader, most, |value| self.number(value.copied()))
            }
            ColumnReader::ByteArrayColumnReader(reader) => {
                each(reader, most, |value| self.bytes(value))
            }
            ColumnReader::FixedLenByteArrayColumnReader(reader) => each(reader, most, |value| {
                self.bytes(value.map(|value| &**value))
            }),
        }
    }

    #[expect(clippy::unnecessary_wraps, reason = "the others can fail")]
    fn number(&mut self, value: Option<f64>) -> Result<(), ParquetError> {
        self.numbers.push(value.unwrap_or(f64::NAN));
        Ok(())
    }

    fn integer(&mut self, value: Option<i128>) {
        match self.kind {
            Kind::Time { unit_ns, .. } => self.times.push(value.map(|value| value * unit_ns)),
            Kind::Decimal(scale) => {
                let value = value.map(|value| value as f64 / 10_f64.powi(scale));
                self.numbers.push(value.unwrap_or(f64::NAN));
            }
            Kind::Number | Kind::Unsigned | Kind::Text => {
                self.numbers
                    .push(value.map_or(f64::NAN, |value| value as f64));
            }
        }
    }

    fn bytes(&mut self, value: Option<&ByteArray>) -> Result<(), ParquetError> {
        if let Kind::Decimal(_) = self.kind {
            let value = match value.map(ByteArray::data) {
                Some(bytes) if bytes.len() > 16 => {
                    let error = format!("a decimal of {} bytes; 16 are read", bytes.len());
                    return Err(ParquetError::General(error));
                }
                Some(bytes) => Some(big_endian(bytes)),
                None => None,
            };
            self.integer(value);
            return Ok(());
        }
        let Some(value) = value else {
            self.texts.push(NO_WORD);
            return Ok(());
        };
        let text = value.as_utf8()?;
        let next = u32::try_from(self.words.len()).unwrap_or(NO_WORD);
        let word = if let Some(&word) = self.numbers_of_words.get(text) {
            word
        } else {
            self.words.push(text.to_owned());
            self.numbers_of_words.insert(text.to_owned(), next);
            next
        };
        self.texts.push(word);
        Ok(())
    }
}

/// Calls `visit` with every row of a group, in batches so that no number in a broken file asks for
/// memory.
fn each<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    most: i16,
    mut visit: impl FnMut(Option<&T::T>) -> Result<(), ParquetError>,
) -> Result<(), ParquetError> {
    loop {
        let (mut values, mut levels) = (Vec::new(), Vec::new());
        let wanted = (most > 0).then_some(&mut levels);
        let (records, ..) = reader.read_records(BATCH, wanted, None, &mut values)?;
        if records == 0 {
            return Ok(());
        }
        if most == 0 {
            values.iter().try_for_each(|value| visit(Some(value)))?;
            continue;
        }
        let mut values = values.iter();
        for level in levels {
            let value = if level == most { values.next() } else { None };
            visit(value)?;
        }
    }
}

/// A number in two's complement.
fn big_endian(bytes: &[u8]) -> i128 {
    let sign = bytes.first().map_or(0, |&first| -i128::from(first >> 7));
    bytes
        .iter()
        .fold(sign, |value, &byte| (value << 8) | i128::from(byte))
}

/// Nanoseconds of the day, then the Julian day.
fn int96_ns(value: &Int96) -> i128 {
    let [low, high, day] = *value.data() else {
        return 0;
    };
    let of_day = (i128::from(high) << 32) | i128::from(low);
    (i128::from(day) - EPOCH_JULIAN_DAY) * DAY_NS + of_day
}
