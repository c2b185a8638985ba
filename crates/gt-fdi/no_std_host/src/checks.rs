//! Every statistic, with values that are known.

use alloc::boxed::Box;
use alloc::vec::Vec;
use core::hint::black_box;

use gt_fdi::runtime::{
    AdaptiveThreshold, Cusum, Detector, ExceedanceRun, Glr, GrowingChiSquare, GrowingVariance,
    Growth, Modulus, MovingAverage, Persistence, RunSum, ShiryaevRoberts, Sides, Sprt, Statistic,
    StatisticError, Waveform, Whiteness, WindowedChiSquare, WindowedVariance,
};

use crate::bump;

/// A statistic with its value after the residuals 1, -1, 1, -1, ..., 2, 2, 2, 2: eight and four.
type Case = (Box<dyn Statistic>, f64);

/// Values by hand, or by decimal arithmetic where a root or a logarithm is in them: to rounding.
const TOLERANCE: f64 = 1e-12;

/// 0 when all is as it should be.
pub fn run() -> i32 {
    let Ok(mut cases) = cases() else {
        return 1;
    };
    let Ok(mut adaptive) = AdaptiveThreshold::new(1.0, &[0.5], 10.0) else {
        return 2;
    };
    let mut row = ExceedanceRun::default();
    let before = bump::used();
    if before == 0 {
        return 3;
    }
    for round in 0..1000_u32 {
        for (statistic, _) in &mut cases {
            statistic.reset();
        }
        for sample in 0..12_u32 {
            let r = match sample {
                8.. => 2.0,
                _ if sample % 2 == 0 => 1.0,
                _ => -1.0,
            };
            for (statistic, _) in &mut cases {
                if statistic.step(f64::NAN).missing != statistic.step(r).missing {
                    continue;
                }
                return 4;
            }
            let input = f64::from(round % 7);
            if adaptive.step(&[input], r).is_err() {
                return 5;
            }
            row.update(f64::from(sample), r, 1.5, Persistence::consecutive(4));
        }
        for (number, (statistic, expected)) in (10..).zip(&cases) {
            if (statistic.value() - expected).abs() > TOLERANCE {
                return number;
            }
        }
    }
    if bump::used() != before {
        return 6;
    }
    if row.length() != 4 || !row.alarm() || adaptive.limit() <= 1.0 {
        return 7;
    }
    // The detector is linked, step and all, though it is made elsewhere.
    black_box(watch as fn(&mut Detector) -> bool);
    0
}

fn watch(detector: &mut Detector) -> bool {
    let alarm = detector
        .step(0.0, &[0.0], &[0.0])
        .is_ok_and(|verdict| verdict.channels.iter().any(|channel| channel.alarm));
    detector.reset();
    alarm
}

fn cases() -> Result<Vec<Case>, StatisticError> {
    let both = Sides::Both;
    let growth = Growth {
        shortest: 2,
        longest: 100,
    };
    let mut cases: Vec<Case> = Vec::new();
    let mut case = |statistic: Box<dyn Statistic>, expected| cases.push((statistic, expected));
    // Four times 2 - 0.5.
    case(Box::new(Cusum::new(0.5, 5.0, both)?), 6.0);
    case(Box::new(MovingAverage::new(8, 1.0, both)?), 1.0);
    case(Box::new(Modulus::new(3.0)), 2.0);
    // Four of 1 and four of 4.
    case(Box::new(WindowedChiSquare::new(8, 50.0)?), 20.0);
    // The last four: a step of 2, half of 4 x 4; a ramp of 20 / 30 a sample, half of 400 / 30.
    case(
        Box::new(Glr::new(Waveform::Step, (0.1, 3.0), 4, 9.0, both)?),
        8.0,
    );
    case(
        Box::new(Glr::new(Waveform::Ramp, (0.1, 3.0), 4, 9.0, both)?),
        20.0 / 3.0,
    );
    // Eight times 0 - 0.5 in the mean, four times 2 - 0.5.
    case(Box::new(Sprt::new(1.0, -9.0, 9.0)?), 2.0);
    // R = (1 + R) e^(r - 0.5), in decimal arithmetic.
    case(
        Box::new(ShiryaevRoberts::new(1.0, 7.0, Sides::Upper)?),
        6.79042993520808,
    );
    case(
        Box::new(RunSum::new(1.0, RunSum::ZONE_SCORES, 7.0, both)?),
        16.0,
    );
    // 1, -1, 1, -1 and four of 2: the mean 1, the squares 2 x 4 + 4 x 1 = 12, with 7 degrees.
    case(
        Box::new(WindowedVariance::new(8, 3.0, Sides::Upper)?),
        1.2828066162212794,
    );
    // 8 + 16 with 12 degrees; less 12 x (2 / 3)^2 with 11.
    case(
        Box::new(GrowingChiSquare::new(growth, 3.0, Sides::Upper)?),
        2.0461046004407337,
    );
    case(
        Box::new(GrowingVariance::new(growth, 3.0, Sides::Upper)?),
        1.4984165179464608,
    );
    // 1, -1, 2, 2, 2, 2 of the last six: c_0 = 18, c_1 = 9; 6 x 8 / 5 / 4.
    case(Box::new(Whiteness::new(6, 1, 9.0)?), 2.4);
    Ok(cases)
}
