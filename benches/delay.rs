//! Mean delays of detections of ramps in white residuals, with a mean time between false alarms of
//! 24 h, over the bound that no detector beats.
//!
//! `cargo bench -p gtfdi --bench delay`
//!
//! Thresholds of likelihood ratios are those at which the peaks of a long white record, an
//! exponential tail fitted to the highest, have that mean time; those of the CUSUM come from its
//! integral equation. Everything follows from the seeds.

use std::error::Error;
use std::thread;

use gtfdi::fdi::{Cusum, CusumRunLength, Glr, Sides, Statistic, Waveform, mean_delay_bound};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// 24 h at 0.08 s.
const RUN_LENGTH: f64 = 1.08e6;
/// Slopes of the ramps in standard deviations a sample.
const SLOPES: [f64; 3] = [1e-4, 1e-3, 1e-2];
/// The longest window.
const LONGEST: usize = 4096;
/// Healthy samples of each of two threads, and ramps of each slope.
const HEALTHY: usize = 40_000_000;
const RAMPS: usize = 2000;
/// Healthy samples before each ramp.
const BEFORE: usize = 500;
const SEED: u64 = 20_261_126;
/// Peaks whose heights are fitted.
const PEAKS: usize = 1000;

fn main() -> Result<(), Box<dyn Error>> {
    // `cargo test` runs it too, without the argument, to see that it does.
    let (healthy, ramps) = if std::env::args().any(|argument| argument == "--bench") {
        (HEALTHY, RAMPS)
    } else {
        (200_000, 20)
    };
    println!(
        "Mean delay over the bound, two-sided, ARL0 = {RUN_LENGTH:.3e} samples; {ramps} ramps, \
         seed {SEED}; thresholds from {:.0e} white samples",
        2.0 * healthy as f64
    );
    println!(
        "detector                       threshold (se)  slope    delay (se)     bound   ratio (se)"
    );
    for (name, (smallest, largest), slopes) in [
        ("ramp GLR, 3e-5..3e-4", (3.16e-5, 3.16e-4), &SLOPES[..1]),
        ("ramp GLR, 3e-4..3e-3", (3.16e-4, 3.16e-3), &SLOPES[1..2]),
        ("ramp GLR, 3e-3..3e-2", (3.16e-3, 3.16e-2), &SLOPES[2..]),
        ("ramp GLR, 3e-5..3e-2", (3.16e-5, 3.16e-2), &SLOPES[..]),
    ] {
        let make = |threshold| {
            Glr::new(
                Waveform::Ramp,
                (smallest, largest),
                LONGEST,
                threshold,
                Sides::Both,
            )
        };
        let (threshold, error) = threshold(&make(1.0)?, healthy)?;
        report(name, &make(threshold)?, error, slopes, ramps)?;
    }
    for allowance in [0.25, 0.5] {
        let threshold = CusumRunLength::threshold_for(allowance, Sides::Both, RUN_LENGTH)?;
        let cusum = Cusum::new(allowance, threshold, Sides::Both)?;
        report(
            &format!("CUSUM, allowance {allowance}"),
            &cusum,
            0.0,
            &SLOPES,
            ramps,
        )?;
    }
    Ok(())
}

/// The rows of one detector.
fn report<S: Statistic + Clone + Sync + Send>(
    name: &str,
    detector: &S,
    error: f64,
    slopes: &[f64],
    ramps: usize,
) -> Result<(), Box<dyn Error>> {
    for &slope in slopes {
        let delays = on_two_threads(|half| {
            let mut statistic = detector.clone();
            let runs = (0..ramps / 2).map(|run| {
                let run = (2 * run + half) as u64;
                delay(&mut statistic, slope, SEED.wrapping_add(run))
            });
            runs.collect::<Vec<f64>>()
        });
        let count = delays.len() as f64;
        let mean = delays.iter().sum::<f64>() / count;
        let squares = delays
            .iter()
            .map(|delay| (delay - mean).powi(2))
            .sum::<f64>();
        let deviation = (squares / (count - 1.0) / count).sqrt();
        // Either sign may alarm falsely.
        let bound = mean_delay_bound(Waveform::Ramp, slope, 2.0 * RUN_LENGTH)?;
        println!(
            "{name:<26}{:>10.3} ({error:.3})  {slope:.0e}{mean:>9.1} ({deviation:.1}){bound:>9.1}\
             {:>8.3} ({:.3})",
            detector.threshold(),
            mean / bound,
            deviation / bound
        );
    }
    Ok(())
}

/// Samples from the first faulty one to the alarm, of a ramp after healthy running without one.
fn delay<S: Statistic>(statistic: &mut S, slope: f64, seed: u64) -> f64 {
    let mut noise = Normal::new(seed);
    loop {
        statistic.reset();
        if (0..BEFORE).any(|_| statistic.step(noise.next()).alarm) {
            continue;
        }
        let mut samples = 0.0;
        loop {
            samples += 1.0;
            if statistic.step(noise.next() + slope * samples).alarm {
                return samples;
            }
        }
    }
}

/// The threshold with the run length, and its standard error.
fn threshold(glr: &Glr, healthy: usize) -> Result<(f64, f64), Box<dyn Error>> {
    // Values below the level are no peaks; a peak ends when the value has been low for as long as a
    // window remembers.
    let release = LONGEST / 4;
    let mut peaks = on_two_threads(|half| {
        let mut statistic = glr.clone();
        let mut noise = Normal::new(SEED ^ ((half as u64 + 1) << 32));
        let (mut peaks, mut peak, mut since) = (Vec::new(), 0.0_f64, 0);
        for _ in 0..healthy {
            let value = statistic.step(noise.next()).value;
            if value > LOW {
                if since >= release && peak > LOW {
                    peaks.push(peak);
                    peak = 0.0;
                }
                peak = peak.max(value);
                since = 0;
            } else {
                since += 1;
            }
        }
        peaks
    });
    peaks.sort_by(|left, right| right.total_cmp(left));
    let count = PEAKS.min(peaks.len() / 2);
    let level = *peaks.get(count).ok_or("too few peaks")?;
    let heights: f64 = peaks[..count].iter().map(|peak| peak - level).sum();
    let height = heights / count as f64;
    let ratio = (RUN_LENGTH * count as f64 / (2 * healthy) as f64).ln();
    // Errors of the number of peaks and of their mean height.
    let error = height * ((1.0 + ratio * ratio) / count as f64).sqrt();
    Ok((level + height * ratio, error))
}

/// A value above which a likelihood ratio may be at a peak.
const LOW: f64 = 4.5;

/// Both halves of some work, one after the other in the result.
fn on_two_threads<T: Send>(work: impl Fn(usize) -> Vec<T> + Sync) -> Vec<T> {
    thread::scope(|scope| {
        let other = scope.spawn(|| work(1));
        let mut all = work(0);
        all.extend(other.join().unwrap_or_default());
        all
    })
}

/// Standard normal numbers.
struct Normal(ChaCha8Rng);

impl Normal {
    fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn next(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }
}
