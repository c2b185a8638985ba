//! Least-squares identification of ARX models (eq. 7).

use gt_core::Dataset;

use crate::least_squares::{CONDITION_LIMIT, LeastSquares};
use crate::model::Fitted;
use crate::regressor::{Deviations, check_varies};
use crate::{ArxModel, ArxRow, ArxStructure, Channel, IdentError, Regressor, Term};

/// An ARX model that is still to be fitted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Arx {
    structure: ArxStructure,
    first_row: usize,
}

impl Arx {
    /// An ARX model of the given structure.
    pub fn new(structure: ArxStructure) -> Self {
        Self {
            structure,
            first_row: 0,
        }
    }

    /// The same model fitted on the rows from `first_row` on (0-based; never below the longest
    /// lag), so that structures of different lags can share one window.
    #[must_use]
    pub fn first_row(mut self, first_row: usize) -> Self {
        self.first_row = first_row;
        self
    }

    /// Fits each row by ordinary least squares, without regularisation.
    ///
    /// The means of the whole record are removed first and kept as the operating point. All rows
    /// of the model use the samples `t = L..N` with `L` the longest lag of the model.
    ///
    /// # Errors
    /// What [`ArxStructure::validate`] refuses; [`IdentError::TooFewRows`];
    /// [`IdentError::Data`] for a sample that is not finite; [`IdentError::ConstantChannel`] for
    /// an output or a used input without variation; [`IdentError::RankDeficient`] when the
    /// condition of the column-scaled regressors exceeds [`CONDITION_LIMIT`];
    /// [`IdentError::CoefficientNotFinite`] when a coefficient overflows.
    pub fn fit(&self, data: &Dataset) -> Result<ArxModel, IdentError> {
        let (nu, ny) = (data.nu(), data.ny());
        self.structure.validate(nu, ny)?;
        self.structure
            .check_rows(nu, ny, self.first_row, data.len())?;
        data.check_finite()?;
        let regressors = (0..ny)
            .map(|output| self.structure.regressors(output, nu, ny))
            .collect::<Result<Vec<_>, _>>()?;
        check_channels(data, &regressors)?;

        let point = data.mean();
        let record = Deviations::new(data, &point)?;
        let rows = self.structure.max_lag(nu).max(self.first_row)..data.len();
        let mut fitted_rows = Vec::with_capacity(ny);
        let mut conditions = Vec::with_capacity(ny);
        let mut output = 0;
        while output < ny {
            // Outputs with the same regressors share one factorisation.
            let next = (output..ny)
                .find(|&other| regressors[other] != regressors[output])
                .unwrap_or(ny);
            let targets: Vec<_> = (output..next)
                .map(|index| Regressor {
                    channel: Channel::Output(index),
                    lag: 0,
                })
                .collect();
            let design = record.design(&regressors[output], &rows);
            let solution = LeastSquares::new(&design, &record.design(&targets, &rows));
            check_solution(data, output, &regressors[output], &solution)?;
            for (column, row) in solution.coefficients.column_iter().enumerate() {
                let terms = regressors[output]
                    .iter()
                    .zip(row.iter())
                    .map(|(regressor, &coefficient)| Term::new(*regressor, coefficient))
                    .collect();
                let residual = solution.residuals.column(column);
                let residual_variance = residual.norm_squared() / rows.len() as f64;
                fitted_rows.push(ArxRow {
                    terms,
                    residual_variance,
                });
                conditions.push(solution.condition);
            }
            output = next;
        }
        ArxModel::new(Fitted {
            inputs: data.inputs().to_vec(),
            outputs: data.outputs().to_vec(),
            sample_time_s: data.sample_time_s(),
            operating_point: point,
            structure: self.structure.clone(),
            rows: fitted_rows,
            rows_used: rows.len(),
            condition: conditions,
        })
    }
}

/// Refuses outputs and used inputs that do not vary over the record.
pub(crate) fn check_channels(
    data: &Dataset,
    regressors: &[Vec<Regressor>],
) -> Result<(), IdentError> {
    for (index, signal) in data.inputs().iter().enumerate() {
        let used = |regressor: &Regressor| regressor.channel == Channel::Input(index);
        if regressors.iter().flatten().any(used) {
            check_varies(signal, data.u().row(index).iter().copied())?;
        }
    }
    for (index, signal) in data.outputs().iter().enumerate() {
        check_varies(signal, data.y().row(index).iter().copied())?;
    }
    Ok(())
}

/// Refuses a solution of too high condition, or one that overflows.
pub(crate) fn check_solution(
    data: &Dataset,
    output: usize,
    regressors: &[Regressor],
    solution: &LeastSquares,
) -> Result<(), IdentError> {
    let name = data.outputs()[output].name.clone();
    if !solution.full_rank() {
        let blamed = regressors[solution.weakest];
        let channel = match blamed.channel {
            Channel::Output(index) => data.outputs()[index].name.clone(),
            Channel::Input(index) => data.inputs()[index].name.clone(),
        };
        return Err(IdentError::RankDeficient {
            output: name,
            channel,
            lag: blamed.lag,
            condition: solution.condition,
            limit: CONDITION_LIMIT,
        });
    }
    let numbers = solution
        .coefficients
        .iter()
        .chain(solution.residuals.iter());
    if let Some(&found) = numbers.into_iter().find(|value| !value.is_finite()) {
        return Err(IdentError::CoefficientNotFinite {
            output: name,
            found,
        });
    }
    Ok(())
}
