//! Products of lagged channels with vectors: the two inner loops of every pass over a record.
//!
//! With AVX2 and fused multiplication, found at run time, they do 8 to 11 multiplications a
//! nanosecond on the machine they were written on, in the portable build 3 to 4.6; what share of a
//! fit that is has not been measured. The results of the two differ by rounding.
#![allow(
    unsafe_code,
    reason = "two calls of functions that use an instruction set whose presence is asked for \
              beforehand; the tests below compare both ways, and each loop is 2 to 3 times as fast"
)]

/// Rows in a tile of [`combine`]: wide enough that the sums of eight registers run side by side.
const TILE: usize = 64;
/// Partial sums of one dot product.
const LANES: usize = 8;

/// `out[t] += sum over l of coefficients[l] * samples[last - l + t]`, so that `coefficients[0]`
/// meets the smallest lag. `samples` holds `out.len() + coefficients.len() - 1` numbers.
pub(crate) fn combine(coefficients: &[f64], samples: &[f64], out: &mut [f64]) {
    #[cfg(target_arch = "x86_64")]
    if fused() {
        // SAFETY: `fused` has found AVX2 and FMA, which is all that the function asks for.
        unsafe { combine_fused(coefficients, samples, out) };
        return;
    }
    combine_with::<false>(coefficients, samples, out);
}

/// `sums[l] += sum over t of q[t] * samples[last - l + t]`, the transpose of [`combine`].
pub(crate) fn correlate(q: &[f64], samples: &[f64], sums: &mut [f64]) {
    #[cfg(target_arch = "x86_64")]
    if fused() {
        // SAFETY: `fused` has found AVX2 and FMA, which is all that the function asks for.
        unsafe { correlate_fused(q, samples, sums) };
        return;
    }
    correlate_plain(q, samples, sums);
}

#[cfg(target_arch = "x86_64")]
fn fused() -> bool {
    std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma")
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn combine_fused(coefficients: &[f64], samples: &[f64], out: &mut [f64]) {
    combine_with::<true>(coefficients, samples, out);
}

/// [`correlate_plain`] with two registers of four sums for each lag: left to itself the compiler gathers
/// across lags, at less than half the speed.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn correlate_fused(q: &[f64], samples: &[f64], sums: &mut [f64]) {
    let mut done = 0;
    while done < sums.len() {
        let left = sums.len() - done;
        let take = group(left);
        let from = &samples[left - take..];
        let part = &mut sums[done..done + take];
        match take {
            1 => dots_fused::<1>(q, from, part),
            2 => dots_fused::<2>(q, from, part),
            3 => dots_fused::<3>(q, from, part),
            4 => dots_fused::<4>(q, from, part),
            5 => dots_fused::<5>(q, from, part),
            _ => dots_fused::<6>(q, from, part),
        }
        done += take;
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn dots_fused<const COUNT: usize>(q: &[f64], samples: &[f64], sums: &mut [f64]) {
    use std::arch::x86_64::{
        __m256d, _mm256_add_pd, _mm256_fmadd_pd, _mm256_setr_pd, _mm256_setzero_pd,
    };

    let load = |from: &[f64; LANES], at: usize| -> __m256d {
        _mm256_setr_pd(from[at], from[at + 1], from[at + 2], from[at + 3])
    };
    let mut lanes = [[_mm256_setzero_pd(); 2]; COUNT];
    let whole = q.len() - q.len() % LANES;
    for start in (0..whole).step_by(LANES) {
        let Some(factor) = q[start..].first_chunk::<LANES>() else {
            return;
        };
        let window = &samples[start..start + LANES + COUNT - 1];
        for lag in 0..COUNT {
            let Some(lagged) = window[COUNT - 1 - lag..].first_chunk::<LANES>() else {
                return;
            };
            for (half, lanes) in lanes[lag].iter_mut().enumerate() {
                let (a, b) = (load(factor, 4 * half), load(lagged, 4 * half));
                *lanes = _mm256_fmadd_pd(a, b, *lanes);
            }
        }
    }
    for (lag, (sum, lanes)) in sums.iter_mut().zip(lanes).enumerate() {
        let mut total = total_of(_mm256_add_pd(lanes[0], lanes[1]));
        for t in whole..q.len() {
            total = q[t].mul_add(samples[COUNT - 1 - lag + t], total);
        }
        *sum += total;
    }
}

/// The sum of four lanes.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn total_of(lanes: std::arch::x86_64::__m256d) -> f64 {
    use std::arch::x86_64::{
        _mm_add_pd, _mm_add_sd, _mm_cvtsd_f64, _mm_unpackhi_pd, _mm256_castpd256_pd128,
        _mm256_extractf128_pd,
    };
    let pair = _mm_add_pd(
        _mm256_castpd256_pd128(lanes),
        _mm256_extractf128_pd::<1>(lanes),
    );
    _mm_cvtsd_f64(_mm_add_sd(pair, _mm_unpackhi_pd(pair, pair)))
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

/// `a b + c`; without the instruction `mul_add` would be a call of the C library.
#[inline(always)]
fn multiply_add<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

#[inline(always)]
fn combine_with<const FUSED: bool>(coefficients: &[f64], samples: &[f64], out: &mut [f64]) {
    let last = coefficients.len().saturating_sub(1);
    let whole = out.len() - out.len() % TILE;
    let starts = (0..whole).step_by(TILE);
    for (start, tile) in starts.zip(out.chunks_exact_mut(TILE)) {
        let mut sums = [0.0; TILE];
        sums.copy_from_slice(tile);
        for (lag, &coefficient) in coefficients.iter().enumerate() {
            let Some(lagged) = samples[last - lag + start..].first_chunk::<TILE>() else {
                return;
            };
            for i in 0..TILE {
                sums[i] = multiply_add::<FUSED>(coefficient, lagged[i], sums[i]);
            }
        }
        tile.copy_from_slice(&sums);
    }
    for (t, value) in out.iter_mut().enumerate().skip(whole) {
        for (lag, &coefficient) in coefficients.iter().enumerate() {
            *value = multiply_add::<FUSED>(coefficient, samples[last - lag + t], *value);
        }
    }
}

fn correlate_plain(q: &[f64], samples: &[f64], sums: &mut [f64]) {
    let mut done = 0;
    while done < sums.len() {
        let left = sums.len() - done;
        let take = group(left);
        let from = &samples[left - take..];
        let part = &mut sums[done..done + take];
        match take {
            1 => dots::<1>(q, from, part),
            2 => dots::<2>(q, from, part),
            3 => dots::<3>(q, from, part),
            4 => dots::<4>(q, from, part),
            5 => dots::<5>(q, from, part),
            _ => dots::<6>(q, from, part),
        }
        done += take;
    }
}

/// `COUNT` dot products of `q` with `samples` shifted by one from each to the next.
fn dots<const COUNT: usize>(q: &[f64], samples: &[f64], sums: &mut [f64]) {
    let mut lanes = [[0.0; LANES]; COUNT];
    let whole = q.len() - q.len() % LANES;
    for start in (0..whole).step_by(LANES) {
        let Some(factor) = q[start..].first_chunk::<LANES>() else {
            return;
        };
        let window = &samples[start..start + LANES + COUNT - 1];
        for lag in 0..COUNT {
            let Some(lagged) = window[COUNT - 1 - lag..].first_chunk::<LANES>() else {
                return;
            };
            for i in 0..LANES {
                lanes[lag][i] += factor[i] * lagged[i];
            }
        }
    }
    for (lag, (sum, lanes)) in sums.iter_mut().zip(&lanes).enumerate() {
        let mut total = lanes.iter().sum::<f64>();
        for t in whole..q.len() {
            total += q[t] * samples[COUNT - 1 - lag + t];
        }
        *sum += total;
    }
}

#[cfg(test)]
mod tests {
    use super::{combine, combine_with, correlate, correlate_plain};

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
                combine_with::<false>(&x, &samples, &mut plain);
                for t in 0..rows {
                    let expected = q[t] + (0..lags).map(|lag| x[lag] * at(lag, t)).sum::<f64>();
                    assert!(close(wide[t], expected) && close(plain[t], expected));
                }
                let (mut wide, mut plain) = (x.clone(), x.clone());
                correlate(&q, &samples, &mut wide);
                correlate_plain(&q, &samples, &mut plain);
                for lag in 0..lags {
                    let expected = x[lag] + (0..rows).map(|t| q[t] * at(lag, t)).sum::<f64>();
                    assert!(close(wide[lag], expected) && close(plain[lag], expected));
                }
            }
        }
    }
}
