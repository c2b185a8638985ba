//! A checked discrete state-space model.

use nalgebra::{Complex, DMatrix, DVector, Schur};
use serde::{Deserialize, Serialize};

use crate::{DimensionError, ModelError, Signal, stored_matrix};

/// Iterations per eigenvalue after which the Schur form is given up; LAPACK allows 30.
const SCHUR_ITERATIONS_PER_EIGENVALUE: usize = 100;

/// `x(t+1) = A x(t) + B u(t)`, `y(t) = C x(t) + D u(t)`: eq. 1 of Simani and Fantuzzi (2006) with
/// a direct term.
///
/// Shapes: `A (nx x nx)`, `B (nx x nu)`, `C (ny x nx)`, `D (ny x nu)`; the entries are finite and
/// the sizes agree, which construction and deserialisation both check.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct StateSpace {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
    sample_time_s: f64,
    inputs: Vec<Signal>,
    outputs: Vec<Signal>,
}

/// The fields of a [`StateSpace`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    #[serde(deserialize_with = "stored_matrix")]
    a: DMatrix<f64>,
    #[serde(deserialize_with = "stored_matrix")]
    b: DMatrix<f64>,
    #[serde(deserialize_with = "stored_matrix")]
    c: DMatrix<f64>,
    #[serde(deserialize_with = "stored_matrix")]
    d: DMatrix<f64>,
    sample_time_s: f64,
    inputs: Vec<Signal>,
    outputs: Vec<Signal>,
}

impl TryFrom<Unchecked> for StateSpace {
    type Error = ModelError;

    fn try_from(raw: Unchecked) -> Result<Self, ModelError> {
        Self::new(
            [raw.a, raw.b, raw.c, raw.d],
            raw.sample_time_s,
            raw.inputs,
            raw.outputs,
        )
    }
}

impl StateSpace {
    /// A checked model from `[A, B, C, D]`.
    ///
    /// # Errors
    /// [`ModelError`] when sizes disagree, an entry is not finite or the sample time not positive.
    pub fn new(
        [a, b, c, d]: [DMatrix<f64>; 4],
        sample_time_s: f64,
        inputs: Vec<Signal>,
        outputs: Vec<Signal>,
    ) -> Result<Self, ModelError> {
        let nx = a.nrows();
        DimensionError::check("columns of A", nx, a.ncols())?;
        DimensionError::check("rows of B", nx, b.nrows())?;
        DimensionError::check("columns of B (inputs)", inputs.len(), b.ncols())?;
        DimensionError::check("rows of C (outputs)", outputs.len(), c.nrows())?;
        DimensionError::check("columns of C", nx, c.ncols())?;
        DimensionError::check("rows of D (outputs)", outputs.len(), d.nrows())?;
        DimensionError::check("columns of D (inputs)", inputs.len(), d.ncols())?;
        for (name, matrix) in [('A', &a), ('B', &b), ('C', &c), ('D', &d)] {
            for row in 0..matrix.nrows() {
                for column in 0..matrix.ncols() {
                    let found = matrix[(row, column)];
                    if !found.is_finite() {
                        return Err(ModelError::NotFinite {
                            matrix: name,
                            row,
                            column,
                            found,
                        });
                    }
                }
            }
        }
        if !(sample_time_s.is_finite() && sample_time_s > 0.0) {
            return Err(ModelError::SampleTime {
                found: sample_time_s,
            });
        }
        Ok(Self {
            a,
            b,
            c,
            d,
            sample_time_s,
            inputs,
            outputs,
        })
    }

    /// State matrix, `nx x nx`.
    pub fn a(&self) -> &DMatrix<f64> {
        &self.a
    }

    /// Input matrix, `nx x nu`.
    pub fn b(&self) -> &DMatrix<f64> {
        &self.b
    }

    /// Output matrix, `ny x nx`.
    pub fn c(&self) -> &DMatrix<f64> {
        &self.c
    }

    /// Direct term, `ny x nu`.
    pub fn d(&self) -> &DMatrix<f64> {
        &self.d
    }

    /// Sample time in seconds.
    pub fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// The input signals (nu).
    pub fn inputs(&self) -> &[Signal] {
        &self.inputs
    }

    /// The output signals (ny).
    pub fn outputs(&self) -> &[Signal] {
        &self.outputs
    }

    /// Number of states.
    pub fn nx(&self) -> usize {
        self.a.nrows()
    }

    /// Number of inputs.
    pub fn nu(&self) -> usize {
        self.inputs.len()
    }

    /// Number of outputs.
    pub fn ny(&self) -> usize {
        self.outputs.len()
    }

    /// The outputs `y (ny x N)` that the inputs `u (nu x N)` produce from the state `x0 (nx)`.
    ///
    /// # Errors
    /// [`DimensionError`] when `x0` or `u` has another size than the model.
    pub fn simulate(
        &self,
        x0: &DVector<f64>,
        u: &DMatrix<f64>,
    ) -> Result<DMatrix<f64>, DimensionError> {
        DimensionError::check("rows of x0 (states)", self.nx(), x0.len())?;
        DimensionError::check("rows of u (inputs)", self.nu(), u.nrows())?;
        let mut y = DMatrix::zeros(self.ny(), u.ncols());
        let mut x = x0.clone();
        let mut next = DVector::zeros(self.nx());
        for (input, mut output) in u.column_iter().zip(y.column_iter_mut()) {
            self.c.mul_to(&x, &mut output);
            output.gemv(1.0, &self.d, &input, 1.0);
            self.a.mul_to(&x, &mut next);
            next.gemv(1.0, &self.b, &input, 1.0);
            std::mem::swap(&mut x, &mut next);
        }
        Ok(y)
    }

    /// The first `count` Markov parameters: `D, C B, C A B, ...` (`ny x nu` each).
    pub fn markov_parameters(&self, count: usize) -> Vec<DMatrix<f64>> {
        let mut powers = self.b.clone();
        let mut parameters = Vec::with_capacity(count);
        for index in 0..count {
            if index == 0 {
                parameters.push(self.d.clone());
            } else {
                parameters.push(&self.c * &powers);
                powers = &self.a * powers;
            }
        }
        parameters
    }

    /// The eigenvalues of A.
    ///
    /// # Errors
    /// [`ModelError::NoConvergence`] when the Schur iteration stalls.
    pub fn poles(&self) -> Result<Vec<Complex<f64>>, ModelError> {
        if self.nx() == 0 {
            return Ok(Vec::new());
        }
        let iterations = SCHUR_ITERATIONS_PER_EIGENVALUE * self.nx();
        let largest = self.a.amax();
        if largest == 0.0 {
            return Ok(vec![Complex::new(0.0, 0.0); self.nx()]);
        }
        // The decomposition scales its result back by the largest entry, and near a double pole
        // that rounding can make an imaginary part NaN: with a largest entry of 1 it is exact.
        Schur::try_new(&self.a / largest, f64::EPSILON, iterations)
            .map(|schur| schur.complex_eigenvalues() * Complex::new(largest, 0.0))
            .filter(|poles| {
                poles
                    .iter()
                    .all(|pole| pole.re.is_finite() && pole.im.is_finite())
            })
            .map(|poles| poles.iter().copied().collect())
            .ok_or(ModelError::NoConvergence {
                order: self.nx(),
                iterations,
            })
    }

    /// The largest modulus of a pole; below 1 the model is stable.
    ///
    /// # Errors
    /// As [`StateSpace::poles`].
    pub fn spectral_radius(&self) -> Result<f64, ModelError> {
        Ok(self
            .poles()?
            .iter()
            .map(|pole| pole.norm())
            .fold(0.0, f64::max))
    }
}
