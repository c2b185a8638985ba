//! Differential evolution, in place of the paper's genetic algorithm.

use rand::{Rng, RngExt};

use super::energy_ratio::EnergyRatio;
use super::sections::Sections;
use super::start::from_cube;

/// Members of the population for each coefficient, and at least so many.
const MEMBERS_PER_COEFFICIENT: usize = 10;
const FEWEST_MEMBERS: usize = 20;
/// Generations after which the search ends.
const GENERATIONS: usize = 400;
/// The chance that a coefficient comes from the mutant.
const CROSSOVER: f64 = 0.9;
/// The weight of a difference, drawn anew for each generation.
const WEIGHTS: [f64; 2] = [0.5, 0.9];
/// How far the worst member's value may be from the best, relative to it, at the end.
const SPREAD: f64 = 1e-10;

/// The best sections found, their value and the evaluations spent: R. Storn, K. Price, *Differential
/// evolution*, Journal of Global Optimization 11 (1997), scheme `rand/1/bin` with dithered weights
/// on the unit cube of [`from_cube`], whose faces catch what leaves it.
pub(super) fn evolve(
    ratio: &EnergyRatio,
    radius: f64,
    rng: &mut impl Rng,
) -> (Sections, f64, usize) {
    let order = ratio.order();
    let size = (MEMBERS_PER_COEFFICIENT * order).max(FEWEST_MEMBERS);
    let value_of = |member: &[f64]| {
        let value = ratio.value(&from_cube(member, radius));
        if value.is_nan() { f64::INFINITY } else { value }
    };
    let mut members: Vec<Vec<f64>> = (0..size)
        .map(|_| (0..order).map(|_| rng.random::<f64>()).collect())
        .collect();
    let mut values: Vec<f64> = members.iter().map(|member| value_of(member)).collect();
    let mut evaluations = size;
    for _ in 0..GENERATIONS {
        let best = values.iter().copied().fold(f64::INFINITY, f64::min);
        let worst = values.iter().copied().fold(0.0, f64::max);
        if worst - best <= SPREAD * best {
            break;
        }
        let weight = rng.random_range(WEIGHTS[0]..WEIGHTS[1]);
        for target in 0..size {
            let [base, plus, minus] = others(size, target, rng);
            let kept = rng.random_range(0..order);
            let trial: Vec<f64> = (0..order)
                .map(|k| {
                    let crossed = rng.random::<f64>() < CROSSOVER;
                    if crossed || k == kept {
                        let mutant =
                            members[base][k] + weight * (members[plus][k] - members[minus][k]);
                        mutant.clamp(0.0, 1.0)
                    } else {
                        members[target][k]
                    }
                })
                .collect();
            let value = value_of(&trial);
            evaluations += 1;
            if value <= values[target] {
                members[target] = trial;
                values[target] = value;
            }
        }
    }
    let best = (0..size).fold(0, |best, index| {
        if values[index] < values[best] {
            index
        } else {
            best
        }
    });
    (from_cube(&members[best], radius), values[best], evaluations)
}

/// Three different members that are not the target.
fn others(size: usize, target: usize, rng: &mut impl Rng) -> [usize; 3] {
    let mut chosen = [target; 3];
    for place in 0..chosen.len() {
        loop {
            let index = rng.random_range(0..size);
            if index != target && !chosen[..place].contains(&index) {
                chosen[place] = index;
                break;
            }
        }
    }
    chosen
}
