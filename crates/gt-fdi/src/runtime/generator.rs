//! One residual generator in flat arrays.

use alloc::vec;
use alloc::vec::Vec;

/// An output further than this from its operating point, in any unit, is judged but kept out of
/// the state: half of the range of doubles, so that no product with a sane gain overflows.
const LARGEST_CORRECTION: f64 = 1e150;

/// Rows of a state equation that are summed side by side, so that no sum waits for another.
const LANES: usize = 8;

/// The numbers of a generator, matrices row by row; `nx` states, `nu` inputs, one output.
pub(crate) struct Matrices {
    /// `A (nx x nx)` of the model.
    pub(crate) a: Vec<f64>,
    /// `B (nx x nu)` of the model.
    pub(crate) b: Vec<f64>,
    /// `A - K C (nx x nx)`.
    pub(crate) closed_a: Vec<f64>,
    /// `B - K D (nx x nu)`.
    pub(crate) closed_b: Vec<f64>,
    /// `K (nx)`.
    pub(crate) gain: Vec<f64>,
    /// `C (1 x nx)`.
    pub(crate) c: Vec<f64>,
    /// `D (1 x nu)`.
    pub(crate) d: Vec<f64>,
    /// Operating point of the inputs (nu).
    pub(crate) u0: Vec<f64>,
    /// Operating point of the output.
    pub(crate) y0: f64,
}

/// What a generator made of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Update {
    /// The residual, a finite number.
    Residual(f64),
    /// There was no output to compare with: the state was predicted.
    NoOutput,
    /// An input was missing or the arithmetic overflowed: the state is the initial one again.
    Restarted,
}

/// A residual generator with its state: `r = (y - y0) - C x - D (u - u0)`,
/// `x+ = (A - K C) x + (B - K D)(u - u0) + K (y - y0)`, which is the paper's eq. 22.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Generator {
    /// `[B, 0, A]`, without a correction.
    open: Blocks,
    /// `[B - K D, K, A - K C]`.
    closed: Blocks,
    c: Vec<f64>,
    d: Vec<f64>,
    u0: Vec<f64>,
    y0: f64,
    /// Where each input stands in the vector given to `step`.
    places: Vec<usize>,
    /// The state in blocks of [`LANES`], the last one filled up with zeros.
    x: Vec<[f64; LANES]>,
    next: Vec<[f64; LANES]>,
    /// The deviations of the inputs and of the output (nu + 1).
    deviations: Vec<f64>,
}

impl Generator {
    /// A generator at rest at its operating point; `places` says where each of its inputs stands
    /// in the input vector that [`Generator::step`] gets.
    pub(crate) fn new(matrices: Matrices, places: Vec<usize>) -> Self {
        let Matrices {
            a,
            b,
            closed_a,
            closed_b,
            gain,
            c,
            d,
            u0,
            y0,
        } = matrices;
        let (nx, nu) = (gain.len(), u0.len());
        let open = Blocks::new([&b, &vec![0.0; nx], &a], [nu, 1, nx], nx);
        let closed = Blocks::new([&closed_b, &gain, &closed_a], [nu, 1, nx], nx);
        let blocks = nx.div_ceil(LANES);
        Self {
            open,
            closed,
            c,
            d,
            u0,
            y0,
            places,
            x: vec![[0.0; LANES]; blocks],
            next: vec![[0.0; LANES]; blocks],
            deviations: vec![0.0; nu + 1],
        }
    }

    /// Back to rest at the operating point.
    pub(crate) fn reset(&mut self) {
        self.x.fill([0.0; LANES]);
    }

    /// Takes one sample: all inputs `u`, of which this generator reads its own, and its output.
    pub(crate) fn step(&mut self, u: &[f64], y: f64) -> Update {
        // There is always a place for the output.
        let Some((dy, du)) = self.deviations.split_last_mut() else {
            return Update::Restarted;
        };
        for ((du, &place), u0) in du.iter_mut().zip(&self.places).zip(&self.u0) {
            // A place outside `u` cannot happen (the detector checks the size); NaN is the answer
            // that would be safe if it did.
            *du = u.get(place).copied().unwrap_or(f64::NAN) - u0;
        }
        if !all_finite(du) {
            self.reset();
            return Update::Restarted;
        }
        if !y.is_finite() {
            return if self.predict() {
                Update::NoOutput
            } else {
                Update::Restarted
            };
        }
        *dy = y - self.y0;
        let residual = *dy - dot(&self.c, self.x.as_flattened()) - dot(&self.d, du);
        if !residual.is_finite() {
            self.reset();
            return Update::Restarted;
        }
        if dy.abs() <= LARGEST_CORRECTION {
            self.closed.times(&self.deviations, &self.x, &mut self.next);
            if all_finite(self.next.as_flattened()) {
                core::mem::swap(&mut self.x, &mut self.next);
                return Update::Residual(residual);
            }
        }
        if self.predict() {
            Update::Residual(residual)
        } else {
            Update::Restarted
        }
    }

    /// `x+ = A x + B (u - u0)`, without a correction; resets and says `false` on overflow.
    fn predict(&mut self) -> bool {
        if let Some(dy) = self.deviations.last_mut() {
            *dy = 0.0;
        }
        self.open.times(&self.deviations, &self.x, &mut self.next);
        let finite = all_finite(self.next.as_flattened());
        if finite {
            core::mem::swap(&mut self.x, &mut self.next);
        } else {
            self.reset();
        }
        finite
    }
}

/// A matrix in blocks of [`LANES`] rows, each block column by column, zeros below the last row:
/// a product adds whole columns, and a row's terms in the order of the columns.
#[derive(Debug, Clone, PartialEq)]
struct Blocks {
    columns: usize,
    values: Vec<[f64; LANES]>,
}

impl Blocks {
    /// The matrix with `parts` side by side, each row by row and `widths` wide.
    fn new(parts: [&[f64]; 3], widths: [usize; 3], rows: usize) -> Self {
        let columns = widths.iter().sum();
        let mut values = Vec::with_capacity(rows.div_ceil(LANES) * columns);
        for first in (0..rows).step_by(LANES) {
            for (part, width) in parts.into_iter().zip(widths) {
                for column in 0..width {
                    values.push(core::array::from_fn(|lane| {
                        let row = first + lane;
                        if row < rows {
                            part[row * width + column]
                        } else {
                            0.0
                        }
                    }));
                }
            }
        }
        Self { columns, values }
    }

    /// `next = matrix [known; x]`; `known` comes first because the sums can begin with it while
    /// `x` is still being computed.
    fn times(&self, known: &[f64], x: &[[f64; LANES]], next: &mut [[f64; LANES]]) {
        let blocks = self.values.chunks_exact(self.columns);
        for (block, next) in blocks.zip(next) {
            let (of_known, of_state) = block.split_at(known.len());
            let mut sums = [0.0; LANES];
            add_columns(&mut sums, of_known, known);
            add_columns(&mut sums, of_state, x.as_flattened());
            *next = sums;
        }
    }
}

fn add_columns(sums: &mut [f64; LANES], columns: &[[f64; LANES]], factors: &[f64]) {
    for (column, factor) in columns.iter().zip(factors) {
        for (sum, value) in sums.iter_mut().zip(column) {
            *sum += value * factor;
        }
    }
}

fn dot(left: &[f64], right: &[f64]) -> f64 {
    left.iter()
        .zip(right)
        .fold(0.0, |sum, (left, right)| sum + left * right)
}

/// Looks at all values, which costs less than stopping early.
fn all_finite(values: &[f64]) -> bool {
    values
        .iter()
        .fold(true, |finite, value| finite & value.is_finite())
}
