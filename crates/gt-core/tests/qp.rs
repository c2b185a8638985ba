//! Quadratic programmes: optimality conditions on random problems, and every refusal.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test may stop where it fails"
)]

use gt_core::DimensionError;
use gt_core::qp::{QpError, QuadraticProgram};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use proptest::test_runner::Config;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

fn normal(rng: &mut ChaCha8Rng, rows: usize, columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |_, _| rng.sample(StandardNormal))
}

fn vector(rng: &mut ChaCha8Rng, rows: usize) -> DVector<f64> {
    DVector::from_fn(rows, |_, _| rng.sample(StandardNormal))
}

fn vec_of(values: &[f64]) -> DVector<f64> {
    DVector::from_column_slice(values)
}

fn rows_of(rows: &[[f64; 2]]) -> DMatrix<f64> {
    DMatrix::from_row_slice(rows.len(), 2, rows.as_flattened())
}

proptest! {
    #![proptest_config(Config { cases: 200, failure_persistence: None, ..Config::default() })]

    /// The Karush-Kuhn-Tucker conditions, which hold at the minimiser of a convex programme and
    /// nowhere else. The solver asks for 1e-10 of the problem's size; sizes here are below 1e3, and
    /// complementary pairs multiply to the gap, so that 1e-5 bounds either factor of a pair by the
    /// root of 1e-10 while feasibility and stationarity keep 1e-6.
    #[test]
    fn prop_solutions_satisfy_the_kkt_conditions(
        n in 1_usize..8, k in 0_usize..3, m in 0_usize..12, rank in 0_usize..8, seed: u64,
    ) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let root = normal(&mut rng, rank.min(n), n);
        let p = root.transpose() * &root;
        // q in the range of P, E' and G': then the objective is bounded whatever the rank of P.
        let k = k.min(n - 1);
        let (e, g) = (normal(&mut rng, k, n), normal(&mut rng, m, n));
        let within = vector(&mut rng, n);
        let q = &p * vector(&mut rng, n) + e.transpose() * vector(&mut rng, k);
        // Feasible by construction: the bounds leave `within` room on both sides, or on one only.
        let (lower, upper): (Vec<f64>, Vec<f64>) = (&g * &within)
            .iter()
            .map(|&value| {
                let (below, above) = (rng.random_range(0.0..1.0), rng.random_range(0.0..1.0));
                match rng.random_range(0..3) {
                    0 => (f64::NEG_INFINITY, value + above),
                    1 => (value - below, f64::INFINITY),
                    _ => (value - below, value + above),
                }
            })
            .unzip();
        let right = &e * &within;
        let (lower, upper) = (DVector::from_vec(lower), DVector::from_vec(upper));
        let solution = QuadraticProgram::new(p.clone(), q.clone())
            .unwrap()
            .equalities(e.clone(), right.clone())
            .unwrap()
            .bounds(g.clone(), lower.clone(), upper.clone())
            .unwrap()
            .solve()
            .unwrap();
        let (x, y, z) =
            (&solution.x, &solution.equality_multipliers, &solution.bound_multipliers);
        let size = 1.0 + x.amax() + q.amax() + p.amax();
        let gradient = &p * x + &q + e.transpose() * y + g.transpose() * z;
        prop_assert!(gradient.amax() < 1e-6 * size, "gradient {:e}", gradient.amax());
        let off = &e * x - &right;
        prop_assert!(k == 0 || off.amax() < 1e-6 * size, "equalities");
        for (row, &value) in (&g * x).iter().enumerate() {
            let (to_lower, to_upper) = (value - lower[row], upper[row] - value);
            prop_assert!(to_lower > -1e-6 * size && to_upper > -1e-6 * size, "bounds");
            prop_assert!(z[row] < 1e-5 * size || to_upper < 1e-5 * size, "upper, row {}", row);
            prop_assert!(z[row] > -1e-5 * size || to_lower < 1e-5 * size, "lower, row {}", row);
        }
        let objective = 0.5 * (&p * x).dot(x) + q.dot(x);
        prop_assert!((solution.objective - objective).abs() <= 1e-12 * objective.abs().max(1.0));
    }
}

#[test]
fn published_projection_onto_the_simplex() {
    // The point of the simplex nearest to (0.9, 0.6, -0.5) is (0.65, 0.35, 0): subtract
    // (0.9 + 0.6 - 1) / 2 from the two that stay positive (Held, Wolfe and Crowder, 1974).
    let target = vec_of(&[0.9, 0.6, -0.5]);
    let solution = QuadraticProgram::new(DMatrix::identity(3, 3), -target)
        .unwrap()
        .equalities(DMatrix::from_element(1, 3, 1.0), vec_of(&[1.0]))
        .unwrap()
        .bounds(
            DMatrix::identity(3, 3),
            DVector::zeros(3),
            DVector::from_element(3, f64::INFINITY),
        )
        .unwrap()
        .solve()
        .unwrap();
    // 1e-8 is the solver's 1e-10 with room for its scaling.
    assert!((solution.x - vec_of(&[0.65, 0.35, 0.0])).amax() < 1e-8);
    // Stationarity: 0.65 - 0.9 + y = 0 and 0 + 0.5 + y + z = 0.
    assert!((solution.equality_multipliers[0] - 0.25).abs() < 1e-8);
    assert!((solution.bound_multipliers[2] + 0.75).abs() < 1e-8);
    assert!(!solution.reduced_accuracy);
}

#[test]
fn a_programme_without_constraints_is_a_linear_system() {
    let p = rows_of(&[[2.0, 1.0], [1.0, 3.0]]);
    let solution = QuadraticProgram::new(p.clone(), vec_of(&[1.0, -1.0]))
        .unwrap()
        .solve()
        .unwrap();
    assert!((p * solution.x + vec_of(&[1.0, -1.0])).amax() < 1e-9);
}

#[test]
fn programmes_without_a_solution() {
    let flat = || QuadraticProgram::new(DMatrix::zeros(2, 2), vec_of(&[1.0, 0.0])).unwrap();
    assert_eq!(flat().solve().unwrap_err(), QpError::Unbounded);
    let one_side = flat()
        .bounds(
            rows_of(&[[1.0, 0.0]]),
            vec_of(&[f64::NEG_INFINITY]),
            vec_of(&[3.0]),
        )
        .unwrap();
    assert_eq!(one_side.solve().unwrap_err(), QpError::Unbounded);
    let square = || QuadraticProgram::new(DMatrix::identity(2, 2), DVector::zeros(2)).unwrap();
    // x1 = 1 and x1 <= 0.
    let apart = square()
        .equalities(rows_of(&[[1.0, 0.0]]), vec_of(&[1.0]))
        .unwrap()
        .bounds(
            rows_of(&[[1.0, 0.0]]),
            vec_of(&[f64::NEG_INFINITY]),
            vec_of(&[0.0]),
        )
        .unwrap();
    assert_eq!(apart.solve().unwrap_err(), QpError::Infeasible);
    // x1 + x2 = 0 and x1 + x2 = 1.
    let twice = square()
        .equalities(rows_of(&[[1.0, 1.0], [1.0, 1.0]]), vec_of(&[0.0, 1.0]))
        .unwrap();
    assert_eq!(twice.solve().unwrap_err(), QpError::Infeasible);
}

#[test]
fn programmes_that_cannot_be_posed() {
    let square = |p: DMatrix<f64>| QuadraticProgram::new(p, DVector::zeros(2)).unwrap_err();
    assert_eq!(
        QuadraticProgram::new(DMatrix::zeros(0, 0), DVector::zeros(0)).unwrap_err(),
        QpError::NoVariables
    );
    assert_eq!(
        square(DMatrix::zeros(3, 2)),
        QpError::Dimension(DimensionError {
            what: "rows of P".to_owned(),
            expected: 2,
            found: 3
        })
    );
    assert_eq!(
        square(rows_of(&[[1.0, 0.5], [0.25, 1.0]])),
        QpError::NotSymmetric {
            row: 0,
            column: 1,
            expected: 0.25,
            found: 0.5
        }
    );
    assert_eq!(
        square(rows_of(&[[1.0, 2.0], [2.0, 1.0]])).to_string(),
        "P: expected no negative eigenvalue, found one of at most -2e-10"
    );
    assert_eq!(
        square(rows_of(&[[1.0, f64::INFINITY], [0.0, 1.0]])).to_string(),
        "P(0, 1): expected a finite number, found inf"
    );
    let good = || QuadraticProgram::new(DMatrix::identity(2, 2), DVector::zeros(2)).unwrap();
    assert_eq!(
        good()
            .bounds(rows_of(&[[1.0, 0.0]]), vec_of(&[2.0]), vec_of(&[1.0]))
            .unwrap_err(),
        QpError::CrossedBounds {
            row: 0,
            lower: 2.0,
            upper: 1.0
        }
    );
    assert_eq!(
        good()
            .bounds(
                rows_of(&[[1.0, 0.0]]),
                vec_of(&[f64::INFINITY]),
                vec_of(&[f64::INFINITY])
            )
            .unwrap_err()
            .to_string(),
        "lower(0, 0): expected a finite number, found inf"
    );
    assert_eq!(
        good()
            .equalities(rows_of(&[[1.0, 0.0]]), vec_of(&[1.0, 2.0]))
            .unwrap_err()
            .to_string(),
        "rows of e: expected 1, found 2"
    );
}
