//! A statistical test on the residuals of one or several outputs, calibrated on healthy records.

use gt_core::Dataset;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::calibration::{Calibration, FalseAlarmSummary, calibrate, calibrate_held, check_finite};
use super::false_alarm::{FalseAlarmRate, count_alarms};
use super::generator::ResidualGenerator;
use super::mean_time::MeanTime;
use super::statistic_kind::StatisticKind;
use super::tail::Tail;
use super::threshold::{FixedThreshold, ThresholdRule};
use super::whitening::Whitening;
use crate::FdiError;
use crate::runtime::{Persistence, Statistic, StatisticError};

/// Folds of a cross-validation: a single record is cut into as many contiguous blocks, more records
/// than that share them.
const FOLDS: usize = 5;

/// What a test computes of the residuals that it watches.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Evaluation {
    /// How the residuals become white; `None`: one residual in its unit, as it is.
    pub whitening: Option<Whitening>,
    /// The statistic.
    pub statistic: StatisticKind,
}

/// A test on the residuals of some outputs with its limit, and the false alarms counted when that
/// was set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResidualTest {
    /// The test's name; that of the output where it watches one.
    pub name: String,
    /// Tags of the outputs whose residuals it watches.
    pub outputs: Vec<String>,
    /// From the residuals to a number.
    pub evaluation: Evaluation,
    /// The limit on that number.
    pub threshold: FixedThreshold,
    /// The false alarms counted when the limit was set.
    pub false_alarms: FalseAlarmSummary,
}

impl ResidualTest {
    /// The paper's test of one generator's only residual as it is (eq. 26), with a limit calibrated
    /// elsewhere.
    pub fn modulus(generator: &ResidualGenerator, calibration: &Calibration) -> Self {
        let tag = &generator.outputs()[0].name;
        Self {
            name: tag.clone(),
            outputs: vec![tag.clone()],
            evaluation: Evaluation {
                whitening: None,
                statistic: StatisticKind::Modulus,
            },
            threshold: calibration.threshold,
            false_alarms: calibration.summary(),
        }
    }

    /// A test named `name` on all residuals of `generators` together, calibrated on healthy
    /// records: their residuals without the samples in which a generator settles.
    ///
    /// - **One residual, [`StatisticKind::Modulus`]**: the residual as it is, in its unit.
    /// - **One residual, any other statistic**: the residual whitened, colour and all
    ///   ([`Whitening::estimate`]).
    /// - **Several residuals**: the norm of the residuals whitened among themselves, which is the
    ///   root of `e' L^-1 e`; the colour is left to the calibration.
    ///
    /// Whitening and limit are cross-validated in five folds: the values that set the limit are
    /// those of each fold with the whitening of the others, because a covariance always fits its own
    /// record best. (Where the false alarms of a fold are counted, the limit is that of the values of
    /// the others, whose whitening has seen the fold.) Values of windows that are not yet full do not
    /// count. With [`ThresholdRule::MeanTimeBetweenFalseAlarms`] and a statistic with memory
    /// the limit is the larger of two: that for white residuals, and that which the peaks of the
    /// statistic on the healthy records ask for, with what they promise in
    /// [`FalseAlarmSummary::mean_time`].
    ///
    /// # Errors
    /// As [`ResidualGenerator::residuals`], [`Whitening::estimate`] and [`calibrate`], whose sample
    /// indices count from the end of the settling; besides when a record is not longer than that,
    /// and [`FdiError::SignedStatistic`] of several residuals.
    pub fn calibrate(
        name: impl Into<String>,
        generators: &[&ResidualGenerator],
        healthy: &[Dataset],
        statistic: StatisticKind,
        rule: ThresholdRule,
    ) -> Result<Self, FdiError> {
        let optimism = DMatrix::from_element(generators.len(), healthy.len(), 1.0);
        Self::calibrate_in_sample(name, generators, healthy, &optimism, statistic, rule)
    }

    /// As [`ResidualTest::calibrate`], for healthy records from which models were identified: a
    /// model fits its own record better than any other, so the residuals of generator `i` over
    /// record `j` count `optimism[(i, j)]` times (generators x records; 1 for other records).
    ///
    /// # Errors
    /// As [`ResidualTest::calibrate`]; [`gt_core::DimensionError`] for another size of `optimism`,
    /// [`FdiError::Option`] where it is below 1 or not finite.
    pub fn calibrate_in_sample(
        name: impl Into<String>,
        generators: &[&ResidualGenerator],
        healthy: &[Dataset],
        optimism: &DMatrix<f64>,
        statistic: StatisticKind,
        rule: ThresholdRule,
    ) -> Result<Self, FdiError> {
        check_optimism(optimism, generators.len(), healthy.len())?;
        rule.validate()?;
        statistic.validate()?;
        let signals = generators.iter().flat_map(|generator| generator.outputs());
        let outputs: Vec<String> = signals.map(|signal| signal.name.clone()).collect();
        let Some(first) = generators.first() else {
            return Err(FdiError::EmptyBank { name: name.into() });
        };
        check_several(statistic, outputs.len())?;
        let sample_time_s = first.sample_time_s();
        let residuals = settled_residuals(generators, healthy, optimism)?;
        let (whitening, calibration, mean_time) =
            if outputs.len() == 1 && statistic == StatisticKind::Modulus {
                let rows: Vec<&[f64]> = residuals.iter().map(DMatrix::as_slice).collect();
                (None, calibrate(&rows, sample_time_s, rule)?, None)
            } else {
                let colour = outputs.len() == 1;
                let folds = Folds::new(&residuals, statistic, colour)?;
                let (calibration, mean_time) = folds.calibrate(sample_time_s, rule)?;
                (Some(folds.whitening()?), calibration, mean_time)
            };
        let test = Self {
            name: name.into(),
            outputs,
            evaluation: Evaluation {
                whitening,
                statistic,
            },
            threshold: calibration.threshold,
            false_alarms: FalseAlarmSummary {
                mean_time,
                ..calibration.summary()
            },
        };
        test.validate()?;
        Ok(test)
    }

    /// Refuses a bad limit or statistic, and a whitening of another size than the outputs.
    ///
    /// # Errors
    /// [`FdiError`].
    pub fn validate(&self) -> Result<(), FdiError> {
        self.threshold.validate()?;
        self.evaluation.statistic.validate()?;
        if self.outputs.is_empty() {
            return Err(FdiError::EmptyBank {
                name: self.name.clone(),
            });
        }
        if self.evaluation.statistic != StatisticKind::Modulus && self.threshold.limit <= 0.0 {
            let found = self.threshold.limit;
            return Err(StatisticError::Threshold { found }.into());
        }
        check_several(self.evaluation.statistic, self.outputs.len())?;
        let size = self
            .evaluation
            .whitening
            .as_ref()
            .map_or(1, |whitening| whitening.mean().len());
        let what = format!("outputs of the test `{}`", self.name);
        Ok(gt_core::DimensionError::check(
            &what,
            size,
            self.outputs.len(),
        )?)
    }

    /// How many samples an alarm waits for and outlives its cause.
    pub fn persistence(&self) -> Persistence {
        Persistence {
            consecutive: self.threshold.consecutive,
            release: self.evaluation.statistic.release(),
        }
    }
}

/// The residuals of all generators (m x N) over each record, settling cut off.
fn settled_residuals(
    generators: &[&ResidualGenerator],
    healthy: &[Dataset],
    optimism: &DMatrix<f64>,
) -> Result<Vec<DMatrix<f64>>, FdiError> {
    let settles = generators
        .iter()
        .map(|generator| generator.settle_samples());
    let settle = settles.max().unwrap_or(0);
    let rows: usize = generators
        .iter()
        .map(|generator| generator.outputs().len())
        .sum();
    let mut residuals = Vec::with_capacity(healthy.len());
    for (record, data) in healthy.iter().enumerate() {
        if data.len() <= settle {
            return Err(FdiError::HealthySamples {
                record,
                needed: settle + 1,
                found: data.len(),
            });
        }
        let mut all = DMatrix::zeros(rows, data.len());
        let mut first = 0;
        for (index, generator) in generators.iter().enumerate() {
            let own = generator.residuals(data)? * optimism[(index, record)];
            all.rows_mut(first, own.nrows()).copy_from(&own);
            first += own.nrows();
        }
        let settled = all.columns(settle, data.len() - settle).into_owned();
        for row in settled.row_iter() {
            let values: Vec<f64> = row.iter().copied().collect();
            check_finite(&format!("healthy residual {record}"), &values)?;
        }
        residuals.push(settled);
    }
    Ok(residuals)
}

fn check_several(statistic: StatisticKind, found: usize) -> Result<(), FdiError> {
    if found == 1 || statistic.takes_several() {
        return Ok(());
    }
    Err(FdiError::SignedStatistic { found })
}

fn check_optimism(optimism: &DMatrix<f64>, rows: usize, columns: usize) -> Result<(), FdiError> {
    gt_core::DimensionError::check("rows of the optimism", rows, optimism.nrows())?;
    gt_core::DimensionError::check("columns of the optimism", columns, optimism.ncols())?;
    let bad = |factor: &&f64| !(factor.is_finite() && **factor >= 1.0);
    match optimism.iter().find(bad) {
        Some(&found) => Err(FdiError::Option {
            option: "optimism",
            expected: "a finite factor not below 1",
            found,
        }),
        None => Ok(()),
    }
}

/// Healthy residuals in folds, with the statistic of each under the whitening of the others.
struct Folds {
    records: Vec<Vec<DMatrix<f64>>>,
    /// Of each fold's records.
    values: Vec<Vec<Vec<f64>>>,
    statistic: StatisticKind,
    colour: bool,
}

impl Folds {
    fn new(
        residuals: &[DMatrix<f64>],
        statistic: StatisticKind,
        colour: bool,
    ) -> Result<Self, FdiError> {
        let mut records: Vec<Vec<DMatrix<f64>>> = Vec::new();
        match residuals {
            [] => return Err(FdiError::NoHealthyData),
            [single] => {
                let edge = |fold: usize| fold * single.ncols() / FOLDS;
                for fold in 0..FOLDS {
                    let (start, end) = (edge(fold), edge(fold + 1));
                    records.push(vec![single.columns(start, end - start).into_owned()]);
                }
            }
            several => {
                records.resize(several.len().min(FOLDS), Vec::new());
                for (index, record) in several.iter().enumerate() {
                    records[index % FOLDS].push(record.clone());
                }
            }
        }
        let mut folds = Self {
            records,
            values: Vec::new(),
            statistic,
            colour,
        };
        for fold in 0..folds.records.len() {
            let whitening = Whitening::estimate(&folds.others(fold), colour)?;
            let own = folds.records[fold].iter();
            let values = own.map(|record| folds.values_of(record, &whitening));
            let values = values.collect::<Result<_, FdiError>>()?;
            folds.values.push(values);
        }
        Ok(folds)
    }

    fn others(&self, fold: usize) -> Vec<&DMatrix<f64>> {
        let folds = self.records.iter().enumerate();
        let kept = folds.filter(|(index, _)| *index != fold);
        kept.flat_map(|(_, records)| records).collect()
    }

    fn whitening(&self) -> Result<Whitening, FdiError> {
        let all: Vec<&DMatrix<f64>> = self.records.iter().flatten().collect();
        Whitening::estimate(&all, self.colour)
    }

    fn residuals(&self) -> usize {
        self.records[0][0].nrows()
    }

    /// The values of the statistic over a record, without the samples before the whitening has its
    /// past.
    fn values_of(
        &self,
        record: &DMatrix<f64>,
        whitening: &Whitening,
    ) -> Result<Vec<f64>, FdiError> {
        let mut whitener = whitening.runtime();
        let mut evaluator = self.statistic.evaluator(1.0)?;
        let places: Vec<usize> = (0..record.nrows()).collect();
        let skipped = whitening.order() + self.statistic.warm_up();
        if record.ncols() <= skipped {
            return Err(FdiError::ShortFold {
                needed: skipped + 1,
                found: record.ncols(),
            });
        }
        let mut values = Vec::with_capacity(record.ncols());
        for (sample, column) in record.column_iter().enumerate() {
            let residual = whitener.step(column.clone_owned().as_slice(), &places);
            if sample >= whitening.order() {
                let value = evaluator.step(residual).value.max(0.0);
                if sample >= skipped {
                    values.push(value);
                }
            }
        }
        Ok(values)
    }

    fn calibrate(
        &self,
        sample_time_s: f64,
        rule: ThresholdRule,
    ) -> Result<(Calibration, Option<MeanTime>), FdiError> {
        let (hours, consecutive) = match rule {
            ThresholdRule::MeanTimeBetweenFalseAlarms { hours, consecutive }
                if self.statistic != StatisticKind::Modulus =>
            {
                (hours, consecutive)
            }
            _ => {
                let series: Vec<&[f64]> = self.values.iter().flatten().map(Vec::as_slice).collect();
                let release = self.statistic.release();
                return Ok((calibrate_held(&series, sample_time_s, rule, release)?, None));
            }
        };
        if consecutive > 1 {
            // The peaks say when a statistic crosses its limit, not how long it stays there.
            return Err(FdiError::Option {
                option: "consecutive",
                expected: "1 where a statistic with memory has a mean time between false alarms",
                found: consecutive as f64,
            });
        }
        let run_length = hours * 3600.0 / sample_time_s;
        let white = self.statistic.white_limit(self.residuals(), run_length)?;
        let tail = self.tail(None, run_length);
        let limit = self.limit(tail.as_ref().ok(), white, run_length);
        let threshold = FixedThreshold {
            limit,
            consecutive,
            rule,
        };
        threshold.validate()?;
        let wait = Persistence {
            consecutive,
            release: self.statistic.release(),
        };
        let (mut alarms, mut cross_alarms, mut above, mut samples) = (0, 0, 0, 0);
        for fold in 0..self.values.len() {
            let tail = self.tail(Some(fold), run_length);
            let cross = self.limit(tail.as_ref().ok(), white, run_length);
            for values in &self.values[fold] {
                alarms += count_alarms(values, limit, wait);
                cross_alarms += count_alarms(values, cross, wait);
                above += values.iter().filter(|&&value| value > cross).count();
                samples += values.len();
            }
        }
        let healthy_hours = samples as f64 * sample_time_s / 3600.0;
        let on_tail = self.statistic.to_tail(limit, self.residuals());
        let mean_time = MeanTime::of(
            hours,
            sample_time_s,
            healthy_hours,
            self.statistic.release(),
            tail.ok().map(|tail| (tail, on_tail)),
        );
        let calibration = Calibration {
            threshold,
            false_alarms: FalseAlarmRate::from_counts(alarms, healthy_hours)?,
            cross_validated: FalseAlarmRate::from_counts(cross_alarms, healthy_hours)?,
            cross_validated_exceedance_share: above as f64 / samples as f64,
        };
        Ok((calibration, Some(mean_time)))
    }

    /// The tail of the statistic over all folds but one.
    fn tail(&self, excluded: Option<usize>, run_length: f64) -> Result<Tail, FdiError> {
        let folds = self.values.iter().enumerate();
        let kept = folds.filter(|(index, _)| Some(*index) != excluded);
        let scaled: Vec<Vec<f64>> = kept
            .flat_map(|(_, records)| records)
            .map(|values| {
                let scaled = values.iter();
                scaled
                    .map(|&value| self.statistic.to_tail(value, self.residuals()))
                    .collect()
            })
            .collect();
        let series: Vec<&[f64]> = scaled.iter().map(Vec::as_slice).collect();
        Tail::fit(&series, self.statistic.release(), run_length)
    }

    fn limit(&self, tail: Option<&Tail>, white: f64, run_length: f64) -> f64 {
        tail.map_or(white, |tail| {
            let real = tail.limit_for(run_length);
            white.max(self.statistic.value_of_tail(real, self.residuals()))
        })
    }
}
