//! Observers with pairs of complex poles, one output.

use gt_core::OperatingPoint;
use gt_fdi::FdiError;
use gt_fdi::design::{
    Bank, PlacementError, ResidualGenerator, ThresholdRule, place, place_complex,
};
use nalgebra::{Complex, DVector};
use proptest::prelude::*;

use crate::fixtures::{limit_on, plain_generator, plain_model, record};

fn pair(re: f64, im: f64) -> [Complex<f64>; 2] {
    [Complex::new(re, im), Complex::new(re, -im)]
}

/// `p = z^2 - 1.5 z + 0.54`, `d = z^2 - z + 0.5`: `k1 = 0.5`, `k2 = 0.5 - 0.54 + 1.5 k1`.
#[test]
fn a_pair_has_the_gain_found_by_hand() {
    let gain = place_complex(&plain_model("y"), &pair(0.5, 0.5)).unwrap();
    assert!((gain - DVector::from_vec(vec![0.5, 0.71])).amax() < 1e-15);
}

#[test]
fn real_poles_have_the_same_gain_either_way() {
    let real = [0.25, 0.5].map(|re| Complex::new(re, 0.0));
    assert_eq!(
        place_complex(&plain_model("y"), &real),
        place(&plain_model("y"), &[0.25, 0.5])
    );
    let point = OperatingPoint::zero(2, 1);
    let generator = ResidualGenerator::observer_complex(plain_model("y"), point, &real).unwrap();
    assert_eq!(generator.poles(), [0.25, 0.5]);
    assert_eq!(generator.complex_poles(), real);
}

#[test]
fn poles_that_do_not_fit_are_refused() {
    let model = plain_model("y");
    let lone = [Complex::new(0.1, 0.2), Complex::new(0.1, 0.2)];
    let error = PlacementError::Unpaired {
        index: 0,
        found: lone[0],
    };
    assert_eq!(place_complex(&model, &lone), Err(error.into()));
    assert_eq!(
        place_complex(&model, &lone[..1]),
        Err(FdiError::PoleCount {
            expected: 2,
            found: 1
        })
    );
    let outside = place_complex(&model, &pair(0.6, 0.8));
    assert_eq!(
        outside,
        Err(FdiError::PoleOutside {
            index: 0,
            found: 1.0
        })
    );
    let nan = place_complex(&model, &pair(f64::NAN, 0.1));
    assert!(matches!(nan, Err(FdiError::PoleOutside { index: 0, .. })));
}

/// Real poles are numbers in a file, as they always were; others are pairs.
#[test]
fn files_hold_pairs_only_where_they_must() {
    let old = serde_json::to_value(plain_generator("y")).unwrap();
    assert_eq!(old["poles"], serde_json::json!([0.4, 0.4]));
    let read: ResidualGenerator = serde_json::from_value(old).unwrap();
    assert_eq!(read, plain_generator("y"));

    let point = OperatingPoint::zero(2, 1);
    let poles = pair(0.5, 0.25);
    let generator = ResidualGenerator::observer_complex(plain_model("y"), point, &poles).unwrap();
    assert_eq!(generator.poles(), &[] as &[f64]);
    let json = serde_json::to_value(&generator).unwrap();
    assert_eq!(
        json["poles"],
        serde_json::json!([[0.5, 0.25], [0.5, -0.25]])
    );
    let back: ResidualGenerator = serde_json::from_value(json.clone()).unwrap();
    assert_eq!(back, generator);
    assert_eq!(back.complex_poles(), poles);

    let error = |poles: serde_json::Value| {
        let mut changed = json.clone();
        changed["poles"] = poles;
        let read = serde_json::from_value::<ResidualGenerator>(changed);
        read.unwrap_err().to_string()
    };
    let other = error(serde_json::json!([[0.5, 0.2], [0.5, -0.2]]));
    assert!(other.contains("expected that of its poles"), "{other}");
    let lone = error(serde_json::json!([[0.5, 0.2], [0.5, 0.2]]));
    assert!(lone.contains("expected its complex conjugate"), "{lone}");
}

/// A bank takes the observer like any other: the file gives the same bank, the online detector the
/// same residuals.
#[test]
fn banks_take_observers_with_complex_poles() {
    let point = OperatingPoint {
        u: DVector::from_vec(vec![10.0, -3.0]),
        y: DVector::from_vec(vec![100.0]),
    };
    let generator =
        ResidualGenerator::observer_complex(plain_model("q"), point, &pair(0.5, 0.25)).unwrap();
    let rule = ThresholdRule::Margin {
        factor: 2.0,
        consecutive: 2,
    };
    let data = record(1);
    let test = limit_on(&generator, &[record(2)], rule).unwrap();
    let bank = Bank::new("test", vec![generator.clone()], vec![test]).unwrap();
    let json = serde_json::to_string(&bank).unwrap();
    assert_eq!(serde_json::from_str::<Bank>(&json).unwrap(), bank);
    let residual = generator.residuals(&data).unwrap().row(0).transpose();
    let run = bank.run(&data).unwrap();
    let online: Vec<f64> = run.residuals.row(0).iter().copied().collect();
    assert_eq!(online, residual.as_slice());
}

proptest! {
    /// The trace and the determinant of `A - K C` of two states are sum and product of the poles.
    #[test]
    fn prop_a_pair_is_placed(re in -0.7_f64..0.7, im in 0.0_f64..0.7) {
        let model = plain_model("y");
        let gain = place_complex(&model, &pair(re, im)).unwrap();
        let closed = model.a() - gain * model.c();
        prop_assert!((closed.trace() - 2.0 * re).abs() < 1e-14);
        prop_assert!((closed.determinant() - re * re - im * im).abs() < 1e-14);
    }
}
