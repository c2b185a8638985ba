//! The linearised twin: the plant's linear model at rest, driven by what the plant's inputs did.

use gtfdi::core::{DataError, Dataset, StateSpace};
use gtfdi::plant::{
    FaultSizes, Inputs, PlantParameters, SAMPLE_TIME_S, open_loop_model, steady_state,
};
use nalgebra::{DMatrix, DVector};

use crate::error::{CampaignError, During as _};
use crate::paper;

/// What a run is called in errors.
const WHAT: &str = "linearised twin";

/// A record without and with noise.
#[derive(Debug, Clone)]
pub struct Pair {
    /// What the plant did.
    pub clean: Dataset,
    /// What its sensors said.
    pub noisy: Dataset,
}

/// A linear plant with the gains and poles that the non-linear one has at rest.
#[derive(Debug)]
pub struct Twin {
    model: StateSpace,
    /// The inputs at rest, in the order of [`paper::INPUTS`].
    rest: [f64; 2],
}

impl Twin {
    /// The twin of a plant: linear from valve angle and demanded fuel, both held over a sample.
    pub fn new(plant: &PlantParameters) -> Result<Self, CampaignError> {
        let rest = steady_state(plant).during(WHAT)?;
        let design = Inputs::design(plant);
        let model = open_loop_model(plant, &design, &FaultSizes::HEALTHY, &rest.state)
            .and_then(|model| model.discretise(SAMPLE_TIME_S))
            .during(WHAT)?;
        Ok(Self {
            model,
            rest: [design.valve_deg, plant.governor.design_fuel_kg_s],
        })
    }

    /// The twin's outputs, as deviations from rest, over the inputs of a run of the plant that
    /// started at rest. The noise of its inputs is that of the run; that of its outputs too, in the
    /// same proportion to what the outputs do.
    pub fn follow(&self, plant: &Pair) -> Result<Pair, CampaignError> {
        let (clean, noisy) = (&plant.clean, &plant.noisy);
        let tags: Vec<&str> = clean.outputs().iter().map(|s| s.name.as_str()).collect();
        let mut u = DMatrix::zeros(self.model.nu(), clean.len());
        for (input, name) in paper::INPUTS.iter().enumerate() {
            let row = self.model.inputs().iter().position(|s| s.name == *name);
            let row = row
                .ok_or_else(|| DataError::UnknownChannel {
                    name: (*name).to_owned(),
                    available: self.model.inputs().iter().map(|s| s.name.clone()).collect(),
                })
                .during(WHAT)?;
            let deviation = clean.u().row(input).add_scalar(-self.rest[input]);
            u.set_row(row, &deviation);
        }
        let y = self
            .model
            .simulate(&DVector::zeros(self.model.nx()), &u)
            .map_err(DataError::from)
            .during(WHAT)?;
        let (inputs, outputs) = (self.model.inputs(), self.model.outputs());
        let own = Dataset::new(inputs.to_vec(), outputs.to_vec(), u, y, SAMPLE_TIME_S)
            .and_then(|all| all.select(&paper::INPUTS, &tags))
            .during(WHAT)?;
        let mut y = noisy.y() - clean.y();
        for (output, mut row) in y.row_iter_mut().enumerate() {
            row *= deviation(own.y(), output) / deviation(clean.y(), output);
        }
        y += own.y();
        let with = |u: &DMatrix<f64>, y: DMatrix<f64>| {
            let (inputs, outputs) = (own.inputs().to_vec(), own.outputs().to_vec());
            Dataset::new(inputs, outputs, u.clone(), y, SAMPLE_TIME_S).during(WHAT)
        };
        Ok(Pair {
            noisy: with(noisy.u(), y)?,
            clean: with(clean.u(), own.y().clone())?,
        })
    }
}

/// The standard deviation of a row (population).
pub fn deviation(signals: &DMatrix<f64>, row: usize) -> f64 {
    signals.row(row).variance().sqrt()
}
