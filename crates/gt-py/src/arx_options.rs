//! The options of a least-squares fit besides the structure.

use gtfdi::core::OperatingPoint;
use gtfdi::ident::{Arx, ArxStructure, Centre, EquationErrors, Missing, Solver};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

use crate::array::vector;
use crate::choice::named;
use crate::error::Failure;

/// What `centre` may be.
#[derive(FromPyObject)]
pub enum CentreOption<'py> {
    /// `means` or `zero`.
    #[pyo3(annotation = "str")]
    Name(String),
    /// A known operating point.
    #[pyo3(annotation = "tuple of two arrays")]
    At((Bound<'py, PyAny>, Bound<'py, PyAny>)),
}

impl CentreOption<'_> {
    fn read(&self) -> Result<Centre, Failure> {
        match self {
            Self::Name(name) if name == "means" => Ok(Centre::Means),
            Self::Name(name) if name == "zero" => Ok(Centre::Zero),
            Self::Name(name) => Err(Failure::Option {
                option: "centre",
                expected: "means, zero or a tuple (u, y)".to_owned(),
                found: format!("{name:?}"),
            }),
            Self::At((u, y)) => Ok(Centre::At(OperatingPoint {
                u: vector(u, "inputs of centre")?,
                y: vector(y, "outputs of centre")?,
            })),
        }
    }
}

/// The options of a fit, as given.
pub struct FitArguments<'a, 'py> {
    pub first_row: usize,
    pub centre: Option<CentreOption<'py>>,
    pub missing: &'a str,
    pub ridge: f64,
    pub equation_errors: &'a str,
    pub solver: &'a str,
}

/// The options of a fit.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
pub struct FitOptions {
    first_row: usize,
    centre: Centre,
    missing: Missing,
    ridge: f64,
    equation_errors: EquationErrors,
    solver: Solver,
}

impl FitOptions {
    /// Reads what is given.
    pub fn read(given: &FitArguments<'_, '_>) -> Result<Self, Failure> {
        let missing = [("refuse", Missing::Refuse), ("break", Missing::Break)];
        let equation_errors = [
            ("uncorrelated", EquationErrors::Uncorrelated),
            ("correlated", EquationErrors::Correlated),
        ];
        let solver = [("qr", Solver::Qr), ("automatic", Solver::Automatic)];
        Ok(Self {
            first_row: given.first_row,
            centre: match &given.centre {
                Some(centre) => centre.read()?,
                None => Centre::default(),
            },
            missing: named("missing", given.missing, &missing)?,
            ridge: given.ridge,
            equation_errors: named("equation_errors", given.equation_errors, &equation_errors)?,
            solver: named("solver", given.solver, &solver)?,
        })
    }

    /// A model of the structure that is still to be fitted.
    pub fn arx(&self, structure: ArxStructure) -> Arx {
        Arx::new(structure)
            .first_row(self.first_row)
            .centre(self.centre.clone())
            .missing(self.missing)
            .ridge(self.ridge)
            .equation_errors(self.equation_errors)
            .solver(self.solver)
    }
}
