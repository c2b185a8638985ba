//! The plant linearised about a state: exact derivatives of its laws.

use nalgebra::DMatrix;

use crate::channels::{ALL_OUTPUTS, outputs, signals};
use crate::dual::Dual;
use crate::dynamics::Instant;
use crate::faults::FaultSizes;
use crate::inputs::Inputs;
use crate::linearise::{Linearisation, jacobian_exact};
use crate::stability::longest_stable_step_s;
use crate::state::{STATES, State};
use crate::{PlantError, PlantParameters};

/// Inputs of a local model: `a_v`, fuel offset, `w_ref`, `p_a`, `T_a`, `LHV`.
const LOCAL_INPUTS: usize = 6;
/// Variables by which the laws are differentiated.
const VARIABLES: usize = STATES + LOCAL_INPUTS;
/// Values that are differentiated.
const VALUES: usize = STATES + ALL_OUTPUTS;

/// The local model of a plant at a state: states and measured outputs of its variant; inputs are
/// the valve's angle `a_v` (deg), what is added to the fuel demand `M_f` (kg/s), the reference
/// `w_ref` (rad/s), `p_a` (Pa), `T_a` (K) and `LHV` (J/kg).
///
/// The derivatives are exact (forward mode). The controllers' limits and the valve's choking are
/// taken as they stand at the state.
///
/// # Errors
/// [`PlantError`] where a derivative is not finite or the poles cannot be found.
pub fn local_model(
    plant: &PlantParameters,
    inputs: &Inputs,
    faults: &FaultSizes,
    state: &State,
) -> Result<Linearisation, PlantError> {
    let mut at = [0.0; VARIABLES];
    at[..STATES].copy_from_slice(&state.to_array());
    at[STATES..].copy_from_slice(&[
        inputs.valve_deg,
        inputs.fuel_offset_kg_s,
        inputs.speed_reference_rad_s,
        inputs.ambient_pa,
        inputs.ambient_k,
        inputs.heating_value_j_kg,
    ]);
    let jacobian = jacobian_exact(
        |z: &[Dual<VARIABLES>; VARIABLES]| -> [Dual<VARIABLES>; VALUES] {
            let x = State::from_array(&std::array::from_fn(|i| z[i]));
            let inputs = Inputs {
                valve_deg: z[STATES],
                fuel_offset_kg_s: z[STATES + 1],
                speed_reference_rad_s: z[STATES + 2],
                ambient_pa: z[STATES + 3],
                ambient_k: z[STATES + 4],
                heating_value_j_kg: z[STATES + 5],
                ..inputs.like(z[0])
            };
            let instant = Instant::at(plant, &inputs, &faults.like(z[0]), &x);
            let outputs = outputs(plant, &inputs, &x, &instant);
            std::array::from_fn(|i| {
                if i < STATES {
                    instant.rates[i]
                } else {
                    outputs[i - STATES]
                }
            })
        },
        &at,
    );
    let states = plant.variant.states();
    let channels = plant.variant.output_channels();
    let part = |rows: &[usize], columns: &[usize]| {
        DMatrix::from_fn(rows.len(), columns.len(), |i, j| {
            jacobian[(rows[i], columns[j])]
        })
    };
    let x: Vec<usize> = states.iter().map(|(index, _)| *index).collect();
    let u: Vec<usize> = (STATES..VARIABLES).collect();
    let y: Vec<usize> = (STATES..STATES + channels.len()).collect();
    Linearisation::new(
        [part(&x, &x), part(&x, &u), part(&y, &x), part(&y, &u)],
        states.iter().map(|(_, name)| (*name).to_owned()).collect(),
        signals(&plant.variant.input_channels()[..LOCAL_INPUTS]),
        signals(channels),
    )
}

/// The longest step, s, at which RK4 is stable on the plant linearised about a state.
///
/// # Errors
/// As [`local_model`].
pub fn longest_step_s(
    plant: &PlantParameters,
    inputs: &Inputs,
    state: &State,
) -> Result<f64, PlantError> {
    let model = local_model(plant, inputs, &FaultSizes::HEALTHY, state)?;
    Ok(longest_stable_step_s(model.poles_per_s()))
}
