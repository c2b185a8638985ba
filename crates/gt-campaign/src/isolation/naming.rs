//! Whether the fault is called by its name, since when and how large it is said to be.

use gtfdi::fdi::{Finding, IsolationRun};
use gtfdi::plant::{FaultCase, SAMPLE_TIME_S};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha12Rng;
use serde::Serialize;

use super::preparation::Prepared;
use super::recipe::ramp;
use super::verdict::{FaultVerdict, Found, SIZE_TOLERANCE};
use crate::campaign::Proportion;
use crate::error::{CampaignError, During as _};

/// First run index.
const FIRST_INDEX: u64 = 20_000;
/// Onsets in seconds.
const ONSETS_S: [f64; 2] = [120.0, 180.0];
/// Seconds in which a fault grows to its size.
const RISE_S: f64 = 60.0;
/// Seconds after the latest onset at which runs end: the fault has had its size for a minute.
const AFTER_S: f64 = 120.0;

/// Seeded runs with a random case, sign, onset and size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NamingStudy {
    /// Limits of the four cases at 60 s, in their units.
    pub limits: [f64; 4],
    /// Multiples of the limits: sizes are even between them.
    pub multiples: [f64; 2],
    /// Runs.
    pub runs: u64,
}

/// One run of a study.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamingRow {
    /// Number of the case, from 1.
    pub case: usize,
    /// Size with its sign, in the case's unit.
    pub size: f64,
    /// Onset in seconds.
    pub onset_s: f64,
    /// First alarm after the onset, in seconds.
    pub alarm_s: Option<f64>,
    /// An alarm before the onset.
    pub false_alarm: bool,
    /// The name within five seconds of the alarm: number of a case, 0 for none of them or two at
    /// once.
    pub named: Option<usize>,
    /// Whether another name than that of the case was ever given after the onset.
    pub ever_wrong: bool,
    /// The size found at the end of the run, for the true case.
    pub magnitude: Option<f64>,
    /// Its 95 % interval.
    pub magnitude_interval: Option<[f64; 2]>,
    /// 95 % interval of the onset found at the end, for the true case, in seconds.
    pub onset_interval_s: Option<[f64; 2]>,
}

/// What a study found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamingSummary {
    /// Runs.
    pub runs: usize,
    /// Share of the runs with an alarm after the onset, percent.
    pub detected_percent: f64,
    /// Share of the runs named within 5 s of the alarm whose name is right, percent.
    pub accuracy_percent: f64,
    /// Share of the detected runs that were ever given a wrong name, percent.
    pub wrong_fault_alarm_percent: f64,
    /// Share of the detected runs without a name 5 s after the alarm, percent.
    pub undecided_percent: f64,
    /// Share of the detected runs whose size at the end is within 15 %, percent.
    pub magnitude_within_15_percent: f64,
    /// Share of the detected runs whose onset lies in its 95 % interval, percent.
    pub onset_in_interval_percent: f64,
    /// Share of the detected runs whose size lies in its 95 % interval at the end, percent.
    pub magnitude_in_interval_percent: f64,
    /// Rows: true cases; columns: named as each case, as another or several, undecided, undetected.
    pub confusion: Vec<Vec<usize>>,
    /// 95 % intervals (Wilson) of the shares above, in their order, percent.
    pub intervals_percent: Vec<[f64; 2]>,
    /// Runs with a false alarm before the onset.
    pub false_alarms: usize,
}

impl NamingStudy {
    /// Carries out the runs.
    ///
    /// # Errors
    /// [`CampaignError`] when a run leaves the plant's validity.
    pub fn rows(&self, prepared: &Prepared) -> Result<Vec<NamingRow>, CampaignError> {
        let drawn: Vec<(usize, f64, f64)> =
            (0..self.runs).map(|run| self.draw(prepared, run)).collect();
        let jobs: Vec<_> = drawn
            .iter()
            .zip(FIRST_INDEX..)
            .map(|(&(case, size, onset_s), index)| {
                (
                    index,
                    vec![ramp(FaultCase::ALL[case], onset_s, RISE_S, size)],
                )
            })
            .collect();
        let duration_s = ONSETS_S[1] + AFTER_S;
        prepared.setting.map(&jobs, duration_s, |index, record| {
            let (case, size, onset_s) = drawn[index];
            let run = prepared.isolator.run(&record).during("isolation")?;
            Ok(judge(&run, case, size, onset_s))
        })
    }

    /// Case, size and onset of a run, from its own stream.
    fn draw(&self, prepared: &Prepared, run: u64) -> (usize, f64, f64) {
        let mut random = ChaCha12Rng::seed_from_u64(prepared.setting.seed);
        random.set_stream(FIRST_INDEX + run);
        let case = random.random_range(0..FaultCase::ALL.len());
        let multiple = random.random_range(self.multiples[0]..=self.multiples[1]);
        let has_sign = FaultCase::ALL[case] == FaultCase::ThermocoupleDrift;
        let negative = random.random_bool(0.5) && has_sign;
        let onset = random.random_range(ONSETS_S[0]..ONSETS_S[1]);
        let onset_s = (onset / SAMPLE_TIME_S).round() * SAMPLE_TIME_S;
        let size = self.limits[case] * multiple;
        (case, if negative { -size } else { size }, onset_s)
    }
}

fn judge(run: &IsolationRun, case: usize, size: f64, onset_s: f64) -> NamingRow {
    let verdict = FaultVerdict::of(run, Some(case), onset_s, SAMPLE_TIME_S);
    let number = |finding| match finding {
        Finding::Named(place) => place + 1,
        _ => 0,
    };
    let interval = |found: Found| [found.low, found.high];
    NamingRow {
        case: case + 1,
        size,
        onset_s,
        alarm_s: verdict.alarm.map(|(time_s, _)| time_s),
        false_alarm: verdict.false_alarms > 0,
        named: verdict.named.map(|(finding, _)| number(finding)),
        ever_wrong: verdict.ever_wrong,
        magnitude: verdict.size.map(|found| found.value),
        magnitude_interval: verdict.size.map(interval),
        onset_interval_s: verdict.onset_s.map(interval),
    }
}

impl NamingSummary {
    /// Counts rows.
    pub fn of(rows: &[NamingRow]) -> Self {
        let count =
            |holds: &dyn Fn(&NamingRow) -> bool| rows.iter().filter(|row| holds(row)).count();
        let detected = |row: &NamingRow| row.alarm_s.is_some();
        let found = count(&detected);
        let named = count(&|row| row.named.is_some());
        let shares = [
            (found, rows.len()),
            (count(&|row| row.named == Some(row.case)), named),
            (count(&|row| detected(row) && row.ever_wrong), found),
            (count(&|row| detected(row) && row.named.is_none()), found),
            (
                count(&|row| {
                    let right =
                        |found: f64| (found - row.size).abs() <= SIZE_TOLERANCE * row.size.abs();
                    row.magnitude.is_some_and(right)
                }),
                found,
            ),
            (
                count(&|row| {
                    let inside = |[low, high]: [f64; 2]| low <= row.onset_s && row.onset_s <= high;
                    row.onset_interval_s.is_some_and(inside)
                }),
                found,
            ),
            (
                count(&|row| {
                    let inside = |[low, high]: [f64; 2]| low <= row.size && row.size <= high;
                    row.magnitude_interval.is_some_and(inside)
                }),
                found,
            ),
        ];
        let percent = |(part, whole): (usize, usize)| 100.0 * part as f64 / whole.max(1) as f64;
        let mut confusion = vec![vec![0; 7]; 4];
        for row in rows {
            let column = match (row.alarm_s, row.named) {
                (None, _) => 6,
                (_, None) => 5,
                (_, Some(0)) => 4,
                (_, Some(name)) => name - 1,
            };
            confusion[row.case - 1][column] += 1;
        }
        Self {
            runs: rows.len(),
            detected_percent: percent(shares[0]),
            accuracy_percent: percent(shares[1]),
            wrong_fault_alarm_percent: percent(shares[2]),
            undecided_percent: percent(shares[3]),
            magnitude_within_15_percent: percent(shares[4]),
            onset_in_interval_percent: percent(shares[5]),
            magnitude_in_interval_percent: percent(shares[6]),
            confusion,
            intervals_percent: shares.iter().map(interval_percent).collect(),
            false_alarms: count(&|row| row.false_alarm),
        }
    }
}

/// The 95 % interval of a share, in percent.
fn interval_percent(&(part, whole): &(usize, usize)) -> [f64; 2] {
    let own = Proportion::new(part as u64, whole as u64);
    [100.0 * own.low, 100.0 * own.high]
}
