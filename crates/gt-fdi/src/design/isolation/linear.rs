//! Generators as linear systems of deviations.

use nalgebra::{DMatrix, DVector};

use crate::FdiError;
use crate::design::generator::ResidualGenerator;
use crate::design::joint_whitening::JointWhitening;
use crate::runtime::{Generator, Update};

/// The tags of a set of generators.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tags {
    /// Of all inputs that are not outputs.
    pub(super) inputs: Vec<String>,
    /// Of the outputs, in the order of the generators.
    pub(super) outputs: Vec<String>,
}

impl Tags {
    pub(super) fn of(generators: &[ResidualGenerator]) -> Self {
        let signals = generators.iter().flat_map(ResidualGenerator::outputs);
        let outputs: Vec<String> = signals.map(|signal| signal.name.clone()).collect();
        let mut inputs: Vec<String> = Vec::new();
        for signal in generators.iter().flat_map(ResidualGenerator::inputs) {
            if !inputs.contains(&signal.name) && !outputs.contains(&signal.name) {
                inputs.push(signal.name.clone());
            }
        }
        Self { inputs, outputs }
    }

    fn places(&self, generator: &ResidualGenerator) -> Vec<usize> {
        let own = generator.inputs().iter();
        own.filter_map(|signal| {
            let mut all = self.inputs.iter().chain(&self.outputs);
            all.position(|tag| *tag == signal.name)
        })
        .collect()
    }

    /// The generators in flat arrays, round their operating points.
    pub(super) fn runtime(&self, generators: &[ResidualGenerator]) -> Vec<Generator> {
        let own = generators.iter();
        own.map(|generator| generator.runtime(self.places(generator)))
            .collect()
    }

    /// The generators in flat arrays, round 0: what they make of deviations.
    pub(super) fn linear(&self, generators: &[ResidualGenerator]) -> Vec<Generator> {
        let own = generators.iter();
        own.map(|generator| generator.runtime_of_deviations(self.places(generator)))
            .collect()
    }

    /// The residuals' change (m x N) for changes of the inputs (nu x N) and outputs (m x N).
    pub(super) fn response(
        &self,
        generators: &[ResidualGenerator],
        u: &DMatrix<f64>,
        y: &DMatrix<f64>,
    ) -> DMatrix<f64> {
        let mut linear = self.linear(generators);
        let mut change = DMatrix::zeros(self.outputs.len(), y.ncols());
        for (sample, mut column) in change.column_iter_mut().enumerate() {
            let (u, y) = (u.column(sample), y.column(sample));
            let mut first = 0;
            for generator in &mut linear {
                let own = first..first + generator.ny();
                let residuals = &mut column.as_mut_slice()[own.clone()];
                if generator.step(u.as_slice(), y.as_slice(), first, residuals) != Update::Residual
                {
                    residuals.fill(0.0);
                }
                first = own.end;
            }
        }
        change
    }

    /// `I - C (I - A + K C)^-1 K` of all generators (m x m), by their own recursion: what a lasting
    /// change of the outputs becomes.
    pub(super) fn steady_gain(&self, generators: &[ResidualGenerator]) -> DMatrix<f64> {
        let size = self.outputs.len();
        let settle = generators.iter().map(ResidualGenerator::settle_samples);
        // The square of the level at which a generator counts as settled.
        let length = 2 * settle.max().unwrap_or(0) + 2;
        let mut gain = DMatrix::zeros(size, size);
        for output in 0..size {
            let mut y = DMatrix::zeros(size, length);
            y.row_mut(output).fill(1.0);
            let change = self.response(generators, &DMatrix::zeros(self.inputs.len(), length), &y);
            gain.column_mut(output)
                .copy_from(&change.column(length - 1));
        }
        gain
    }

    /// Samples by which the whitened residuals follow changes (m) of the outputs that grow evenly.
    pub(super) fn growth_delay(
        &self,
        generators: &[ResidualGenerator],
        whitening: &JointWhitening,
        changes: &DVector<f64>,
    ) -> Result<f64, FdiError> {
        let settle = generators
            .iter()
            .map(ResidualGenerator::settle_samples)
            .max();
        let length = 2 * (settle.unwrap_or(0) + whitening.order()) + 2;
        let y = DMatrix::from_fn(changes.len(), length, |row, t| changes[row] * t as f64);
        let u = DMatrix::zeros(self.inputs.len(), length);
        let white = whitening.response(&self.response(generators, &u, &y))?;
        let (last, before) = (white.column(length - 1), white.column(length - 2));
        let growth = last - before;
        Ok((length - 1) as f64 - last.dot(&growth) / growth.norm_squared())
    }

    /// Samples until the whitened residuals have answered to a sudden change (m) of the outputs: they
    /// are off what they stay at by less than `tolerance` of it.
    pub(super) fn answer_time(
        &self,
        generators: &[ResidualGenerator],
        whitening: &JointWhitening,
        changes: &DVector<f64>,
        tolerance: f64,
    ) -> Result<usize, FdiError> {
        let settle = generators.iter().map(ResidualGenerator::settle_samples);
        let length = 2 * (settle.max().unwrap_or(0) + whitening.order()) + 2;
        let y = DMatrix::from_fn(changes.len(), length, |row, _| changes[row]);
        let u = DMatrix::zeros(self.inputs.len(), length);
        let white = whitening.response(&self.response(generators, &u, &y))?;
        let last = white.column(length - 1);
        let near =
            |sample: &usize| (white.column(*sample) - last).norm() <= tolerance * last.norm();
        Ok(length - (0..length).rev().take_while(near).count())
    }
}
