//! One-step-ahead prediction and free run of scheduled models.

use gt_core::{Dataset, index_of};
use nalgebra::DMatrix;

use super::membership::Pair;
use super::model::ScheduledModel;
use crate::free_run::{contribution, divergence_limit};
use crate::regressor::Deviations;
use crate::{Channel, FreeRun, IdentError};

/// A record in deviations from the first point's operating point, and what the points make of it.
struct Blend<'a> {
    model: &'a ScheduledModel,
    record: Deviations,
    /// `points x outputs`: what a point's row adds for having another operating point.
    offsets: DMatrix<f64>,
    /// The points that take part, sample by sample.
    pairs: Vec<Pair>,
}

impl<'a> Blend<'a> {
    fn new(model: &'a ScheduledModel, data: &Dataset) -> Result<Self, IdentError> {
        let first = &model.points()[0].model;
        first.check_record(data)?;
        let needed = model.max_lag().saturating_add(1);
        if data.len() < needed {
            return Err(IdentError::TooFewRows {
                structure: first.structure().to_string(),
                needed,
                found: data.len(),
            });
        }
        let reference = first.operating_point();
        let offsets = DMatrix::from_fn(model.points().len(), data.ny(), |point, output| {
            let local = &model.points()[point].model;
            let (u, y) = (
                &local.operating_point().u - &reference.u,
                &local.operating_point().y - &reference.y,
            );
            let explained: f64 = (local.rows()[output].terms.iter())
                .map(|term| {
                    term.coefficient
                        * match term.channel {
                            Channel::Output(index) => y[index],
                            Channel::Input(index) => u[index],
                        }
                })
                .sum();
            y[output] - explained
        });
        let record = Deviations::new(data, reference)?;
        let schedule = index_of(data.inputs(), model.channel())?;
        let memberships = model.memberships();
        let pairs = (data.u().row(schedule).iter())
            .map(|&value| memberships.at(value))
            .collect();
        Ok(Self {
            model,
            record,
            offsets,
            pairs,
        })
    }

    /// The blended equation of `output` at `t` on the outputs `y` (`N x ny`).
    fn value(&self, output: usize, y: &DMatrix<f64>, t: usize) -> f64 {
        let taking_part = self.pairs[t].iter().filter(|(_, weight)| *weight > 0.0);
        taking_part
            .map(|&(point, weight)| {
                let row = &self.model.points()[point].model.rows()[output];
                let terms = row.terms.iter();
                let sum: f64 = terms
                    .map(|term| contribution(term, y, &self.record.u, t))
                    .sum();
                weight * (self.offsets[(point, output)] + sum)
            })
            .sum()
    }

    /// `N x ny` deviations back in the record's units, channels in rows.
    fn restored(&self, y: &DMatrix<f64>) -> DMatrix<f64> {
        let mut y = y.transpose();
        for mut column in y.column_iter_mut() {
            column += &self.model.points()[0].model.operating_point().y;
        }
        y
    }
}

impl ScheduledModel {
    /// The outputs predicted one step ahead (`ny x N`, in the record's units); the first `max_lag`
    /// columns are NaN. Another output at lag 0 is its own prediction, as in
    /// [`crate::ArxModel::predict`].
    ///
    /// # Errors
    /// As [`crate::ArxModel::predict`].
    pub fn predict(&self, data: &Dataset) -> Result<DMatrix<f64>, IdentError> {
        let blend = Blend::new(self, data)?;
        let (samples, ny) = blend.record.y.shape();
        let mut predicted = DMatrix::from_element(samples, ny, f64::NAN);
        let mut y = blend.record.y.clone();
        for t in self.max_lag()..samples {
            for output in 0..ny {
                y[(t, output)] = blend.value(output, &y, t);
            }
            for output in 0..ny {
                predicted[(t, output)] = y[(t, output)];
                y[(t, output)] = blend.record.y[(t, output)];
            }
        }
        Ok(blend.restored(&predicted))
    }

    /// The outputs of a free run over the record's inputs, started from its first `max_lag`
    /// measured outputs; the conventions are those of [`FreeRun`], with the first point's
    /// operating point.
    ///
    /// # Errors
    /// As [`crate::ArxModel::predict`].
    pub fn simulate(&self, data: &Dataset) -> Result<FreeRun, IdentError> {
        let blend = Blend::new(self, data)?;
        let (samples, ny) = blend.record.y.shape();
        let limits: Vec<f64> = (blend.record.y.column_iter())
            .map(|y| divergence_limit(y.iter()))
            .collect();
        let mut y = blend.record.y.clone();
        let mut diverges_at = vec![None; ny];
        for t in self.max_lag()..samples {
            for output in 0..ny {
                let value = blend.value(output, &y, t);
                if diverges_at[output].is_none() && value.abs() <= limits[output] {
                    y[(t, output)] = value;
                } else {
                    y[(t, output)] = f64::NAN;
                    diverges_at[output].get_or_insert(t);
                }
            }
        }
        let mut y = blend.restored(&y);
        y.columns_mut(0, self.max_lag())
            .copy_from(&data.y().columns(0, self.max_lag()));
        Ok(FreeRun { y, diverges_at })
    }
}
