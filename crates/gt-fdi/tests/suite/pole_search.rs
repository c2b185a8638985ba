//! The search for an observer's poles.

use gt_fdi::FdiError;
use gt_fdi::design::{
    Criterion, EnergyRatio, ObserverDesign, PoleSearch, RecordPair, ResidualGenerator, SearchError,
    SearchMethod, Sections, Start,
};
use nalgebra::{Complex, DMatrix};

use crate::fixtures::canonical;
use crate::toys::{Fault, Records, Toy};

const BOTH: [Criterion; 2] = [Criterion::Paper, Criterion::FaultEnergy];

fn toys() -> Vec<Toy> {
    let four = [0.95, 0.8, 0.5, 0.2];
    vec![
        Toy::new(&[0.9], Fault::Ramp(0.5)),
        Toy::new(&[0.9, 0.6], Fault::Ramp(0.5)),
        Toy::new(&[0.9, 0.6, -0.3], Fault::Ramp(0.5)),
        Toy::new(&four, Fault::Ramp(0.5)),
        Toy::new(&four, Fault::Bias(0.3)),
        Toy::new(&[0.9, 0.6], Fault::Component(0.01)),
        Toy::new(&four, Fault::Component(0.001)),
        Toy::new(&[0.95, 0.8, 0.5, 0.2, -0.4], Fault::Component(0.001)),
    ]
}

fn design(search: &PoleSearch, toy: &Toy, records: &Records) -> ObserverDesign {
    search
        .design(&toy.model, &Toy::point(), &[records.pair()], &[])
        .unwrap()
}

/// The least of the attempts that begin where `chosen` says.
fn least(design: &ObserverDesign, chosen: impl Fn(Start) -> bool) -> f64 {
    let attempts = design.attempts.iter();
    let found = attempts.filter(|attempt| chosen(attempt.start));
    found.map(|attempt| attempt.v).fold(f64::INFINITY, f64::min)
}

/// Descents from all starts are never behind the evolution, at a fraction of what it spends where
/// minima are not corners; what they found is a minimum over their attempts and above the bound.
#[test]
fn descents_are_never_worse_than_evolution() {
    for (index, toy) in toys().iter().enumerate() {
        let records = toy.records(7, 500);
        for criterion in BOTH {
            let descent = PoleSearch {
                criterion,
                ..PoleSearch::default()
            };
            let evolution = PoleSearch {
                method: SearchMethod::Evolution,
                ..descent.clone()
            };
            let found = design(&descent, toy, &records);
            let evolved = design(&evolution, toy, &records);
            println!(
                "toy {index}, {criterion:?}: V {:.6e} in {} evaluations from {} starts, {:?}; \
                 evolution {:+.1e} in {}; bound {:.6e}",
                found.v,
                found.evaluations,
                found.attempts.len(),
                found.start,
                evolved.v / found.v - 1.0,
                evolved.evaluations,
                found.bound.value
            );
            assert!(found.v <= evolved.v * (1.0 + 1e-9), "toy {index}");
            assert_eq!(evolved.start, Start::Evolution);
            let spent: usize = found
                .attempts
                .iter()
                .map(|attempt| attempt.evaluations)
                .sum();
            assert_eq!(found.evaluations, spent);
            assert_eq!(found.v, least(&found, |_| true));
            assert_eq!(found.v, least(&found, |start| start == found.start));
            for design in [&found, &evolved] {
                assert!(design.bound.value <= design.v * (1.0 + 1e-9), "toy {index}");
                let radius = |pole: &Complex<f64>| pole.norm() <= 0.97 + 1e-12;
                assert!(design.poles.iter().all(radius), "{:?}", design.poles);
                assert_eq!(design.poles.len(), toy.model.nx());
            }
        }
    }
}

/// The best observer of this plant has all poles at the radius: a corner of the polytope and of the
/// diagonal of equal poles. The evolution and all descents from random starts end 1.3 % above it,
/// each in a minimum of its own; the starts at vertices and on the diagonal find it.
#[test]
fn a_corner_that_searches_from_inside_miss_is_found() {
    let toy = Toy::new(&[0.95, 0.8, 0.5, 0.2], Fault::Ramp(0.5));
    let records = toy.records(7, 500);
    let search = PoleSearch {
        criterion: Criterion::Paper,
        random_starts: 50,
        ..PoleSearch::default()
    };
    let found = design(&search, &toy, &records);
    assert_eq!(found.poles, vec![Complex::new(0.97, 0.0); 4]);
    let random = least(&found, |start| matches!(start, Start::Random { .. }));
    assert!(random > 1.01 * found.v, "{random} {}", found.v);
    let evolution = PoleSearch {
        method: SearchMethod::Evolution,
        ..search
    };
    let evolved = design(&evolution, &toy, &records);
    assert!(evolved.v > 1.01 * found.v, "{} {}", evolved.v, found.v);
    for found_by in [
        least(&found, |start| matches!(start, Start::Vertex { .. })),
        least(&found, |start| matches!(start, Start::Diagonal { .. })),
    ] {
        assert_eq!(found_by, found.v);
    }
}

/// White equation error, and a component fault that is slow: the slowest poles allowed are the best
/// of order two, exactly, from vertices and from random starts alike.
#[test]
fn vertices_are_met_exactly() {
    let toy = Toy::new(&[0.9, 0.6], Fault::Component(0.01));
    let records = toy.records(7, 500);
    for radius in [1e-6, 0.5, 0.8, 0.97] {
        let search = PoleSearch {
            radius,
            ..PoleSearch::default()
        };
        let found = design(&search, &toy, &records);
        // On the real axis, and at the radius but for the rounding of its square.
        let at_vertex = |pole: &Complex<f64>| pole.im == 0.0 && (pole.re - radius).abs() < 1e-15;
        assert!(found.poles.iter().all(at_vertex), "{:?}", found.poles);
        let random = least(&found, |start| matches!(start, Start::Random { .. }));
        assert!(random <= found.v * (1.0 + 1e-12), "{random} {}", found.v);
    }
}

/// A short ramp in noise of the same size: the best single pole is inside the radius, where V is
/// the least of a scan in steps of 1e-5.
#[test]
fn an_interior_minimum_is_that_of_a_scan() {
    let toy = Toy::new(&[0.9], Fault::Ramp(0.5));
    let records = toy.records(7, 100);
    let search = PoleSearch {
        radius: 0.99,
        ..PoleSearch::default()
    };
    let found = design(&search, &toy, &records);
    let pairs = [records.pair()];
    let ratio = EnergyRatio::new(search.criterion, &toy.model, &Toy::point(), &pairs, 0).unwrap();
    let at = |step: i32| {
        let pole = Complex::new(f64::from(step) * 1e-5, 0.0);
        ratio.value(&Sections::from_poles(&[pole]).unwrap())
    };
    let scanned = (-99_000..=99_000).min_by(|l, r| at(*l).total_cmp(&at(*r)));
    let scanned = scanned.unwrap();
    let pole = found.poles[0].re;
    assert!(pole < 0.98, "{pole}");
    assert!((pole - f64::from(scanned) * 1e-5).abs() <= 1e-5, "{pole}");
    assert!(found.v <= at(scanned), "{} {}", found.v, at(scanned));
}

/// A larger radius allows all that a smaller one does.
#[test]
fn v_falls_with_the_radius() {
    for (index, toy) in toys().iter().enumerate() {
        for len in [100, 300] {
            let records = toy.records(7, len);
            let at = |radius: f64| {
                let search = PoleSearch {
                    radius,
                    ..PoleSearch::default()
                };
                design(&search, toy, &records).v
            };
            let found = [0.5, 0.9, 0.95, 0.97, 0.99].map(at);
            let falls = |pair: &[f64]| pair[1] <= pair[0] * (1.0 + 1e-9);
            assert!(found.windows(2).all(falls), "toy {index}, {len}: {found:?}");
        }
    }
}

/// On a short record V falls all the way to the radius, by poles that ring as the noise of that
/// record happens to; on another record of the same plant they are worse and worse.
#[test]
fn overfit_shows_on_the_validation_record() {
    let toy = Toy::new(&[0.9, 0.6], Fault::Ramp(0.5));
    let (records, others) = (toy.records(7, 100), toy.records(8, 100));
    let found = [0.95, 0.97, 0.99, 0.995].map(|radius| {
        let search = PoleSearch {
            radius,
            ..PoleSearch::default()
        };
        search
            .design(
                &toy.model,
                &Toy::point(),
                &[records.pair()],
                &[others.pair()],
            )
            .unwrap()
    });
    for design in &found {
        println!(
            "radius {}: V {:.4}, validation {:.4}, poles {:.4}, bound {:.4}, validation {:.4}",
            design.radius,
            design.v,
            design.v_validation.unwrap(),
            design.poles[0],
            design.bound.value,
            design.bound.validation.unwrap()
        );
    }
    for pair in found.windows(2) {
        assert!(pair[1].v < pair[0].v);
        assert!(pair[1].v_validation > pair[0].v_validation);
    }
    // A lightly damped pair.
    let pole = found[3].poles[0];
    assert!(pole.im.abs() > 0.03 && pole.norm() > 0.99, "{pole}");
    assert!(found[3].v_validation.unwrap() > 2.0 * found[0].v_validation.unwrap());
}

/// What was reported is what the observer does on the records.
#[test]
fn designs_become_generators_with_the_same_v() {
    let toy = Toy::new(&[0.95, 0.8, 0.5, 0.2, -0.4], Fault::Component(0.001));
    let (records, others) = (toy.records(7, 400), toy.records(8, 300));
    let search = PoleSearch {
        criterion: Criterion::Paper,
        radius: 0.9,
        skip_samples: 20,
        ..PoleSearch::default()
    };
    let found = search
        .design(
            &toy.model,
            &Toy::point(),
            &[records.pair()],
            &[others.pair()],
        )
        .unwrap();
    let generator = found.generator(toy.model.clone(), Toy::point()).unwrap();
    assert_eq!(generator.complex_poles(), found.poles);
    for (pair, v) in [
        (records.pair(), found.v),
        (others.pair(), found.v_validation.unwrap()),
    ] {
        let energy = |data| {
            let residual = generator.residuals(data).unwrap().row(0).transpose();
            residual.rows_range(20..).norm_squared()
        };
        let expected = energy(pair.healthy) / energy(pair.faulty);
        // Five poles near 0.9 in the state space and in sections.
        assert!((v / expected - 1.0).abs() < 1e-8, "{v} {expected}");
    }
    let json = serde_json::to_string(&generator).unwrap();
    let back: ResidualGenerator = serde_json::from_str(&json).unwrap();
    assert_eq!(back, generator);
}

/// The same search is the same bit for bit; another seed changes the draws only; starts that are
/// there either way end the same.
#[test]
fn searches_repeat_bit_for_bit() {
    let toy = Toy::new(&[0.95, 0.8, 0.5, 0.2], Fault::Component(0.001));
    let records = toy.records(7, 200);
    let search = PoleSearch::default();
    let found = design(&search, &toy, &records);
    assert_eq!(design(&search, &toy, &records), found);
    let fewer = PoleSearch {
        random_starts: 5,
        ..search.clone()
    };
    let with_fewer = design(&fewer, &toy, &records).attempts;
    assert_eq!(found.attempts[..with_fewer.len()], with_fewer);
    let other = PoleSearch {
        seed: 1,
        ..search.clone()
    };
    let reseeded = design(&other, &toy, &records).attempts;
    let drawn = found.attempts.len() - 20;
    assert_eq!(found.attempts[..drawn], reseeded[..drawn]);
    assert_ne!(found.attempts[drawn..], reseeded[drawn..]);
    let evolution = PoleSearch {
        method: SearchMethod::Evolution,
        ..search
    };
    let evolved = design(&evolution, &toy, &records);
    assert_eq!(design(&evolution, &toy, &records), evolved);
}

/// Several pairs are judged by the sums of their energies.
#[test]
fn several_pairs_share_one_ratio() {
    let toy = Toy::new(&[0.9, 0.6], Fault::Component(0.01));
    let (first, second) = (toy.records(1, 200), toy.records(2, 300));
    let pairs = [first.pair(), second.pair()];
    let search = PoleSearch::default();
    let found = search
        .design(&toy.model, &Toy::point(), &pairs, &pairs)
        .unwrap();
    assert_eq!(found.v_validation, Some(found.v));
    let sections = Sections::from_poles(&found.poles).unwrap();
    let alone = pairs.map(|pair| {
        EnergyRatio::new(search.criterion, &toy.model, &Toy::point(), &[pair], 0)
            .unwrap()
            .value(&sections)
    });
    let (low, high) = (alone[0].min(alone[1]), alone[0].max(alone[1]));
    assert!(low < found.v && found.v < high, "{low} {} {high}", found.v);
}

fn refused(search: &PoleSearch, pairs: &[RecordPair], validation: &[RecordPair]) -> FdiError {
    let toy = Toy::new(&[0.9, 0.6], Fault::Bias(1.0));
    search
        .design(&toy.model, &Toy::point(), pairs, validation)
        .unwrap_err()
}

#[test]
fn options_and_records_that_do_not_fit_are_refused() {
    let toy = Toy::new(&[0.9, 0.6], Fault::Bias(1.0));
    let (long, short) = (toy.records(1, 60), toy.records(1, 9));
    let pairs = [long.pair()];
    for radius in [0.0, 1.0, -0.5, 1.5, f64::NAN] {
        let search = PoleSearch {
            radius,
            ..PoleSearch::default()
        };
        let error = refused(&search, &pairs, &[]);
        assert!(
            matches!(
                error,
                FdiError::Option {
                    option: "radius",
                    ..
                }
            ),
            "{error:?}"
        );
    }
    for (search, option) in [
        (
            PoleSearch {
                bound_pole: 1.0,
                ..PoleSearch::default()
            },
            "bound_pole",
        ),
        (
            PoleSearch {
                bound_functions: 0,
                ..PoleSearch::default()
            },
            "bound_functions",
        ),
    ] {
        let error = refused(&search, &pairs, &[]).to_string();
        assert!(error.starts_with(&format!("option `{option}`")), "{error}");
    }
    let search = PoleSearch::default();
    assert_eq!(
        refused(&search, &[], &[]),
        FdiError::Search(SearchError::NoRecords)
    );
    let too_short = SearchError::TooShort {
        set: "training",
        pair: 0,
        needed: 11,
        found: 9,
    };
    assert_eq!(
        refused(&search, &[short.pair()], &[]),
        FdiError::Search(too_short)
    );
    let mixed = RecordPair {
        healthy: long.pair().healthy,
        faulty: short.pair().faulty,
    };
    let error = refused(&search, &pairs, &[long.pair(), mixed]).to_string();
    assert!(error.starts_with("validation pair 1, samples"), "{error}");

    let none = canonical(&[], DMatrix::zeros(0, 1), DMatrix::zeros(1, 1), "y");
    let error = search.design(&none, &Toy::point(), &pairs, &[]);
    assert!(matches!(
        error,
        Err(FdiError::Search(SearchError::NoStates { .. }))
    ));
    let found = design(&search, &toy, &long);
    let other = Toy::new(&[0.9, 0.6, 0.1], Fault::Bias(1.0)).model;
    let error = found.generator(other, Toy::point());
    let expected = FdiError::PoleCount {
        expected: 3,
        found: 2,
    };
    assert_eq!(error, Err(expected));
}

#[test]
fn options_are_read_by_name_and_the_others_are_the_defaults() {
    let read: PoleSearch =
        serde_json::from_str(r#"{"radius": 0.9, "criterion": "paper"}"#).unwrap();
    let expected = PoleSearch {
        radius: 0.9,
        criterion: Criterion::Paper,
        ..PoleSearch::default()
    };
    assert_eq!(read, expected);
    let unknown = serde_json::from_str::<PoleSearch>(r#"{"colour": "red"}"#);
    assert!(
        unknown
            .unwrap_err()
            .to_string()
            .starts_with("unknown field")
    );
}
