//! The cumulative sum on many streams at once.

use alloc::vec;
use alloc::vec::Vec;

use super::super::fleet::FleetError;
use super::super::wide::{Simd, Wide, Work, registers, registers_mut};
use super::{Cusum, LARGEST_SAMPLE, Sides, Statistic};

/// Streams whose sums lie together: the lanes of the widest register.
const TILE: usize = 8;
/// Samples that the streams of a register take before those of the next.
const BLOCK: usize = 16;

/// One [`Cusum`] on many streams; its values are those of the `Cusum` on each by itself. Onsets and
/// sizes are not kept.
///
/// Streams lie side by side, as the residuals of a [`Fleet`](crate::runtime::Fleet) of one output.
#[derive(Debug, Clone, PartialEq)]
pub struct CusumFleet {
    allowance: f64,
    threshold: f64,
    sides: Sides,
    streams: usize,
    /// Sums of what rises and of what falls (tiles x 2).
    sums: Vec<[[f64; TILE]; 2]>,
    wide: Wide,
}

impl CusumFleet {
    /// As many sums at zero as `streams`, with the options of `cusum`.
    pub fn new(cusum: &Cusum, streams: usize) -> Self {
        Self {
            allowance: cusum.allowance(),
            threshold: cusum.threshold(),
            sides: cusum.sides(),
            streams,
            sums: vec![[[0.0; TILE]; 2]; streams.div_ceil(TILE)],
            wide: Wide::new(),
        }
    }

    /// Number of streams.
    pub fn streams(&self) -> usize {
        self.streams
    }

    /// The value above which an alarm is up.
    pub fn threshold(&self) -> f64 {
        self.threshold
    }

    /// All sums back to zero.
    pub fn reset(&mut self) {
        self.sums.fill([[0.0; TILE]; 2]);
    }

    /// Takes the next residual or residuals of all streams (samples x streams, in standard
    /// deviations) and writes the values after each (samples x streams). A residual that is NaN or
    /// infinite leaves the value of the sample before. Nothing is allocated.
    ///
    /// # Errors
    /// [`FleetError`] when the residuals are no whole number of samples, or the values not as many.
    pub fn step(&mut self, residuals: &[f64], values: &mut [f64]) -> Result<(), FleetError> {
        let samples = residuals.len().checked_div(self.streams).unwrap_or(0);
        FleetError::check("residuals", samples * self.streams, residuals.len())?;
        FleetError::check("values", residuals.len(), values.len())?;
        self.wide.run(Samples {
            fleet: self,
            residuals,
            values,
        });
        Ok(())
    }
}

/// The next residuals of all streams.
struct Samples<'a> {
    fleet: &'a mut CusumFleet,
    residuals: &'a [f64],
    values: &'a mut [f64],
}

impl Work for Samples<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            fleet,
            residuals,
            values,
        } = self;
        let streams = fleet.streams;
        let sides = [fleet.sides != Sides::Lower, fleet.sides != Sides::Upper];
        let options = (fleet.allowance, sides);
        let width = BLOCK * streams.max(1);
        for (residuals, values) in residuals.chunks(width).zip(values.chunks_mut(width)) {
            for first in (0..streams).step_by(S::F64_LANES) {
                let own = first..streams.min(first + S::F64_LANES);
                let Some(tile) = fleet.sums.get_mut(first / TILE) else {
                    return;
                };
                let register = first % TILE / S::F64_LANES;
                // By themselves, so that they stay in registers.
                let mut upper = registers::<S>(&tile[0])[register];
                let mut lower = registers::<S>(&tile[1])[register];
                let samples = residuals.chunks_exact(streams);
                for (r, value) in samples.zip(values.chunks_exact_mut(streams)) {
                    let (r, value) = (&r[own.clone()], &mut value[own.clone()]);
                    if r.len() == S::F64_LANES {
                        let r = registers::<S>(r)[0];
                        (upper, lower) = add(simd, r, options, (upper, lower));
                        registers_mut::<S>(value)[0] = simd.max_f64s(upper, lower);
                    } else {
                        // The last streams, filled up with missing ones.
                        let (mut all, mut found) = ([f64::NAN; TILE], [0.0; TILE]);
                        all[..r.len()].copy_from_slice(r);
                        let r = registers::<S>(&all)[0];
                        (upper, lower) = add(simd, r, options, (upper, lower));
                        registers_mut::<S>(&mut found)[0] = simd.max_f64s(upper, lower);
                        value.copy_from_slice(&found[..value.len()]);
                    }
                }
                registers_mut::<S>(&mut tile[0])[register] = upper;
                registers_mut::<S>(&mut tile[1])[register] = lower;
            }
        }
    }
}

/// The sums with the residuals of some streams; `options` are the allowance and which sides count.
#[inline(always)]
fn add<S: Simd>(
    simd: S,
    r: S::f64s,
    (allowance, [rises, falls]): (f64, [bool; 2]),
    (mut upper, mut lower): (S::f64s, S::f64s),
) -> (S::f64s, S::f64s) {
    let allowance = simd.splat_f64s(allowance);
    let largest = simd.splat_f64s(LARGEST_SAMPLE);
    let there = simd.less_than_f64s(simd.abs_f64s(r), simd.splat_f64s(f64::INFINITY));
    let r = simd.min_f64s(simd.max_f64s(r, simd.neg_f64s(largest)), largest);
    if rises {
        upper = sum(simd, upper, simd.sub_f64s(r, allowance), there);
    }
    if falls {
        let excess = simd.sub_f64s(simd.neg_f64s(r), allowance);
        lower = sum(simd, lower, excess, there);
    }
    (upper, lower)
}

/// A sum with what exceeds, where a residual is there.
#[inline(always)]
fn sum<S: Simd>(simd: S, sum: S::f64s, excess: S::f64s, there: S::m64s) -> S::f64s {
    let [zero, most] = [0.0, f64::MAX].map(|value| simd.splat_f64s(value));
    let added = simd.min_f64s(simd.add_f64s(sum, excess), most);
    simd.select_f64s(there, simd.max_f64s(added, zero), sum)
}
