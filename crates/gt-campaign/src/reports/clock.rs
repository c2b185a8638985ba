//! The abscissa of charts over time.

use gtfdi::core::Dataset;

/// From this time on a record's start is a date, and charts count from it.
const DATE_FROM_S: f64 = 1e7;

/// Times of a record as its charts show them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clock {
    origin_s: f64,
}

impl Clock {
    pub fn of(data: &Dataset) -> Self {
        let start_s = data.start_time_s();
        Self {
            origin_s: if start_s.abs() < DATE_FROM_S {
                0.0
            } else {
                start_s
            },
        }
    }

    /// A time of the record, as charts have it.
    pub fn shown_s(self, time_s: f64) -> f64 {
        time_s - self.origin_s
    }

    /// The times of a record's samples.
    pub fn times_s(self, data: &Dataset) -> Vec<f64> {
        (0..data.len())
            .map(|k| self.shown_s(data.time_s(k)))
            .collect()
    }

    /// What a reader of a table of times has to know.
    pub fn note(self) -> Option<String> {
        (self.origin_s != 0.0).then(|| {
            format!(
                "Times are in seconds after {} s, the start of the record.",
                self.origin_s
            )
        })
    }

    /// The label of the axis.
    pub fn label(self) -> String {
        if self.origin_s == 0.0 {
            "time [s]".to_owned()
        } else {
            format!("time after {} s [s]", self.origin_s)
        }
    }
}

#[cfg(test)]
mod tests {
    use gtfdi::core::Signal;
    use nalgebra::DMatrix;

    use super::*;

    #[test]
    fn a_date_is_taken_off() {
        let (u, y) = (DMatrix::zeros(0, 3), DMatrix::zeros(1, 3));
        let data = Dataset::new(vec![], Signal::named(&["y"]), u, y, 0.5).expect("a record");
        let plain = Clock::of(&data);
        assert_eq!(plain.times_s(&data), [0.0, 0.5, 1.0]);
        assert_eq!(plain.label(), "time [s]");
        let data = data.starting_at(1_732_680_000.0);
        let dated = Clock::of(&data);
        assert_eq!(dated.times_s(&data), [0.0, 0.5, 1.0]);
        assert_eq!(dated.label(), "time after 1732680000 s [s]");
        assert!((dated.shown_s(1_732_680_002.0) - 2.0).abs() < 1e-9);
    }
}
