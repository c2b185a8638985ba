//! Table 10 and the naming of faults: seeded Monte-Carlo with isolators.

use std::collections::BTreeMap;

use gtfdi::fdi::{FaultEffect, Waveform, mean_delay_bound};
use gtfdi::plant::{FaultCase, MapSet, NoiseLevel};
use serde::Serialize;

use super::detection_curves::{LEVELS, detection_curves};
use crate::error::{CampaignError, During as _};
use crate::isolation::{
    Ambient, DetectionLimit, LimitSearch, NamingStudy, NamingSummary, PaperScheme, Preparation,
    Prepared, Setting,
};
use crate::progress::{Progress, report_or_stop};
use crate::report::Figure;
use crate::{paper, parallel};

/// Time constant of the rotor alone, in seconds, which case 4's percent is of.
const ROTOR_S: f64 = 3.19;
/// Hours between false alarms of all statistics together.
const ARL0_HOURS: f64 = 24.0;
/// Probability of detection.
const DETECTION_PROBABILITY: f64 = 0.95;
/// Seconds in which the faults of the naming study grow.
const NAMING_S: f64 = 60.0;
/// Multiples of the limits in the naming study.
const MULTIPLES: [f64; 2] = [1.0, 4.0];

/// How much is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Depth {
    /// Few runs, wide intervals, the `paper` maps, without noise and with Table 8's.
    #[default]
    Short,
    /// Many runs, all levels of noise, both map sets, a varying ambient.
    Full,
}

/// How many runs there are of what.
struct Plan {
    healthy_hours: u64,
    runs: u64,
    /// Whether the mean delays of ramps that go on are measured.
    mean_delays: bool,
    settings: Vec<(MapSet, Ambient, NoiseLevel, u64)>,
}

impl Depth {
    /// Settings with the runs of their naming study.
    fn plan(self) -> Plan {
        use Ambient::{Constant, Measured};
        use MapSet::{Axial, Paper};
        use NoiseLevel::{None, Table8, Tables4And5};
        match self {
            Self::Short => Plan {
                healthy_hours: 8,
                runs: 20,
                mean_delays: false,
                settings: vec![(Paper, Constant, None, 0), (Paper, Constant, Table8, 60)],
            },
            Self::Full => Plan {
                healthy_hours: 16,
                runs: 120,
                mean_delays: true,
                settings: vec![
                    (Paper, Constant, None, 300),
                    (Paper, Constant, Table8, 1000),
                    (Paper, Constant, Tables4And5, 0),
                    (Axial, Constant, None, 300),
                    (Axial, Constant, Table8, 1000),
                    (Axial, Constant, Tables4And5, 0),
                    (Paper, Measured, None, 0),
                    (Paper, Measured, Table8, 0),
                ],
            },
        }
    }
}

impl Plan {
    /// The limits of all cases and delays, at the naming study's too where one follows, in order,
    /// with the positions of their cases.
    fn limits(
        &self,
        prepared: &Prepared,
        with_naming: bool,
    ) -> Result<Vec<(usize, f64, Level)>, CampaignError> {
        let jobs: Vec<(usize, f64)> = (0..FaultCase::ALL.len())
            .flat_map(|place| {
                let mut times = delays(place);
                if with_naming && !times.contains(&NAMING_S) {
                    times.push(NAMING_S);
                }
                times.into_iter().map(move |delay_s| (place, delay_s))
            })
            .collect();
        // Each batch alone would leave a core without work at its end.
        parallel::map(&jobs, |&(place, delay_s)| {
            Ok((place, delay_s, self.limit(prepared, place, delay_s)?))
        })
    }

    fn limit(
        &self,
        prepared: &Prepared,
        place: usize,
        delay_s: f64,
    ) -> Result<Level, CampaignError> {
        let setting = &prepared.setting;
        let [guess, scheme_guess] = guesses(setting.level, place);
        let search = |guess: f64| LimitSearch {
            case: FaultCase::ALL[place],
            delay_s,
            guess,
            largest: LARGEST[place],
            runs: self.runs,
            detection_probability: DETECTION_PROBABILITY,
        };
        let own = search(guess);
        let limit = own.find(setting, &prepared.isolator)?;
        let shown = delays(place).contains(&delay_s);
        let scheme = if shown {
            search(scheme_guess).find(setting, &prepared.scheme)?.size
        } else {
            f64::INFINITY
        };
        // The ramp goes on to three times the size.
        let within = limit.size.is_finite() && 3.0 * limit.size <= LARGEST[place];
        let mean_delay_s = if self.mean_delays && shown && within {
            own.mean_delay_s(limit.size, setting, &prepared.isolator)?
        } else {
            None
        };
        Ok(Level {
            delay_bound_s: delay_bound_s(prepared, place, limit.size / delay_s)?,
            limit,
            scheme,
            mean_delay_s,
        })
    }
}

/// A minimal detectable fault.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Table10Row {
    /// Number of the case, from 1.
    pub case: usize,
    /// Its name.
    pub name: String,
    /// Compressor maps.
    pub map_set: String,
    /// Whether temperature and pressure of the ambient vary.
    pub ambient_varies: bool,
    /// Tag of the output that the paper watches for it.
    pub output: String,
    /// Seconds in which the fault grows to its size, and must be found.
    pub delay_s: f64,
    /// Percent without noise; of case 4 its lag over the rotor's time constant, 3.19 s.
    pub noise_free_percent: Option<f64>,
    /// Percent with the deviations of Table 8.
    pub noisy_percent: Option<f64>,
    /// Percent with the accuracies of Tables 4 and 5 as three deviations.
    pub noisy_accuracy_percent: Option<f64>,
    /// The sizes above in the case's unit, in the same order.
    pub sizes: [Option<f64>; 3],
    /// The case's unit.
    pub unit: String,
    /// What the fault of `noisy_percent` does to the output at held inputs, in percent of its value.
    pub effect_percent: Option<f64>,
    /// The paper's numbers, without and with noise, where the delay is its.
    pub paper_percent: Option<[f64; 2]>,
    /// Hours between false alarms of all statistics together.
    pub arl0_h: f64,
    /// Probability of an alarm within the delay.
    pub detection_probability: f64,
    /// Seeded runs behind each number.
    pub runs: u64,
    /// 95 % intervals of the three percentages; null where an end is beyond the range searched.
    pub interval: [Option<[Option<f64>; 2]>; 3],
    /// The same three percentages for the paper's own scheme on the same records; null where it
    /// does not find the largest size searched.
    pub paper_scheme_percent: [Option<f64>; 3],
    /// The mean delay in seconds of the alarms of ramps that reach the three sizes within `delay_s`
    /// and go on; null where a run has no alarm in three times that, and with few runs.
    pub mean_delay_s: [Option<f64>; 3],
    /// The delay in seconds below which no detector of this fault's direction in white residuals
    /// comes (Neyman and Pearson) with a mean time of `arl0_h` between false alarms; null for a lag,
    /// whose effect depends on the movements.
    pub delay_bound_s: [Option<f64>; 3],
}

/// A naming study with its setting.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct IsolationTable {
    /// Compressor maps.
    pub map_set: String,
    /// Level of the noise.
    pub noise: String,
    /// What was found.
    #[serde(flatten)]
    pub summary: NamingSummary,
}

/// Table 10 and the naming of faults.
#[derive(Debug, Clone, Default)]
pub struct Limits {
    /// Rows of Table 10.
    pub table10: Vec<Table10Row>,
    /// Naming studies, that of the `paper` maps with Table 8's noise first.
    pub isolation: Vec<IsolationTable>,
    /// Detection over the size, a figure a row.
    pub figures: Vec<Figure>,
    /// How both are computed.
    pub definition: String,
}

/// Delays of each case, the paper's first.
fn delays(case: usize) -> Vec<f64> {
    let own = paper::TABLE10[case].delay_s;
    if case == 3 {
        vec![own, 30.0]
    } else {
        vec![own]
    }
}

/// Sizes near the limit, of our isolator and of the paper's scheme.
fn guesses(level: NoiseLevel, case: usize) -> [f64; 2] {
    let (own, scheme) = match level {
        NoiseLevel::None => ([0.035, 0.02, 0.04, 0.03], [0.25, 0.7, 3.0, 0.5]),
        NoiseLevel::Tables4And5 => ([3.0, 0.7, 1.5, 3.0], [15.0, 10.0, 15.0, 3.0]),
        _ => ([0.08, 0.05, 0.25, 0.4], [1.0, 9.0, 15.0, 3.0]),
    };
    [own[case], scheme[case]]
}

/// The largest sizes searched: percent, and seconds of lag just below where the speed loop becomes
/// unstable.
const LARGEST: [f64; 4] = [25.0, 25.0, 25.0, 2.9];

/// Computes both.
///
/// # Errors
/// [`CampaignError`] when a run, an identification or a design fails.
pub fn compute(seed: u64, depth: Depth, progress: &dyn Progress) -> Result<Limits, CampaignError> {
    let plan = depth.plan();
    let preparation = Preparation {
        healthy_hours: plan.healthy_hours,
        arl0_hours: ARL0_HOURS,
    };
    let mut found: BTreeMap<(usize, usize, u64), Cell> = BTreeMap::new();
    let mut isolation = Vec::new();
    for (step, &(map_set, ambient, level, naming_runs)) in plan.settings.iter().enumerate() {
        let what = format!("limits, {map_set} maps, noise {level}");
        report_or_stop(progress, &what, step, plan.settings.len())?;
        let setting = Setting::new(map_set, level, ambient, seed)?;
        let prepared = preparation.prepare(&setting)?;
        let mut of_naming = [0.0; 4];
        for (place, delay_s, found_at) in plan.limits(&prepared, naming_runs > 0)? {
            if same(delay_s, NAMING_S) {
                of_naming[place] = found_at.limit.size;
            }
            if !delays(place).contains(&delay_s) {
                continue;
            }
            let group = group(map_set, ambient);
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // seconds
            let cell = found.entry((group, place, delay_s as u64)).or_default();
            if level == NoiseLevel::Table8 {
                cell.effect = effect(&prepared, place);
            }
            cell.levels[column(level)] = Some(found_at);
        }
        if naming_runs > 0 && of_naming.iter().all(|size| size.is_finite()) {
            let study = NamingStudy {
                limits: of_naming,
                multiples: MULTIPLES,
                runs: naming_runs,
            };
            isolation.push(IsolationTable {
                map_set: map_set.to_string(),
                noise: level.to_string(),
                summary: NamingSummary::of(&study.rows(&prepared)?),
            });
        }
    }
    isolation.sort_by_key(|table| (table.map_set != "paper", table.noise != "table8"));
    let mut rows: Vec<(Table10Row, Option<Figure>)> = found
        .into_iter()
        .map(|((group, place, delay), cell)| {
            let row = cell.row(group, place, delay as f64, plan.runs);
            let figure = detection_curves(&row, cell.smallest());
            (row, figure)
        })
        .collect();
    // The paper's own setting and delays first.
    rows.sort_by_key(|(row, _)| {
        let own = row.paper_percent.is_none();
        (row.ambient_varies, row.map_set != "paper", own, row.case)
    });
    let (table10, figures): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
    Ok(Limits {
        table10,
        isolation,
        figures: figures.into_iter().flatten().collect(),
        definition: definition(&preparation, plan.runs),
    })
}

const MAPS: [MapSet; 2] = [MapSet::Paper, MapSet::Axial];

/// A number for a group of settings that differ in noise only.
fn group(map_set: MapSet, ambient: Ambient) -> usize {
    usize::from(map_set != MAPS[0]) + 2 * usize::from(ambient == Ambient::Measured)
}

/// The column of a level of noise.
fn column(level: NoiseLevel) -> usize {
    let place = LEVELS.iter().position(|(own, _)| *own == level);
    place.unwrap_or(0)
}

#[allow(clippy::float_cmp)] // the very number
fn same(left: f64, right: f64) -> bool {
    left == right
}

/// What was found at one level of noise.
struct Level {
    limit: DetectionLimit,
    scheme: f64,
    mean_delay_s: Option<f64>,
    delay_bound_s: Option<f64>,
}

/// One case and delay at the levels of noise.
#[derive(Default)]
struct Cell {
    levels: [Option<Level>; 3],
    /// Change of the output for one unit, over its value, percent.
    effect: Option<f64>,
}

impl Cell {
    /// The smallest sizes found in the runs, by level of noise.
    fn smallest(&self) -> [Option<&[f64]>; 3] {
        let levels = self.levels.each_ref().map(Option::as_ref);
        levels.map(|own| Some(own?.limit.smallest.as_slice()))
    }

    fn row(&self, group: usize, place: usize, delay_s: f64, runs: u64) -> Table10Row {
        let case = FaultCase::ALL[place];
        let paper = &paper::TABLE10[place];
        let finite = |size: f64| {
            let percent = if place == 3 {
                100.0 * size / ROTOR_S
            } else {
                size
            };
            size.is_finite().then_some(percent)
        };
        let levels = self.levels.each_ref().map(Option::as_ref);
        let sizes = levels.map(|own| Some(own?.limit.size).filter(|size| size.is_finite()));
        let [noise_free_percent, noisy_percent, noisy_accuracy_percent] =
            sizes.map(|size| finite(size?));
        Table10Row {
            case: place + 1,
            name: case.name().to_owned(),
            map_set: MAPS[group % 2].to_string(),
            ambient_varies: group >= 2,
            output: paper.output.to_owned(),
            delay_s,
            noise_free_percent,
            noisy_percent,
            noisy_accuracy_percent,
            sizes,
            unit: case.unit().to_owned(),
            effect_percent: self
                .effect
                .zip(sizes[1])
                .map(|(effect, size)| effect * size),
            paper_percent: same(delay_s, paper.delay_s)
                .then_some([paper.noise_free_percent, paper.noisy_percent]),
            arl0_h: ARL0_HOURS,
            detection_probability: DETECTION_PROBABILITY,
            runs,
            interval: levels.map(|own| Some(own?.limit.interval.map(finite))),
            paper_scheme_percent: levels.map(|own| finite(own?.scheme)),
            mean_delay_s: levels.map(|own| own?.mean_delay_s),
            delay_bound_s: levels.map(|own| own?.delay_bound_s),
        }
    }
}

/// The bound on the mean delay, in seconds, for a fault that grows by so many units a second, in
/// white residuals of the isolator's robust deviations.
fn delay_bound_s(
    prepared: &Prepared,
    place: usize,
    growth_per_s: f64,
) -> Result<Option<f64>, CampaignError> {
    let directions = prepared.isolator.directions();
    let Some(direction) = directions[place]
        .as_ref()
        .filter(|_| growth_per_s.is_finite())
    else {
        return Ok(None);
    };
    let sample_time_s = prepared.isolator.sample_time_s();
    let slope = direction.norm() * growth_per_s * sample_time_s;
    let samples = ARL0_HOURS * 3600.0 / sample_time_s;
    let bound = mean_delay_bound(Waveform::Ramp, slope, samples).during("bound on the delay")?;
    Ok(Some(bound * sample_time_s))
}

/// Percent by which the output that the paper watches changes for one unit of a fault, at held
/// inputs.
fn effect(prepared: &Prepared, place: usize) -> Option<f64> {
    let isolator = &prepared.isolator;
    let tag = paper::TABLE10[place].tag;
    let FaultEffect::Outputs { changes, .. } = &isolator.hypotheses()[place].effect else {
        return None;
    };
    let value = isolator.generators().iter().find_map(|generator| {
        let mut outputs = generator.outputs().iter();
        let row = outputs.position(|signal| signal.name == tag)?;
        Some(generator.point().y[row])
    })?;
    Some(100.0 * (changes.get(tag)? / value).abs())
}

fn definition(preparation: &Preparation, runs: u64) -> String {
    let scheme = PaperScheme::DEFINITION;
    format!(
        "Minimal detectable fault: the smallest size, reached evenly in the delay, that alarms \
         within the delay in {DETECTION_PROBABILITY} of {runs} seeded runs (the quantile over the \
         runs of the smallest size found in each, closed in to 5 %), on the +-1.5 deg profile; \
         intervals by order statistics. {} {scheme} Mean delays are of ramps of the slope of the \
         limit that go on; the bound beside them is Neyman and Pearson's for white residuals of \
         the same direction. Sensors keep one noise in all runs, scaled by one \
         noise-free hour. Case 4 in percent is its lag over {ROTOR_S} s. Naming: case, onset, sign \
         (of the thermocouple) and size, 1 to 4 times the limit at {NAMING_S} s, drawn at random; \
         a name counts as given where its probability reaches 0.99 in two diagnoses in a row and \
         residuals have answered to the onset, in time within 5 s of the \
         alarm, wrong where it ever was another.",
        preparation.definition()
    )
}
