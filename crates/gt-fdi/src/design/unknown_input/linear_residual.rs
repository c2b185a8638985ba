//! A residual generator of any linear form.

use gt_core::{Dataset, DimensionError, OperatingPoint, Signal, StateSpace};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::super::channels::{Channels, check_unique, names};
use super::super::generator::{MAX_SETTLE_SAMPLES, SETTLE_LEVEL};
use super::super::settling::{settling, spectral_radius};
use crate::FdiError;

/// Residuals `r (nr)` as a stable linear system driven by the deviations of measured inputs and
/// outputs from their operating point: `z(t+1) = A z + B [u - u0; y - y0]`,
/// `r(t) = C z + D [u - u0; y - y0]`, from `z(0) = 0`.
///
/// [`super::super::ResidualGenerator`] is the special case that the online detector runs.
/// Construction and deserialisation both check that the sizes fit and that the system settles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct LinearResidual {
    system: StateSpace,
    point: OperatingPoint,
    #[serde(skip)]
    settle_samples: usize,
}

/// The fields of a [`LinearResidual`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    system: StateSpace,
    point: OperatingPoint,
}

impl TryFrom<Unchecked> for LinearResidual {
    type Error = FdiError;

    fn try_from(raw: Unchecked) -> Result<Self, FdiError> {
        Self::new(raw.system, raw.point)
    }
}

impl LinearResidual {
    /// A checked generator: the inputs of `system` are the `nu` inputs of `point` and, after them,
    /// its `ny` outputs.
    ///
    /// # Errors
    /// [`FdiError::Dimension`] when the sizes disagree, [`FdiError::NotFinite`] of the operating
    /// point, [`FdiError::DuplicateTag`], [`FdiError::DoesNotSettle`].
    pub fn new(system: StateSpace, point: OperatingPoint) -> Result<Self, FdiError> {
        let channels = point.u.len() + point.y.len();
        DimensionError::check("inputs of the system [u; y]", channels, system.nu())?;
        for (place, signals) in [
            ("channels of a residual generator", system.inputs()),
            ("residuals of a generator", system.outputs()),
        ] {
            let tags: Vec<&String> = signals.iter().map(|signal| &signal.name).collect();
            check_unique(place, &tags)?;
        }
        let names: Vec<&str> = (system.outputs().iter())
            .map(|signal| signal.name.as_str())
            .collect();
        let output = names.join(", ");
        let numbers = [
            ("operating point u", point.u.as_slice()),
            ("operating point y", point.y.as_slice()),
        ];
        for (what, values) in numbers {
            if let Some(&found) = values.iter().find(|value| !value.is_finite()) {
                return Err(FdiError::NotFinite {
                    output,
                    what,
                    found,
                });
            }
        }
        let Some(settle_samples) = settling(system.a()) else {
            return Err(FdiError::DoesNotSettle {
                output,
                level: SETTLE_LEVEL,
                limit: MAX_SETTLE_SAMPLES,
                spectral_radius: spectral_radius(system.a()),
            });
        };
        Ok(Self {
            system,
            point,
            settle_samples,
        })
    }

    /// The system from `[u - u0; y - y0]` to `r`.
    pub fn system(&self) -> &StateSpace {
        &self.system
    }

    /// The operating point `u0 (nu)`, `y0 (ny)`.
    pub fn point(&self) -> &OperatingPoint {
        &self.point
    }

    /// The measured inputs (nu).
    pub fn inputs(&self) -> &[Signal] {
        &self.system.inputs()[..self.point.u.len()]
    }

    /// The measured outputs (ny).
    pub fn outputs(&self) -> &[Signal] {
        &self.system.inputs()[self.point.u.len()..]
    }

    /// The residuals (nr).
    pub fn residual_signals(&self) -> &[Signal] {
        self.system.outputs()
    }

    /// Sample time in seconds.
    pub fn sample_time_s(&self) -> f64 {
        self.system.sample_time_s()
    }

    /// Samples after which a wrong initial state is forgotten, as of
    /// [`super::super::ResidualGenerator::settle_samples`].
    pub fn settle_samples(&self) -> usize {
        self.settle_samples
    }

    /// The residuals (nr x N) of a record that has the generator's channels, by name, in any order
    /// and among others; the first [`LinearResidual::settle_samples`] hold the initial transient.
    ///
    /// A sample with a missing channel gives NaN for all residuals and begins a new transient.
    ///
    /// # Errors
    /// [`FdiError::MissingTags`] and [`FdiError::SampleTime`] when the record does not fit.
    pub fn residuals(&self, data: &Dataset) -> Result<DMatrix<f64>, FdiError> {
        let (inputs, outputs) = (names(self.inputs()), names(self.outputs()));
        let mut channels = Channels::of(data, self.sample_time_s(), &inputs, &outputs)?;
        let (system, nu) = (&self.system, inputs.len());
        let mut v = DVector::zeros(system.nu());
        let mut z = DVector::zeros(system.nx());
        let mut residuals = DMatrix::zeros(system.ny(), data.len());
        for (sample, mut residual) in residuals.column_iter_mut().enumerate() {
            let (u, y) = channels.at(sample);
            v.rows_mut(0, nu).copy_from_slice(u);
            v.rows_mut(nu, y.len()).copy_from_slice(y);
            let mut inputs = v.rows_mut(0, nu);
            inputs -= &self.point.u;
            let mut outputs = v.rows_mut(nu, y.len());
            outputs -= &self.point.y;
            residual.copy_from(&(system.c() * &z + system.d() * &v));
            z = system.a() * z + system.b() * &v;
            if !residual
                .iter()
                .chain(z.iter())
                .chain(v.iter())
                .all(|value| value.is_finite())
            {
                residual.fill(f64::NAN);
                z.fill(0.0);
            }
        }
        Ok(residuals)
    }
}
