//! Numbers and tables as plain text.

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

/// A table for people: the first column to the left, numbers to the right.
pub fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let widths: Vec<usize> = head
        .iter()
        .enumerate()
        .map(|(column, title)| {
            let cells = rows.iter().filter_map(|row| row.get(column));
            cells
                .map(|cell| cell.chars().count())
                .fold(title.chars().count(), usize::max)
        })
        .collect();
    let line = |cells: &mut dyn Iterator<Item = &str>| {
        let mut text = String::new();
        for (column, cell) in cells.enumerate() {
            let pad = " ".repeat(widths[column].saturating_sub(cell.chars().count()));
            if column == 0 {
                text.push_str(cell);
                text.push_str(&pad);
            } else {
                text.push_str("  ");
                text.push_str(&pad);
                text.push_str(cell);
            }
        }
        text.truncate(text.trim_end().len());
        text.push('\n');
        text
    };
    let mut text = line(&mut head.iter().copied());
    for row in rows {
        text.push_str(&line(&mut row.iter().map(String::as_str)));
    }
    text
}

/// Text broken into lines of at most `width` characters, between words; a longer word has a line
/// of its own.
pub fn wrap(text: &str, width: usize) -> String {
    let mut lines = String::new();
    let mut length = 0;
    for word in text.split_whitespace() {
        let count = word.chars().count();
        if length > 0 && length + 1 + count > width {
            lines.push('\n');
            length = 0;
        } else if length > 0 {
            lines.push(' ');
            length += 1;
        }
        lines.push_str(word);
        length += count;
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::{digits, table, wrap};

    #[test]
    fn lines_break_between_words() {
        assert_eq!(wrap("a bb  ccc dddddd e", 5), "a bb\nccc\ndddddd\ne");
        assert_eq!(wrap("", 5), "");
    }

    #[test]
    fn digits_are_significant() {
        assert_eq!(digits(1_014_989.503, 6), "1014990");
        assert_eq!(digits(0.876_73, 6), "0.876730");
        assert_eq!(digits(3.2e-8, 2), "3.2e-8");
        assert_eq!(digits(f64::NAN, 2), "-");
        assert_eq!(digits(0.01, 1), "0.01");
    }

    #[test]
    fn numbers_stand_to_the_right() {
        let rows = [["y".into(), "1".into()], ["q_c".into(), "22.5".into()]];
        let rows = rows.map(|row: [String; 2]| row.to_vec());
        assert_eq!(
            table(&["tag", "fit"], &rows),
            "tag   fit\ny       1\nq_c  22.5\n"
        );
    }
}
