//! A machine from readings to alarms: against the bank itself, out of order, and across restarts.

#![allow(clippy::expect_used, clippy::unwrap_used)] // a failed step is a failed test

use gt_log::DetectorFile;
use gt_serve::pipeline::{
    AlarmAction, AlarmEvent, AlarmOptions, HygieneOptions, Machine, MachineOptions,
    MachineSnapshot, MachineState, Quality, Reading,
};
use gtfdi::core::{Dataset, OperatingPoint, Signal, StateSpace};
use gtfdi::fdi::{Bank, ResidualGenerator, ResidualTest, StatisticKind, ThresholdRule};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

const PERIOD_S: f64 = 0.08;
const PERIOD_NS: i64 = 80_000_000;
/// The record begins in 2026.
const START_NS: i64 = 1_700_000_000_000_000_000;

const NOW_MS: i64 = START_NS / 1_000_000;

/// Numbers without visible order in -1 .. 1 (`SplitMix64`).
fn noise(seed: u64, len: usize) -> Vec<f64> {
    let mut state = seed;
    let next = |_| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = state;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        (bits >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    (0..len).map(next).collect()
}

/// A first-order observer of `output` from `u`.
fn generator(output: &str) -> ResidualGenerator {
    let one = |value: f64| DMatrix::from_element(1, 1, value);
    let parts = [one(0.8), one(0.5), one(1.0), one(0.0)];
    let model = StateSpace::new(
        parts,
        PERIOD_S,
        Signal::named(&["u"]),
        Signal::named(&[output]),
    );
    let point = OperatingPoint {
        u: DVector::from_element(1, 0.0),
        y: DVector::from_element(1, 100.0),
    };
    ResidualGenerator::observer(model.unwrap(), point, &[0.3]).unwrap()
}

/// Noise round the operating point, and a bias of 6 on `q` in some stretches.
fn record(seed: u64, len: usize, faulty: bool) -> Dataset {
    let channel = |place: u64| noise(seed * 10 + place, len);
    let (u, p, q) = (channel(0), channel(1), channel(2));
    let bias = |k: usize| {
        if faulty && (k / 150) % 3 == 1 {
            6.0
        } else {
            0.0
        }
    };
    let y = DMatrix::from_fn(2, len, |row, k| {
        100.0 + if row == 0 { p[k] } else { q[k] + bias(k) }
    });
    let u = DMatrix::from_row_slice(1, len, &u);
    let (inputs, outputs) = (Signal::named(&["u"]), Signal::named(&["p", "q"]));
    Dataset::new(inputs, outputs, u, y, PERIOD_S).unwrap()
}

fn bank() -> Bank {
    let healthy = [record(1, 4000, false)];
    let rule = ThresholdRule::Margin {
        factor: 1.2,
        consecutive: 2,
    };
    let of = |output: &str| {
        let generator = generator(output);
        let kind = StatisticKind::Modulus;
        let test = ResidualTest::calibrate(output, &[&generator], &healthy, kind, rule);
        (generator, test.unwrap())
    };
    let (generators, tests) = [of("p"), of("q")].into_iter().unzip();
    Bank::new("bank", generators, tests).unwrap()
}

fn machine(latch: bool) -> Machine {
    let options = MachineOptions {
        hygiene: HygieneOptions::default(),
        alarms: AlarmOptions {
            off_delay_s: 0.0,
            latch,
            ..AlarmOptions::default()
        },
    };
    Machine::new("gt1", &DetectorFile::Bank(bank()), options).unwrap()
}

/// The readings of sample `k`, in the order of the bank's channels.
fn readings(data: &Dataset, k: usize) -> Vec<Reading> {
    let values = data
        .u()
        .column(k)
        .iter()
        .chain(data.y().column(k).iter())
        .copied()
        .collect::<Vec<f64>>();
    let time_ns = START_NS + i64::try_from(k).unwrap() * PERIOD_NS;
    let reading = |(tag, value)| Reading {
        tag,
        time_ns,
        value,
        quality: Quality::Good,
    };
    values.into_iter().enumerate().map(reading).collect()
}

/// Sample and test of each alarm that came up.
fn raised(events: &[AlarmEvent]) -> Vec<(i64, String)> {
    let raised = events
        .iter()
        .filter(|event| event.event == AlarmAction::Raised);
    raised
        .map(|event| {
            let after_ms = event.alarm.raised_ms - START_NS / 1_000_000;
            (after_ms / 80, event.alarm.source.clone())
        })
        .collect()
}

#[test]
fn a_machine_says_what_its_bank_says() {
    let data = record(2, 2000, true);
    let run = bank().run(&data).unwrap();
    #[allow(clippy::cast_possible_truncation)] // samples of a short record
    let expected: Vec<(i64, String)> = run
        .alarms
        .iter()
        .map(|alarm| ((alarm.time_s / PERIOD_S).round() as i64, alarm.tag.clone()))
        .collect();
    assert!(expected.len() >= 4, "{expected:?}");
    let mut machine = machine(false);
    assert_eq!(machine.state(START_NS), MachineState::NoData);
    let mut residuals = Vec::new();
    for k in 0..data.len() {
        for reading in readings(&data, k) {
            machine.offer(&reading, reading.time_ns, |machine, _| {
                residuals.extend(machine.watch().residuals().iter().map(|own| own.to_bits()));
            });
        }
    }
    let all: Vec<u64> = run.residuals.iter().map(|own| own.to_bits()).collect();
    assert_eq!(residuals, all, "the residuals of the bank, bit for bit");
    assert_eq!(raised(&machine.take_events()), expected);
}

/// After two tags have swapped their places in the bank nobody would notice: another detector is
/// refused, and the machine goes on.
#[test]
fn a_detector_of_other_tags_is_refused() {
    let mut machine = machine(true);
    let other = Bank::new(
        "other",
        vec![generator("p")],
        vec![bank().tests()[0].clone()],
    )
    .unwrap();
    let error = machine
        .reload(&DetectorFile::Bank(other), NOW_MS)
        .unwrap_err()
        .to_string();
    assert_eq!(
        error,
        "detector `other`: expected the tags [\"u\", \"p\", \"q\"] every 0.08 s, found [\"u\", \"p\"] \
         every 0.08 s"
    );
    assert_eq!(machine.watch().name(), "bank");
    machine.reload(&DetectorFile::Bank(bank()), NOW_MS).unwrap();
}

#[test]
fn a_snapshot_of_another_detector_or_version_begins_afresh() {
    // Two samples into the first bias, which the observer soon follows in part.
    let data = record(2, 152, true);
    let mut first = machine(true);
    for k in 0..data.len() {
        for reading in readings(&data, k) {
            first.offer(&reading, reading.time_ns, |_, _| {});
        }
    }
    let snapshot = first.snapshot().unwrap();
    let mut text = serde_json::to_value(&snapshot).unwrap();
    text["schema_version"] = 99.into();
    let newer: MachineSnapshot = serde_json::from_value(text).unwrap();
    let open: Vec<_> = first.alarms().open().cloned().collect();
    assert_eq!(open.len(), 1);
    let mut second = machine(true);
    let why = second.resume(open, Some(newer), NOW_MS).unwrap();
    assert_eq!(why, "schema_version of the snapshot: expected 1, found 99");
    let stands: Vec<bool> = second
        .alarms()
        .open()
        .map(|alarm| alarm.unconfirmed)
        .collect();
    assert_eq!(
        stands,
        [true],
        "the alarm stands until it is seen again or not"
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, ..ProptestConfig::default() })]

    /// Readings that come in any order within the reordering window, some twice, give the samples
    /// that they give in order.
    #[test]
    fn prop_order_within_the_window_does_not_matter(seed in any::<u64>()) {
        let data = record(3, 600, true);
        let ordered: Vec<Reading> = (0..data.len()).flat_map(|k| readings(&data, k)).collect();
        // A reading is moved by up to 5 samples: 0.4 s of the 0.5 s.
        let moves = noise(seed, ordered.len());
        let mut shuffled: Vec<(f64, Reading)> = ordered
            .iter()
            .zip(&moves)
            .map(|(reading, own)| (reading.time_ns as f64 + 2.5 * own * PERIOD_NS as f64, *reading))
            .collect();
        // The first reading begins the grid.
        shuffled[0].0 = 0.0;
        shuffled.sort_by(|a, b| a.0.total_cmp(&b.0));
        let events = |readings: &mut dyn Iterator<Item = Reading>| {
            let mut machine = machine(false);
            for reading in readings {
                machine.offer(&reading, START_NS + 600 * PERIOD_NS, |_, _| {});
            }
            machine.drain(|_, _| {});
            machine.take_events()
        };
        let twice = shuffled.iter().flat_map(|(at, reading)| {
            let count = if at.rem_euclid(7.0) < 1.0 { 2 } else { 1 };
            std::iter::repeat_n(*reading, count)
        });
        prop_assert_eq!(events(&mut twice.into_iter()), events(&mut ordered.iter().copied()));
    }

    /// Wherever the program ends and begins again, from a snapshot of that sample: the same events,
    /// with the same numbers.
    #[test]
    fn prop_a_restart_changes_nothing(cut in 1..599_usize, latch in any::<bool>()) {
        let data = record(4, 600, true);
        let feed = |machine: &mut Machine, samples: std::ops::Range<usize>| {
            for k in samples {
                for reading in readings(&data, k) {
                    machine.offer(&reading, reading.time_ns, |_, _| {});
                }
            }
            machine.take_events()
        };
        let mut whole = machine(latch);
        let expected = feed(&mut whole, 0..600);
        let mut first = machine(latch);
        let mut found = feed(&mut first, 0..cut);
        let text = serde_json::to_string(&first.snapshot().unwrap()).unwrap();
        let open: Vec<_> = first.alarms().open().cloned().collect();
        let given = found.iter().map(|event| event.alarm.id).max().unwrap_or(0);
        let mut second = machine(latch);
        second.set_ids(given + 1, 1);
        prop_assert_eq!(second.resume(open, Some(serde_json::from_str(&text).unwrap()), NOW_MS), None);
        found.extend(feed(&mut second, cut..600));
        prop_assert_eq!(found, expected);
    }

    /// As after a kill: the snapshot is older than the last events, and the source sends again what
    /// came since. No alarm is there twice.
    #[test]
    fn prop_an_older_snapshot_doubles_no_alarm(cut in 50..500_usize, since in 1..50_usize) {
        let data = record(4, 600, true);
        let mut first = machine(true);
        let mut snapshot = None;
        let mut events = Vec::new();
        for k in 0..cut {
            if k + since == cut {
                snapshot = first.snapshot();
            }
            for reading in readings(&data, k) {
                first.offer(&reading, reading.time_ns, |_, _| {});
            }
            events.extend(first.take_events());
        }
        let open: Vec<_> = first.alarms().open().cloned().collect();
        let given = events.iter().map(|event| event.alarm.id).max().unwrap_or(0);
        let mut second = machine(true);
        second.set_ids(given + 1, 1);
        second.resume(open, snapshot, NOW_MS);
        for k in cut - since..600 {
            for reading in readings(&data, k) {
                second.offer(&reading, reading.time_ns, |_, _| {});
            }
            events.extend(second.take_events());
            let mut active: Vec<usize> = second
                .alarms()
                .open()
                .filter(|alarm| alarm.is_active())
                .map(|alarm| alarm.key)
                .collect();
            active.sort_unstable();
            let count = active.len();
            active.dedup();
            prop_assert_eq!(active.len(), count, "two alarms of one test");
        }
        // Nobody acknowledges, so each test has one alarm that comes and goes.
        let numbers: std::collections::BTreeSet<u64> = events.iter().map(|event| event.alarm.id).collect();
        prop_assert!(numbers.len() <= 2, "{numbers:?}");
    }
}
