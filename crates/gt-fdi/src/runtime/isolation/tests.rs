//! Sums over every onset against direct ones.

use alloc::vec::Vec;

use super::memory::Memory;
use super::profile::Profile;
use super::suffix::Suffixes;

/// Two signals that repeat nothing.
fn sample(t: usize) -> [f64; 2] {
    let x = t as f64;
    [
        libm::sin(0.7 * x) + 0.1,
        libm::cos(0.31 * x) + libm::sin(0.011 * x),
    ]
}

/// Relative to the sum of moduli: rounding of some thousand terms.
const ROUNDING: f64 = 1e-11;

fn filled(samples: usize) -> (Suffixes, Vec<[f64; 2]>) {
    let mut memory = Memory::new(2, 1000);
    let mut sums = Suffixes::new(&memory, 2);
    let all: Vec<[f64; 2]> = (0..samples).map(sample).collect();
    for own in &all {
        memory.push(own);
    }
    sums.gather(&memory);
    (sums, all)
}

/// The profile's value at each of the last samples.
fn shape(sums: &Suffixes, profile: &Profile, samples: usize) -> Vec<f64> {
    let after = |edge: usize, t: usize| {
        let start = samples as f64 - sums.age(edge);
        (t as f64 + 1.0 - start).max(0.0)
    };
    (0..samples)
        .map(|t| after(profile.onset, t) - profile.full.map_or(0.0, |full| after(full, t)))
        .collect()
}

#[test]
fn profiles_sum_what_direct_sums_do() {
    for samples in [37, 500, 3001] {
        let (sums, all) = filled(samples);
        assert!(sums.len() > 5);
        for onset in 0..sums.len() {
            for full in [None, Some(onset / 2)]
                .into_iter()
                .filter(|full| *full != Some(onset))
            {
                let profile = Profile { onset, full };
                let f = shape(&sums, &profile, samples);
                let other = Profile {
                    onset: sums.len() - 1,
                    full: Some(1),
                };
                let g = shape(&sums, &other, samples);
                for signal in 0..2 {
                    let direct = |weight: &dyn Fn(usize) -> f64| {
                        let terms = all
                            .iter()
                            .enumerate()
                            .map(|(t, own)| weight(t) * own[signal]);
                        let scale: f64 = terms.clone().map(f64::abs).sum();
                        (terms.sum::<f64>(), ROUNDING * (scale + 1.0))
                    };
                    let (expected, tolerance) = direct(&|t| f[t]);
                    assert!((profile.weighted(&sums, signal) - expected).abs() < tolerance);
                    let (expected, tolerance) = direct(&|t| f[t] * f[t]);
                    assert!((profile.energy(&sums, signal) - expected).abs() < 10.0 * tolerance);
                    let (expected, tolerance) = direct(&|t| f[t] * g[t]);
                    let found = profile.cross(&other, &sums, Some(signal));
                    assert!((found - expected).abs() < 100.0 * tolerance);
                }
                let squares: f64 = f.iter().map(|own| own * own).sum();
                assert!((profile.own_energy(&sums) / squares - 1.0).abs() < 1e-9);
                let growth = f.last().copied().unwrap_or(0.0);
                assert!((profile.growth(&sums) - growth).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn memory_is_bounded_and_reaches_back() {
    let mut memory = Memory::new(1, 1000);
    for t in 0..100_000 {
        memory.push(&sample(t)[..1]);
    }
    let (mut blocks, mut age) = (0, 0);
    memory.newest_first(|_, samples, _| {
        blocks += 1;
        age += samples;
    });
    assert!(blocks <= memory.capacity());
    assert!(age >= 1000, "{age}");
    memory.reset();
    let mut left = 0;
    memory.newest_first(|_, _, _| left += 1);
    assert_eq!(left, 0);
}
