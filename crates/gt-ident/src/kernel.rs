//! Products of lagged channels with vectors: the two inner loops of every pass over a record.
//!
//! Both are written on arrays that the compiler turns into registers. With AVX2 and fused
//! multiplication, found at run time, they run at two to three times the speed of the portable
//! build (`cargo bench -p gtfdi --bench arx` prints what is gained); the results of the two differ
//! by rounding.
#![allow(
    unsafe_code,
    reason = "two calls of functions that use an instruction set whose presence is asked for \
              beforehand; the tests below compare both ways, benches/arx.rs shows the gain"
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
    correlate_with::<false>(q, samples, sums);
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

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn correlate_fused(q: &[f64], samples: &[f64], sums: &mut [f64]) {
    correlate_with::<true>(q, samples, sums);
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

#[inline(always)]
fn correlate_with<const FUSED: bool>(q: &[f64], samples: &[f64], sums: &mut [f64]) {
    // Groups of four to six lags keep their sums in sixteen registers; one alone would wait for
    // its own last addition.
    let mut done = 0;
    while done < sums.len() {
        let left = sums.len() - done;
        let take = match left {
            0..=6 => left,
            7 | 8 => 4,
            9 | 10 => 5,
            _ => 6,
        };
        let from = &samples[left - take..];
        let group = &mut sums[done..done + take];
        match take {
            1 => dots::<FUSED, 1>(q, from, group),
            2 => dots::<FUSED, 2>(q, from, group),
            3 => dots::<FUSED, 3>(q, from, group),
            4 => dots::<FUSED, 4>(q, from, group),
            5 => dots::<FUSED, 5>(q, from, group),
            _ => dots::<FUSED, 6>(q, from, group),
        }
        done += take;
    }
}

/// `COUNT` dot products of `q` with `samples` shifted by one from each to the next.
#[inline(always)]
fn dots<const FUSED: bool, const COUNT: usize>(q: &[f64], samples: &[f64], sums: &mut [f64]) {
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
                lanes[lag][i] = multiply_add::<FUSED>(factor[i], lagged[i], lanes[lag][i]);
            }
        }
    }
    for (lag, (sum, lanes)) in sums.iter_mut().zip(&lanes).enumerate() {
        let mut total = lanes.iter().sum::<f64>();
        for t in whole..q.len() {
            total = multiply_add::<FUSED>(q[t], samples[COUNT - 1 - lag + t], total);
        }
        *sum += total;
    }
}

#[cfg(test)]
mod tests {
    use super::{combine, combine_with, correlate, correlate_with};

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
                correlate_with::<false>(&q, &samples, &mut plain);
                for lag in 0..lags {
                    let expected = x[lag] + (0..rows).map(|t| q[t] * at(lag, t)).sum::<f64>();
                    assert!(close(wide[lag], expected) && close(plain[lag], expected));
                }
            }
        }
    }
}
