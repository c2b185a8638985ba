//! Whether faults were called by their names, and how well onset and size were said.

use gtfdi::plant::FaultCase;
use serde::Serialize;

use super::interval::Proportion;
use super::naming::NONE_OF_THESE;
use super::row::Row;
use crate::isolation::SIZE_TOLERANCE;

/// Columns of [`Confusion`] beside the names.
const TWO_AT_ONCE: &str = "two at once";
const UNDECIDED: &str = "undecided";
const UNDETECTED: &str = "undetected";

/// How faults were named. A name is that which stood five seconds after the alarm.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamingCounts {
    /// Rightly named runs of all named ones.
    pub right: Proportion,
    /// Detected runs that were ever given a wrong name.
    pub ever_wrong: Proportion,
    /// Detected runs without a name.
    pub undecided: Proportion,
    /// Detected runs whose size at the end is within 15 %.
    pub size_within_15_percent: Proportion,
    /// Detected runs whose size lies in its 95 % interval.
    pub size_in_interval: Proportion,
    /// Detected runs whose onset lies in its 95 % interval.
    pub onset_in_interval: Proportion,
}

impl NamingCounts {
    /// Heads of [`NamingCounts::cells`].
    pub const HEAD: [&'static str; 6] = [
        "named right %",
        "ever wrong %",
        "undecided %",
        "size within 15 %",
        "size in interval %",
        "onset in interval %",
    ];

    /// All shares in percent with their intervals.
    pub fn cells(&self) -> [String; 6] {
        [
            self.right,
            self.ever_wrong,
            self.undecided,
            self.size_within_15_percent,
            self.size_in_interval,
            self.onset_in_interval,
        ]
        .map(|own| own.to_string())
    }

    /// Counts the runs with a fault; `None` where nothing gives names.
    pub(super) fn of<'a>(rows: impl Iterator<Item = &'a Row>) -> Option<Self> {
        let judged = rows.filter(|row| row.right.is_some());
        let judged: Vec<&Row> = judged.collect();
        if judged.is_empty() {
            return None;
        }
        let detected = judged.iter().filter(|row| row.detected == Some(true));
        let named = detected.clone().filter(|row| row.named.is_some());
        let sizes = detected.clone().filter_map(|row| {
            let truth = row.size? * row.sign?;
            Some((
                truth,
                row.found_size?,
                row.found_size_low?,
                row.found_size_high?,
            ))
        });
        let onsets = detected.clone().filter_map(|row| {
            let inside = row.found_onset_low_s?..=row.found_onset_high_s?;
            Some(inside.contains(&row.onset_s?))
        });
        Some(Self {
            right: Proportion::of(named.map(|row| row.right == Some(true))),
            ever_wrong: Proportion::of(detected.clone().map(|row| row.ever_wrong == Some(true))),
            undecided: Proportion::of(detected.map(|row| row.named.is_none())),
            size_within_15_percent: Proportion::of(
                sizes.clone().map(|(truth, found, ..)| {
                    (found - truth).abs() <= SIZE_TOLERANCE * truth.abs()
                }),
            ),
            size_in_interval: Proportion::of(
                sizes.map(|(truth, _, low, high)| low <= truth && truth <= high),
            ),
            onset_in_interval: Proportion::of(onsets),
        })
    }
}

/// Which fault was named in the place of which; without names where a bank judges.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Confusion {
    /// The faults that were there.
    pub faults: Vec<String>,
    /// The names that were given.
    pub names: Vec<String>,
    /// Runs: a row a fault, a column a name.
    pub runs: Vec<Vec<u64>>,
}

impl Confusion {
    /// Counts the whole runs with one of `faults`.
    pub(super) fn of(faults: &[&str], whole: &[&Row]) -> Self {
        let mut rows: Vec<String> = Vec::new();
        for fault in faults {
            if !rows.iter().any(|own| own == fault) {
                rows.push((*fault).to_owned());
            }
        }
        if whole.iter().all(|row| row.right.is_none()) {
            let runs = vec![Vec::new(); rows.len()];
            return Self {
                faults: rows,
                names: Vec::new(),
                runs,
            };
        }
        let mut names: Vec<String> = FaultCase::ALL
            .iter()
            .map(|case| case.name().to_owned())
            .collect();
        // An isolator of a file may know other faults.
        let single = |name: &&str| *name != NONE_OF_THESE && !name.contains(" and ");
        for name in whole
            .iter()
            .filter_map(|row| row.named.as_deref())
            .filter(single)
        {
            if !names.iter().any(|own| own == name) {
                names.push(name.to_owned());
            }
        }
        names.extend([NONE_OF_THESE, TWO_AT_ONCE, UNDECIDED, UNDETECTED].map(str::to_owned));
        let column = |row: &Row| match (row.detected, row.named.as_deref()) {
            (Some(true), Some(name)) if name.contains(" and ") => TWO_AT_ONCE.to_owned(),
            (Some(true), Some(name)) => name.to_owned(),
            (Some(true), None) => UNDECIDED.to_owned(),
            _ => UNDETECTED.to_owned(),
        };
        let count = |fault: &String, name: &String| {
            let own = whole
                .iter()
                .filter(|row| row.fault.as_ref() == Some(fault) && column(row) == *name);
            own.count() as u64
        };
        let runs = rows
            .iter()
            .map(|fault| names.iter().map(|name| count(fault, name)).collect())
            .collect();
        Self {
            faults: rows,
            names,
            runs,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(fault: &str, detected: bool, named: Option<&str>, right: bool) -> Row {
        Row {
            fault: Some(fault.to_owned()),
            size: Some(2.0),
            sign: Some(-1.0),
            onset_s: Some(10.0),
            detected: Some(detected),
            named: named.map(str::to_owned),
            right: Some(right),
            ever_wrong: Some(named.is_some() && !right),
            ..Row::blank()
        }
    }

    #[test]
    fn shares_are_of_what_they_say() {
        let (one, two) = ("compressor_fouling", "thermocouple_drift");
        let rows = [
            Row {
                found_size: Some(-2.2),
                found_size_low: Some(-2.1),
                found_size_high: Some(-1.0),
                found_onset_low_s: Some(9.0),
                found_onset_high_s: Some(10.0),
                ..row(one, true, Some(one), true)
            },
            // The size has the wrong sign, and the onset is off.
            Row {
                found_size: Some(2.0),
                found_size_low: Some(1.0),
                found_size_high: Some(3.0),
                found_onset_low_s: Some(10.5),
                found_onset_high_s: Some(11.0),
                ..row(two, true, Some(one), false)
            },
            row(two, true, None, false),
            row(
                two,
                true,
                Some("compressor_fouling and thermocouple_drift"),
                false,
            ),
            row(two, true, Some(NONE_OF_THESE), false),
            // What came too late is not counted, whatever it was called.
            row(two, false, Some(two), true),
        ];
        let counts = NamingCounts::of(rows.iter()).expect("counts");
        let pairs = |own: Proportion| (own.count, own.of);
        assert_eq!(pairs(counts.right), (1, 4));
        assert_eq!(pairs(counts.ever_wrong), (3, 5));
        assert_eq!(pairs(counts.undecided), (1, 5));
        assert_eq!(pairs(counts.size_within_15_percent), (1, 2));
        assert_eq!(pairs(counts.size_in_interval), (1, 2));
        assert_eq!(pairs(counts.onset_in_interval), (1, 2));

        let whole: Vec<&Row> = rows.iter().collect();
        let confusion = Confusion::of(&[one, two, two], &whole);
        assert_eq!(confusion.faults, [one, two]);
        // Fouling, drift, damage, lag, none of these, two at once, undecided, undetected.
        assert_eq!(confusion.runs[0], [1, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(confusion.runs[1], [1, 0, 0, 0, 1, 1, 1, 1]);
    }

    #[test]
    fn a_bank_names_nothing() {
        let rows = [Row {
            right: None,
            ..row("compressor_fouling", true, None, false)
        }];
        assert_eq!(NamingCounts::of(rows.iter()), None);
        let confusion = Confusion::of(&["compressor_fouling"], &[&rows[0]]);
        assert!(confusion.names.is_empty() && confusion.runs == [Vec::<u64>::new()]);
    }
}
