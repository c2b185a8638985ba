//! Pole placement.

use gt_core::{ModelError, Signal, StateSpace};
use gt_fdi::FdiError;
use gt_fdi::design::{MAX_OBSERVABILITY_CONDITION, place};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use crate::fixtures::{TS, canonical, monic, plain_model, transformed};

fn model(a: &[f64], c: &[f64]) -> Result<StateSpace, ModelError> {
    let nx = c.len();
    StateSpace::new(
        [
            DMatrix::from_row_slice(nx, nx, a),
            DMatrix::zeros(nx, 0),
            DMatrix::from_row_slice(1, nx, c),
            DMatrix::zeros(1, 0),
        ],
        TS,
        vec![],
        Signal::named(&["y"]),
    )
}

/// Position and velocity seen through the position: `|zI - A + K C|` is
/// `z^2 + (k1 - 2) z + 1 - k1 + k2`, so poles p, p need `K = [2 (1 - p), (1 - p)^2]`.
#[test]
fn double_integrator_has_the_gain_found_by_hand() {
    let model = model(&[1.0, 1.0, 0.0, 1.0], &[1.0, 0.0]).unwrap();
    for pole in [0.0, 0.25, 0.5, -0.5] {
        let gain = place(&model, &[pole, pole]).unwrap();
        let expected = DVector::from_vec(vec![2.0 * (1.0 - pole), (1.0 - pole).powi(2)]);
        // The poles and gains are short binary fractions: rounding only in the 2 x 2 solves.
        assert!((&gain - expected).amax() < 1e-14, "{gain}");
    }
}

/// In canonical form the gain is found by substitution alone: the first Markov parameter of K is
/// the difference of the sums of the poles.
#[test]
fn canonical_model_needs_no_transformation() {
    let gain = place(&plain_model("y"), &[0.5, 0.25]).unwrap();
    // p = z^2 - 1.5 z + 0.54, d = z^2 - 0.75 z + 0.125: k1 = 0.75, k2 = 0.125 - 0.54 + 1.5 k1.
    assert!(
        (gain[0] - 0.75).abs() < 1e-15 && (gain[1] - 0.71).abs() < 1e-15,
        "{gain}"
    );
}

#[test]
fn a_model_without_states_has_an_empty_gain() {
    assert_eq!(place(&model(&[], &[]).unwrap(), &[]).unwrap().len(), 0);
}

#[test]
fn errors_name_what_was_expected_and_found() {
    let second = plain_model("y");
    assert_eq!(
        place(&second, &[0.1]),
        Err(FdiError::PoleCount {
            expected: 2,
            found: 1
        })
    );
    for found in [1.0, -1.0, 1.5, f64::INFINITY] {
        let error = place(&second, &[0.1, found]);
        assert_eq!(error, Err(FdiError::PoleOutside { index: 1, found }));
    }
    let nan = place(&second, &[f64::NAN, 0.1]);
    assert!(
        matches!(nan, Err(FdiError::PoleOutside { index: 0, .. })),
        "{nan:?}"
    );

    let two = StateSpace::new(
        [
            DMatrix::zeros(1, 1),
            DMatrix::zeros(1, 0),
            DMatrix::zeros(2, 1),
            DMatrix::zeros(2, 0),
        ],
        TS,
        vec![],
        Signal::named(&["y", "z"]),
    );
    assert_eq!(
        place(&two.unwrap(), &[0.0]),
        Err(FdiError::OutputCount { found: 2 })
    );
}

#[test]
fn unobservable_models_are_refused_with_their_condition() {
    let hidden = model(&[0.5, 0.0, 0.0, 0.25], &[1.0, 0.0]).unwrap();
    let expected = FdiError::Unobservable {
        output: "y".to_owned(),
        condition: f64::INFINITY,
        limit: MAX_OBSERVABILITY_CONDITION,
    };
    assert_eq!(place(&hidden, &[0.1, 0.1]), Err(expected));

    // One mode seen 1e-13 times as well as the other: condition 2.2e13 and not infinite.
    let nearly = model(&[0.5, 0.0, 0.0, 0.25], &[1.0, 1e-13]).unwrap();
    match place(&nearly, &[0.1, 0.1]) {
        Err(FdiError::Unobservable { condition, .. }) => {
            assert!(condition > 1e13 && condition < 1e14, "{condition}");
        }
        other => panic!("{other:?}"),
    }
    // The same pair seen a hundred times better is placed.
    let seen = model(&[0.5, 0.0, 0.0, 0.25], &[1.0, 1e-11]).unwrap();
    assert!(place(&seen, &[0.1, 0.1]).is_ok());
}

#[test]
fn overflow_in_the_observability_matrix_is_an_error() {
    let huge = model(&[1e300, 1.0, 1.0, 1e300], &[1.0, 1.0]).unwrap();
    assert!(matches!(
        place(&huge, &[0.1, 0.1]),
        Err(FdiError::Unobservable { .. })
    ));
}

proptest! {
    /// The characteristic polynomial of `A - K C` is the desired one, in any coordinates; read off
    /// by Faddeev and Leverrier, which the code under test does not use.
    #[test]
    fn prop_closed_loop_has_the_desired_polynomial(
        open in prop::collection::vec(-0.95_f64..0.99, 1..6),
        seed in any::<u64>(),
        repeated in -0.5_f64..0.9,
    ) {
        let nx = open.len();
        let canonical =
            canonical(&open, DMatrix::zeros(nx, 0), DMatrix::zeros(1, 0), "y");
        let draws = crate::fixtures::noise(seed, nx * nx);
        let t = DMatrix::identity(nx, nx) + 0.2 * DMatrix::from_vec(nx, nx, draws);
        prop_assume!(t.clone().try_inverse().is_some_and(|inverse| inverse.norm() < 20.0));
        let model = transformed(&canonical, &t);
        let poles = vec![repeated; nx];
        let gain = place(&model, &poles).unwrap();
        let closed = model.a() - gain * model.c();
        let found = faddeev_leverrier(&closed);
        for (l, (found, expected)) in found.iter().zip(monic(&poles)).enumerate() {
            // Rounding of the gain, enlarged by T (its inverse has a norm of up to 20) and by fifth
            // powers in the check: up to 4e-9 among 20 000 cases. Coefficients are below 30.
            prop_assert!((found - expected).abs() < 1e-7, "z^{l}: {found} {expected}");
        }
    }
}

/// Coefficients of `|zI - A|`, that of `z^l` at index `l`.
fn faddeev_leverrier(a: &DMatrix<f64>) -> Vec<f64> {
    let nx = a.nrows();
    let mut coefficients = vec![1.0; nx + 1];
    let mut auxiliary = DMatrix::zeros(nx, nx);
    for k in 1..=nx {
        auxiliary = a * auxiliary + DMatrix::identity(nx, nx) * coefficients[nx + 1 - k];
        coefficients[nx - k] = -(a * &auxiliary).trace() / k as f64;
    }
    coefficients
}
