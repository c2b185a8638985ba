//! The regression rows of several records along a load.

use gt_core::{Dataset, DimensionError, OperatingPoint, index_of};
use nalgebra::{DMatrix, DVector};

use super::fit::{Estimation, ScheduledArx};
use super::membership::Memberships;
use crate::least_squares::{CONDITION_LIMIT, LeastSquares};
use crate::model::check_signals;
use crate::regressor::Deviations;
use crate::{ArxRow, Channel, Dependence, IdentError, Regressor, Term};

/// All regression rows of all records.
pub(super) struct Stacked {
    /// Deviations of each record from the mean of all.
    records: Vec<Deviations>,
    reference: OperatingPoint,
    first_row: usize,
    /// `rows x points`.
    weights: DMatrix<f64>,
    /// `rows x nu`, deviations.
    u: DMatrix<f64>,
    /// Position of the scheduling channel among the inputs.
    schedule: usize,
}

/// One row at one point.
pub(super) struct Solution {
    pub row: ArxRow,
    pub constant: f64,
    pub condition: f64,
}

impl Stacked {
    pub fn new(options: &ScheduledArx, records: &[Dataset]) -> Result<Self, IdentError> {
        let first = records.first().ok_or(IdentError::NoRecords)?;
        let (nu, ny) = (first.nu(), first.ny());
        options.structure.validate(nu, ny)?;
        let schedule = index_of(first.inputs(), &options.channel)?;
        let first_row = options.structure.max_lag(nu);
        for data in records {
            DimensionError::check("inputs of the record", nu, data.nu())?;
            DimensionError::check("outputs of the record", ny, data.ny())?;
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
            first_row,
            weights,
            u,
            schedule,
        })
    }

    /// The rows that belong to a point.
    pub fn around(&self, point: usize) -> Vec<usize> {
        let weights = self.weights.column(point);
        (0..weights.len())
            .filter(|&row| weights[row] > 0.0)
            .collect()
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
    pub fn solve(
        &self,
        options: &ScheduledArx,
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
        let mut coefficients = DMatrix::zeros(p, points);
        let mut conditions = vec![0.0; points];
        match options.estimation {
            Estimation::Local => {
                for (point, condition) in conditions.iter_mut().enumerate() {
                    let around = self.around(point);
                    let local = self.local(options, point, &around, regressors, &design);
                    let (needed, found) = (local.ncols() + 1, around.len());
                    if found < needed {
                        return Err(IdentError::SchedulePoint {
                            channel: options.channel.clone(),
                            value: options.values[point],
                            needed,
                            found,
                        });
                    }
                    let right = self.weighted(point, &around, &target);
                    let solution = LeastSquares::new(&local, &right);
                    check(names, output, regressors, &solution)?;
                    coefficients.set_column(point, &solution.coefficients.rows(0, p).column(0));
                    *condition = solution.condition;
                }
            }
            Estimation::Joint => {
                let (needed, found) = (p * points + 1, design.nrows());
                if found < needed {
                    return Err(IdentError::TooFewRows {
                        structure: options.structure.to_string(),
                        needed: needed + self.first_row,
                        found: found + self.first_row,
                    });
                }
                let blended = DMatrix::from_fn(found, p * points, |row, column| {
                    design[(row, column % p)] * self.weights[(row, column / p)]
                });
                let solution = LeastSquares::new(&blended, &target);
                check(names, output, regressors, &solution)?;
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

    /// The design of a point: weighted rows around it and, where the load varies there, the same
    /// columns times the load's distance from the point. The load stands for the constant's slope
    /// itself where it is a regressor.
    fn local(
        &self,
        options: &ScheduledArx,
        point: usize,
        around: &[usize],
        regressors: &[Regressor],
        design: &DMatrix<f64>,
    ) -> DMatrix<f64> {
        let plain = self.weighted(point, around, design);
        let at = options.values[point] - self.reference.u[self.schedule];
        let distance = |row: usize| self.u[(row, self.schedule)] - at;
        let (low, high) = around
            .iter()
            .map(|&row| distance(row))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x), high.max(x))
            });
        let size = at.abs().max(options.values[point].abs());
        if high.is_nan() || high - low <= 1e-9 * size.max(high.abs()).max(low.abs()) {
            return plain;
        }
        let channel = Channel::Input(self.schedule);
        let regressed = regressors.iter().any(|known| known.channel == channel);
        let (p, slopes) = (plain.ncols(), plain.ncols() - usize::from(regressed));
        let width = low.abs().max(high.abs());
        DMatrix::from_fn(plain.nrows(), p + slopes, |row, column| {
            if column < p {
                plain[(row, column)]
            } else {
                plain[(row, column - p)] * distance(around[row]) / width
            }
        })
    }

    /// Rows of `matrix`, each times the root of its weight.
    fn weighted(&self, point: usize, rows: &[usize], matrix: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(rows.len(), matrix.ncols(), |row, column| {
            matrix[(rows[row], column)] * self.weights[(rows[row], point)].sqrt()
        })
    }

    /// The operating point at which the equations of a point, constants included, are at rest with
    /// the weighted mean of the inputs. `None` where there is no such point.
    pub fn equilibrium(
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
        let blamed = regressors.get(solution.weakest() % (regressors.len() + 1));
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
            dependence: Box::new(Dependence::Unclear),
        });
    }
    let numbers = solution.coefficients.iter().chain(&solution.squares);
    if let Some(&found) = numbers.into_iter().find(|value| !value.is_finite()) {
        return Err(IdentError::CoefficientNotFinite {
            output: name,
            found,
        });
    }
    Ok(())
}
