//! A record from lanes is that of the run alone.

use gt_plant::{MapSet, Run, Scenario, Variant, Warning, simulate_batch, simulate_with};
use nalgebra::DMatrix;

use crate::scenarios::{all, tabulated};

/// Rounding of other elementary functions and fused multiplications, which the plant damps.
const ROUNDING: f64 = 1e-12;

fn close(found: &DMatrix<f64>, expected: &DMatrix<f64>, what: &str) {
    assert_eq!(found.shape(), expected.shape(), "{what}");
    for (row, (found, expected)) in found.row_iter().zip(expected.row_iter()).enumerate() {
        // What crosses zero has no relative error: the largest value is its size. Guide vanes that
        // stand open have none either.
        let finite = expected.iter().filter(|value| !value.is_nan());
        let size = finite.fold(0.1, |most: f64, value| most.max(value.abs()));
        for (k, (&found, &expected)) in found.iter().zip(expected.iter()).enumerate() {
            assert!(
                (found.is_nan() && expected.is_nan())
                    || (found - expected).abs() <= ROUNDING * size,
                "{what}, row {row}, sample {k}: {found} and {expected}"
            );
        }
    }
}

/// Warnings with the time and count of each, and the edge that was passed.
fn remarks(run: &Run) -> Vec<String> {
    let word = |warning: &Warning| match warning {
        Warning::OutsideCompressorMap { seen, furthest }
        | Warning::OutsideTurbineMap { seen, furthest } => {
            format!("{seen:?} {:?} {:.9}", furthest.edge, furthest.value)
        }
        other => format!("{other:?}"),
    };
    run.warnings.iter().map(word).collect()
}

fn assert_alike(scenarios: &[Scenario]) {
    let parameters = scenarios[0].parameters();
    let runs = simulate_batch(&parameters, scenarios);
    assert_eq!(runs.len(), scenarios.len());
    for (index, (scenario, run)) in scenarios.iter().zip(runs).enumerate() {
        let what = format!("{} {:?} {index}", scenario.variant, scenario.map_set);
        let alone = simulate_with(&parameters, scenario).unwrap();
        let run = run.unwrap();
        close(run.truth.u(), alone.truth.u(), &what);
        close(run.truth.y(), alone.truth.y(), &what);
        close(run.measured.u(), alone.measured.u(), &what);
        close(run.measured.y(), alone.measured.y(), &what);
        close(&run.hidden, &alone.hidden, &what);
        assert!(run.fault_magnitudes == alone.fault_magnitudes, "{what}");
        assert_eq!(run.fault_signals, alone.fault_signals, "{what}");
        assert_eq!(run.hidden_signals, alone.hidden_signals, "{what}");
        assert_eq!(run.truth.inputs(), alone.truth.inputs(), "{what}");
        assert_eq!(run.measured.outputs(), alone.measured.outputs(), "{what}");
        assert_eq!(remarks(&run), remarks(&alone), "{what}");
        assert_eq!((&run.ended, &alone.ended), (&None, &None), "{what}");
    }
}

#[test]
fn prototype_runs_are_those_alone() {
    assert_alike(&all(Variant::Prototype, MapSet::Paper));
    assert_alike(&all(Variant::Prototype, MapSet::Axial));
}

#[test]
fn cogeneration_runs_are_those_alone() {
    assert_alike(&all(Variant::Cogeneration, MapSet::Paper));
    assert_alike(&all(Variant::Cogeneration, MapSet::Axial));
}

#[test]
fn runs_with_a_tabulated_compressor_are_those_alone() {
    for variant in [Variant::Prototype, Variant::Cogeneration] {
        for map_set in [MapSet::Paper, MapSet::Axial] {
            assert_alike(&tabulated(all(variant, map_set)));
        }
    }
}
