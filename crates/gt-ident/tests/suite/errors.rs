//! Every way to ask for the impossible, with the exact error.

use gt_core::{DataError, Dataset, DimensionError, Signal};
use gt_ident::{
    Arx, ArxModel, ArxStructure, CanonicalForm, IdentError, OrderKind, Similarity, generic_indices,
    order_table, validate,
};
use nalgebra::DMatrix;

use crate::common::*;

/// Two inputs, two outputs, `samples` columns of white noise.
fn noise(samples: usize) -> Dataset {
    let mut rng = generator(1);
    let (u, y) = (
        normal_matrix(&mut rng, 2, samples),
        normal_matrix(&mut rng, 2, samples),
    );
    Dataset::new(signals("u", 2), signals("y", 2), u, y, 0.5).unwrap()
}

/// The same record after a change of its matrices.
fn changed(data: &Dataset, change: impl Fn(&mut DMatrix<f64>, &mut DMatrix<f64>)) -> Dataset {
    let (mut u, mut y) = (data.u().clone(), data.y().clone());
    change(&mut u, &mut y);
    let (inputs, outputs) = (data.inputs().to_vec(), data.outputs().to_vec());
    Dataset::new(inputs, outputs, u, y, data.sample_time_s()).unwrap()
}

fn full(na: usize, nb: &[usize], nk: &[usize]) -> ArxStructure {
    ArxStructure::Full {
        na,
        nb: nb.to_vec(),
        nk: nk.to_vec(),
    }
}

fn diagonal(na: usize, nb: &[usize], nk: &[usize]) -> ArxStructure {
    ArxStructure::Diagonal {
        na,
        nb: nb.to_vec(),
        nk: nk.to_vec(),
    }
}

fn canonical(indices: &[usize]) -> ArxStructure {
    ArxStructure::Canonical {
        indices: indices.to_vec(),
        feedthrough: false,
    }
}

fn refused(structure: ArxStructure, data: &Dataset) -> IdentError {
    Arx::new(structure).fit(data).unwrap_err()
}

fn fitted() -> ArxModel {
    Arx::new(full(2, &[1], &[1])).fit(&noise(100)).unwrap()
}

#[test]
fn structures_that_do_not_fit_the_record() {
    let data = noise(100);
    assert_eq!(
        refused(full(1, &[1, 1, 1], &[1]), &data),
        IdentError::OptionLength {
            option: "nb",
            inputs: 2,
            found: 3
        }
    );
    assert_eq!(
        refused(diagonal(1, &[1], &[]), &data).to_string(),
        "option nk: expected 1 entry or 2 (one per input), found 0"
    );
    assert_eq!(
        refused(full(0, &[0, 0], &[1]), &data).to_string(),
        "structure full na=0 nb=0,0 nk=1: expected na >= 1 or some nb >= 1 with an input, found \
         neither"
    );
    assert_eq!(
        refused(canonical(&[1, 1, 1]), &data),
        IdentError::IndexCount {
            expected: 2,
            found: 3
        }
    );
    assert_eq!(
        refused(canonical(&[2, 0]), &data),
        IdentError::IndexZero { output: 1 }
    );
    let no_inputs = data.select::<&str, &str>(&[], &["y1"]).unwrap();
    assert!(matches!(
        refused(full(0, &[2], &[1]), &no_inputs),
        IdentError::NoTerms { .. }
    ));
    let no_outputs = data.select::<&str, &str>(&["u1"], &[]).unwrap();
    assert_eq!(
        refused(full(1, &[2], &[1]), &no_outputs),
        IdentError::NoOutputs
    );
}

#[test]
fn a_record_that_is_too_short_names_what_it_takes() {
    // Longest lag 3 (nk = 2, nb = 2), 2 * 1 + 2 * 2 = 6 coefficients a row, one row to spare.
    let structure = full(1, &[2], &[2]);
    assert!(Arx::new(structure.clone()).fit(&noise(10)).is_ok());
    assert_eq!(
        refused(structure.clone(), &noise(9)).to_string(),
        "samples: expected at least 10 for full na=1 nb=2 nk=2, found 9"
    );
    let later = Arx::new(structure)
        .first_row(5)
        .fit(&noise(11))
        .unwrap_err();
    assert!(matches!(
        later,
        IdentError::TooFewRows {
            needed: 12,
            found: 11,
            ..
        }
    ));
    // Sizes that no memory holds are refused as well.
    for huge in [
        full(usize::MAX, &[1], &[1]),
        diagonal(1, &[usize::MAX], &[usize::MAX]),
        canonical(&[usize::MAX, usize::MAX]),
        full(1, &[1], &[usize::MAX]),
    ] {
        let error = refused(huge, &noise(50));
        assert!(
            matches!(
                error,
                IdentError::TooFewRows {
                    needed: usize::MAX,
                    found: 50,
                    ..
                }
            ),
            "{error}"
        );
    }
    let model = fitted();
    let short = noise(2);
    for error in [
        model.predict(&short).unwrap_err(),
        model.simulate(&short).unwrap_err(),
    ] {
        assert!(
            matches!(
                error,
                IdentError::TooFewRows {
                    needed: 3,
                    found: 2,
                    ..
                }
            ),
            "{error}"
        );
    }
    let error = validate(&model, &noise(3)).unwrap_err();
    assert!(
        matches!(
            error,
            IdentError::TooFewRows {
                needed: 4,
                found: 3,
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn constant_channels_are_named() {
    let still_input = changed(&noise(60), |u, _| u.row_mut(1).fill(0.1));
    let expected = IdentError::ConstantChannel {
        channel: "u2".into(),
        value: 0.1,
    };
    assert_eq!(refused(full(1, &[1], &[1]), &still_input), expected);
    let kind = OrderKind::Full { nk: vec![1] };
    assert_eq!(
        order_table(&still_input, 1..=2, &kind).unwrap_err(),
        expected
    );
    // An input that the structure leaves out may stand still.
    assert!(Arx::new(full(1, &[1, 0], &[1])).fit(&still_input).is_ok());
    let still_output = changed(&noise(60), |_, y| y.row_mut(0).fill(-3.0));
    assert_eq!(
        refused(diagonal(1, &[1], &[1]), &still_output).to_string(),
        "channel `y1`: expected a signal that varies, found -3 in every row used"
    );
    assert_eq!(
        validate(&fitted(), &still_output).unwrap_err(),
        IdentError::ConstantChannel {
            channel: "y1".into(),
            value: -3.0
        }
    );
}

#[test]
fn samples_that_are_not_finite_are_named() {
    let holed = changed(&noise(60), |_, y| y[(1, 17)] = f64::INFINITY);
    let expected = IdentError::Data(DataError::NotFinite {
        channel: "y2".into(),
        sample: 17,
        found: f64::INFINITY,
    });
    assert_eq!(refused(full(1, &[1], &[1]), &holed), expected);
    let model = fitted();
    assert_eq!(model.predict(&holed).unwrap_err(), expected);
    assert_eq!(model.equation_error(&holed).unwrap_err(), expected);
    assert_eq!(model.simulate(&holed).unwrap_err(), expected);
    assert_eq!(validate(&model, &holed).unwrap_err(), expected);
    let kind = OrderKind::Full { nk: vec![1] };
    assert_eq!(order_table(&holed, 1..=2, &kind).unwrap_err(), expected);
    let nan = changed(&noise(60), |u, _| u[(0, 3)] = f64::NAN);
    assert_eq!(
        refused(full(1, &[1], &[1]), &nan).to_string(),
        "channel `u1`, sample 3: expected a finite number, found NaN"
    );
}

/// The column blamed is the first that those before it explain.
#[track_caller]
fn assert_dependent(error: &IdentError, expected: (&str, &str, usize)) {
    let IdentError::RankDeficient {
        output,
        channel,
        lag,
        condition,
        limit,
        ..
    } = error
    else {
        panic!("{error}");
    };
    assert_eq!((output.as_str(), channel.as_str(), *lag), expected);
    assert!(*limit == 1e12 && *condition > *limit);
}

#[test]
fn dependent_regressors_are_named() {
    let twice = changed(&noise(60), |u, _| {
        let copy = u.row(0) * 2.0;
        u.set_row(1, &copy);
    });
    assert_dependent(&refused(full(1, &[2], &[1]), &twice), ("y1", "u2", 1));
    // An output that repeats an input.
    let echo = changed(&noise(60), |u, y| y.set_row(1, &u.row(0)));
    assert_dependent(&refused(full(1, &[1], &[1]), &echo), ("y1", "u1", 1));
    // A pulse that is over before the regression begins: its lags are equal in every row used.
    let pulse = changed(&noise(60), |u, _| {
        u.row_mut(1).fill(0.0);
        u[(1, 0)] = 1.0;
    });
    assert_dependent(&refused(full(8, &[2], &[0]), &pulse), ("y1", "u2", 1));
}

#[test]
fn numbers_that_overflow_are_refused() {
    let huge = changed(&noise(60), |_, y| *y *= 1e300);
    let error = refused(full(1, &[1], &[1]), &huge);
    assert_eq!(
        error,
        IdentError::ModelValue {
            what: "row 0, residual variance".into(),
            expected: "a finite number of at least 0",
            found: f64::INFINITY,
        }
    );
    let vast = changed(&noise(60), |u, _| *u *= 1e308);
    assert!(Arx::new(full(1, &[1], &[1])).fit(&vast).is_err());
}

#[test]
fn records_of_another_plant_are_refused() {
    let model = fitted();
    let data = noise(50);
    let rebuilt = |inputs: Vec<Signal>, outputs: Vec<Signal>, sample_time_s: f64| {
        let (u, y) = (data.u().clone(), data.y().clone());
        Dataset::new(inputs, outputs, u, y, sample_time_s).unwrap()
    };
    let error = |data: &Dataset| model.predict(data).unwrap_err();
    assert_eq!(
        error(&data.select(&["u1"], &["y1", "y2"]).unwrap()).to_string(),
        "inputs of the record: expected 2, found 1"
    );
    assert_eq!(
        error(&data.select(&["u1", "u2"], &["y1"]).unwrap()).to_string(),
        "outputs of the record: expected 2, found 1"
    );
    assert_eq!(
        error(&data.select(&["u2", "u1"], &["y1", "y2"]).unwrap()).to_string(),
        "input 0: expected channel `u1`, found `u2`"
    );
    assert_eq!(
        error(&data.select(&["u1", "u2"], &["y2", "y1"]).unwrap()).to_string(),
        "output 0: expected channel `y1`, found `y2`"
    );
    assert_eq!(
        error(&rebuilt(signals("u", 2), signals("y", 2), 0.25)),
        IdentError::SampleTime {
            expected: 0.5,
            found: 0.25
        }
    );
    let pascal = vec![Signal::new("y1", "Pa"), Signal::new("y2", "")];
    let bar = vec![Signal::new("y1", "bar"), Signal::new("y2", "")];
    let with_unit = Arx::new(full(1, &[1], &[1]))
        .fit(&rebuilt(signals("u", 2), pascal, 0.5))
        .unwrap();
    let found = with_unit
        .simulate(&rebuilt(signals("u", 2), bar, 0.5))
        .unwrap_err();
    assert_eq!(
        found.to_string(),
        "channel `y1`: expected unit `Pa`, found `bar`"
    );
}

#[test]
fn outputs_and_orders_out_of_range() {
    let model = fitted();
    assert_eq!(
        model.output_model(2).unwrap_err(),
        IdentError::NoSuchOutput {
            found: 2,
            outputs: 2
        }
    );
    assert_eq!(generic_indices(3, 0).unwrap_err(), IdentError::NoOutputs);
    assert_eq!(
        generic_indices(2, 3).unwrap_err(),
        IdentError::OrderTooSmall {
            order: 2,
            outputs: 3
        }
    );
    let data = noise(40);
    let canonical = OrderKind::Canonical { feedthrough: false };
    assert_eq!(
        order_table(&data, 1..=4, &canonical).unwrap_err(),
        IdentError::OrderTooSmall {
            order: 1,
            outputs: 2
        }
    );
    let kind = OrderKind::Full { nk: vec![1] };
    assert_eq!(
        order_table(&data, 0..=4, &kind).unwrap_err(),
        IdentError::OrderRange { first: 0, last: 4 }
    );
    #[allow(clippy::reversed_empty_ranges, reason = "that is the error under test")]
    let reversed = 3..=2;
    assert_eq!(
        order_table(&data, reversed, &kind).unwrap_err().to_string(),
        "orders 3..=2: expected a non-empty range that starts at 1 or above"
    );
    // Order 8: longest lag 8 and 32 coefficients a row.
    let error = order_table(&data, 1..=8, &kind).unwrap_err();
    assert!(
        matches!(
            error,
            IdentError::TooFewRows {
                needed: 41,
                found: 40,
                ..
            }
        ),
        "{error}"
    );
    let wrong = OrderKind::Full { nk: vec![1, 1, 1] };
    assert_eq!(
        order_table(&data, 1..=2, &wrong).unwrap_err(),
        IdentError::OptionLength {
            option: "nk",
            inputs: 2,
            found: 3
        }
    );
    let twice = changed(&data, |u, _| {
        let copy = u.row(0).into_owned();
        u.set_row(1, &copy);
    });
    assert_dependent(
        &order_table(&twice, 1..=2, &kind).unwrap_err(),
        ("y1", "u2", 1),
    );
}

#[test]
fn generic_indices_differ_by_one_at_most() {
    assert_eq!(generic_indices(7, 3).unwrap(), [3, 2, 2]);
    assert_eq!(generic_indices(6, 3).unwrap(), [2, 2, 2]);
    assert_eq!(generic_indices(3, 3).unwrap(), [1, 1, 1]);
    let mut rng = generator(2);
    let (u, y) = (
        normal_matrix(&mut rng, 1, 100),
        normal_matrix(&mut rng, 3, 100),
    );
    let data = Dataset::new(signals("u", 1), signals("y", 3), u, y, 1.0).unwrap();
    // v_ij = min(v_i + 1, v_j) exceeds v_i where an output before has the larger index: only
    // orders that the outputs share evenly have no term at lag 0.
    for order in 3..20 {
        let model = Arx::new(canonical(&generic_indices(order, 3).unwrap()))
            .fit(&data)
            .unwrap();
        let lag_zero = model
            .rows()
            .iter()
            .flat_map(|row| &row.terms)
            .any(|term| term.lag == 0);
        assert_eq!(lag_zero, order % 3 != 0, "order {order}");
    }
    // Section 1 of the specification: (2, 3, 1) with two inputs has 28 coefficients.
    assert_eq!(canonical(&[2, 3, 1]).parameters(2, 3), 28);
}

#[test]
fn options_are_read_strictly() {
    let read = |text: &str| serde_json::from_str::<ArxStructure>(text);
    let structure = read(r#"{"diagonal": {"na": 2, "nb": [2], "nk": [1]}}"#).unwrap();
    assert_eq!(structure, diagonal(2, &[2], &[1]));
    assert_eq!(structure.to_string(), "diagonal na=2 nb=2 nk=1");
    let structure = read(r#"{"canonical": {"indices": [2, 1], "feedthrough": true}}"#).unwrap();
    assert_eq!(structure.to_string(), "canonical v=(2,1) with feedthrough");
    let error = read(r#"{"full": {"na": 2, "nb": [2], "nk": [1], "ridge": 1}}"#).unwrap_err();
    assert!(
        error.to_string().starts_with("unknown field `ridge`"),
        "{error}"
    );
    assert!(read(r#"{"full": {"na": 2, "nb": [2]}}"#).is_err());
}

#[test]
fn canonical_forms_of_wrong_size() {
    let form = |v: &[usize], alpha: Vec<Vec<Vec<f64>>>, beta: Vec<Vec<Vec<f64>>>| {
        CanonicalForm::new(v.to_vec(), alpha, beta).unwrap_err()
    };
    assert_eq!(form(&[], vec![], vec![]), IdentError::NoOutputs);
    assert_eq!(
        form(&[0], vec![vec![vec![]]], vec![vec![]]),
        IdentError::IndexZero { output: 0 }
    );
    let size = |what: &str, expected, found| {
        IdentError::Dimension(DimensionError {
            what: what.into(),
            expected,
            found,
        })
    };
    assert_eq!(
        form(
            &[2],
            vec![vec![vec![0.1]]],
            vec![vec![vec![1.0], vec![1.0]]]
        ),
        size("alpha[0][0]", 2, 1)
    );
    assert_eq!(
        form(&[1], vec![], vec![vec![vec![1.0]]]),
        size("rows of alpha (outputs)", 1, 0)
    );
    assert_eq!(
        form(&[1], vec![vec![vec![0.5]]], vec![]),
        size("rows of beta (outputs)", 1, 0)
    );
    assert_eq!(
        form(&[1], vec![vec![]], vec![vec![vec![1.0]]]),
        size("columns of alpha, row 0", 1, 0)
    );
    let three = vec![vec![vec![1.0]; 3]];
    assert_eq!(
        form(&[1], vec![vec![vec![0.5]]], three),
        size("beta[0]", 2, 3)
    );
    let ragged = vec![vec![vec![1.0], vec![]]];
    assert_eq!(
        form(&[1], vec![vec![vec![0.5]]], ragged),
        size("beta[0][1] (inputs)", 1, 0)
    );
    assert_eq!(
        form(&[1], vec![vec![vec![0.5]]], vec![vec![vec![f64::INFINITY]]]).to_string(),
        "beta: expected a finite number, found inf"
    );
    let strict = r#"{"indices": [1], "alpha": [[[0.5]]], "beta": [[[1.0]]], "gamma": 1}"#;
    assert!(serde_json::from_str::<CanonicalForm>(strict).is_err());
}

fn model(a: DMatrix<f64>, c: DMatrix<f64>) -> gt_core::StateSpace {
    let (nx, ny) = (a.nrows(), c.nrows());
    let (b, d) = (DMatrix::from_element(nx, 1, 1.0), DMatrix::zeros(ny, 1));
    gt_core::StateSpace::new([a, b, c, d], 1.0, signals("u", 1), signals("y", ny)).unwrap()
}

#[test]
fn state_space_models_that_are_not_canonical() {
    let refused = |a: &[f64], c: &[f64]| {
        let c = DMatrix::from_row_slice(c.len() / 3, 3, c);
        CanonicalForm::from_state_space(&model(DMatrix::from_row_slice(3, 3, a), c)).unwrap_err()
    };
    let good_a = [0.0, 1.0, 0.0, 0.2, 0.3, 0.1, 0.1, 0.0, 0.5];
    let fault = |matrix, row, column, expected, found| IdentError::NotCanonical {
        matrix,
        row,
        column,
        expected,
        found,
    };
    assert_eq!(
        refused(&good_a, &[0.0, 1.0, 0.0]),
        fault('C', 0, 0, 1.0, 0.0)
    );
    assert_eq!(
        refused(&good_a, &[1.0, 0.0, 0.0, 0.0, 0.0, 2.0]),
        fault('C', 1, 1, 1.0, 0.0)
    );
    assert_eq!(
        refused(&good_a, &[1.0, 0.0, 0.5, 0.0, 0.0, 1.0]),
        fault('C', 0, 2, 0.0, 0.5)
    );
    let (mut shifted, mut extra) = (good_a, good_a);
    shifted[1] = 0.9;
    assert_eq!(
        refused(&shifted, &[1.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
        fault('A', 0, 1, 1.0, 0.9)
    );
    // v = (1, 2): v_12 = 1 leaves A(0, 2) zero.
    extra = [0.1, 0.2, 0.3, 0.0, 0.0, 1.0, extra[6], 0.0, 0.5];
    assert_eq!(
        refused(&extra, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
        fault('A', 0, 2, 0.0, 0.3)
    );
    let no_state = model(DMatrix::zeros(0, 0), DMatrix::zeros(1, 0));
    assert_eq!(
        CanonicalForm::from_state_space(&no_state).unwrap_err(),
        IdentError::IndexZero { output: 0 }
    );
    let more_outputs = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
    assert_eq!(
        refused(&good_a, &more_outputs),
        IdentError::IndexZero { output: 3 }
    );
}

#[test]
fn models_without_a_canonical_form() {
    let hidden = model(
        DMatrix::from_diagonal_element(3, 3, 0.5),
        DMatrix::from_row_slice(2, 3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
    );
    assert_eq!(
        Similarity::new(&hidden).unwrap_err(),
        IdentError::NotObservable {
            expected: 3,
            found: 2
        }
    );
    let doubled = model(
        DMatrix::from_row_slice(2, 2, &[0.5, 1.0, 0.0, 0.3]),
        DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 3.0, 0.0]),
    );
    assert_eq!(
        Similarity::new(&doubled).unwrap_err(),
        IdentError::IndexZero { output: 1 }
    );
    let empty = model(DMatrix::zeros(0, 0), DMatrix::zeros(1, 0));
    assert_eq!(
        Similarity::new(&empty).unwrap_err(),
        IdentError::IndexZero { output: 0 }
    );
    let static_model = Arx::new(full(0, &[1], &[0])).fit(&noise(30)).unwrap();
    assert_eq!(
        static_model.canonical_form().unwrap_err(),
        IdentError::IndexZero { output: 0 }
    );
}

#[test]
fn realisations_beyond_all_measure_are_refused() {
    let model = fitted();
    let mut value = serde_json::to_value(&model).unwrap();
    value["structure"]["full"]["nk"] = serde_json::json!([3_000]);
    for row in 0..2 {
        for term in 4..6 {
            value["rows"][row]["terms"][term]["lag"] = 3_000.into();
        }
    }
    let late: ArxModel = serde_json::from_value(value).unwrap();
    let error = IdentError::TooManyStates {
        limit: 5000,
        found: 6000,
        max_lag: 3000,
    };
    assert_eq!(late.state_space().unwrap_err(), error);
    assert_eq!(late.canonical_form().unwrap_err(), error);
    assert_eq!(late.output_model(0).unwrap().model.nx(), 3000);
}
