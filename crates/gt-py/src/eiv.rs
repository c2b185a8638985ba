//! `eiv` and `frisch`: models of records with noise on the inputs too.

use std::num::NonZeroUsize;

use gt_log::ModelKind;
use gtfdi::ident::eiv::{EivIdentification, EivMethod};
use gtfdi::ident::frisch::CriterionKind;
use pyo3::prelude::*;

use crate::choice::named;
use crate::dataset::Names;
use crate::eiv_model::PyEivModel;
use crate::error::Failure;
use crate::interrupt::interruptible;
use crate::order::{Numbers, Order, smallest_lags};
use crate::record::Given;
use crate::warning::warn;

/// Identifies by either method.
fn identify(
    (u, y): (&Bound<'_, PyAny>, Option<&Bound<'_, PyAny>>),
    (order, nk): (&Order, Option<Numbers>),
    (kind, method): (ModelKind, EivMethod),
    (inputs, outputs): (Option<Names>, Option<Names>),
    sample_time_s: Option<f64>,
) -> Result<PyEivModel, Failure> {
    let py = u.py();
    let wish = EivIdentification::new(order.read()?)
        .nk(smallest_lags(nk))
        .method(method);
    let data = Given::new(u, y)?.unknown(inputs, outputs, sample_time_s)?;
    let found = interruptible(py, move |abandoned| {
        Ok(wish.identify_until(&data, abandoned)?)
    })?;
    for remark in &found.remarks {
        warn(py, &remark.to_string())?;
    }
    Ok(PyEivModel {
        inner: found.model,
        kind,
        orders: found.orders,
    })
}

/// Identifies an errors-in-variables model by maximum likelihood: white noise of unknown variance
/// on every input and output, and a relation of each output between what the channels would be
/// without it.
///
/// Least squares takes the inputs as exact and is biased where they are not. What a reader should
/// know, such as a variance that the record does not tell, is issued as a ``UserWarning``. The lock
/// on the interpreter is released meanwhile.
///
/// Parameters
/// ----------
/// u : array_like, shape (N, nu), or Dataset
///     Inputs, or a whole record (then without ``y``).
/// y : array_like, shape (N, ny), optional
///     Outputs.
/// order : int, tuple of int or "auto"
///     Order n of every relation: lags 1 to n of its output and ``nk`` to n of each input. A pair
///     ``(low, high)`` searches by the likelihood's BIC, ``"auto"`` is ``(1, 6)`` as far as the
///     record bears it.
/// nk : int or list of int, default 1
///     Smallest lag of the inputs, one number or one an input.
/// autoregression_order : int, optional
///     Order of the autoregression behind the spectrum; chosen by the length of the record.
/// frequencies : int, optional
///     Points of the likelihood; 256, or 128 for several outputs.
/// pole_prior : float, default 0
///     Weight of a prior that keeps needless poles off the unit circle: 1 costs next to nothing where
///     the record tells all parameters, 10 holds those of far too high an order.
/// sample_time_s : float, optional
///     Sample time of the arrays, 1 where left out.
/// inputs, outputs : list of str, optional
///     Tags of the arrays' channels; of a Dataset, the channels to use.
///
/// Returns
/// -------
/// EivModel
///
/// Raises
/// ------
/// IdentError
///     The record does not determine the model; the message says why.
/// OptionError, DimensionError, DataError, ArrayTypeError
///     An option or the record cannot be used.
///
/// Examples
/// --------
/// >>> generator = np.random.default_rng(1)
/// >>> level, speed = np.zeros(2000), np.zeros(2000)
/// >>> for t in range(1, 2000):
/// ...     level[t] = 0.6 * level[t - 1] + generator.normal()
/// ...     speed[t] = 0.8 * speed[t - 1] + level[t - 1]
/// >>> noisy = level + generator.normal(0.0, 0.5, 2000)
/// >>> model = gtfdi.eiv(noisy, speed + generator.normal(0.0, 0.5, 2000), order=1)
/// >>> abs(model.noise_variances["u1"] - 0.25) < 4 * model.noise["u1"]["standard_error"]
/// True
#[pyfunction]
#[pyo3(signature = (u, y=None, *, order, nk=None, autoregression_order=None, frequencies=None,
    pole_prior=0.0, sample_time_s=None, inputs=None, outputs=None),
    text_signature = "(u, y=None, *, order, nk=1, autoregression_order=None, frequencies=None, \
    pole_prior=0.0, sample_time_s=None, inputs=None, outputs=None)")]
#[allow(clippy::too_many_arguments)] // Python names them
pub fn eiv(
    u: &Bound<'_, PyAny>,
    y: Option<&Bound<'_, PyAny>>,
    order: Order,
    nk: Option<Numbers>,
    autoregression_order: Option<NonZeroUsize>,
    frequencies: Option<NonZeroUsize>,
    pole_prior: f64,
    sample_time_s: Option<f64>,
    inputs: Option<Names>,
    outputs: Option<Names>,
) -> Result<PyEivModel, Failure> {
    let method = EivMethod::Likelihood {
        autoregression_order: autoregression_order.map(NonZeroUsize::get),
        frequencies: frequencies.map(NonZeroUsize::get),
        pole_prior,
    };
    identify(
        (u, y),
        (&order, nk),
        (ModelKind::Eiv, method),
        (inputs, outputs),
        sample_time_s,
    )
}

/// Identifies an errors-in-variables model by the Frisch scheme, from covariances alone: for a given
/// order quicker than ``gtfdi.eiv``, and less accurate.
///
/// Parameters
/// ----------
/// u, y, order, nk, sample_time_s, inputs, outputs
///     As for ``gtfdi.eiv``; orders are compared by its likelihood.
/// criterion : {"yule-walker", "covariance", "shift"}, default "yule-walker"
///     How the noise is chosen among the variances that the covariances admit: the residual does
///     not depend on older samples, it has the covariances of filtered white noise, or the relation
///     holds one sample later too.
///
/// Returns
/// -------
/// EivModel
///     Without standard errors of the coefficients.
///
/// Raises
/// ------
/// IdentError
///     The record does not determine the model; the message says why.
/// OptionError, DimensionError, DataError, ArrayTypeError
///     An option or the record cannot be used.
///
/// Examples
/// --------
/// >>> generator = np.random.default_rng(1)
/// >>> level, speed = np.zeros(2000), np.zeros(2000)
/// >>> for t in range(1, 2000):
/// ...     level[t] = 0.6 * level[t - 1] + generator.normal()
/// ...     speed[t] = 0.8 * speed[t - 1] + level[t - 1]
/// >>> noisy = level + generator.normal(0.0, 0.5, 2000)
/// >>> model = gtfdi.frisch(noisy, speed + generator.normal(0.0, 0.5, 2000), order=1)
/// >>> sorted(model.noise_variances)
/// ['u1', 'y1']
#[pyfunction]
#[pyo3(signature = (u, y=None, *, order, nk=None, criterion="yule-walker", sample_time_s=None,
    inputs=None, outputs=None),
    text_signature = "(u, y=None, *, order, nk=1, criterion='yule-walker', sample_time_s=None, \
    inputs=None, outputs=None)")]
#[allow(clippy::too_many_arguments)] // Python names them
pub fn frisch(
    u: &Bound<'_, PyAny>,
    y: Option<&Bound<'_, PyAny>>,
    order: Order,
    nk: Option<Numbers>,
    criterion: &str,
    sample_time_s: Option<f64>,
    inputs: Option<Names>,
    outputs: Option<Names>,
) -> Result<PyEivModel, Failure> {
    let criteria = [
        ("shift", CriterionKind::Shift),
        ("covariance", CriterionKind::Covariance),
        ("yule-walker", CriterionKind::YuleWalker),
    ];
    let method = EivMethod::Frisch(named("criterion", criterion, &criteria)?);
    identify(
        (u, y),
        (&order, nk),
        (ModelKind::Frisch, method),
        (inputs, outputs),
        sample_time_s,
    )
}
