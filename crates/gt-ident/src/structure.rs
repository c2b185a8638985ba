//! Which lags of which channels an ARX model uses.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::IdentError;

/// The structure of an ARX model: which lagged channels explain an output.
///
/// | Name | Default | Purpose | Range |
/// |---|---|---|---|
/// | `na` | none | output lags `1..=na` | `0..`, 0 gives a finite impulse response |
/// | `nb` | none | number of lags of an input; one entry for all inputs or one per input | `0..`, 0 leaves the input out |
/// | `nk` | none | smallest lag of an input; one entry or one per input | `0..` |
/// | `indices` | none | `v_i` of eq. 7-9, one per output | `1..` |
/// | `feedthrough` | none | adds `u(t)`, the coefficients `beta_{i, v_i + 1}` | true, false |
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ArxStructure {
    /// Each output is explained by its own past and the inputs.
    Diagonal {
        /// Output lags.
        na: usize,
        /// Input lags, one entry or one per input.
        nb: Vec<usize>,
        /// Smallest input lag, one entry or one per input.
        nk: Vec<usize>,
    },
    /// Each output is explained by the past of all outputs and the inputs.
    Full {
        /// Output lags.
        na: usize,
        /// Input lags, one entry or one per input.
        nb: Vec<usize>,
        /// Smallest input lag, one entry or one per input.
        nk: Vec<usize>,
    },
    /// The minimal parametrisation of eq. 7-9.
    ///
    /// Where `v_j > v_i` for some `j < i`, the row of output `i` holds `y_j` at lag 0. Least
    /// squares on such a row is consistent only where the equation errors of the outputs are not
    /// correlated; [`crate::EquationErrors::Correlated`] estimates all rows together. Equal indices have no such term, nor have ascending ones; [`generic_indices`]
    /// have it unless the outputs share the order evenly.
    Canonical {
        /// `v_i`, one per output; the order is their sum (eq. 8).
        indices: Vec<usize>,
        /// Whether `u(t)` acts on `y(t)`.
        feedthrough: bool,
    },
}

/// A measured channel, by its 0-based position among the outputs or inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// An output.
    Output(usize),
    /// An input.
    Input(usize),
}

impl fmt::Display for Channel {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Output(index) => write!(formatter, "output {index}"),
            Self::Input(index) => write!(formatter, "input {index}"),
        }
    }
}

/// A lagged channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Regressor {
    /// The channel.
    pub channel: Channel,
    /// The lag in samples.
    pub lag: usize,
}

impl fmt::Display for Regressor {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} at lag {}", self.channel, self.lag)
    }
}

impl ArxStructure {
    /// Refuses a structure that does not fit `nu` inputs and `ny` outputs.
    ///
    /// # Errors
    /// [`IdentError::NoOutputs`], [`IdentError::OptionLength`], [`IdentError::NoTerms`],
    /// [`IdentError::IndexCount`] or [`IdentError::IndexZero`].
    pub fn validate(&self, nu: usize, ny: usize) -> Result<(), IdentError> {
        if ny == 0 {
            return Err(IdentError::NoOutputs);
        }
        match self {
            Self::Diagonal { na, nb, nk } | Self::Full { na, nb, nk } => {
                for (option, list) in [("nk", nk), ("nb", nb)] {
                    if list.len() != 1 && list.len() != nu {
                        let found = list.len();
                        return Err(IdentError::OptionLength {
                            option,
                            inputs: nu,
                            found,
                        });
                    }
                }
                if *na == 0 && (nu == 0 || nb.iter().all(|&lags| lags == 0)) {
                    return Err(IdentError::NoTerms {
                        structure: self.to_string(),
                    });
                }
            }
            Self::Canonical { indices, .. } => {
                if indices.len() != ny {
                    return Err(IdentError::IndexCount {
                        expected: ny,
                        found: indices.len(),
                    });
                }
                if let Some(output) = indices.iter().position(|&index| index == 0) {
                    return Err(IdentError::IndexZero { output });
                }
            }
        }
        Ok(())
    }

    /// The longest lag of any row with `nu` inputs, in samples: the first regression row.
    pub fn max_lag(&self, nu: usize) -> usize {
        match self {
            Self::Diagonal { na, nb, nk } | Self::Full { na, nb, nk } => {
                let input = (0..nu)
                    .filter(|&input| entry(nb, input) > 0)
                    .map(|input| entry(nk, input).saturating_add(entry(nb, input) - 1))
                    .max();
                input.unwrap_or(0).max(*na)
            }
            Self::Canonical { indices, .. } => indices.iter().copied().max().unwrap_or(0),
        }
    }

    /// Number of coefficients of the row of `output`, saturating.
    pub fn row_parameters(&self, output: usize, nu: usize, ny: usize) -> usize {
        let inputs =
            |nb: &[usize]| (0..nu).fold(0_usize, |sum, input| sum.saturating_add(entry(nb, input)));
        match self {
            Self::Diagonal { na, nb, .. } => inputs(nb).saturating_add(*na),
            Self::Full { na, nb, .. } => inputs(nb).saturating_add(na.saturating_mul(ny)),
            Self::Canonical {
                indices,
                feedthrough,
            } => {
                let Some(&own) = indices.get(output) else {
                    return 0;
                };
                let outputs = (0..indices.len()).fold(0_usize, |sum, j| {
                    sum.saturating_add(shared_index(indices, output, j))
                });
                let lags = own.saturating_add(usize::from(*feedthrough));
                outputs.saturating_add(lags.saturating_mul(nu))
            }
        }
    }

    /// Number of coefficients of the whole model, saturating; for the canonical structure
    /// `sum of v_ij + n nu (+ ny nu with feedthrough)`.
    pub fn parameters(&self, nu: usize, ny: usize) -> usize {
        (0..ny).fold(0, |sum, output| {
            sum.saturating_add(self.row_parameters(output, nu, ny))
        })
    }

    /// The regressors of the row of `output`, outputs before inputs, recent lags first. Sizes
    /// have been checked against a record or a stored row by then, so that they fit in memory.
    pub(crate) fn regressors(
        &self,
        output: usize,
        nu: usize,
        ny: usize,
    ) -> Result<Vec<Regressor>, IdentError> {
        self.validate(nu, ny)?;
        if output >= ny {
            return Err(IdentError::NoSuchOutput {
                found: output,
                outputs: ny,
            });
        }
        let mut regressors = Vec::with_capacity(self.row_parameters(output, nu, ny));
        match self {
            Self::Diagonal { na, nb, nk } => {
                for lag in 1..=*na {
                    regressors.push(Regressor {
                        channel: Channel::Output(output),
                        lag,
                    });
                }
                push_inputs(&mut regressors, nb, nk, nu);
            }
            Self::Full { na, nb, nk } => {
                for lag in 1..=*na {
                    let outputs = (0..ny).map(Channel::Output);
                    regressors.extend(outputs.map(|channel| Regressor { channel, lag }));
                }
                push_inputs(&mut regressors, nb, nk, nu);
            }
            Self::Canonical {
                indices,
                feedthrough,
            } => {
                let own = indices[output];
                for lag in 0..=own {
                    for j in 0..ny {
                        // y_j(t + k - 1) with k <= v_ij in eq. 7 is lag v_i - k + 1 here.
                        if lag + shared_index(indices, output, j) > own {
                            regressors.push(Regressor {
                                channel: Channel::Output(j),
                                lag,
                            });
                        }
                    }
                }
                for lag in usize::from(!*feedthrough)..=own {
                    let inputs = (0..nu).map(Channel::Input);
                    regressors.extend(inputs.map(|channel| Regressor { channel, lag }));
                }
            }
        }
        Ok(regressors)
    }

    /// Refuses sizes that would not fit a record of `samples`, before anything is allocated.
    pub(crate) fn check_rows(
        &self,
        nu: usize,
        ny: usize,
        first_row: usize,
        samples: usize,
    ) -> Result<(), IdentError> {
        let largest = (0..ny)
            .map(|output| self.row_parameters(output, nu, ny))
            .max()
            .unwrap_or(0);
        let first = self.max_lag(nu).max(first_row);
        let needed = first.saturating_add(largest).saturating_add(1);
        if samples < needed {
            let structure = self.to_string();
            return Err(IdentError::TooFewRows {
                structure,
                needed,
                found: samples,
            });
        }
        Ok(())
    }
}

/// `v_ij` of eq. 9.
pub(crate) fn shared_index(indices: &[usize], i: usize, j: usize) -> usize {
    let (own, other) = (indices[i], indices[j]);
    match i.cmp(&j) {
        std::cmp::Ordering::Equal => own,
        std::cmp::Ordering::Greater => own.saturating_add(1).min(other),
        std::cmp::Ordering::Less => own.min(other),
    }
}

/// The indices of a generic system of the given order: `v_1 >= v_2 >= .. >= v_m >= v_1 - 1`, which
/// almost every system of that order has. An order that is a multiple of the number of outputs
/// gives equal indices, and no row then has a term at lag 0 of another output.
///
/// # Errors
/// [`IdentError::NoOutputs`], or [`IdentError::OrderTooSmall`] when an output would get none.
pub fn generic_indices(order: usize, outputs: usize) -> Result<Vec<usize>, IdentError> {
    if outputs == 0 {
        return Err(IdentError::NoOutputs);
    }
    if order < outputs {
        return Err(IdentError::OrderTooSmall { order, outputs });
    }
    let (each, left) = (order / outputs, order % outputs);
    Ok((0..outputs)
        .map(|output| each + usize::from(output < left))
        .collect())
}

/// The entry of a list that holds one value for all inputs or one per input.
fn entry(list: &[usize], input: usize) -> usize {
    if list.len() == 1 {
        list[0]
    } else {
        list.get(input).copied().unwrap_or(0)
    }
}

fn push_inputs(regressors: &mut Vec<Regressor>, nb: &[usize], nk: &[usize], nu: usize) {
    let most = (0..nu).map(|input| entry(nb, input)).max().unwrap_or(0);
    for step in 0..most {
        for input in (0..nu).filter(|&input| step < entry(nb, input)) {
            let lag = entry(nk, input).saturating_add(step);
            regressors.push(Regressor {
                channel: Channel::Input(input),
                lag,
            });
        }
    }
}

impl fmt::Display for ArxStructure {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |values: &[usize]| {
            values
                .iter()
                .map(ToString::to_string)
                .collect::<Vec<_>>()
                .join(",")
        };
        match self {
            Self::Diagonal { na, nb, nk } => {
                write!(
                    formatter,
                    "diagonal na={na} nb={} nk={}",
                    list(nb),
                    list(nk)
                )
            }
            Self::Full { na, nb, nk } => {
                write!(formatter, "full na={na} nb={} nk={}", list(nb), list(nk))
            }
            Self::Canonical {
                indices,
                feedthrough,
            } => {
                let direct = if *feedthrough {
                    " with feedthrough"
                } else {
                    ""
                };
                write!(formatter, "canonical v=({}){direct}", list(indices))
            }
        }
    }
}
