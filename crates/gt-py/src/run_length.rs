//! How long a test runs in the mean before it alarms, and the limit for a time that is asked for.

use gtfdi::fdi::{
    CusumRunLength, ExceedanceRunLength, RunSum, RunSumRunLength, ShiryaevRobertsRunLength,
    mean_delay_bound as bound,
};
use pyo3::prelude::*;

use crate::error::Failure;
use crate::interrupt::interruptible;
use crate::statistics::{sides, waveform};

/// The average run length of a CUSUM in samples, on white normal residuals of standard deviation 1.
///
/// Parameters
/// ----------
/// allowance, threshold : float
///     Those of ``gtfdi.statistics.Cusum``.
/// shift : float, default 0
///     The residual's mean in standard deviations; 0 gives the time between false alarms, another
///     one the delay.
/// sides : {"upper", "lower", "both"}, default "both"
///     Which deviations count.
///
/// Returns
/// -------
/// float
///     To a relative error below 1e-11 (Page's equation by Nystroem's method).
///
/// Examples
/// --------
/// >>> from gtfdi import run_length
/// >>> round(run_length.cusum(0.5, 5.0), 1), round(run_length.cusum(0.5, 5.0, shift=1.0), 2)
/// (465.4, 10.38)
#[pyfunction]
#[pyo3(signature = (allowance, threshold, shift=0.0, sides="both"))]
pub fn cusum_run_length(
    py: Python<'_>,
    allowance: f64,
    threshold: f64,
    shift: f64,
    sides: &str,
) -> Result<f64, Failure> {
    let run = CusumRunLength::new(allowance, threshold, self::sides(sides)?)?;
    interruptible(py, move |_| Ok(run.samples(shift)?))
}

/// The threshold of a CUSUM with that many samples between false alarms in the mean.
///
/// Parameters
/// ----------
/// allowance : float
///     Half the deviation to be found, in standard deviations.
/// run_length : float
///     In samples.
/// sides : {"upper", "lower", "both"}, default "both"
///     Which deviations count.
///
/// Examples
/// --------
/// >>> from gtfdi import run_length
/// >>> day = 24 * 3600 / 0.08  # samples
/// >>> threshold = run_length.cusum_threshold(0.5, day)
/// >>> bool(abs(run_length.cusum(0.5, threshold) / day - 1) < 1e-9)
/// True
#[pyfunction]
#[pyo3(signature = (allowance, run_length, sides="both"))]
pub fn cusum_threshold(
    py: Python<'_>,
    allowance: f64,
    run_length: f64,
    sides: &str,
) -> Result<f64, Failure> {
    let sides = self::sides(sides)?;
    interruptible(py, move |_| {
        Ok(CusumRunLength::threshold_for(allowance, sides, run_length)?)
    })
}

/// The average run length, in samples, of an alarm after samples in a row beyond a limit, on white
/// normal residuals of standard deviation 1.
///
/// Parameters
/// ----------
/// limit : float
///     In standard deviations.
/// consecutive : int, default 1
///     Samples in a row.
/// shift : float, default 0
///     The residual's mean in standard deviations.
/// sides : {"upper", "lower", "both"}, default "both"
///     Which deviations count.
///
/// Examples
/// --------
/// >>> from gtfdi import run_length
/// >>> round(run_length.exceedance(3.0), 1)
/// 370.4
#[pyfunction]
#[pyo3(signature = (limit, consecutive=1, shift=0.0, sides="both"))]
pub fn exceedance_run_length(
    limit: f64,
    consecutive: usize,
    shift: f64,
    sides: &str,
) -> Result<f64, Failure> {
    let run = ExceedanceRunLength::new(limit, consecutive, self::sides(sides)?)?;
    Ok(run.samples(shift)?)
}

/// The limit, in standard deviations, with that many samples between false alarms in the mean.
///
/// Parameters
/// ----------
/// run_length : float
///     In samples.
/// consecutive : int, default 1
///     Samples in a row beyond the limit that make an alarm.
/// sides : {"upper", "lower", "both"}, default "both"
///     Which deviations count.
///
/// Examples
/// --------
/// >>> from gtfdi import run_length
/// >>> round(run_length.exceedance_limit(370.3983), 4)
/// 3.0
#[pyfunction]
#[pyo3(signature = (run_length, consecutive=1, sides="both"))]
pub fn exceedance_limit(run_length: f64, consecutive: usize, sides: &str) -> Result<f64, Failure> {
    let sides = self::sides(sides)?;
    let limit = ExceedanceRunLength::limit_for(consecutive, sides, run_length)?;
    Ok(limit)
}

/// The average run length of a run sum in samples, on white normal residuals of standard deviation
/// 1 (a Markov chain, exact).
///
/// Parameters
/// ----------
/// width, scores, threshold, sides
///     Those of ``gtfdi.statistics.RunSum``; the threshold is a whole number.
/// shift : float, default 0
///     The residual's mean in standard deviations.
///
/// Examples
/// --------
/// >>> from gtfdi import run_length
/// >>> round(run_length.run_sum(1.0))  # the zone control chart
/// 95
#[pyfunction]
#[pyo3(signature = (width, scores=RunSum::ZONE_SCORES, threshold=7, shift=0.0, sides="both"),
    text_signature = "(width, scores=(0, 2, 4, 8), threshold=7, shift=0.0, sides='both')")]
pub fn run_sum_run_length(
    width: f64,
    scores: [u32; 4],
    threshold: u32,
    shift: f64,
    sides: &str,
) -> Result<f64, Failure> {
    let run = RunSumRunLength::new(width, scores, threshold, self::sides(sides)?)?;
    Ok(run.samples(shift)?)
}

/// The width of the zones, in standard deviations, with that many samples between false alarms in
/// the mean.
///
/// Parameters
/// ----------
/// run_length : float
///     In samples.
/// scores, threshold, sides
///     Those of ``gtfdi.statistics.RunSum``; the threshold is a whole number.
///
/// Examples
/// --------
/// >>> from gtfdi import run_length
/// >>> 1.42 < run_length.run_sum_width(2000.0) < 1.44
/// True
#[pyfunction]
#[pyo3(signature = (run_length, scores=RunSum::ZONE_SCORES, threshold=7, sides="both"),
    text_signature = "(run_length, scores=(0, 2, 4, 8), threshold=7, sides='both')")]
pub fn run_sum_width(
    run_length: f64,
    scores: [u32; 4],
    threshold: u32,
    sides: &str,
) -> Result<f64, Failure> {
    let sides = self::sides(sides)?;
    let width = RunSumRunLength::width_for(scores, threshold, sides, run_length)?;
    Ok(width)
}

/// The average run length of a one-sided Shiryaev-Roberts procedure in samples, on white normal
/// residuals of standard deviation 1.
///
/// Parameters
/// ----------
/// shift : float
///     The step that the procedure is for, 0.1 to 5 standard deviations.
/// threshold : float
///     On ``ln(1 + R)``.
/// mean : float, default 0
///     The residual's mean in standard deviations.
///
/// Examples
/// --------
/// >>> from gtfdi import run_length
/// >>> threshold = run_length.shiryaev_roberts_threshold(1.0, 1000.0)
/// >>> round(run_length.shiryaev_roberts(1.0, threshold), 3)
/// 1000.0
#[pyfunction]
#[pyo3(signature = (shift, threshold, mean=0.0))]
pub fn shiryaev_roberts_run_length(
    py: Python<'_>,
    shift: f64,
    threshold: f64,
    mean: f64,
) -> Result<f64, Failure> {
    let run = ShiryaevRobertsRunLength::new(shift, threshold)?;
    interruptible(py, move |_| Ok(run.samples(mean)?))
}

/// The threshold on ``ln(1 + R)`` with that many samples between false alarms in the mean.
///
/// Parameters
/// ----------
/// shift : float
///     The step that the procedure is for, 0.1 to 5 standard deviations.
/// run_length : float
///     In samples.
///
/// Examples
/// --------
/// >>> from gtfdi import run_length
/// >>> # Below ln(1 + 1000), which is always safe.
/// >>> run_length.shiryaev_roberts_threshold(1.0, 1000.0) < np.log(1001.0)
/// np.True_
#[pyfunction]
pub fn shiryaev_roberts_threshold(
    py: Python<'_>,
    shift: f64,
    run_length: f64,
) -> Result<f64, Failure> {
    interruptible(py, move |_| {
        Ok(ShiryaevRobertsRunLength::threshold_for(shift, run_length)?)
    })
}

/// The least mean delay, in samples, that any detector has with that many samples between false
/// alarms, for a step or ramp of known size and unknown onset.
///
/// Parameters
/// ----------
/// waveform : {"step", "ramp"}
///     How the fault moves the mean.
/// size : float
///     Standard deviations of a step, standard deviations a sample of a ramp.
/// run_length : float
///     Samples between false alarms in the mean.
///
/// Examples
/// --------
/// >>> from gtfdi import run_length
/// >>> threshold = run_length.cusum_threshold(0.5, 1e5, "upper")
/// >>> run_length.mean_delay_bound("step", 1.0, 1e5) < run_length.cusum(0.5, threshold, 1.0, "upper")
/// True
#[pyfunction]
pub fn mean_delay_bound(waveform: &str, size: f64, run_length: f64) -> Result<f64, Failure> {
    Ok(bound(self::waveform(waveform)?, size, run_length)?)
}
