//! Features and signature matrices.

use gt_core::DimensionError;
use gt_fdi::FdiError;
use gt_fdi::design::{Feature, IsolatingResiduals, SignatureMatrix, feature, signature};
use proptest::prelude::*;

use crate::fixtures::{TS, noise};

fn matrix(entries: &[&[f64]]) -> SignatureMatrix {
    let rows: Vec<Vec<f64>> = entries.iter().map(|row| row.to_vec()).collect();
    SignatureMatrix {
        rows: (0..rows.len()).map(|i| format!("f{i}")).collect(),
        columns: (0..entries[0].len()).map(|j| format!("r{j}")).collect(),
        matrix: rows.clone(),
        raw: rows,
        definition: String::new(),
    }
}

#[test]
fn moving_mean_by_hand() {
    let series = [1.0, 2.0, 6.0, 3.0, f64::NAN, 5.0];
    // 2.1 s of 1 s samples: two samples.
    let means = feature(&series, 1.0, Feature::MovingMean { window_s: 2.1 });
    assert_eq!(means, [1.0, 1.5, 4.0, 4.5, 3.0, 5.0]);
    let high = feature(&series[..4], 1.0, Feature::HighPass { window_s: 2.1 });
    assert_eq!(high, [0.0, 0.5, 2.0, -1.5]);
    assert_eq!(feature(&series[..4], 1.0, Feature::Plain), series[..4]);
    // A window shorter than a sample is one sample.
    assert_eq!(
        feature(&series[..3], 1.0, Feature::MovingMean { window_s: 0.1 }),
        series[..3]
    );
    let nan = feature(&[f64::NAN, 1.0], 1.0, Feature::MovingMean { window_s: 1.0 });
    assert!(nan[0].is_nan() && nan[1] == 1.0);
}

/// A value that swallows the others' digits is forgotten a window after it has left.
#[test]
fn a_moving_mean_forgets_a_huge_value() {
    let mut series = vec![1.0; 40];
    series[2] = 1e17;
    let means = feature(&series, 1.0, Feature::MovingMean { window_s: 4.0 });
    assert_eq!(means[8..], [1.0; 32]);
}

proptest! {
    #[test]
    fn prop_moving_mean_is_the_mean_of_the_window(seed in any::<u64>(), window in 1_usize..40) {
        let series = noise(seed, 150);
        let means = feature(&series, TS, Feature::MovingMean { window_s: window as f64 * TS });
        for (k, mean) in means.iter().enumerate() {
            let seen = &series[(k + 1).saturating_sub(window)..=k];
            let expected = seen.iter().sum::<f64>() / seen.len() as f64;
            // Values of order 1, at most 80 roundings between two fresh sums.
            prop_assert!((mean - expected).abs() < 1e-13, "{k}: {mean} {expected}");
        }
    }
}

/// Constant effects: rms is their size. Column 0: 3 and 1, column 1: 2 (minus 0.5 healthy) and 6.
#[test]
fn constant_effects_by_hand() {
    let constant = |a: f64, b: f64| vec![vec![a; 20], vec![b; 20]];
    let (valve, sensor) = (constant(3.0, -1.5), constant(1.0, 6.5));
    let columns = [
        ("q", Feature::Plain),
        ("t", Feature::MovingMean { window_s: 8.0 * TS }),
    ];
    let found = signature(
        &[("valve", &valve), ("sensor", &sensor)],
        &constant(0.0, 0.5),
        &columns,
        TS,
        5..20,
    )
    .unwrap();
    assert_eq!(found.raw, [[3.0, 2.0], [1.0, 6.0]]);
    assert_eq!(found.matrix, [[1.0, 2.0 / 6.0], [1.0 / 3.0, 1.0]]);
    assert_eq!(
        (found.rows[1].as_str(), found.columns[1].as_str()),
        ("sensor", "t")
    );
    assert!(found.is_diagonal());
    assert_eq!(
        found.definition,
        "S_ij = rms of feature_j(fault i) - feature_j(healthy) over samples 5..20 at 0.08 s, each \
         column divided by its largest entry; features: q: plain, t: moving mean of 0.64 s"
    );
    let json = serde_json::to_string(&found).unwrap();
    assert_eq!(
        serde_json::from_str::<SignatureMatrix>(&json).unwrap(),
        found
    );
}

/// What the healthy run and the faulty one share does not count; a residual that no fault moves
/// stays a column of zeros.
#[test]
fn common_noise_cancels() {
    let healthy = vec![noise(1, 100)];
    let columns = [("q", Feature::HighPass { window_s: 1.0 })];
    let found = signature(
        &[("none", &healthy.clone())],
        &healthy,
        &columns,
        TS,
        0..100,
    )
    .unwrap();
    assert_eq!((&found.raw[0][0], &found.matrix[0][0]), (&0.0, &0.0));
    assert!(!found.is_diagonal());
}

#[test]
fn diagonal_means_each_column_peaks_at_its_own_fault() {
    assert!(matrix(&[&[1.0, 0.9], &[0.9, 1.0]]).is_diagonal());
    assert!(!matrix(&[&[0.9, 0.2], &[1.0, 1.0]]).is_diagonal());
    assert!(
        !matrix(&[&[1.0, 1.0], &[0.2, 1.0]]).is_diagonal(),
        "a tie is not a peak"
    );
    assert!(
        !matrix(&[&[1.0, 0.1, 0.1], &[0.1, 1.0, 1.0]]).is_diagonal(),
        "not square"
    );
}

/// The matrix of a ruined file answers without a panic.
#[test]
fn a_ragged_matrix_is_not_diagonal() {
    let mut ragged = matrix(&[&[1.0, 0.0], &[0.0, 1.0]]);
    ragged.matrix[1].truncate(1);
    assert!(!ragged.is_diagonal());
    ragged.matrix.clear();
    assert!(!ragged.is_diagonal());
}

/// The rows 110 and 010: different, so weakly isolating; the first covers the second, so not
/// strongly. At a cut of 0.3 both are 110.
#[test]
fn isolability_by_hand() {
    let covered = matrix(&[&[1.0, 1.0], &[0.4, 1.0]]);
    assert_eq!(covered.binary(0.5), [[true, true], [false, true]]);
    assert!(covered.is_weakly_isolable(0.5) && !covered.is_strongly_isolable(0.5));
    assert!(!covered.is_weakly_isolable(0.3));
    let strong = matrix(&[&[1.0, 1.0, 0.0], &[0.0, 1.0, 1.0], &[1.0, 0.0, 1.0]]);
    assert!(strong.is_weakly_isolable(0.5) && strong.is_strongly_isolable(0.5));
    let dark = matrix(&[&[1.0, 0.0], &[0.2, 0.3]]);
    assert!(
        !dark.is_weakly_isolable(0.5),
        "a fault that lights nothing is not even detected"
    );
    // At the cut is not above it.
    assert_eq!(matrix(&[&[0.5]]).binary(0.5), [[false]]);
}

#[test]
fn errors_name_the_run_and_the_residual() {
    let healthy = vec![vec![0.0; 10]];
    let columns = [("q", Feature::Plain)];
    let found = |faulty: Vec<Vec<f64>>, window| {
        signature(&[("valve", &faulty)], &healthy, &columns, TS, window).unwrap_err()
    };
    let dimension = |what: &str, expected, found| {
        FdiError::Dimension(DimensionError {
            what: what.to_owned(),
            expected,
            found,
        })
    };
    assert_eq!(
        found(vec![], 0..10),
        dimension("residuals of `valve`", 1, 0)
    );
    let short = dimension("samples of residual `q` of `valve`", 10, 9);
    assert_eq!(found(vec![vec![0.0; 9]], 0..10), short);
    let window = FdiError::Window {
        start: 5,
        end: 11,
        len: 10,
    };
    assert_eq!(found(healthy.clone(), 5..11), window);
    let empty = FdiError::Window {
        start: 5,
        end: 5,
        len: 10,
    };
    assert_eq!(found(healthy.clone(), 5..5), empty);
    let mut broken = healthy.clone();
    broken[0][3] = f64::INFINITY;
    let what = "residual `q` of `valve`".to_owned();
    let expected = FdiError::NotFiniteResidual {
        what,
        sample: 3,
        found: f64::INFINITY,
    };
    assert_eq!(found(broken, 0..10), expected);

    assert_eq!(
        signature(&[], &[], &columns, TS, 0..10),
        Err(FdiError::NoHealthyData)
    );
    let bad = [("q", Feature::MovingMean { window_s: 0.0 })];
    let expected = "a positive finite number of seconds";
    let error = FdiError::Option {
        option: "window_s",
        expected,
        found: 0.0,
    };
    assert_eq!(signature(&[], &healthy, &bad, TS, 0..10), Err(error));
}

/// Units of the residuals, far apart.
const UNITS: [f64; 3] = [1.0, 1e3, 1e-3];

/// Faults that move mixtures of the residuals, each in its own course, on top of what moves them
/// anyway.
fn mixed(mixing: &[[f64; 3]; 3], size: f64, fault: Option<usize>, seed: u64) -> Vec<Vec<f64>> {
    let len = 2000;
    let own = noise(seed, len);
    (0..3)
        .map(|output| {
            let healthy = noise(100 + output as u64, len);
            let change = fault.map_or(0.0, |fault| size * mixing[fault][output]);
            (0..len)
                .map(|t| UNITS[output] * (1e-3 * healthy[t] + change * (1.0 + own[t])))
                .collect()
        })
        .collect()
}

#[test]
fn isolating_residuals_undo_a_mixture_and_hold_on_other_records() {
    let mixing = [[1.0, 0.5, 0.4], [0.3, 1.0, -0.2], [-0.6, 0.2, 1.0]];
    let names = ["f1", "f2", "f3"];
    let run = |fault, size, seed| mixed(&mixing, size, fault, seed);
    let teaching: Vec<_> = (0..3).map(|fault| run(Some(fault), 2.0, 7)).collect();
    let faulty: Vec<(&str, &[Vec<f64>])> = names
        .into_iter()
        .zip(teaching.iter().map(Vec::as_slice))
        .collect();
    let features = [Feature::Plain; 3];
    let isolating =
        IsolatingResiduals::learn(&faulty, &run(None, 0.0, 7), &features, TS, 100..2000).unwrap();
    // Other courses and sizes.
    let others: Vec<_> = (0..3)
        .map(|fault| isolating.apply(&run(Some(fault), 0.7, 8)).unwrap())
        .collect();
    let healthy = isolating.apply(&run(None, 0.0, 8)).unwrap();
    let faulty: Vec<(&str, &[Vec<f64>])> = names
        .into_iter()
        .zip(others.iter().map(Vec::as_slice))
        .collect();
    let columns = names.map(|name| (name, Feature::Plain));
    let found = signature(&faulty, &healthy, &columns, TS, 100..2000).unwrap();
    for (i, row) in found.matrix.iter().enumerate() {
        for (j, entry) in row.iter().enumerate() {
            // The mixtures are gone but for the balance with healthy energy, 1e-6 of the smallest.
            let expected = f64::from(u8::from(i == j));
            assert!((entry - expected).abs() < 1e-3, "({i}, {j}): {entry}");
        }
        // Scaled to the size of the records that taught it.
        let rms = found.raw[i][i] / 0.35;
        assert!((rms - 1.0).abs() < 0.05, "{i}: {rms}");
    }
}

#[test]
fn isolating_residuals_refuse_what_does_not_fit() {
    let run = || mixed(&[[1.0, 0.0, 0.0]; 3], 1.0, Some(0), 3);
    let (own, healthy) = (run(), mixed(&[[0.0; 3]; 3], 0.0, None, 3));
    let one = [("f1", own.as_slice())];
    let learn = |faulty: &[(&str, &[Vec<f64>])], healthy: &[Vec<f64>], features: &[Feature]| {
        IsolatingResiduals::learn(faulty, healthy, features, TS, 0..2000)
    };
    let plain = [Feature::Plain];
    assert!(learn(&one, &healthy, &plain).is_ok());
    assert!(matches!(
        learn(&one, &healthy, &[]),
        Err(FdiError::Dimension(_))
    ));
    assert!(matches!(
        learn(&one, &healthy[..2], &plain),
        Err(FdiError::Dimension(_))
    ));
    assert!(matches!(
        learn(&one, &[], &plain),
        Err(FdiError::NoHealthyData)
    ));
    // A fault that does not show.
    let same = [("f1", healthy.as_slice())];
    assert!(matches!(
        learn(&same, &healthy, &plain),
        Err(FdiError::NoEffect)
    ));
    let isolating = learn(&one, &healthy, &plain).unwrap();
    assert!(matches!(
        isolating.apply(&own[..2]),
        Err(FdiError::Dimension(_))
    ));
}
