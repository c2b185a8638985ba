//! Cells into numbers.

use gtfdi::ident::Missing;

use super::sheet::Cell;
use super::{Decimal, Reading};
use crate::error::CellProblem;

/// What historians, SCADA systems and spreadsheets write where there is no value, in lower case.
const MISSING_WORDS: [&str; 37] = [
    "-",
    "--",
    "---",
    "?",
    "#div/0!",
    "#n/a",
    "#num!",
    "#ref!",
    "#value!",
    "arc off-line",
    "bad",
    "bad data",
    "bad input",
    "bad quality",
    "bad total",
    "calc failed",
    "calc off",
    "comm fail",
    "configure",
    "disconnected",
    "error",
    "i/o timeout",
    "intf shut",
    "invalid",
    "missing",
    "n/a",
    "na",
    "no data",
    "no result",
    "no sample",
    "none",
    "not connect",
    "null",
    "out of serv",
    "pt created",
    "scan off",
    "shutdown",
];

/// What a cell of a number column holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Sample<'a> {
    /// A finite number.
    Number(f64),
    /// Nothing valid, and the word for it, which may be empty.
    Missing(&'a str),
}

impl Sample<'_> {
    /// The number, NaN where there is none and that may be.
    pub(crate) fn allowed(self, missing: Missing) -> Result<f64, CellProblem> {
        match self {
            Self::Number(value) => Ok(value),
            Self::Missing(_) if missing == Missing::Break => Ok(f64::NAN),
            Self::Missing("") => Err(CellProblem::Empty),
            Self::Missing(word) if is_nan(word) => Err(CellProblem::NotFinite(word.to_owned())),
            Self::Missing(word) => Err(CellProblem::Bad(word.to_owned())),
        }
    }
}

/// How numbers are written in a file.
#[derive(Debug, Clone)]
pub(crate) struct Numerals {
    decimal: Decimal,
    bad_values: Vec<String>,
}

impl Numerals {
    pub(crate) fn new(decimal: Decimal, reading: &Reading) -> Self {
        let words = reading.bad_values.iter();
        Self {
            decimal,
            bad_values: words.map(|word| word.trim().to_lowercase()).collect(),
        }
    }

    /// A finite number, or nothing valid.
    pub(crate) fn sample<'c>(&self, cell: Cell<'c>) -> Result<Sample<'c>, CellProblem> {
        let text = match cell {
            Cell::Text(text) => text,
            Cell::Number(value) if value.is_finite() => return Ok(Sample::Number(value)),
            Cell::Number(value) if value.is_nan() => return Ok(Sample::Missing("NaN")),
            Cell::Nothing => return Ok(Sample::Missing("")),
            Cell::Number(_) => return Err(CellProblem::NotFinite(cell.to_string())),
            Cell::Instant(_) | Cell::Local(_) => return Err(CellProblem::Text(cell.to_string())),
        };
        match self.parse(text) {
            Some(value) if value.is_finite() => return Ok(Sample::Number(value)),
            Some(value) if !value.is_nan() => return Err(CellProblem::NotFinite(text.to_owned())),
            _ => {}
        }
        if self.is_missing(text) {
            return Ok(Sample::Missing(text));
        }
        let text = text.to_owned();
        Err(match self.decimal {
            _ if has_thousands(&text, self.decimal) => CellProblem::Thousands(text),
            Decimal::Point if is_decimal(&text, b',') => CellProblem::Comma(text),
            _ => CellProblem::Text(text),
        })
    }

    /// The number that a text is.
    pub(crate) fn parse(&self, text: &str) -> Option<f64> {
        if self.decimal == Decimal::Point || !text.contains([',', '.']) {
            return text.parse().ok();
        }
        let is_point = text.contains('.');
        (!is_point).then(|| text.replacen(',', ".", 1).parse().ok())?
    }

    /// Whether a text stands for a value that is not there.
    pub(crate) fn is_missing(&self, text: &str) -> bool {
        if text.is_empty() || is_nan(text) {
            return true;
        }
        let text = text.to_lowercase();
        MISSING_WORDS.contains(&text.as_str()) || self.bad_values.contains(&text)
    }
}

fn is_nan(text: &str) -> bool {
    text.parse::<f64>().is_ok_and(f64::is_nan)
}

/// Whether a text is a number with this decimal sign in it: `-1,5e3`.
pub(crate) fn is_decimal(text: &str, sign: u8) -> bool {
    let mut signs = text.bytes().filter(|byte| !byte.is_ascii_digit());
    let has_one = text.bytes().filter(|&byte| byte == sign).count() == 1;
    let fits = signs.all(|byte| byte == sign || b"+-eE".contains(&byte));
    let point = text.replacen(char::from(sign), ".", 1);
    has_one && fits && point.parse::<f64>().is_ok()
}

/// Whether a text is a number whose digits are grouped by threes: `1,234.5`, `12 000`.
fn has_thousands(text: &str, decimal: Decimal) -> bool {
    let sign = if decimal == Decimal::Point { '.' } else { ',' };
    let text = text.trim_start_matches(['+', '-']);
    let whole = match text.split_once(sign) {
        Some((whole, fraction)) if fraction.bytes().all(|byte| byte.is_ascii_digit()) => whole,
        Some(_) => return false,
        None => text,
    };
    let separators = [',', '.', ' ', '\'', '\u{a0}', '\u{202f}', '\u{2019}'];
    separators
        .into_iter()
        .filter(|&s| s != sign)
        .any(|separator| {
            let mut groups = whole.split(separator);
            let is_digits = |group: &str| group.bytes().all(|byte| byte.is_ascii_digit());
            let first = groups.next().unwrap_or_default();
            let mut rest = groups.peekable();
            (1..=3).contains(&first.len())
                && is_digits(first)
                && rest.peek().is_some()
                && rest.all(|group| group.len() == 3 && is_digits(group))
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(decimal: Decimal, text: &str) -> Result<Sample<'_>, CellProblem> {
        let reading = Reading {
            bad_values: vec!["Defekt".to_owned()],
            ..Reading::default()
        };
        Numerals::new(decimal, &reading).sample(Cell::Text(text))
    }

    #[test]
    fn the_words_are_sorted_and_in_lower_case() {
        assert!(
            MISSING_WORDS
                .iter()
                .all(|word| *word == word.to_lowercase())
        );
        let unique: std::collections::BTreeSet<_> = MISSING_WORDS.iter().collect();
        assert_eq!(unique.len(), MISSING_WORDS.len());
    }

    #[test]
    fn points_and_commas_are_kept_apart() {
        use CellProblem::{Comma, Text, Thousands};
        let point = |text| of(Decimal::Point, text);
        let comma = |text| of(Decimal::Comma, text);
        assert_eq!(point("-1.5e3"), Ok(Sample::Number(-1500.0)));
        assert_eq!(comma("-1,5e3"), Ok(Sample::Number(-1500.0)));
        assert_eq!(comma("7"), Ok(Sample::Number(7.0)));
        assert_eq!(point("2,5"), Err(Comma("2,5".into())));
        assert_eq!(comma("2.5"), Err(Text("2.5".into())));
        for text in [
            "1,234",
            "1,234.5",
            "-12,345,678",
            "1 234",
            "1'234.5",
            "1\u{a0}234",
        ] {
            assert_eq!(point(text), Err(Thousands(text.into())), "{text}");
        }
        for text in ["1.234", "1.234,5", "1 234,5"] {
            assert_eq!(comma(text), Err(Thousands(text.into())), "{text}");
        }
        for text in ["1,2,3", "12,34,567", "1.2.3", "x", "1,234,", "1e5,5"] {
            assert_eq!(point(text), Err(Text(text.into())), "{text}");
        }
        assert_eq!(comma("1,5,"), Err(Text("1,5,".into())));
    }

    #[test]
    fn words_are_missing_in_any_case() {
        for word in [
            "",
            "Bad",
            "I/O Timeout",
            "PT CREATED",
            "NaN",
            "null",
            "-",
            "defekt",
        ] {
            assert_eq!(
                of(Decimal::Point, word),
                Ok(Sample::Missing(word)),
                "{word}"
            );
            assert_eq!(
                of(Decimal::Comma, word),
                Ok(Sample::Missing(word)),
                "{word}"
            );
        }
        assert_eq!(
            of(Decimal::Point, "badly"),
            Err(CellProblem::Text("badly".into()))
        );
    }
}
