//! A record does not depend on what else is in the list.

use std::thread;

use gt_plant::{
    Fault, FaultCase, MapSet, NoiseLevel, PlantError, Run, Scenario, Shape, Step, Target, Variant,
    simulate_batch, simulate_with,
};

use crate::assert_same;
use crate::scenarios::{all, plain};

fn together(scenarios: &[Scenario]) -> Vec<Result<Run, PlantError>> {
    simulate_batch(&scenarios[0].parameters(), scenarios)
}

fn alone(scenario: &Scenario) -> Result<Run, PlantError> {
    together(std::slice::from_ref(scenario)).remove(0)
}

/// Leaves the plant's range some seconds after the beginning.
fn ending() -> Scenario {
    Scenario {
        faults: vec![Fault::growing(
            FaultCase::TurbineDamage,
            1.0,
            72e3,
            Some(99.0),
        )],
        noise: NoiseLevel::Table8.into(),
        ..plain(Variant::Prototype, 30)
    }
}

/// Is out of the plant's range at its first sample: a turbine that loses more than it has.
fn stillborn() -> Scenario {
    let most = Shape::Step(Step { size: 60.0 });
    let damage = Fault::new(Target::Case(FaultCase::TurbineDamage), 0.0, most);
    Scenario {
        faults: vec![damage; 2],
        ..plain(Variant::Prototype, 31)
    }
}

/// Runs that are refused, each for a reason of its own.
fn refused() -> [Scenario; 3] {
    let few = Scenario {
        substeps: 4,
        ..plain(Variant::Prototype, 32)
    };
    let mut hot = plain(Variant::Prototype, 33);
    hot.boundary.temperature_k.offset = 500.0;
    let endless = Scenario {
        duration_s: f64::NAN,
        ..plain(Variant::Prototype, 34)
    };
    [few, hot, endless]
}

/// Runs of all kinds, some of which differ in length and steps.
fn mixed() -> Vec<Scenario> {
    let mut list = all(Variant::Prototype, MapSet::Paper);
    for (scenario, duration_s) in list.iter_mut().zip([8.0, 3.2, 0.08, 5.0]) {
        scenario.duration_s = duration_s;
    }
    for (scenario, substeps) in list.iter_mut().rev().zip([40, 25, 50, 25]) {
        scenario.substeps = substeps;
    }
    list.insert(3, ending());
    list.push(stillborn());
    list.extend(refused());
    list
}

fn assert_same_result(
    found: &Result<Run, PlantError>,
    expected: &Result<Run, PlantError>,
    what: &str,
) {
    match (found, expected) {
        (Ok(found), Ok(expected)) => assert_same(found, expected, what),
        // Texts, because a NaN is not itself.
        (found, expected) => assert_eq!(
            format!("{:?}", found.as_ref().err()),
            format!("{:?}", expected.as_ref().err()),
            "{what}"
        ),
    }
}

#[test]
fn an_empty_list_has_no_runs() {
    let parameters = plain(Variant::Prototype, 0).parameters();
    assert!(simulate_batch(&parameters, &[]).is_empty());
}

#[test]
fn the_order_of_the_list_changes_no_bit() {
    let list = mixed();
    let runs = together(&list);
    for (index, (scenario, run)) in list.iter().zip(&runs).enumerate() {
        assert_same_result(run, &alone(scenario), &format!("{index} alone"));
    }
    let n = list.len();
    for (what, order) in [
        ("reversed", (0..n).rev().collect::<Vec<_>>()),
        ("rotated", (0..n).map(|index| (index + 5) % n).collect()),
        ("twice", (0..2 * n).map(|index| index % n).collect()),
    ] {
        let other: Vec<Scenario> = order.iter().map(|&index| list[index].clone()).collect();
        for (run, &index) in together(&other).iter().zip(&order) {
            assert_same_result(run, &runs[index], &format!("{index} {what}"));
        }
    }
}

#[test]
fn neighbours_in_the_register_change_no_bit() {
    // More places than any register has lanes.
    let places = 9;
    let watched = all(Variant::Prototype, MapSet::Paper);
    for (scenario, neighbour) in [
        (&watched[1], ending()),
        (&watched[4], stillborn()),
        (&watched[5], plain(Variant::Prototype, 40)),
        (&plain(Variant::Prototype, 41), watched[7].clone()),
        (&watched[8], refused()[1].clone()),
    ] {
        let expected = alone(scenario);
        for place in 0..places {
            let mut list = vec![neighbour.clone(); places];
            list[place] = scenario.clone();
            let run = together(&list).remove(place);
            assert_same_result(&run, &expected, &format!("place {place}"));
        }
    }
}

#[test]
fn threads_that_share_a_list_give_what_one_gives() {
    let list = mixed();
    let whole = together(&list);
    let halves: Vec<_> = thread::scope(|scope| {
        let handles: Vec<_> = list
            .chunks(list.len().div_ceil(2))
            .map(|half| scope.spawn(|| together(half)))
            .collect();
        let joined = handles.into_iter().map(|handle| handle.join().unwrap());
        joined.flatten().collect()
    });
    assert_eq!(halves.len(), whole.len());
    for (index, (half, whole)) in halves.iter().zip(&whole).enumerate() {
        assert_same_result(half, whole, &index.to_string());
    }
}

#[test]
fn durations_and_substeps_of_one_list_differ() {
    let list: Vec<Scenario> = [(8.0, 40), (2.4, 25), (0.08, 40), (4.0, 50), (8.0, 25)]
        .into_iter()
        .zip(0..)
        .map(|((duration_s, substeps), run_index)| Scenario {
            duration_s,
            substeps,
            ..plain(Variant::Prototype, run_index)
        })
        .collect();
    for (scenario, run) in list.iter().zip(together(&list)) {
        let (run, expected) = (
            run.unwrap(),
            simulate_with(&scenario.parameters(), scenario),
        );
        let expected = expected.unwrap();
        assert_eq!(run.truth.len(), scenario.samples().unwrap());
        let largest = run.truth.y().iter().zip(expected.truth.y().iter());
        let largest = largest.map(|(found, expected)| (found / expected - 1.0).abs());
        // P_e of the prototype is not recorded: no output is zero.
        assert!(largest.fold(0.0, f64::max) < 1e-12);
        assert_same(&run, &alone(scenario).unwrap(), "alone");
    }
}

#[test]
fn a_refused_run_gives_its_own_error() {
    let [few, hot, endless] = refused();
    let list = [plain(Variant::Prototype, 0), few, hot, endless];
    let runs = together(&list);
    assert_same_result(&runs[0], &alone(&list[0]), "the run that is not refused");
    for (scenario, run) in list.iter().zip(&runs).skip(1) {
        let expected = simulate_with(&scenario.parameters(), scenario).unwrap_err();
        let found = run.as_ref().unwrap_err();
        assert_eq!(found.to_string(), expected.to_string());
    }
    assert!(matches!(
        runs[1],
        Err(PlantError::Substeps { found: 4, .. })
    ));
    assert!(matches!(runs[3], Err(PlantError::Duration { .. })));
}

#[test]
fn a_run_that_leaves_the_range_ends_at_the_sample_at_which_it_ends_alone() {
    let healthy = plain(Variant::Prototype, 0);
    let list = [healthy.clone(), ending(), healthy.clone(), stillborn()];
    let runs = together(&list);
    for (place, samples) in [(1, 20..100), (3, 0..1)] {
        let single = simulate_with(&list[place].parameters(), &list[place]).unwrap();
        let run = runs[place].as_ref().unwrap();
        assert_eq!(run.truth.len(), single.truth.len());
        assert!(samples.contains(&run.truth.len()), "{:?}", run.ended);
        let (found, expected) = (run.ended.as_ref().unwrap(), single.ended.unwrap());
        let (
            PlantError::OutOfRange {
                time_s,
                quantity,
                low,
                high,
                found,
            },
            PlantError::OutOfRange {
                time_s: expected_s,
                quantity: expected_quantity,
                low: expected_low,
                high: expected_high,
                found: expected,
            },
        ) = (found, expected)
        else {
            panic!("expected a plant out of range");
        };
        assert_eq!(time_s.to_bits(), expected_s.to_bits());
        assert_eq!(*quantity, expected_quantity);
        assert_eq!(
            [*low, *high].map(f64::to_bits),
            [expected_low, expected_high].map(f64::to_bits)
        );
        // Rounding, enlarged by a plant that is about to break down.
        let close = (found / expected - 1.0).abs() < 1e-9;
        assert!(
            close || (found.is_nan() && expected.is_nan()),
            "{found} {expected}"
        );
    }
    for place in [0, 2] {
        assert_same_result(&runs[place], &alone(&healthy), "the neighbours go on");
    }
}
