//! Joint whitening: a known vector autoregression, and what is refused.

use gt_fdi::FdiError;
use gt_fdi::design::JointWhitening;
use nalgebra::{DMatrix, DVector};

use crate::fixtures::{noise, rows};

/// `e(t) = F e(t-1) + G w(t)` round (3, -2), after it has forgotten its start.
fn coloured(seed: u64, len: usize) -> DMatrix<f64> {
    let (f, g) = (transition(), rows([[1.0, 0.0], [0.6, 0.5]]));
    let draws = noise(seed, 2 * (len + 100));
    let mut state = DVector::from_vec(vec![0.0, 0.0]);
    let mut values = DMatrix::zeros(2, len);
    for (t, draw) in draws.chunks_exact(2).enumerate() {
        state = &f * state + &g * DVector::from_vec(vec![draw[0], draw[1]]);
        if t >= 100 {
            values.set_column(t - 100, &(&state + DVector::from_vec(vec![3.0, -2.0])));
        }
    }
    values
}

/// One residual drives the other: no whitening of each by itself undoes that.
fn transition() -> DMatrix<f64> {
    rows([[0.9, 0.0], [0.3, 0.5]])
}

#[test]
fn a_known_autoregression_is_found_and_undone() {
    let records = [coloured(1, 20_000), coloured(2, 20_000)];
    let whitening = JointWhitening::estimate(&records.each_ref()).unwrap();
    assert_eq!(whitening.order(), 1);
    let difference = &whitening.coefficients()[0] + transition();
    // Standard errors of the coefficients are at most sqrt(0.61 / (0.6 N)) = 0.005: five of them.
    assert!(difference.amax() < 0.025, "{difference}");
    let white = whitening.whiten(&coloured(3, 40_000)).unwrap();
    let later = white.columns(1, 39_999).into_owned();
    let covariance = &later * later.transpose() / 39_999.0;
    let lagged = &later * white.columns(0, 39_999).transpose() / 39_999.0;
    // Sampling errors are 1 / sqrt(N) = 0.005 off the diagonal, sqrt(2) times that on it.
    assert!((covariance - DMatrix::identity(2, 2)).amax() < 0.04);
    assert!(lagged.amax() < 0.025, "{lagged}");
}

#[test]
fn a_lasting_change_becomes_the_steady_gain_times_it() {
    let whitening = JointWhitening::estimate(&[&coloured(1, 20_000)]).unwrap();
    let change = DVector::from_vec(vec![0.7, -0.2]);
    let step = DMatrix::from_fn(2, 40, |row, _| change[row]);
    let found = whitening.response(&step).unwrap();
    let expected = whitening.steady_gain() * change;
    // The response is finite and over after the order: rounding only.
    assert!((found.column(39) - expected).amax() < 1e-12);
}

#[test]
fn files_keep_every_bit_and_odd_sizes_are_refused() {
    let whitening = JointWhitening::estimate(&[&coloured(1, 5000)]).unwrap();
    let text = serde_json::to_string(&whitening).unwrap();
    let read: JointWhitening = serde_json::from_str(&text).unwrap();
    assert_eq!(read, whitening);
    let mut value = serde_json::to_value(&whitening).unwrap();
    value["mean"] = serde_json::json!([[1.0], null, 1]);
    assert!(serde_json::from_value::<JointWhitening>(value).is_err());
}

#[test]
fn too_few_samples_and_constant_residuals_are_refused() {
    let few = coloured(1, 23);
    let error = JointWhitening::estimate(&[&few]).unwrap_err();
    assert!(
        matches!(
            error,
            FdiError::HealthySamples {
                needed: 24,
                found: 23,
                ..
            }
        ),
        "{error}"
    );
    assert!(matches!(
        JointWhitening::estimate(&[]).unwrap_err(),
        FdiError::NoHealthyData
    ));
    let mut still = coloured(1, 100);
    still.row_mut(1).fill(5.0);
    let error = JointWhitening::estimate(&[&still]).unwrap_err();
    assert!(
        matches!(error, FdiError::ConstantResidual { index: 1, .. }),
        "{error}"
    );
    let whitening = JointWhitening::estimate(&[&coloured(1, 5000)]).unwrap();
    assert!(whitening.whiten(&DMatrix::zeros(3, 10)).is_err());
}
