//! One residual generator in flat arrays.

use alloc::vec;
use alloc::vec::Vec;

/// An output further than this from its operating point, in any unit, is judged but kept out of
/// the state: half of the range of doubles, so that no product with a sane gain overflows.
const LARGEST_CORRECTION: f64 = 1e150;

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
    a: Vec<f64>,
    b: Vec<f64>,
    closed_a: Vec<f64>,
    closed_b: Vec<f64>,
    gain: Vec<f64>,
    c: Vec<f64>,
    d: Vec<f64>,
    u0: Vec<f64>,
    y0: f64,
    /// Where each input stands in the vector given to `step`.
    places: Vec<usize>,
    x: Vec<f64>,
    next: Vec<f64>,
    du: Vec<f64>,
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
        Self {
            a,
            b,
            closed_a,
            closed_b,
            gain,
            c,
            d,
            u0,
            y0,
            places,
            x: vec![0.0; nx],
            next: vec![0.0; nx],
            du: vec![0.0; nu],
        }
    }

    /// Back to rest at the operating point.
    pub(crate) fn reset(&mut self) {
        self.x.fill(0.0);
    }

    /// Takes one sample: all inputs `u`, of which this generator reads its own, and its output.
    pub(crate) fn step(&mut self, u: &[f64], y: f64) -> Update {
        for ((du, &place), u0) in self.du.iter_mut().zip(&self.places).zip(&self.u0) {
            // A place outside `u` cannot happen (the detector checks the size); NaN is the answer
            // that would be safe if it did.
            *du = u.get(place).copied().unwrap_or(f64::NAN) - u0;
        }
        if !all_finite(&self.du) {
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
        let dy = y - self.y0;
        let residual = dy - dot(&self.c, &self.x) - dot(&self.d, &self.du);
        if !residual.is_finite() {
            self.reset();
            return Update::Restarted;
        }
        if dy.abs() <= LARGEST_CORRECTION {
            let gains = self.gain.iter().map(|gain| gain * dy);
            advance(
                &self.closed_a,
                &self.x,
                &self.closed_b,
                &self.du,
                gains,
                &mut self.next,
            );
            if all_finite(&self.next) {
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
        let none = self.gain.iter().map(|_| 0.0);
        advance(&self.a, &self.x, &self.b, &self.du, none, &mut self.next);
        let finite = all_finite(&self.next);
        if finite {
            core::mem::swap(&mut self.x, &mut self.next);
        } else {
            self.reset();
        }
        finite
    }
}

/// `next = A x + B u + w`, in this order of additions.
fn advance(
    a: &[f64],
    x: &[f64],
    b: &[f64],
    u: &[f64],
    w: impl Iterator<Item = f64>,
    next: &mut [f64],
) {
    let (nx, nu) = (x.len(), u.len());
    for (row, (next, w)) in next.iter_mut().zip(w).enumerate() {
        let of_state = dot(&a[row * nx..(row + 1) * nx], x);
        let of_input = dot(&b[row * nu..(row + 1) * nu], u);
        *next = of_state + of_input + w;
    }
}

fn dot(left: &[f64], right: &[f64]) -> f64 {
    left.iter()
        .zip(right)
        .fold(0.0, |sum, (left, right)| sum + left * right)
}

fn all_finite(values: &[f64]) -> bool {
    values.iter().all(|value| value.is_finite())
}
