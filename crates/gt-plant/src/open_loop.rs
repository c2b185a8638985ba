//! The linear plant without its speed governor: from the fuel that is demanded to the outputs.

use nalgebra::{DMatrix, RowDVector};

use crate::inputs::Inputs;
use crate::linearise::Linearisation;
use crate::state::State;
use crate::{FaultSizes, PlantError, PlantParameters, Variant, local_model};

/// The governor's state among the names of [`State`].
const INTEGRAL: &str = "speed_error_integral";
/// The state that the governor reads.
const SPEED: &str = "w_t";
/// The input that only the governor reads.
const REFERENCE: &str = "w_ref";
/// The demanded fuel flow.
const FUEL: &str = "M_f";

/// The local model of a plant whose demanded fuel `M_f` (kg/s) is an input of its own, whoever
/// demands it: what a model of a record with the inputs `a_v` and `M_f` describes. Inputs are `a_v`
/// (deg), `M_f` (kg/s), `p_a` (Pa), `T_a` (K) and `LHV` (J/kg); outputs as in [`local_model`].
///
/// It is the closed loop with the governor's feedback subtracted from the fuel (`A - b k`, `C - d k`
/// with `k x` the governor's demand); the governor's integral, which nothing then reads, is left
/// out. In cogeneration the demand is an input already, and only `w_ref` (the mains' frequency) stays
/// beside it: there the model is [`local_model`]'s, with the vanes' control as it is.
///
/// # Errors
/// As [`local_model`]. The governor must be within its limits at the state: at a limit the demand
/// moves nothing, and the column of `M_f` is zero.
pub fn open_loop_model(
    plant: &PlantParameters,
    inputs: &Inputs,
    faults: &FaultSizes,
    state: &State,
) -> Result<Linearisation, PlantError> {
    let closed = local_model(plant, inputs, faults, state)?;
    if plant.variant == Variant::Cogeneration {
        return Ok(closed);
    }
    let index = |name: &str| closed.inputs().iter().position(|input| input.name == name);
    let Some(fuel) = index(FUEL) else {
        return Ok(closed);
    };
    let names = closed.states().iter().map(String::as_str);
    let feedback = RowDVector::from_iterator(
        closed.nx(),
        names.map(|name| match name {
            SPEED => -plant.governor.proportional_gain,
            INTEGRAL => plant.governor.integral_gain,
            _ => 0.0,
        }),
    );
    let a = closed.a() - closed.b().column(fuel) * &feedback;
    let c = closed.c() - closed.d().column(fuel) * &feedback;
    let kept = |names: Vec<&str>, without: &str| -> Vec<usize> {
        (0..names.len()).filter(|&k| names[k] != without).collect()
    };
    let x = kept(
        closed.states().iter().map(String::as_str).collect(),
        INTEGRAL,
    );
    let u = kept(
        closed
            .inputs()
            .iter()
            .map(|input| input.name.as_str())
            .collect(),
        REFERENCE,
    );
    let y: Vec<usize> = (0..closed.ny()).collect();
    let part = |matrix: &DMatrix<f64>, rows: &[usize], columns: &[usize]| {
        matrix.select_rows(rows).select_columns(columns)
    };
    Linearisation::new(
        [
            part(&a, &x, &x),
            part(closed.b(), &x, &u),
            part(&c, &y, &x),
            part(closed.d(), &y, &u),
        ],
        x.iter().map(|&k| closed.states()[k].clone()).collect(),
        u.iter().map(|&k| closed.inputs()[k].clone()).collect(),
        closed.outputs().to_vec(),
    )
}
