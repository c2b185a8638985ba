//! Records as the arguments of a call.

use std::sync::Arc;

use gtfdi::core::{Dataset, DimensionError, Signal};
use gtfdi::fdi::ResidualGenerator;
use nalgebra::DMatrix;
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

use crate::array::{Samples, samples};
use crate::dataset::{Names, PyDataset, names, signals};
use crate::error::Failure;

/// A record as it is given: `(data, None)`, `((u, y), None)` or `(u, y)`.
pub enum Given<'py> {
    /// A `Dataset`.
    Record(Arc<Dataset>),
    /// Two arrays.
    Arrays(Bound<'py, PyAny>, Bound<'py, PyAny>),
}

impl<'py> Given<'py> {
    /// Sorts the arguments `u` and `y` of a call.
    pub fn new(u: &Bound<'py, PyAny>, y: Option<&Bound<'py, PyAny>>) -> Result<Self, Failure> {
        if let Some(y) = y {
            return Ok(Self::Arrays(u.clone(), y.clone()));
        }
        if let Ok(data) = u.cast::<PyDataset>() {
            return Ok(Self::Record(Arc::clone(&data.get().inner)));
        }
        match u.cast::<PyTuple>() {
            Ok(pair) if pair.len() == 2 => Ok(Self::Arrays(pair.get_item(0)?, pair.get_item(1)?)),
            _ => Err(Failure::Option {
                option: "y",
                expected: "a Dataset, a tuple (u, y), or both u and y".to_owned(),
                found: format!("{} alone", u.get_type().name()?),
            }),
        }
    }

    /// The record for something that finds its channels in a `Dataset` by itself, which then goes there
    /// as it is; arrays have the channels of these tags.
    pub fn by_name(
        self,
        inputs: &[String],
        outputs: &[String],
        sample_time_s: f64,
    ) -> Result<Arc<Dataset>, Failure> {
        match self {
            Self::Record(data) => Ok(data),
            arrays @ Self::Arrays(..) => arrays.known(
                &Signal::named(inputs),
                &Signal::named(outputs),
                sample_time_s,
            ),
        }
    }

    /// The record for something that knows its channels. A `Dataset` is looked through by name.
    pub fn known(
        self,
        inputs: &[Signal],
        outputs: &[Signal],
        sample_time_s: f64,
    ) -> Result<Arc<Dataset>, Failure> {
        match self {
            Self::Record(data) => {
                if data.inputs() == inputs && data.outputs() == outputs {
                    return Ok(data);
                }
                Ok(Arc::new(data.select(&names(inputs), &names(outputs))?))
            }
            Self::Arrays(u, y) => {
                let (u, y) = (samples(&u, "u")?, samples(&y, "y")?);
                let (inputs, outputs) = (inputs.to_vec(), outputs.to_vec());
                Ok(Arc::new(Dataset::new(
                    inputs,
                    outputs,
                    u,
                    y,
                    sample_time_s,
                )?))
            }
        }
    }

    /// What a generator makes of the record: arrays are read where they are.
    pub fn residuals(
        self,
        py: Python<'_>,
        generator: &ResidualGenerator,
    ) -> Result<DMatrix<f64>, Failure> {
        let (u, y) = match self {
            Self::Arrays(u, y) => (Samples::new(&u, "u")?, Samples::new(&y, "y")?),
            record @ Self::Record(_) => {
                let model = generator.model();
                let data = record.known(model.inputs(), model.outputs(), model.sample_time_s())?;
                return Ok(py.detach(|| generator.residuals(&data))?);
            }
        };
        let model = generator.model();
        DimensionError::check("rows of u (inputs)", model.nu(), u.channels())?;
        DimensionError::check("rows of y (outputs)", model.ny(), y.channels())?;
        DimensionError::check("columns of y (samples)", u.count(), y.count())?;
        let (u, y) = (u.values()?, y.values()?);
        Ok(py.detach(|| generator.residuals_of(u, y))?)
    }

    /// The record for something that takes its channels from it: a `Dataset` is narrowed to the
    /// named channels, arrays are given the names.
    pub fn unknown(
        self,
        inputs: Option<Names>,
        outputs: Option<Names>,
        sample_time_s: Option<f64>,
    ) -> Result<Arc<Dataset>, Failure> {
        match (self, sample_time_s) {
            (Self::Record(_), Some(found)) => Err(Failure::Option {
                option: "sample_time_s",
                expected: "none with a Dataset, which has its own".to_owned(),
                found: found.to_string(),
            }),
            (Self::Record(data), None) => {
                if inputs.is_none() && outputs.is_none() {
                    return Ok(data);
                }
                let inputs = inputs.map_or_else(|| names(data.inputs()), Into::into);
                let outputs = outputs.map_or_else(|| names(data.outputs()), Into::into);
                Ok(Arc::new(data.select(&inputs, &outputs)?))
            }
            (Self::Arrays(u, y), sample_time_s) => {
                let (u, y) = (samples(&u, "u")?, samples(&y, "y")?);
                let inputs = signals(inputs, None, 'u', u.nrows())?;
                let outputs = signals(outputs, None, 'y', y.nrows())?;
                Ok(Arc::new(Dataset::new(
                    inputs,
                    outputs,
                    u,
                    y,
                    sample_time_s.unwrap_or(1.0),
                )?))
            }
        }
    }
}

/// One record or several: a list without `y` holds records, each a `Dataset` or a tuple `(u, y)`.
pub fn unknown_records(
    u: &Bound<'_, PyAny>,
    y: Option<&Bound<'_, PyAny>>,
    inputs: Option<&Names>,
    outputs: Option<&Names>,
    sample_time_s: Option<f64>,
) -> Result<Vec<Arc<Dataset>>, Failure> {
    let given = match (u.cast::<PyList>(), y) {
        (Ok(list), None) => list
            .iter()
            .map(|record| Given::new(&record, None))
            .collect::<Result<Vec<_>, Failure>>()?,
        _ => vec![Given::new(u, y)?],
    };
    given
        .into_iter()
        .map(|record| record.unknown(inputs.cloned(), outputs.cloned(), sample_time_s))
        .collect()
}

/// Records as a fit takes them.
pub fn borrowed(records: &[Arc<Dataset>]) -> Vec<&Dataset> {
    records.iter().map(AsRef::as_ref).collect()
}
