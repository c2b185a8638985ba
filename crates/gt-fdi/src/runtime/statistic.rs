//! The decision on one residual: a run of samples above a fixed limit.

/// The run of consecutive samples with `|r| > limit` that the newest sample belongs to: the
/// geometric test of the paper's eq. 26, with memory.
///
/// An alarm is up while the run is at least `consecutive` samples long; it ends, and may come
/// again, when the residual returns to the limit or is not a number.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ExceedanceRun {
    length: usize,
    first_s: f64,
}

impl ExceedanceRun {
    /// Takes the residual at `time_s` into account and returns the length of the run, 0 when the
    /// residual is within the limit or NaN.
    pub fn update(&mut self, time_s: f64, residual: f64, limit: f64) -> usize {
        if residual.abs() > limit {
            if self.length == 0 {
                self.first_s = time_s;
            }
            self.length = self.length.saturating_add(1);
        } else {
            self.clear();
        }
        self.length
    }

    /// Ends the run.
    pub fn clear(&mut self) {
        self.length = 0;
    }

    /// Samples in the run.
    pub fn length(&self) -> usize {
        self.length
    }

    /// Time of the run's first sample in seconds, the estimate of the fault's onset; `None`
    /// outside a run.
    pub fn first_exceedance_s(&self) -> Option<f64> {
        (self.length > 0).then_some(self.first_s)
    }
}
