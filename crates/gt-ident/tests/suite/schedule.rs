//! Models along a load.

use gt_core::Dataset;
use gt_ident::schedule::{Estimation, SchedulePoint, ScheduledArx, ScheduledModel};
use gt_ident::{Arx, ArxStructure, IdentError};
use nalgebra::DMatrix;
use rand::RngExt;

use crate::common::*;

/// Input 1 drives, input 2 is the load and stands in no equation.
fn structure(na: usize, nb: usize) -> ArxStructure {
    ArxStructure::Diagonal {
        na,
        nb: vec![nb, 0],
        nk: vec![1],
    }
}

/// `y(t) = a(s) y(t-1) + b(s) u(t-1) + c(s) + e`, with the load `s(t)` and a drive that takes a new
/// level every `hold` samples.
fn varying(
    seed: u64,
    load: &[f64],
    hold: usize,
    deviation: f64,
    coefficients: impl Fn(f64) -> [f64; 3],
) -> Dataset {
    let mut rng = generator(seed);
    let samples = load.len();
    let drive = normal_matrix(&mut rng, 1, samples);
    let e = normal_matrix(&mut rng, 1, samples) * deviation;
    let mut u = DMatrix::zeros(2, samples);
    let mut y = DMatrix::zeros(1, samples);
    for t in 0..samples {
        u[(0, t)] = 3.0 + drive[t / hold];
        u[(1, t)] = load[t];
        let [a, b, c] = coefficients(load[t]);
        y[t] = if t == 0 {
            c / (1.0 - a)
        } else {
            a * y[t - 1] + b * (u[(0, t - 1)] - 3.0) + c + e[t]
        };
    }
    Dataset::new(signals("u", 2), signals("y", 1), u, y, 1.0).unwrap()
}

/// A time constant of 3.3 to 50 samples and a gain of 20 to 4 that is not linear in the load.
fn turbine_like(load: f64) -> [f64; 3] {
    let a = 0.98 - 0.28 * load;
    let gain = 20.0 / (1.0 + 4.0 * load);
    [a, gain * (1.0 - a), 2.0 * load * (1.0 - a)]
}

/// Up and down between the loads 0 and 1, `ramp` samples each way.
fn ramps(samples: usize, ramp: usize) -> Vec<f64> {
    (0..samples)
        .map(|t| {
            let part = (t % (2 * ramp)) as f64 / ramp as f64;
            if part < 1.0 { part } else { 2.0 - part }
        })
        .collect()
}

fn free_run_error(run: &gt_ident::FreeRun, data: &Dataset) -> f64 {
    assert_eq!(run.diverges_at, [None]);
    ((data.y() - &run.y).norm_squared() / data.len() as f64).sqrt()
}

/// Against the best of single models: one fitted at each load, and three to the ramp itself, of
/// which two have the load as an input.
#[test]
fn a_load_ramp_is_followed_ten_times_better_than_by_one_model() {
    let values = vec![0.0, 0.1, 0.25, 0.5, 0.75, 1.0];
    let constant: Vec<Dataset> = values
        .iter()
        .zip(10..)
        .map(|(&load, seed)| varying(seed, &[load; 1000], 20, 0.02, turbine_like))
        .collect();
    let ramp = varying(1, &ramps(3000, 500), 20, 0.02, turbine_like);
    let test = varying(2, &ramps(2000, 250), 20, 0.02, turbine_like);
    let with_load = |lags: usize| ArxStructure::Diagonal {
        na: lags,
        nb: vec![lags],
        nk: vec![1],
    };
    let mut singles: Vec<(ArxStructure, &Dataset)> = (constant.iter().chain([&ramp]))
        .map(|data| (structure(1, 1), data))
        .collect();
    singles.extend([(with_load(1), &ramp), (with_load(3), &ramp)]);
    let mut single = f64::INFINITY;
    for (structure, data) in singles {
        let model = Arx::new(structure).fit(data).unwrap();
        let run = model.simulate(&test).unwrap();
        let error = free_run_error(&run, &test);
        single = single.min(error);
    }
    let options = ScheduledArx::new(structure(1, 1), "u2", values);
    let from_records = options.fit(&constant).unwrap();
    let from_ramp = options.fit(std::slice::from_ref(&ramp)).unwrap();
    let joint = options
        .clone()
        .estimation(Estimation::Joint)
        .fit(std::slice::from_ref(&ramp))
        .unwrap();
    for (name, model) in [
        ("records", from_records),
        ("ramp", from_ramp),
        ("joint", joint),
    ] {
        let error = free_run_error(&model.simulate(&test).unwrap(), &test);
        assert!(error < single / 10.0, "{name}: {error} against {single}");
    }
}

/// Coefficients linear in the load between the points are found exactly by the joint estimate, and
/// prediction and free run are then exact; 1e-8 is rounding times the condition.
#[test]
fn a_system_linear_in_the_load_is_recovered_exactly() {
    let coefficients = |load: f64| {
        let bend = if load < 2.0 { 0.0 } else { load - 2.0 };
        [0.5 + 0.1 * load - 0.05 * bend, 2.0 - 0.3 * bend, 1.0 + load]
    };
    let mut rng = generator(9);
    let load: Vec<f64> = (0..600).map(|_| rng.random_range(1.0..4.0)).collect();
    let data = varying(3, &load, 1, 0.0, coefficients);
    let model = ScheduledArx::new(structure(1, 1), "u2", vec![1.0, 2.0, 4.0])
        .estimation(Estimation::Joint)
        .fit(&[data.rows(0..300).unwrap(), data.rows(300..600).unwrap()])
        .unwrap();
    for point in model.points() {
        let [a, b, c] = coefficients(point.value);
        let terms = &point.model.rows()[0].terms;
        assert!((terms[0].coefficient - a).abs() < 1e-8);
        assert!((terms[1].coefficient - b).abs() < 1e-8);
        // The operating point is the equilibrium of the local model.
        let at = point.model.operating_point();
        assert!((at.y[0] * (1.0 - a) - b * (at.u[0] - 3.0) - c).abs() < 1e-7);
    }
    let predicted = model.predict(&data).unwrap();
    assert!(predicted[0].is_nan());
    assert!((predicted.columns(1, 599) - data.y().columns(1, 599)).amax() < 1e-8);
    let run = model.simulate(&data).unwrap();
    assert!(largest_difference(&run.y, data.y()) < 1e-7);
}

/// One point, or the same model at every point, is that model.
#[test]
fn equal_points_are_one_model() {
    let data = varying(4, &ramps(400, 50), 1, 0.3, |_| [0.8, 1.0, 2.0]);
    let model = Arx::new(structure(2, 2)).fit(&data).unwrap();
    let alone = model.simulate(&data).unwrap();
    let predicted = model.predict(&data).unwrap();
    for values in [vec![0.5], vec![0.0, 1.0], vec![0.1, 0.4, 0.6]] {
        for width in [0.0, 0.3, 1.0] {
            let points = values.iter().map(|&value| SchedulePoint {
                value,
                model: model.clone(),
            });
            let scheduled = ScheduledModel::new("u2", points.collect(), width).unwrap();
            let run = scheduled.simulate(&data).unwrap();
            // Weights that sum to 1 within rounding, at outputs of about 10.
            assert!(largest_difference(&run.y, &alone.y) < 1e-11);
            let found = scheduled.predict(&data).unwrap();
            let gap = found.columns(2, 398) - predicted.columns(2, 398);
            assert!(gap.amax() < 1e-11);
            let text = serde_json::to_string(&scheduled).unwrap();
            let read: ScheduledModel = serde_json::from_str(&text).unwrap();
            assert_eq!(read, scheduled);
        }
    }
}

/// The same with coupled outputs, one of them at lag 0, and the load among the regressors.
#[test]
fn equal_points_of_coupled_outputs_are_one_model() {
    let mut rng = generator(11);
    let form = random_form(&mut rng, &[2, 1], 2, true);
    let data = record(&mut rng, &form, 300, 0.2);
    let structure = ArxStructure::Canonical {
        indices: vec![2, 1],
        feedthrough: true,
    };
    let model = Arx::new(structure.clone()).fit(&data).unwrap();
    let points = [-1.0, 1.0].map(|value| SchedulePoint {
        value,
        model: model.clone(),
    });
    let scheduled = ScheduledModel::new("u2", points.to_vec(), 1.0).unwrap();
    // Rounding, at outputs of about 10 and poles below 1.
    let run = scheduled.simulate(&data).unwrap();
    assert!(largest_difference(&run.y, &model.simulate(&data).unwrap().y) < 1e-11);
    let gap = scheduled.predict(&data).unwrap() - model.predict(&data).unwrap();
    assert!(gap.columns(2, 298).amax() < 1e-11);
    // And one point fitted to the record is the fit of the record, but for its constant and for
    // the means, which leave out the first two samples: 3e-2 of noise of 0.2.
    let one = ScheduledArx::new(structure, "u2", vec![0.0]).fit(std::slice::from_ref(&data));
    let one = one.unwrap();
    for (left, right) in one.points()[0].model.rows().iter().zip(model.rows()) {
        for (left, right) in left.terms.iter().zip(&right.terms) {
            assert!((left.coefficient - right.coefficient).abs() < 3e-2);
        }
    }
}

/// Width 0 switches half-way: each half of the range is the point's own model, exactly.
#[test]
fn a_hand_over_of_no_width_is_a_switch() {
    let low = varying(5, &[0.0; 200], 1, 0.1, |_| [0.5, 1.0, 2.0]);
    let high = varying(6, &[1.0; 200], 1, 0.1, |_| [0.9, 0.3, 0.1]);
    let fit = |data: &Dataset| Arx::new(structure(1, 1)).fit(data).unwrap();
    let points = vec![
        SchedulePoint {
            value: 0.0,
            model: fit(&low),
        },
        SchedulePoint {
            value: 1.0,
            model: fit(&high),
        },
    ];
    let load: Vec<f64> = (0..300)
        .map(|t| if t < 150 { 0.49 } else { 0.51 })
        .collect();
    let data = varying(7, &load, 1, 0.1, |_| [0.7, 1.0, 1.0]);
    let predicted = ScheduledModel::new("u2", points.clone(), 0.0)
        .unwrap()
        .predict(&data)
        .unwrap();
    for (point, range) in points.iter().zip([1..150, 150..300]) {
        let own = point.model.predict(&data).unwrap();
        let gap = predicted.columns_range(range.clone()) - own.columns_range(range);
        assert!(gap.amax() < 1e-12);
    }
}

#[test]
fn schedules_that_cannot_be() {
    let data = varying(8, &ramps(400, 50), 1, 0.3, turbine_like);
    let refused = |values: &[f64], records: &[Dataset]| {
        ScheduledArx::new(structure(1, 1), "u2", values.to_vec())
            .fit(records)
            .unwrap_err()
    };
    let one = std::slice::from_ref(&data);
    for values in [vec![], vec![1.0, 1.0], vec![1.0, 0.0], vec![f64::INFINITY]] {
        let found = values.clone();
        assert_eq!(refused(&values, one), IdentError::ScheduleValues { found });
    }
    assert_eq!(refused(&[0.0], &[]), IdentError::NoRecords);
    assert_eq!(
        refused(&[0.0, 1.0, 5.0, 9.0], one).to_string(),
        "samples around `u2` = 5: expected at least 4, found 0"
    );
    let options = ScheduledArx::new(structure(1, 1), "u2", vec![0.0, 1.0]);
    assert_eq!(
        options.clone().width(1.5).fit(one).unwrap_err(),
        IdentError::OptionRange {
            option: "width",
            expected: "from 0 to 1",
            found: 1.5
        }
    );
    assert_eq!(
        ScheduledArx::new(structure(1, 1), "y1", vec![0.0])
            .fit(one)
            .unwrap_err()
            .to_string(),
        "channel `y1`: not found; there are: u1, u2"
    );
    let renamed = data.select(&["u2", "u1"], &["y1"]).unwrap();
    assert!(matches!(
        refused(&[0.0], &[data.clone(), renamed]),
        IdentError::ChannelName { .. }
    ));
    // A drive that rests at every load explains nothing beside the constant.
    let still = Dataset::new(
        data.inputs().to_vec(),
        data.outputs().to_vec(),
        DMatrix::from_fn(
            2,
            400,
            |row, t| if row == 0 { 1.0 } else { data.u()[(1, t)] },
        ),
        data.y().clone(),
        1.0,
    )
    .unwrap();
    assert!(matches!(
        refused(&[0.5], &[still]),
        IdentError::RankDeficient { .. }
    ));
}
