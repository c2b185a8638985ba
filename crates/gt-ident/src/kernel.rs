//! Products of lagged channels with vectors: the two inner loops of every pass over a record.
//!
//! They are written once over pulp's registers and run on the widest that the machine has; without
//! any they are plain loops. The results differ from machine to machine by rounding.
//! `cargo bench -p gtfdi --bench arx` compares both ways and says what a fit gains.

use pulp::{Arch, Simd, WithSimd, bytemuck};

/// Registers in a tile of [`combine`]: their sums run side by side.
const TILE: usize = 8;
/// Registers of one dot product.
const CHAINS: usize = 2;

/// `out[t] += sum over l of coefficients[l] * samples[last - l + t]`, so that `coefficients[0]`
/// meets the smallest lag. `samples` holds `out.len() + coefficients.len() - 1` numbers.
pub(crate) fn combine(coefficients: &[f64], samples: &[f64], out: &mut [f64]) {
    Arch::new().dispatch(Combine {
        coefficients,
        samples,
        out,
    });
}

/// `sums[l] += sum over t of q[t] * samples[last - l + t]`, the transpose of [`combine`].
pub(crate) fn correlate(q: &[f64], samples: &[f64], sums: &mut [f64]) {
    Arch::new().dispatch(Correlate { q, samples, sums });
}

/// The operation of [`combine`].
pub(crate) struct Combine<'a> {
    pub coefficients: &'a [f64],
    pub samples: &'a [f64],
    pub out: &'a mut [f64],
}

impl WithSimd for Combine<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            coefficients,
            samples,
            out,
        } = self;
        let last = coefficients.len().saturating_sub(1);
        let width = TILE * S::F64_LANES;
        let whole = out.len() - out.len() % width;
        for (start, tile) in (0..whole).step_by(width).zip(out.chunks_exact_mut(width)) {
            let tile: &mut [S::f64s] = bytemuck::cast_slice_mut(tile);
            let mut sums = [simd.splat_f64s(0.0); TILE];
            sums.copy_from_slice(tile);
            for (lag, &coefficient) in coefficients.iter().enumerate() {
                let factor = simd.splat_f64s(coefficient);
                let from = last - lag + start;
                let lagged: &[S::f64s] = bytemuck::cast_slice(&samples[from..from + width]);
                for (sum, &value) in sums.iter_mut().zip(lagged) {
                    *sum = simd.mul_add_e_f64s(factor, value, *sum);
                }
            }
            tile.copy_from_slice(&sums);
        }
        for (t, value) in out.iter_mut().enumerate().skip(whole) {
            for (lag, &coefficient) in coefficients.iter().enumerate() {
                *value += coefficient * samples[last - lag + t];
            }
        }
    }
}

/// The operation of [`correlate`].
pub(crate) struct Correlate<'a> {
    pub q: &'a [f64],
    pub samples: &'a [f64],
    pub sums: &'a mut [f64],
}

impl WithSimd for Correlate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { q, samples, sums } = self;
        let mut done = 0;
        while done < sums.len() {
            let left = sums.len() - done;
            let take = group(left);
            let from = &samples[left - take..];
            let part = &mut sums[done..done + take];
            match take {
                1 => dots::<S, 1>(simd, q, from, part),
                2 => dots::<S, 2>(simd, q, from, part),
                3 => dots::<S, 3>(simd, q, from, part),
                4 => dots::<S, 4>(simd, q, from, part),
                5 => dots::<S, 5>(simd, q, from, part),
                _ => dots::<S, 6>(simd, q, from, part),
            }
            done += take;
        }
    }
}

/// How many of `left` lags make the next group: four to six keep their sums in sixteen registers,
/// one alone would wait for its own last addition.
fn group(left: usize) -> usize {
    match left {
        0..=6 => left,
        7 | 8 => 4,
        9 | 10 => 5,
        _ => 6,
    }
}

/// `COUNT` dot products of `q` with `samples` shifted by one from each to the next.
#[inline(always)]
fn dots<S: Simd, const COUNT: usize>(simd: S, q: &[f64], samples: &[f64], sums: &mut [f64]) {
    let mut lanes = [[simd.splat_f64s(0.0); CHAINS]; COUNT];
    let width = CHAINS * S::F64_LANES;
    let whole = q.len() - q.len() % width;
    for start in (0..whole).step_by(width) {
        let factors: &[S::f64s] = bytemuck::cast_slice(&q[start..start + width]);
        let window = &samples[start..start + width + COUNT - 1];
        for (lag, lanes) in lanes.iter_mut().enumerate() {
            let from = COUNT - 1 - lag;
            let lagged: &[S::f64s] = bytemuck::cast_slice(&window[from..from + width]);
            for (sum, (&factor, &value)) in lanes.iter_mut().zip(factors.iter().zip(lagged)) {
                *sum = simd.mul_add_e_f64s(factor, value, *sum);
            }
        }
    }
    for (lag, (sum, [first, second])) in sums.iter_mut().zip(lanes).enumerate() {
        let mut total = simd.reduce_sum_f64s(simd.add_f64s(first, second));
        for t in whole..q.len() {
            total += q[t] * samples[COUNT - 1 - lag + t];
        }
        *sum += total;
    }
}

#[cfg(test)]
mod tests {
    use pulp::Scalar;

    use super::{Combine, Correlate, WithSimd, combine, correlate};

    /// Numbers of magnitude below 1 without a pattern that the kernels could hide behind.
    fn numbers(count: usize, seed: u64) -> Vec<f64> {
        let mut state = seed;
        let draw = |_| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        (0..count).map(draw).collect()
    }

    #[test]
    fn both_instruction_sets_give_the_definition() {
        for rows in [0, 1, 7, 8, 63, 64, 65, 200] {
            for lags in 1..30 {
                let samples = numbers(rows + lags - 1, 3 + rows as u64);
                let (x, q) = (numbers(lags, 5), numbers(rows, 7));
                let at = |lag: usize, t: usize| samples[lags - 1 - lag + t];
                // At most 230 products of numbers below 1/2: their rounding stays below 1e-13.
                let close = |found: f64, expected: f64| (found - expected).abs() < 1e-13;
                let (mut wide, mut plain) = (q.clone(), q.clone());
                combine(&x, &samples, &mut wide);
                Combine {
                    coefficients: &x,
                    samples: &samples,
                    out: &mut plain,
                }
                .with_simd(Scalar);
                for t in 0..rows {
                    let expected = q[t] + (0..lags).map(|lag| x[lag] * at(lag, t)).sum::<f64>();
                    assert!(close(wide[t], expected) && close(plain[t], expected));
                }
                let (mut wide, mut plain) = (x.clone(), x.clone());
                correlate(&q, &samples, &mut wide);
                Correlate {
                    q: &q,
                    samples: &samples,
                    sums: &mut plain,
                }
                .with_simd(Scalar);
                for lag in 0..lags {
                    let expected = x[lag] + (0..rows).map(|t| q[t] * at(lag, t)).sum::<f64>();
                    assert!(close(wide[lag], expected) && close(plain[lag], expected));
                }
            }
        }
    }
}
