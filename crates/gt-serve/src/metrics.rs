//! Counters of the service, in the text format of Prometheus.

use std::fmt::Write as _;
use std::sync::atomic::{AtomicU64, Ordering};

/// Upper ends of the buckets of the delay from arrival to verdict, in seconds.
const DELAY_BUCKETS_S: [f64; 10] = [0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.5, 2.0];

/// A histogram of delays.
#[derive(Debug, Default)]
pub struct Delays {
    /// One more than there are ends.
    counts: [AtomicU64; DELAY_BUCKETS_S.len() + 1],
    sum_us: AtomicU64,
}

impl Delays {
    /// Takes a delay in nanoseconds.
    pub fn take(&self, delay_ns: i64) {
        let delay_s = delay_ns.max(0) as f64 * 1e-9;
        let bucket = DELAY_BUCKETS_S.partition_point(|end_s| *end_s < delay_s);
        self.counts[bucket].fetch_add(1, Ordering::Relaxed);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturates
        self.sum_us
            .fetch_add((delay_s * 1e6) as u64, Ordering::Relaxed);
    }
}

/// Counters of all machines together.
#[derive(Debug, Default)]
pub struct Metrics {
    /// Readings that came.
    pub readings: AtomicU64,
    /// Messages that could not be read.
    pub malformed: AtomicU64,
    /// Readings of machines or tags that there are not.
    pub unknown: AtomicU64,
    /// Wrong tokens.
    pub unauthorized: AtomicU64,
    /// Frames that slow clients of the page missed.
    pub frames_dropped: AtomicU64,
    /// Events that could not be written to the journal.
    pub journal_errors: AtomicU64,
    /// Events that were told before they were written.
    pub journal_late: AtomicU64,
    /// Records that could not be written to the log.
    pub recorder_errors: AtomicU64,
    /// Times the broker was found again.
    pub mqtt_connects: AtomicU64,
    /// From arrival to verdict.
    pub delays: Delays,
}

/// One more.
pub fn count(counter: &AtomicU64) {
    counter.fetch_add(1, Ordering::Relaxed);
}

/// A text of metrics under construction.
#[derive(Debug, Default)]
pub struct Exposition {
    text: String,
}

impl Exposition {
    /// A counter or gauge with its values by their labels.
    pub fn family<'a>(
        &mut self,
        name: &str,
        kind: &str,
        help: &str,
        values: impl IntoIterator<Item = (&'a [(&'a str, &'a str)], f64)>,
    ) {
        let _ = writeln!(
            self.text,
            "# HELP gtfdi_{name} {help}\n# TYPE gtfdi_{name} {kind}"
        );
        for (labels, value) in values {
            let _ = writeln!(self.text, "gtfdi_{name}{} {value}", braces(labels));
        }
    }

    /// A counter or gauge of one value.
    pub fn single(&mut self, name: &str, kind: &str, help: &str, value: f64) {
        self.family(name, kind, help, [(&[][..], value)]);
    }

    /// The delays.
    pub fn delays(&mut self, delays: &Delays) {
        let name = "arrival_to_verdict_seconds";
        let _ = writeln!(
            self.text,
            "# HELP gtfdi_{name} From the arrival of a sample's last reading to its verdict.\n\
             # TYPE gtfdi_{name} histogram"
        );
        let mut total = 0;
        for (place, counter) in delays.counts.iter().enumerate() {
            total += counter.load(Ordering::Relaxed);
            let end = DELAY_BUCKETS_S
                .get(place)
                .map_or_else(|| "+Inf".to_owned(), ToString::to_string);
            let _ = writeln!(self.text, "gtfdi_{name}_bucket{{le=\"{end}\"}} {total}");
        }
        let sum_s = delays.sum_us.load(Ordering::Relaxed) as f64 * 1e-6;
        let _ = writeln!(
            self.text,
            "gtfdi_{name}_sum {sum_s}\ngtfdi_{name}_count {total}"
        );
    }

    /// The text.
    pub fn finish(self) -> String {
        self.text
    }
}

fn braces(labels: &[(&str, &str)]) -> String {
    if labels.is_empty() {
        return String::new();
    }
    let pairs: Vec<String> = labels
        .iter()
        .map(|(name, value)| format!("{name}=\"{}\"", escape(value)))
        .collect();
    format!("{{{}}}", pairs.join(","))
}

fn escape(value: &str) -> String {
    value
        .replace('\\', "\\\\")
        .replace('"', "\\\"")
        .replace('\n', "\\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_are_counted_below_their_ends() {
        let delays = Delays::default();
        for delay_ns in [100_000, 1_000_000, 1_000_001, 30_000_000, 9_000_000_000, -5] {
            delays.take(delay_ns);
        }
        let mut text = Exposition::default();
        text.delays(&delays);
        let text = text.finish();
        for line in [
            "gtfdi_arrival_to_verdict_seconds_bucket{le=\"0.0005\"} 2",
            "gtfdi_arrival_to_verdict_seconds_bucket{le=\"0.001\"} 3",
            "gtfdi_arrival_to_verdict_seconds_bucket{le=\"0.002\"} 4",
            "gtfdi_arrival_to_verdict_seconds_bucket{le=\"0.05\"} 5",
            "gtfdi_arrival_to_verdict_seconds_bucket{le=\"2\"} 5",
            "gtfdi_arrival_to_verdict_seconds_bucket{le=\"+Inf\"} 6",
            "gtfdi_arrival_to_verdict_seconds_count 6",
        ] {
            assert!(text.lines().any(|own| own == line), "{line}\n{text}");
        }
    }

    #[test]
    fn labels_are_escaped() {
        let mut text = Exposition::default();
        let labels = [("machine", "a\"b\\c\nd")];
        text.family("up", "gauge", "Whether.", [(&labels[..], 1.0)]);
        assert!(
            text.finish()
                .ends_with("gtfdi_up{machine=\"a\\\"b\\\\c\\nd\"} 1\n")
        );
    }
}
