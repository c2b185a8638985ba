//! The errors-in-variables model: its relation is an ARX model, its noise is checked.

use gt_core::Dataset;
use gt_ident::eiv::{ChannelNoise, EivLags, EivModel, EivRow};
use gt_ident::{IdentError, validate};
use nalgebra::{DMatrix, DVector};

use crate::common::{generator, normal_matrix, signals};

const QUIET: ChannelNoise = ChannelNoise {
    variance: 0.0,
    standard_error: None,
    at_limit: false,
};

/// Two relations of orders 2 and 1, the second input acting at once.
fn relations() -> [EivRow; 2] {
    let row = |order, theta: &[f64]| {
        let lags = EivLags::new(order, vec![1, 0]).unwrap();
        EivRow::new(lags, DVector::from_row_slice(theta)).unwrap()
    };
    [
        row(2, &[-1.2, 0.5, 1.0, 0.5, 0.3, -0.6, 0.8]),
        row(1, &[0.4, -0.7, 0.2, 0.9]),
    ]
}

/// A record without noise, written out from the definition of the relation.
fn exact_record(rows: &[EivRow]) -> Dataset {
    let samples = 300;
    let u = normal_matrix(&mut generator(5), 2, samples);
    let mut y = DMatrix::zeros(2, samples);
    for t in 0..samples {
        for (output, row) in rows.iter().enumerate() {
            let mut value = 0.0;
            for (k, a) in row.a().iter().enumerate().filter(|(k, _)| *k < t) {
                value -= a * y[(output, t - k - 1)];
            }
            for input in 0..2 {
                for (k, b) in row.b(input).iter().enumerate() {
                    let lag = row.lags().nk()[input] + k;
                    if lag <= t {
                        value += b * u[(input, t - lag)];
                    }
                }
            }
            y[(output, t)] = value;
        }
    }
    Dataset::new(signals("u", 2), signals("y", 2), u, y, 0.1).unwrap()
}

#[test]
fn the_relation_is_an_arx_model_of_the_same_outputs() {
    let rows = relations();
    let data = exact_record(&rows);
    let model = EivModel::from_rows(&data, &rows, None, vec![QUIET; 2], vec![QUIET; 2]).unwrap();
    let fits = validate(model.relation(), &data).unwrap();
    for fit in &fits.outputs {
        // The means of the record are removed, and the relation holds for the whole signals: what
        // is left is a constant, (1 + sum a) mean y - (sum b) mean u, the record's start over 300.
        assert!(fit.fit_simulation_percent.unwrap() > 99.0, "{fit:?}");
    }
    // The shorter relation has zeros where it has no lag.
    let second = &model.relation().rows()[1];
    let at = |lag: usize| second.terms.iter().filter(move |term| term.lag == lag);
    assert!(at(2).all(|term| term.coefficient == 0.0));
    assert_eq!(
        at(1).map(|term| term.coefficient).collect::<Vec<_>>(),
        [-0.4, -0.7, 0.9]
    );
    assert_eq!(model.relation().max_lag(), 2);
    let names: Vec<&str> = model
        .noise()
        .map(|(signal, _)| signal.name.as_str())
        .collect();
    assert_eq!(names, ["y1", "y2", "u1", "u2"]);
}

#[test]
fn what_does_not_fit_is_refused() {
    let rows = relations();
    let data = exact_record(&rows);
    let model = |rows: &[EivRow], outputs: usize, noise: ChannelNoise| {
        EivModel::from_rows(&data, rows, None, vec![noise; outputs], vec![QUIET; 2])
    };
    let text = |result: Result<EivModel, IdentError>| result.unwrap_err().to_string();
    assert_eq!(
        text(model(&rows[..1], 2, QUIET)),
        "relations (outputs): expected 2, found 1"
    );
    assert_eq!(
        text(model(&rows, 1, QUIET)),
        "output noise: expected 2, found 1"
    );
    let infinite = ChannelNoise {
        standard_error: Some(f64::INFINITY),
        ..QUIET
    };
    assert_eq!(
        text(model(&rows, 2, infinite)),
        "noise of `y1`, standard error of the variance: expected a finite number of at least 0, \
         found inf"
    );
    assert_eq!(EivLags::new(0, vec![1]), Err(IdentError::EivOrder));
    let late = IdentError::EivLag {
        input: 1,
        order: 2,
        found: 3,
    };
    assert_eq!(EivLags::new(2, vec![1, 3]), Err(late));
}

#[test]
fn a_variance_is_told_where_its_error_is_at_most_half_of_it() {
    let noise = |standard_error, at_limit| ChannelNoise {
        variance: 2.0,
        standard_error,
        at_limit,
    };
    assert_eq!(noise(Some(1.0), false).identifiable(), Some(true));
    assert_eq!(noise(Some(1.01), false).identifiable(), Some(false));
    assert_eq!(noise(None, false).identifiable(), None);
    assert_eq!(noise(None, true).identifiable(), Some(false));
}
