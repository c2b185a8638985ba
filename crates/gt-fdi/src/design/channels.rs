//! Channels of a record by name.

use std::collections::HashSet;

use gt_core::{Dataset, Signal};

use crate::FdiError;
use crate::runtime::Rows;

/// Relative difference up to which two sample times count as one: a sample in a million.
const SAMPLE_TIME_TOLERANCE: f64 = 1e-6;

/// Samples that are copied at once where channels do not lie as asked for.
const COPIED: usize = 256;

/// The rows of a record that hold some inputs and outputs, in the order asked for, and room for
/// copies of their samples. Either may come from either side of the record.
pub(super) struct Channels<'a> {
    data: &'a Dataset,
    inputs: Vec<usize>,
    outputs: Vec<usize>,
    u: Vec<f64>,
    y: Vec<f64>,
    /// Rows of the first input and of the first output, where the others follow in their order on
    /// the same side of the record: then nothing needs copying.
    firsts: Option<(usize, usize)>,
    /// Inputs and outputs of several samples.
    copied: (Vec<f64>, Vec<f64>),
}

impl<'a> Channels<'a> {
    /// Finds the channels, checking the sample time.
    pub(super) fn of<S: AsRef<str>, T: AsRef<str>>(
        data: &'a Dataset,
        sample_time_s: f64,
        inputs: &[S],
        outputs: &[T],
    ) -> Result<Self, FdiError> {
        check_sample_time("the record", sample_time_s, data.sample_time_s())?;
        let names = || {
            data.inputs()
                .iter()
                .chain(data.outputs())
                .map(|signal| &signal.name)
        };
        let mut missing: Vec<String> = Vec::new();
        let mut find = |tag: &str| {
            let found = names().position(|name| name == tag);
            if found.is_none() && !missing.iter().any(|name| name == tag) {
                missing.push(tag.to_owned());
            }
            found
        };
        let input_rows: Vec<usize> = inputs.iter().filter_map(|tag| find(tag.as_ref())).collect();
        let output_rows: Vec<usize> = outputs
            .iter()
            .filter_map(|tag| find(tag.as_ref()))
            .collect();
        if !missing.is_empty() {
            return Err(FdiError::MissingTags {
                missing,
                available: names().cloned().collect(),
            });
        }
        let (u, y) = (vec![0.0; input_rows.len()], vec![0.0; output_rows.len()]);
        let nu = data.nu();
        let firsts = first(&input_rows, 0..nu).zip(first(&output_rows, nu..nu + data.ny()));
        let firsts = firsts.map(|(input, output)| (input, output - nu));
        Ok(Self {
            data,
            inputs: input_rows,
            outputs: output_rows,
            u,
            y,
            firsts,
            copied: Default::default(),
        })
    }

    /// Inputs and outputs of one sample.
    #[inline(always)]
    pub(super) fn at(&mut self, sample: usize) -> (&[f64], &[f64]) {
        let nu = self.data.nu();
        if let Some((first_input, first_output)) = self.firsts {
            let (u, y) = (self.data.u().as_slice(), self.data.y().as_slice());
            let input = sample * nu + first_input;
            let output = sample * self.data.ny() + first_output;
            let own = (
                u.get(input..input + self.inputs.len()),
                y.get(output..output + self.outputs.len()),
            );
            if let (Some(u), Some(y)) = own {
                return (u, y);
            }
        }
        let value = |row: usize| {
            if row < nu {
                self.data.u()[(row, sample)]
            } else {
                self.data.y()[(row - nu, sample)]
            }
        };
        for (value_of, &row) in self.u.iter_mut().zip(&self.inputs) {
            *value_of = value(row);
        }
        for (value_of, &row) in self.y.iter_mut().zip(&self.outputs) {
            *value_of = value(row);
        }
        (&self.u, &self.y)
    }
}

/// Samples of some channels as they lie in memory.
pub(super) struct Stretch<'a> {
    pub(super) u: Rows<'a>,
    pub(super) y: Rows<'a>,
    /// How many they are.
    pub(super) len: usize,
}

impl Channels<'_> {
    /// The samples from `begin` on: all where the channels lie in the record as asked for, else
    /// copies of the next few.
    pub(super) fn stretch(&mut self, begin: usize) -> Stretch<'_> {
        let left = self.data.len().saturating_sub(begin);
        if let Some((input, output)) = self.firsts {
            let (nu, ny) = (self.data.nu(), self.data.ny());
            let (u, y) = (self.data.u().as_slice(), self.data.y().as_slice());
            let u = u.get(begin * nu + input..).unwrap_or(&[]);
            let y = y.get(begin * ny + output..).unwrap_or(&[]);
            let (u, y) = (Rows::new(u, nu), Rows::new(y, ny));
            return Stretch { u, y, len: left };
        }
        let len = left.min(COPIED);
        let (mut copied_u, mut copied_y) = core::mem::take(&mut self.copied);
        copied_u.clear();
        copied_y.clear();
        for sample in begin..begin + len {
            let (u, y) = self.at(sample);
            copied_u.extend_from_slice(u);
            copied_y.extend_from_slice(y);
        }
        self.copied = (copied_u, copied_y);
        let u = Rows::new(&self.copied.0, self.inputs.len());
        let y = Rows::new(&self.copied.1, self.outputs.len());
        Stretch { u, y, len }
    }
}

/// The tags of signals.
pub(super) fn names(signals: &[Signal]) -> Vec<String> {
    signals.iter().map(|signal| signal.name.clone()).collect()
}

/// The first of `rows` where they follow each other within `side`.
fn first(rows: &[usize], side: std::ops::Range<usize>) -> Option<usize> {
    let first = rows.first().copied().unwrap_or(side.start);
    let mut pairs = rows.iter().zip(first..);
    pairs
        .all(|(&row, expected)| row == expected && side.contains(&row))
        .then_some(first)
}

/// Refuses two sample times that differ by more than rounding.
pub(super) fn check_sample_time(what: &str, expected_s: f64, found_s: f64) -> Result<(), FdiError> {
    if (found_s - expected_s).abs() <= SAMPLE_TIME_TOLERANCE * expected_s {
        Ok(())
    } else {
        Err(FdiError::SampleTime {
            what: what.to_owned(),
            expected_s,
            found_s,
        })
    }
}

/// Refuses a tag that appears twice.
pub(super) fn check_unique(place: &'static str, tags: &[&String]) -> Result<(), FdiError> {
    let mut seen = HashSet::new();
    match tags.iter().find(|tag| !seen.insert(tag.as_str())) {
        Some(&tag) => Err(FdiError::DuplicateTag {
            place,
            tag: tag.clone(),
        }),
        None => Ok(()),
    }
}
