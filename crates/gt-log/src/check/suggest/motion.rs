//! How a tag moves: smoothly, in steps that are held, or renewed every so many samples.

/// Share of the samples that repeat the one before from which a tag is held.
const HELD: f64 = 0.5;
/// A jump of a held tag, as a share of its range; a coarse sensor moves by less.
const JUMP: f64 = 0.05;
/// Runs of one value that are needed to call them regular.
const FEWEST_RUNS: usize = 10;
/// Share of the runs that have the usual length where a tag is renewed regularly.
const REGULAR: f64 = 0.8;

/// How a tag moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Motion {
    /// Nearly every sample differs from the one before.
    Free,
    /// Values are held and left in jumps; the share of samples that repeat the one before.
    Held(f64),
    /// Values stand for the same number of samples each, like those of an analyser.
    Renewed(usize),
}

impl Motion {
    /// The motion of samples; NaN is passed over.
    pub(super) fn of(values: &[f64]) -> Self {
        let valid: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        let runs: Vec<(f64, usize)> = valid
            .chunk_by(|a, b| a.total_cmp(b).is_eq())
            .map(|run| (run[0], run.len()))
            .collect();
        if runs.len() < 2 {
            return Self::Free;
        }
        if let Some(length) = regular(&runs) {
            return Self::Renewed(length);
        }
        let held = 1.0 - runs.len() as f64 / valid.len() as f64;
        let least = valid.iter().copied().fold(f64::INFINITY, f64::min);
        let most = valid.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut jumps: Vec<f64> = runs
            .windows(2)
            .map(|pair| (pair[1].0 - pair[0].0).abs())
            .collect();
        jumps.sort_unstable_by(f64::total_cmp);
        let usual = jumps[jumps.len() / 2];
        if held >= HELD && usual >= JUMP * (most - least) {
            Self::Held(held)
        } else {
            Self::Free
        }
    }
}

/// The length that nearly all runs but the first and the last have; two at least.
fn regular(runs: &[(f64, usize)]) -> Option<usize> {
    let inner = runs.get(1..runs.len() - 1)?;
    if inner.len() < FEWEST_RUNS {
        return None;
    }
    let mut lengths: Vec<usize> = inner.iter().map(|run| run.1).collect();
    lengths.sort_unstable();
    let usual = lengths[lengths.len() / 2];
    let same = lengths.iter().filter(|&&length| length == usual).count();
    (usual >= 2 && same as f64 >= REGULAR * lengths.len() as f64).then_some(usual)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A binary signal that may change every third sample, by the bits of a shift register.
    fn binary() -> Vec<f64> {
        let mut register = 0b1_0110_u32;
        let mut values = Vec::new();
        for _ in 0..60 {
            let bit = (register ^ (register >> 2)) & 1;
            register = (register >> 1) | (bit << 4);
            values.extend([f64::from(register & 1); 3]);
        }
        values
    }

    #[test]
    fn steps_analysers_and_sensors_are_told_apart() {
        let Motion::Held(share) = Motion::of(&binary()) else {
            panic!("a binary signal is held");
        };
        assert!((0.8..0.9).contains(&share), "{share}");
        let sine = |k: u32| (0.37 * f64::from(k)).sin();
        let analyser: Vec<f64> = (0..200).map(|k| sine(k / 5)).collect();
        assert_eq!(Motion::of(&analyser), Motion::Renewed(5));
        let smooth: Vec<f64> = (0..200).map(sine).collect();
        assert_eq!(Motion::of(&smooth), Motion::Free);
        // A slow value, rounded: repeated often, and left by the smallest step.
        let coarse: Vec<f64> = (0..400)
            .map(|k| (25.0 * (0.011 * f64::from(k)).sin()).round())
            .collect();
        assert_eq!(Motion::of(&coarse), Motion::Free);
        assert_eq!(Motion::of(&[1.0; 50]), Motion::Free);
        assert_eq!(Motion::of(&[]), Motion::Free);
    }
}
