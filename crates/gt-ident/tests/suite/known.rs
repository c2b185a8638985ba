//! Models with given coefficients, and records of given errors, for the tests of validation.

use gt_core::Dataset;
use gt_ident::{Arx, ArxModel, ArxStructure, CanonicalForm};
use nalgebra::DMatrix;
use rand_chacha::ChaCha8Rng;

use crate::common::*;

/// A model of the given structure and coefficients, a row an output; sample time `0.5 s`,
/// operating point 0, `rows_used` samples in its fit.
pub fn known_model(
    structure: ArxStructure,
    nu: usize,
    coefficients: &[&[f64]],
    rows_used: usize,
) -> ArxModel {
    let mut rng = generator(99);
    let (u, y) = (
        normal_matrix(&mut rng, nu, 300),
        normal_matrix(&mut rng, coefficients.len(), 300),
    );
    let data = dataset(u, y);
    let fitted = Arx::new(structure).fit(&data).unwrap();
    let mut value = serde_json::to_value(&fitted).unwrap();
    for (row, list) in coefficients.iter().enumerate() {
        let terms = value["rows"][row]["terms"].as_array_mut().unwrap();
        assert_eq!(terms.len(), list.len());
        for (term, &coefficient) in terms.iter_mut().zip(*list) {
            term["coefficient"] = coefficient.into();
        }
    }
    value["rows_used"] = rows_used.into();
    for side in ["u", "y"] {
        let point = value["operating_point"][side][0].as_array_mut().unwrap();
        for entry in point.iter_mut() {
            *entry = 0.0.into();
        }
    }
    serde_json::from_value(value).unwrap()
}

pub fn dataset(u: DMatrix<f64>, y: DMatrix<f64>) -> Dataset {
    Dataset::new(signals("u", u.nrows()), signals("y", y.nrows()), u, y, 0.5).unwrap()
}

pub fn diagonal(na: usize, nb: usize) -> ArxStructure {
    ArxStructure::Diagonal {
        na,
        nb: vec![nb],
        nk: vec![1],
    }
}

pub fn full(na: usize, nb: usize) -> ArxStructure {
    ArxStructure::Full {
        na,
        nb: vec![nb],
        nk: vec![1],
    }
}

/// First-order coloured rows, `x(t) = pole x(t - 1) + w(t)`.
pub fn coloured(white: &DMatrix<f64>, pole: f64) -> DMatrix<f64> {
    let mut x = white.clone();
    for t in 1..x.ncols() {
        for row in 0..x.nrows() {
            x[(row, t)] += pole * x[(row, t - 1)];
        }
    }
    x
}

/// The record of a system under inputs and equation errors, without its first 200 samples.
pub fn settled(form: &CanonicalForm, u: &DMatrix<f64>, e: &DMatrix<f64>) -> Dataset {
    let y = difference_equation(form, u, e);
    let keep = u.ncols() - 200;
    dataset(
        u.columns(200, keep).into_owned(),
        y.columns(200, keep).into_owned(),
    )
}

/// `y(t) = 1.5 y(t-1) - 0.7 y(t-2) + u(t-1) + 0.5 u(t-2) + e(t)`.
pub fn second_order(gain: f64) -> CanonicalForm {
    CanonicalForm::new(
        vec![2],
        vec![vec![vec![-0.7, 1.5]]],
        vec![vec![vec![0.5 * gain], vec![gain]]],
    )
    .unwrap()
}

/// A record of [`second_order`] with the given input colour and unit errors.
pub fn second_order_record(rng: &mut ChaCha8Rng, gain: f64, pole: f64, samples: usize) -> Dataset {
    let u = coloured(&normal_matrix(rng, 1, samples + 200), pole);
    let e = normal_matrix(rng, 1, samples + 200);
    settled(&second_order(gain), &u, &e)
}
