//! One residual generator in flat arrays.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use super::blocks::{Blocks, LANES};
use super::fingerprint::Fingerprint;
use super::kernel::{Kernel, LARGEST_CORRECTION, all_finite, dot, dot_in_order};
use super::wide::{Simd, Wide, Work};

/// Does `work` with the numbers of inputs and outputs as constants, `other` where there are more than
/// four.
macro_rules! of_sizes {
    ($sizes:expr, $nu:ident, $ny:ident, $work:expr, $other:expr) => {
        of_sizes!(@ $sizes, $nu, $ny, $work, $other, (1 1)(1 2)(1 3)(1 4)(2 1)(2 2)(2 3)(2 4)(3 1)(3 2)
            (3 3)(3 4)(4 1)(4 2)(4 3)(4 4))
    };
    (@ $sizes:expr, $nu:ident, $ny:ident, $work:expr, $other:expr, $(($inputs:literal $outputs:literal))*) => {
        match $sizes {
            $(($inputs, $outputs) => {
                const $nu: usize = $inputs;
                const $ny: usize = $outputs;
                $work
            })*
            _ => $other,
        }
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

/// Where samples come from.
pub(crate) trait Samples {
    /// Inputs and outputs of one sample.
    fn at(&mut self, sample: usize) -> (&[f64], &[f64]);
}

/// A residual generator with its state: `r = (y - y0) - C x - D (u - u0)`,
/// `x+ = (A - K C) x + (B - K D)(u - u0) + K (y - y0)`, which is the paper's eq. 22.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Generator {
    /// `[B, 0, A]`, without a correction.
    open: Blocks,
    /// `[B - K D, K, A - K C]`.
    closed: Blocks,
    /// `C`, a row an output in blocks of [`LANES`].
    c: Vec<[f64; LANES]>,
    /// `D`, row by row.
    d: Vec<f64>,
    u0: Box<[f64]>,
    y0: Box<[f64]>,
    /// Where each input stands among the inputs given to `step` and, after them, the outputs: what
    /// one generator explains, another may use.
    places: Vec<usize>,
    /// The state in blocks of [`LANES`], the last one filled up with zeros.
    x: Vec<[f64; LANES]>,
    next: Vec<[f64; LANES]>,
    /// The deviations of the inputs and of the outputs (nu + ny).
    deviations: Vec<f64>,
    wide: Wide,
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
        let none = vec![0.0; nx * ny];
        let open = Blocks::new(&[(&b, nu), (&none, ny)], (&a, nx), nx);
        let closed = Blocks::new(&[(&closed_b, nu), (&gain, ny)], (&closed_a, nx), nx);
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
            c: rows.collect(),
            d,
            u0: u0.into(),
            y0: y0.into(),
            places,
            x: vec![[0.0; LANES]; blocks],
            next: vec![[0.0; LANES]; blocks],
            deviations: vec![0.0; nu + ny],
            wide: Wide::new(),
        }
    }

    /// Number of outputs.
    pub(crate) fn ny(&self) -> usize {
        self.y0.len()
    }

    /// Adds its numbers to a fingerprint.
    pub(crate) fn mark(&self, print: &mut Fingerprint) {
        let matrices = self.open.values().chain(self.closed.values());
        let outputs = self.c.as_flattened().iter().chain(&self.d);
        for value in self
            .u0
            .iter()
            .chain(&self.y0)
            .chain(outputs)
            .chain(matrices)
        {
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
        self.wide.run(One {
            generator: self,
            sample: (u, y),
            first,
            residuals,
        })
    }

    /// Takes one sample after the other as [`Generator::step`] does: `samples` gives the inputs and
    /// the outputs (this generator's own first), and `residuals` (samples x ny) has a place for all.
    pub(crate) fn run(&mut self, samples: impl Samples, residuals: &mut [f64]) {
        self.wide.run(Many {
            generator: self,
            samples,
            residuals,
        });
    }

    /// The equations of a generator with up to [`LANES`] states and so many inputs and outputs.
    #[inline(always)]
    fn kernel<const NU: usize, const NY: usize>(&self) -> Option<Kernel<'_, NU, NY>> {
        if self.x.len() != 1 {
            return None;
        }
        let (b, gain, a) = self.closed.parts::<NU, NY>()?;
        Some(Kernel {
            b,
            gain,
            a,
            c: self.c.first_chunk()?,
            d: self.d.as_chunks().0.first_chunk()?,
            u0: self.u0.first_chunk()?,
            y0: self.y0.first_chunk()?,
            places: self.places.first_chunk()?,
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
            // Never -0: then a term that is 0 has no effect on any residual, wherever it is added.
            *dy = y - y0 + 0.0;
            let there = y.is_finite();
            let value = *dy - of_state - of_inputs;
            *residual = if there { value } else { f64::NAN };
            missing |= !there;
            overflow |= there & !value.is_finite();
            small &= dy.abs() <= LARGEST_CORRECTION;
        }
        if overflow {
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

/// One sample of a generator.
struct One<'a> {
    generator: &'a mut Generator,
    sample: (&'a [f64], &'a [f64]),
    first: usize,
    residuals: &'a mut [f64],
}

impl Work for One<'_> {
    type Output = Update;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Update {
        let (generator, sample, first) = (self.generator, self.sample, self.first);
        let sizes = (generator.u0.len(), generator.y0.len());
        // No closures, which may stay outside the function that may use the instruction set.
        let mut next = None;
        if let Some(x) = generator.x.first() {
            of_sizes!(
                sizes,
                NU,
                NY,
                if let Some(kernel) = generator.kernel::<NU, NY>() {
                    next = kernel.step(simd, sample, first, x, self.residuals);
                },
                {}
            );
        }
        match (next, generator.x.first_mut()) {
            (Some(next), Some(x)) => {
                *x = next;
                Update::Residual
            }
            _ => generator.step_in(simd, sample, first, self.residuals),
        }
    }
}

/// Samples of a generator one after the other.
struct Many<'a, T> {
    generator: &'a mut Generator,
    samples: T,
    residuals: &'a mut [f64],
}

impl<T: Samples> Work for Many<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let (generator, samples) = (self.generator, &mut self.samples);
        let sizes = (generator.u0.len(), generator.y0.len());
        let mut own = self.residuals.chunks_exact_mut(sizes.1.max(1)).enumerate();
        loop {
            // Until one needs a closer look, the kernel and the state stay at hand.
            let mut closer = None;
            if let Some(&(mut x)) = generator.x.first() {
                of_sizes!(
                    sizes,
                    NU,
                    NY,
                    if let Some(kernel) = generator.kernel::<NU, NY>() {
                        for (index, residuals) in own.by_ref() {
                            let next = kernel.step(simd, samples.at(index), 0, &x, residuals);
                            let Some(next) = next else {
                                closer = Some((index, residuals));
                                break;
                            };
                            x = next;
                        }
                    },
                    {}
                );
                generator.x[0] = x;
            }
            let Some((index, residuals)) = closer.or_else(|| own.next()) else {
                return;
            };
            generator.step_in(simd, samples.at(index), 0, residuals);
        }
    }
}
