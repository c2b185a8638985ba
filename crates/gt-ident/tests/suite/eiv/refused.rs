//! Every way to ask an errors-in-variables fit for the impossible, with the exact error.

use gt_core::{DataError, Dataset, DimensionError};
use gt_ident::IdentError;
use gt_ident::eiv::{Eiv, EivLags, Likelihood, NOISE_FLOOR, NoiseVariances, Spectrum};
use nalgebra::{Complex, DMatrix, DVector};

use super::system::{m1, row, s1};

fn changed(data: &Dataset, change: impl Fn(&mut DMatrix<f64>, &mut DMatrix<f64>)) -> Dataset {
    let (mut u, mut y) = (data.u().clone(), data.y().clone());
    change(&mut u, &mut y);
    let (inputs, outputs) = (data.inputs().to_vec(), data.outputs().to_vec());
    Dataset::new(inputs, outputs, u, y, data.sample_time_s()).unwrap()
}

fn two_inputs(change: impl Fn(&mut DMatrix<f64>, &mut DMatrix<f64>)) -> IdentError {
    let system = m1(20.0);
    let data = changed(&system.record(300, 51, 0), change);
    Eiv::new(system.lags()).fit(&data).unwrap_err()
}

#[test]
fn records_that_cannot_be_used_are_refused() {
    assert_eq!(
        two_inputs(|u, _| u[(1, 17)] = f64::INFINITY),
        IdentError::Data(DataError::NotFinite {
            channel: "u2".into(),
            sample: 17,
            found: f64::INFINITY
        })
    );
    assert_eq!(
        two_inputs(|u, _| u.row_mut(0).fill(4.5)),
        IdentError::ConstantChannel {
            channel: "u1".into(),
            value: 4.5
        }
    );
    assert_eq!(
        two_inputs(|_, y| y.fill(-2.0)),
        IdentError::ConstantChannel {
            channel: "y1".into(),
            value: -2.0
        }
    );
    let IdentError::EivDetermined {
        channel,
        found,
        limit,
    } = two_inputs(|u, _| {
        let first = u.row(0).into_owned() * 3.0;
        u.set_row(1, &first);
    })
    else {
        panic!("two equal channels were fitted");
    };
    assert_eq!((channel.as_str(), limit), ("u2", NOISE_FLOOR));
    assert!(found < NOISE_FLOOR);
    // A periodic input is known from its past.
    let error = two_inputs(|u, _| {
        for t in 0..u.ncols() {
            u[(0, t)] = (0.3 * t as f64).sin();
        }
    });
    assert!(
        matches!(&error, IdentError::EivDetermined { channel, .. } if channel == "u1"),
        "{error}"
    );
    assert!(matches!(
        two_inputs(|u, _| u.row_mut(0).scale_mut(1e-320)),
        IdentError::EivScale { channel, .. } if channel == "u1"
    ));
}

#[test]
fn records_that_are_too_short_are_refused() {
    let system = s1(20.0);
    let data = system.record(15, 52, 0);
    let short = |samples| data.rows(0..samples).unwrap();
    // p = 4: three columns of four lags, and a row for each of two residuals and one to spare.
    assert_eq!(
        Eiv::new(system.lags()).fit(&short(14)).unwrap_err(),
        IdentError::EivTooFewSamples {
            needed: 15,
            found: 14
        }
    );
    assert!(Eiv::new(system.lags()).fit(&short(15)).is_ok());
    assert_eq!(
        Eiv::new(system.lags())
            .autoregression_order(usize::MAX)
            .fit(&data)
            .unwrap_err(),
        IdentError::EivTooFewSamples {
            needed: usize::MAX,
            found: 15
        }
    );
    // Nothing of the size of the order is allocated first.
    let endless = EivLags::new(usize::MAX, vec![usize::MAX]).unwrap();
    assert_eq!(
        Eiv::new(vec![endless]).fit(&data).unwrap_err(),
        IdentError::EivTooFewSamples {
            needed: usize::MAX,
            found: 15
        }
    );
}

#[test]
fn structures_that_do_not_fit_are_refused() {
    let system = s1(20.0);
    let data = system.record(300, 53, 0);
    let lags = |order, nk: &[usize]| EivLags::new(order, nk.to_vec()).unwrap();
    let refused = |rows: Vec<EivLags>| Eiv::new(rows).fit(&data).unwrap_err();
    assert_eq!(refused(vec![]), IdentError::NoOutputs);
    assert_eq!(refused(vec![lags(2, &[])]), IdentError::NoInputs);
    for (rows, what, expected, found) in [
        (vec![lags(2, &[1]); 2], "outputs of the structure", 1, 2),
        (vec![lags(2, &[1, 1])], "inputs of the structure", 1, 2),
    ] {
        let error = DimensionError::check(what, expected, found).unwrap_err();
        assert_eq!(refused(rows), IdentError::Dimension(error));
    }
    // Rows of one model share its inputs.
    let rows = [lags(2, &[1]), lags(2, &[1, 1])];
    let spectrum = system.spectrum(4).unwrap();
    let error = DimensionError::check("inputs of an errors-in-variables row", 1, 2).unwrap_err();
    assert_eq!(
        Likelihood::new(&rows, &spectrum).unwrap_err(),
        IdentError::Dimension(error)
    );
}

#[test]
fn starts_that_do_not_fit_are_refused() {
    let system = s1(20.0);
    let data = system.record(300, 54, 0);
    let noise = |output: f64, inputs: &[f64]| NoiseVariances {
        output,
        inputs: DVector::from_column_slice(inputs),
    };
    let good = (system.rows[0].clone(), noise(1.0, &[0.1]));
    let refused = |start| {
        let model = Eiv::new(system.lags())
            .start(vec![good.clone()])
            .start(start);
        model.fit(&data).unwrap_err()
    };
    let other = row(&[-0.5], &[&[1.0]]);
    assert_eq!(
        refused(vec![(other, noise(1.0, &[0.1]))]),
        IdentError::EivStartLags {
            start: 1,
            output: 0
        }
    );
    for (what, start) in [
        ("outputs of a starting point", vec![]),
        (
            "outputs of a starting point",
            vec![good.clone(), good.clone()],
        ),
        (
            "input variances of a starting point",
            vec![(good.0.clone(), noise(1.0, &[0.1, 0.1]))],
        ),
    ] {
        let found = if start.is_empty() { 0 } else { 2 };
        let error = DimensionError::check(what, 1, found).unwrap_err();
        assert_eq!(refused(start), IdentError::Dimension(error));
    }
    let wild = row(&[-1.5, f64::INFINITY], &[&[1.0, 0.5]]);
    for (start, found) in [
        ((wild, noise(1.0, &[0.1])), f64::INFINITY),
        ((good.0.clone(), noise(-1.0, &[0.1])), -1.0),
        (
            (good.0.clone(), noise(1.0, &[f64::INFINITY])),
            f64::INFINITY,
        ),
    ] {
        assert_eq!(
            refused(vec![start]),
            IdentError::EivStartValue {
                start: 1,
                output: 0,
                found
            }
        );
    }
}

#[test]
fn spectra_that_are_none_are_refused() {
    let diagonal = |values: [f64; 2]| {
        DMatrix::from_diagonal(&DVector::from_column_slice(&values)).map(Complex::from)
    };
    assert_eq!(
        Spectrum::from_fn(2, 4, |w| diagonal([1.0, 2.0 - w])).unwrap_err(),
        IdentError::SpectrumNotPositive { index: 3 }
    );
    let error = DimensionError::check("rows of a spectrum", 3, 2).unwrap_err();
    assert_eq!(
        Spectrum::from_fn(3, 4, |_| diagonal([1.0, 1.0])).unwrap_err(),
        IdentError::Dimension(error)
    );
    let white = Spectrum::from_fn(2, 4, |_| diagonal([1.0, 1.0])).unwrap();
    assert!((white.frequency(0) - std::f64::consts::PI / 8.0).abs() < 1e-15);
    let lags = m1(20.0).lags();
    let error = DimensionError::check("channels of the spectrum (outputs and inputs)", 3, 2);
    assert_eq!(
        Likelihood::new(&lags, &white).unwrap_err(),
        IdentError::Dimension(error.unwrap_err())
    );
    let lags = s1(20.0).lags();
    let mut likelihood = Likelihood::new(&lags, &white).unwrap();
    assert_eq!(likelihood.parameters(), 6);
    assert!(matches!(
        likelihood.gradient(&[0.0; 5]).unwrap_err(),
        IdentError::Dimension(_)
    ));
}
