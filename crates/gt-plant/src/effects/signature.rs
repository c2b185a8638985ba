//! Which of the monitored outputs each fault moves, and which fault moves each output most.

use gt_core::Signal;
use nalgebra::DMatrix;
use serde::Serialize;

use super::{CASES, rows};

/// The monitored outputs, in the order of the cases that each is to show: the torque of the
/// compressor, the temperature at its exit, the pressure at the turbine's exit, the flow out of the
/// combustor (the paper's q, t, p and m).
pub const MONITORED: [&str; CASES] = ["q_c", "t3", "p7", "m9"];

/// The four cases in the four monitored outputs.
///
/// The scales of outputs cannot be compared, so each output is normalised by the case that moves it
/// most. The signature of the paper's Table 2 holds where [`Signature::is_diagonal`]; its zeros
/// hold where the other shares are small.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Signature {
    /// The size of each effect over the largest on the same output (4 x 4: [`MONITORED`], cases).
    #[serde(serialize_with = "rows")]
    pub share: DMatrix<f64>,
    /// The number of the case, 1 to 4, that moves each of [`MONITORED`] most; none where no case
    /// moves it.
    pub strongest_case: [Option<usize>; CASES],
    /// The monitored output that each case moves most in percent; none where it moves none.
    pub most_affected: [Option<&'static str>; CASES],
}

impl Signature {
    /// The signature in effects (28 x 4) on these outputs.
    pub(super) fn of(outputs: &[Signal], percent: &DMatrix<f64>) -> Self {
        let row = |name| outputs.iter().position(|signal| signal.name == name);
        let sizes = DMatrix::from_fn(CASES, CASES, |output, case| {
            let effect = row(MONITORED[output]).and_then(|row| percent.get((row, case)));
            effect.map_or(0.0, |percent| percent.abs())
        });
        let largest = |output| sizes.row(output).max();
        Self {
            share: DMatrix::from_fn(CASES, CASES, |output, case| {
                let size = sizes[(output, case)];
                if size > 0.0 {
                    size / largest(output)
                } else {
                    0.0
                }
            }),
            strongest_case: std::array::from_fn(|output| {
                peak(sizes.row(output).iter()).map(|case| case + 1)
            }),
            most_affected: std::array::from_fn(|case| {
                peak(sizes.column(case).iter()).map(|output| MONITORED[output])
            }),
        }
    }

    /// Whether every monitored output is moved most by its own case.
    pub fn is_diagonal(&self) -> bool {
        self.strongest_case == [Some(1), Some(2), Some(3), Some(4)]
    }
}

/// Where the largest of numbers stands; none where no number is above zero.
fn peak<'a>(numbers: impl Iterator<Item = &'a f64>) -> Option<usize> {
    let mut best = (None, 0.0);
    for (index, &number) in numbers.enumerate() {
        if number > best.1 {
            best = (Some(index), number);
        }
    }
    best.0
}
