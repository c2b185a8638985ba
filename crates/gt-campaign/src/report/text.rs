//! Numbers and tables as plain text.

use std::fmt::Write as _;

/// A fixed number of significant digits, plain where that is readable.
pub fn digits(value: f64, significant: i32) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return "-".to_owned();
    }
    #[allow(clippy::cast_possible_truncation)] // the exponent of a double
    let exponent = value.abs().log10().floor() as i32;
    if (-4..9).contains(&exponent) {
        #[allow(clippy::cast_sign_loss)] // not negative
        let decimals = (significant - 1 - exponent).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        #[allow(clippy::cast_sign_loss)] // not negative
        let decimals = (significant - 1).max(0) as usize;
        format!("{value:.decimals$e}")
    }
}

/// Rows of equal cells, aligned.
pub fn aligned(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns)
        .map(|column| {
            rows.iter()
                .filter_map(|row| row.get(column))
                .map(|cell| cell.chars().count())
                .max()
        })
        .map(Option::unwrap_or_default)
        .collect();
    let mut text = String::new();
    for row in rows {
        for (column, cell) in row.iter().enumerate() {
            let pad = " ".repeat(widths[column] - cell.chars().count());
            let _ = if column == 0 {
                write!(text, "  {cell}{pad}")
            } else {
                write!(text, "  {pad}{cell}")
            };
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{aligned, digits};

    #[test]
    fn digits_are_significant() {
        assert_eq!(digits(1_014_989.503, 6), "1014990");
        assert_eq!(digits(0.876_73, 6), "0.876730");
        assert_eq!(digits(3.2e-8, 2), "3.2e-8");
        assert_eq!(digits(f64::NAN, 2), "-");
        assert_eq!(digits(0.01, 1), "0.01");
    }

    #[test]
    fn columns_line_up() {
        let rows = [
            vec!["a".to_owned(), "10".to_owned()],
            vec!["bcd".to_owned(), "7".to_owned()],
        ];
        assert_eq!(aligned(&rows), "  a    10\n  bcd   7\n");
    }
}
