//! A filter of a model that no error of some channels reaches.

use gtfdi::core::{OperatingPoint, Signal, StateSpace};
use gtfdi::fdi::{
    FaultModel, FdiError, NoiseCovariance, ResidualGenerator, UnknownInput, UnknownInputError,
};
use gtfdi::ident::eiv::{ChannelNoise, EivModel};
use nalgebra::{DMatrix, DVector};

use crate::CampaignError;
use crate::error::During;

/// One Kalman filter of an errors-in-variables model whose residuals do not feel what the channels
/// `unknown` do, whatever it is: unknown outputs are left out with the states that only they show,
/// and what an unknown input does to the others is a disturbance that is decoupled
/// ([`ResidualGenerator::unknown_input`]). Names that are no channel of the model have no effect.
///
/// # Errors
/// [`CampaignError`] when the model has no state space, no output is left, or there is no such
/// filter.
pub fn unknown_input_generator(
    noise: &EivModel,
    unknown: &[String],
) -> Result<ResidualGenerator, CampaignError> {
    let what = "Kalman filter without the unknown channels";
    let relation = noise.relation();
    let model = relation.state_space().during(what)?;
    let split = |signals: &[Signal]| -> (Vec<usize>, Vec<usize>) {
        (0..signals.len()).partition(|&index| !unknown.contains(&signals[index].name))
    };
    let (inputs, unknown_inputs) = split(model.inputs());
    let (outputs, _) = split(model.outputs());
    if outputs.is_empty() {
        let none = UnknownInputError::NoOutputLeft {
            disturbances: unknown_inputs.len(),
            outputs: 0,
        };
        return Err(FdiError::from(none)).during(what);
    }
    let states = reaching(&model, &outputs);
    let (a, b) = (
        model.a().select_rows(&states).select_columns(&states),
        model.b().select_rows(&states),
    );
    let (c, d) = (
        model.c().select_rows(&outputs).select_columns(&states),
        model.d().select_rows(&outputs),
    );
    let matrices = [a, b.select_columns(&inputs), c, d.select_columns(&inputs)];
    let (own_inputs, own_outputs) = (
        chosen(model.inputs(), &inputs),
        chosen(model.outputs(), &outputs),
    );
    let kept = StateSpace::new(matrices, model.sample_time_s(), own_inputs, own_outputs)
        .map_err(FdiError::from)
        .during(what)?;
    let point = relation.operating_point();
    let point = OperatingPoint {
        u: elements(&point.u, &inputs),
        y: elements(&point.y, &outputs),
    };
    let variances = |channels: &[ChannelNoise], wanted: &[usize]| -> Vec<f64> {
        wanted
            .iter()
            .map(|&index| channels[index].variance)
            .collect()
    };
    let covariance = NoiseCovariance::errors_in_variables(
        &kept,
        &variances(noise.input_noise(), &inputs),
        &variances(noise.output_noise(), &outputs),
    )
    .during(what)?;
    if unknown_inputs.is_empty() {
        return ResidualGenerator::kalman(kept, point, covariance).during(what);
    }
    let disturbance = UnknownInput {
        state: b.select_columns(&unknown_inputs),
        output: d.select_columns(&unknown_inputs),
    };
    let no_fault = UnknownInput::of_state(DMatrix::zeros(kept.nx(), 0), kept.ny());
    let disturbed = FaultModel::new(kept, disturbance, no_fault).during(what)?;
    ResidualGenerator::unknown_input(&disturbed, &point, &covariance).during(what)
}

/// The states that reach some of the outputs: those of an output that is left out may reach none.
fn reaching(model: &StateSpace, outputs: &[usize]) -> Vec<usize> {
    let nx = model.nx();
    let mut reaches: Vec<bool> = (0..nx)
        .map(|state| {
            outputs
                .iter()
                .any(|&output| model.c()[(output, state)] != 0.0)
        })
        .collect();
    // A path passes every state once at most.
    for _ in 0..nx {
        for state in 0..nx {
            let further = |next: usize| reaches[next] && model.a()[(next, state)] != 0.0;
            reaches[state] |= (0..nx).any(further);
        }
    }
    (0..nx).filter(|&state| reaches[state]).collect()
}

fn chosen(signals: &[Signal], wanted: &[usize]) -> Vec<Signal> {
    wanted.iter().map(|&index| signals[index].clone()).collect()
}

fn elements(values: &DVector<f64>, wanted: &[usize]) -> DVector<f64> {
    DVector::from_iterator(wanted.len(), wanted.iter().map(|&index| values[index]))
}

#[cfg(test)]
mod tests {
    use gtfdi::core::Dataset;
    use gtfdi::ident::eiv::{EivLags, EivRow};

    use super::*;

    /// A model of first order of each output, with these poles; every output has one of its own state
    /// only.
    fn model(outputs: &[(&str, f64)]) -> EivModel {
        let wave = |row: usize, sample: usize| (0.3 * sample as f64 * (row + 1) as f64).sin();
        let data = Dataset::new(
            Signal::named(&["u"]),
            Signal::named(&outputs.iter().map(|(name, _)| *name).collect::<Vec<_>>()),
            DMatrix::from_fn(1, 50, wave),
            DMatrix::from_fn(outputs.len(), 50, |row, sample| wave(row + 1, sample)),
            0.1,
        )
        .unwrap();
        let rows: Vec<EivRow> = outputs
            .iter()
            .map(|(_, pole)| {
                let lags = EivLags::new(1, vec![1]).unwrap();
                EivRow::new(lags, DVector::from_row_slice(&[-pole, 1.0])).unwrap()
            })
            .collect();
        let noise = |count: usize| {
            let one = ChannelNoise {
                variance: 0.01,
                standard_error: None,
                at_limit: false,
            };
            vec![one; count]
        };
        EivModel::from_rows(&data, &rows, None, noise(outputs.len()), noise(1)).unwrap()
    }

    /// A growing state that only an unknown output shows would leave no steady filter: it is dropped,
    /// and the filter is that of the model without the output.
    #[test]
    fn states_that_only_an_unknown_output_shows_are_dropped() {
        let without =
            |model: &EivModel, unknown: &[String]| unknown_input_generator(model, unknown);
        let found = without(&model(&[("a", 0.9), ("b", 1.2)]), &["b".to_owned()]).unwrap();
        let expected = without(&model(&[("a", 0.9)]), &[]).unwrap();
        assert_eq!(found.outputs(), expected.outputs());
        assert_eq!(found.model().nx(), 1);
        assert_eq!(found.gain(), expected.gain());
        let unseen = without(&model(&[("a", 0.9), ("b", 1.2)]), &["a".to_owned()]).unwrap();
        assert_eq!(unseen.model().a()[(0, 0)].to_bits(), 1.2_f64.to_bits());
    }
}
