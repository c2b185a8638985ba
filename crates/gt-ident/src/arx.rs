//! Least-squares identification of ARX models (eq. 7).

use gt_core::{Dataset, DimensionError, OperatingPoint, Signal};
use nalgebra::DMatrix;

use crate::dependence::{channel_name, explain};
use crate::gram::Gram;
use crate::joint::{self, Joint};
use crate::least_squares::{CONDITION_LIMIT, LeastSquares};
use crate::model::{Fitted, check_signals};
use crate::record::{Records, Window};
use crate::tall::triangle;
use crate::{
    ArxModel, ArxRow, ArxStructure, Centre, Channel, EquationErrors, IdentError, Missing,
    Regressor, SolvedBy, Solver, Term, refine,
};

/// Rows below which a QR factorisation is quick enough.
const REFINEMENT_ROWS: usize = 2000;
/// Rows for each regressor below which the inner products of lags are no shortcut.
const REFINEMENT_ROWS_PER_REGRESSOR: usize = 20;
/// Lagged channels above which the table of their inner products is large itself.
const REFINEMENT_PRODUCTS: usize = 256;

/// An ARX model that is still to be fitted.
///
/// | Option | Default | Purpose |
/// |---|---|---|
/// | `first_row` | 0 | rows before it, in each record, are not used |
/// | `centre` | means | the operating point that is subtracted |
/// | `missing` | refuse | whether NaN breaks a record |
/// | `ridge` | 0 | weight of the penalty on scaled coefficients |
/// | `equation_errors` | uncorrelated | whether rows are estimated together |
/// | `solver` | `Qr` | how the least-squares problem may be solved |
#[derive(Debug, Clone, PartialEq)]
pub struct Arx {
    structure: ArxStructure,
    first_row: usize,
    centre: Centre,
    missing: Missing,
    ridge: f64,
    equation_errors: EquationErrors,
    solver: Solver,
}

/// A fitted model with what is known of its fit.
#[derive(Debug, Clone, PartialEq)]
pub struct ArxFit {
    /// The model.
    pub model: ArxModel,
    /// Covariance of the coefficients of each row (`terms x terms`), whose diagonal are the squares
    /// of [`ArxModel::standard_errors`].
    pub covariance: Vec<DMatrix<f64>>,
    /// How each row was solved.
    pub solved_by: Vec<SolvedBy>,
}

impl Arx {
    /// An ARX model of the given structure.
    pub fn new(structure: ArxStructure) -> Self {
        Self {
            structure,
            first_row: 0,
            centre: Centre::default(),
            missing: Missing::default(),
            ridge: 0.0,
            equation_errors: EquationErrors::default(),
            solver: Solver::default(),
        }
    }

    /// The same model fitted on the rows from `first_row` on (0-based, in each record; never below
    /// the longest lag), so that structures of different lags can share one window.
    #[must_use]
    pub fn first_row(mut self, first_row: usize) -> Self {
        self.first_row = first_row;
        self
    }

    /// The same model with another operating point than the means of the records.
    #[must_use]
    pub fn centre(mut self, centre: Centre) -> Self {
        self.centre = centre;
        self
    }

    /// The same model with another meaning of NaN.
    #[must_use]
    pub fn missing(mut self, missing: Missing) -> Self {
        self.missing = missing;
        self
    }

    /// The same model with `ridge * sum of |phi_j|^2 theta_j^2` added to the sum of squares of each
    /// row, `|phi_j|` the norm of the regressor of coefficient `theta_j`: the weight has no unit, 1
    /// holds a coefficient back as much as the record asks for it. The condition is then that of
    /// the regressors with the penalty; residual variances leave the penalty out.
    #[must_use]
    pub fn ridge(mut self, ridge: f64) -> Self {
        self.ridge = ridge;
        self
    }

    /// The same model with another assumption on the equation errors.
    #[must_use]
    pub fn equation_errors(mut self, equation_errors: EquationErrors) -> Self {
        self.equation_errors = equation_errors;
        self
    }

    /// The same model with another choice of solvers.
    #[must_use]
    pub fn solver(mut self, solver: Solver) -> Self {
        self.solver = solver;
        self
    }

    /// Fits each row by least squares.
    ///
    /// The means of the whole record are removed first, unless the centre is another, and kept as
    /// the operating point. All rows of the model use the samples `t = L..N` with `L` the longest
    /// lag of the model.
    ///
    /// # Errors
    /// As [`Arx::fit_records`].
    pub fn fit(&self, data: &Dataset) -> Result<ArxModel, IdentError> {
        self.fit_records(&[data])
    }

    /// Fits one model to several records of one plant: no regression row reaches from one record
    /// into another, the operating point is common to all.
    ///
    /// # Errors
    /// [`IdentError::NoRecords`]; records that differ in channels, units or sample time; what
    /// [`ArxStructure::validate`] refuses; [`IdentError::Ridge`], [`IdentError::JointRidge`];
    /// [`IdentError::TooFewRows`] (samples are counted as if the records were one);
    /// [`IdentError::Data`] for a sample that is not finite; [`IdentError::ConstantChannel`] for
    /// an output or a used input without variation; [`IdentError::RankDeficient`] when the
    /// condition of the column-scaled regressors exceeds [`CONDITION_LIMIT`];
    /// [`IdentError::CoefficientNotFinite`] when a coefficient overflows.
    pub fn fit_records(&self, records: &[&Dataset]) -> Result<ArxModel, IdentError> {
        self.fit_in_full(records).map(|fit| fit.model)
    }

    /// [`Arx::fit_records`] with the covariance of the coefficients.
    ///
    /// # Errors
    /// As [`Arx::fit_records`].
    pub fn fit_in_full(&self, records: &[&Dataset]) -> Result<ArxFit, IdentError> {
        let data = *records.first().ok_or(IdentError::NoRecords)?;
        let (nu, ny) = (data.nu(), data.ny());
        self.check_options(nu, ny)?;
        let total = check_alike(records)?;
        self.structure.check_rows(nu, ny, self.first_row, total)?;
        let mut found = Records::new(records, self.missing)?;
        let longest = self.structure.max_lag(nu);
        let rows_used = found.rows(longest, self.first_row);
        // Short records lose their first samples, each.
        let usable = rows_used.saturating_add(longest.max(self.first_row));
        self.structure.check_rows(nu, ny, self.first_row, usable)?;
        let regressors = (0..ny)
            .map(|output| self.structure.regressors(output, nu, ny))
            .collect::<Result<Vec<_>, _>>()?;
        found.check_vary(data.inputs(), data.outputs(), |input| {
            let uses = |each: &Regressor| each.channel == Channel::Input(input);
            regressors.iter().flatten().any(uses)
        })?;
        let point = self.point(&found, nu, ny)?;
        found.centre_at(&point);

        let mut window = Window::new(&found, longest, self.first_row);
        for input in 0..nu {
            let channel = Channel::Input(input);
            let used = regressors
                .iter()
                .flatten()
                .any(|each| each.channel == channel);
            window.uses[ny + input] = used;
        }
        let problem = Problem {
            records: found,
            window,
            rows_used,
            signals: (data.inputs(), data.outputs()),
            regressors,
        };
        let rows = match self.equation_errors {
            EquationErrors::Uncorrelated => problem.solve_rows(self.solver, self.ridge)?,
            EquationErrors::Correlated => problem.solve_jointly()?,
        };
        let mut fit = Fitted {
            inputs: data.inputs().to_vec(),
            outputs: data.outputs().to_vec(),
            sample_time_s: data.sample_time_s(),
            operating_point: point,
            structure: self.structure.clone(),
            rows: Vec::with_capacity(ny),
            rows_used,
            condition: rows.iter().map(|row| row.condition).collect(),
            standard_errors: None,
        };
        let mut errors = Vec::with_capacity(ny);
        let mut covariance = Vec::with_capacity(ny);
        let solved_by = rows.iter().map(|row| row.solved_by).collect();
        for row in rows {
            errors.push(row.covariance.diagonal().map(f64::sqrt).as_slice().to_vec());
            covariance.push(row.covariance);
            fit.rows.push(row.row);
        }
        fit.standard_errors = Some(errors);
        Ok(ArxFit {
            model: ArxModel::new(fit)?,
            covariance,
            solved_by,
        })
    }

    fn check_options(&self, nu: usize, ny: usize) -> Result<(), IdentError> {
        self.structure.validate(nu, ny)?;
        let found = self.ridge;
        if !(0.0..f64::INFINITY).contains(&found) {
            return Err(IdentError::Ridge { found });
        }
        if found > 0.0 && self.equation_errors == EquationErrors::Correlated {
            return Err(IdentError::JointRidge { found });
        }
        Ok(())
    }

    fn point(&self, records: &Records, nu: usize, ny: usize) -> Result<OperatingPoint, IdentError> {
        match &self.centre {
            Centre::Means => Ok(records.means()),
            Centre::Zero => Ok(OperatingPoint {
                u: vec![0.0; nu].into(),
                y: vec![0.0; ny].into(),
            }),
            Centre::At(point) => {
                DimensionError::check("inputs of the operating point", nu, point.u.len())?;
                DimensionError::check("outputs of the operating point", ny, point.y.len())?;
                Ok(point.clone())
            }
        }
    }
}

/// Refuses records of different plants; the number of samples of all.
fn check_alike(records: &[&Dataset]) -> Result<usize, IdentError> {
    let mut total = 0_usize;
    for data in records {
        let first = records[0];
        DimensionError::check("inputs of the record", first.nu(), data.nu())?;
        DimensionError::check("outputs of the record", first.ny(), data.ny())?;
        check_signals("input", first.inputs(), data.inputs())?;
        check_signals("output", first.outputs(), data.outputs())?;
        let (expected, found) = (first.sample_time_s(), data.sample_time_s());
        // Sample times often come from differences of time stamps.
        if (expected - found).abs() > 1e-6 * expected {
            return Err(IdentError::SampleTime { expected, found });
        }
        total = total.saturating_add(data.len());
    }
    Ok(total)
}

/// A row of a fit.
struct SolvedRow {
    row: ArxRow,
    covariance: DMatrix<f64>,
    condition: f64,
    solved_by: SolvedBy,
}

/// Records, rows and regressors of one fit.
struct Problem<'a> {
    records: Records<'a>,
    window: Window,
    rows_used: usize,
    signals: (&'a [Signal], &'a [Signal]),
    regressors: Vec<Vec<Regressor>>,
}

impl Problem<'_> {
    fn solve_rows(&self, solver: Solver, ridge: f64) -> Result<Vec<SolvedRow>, IdentError> {
        let largest = self.regressors.iter().map(Vec::len).max().unwrap_or(0);
        let products = self.records.channels() * (self.window.longest + 1);
        let quick = solver == Solver::Automatic
            && ridge <= 0.0
            && self.rows_used >= REFINEMENT_ROWS.max(REFINEMENT_ROWS_PER_REGRESSOR * largest)
            && products <= REFINEMENT_PRODUCTS;
        let gram = quick.then(|| Gram::new(&self.records, &self.window));
        let ny = self.regressors.len();
        let mut rows = Vec::with_capacity(ny);
        let mut output = 0;
        while output < ny {
            // Outputs with the same regressors share one factorisation.
            let regressors = &self.regressors[output];
            let next = (output..ny)
                .find(|&other| self.regressors[other] != *regressors)
                .unwrap_or(ny);
            let targets: Vec<_> = (output..next)
                .map(|index| Regressor {
                    channel: Channel::Output(index),
                    lag: 0,
                })
                .collect();
            let refined = gram.as_ref().and_then(|gram| {
                refine::solve(&self.records, &self.window, gram, regressors, &targets)
            });
            let (solution, solved_by) = match refined {
                Some(solution) => (solution, SolvedBy::Refinement),
                None => (self.factorise(regressors, &targets, ridge), SolvedBy::Qr),
            };
            check_solution(&self.records, self.signals, output, regressors, &solution)?;
            let unit = solution.unit_covariance(ridge);
            for column in 0..targets.len() {
                let freedom = self.rows_used - regressors.len();
                let variance = solution.squares[column] / freedom as f64;
                rows.push(self.row(
                    output + column,
                    solution.coefficients.column(column).as_slice(),
                    solution.squares[column],
                    &unit * variance,
                    (solution.condition, solved_by),
                )?);
            }
            output = next;
        }
        Ok(rows)
    }

    fn factorise(
        &self,
        regressors: &[Regressor],
        targets: &[Regressor],
        ridge: f64,
    ) -> LeastSquares {
        let columns = [regressors, targets].concat();
        let factor = triangle(&self.records, &self.window, &columns, false);
        LeastSquares::from_triangle(&factor, regressors.len(), ridge)
    }

    fn solve_jointly(&self) -> Result<Vec<SolvedRow>, IdentError> {
        let joint = match joint::solve(&self.records, &self.window, &self.regressors) {
            Ok(joint) => joint,
            Err(found) => {
                let regressors = &self.regressors[found.output];
                return Err(rank_deficient(
                    &self.records,
                    self.signals,
                    found.output,
                    regressors,
                    &found.solution,
                ));
            }
        };
        let Joint {
            coefficients,
            covariances,
            squares,
            conditions,
        } = joint;
        let t = self.rows_used as f64;
        let rows = coefficients.iter().zip(covariances).enumerate();
        rows.map(|(output, (theta, spread))| {
            let freedom = (self.rows_used - theta.len()) as f64;
            self.row(
                output,
                theta.as_slice(),
                squares[output],
                spread * (t / freedom),
                (conditions[output], SolvedBy::Joint),
            )
        })
        .collect()
    }

    /// A row in the units of the record.
    fn row(
        &self,
        output: usize,
        coefficients: &[f64],
        squares: f64,
        mut covariance: DMatrix<f64>,
        (condition, solved_by): (f64, SolvedBy),
    ) -> Result<SolvedRow, IdentError> {
        let regressors = &self.regressors[output];
        let own = self.records.scale(Channel::Output(output));
        let mut terms = Vec::with_capacity(regressors.len());
        for (index, (regressor, value)) in regressors.iter().zip(coefficients).enumerate() {
            let unit = self.records.scale(regressor.channel) / own;
            let found = value * unit;
            if !found.is_finite() {
                let output = self.signals.1[output].name.clone();
                return Err(IdentError::CoefficientNotFinite { output, found });
            }
            covariance.row_mut(index).scale_mut(unit);
            covariance.column_mut(index).scale_mut(unit);
            terms.push(Term::new(*regressor, found));
        }
        // Twice, because the square of a scale may underflow where the quotients do not.
        let residual_variance = squares / self.rows_used as f64 / own / own;
        Ok(SolvedRow {
            row: ArxRow {
                terms,
                residual_variance,
            },
            covariance,
            condition,
            solved_by,
        })
    }
}

/// Refuses a solution of too high condition, or one that overflows.
pub(crate) fn check_solution(
    records: &Records,
    signals: (&[Signal], &[Signal]),
    output: usize,
    regressors: &[Regressor],
    solution: &LeastSquares,
) -> Result<(), IdentError> {
    if !solution.full_rank() {
        return Err(rank_deficient(
            records, signals, output, regressors, solution,
        ));
    }
    let numbers = solution.coefficients.iter().chain(&solution.squares);
    if let Some(&found) = numbers.into_iter().find(|value| !value.is_finite()) {
        return Err(IdentError::CoefficientNotFinite {
            output: signals.1[output].name.clone(),
            found,
        });
    }
    Ok(())
}

/// The error that names the dependent regressor and what it depends on.
pub(crate) fn rank_deficient(
    records: &Records,
    (inputs, outputs): (&[Signal], &[Signal]),
    output: usize,
    regressors: &[Regressor],
    solution: &LeastSquares,
) -> IdentError {
    let blamed = regressors[solution.weakest()];
    IdentError::RankDeficient {
        output: outputs[output].name.clone(),
        channel: channel_name(inputs, outputs, blamed.channel).to_owned(),
        lag: blamed.lag,
        dependence: Box::new(explain(records, (inputs, outputs), regressors, solution)),
        condition: solution.condition,
        limit: CONDITION_LIMIT,
    }
}
