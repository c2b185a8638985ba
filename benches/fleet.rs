//! Throughput of one generator on many streams, 8 states, 2 inputs, 1 output in canonical form,
//! against one stream after the other, the loop that a user would write, and what memory and
//! arithmetic alone cost.
//!
//! `cargo bench -p gtfdi --bench fleet`

mod timing;

use std::error::Error;
use std::hint::black_box;

use gtfdi::core::{Dataset, OperatingPoint, Signal, StateSpace};
use gtfdi::fdi::{Fleet, ResidualGenerator};
use nalgebra::DMatrix;
use pulp::{Arch, Simd, WithSimd};

/// States and inputs of the generator.
const NX: usize = 8;
const NU: usize = 2;
/// Streams, and samples of each: together more than the caches hold.
const STREAMS: usize = 4096;
const SAMPLES: usize = 512;
/// Samples that a fleet takes at once.
const BLOCK: usize = 64;
/// Multiplications with an addition that a residual needs in canonical form: the first column and
/// the last row of `A - K C`, `B - K D`, `K` and `D`; the shift and `C x` need none.
const MULTIPLY_ADDS: usize = 2 * NX - 1 + NX * NU + NX + NU;
/// Bytes of a residual: inputs and output in, the residual out.
const BYTES: usize = 8 * (NU + 1 + 1);

fn main() -> Result<(), Box<dyn Error>> {
    let generator = generator()?;
    let mut normal = Normal(7);
    let mut draw = |count: usize| -> Vec<f64> { (0..count).map(|_| normal.next()).collect() };
    let u = draw(SAMPLES * NU * STREAMS);
    let y = draw(SAMPLES * STREAMS);
    let records: Vec<Dataset> = (0..STREAMS)
        .map(|stream| record(&u, &y, stream))
        .collect::<Result<_, _>>()?;
    let mut fleet = Fleet::new(&generator, STREAMS);
    let mut user = Canonical::new(&generator);
    let [mut by_block, mut by_sample, mut by_user, mut copied] =
        [(); 4].map(|()| vec![0.0; y.len()]);

    run(&mut fleet, BLOCK, &u, &y, &mut by_block)?;
    run(&mut fleet, 1, &u, &y, &mut by_sample)?;
    user.run(&u, &y, &mut by_user);
    let mut most = 0.0_f64;
    for (stream, record) in records.iter().enumerate() {
        let alone = generator.residuals(record)?;
        for (sample, expected) in alone.iter().enumerate() {
            let place = sample * STREAMS + stream;
            let found = [by_block[place], by_sample[place]];
            if found.map(f64::to_bits) != [expected.to_bits(); 2] {
                return Err(format!("stream {stream}, sample {sample} differs").into());
            }
            most = most.max((by_user[place] - expected).abs());
        }
    }
    println!(
        "Residuals of {STREAMS} streams, n = {NX}, r = {NU}, m = 1, {SAMPLES} samples: the fleet has \
         the bits of one stream, the loop of a user differs by {most:.0e}"
    );
    if most.is_nan() || most > 1e-9 {
        return Err("the loop of a user disagrees".into());
    }

    let times = timing::race(vec![
        (
            "one stream after the other",
            Box::new(|| {
                for record in &records {
                    let _ = black_box(generator.residuals(black_box(record)));
                }
            }),
        ),
        (
            "canonical loop over streams, as a user writes it",
            Box::new(|| user.run(black_box(&u), black_box(&y), &mut by_user)),
        ),
        (
            "gtfdi Fleet::step, a sample at a time",
            Box::new(|| {
                let _ = run(
                    &mut fleet.clone(),
                    1,
                    black_box(&u),
                    black_box(&y),
                    &mut by_sample,
                );
            }),
        ),
        (
            "gtfdi Fleet::step, 64 samples at a time",
            Box::new(|| {
                let (u, y) = (black_box(&u), black_box(&y));
                let _ = run(&mut fleet.clone(), BLOCK, u, y, &mut by_block);
            }),
        ),
        (
            "limit: memory, 24 B in and 8 B out a residual",
            Box::new(|| {
                Arch::new().dispatch(
                    #[inline(always)]
                    || pass(black_box(&u), black_box(&y), &mut copied),
                );
            }),
        ),
        (
            "limit: the multiply-adds alone",
            Box::new(|| {
                let count = black_box(STREAMS * SAMPLES * MULTIPLY_ADDS);
                black_box(Arch::new().dispatch(MultiplyAdds(count)));
            }),
        ),
    ]);
    let residuals = (STREAMS * SAMPLES) as f64;
    times.print(
        "M residuals/s",
        |seconds| 1e-6 * residuals / seconds,
        &[0, 1, 4, 5],
        ("", &[]),
    );
    println!(
        "/ [i]: speed over that of row i, median of rounds. Row 4: {:.1} GB/s without those that a \
         store reads first. Row 5: {MULTIPLY_ADDS} independent multiplications and additions a \
         residual, from registers, in the widest registers of the machine.",
        1e-9 * BYTES as f64 * residuals / times.median_s(4)
    );
    Ok(())
}

/// The samples in blocks through a fleet that is put to rest.
fn run(
    fleet: &mut Fleet,
    block: usize,
    u: &[f64],
    y: &[f64],
    residuals: &mut [f64],
) -> Result<(), Box<dyn Error>> {
    fleet.reset();
    let width = block * STREAMS;
    let samples = u.chunks(NU * width).zip(y.chunks(width));
    for ((u, y), residuals) in samples.zip(residuals.chunks_mut(width)) {
        fleet.step(u, y, residuals)?;
    }
    Ok(())
}

/// Eight poles from 0.3 to 0.97, observer poles at 0.4.
fn generator() -> Result<ResidualGenerator, Box<dyn Error>> {
    let poles: Vec<f64> = (0..NX).map(|i| 0.3 + 0.67 * i as f64 / 7.0).collect();
    let monic = poles.iter().fold(vec![1.0], |p: Vec<f64>, pole| {
        let mut product = vec![0.0; p.len() + 1];
        for (power, value) in p.iter().enumerate() {
            product[power + 1] += value;
            product[power] -= pole * value;
        }
        product
    });
    let a = DMatrix::from_fn(NX, NX, |i, j| match (i, j) {
        _ if i + 1 == NX => -monic[j],
        _ if j == i + 1 => 1.0,
        _ => 0.0,
    });
    let b = DMatrix::from_fn(NX, NU, |i, j| 0.5 / (1 + i + j) as f64);
    let c = DMatrix::from_fn(1, NX, |_, j| if j == 0 { 1.0 } else { 0.0 });
    let d = DMatrix::from_element(1, NU, 0.1);
    let (inputs, outputs) = (Signal::named(&["a", "b"]), Signal::named(&["y"]));
    let model = StateSpace::new([a, b, c, d], 0.08, inputs, outputs)?;
    let point = OperatingPoint::zero(NU, 1);
    Ok(ResidualGenerator::observer(model, point, &[0.4; NX])?)
}

/// One stream as a record.
fn record(u: &[f64], y: &[f64], stream: usize) -> Result<Dataset, Box<dyn Error>> {
    let u = DMatrix::from_fn(NU, SAMPLES, |i, k| u[(k * NU + i) * STREAMS + stream]);
    let y = DMatrix::from_fn(1, SAMPLES, |_, k| y[k * STREAMS + stream]);
    let (inputs, outputs) = (Signal::named(&["a", "b"]), Signal::named(&["y"]));
    Ok(Dataset::new(inputs, outputs, u, y, 0.08)?)
}

/// The innovation form, states of all streams side by side.
struct Canonical {
    last: [f64; NX],
    b: [[f64; NU]; NX],
    gain: [f64; NX],
    d: [f64; NU],
    x: [Vec<f64>; NX],
}

impl Canonical {
    fn new(generator: &ResidualGenerator) -> Self {
        let (model, gain) = (generator.model(), generator.gain());
        Self {
            last: std::array::from_fn(|j| model.a()[(NX - 1, j)]),
            b: std::array::from_fn(|i| std::array::from_fn(|j| model.b()[(i, j)])),
            gain: std::array::from_fn(|i| gain[i]),
            d: std::array::from_fn(|j| model.d()[j]),
            x: std::array::from_fn(|_| vec![0.0; STREAMS]),
        }
    }

    fn run(&mut self, u: &[f64], y: &[f64], residuals: &mut [f64]) {
        for x in &mut self.x {
            x.fill(0.0);
        }
        let samples = u.chunks(NU * STREAMS).zip(y.chunks(STREAMS));
        for ((u, y), residuals) in samples.zip(residuals.chunks_mut(STREAMS)) {
            let (first, second) = u.split_at(STREAMS);
            for stream in 0..STREAMS {
                let du = [first[stream], second[stream]];
                let x: [f64; NX] = std::array::from_fn(|i| self.x[i][stream]);
                let r = y[stream] - x[0] - self.d[0] * du[0] - self.d[1] * du[1];
                residuals[stream] = r;
                for i in 0..NX {
                    let shifted = if i + 1 < NX {
                        x[i + 1]
                    } else {
                        self.last.iter().zip(&x).map(|(a, x)| a * x).sum()
                    };
                    self.x[i][stream] =
                        shifted + self.b[i][0] * du[0] + self.b[i][1] * du[1] + self.gain[i] * r;
                }
            }
        }
    }
}

/// A pass over the data that computes next to nothing.
#[inline(always)]
fn pass(u: &[f64], y: &[f64], out: &mut [f64]) {
    let samples = u.chunks(NU * STREAMS).zip(y.chunks(STREAMS));
    for ((u, y), out) in samples.zip(out.chunks_mut(STREAMS)) {
        let (first, second) = u.split_at(STREAMS);
        for ((out, y), (first, second)) in out.iter_mut().zip(y).zip(first.iter().zip(second)) {
            *out = y - first - second;
        }
    }
}

/// So many multiplications and additions in registers, on sums that do not wait for each other.
struct MultiplyAdds(usize);

impl WithSimd for MultiplyAdds {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let factor = simd.splat_f64s(black_box(1.0 - 1e-9));
        let term = simd.splat_f64s(black_box(1e-9));
        let mut sums = [simd.splat_f64s(1.0); 8];
        for _ in 0..self.0 / (sums.len() * S::F64_LANES) {
            for sum in &mut sums {
                *sum = simd.add_f64s(simd.mul_f64s(*sum, factor), term);
            }
        }
        let add = |total, sum| simd.add_f64s(total, sum);
        simd.reduce_sum_f64s(sums.into_iter().fold(term, add))
    }
}

/// Standard normal numbers after Box and Muller.
struct Normal(u64);

impl Normal {
    fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        ((self.0 >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    fn next(&mut self) -> f64 {
        let (radius, angle) = (self.uniform(), self.uniform());
        (-2.0 * radius.ln()).sqrt() * (std::f64::consts::TAU * angle).cos()
    }
}
