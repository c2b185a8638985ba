//! What there is to say about an identified errors-in-variables model.

use std::fmt;

use super::{ChannelNoise, EivModel};

/// Something that the user of an identified model should know.
#[derive(Debug, Clone, PartialEq)]
pub enum EivRemark {
    /// The record ended the automatic search for the order early.
    NoHigherOrder {
        /// Samples of the record.
        samples: usize,
        /// The highest order that it bears.
        highest: usize,
    },
    /// The record is short for the model, see [`super::EivEstimate::short_record`].
    ShortRecord {
        /// Samples of the record.
        samples: usize,
    },
    /// The likelihood's maximum was not found to the tolerance of the search.
    NotConverged,
    /// The record does not tell a variance, see [`ChannelNoise::identifiable`].
    NoiseNotTold {
        /// The channel's name.
        channel: String,
        /// What was found.
        noise: ChannelNoise,
    },
}

impl EivModel {
    /// The variances that the record does not tell.
    pub fn not_told(&self) -> Vec<EivRemark> {
        let untold = self
            .noise()
            .filter(|(_, noise)| noise.identifiable() == Some(false));
        let remarks = untold.map(|(signal, noise)| EivRemark::NoiseNotTold {
            channel: signal.name.clone(),
            noise: *noise,
        });
        remarks.collect()
    }
}

impl fmt::Display for EivRemark {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoHigherOrder { samples, highest } => write!(
                formatter,
                "{samples} rows bear no order above {highest}: the search looked no further"
            ),
            Self::ShortRecord { samples } => write!(
                formatter,
                "{samples} rows are few for this model: the standard errors promise too much"
            ),
            Self::NotConverged => {
                formatter.write_str("the search for the likelihood's maximum did not end")
            }
            Self::NoiseNotTold { channel, noise } => {
                write!(
                    formatter,
                    "the record does not tell the noise of `{channel}`: variance {:.3e}, ",
                    noise.variance
                )?;
                match (noise.standard_error, noise.at_limit) {
                    (Some(_), true) => formatter.write_str("it stands at a limit of the search"),
                    (Some(error), false) => write!(formatter, "standard error {error:.3e}"),
                    (None, _) => formatter.write_str("its standard error is without bound"),
                }
            }
        }
    }
}
