//! One generator on many streams at once.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

use thiserror::Error;

use super::columns::{Columns, MOST_SIGNALS, MOST_STATES};
use super::generator::origins;
use super::lanes::{LANES, Lanes};
use super::wide::{Simd, Wide, Work, lanes_of, registers, registers_mut};
use super::{Generator, Matrices};

/// The call with the number of states as a constant where there are up to [`MOST_STATES`], or what
/// `else` says. Each is a function by itself, as of one stream.
macro_rules! of_states {
    ($nx:expr, $samples:ident.$call:ident $arguments:tt, else $otherwise:expr) => {
        of_states!(@ $nx, $samples $call $arguments $otherwise, 1 2 3 4 5 6 7 8 9 10 11 12)
    };
    (@ $nx:expr, $samples:ident $call:ident $arguments:tt $otherwise:expr, $($count:literal)*) => {
        match $nx {
            $($count => $samples.$call::<$count> $arguments,)*
            _ => $otherwise,
        }
    };
}

/// Streams whose states lie together.
const TILE: usize = LANES;
/// Samples that the streams of a register take before those of the next: few enough that the caches
/// read ahead in all of them, enough that states are seldom loaded.
const BLOCK: usize = 2;
/// Deviations and states with squares up to this are computed many at once without looking at each
/// result.
const SAFE: f64 = 1e200;
/// How much larger than the root of [`SAFE`] everything may become meanwhile; far from the largest
/// double.
const HEADROOM: f64 = 1e190;

/// Samples of another size than the fleet's; nothing was taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("{what} of the fleet: expected {expected} numbers, found {found}")]
pub struct FleetError {
    /// Inputs, outputs, residuals or values.
    pub what: &'static str,
    /// The numbers that there should be.
    pub expected: usize,
    /// The numbers found.
    pub found: usize,
}

impl FleetError {
    pub(super) fn check(what: &'static str, expected: usize, found: usize) -> Result<(), Self> {
        if expected == found {
            return Ok(());
        }
        Err(Self {
            what,
            expected,
            found,
        })
    }
}

/// One residual generator on many streams, such as machines of one type; made by
/// `Fleet::new(&generator, streams)`.
///
/// The residuals are those of the generator on each stream by itself, bit for bit: missing outputs
/// are predicted over, missing inputs and overflow put a stream back to its initial state, and none
/// of it touches the others (see [`Detector`](super::Detector)). Nothing is allocated after
/// construction.
///
/// Streams lie side by side: of each sample, of each signal, the values of all streams.
#[derive(Debug, Clone)]
pub struct Fleet {
    streams: usize,
    /// For one stream that needs a look at every result.
    single: Generator,
    columns: Columns,
    u0: Box<[f64]>,
    y0: Box<[f64]>,
    /// Number of states.
    nx: usize,
    /// Samples in a row that cannot overflow from the root of [`SAFE`], up to [`BLOCK`].
    horizon: usize,
    /// The states of each tile of streams (tiles x nx).
    states: Vec<Lanes>,
    /// A sample of one stream: its inputs, outputs and residuals.
    sample: [Vec<f64>; 3],
    wide: Wide,
}

impl Fleet {
    /// All streams at rest at the operating point.
    pub(crate) fn from_matrices(matrices: Matrices, streams: usize) -> Self {
        let (nu, ny) = (matrices.u0.len(), matrices.y0.len());
        let nx = matrices.nx();
        let columns = Columns::new(&matrices);
        let (growth, of_residual) = columns.growth(nx);
        let mut horizon = 0;
        let mut reached = of_residual * growth;
        let small = nx <= MOST_STATES && nu + ny <= MOST_SIGNALS;
        while horizon < BLOCK && reached <= HEADROOM && small {
            horizon += 1;
            reached *= growth;
        }
        Self {
            streams,
            columns,
            u0: origins(matrices.u0.clone()),
            y0: origins(matrices.y0.clone()),
            single: Generator::new(matrices, (0..nu).collect()),
            nx,
            horizon,
            states: vec![Lanes::ZERO; streams.div_ceil(TILE) * nx],
            sample: [vec![0.0; nu], vec![0.0; ny], vec![0.0; ny]],
            wide: Wide::new(),
        }
    }

    /// Number of streams.
    pub fn streams(&self) -> usize {
        self.streams
    }

    /// All streams back to rest at the operating point.
    pub fn reset(&mut self) {
        self.states.fill(Lanes::ZERO);
    }

    /// Takes the next sample or samples of all streams: the inputs `u` (samples x nu x streams), the
    /// outputs `y` (samples x ny x streams), the streams of a signal side by side, in the units of
    /// the model, NaN where there is no valid sample. Writes the `residuals` (samples x ny x
    /// streams) in the outputs' units, NaN where there is none.
    ///
    /// Many samples at once are faster than one after the other, and the same.
    ///
    /// # Errors
    /// [`FleetError`] when the outputs are no whole number of samples, or inputs or residuals are
    /// not as many.
    pub fn step(&mut self, u: &[f64], y: &[f64], residuals: &mut [f64]) -> Result<(), FleetError> {
        let width = self.y0.len() * self.streams;
        let samples = y.len().checked_div(width).unwrap_or(0);
        FleetError::check("outputs", samples * width, y.len())?;
        FleetError::check("inputs", samples * self.u0.len() * self.streams, u.len())?;
        FleetError::check("residuals", y.len(), residuals.len())?;
        let (wide, nx) = (self.wide, self.nx);
        let mut samples = Samples {
            fleet: self,
            count: samples,
            u,
            y,
            residuals,
        };
        if samples.fleet.horizon == 0 {
            samples.take_one_by_one();
            return Ok(());
        }
        of_states!(nx, samples.take_in(wide), else samples.take_one_by_one());
        Ok(())
    }
}

/// The next samples of all streams.
struct Samples<'a> {
    fleet: &'a mut Fleet,
    count: usize,
    u: &'a [f64],
    y: &'a [f64],
    residuals: &'a mut [f64],
}

impl Samples<'_> {
    /// Takes all samples of a generator with so many states in the widest registers.
    fn take_in<const NX: usize>(self, wide: Wide) {
        match (self.fleet.columns.canonical(), self.fleet.u0.len()) {
            (true, 1) => wide.run(Canonical::<NX, 1>(self)),
            (true, 2) => wide.run(Canonical::<NX, 2>(self)),
            (true, 3) => wide.run(Canonical::<NX, 3>(self)),
            _ => wide.run(General::<NX>(self)),
        }
    }
}

/// Samples of a generator in canonical form with so many states and inputs.
struct Canonical<'a, const NX: usize, const NU: usize>(Samples<'a>);

impl<const NX: usize, const NU: usize> Work for Canonical<'_, NX, NU> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        if const { S::F64_LANES == 1 } {
            // Without wide registers there is nothing to win.
            self.0.take_one_by_one();
        } else {
            self.0.take_canonical::<S, NX, NU>(simd);
        }
    }
}

/// Samples of any generator with so many states.
struct General<'a, const NX: usize>(Samples<'a>);

impl<const NX: usize> Work for General<'_, NX> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        if const { S::F64_LANES == 1 } {
            self.0.take_one_by_one();
        } else {
            self.0.take(simd, Samples::block::<S, NX>);
        }
    }
}

impl Samples<'_> {
    /// Every stream by itself.
    #[inline(never)]
    fn take_one_by_one(&mut self) {
        for stream in 0..self.fleet.streams {
            self.take_one(0..self.count, stream);
        }
    }

    /// Takes samples of one stream with a look at every result.
    #[inline(never)]
    fn take_one(&mut self, samples: Range<usize>, stream: usize) {
        let fleet = &mut *self.fleet;
        let first = stream / TILE * fleet.nx;
        let states = &mut fleet.states[first..first + fleet.nx];
        let single = &mut fleet.single;
        single.set_elements(states.iter().map(|x| x.0[stream % TILE]));
        let [u, y, residuals] = &mut fleet.sample;
        for sample in samples {
            let of = |all: &[f64], own: &mut [f64]| {
                let begin = sample * own.len() * fleet.streams + stream;
                let all = all.iter().skip(begin).step_by(fleet.streams);
                for (own, value) in own.iter_mut().zip(all) {
                    *own = *value;
                }
            };
            of(self.u, u);
            of(self.y, y);
            single.step(u, y, 0, residuals);
            let begin = sample * residuals.len() * fleet.streams + stream;
            let places = self.residuals.iter_mut().skip(begin);
            for (place, residual) in places.step_by(fleet.streams).zip(residuals.iter()) {
                *place = *residual;
            }
        }
        for (x, value) in states.iter_mut().zip(single.state()) {
            x.0[stream % TILE] = *value;
        }
    }

    /// Takes all samples by `block`, which takes those of the streams of one register.
    #[inline(always)]
    fn take<S: Simd>(&mut self, simd: S, block: impl Fn(&mut Self, S, &Range<usize>, usize)) {
        let streams = self.fleet.streams;
        let whole = streams - streams % S::F64_LANES;
        for begin in (0..self.count).step_by(self.fleet.horizon) {
            let samples = begin..self.count.min(begin + self.fleet.horizon);
            for first in (0..whole).step_by(S::F64_LANES) {
                block(self, simd, &samples, first);
            }
            for stream in whole..streams {
                self.take_one(samples.clone(), stream);
            }
        }
    }

    /// Takes a block of samples of the streams of one register.
    #[inline(always)]
    fn block<S: Simd, const NX: usize>(&mut self, simd: S, block: &Range<usize>, first: usize) {
        let fleet = &mut *self.fleet;
        let (columns, streams) = (&fleet.columns, fleet.streams);
        let (nu, ny) = (fleet.u0.len(), fleet.y0.len());
        let register = first % TILE / S::F64_LANES;
        let tile = first / TILE * NX;
        let mut x = [simd.splat_f64s(0.0); NX];
        // A sum of squares is safe when all are, and NaN or infinite when one is.
        let mut sizes = simd.splat_f64s(0.0);
        for (x, lanes) in x.iter_mut().zip(&fleet.states[tile..tile + NX]) {
            *x = registers::<S>(&lanes.0)[register];
            sizes = simd.mul_add_f64s(*x, *x, sizes);
        }
        let mut known = [simd.splat_f64s(0.0); MOST_SIGNALS];
        let known = &mut known[..nu + ny];
        let (mut of_u, mut of_y) = (
            block.start * nu * streams + first,
            block.start * ny * streams + first,
        );
        for _ in block.clone() {
            let (du, dy) = known.split_at_mut(nu);
            for (value, u0) in du.iter_mut().zip(&fleet.u0) {
                *value = deviation(simd, &self.u[of_u..of_u + S::F64_LANES], *u0);
                sizes = simd.mul_add_f64s(*value, *value, sizes);
                of_u += streams;
            }
            for (output, (value, y0)) in dy.iter_mut().zip(&fleet.y0).enumerate() {
                let own = of_y..of_y + S::F64_LANES;
                *value = deviation(simd, &self.y[own.clone()], *y0);
                sizes = simd.mul_add_f64s(*value, *value, sizes);
                let [of_state, of_inputs] = columns.expected::<S, NX>(simd, output, du, &x);
                let residual = simd.sub_f64s(simd.sub_f64s(*value, of_state), of_inputs);
                registers_mut::<S>(&mut self.residuals[own])[0] = residual;
                of_y += streams;
            }
            x = columns.next::<S, NX>(simd, known, &x);
        }
        let Some(states) = fleet.states[tile..].first_chunk_mut::<NX>() else {
            return;
        };
        if !keep(simd, states, register, x, sizes) {
            self.take_unsafe(block, first, lanes_of::<S>(&[sizes]));
        }
    }

    /// As [`Samples::take`] by [`Samples::block`], of a generator in canonical form.
    #[inline(always)]
    fn take_canonical<S: Simd, const NX: usize, const NU: usize>(&mut self, simd: S) {
        let streams = self.fleet.streams;
        let whole = streams - streams % S::F64_LANES;
        for begin in (0..self.count).step_by(self.fleet.horizon) {
            let samples = begin..self.count.min(begin + self.fleet.horizon);
            let mut first = 0;
            loop {
                const { assert!(BLOCK == 2, "a block is one sample or all") };
                let found = if samples.len() == BLOCK {
                    self.canonical_block::<S, NX, NU, BLOCK>(simd, begin, first..whole)
                } else {
                    self.canonical_block::<S, NX, NU, 1>(simd, begin, first..whole)
                };
                let Some((register, sizes)) = found else {
                    break;
                };
                self.take_unsafe(&samples, register, lanes_of::<S>(&[sizes]));
                first = register + S::F64_LANES;
            }
            for stream in whole..streams {
                self.take_one(samples.clone(), stream);
            }
        }
    }

    /// Takes a block of samples of `streams`, whole registers of them, until some are not safe: of
    /// those the first stream and the sizes.
    ///
    /// The numbers of samples, states and inputs are constants because what waits for memory here
    /// waits the shorter the fewer instructions lie between two samples.
    #[inline(always)]
    fn canonical_block<S: Simd, const NX: usize, const NU: usize, const COUNT: usize>(
        &mut self,
        simd: S,
        begin: usize,
        own: Range<usize>,
    ) -> Option<(usize, S::f64s)> {
        let fleet = &mut *self.fleet;
        let streams = fleet.streams;
        let form = fleet.columns.canonical_form::<NX, NU>()?;
        let u0 = fleet.u0.first_chunk::<NU>()?.map(|u0| simd.splat_f64s(u0));
        let y0 = simd.splat_f64s(*fleet.y0.first()?);
        let (states, _) = fleet.states.as_chunks_mut::<NX>();
        let u = self.u.get(begin * NU * streams..)?;
        let y = self.y.get(begin * streams..)?;
        let residuals = self.residuals.get_mut(begin * streams..)?;
        for first in own.step_by(S::F64_LANES) {
            let states = states.get_mut(first / TILE)?;
            let register = first % TILE / S::F64_LANES;
            let mut x = [simd.splat_f64s(0.0); NX];
            let mut sizes = simd.splat_f64s(0.0);
            for (x, lanes) in x.iter_mut().zip(&*states) {
                *x = registers::<S>(&lanes.0)[register];
                sizes = simd.mul_add_f64s(*x, *x, sizes);
            }
            let (mut of_u, mut of_y) = (first, first);
            for _ in 0..COUNT {
                let mut du = u0;
                for du in &mut du {
                    let own = registers::<S>(u.get(of_u..of_u + S::F64_LANES)?)[0];
                    *du = simd.sub_f64s(own, *du);
                    sizes = simd.mul_add_f64s(*du, *du, sizes);
                    of_u += streams;
                }
                let own = registers::<S>(y.get(of_y..of_y + S::F64_LANES)?)[0];
                let dy = simd.sub_f64s(own, y0);
                sizes = simd.mul_add_f64s(dy, dy, sizes);
                let (residual, next) = form.step(simd, &du, dy, &x);
                registers_mut::<S>(residuals.get_mut(of_y..of_y + S::F64_LANES)?)[0] = residual;
                of_y += streams;
                x = next;
            }
            if !keep(simd, states, register, x, sizes) {
                return Some((first, sizes));
            }
        }
        None
    }

    /// Takes a block of samples again, of those streams from `first` on whose `sizes` are not safe.
    #[cold]
    #[inline(never)]
    fn take_unsafe(&mut self, block: &Range<usize>, first: usize, sizes: &[f64]) {
        for (lane, size) in sizes.iter().enumerate() {
            if size.is_nan() || *size >= SAFE {
                self.take_one(block.clone(), first + lane);
            }
        }
    }
}

/// Keeps the next states `x` of the streams of one register where their `sizes` are safe; whether
/// all are.
#[inline(always)]
fn keep<S: Simd, const NX: usize>(
    simd: S,
    states: &mut [Lanes; NX],
    register: usize,
    x: [S::f64s; NX],
    sizes: S::f64s,
) -> bool {
    let all = simd.reduce_sum_f64s(sizes) <= SAFE;
    let safe = simd.less_than_f64s(sizes, simd.splat_f64s(SAFE));
    // Without an address of `x`, which would keep it in memory all along.
    for (lanes, x) in states.iter_mut().zip(x) {
        let own = &mut registers_mut::<S>(&mut lanes.0)[register];
        *own = if all {
            x
        } else {
            simd.select_f64s(safe, x, *own)
        };
    }
    all
}

/// `values - origin`.
#[inline(always)]
fn deviation<S: Simd>(simd: S, values: &[f64], origin: f64) -> S::f64s {
    simd.sub_f64s(registers::<S>(values)[0], simd.splat_f64s(origin))
}
