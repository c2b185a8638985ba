//! What is wrong with how a file is read.

/// Why a file cannot be read as it was asked to be. Options are named as on the command line.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ReadingError {
    /// An encoding that nobody knows.
    #[error(
        "--encoding: expected a label of the Encoding standard such as utf-8, utf-16le or \
         windows-1252, found `{found}`"
    )]
    Encoding {
        /// The label.
        found: String,
    },
    /// Bytes that the encoding does not have.
    #[error(
        "line {line}: expected text in {encoding}, found bytes that are none; give the encoding \
         the file was written in, for example --encoding windows-1252"
    )]
    Undecodable {
        /// The line, from 1.
        line: u64,
        /// The encoding.
        encoding: &'static str,
    },
    /// Lines are counted from 1.
    #[error("--header-line: expected a line from 1 on, found 0")]
    HeaderLineZero,
    /// A header beyond the end of the file.
    #[error("--header-line: expected a line of the file, which has {lines}, found {found}")]
    HeaderLine {
        /// The line asked for.
        found: u64,
        /// The lines there are.
        lines: u64,
    },
    /// Lines before the header.
    #[error(
        "line {line}: expected a header row of tags, found {found} field where line {guess} has \
         {fields}; if that is the header, give --header-line {guess}"
    )]
    Preamble {
        /// The first line.
        line: u64,
        /// Its fields.
        found: usize,
        /// The line that looks like a header.
        guess: u64,
        /// Its fields.
        fields: usize,
    },
    /// A word for a missing value that is a number.
    #[error("--bad-values: expected words, found the number `{found}`")]
    BadValue {
        /// The word.
        found: String,
    },
    /// A time zone that nobody knows.
    #[error(
        "--time-zone: expected a name of the IANA database such as Europe/Rome, found `{found}`"
    )]
    TimeZone {
        /// The name.
        found: String,
    },
    /// Dates whose day and month cannot be told apart.
    #[error(
        "column `{column}`: expected times that tell day from month, found none from `{found}` \
         on; give --time-format \"{day_first}\" or --time-format \"{month_first}\""
    )]
    DayOrMonth {
        /// The time column.
        column: String,
        /// The first time.
        found: String,
        /// The format with the day first.
        day_first: String,
        /// The format with the month first.
        month_first: String,
    },
    /// A file of another layout than the one that is asked for.
    #[error(
        "--layout long: expected columns tag, time and value, found {available}; name the time \
         column (--time), or leave --layout out"
    )]
    NotLong {
        /// The columns there are.
        available: String,
    },
    /// Tags with times of their own.
    #[error(
        "expected all tags at the same times, found {first_count} readings of `{first}` and \
         {other_count} of `{other}` at other times; give --resample with the sample time you want"
    )]
    OwnTimes {
        /// A tag.
        first: String,
        /// Its readings.
        first_count: usize,
        /// Another tag.
        other: String,
        /// Its readings.
        other_count: usize,
    },
    /// A number of seconds that is none.
    #[error("--{option}: expected a positive, finite number of seconds, found {found}")]
    NotPositive {
        /// The option, without dashes.
        option: &'static str,
        /// The number.
        found: f64,
    },
    /// A limit that means take no limit for.
    #[error(
        "--hold-at-most: expected with --resample-method hold or linear, found {found} with mean"
    )]
    HoldWithMean {
        /// The limit in seconds.
        found: f64,
    },
    /// No limit where one is needed.
    #[error(
        "--hold-at-most: required with --resample-method hold and linear, for example \
         --hold-at-most 60"
    )]
    HoldMissing,
    /// More samples than anyone wants.
    #[error(
        "--resample: expected at most {most} samples, found {found}; give a longer step, or look \
         for a wrong time"
    )]
    TooManySamples {
        /// The samples it would be.
        found: f64,
        /// The most there may be.
        most: f64,
    },
    /// Samples for which there is no reading that may stand for them.
    #[error(
        "`{tag}`: expected a reading for each of {samples} samples, found none for {missing}, the \
         first at sample {first}"
    )]
    NoReading {
        /// The tag.
        tag: String,
        /// The samples without one.
        missing: usize,
        /// All samples.
        samples: usize,
        /// The first without one, from 0.
        first: usize,
    },
    /// Nothing to resample by.
    #[error("--resample: expected a time column, found none; name it (--time)")]
    NoTimes,
    /// Two sample times.
    #[error("--resample: expected without --sample-time, found both")]
    TwoSampleTimes,
    /// A file of tags that cannot be read.
    #[error("expected a section [tags.\"TAG\"] for each tag, found: {cause}")]
    TagFile {
        /// What is wrong.
        cause: String,
    },
    /// A rule of a file of tags that cannot be followed.
    #[error("tag `{tag}`: {found}")]
    TagRule {
        /// The tag.
        tag: String,
        /// What was expected and what was found.
        found: String,
    },
    /// A gap that does not fit the sample time.
    #[error(
        "sample {sample}: expected a gap of a whole number of sample times ({period_s} s), found \
         {steps}; --resample makes samples of one period"
    )]
    OddGap {
        /// The sample after the gap.
        sample: usize,
        /// The gap in sample times.
        steps: f64,
        /// The sample time.
        period_s: f64,
    },
    /// A gap too long to fill.
    #[error(
        "expected at most {most} samples, found more in a gap of {seconds} s; choose rows without \
         it (--rows), or look for a wrong time"
    )]
    LongGap {
        /// The gap in seconds.
        seconds: f64,
        /// The most samples there may be.
        most: f64,
    },
    /// A file that is neither a table nor a log.
    #[error("expected a file that ends in .csv, .parquet or .mcap, found {found}")]
    NoTable {
        /// The extension found, in words.
        found: String,
    },
    /// A Parquet file that cannot be read.
    #[error("expected a sound Parquet file, found: {cause}")]
    Parquet {
        /// What the reader found.
        cause: String,
    },
    /// Two columns of one name.
    #[error("expected every column once, found `{column}` twice")]
    ParquetTwice {
        /// The name.
        column: String,
    },
    /// A column that has no numbers, texts or times.
    #[error("column `{column}`: expected numbers, texts or times, found {found}")]
    ParquetColumn {
        /// The column.
        column: String,
        /// What it holds.
        found: String,
    },
    /// A codec that is not built in.
    #[error(
        "column `{column}`: expected no compression, Snappy, gzip or zstd, found {found}; write the file \
         again, for example with compression=\"zstd\" in pandas, pyarrow or DuckDB"
    )]
    ParquetCodec {
        /// The column.
        column: String,
        /// The codec.
        found: String,
    },
    /// An option that a Parquet file cannot follow.
    #[error("--{option}: expected with a CSV file, found a Parquet file")]
    OnlyForText {
        /// The option, without dashes.
        option: &'static str,
    },
    /// An option that a log cannot follow.
    #[error("--{option}: expected with .csv or .parquet, found an MCAP log")]
    NotForLogs {
        /// The option, without dashes.
        option: &'static str,
    },
}
