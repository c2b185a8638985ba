//! Throughput of statistics on one residual.
//!
//! `cargo bench -p gtfdi --bench detectors`

mod timing;

use std::error::Error;
use std::hint::black_box;

use gtfdi::fdi::{Cusum, CusumFleet, Glr, Sides, Statistic, Waveform};

/// Residuals of each contender.
const SAMPLES: usize = 200_000;
/// Streams among which they are dealt out for many sums at once.
const STREAMS: usize = 200;
/// Residuals that these take at once.
const PART: usize = 100 * STREAMS;
/// Windows up to this: 24 of them.
const LONGEST: usize = 4096;

fn main() -> Result<(), Box<dyn Error>> {
    let mut state = 7_u64;
    let mut uniform = || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    // Sums of uniform numbers, of variance 1: what they are hardly matters here.
    let residuals: Vec<f64> = (0..SAMPLES)
        .map(|_| (0..12).map(|_| uniform()).sum())
        .collect();
    let mut cusum = Cusum::new(0.5, 14.0, Sides::Both)?;
    let glr = |waveform| Glr::new(waveform, (1e-3, 1e-2), LONGEST, 14.0, Sides::Both);
    let (mut ramp, mut step) = (glr(Waveform::Ramp)?, glr(Waveform::Step)?);
    let windows = ramp.windows().count();
    let mut fleet = CusumFleet::new(&cusum, STREAMS);
    let mut values = vec![0.0; PART];

    let by_hand = cusum_by_hand(&residuals, 0.5, 14.0);
    let found = alarms(&mut cusum, &residuals);
    if found != by_hand {
        return Err(format!("CUSUM: {found} alarms, by hand {by_hand}").into());
    }
    println!(
        "{SAMPLES} residuals, the CUSUM has the alarms of the loop; likelihood ratios over {windows} windows"
    );
    let times = timing::race(vec![
        (
            "two-sided CUSUM, a loop on two numbers",
            Box::new(|| {
                black_box(cusum_by_hand(black_box(&residuals), black_box(0.5), 14.0));
            }),
        ),
        (
            "gtfdi Cusum::step, two-sided",
            Box::new(|| {
                black_box(alarms(&mut cusum, black_box(&residuals)));
            }),
        ),
        (
            "gtfdi CusumFleet::step, two-sided, 200 streams",
            Box::new(|| {
                for part in residuals.chunks(PART) {
                    let _ = fleet.step(black_box(part), black_box(&mut values));
                }
            }),
        ),
        (
            "gtfdi Glr::step, ramp",
            Box::new(|| {
                black_box(alarms(&mut ramp, black_box(&residuals)));
            }),
        ),
        (
            "gtfdi Glr::step, step",
            Box::new(|| {
                black_box(alarms(&mut step, black_box(&residuals)));
            }),
        ),
    ]);
    times.print(
        "M residuals/s",
        |seconds| 1e-6 * SAMPLES as f64 / seconds,
        &[0],
        ("", &[]),
    );

    Ok(())
}

/// Samples of a record at which the alarm is up.
fn alarms(statistic: &mut impl Statistic, residuals: &[f64]) -> usize {
    statistic.reset();
    let up = |&r: &f64| usize::from(statistic.step(r).alarm);
    residuals.iter().map(up).sum()
}

/// The two sums and nothing else.
fn cusum_by_hand(residuals: &[f64], allowance: f64, threshold: f64) -> usize {
    let (mut upper, mut lower, mut count) = (0.0_f64, 0.0_f64, 0);
    for r in residuals {
        upper = (upper + (r - allowance)).max(0.0);
        lower = (lower + (-r - allowance)).max(0.0);
        count += usize::from(upper.max(lower) > threshold);
    }
    count
}
