//! A limit that gives way while the inputs move.

use alloc::boxed::Box;
use alloc::vec;

use serde::{Deserialize, Serialize};

use super::statistic::{Decision, LARGEST_SAMPLE};
use super::{StatisticError, check_option, check_state};

/// A limit on the modulus of a residual that follows how much the inputs move:
/// `limit = base + a`, `a = q a + sum_j g_j |u_j - u_j before|`, with `q = exp(-1 / time_constant)`.
///
/// A model that is a little wrong makes a residual while the plant moves, which a fixed limit must
/// be wide enough for at all times. When the residual that the model's error makes after a unit step
/// of input `j` stays below `g_j q^k` after `k` samples, then by superposition that after any inputs
/// stays below `a`, and the limit holds what the fixed limit `base` holds at rest. The terms are
/// also an upper bound on the inputs passed through the high pass `h = q h + (u - u before)`: `|h|`
/// is at most the same sum with `g = 1`.
///
/// That thresholds should follow the inputs is from Emami-Naeini, Akhter and Rock (*IEEE
/// Transactions on Automatic Control* 33, 1988); this form is the bound just derived.
///
/// It stands beside a residual and an input vector, so that it is no
/// [`Statistic`](super::Statistic), but it steps like one. The value is `|r| / limit`, and the alarm
/// is up while it is above 1. The residual is in any unit, which is that of `base`. A sample whose
/// residual or any of whose inputs is NaN or infinite changes nothing and is flagged; the next input
/// is compared with the last valid one. After the first sample, and the first after a reset, the
/// inputs count as at rest.
///
/// ```
/// use gt_fdi::AdaptiveThreshold;
///
/// let mut threshold = AdaptiveThreshold::new(2.0, &[0.5], 10.0)?;
/// assert!(threshold.step(&[100.0], 3.0)?.alarm);
/// // A step of 4 in the input: the limit is 2 + 0.5 x 4.
/// assert!(!threshold.step(&[104.0], 3.0)?.alarm);
/// assert_eq!(threshold.limit(), 4.0);
/// // Ten samples later it has come back by the factor 1 / e.
/// for _ in 0..10 {
///     threshold.step(&[104.0], 0.0)?;
/// }
/// assert!((threshold.limit() - 2.0 - 2.0 * (-1.0_f64).exp()).abs() < 1e-12);
/// # Ok::<(), gt_fdi::StatisticError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Saved", into = "Saved")]
pub struct AdaptiveThreshold {
    base: f64,
    gains: Box<[f64]>,
    time_constant: f64,
    /// `q`.
    decay: f64,
    /// `a`.
    allowance: f64,
    /// The last valid inputs; zeros before the first.
    inputs: Box<[f64]>,
    has_inputs: bool,
    value: f64,
}

/// What of an [`AdaptiveThreshold`] is saved: all else follows from it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    base: f64,
    gains: Box<[f64]>,
    time_constant: f64,
    allowance: f64,
    inputs: Option<Box<[f64]>>,
    value: f64,
}

impl From<AdaptiveThreshold> for Saved {
    fn from(threshold: AdaptiveThreshold) -> Self {
        Self {
            base: threshold.base,
            gains: threshold.gains,
            time_constant: threshold.time_constant,
            allowance: threshold.allowance,
            inputs: threshold.has_inputs.then_some(threshold.inputs),
            value: threshold.value,
        }
    }
}

impl TryFrom<Saved> for AdaptiveThreshold {
    type Error = StatisticError;

    fn try_from(saved: Saved) -> Result<Self, StatisticError> {
        let made = Self::new(saved.base, &saved.gains, saved.time_constant)?;
        let largest = if saved.inputs.is_some() {
            f64::MAX
        } else {
            0.0
        };
        check_state("allowance", saved.allowance, 0.0, largest)?;
        check_state("value", saved.value, 0.0, largest)?;
        let Some(inputs) = saved.inputs else {
            return Ok(made);
        };
        if inputs.len() != made.gains.len() {
            return Err(StatisticError::Length {
                what: "inputs",
                expected: made.gains.len(),
                found: inputs.len(),
            });
        }
        for &input in &inputs {
            check_state("input", input, -f64::MAX, f64::MAX)?;
        }
        Ok(Self {
            allowance: saved.allowance,
            inputs,
            has_inputs: true,
            value: saved.value,
            ..made
        })
    }
}

impl AdaptiveThreshold {
    /// A limit at rest of `base` (above 0, in the residual's unit), that gives way by the `gains`
    /// (0 or above, one an input, in the residual's unit per unit of the input) and comes back with
    /// the `time_constant` (above 0, in samples).
    ///
    /// # Errors
    /// [`StatisticError::Option`] for any that is out of range.
    pub fn new(base: f64, gains: &[f64], time_constant: f64) -> Result<Self, StatisticError> {
        for (option, found) in [("base", base), ("time_constant", time_constant)] {
            let fits = found > 0.0 && found.is_finite();
            check_option(option, "a positive finite number", found, fits)?;
        }
        for &gain in gains {
            let fits = gain >= 0.0 && gain.is_finite();
            check_option("gains", "finite numbers not below 0", gain, fits)?;
        }
        Ok(Self {
            base,
            gains: gains.into(),
            time_constant,
            decay: libm::exp(-1.0 / time_constant),
            allowance: 0.0,
            inputs: vec![0.0; gains.len()].into(),
            has_inputs: false,
            value: 0.0,
        })
    }

    /// Takes the inputs `u` and the residual `r` of one sample into account.
    ///
    /// # Errors
    /// [`StatisticError::Inputs`] for another number of inputs than of gains; nothing has changed
    /// then.
    pub fn step(&mut self, u: &[f64], r: f64) -> Result<Decision, StatisticError> {
        if u.len() != self.gains.len() {
            return Err(StatisticError::Inputs {
                expected: self.gains.len(),
                found: u.len(),
            });
        }
        let missing = !(r.is_finite() && u.iter().all(|u| u.is_finite()));
        if !missing {
            self.take(u, r.clamp(-LARGEST_SAMPLE, LARGEST_SAMPLE));
        }
        Ok(Decision {
            value: self.value,
            alarm: self.value > 1.0,
            missing,
        })
    }

    fn take(&mut self, u: &[f64], r: f64) {
        let mut allowance = self.decay * self.allowance;
        for ((before, &now), gain) in self.inputs.iter_mut().zip(u).zip(&self.gains) {
            if self.has_inputs {
                allowance += gain * (now - *before).abs().min(f64::MAX);
            }
            *before = now;
        }
        self.has_inputs = true;
        // Never reached by inputs in range; keeps the state finite.
        self.allowance = allowance.min(f64::MAX);
        self.value = (r.abs() / self.limit()).min(f64::MAX);
    }

    /// Forgets all samples.
    pub fn reset(&mut self) {
        self.allowance = 0.0;
        self.inputs.fill(0.0);
        self.has_inputs = false;
        self.value = 0.0;
    }

    /// The limit on the residual after the last sample, in the residual's unit.
    pub fn limit(&self) -> f64 {
        (self.base + self.allowance).min(f64::MAX)
    }

    /// `|r| / limit` after the last sample, which has no unit.
    pub fn value(&self) -> f64 {
        self.value
    }
}
