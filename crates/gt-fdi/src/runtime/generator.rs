//! One residual generator in flat arrays.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use super::blocks::{Blocks, SUMS};
use super::fingerprint::Fingerprint;
use super::kernel::{Kernel, LARGEST_CORRECTION, all_finite, dot, dot_in_order};
use super::lanes::LANES;
use super::last_row::LastRow;
use super::rows::Rows;
use super::wide::{FEW_LANES, Simd, Wide, Work};

/// Samples of one generator that are looked at together: a closer look at one is one at all of them.
const BLOCK: usize = 32;

/// The call with the numbers of inputs and outputs as constants where there are up to four of each,
/// or what `else` says; of a canonical form, with one output, where that stands before the numbers.
/// Each is a function by itself: the loops of all sizes in one leave the compiler too few registers for
/// any.
macro_rules! of_sizes {
    (canonical $sizes:expr, $generator:ident.$call:ident $arguments:tt, else $otherwise:expr) => {
        of_sizes!(@ $sizes, $generator $call $arguments $otherwise, true, (1 1)(2 1)(3 1)(4 1))
    };
    ($sizes:expr, $generator:ident.$call:ident $arguments:tt, else $otherwise:expr) => {
        of_sizes!(@ $sizes, $generator $call $arguments $otherwise, false, (1 1)(1 2)(1 3)(1 4)
            (2 1)(2 2)(2 3)(2 4)(3 1)(3 2)(3 3)(3 4)(4 1)(4 2)(4 3)(4 4))
    };
    (@ $sizes:expr, $generator:ident $call:ident $arguments:tt $otherwise:expr, $canonical:literal,
        $(($nu:literal $ny:literal))*) => {
        match $sizes {
            $(($nu, $ny) =>
                of_sizes!(@call $generator $call $nu $ny $canonical $arguments),)*
            _ => $otherwise,
        }
    };
    (@call $generator:ident $call:ident $nu:literal $ny:literal $canonical:literal
        ($($argument:expr),*)) => {
        $generator.$call::<$nu, $ny, $canonical>($($argument),*)
    };
}

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
    /// Whether `A` is fit for predicting over outputs that are missing.
    pub(crate) predicts: bool,
}

impl Matrices {
    /// The number of states.
    pub(super) fn nx(&self) -> usize {
        self.closed_a.len().isqrt()
    }

    /// Whether there is one output, which is the first state, and all rows of `A - K C` but the last
    /// are the first state's column and the next state.
    pub(super) fn are_canonical(&self) -> bool {
        let nx = self.nx();
        let rows = self.closed_a.chunks_exact(nx.max(1)).enumerate();
        let shifts = rows.take(nx.saturating_sub(1)).all(|(row, values)| {
            let mut others = values.iter().enumerate().skip(1);
            others.all(|(column, &value)| value - f64::from(column == row + 1) == 0.0)
        });
        let mut c = self.c.iter().enumerate();
        let first = c.all(|(column, &value)| value - f64::from(column == 0) == 0.0);
        shifts && first && self.y0.len() == 1
    }
}

/// What a generator made of a sample, from the best to the worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Update {
    /// All residuals are finite numbers.
    Residual,
    /// An output was missing: the state was predicted, the residuals of the other outputs are there
    /// and that of the missing one is NaN.
    NoOutput,
    /// An input was missing, or an output of a model that grows too fast to be predicted, or the
    /// arithmetic overflowed: the state is the initial one again, and all residuals are NaN.
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
    /// `[D, C]`.
    outputs: Blocks,
    /// `C`, a row an output in blocks of [`LANES`].
    c: Vec<[f64; LANES]>,
    /// `D`, row by row.
    d: Vec<f64>,
    u0: Box<[f64]>,
    y0: Box<[f64]>,
    /// Where each input stands among the inputs given to `step` and, after them, the outputs: what
    /// one generator explains, another may use.
    places: Vec<usize>,
    /// Where [`LastRow::of`] finds one.
    last: Option<Box<LastRow>>,
    /// The state in blocks of [`LANES`], the last one filled up with zeros.
    x: Vec<[f64; LANES]>,
    next: Vec<[f64; LANES]>,
    /// The deviations of the inputs and of the outputs (nu + ny).
    deviations: Vec<f64>,
    /// Whether the state is predicted where an output is missing.
    predicts: bool,
    wide: Wide,
}

impl Generator {
    /// A generator at rest at its operating point; `places` says where each of its inputs stands
    /// among the inputs and, after them, the outputs that [`Generator::step`] gets.
    pub(crate) fn new(matrices: Matrices, places: Vec<usize>) -> Self {
        let (nx, last) = (matrices.nx(), LastRow::of(&matrices));
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
            predicts,
        } = matrices;
        let (nu, ny) = (u0.len(), y0.len());
        let none = vec![0.0; nx * ny];
        let open = Blocks::new(&[(&b, nu), (&none, ny)], (&a, nx), nx);
        let closed = Blocks::new(&[(&closed_b, nu), (&gain, ny)], (&closed_a, nx), nx);
        let outputs = Blocks::new(&[(&d, nu)], (&c, nx), ny);
        let blocks = nx.div_ceil(LANES);
        let rows = (0..ny).flat_map(|output| {
            let row = &c[output * nx..(output + 1) * nx];
            row.chunks(LANES).map(|part| {
                core::array::from_fn(|lane| part.get(lane).copied().unwrap_or_default())
            })
        });
        Self {
            open,
            closed,
            outputs,
            c: rows.collect(),
            d,
            u0: origins(u0),
            y0: origins(y0),
            places,
            last: last.map(Box::new),
            x: vec![[0.0; LANES]; blocks],
            next: vec![[0.0; LANES]; blocks],
            deviations: vec![0.0; nu + ny],
            predicts,
            wide: if blocks == 1 {
                Wide::with_few_lanes()
            } else {
                Wide::new()
            },
        }
    }

    /// Number of outputs.
    pub(crate) fn ny(&self) -> usize {
        self.y0.len()
    }

    /// Numbers of inputs and outputs.
    fn sizes(&self) -> (usize, usize) {
        (self.u0.len(), self.y0.len())
    }

    /// Adds its numbers to a fingerprint.
    pub(crate) fn mark(&self, print: &mut Fingerprint) {
        let matrices = self.open.values().chain(self.closed.values());
        let outputs = self.c.as_flattened().iter().chain(&self.d);
        // An origin of 0 is kept as -0.
        for origin in self.u0.iter().chain(&self.y0) {
            print.add((origin + 0.0).to_bits());
        }
        for value in outputs.chain(matrices) {
            print.add(value.to_bits());
        }
    }

    /// The state (nx, filled up with zeros to whole blocks).
    pub(crate) fn state(&self) -> &[f64] {
        self.x.as_flattened()
    }

    /// The state, to be overwritten with finite numbers.
    pub(crate) fn state_mut(&mut self) -> &mut [f64] {
        self.x.as_flattened_mut()
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

    /// Takes the elements of a state (nx), finite numbers.
    pub(super) fn set_elements(&mut self, elements: impl Iterator<Item = f64>) {
        for (own, element) in self.x.as_flattened_mut().iter_mut().zip(elements) {
            *own = element;
        }
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
        let small = self.x.len() == 1;
        // Of a canonical form too: its last element would come from memory and go there.
        if small && of_sizes!(self.sizes(), self.step_small((u, y), first, residuals), else false) {
            return Update::Residual;
        }
        self.wide.run(General {
            generator: self,
            sample: (u, y),
            first,
            residuals,
        })
    }

    /// As [`Generator::step`] of so few inputs and outputs; `false`, and nothing taken, for a sample
    /// that needs a closer look.
    fn step_small<const NU: usize, const NY: usize, const CANONICAL: bool>(
        &mut self,
        sample: (&[f64], &[f64]),
        first: usize,
        residuals: &mut [f64],
    ) -> bool {
        self.wide.run(One::<NU, NY, CANONICAL> {
            generator: self,
            sample,
            first,
            residuals,
        })
    }

    /// Takes one sample after the other as [`Generator::step`] does, inputs `u` and outputs `y`, of
    /// which this generator's own come first; writes the `residuals` (samples x ny).
    pub(crate) fn run(&mut self, u: Rows<'_>, y: Rows<'_>, residuals: &mut [f64]) {
        let (nu, ny) = (self.u0.len(), self.y0.len());
        for (index, residuals) in residuals.chunks_mut(BLOCK * ny.max(1)).enumerate() {
            let (u, y) = (u.from(index * BLOCK), y.from(index * BLOCK));
            let small = self.x.len() == 1;
            let sizes = self.sizes();
            let done = match &self.last {
                _ if !small => false,
                Some(_) => {
                    of_sizes!(canonical sizes, self.run_small((u, y), residuals), else false)
                }
                None => of_sizes!(sizes, self.run_small((u, y), residuals), else false),
            };
            if !done {
                let own = residuals.chunks_exact_mut(ny.max(1)).enumerate();
                for (sample, residuals) in own {
                    self.step(u.at(sample, nu), y.at(sample, ny), 0, residuals);
                }
            }
        }
    }

    /// As [`Generator::run`] of so few inputs and outputs; `false`, and nothing taken, when a sample
    /// needs a closer look.
    fn run_small<const NU: usize, const NY: usize, const CANONICAL: bool>(
        &mut self,
        samples: (Rows<'_>, Rows<'_>),
        residuals: &mut [f64],
    ) -> bool {
        self.wide.run(Many::<NU, NY, CANONICAL> {
            generator: self,
            samples,
            residuals,
        })
    }

    /// The equations of a generator with up to [`LANES`] states and so many inputs and outputs.
    #[inline(always)]
    fn kernel<const NU: usize, const NY: usize, const CANONICAL: bool>(
        &self,
    ) -> Option<Kernel<'_, NU, NY, CANONICAL>> {
        if self.x.len() != 1 {
            return None;
        }
        let last = match &self.last {
            Some(last) if CANONICAL => last,
            None if CANONICAL => return None,
            _ => &LastRow::NONE,
        };
        let (b, gain, a) = self.closed.parts::<NU, NY>()?;
        let (d, _, c) = self.outputs.parts::<NU, 0>()?;
        let c_rows = self.c.first_chunk()?;
        Some(Kernel {
            b,
            gain,
            a,
            c,
            c_rows,
            d,
            u0: self.u0.first_chunk()?,
            y0: self.y0.first_chunk()?,
            last,
        })
    }

    /// As [`Generator::step`], for any number of states, inputs and outputs and for any sample.
    #[inline(always)]
    fn step_in<S: Simd>(
        &mut self,
        simd: S,
        (u, y): (&[f64], &[f64]),
        first: usize,
        residuals: &mut [f64],
    ) -> Update {
        let Some((du, dy)) = self.deviations.split_at_mut_checked(self.u0.len()) else {
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
        let Some(y) = y.get(first..first + dy.len()) else {
            return self.restarted(residuals);
        };
        let blocks = self.x.len();
        let expected = (0..dy.len()).map(|output| {
            let c = self.c.get(output * blocks..).unwrap_or(&[]);
            let d = self.d.get(output * du.len()..).unwrap_or(&[]);
            [
                dot(c.as_flattened(), self.x.as_flattened()),
                dot_in_order(d, du),
            ]
        });
        let outputs = y.iter().zip(&self.y0).zip(dy.iter_mut());
        let (mut missing, mut overflow, mut small) = (false, false, true);
        for (((y, y0), dy), ([of_state, of_inputs], residual)) in
            outputs.zip(expected.zip(residuals.iter_mut()))
        {
            *dy = y - y0;
            let there = y.is_finite();
            let value = *dy - of_state - of_inputs;
            *residual = if there { value } else { f64::NAN };
            missing |= !there;
            overflow |= there & !value.is_finite();
            small &= dy.abs() <= LARGEST_CORRECTION;
        }
        if overflow || (missing && !self.predicts) {
            return self.restarted(residuals);
        }
        if small && !missing {
            self.closed
                .times(simd, &self.deviations, &self.x, &mut self.next);
            if all_finite(self.next.as_flattened()) {
                core::mem::swap(&mut self.x, &mut self.next);
                return Update::Residual;
            }
        }
        if !self.predict(simd) {
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
    #[inline(always)]
    fn predict<S: Simd>(&mut self, simd: S) -> bool {
        if let Some(dy) = self.deviations.get_mut(self.u0.len()..) {
            dy.fill(0.0);
        }
        self.open
            .times(simd, &self.deviations, &self.x, &mut self.next);
        let finite = all_finite(self.next.as_flattened());
        if finite {
            core::mem::swap(&mut self.x, &mut self.next);
        }
        finite
    }
}

/// An operating point from which no deviation is -0: then a term that is 0 has no effect on any
/// residual, wherever it is added.
pub(super) fn origins(point: Vec<f64>) -> Box<[f64]> {
    let mut origins = point.into_boxed_slice();
    for origin in &mut origins {
        if *origin == 0.0 {
            *origin = -0.0;
        }
    }
    origins
}

/// One sample of any generator.
struct General<'a> {
    generator: &'a mut Generator,
    sample: (&'a [f64], &'a [f64]),
    first: usize,
    residuals: &'a mut [f64],
}

impl Work for General<'_> {
    type Output = Update;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Update {
        let generator = self.generator;
        generator.step_in(simd, self.sample, self.first, self.residuals)
    }
}

/// One sample of a small generator.
struct One<'a, const NU: usize, const NY: usize, const CANONICAL: bool> {
    generator: &'a mut Generator,
    sample: (&'a [f64], &'a [f64]),
    first: usize,
    residuals: &'a mut [f64],
}

impl<const NU: usize, const NY: usize, const CANONICAL: bool> Work for One<'_, NU, NY, CANONICAL> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        if const { !suits_small::<S>(CANONICAL) } {
            return false;
        }
        let generator = self.generator;
        let own = own_signals::<NU, NY>(&generator.places, self.sample, self.first);
        let (Some((u, y)), Some(residuals), Some(x), Some(kernel)) = (
            own,
            self.residuals.first_chunk_mut::<NY>(),
            generator.x.first(),
            generator.kernel::<NU, NY, CANONICAL>(),
        ) else {
            return false;
        };
        let Some((found, next)) = kernel.step(simd, (&u, &y), x) else {
            return false;
        };
        *residuals = found;
        generator.x[0] = next;
        true
    }
}

/// A generator's own inputs, which stand at `places` among the inputs and, after them, the outputs
/// of a sample, and its own outputs, which begin at `first`.
#[inline(always)]
fn own_signals<const NU: usize, const NY: usize>(
    places: &[usize],
    (u, y): (&[f64], &[f64]),
    first: usize,
) -> Option<([f64; NU], [f64; NY])> {
    let mut own = [0.0; NU];
    for (own, &place) in own.iter_mut().zip(places.first_chunk::<NU>()?) {
        *own = match place.checked_sub(u.len()) {
            None => *u.get(place)?,
            Some(output) => *y.get(output)?,
        };
    }
    Some((own, *y.get(first..)?.first_chunk::<NY>()?))
}

/// Samples of a small generator one after the other.
struct Many<'a, const NU: usize, const NY: usize, const CANONICAL: bool> {
    generator: &'a mut Generator,
    samples: (Rows<'a>, Rows<'a>),
    residuals: &'a mut [f64],
}

impl<const NU: usize, const NY: usize, const CANONICAL: bool> Work for Many<'_, NU, NY, CANONICAL> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        if const { !suits_small::<S>(CANONICAL) } {
            return false;
        }
        let generator = self.generator;
        let (Some(&(mut x)), Some(kernel)) =
            (generator.x.first(), generator.kernel::<NU, NY, CANONICAL>())
        else {
            return false;
        };
        let (residuals, _) = self.residuals.as_chunks_mut::<NY>();
        let done = kernel.run(simd, self.samples, &mut x, residuals);
        if done {
            generator.x[0] = x;
        }
        done
    }
}

/// Without registers there is nothing to win, and [`Wide::with_few_lanes`] has none that are wider;
/// those of a canonical form hold no more than the sums of its last row.
const fn suits_small<S: Simd>(canonical: bool) -> bool {
    S::F64_LANES > 1 && S::F64_LANES <= if canonical { SUMS } else { FEW_LANES }
}
