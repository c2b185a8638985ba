//! The messages of a topic read to their end, whatever is wrong with them.

use std::path::Path;

use gt_core::Signal;

use super::reading::Reading;
use super::{Damage, DamageKind, DataCheck, timing};
use crate::import::{Columns, DEFAULT_TOPIC, Selection, cell_error, chosen_tags};
use crate::reader::{Fault, Messages, read_messages};
use crate::time::Clock;
use crate::{CellProblem, LogError, Place};

/// What stands for the time column of a topic.
const TIMES: &str = "publish time";

/// Examines a topic of a log.
pub(super) fn examine(
    path: &Path,
    selection: &Selection,
    report: &mut DataCheck,
) -> Result<(), LogError> {
    let topic = selection.topic.as_deref().unwrap_or(DEFAULT_TOPIC);
    report.layout = Some("log");
    report.topic = Some(topic.to_owned());
    let read = read_messages(path, selection, |signals| {
        let outputs = chosen_tags(path, signals, None, selection)?;
        let inputs = Vec::new();
        Ok(Columns { inputs, outputs })
    })?;
    report.sha256 = read.sha256;
    let (signals, messages) = (&read.table.signals, &read.messages);
    report.rows = messages.times_ns.len();
    let order = messages.order();
    let places: Vec<Place> = (0..order.len()).map(Place::Message).collect();
    let times = order.iter().map(|&index| messages.times_ns[index].into());
    let clock = Clock::Nanoseconds(times.collect());
    let mut damages = Vec::new();
    report.time = Some(timing::times(
        path,
        TIMES,
        None,
        &clock,
        &places,
        &mut damages,
    ));
    let about = Topic {
        path,
        name: topic,
        signals,
        messages,
        since_s: clock.since(&clock),
    };
    let malformed = order.iter().zip(&places);
    damages.extend(malformed.filter_map(|(&index, &place)| about.malformed(index, place)));
    let mut values = Vec::new();
    for (slot, signal) in signals.iter().enumerate() {
        let mut reading = Reading::new(signal, None);
        for (&index, &place) in order.iter().zip(&places) {
            about.take(&mut reading, slot, index, place);
        }
        let (check, found, own) = reading.finish(true);
        report.tags.push(check);
        damages.extend(found);
        values.push(own);
    }
    damages.sort_by_key(|damage| damage.row);
    report.damages.extend(damages);
    report.suggest(&values, true);
    Ok(())
}

/// The messages of a topic and where they are from.
struct Topic<'a> {
    path: &'a Path,
    name: &'a str,
    signals: &'a [Signal],
    messages: &'a Messages,
    /// The times of the messages in their order, since the first.
    since_s: Vec<f64>,
}

impl Topic<'_> {
    fn time_s(&self, place: Place) -> f64 {
        let (Place::Message(row) | Place::Row(row)) = place else {
            return 0.0;
        };
        self.since_s.get(row).copied().unwrap_or_default()
    }

    /// The damage of a message that cannot be read.
    fn malformed(&self, index: usize, place: Place) -> Option<Damage> {
        let Some(Fault::Malformed(cause)) = self.messages.faults.get(&index) else {
            return None;
        };
        let error = LogError::Message {
            path: self.path.to_owned(),
            topic: self.name.to_owned(),
            time_s: self.time_s(place),
            cause: cause.clone(),
        };
        Some(Damage::at(DamageKind::Row, place, None, &error, None))
    }

    /// Takes a field of a message for what it is.
    fn take(&self, reading: &mut Reading, slot: usize, index: usize, place: Place) {
        let signal = &self.signals[slot];
        let value = self.messages.values[index * self.signals.len() + slot];
        let missing = |error: &LogError| {
            let tag = Some(signal.name.as_str());
            Damage::at(DamageKind::Missing, place, tag, error, Some("--missing"))
        };
        match self.messages.faults.get(&index) {
            Some(Fault::Malformed(_)) => {}
            Some(Fault::Missing(slots)) if slots.contains(&slot) => {
                let error = LogError::MissingField {
                    path: self.path.to_owned(),
                    topic: self.name.to_owned(),
                    column: signal.name.clone(),
                    time_s: self.time_s(place),
                };
                reading.miss("", Some(missing(&error)));
            }
            _ if value.is_finite() => {}
            _ => {
                let problem = CellProblem::NotFinite(value.to_string());
                let error = cell_error(self.path, place, signal, problem);
                let damage = Damage::of_cell(place, &error);
                if value.is_nan() {
                    reading.miss("NaN", Some(damage));
                } else {
                    reading.refuse(damage);
                }
            }
        }
        let number = if value.is_finite() { value } else { f64::NAN };
        reading.push_number(place, number);
    }
}
