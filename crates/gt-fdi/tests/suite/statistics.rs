//! Streaming statistics against their definitions on whole records.

use gt_fdi::runtime::{
    Change, Cusum, Decision, Glr, MAX_WINDOW, MovingAverage, Sides, Sprt, SprtDecision, Statistic,
    Waveform, WindowedChiSquare,
};
use proptest::prelude::*;

use crate::fixtures::noise;

pub const SIDES: [Sides; 3] = [Sides::Upper, Sides::Lower, Sides::Both];

/// What happens to a statistic.
#[derive(Debug, Clone, Copy)]
pub enum Event {
    Sample(f64),
    Reset,
}

/// Samples of every kind, rarely a reset.
pub fn events(len: usize) -> impl Strategy<Value = Vec<Event>> {
    let event = prop_oneof![
        60 => (-4.0..4.0_f64).prop_map(Event::Sample),
        20 => (0.0..3.0_f64).prop_map(Event::Sample),
        4 => (-1e3..1e3_f64).prop_map(Event::Sample),
        4 => Just(Event::Sample(f64::NAN)),
        2 => Just(Event::Sample(f64::INFINITY)),
        1 => Just(Event::Reset),
    ];
    prop::collection::vec(event, 1..len)
}

/// Runs the statistic and has each value compared with that on the samples since the last
/// reset that were not missing, by `compare`.
pub fn check_against_batch<S: Statistic>(
    statistic: &mut S,
    events: &[Event],
    mut compare: impl FnMut(&S, Decision, &[f64]),
) {
    let mut since_reset = Vec::new();
    let mut before = statistic.value();
    for event in events {
        match *event {
            Event::Reset => {
                statistic.reset();
                since_reset.clear();
                before = statistic.value();
                assert_eq!(before, 0.0);
            }
            Event::Sample(r) => {
                let decision = statistic.step(r);
                assert_eq!(decision.missing, !r.is_finite());
                assert_eq!(decision.alarm, decision.value > statistic.threshold());
                assert_eq!(decision.value, statistic.value());
                if decision.missing {
                    assert_eq!(decision.value, before);
                } else {
                    since_reset.push(r);
                }
                before = decision.value;
                compare(statistic, decision, &since_reset);
            }
        }
    }
}

pub fn folded(sides: Sides, value: f64) -> f64 {
    match sides {
        Sides::Upper => value,
        Sides::Lower => -value,
        Sides::Both => value.abs(),
    }
}

/// Rounding of sums in another order: 1e-12 of the sum of the moduli is thousands of roundings.
pub fn assert_near(found: f64, expected: f64, moduli: f64) {
    let tolerance = 1e-12 * (1.0 + moduli);
    assert!(
        (found - expected).abs() <= tolerance,
        "expected {expected}, found {found}, tolerance {tolerance}"
    );
}

/// The last `len` of `samples`.
pub fn last(samples: &[f64], len: usize) -> &[f64] {
    &samples[samples.len().saturating_sub(len)..]
}

/// `max_j sum_{i >= j} (r_i - k)`, at least 0: the CUSUM without its recursion, with the number of
/// samples in the best sum.
fn batch_cusum(samples: &[f64], sign: f64, allowance: f64) -> (f64, u64) {
    let (mut best, mut sum, mut age) = (0.0, 0.0, 0);
    for (index, r) in samples.iter().rev().enumerate() {
        sum += sign * r - allowance;
        if sum > best {
            (best, age) = (sum, index as u64 + 1);
        }
    }
    (best, age)
}

/// The ratio of a fault with `size >= 0` on one side over the last `m` samples, maximised on a
/// fixed grid of windows, written with the squared errors themselves:
/// `(sum r^2 - sum (r - mean)^2) / 2`.
fn batch_glr(
    samples: &[f64],
    waveform: Waveform,
    (smallest, largest): (f64, f64),
    windows: &[usize],
    sides: Sides,
) -> (f64, Option<Change>) {
    let mut best = (0.0, None);
    for &m in windows.iter().filter(|&&m| m <= samples.len()) {
        let window = last(samples, m);
        let mean = |j: usize| match waveform {
            Waveform::Step => 1.0,
            Waveform::Ramp => (j + 1) as f64,
        };
        let energy: f64 = (0..m).map(|j| mean(j) * mean(j)).sum();
        let fit: f64 = window.iter().enumerate().map(|(j, r)| mean(j) * r).sum();
        let signs: &[f64] = match sides {
            Sides::Upper => &[1.0],
            Sides::Lower => &[-1.0],
            Sides::Both => &[1.0, -1.0],
        };
        for sign in signs {
            let size = (sign * fit / energy).max(smallest).min(largest) * sign;
            let ratio: f64 = window
                .iter()
                .enumerate()
                .map(|(j, r)| 0.5 * (r * r - (r - size * mean(j)).powi(2)))
                .sum();
            if ratio > best.0 {
                best = (ratio, Some(Change { age: m, size }));
            }
        }
    }
    best
}

proptest! {
    #[test]
    fn prop_cusum_is_its_batch_definition(
        events in events(300), allowance in 0.0..2.0_f64, side in 0..3_usize,
    ) {
        let sides = SIDES[side];
        let mut statistic = Cusum::new(allowance, 5.0, sides).unwrap();
        check_against_batch(&mut statistic, &events, |cusum, decision, samples| {
            let moduli: f64 = samples.iter().map(|r| r.abs() + allowance).sum();
            let upper = batch_cusum(samples, 1.0, allowance);
            let lower = batch_cusum(samples, -1.0, allowance);
            let upper = if sides == Sides::Lower { (0.0, 0) } else { upper };
            let lower = if sides == Sides::Upper { (0.0, 0) } else { lower };
            assert_near(cusum.upper(), upper.0, moduli);
            assert_near(cusum.lower(), lower.0, moduli);
            assert_eq!(decision.value, cusum.upper().max(cusum.lower()));
            // Where both are as good to rounding, either age will do.
            if (upper.0 - lower.0).abs() > 1e-9 {
                assert_eq!(cusum.onset_age(), if upper.0 > lower.0 { upper.1 } else { lower.1 });
            }
        });
    }

    #[test]
    fn prop_moving_average_is_its_batch_definition(
        events in events(300), window in 1..40_usize, side in 0..3_usize,
    ) {
        let mut statistic = MovingAverage::new(window, 0.5, SIDES[side]).unwrap();
        check_against_batch(&mut statistic, &events, |_, decision, samples| {
            let window_samples = last(samples, window);
            let mean = window_samples.iter().sum::<f64>() / window as f64;
            let moduli = window_samples.iter().map(|r| r.abs()).sum();
            assert_near(decision.value, folded(SIDES[side], mean), moduli);
        });
    }

    #[test]
    fn prop_chi_square_is_its_batch_definition(events in events(300), window in 1..40_usize) {
        let mut statistic = WindowedChiSquare::new(window, 50.0).unwrap();
        check_against_batch(&mut statistic, &events, |_, decision, samples| {
            let expected = last(samples, window).iter().map(|r| r * r).sum();
            assert_near(decision.value, expected, expected);
        });
    }

    #[test]
    fn prop_glr_is_its_batch_definition(
        events in events(250), longest in 1..70_usize, side in 0..3_usize, ramp: bool,
        smallest in 1e-3..1.0_f64, ratio in 1.0..100.0_f64,
    ) {
        let waveform = if ramp { Waveform::Ramp } else { Waveform::Step };
        let sizes = (smallest, smallest * ratio);
        let mut statistic = Glr::new(waveform, sizes, longest, 10.0, SIDES[side]).unwrap();
        let windows: Vec<usize> = statistic.windows().collect();
        check_against_batch(&mut statistic, &events, |glr, decision, samples| {
            let (expected, _) = batch_glr(samples, waveform, sizes, &windows, SIDES[side]);
            // Sums may hold what was kept before the window: twice the longest of it, each sample
            // with a weight of up to its position, times the size; and squared errors.
            let kept = last(samples, 2 * longest);
            let largest = kept.iter().fold(0.0_f64, |a, r| a.max(r.abs())) + 1.0;
            let weight = if ramp { 2.0 * longest as f64 } else { 1.0 };
            let scale = largest + sizes.1 * weight;
            let moduli = 2.0 * longest as f64 * scale * scale;
            assert_near(decision.value, expected, moduli);
            assert_eq!(decision.value > 0.0, glr.change().is_some());
            if let Some(found) = glr.change() {
                // No other fault is likelier, and its size is the likeliest at its age.
                let (value, change) =
                    batch_glr(samples, waveform, sizes, &[found.age], SIDES[side]);
                assert_near(value, expected, moduli);
                if let Some(change) = change {
                    assert_eq!(found.age, change.age);
                    assert_near(found.size, change.size, moduli);
                }
            }
        });
    }

    #[test]
    fn prop_sprt_is_its_batch_definition(events in events(100), shift in 0.1..2.0_f64, down: bool) {
        let shift = if down { -shift } else { shift };
        let mut statistic = Sprt::new(shift, -4.6, 4.6).unwrap();
        check_against_batch(&mut statistic, &events, |sprt, decision, samples| {
            // Squared errors of the two means, until a bound is reached.
            let (mut ratio, mut moduli) = (0.0, 0.0);
            for r in samples {
                if ratio > -4.6 && ratio <= 4.6 {
                    ratio += 0.5 * (r * r - (r - shift) * (r - shift));
                    moduli += r * r + shift * shift;
                }
            }
            assert_near(decision.value, ratio, moduli);
            let expected = match ratio {
                _ if ratio > 4.6 => SprtDecision::Faulty,
                _ if ratio <= -4.6 => SprtDecision::Healthy,
                _ => SprtDecision::Undecided,
            };
            assert_eq!(sprt.decision(), expected);
        });
    }
}

/// A record of noise and large values that is many times longer than the longest window, so that
/// the sums are made anew again and again.
#[test]
fn long_records_do_not_drift() {
    let sizes = (1e-4, 1e-1);
    let mut glr = Glr::new(Waveform::Ramp, sizes, 64, 10.0, Sides::Both).unwrap();
    let mut chi_square = WindowedChiSquare::new(64, 100.0).unwrap();
    let windows: Vec<usize> = glr.windows().collect();
    let mut samples = noise(11, 20_000);
    for r in samples.iter_mut().step_by(1000) {
        *r = 1e12;
    }
    for now in 1..=samples.len() {
        let found = glr.step(samples[now - 1]).value;
        let energy = chi_square.step(samples[now - 1]).value;
        // 500 samples after the last large one: no trace of it is left in any sum.
        if now % 1000 > 500 {
            let past = &samples[..now];
            let (expected, _) = batch_glr(past, Waveform::Ramp, sizes, &windows, Sides::Both);
            // Rounding of 128 terms up to 128 x 4 standard deviations.
            assert!((found - expected).abs() < 1e-9, "{now}: {found} {expected}");
            let expected: f64 = last(past, 64).iter().map(|r| r * r).sum();
            assert!(
                (energy - expected).abs() < 1e-10,
                "{now}: {energy} {expected}"
            );
        }
    }
}

/// About 24 windows up to 4096, each about the root of two times the one before.
#[test]
fn windows_grow_geometrically() {
    let windows = |longest| -> Vec<usize> {
        let glr = Glr::new(Waveform::Ramp, (1e-4, 1e-1), longest, 11.81, Sides::Upper).unwrap();
        glr.windows().collect()
    };
    let all = windows(Glr::DEFAULT_LONGEST);
    assert_eq!(all.len(), 24);
    assert_eq!(all[..8], [1, 2, 3, 4, 6, 8, 11, 16]);
    assert_eq!(all[20..], [1448, 2048, 2896, 4096]);
    let growth = |pair: &[usize]| pair[1] as f64 / pair[0] as f64;
    assert!(
        all[4..]
            .windows(2)
            .map(growth)
            .all(|g| (1.33..1.46).contains(&g))
    );
    assert_eq!(windows(1), [1]);
    assert_eq!(windows(2), [1, 2]);
    assert_eq!(windows(7), [1, 2, 3, 4, 6, 7]);
    assert_eq!(windows(MAX_WINDOW).len(), 32);
}

/// A ramp without noise: onset and slope, as finely as the windows lie.
#[test]
fn a_clean_ramp_gives_its_onset_and_slope() {
    for sign in [1.0, -1.0] {
        let mut glr = Glr::new(Waveform::Ramp, (1e-4, 1e-1), 4096, 11.81, Sides::Both).unwrap();
        for _ in 0..5000 {
            assert_eq!(glr.step(0.0).value, 0.0);
        }
        for k in 1..=512 {
            glr.step(sign * 1e-2 * f64::from(k));
        }
        let change = glr.change().unwrap();
        assert_eq!(change.age, 512);
        assert!((change.size - sign * 1e-2).abs() < 1e-12, "{}", change.size);
        // The logarithm of the likelihood ratio of a fault that fits exactly: s^2 E / 2.
        let energy: f64 = (1..=512).map(|k| f64::from(k * k)).sum();
        assert!((glr.value() / (0.5e-4 * energy) - 1.0).abs() < 1e-12);
    }
}
