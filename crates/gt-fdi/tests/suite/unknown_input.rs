//! Observers whose residuals no disturbance reaches.

use gt_core::{Dataset, OperatingPoint, Signal, StateSpace};
use gt_fdi::FdiError;
use gt_fdi::design::{
    FaultModel, FilterError, KalmanFilter, LinearResidual, MAX_PREDICTED_RADIUS, NoiseCovariance,
    ResidualGenerator, UnknownInput, UnknownInputError, UnknownInputObserver,
};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use crate::fixtures::{TS, noise, rows};

fn signals(prefix: &str, count: usize) -> Vec<Signal> {
    let names: Vec<String> = (0..count).map(|index| format!("{prefix}{index}")).collect();
    Signal::named(&names)
}

fn draws(seed: u64, stream: u64, rows: usize, columns: usize) -> DMatrix<f64> {
    let values = noise(seed.wrapping_add(stream), rows * columns);
    DMatrix::from_vec(rows, columns, values)
}

fn plant(a: DMatrix<f64>, c: DMatrix<f64>) -> StateSpace {
    let (nx, ny) = (a.nrows(), c.nrows());
    let b = DMatrix::from_fn(nx, 2, |i, j| 0.3 + 0.2 * i as f64 - 0.4 * j as f64);
    let d = DMatrix::from_fn(ny, 2, |i, j| 0.5 * i as f64 - j as f64);
    StateSpace::new([a, b, c, d], TS, signals("u", 2), signals("y", ny)).unwrap()
}

/// A random model: `of_state` disturbances enter the state only, `at_once` both state and outputs;
/// one fault enters both. Disturbances in units of 1 and of 1000, outputs too.
fn random_model(nx: usize, ny: usize, of_state: usize, at_once: usize, seed: u64) -> FaultModel {
    let a = draws(seed, 1, nx, nx) * (0.7 / (nx as f64).sqrt());
    let units = DVector::from_fn(ny, |row, _| if row == 0 { 1000.0 } else { 1.0 });
    let units = DMatrix::from_diagonal(&units);
    let c = &units * draws(seed, 2, ny, nx);
    let mut state = draws(seed, 3, nx, of_state + at_once);
    state.column_mut(0).scale_mut(1e-3);
    let mut output = DMatrix::zeros(ny, of_state + at_once);
    output
        .columns_mut(of_state, at_once)
        .copy_from(&(&units * draws(seed, 4, ny, at_once)));
    let fault = UnknownInput {
        state: draws(seed, 5, nx, 1),
        output: &units * draws(seed, 6, ny, 1),
    };
    let disturbance = UnknownInput { state, output };
    FaultModel::new(plant(a, c), disturbance, fault).unwrap()
}

/// The record of a model from `x0` with the point added.
fn record(
    model: &FaultModel,
    x0: &DVector<f64>,
    [u, d, f]: [&DMatrix<f64>; 3],
    point: &OperatingPoint,
) -> Dataset {
    let plant = model.model();
    let (disturbance, fault) = (model.disturbance(), model.fault());
    let mut x = x0.clone();
    let (mut measured_u, mut y) = (u.clone(), DMatrix::zeros(plant.ny(), u.ncols()));
    for k in 0..u.ncols() {
        let (u, d, f) = (u.column(k), d.column(k), f.column(k));
        let output = plant.c() * &x + plant.d() * u + &disturbance.output * d + &fault.output * f;
        y.set_column(k, &(output + &point.y));
        x = plant.a() * x + plant.b() * u + &disturbance.state * d + &fault.state * f;
        measured_u.set_column(k, &(u + &point.u));
    }
    let (inputs, outputs) = (plant.inputs().to_vec(), plant.outputs().to_vec());
    Dataset::new(inputs, outputs, measured_u, y, TS).unwrap()
}

fn unit_noise(nx: usize, ny: usize) -> NoiseCovariance {
    let (q, r) = (DMatrix::identity(nx, nx), DMatrix::identity(ny, ny));
    NoiseCovariance::new(&q, &r, &DMatrix::zeros(nx, ny)).unwrap()
}

fn point(ny: usize) -> OperatingPoint {
    OperatingPoint {
        u: DVector::from_vec(vec![2.0, -1.0]),
        y: DVector::from_fn(ny, |row, _| 10.0 + row as f64),
    }
}

proptest! {
    /// Any disturbance leaves the residuals as they are, transients included, and faults show in
    /// them as `from_fault` says.
    #[test]
    fn prop_no_disturbance_reaches_the_residuals(
        nx in 2_usize..7,
        of_state in 1_usize..3,
        at_once in 0_usize..3,
        left in 1_usize..3,
        seed in any::<u64>(),
    ) {
        const LEN: usize = 80;
        let of_state = of_state.min(nx - 1);
        let ny = of_state + at_once + left;
        let model = random_model(nx, ny, of_state, at_once, seed);
        let nd = of_state + at_once;
        let point = point(ny);
        let built = UnknownInputObserver::kalman(&model, point.clone(), &unit_noise(nx, ny));
        // A random model with more outputs than disturbances has no zeros. One in some thousands has
        // a growing mode that the outputs hardly show, which the Riccati equation refuses.
        prop_assume!(!matches!(built, Err(FdiError::Filter(FilterError::NoSteadySolution { .. }))));
        let observer = built.unwrap();
        prop_assume!(observer.settle_samples() < 100);
        prop_assert_eq!(observer.residual().residual_signals().len(), left);
        prop_assert_eq!(observer.residual().system().nx(), nx - of_state);
        // How much of the rounding the observer enlarges: the inverse of C E.
        let enlarged = observer.residual().system().b().norm().max(1.0);
        prop_assume!(enlarged < 1e4);

        let (u, f) = (draws(seed, 11, 2, LEN), draws(seed, 12, 1, LEN));
        let d = 1000.0 * draws(seed, 13, nd, LEN);
        let none = (DMatrix::zeros(nd, LEN), DMatrix::zeros(1, LEN));
        let zero = DVector::zeros(nx);
        let of = |d: &DMatrix<f64>, f: &DMatrix<f64>| {
            let data = record(&model, &zero, [&u, d, f], &point);
            // What the outputs alone would put into the residuals.
            let through = observer.residual().system().d().columns(2, ny).abs();
            let size = DVector::from_fn(ny, |row, _| data.y().row(row).amax());
            (observer.residuals(&data).unwrap(), (through * size).max())
        };
        let (quiet, _) = of(&none.0, &none.1);
        let (disturbed, y) = of(&d, &none.1);
        let error = (&disturbed - &quiet).amax() / y;
        prop_assert!(error < 1e-9, "{error:e}");
        // The model is exact: nothing is left.
        prop_assert!(quiet.amax() < 1e-9 * y, "{:e}", quiet.amax());

        let (faulty, y) = of(&d, &f);
        let start = DVector::zeros(nx - of_state);
        let expected = observer.from_fault().simulate(&start, &f).unwrap();
        prop_assert!((&faulty - &expected).amax() < 1e-9 * y);
        prop_assert!(expected.amax() > 0.0);
        let through = observer.from_disturbance();
        prop_assert!(through.b().amax() < 1e-8 * enlarged && through.d().amax() < 1e-8);
    }
}

proptest! {
    /// The form for the detector has the residuals of the observer, combined so that each output of
    /// its own has a residual: the same numbers times the inverse of a square part of M, which stands
    /// in the observer's direct term.
    #[test]
    fn prop_the_generator_has_the_residuals_of_the_observer(
        nx in 2_usize..7,
        of_state in 1_usize..3,
        at_once in 0_usize..3,
        left in 1_usize..4,
        seed in any::<u64>(),
    ) {
        const LEN: usize = 200;
        let of_state = of_state.min(nx - 1);
        let ny = of_state + at_once + left;
        let model = random_model(nx, ny, of_state, at_once, seed);
        let point = point(ny);
        // With a cross term.
        let mixing = draws(seed, 7, nx + ny, nx + ny);
        let joint = &mixing * mixing.transpose() + DMatrix::identity(nx + ny, nx + ny);
        let noise = NoiseCovariance::new(
            &joint.view((0, 0), (nx, nx)).into_owned(),
            &joint.view((nx, nx), (ny, ny)).into_owned(),
            &joint.view((0, nx), (nx, ny)).into_owned(),
        ).unwrap();
        let built = UnknownInputObserver::kalman(&model, point.clone(), &noise);
        prop_assume!(!matches!(built, Err(FdiError::Filter(FilterError::NoSteadySolution { .. }))));
        let observer = built.unwrap();
        prop_assume!(observer.settle_samples() < 100);
        let system = observer.residual().system();
        prop_assume!(system.b().norm() < 1e4);
        let generator = ResidualGenerator::unknown_input(&model, &point, &noise).unwrap();

        prop_assert_eq!(generator.outputs().len(), left);
        let plant = model.model();
        let places: Vec<usize> = generator.outputs().iter().map(|own| {
            plant.outputs().iter().position(|output| output == own).unwrap()
        }).collect();
        let m = system.d().columns(2, ny).into_owned();
        let combination = m.select_columns(&places).try_inverse().unwrap();
        // Of columns that are furthest from each other, and of rows that are at right angles.
        let condition = combination.norm() * m.select_columns(&places).norm();

        let (u, f) = (draws(seed, 11, 2, LEN), draws(seed, 12, 1, LEN));
        let d = 1000.0 * draws(seed, 13, of_state + at_once, LEN);
        let data = record(&model, &DVector::zeros(nx), [&u, &d, &f], &point);
        let expected = &combination * observer.residuals(&data).unwrap();
        let found = generator.residuals(&data).unwrap();
        // As in the test above, of what the outputs alone would put into the residuals.
        let size = DVector::from_fn(ny, |row, _| data.y().row(row).amax());
        let through = (&combination * &m).abs() * size;
        for (row, through) in through.iter().enumerate() {
            let error = (found.row(row) - expected.row(row)).amax() / through;
            prop_assert!(error < 1e-9 * condition, "{error:e}, {condition:e}");
        }
        let covariance = KalmanFilter::new(
            generator.model().clone(),
            generator.noise().unwrap().clone(),
        ).unwrap().innovation_covariance();
        let own = observer.covariance().unwrap();
        let expected = &combination * own * combination.transpose();
        let error = (covariance - &expected).amax() / expected.amax();
        prop_assert!(error < 1e-8 * condition, "{error:e}, {condition:e}");

        // It goes into files as any filter does.
        let text = serde_json::to_string(&generator).unwrap();
        let read: ResidualGenerator = serde_json::from_str(&text).unwrap();
        prop_assert_eq!(read, generator);
    }
}

/// Noise on two of three outputs only and an input that is not known: rounding leaves no variance of
/// the form for detectors below zero, so that it exists where the observer does.
#[test]
fn an_output_without_noise_is_no_reason_to_refuse() {
    let r = DMatrix::from_diagonal(&DVector::from_vec(vec![0.0, 1.0, 2.0]));
    let noise = NoiseCovariance::new(&DMatrix::zeros(4, 4), &r, &DMatrix::zeros(4, 3)).unwrap();
    let mut made = 0;
    for seed in 0..40 {
        let model = random_model(4, 3, 1, 0, seed);
        let observer = UnknownInputObserver::kalman(&model, point(3), &noise);
        let generator = ResidualGenerator::unknown_input(&model, &point(3), &noise);
        assert_eq!(
            observer.is_ok(),
            generator.is_ok(),
            "{seed}: {:?}, {:?}",
            observer.err(),
            generator.err()
        );
        made += usize::from(generator.is_ok());
    }
    assert!(made > 30, "{made}");
}

/// What is left of a stable plant is `x2 - x1/2`, which with `x1` measured grows as
/// `0.3 + 2/2 = 1.3`. Without a sample of its own output such a filter does not predict: it begins
/// anew, and after it has settled the residuals of an exact model are zero again.
#[test]
fn a_filter_that_grows_begins_anew_after_a_gap() {
    const LEN: usize = 200;
    let plant = plant(rows([[0.5, -2.0], [0.4, 0.3]]), DMatrix::identity(2, 2));
    let disturbance = UnknownInput::of_state(rows([[1.0], [0.5]]), 2);
    let none = UnknownInput::of_state(DMatrix::zeros(2, 0), 2);
    let model = FaultModel::new(plant, disturbance, none).unwrap();
    let noise = unit_noise(2, 2);
    let generator = ResidualGenerator::unknown_input(&model, &point(2), &noise).unwrap();
    assert!((generator.model().a()[0] - 1.3).abs() < 1e-14);
    assert!(generator.model().a()[0] > MAX_PREDICTED_RADIUS);
    let own = model
        .model()
        .outputs()
        .iter()
        .position(|output| *output == generator.outputs()[0]);
    let own = own.unwrap();

    let (u, d) = (draws(3, 0, 2, LEN), draws(3, 1, 1, LEN));
    let data = record(
        &model,
        &DVector::zeros(2),
        [&u, &d, &DMatrix::zeros(0, LEN)],
        &point(2),
    );
    let mut y = data.y().clone();
    y[(own, 100)] = f64::NAN;
    let gap = Dataset::new(
        data.inputs().to_vec(),
        data.outputs().to_vec(),
        data.u().clone(),
        y,
        TS,
    )
    .unwrap();
    let residuals = generator.residuals(&gap).unwrap();
    let settled = 101 + generator.settle_samples();
    assert!(residuals[100].is_nan());
    let after = residuals.columns(settled, LEN - settled).amax();
    // The settling leaves 1e-4 of a state of some units.
    assert!(after < 1e-2, "{after:e}");
    assert!(residuals[101].abs() > 1e-3);
}

/// `x1+ = 0.9 x1 + 0.2 x2 + d`, `x2+ = 0.5 x2`, both measured: what is left is `x2` and its output.
fn two_states() -> FaultModel {
    let plant = plant(rows([[0.9, 0.2], [0.1, 0.5]]), DMatrix::identity(2, 2));
    let disturbance = UnknownInput::of_state(rows([[1.0], [0.0]]), 2);
    let fault = UnknownInput::of_output(2, rows([[0.0], [1.0]]));
    FaultModel::new(plant, disturbance, fault).unwrap()
}

/// By hand: `T = diag(0, 1)`, so `r+ ... ` has the pole that was placed, and a fault of the second
/// sensor shows as `(z - 0.5)/(z - p)`.
#[test]
fn placed_observer_settles_at_the_placed_rate() {
    const LEN: usize = 20;
    let (model, pole) = (two_states(), 0.3);
    let observer = UnknownInputObserver::placed(&model, point(2), &[pole]).unwrap();
    let system = observer.residual().system();
    assert!((system.a()[0] - pole).abs() < 1e-14, "{}", system.a());
    assert!((observer.gain().norm() - 0.2).abs() < 1e-14);
    let markov = observer.from_fault().markov_parameters(4);
    for (k, parameter) in markov.iter().enumerate() {
        let expected = if k == 0 {
            1.0
        } else {
            (pole - 0.5) * pole.powf(k as f64 - 1.0)
        };
        assert!(
            (parameter[0].abs() - f64::abs(expected)).abs() < 1e-14,
            "{k}: {parameter}"
        );
    }

    let (u, d) = (draws(3, 0, 2, LEN), draws(3, 1, 1, LEN));
    let x0 = DVector::from_vec(vec![5.0, 2.0]);
    let data = record(&model, &x0, [&u, &d, &DMatrix::zeros(1, LEN)], &point(2));
    let residuals = observer.residuals(&data).unwrap();
    for k in 0..LEN - 1 {
        let expected = 2.0 * pole.powf(k as f64);
        // Rounding of numbers round 10.
        assert!(
            (residuals[k].abs() - expected).abs() < 1e-13,
            "{k}: {residuals}"
        );
    }
    // 0.3^k < 1e-4.
    assert_eq!(observer.settle_samples(), 8);
}

/// Residuals are white with the covariance that the observer says, however large the disturbances:
/// 100 000 samples say a variance to 0.45 %, a correlation to 0.32 %.
#[test]
fn kalman_observer_has_white_residuals() {
    const LEN: usize = 100_000;
    let model = random_model(4, 4, 1, 1, 5);
    let mixing = draws(6, 0, 8, 8);
    let joint = &mixing * mixing.transpose();
    let noise = NoiseCovariance::new(
        &joint.view((0, 0), (4, 4)).into_owned(),
        &joint.view((4, 4), (4, 4)).into_owned(),
        &joint.view((0, 4), (4, 4)).into_owned(),
    );
    let observer = UnknownInputObserver::kalman(&model, point(4), &noise.unwrap()).unwrap();
    // Noise as more disturbances of known course.
    let all = UnknownInput {
        state: mixing.rows(0, 4).into_owned(),
        output: mixing.rows(4, 4).into_owned(),
    };
    let nothing = DMatrix::zeros(1, LEN);
    let plant = model.model().clone();
    let mut state = DMatrix::zeros(4, 10);
    let mut output = DMatrix::zeros(4, 10);
    for (to, disturbance, noise) in [
        (&mut state, &model.disturbance().state, &all.state),
        (&mut output, &model.disturbance().output, &all.output),
    ] {
        to.columns_mut(0, 2).copy_from(disturbance);
        to.columns_mut(2, 8).copy_from(noise);
    }
    let driven = UnknownInput { state, output };
    let simulated = FaultModel::new(plant, driven, model.fault().clone()).unwrap();
    let mut d = draws(8, 0, 10, LEN);
    d.rows_mut(0, 2).scale_mut(30.0);
    let u = draws(9, 0, 2, LEN);
    let data = record(
        &simulated,
        &DVector::zeros(4),
        [&u, &d, &nothing],
        &point(4),
    );
    let residuals = observer.residuals(&data).unwrap();
    let settled = residuals.columns(200, LEN - 200);
    let covariance = observer.covariance().unwrap();
    let scale = |i: usize, j: usize| (covariance[(i, i)] * covariance[(j, j)]).sqrt();
    for lag in 0..5 {
        let (early, late) = (
            settled.columns(0, settled.ncols() - lag),
            settled.columns(lag, settled.ncols() - lag),
        );
        let found = early * late.transpose() / early.ncols() as f64;
        for i in 0..2 {
            for j in 0..2 {
                let expected = if lag == 0 { covariance[(i, j)] } else { 0.0 };
                let error = (found[(i, j)] - expected) / scale(i, j);
                // Four standard errors and a little.
                assert!(error.abs() < 0.02, "lag {lag}, ({i}, {j}): {error}");
            }
        }
    }
}

#[test]
fn each_condition_that_fails_is_named() {
    let fault = |nx| UnknownInput::of_state(DMatrix::zeros(nx, 0), 2);
    let kalman = |a: DMatrix<f64>, c: DMatrix<f64>, e: DMatrix<f64>| {
        let (nx, ny) = (a.nrows(), c.nrows());
        let disturbance = UnknownInput::of_state(e, ny);
        let fault = if ny == 2 {
            fault(nx)
        } else {
            UnknownInput::of_state(DMatrix::zeros(nx, 0), ny)
        };
        let model = FaultModel::new(plant(a, c), disturbance, fault).unwrap();
        match UnknownInputObserver::kalman(&model, point(ny), &unit_noise(nx, ny)) {
            Err(FdiError::UnknownInput(error)) => error,
            other => panic!("{other:?}"),
        }
    };
    // The disturbance takes two steps to the outputs.
    let chain = rows([[0.5, 1.0, 0.0], [0.0, 0.5, 1.0], [0.0, 0.0, 0.5]]);
    let c = rows([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let hidden = kalman(chain.clone(), c.clone(), rows([[0.0], [0.0], [2.0]]));
    match hidden {
        UnknownInputError::HiddenDisturbance {
            expected: 1,
            found: 0,
            smallest,
            limit,
        } => assert!(smallest < 1e-15 && limit == 1e-8, "{smallest:e}"),
        other => panic!("{other:?}"),
    }
    // One of two does, and that within rounding of the limit.
    let two = rows([[1.0, 0.0], [0.0, 1e-9], [0.0, 1.0]]);
    match kalman(chain.clone(), c.clone(), two) {
        UnknownInputError::HiddenDisturbance {
            expected: 2,
            found: 1,
            smallest,
            ..
        } => {
            assert!(
                (smallest * f64::sqrt(2.0) - 1e-9).abs() < 1e-15,
                "{smallest:e}"
            );
        }
        other => panic!("{other:?}"),
    }
    // As many as outputs.
    let all = kalman(
        chain.clone(),
        c.clone(),
        rows([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]),
    );
    let expected = UnknownInputError::NoOutputLeft {
        disturbances: 2,
        outputs: 2,
    };
    assert_eq!(all, expected);
    // x2 grows and shows through x1 alone, which the disturbance hides.
    let growing = rows([[0.0, 1.0, 0.0], [0.0, 1.25, 0.0], [0.0, 0.0, 0.5]]);
    let c = rows([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    match kalman(growing.clone(), c.clone(), rows([[1.0], [0.0], [0.0]])) {
        UnknownInputError::UnstableZero {
            modulus,
            angle_rad,
            smallest,
            limit,
        } => {
            assert!((modulus - 1.25).abs() < 1e-12 && angle_rad < 1e-12);
            assert!(smallest < 1e-15 && limit == 1e-8);
        }
        other => panic!("{other:?}"),
    }
    // The same, decaying: an observer that forgets x2 at its own rate.
    let decaying = rows([[0.0, 1.0, 0.0], [0.0, 0.75, 0.0], [0.0, 0.0, 0.5]]);
    let disturbance = UnknownInput::of_state(rows([[1.0], [0.0], [0.0]]), 2);
    let model = FaultModel::new(plant(decaying, c), disturbance, fault(3)).unwrap();
    let built = UnknownInputObserver::kalman(&model, point(2), &unit_noise(3, 2)).unwrap();
    let radius = built.residual().system().spectral_radius().unwrap();
    assert!((radius - 0.75).abs() < 1e-12);
    // The poles of an output that does not show all states cannot be placed.
    let error = UnknownInputObserver::placed(&model, point(2), &[0.1, 0.2]).unwrap_err();
    assert!(matches!(error, FdiError::Unobservable { .. }), "{error:?}");
}

#[test]
fn numbers_of_poles_and_sizes_are_checked() {
    let wide = UnknownInputObserver::placed(&random_model(3, 4, 1, 0, 1), point(4), &[0.1; 2]);
    assert_eq!(wide.unwrap_err(), FdiError::OutputCount { found: 3 });
    let few = UnknownInputObserver::placed(&two_states(), point(2), &[0.1; 2]).unwrap_err();
    assert_eq!(
        few,
        FdiError::PoleCount {
            expected: 1,
            found: 2
        }
    );
    let outside = UnknownInputObserver::placed(&two_states(), point(2), &[1.5]).unwrap_err();
    assert_eq!(
        outside,
        FdiError::PoleOutside {
            index: 0,
            found: 1.5
        }
    );
    let sizes = UnknownInputObserver::kalman(&two_states(), point(2), &unit_noise(2, 3));
    assert_eq!(
        sizes.unwrap_err().to_string(),
        "rows of R (outputs): expected 2, found 3"
    );
    let other = UnknownInputObserver::placed(&two_states(), point(3), &[0.1]).unwrap_err();
    assert_eq!(
        other.to_string(),
        "inputs of the system [u; y]: expected 5, found 4"
    );
}

#[test]
fn residuals_begin_again_after_a_missing_sample_and_come_back_from_a_file() {
    const LEN: usize = 60;
    let observer = UnknownInputObserver::placed(&two_states(), point(2), &[0.3]).unwrap();
    let residual = observer.residual();
    let text = serde_json::to_string(residual).unwrap();
    let read: LinearResidual = serde_json::from_str(&text).unwrap();
    assert_eq!(&read, residual);
    let names = |signals: &[Signal]| -> Vec<String> {
        signals.iter().map(|signal| signal.name.clone()).collect()
    };
    assert_eq!(names(residual.inputs()), ["u0", "u1"]);
    assert_eq!(names(residual.outputs()), ["y0", "y1"]);

    let (u, y) = (draws(1, 0, 2, LEN), draws(2, 0, 2, LEN));
    let data = |u: &DMatrix<f64>, y: &DMatrix<f64>| {
        Dataset::new(signals("u", 2), signals("y", 2), u.clone(), y.clone(), TS).unwrap()
    };
    let whole = residual.residuals(&data(&u, &y)).unwrap();
    for (row, output) in [(0, false), (1, true)] {
        let (mut u, mut y) = (u.clone(), y.clone());
        if output {
            y[(row, 20)] = f64::NAN;
        } else {
            u[(row, 20)] = f64::INFINITY;
        }
        let gap = residual.residuals(&data(&u, &y)).unwrap();
        let missing: Vec<usize> = (0..LEN).filter(|&k| gap[k].is_nan()).collect();
        assert_eq!(missing, [20]);
        assert_eq!(gap.columns(0, 20), whole.columns(0, 20));
        let settled = 21 + residual.settle_samples();
        for k in settled..LEN {
            assert!((gap[k] - whole[k]).abs() < 1e-3);
        }
    }
    let lacking = Dataset::new(
        signals("u", 2),
        signals("y", 1),
        u,
        y.rows(0, 1).into_owned(),
        TS,
    );
    let error = residual.residuals(&lacking.unwrap()).unwrap_err();
    assert!(matches!(error, FdiError::MissingTags { .. }), "{error:?}");
    let slow = text.replace("0.3", "1.3");
    if slow != text {
        let error = serde_json::from_str::<LinearResidual>(&slow).unwrap_err();
        assert!(error.to_string().contains("stable"), "{error}");
    }
}
