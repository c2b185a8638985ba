//! `linearise`: the embedded gas turbine as a linear model.

use gtfdi::plant::{
    FaultSizes, Inputs, PlantParameters, SAMPLE_TIME_S, local_model, open_loop_model, steady_state,
};
use pyo3::prelude::*;

use crate::choice::named;
use crate::error::Failure;
use crate::state_space::PyStateSpace;

/// The gas turbine linearised at its healthy equilibrium at design, in deviations from it, with
/// inputs held for a sample of 0.08 s.
///
/// The derivatives are exact (forward mode).
///
/// Parameters
/// ----------
/// variant : {"prototype", "cogeneration"}, default "prototype"
///     The machine.
/// map_set : {"paper", "axial"}, default "paper"
///     Compressor map.
/// loop : {"closed", "open"}, default "closed"
///     With the speed governor, whose reference is then an input and ``M_f`` what is added to its
///     demand; or without it, ``M_f`` being the fuel demand: what a model of a record describes.
///     In cogeneration there is no governor, and both are the same.
///
/// Returns
/// -------
/// StateSpace
///
/// Raises
/// ------
/// PlantError
///     There is no such variant or map.
///
/// Examples
/// --------
/// >>> turbine = gtfdi.linearise(loop="open")
/// >>> turbine.inputs, len(turbine.outputs), turbine.dt
/// (['a_v', 'M_f', 'p_a', 'T_a', 'LHV'], 28, 0.08)
#[pyfunction]
#[pyo3(signature = (variant="prototype", map_set="paper", r#loop="closed"),
    text_signature = "(variant='prototype', map_set='paper', loop='closed')")]
pub fn linearise(variant: &str, map_set: &str, r#loop: &str) -> Result<PyStateSpace, Failure> {
    let parameters = PlantParameters::new(variant.parse()?, map_set.parse()?);
    let open = named("loop", r#loop, &[("closed", false), ("open", true)])?;
    let rest = steady_state(&parameters)?;
    let inputs = Inputs::design(&parameters);
    let model = if open { open_loop_model } else { local_model };
    let model = model(&parameters, &inputs, &FaultSizes::HEALTHY, &rest.state)?;
    let inner = model.discretise(SAMPLE_TIME_S)?;
    Ok(PyStateSpace { inner })
}
