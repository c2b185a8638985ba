//! Records of known systems as CSV.

use std::fmt::Write as _;

/// Numbers without visible order in -1 .. 1 (`SplitMix64`), the same in every run.
pub struct Noise(u64);

impl Noise {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        (bits >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// A header and rows.
pub fn csv(header: &str, rows: &[Vec<f64>]) -> String {
    let mut text = format!("{header}\n");
    for row in rows {
        let cells: Vec<String> = row.iter().map(ToString::to_string).collect();
        writeln!(text, "{}", cells.join(",")).expect("a string");
    }
    text
}

/// `y(t) = sum a_i y(t - i) + sum b_i u(t - i) + noise e(t)`, rows `[u, y]`, u and e in -1 .. 1.
pub fn arx(a: &[f64], b: &[f64], noise: f64, rows: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut source = Noise::new(seed);
    let (mut u, mut y): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    for t in 0..rows {
        let past = |values: &[f64], lag: usize| if t < lag { 0.0 } else { values[t - lag] };
        let own: f64 = (1..).zip(a).map(|(lag, a)| a * past(&y, lag)).sum();
        let input: f64 = (1..).zip(b).map(|(lag, b)| b * past(&u, lag)).sum();
        y.push(own + input + noise * source.next());
        u.push(source.next());
    }
    u.into_iter().zip(y).map(|(u, y)| vec![u, y]).collect()
}

/// A record `u,y` of a second-order system (poles of modulus 0.84).
pub fn second_order(rows: usize, seed: u64) -> Vec<Vec<f64>> {
    arx(&[1.5, -0.7], &[1.0, 0.5], 0.1, rows, seed)
}

/// `u,y` of [`second_order`] as CSV.
pub fn second_order_csv(rows: usize, seed: u64) -> String {
    csv("u,y", &second_order(rows, seed))
}

/// A record `u1,u2,y1,y2` of two such systems, each with its own input.
pub fn two_outputs_csv(rows: usize, seed: u64) -> String {
    let first = second_order(rows, seed);
    let second = arx(&[1.1, -0.3], &[0.7, -0.2], 0.1, rows, seed + 1000);
    let rows: Vec<Vec<f64>> = first
        .iter()
        .zip(&second)
        .map(|(a, b)| vec![a[0], b[0], a[1], b[1]])
        .collect();
    csv("u1,u2,y1,y2", &rows)
}
