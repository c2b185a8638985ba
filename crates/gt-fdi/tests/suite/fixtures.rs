//! Models, records and banks that several tests share.

use gt_core::{Dataset, OperatingPoint, Signal, StateSpace};
use gt_fdi::FdiError;
use gt_fdi::design::{
    Bank, ResidualGenerator, ResidualTest, StatisticKind, ThresholdRule, calibrate,
};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

pub const TS: f64 = 0.08;

pub fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// White noise of unit variance.
pub fn noise(seed: u64, len: usize) -> Vec<f64> {
    let mut rng = rng(seed);
    (0..len).map(|_| rng.sample(StandardNormal)).collect()
}

/// A matrix from its rows.
pub fn rows<const R: usize, const C: usize>(values: [[f64; C]; R]) -> DMatrix<f64> {
    DMatrix::from_fn(R, C, |row, column| values[row][column])
}

/// A model in observable canonical form: its poles, its Markov parameters `C A^k B` (nx x nu)
/// and its direct term (1 x nu).
pub fn canonical(poles: &[f64], markov: DMatrix<f64>, d: DMatrix<f64>, output: &str) -> StateSpace {
    let nx = poles.len();
    let p = monic(poles);
    let a = DMatrix::from_fn(nx, nx, |row, column| {
        if row + 1 == nx {
            -p[column]
        } else {
            f64::from(u8::from(column == row + 1))
        }
    });
    let c = DMatrix::from_fn(1, nx, |_, column| f64::from(u8::from(column == 0)));
    let names: Vec<String> = (0..d.ncols()).map(|j| format!("u{j}")).collect();
    let signals = [Signal::named(&names), Signal::named(&[output])];
    let [inputs, outputs] = signals;
    StateSpace::new([a, markov, c, d], TS, inputs, outputs).expect("a model")
}

/// Coefficients of `prod (z - root)`, that of `z^l` at index `l`, by convolution.
pub fn monic(roots: &[f64]) -> Vec<f64> {
    roots.iter().fold(vec![1.0], |p, root| {
        let mut product = vec![0.0; p.len() + 1];
        for (l, value) in p.iter().enumerate() {
            product[l + 1] += value;
            product[l] -= root * value;
        }
        product
    })
}

/// The model in the coordinates `T x`.
pub fn transformed(model: &StateSpace, t: &DMatrix<f64>) -> StateSpace {
    let inverse = t.clone().try_inverse().expect("an invertible T");
    let a = t * model.a() * &inverse;
    let (b, c) = (t * model.b(), model.c() * inverse);
    let (inputs, outputs) = (model.inputs().to_vec(), model.outputs().to_vec());
    StateSpace::new([a, b, c, model.d().clone()], TS, inputs, outputs).expect("a model")
}

/// A second-order model of output `output` with two inputs, one direct.
pub fn plain_model(output: &str) -> StateSpace {
    let markov = DMatrix::from_row_slice(2, 2, &[0.4, -0.2, 0.3, 0.1]);
    canonical(
        &[0.9, 0.6],
        markov,
        DMatrix::from_row_slice(1, 2, &[0.0, 0.5]),
        output,
    )
}

pub fn plain_generator(output: &str) -> ResidualGenerator {
    let point = OperatingPoint {
        u: DVector::from_vec(vec![10.0, -3.0]),
        y: DVector::from_vec(vec![100.0]),
    };
    ResidualGenerator::observer(plain_model(output), point, &[0.4, 0.4]).expect("an observer")
}

/// A bank of two generators that share `u0` and `u1`; limits half and twice the
/// largest of 1000 draws of noise.
pub fn bank() -> Bank {
    let calibrated = |output: &str, factor: f64| {
        let residual = noise(7, 1000);
        let rule = ThresholdRule::Margin {
            factor,
            consecutive: 2,
        };
        let calibration = calibrate(&[&residual], TS, rule).expect("a calibration");
        let generator = plain_generator(output);
        let test = ResidualTest::modulus(&generator, &calibration);
        (generator, test)
    };
    bank_of("test", vec![calibrated("p", 0.5), calibrated("q", 2.0)]).expect("a bank")
}

/// A bank of generators with their tests.
pub fn bank_of(
    name: &str,
    parts: Vec<(ResidualGenerator, ResidualTest)>,
) -> Result<Bank, FdiError> {
    let (generators, tests) = parts.into_iter().unzip();
    Bank::new(name, generators, tests)
}

/// The test of the modulus of one generator's residual.
pub fn limit_on(
    generator: &ResidualGenerator,
    healthy: &[Dataset],
    rule: ThresholdRule,
) -> Result<ResidualTest, FdiError> {
    let name = &generator.outputs()[0].name;
    ResidualTest::calibrate(name, &[generator], healthy, StatisticKind::Modulus, rule)
}

/// A record of the bank's channels and one that it does not know, inputs and outputs in an order
/// that is not the bank's: noise round the operating point, and a bias of 100 on `q` from sample
/// 300 to 399.
pub fn record(seed: u64) -> Dataset {
    const LEN: usize = 600;
    let draws: Vec<Vec<f64>> = (0..5).map(|channel| noise(seed + channel, LEN)).collect();
    let u = DMatrix::from_fn(2, LEN, |row, k| [-3.0, 10.0][row] + draws[row][k]);
    let y = DMatrix::from_fn(3, LEN, |row, k| {
        let bias = if row == 0 && (300..400).contains(&k) {
            30.0
        } else {
            0.0
        };
        100.0 + bias + draws[2 + row][k]
    });
    let (inputs, outputs) = (
        Signal::named(&["u1", "u0"]),
        Signal::named(&["q", "x", "p"]),
    );
    Dataset::new(inputs, outputs, u, y, TS).expect("a record")
}
