//! Jacobians, exact and by central differences, and the linear plant that they make up.

use gt_core::{DimensionError, ModelError, Signal, StateSpace};
use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{Complex, DMatrix, DVector, SMatrix, Schur};

use crate::PlantError;
use crate::dual::Dual;

/// Relative step: the cube root of the rounding unit balances truncation against rounding.
const RELATIVE_STEP: f64 = 6e-6;
/// Iterations per eigenvalue after which the Schur form is given up; LAPACK allows 30.
const SCHUR_ITERATIONS_PER_EIGENVALUE: usize = 100;
/// Shifts of A, in units of its largest entry, under which the Schur form is sought one after the
/// other: nalgebra's iteration, without exceptional shifts, stands still on some cyclic matrices.
/// The numbers are arbitrary.
const SCHUR_SHIFTS: [f64; 3] = [0.0, 0.3137, -0.7719];
/// Terms of the exponential's series: with a norm of at most 1/2 the next one is below 1e-20.
const SERIES_TERMS: u32 = 16;

/// The Jacobian (N x N) of `function` at `x`; `scale` is the size of each unknown.
pub fn jacobian<const N: usize>(
    function: impl Fn(&[f64; N]) -> [f64; N],
    x: &[f64; N],
    scale: &[f64; N],
) -> SMatrix<f64, N, N> {
    let mut matrix = SMatrix::zeros();
    for column in 0..N {
        let step = RELATIVE_STEP * scale[column];
        let (mut up, mut down) = (*x, *x);
        up[column] += step;
        down[column] -= step;
        let (high, low) = (function(&up), function(&down));
        for row in 0..N {
            matrix[(row, column)] = (high[row] - low[row]) / (2.0 * step);
        }
    }
    matrix
}

/// The exact Jacobian (M x N: a row a function, a column a variable) of `function` at `x`, by dual
/// numbers.
pub fn jacobian_exact<const N: usize, const M: usize>(
    function: impl Fn(&[Dual<N>; N]) -> [Dual<N>; M],
    x: &[f64; N],
) -> SMatrix<f64, M, N> {
    let values = function(&Dual::variables(x));
    SMatrix::from_fn(|row, column| values[row].partials[column])
}

/// A continuous plant near an operating point: `x' = A x + B u`, `y = C x + D u`, where x, u and y
/// are deviations from that point and time is in seconds.
///
/// Shapes: `A (nx x nx)`, `B (nx x nu)`, `C (ny x nx)`, `D (ny x nu)`. An entry has the unit of its
/// row over that of its column; those of A and B moreover 1/s. The entries are finite, the sizes
/// agree with the names, and the poles are known: construction checks all three.
#[derive(Debug, Clone, PartialEq)]
pub struct Linearisation {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
    states: Vec<String>,
    inputs: Vec<Signal>,
    outputs: Vec<Signal>,
    poles_per_s: Vec<Complex<f64>>,
}

impl Linearisation {
    /// A checked plant from `[A, B, C, D]`, the names of its states (nx), its inputs (nu) and
    /// outputs (ny).
    ///
    /// # Errors
    /// [`PlantError::Model`] when sizes disagree, an entry is not finite or the poles are not
    /// found.
    pub fn new(
        [a, b, c, d]: [DMatrix<f64>; 4],
        states: Vec<String>,
        inputs: Vec<Signal>,
        outputs: Vec<Signal>,
    ) -> Result<Self, PlantError> {
        let named = [
            ('A', "rows of A (states)", "columns of A (states)", &a),
            ('B', "rows of B (states)", "columns of B (inputs)", &b),
            ('C', "rows of C (outputs)", "columns of C (states)", &c),
            ('D', "rows of D (outputs)", "columns of D (inputs)", &d),
        ];
        let sizes = [
            (states.len(), states.len()),
            (states.len(), inputs.len()),
            (outputs.len(), states.len()),
            (outputs.len(), inputs.len()),
        ];
        for ((name, rows, columns, matrix), (expected_rows, expected_columns)) in
            named.into_iter().zip(sizes)
        {
            DimensionError::check(rows, expected_rows, matrix.nrows()).map_err(ModelError::from)?;
            DimensionError::check(columns, expected_columns, matrix.ncols())
                .map_err(ModelError::from)?;
            check_finite(name, matrix)?;
        }
        let poles_per_s = poles(&a)?;
        Ok(Self {
            a,
            b,
            c,
            d,
            states,
            inputs,
            outputs,
            poles_per_s,
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

    /// The names of the states (nx).
    pub fn states(&self) -> &[String] {
        &self.states
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
        self.states.len()
    }

    /// Number of inputs.
    pub fn nu(&self) -> usize {
        self.inputs.len()
    }

    /// Number of outputs.
    pub fn ny(&self) -> usize {
        self.outputs.len()
    }

    /// The eigenvalues of A (nx), in 1/s (an imaginary part in rad/s).
    ///
    /// Slowest first: by falling real part, so that what grows comes before what decays; among
    /// equal ones by rising modulus of the imaginary part. The two of a conjugate pair stand side
    /// by side, the one with the positive imaginary part first.
    ///
    /// A is balanced before (Parlett and Reinsch; James, Langou and Lowery, arXiv 1401.5766), so
    /// that units do not matter. The error is then some 1e-16 of the fastest pole, times the
    /// condition of the pole: an exact integrator may come out as a pole of that size.
    pub fn poles_per_s(&self) -> &[Complex<f64>] {
        &self.poles_per_s
    }

    /// The time constant -1/Re of each pole, in the order of [`Linearisation::poles_per_s`], s:
    /// negative for a mode that grows, infinite for one that does neither grow nor decay.
    pub fn time_constants_s(&self) -> Vec<f64> {
        self.poles_per_s
            .iter()
            .map(|pole| {
                if pole.re == 0.0 {
                    f64::INFINITY
                } else {
                    -1.0 / pole.re
                }
            })
            .collect()
    }

    /// The rate at which the slowest mode decays, 1/s: the least -Re of a pole, negative when one
    /// grows, infinite without states.
    pub fn decay_per_s(&self) -> f64 {
        self.poles_per_s
            .first()
            .map_or(f64::INFINITY, |slowest| -slowest.re)
    }

    /// Whether every mode decays.
    pub fn is_stable(&self) -> bool {
        self.decay_per_s() > 0.0
    }

    /// The steady outputs over constant inputs, `D - C A^-1 B` (`ny x nu`, unit of the output over
    /// that of the input). They are reached only when the plant is stable.
    ///
    /// # Errors
    /// [`PlantError::Singular`] when A is singular: the plant then has a pole at zero.
    pub fn dc_gain(&self) -> Result<DMatrix<f64>, PlantError> {
        Ok(self.frequency_response(0.0)?.map(|gain| gain.re))
    }

    /// The complex gain `C (j w I - A)^-1 B + D` (`ny x nu`) at the angular frequency w in rad/s.
    ///
    /// # Errors
    /// [`PlantError::Singular`] when the plant has a pole at `j w`, or w is not finite.
    pub fn frequency_response(
        &self,
        omega_rad_s: f64,
    ) -> Result<DMatrix<Complex<f64>>, PlantError> {
        let complex = |matrix: &DMatrix<f64>| matrix.map(|entry| Complex::new(entry, 0.0));
        let mut system = complex(&-&self.a);
        for i in 0..self.nx() {
            system[(i, i)].im = omega_rad_s;
        }
        let states = solve(system, complex(&self.b)).map_err(|found| PlantError::Singular {
            omega_rad_s,
            least: least_condition(self.nx()),
            found,
        })?;
        Ok(complex(&self.c) * states + complex(&self.d))
    }

    /// The discrete plant whose inputs are held from one sample to the next (zero-order hold):
    /// `e^(A Ts)` and the integral of `e^(A t) B` over one sample (Franklin, Powell and Workman,
    /// Digital Control of Dynamic Systems, 3rd ed., chapter 4). A may be singular.
    ///
    /// # Errors
    /// [`PlantError::Model`] when the sample time is not positive and finite, or so long that the
    /// plant leaves the finite numbers within one sample.
    pub fn discretise(&self, sample_time_s: f64) -> Result<StateSpace, PlantError> {
        if !(sample_time_s.is_finite() && sample_time_s > 0.0) {
            let found = sample_time_s;
            return Err(ModelError::SampleTime { found }.into());
        }
        let (balanced, scale) = balance(&self.a);
        let (mut transition, mut integral) = exponential(&balanced, sample_time_s);
        for matrix in [&mut transition, &mut integral] {
            for column in 0..self.nx() {
                for row in 0..self.nx() {
                    matrix[(row, column)] *= scale[row] / scale[column];
                }
            }
        }
        let held = integral * &self.b;
        let matrices = [transition, held, self.c.clone(), self.d.clone()];
        let (inputs, outputs) = (self.inputs.clone(), self.outputs.clone());
        Ok(StateSpace::new(matrices, sample_time_s, inputs, outputs)?)
    }
}

fn check_finite(matrix: char, entries: &DMatrix<f64>) -> Result<(), ModelError> {
    for row in 0..entries.nrows() {
        for column in 0..entries.ncols() {
            let found = entries[(row, column)];
            if !found.is_finite() {
                return Err(ModelError::NotFinite {
                    matrix,
                    row,
                    column,
                    found,
                });
            }
        }
    }
    Ok(())
}

/// `S^-1 A S` with rows and columns of like norms, and the diagonal of S, powers of two.
fn balance(a: &DMatrix<f64>) -> (DMatrix<f64>, DVector<f64>) {
    let largest = a.amax();
    if largest == 0.0 {
        return (a.clone(), DVector::from_element(a.nrows(), 1.0));
    }
    // The library squares the entries: from 1e154 on it would count to infinity.
    let unit = largest.log2().floor().exp2();
    let mut balanced = a / unit;
    let scale = balance_parlett_reinsch(&mut balanced);
    (balanced * unit, scale)
}

/// The eigenvalues of a finite square matrix, in the order of [`Linearisation::poles_per_s`].
fn poles(a: &DMatrix<f64>) -> Result<Vec<Complex<f64>>, ModelError> {
    let order = a.nrows();
    let (mut balanced, _) = balance(a);
    let size = balanced.amax();
    if size == 0.0 {
        return Ok(vec![Complex::new(0.0, 0.0); order]);
    }
    // With a largest entry of exactly 1 the library's scaling back does nothing. Otherwise rounding
    // there may turn the block of a complex pair into one of real poles, and those into NaN.
    balanced /= size;
    let iterations = SCHUR_ITERATIONS_PER_EIGENVALUE * order;
    for shift in SCHUR_SHIFTS {
        let mut shifted = balanced.clone();
        for i in 0..order {
            shifted[(i, i)] += shift;
        }
        let Some(schur) = Schur::try_new(shifted, f64::EPSILON, iterations) else {
            continue;
        };
        let mut poles: Vec<_> = schur
            .complex_eigenvalues()
            .iter()
            .map(|pole| (pole - shift) * size)
            .collect();
        if poles.iter().all(|pole| pole.is_finite()) {
            poles.sort_by(|p, q| {
                q.re.total_cmp(&p.re)
                    .then(p.im.abs().total_cmp(&q.im.abs()))
                    .then(q.im.total_cmp(&p.im))
            });
            return Ok(poles);
        }
    }
    Err(ModelError::NoConvergence { order, iterations })
}

/// The reciprocal condition below which a matrix counts as singular.
fn least_condition(order: usize) -> f64 {
    order as f64 * f64::EPSILON
}

/// The solution of `matrix x = right`; the reciprocal condition (1-norm) of the matrix when it is
/// too small. Rows and columns are scaled to largest entries of 1 before (LAPACK's `geequ`), so
/// that units and speeds do not count as bad condition.
fn solve(
    mut matrix: DMatrix<Complex<f64>>,
    mut right: DMatrix<Complex<f64>>,
) -> Result<DMatrix<Complex<f64>>, f64> {
    let order = matrix.nrows();
    if order == 0 {
        return Ok(right);
    }
    for row in 0..order {
        let size = largest(matrix.row(row).iter());
        matrix.row_mut(row).unscale_mut(size);
        right.row_mut(row).unscale_mut(size);
    }
    let sizes: Vec<f64> = (0..order)
        .map(|column| {
            let size = largest(matrix.column(column).iter());
            matrix.column_mut(column).unscale_mut(size);
            size
        })
        .collect();
    let norm = one_norm(&matrix);
    let factors = matrix.lu();
    let inverse_norm = factors
        .try_inverse()
        .map_or(f64::INFINITY, |inverse| one_norm(&inverse));
    let condition = 1.0 / (norm * inverse_norm);
    let solution = factors
        .solve(&right)
        .filter(|_| condition >= least_condition(order));
    let mut x = solution.ok_or(condition)?;
    for (row, size) in sizes.into_iter().enumerate() {
        x.row_mut(row).unscale_mut(size);
    }
    Ok(x)
}

/// The largest modulus, 1 when all are zero; a NaN stays in the entries.
fn largest<'a>(entries: impl Iterator<Item = &'a Complex<f64>>) -> f64 {
    let size = entries.map(|entry| entry.norm()).fold(0.0, f64::max);
    if size == 0.0 { 1.0 } else { size }
}

/// The largest sum of moduli in a column; NaN when there is one.
fn one_norm(matrix: &DMatrix<Complex<f64>>) -> f64 {
    matrix
        .column_iter()
        .map(|column| column.iter().map(|entry| entry.norm()).sum())
        .fold(0.0, |worst: f64, sum: f64| {
            if sum.is_nan() || sum > worst {
                sum
            } else {
                worst
            }
        })
}

/// `e^(A t)` and the integral of `e^(A s)` for s from 0 to t, by scaling and doubling of the
/// series. (nalgebra's exponential panics where its norms overflow.)
fn exponential(a: &DMatrix<f64>, time_s: f64) -> (DMatrix<f64>, DMatrix<f64>) {
    let identity = DMatrix::identity(a.nrows(), a.ncols());
    let norm = a
        .column_iter()
        .map(|column| column.abs().sum())
        .fold(0.0, f64::max);
    let (mut step_s, mut doublings) = (time_s, 0);
    while norm * step_s > 0.5 {
        step_s *= 0.5;
        doublings += 1;
    }
    let small = a * step_s;
    let mut series = identity.clone();
    for term in (1..=SERIES_TERMS).rev() {
        series = &small * series / f64::from(term + 1) + &identity;
    }
    let mut transition = &small * &series + &identity;
    let mut integral = series * step_s;
    for _ in 0..doublings {
        integral = &transition * &integral + integral;
        transition = &transition * &transition;
    }
    (transition, integral)
}
