//! The unknown-input observer in the form that the online detector runs.

use gt_core::{OperatingPoint, StateSpace};
use nalgebra::{DMatrix, DVector};

use super::super::filter_error::FilterError;
use super::super::generator::ResidualGenerator;
use super::super::noise::NoiseCovariance;
use super::decoupling::{Decoupling, output_scales};
use super::fault_model::FaultModel;
use crate::FdiError;

impl ResidualGenerator {
    /// The residuals of [`UnknownInputObserver::kalman`](super::UnknownInputObserver::kalman), which
    /// no disturbance reaches, as a Kalman filter of some of the outputs, for banks and detectors.
    ///
    /// Of its residuals `M (y - D u) - C_r xi` (nr), `M (nr x ny)`, those columns of M with the most
    /// distinct directions make a square part, whose inverse gives each of as many outputs a residual
    /// of its own, in its unit: those are the outputs of the generator. The other outputs are inputs
    /// of it, after those of the model. The filter is the same: what it reads of its own outputs
    /// besides goes into A and the gain, and their errors out of Q. Such an A often grows, and then
    /// the generator begins anew after an output that is missing
    /// ([`MAX_PREDICTED_RADIUS`](super::super::MAX_PREDICTED_RADIUS)).
    ///
    /// `point` has the inputs (nu) and outputs (ny) of the model, `noise` its states and outputs.
    ///
    /// # Errors
    /// [`FdiError::Dimension`] for sizes that disagree; else as [`UnknownInputObserver::kalman`](super::UnknownInputObserver::kalman) and
    /// [`ResidualGenerator::kalman`].
    pub fn unknown_input(
        model: &FaultModel,
        point: &OperatingPoint,
        noise: &NoiseCovariance,
    ) -> Result<Self, FdiError> {
        let decoupling = Decoupling::of(model)?;
        let (plant, reduced) = (model.model(), &decoupling.reduced);
        let (nu, ny) = (plant.nu(), plant.ny());
        let point_sizes = [
            ("inputs of the operating point", nu, point.u.len()),
            ("outputs of the operating point", ny, point.y.len()),
        ];
        for (what, expected, found) in point_sizes {
            gt_core::DimensionError::check(what, expected, found)?;
        }
        let m = &decoupling.outputs;
        let scales = output_scales(plant, &model.disturbance().output);
        let unscaled = DMatrix::from_fn(m.nrows(), ny, |row, output| {
            m[(row, output)] / scales[(output, output)]
        });
        let own = distinct_columns(&unscaled);
        let others: Vec<usize> = (0..ny).filter(|output| !own.contains(output)).collect();
        let inverse = m
            .select_columns(&own)
            .try_inverse()
            .ok_or(FilterError::SingularInnovation)?;

        // The outputs of the generator, of the state and of its inputs.
        let c = &inverse * reduced.c();
        let known = |of_inputs: DMatrix<f64>, of_outputs: &DMatrix<f64>| {
            let mut joint = DMatrix::zeros(of_inputs.nrows(), nu + others.len());
            joint.columns_mut(0, nu).copy_from(&of_inputs);
            let rest = of_outputs.select_columns(&others);
            joint.columns_mut(nu, others.len()).copy_from(&rest);
            joint
        };
        let d = known(&inverse * m * plant.d(), &(-&inverse * m));
        let of_outputs = reduced.b().columns(nu, ny).into_owned();
        let fed_back = of_outputs.select_columns(&own);
        let a = reduced.a() + &fed_back * &c;
        let b = known(reduced.b().columns(0, nu).into_owned(), &of_outputs) + &fed_back * &d;

        // What the filter reads of its own outputs takes their errors out of the state again.
        let m = &inverse * m;
        let mut errors = &of_outputs - &fed_back * &m;
        for &output in &own {
            errors.column_mut(output).fill(0.0);
        }
        let noise = decoupling.noise_through(noise, &errors, &m)?;

        let pick = |wanted: &[usize]| {
            let signals = wanted.iter().map(|&output| plant.outputs()[output].clone());
            signals.collect::<Vec<_>>()
        };
        let inputs = [plant.inputs().to_vec(), pick(&others)].concat();
        let own_point = OperatingPoint {
            u: DVector::from_iterator(
                nu + others.len(),
                (point.u.iter().copied()).chain(others.iter().map(|&output| point.y[output])),
            ),
            y: DVector::from_iterator(own.len(), own.iter().map(|&output| point.y[output])),
        };
        let form = StateSpace::new([a, b, c, d], plant.sample_time_s(), inputs, pick(&own))?;
        Self::kalman(form, own_point, noise)
    }
}

/// As many columns as there are rows, each the one that is furthest from the span of those before
/// it, in ascending order.
fn distinct_columns(matrix: &DMatrix<f64>) -> Vec<usize> {
    let mut left = matrix.clone();
    let mut chosen = Vec::with_capacity(matrix.nrows());
    for _ in 0..matrix.nrows().min(matrix.ncols()) {
        let norms = left.column_iter().map(|column| column.norm());
        let (mut best, mut largest) = (0, -1.0);
        for (index, norm) in norms.enumerate() {
            if norm > largest && !chosen.contains(&index) {
                (best, largest) = (index, norm);
            }
        }
        chosen.push(best);
        if largest > 0.0 {
            let direction = left.column(best) / largest;
            left -= &direction * (direction.transpose() * &left);
        }
    }
    chosen.sort_unstable();
    chosen
}
