//! Local models along a scheduling channel.

use gt_core::index_of;
use serde::{Deserialize, Serialize};

use super::membership::Memberships;
use crate::model::check_signals;
use crate::{ArxModel, IdentError};

/// The model of one operating point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SchedulePoint {
    /// Value of the scheduling channel, in its unit.
    pub value: f64,
    /// The model that holds there.
    pub model: ArxModel,
}

/// ARX models along a scheduling channel, which is one of the inputs.
///
/// At time `t` the channel's value `s(t)` lies between two points, at the part `x` of the way. The
/// upper one weighs `clamp(1/2 + (x - 1/2) / width, 0, 1)`: width 1 is linear interpolation, width
/// 0 a switch half-way. Beyond the ends the last point stands alone. Deserialisation checks what
/// construction guarantees.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct ScheduledModel {
    channel: String,
    width: f64,
    points: Vec<SchedulePoint>,
}

/// The fields as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    channel: String,
    width: f64,
    points: Vec<SchedulePoint>,
}

impl TryFrom<Unchecked> for ScheduledModel {
    type Error = IdentError;

    fn try_from(raw: Unchecked) -> Result<Self, IdentError> {
        Self::new(raw.channel, raw.points, raw.width)
    }
}

impl ScheduledModel {
    /// Models that were fitted apart, in ascending order of the channel's value.
    ///
    /// # Errors
    /// [`IdentError::ScheduleValues`] and [`IdentError::OptionRange`] for values and width;
    /// [`gt_core::DataError::UnknownChannel`] when the channel is no input;
    /// [`IdentError::ChannelName`] and its like when the models differ in channels or sample time.
    pub fn new(
        channel: impl Into<String>,
        points: Vec<SchedulePoint>,
        width: f64,
    ) -> Result<Self, IdentError> {
        let channel = channel.into();
        check_values(points.iter().map(|point| point.value).collect(), width)?;
        let first = &points[0].model;
        index_of(first.inputs(), &channel)?;
        for point in &points[1..] {
            check_channels(first, &point.model)?;
        }
        Ok(Self {
            channel,
            width,
            points,
        })
    }

    /// The scheduling channel's name.
    pub fn channel(&self) -> &str {
        &self.channel
    }

    /// Part of the way between two points over which one hands over to the other.
    pub fn width(&self) -> f64 {
        self.width
    }

    /// The points, in ascending order of their values.
    pub fn points(&self) -> &[SchedulePoint] {
        &self.points
    }

    /// The longest lag of any point in samples.
    pub fn max_lag(&self) -> usize {
        let lags = self.points.iter().map(|point| point.model.max_lag());
        lags.max().unwrap_or(0)
    }

    pub(super) fn memberships(&self) -> Memberships {
        let values = self.points.iter().map(|point| point.value).collect();
        Memberships::new(values, self.width)
    }
}

/// Refuses values that do not ascend, and a width out of range.
pub(super) fn check_values(values: Vec<f64>, width: f64) -> Result<(), IdentError> {
    let ascending = values.windows(2).all(|pair| pair[0] < pair[1]);
    if values.is_empty() || !ascending || !values.iter().all(|value| value.is_finite()) {
        return Err(IdentError::ScheduleValues { found: values });
    }
    if !(0.0..=1.0).contains(&width) {
        return Err(IdentError::OptionRange {
            option: "width",
            expected: "from 0 to 1",
            found: width,
        });
    }
    Ok(())
}

fn check_channels(first: &ArxModel, other: &ArxModel) -> Result<(), IdentError> {
    check_signals("input", first.inputs(), other.inputs())?;
    check_signals("output", first.outputs(), other.outputs())?;
    let (expected, found) = (first.sample_time_s(), other.sample_time_s());
    if (expected - found).abs() > 1e-6 * expected {
        return Err(IdentError::SampleTime { expected, found });
    }
    Ok(())
}
