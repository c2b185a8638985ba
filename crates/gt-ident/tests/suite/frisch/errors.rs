//! What is refused, exactly; and that nothing panics.

use gt_core::{DataError, DimensionError};
use gt_ident::IdentError;
use gt_ident::eiv::EivLags;
use gt_ident::frisch::{
    AdmissibleSurface, Criterion, Frisch, LaggedCovariance, WeightedMoments, frisch_order_table,
};
use nalgebra::DMatrix;
use proptest::prelude::*;
use rand::RngExt;

use super::systems::{Vector, dataset, respond};
use crate::common::{cases, generator, normal_matrix};

fn lags(order: usize, nk: &[usize]) -> EivLags {
    EivLags::new(order, nk.to_vec()).unwrap()
}

fn frisch(order: usize, nk: &[usize]) -> Frisch {
    Frisch::new(lags(order, nk))
}

/// `n + q + 1` lags of 5 regressors of order 2, one more a channel for order 3, plus 1.
#[test]
fn a_short_record_is_refused_with_the_samples_needed() {
    let record = |samples| Vector::s1().record().rows(0..samples).unwrap();
    let refused = IdentError::TooFewRows {
        structure: "Frisch scheme of order 2, nk [1]".to_owned(),
        needed: 15,
        found: 14,
    };
    assert_eq!(frisch(2, &[1]).fit(&record(14), 0), Err(refused.clone()));
    assert_eq!(
        frisch(2, &[1]).fit_shared(&record(14)),
        Err(refused.clone())
    );
    assert_eq!(
        WeightedMoments::new(lags(2, &[1])).fit(&record(14), 0),
        Err(refused.clone())
    );
    assert_eq!(
        frisch_order_table(&record(14), 0, 1..=2, &[1]),
        Err(refused)
    );
    assert!(frisch(2, &[1]).fit(&record(15), 0).is_ok());
    for order in [usize::MAX, usize::MAX / 2, 100_000] {
        let found = frisch(order, &[1]).fit(&record(400), 0);
        assert!(matches!(
            found,
            Err(IdentError::TooFewRows { found: 400, .. })
        ));
    }
}

#[test]
fn lags_and_criteria_that_do_not_fit_are_refused() {
    let record = Vector::s1().record();
    let inputs = DimensionError {
        what: "inputs of the lags".to_owned(),
        expected: 1,
        found: 2,
    };
    let refused = Err(IdentError::Dimension(inputs));
    assert_eq!(frisch(2, &[1, 1]).fit(&record, 0), refused);
    assert_eq!(
        frisch(2, &[1]).fit(&record, 1),
        Err(IdentError::NoSuchOutput {
            found: 1,
            outputs: 1
        })
    );
    let too_few = |criterion, needed, found| IdentError::CriterionLags {
        criterion,
        needed,
        found,
    };
    let matching = frisch(2, &[1]).criterion(Criterion::CovarianceMatch { lags: 2 });
    assert_eq!(
        matching.fit(&record, 0),
        Err(too_few("covariance_match", 3, 2))
    );
    let yule_walker = frisch(2, &[1]).criterion(Criterion::HighOrderYuleWalker { lags: 0 });
    assert_eq!(
        yule_walker.fit(&record, 0),
        Err(too_few("high_order_yule_walker", 1, 0))
    );
    let covariance = LaggedCovariance::of_record(&record, 0, 6).unwrap();
    let short = DimensionError {
        what: "lags of the covariances".to_owned(),
        expected: 7,
        found: 6,
    };
    assert_eq!(
        frisch(2, &[1]).fit_covariance(&covariance),
        Err(IdentError::Dimension(short))
    );
    assert_eq!(
        frisch_order_table(&record, 0, 0..=2, &[1]),
        Err(IdentError::OrderRange { first: 0, last: 2 })
    );
}

#[test]
fn channels_without_information_are_refused() {
    let record = Vector::m1().record();
    let fit = |u: &DMatrix<f64>, y: &DMatrix<f64>| {
        frisch(2, &[1, 1]).fit(&dataset(u.clone(), y.clone()), 0)
    };

    let mut constant = record.u().clone();
    constant.row_mut(1).fill(3.5);
    let refused = IdentError::ConstantChannel {
        channel: "u2".to_owned(),
        value: 3.5,
    };
    assert_eq!(fit(&constant, record.y()), Err(refused));

    let mut equal = record.u().clone();
    let first = equal.row(0) * 2.0;
    equal.set_row(1, &first);
    match fit(&equal, record.y()) {
        Err(IdentError::RankDeficient {
            output, channel, ..
        }) => {
            assert_eq!((output.as_str(), channel.as_str()), ("y1", "u2"));
        }
        other => panic!("{other:?}"),
    }

    let mut missing = record.u().clone();
    missing[(0, 7)] = f64::NAN;
    match fit(&missing, record.y()) {
        Err(IdentError::Data(DataError::NotFinite {
            channel, sample, ..
        })) => {
            assert_eq!((channel.as_str(), sample), ("u1", 7));
        }
        other => panic!("{other:?}"),
    }

    let mut huge = record.y().clone();
    huge.fill(f64::MAX);
    huge[0] = -f64::MAX;
    match fit(record.u(), &huge) {
        Err(IdentError::CoefficientNotFinite { output, .. }) => assert_eq!(output, "y1"),
        other => panic!("{other:?}"),
    }
}

/// Without noise nothing is left for it but what the missing mean makes of the start: below 1e-4
/// of the input's variance (1), below 1e-5 of the output's (about 30), and not told from zero.
#[test]
fn a_record_without_noise_has_none_that_is_identifiable() {
    let u = normal_matrix(&mut generator(3), 1, 600);
    let y = respond(&[-1.5, 0.7], &[vec![1.0, 0.5]], &u);
    let found = frisch(2, &[1]).fit(&dataset(u, y), 0).unwrap();
    assert!(found.noise.inputs[0] < 1e-4 && found.noise.output < 3e-4);
    assert!(found.channels.iter().all(|noise| !noise.is_identifiable()));
    for (value, expected) in found.row.theta().iter().zip([-1.5, 0.7, 1.0, 0.5]) {
        assert!((value - expected).abs() < 1e-4);
    }
}

/// A channel that is another one sooner leaves no surface at all.
#[test]
fn an_output_that_is_its_input_is_refused() {
    let u = normal_matrix(&mut generator(3), 1, 600);
    let found = frisch(2, &[1]).fit(&dataset(u.clone(), u), 0);
    match found {
        Err(IdentError::RankDeficient { output, .. }) => assert_eq!(output, "y1"),
        other => panic!("{other:?}"),
    }
}

/// A growing output drowns everything that the other lags know; a sinusoid alone carries one
/// frequency. Either gives finite numbers or an error that says so.
#[test]
fn unstable_and_poor_records_give_numbers_or_an_error() {
    let mut rng = generator(11);
    let noise = normal_matrix(&mut rng, 2, 300);
    let u = DMatrix::from_fn(1, 300, |_, t| (0.3 * t as f64).sin() + 0.1 * noise[(0, t)]);
    for pole in [0.5, 1.0, 1.1, 3.0] {
        let mut y = respond(&[-pole], &[vec![1.0]], &u);
        y += noise.rows(1, 1) * 0.1;
        match frisch(1, &[1]).fit(&dataset(u.clone(), y), 0) {
            Ok(found) => assert!(found.row.theta().iter().all(|value| value.is_finite())),
            Err(IdentError::RankDeficient { .. } | IdentError::CoefficientNotFinite { .. }) => {
                assert!(pole > 1.0);
            }
            Err(other) => panic!("{other:?}"),
        }
    }
}

#[test]
fn covariances_of_no_process_are_refused() {
    let not_definite = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0]);
    assert_eq!(
        LaggedCovariance::of_process(&[not_definite]),
        Err(IdentError::NotPositiveDefinite { size: 2 })
    );
    assert!(matches!(
        LaggedCovariance::of_process(&[]),
        Err(IdentError::Dimension(_))
    ));
    let wide = [DMatrix::identity(2, 2), DMatrix::zeros(3, 3)];
    assert!(matches!(
        LaggedCovariance::of_process(&wide),
        Err(IdentError::Dimension(_))
    ));
    for order in [1, 3, usize::MAX] {
        let found = AdmissibleSurface::of_covariance(&lags(order, &[1]), &Vector::s1().sigma());
        assert!(matches!(found, Err(IdentError::Dimension(_))));
    }
}

#[test]
fn variances_that_no_noise_has_are_refused() {
    let vector = Vector::s1();
    let surface = AdmissibleSurface::of_covariance(&vector.lags(), &vector.sigma()).unwrap();
    let wrong = |channel, found| Err(IdentError::NoiseDirection { channel, found });
    assert_eq!(surface.along(&[1.0, -0.5]), wrong(1, -0.5));
    assert_eq!(
        surface.along(&[f64::INFINITY, 0.5]),
        wrong(0, f64::INFINITY)
    );
    assert_eq!(surface.along(&[0.0, 0.0]), wrong(0, 0.0));
    assert_eq!(surface.at_inputs(&[-1.0]), wrong(1, -1.0));
    assert!(matches!(
        surface.along(&[1.0]),
        Err(IdentError::Dimension(_))
    ));
    let refused = IdentError::NotAdmissible {
        output: "y".to_owned(),
        variances: vec![0.6],
    };
    assert_eq!(surface.at_inputs(&[0.6]), Err(refused));
}

proptest! {
    #![proptest_config(cases(60))]

    /// Short records of any size and mixed magnitudes: numbers or an error, never a panic.
    #[test]
    fn prop_any_record_is_answered(seed in any::<u64>()) {
        let mut rng = generator(seed);
        let (order, nu) = (rng.random_range(1..4), rng.random_range(0..3));
        let samples = rng.random_range(1..60);
        let mut u = normal_matrix(&mut rng, nu, samples);
        let mut y = normal_matrix(&mut rng, 2, samples);
        u.iter_mut().chain(y.iter_mut()).for_each(|value| {
            if rng.random_bool(0.05) {
                *value *= 10.0_f64.powi(rng.random_range(-200..200));
            }
        });
        let record = dataset(u, y);
        let nk = vec![rng.random_range(0..=order); nu];
        let criteria = [
            Criterion::ShiftRelation,
            Criterion::CovarianceMatch { lags: order + 1 },
            Criterion::HighOrderYuleWalker { lags: 3 },
        ];
        let chosen = criteria[rng.random_range(0..3)];
        let frisch = frisch(order, &nk).criterion(chosen);
        if let Ok(found) = frisch.fit(&record, 1) {
            prop_assert!(found.row.theta().iter().all(|value| value.is_finite()));
            prop_assert!(found.noise.inputs.iter().all(|value| *value >= 0.0));
        }
        if let Ok(found) = frisch.fit_shared(&record) {
            prop_assert!(found.output_noise.iter().all(|value| *value >= 0.0));
        }
        if let Ok(found) = WeightedMoments::new(lags(order, &nk)).fit(&record, 0) {
            prop_assert!(found.coefficient_error.iter().all(|value| *value >= 0.0));
        }
    }
}
