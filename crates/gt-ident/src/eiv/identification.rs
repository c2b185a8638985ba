//! From a record to an errors-in-variables model, the choice of the order included.

use std::ops::RangeInclusive;

use gt_core::{Dataset, Never, Stop};

use super::{Eiv, EivLags, EivModel, EivOrderTable, EivRemark, eiv_order_table_until};
use crate::frisch::{CriterionKind, Frisch};
use crate::{IdentError, OrderChoice};

/// Orders that [`OrderChoice::Automatic`] looks at; a larger smallest lag of an input moves both.
const AUTOMATIC_ORDERS: RangeInclusive<usize> = 1..=6;

/// How the noise is told from the relation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EivMethod {
    /// By maximum likelihood, [`Eiv`].
    Likelihood {
        /// Order of the autoregression behind the spectrum, where it is not [`Eiv`]'s own.
        autoregression_order: Option<usize>,
        /// Points of the likelihood, where they are not [`Eiv`]'s own.
        frequencies: Option<usize>,
        /// Weight of the prior on the poles, see [`Eiv::pole_prior`].
        pole_prior: f64,
    },
    /// By the Frisch scheme, [`Frisch::fit_shared`].
    Frisch(CriterionKind),
}

impl Default for EivMethod {
    /// Maximum likelihood with the options of its own.
    fn default() -> Self {
        Self::Likelihood {
            autoregression_order: None,
            frequencies: None,
            pole_prior: 0.0,
        }
    }
}

/// An errors-in-variables model that is still to be identified, every output of the same order.
///
/// | Name | Default | Purpose | Range |
/// |---|---|---|---|
/// | `order` | none | order of every output's relation | `1..` |
/// | `nk` | 1 | smallest lag of an input; one entry for all inputs or one per input | at most the order |
/// | `method` | maximum likelihood | how the noise is told from the relation | [`EivMethod`] |
#[derive(Debug, Clone, PartialEq)]
pub struct EivIdentification {
    order: OrderChoice,
    nk: Vec<usize>,
    method: EivMethod,
}

/// An identified model with what it was chosen by and what there is to say about it.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedEiv {
    /// The model.
    pub model: EivModel,
    /// What the orders were compared by, where they were.
    pub orders: Option<EivOrderTable>,
    /// What a user should know.
    pub remarks: Vec<EivRemark>,
}

impl EivIdentification {
    /// A model of the given order or of the best of some, by maximum likelihood.
    ///
    /// Orders are compared by the BIC of the likelihood ([`eiv_order_table`](super::eiv_order_table)), whatever the method;
    /// an automatic choice looks at 1 to 6, without those that the record is too short for or that an
    /// input's smallest lag exceeds (at least at one). The table of orders has the autoregression and
    /// the frequencies of its own, and no prior; those of [`EivMethod::Likelihood`] are for the last fit.
    pub fn new(order: OrderChoice) -> Self {
        Self {
            order,
            nk: vec![1],
            method: EivMethod::default(),
        }
    }

    /// The same model with other smallest lags of the inputs: one entry for all, or one per input.
    #[must_use]
    pub fn nk(mut self, nk: Vec<usize>) -> Self {
        self.nk = nk;
        self
    }

    /// The same model by another method.
    #[must_use]
    pub fn method(mut self, method: EivMethod) -> Self {
        self.method = method;
        self
    }

    /// Identifies the relations of all outputs and the noise of all channels.
    ///
    /// # Errors
    /// [`IdentError::EivOrder`] or [`IdentError::EivLag`] for lags that make no relation; as
    /// [`eiv_order_table`](super::eiv_order_table), [`Eiv::fit`], [`Frisch::fit_shared`] and [`EivModel::from_rows`].
    pub fn identify(&self, data: &Dataset) -> Result<IdentifiedEiv, IdentError> {
        self.identify_until(data, &Never)
    }

    /// As [`EivIdentification::identify`], until `stop` wants it to end.
    ///
    /// # Errors
    /// As [`EivIdentification::identify`]; [`IdentError::Stopped`].
    pub fn identify_until(
        &self,
        data: &Dataset,
        stop: &dyn Stop,
    ) -> Result<IdentifiedEiv, IdentError> {
        let nk = match self.nk[..] {
            [lag] => vec![lag; data.nu()],
            _ => self.nk.clone(),
        };
        let mut remarks = Vec::new();
        let (order, orders) = match &self.order {
            OrderChoice::Given(order) => (*order, None),
            OrderChoice::Search(orders) => {
                let table = eiv_order_table_until(data, orders.clone(), &nk, stop)?;
                (table.best_bic(), Some(table))
            }
            OrderChoice::Automatic => {
                let table = as_far_as_the_record_bears(data, &nk, stop)?;
                let highest = table.rows.last().map_or(0, |row| row.order);
                if highest < *AUTOMATIC_ORDERS.end() {
                    let samples = data.len();
                    remarks.push(EivRemark::NoHigherOrder { samples, highest });
                }
                (table.best_bic(), Some(table))
            }
        };
        let lags = EivLags::new(order, nk)?;
        let model = match self.method {
            EivMethod::Likelihood {
                autoregression_order,
                frequencies,
                pole_prior,
            } => {
                let mut eiv = Eiv::new(vec![lags; data.ny()]).pole_prior(pole_prior);
                if let Some(order) = autoregression_order {
                    eiv = eiv.autoregression_order(order);
                }
                if let Some(count) = frequencies {
                    eiv = eiv.frequencies(count);
                }
                let found = eiv.fit_until(data, stop)?;
                if found.short_record {
                    let samples = data.len();
                    remarks.push(EivRemark::ShortRecord { samples });
                }
                if !found.converged {
                    remarks.push(EivRemark::NotConverged);
                }
                found.model(data)?
            }
            EivMethod::Frisch(kind) => {
                let scheme = Frisch::new(lags).criterion(kind.criterion(order));
                scheme.fit_shared_until(data, stop)?.model(data)?
            }
        };
        remarks.extend(model.not_told());
        Ok(IdentifiedEiv {
            model,
            orders,
            remarks,
        })
    }
}

/// The table of [`AUTOMATIC_ORDERS`], of as many as the record is long enough for.
fn as_far_as_the_record_bears(
    data: &Dataset,
    nk: &[usize],
    stop: &dyn Stop,
) -> Result<EivOrderTable, IdentError> {
    let first = nk
        .iter()
        .copied()
        .fold(*AUTOMATIC_ORDERS.start(), usize::max);
    let mut last = first.max(*AUTOMATIC_ORDERS.end());
    loop {
        match eiv_order_table_until(data, first..=last, nk, stop) {
            Err(IdentError::EivTooFewSamples { .. }) if last > first => last -= 1,
            result => return result,
        }
    }
}
