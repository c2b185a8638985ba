//! Eq. 13-21: test vectors, and identities on random systems.

use gt_core::StateSpace;
use gt_ident::{CanonicalForm, Similarity};
use nalgebra::DMatrix;
use proptest::prelude::*;
use serde_json::Value;

use crate::common::*;

const SMALL_21: &str = include_str!("../../../../tests/vectors/mimo_21_small.json");
const MIXED_231_D0: &str = include_str!("../../../../tests/vectors/mimo_231_D0.json");
const MIXED_231_D1: &str = include_str!("../../../../tests/vectors/mimo_231_D1.json");
const INNOVATIONS_21: &str = include_str!("../../../../tests/vectors/ee_innovations_21.json");

/// A few dozen rounding errors of numbers around 1.
const VECTOR_TOLERANCE: f64 = 1e-12;

fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = serde_json::from_value(value.clone()).unwrap();
    DMatrix::from_fn(rows.len(), rows[0].len(), |row, column| rows[row][column])
}

fn form(vector: &Value) -> CanonicalForm {
    let field = |key: &str| vector[key].clone();
    CanonicalForm::new(
        serde_json::from_value(field("v")).unwrap(),
        serde_json::from_value(field("alpha")).unwrap(),
        serde_json::from_value(field("beta")).unwrap(),
    )
    .unwrap()
}

fn assert_close(found: &DMatrix<f64>, expected: &DMatrix<f64>, what: &str) {
    let error = largest_difference(found, expected);
    assert!(error < VECTOR_TOLERANCE, "{what}: off by {error:e}");
}

fn check_vector(text: &str) {
    let vector: Value = serde_json::from_str(text).unwrap();
    let form = form(&vector);
    let model = state_space(&form);
    assert_close(model.a(), &matrix(&vector["A"]), "A");
    assert_close(model.b(), &matrix(&vector["B"]), "B");
    assert_close(model.c(), &matrix(&vector["C"]), "C");
    assert_close(&form.l_matrix(), &matrix(&vector["L"]), "L");
    if vector.get("M").is_some() {
        assert_close(&form.m_matrix(), &matrix(&vector["M"]), "M");
    }
    if vector.get("D").is_some() {
        assert_close(model.d(), &matrix(&vector["D"]), "D");
    }
    if let Some(list) = vector.get("markov").and_then(Value::as_array) {
        let found = model.markov_parameters(list.len());
        for (index, expected) in list.iter().enumerate() {
            assert_close(&found[index], &matrix(expected), "Markov parameter");
        }
    }
    if let Some(expected) = vector.get("impulse_response") {
        let expected = matrix(expected).transpose();
        let mut u = DMatrix::zeros(1, expected.ncols());
        u[(0, 0)] = 1.0;
        let found = model.simulate(&zero_state(&model), &u).unwrap();
        assert_close(&found, &expected, "impulse response");
        let e = DMatrix::zeros(form.ny(), u.ncols());
        assert_close(
            &difference_equation(&form, &u, &e),
            &expected,
            "difference equation",
        );
    }
    if vector.get("K").is_some() {
        assert_close(&form.equation_error_gain(), &matrix(&vector["K"]), "K");
    }
    let back = CanonicalForm::from_state_space(&model).unwrap();
    let error = largest_form_difference(&back, &form);
    assert!(error < VECTOR_TOLERANCE, "back again: off by {error:e}");
}

#[test]
fn published_vector_21_with_a_term_at_lag_zero() {
    check_vector(SMALL_21);
}

#[test]
fn published_vector_231_mixed_indices() {
    check_vector(MIXED_231_D0);
}

#[test]
fn published_vector_231_mixed_indices_with_feedthrough() {
    check_vector(MIXED_231_D1);
}

#[test]
fn published_vector_of_the_equation_error_gain() {
    check_vector(INNOVATIONS_21);
}

/// `A - K C_e` of the form that has `y = C x + L^-1 e`.
fn estimator(form: &CanonicalForm, model: &StateSpace) -> DMatrix<f64> {
    model.a() - form.equation_error_gain() * form.l_matrix() * model.c()
}

/// Index sets: generic ones, growing ones (terms at lag 0), and single outputs.
fn index_set() -> impl Strategy<Value = Vec<usize>> {
    prop::sample::select(vec![
        vec![1],
        vec![3],
        vec![5],
        vec![1, 1],
        vec![2, 1],
        vec![1, 3],
        vec![3, 1],
        vec![2, 3, 1],
        vec![1, 2, 3],
        vec![3, 2, 1],
        vec![2, 2, 2, 1],
        vec![4, 1, 3, 2],
    ])
}

proptest! {
    #![proptest_config(crate::common::cases(200))]

    /// Random coefficients of size 1 amplify rounding by cond(M), below 1e5 at these orders.
    #[test]
    fn prop_canonical_form_to_state_space_and_back(
        v in index_set(), nu in 1_usize..4, direct: bool, seed: u64,
    ) {
        let form = random_form(&mut generator(seed), &v, nu, direct);
        let model = state_space(&form);
        prop_assert_eq!(model.nx(), v.iter().sum::<usize>());
        let back = CanonicalForm::from_state_space(&model).unwrap();
        prop_assert_eq!(back.feedthrough(), direct);
        prop_assert!(largest_form_difference(&back, &form) < 1e-9);
    }

    /// Stable systems: rounding errors do not grow over the record.
    #[test]
    fn prop_realisation_gives_the_outputs_of_the_difference_equation(
        v in index_set(), nu in 1_usize..4, direct: bool, seed: u64,
    ) {
        let mut rng = generator(seed);
        let form = random_form(&mut rng, &v, nu, direct);
        let u = normal_matrix(&mut rng, nu, 120);
        let expected = difference_equation(&form, &u, &DMatrix::zeros(v.len(), 120));
        let model = state_space(&form);
        let found = model.simulate(&zero_state(&model), &u).unwrap();
        prop_assert!(largest_difference(&found, &expected) < 1e-9 * expected.amax().max(1.0));
    }

    /// The innovations form: driven by u and e together it gives eq. 7 with its error, and its
    /// estimator is nilpotent.
    #[test]
    fn prop_equation_error_gain_gives_the_outputs_of_the_difference_equation(
        v in index_set(), direct: bool, seed: u64,
    ) {
        let (nu, ny, samples) = (2, v.len(), 80);
        let mut rng = generator(seed);
        let form = random_form(&mut rng, &v, nu, direct);
        let u = normal_matrix(&mut rng, nu, samples);
        let e = normal_matrix(&mut rng, ny, samples);
        let expected = difference_equation(&form, &u, &e);
        let model = state_space(&form);
        let mut x = zero_state(&model);
        let (k, direct_gain) = (form.equation_error_gain(), form.equation_error_direct());
        for t in 0..samples {
            let y = model.c() * &x + model.d() * u.column(t) + &direct_gain * e.column(t);
            let error = (y - expected.column(t)).amax();
            prop_assert!(error < 1e-9 * expected.amax().max(1.0), "sample {}: {:e}", t, error);
            x = model.a() * &x + model.b() * u.column(t) + &k * e.column(t);
        }
        let mut power = DMatrix::identity(model.nx(), model.nx());
        for _ in 0..model.nx() {
            power = estimator(&form, &model) * power;
        }
        prop_assert!(power.amax() < 1e-9, "estimator^n = {:e}", power.amax());
    }

    /// LU of a matrix with entries of size 1 and determinant 1.
    #[test]
    fn prop_determinant_of_m_is_one(v in index_set(), seed: u64) {
        let form = random_form(&mut generator(seed), &v, 1, false);
        let m = form.m_matrix();
        prop_assert!((m.determinant().abs() - 1.0).abs() < 1e-9);
        let l = form.l_matrix();
        prop_assert!((0..v.len()).all(|i| l[(i, i)] == 1.0 && (i + 1..v.len()).all(|j| l[(i, j)] == 0.0)));
    }

    /// A similarity of condition below 20 costs two digits, the observability matrix some more.
    #[test]
    fn prop_similarity_is_undone_by_the_canonical_form(
        v in prop::sample::select(vec![
            vec![1], vec![3], vec![2, 1], vec![1, 1, 1], vec![2, 2], vec![1, 2], vec![2, 1, 1],
            vec![1, 3], vec![2, 3, 1],
        ]),
        direct: bool,
        seed: u64,
    ) {
        let mut rng = generator(seed);
        let form = random_form(&mut rng, &v, 2, direct);
        let model = state_space(&form);
        let n = model.nx();
        // Q + 0.3 noise / sqrt(n): close to orthogonal, so well-conditioned.
        let noise = normal_matrix(&mut rng, n, n) * (0.3 / (n as f64).sqrt());
        let t = normal_matrix(&mut rng, n, n).qr().q() + noise;
        let inverse = t.clone().try_inverse().unwrap();
        let singular = t.singular_values();
        prop_assume!(singular.max() / singular.min() < 20.0);
        let turned = StateSpace::new(
            [&t * model.a() * &inverse, &t * model.b(), model.c() * &inverse, model.d().clone()],
            1.0,
            model.inputs().to_vec(),
            model.outputs().to_vec(),
        )
        .unwrap();
        let similarity = Similarity::new(&turned).unwrap();
        let error = largest_form_difference(&similarity.form, &form);
        prop_assert!(error < 1e-9, "{:e}", error);
        prop_assert!(largest_difference(&similarity.transformation, &inverse) < 1e-9);
        prop_assert!(similarity.smallest_accepted > similarity.largest_rejected);
    }
}
