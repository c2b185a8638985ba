//! Why regressors are linearly dependent, in words.

use std::fmt;

use gt_core::Signal;

use crate::least_squares::{CONDITION_LIMIT, LeastSquares};
use crate::record::Records;
use crate::{Channel, Regressor};

/// Channels named at most; the rest are counted.
const NAMED: usize = 4;

/// What a dependent regressor depends on.
#[derive(Debug, Clone, PartialEq)]
pub enum Dependence {
    /// It is a multiple of one other regressor.
    Multiple {
        /// The other, as it prints.
        of: String,
        /// The factor, in units of the one per unit of the other.
        factor: f64,
    },
    /// It follows from other lags of its own channel, or does not move in the rows used.
    Excitation,
    /// It is a combination of others.
    Combination {
        /// The first few of them, as they print.
        of: Vec<String>,
        /// How many there are besides.
        more: usize,
    },
    /// No regressor follows from those before it, yet together they nearly do.
    Unclear,
}

impl fmt::Display for Dependence {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Multiple { of, factor } => write!(formatter, "is {factor:.6} times {of}"),
            Self::Excitation => formatter.write_str(
                "follows from its own other lags or stands still in the rows used: the channel \
                 does not excite so many lags",
            ),
            Self::Combination { of, more } => {
                write!(formatter, "follows from {}", of.join(", "))?;
                if *more > 0 {
                    write!(formatter, " and {more} more")?;
                }
                Ok(())
            }
            Self::Unclear => formatter.write_str(
                "is the closest to depending on the others; check units, scales and the operating \
                 point for channels that move little beside their size",
            ),
        }
    }
}

/// A lagged channel by the channel's name.
pub(crate) fn named(inputs: &[Signal], outputs: &[Signal], regressor: Regressor) -> String {
    format!(
        "`{}` at lag {}",
        channel_name(inputs, outputs, regressor.channel),
        regressor.lag
    )
}

pub(crate) fn channel_name<'a>(
    inputs: &'a [Signal],
    outputs: &'a [Signal],
    channel: Channel,
) -> &'a str {
    match channel {
        Channel::Output(index) => &outputs[index].name,
        Channel::Input(index) => &inputs[index].name,
    }
}

/// What the weakest column of a solution depends on.
pub(crate) fn explain(
    records: &Records,
    (inputs, outputs): (&[Signal], &[Signal]),
    regressors: &[Regressor],
    solution: &LeastSquares,
) -> Dependence {
    let weakest = solution.weakest();
    let (factor, blamed) = (&solution.factor, regressors[weakest]);
    if factor[(weakest, weakest)].abs() > 10.0 / CONDITION_LIMIT {
        return Dependence::Unclear;
    }
    let before = factor.view((0, 0), (weakest, weakest)).into_owned();
    let mut parts = factor.view((0, weakest), (weakest, 1)).into_owned();
    if !before.solve_upper_triangular_mut(&mut parts) {
        return Dependence::Unclear;
    }
    // Columns have norm 1, so that parts of 1e-6 and below are far from explaining anything.
    let involved: Vec<usize> = (0..weakest).filter(|&i| parts[i].abs() > 1e-6).collect();
    let own = |&i: &usize| regressors[i].channel == blamed.channel;
    if involved.iter().all(own) {
        return Dependence::Excitation;
    }
    let name = |&i: &usize| named(inputs, outputs, regressors[i]);
    if let [only] = involved[..] {
        let per_unit = |i: usize| solution.scales[i] / records.scale(regressors[i].channel);
        return Dependence::Multiple {
            of: name(&only),
            factor: parts[only] * per_unit(weakest) / per_unit(only),
        };
    }
    Dependence::Combination {
        of: involved.iter().take(NAMED).map(name).collect(),
        more: involved.len().saturating_sub(NAMED),
    }
}
