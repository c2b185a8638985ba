//! No step of the detector allocates: counted by the global allocator of this test program.
#![allow(unsafe_code)] // a global allocator is an unsafe trait; this one counts and forwards

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use gt_core::{Dataset, OperatingPoint, Signal, StateSpace};
use gt_fdi::design::{
    Bank, FaultEffect, FaultHypothesis, IsolationDesign, IsolationDetector, NoiseCovariance,
    ResidualGenerator, ResidualTest, ThresholdRule, calibrate,
};
use gt_fdi::runtime::{
    AdaptiveThreshold, Cusum, CusumFleet, Detector, Fleet, Glr, GrowingChiSquare, GrowingVariance,
    Growth, MovingAverage, RunSum, ShiryaevRoberts, Sides, Sprt, Statistic, Waveform, Whiteness,
    WindowedChiSquare, WindowedVariance,
};
use nalgebra::DMatrix;

thread_local! {
    /// Allocations and reallocations of this thread (the test harness has others).
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call is forwarded to the system's allocator unchanged; the counter is a
// thread-local `Cell` with a constant initialiser and no destructor, so it allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        unsafe { System.realloc(pointer, layout, new_size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Eight states, two inputs: a chain of delays with a pole at 0.7.
#[allow(clippy::unwrap_used)] // part of the test below
fn part(output: &str) -> (ResidualGenerator, ResidualTest) {
    let a = DMatrix::from_fn(8, 8, |i, j| match (i, j) {
        _ if i == j => 0.7,
        _ if j == i + 1 => 1.0,
        _ => 0.0,
    });
    let c = DMatrix::from_fn(1, 8, |_, j| if j == 0 { 1.0 } else { 0.0 });
    let matrices = [a, DMatrix::from_element(8, 2, 0.1), c, DMatrix::zeros(1, 2)];
    let (inputs, outputs) = (Signal::named(&["a", "b"]), Signal::named(&[output]));
    let model = StateSpace::new(matrices, 0.08, inputs, outputs).unwrap();
    let point = OperatingPoint::zero(2, 1);
    let generator = ResidualGenerator::observer(model, point, &[0.4; 8]).unwrap();
    let rule = ThresholdRule::Margin {
        factor: 1.0,
        consecutive: 2,
    };
    let calibration = calibrate(&[&[1.0; 20]], 0.08, rule).unwrap();
    let test = ResidualTest::modulus(&generator, &calibration);
    (generator, test)
}

#[test]
fn no_step_allocates() {
    let (generators, tests) = ["p", "q", "r", "s"].map(part).into_iter().unzip();
    let bank = Bank::new("four", generators, tests).unwrap();
    let mut detector = Detector::new(&bank);
    let nan = f64::NAN;
    let mut alarms = 0_usize;
    let mut errors = 0_usize;

    let before = COUNT.with(Cell::get);
    for k in 0..10_000_u32 {
        let t = f64::from(k) * 0.08;
        // Quiet, alarms, missing outputs, missing inputs, overflow and refused samples.
        let (u, y) = match k % 1000 {
            600..620 => ([0.0, 0.0], [5.0, -5.0, 1e308, 0.0]),
            700..720 => ([0.0, 0.0], [nan, 0.0, f64::INFINITY, 0.0]),
            800 => ([nan, 0.0], [0.0; 4]),
            900 => ([1e308, -1e308], [0.0; 4]),
            _ => ([0.01, 0.02], [0.0; 4]),
        };
        match detector.step(t, &u, &y) {
            Ok(verdict) => alarms += verdict.channels.iter().filter(|c| c.new_alarm).count(),
            Err(_) => errors += 1,
        }
        errors += usize::from(detector.step(t, &u, &y).is_err());
        if k == 5000 {
            detector.reset();
        }
    }
    let allocated = COUNT.with(Cell::get) - before;

    assert_eq!(allocated, 0);
    assert!(
        alarms >= 30 && errors >= 9_999,
        "{alarms} {errors}: the record should do both"
    );
    // The counter counts.
    drop(vec![1_u8; 100]);
    assert!(COUNT.with(Cell::get) > before);
}

/// Over many windows, so that every sum is made anew; on what was made, cloned and resumed alike.
#[test]
#[allow(clippy::unwrap_used)] // a test
fn no_statistic_allocates() {
    let both = Sides::Both;
    let ramp = Glr::new(Waveform::Ramp, (1e-4, 1e-1), 256, 9.0, both).unwrap();
    let text = serde_json::to_string(&ramp).unwrap();
    let growth = Growth {
        shortest: 20,
        longest: 700,
    };
    let mut variance = WindowedVariance::new(25, 3.0, both).unwrap();
    let mut whiteness = Whiteness::new(100, 10, 30.0).unwrap();
    for r in [0.5, -0.25, 1.0] {
        variance.step(r);
        whiteness.step(r);
    }
    let variance_text = serde_json::to_string(&variance).unwrap();
    let whiteness_text = serde_json::to_string(&whiteness).unwrap();
    let mut statistics: Vec<Box<dyn Statistic>> = vec![
        Box::new(Cusum::new(0.5, 5.0, both).unwrap()),
        Box::new(MovingAverage::new(25, 1.0, both).unwrap()),
        Box::new(WindowedChiSquare::new(25, 50.0).unwrap()),
        Box::new(ramp.clone()),
        Box::new(serde_json::from_str::<Glr>(&text).unwrap()),
        Box::new(ramp),
        Box::new(Glr::new(Waveform::Step, (0.1, 3.0), 4096, 9.0, both).unwrap()),
        Box::new(Sprt::new(1.0, -5.0, 5.0).unwrap()),
        Box::new(ShiryaevRoberts::new(1.0, 7.0, both).unwrap()),
        Box::new(RunSum::new(1.0, RunSum::ZONE_SCORES, 7.0, both).unwrap()),
        Box::new(GrowingChiSquare::new(growth, 3.0, both).unwrap()),
        Box::new(GrowingVariance::new(growth, 3.0, both).unwrap()),
        Box::new(serde_json::from_str::<WindowedVariance>(&variance_text).unwrap()),
        Box::new(variance.clone()),
        Box::new(variance),
        Box::new(serde_json::from_str::<Whiteness>(&whiteness_text).unwrap()),
        Box::new(whiteness.clone()),
        Box::new(whiteness),
    ];
    let mut threshold = AdaptiveThreshold::new(2.0, &[0.5], 20.0).unwrap();
    let mut alarms = 0_usize;
    let before = COUNT.with(Cell::get);
    for k in 0..20_000_u32 {
        let r = match k % 1000 {
            300..330 => 5.0,
            600..630 => -5.0,
            700 => f64::NAN,
            800 => 1e308,
            900 => f64::INFINITY,
            _ => 0.1,
        };
        let inputs = [f64::from(k % 300), 0.0];
        let decision = threshold.step(&inputs[..=usize::from(k % 7 == 6)], r);
        alarms += usize::from(decision.is_ok_and(|decision| decision.alarm));
        for statistic in &mut statistics {
            alarms += usize::from(statistic.step(r).alarm);
            if k % 5000 == 4999 {
                statistic.reset();
            }
        }
    }
    let allocated = COUNT.with(Cell::get) - before;
    assert_eq!(allocated, 0);
    assert!(alarms > 1000, "{alarms}: the record should raise some");
}

/// Whole registers and single streams, with and without something missing.
#[test]
fn no_step_of_a_fleet_allocates() {
    let (generator, _) = part("p");
    let (streams, samples) = (37, 5);
    let mut fleet = Fleet::new(&generator, streams);
    let u = vec![0.1; samples * 2 * streams];
    let mut y = vec![0.2; samples * streams];
    let mut residuals = y.clone();
    y[3] = f64::NAN;
    let cusum = Cusum::new(0.5, 5.0, Sides::Both).unwrap();
    let (mut sums, mut values) = (CusumFleet::new(&cusum, streams), y.clone());
    let before = COUNT.with(Cell::get);
    for _ in 0..100 {
        assert!(fleet.step(&u, &y, &mut residuals).is_ok());
        assert!(sums.step(&residuals, &mut values).is_ok());
    }
    assert_eq!(COUNT.with(Cell::get) - before, 0);
    assert!(residuals[3].is_nan() && residuals[4].is_finite());
}

/// Numbers without visible order in -1 .. 1.
fn scatter(state: &mut u64) -> f64 {
    *state = state
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1);
    (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// A record of a lag of one second with two sensors, of which one drifts by `size` at the end.
#[allow(clippy::unwrap_used)] // part of the test below
fn scattered(seed: u64, len: usize, size: f64) -> Dataset {
    let mut state = seed;
    let (mut u, mut y) = (DMatrix::zeros(1, len), DMatrix::zeros(2, len));
    let (mut demand, mut x) = (0.0, 0.0);
    for t in 0..len {
        demand = 0.9 * demand + scatter(&mut state);
        u[(0, t)] = demand;
        y[(0, t)] = x + 0.1 * scatter(&mut state) + size * t as f64 / len as f64;
        y[(1, t)] = 0.5 * x + 0.1 * scatter(&mut state);
        x = 0.9 * x + 0.1 * demand;
    }
    let (inputs, outputs) = (Signal::named(&["u"]), Signal::named(&["p", "q"]));
    Dataset::new(inputs, outputs, u, y, 0.1).unwrap()
}

#[test]
#[allow(clippy::unwrap_used)] // a test
fn no_step_of_an_isolator_allocates() {
    let matrices = [
        DMatrix::from_element(1, 1, 0.9),
        DMatrix::from_element(1, 1, 0.1),
        DMatrix::from_column_slice(2, 1, &[1.0, 0.5]),
        DMatrix::zeros(2, 1),
    ];
    let (inputs, outputs) = (Signal::named(&["u"]), Signal::named(&["p", "q"]));
    let model = StateSpace::new(matrices, 0.1, inputs, outputs).unwrap();
    let noise = NoiseCovariance::new(
        &DMatrix::from_element(1, 1, 1e-6),
        &(DMatrix::identity(2, 2) * 0.003),
        &DMatrix::zeros(1, 2),
    )
    .unwrap();
    let filter = ResidualGenerator::kalman(model, OperatingPoint::zero(1, 2), noise).unwrap();
    let fault = |name: &str, effect: FaultEffect| FaultHypothesis {
        name: name.to_owned(),
        unit: String::new(),
        both_signs: true,
        effect,
    };
    let faults = vec![
        fault(
            "p",
            FaultEffect::Outputs {
                changes: [("p".to_owned(), 1.0)].into(),
                delay_s: 0.0,
            },
        ),
        fault(
            "valve",
            FaultEffect::ActuatorLag {
                input: "u".to_owned(),
                nominal_s: 0.3,
                gain: 1.0,
            },
        ),
    ];
    let healthy: Vec<Dataset> = (1..7).map(|seed| scattered(seed, 30_000, 0.0)).collect();
    let isolator = IsolationDesign::new(faults)
        .arl0_hours(0.2)
        .half_width(2)
        .calibrate("two", vec![filter], &healthy)
        .unwrap();
    let mut detector = IsolationDetector::new(&isolator).unwrap();
    let record = scattered(9, 20_000, 1.0);
    let (mut alarms, mut errors) = (0_usize, 0_usize);

    let before = COUNT.with(Cell::get);
    for k in 0..record.len() {
        // A gap of a second half way.
        let t = 0.1 * k as f64 + if k > 10_000 { 1.0 } else { 0.0 };
        let (u, y) = (record.u().column(k), record.y().column(k));
        let y = match k % 5000 {
            600..620 => [f64::NAN, y[1]],
            700 => [1e308, -1e308],
            _ => [y[0], y[1]],
        };
        match detector.step(t, u.as_slice(), &y) {
            Ok(verdict) => alarms += usize::from(verdict.new_alarm),
            Err(_) => errors += 1,
        }
        errors += usize::from(detector.step(t, u.as_slice(), &y).is_err());
        if k == 15_000 {
            detector.reset();
        }
    }
    let allocated = COUNT.with(Cell::get) - before;

    assert_eq!(allocated, 0);
    // One alarm before the gap, one after it, one after the reset.
    assert!(alarms >= 2 && errors == 20_000, "{alarms} {errors}");
}
