//! The default step against an independent integrator of eighth order with control of its error.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

mod sampled;

use differential_equations::prelude::{ExplicitRungeKutta, IVP, ODE};
use gt_plant::channels::{ALL_OUTPUTS, OUTPUTS, outputs};
use gt_plant::dynamics::{Instant, derivative};
use gt_plant::state::STATES;
use gt_plant::{
    FaultSizes, Inputs, MapSet, PlantParameters, Profile, Run, SAMPLE_TIME_S, Scenario, Variant,
    Warning, simulate,
};
use nalgebra::DMatrix;

const VARIANTS: [Variant; 2] = [Variant::Prototype, Variant::Cogeneration];

/// The healthy plant with held inputs.
struct Held<'a> {
    plant: &'a PlantParameters,
    inputs: &'a Inputs,
}

impl ODE<f64, [f64; STATES]> for Held<'_> {
    fn diff(&self, _time_s: f64, x: &[f64; STATES], rates: &mut [f64; STATES]) {
        *rates = derivative(self.plant, self.inputs, &FaultSizes::HEALTHY, x);
    }
}

/// The state one sample after `x` by DOP853 (Hairer, Norsett and Wanner, Solving Ordinary
/// Differential Equations I, section II.5), with local errors of `tolerance` times each state or a
/// tenth of it, whichever is more.
fn by_dop853(
    plant: &PlantParameters,
    inputs: &Inputs,
    x: &[f64; STATES],
    tolerance: f64,
) -> [f64; STATES] {
    let method = ExplicitRungeKutta::dop853()
        .rtol(tolerance)
        .atol(0.1 * tolerance)
        .max_steps(100_000);
    let system = Held { plant, inputs };
    let solution = IVP::ode(&system, 0.0, SAMPLE_TIME_S, *x)
        .method(method)
        .solve()
        .unwrap();
    *solution.y.last().unwrap()
}

/// The true outputs of a healthy scenario (ny + 3 x N), sample by sample with `advance`.
fn truth(
    scenario: &Scenario,
    advance: impl Fn(&PlantParameters, &Inputs, &[f64; STATES]) -> [f64; STATES],
) -> DMatrix<f64> {
    let plant = PlantParameters::new(scenario.variant, scenario.map_set);
    let mut samples = Vec::new();
    sampled::run(
        &plant,
        scenario,
        |inputs, x| {
            let now = Instant::at(&plant, inputs, &FaultSizes::HEALTHY, x);
            samples.extend(outputs(&plant, inputs, x, &now));
        },
        |inputs, x| advance(&plant, inputs, x),
    );
    let all = DMatrix::from_vec(ALL_OUTPUTS, samples.len() / ALL_OUTPUTS, samples);
    let measured = scenario.variant.output_channels().len();
    let rows: Vec<usize> = (0..measured).chain(OUTPUTS..ALL_OUTPUTS).collect();
    all.select_rows(&rows)
}

/// The true outputs of a run and what no sensor measures (ny + 3 x N).
fn all_outputs(run: &Run) -> DMatrix<f64> {
    let (truth, hidden) = (run.truth.y(), &run.hidden);
    let measured = truth.nrows();
    DMatrix::from_fn(measured + hidden.nrows(), truth.ncols(), |i, k| {
        if i < measured {
            truth[(i, k)]
        } else {
            hidden[(i - measured, k)]
        }
    })
}

/// The largest relative error of any output at any sample; a NaN wins.
fn largest_error(found: &DMatrix<f64>, reference: &DMatrix<f64>) -> f64 {
    assert_eq!(found.shape(), reference.shape());
    let errors = found.zip_map(reference, |found, reference| {
        (found / reference - 1.0).abs()
    });
    errors.iter().fold(
        0.0,
        |worst, &error| if error <= worst { worst } else { error },
    )
}

/// Every named profile of both variants with both map sets, 60 s each, the manoeuvres to their end
/// and half a minute beyond.
///
/// Measured: the largest relative error of any true output over the substeps a sample, of the map
/// set that errs more; `steady` errs by its rounding, 1e-10. With 23 substeps the prototype with
/// the paper's maps is refused.
///
/// | profile               | 23     | 24     | 26     | 28     | 32     | 40     |
/// |-----------------------|--------|--------|--------|--------|--------|--------|
/// | gentle                | 1.1e-4 | 4.8e-6 | 1.3e-6 | 9.6e-7 | 5.6e-7 | 2.3e-7 |
/// | standard, prototype   | 1.1e-4 | 4.8e-6 | 1.3e-6 | 9.6e-7 | 5.6e-7 | 2.3e-7 |
/// | lively                | 1.1e-4 | 5.0e-6 | 1.3e-6 | 9.5e-7 | 5.6e-7 | 2.3e-7 |
/// | wide                  | 1.1e-4 | 5.1e-6 | 1.3e-6 | 9.4e-7 | 5.6e-7 | 2.3e-7 |
/// | standard, on mains    | 1.4e-6 | 4.9e-8 | 3.5e-8 | 2.6e-8 | 1.5e-8 | 6.3e-9 |
/// | `load_reduction_igv`  | 1.5e-6 | 5.7e-8 | 9.7e-9 | 7.2e-9 | 4.2e-9 | 1.7e-9 |
/// | `load_reduction_fuel` | 1.9e-8 | 1.6e-8 | 1.2e-8 | 8.6e-9 | 5.0e-9 | 2.1e-9 |
///
/// `standard` and `wide` of the prototype over 400 s, other seeds, 20 K warmer or colder: up to
/// 1.1e-5 with 24 and 1.6e-6 with 26 substeps. Relative to an
/// output's own standard deviation p8 errs most in the prototype, where the choked valve keeps it
/// still: 3e-3 with 28, 8e-4 with 40 substeps (`gentle`).
#[test]
fn prop_default_step_meets_one_in_a_hundred_thousand() {
    for variant in VARIANTS {
        for (map_set, &name) in [MapSet::Paper, MapSet::Axial]
            .into_iter()
            .flat_map(|map_set| {
                Profile::names(variant)
                    .iter()
                    .map(move |name| (map_set, name))
            })
        {
            let scenario = Scenario {
                map_set,
                profile: Profile::named(variant, name).unwrap(),
                // Manoeuvres go from 20 to 80 s.
                duration_s: if name.starts_with("load_reduction") {
                    110.0
                } else {
                    60.0
                },
                seed: 1,
                ..Scenario::of(variant)
            };
            let run = simulate(&scenario).unwrap();
            assert_eq!(run.ended, None);
            // The reference itself is good to 1e-9: with 1e-13 it moves by 6e-10 at most.
            let reference = truth(&scenario, |plant, inputs, x| {
                by_dop853(plant, inputs, x, 1e-11)
            });
            let error = largest_error(&all_outputs(&run), &reference);
            assert!(error < 1e-5, "{variant} {map_set} {name}: {error}");
        }
    }
}

/// Where the vanes come on and off their open stop again and again (20 K warmer, 120 s), and on a
/// cold day. The controller's integral is led back continuously at a stop, so no order is lost.
#[test]
fn prop_default_step_holds_on_warm_and_cold_days() {
    for variant in VARIANTS {
        for offset_k in [-20.0, 20.0] {
            let mut scenario = Scenario {
                duration_s: 120.0,
                seed: 3,
                ..Scenario::of(variant)
            };
            scenario.boundary.temperature_k.offset = offset_k;
            let run = simulate(&scenario).unwrap();
            assert_eq!(run.ended, None);
            let at_the_stop = run
                .warnings
                .iter()
                .any(|warning| matches!(warning, Warning::VanesOpen(_)));
            assert_eq!(
                at_the_stop,
                variant == Variant::Cogeneration && offset_k > 0.0
            );
            let reference = truth(&scenario, |plant, inputs, x| {
                by_dop853(plant, inputs, x, 1e-11)
            });
            let error = largest_error(&all_outputs(&run), &reference);
            assert!(error < 1e-5, "{variant} {offset_k:+} K: {error}");
        }
    }
}

/// Halving the step divides the error by sixteen, over whole runs that meet no kink: no limit of
/// the fuel, no stop and no slew limit of the vanes, a valve that stays choked (prototype) or open.
/// At a kink the derivative jumps within a step, which costs orders there.
#[test]
fn prop_fourth_order_over_a_run() {
    for variant in VARIANTS {
        let scenario = Scenario {
            duration_s: 16.0,
            seed: 1,
            ..Scenario::of(variant)
        };
        assert_eq!(simulate(&scenario).unwrap().warnings, []);
        let reference = truth(&scenario, |plant, inputs, x| {
            by_dop853(plant, inputs, x, 1e-13)
        });
        // From 2 or 2.9 ms on, from where the errors (2e-7 and 9e-10) follow the power law, down to
        // where they (8e-10 and 4e-12) still stand above rounding, some 1e-12.
        let substeps = match variant {
            Variant::Prototype => [40, 80, 160],
            Variant::Cogeneration => [28, 56, 112],
        };
        let errors = substeps.map(|substeps| {
            let found = truth(&scenario, |plant, inputs, x| {
                sampled::by_rk4(plant, inputs, &FaultSizes::HEALTHY, x, substeps)
            });
            largest_error(&found, &reference)
        });
        for pair in errors.windows(2) {
            let ratio = pair[0] / pair[1];
            assert!((14.0..18.0).contains(&ratio), "{variant}: {errors:?}");
        }
    }
}
