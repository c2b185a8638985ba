//! Standard output: the result and nothing else. Standard error: all the rest.

use std::io::{ErrorKind, Write, stderr, stdout};

use gt_campaign::report::text::digits;
use serde::Serialize;

use crate::failure::Failure;

pub use gt_campaign::report::text::table;

/// Writes `text` to standard output; a reader that went away is no failure.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::failed(error)),
        _ => Ok(()),
    }
}

/// Writes one JSON object and a line end.
pub fn print_json(value: &impl Serialize) -> Result<(), Failure> {
    let mut text = serde_json::to_string(value).map_err(Failure::failed)?;
    text.push('\n');
    print(&text)
}

/// Writes a diagnostic to standard error. Where nobody reads that, there is nobody to tell.
pub fn complain(text: &str) {
    let _ = writeln!(stderr().lock(), "gtfdi: {text}");
}

/// A number that may be missing or not finite: four significant digits or a dash.
pub fn number(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| digits(value, 4))
}

/// The fit of a free run in per cent, or when it diverges.
pub fn free_run(fit_percent: Option<f64>, diverges_at_s: Option<f64>) -> String {
    diverges_at_s.map_or_else(
        || number(fit_percent),
        |time| format!("diverges at {} s", number(Some(time))),
    )
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_have_four_digits() {
        let cases = [
            (0.0, "0"),
            (0.0012345, "0.001234"),
            (123.456, "123.5"),
            (-98765.4, "-98765"),
            (1.5e-9, "1.500e-9"),
            (f64::NAN, "-"),
            (f64::INFINITY, "-"),
        ];
        for (value, text) in cases {
            assert_eq!(number(Some(value)), text);
        }
        assert_eq!(number(None), "-");
    }
}
