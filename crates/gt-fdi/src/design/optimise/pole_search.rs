//! The search for an observer's poles.

use gt_core::{OperatingPoint, StateSpace};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::data_bound::DataBound;
use super::energy_ratio::{Criterion, EnergyRatio};
use super::error::SearchError;
use super::evolution::evolve;
use super::observer_design::{Attempt, ObserverDesign};
use super::record_pair::RecordPair;
use super::sections::Sections;
use super::sqp::descend;
use super::start::{Start, diagonal, equal, inner, random, vertices};
use crate::FdiError;

/// How the poles are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SearchMethod {
    /// Descents by sequential quadratic programming from many starts.
    Descent,
    /// Differential evolution, for the paper's genetic algorithm.
    Evolution,
}

/// How an observer's poles are chosen (the paper's Algorithm 1).
///
/// | option | default | purpose | range |
/// |---|---|---|---|
/// | `criterion` | `FaultEnergy` | what is minimised | |
/// | `method` | `Descent` | how | |
/// | `radius` | 0.97 | largest modulus of a pole | above 0, below 1 |
/// | `diagonal_starts` | 9 | starts with all poles at one real place | |
/// | `random_starts` | 20 | starts drawn from the polytope | |
/// | `seed` | 0 | of those draws and of the evolution | |
/// | `skip_samples` | 0 | samples at the start of a record that do not count | |
/// | `bound_pole` | 0.9 | of the bound's Laguerre functions | above -1, below 1 |
/// | `bound_functions` | 8 | their number | at least 1 |
///
/// Descents also begin at each vertex of the polytope of the radius, where minima often are and
/// which searches from inside miss, and at those of a smaller one. With any number of starts the
/// poles found are the best of several local minima. The cap on the radius is part of the problem: as
/// the paper states it, V has no minimum inside the unit circle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PoleSearch {
    /// What is minimised.
    pub criterion: Criterion,
    /// How.
    pub method: SearchMethod,
    /// Largest modulus of a pole, in (0, 1).
    pub radius: f64,
    /// Starts with all poles at one place on the real axis, evenly spaced.
    pub diagonal_starts: usize,
    /// Starts drawn from the polytope.
    pub random_starts: usize,
    /// Seed of the draws; a start is the same whatever the number of starts.
    pub seed: u64,
    /// Samples at the start of each record that are filtered but do not count.
    pub skip_samples: usize,
    /// Pole of the bound's Laguerre functions, in (-1, 1).
    pub bound_pole: f64,
    /// The number of the bound's Laguerre functions, at least 1.
    pub bound_functions: usize,
}

impl Default for PoleSearch {
    fn default() -> Self {
        Self {
            criterion: Criterion::FaultEnergy,
            method: SearchMethod::Descent,
            radius: 0.97,
            diagonal_starts: 9,
            random_starts: 20,
            seed: 0,
            skip_samples: 0,
            bound_pole: 0.9,
            bound_functions: 8,
        }
    }
}

impl PoleSearch {
    /// Refuses options that are out of range.
    ///
    /// # Errors
    /// [`FdiError::Option`] with the option, its range and the value found.
    pub fn validate(&self) -> Result<(), FdiError> {
        let refuse = |option, expected, found| {
            Err(FdiError::Option {
                option,
                expected,
                found,
            })
        };
        if !(self.radius > 0.0 && self.radius < 1.0) {
            return refuse("radius", "a radius above 0 and below 1", self.radius);
        }
        let pole = self.bound_pole;
        if !(pole > -1.0 && pole < 1.0) {
            return refuse("bound_pole", "a pole above -1 and below 1", pole);
        }
        if self.bound_functions == 0 {
            return refuse("bound_functions", "at least 1 function", 0.0);
        }
        Ok(())
    }

    /// Chooses the poles of the observer of a model with one output by the `training` pairs, and
    /// judges them by the `validation` pairs, which may be none and do not enter the choice.
    ///
    /// # Errors
    /// As [`PoleSearch::validate`] and [`EnergyRatio::new`]; [`SearchError::TooShort`] also when
    /// there are fewer samples than functions of the bound.
    pub fn design(
        &self,
        model: &StateSpace,
        point: &OperatingPoint,
        training: &[RecordPair],
        validation: &[RecordPair],
    ) -> Result<ObserverDesign, FdiError> {
        self.validate()?;
        let ratio = EnergyRatio::new(self.criterion, model, point, training, self.skip_samples)?;
        self.check_length(model.nx(), training)?;
        let held_out = if validation.is_empty() {
            None
        } else {
            let skip = self.skip_samples;
            let set = "validation";
            let pairs = validation;
            Some(EnergyRatio::of(
                set,
                self.criterion,
                model,
                point,
                pairs,
                skip,
            )?)
        };
        let (best, attempts) = match self.method {
            SearchMethod::Descent => self.descents(&ratio),
            SearchMethod::Evolution => {
                let mut rng = self.rng(0);
                let (sections, v, evaluations) = evolve(&ratio, self.radius, &mut rng);
                let start = Start::Evolution;
                let attempt = Attempt {
                    start,
                    v,
                    evaluations,
                };
                (sections, vec![attempt])
            }
        };
        let (pole, functions) = (self.bound_pole, self.bound_functions);
        let bound = DataBound::of(&ratio, held_out.as_ref(), &best, pole, functions)
            .ok_or(SearchError::Bound { functions, pole })?;
        // Attempts are never empty: the polytope has vertices.
        let first = attempts.iter().min_by(|l, r| l.v.total_cmp(&r.v));
        Ok(ObserverDesign {
            criterion: self.criterion,
            radius: self.radius,
            v: ratio.value(&best),
            v_validation: held_out.map(|records| records.value(&best)),
            poles: best.poles(),
            bound,
            evaluations: attempts.iter().map(|attempt| attempt.evaluations).sum(),
            start: first.map_or(Start::Evolution, |attempt| attempt.start),
            attempts,
        })
    }

    /// The best of the descents from all starts, the first of equally good ones.
    fn descents(&self, ratio: &EnergyRatio) -> (Sections, Vec<Attempt>) {
        let order = ratio.order();
        let corners = vertices(order, self.radius).into_iter().enumerate();
        let corners = corners.map(|(index, at)| (Start::Vertex { index }, at));
        let inside = vertices(order, inner(self.radius)).into_iter().enumerate();
        let inside = inside.map(|(index, at)| (Start::Inner { index }, at));
        let line = diagonal(self.diagonal_starts, self.radius).into_iter();
        let line = line.map(|pole| (Start::Diagonal { pole }, equal(order, pole)));
        let drawn = (0..self.random_starts).map(|index| {
            let mut rng = self.rng(1 + index as u64);
            (
                Start::Random { index },
                random(order, self.radius, &mut rng),
            )
        });
        let (mut best, mut least) = (equal(order, 0.0), f64::INFINITY);
        let mut attempts = Vec::new();
        for (start, at) in corners.chain(inside).chain(line).chain(drawn) {
            let found = descend(ratio, self.radius, at);
            attempts.push(Attempt {
                start,
                v: found.value,
                evaluations: found.evaluations,
            });
            if found.value < least {
                (best, least) = (found.sections, found.value);
            }
        }
        (best, attempts)
    }

    fn rng(&self, stream: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(stream);
        rng
    }

    /// Refuses records with fewer samples than the bound has unknowns.
    fn check_length(&self, nx: usize, training: &[RecordPair]) -> Result<(), SearchError> {
        let unknowns = self.bound_functions.saturating_add(nx + 1);
        let needed = self.skip_samples.saturating_add(unknowns);
        let lengths = training.iter().map(|records| records.healthy.len());
        match lengths.enumerate().find(|&(_, found)| found < needed) {
            Some((pair, found)) => Err(SearchError::TooShort {
                set: "training",
                pair,
                needed,
                found,
            }),
            None => Ok(()),
        }
    }
}
