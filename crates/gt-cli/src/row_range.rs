//! A range of rows, `A:B`, 0-based and half open.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A non-empty range of rows.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
pub struct RowRange(pub Range<usize>);

impl FromStr for RowRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let bad = || format!("expected rows A:B with A < B, such as 0:500, found `{text}`");
        let (start, end) = text.split_once(':').ok_or_else(bad)?;
        let start: usize = start.trim().parse().map_err(|_| bad())?;
        let end: usize = end.trim().parse().map_err(|_| bad())?;
        if start < end {
            Ok(Self(start..end))
        } else {
            Err(bad())
        }
    }
}

impl TryFrom<String> for RowRange {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<RowRange> for String {
    fn from(range: RowRange) -> Self {
        range.to_string()
    }
}

impl fmt::Display for RowRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.0.start, self.0.end)
    }
}

#[cfg(test)]
mod tests {
    use super::RowRange;

    #[test]
    fn parses_half_open_ranges_and_refuses_the_rest() {
        assert_eq!("0:500".parse(), Ok(RowRange(0..500)));
        for bad in ["", "5", "5:5", "6:5", "a:5", "-1:5", "1:2:3"] {
            let error = bad.parse::<RowRange>().expect_err(bad);
            assert!(error.ends_with(&format!("found `{bad}`")), "{error}");
        }
    }
}
