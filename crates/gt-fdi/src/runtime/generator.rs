//! One residual generator in flat arrays.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use super::fingerprint::Fingerprint;

/// An output further than this from its operating point, in any unit, is judged but kept out of
/// the state: half of the range of doubles, so that no product with a sane gain overflows.
const LARGEST_CORRECTION: f64 = 1e150;

/// Rows of a state equation that are summed side by side, so that no sum waits for another.
const LANES: usize = 8;

/// The numbers of a generator, matrices row by row; `nx` states, `nu` inputs, `ny` outputs.
pub(crate) struct Matrices {
    /// `A (nx x nx)` of the model.
    pub(crate) a: Vec<f64>,
    /// `B (nx x nu)` of the model.
    pub(crate) b: Vec<f64>,
    /// `A - K C (nx x nx)`.
    pub(crate) closed_a: Vec<f64>,
    /// `B - K D (nx x nu)`.
    pub(crate) closed_b: Vec<f64>,
    /// `K (nx x ny)`.
    pub(crate) gain: Vec<f64>,
    /// `C (ny x nx)`.
    pub(crate) c: Vec<f64>,
    /// `D (ny x nu)`.
    pub(crate) d: Vec<f64>,
    /// Operating point of the inputs (nu).
    pub(crate) u0: Vec<f64>,
    /// Operating point of the outputs (ny).
    pub(crate) y0: Vec<f64>,
}

/// What a generator made of a sample, from the best to the worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Update {
    /// All residuals are finite numbers.
    Residual,
    /// An output was missing: the state was predicted, the residuals of the other outputs are there
    /// and that of the missing one is NaN.
    NoOutput,
    /// An input was missing or the arithmetic overflowed: the state is the initial one again, and
    /// all residuals are NaN.
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
    /// One row an output.
    outputs: Box<[OutputRow]>,
    u0: Vec<f64>,
    /// Where each input stands among the inputs given to `step` and, after them, the outputs: what
    /// one generator explains, another may use.
    places: Vec<usize>,
    /// The state in blocks of [`LANES`], the last one filled up with zeros.
    x: Vec<[f64; LANES]>,
    next: Vec<[f64; LANES]>,
    /// The deviations of the inputs and of the outputs (nu + ny).
    deviations: Vec<f64>,
}

/// How an output follows from inputs and state.
#[derive(Debug, Clone, PartialEq)]
struct OutputRow {
    c: Vec<f64>,
    d: Vec<f64>,
    y0: f64,
}

impl Generator {
    /// A generator at rest at its operating point; `places` says where each of its inputs stands
    /// among the inputs and, after them, the outputs that [`Generator::step`] gets.
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
        let (nu, ny) = (u0.len(), y0.len());
        let nx = closed_a.len().isqrt();
        let open = Blocks::new([&b, &vec![0.0; nx * ny], &a], [nu, ny, nx], nx);
        let closed = Blocks::new([&closed_b, &gain, &closed_a], [nu, ny, nx], nx);
        let blocks = nx.div_ceil(LANES);
        let row = |(output, &y0): (usize, &f64)| OutputRow {
            c: c[output * nx..(output + 1) * nx].to_vec(),
            d: d[output * nu..(output + 1) * nu].to_vec(),
            y0,
        };
        let outputs = y0.iter().enumerate().map(row).collect();
        Self {
            open,
            closed,
            outputs,
            u0,
            places,
            x: vec![[0.0; LANES]; blocks],
            next: vec![[0.0; LANES]; blocks],
            deviations: vec![0.0; nu + ny],
        }
    }

    /// Number of outputs.
    pub(crate) fn ny(&self) -> usize {
        self.outputs.len()
    }

    /// Adds its numbers to a fingerprint.
    pub(crate) fn mark(&self, print: &mut Fingerprint) {
        let rows = self.outputs.iter();
        let rows = rows.flat_map(|row| row.c.iter().chain(&row.d).chain([&row.y0]));
        let matrices = [&self.open, &self.closed].into_iter();
        let matrices = matrices.flat_map(|blocks| blocks.values.as_flattened());
        for value in self.u0.iter().chain(rows).chain(matrices) {
            print.add(value.to_bits());
        }
    }

    /// The state (nx, filled up with zeros to whole blocks).
    pub(crate) fn state(&self) -> &[f64] {
        self.x.as_flattened()
    }

    /// Takes a state that [`Generator::state`] gave; `false`, and nothing taken, for one of another
    /// length or with a number that is not finite.
    pub(crate) fn set_state(&mut self, state: &[f64]) -> bool {
        let own = self.x.as_flattened_mut();
        let fits = own.len() == state.len() && all_finite(state);
        if fits {
            own.copy_from_slice(state);
        }
        fits
    }

    /// Back to rest at the operating point.
    pub(crate) fn reset(&mut self) {
        self.x.fill([0.0; LANES]);
    }

    /// Takes one sample: all inputs `u` and all outputs `y`, of which this generator's own begin at
    /// `first`; writes its residuals (ny).
    pub(crate) fn step(
        &mut self,
        u: &[f64],
        y: &[f64],
        first: usize,
        residuals: &mut [f64],
    ) -> Update {
        let nu = self.u0.len();
        let Some((du, dy)) = self.deviations.split_at_mut_checked(nu) else {
            return self.restarted(residuals);
        };
        for ((du, &place), u0) in du.iter_mut().zip(&self.places).zip(&self.u0) {
            // A place outside both cannot happen (the detector checks the sizes); NaN is the answer
            // that would be safe if it did.
            let value = match place.checked_sub(u.len()) {
                None => u.get(place),
                Some(output) => y.get(output),
            };
            *du = value.copied().unwrap_or(f64::NAN) - u0;
        }
        if !all_finite(du) {
            return self.restarted(residuals);
        }
        let Some(y) = y.get(first..first + self.outputs.len()) else {
            return self.restarted(residuals);
        };
        let (mut missing, mut small) = (false, true);
        let outputs = self.outputs.iter().zip(y).zip(dy.iter_mut());
        for (((row, &y), dy), residual) in outputs.zip(residuals.iter_mut()) {
            *dy = y - row.y0;
            *residual = *dy - dot(&row.c, self.x.as_flattened()) - dot(&row.d, du);
            if !y.is_finite() {
                *residual = f64::NAN;
                missing = true;
            } else if !residual.is_finite() {
                return self.restarted(residuals);
            }
            small &= dy.abs() <= LARGEST_CORRECTION;
        }
        if small && !missing {
            self.closed.times(&self.deviations, &self.x, &mut self.next);
            if all_finite(self.next.as_flattened()) {
                core::mem::swap(&mut self.x, &mut self.next);
                return Update::Residual;
            }
        }
        if !self.predict() {
            return self.restarted(residuals);
        }
        if missing {
            Update::NoOutput
        } else {
            Update::Residual
        }
    }

    fn restarted(&mut self, residuals: &mut [f64]) -> Update {
        self.reset();
        residuals.fill(f64::NAN);
        Update::Restarted
    }

    /// `x+ = A x + B (u - u0)`, without a correction; says `false` on overflow.
    fn predict(&mut self) -> bool {
        if let Some(dy) = self.deviations.get_mut(self.u0.len()..) {
            dy.fill(0.0);
        }
        self.open.times(&self.deviations, &self.x, &mut self.next);
        let finite = all_finite(self.next.as_flattened());
        if finite {
            core::mem::swap(&mut self.x, &mut self.next);
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
