//! One recorded channel by name.

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::PlantError;
use crate::channels::{INPUT_CHANNELS, INPUTS, OUTPUT_CHANNELS, OUTPUTS, Quantity};
use crate::variant::Variant;

/// Number of recorded channels.
pub const CHANNELS: usize = INPUTS + OUTPUTS;

/// A recorded channel: an input or an output. In a file it is its name.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema,
)]
#[serde(try_from = "String", into = "String")]
pub struct Channel(usize);

/// Where a channel stands in a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChannelRow {
    /// A row of the inputs.
    Input(usize),
    /// A row of the outputs.
    Output(usize),
}

const fn names() -> [&'static str; CHANNELS] {
    let mut names = [""; CHANNELS];
    let mut row = 0;
    while row < INPUTS {
        names[row] = INPUT_CHANNELS[row].0;
        row += 1;
    }
    while row < CHANNELS {
        names[row] = OUTPUT_CHANNELS[row - INPUTS].0;
        row += 1;
    }
    names
}

impl Channel {
    /// The names, inputs first, in the order of the records.
    pub const NAMES: &[&str] = &names();

    /// All channels, inputs first, in the order of the records.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..CHANNELS).map(Self)
    }

    /// The channels of a variant, inputs first, in the order of its records.
    pub fn of(variant: Variant) -> impl Iterator<Item = Self> {
        Self::all().filter(move |channel| channel.is_in(variant))
    }

    /// Whether the records of a variant have this channel.
    pub fn is_in(self, variant: Variant) -> bool {
        match self.row() {
            ChannelRow::Input(row) => row < variant.input_channels().len(),
            ChannelRow::Output(row) => row < variant.output_channels().len(),
        }
    }

    /// The channel of a name.
    ///
    /// # Errors
    /// [`PlantError::UnknownName`] with the names there are.
    pub fn named(name: &str) -> Result<Self, PlantError> {
        Self::NAMES
            .iter()
            .position(|known| *known == name)
            .map(Self)
            .ok_or_else(|| PlantError::UnknownName {
                what: "channel",
                expected: Self::NAMES,
                found: name.to_owned(),
            })
    }

    /// The name.
    pub fn name(self) -> &'static str {
        self.describe().0
    }

    /// The unit.
    pub fn unit(self) -> &'static str {
        self.describe().1
    }

    /// What it measures.
    pub fn quantity(self) -> Quantity {
        self.describe().2
    }

    /// Its row among the inputs or the outputs.
    pub fn row(self) -> ChannelRow {
        match self.0.checked_sub(INPUTS) {
            Some(row) => ChannelRow::Output(row),
            None => ChannelRow::Input(self.0),
        }
    }

    /// Its place among all channels, inputs first.
    pub fn index(self) -> usize {
        self.0
    }

    fn describe(self) -> (&'static str, &'static str, Quantity) {
        match self.row() {
            ChannelRow::Input(row) => INPUT_CHANNELS[row],
            ChannelRow::Output(row) => OUTPUT_CHANNELS[row],
        }
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

impl FromStr for Channel {
    type Err = PlantError;

    fn from_str(name: &str) -> Result<Self, PlantError> {
        Self::named(name)
    }
}

impl TryFrom<String> for Channel {
    type Error = PlantError;

    fn try_from(name: String) -> Result<Self, PlantError> {
        Self::named(&name)
    }
}

impl From<Channel> for String {
    fn from(channel: Channel) -> Self {
        channel.name().to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_back_and_rows_are_those_of_the_records() {
        assert_eq!(Channel::all().count(), CHANNELS);
        for (index, channel) in Channel::all().enumerate() {
            assert_eq!(channel.name().parse(), Ok(channel));
            assert_eq!(channel.index(), index);
            let found = match channel.row() {
                ChannelRow::Input(row) => INPUT_CHANNELS[row],
                ChannelRow::Output(row) => OUTPUT_CHANNELS[row],
            };
            assert_eq!(found, (channel.name(), channel.unit(), channel.quantity()));
        }
    }

    #[test]
    fn an_unknown_channel_is_named_with_those_there_are() {
        let message = Channel::named("t33").unwrap_err().to_string();
        assert!(
            message
                .starts_with("channel: expected one of a_v, M_f, w_ref, p_a, T_a, LHV, IGV, p1,")
                && message.ends_with(", w_t, N_t, P_e, T_ot, m_ot, found `t33`"),
            "{message}"
        );
    }
}
