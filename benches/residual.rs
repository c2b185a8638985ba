//! Throughput of one residual stream: the observer of t3 on the simulated turbine, 8 states, 2
//! inputs, 1 output, and one of 8 states and 4 outputs, against the loops that a user would write with nalgebra, and against what the
//! arithmetic alone costs.
//!
//! `cargo bench -p gtfdi --bench residual`

mod timing;

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use gtfdi::core::{Dataset, OperatingPoint, StateSpace};
use gtfdi::fdi::{
    Bank, Detector, NoiseCovariance, ResidualGenerator, ResidualTest, StatisticKind, ThresholdRule,
};
use gtfdi::ident::{Arx, ArxStructure};
use gtfdi::plant::{NoiseLevel, Scenario, simulate};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// States and inputs of the observer.
const NX: usize = 8;
const NU: usize = 2;
/// Multiplications with an addition that one sample needs: `(A - K C) x`, `(B - K D) du`, `K dy`,
/// `C x` and `D du`.
const MULTIPLY_ADDS: usize = NX * NX + NX * NU + NX + NX + NU;
/// Largest difference of two residuals over the largest output deviation: the additions come in
/// another order, and the states are as large as the deviations.
const AGREEMENT: f64 = 1e-11;

fn main() -> Result<(), Box<dyn Error>> {
    let record = |run_index| {
        let scenario = Scenario {
            noise: NoiseLevel::Low.into(),
            run_index,
            ..Scenario::default()
        };
        simulate(&scenario).map(|run| run.measured)
    };
    let (training, data) = (record(0)?, record(1)?);
    let poles = [("t3", 0.3), ("q_c", 0.7), ("p7", 0.4), ("m9", 0.4)];
    let parts = poles
        .map(|(tag, pole)| observer(&training, tag, pole))
        .into_iter()
        .collect::<Result<Vec<_>, _>>()?;
    let (generators, tests): (Vec<_>, Vec<_>) = parts.into_iter().unzip();
    let generator = generators[0].clone();
    let one = data.select(&["a_v", "M_f"], &["t3"])?;
    let four = data.select(&["a_v", "M_f"], &poles.map(|(tag, _)| tag))?;
    let (first, its_test) = (generators[..1].to_vec(), tests[..1].to_vec());
    let mut single = Detector::new(&Bank::new("one", first, its_test)?);
    let mut bank = Detector::new(&Bank::new("four", generators, tests)?);

    check_agreement(&generator, &mut single, &one)?;
    let joint = joint(&four)?;
    let mut columns = Columns::new(&generator);
    let times = timing::race(vec![
        (
            "nalgebra, DMatrix, as a user writes it",
            Box::new(|| {
                black_box(dynamic_loop(black_box(&generator), black_box(&one)));
            }),
        ),
        (
            "nalgebra, SMatrix<8, 8>",
            Box::new(|| {
                black_box(fixed_loop(black_box(&generator), black_box(&one)));
            }),
        ),
        (
            "columns of A - K C in arrays, sizes known",
            Box::new(|| {
                black_box(columns.run(black_box(&one)));
            }),
        ),
        (
            "gtfdi batch, ResidualGenerator::residuals",
            Box::new(|| {
                let _ = black_box(black_box(&generator).residuals(black_box(&one)));
            }),
        ),
        (
            "gtfdi batch, 4 outputs of 8 states",
            Box::new(|| {
                let _ = black_box(black_box(&joint).residuals(black_box(&four)));
            }),
        ),
        (
            "gtfdi online, Detector::step with verdict",
            Box::new(|| {
                let _ = black_box(online(&mut single, black_box(&one)));
            }),
        ),
        (
            "floor: the multiply-adds alone",
            Box::new(|| {
                black_box(multiply_adds(black_box(one.len() * MULTIPLY_ADDS)));
            }),
        ),
        (
            "floor: 24 B in, 8 B out a sample",
            Box::new(|| {
                black_box(copy(black_box(&one)));
            }),
        ),
    ]);
    println!();
    let rate = |seconds: f64| 1e-6 * one.len() as f64 / seconds;
    times.print("M samples/s", rate, &[0, 1, 6], ("", &[]));
    println!(
        "/ [i]: speed over that of row i, median of rounds. Row 6: {MULTIPLY_ADDS} independent \
         multiply-adds a sample, from registers, with this build's instruction set."
    );

    let worst = latency(&mut bank, &four)?;
    println!(
        "\nDetector::step, 4 outputs, with decision and clock: median {:.0} ns, p99.9 {:.0} ns \
         (goal: below 5000 ns)",
        worst[0], worst[1]
    );
    Ok(())
}

/// Refuses to time contenders that disagree.
fn check_agreement(
    generator: &ResidualGenerator,
    single: &mut Detector,
    one: &Dataset,
) -> Result<(), Box<dyn Error>> {
    let expected = dynamic_loop(generator, one);
    let scale = one.relative_to(generator.point())?.y().amax();
    println!(
        "Residuals of one stream, n = {NX}, r = {NU}, m = 1, {} samples",
        one.len()
    );
    for (name, residuals) in [
        ("fixed-size nalgebra", fixed_loop(generator, one)),
        ("column arrays", Columns::new(generator).run(one)),
        ("batch", generator.residuals(one)?.as_slice().to_vec()),
        ("online", online(single, one)?),
    ] {
        let pairs = residuals.iter().zip(&expected);
        let most = pairs.map(|(r, e)| (r - e).abs()).fold(0.0, f64::max) / scale;
        println!("{name}: differs from [0] by {most:.1e} of the output (at most {AGREEMENT:.0e})");
        if most.is_nan() || most > AGREEMENT {
            return Err(format!("{name} disagrees with the baseline: {most:e}").into());
        }
    }
    Ok(())
}

/// The paper's observer of one output: ARX of order 8, all poles at one place.
fn observer(
    training: &Dataset,
    tag: &str,
    pole: f64,
) -> Result<(ResidualGenerator, ResidualTest), Box<dyn Error>> {
    let data = training.select(&["a_v", "M_f"], &[tag])?;
    let (na, nb, nk) = (NX, vec![8, 9], vec![1, 0]);
    let model = Arx::new(ArxStructure::Diagonal { na, nb, nk }).fit(&data)?;
    let part = model.output_model(0)?;
    let generator = ResidualGenerator::observer(part.model, part.point, &[pole; NX])?;
    let (factor, consecutive) = (2.0, 1);
    let rule = ThresholdRule::Margin {
        factor,
        consecutive,
    };
    let statistic = StatisticKind::Modulus;
    let test = ResidualTest::calibrate(tag, &[&generator], &[data], statistic, rule)?;
    Ok((generator, test))
}

/// A Kalman filter of 8 states and the 4 outputs of a record. Its equations are made up: a throughput
/// does not ask where they come from.
fn joint(record: &Dataset) -> Result<ResidualGenerator, Box<dyn Error>> {
    let a = DMatrix::from_fn(NX, NX, |i, j| match (i, j) {
        _ if i == j => 0.5 + 0.05 * i as f64,
        _ => 0.02 / (1 + i + 2 * j) as f64,
    });
    let b = DMatrix::from_fn(NX, NU, |i, j| 0.5 / (1 + i + j) as f64);
    let c = DMatrix::from_fn(4, NX, |i, j| 1.0 / (1 + i + j) as f64);
    let d = DMatrix::from_element(4, NU, 0.1);
    let signals = (record.inputs().to_vec(), record.outputs().to_vec());
    let model = StateSpace::new([a, b, c, d], record.sample_time_s(), signals.0, signals.1)?;
    let (q, r) = (DMatrix::identity(NX, NX), DMatrix::identity(4, 4));
    let noise = NoiseCovariance::new(&q, &r, &DMatrix::zeros(NX, 4))?;
    let point = OperatingPoint::zero(NU, 4);
    Ok(ResidualGenerator::kalman(model, point, noise)?)
}

/// What a user of nalgebra would write first.
fn dynamic_loop(generator: &ResidualGenerator, data: &Dataset) -> Vec<f64> {
    let (model, gain, point) = (generator.model(), generator.gain(), generator.point());
    let mut x = DVector::zeros(model.nx());
    let samples = data.u().column_iter().zip(data.y().iter());
    samples
        .map(|(u, y)| {
            let du = u - &point.u;
            let r = y - point.y[0] - (model.c() * &x)[0] - (model.d() * &du)[0];
            x = model.a() * &x + model.b() * du + gain.column(0) * r;
            r
        })
        .collect()
}

/// The same with sizes that the compiler knows.
fn fixed_loop(generator: &ResidualGenerator, data: &Dataset) -> Vec<f64> {
    let (model, point) = (generator.model(), generator.point());
    let a = SMatrix::<f64, NX, NX>::from_iterator(model.a().iter().copied());
    let b = SMatrix::<f64, NX, NU>::from_iterator(model.b().iter().copied());
    let c = SMatrix::<f64, 1, NX>::from_iterator(model.c().iter().copied());
    let d = SMatrix::<f64, 1, NU>::from_iterator(model.d().iter().copied());
    let gain = SVector::<f64, NX>::from_iterator(generator.gain().iter().copied());
    let u0 = SVector::<f64, NU>::from_iterator(point.u.iter().copied());
    let mut x = SVector::<f64, NX>::zeros();
    let samples = data.u().column_iter().zip(data.y().iter());
    samples
        .map(|(u, y)| {
            let du = u.fixed_rows::<NU>(0) - u0;
            let r = y - point.y[0] - (c * x)[0] - (d * du)[0];
            x = a * x + b * du + gain * r;
            r
        })
        .collect()
}

/// The closed loop by columns: what arrays of known size reach.
struct Columns {
    a: [[f64; NX]; NX],
    b: [[f64; NX]; NU],
    gain: [f64; NX],
    c: [f64; NX],
    d: [f64; NU],
    u0: [f64; NU],
    y0: f64,
}

impl Columns {
    fn new(generator: &ResidualGenerator) -> Self {
        let (model, gain, point) = (generator.model(), generator.gain(), generator.point());
        let a = model.a() - gain * model.c();
        let b = model.b() - gain * model.d();
        Self {
            a: std::array::from_fn(|j| std::array::from_fn(|i| a[(i, j)])),
            b: std::array::from_fn(|j| std::array::from_fn(|i| b[(i, j)])),
            gain: std::array::from_fn(|i| gain[i]),
            c: std::array::from_fn(|i| model.c()[i]),
            d: std::array::from_fn(|i| model.d()[i]),
            u0: std::array::from_fn(|i| point.u[i]),
            y0: point.y[0],
        }
    }

    fn run(&mut self, data: &Dataset) -> Vec<f64> {
        let mut x = [0.0; NX];
        let samples = data.u().column_iter().zip(data.y().iter());
        samples
            .map(|(u, y)| {
                let du: [f64; NU] = std::array::from_fn(|j| u[j] - self.u0[j]);
                let dy = y - self.y0;
                let mut next: [f64; NX] = std::array::from_fn(|i| self.gain[i] * dy);
                let mut r = dy;
                for (j, du) in du.iter().enumerate() {
                    r -= self.d[j] * du;
                    for (next, b) in next.iter_mut().zip(&self.b[j]) {
                        *next += b * du;
                    }
                }
                for (j, x) in x.iter().enumerate() {
                    r -= self.c[j] * x;
                    for (next, a) in next.iter_mut().zip(&self.a[j]) {
                        *next += a * x;
                    }
                }
                x = next;
                r
            })
            .collect()
    }
}

/// The residuals of the first output, taken sample by sample.
fn online(detector: &mut Detector, data: &Dataset) -> Result<Vec<f64>, Box<dyn Error>> {
    detector.reset();
    let mut residuals = Vec::with_capacity(data.len());
    let samples = data.u().column_iter().zip(data.y().column_iter());
    for (k, (u, y)) in samples.enumerate() {
        let verdict = detector.step(data.time_s(k), u.as_slice(), y.as_slice())?;
        residuals.push(verdict.channels[0].residual);
    }
    Ok(residuals)
}

/// `count` multiply-adds on accumulators that do not wait for each other.
fn multiply_adds(count: usize) -> [f64; 16] {
    let mut sums = [1.0; 16];
    let factor = black_box(1.0 - 1e-9);
    for _ in 0..count / sums.len() {
        for sum in &mut sums {
            *sum = *sum * factor + 1e-9;
        }
    }
    sums
}

/// A pass over the data that computes next to nothing.
fn copy(data: &Dataset) -> Vec<f64> {
    let samples = data.u().as_slice().chunks_exact(NU).zip(data.y().iter());
    samples.map(|(u, y)| u[0] + u[1] + y).collect()
}

/// Median and 99.9 % quantile of the time of one step in nanoseconds.
fn latency(detector: &mut Detector, data: &Dataset) -> Result<[f64; 2], Box<dyn Error>> {
    let mut nanoseconds = Vec::new();
    for _ in 0..20 {
        detector.reset();
        for k in 0..data.len() {
            let (u, y) = (data.u().column(k), data.y().column(k));
            let start = Instant::now();
            black_box(detector.step(data.time_s(k), u.as_slice(), y.as_slice())?);
            nanoseconds.push(start.elapsed().as_secs_f64() * 1e9);
        }
    }
    nanoseconds.sort_by(f64::total_cmp);
    let count = nanoseconds.len();
    Ok([nanoseconds[count / 2], nanoseconds[count - count / 1000]])
}
