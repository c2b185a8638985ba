//! Pole placement for several outputs.

use std::path::PathBuf;

use gt_core::{Signal, StateSpace};
use gt_fdi::FdiError;
use gt_fdi::design::{PlacementError, SchurPlacement, StabilityBound, place_complex};
use nalgebra::{Complex, DMatrix};
use proptest::prelude::*;

use crate::fixtures::{TS, canonical, noise, rows};

fn real(poles: &[f64]) -> Vec<Complex<f64>> {
    poles.iter().map(|&re| Complex::new(re, 0.0)).collect()
}

/// The eigenvalues of a matrix, by real and then by imaginary part.
fn eigenvalues(a: &DMatrix<f64>) -> Vec<Complex<f64>> {
    let inputs = DMatrix::zeros(a.nrows(), 0);
    let outputs = DMatrix::zeros(0, a.nrows());
    let matrices = [a.clone(), inputs, outputs, DMatrix::zeros(0, 0)];
    let model = StateSpace::new(matrices, TS, vec![], vec![]).unwrap();
    sorted(model.poles().unwrap())
}

fn sorted(mut values: Vec<Complex<f64>>) -> Vec<Complex<f64>> {
    values.sort_by(|l, r| l.re.total_cmp(&r.re).then(l.im.total_cmp(&r.im)));
    values
}

/// The largest distance between a value and the one that is paired with it, nearest first.
fn apart(found: &[Complex<f64>], expected: &[Complex<f64>]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let mut left = expected.to_vec();
    let mut worst = 0.0_f64;
    for value in found {
        let nearest = |l: &&usize, r: &&usize| {
            (left[**l] - value)
                .norm()
                .total_cmp(&(left[**r] - value).norm())
        };
        let indices: Vec<usize> = (0..left.len()).collect();
        let index = *indices.iter().min_by(nearest).unwrap();
        worst = worst.max((left.remove(index) - value).norm());
    }
    worst
}

fn model(a: DMatrix<f64>, c: DMatrix<f64>) -> StateSpace {
    let names: Vec<String> = (0..c.nrows()).map(|i| format!("y{i}")).collect();
    let (b, d) = (DMatrix::zeros(a.nrows(), 0), DMatrix::zeros(c.nrows(), 0));
    StateSpace::new([a, b, c, d], TS, vec![], Signal::named(&names)).unwrap()
}

/// The numbers of a file, line by line, without its title.
fn numbers(text: &str) -> Vec<Vec<f64>> {
    let of_line = |line: &str| -> Vec<f64> {
        let words = line.split(|c: char| c.is_whitespace() || "(),".contains(c));
        words.filter_map(|word| word.parse().ok()).collect()
    };
    text.lines()
        .map(of_line)
        .filter(|line| !line.is_empty())
        .collect()
}

/// The example of SLICOT's SB01BD in continuous time: two eigenvalues with a real part below -0.4
/// stay, two go to -0.5 +- 0.15i. Gain and eigenvalues agree to the four digits that are printed.
#[test]
fn published_slicot_example_of_sb01bd() {
    let Some(folder) = std::env::var_os("GTFDI_REFERENCE_DATA").map(PathBuf::from) else {
        println!("skipped: published_slicot_example_of_sb01bd: GTFDI_REFERENCE_DATA is not set");
        return;
    };
    let read = |name: &str| std::fs::read_to_string(folder.join("slicot").join(name)).unwrap();
    let data = numbers(&read("SB01BD.dat"));
    let (n, m, alpha) = (4, 2, data[0][3]);
    assert_eq!((data[0][0], data[0][1], alpha), (4.0, 2.0, -0.4));
    let a = DMatrix::from_fn(n, n, |i, j| data[1 + i][j]);
    let b = DMatrix::from_fn(n, m, |i, j| data[1 + n + i][j]);
    let poles: Vec<Complex<f64>> = data[1 + 2 * n..]
        .iter()
        .map(|line| Complex::new(line[0], line[1]))
        .collect();
    assert_eq!(poles.len(), 4);

    let bound = StabilityBound::RealPart(alpha);
    let found = SchurPlacement::feedback(&a, &b, bound, &poles).unwrap();
    let text = read("SB01BD.res");
    let printed = |title: &str, lines: usize| {
        let (_, after) = text.split_once(title).expect("the title");
        numbers(after)[..lines].to_vec()
    };
    let f = printed("The state feedback matrix F is", m);
    let f = DMatrix::from_fn(m, n, |i, j| f[i][j]);
    assert!((&found.gain - &f).amax() <= 0.5e-4, "{} {f}", found.gain);
    let expected: Vec<Complex<f64>> = printed("eigenvalues of closed-loop matrix A+B*F", n)
        .iter()
        .map(|line| Complex::new(line[line.len() - 2], line[line.len() - 1]))
        .collect();
    let closed = &a + &b * &found.gain;
    for (value, expected) in eigenvalues(&closed).iter().zip(sorted(expected)) {
        let rounded = |x: f64, y: f64| (x - y).abs() <= 0.5e-4;
        assert!(
            rounded(value.re, expected.re) && rounded(value.im, expected.im),
            "{value}"
        );
    }
    assert_eq!((found.assigned.len(), found.kept.len()), (2, 2));
}

/// One output leaves nothing to choose: the gain is that of the canonical form.
#[test]
fn one_output_has_the_only_gain_there_is() {
    let open = [0.95, 0.7, 0.2, -0.3, -0.6];
    let t = DMatrix::identity(5, 5) + 0.2 * DMatrix::from_vec(5, 5, noise(5, 25));
    let plain = canonical(&open, DMatrix::zeros(5, 0), DMatrix::zeros(1, 0), "y");
    let model = crate::fixtures::transformed(&plain, &t);
    let pair = Complex::new(0.4, 0.3);
    for poles in [
        vec![
            pair,
            Complex::new(0.1, 0.0),
            pair.conj(),
            Complex::new(-0.2, 0.0),
            Complex::new(0.5, 0.0),
        ],
        vec![pair, pair.conj(), pair, pair.conj(), Complex::new(0.5, 0.0)],
        real(&[0.5; 5]),
    ] {
        let expected = place_complex(&model, &poles).unwrap();
        let found = SchurPlacement::observer(&model, 0.0, &poles).unwrap();
        // The condition of the observability matrix is of the order of 1e3.
        let error = (found.gain.column(0) - &expected).amax() / expected.amax();
        assert!(error < 1e-10, "{error:e}");
        assert!(found.kept.is_empty());
    }
}

/// Both modes of a diagonal model have an output each, so the least gain is known: a mode inside
/// the radius has none, the other what it takes.
#[test]
fn modes_inside_the_radius_are_left_alone() {
    let model = model(
        rows([[0.5, 0.0], [0.0, 0.9]]),
        rows([[1.0, 0.0], [0.0, 2.0]]),
    );
    let found = SchurPlacement::observer(&model, 0.8, &real(&[0.3])).unwrap();
    assert!(
        (&found.gain - rows([[0.0, 0.0], [0.0, 0.3]])).amax() < 1e-15,
        "{}",
        found.gain
    );
    assert_eq!((found.assigned, found.kept), (real(&[0.3]), real(&[0.5])));
}

#[test]
fn the_same_model_has_the_same_gain_bit_for_bit() {
    let draws = noise(11, 60);
    let model = model(
        DMatrix::from_column_slice(6, 6, &draws[..36]),
        DMatrix::from_column_slice(3, 6, &draws[36..54]),
    );
    let poles = real(&[0.1, 0.2, 0.3, 0.4, 0.5, 0.6]);
    let place = || SchurPlacement::observer(&model, 0.0, &poles).unwrap().gain;
    assert_eq!(place(), place());
}

#[test]
fn errors_name_what_was_expected_and_found() {
    let model = model(
        rows([[0.95, 1.0], [0.0, 0.9]]),
        rows([[1.0, 0.0], [0.0, 1.0]]),
    );
    let place = |radius: f64, poles: &[Complex<f64>]| {
        SchurPlacement::observer(&model, radius, poles).unwrap_err()
    };
    let placement = |error: PlacementError| FdiError::Placement(error);
    let i = |re: f64, im: f64| Complex::new(re, im);
    assert_eq!(
        place(0.5, &real(&[0.1])),
        placement(PlacementError::TooFew {
            expected: 2,
            found: 1
        })
    );
    let lone = place(0.5, &[i(0.1, 0.2), i(0.1, 0.3)]);
    assert_eq!(
        lone,
        placement(PlacementError::Unpaired {
            index: 0,
            found: i(0.1, 0.2)
        })
    );
    assert_eq!(
        lone.to_string(),
        "pole 0, 0.1+0.2i: expected its complex conjugate in the list too, found none"
    );
    assert_eq!(
        place(0.5, &[i(0.3, 0.0), i(0.1, 0.2), i(0.1, -0.2)]),
        placement(PlacementError::SplitPair {
            used: 2,
            index: 1,
            found: i(0.1, 0.2)
        })
    );
    assert_eq!(
        place(0.5, &real(&[0.1, 1.5])),
        FdiError::PoleOutside {
            index: 1,
            found: 1.5
        }
    );
    assert_eq!(
        place(1.5, &real(&[0.1, 0.5])),
        FdiError::Option {
            option: "radius",
            expected: "a radius from 0 to 1",
            found: 1.5
        }
    );
    let a = rows([[0.5, f64::INFINITY], [0.0, 0.2]]);
    let b = rows([[1.0], [1.0]]);
    let bound = StabilityBound::RealPart(0.0);
    let entry = PlacementError::Entry {
        matrix: "A",
        row: 0,
        column: 1,
        found: f64::INFINITY,
    };
    let feedback = |a: &DMatrix<f64>, b: &DMatrix<f64>, bound, poles: &[Complex<f64>]| {
        SchurPlacement::feedback(a, b, bound, poles).unwrap_err()
    };
    assert_eq!(feedback(&a, &b, bound, &[]), placement(entry));
    let a = rows([[0.5, 0.0], [0.0, 0.2]]);
    assert_eq!(
        feedback(&a, &rows([[1.0]]), bound, &[]).to_string(),
        "rows of B: expected 2, found 1"
    );
    let nan = feedback(&a, &b, StabilityBound::Modulus(f64::NAN), &[]);
    assert!(
        nan.to_string()
            .starts_with("bound of the eigenvalues that stay: expected a radius")
    );
    let infinite = feedback(&a, &b, bound, &[i(f64::INFINITY, 0.0)]);
    assert!(matches!(
        infinite,
        FdiError::Placement(PlacementError::NotFinite { index: 0, .. })
    ));
}

/// A mode that no output shows stays where it is, inside the radius, or is named.
#[test]
fn hidden_modes_are_named_unless_they_may_stay() {
    let hidden = model(
        rows([[0.5, 0.0], [0.0, 0.9]]),
        rows([[0.0, 1.0], [0.0, 2.0]]),
    );
    let found = SchurPlacement::observer(&hidden, 0.8, &real(&[0.3])).unwrap();
    assert!((found.kept[0].re - 0.5).abs() < 1e-15);
    let error = SchurPlacement::observer(&hidden, 0.4, &real(&[0.3, 0.2])).unwrap_err();
    match error {
        FdiError::Placement(PlacementError::Fixed {
            found,
            reach,
            limit,
        }) => {
            assert!((found.re - 0.5).abs() < 1e-15);
            assert!(reach <= limit && limit < 1e-14, "{reach} {limit}");
        }
        other => panic!("{other:?}"),
    }
    // Two real modes that have to move together, one of them hidden.
    let pair = [Complex::new(0.1, 0.2), Complex::new(0.1, -0.2)];
    let error = SchurPlacement::observer(&hidden, 0.4, &pair).unwrap_err();
    assert!(
        matches!(error, FdiError::Placement(PlacementError::Fixed { .. })),
        "{error:?}"
    );
}

proptest! {
    /// Closed-loop eigenvalues are the poles and those that stay, whatever the model's are.
    #[test]
    fn prop_eigenvalues_are_the_poles_and_those_inside_the_radius(
        nx in 1_usize..8,
        ny in 1_usize..4,
        radius in prop_oneof![Just(0.0), 0.3_f64..1.0],
        seed in any::<u64>(),
    ) {
        let draws = noise(seed, nx * nx + ny * nx + 2 * nx);
        let a = DMatrix::from_column_slice(nx, nx, &draws[..nx * nx]) / (nx as f64).sqrt();
        let c = DMatrix::from_column_slice(ny, nx, &draws[nx * nx..nx * nx + ny * nx]);
        let open = eigenvalues(&a);
        let moved = open.iter().filter(|value| value.norm() >= radius).count();
        // Distinct poles: half of them in pairs where the number allows it.
        let mut poles: Vec<Complex<f64>> = Vec::new();
        while poles.len() < moved {
            let place = 0.8 * (poles.len() as f64 + 1.0) / (moved as f64 + 1.0);
            if poles.len() % 3 == 1 && poles.len() + 1 < moved {
                poles.extend([0.3, -0.3].map(|im| Complex::new(place - 0.2, im)));
            } else {
                poles.push(Complex::new(place, 0.0));
            }
        }
        let model = model(a.clone(), c.clone());
        let found = SchurPlacement::observer(&model, radius, &poles).unwrap();
        let closed = &a - &found.gain * &c;
        let mut expected = poles.clone();
        expected.extend(open.iter().filter(|value| value.norm() < radius));
        let error = apart(&eigenvalues(&closed), &expected);
        // One output needs gains of up to 1e5 for eight poles, and eigenvalues feel all of them: up
        // to 1.5e-10 of the square among 20 000 cases, 1e-15 in half of them.
        let allowed = 1e-9 * (1.0 + found.gain.norm()).powi(2);
        prop_assert!(error < allowed, "{error:e} {:e}", found.gain.norm());
        prop_assert_eq!(found.assigned.len(), moved);
        prop_assert_eq!(found.kept.len(), nx - moved);
    }
}
