//! The messages of a topic in the order of time, a few of them in memory at a time.

use std::collections::BTreeMap;
use std::ops::{ControlFlow, Range};
use std::path::Path;

use mcap::Channel;

use crate::LogError;
use crate::reader::{self, Event, follow, message_time_ns};

/// In which order the messages of a topic are rows.
pub(super) struct Order {
    /// All messages.
    pub(super) total: usize,
    /// The earliest time.
    pub(super) first_ns: u64,
    /// The row of each message of the file; none where time never goes back.
    rows: Option<Vec<usize>>,
}

impl Order {
    /// Reads the times of a topic.
    pub(super) fn read(path: &Path, topic: &str) -> Result<Self, LogError> {
        let (mut total, mut first_ns, mut latest_ns) = (0, u64::MAX, 0);
        let mut is_sorted = true;
        times(path, topic, |time_ns| {
            total += 1;
            is_sorted &= time_ns >= latest_ns;
            first_ns = first_ns.min(time_ns);
            latest_ns = time_ns;
        })?;
        if total == 0 {
            return Err(LogError::NoMessages {
                path: path.to_owned(),
                topic: topic.to_owned(),
            });
        }
        let mut rows = None;
        if !is_sorted {
            let mut found = Vec::with_capacity(total);
            times(path, topic, |time_ns| found.push(time_ns))?;
            let mut order: Vec<usize> = (0..found.len()).collect();
            // Stable: messages of one time stay in the order of the file.
            order.sort_by_key(|&message| found[message]);
            let mut places = vec![0; found.len()];
            for (row, message) in order.into_iter().enumerate() {
                places[message] = row;
            }
            rows = Some(places);
        }
        Ok(Self {
            total,
            first_ns,
            rows,
        })
    }

    /// The row of a message of the file.
    fn row(&self, message: usize) -> usize {
        match &self.rows {
            None => message,
            Some(rows) => rows.get(message).copied().unwrap_or(message),
        }
    }

    /// Calls `sink` with the time and content of every row of `rows` in order. Rows that are not yet
    /// due wait: as many as the log is out of order.
    pub(super) fn rows<T>(
        &self,
        (path, topic): (&Path, &str),
        rows: &Range<usize>,
        mut decode: impl FnMut(&Channel<'static>, &[u8]) -> Result<Result<T, String>, LogError>,
        mut sink: impl FnMut(u64, T) -> Result<(), LogError>,
    ) -> Result<(), LogError> {
        let (mut message, mut next) = (0, rows.start);
        let mut waiting: BTreeMap<usize, (u64, T)> = BTreeMap::new();
        let (source, size) = reader::buffered(path)?;
        follow(path, source, size, |event| {
            let Event::Message(channel, header, data) = event else {
                return Ok(ControlFlow::Continue(()));
            };
            if channel.topic != topic {
                return Ok(ControlFlow::Continue(()));
            }
            let row = self.row(message);
            message += 1;
            if !rows.contains(&row) {
                return Ok(ControlFlow::Continue(()));
            }
            let time_ns = message_time_ns(&header);
            let found = decode(channel, data)?.map_err(|cause| LogError::Message {
                path: path.to_owned(),
                topic: topic.to_owned(),
                time_s: time_ns.saturating_sub(self.first_ns) as f64 / 1e9,
                cause,
            })?;
            waiting.insert(row, (time_ns, found));
            while let Some((time_ns, found)) = waiting.remove(&next) {
                sink(time_ns, found)?;
                next += 1;
            }
            // What follows was looked at when the times were read.
            Ok(if next == rows.end {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            })
        })
    }
}

/// Calls `visit` with the time of every message of a topic.
fn times(path: &Path, topic: &str, mut visit: impl FnMut(u64)) -> Result<(), LogError> {
    let (source, size) = reader::buffered(path)?;
    follow(path, source, size, |event| {
        if let Event::Message(channel, header, _) = event
            && channel.topic == topic
        {
            visit(message_time_ns(&header));
        }
        Ok(ControlFlow::Continue(()))
    })
}
