//! ARX fits and an order search against a full QR factorisation of the same regressors in the same
//! process, with accuracy and peak memory beside the speed.
//!
//! `cargo bench -p gtfdi --bench arx`
//!
//! The record is that of two slow inputs (double poles at 0.99) into outputs with double poles at
//! 0.9 and less; with little noise neighbouring lags are nearly alike, which sets the condition.

#[allow(
    dead_code,
    unused_imports,
    reason = "the tests of the loops are in gt-ident"
)]
#[path = "../crates/gt-ident/src/kernel.rs"]
mod kernel;
mod timing;

use std::alloc::{GlobalAlloc, Layout, System};
use std::error::Error;
use std::hint::black_box;
use std::sync::atomic::{AtomicUsize, Ordering};

use gtfdi::core::{Dataset, Signal, la};
use gtfdi::ident::{Arx, ArxModel, ArxStructure, Channel, OrderKind, Solver, order_table};
use nalgebra::DMatrix;
use pulp::{Scalar, WithSimd};

/// Lags of every output and input.
const ORDER: usize = 8;
/// Orders of the search.
const ORDERS: usize = 12;
/// Double pole of the inputs.
const INPUT_POLE: f64 = 0.99;
/// Largest relative difference of coefficients from those of the full QR.
const AGREEMENT: f64 = 1e-9;

/// The system's allocator with the bytes in use and their peak.
struct Counting;

static IN_USE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

#[allow(
    unsafe_code,
    reason = "an allocator has no safe interface; it forwards every call"
)]
// SAFETY: every call goes to the system's allocator unchanged; only counters are kept beside it.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let now = IN_USE.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        PEAK.fetch_max(now, Ordering::Relaxed);
        // SAFETY: the caller's promises are those that the system asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the pointer came from `alloc` above, that is from the system.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Peak of the memory that `work` allocates, in MB.
fn peak_mb(work: impl FnOnce()) -> f64 {
    let before = IN_USE.load(Ordering::Relaxed);
    PEAK.store(before, Ordering::Relaxed);
    work();
    (PEAK.load(Ordering::Relaxed) - before) as f64 / 1e6
}

/// Rows and lags of a call of the inner loops: those of a block of a fit.
const KERNEL_ROWS: usize = 2048;
const KERNEL_CALLS: usize = 200;

/// The inner loops of a fit in registers against the same loops without any.
fn kernels() {
    let mut normal = Normal(7);
    let mut draw = |count: usize| -> Vec<f64> { (0..count).map(|_| normal.next()).collect() };
    let (samples, weights) = (draw(KERNEL_ROWS + ORDER - 1), draw(KERNEL_ROWS));
    let coefficients = draw(ORDER);
    let [mut wide, mut plain] = [(); 2].map(|()| vec![0.0; KERNEL_ROWS]);
    let [mut wide_sums, mut plain_sums] = [(); 2].map(|()| vec![0.0; ORDER]);
    let times = timing::race(vec![
        (
            "combine, no registers",
            Box::new(|| {
                for _ in 0..KERNEL_CALLS {
                    let operation = kernel::Combine {
                        coefficients: black_box(&coefficients),
                        samples: &samples,
                        out: &mut plain,
                    };
                    operation.with_simd(Scalar);
                }
            }),
        ),
        (
            "combine, as it is",
            Box::new(|| {
                for _ in 0..KERNEL_CALLS {
                    kernel::combine(black_box(&coefficients), &samples, &mut wide);
                }
            }),
        ),
        (
            "correlate, no registers",
            Box::new(|| {
                for _ in 0..KERNEL_CALLS {
                    let operation = kernel::Correlate {
                        q: black_box(&weights),
                        samples: &samples,
                        sums: &mut plain_sums,
                    };
                    operation.with_simd(Scalar);
                }
            }),
        ),
        (
            "correlate, as it is",
            Box::new(|| {
                for _ in 0..KERNEL_CALLS {
                    kernel::correlate(black_box(&weights), &samples, &mut wide_sums);
                }
            }),
        ),
    ]);
    println!("inner loops of a refinement: {KERNEL_ROWS} rows, {ORDER} lags");
    let products = (KERNEL_CALLS * KERNEL_ROWS * ORDER) as f64;
    let figure = |seconds: f64| products / seconds / 1e9;
    times.print("products/ns", figure, &[0, 2], ("", &[]));
    println!();
}

fn main() -> Result<(), Box<dyn Error>> {
    kernels();
    for (samples, rounds) in [(100_000, 9), (1_000_000, 3)] {
        for (outputs, deviation) in [(1, 1e-3), (1, 2e-7), (4, 1e-3)] {
            fits(&record(samples, outputs, deviation)?, rounds)?;
        }
    }
    search(&record(100_000, 1, 1e-3)?)?;
    search(&record(100_000, 4, 1e-3)?)?;
    println!(
        "/ [i]: speed over that of row i, median of rounds. All rows remove the means. Error: \
         |theta - theta[0]| / |theta[0]|, the worst output."
    );
    Ok(())
}

/// Standard normal numbers from a linear congruential generator (sums of twelve uniform ones).
struct Normal(u64);

impl Normal {
    fn next(&mut self) -> f64 {
        let mut uniform = || {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }
}

fn record(samples: usize, outputs: usize, deviation: f64) -> Result<Dataset, Box<dyn Error>> {
    let mut normal = Normal(1);
    let (mut u, mut y) = (DMatrix::zeros(2, samples), DMatrix::zeros(outputs, samples));
    for t in 2..samples {
        for i in 0..2 {
            u[(i, t)] = 2.0 * INPUT_POLE * u[(i, t - 1)] - INPUT_POLE * INPUT_POLE * u[(i, t - 2)]
                + (1.0 - INPUT_POLE).powi(2) * normal.next();
        }
        for j in 0..outputs {
            let pole = 0.9 - 0.02 * j as f64;
            y[(j, t)] = 2.0 * pole * y[(j, t - 1)] - pole * pole * y[(j, t - 2)]
                + 0.1 * (u[(0, t - 1)] + 0.5 * u[(1, t - 2)])
                + deviation * normal.next();
        }
    }
    let names = |prefix: &str, count: usize| -> Vec<Signal> {
        (1..=count)
            .map(|index| Signal::new(format!("{prefix}{index}"), ""))
            .collect()
    };
    Ok(Dataset::new(
        names("u", 2),
        names("y", outputs),
        u,
        y,
        0.08,
    )?)
}

/// The triangular factor of `[regressors | targets]`, formed whole and factorised by faer.
fn full_factor(data: &Dataset, order: usize, first: usize) -> DMatrix<f64> {
    let (nu, ny) = (data.nu(), data.ny());
    let (mean, p) = (data.mean(), order * (nu + ny));
    let mut stacked = DMatrix::zeros(data.len() - first, p + ny);
    for (index, mut column) in stacked.column_iter_mut().enumerate() {
        let (channel, lag) = if index < p {
            (index / order, index % order + 1)
        } else {
            (index - p, 0)
        };
        for (row, value) in column.iter_mut().enumerate() {
            let t = first + row - lag;
            *value = match channel.checked_sub(ny) {
                None => data.y()[(channel, t)] - mean.y[channel],
                Some(input) => data.u()[(input, t)] - mean.u[input],
            };
        }
    }
    la::to_nalgebra(la::as_faer(&stacked).qr().thin_R())
}

fn solve(factor: &DMatrix<f64>, outputs: usize) -> Option<DMatrix<f64>> {
    let p = factor.ncols() - outputs;
    let square = factor.view((0, 0), (p, p)).into_owned();
    square.solve_upper_triangular(&factor.view((0, p), (p, outputs)).into_owned())
}

/// The coefficients of a fitted model in the order of [`full_factor`].
fn by_channel(model: &ArxModel) -> DMatrix<f64> {
    let (nu, ny) = (model.inputs().len(), model.outputs().len());
    let mut theta = DMatrix::zeros(ORDER * (nu + ny), ny);
    for (output, row) in model.rows().iter().enumerate() {
        for term in &row.terms {
            let channel = match term.channel {
                Channel::Output(index) => index,
                Channel::Input(index) => ny + index,
            };
            theta[(channel * ORDER + term.lag - 1, output)] = term.coefficient;
        }
    }
    theta
}

fn fits(data: &Dataset, rounds: usize) -> Result<(), Box<dyn Error>> {
    let ny = data.ny();
    let structure = ArxStructure::Full {
        na: ORDER,
        nb: vec![ORDER],
        nk: vec![1],
    };
    let arx = Arx::new(structure).solver(Solver::Automatic);
    let blocked = arx.clone().solver(Solver::Qr);
    let reference = solve(&full_factor(data, ORDER, ORDER), ny).ok_or("full QR: singular")?;
    let (fit, qr) = (arx.fit_in_full(&[data])?, blocked.fit_in_full(&[data])?);
    println!(
        "ARX: N = {}, {ny} outputs, {} regressors, condition {:.1e}, solved by {:?}",
        data.len(),
        reference.nrows(),
        qr.model.condition()[0],
        fit.solved_by[0]
    );
    let error = |model: &ArxModel| {
        let theta = by_channel(model);
        let columns = theta.column_iter().zip(reference.column_iter());
        columns
            .map(|(found, expected)| (found - expected).norm() / expected.norm())
            .fold(0.0, f64::max)
    };
    let errors = [0.0, error(&qr.model), error(&fit.model)];
    if let Some(worst) = errors
        .iter()
        .find(|error| error.is_nan() || **error >= AGREEMENT)
    {
        return Err(format!("coefficients differ by {worst:e}, limit {AGREEMENT:e}").into());
    }
    let peaks = [
        peak_mb(|| drop(black_box(full_factor(data, ORDER, ORDER)))),
        peak_mb(|| drop(black_box(blocked.fit(data)))),
        peak_mb(|| drop(black_box(arx.fit(data)))),
    ];
    let times = timing::race_rounds(
        vec![
            (
                "full QR by faer",
                Box::new(|| {
                    black_box(solve(&full_factor(black_box(data), ORDER, ORDER), ny));
                }),
            ),
            (
                "gtfdi Arx::fit, QR in blocks",
                Box::new(|| {
                    let _ = black_box(blocked.fit(black_box(data)));
                }),
            ),
            (
                "gtfdi Arx::fit, automatic",
                Box::new(|| {
                    let _ = black_box(arx.fit(black_box(data)));
                }),
            ),
        ],
        rounds,
    );
    let notes: Vec<String> = errors
        .iter()
        .zip(peaks)
        .map(|(error, peak)| format!("{error:>8.1e} {peak:>8.1}"))
        .collect();
    let milliseconds = |seconds: f64| 1e3 * seconds;
    times.print("ms", milliseconds, &[0], ("   error  peak MB", &notes));
    println!();
    Ok(())
}

/// The residual variances of all orders on one window, each by a full QR.
fn repeated(data: &Dataset) -> Vec<f64> {
    let ny = data.ny();
    let rows = (data.len() - ORDERS) as f64;
    (1..=ORDERS)
        .map(|order| {
            let factor = full_factor(data, order, ORDERS);
            let p = factor.ncols() - ny;
            factor.view((p, p), (ny, 1)).norm_squared() / rows
        })
        .collect()
}

fn search(data: &Dataset) -> Result<(), Box<dyn Error>> {
    let kind = OrderKind::Full { nk: vec![1] };
    let table = order_table(data, 1..=ORDERS, &kind)?;
    let expected = repeated(data);
    let rows = table.rows.iter().zip(&expected);
    let worst = rows
        .map(|(row, expected)| (row.residual_variance[0] / expected - 1.0).abs())
        .fold(0.0, f64::max);
    println!(
        "orders 1..{ORDERS}: N = {}, {} outputs; residual variances differ by {worst:.1e}",
        data.len(),
        data.ny()
    );
    if worst.is_nan() || worst >= AGREEMENT {
        return Err(format!("residual variances differ by {worst:e}").into());
    }
    let times = timing::race(vec![
        (
            "a full QR by faer for each order",
            Box::new(|| {
                black_box(repeated(black_box(data)));
            }),
        ),
        (
            "gtfdi order_table",
            Box::new(|| {
                let _ = black_box(order_table(black_box(data), 1..=ORDERS, &kind));
            }),
        ),
    ]);
    times.print("ms", |seconds| 1e3 * seconds, &[0], ("", &[]));
    println!();
    Ok(())
}
