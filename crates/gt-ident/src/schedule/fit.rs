//! Identification of local models along a scheduling channel.

use gt_core::{Dataset, OperatingPoint, index_of};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::membership::Memberships;
use super::model::{SchedulePoint, ScheduledModel, check_values};
use crate::least_squares::{CONDITION_LIMIT, LeastSquares};
use crate::model::{Fitted, check_signals};
use crate::regressor::Deviations;
use crate::{ArxModel, ArxRow, ArxStructure, Channel, IdentError, Regressor, Term};

/// How the points share the samples between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Estimation {
    /// Each point alone, on samples weighted by its membership: robust, and each model is the best
    /// linear one around its point; where coefficients change, the ends of the range are pulled
    /// inwards.
    #[default]
    Local,
    /// All points at once on the error of the blended equation: exact where the coefficients are
    /// linear in the load between points, and needs samples between them.
    Joint,
}

/// Local models that are still to be fitted.
///
/// | Name | Default | Purpose | Range |
/// |---|---|---|---|
/// | `channel` | none | the scheduling channel, an input; `nb = 0` leaves it out of the equations | a name |
/// | `values` | none | the operating points, in the channel's unit | ascending |
/// | `width` | 1 | part of the way between points that hands over | 0..=1 |
/// | `estimation` | local | how points share samples | [`Estimation`] |
#[derive(Debug, Clone, PartialEq)]
pub struct ScheduledArx {
    structure: ArxStructure,
    channel: String,
    values: Vec<f64>,
    width: f64,
    estimation: Estimation,
}

impl ScheduledArx {
    /// One model of `structure` at each value of `channel`.
    pub fn new(structure: ArxStructure, channel: impl Into<String>, values: Vec<f64>) -> Self {
        Self {
            structure,
            channel: channel.into(),
            values,
            width: 1.0,
            estimation: Estimation::Local,
        }
    }

    /// The same with another width of the hand-over.
    #[must_use]
    pub fn width(mut self, width: f64) -> Self {
        self.width = width;
        self
    }

    /// The same with another way to share samples.
    #[must_use]
    pub fn estimation(mut self, estimation: Estimation) -> Self {
        self.estimation = estimation;
        self
    }

    /// Fits all points to the records; no regression row reaches from one record into another.
    ///
    /// Each equation has a constant of its own, which becomes the output's operating point: the
    /// equilibrium of the local model at the weighted mean of the inputs.
    ///
    /// # Errors
    /// What [`ScheduledModel::new`] and [`ArxStructure::validate`] refuse;
    /// [`IdentError::NoRecords`]; records that differ in channels or sample time, or are too short;
    /// [`IdentError::SchedulePoint`] for a point without samples enough;
    /// [`IdentError::RankDeficient`] and [`IdentError::CoefficientNotFinite`] as in
    /// [`crate::Arx::fit`]; [`IdentError::NoEquilibrium`] for a local model with a pole at 1.
    pub fn fit(&self, records: &[Dataset]) -> Result<ScheduledModel, IdentError> {
        check_values(self.values.clone(), self.width)?;
        let stacked = Stacked::new(self, records)?;
        let first = &records[0];
        let (points, p) = (self.values.len(), stacked.largest_row() + 1);
        for (point, weights) in stacked.weights.column_iter().enumerate() {
            let found = weights.iter().filter(|&&weight| weight > 0.0).count();
            if found < p + 1 {
                return Err(IdentError::SchedulePoint {
                    channel: self.channel.clone(),
                    value: self.values[point],
                    needed: p + 1,
                    found,
                });
            }
        }
        let (nu, ny) = (first.nu(), first.ny());
        // Per point: rows, constants, conditions.
        let mut locals = vec![(Vec::new(), DVector::zeros(ny), Vec::new()); points];
        for output in 0..ny {
            let regressors = self.structure.regressors(output, nu, ny)?;
            let solutions = stacked.solve(self.estimation, output, first, &regressors)?;
            for (local, solution) in locals.iter_mut().zip(solutions) {
                local.0.push(solution.row);
                local.1[output] = solution.constant;
                local.2.push(solution.condition);
            }
        }
        let models =
            (locals.into_iter().enumerate()).map(|(point, (rows, constants, condition))| {
                let value = self.values[point];
                let operating_point = stacked
                    .equilibrium(point, &rows, &constants)
                    .ok_or(IdentError::NoEquilibrium { value })?;
                let model = ArxModel::new(Fitted {
                    inputs: first.inputs().to_vec(),
                    outputs: first.outputs().to_vec(),
                    sample_time_s: first.sample_time_s(),
                    operating_point,
                    structure: self.structure.clone(),
                    rows,
                    rows_used: (stacked.weights.column(point).iter())
                        .filter(|&&weight| weight > 0.0)
                        .count(),
                    condition,
                })?;
                Ok(SchedulePoint { value, model })
            });
        let models = models.collect::<Result<Vec<_>, IdentError>>()?;
        ScheduledModel::new(self.channel.clone(), models, self.width)
    }
}

/// All regression rows of all records.
struct Stacked {
    /// Deviations of each record from the mean of all.
    records: Vec<Deviations>,
    reference: OperatingPoint,
    regressors: Vec<Vec<Regressor>>,
    first_row: usize,
    /// `rows x points`.
    weights: DMatrix<f64>,
    /// `rows x nu`, deviations.
    u: DMatrix<f64>,
}

/// One row at one point.
struct Solution {
    row: ArxRow,
    constant: f64,
    condition: f64,
}

impl Stacked {
    fn new(options: &ScheduledArx, records: &[Dataset]) -> Result<Self, IdentError> {
        let first = records.first().ok_or(IdentError::NoRecords)?;
        let (nu, ny) = (first.nu(), first.ny());
        options.structure.validate(nu, ny)?;
        let schedule = index_of(first.inputs(), &options.channel)?;
        let first_row = options.structure.max_lag(nu);
        for data in records {
            gt_core::DimensionError::check("inputs of the record", nu, data.nu())?;
            gt_core::DimensionError::check("outputs of the record", ny, data.ny())?;
            check_signals("input", first.inputs(), data.inputs())?;
            check_signals("output", first.outputs(), data.outputs())?;
            let (expected, found) = (first.sample_time_s(), data.sample_time_s());
            if (expected - found).abs() > 1e-6 * expected {
                return Err(IdentError::SampleTime { expected, found });
            }
            options
                .structure
                .check_rows(nu, ny, first_row, data.len())?;
        }
        let total: f64 = records.iter().map(|data| data.len() as f64).sum();
        let mut reference = OperatingPoint::zero(nu, ny);
        for data in records {
            let (mean, share) = (data.mean(), data.len() as f64 / total);
            reference.u += mean.u * share;
            reference.y += mean.y * share;
        }
        let rows = || {
            records
                .iter()
                .flat_map(|data| (first_row..data.len()).map(move |t| (data, t)))
        };
        let memberships = Memberships::new(options.values.clone(), options.width);
        let count = rows().count();
        let mut weights = DMatrix::zeros(count, options.values.len());
        let mut u = DMatrix::zeros(count, nu);
        for (index, (data, t)) in rows().enumerate() {
            let value = data.u()[(schedule, t)];
            for point in 0..options.values.len() {
                weights[(index, point)] = memberships.of(point, value);
            }
            u.set_row(index, &(data.u().column(t) - &reference.u).transpose());
        }
        Ok(Self {
            records: records
                .iter()
                .map(|data| Deviations::new(data, &reference))
                .collect::<Result<_, _>>()?,
            reference,
            regressors: (0..ny)
                .map(|output| options.structure.regressors(output, nu, ny))
                .collect::<Result<_, _>>()?,
            first_row,
            weights,
            u,
        })
    }

    fn largest_row(&self) -> usize {
        self.regressors.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// The regressors of all records below each other.
    fn design(&self, regressors: &[Regressor]) -> DMatrix<f64> {
        let mut design = DMatrix::zeros(self.weights.nrows(), regressors.len());
        let mut start = 0;
        for record in &self.records {
            let part = record.design(regressors, &(self.first_row..record.y.nrows()));
            design.rows_mut(start, part.nrows()).copy_from(&part);
            start += part.nrows();
        }
        design
    }

    /// The row of `output` at each point.
    fn solve(
        &self,
        estimation: Estimation,
        output: usize,
        names: &Dataset,
        regressors: &[Regressor],
    ) -> Result<Vec<Solution>, IdentError> {
        let own = Regressor {
            channel: Channel::Output(output),
            lag: 0,
        };
        let design = self.design(regressors).insert_column(regressors.len(), 1.0);
        let target = self.design(&[own]);
        let (p, points) = (design.ncols(), self.weights.ncols());
        let check = |solution: &LeastSquares| check(names, output, regressors, solution);
        let mut coefficients = DMatrix::zeros(p, points);
        let mut conditions = vec![0.0; points];
        match estimation {
            Estimation::Local => {
                for (point, weights) in self.weights.column_iter().enumerate() {
                    // Samples of other points would be rows of zeros.
                    let own: Vec<usize> = (0..weights.len())
                        .filter(|&row| weights[row] > 0.0)
                        .collect();
                    let pick = |matrix: &DMatrix<f64>| {
                        DMatrix::from_fn(own.len(), matrix.ncols(), |row, column| {
                            matrix[(own[row], column)] * weights[own[row]].sqrt()
                        })
                    };
                    let solution = LeastSquares::new(&pick(&design), &pick(&target));
                    check(&solution)?;
                    coefficients.set_column(point, &solution.coefficients.column(0));
                    conditions[point] = solution.condition;
                }
            }
            Estimation::Joint => {
                let blended = DMatrix::from_fn(design.nrows(), p * points, |row, column| {
                    design[(row, column % p)] * self.weights[(row, column / p)]
                });
                let solution = LeastSquares::new(&blended, &target);
                check(&solution)?;
                let flat = solution.coefficients.as_slice();
                coefficients.as_mut_slice().copy_from_slice(flat);
                conditions.fill(solution.condition);
            }
        }
        let errors = DMatrix::from_fn(design.nrows(), points, |row, point| {
            target[row] - design.row(row).transpose().dot(&coefficients.column(point))
        });
        let solutions = (0..points).map(|point| {
            let (weights, column) = (self.weights.column(point), coefficients.column(point));
            let squares = errors.column(point).map(|error| error * error);
            Solution {
                row: ArxRow {
                    terms: (regressors.iter().zip(column.iter()))
                        .map(|(regressor, &value)| Term::new(*regressor, value))
                        .collect(),
                    residual_variance: squares.dot(&weights) / weights.sum(),
                },
                constant: column[p - 1],
                condition: conditions[point],
            }
        });
        Ok(solutions.collect())
    }

    /// The operating point at which the equations of a point, constants included, are at rest with
    /// the weighted mean of the inputs. `None` where there is no such point.
    fn equilibrium(
        &self,
        point: usize,
        rows: &[ArxRow],
        constants: &DVector<f64>,
    ) -> Option<OperatingPoint> {
        let weights = self.weights.column(point);
        let u = self.u.tr_mul(&weights) / weights.sum();
        let mut system = DMatrix::identity(rows.len(), rows.len());
        let mut right = constants.clone();
        for (output, row) in rows.iter().enumerate() {
            for term in &row.terms {
                match term.channel {
                    Channel::Output(other) => system[(output, other)] -= term.coefficient,
                    Channel::Input(input) => right[output] += term.coefficient * u[input],
                }
            }
        }
        let y = system.lu().solve(&right)?;
        y.iter()
            .all(|value| value.is_finite())
            .then(|| OperatingPoint {
                u: u + &self.reference.u,
                y: y + &self.reference.y,
            })
    }
}

fn check(
    names: &Dataset,
    output: usize,
    regressors: &[Regressor],
    solution: &LeastSquares,
) -> Result<(), IdentError> {
    let name = names.outputs()[output].name.clone();
    if !solution.full_rank() {
        // A column per regressor and one for the constant, point after point.
        let blamed = regressors.get(solution.weakest % (regressors.len() + 1));
        let (channel, lag) = match blamed.map(|regressor| (regressor.channel, regressor.lag)) {
            Some((Channel::Output(index), lag)) => (names.outputs()[index].name.clone(), lag),
            Some((Channel::Input(index), lag)) => (names.inputs()[index].name.clone(), lag),
            None => ("constant".to_owned(), 0),
        };
        return Err(IdentError::RankDeficient {
            output: name,
            channel,
            lag,
            condition: solution.condition,
            limit: CONDITION_LIMIT,
        });
    }
    let numbers = solution.coefficients.iter().chain(&solution.residuals);
    if let Some(&found) = numbers.into_iter().find(|value| !value.is_finite()) {
        return Err(IdentError::CoefficientNotFinite {
            output: name,
            found,
        });
    }
    Ok(())
}
