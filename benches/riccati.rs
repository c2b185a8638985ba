//! The time of a discrete Riccati equation of a filter with 8 states.
//!
//! `cargo bench -p gtfdi --bench riccati`

mod timing;

use std::error::Error;
use std::hint::black_box;

use gtfdi::fdi::Riccati;
use nalgebra::{Cholesky, DMatrix};

/// Riccati equations of each contender.
const EQUATIONS: usize = 200;

fn main() -> Result<(), Box<dyn Error>> {
    let mut state = 7_u64;
    let mut uniform = || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let problems = [problem(1, &mut uniform), problem(4, &mut uniform)];
    println!("Discrete Riccati equations of a filter, 8 states");
    for matrices in &problems {
        let [a, c, q, r, s] = matrices;
        let solved = Riccati::solve(a, c, q, r, s)?;
        let by_hand = recursion(matrices);
        println!(
            "{} output(s): relative residual {:.1e}, {} doublings, {:.1e} from the recursion",
            c.nrows(),
            solved.relative_residual,
            solved.iterations,
            (&solved.p - &by_hand).norm() / by_hand.norm()
        );
        if solved.relative_residual > 1e-12 {
            return Err("the residual is above 1e-12".into());
        }
    }
    let solve = |[a, c, q, r, s]: &[DMatrix<f64>; 5]| {
        for _ in 0..EQUATIONS {
            let _ = black_box(Riccati::solve(black_box(a), c, q, r, s));
        }
    };
    let times = timing::race(vec![
        (
            "the recursion to its limit, as a user writes it",
            Box::new(|| {
                for _ in 0..EQUATIONS / 20 {
                    black_box(recursion(black_box(&problems[0])));
                }
            }),
        ),
        ("Riccati::solve, 1 output", Box::new(|| solve(&problems[0]))),
        (
            "Riccati::solve, 4 outputs",
            Box::new(|| solve(&problems[1])),
        ),
        (
            "yardstick: 100 products of two 8 x 8 matrices",
            Box::new(|| {
                for _ in 0..100 * EQUATIONS {
                    black_box(black_box(&problems[0][0]) * &problems[0][2]);
                }
            }),
        ),
        (
            "yardstick: the poles of A",
            Box::new(|| {
                for _ in 0..EQUATIONS {
                    black_box(black_box(&problems[0][0]).complex_eigenvalues());
                }
            }),
        ),
    ]);
    times.print(
        "us each",
        |seconds| 1e6 * seconds / EQUATIONS as f64,
        &[3],
        ("", &[]),
    );
    println!("Row 0 solves one in 20 as often.");
    Ok(())
}

/// Steps of the recursion until `P` stands still.
fn recursion([a, c, q, r, s]: &[DMatrix<f64>; 5]) -> DMatrix<f64> {
    let mut p = q.clone();
    for _ in 0..10_000 {
        let cross = a * &p * c.transpose() + s;
        let Some(innovation) = Cholesky::new(c * &p * c.transpose() + r) else {
            break;
        };
        let next = a * &p * a.transpose() - &cross * innovation.solve(&cross.transpose()) + q;
        let change = (&next - &p).norm();
        p = next;
        if change <= 1e-15 * p.norm() {
            break;
        }
    }
    p
}

/// `A`, `C`, `Q`, `R` and `S` of a stable system with 8 states.
fn problem(ny: usize, uniform: &mut impl FnMut() -> f64) -> [DMatrix<f64>; 5] {
    let a = DMatrix::from_fn(8, 8, |i, j| {
        0.3 * uniform() + if i == j { 0.7 } else { 0.0 }
    });
    let c = DMatrix::from_fn(ny, 8, |_, _| uniform());
    let (q, r) = (DMatrix::identity(8, 8), DMatrix::identity(ny, ny));
    [a, c, q, r, DMatrix::zeros(8, ny)]
}
