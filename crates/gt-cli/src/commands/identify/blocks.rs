//! The rows of each record.

use std::ops::Range;
use std::path::Path;

use gtfdi::ident::RecordOrigin;

use crate::cli::IdentifyArgs;
use crate::failure::Failure;

/// The training and the validation rows, and the rows of a file that hold both: only those have to
/// be readable.
pub struct Blocks {
    pub train: Option<Range<usize>>,
    pub validate: Option<Range<usize>>,
    pub window: Option<Range<usize>>,
}

impl Blocks {
    pub fn of(args: &IdentifyArgs) -> Self {
        let [train, validate] =
            [&args.train, &args.validate].map(|rows| rows.as_ref().map(|rows| rows.0.clone()));
        let window = match (&train, &validate) {
            (Some(train), Some(validate)) => {
                Some(train.start.min(validate.start)..train.end.max(validate.end))
            }
            (Some(train), None) => Some(train.clone()),
            (None, _) => None,
        };
        Self {
            train,
            validate,
            window,
        }
    }

    /// What the rows to validate on are to the fit.
    pub fn origin(&self, holdout: bool) -> RecordOrigin {
        if holdout || self.validate.is_some() && self.validate != self.train {
            RecordOrigin::Fresh
        } else {
            RecordOrigin::Fitted
        }
    }

    /// The rows that the file has not, by the option that asks for them.
    pub fn beyond(&self, path: &Path, total: usize) -> Option<Failure> {
        [("--train", &self.train), ("--validate", &self.validate)]
            .into_iter()
            .filter_map(|(option, rows)| Some((option, rows.as_ref()?)))
            .find(|(_, rows)| rows.end > total)
            .map(|(option, rows)| {
                let (start, end) = (rows.start, rows.end);
                Failure::in_file(
                    path,
                    format!(
                        "{option}: expected rows A:B with B at most {total}, found {start}:{end}"
                    ),
                )
            })
    }
}
