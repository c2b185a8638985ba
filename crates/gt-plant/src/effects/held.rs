//! A faulty plant and two healthy ones that get its valve angle and its fuel, integrated as one
//! system; the cases side by side in the lanes of a register.

use nalgebra::DMatrix;
use pulp::{Arch, Simd, WithSimd};

use crate::channels::{ALL_OUTPUTS, outputs};
use crate::dynamics::Instant;
use crate::faults::{ActuatorFault, FaultSizes};
use crate::inputs::Inputs;
use crate::lanes::Pack;
use crate::real::Real;
use crate::simulate::time_s;
use crate::state::{STATES, State};
use crate::{PlantError, PlantParameters, rk4};

/// The faulty plant, then its shadows at demanded and at delivered fuel.
pub(super) const PLANTS: usize = 3;
/// States of the three plants.
const ALL_STATES: usize = PLANTS * STATES;

/// One fault case.
pub(super) struct Case {
    /// What acts on the faulty plant.
    pub faults: FaultSizes,
    /// Where the three plants start.
    pub start: [[f64; STATES]; PLANTS],
}

/// Excitation and window, the same for every case.
pub(super) struct Window {
    /// What acts from sample `k - 1` to sample `k`, for every `k`; the first is at `t = 0`.
    pub inputs: Vec<Inputs>,
    /// The first sample that counts.
    pub first: usize,
    /// Integration steps a sample.
    pub substeps: usize,
    /// Length of a step, s.
    pub step_s: f64,
}

/// The measured outputs (28 x N) of the three plants over the window.
pub(super) struct Records([DMatrix<f64>; PLANTS]);

impl Records {
    /// The faulty plant.
    pub fn faulty(&self) -> &DMatrix<f64> {
        &self.0[0]
    }

    /// The healthy plant at its valve angle and demanded fuel.
    pub fn at_demanded_fuel(&self) -> &DMatrix<f64> {
        &self.0[1]
    }

    /// The healthy plant at its valve angle and delivered fuel.
    pub fn at_delivered_fuel(&self) -> &DMatrix<f64> {
        &self.0[2]
    }
}

/// Runs the cases.
///
/// # Errors
/// [`PlantError::OutOfRange`] when a plant leaves the model's range of validity.
pub(super) fn records(
    plant: &PlantParameters,
    cases: &[Case],
    window: &Window,
) -> Result<Vec<Records>, PlantError> {
    Arch::new().dispatch(Run {
        plant,
        cases,
        window,
    })
}

struct Run<'a> {
    plant: &'a PlantParameters,
    cases: &'a [Case],
    window: &'a Window,
}

impl WithSimd for Run<'_> {
    type Output = Result<Vec<Records>, PlantError>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut all = Vec::with_capacity(self.cases.len());
        for cases in self.cases.chunks(Pack::<S>::LANES) {
            all.extend(self.group(simd, cases)?);
        }
        Ok(all)
    }
}

impl Run<'_> {
    /// As many cases as there are lanes, or fewer.
    #[inline(always)]
    fn group<S: Simd>(&self, simd: S, cases: &[Case]) -> Result<Vec<Records>, PlantError> {
        let Window {
            ref inputs,
            first,
            substeps,
            step_s,
        } = *self.window;
        let last = cases.len() - 1;
        let lanes = |number: &dyn Fn(&Case) -> f64| {
            Pack::from_fn(simd, |lane| number(&cases[lane.min(last)]))
        };
        let zero = Pack::splat(simd, 0.0);
        let healthy = FaultSizes::HEALTHY.like(zero);
        let faults = FaultSizes {
            compressor_flow_loss: lanes(&|case| case.faults.compressor_flow_loss),
            turbine_efficiency_loss: lanes(&|case| case.faults.turbine_efficiency_loss),
            fuel: ActuatorFault {
                lag_s: lanes(&|case| case.faults.fuel.lag_s),
                ..healthy.fuel
            },
            ..healthy
        };
        let mut x = [zero; ALL_STATES];
        for (i, state) in x.iter_mut().enumerate() {
            *state = lanes(&|case| case.start[i / STATES][i % STATES]);
        }
        let ny = self.plant.variant.output_channels().len();
        let empty = || DMatrix::zeros(ny, inputs.len() - first);
        let mut found: Vec<Records> = cases
            .iter()
            .map(|_| Records([empty(), empty(), empty()]))
            .collect();
        for (k, now) in inputs.iter().enumerate() {
            let now = now.like(zero);
            let system = Coupled {
                plant: self.plant,
                inputs: &now,
                faults: &faults,
                healthy: &healthy,
            };
            for substep in 0..if k == 0 { 0 } else { substeps } {
                let t = time_s(k - 1) + substep as f64 * step_s;
                x = rk4::step(
                    #[inline(always)]
                    |_, x: &[Pack<S>; ALL_STATES]| system.rates(x),
                    t,
                    &x,
                    step_s,
                );
            }
            check(&x, cases.len(), time_s(k))?;
            if k >= first {
                let values = system.outputs(&x);
                for (lane, records) in found.iter_mut().enumerate() {
                    for (record, values) in records.0.iter_mut().zip(&values) {
                        for (to, value) in record.column_mut(k - first).iter_mut().zip(values) {
                            *to = value.lanes()[lane];
                        }
                    }
                }
            }
        }
        Ok(found)
    }
}

/// Refuses a plant outside the model's range of validity.
fn check<S: Simd>(x: &[Pack<S>; ALL_STATES], lanes: usize, time_s: f64) -> Result<(), PlantError> {
    for lane in 0..lanes {
        for states in x.as_chunks::<STATES>().0 {
            State::from_array(&states.map(|state| state.lanes()[lane])).check(time_s)?;
        }
    }
    Ok(())
}

/// The three plants as one system.
struct Coupled<'a, R> {
    plant: &'a PlantParameters,
    inputs: &'a Inputs<R>,
    /// Of the faulty plant.
    faults: &'a FaultSizes<R>,
    /// None, as numbers of this kind.
    healthy: &'a FaultSizes<R>,
}

impl<R: Real> Coupled<'_, R> {
    /// Shows each plant at a state to `see`.
    #[inline(always)]
    fn visit(&self, x: &[R; ALL_STATES], mut see: impl FnMut(usize, &State<R>, &Instant<R>)) {
        // A shadow's fuel actuator is stuck where the faulty plant's fuel is at this moment. A
        // loop, because the compiler would write the plant's laws out three times.
        let mut faults = *self.faults;
        let mut delivered_kg_s = x[0];
        for plant in 0..PLANTS {
            let mut own = [x[0]; STATES];
            own.copy_from_slice(&x[plant * STATES..(plant + 1) * STATES]);
            let state = State::from_array(&own);
            let instant = Instant::at(self.plant, self.inputs, &faults, &state);
            see(plant, &state, &instant);
            let stuck_at = if plant == 0 {
                delivered_kg_s = instant.actuation.fuel_kg_s;
                instant.fuel_demand_kg_s
            } else {
                delivered_kg_s
            };
            faults = FaultSizes {
                fuel: ActuatorFault {
                    stuck: stuck_at.like(1.0),
                    stuck_at,
                    ..self.healthy.fuel
                },
                ..*self.healthy
            };
        }
    }

    #[inline(always)]
    fn rates(&self, x: &[R; ALL_STATES]) -> [R; ALL_STATES] {
        let mut rates = *x;
        self.visit(
            x,
            #[inline(always)]
            |plant, _, instant| {
                rates[plant * STATES..(plant + 1) * STATES].copy_from_slice(&instant.rates);
            },
        );
        rates
    }

    #[inline(always)]
    fn outputs(&self, x: &[R; ALL_STATES]) -> [[R; ALL_OUTPUTS]; PLANTS] {
        let mut values = [[x[0]; ALL_OUTPUTS]; PLANTS];
        self.visit(
            x,
            #[inline(always)]
            |plant, state, instant| {
                values[plant] = outputs(self.plant, self.inputs, state, instant);
            },
        );
        values
    }
}
