//! Generators at several operating points.

use gt_core::{Dataset, OperatingPoint, Signal, StateSpace};
use gt_fdi::FdiError;
use gt_fdi::design::{
    Blend, ResidualGenerator, ScheduleError, ScheduledGenerators, ScheduledPoint,
};
use nalgebra::{DMatrix, DVector};

use crate::fixtures::{TS, noise, plain_generator, rows};

const BREAKPOINTS: [f64; 3] = [0.0, 1.0, 2.0];

/// `x+ = a(load) x + b(load) u`, `y = x + 10 load`: exact at a load with the operating point
/// `y0 = 10 load`.
fn coefficients(load: f64) -> (f64, f64) {
    (0.5 + 0.2 * load, 1.0 - 0.25 * load)
}

fn local(load: f64) -> ResidualGenerator {
    let (a, b) = coefficients(load);
    let matrices = [a, b, 1.0, 0.0].map(|value| rows([[value]]));
    let model =
        StateSpace::new(matrices, TS, Signal::named(&["u"]), Signal::named(&["y"])).unwrap();
    let point = OperatingPoint {
        u: DVector::zeros(1),
        y: DVector::from_element(1, 10.0 * load),
    };
    ResidualGenerator::observer(model, point, &[0.3]).unwrap()
}

fn points(generators: &[(f64, ResidualGenerator)]) -> Vec<ScheduledPoint> {
    let point = |(breakpoint, generator): &(f64, ResidualGenerator)| ScheduledPoint {
        breakpoint: *breakpoint,
        generator: generator.clone(),
    };
    generators.iter().map(point).collect()
}

fn schedule(blend: Blend) -> ScheduledGenerators {
    let all = BREAKPOINTS.map(|load| (load, local(load)));
    ScheduledGenerators::new("load", points(&all), blend).unwrap()
}

/// The plant along a load, noise as its input.
fn record(load: &[f64]) -> Dataset {
    let u = noise(3, load.len());
    let (mut x, mut y) = (0.0, Vec::new());
    for (&load, u) in load.iter().zip(&u) {
        let (a, b) = coefficients(load);
        y.push(x + 10.0 * load);
        x = a * x + b * u;
    }
    dataset(load, &u, &y)
}

fn dataset(load: &[f64], u: &[f64], y: &[f64]) -> Dataset {
    let inputs = DMatrix::from_fn(2, load.len(), |row, k| [load[k], u[k]][row]);
    let y = DMatrix::from_row_slice(1, y.len(), y);
    let names = (Signal::named(&["load", "u"]), Signal::named(&["y"]));
    Dataset::new(names.0, names.1, inputs, y, TS).unwrap()
}

/// 100 samples at each breakpoint with ramps of 100 samples between them, up and down again.
fn course() -> Vec<f64> {
    let level = |k: usize| match k % 200 {
        within if within < 100 => (k / 200) as f64,
        within => (k / 200) as f64 + (within - 100) as f64 / 100.0,
    };
    let up: Vec<f64> = (0..500).map(level).collect();
    let down: Vec<f64> = up.iter().rev().copied().collect();
    [up, down].concat()
}

/// At the breakpoints the local models are exact, and so is the residual, as soon as the generator
/// there, which ran all the time, has settled; on the ramps it stays below that of any single one.
#[test]
fn residuals_vanish_where_a_local_model_is_exact() {
    let load = course();
    let data = record(&load);
    for blend in [Blend::Interpolated, Blend::Switched { hysteresis: 0.1 }] {
        let residuals = schedule(blend).residuals(&data).unwrap();
        let mut held = 0;
        let mut exact = 0;
        for (k, value) in load.iter().enumerate() {
            let same = k > 0 && load[k - 1] == *value;
            held = if same { held + 1 } else { 0 };
            // 0.3^30 is 2e-16; the mismatch of the ramps is below 100.
            if held > 30 {
                assert!(residuals[k].abs() < 1e-12, "{k}: {}", residuals[k]);
                exact += 1;
            }
        }
        assert!(exact > 300, "{exact}");
        let single = BREAKPOINTS.map(|load| local(load).residuals(&data).unwrap().norm());
        let ratio = single.map(|norm| residuals.norm() / norm);
        println!("{blend:?}: of the norm of a single generator {ratio:.3?}");
        // A single one is off by up to two intervals, a switched one by half of one on the ramps.
        assert!(
            ratio.iter().all(|ratio| *ratio < 0.5),
            "{blend:?}: {ratio:?}"
        );
    }
}

#[test]
fn equal_local_models_are_one_generator() {
    let own = local(0.7);
    let data = record(&course());
    let alone = own.residuals(&data).unwrap();
    let all = BREAKPOINTS.map(|load| (load, own.clone()));
    let of = |blend| {
        let made = ScheduledGenerators::new("load", points(&all), blend).unwrap();
        made.residuals(&data).unwrap()
    };
    assert_eq!(of(Blend::Switched { hysteresis: 0.0 }), alone);
    // Rounding of one sum of two.
    let error = (of(Blend::Interpolated) - &alone).amax();
    assert!(error < 1e-15 * alone.amax(), "{error:e}");
    let single = ScheduledGenerators::new("load", points(&all[..1]), Blend::default()).unwrap();
    assert_eq!(single.residuals(&data).unwrap(), alone);
}

#[test]
fn residuals_are_continuous_across_breakpoints_and_held_beyond_the_ends() {
    let data = record(&course());
    let (u, y) = (data.u().row(1).into_owned(), data.y().row(0).into_owned());
    let made = schedule(Blend::Interpolated);
    let at = |load: f64| {
        let load = vec![load; data.len()];
        let data = dataset(&load, u.as_slice(), y.as_slice());
        made.residuals(&data).unwrap()
    };
    for breakpoint in BREAKPOINTS {
        let own = local(breakpoint).residuals(&data).unwrap();
        assert_eq!(at(breakpoint), own);
        for step in [1e-9, -1e-9] {
            // The local residuals differ by less than 50.
            assert!((at(breakpoint + step) - &own).amax() < 5e-8);
        }
    }
    assert_eq!(at(-100.0), at(0.0));
    assert_eq!(at(1e300), at(2.0));
    let between = 0.25 * at(0.0) + 0.75 * at(1.0);
    assert!((at(0.75) - between).amax() < 1e-12);
    assert_eq!(made.weights(1.25), [0.0, 0.75, 0.25]);
    assert_eq!(made.weights(f64::NEG_INFINITY), [1.0, 0.0, 0.0]);
    assert!(made.weights(f64::NAN).iter().all(|weight| weight.is_nan()));
    assert_eq!(made.settle_samples(), local(0.0).settle_samples());
}

/// A load that trembles round the middle between two breakpoints changes nothing within the
/// hysteresis, and each change shows the sample of the other generator that ran along.
#[test]
fn switching_waits_for_the_hysteresis() {
    let tremble = noise(9, 300);
    let load: Vec<f64> = (tremble.iter().enumerate())
        .map(|(k, draw)| match k {
            0..50 => 0.2,
            200..250 => 0.9,
            _ => 0.5 + 0.15 * draw.clamp(-1.0, 1.0),
        })
        .collect();
    let data = record(&load);
    let changes = |hysteresis| {
        let run = schedule(Blend::Switched { hysteresis }).run(&data).unwrap();
        let active: Vec<usize> = (run.weights.column_iter())
            .map(|column| column.iter().position(|weight| *weight == 1.0).unwrap())
            .collect();
        for (k, &index) in active.iter().enumerate() {
            let own = local(BREAKPOINTS[index]).residuals(&data).unwrap();
            assert_eq!(run.residuals[k], own[k]);
        }
        (active.windows(2).filter(|pair| pair[0] != pair[1])).count()
    };
    assert_eq!(changes(0.2), 1);
    assert!(changes(0.0) > 50);
    let made = schedule(Blend::Switched { hysteresis: 0.2 });
    assert_eq!(made.weights(0.49), [1.0, 0.0, 0.0]);
    assert_eq!(made.weights(0.5), [0.0, 1.0, 0.0]);
    assert_eq!(made.weights(7.0), [0.0, 0.0, 1.0]);
}

#[test]
fn missing_samples_give_no_residual_and_return() {
    let whole = course();
    let made = schedule(Blend::Interpolated);
    let run = made.run(&record(&whole)).unwrap();
    let data = record(&whole);
    let mut load = whole.clone();
    load[150] = f64::NAN;
    let (u, y) = (data.u().row(1).into_owned(), data.y().row(0).into_owned());
    let gap = made
        .residuals(&dataset(&load, u.as_slice(), y.as_slice()))
        .unwrap();
    for k in 0..whole.len() {
        // The load drives no generator here: only its own sample is lost.
        assert!(if k == 150 {
            gap[k].is_nan()
        } else {
            gap[k] == run.residuals[k]
        });
    }
    let mut y = y.as_slice().to_vec();
    y[50] = f64::NAN;
    let gap = made.residuals(&dataset(&whole, u.as_slice(), &y)).unwrap();
    assert!(gap[50].is_nan() && gap.iter().filter(|value| value.is_nan()).count() == 1);
    for column in run.weights.column_iter() {
        assert!((column.sum() - 1.0).abs() < 1e-15);
    }
}

#[test]
fn schedules_that_do_not_fit_are_refused() {
    let of = |all: &[(f64, ResidualGenerator)], blend| {
        ScheduledGenerators::new("load", points(all), blend).unwrap_err()
    };
    assert_eq!(of(&[], Blend::default()), ScheduleError::Empty.into());
    let own = || local(0.0);
    for (breakpoints, index, previous) in [
        ([1.0, 1.0], 1, 1.0),
        ([1.0, 0.5], 1, 1.0),
        ([f64::NAN, 0.5], 0, f64::NEG_INFINITY),
        ([0.0, f64::INFINITY], 1, 0.0),
    ] {
        let all = breakpoints.map(|breakpoint| (breakpoint, own()));
        match of(&all, Blend::default()) {
            FdiError::Schedule(ScheduleError::Breakpoint {
                index: i,
                previous: p,
                ..
            }) => {
                assert_eq!((i, p), (index, previous));
            }
            other => panic!("{other:?}"),
        }
    }
    let error = of(
        &[(0.0, own()), (1.0, plain_generator("y"))],
        Blend::default(),
    );
    let text = "generator 1, inputs: expected those of the first, u, found u0, u1";
    assert_eq!(error.to_string(), text);
    let slow = serde_json::to_string(&own()).unwrap();
    let slow = slow.replace("\"sample_time_s\":0.08", "\"sample_time_s\":0.1");
    let slow: ResidualGenerator = serde_json::from_str(&slow).unwrap();
    let error = of(&[(0.0, own()), (1.0, slow)], Blend::default());
    assert!(matches!(error, FdiError::SampleTime { .. }), "{error:?}");
    for hysteresis in [-0.1, 0.6, f64::NAN, f64::INFINITY] {
        let error = of(
            &[(0.0, own()), (1.0, own())],
            Blend::Switched { hysteresis },
        );
        match error {
            FdiError::Schedule(ScheduleError::Hysteresis { largest, .. }) => {
                assert_eq!(largest, 0.5);
            }
            other => panic!("{other:?}"),
        }
    }
    let made = schedule(Blend::Interpolated);
    let data = record(&course()).select(&["u"], &["y"]).unwrap();
    let error = made.residuals(&data).unwrap_err();
    assert!(matches!(error, FdiError::MissingTags { .. }), "{error:?}");

    let made = schedule(Blend::Switched { hysteresis: 0.25 });
    let text = serde_json::to_string(&made).unwrap();
    assert_eq!(
        serde_json::from_str::<ScheduledGenerators>(&text).unwrap(),
        made
    );
    let wrong = text.replace("\"breakpoint\":2.0", "\"breakpoint\":0.5");
    assert_ne!(wrong, text);
    let error = serde_json::from_str::<ScheduledGenerators>(&wrong).unwrap_err();
    assert!(
        error.to_string().starts_with("breakpoint 2: expected"),
        "{error}"
    );
}
