//! A run but for its integration: an operation of a given length, recorded.

use nalgebra::DMatrix;

use crate::channels::ALL_OUTPUTS;
use crate::faults::{Fault, FaultSizes, Place};
use crate::inputs::Inputs;
use crate::operation::Operation;
use crate::scenario::Scenario;
use crate::state::STATES;
use crate::warning::Warning;
use crate::{PlantError, PlantParameters};

/// The true inputs (nu x N) and all outputs (34 x N) of a run.
pub(crate) struct Path {
    pub u: DMatrix<f64>,
    pub y: DMatrix<f64>,
    pub warnings: Vec<Warning>,
    pub ended: Option<PlantError>,
}

/// Drives and records one plant; the caller integrates.
pub(crate) struct Recorder<'a> {
    plant: &'a PlantParameters,
    operation: Operation,
    u: DMatrix<f64>,
    y: DMatrix<f64>,
    ended: Option<PlantError>,
}

impl<'a> Recorder<'a> {
    /// The recorder of a scenario, with the faults that act on the plant, and the state in which
    /// it starts.
    pub fn start(
        plant: &'a PlantParameters,
        scenario: &Scenario,
        faults: &[Fault],
    ) -> Result<(Self, [f64; STATES]), PlantError> {
        let n = scenario.samples()?;
        let (operation, x) = Operation::start(plant, scenario, faults)?;
        let recorder = Self {
            plant,
            operation,
            u: DMatrix::zeros(plant.variant.input_channels().len(), n),
            y: DMatrix::zeros(ALL_OUTPUTS, n),
            ended: None,
        };
        Ok((recorder, x))
    }

    /// What acts on the plant until the next sample.
    pub fn inputs(&self) -> &Inputs {
        self.operation.inputs()
    }

    /// As [`Operation::sizes`].
    #[inline]
    pub fn sizes(&self, t_s: f64) -> FaultSizes {
        self.operation.sizes(t_s)
    }

    /// The part of [`Self::sizes`] that holds until the next sample.
    pub fn held_sizes(&self) -> &FaultSizes {
        self.operation.faults().held()
    }

    /// The other part of [`Self::sizes`]: what is to be added where.
    #[inline]
    pub fn each_growing(&self, t_s: f64, add: impl FnMut(Place, f64)) {
        self.operation.each_growing(t_s, add);
    }

    /// Whether any fault acts on the plant.
    pub fn is_faulty(&self) -> bool {
        !self.operation.faults().is_healthy()
    }

    /// Samples that the scenario asks for.
    pub fn samples(&self) -> usize {
        self.y.ncols()
    }

    /// Whether samples are still to be read.
    pub fn is_running(&self) -> bool {
        self.ended.is_none() && self.operation.read() < self.y.ncols()
    }

    /// Reads a sample in the state `x`, then moves the inputs; false when the run is over.
    pub fn sample(&mut self, x: &[f64; STATES]) -> bool {
        let k = self.operation.read();
        match self.operation.sample(self.plant, x) {
            Ok(truth) => {
                self.y.column_mut(k).copy_from_slice(&truth.y);
                let rows = self.u.nrows();
                self.u.column_mut(k).copy_from_slice(&truth.u[..rows]);
                self.is_running()
            }
            Err(reason) => {
                self.ended = Some(reason);
                false
            }
        }
    }

    /// The record.
    pub fn finish(self) -> Path {
        let n = self.operation.read();
        Path {
            u: self.u.resize_horizontally(n, 0.0),
            y: self.y.resize_horizontally(n, 0.0),
            warnings: self.operation.warnings(),
            ended: self.ended,
        }
    }
}
