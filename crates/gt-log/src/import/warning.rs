//! What the user should know of a record.

use std::fmt;

/// What the user should know of a record that could be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Warning {
    /// Neither a time column nor a sample time: the sample time is set to 1.
    TimeInSamples,
    /// Values that are NaN: the sensor gave nothing valid.
    InvalidSamples {
        /// The tag.
        column: String,
        /// How many there are.
        count: usize,
    },
    /// A word for a missing value.
    BadWord {
        /// The tag.
        column: String,
        /// The word, as it stands.
        word: String,
        /// How many there are.
        count: usize,
    },
    /// A comma was taken for the decimal sign.
    DecimalComma,
    /// A row below the header was taken for the units.
    UnitRow {
        /// Its line, from 1.
        line: u64,
    },
    /// Numbers were taken for times since 1970.
    EpochTimes {
        /// The time column.
        column: String,
        /// `seconds`, `milliseconds` and so on.
        unit: &'static str,
    },
    /// A format of the times was found out.
    TimesRead {
        /// The time column.
        column: String,
        /// The format.
        format: String,
    },
    /// Readings of uncertain quality, which are kept.
    Uncertain {
        /// The tag.
        column: String,
        /// How many there are.
        count: usize,
    },
    /// Readings outside their range, which are missing.
    OutOfRange {
        /// The tag.
        column: String,
        /// How many there are.
        count: usize,
    },
    /// Times that the time zone has twice were told apart by their order.
    Folded {
        /// How many there are.
        count: usize,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TimeInSamples => f.write_str(
                "no column named time, timestamp or t and no sample time given: time is counted \
                 in samples (sample time 1)",
            ),
            Self::InvalidSamples { column, count } => {
                write!(f, "`{column}` has {count} samples that are not valid (NaN)")
            }
            Self::BadWord {
                column,
                word,
                count,
            } => write!(f, "`{column}`: {count} times `{word}`, read as missing"),
            Self::DecimalComma => {
                f.write_str("the comma is taken for the decimal sign; --decimal says otherwise")
            }
            Self::UnitRow { line } => write!(f, "line {line} is taken for the units"),
            Self::EpochTimes { column, unit } => write!(
                f,
                "the numbers of `{column}` are taken for {unit} since 1970; --sample-time does \
                 without them"
            ),
            Self::TimesRead { column, format } => write!(
                f,
                "the times of `{column}` are read as `{format}`; --time-format says otherwise"
            ),
            Self::Uncertain { column, count } => {
                write!(f, "`{column}`: {count} readings of uncertain quality, kept")
            }
            Self::OutOfRange { column, count } => write!(
                f,
                "`{column}`: {count} readings outside the range of the tags' file, read as missing"
            ),
            Self::Folded { count } => write!(
                f,
                "{count} times of the hour that comes twice when clocks are put back are told \
                 apart by their order"
            ),
        }
    }
}
