//! Several outputs with the noise of their inputs in common.

use gt_core::Dataset;
use gt_ident::eiv::EivLags;
use gt_ident::frisch::{Criterion, Frisch};
use nalgebra::DMatrix;

use super::systems::{Vector, noisy, respond, with_burn_in};
use crate::common::{generator, normal_matrix};

const A: [[f64; 2]; 2] = [[-1.5, 0.7], [-0.6, 0.3]];
const B: [[f64; 2]; 2] = [[1.0, 0.5], [0.8, -0.4]];
const VARIANCES: [f64; 3] = [1.0, 0.1, 0.2];

/// Two outputs of one coloured input.
fn record(seed: u64, samples: usize) -> Dataset {
    let mut rng = generator(seed);
    let white = normal_matrix(&mut rng, 1, with_burn_in(samples));
    let u = respond(&[-0.5], &[vec![1.0, 0.7]], &white);
    let mut y = DMatrix::zeros(2, u.ncols());
    for output in 0..2 {
        y.set_row(
            output,
            &respond(&A[output], &[B[output].to_vec()], &u).row(0),
        );
    }
    noisy(&mut rng, &u, &y, &VARIANCES)
}

/// One variance for the input, nearer the truth than the weaker output alone finds it.
#[test]
fn sharing_helps_the_output_that_knows_less() {
    const RUNS: u32 = 60;
    let frisch = Frisch::new(EivLags::new(2, vec![1]).unwrap());
    let mut squares = [0.0; 3];
    let mut mean = [0.0; 3];
    for run in 0..RUNS {
        let data = record(u64::from(run), 1000);
        let shared = frisch.fit_shared(&data).unwrap();
        let alone = |output| frisch.fit(&data, output).unwrap().noise.inputs[0];
        for (sum, found) in squares
            .iter_mut()
            .zip([shared.input_noise[0], alone(0), alone(1)])
        {
            *sum += (found - VARIANCES[2]).powi(2) / f64::from(RUNS);
        }
        let all = shared.output_noise.iter().chain(&shared.input_noise);
        for (sum, found) in mean.iter_mut().zip(all) {
            *sum += found / f64::from(RUNS);
        }
        assert_eq!((shared.rows.len(), shared.channels.len()), (2, 3));
        assert_eq!(shared.channels[2].variance, shared.input_noise[0]);
    }
    let [shared, first, second] = squares.map(f64::sqrt);
    println!("input variance, root mean square error: {shared:.4}, {first:.4}, {second:.4}");
    assert!(shared < 0.75 * first.max(second));
    // 60 runs: the mean of the input's variance has a deviation of 0.005, the outputs' of 0.01.
    for (found, truth) in mean.iter().zip(VARIANCES) {
        assert!((found - truth).abs() < 0.03, "{mean:?}");
    }
}

/// With one output there is nothing to share: the same point, to what two searches leave.
#[test]
fn one_output_shares_with_itself() {
    for (vector, tolerance) in [(Vector::s1(), 1e-6), (Vector::m1(), 1e-4)] {
        for criterion in [
            Criterion::ShiftRelation,
            Criterion::CovarianceMatch { lags: 5 },
            Criterion::default(),
        ] {
            let frisch = Frisch::new(vector.lags()).criterion(criterion);
            let record = vector.record();
            let alone = frisch.fit(&record, 0).unwrap();
            let shared = frisch.fit_shared(&record).unwrap();
            let error = (shared.rows[0].theta() - alone.row.theta()).amax();
            assert!(error < tolerance, "{criterion:?}: {error:e}");
            let error = (shared.output_noise[0] - alone.noise.output).abs();
            assert!(
                error < tolerance * alone.noise.output,
                "{criterion:?}: {error:e}"
            );
        }
    }
}
