//! Singular values of a frequency response.

use gt_core::StateSpace;
use nalgebra::{Complex, DMatrix, SVD};

use super::error::UnknownInputError;
use crate::FdiError;

/// How far above the largest gain that was found the frequency response is shown not to reach.
pub const PEAK_TOLERANCE: f64 = 1e-7;

/// Iterations after which singular values are given up.
const SVD_ITERATIONS: usize = 10_000;
/// Frequencies of a sweep: evenly spaced, and evenly on a logarithmic scale below them.
const LINEAR: usize = 512;
const LOGARITHMIC: usize = 192;
/// The lowest frequency above 0 of a sweep, in radians a sample.
const LOWEST: f64 = 1e-5;
/// Steps of a golden section: `0.618^60` of the interval is left.
const SECTIONS: usize = 60;
/// Local extrema of a sweep that are refined.
const REFINED: usize = 8;
/// Levels tried at most.
const LEVELS: usize = 50;
/// Real part, relative to the modulus, up to which an eigenvalue may lie on the imaginary axis.
const ON_AXIS: f64 = 1e-5;

/// Frequencies from `low_hz` to `high_hz`, in hertz.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrequencyBand {
    /// The lowest frequency in hertz, 0 or above.
    pub low_hz: f64,
    /// The highest frequency in hertz, at most half of the sampling frequency.
    pub high_hz: f64,
}

impl FrequencyBand {
    /// All frequencies of a sampled signal: 0 to `0.5 / sample_time_s`.
    pub fn all(sample_time_s: f64) -> Self {
        Self {
            low_hz: 0.0,
            high_hz: 0.5 / sample_time_s,
        }
    }

    /// The band in radians a sample.
    fn in_radians(self, sample_time_s: f64) -> Result<(f64, f64), UnknownInputError> {
        let Self { low_hz, high_hz } = self;
        let nyquist_hz = 0.5 / sample_time_s;
        let valid = low_hz >= 0.0 && low_hz <= high_hz && high_hz <= nyquist_hz * (1.0 + 1e-12);
        if valid {
            let scale = std::f64::consts::TAU * sample_time_s;
            let radians = |hertz: f64| (hertz * scale).min(std::f64::consts::PI);
            Ok((radians(low_hz), radians(high_hz)))
        } else {
            Err(UnknownInputError::Band {
                low_hz,
                high_hz,
                nyquist_hz,
            })
        }
    }
}

/// The largest gain of a system over all frequencies, its H-infinity norm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeakGain {
    /// The largest singular value of the frequency response that was found; it is reached.
    pub gain: f64,
    /// Where it is reached, in hertz.
    pub frequency_hz: f64,
    /// A gain that is nowhere exceeded, [`PEAK_TOLERANCE`] above `gain`.
    pub bound: f64,
}

/// The H-infinity norm of a stable system: a sweep over frequencies whose best is refined, and
/// then raised until the Hamiltonian matrix of the level above it shows no frequency that reaches
/// it (N. A. Bruinsma, M. Steinbuch, Systems & Control Letters 14, 1990), after the bilinear
/// transformation `z = (1 + s)/(1 - s)`, which keeps the gains.
///
/// # Errors
/// [`UnknownInputError::Unstable`], [`UnknownInputError::NoConvergence`].
pub fn peak_gain(system: &StateSpace) -> Result<PeakGain, FdiError> {
    let largest = |values: &[f64]| values.first().copied().unwrap_or(0.0);
    check_stable(system)?;
    let negative = |omega: f64| Ok(-largest(&singular_values(system, omega)?));
    let (mut omega, value) = smallest(system, (0.0, std::f64::consts::PI), &negative)?;
    let mut gain = -value;
    for _ in 0..LEVELS {
        if gain == 0.0 {
            break;
        }
        let mut frequencies = reaching(system, gain * (1.0 + PEAK_TOLERANCE))?;
        let between: Vec<f64> = (frequencies.windows(2))
            .map(|pair| f64::midpoint(pair[0], pair[1]))
            .collect();
        frequencies.extend(between);
        let mut best = gain;
        for candidate in frequencies {
            let found = -negative(candidate)?;
            if found > best {
                (best, omega) = (found, candidate);
            }
        }
        let raised = best > gain * (1.0 + PEAK_TOLERANCE);
        gain = best;
        if !raised {
            break;
        }
    }
    Ok(PeakGain {
        gain,
        frequency_hz: omega / (std::f64::consts::TAU * system.sample_time_s()),
        bound: gain * (1.0 + PEAK_TOLERANCE),
    })
}

/// The least that any direction of the inputs is amplified within a band, `(gain, hertz)`: the
/// smallest singular value, by a sweep whose lowest minima are refined; 0 where there are more
/// inputs than outputs. Without inputs it is infinite.
pub(super) fn least_gain(system: &StateSpace, band: FrequencyBand) -> Result<(f64, f64), FdiError> {
    check_stable(system)?;
    let ts = system.sample_time_s();
    let range = band.in_radians(ts)?;
    let (nu, ny) = (system.nu(), system.ny());
    let least = |omega: f64| {
        if nu > ny {
            return Ok(0.0);
        }
        let values = singular_values(system, omega)?;
        Ok(values.last().copied().unwrap_or(f64::INFINITY))
    };
    let (omega, value) = smallest(system, range, &least)?;
    Ok((value, omega / (std::f64::consts::TAU * ts)))
}

fn check_stable(system: &StateSpace) -> Result<(), UnknownInputError> {
    let spectral_radius = system.spectral_radius().unwrap_or(f64::NAN);
    if spectral_radius < 1.0 {
        Ok(())
    } else {
        Err(UnknownInputError::Unstable { spectral_radius })
    }
}

/// Singular values of `C (e^(j omega) I - A)^-1 B + D` from the largest to the smallest, `omega` in
/// radians a sample.
fn singular_values(system: &StateSpace, omega: f64) -> Result<Vec<f64>, FdiError> {
    let complex = |matrix: &DMatrix<f64>| matrix.map(|value| Complex::new(value, 0.0));
    let mut shifted = -complex(system.a());
    let z = Complex::from_polar(1.0, omega);
    for state in 0..system.nx() {
        shifted[(state, state)] += z;
    }
    let failed = UnknownInputError::NoConvergence {
        iterations: SVD_ITERATIONS,
    };
    let Some(states) = shifted.lu().solve(&complex(system.b())) else {
        return Err(failed.into());
    };
    let response = complex(system.c()) * states + complex(system.d());
    if response.is_empty() {
        return Ok(Vec::new());
    }
    let svd = SVD::try_new(response, false, false, f64::EPSILON, SVD_ITERATIONS);
    let mut values: Vec<f64> = svd.ok_or(failed)?.singular_values.iter().copied().collect();
    values.sort_by(|left, right| right.total_cmp(left));
    Ok(values)
}

/// The smallest value of a function of the frequency within `low..high` (radians a sample), and
/// where: at the frequencies of a sweep and those of the poles, the lowest minima refined.
fn smallest(
    system: &StateSpace,
    (low, high): (f64, f64),
    value: &dyn Fn(f64) -> Result<f64, FdiError>,
) -> Result<(f64, f64), FdiError> {
    let even = (0..=LINEAR).map(|index| low + (high - low) * index as f64 / LINEAR as f64);
    let ratio = (std::f64::consts::PI / LOWEST).ln();
    let logarithmic = (0..=LOGARITHMIC)
        .map(|index| LOWEST * (ratio * index as f64 / LOGARITHMIC as f64).exp())
        .filter(|omega| (low..=high).contains(omega));
    let poles = system.poles()?;
    let angles = poles
        .iter()
        .map(|pole| pole.arg().abs())
        .filter(|omega| (low..=high).contains(omega));
    let mut grid: Vec<f64> = even.chain(logarithmic).chain(angles).collect();
    grid.sort_by(f64::total_cmp);
    grid.dedup();
    let values = grid
        .iter()
        .map(|&omega| value(omega))
        .collect::<Result<Vec<_>, _>>()?;
    let last = grid.len() - 1;
    let around = |index: usize| (index.saturating_sub(1), (index + 1).min(last));
    let mut minima: Vec<usize> = (0..=last)
        .filter(|&index| {
            let (left, right) = around(index);
            values[index] <= values[left] && values[index] <= values[right]
        })
        .collect();
    minima.sort_by(|&left, &right| values[left].total_cmp(&values[right]));
    let mut best = (low, f64::INFINITY);
    for &index in minima.iter().take(REFINED) {
        if values[index] < best.1 {
            best = (grid[index], values[index]);
        }
        let (left, right) = around(index);
        let refined = golden_section((grid[left], grid[right]), value)?;
        if refined.1 < best.1 {
            best = refined;
        }
    }
    Ok(best)
}

/// A local minimum within an interval.
fn golden_section(
    (mut low, mut high): (f64, f64),
    value: &dyn Fn(f64) -> Result<f64, FdiError>,
) -> Result<(f64, f64), FdiError> {
    let share = (5.0_f64.sqrt() - 1.0) / 2.0;
    let inner = |low: f64, high: f64| (high - share * (high - low), low + share * (high - low));
    let (mut left, mut right) = inner(low, high);
    let (mut at_left, mut at_right) = (value(left)?, value(right)?);
    for _ in 0..SECTIONS {
        if at_left <= at_right {
            (high, right, at_right) = (right, left, at_left);
            left = inner(low, high).0;
            at_left = value(left)?;
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = inner(low, high).1;
            at_right = value(right)?;
        }
    }
    if at_left <= at_right {
        Ok((left, at_left))
    } else {
        Ok((right, at_right))
    }
}

/// Frequencies in radians a sample, ascending, at which a singular value may equal `level`, which is
/// above the gain at half of the sampling frequency: angles of the imaginary eigenvalues of the
/// Hamiltonian matrix of the transformed system. Some may be wrong, none is missing but for
/// rounding.
fn reaching(system: &StateSpace, level: f64) -> Result<Vec<f64>, FdiError> {
    let nx = system.nx();
    let identity = DMatrix::<f64>::identity(nx, nx);
    let failed = || UnknownInputError::NoConvergence {
        iterations: SVD_ITERATIONS,
    };
    // A stable A has no eigenvalue at -1.
    let inverse = (system.a() + &identity).try_inverse().ok_or_else(failed)?;
    let a = &inverse * (system.a() - identity);
    let root = std::f64::consts::SQRT_2;
    let b = &inverse * system.b() * root;
    let c = system.c() * &inverse * root;
    let d = system.d() - system.c() * inverse * system.b();
    let nu = system.nu();
    let gap = DMatrix::identity(nu, nu) * (level * level) - d.transpose() * &d;
    let Some(gap) = gap.cholesky() else {
        return Ok(Vec::new());
    };
    let weighted = gap.solve(&d.transpose());
    let block = a + &b * &weighted * &c;
    let mut hamiltonian = DMatrix::zeros(2 * nx, 2 * nx);
    let shape = (nx, nx);
    hamiltonian.view_mut((0, 0), shape).copy_from(&block);
    let upper = &b * gap.solve(&b.transpose());
    hamiltonian.view_mut((0, nx), shape).copy_from(&upper);
    let lower = -(c.transpose() * (&c + &d * weighted * &c));
    hamiltonian.view_mut((nx, 0), shape).copy_from(&lower);
    hamiltonian
        .view_mut((nx, nx), shape)
        .copy_from(&-block.transpose());
    let none = DMatrix::zeros;
    let matrices = [hamiltonian, none(2 * nx, 0), none(0, 2 * nx), none(0, 0)];
    let poles = StateSpace::new(matrices, 1.0, Vec::new(), Vec::new())?.poles()?;
    let mut angles: Vec<f64> = poles
        .iter()
        .filter(|pole| pole.re.abs() <= ON_AXIS * pole.norm().max(1.0))
        .map(|pole| 2.0 * pole.im.abs().atan())
        .collect();
    angles.sort_by(f64::total_cmp);
    angles.dedup();
    Ok(angles)
}
