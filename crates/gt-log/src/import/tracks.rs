//! Readings of several tags, each at its own times.

use std::collections::BTreeMap;
use std::path::Path;

use gt_core::Signal;

use super::gather::{Gathered, word_warnings};
use super::grid::{Grid, Readings};
use super::instant::FileTime;
use super::{Imported, ReadingError, Resample, Selection, Warning};
use crate::time::Clock;
use crate::{LogError, Place};

/// The readings of a tag.
#[derive(Debug, Clone)]
pub(crate) struct Track {
    pub(crate) clock: Clock,
    pub(crate) values: Vec<f64>,
    pub(crate) places: Vec<Place>,
}

impl Track {
    /// No readings, at the times of an empty clock.
    pub(crate) fn new(clock: Clock) -> Self {
        Self {
            clock,
            values: Vec::new(),
            places: Vec::new(),
        }
    }

    /// The time of the last reading, where it is an instant.
    pub(crate) fn last_ns(&self) -> Option<i128> {
        match &self.clock {
            Clock::Nanoseconds(times) => times.last().copied(),
            Clock::Seconds(_) => None,
        }
    }

    /// Appends a reading; all times of a file are of one kind.
    pub(crate) fn push(&mut self, time: FileTime, value: f64, place: Place) {
        match (&mut self.clock, time) {
            (Clock::Seconds(times), FileTime::Seconds(time)) => times.push(time),
            (Clock::Nanoseconds(times), FileTime::Nanoseconds(time)) => times.push(time),
            _ => return,
        }
        self.values.push(value);
        self.places.push(place);
    }

    /// Puts the readings in the order of their times; those of one time keep theirs.
    fn sort(&mut self) {
        let mut order: Vec<usize> = (0..self.values.len()).collect();
        match &mut self.clock {
            Clock::Seconds(times) => {
                order.sort_by(|&a, &b| times[a].total_cmp(&times[b]));
                *times = order.iter().map(|&k| times[k]).collect();
            }
            Clock::Nanoseconds(times) => {
                order.sort_by_key(|&k| times[k]);
                *times = order.iter().map(|&k| times[k]).collect();
            }
        }
        self.values = order.iter().map(|&k| self.values[k]).collect();
        self.places = order.iter().map(|&k| self.places[k]).collect();
    }
}

/// The readings of the selected tags, inputs first.
#[derive(Debug)]
pub(crate) struct Tracks {
    pub(crate) signals: Vec<Signal>,
    pub(crate) nu: usize,
    pub(crate) readings: Vec<Track>,
    pub(crate) words: BTreeMap<(usize, String), usize>,
    pub(crate) warnings: Vec<Warning>,
}

impl Tracks {
    /// Puts the readings of every tag in the order of their times.
    pub(crate) fn sort(&mut self) {
        self.readings.iter_mut().for_each(Track::sort);
    }

    /// Puts values and places in the order of their times, which it gives back so.
    pub(crate) fn in_order(clock: Clock, values: &mut Vec<f64>, places: &mut Vec<Place>) -> Clock {
        let mut track = Track {
            clock,
            values: std::mem::take(values),
            places: std::mem::take(places),
        };
        track.sort();
        (*values, *places) = (track.values, track.places);
        track.clock
    }

    /// The record at another period.
    pub(crate) fn resampled(
        self,
        path: &Path,
        selection: &Selection,
        resample: Resample,
        sha256: String,
    ) -> Result<Imported, LogError> {
        let clocks = self.readings.iter().map(|track| &track.clock);
        let origin = Clock::earliest(clocks).unwrap_or(Clock::Seconds(vec![0.0]));
        let tracks = self.readings.iter();
        let times: Vec<Vec<f64>> = tracks.map(|track| track.clock.since(&origin)).collect();
        let tracks = self.readings.iter().zip(&times);
        let readings: Vec<Readings> = tracks
            .map(|(track, times_s)| Readings {
                times_s,
                values: &track.values,
            })
            .collect();
        let grid = Grid {
            path,
            selection,
            resample,
            origin,
        };
        let words = word_warnings(&self.signals, &self.words);
        let warnings = self.warnings.into_iter().chain(words).collect();
        grid.record((&self.signals, self.nu), &readings, warnings, sha256)
    }

    /// A table, where all tags have the same times.
    pub(crate) fn into_table(mut self, path: &Path) -> Result<Gathered, LogError> {
        let same = |track: &Track, first: &Track| track.clock == first.clock;
        let odd = self
            .readings
            .iter()
            .position(|track| !same(track, &self.readings[0]));
        if let Some(odd) = odd {
            let count = |index: usize| self.readings[index].values.len();
            return Err(LogError::reading(
                path,
                ReadingError::OwnTimes {
                    first: self.signals[0].name.clone(),
                    first_count: count(0),
                    other: self.signals[odd].name.clone(),
                    other_count: count(odd),
                },
            ));
        }
        let first = self.readings.first_mut();
        let (clock, places) = first.map_or((None, Vec::new()), |track| {
            let places = std::mem::take(&mut track.places);
            (Some(track.clock.clone()), places)
        });
        Ok(Gathered {
            total_rows: places.len(),
            signals: self.signals,
            nu: self.nu,
            columns: self
                .readings
                .into_iter()
                .map(|track| track.values)
                .collect(),
            clock,
            places,
            words: self.words,
            warnings: self.warnings,
        })
    }
}
