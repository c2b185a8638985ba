//! One generator on many streams: the same bits as on each by itself.

use gt_core::{DimensionError, OperatingPoint, Signal, StateSpace};
use gt_fdi::design::{NoiseCovariance, ResidualGenerator};
use gt_fdi::runtime::{Cusum, CusumFleet, Fleet, FleetError, Sides, Statistic};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use crate::fixtures::{TS, canonical, noise, plain_generator, transformed};

/// The generator alone on the stream `stream` of `streams`: from a record, from one with its channels
/// elsewhere, and from numbers, which are the same bits.
#[allow(clippy::unwrap_used)] // part of the tests below
fn alone(
    generator: &ResidualGenerator,
    streams: usize,
    stream: usize,
    (u, y): (&[f64], &[f64]),
) -> Vec<u64> {
    let (nu, ny) = (generator.inputs().len(), generator.outputs().len());
    let own = |values: &[f64], rows: usize| {
        let values: Vec<f64> = values
            .iter()
            .skip(stream)
            .step_by(streams)
            .copied()
            .collect();
        DMatrix::from_vec(rows, values.len() / rows, values)
    };
    let signals = (generator.inputs().to_vec(), generator.outputs().to_vec());
    let data = gt_core::Dataset::new(signals.0, signals.1, own(u, nu), own(y, ny), TS).unwrap();
    let bits = |residuals: DMatrix<f64>| -> Vec<u64> {
        residuals.iter().map(|value| value.to_bits()).collect()
    };
    let residuals = bits(generator.residuals(&data).unwrap());
    let reversed = |signals: &[Signal]| -> Vec<String> {
        signals.iter().rev().map(|own| own.name.clone()).collect()
    };
    let (inputs, outputs) = (reversed(data.outputs()), reversed(data.inputs()));
    let elsewhere = data.select(&inputs, &outputs).unwrap();
    assert_eq!(residuals, bits(generator.residuals(&elsewhere).unwrap()));
    let (u, y) = (data.u().as_slice(), data.y().as_slice());
    assert_eq!(residuals, bits(generator.residuals_of(u, y).unwrap()));
    residuals
}

/// A generator with `ny` outputs and `nx` states: in canonical form with one output, else a Kalman
/// filter in random coordinates.
fn generator(nx: usize, ny: usize, seed: u64) -> Option<ResidualGenerator> {
    let draws = noise(seed, 2 * nx * (nx + ny + 2) + 2 * ny);
    let poles: Vec<f64> = draws.iter().take(nx).map(|draw| draw.tanh()).collect();
    let point = OperatingPoint {
        u: DVector::from_vec(vec![3.0, 0.0]),
        y: DVector::from_element(ny, if seed.is_multiple_of(2) { 10.0 } else { 0.0 }),
    };
    let b = DMatrix::from_column_slice(nx, 2, &draws[nx..3 * nx]);
    if ny == 1 {
        let d = DMatrix::from_row_slice(1, 2, &[0.0, draws[3 * nx]]);
        let model = canonical(&poles, b, d, "y0");
        return ResidualGenerator::observer(model, point, &vec![0.4; nx]).ok();
    }
    let a = DMatrix::from_fn(nx, nx, |i, j| {
        0.2 * draws[3 * nx + i * nx + j] + if i == j { poles[i] * 0.7 } else { 0.0 }
    });
    let c = DMatrix::from_column_slice(ny, nx, &draws[(3 + nx) * nx..][..ny * nx]);
    let d = DMatrix::from_fn(ny, 2, |i, j| draws[draws.len() - 1 - 2 * i - j]);
    let names: Vec<String> = (0..ny).map(|i| format!("y{i}")).collect();
    let (inputs, outputs) = (Signal::named(&["u0", "u1"]), Signal::named(&names));
    let model = StateSpace::new([a, b, c, d], TS, inputs, outputs).ok()?;
    let identity = |size| DMatrix::identity(size, size);
    let noise = NoiseCovariance::new(&identity(nx), &identity(ny), &DMatrix::zeros(nx, ny)).ok()?;
    ResidualGenerator::kalman(model, point, noise).ok()
}

/// An output out of all range is kept out of the state, also where an input hides it in the residual
/// and in the corrected state: `A = 0.5`, `K = 0.25`, `C = D = 1`, `B = 0`.
#[test]
fn an_output_that_an_input_hides_is_kept_out() {
    let d = DMatrix::from_row_slice(1, 2, &[1.0, 0.0]);
    let model = canonical(&[0.5], DMatrix::zeros(1, 2), d, "y0");
    let point = OperatingPoint::zero(2, 1);
    let generator = ResidualGenerator::observer(model, point, &[0.25]).unwrap();
    let huge = 2.0_f64.powi(600);
    let u = [0.0, 0.0, huge, 0.0, 0.0, 0.0];
    let y = [1.0, huge, 0.0];
    // The state is 0.25 after the first sample and half of that, predicted, after the second.
    let expected = [1.0, 0.0, -0.125];
    let residuals = generator.residuals_of(&u, &y).unwrap();
    assert_eq!(residuals.as_slice(), expected);
    let mut fleet = Fleet::new(&generator, 1);
    let mut residuals = [0.0; 3];
    fleet.step(&u, &y, &mut residuals).unwrap();
    assert_eq!(residuals, expected);
}

#[test]
fn numbers_that_are_no_whole_samples_are_refused() {
    let generator = generator(3, 2, 1).unwrap();
    for (u, y, expected, what) in [
        (4, 5, 4, "numbers in y (outputs x samples)"),
        (5, 4, 4, "numbers in u (inputs x samples)"),
    ] {
        let found = generator.residuals_of(&vec![0.0; u], &vec![0.0; y]);
        let error = DimensionError {
            what: what.to_owned(),
            expected,
            found: 5,
        };
        assert_eq!(found, Err(error));
    }
}

/// A value that upsets a generator, by its number.
fn upset(number: u8) -> f64 {
    match number {
        0 => f64::NAN,
        1 => f64::INFINITY,
        2 => 1e308,
        3 => -1e160,
        4 => 1e120,
        5 => 1e99,
        _ => -0.0,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Samples one by one and in blocks of any length, with everything that can go wrong in some
    /// streams, against the generator on each stream alone.
    #[test]
    fn prop_a_fleet_gives_the_bits_of_one_stream(
        (nx, ny) in (1_usize..12, 1_usize..6),
        streams in 1_usize..80,
        cuts in prop::collection::vec(1_usize..90, 4),
        seed in any::<u64>(),
        upsets in prop::collection::vec((any::<usize>(), any::<bool>(), 0_u8..8), 0..12),
    ) {
        let Some(generator) = generator(nx, ny, seed) else { return Ok(()) };
        let samples: usize = cuts.iter().sum();
        let mut u = noise(seed ^ 1, samples * 2 * streams);
        let mut y = noise(seed ^ 2, samples * ny * streams);
        for (place, input, number) in upsets {
            let of = if input { &mut u } else { &mut y };
            let place = place % of.len();
            of[place] = upset(number);
        }
        let mut fleet = Fleet::new(&generator, streams);
        let mut residuals = vec![0.0; y.len()];
        let mut begin = 0;
        for length in cuts {
            let part = |of: usize| begin * of * streams..(begin + length) * of * streams;
            let own = &mut residuals[part(ny)];
            fleet.step(&u[part(2)], &y[part(ny)], own).unwrap();
            begin += length;
        }
        for stream in 0..streams {
            let found = residuals.iter().skip(stream).step_by(streams);
            let found: Vec<u64> = found.map(|value| value.to_bits()).collect();
            let expected = alone(&generator, streams, stream, (&u, &y));
            for (index, (found, expected)) in found.iter().zip(&expected).enumerate() {
                let values = (f64::from_bits(*found), f64::from_bits(*expected));
                // The sign and the payload of a NaN say nothing.
                let same = found == expected || (values.0.is_nan() && values.1.is_nan());
                prop_assert!(same, "stream {stream}, residual {index}: {values:?}");
            }
        }
    }
}

/// A generator of one output with these poles and the effects of its inputs, in canonical form or in
/// random coordinates.
fn single(
    poles: &[f64],
    markov: &DMatrix<f64>,
    coordinates: Option<&DMatrix<f64>>,
) -> Option<ResidualGenerator> {
    let (nx, nu) = (poles.len(), markov.ncols());
    let d = markov.rows(nx, 1).into_owned();
    let mut model = canonical(poles, markov.rows(0, nx).into_owned(), d, "y0");
    if let Some(coordinates) = coordinates {
        model = transformed(&model, coordinates);
    }
    let point = OperatingPoint {
        u: DVector::from_element(nu, 3.0),
        y: DVector::from_element(1, 10.0),
    };
    ResidualGenerator::observer(model, point, &vec![0.4; nx]).ok()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Up to four inputs and eight states are computed by loops of their own, those of a canonical
    /// form by others again, and more inputs by one that takes any: with inputs that have no effect
    /// it finds the same, in a batch and one by one.
    #[test]
    fn prop_inputs_without_effect_change_no_bit(
        (nx, nu) in (1_usize..9, 1_usize..5),
        (in_canonical_form, last_is_idle) in any::<(bool, bool)>(),
        samples in 1_usize..100,
        seed in any::<u64>(),
        upsets in prop::collection::vec((any::<usize>(), any::<bool>(), 0_u8..8), 0..4),
    ) {
        const MORE: usize = 5;
        let draws = noise(seed, nx + nx * nx + (nx + 1) * nu);
        let poles: Vec<f64> = draws.iter().take(nx).map(|draw| draw.tanh()).collect();
        let coordinates = DMatrix::identity(nx, nx)
            + 0.2 * DMatrix::from_column_slice(nx, nx, &draws[nx..nx + nx * nx]);
        let coordinates = (!in_canonical_form).then_some(&coordinates);
        let mut markov = DMatrix::from_column_slice(nx + 1, nu, &draws[nx + nx * nx..]);
        if last_is_idle {
            markov.column_mut(nu - 1).fill(0.0);
        }
        let wider = markov.clone().resize_horizontally(MORE, 0.0);
        let (Some(few), Some(more)) = (
            single(&poles, &markov, coordinates),
            single(&poles, &wider, coordinates),
        ) else { return Ok(()) };
        let mut u = DMatrix::from_vec(MORE, samples, noise(seed ^ 1, MORE * samples));
        let mut y = noise(seed ^ 2, samples);
        for (place, input, number) in upsets {
            let sample = place % samples;
            if input {
                u[(place / samples % nu, sample)] = upset(number);
            } else {
                y[sample] = upset(number);
            }
        }
        let own = u.rows(0, nu).into_owned();
        let batch = [
            few.residuals_of(own.as_slice(), &y).unwrap(),
            more.residuals_of(u.as_slice(), &y).unwrap(),
        ];
        let one_by_one = |generator: &ResidualGenerator, u: &[f64]| {
            let mut fleet = Fleet::new(generator, 1);
            let mut residuals = vec![0.0; samples];
            fleet.step(u, &y, &mut residuals).unwrap();
            residuals
        };
        let stepped = [one_by_one(&few, own.as_slice()), one_by_one(&more, u.as_slice())];
        for sample in 0..samples {
            let expected = batch[1][(0, sample)];
            for found in [batch[0][(0, sample)], stepped[0][sample], stepped[1][sample]] {
                // The sign and the payload of a NaN say nothing.
                let same = found.to_bits() == expected.to_bits() || (found.is_nan() && expected.is_nan());
                prop_assert!(same, "sample {sample}: {found:e} and {expected:e}");
            }
        }
    }
}

#[test]
fn a_fleet_that_is_reset_begins_again() {
    let generator = plain_generator("y");
    let mut fleet = Fleet::new(&generator, 3);
    let (u, y) = (noise(1, 12), noise(2, 6));
    let (mut first, mut second) = (vec![0.0; 6], vec![0.0; 6]);
    fleet.step(&u, &y, &mut first).unwrap();
    fleet.reset();
    fleet.step(&u, &y, &mut second).unwrap();
    assert_eq!((first, fleet.streams()), (second, 3));
}

#[test]
fn samples_of_another_size_are_refused() {
    let mut fleet = Fleet::new(&plain_generator("y"), 3);
    let mut step = |u: usize, y: usize, residuals: usize| {
        fleet.step(&vec![0.0; u], &vec![0.0; y], &mut vec![0.0; residuals])
    };
    assert_eq!(step(12, 6, 6), Ok(()));
    for (sizes, what, expected, found) in [
        ((12, 7, 7), "outputs", 6, 7),
        ((11, 6, 6), "inputs", 12, 11),
        ((12, 6, 5), "residuals", 6, 5),
    ] {
        let error = FleetError {
            what,
            expected,
            found,
        };
        assert_eq!(step(sizes.0, sizes.1, sizes.2), Err(error));
    }
    let mut none = Fleet::new(&plain_generator("y"), 0);
    assert_eq!(none.step(&[], &[], &mut []), Ok(()));
}

/// Values after each residual, with missing and huge ones, whole tiles and what is left over.
#[test]
fn sums_of_many_streams_are_those_of_one() {
    let (streams, samples) = (21, 50);
    let mut r: Vec<f64> = noise(5, samples * streams)
        .iter()
        .map(|r| 2.0 * r)
        .collect();
    for (place, value) in [
        (3, f64::NAN),
        (200, f64::INFINITY),
        (401, 1e300),
        (777, -1e300),
    ] {
        r[place] = value;
    }
    for sides in [Sides::Upper, Sides::Lower, Sides::Both] {
        let cusum = Cusum::new(0.5, 5.0, sides).unwrap();
        let mut fleet = CusumFleet::new(&cusum, streams);
        let mut values = vec![0.0; r.len()];
        let (first, rest) = r.split_at(7 * streams);
        let (first_values, other_values) = values.split_at_mut(first.len());
        fleet.step(first, first_values).unwrap();
        fleet.step(rest, other_values).unwrap();
        for stream in 0..streams {
            let mut one = cusum.clone();
            for place in (stream..r.len()).step_by(streams) {
                assert_eq!(values[place], one.step(r[place]).value, "{sides:?} {place}");
            }
        }
        assert!(values.iter().any(|&value| value > fleet.threshold()));
        let again = values.clone();
        fleet.reset();
        fleet.step(&r, &mut values).unwrap();
        assert_eq!(again, values);
        let short = fleet.step(&r[1..], &mut values);
        let expected = (samples - 1) * streams;
        let (what, found) = ("residuals", r.len() - 1);
        let error = FleetError {
            what,
            expected,
            found,
        };
        assert_eq!(short, Err(error));
        assert!(fleet.step(&r, &mut values[1..]).is_err());
    }
}
