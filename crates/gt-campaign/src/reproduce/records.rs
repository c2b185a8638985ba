//! The seeded runs behind the tables.

use std::sync::atomic::{AtomicUsize, Ordering};

use gtfdi::core::{Dataset, Signal};
use gtfdi::plant::{
    Fault, FaultCase, MapSet, NoiseLevel, Profile, Run, Scenario, Variant, simulate,
};

use crate::error::{CampaignError, During as _};
use crate::progress::{Progress, report_or_stop};
use crate::{paper, parallel};

/// Excitation of the identification and validation records (+-1.0 deg).
pub const IDENTIFICATION_PROFILE: &str = "standard";
/// Length of the identification and validation records in seconds.
pub const IDENTIFICATION_S: f64 = 600.0;
/// Excitation of the signature runs (+-1.5 deg), as in the definition of the signature.
pub const SIGNATURE_PROFILE: &str = "lively";
/// Length of the signature runs in seconds.
pub const SIGNATURE_S: f64 = 600.0;
/// Number of healthy records behind the thresholds.
pub const HEALTHY_RECORDS: usize = 4;
/// Length of each healthy record in seconds.
pub const HEALTHY_S: f64 = 600.0;
/// Length of the runs with the paper's nominal faults in seconds.
pub const FAULT_RUN_S: f64 = 1800.0;
/// Onset of the nominal faults in seconds (figures 20 to 23 of the paper).
pub const ONSET_S: f64 = 15.0;
/// Sizes of the signature's faults: percent for cases 1 to 3, seconds of lag for case 4.
pub const SIGNATURE_SIZES: [f64; 4] = [5.0, 5.0, 5.0, 2.0];
/// When the signature's faults begin, in seconds; each reaches its full size in one second.
pub const SIGNATURE_ONSET_S: f64 = 30.0;
/// Start of the window of the signature, in seconds: transients of onset and models are over.
pub const SIGNATURE_WINDOW_S: f64 = 60.0;

/// The load reductions of section 3.1, by the plant's profiles.
pub const LOAD_REDUCTIONS: [&str; 2] = ["load_reduction_igv", "load_reduction_fuel"];
/// Length of a load reduction in seconds.
pub const LOAD_REDUCTION_S: f64 = 300.0;

/// The four cases of section 3.2.
pub const CASES: [FaultCase; 4] = FaultCase::ALL;

/// A run that a table needs.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The log's name, without extension.
    pub name: String,
    /// What is simulated.
    pub scenario: Scenario,
}

/// A finished run.
#[derive(Debug)]
pub struct Record {
    /// The plan behind it.
    pub plan: Plan,
    /// What the plant did.
    pub run: Run,
}

impl Record {
    /// The paper's inputs and the given outputs, as measured.
    pub fn select(&self, outputs: &[&str]) -> Result<Dataset, CampaignError> {
        self.run
            .measured
            .select(&paper::INPUTS, outputs)
            .during(&self.plan.name)
    }

    /// An input or output by name, as the plant has it, with its values.
    pub fn signal(&self, name: &str) -> Option<(&Signal, Vec<f64>)> {
        let truth = &self.run.truth;
        let inputs = truth.inputs().iter().zip(truth.u().row_iter());
        let outputs = truth.outputs().iter().zip(truth.y().row_iter());
        let (signal, values) = inputs
            .chain(outputs)
            .find(|(signal, _)| signal.name == name)?;
        Some((signal, values.iter().copied().collect()))
    }
}

/// The runs on one map set; every run of a kind has the same scenario but for its run index.
#[derive(Debug)]
pub struct Records {
    /// The identification record, then the two validation records.
    pub identification: Vec<Record>,
    /// Healthy records for the thresholds, then one more that no threshold saw.
    pub healthy: Vec<Record>,
    /// The nominal faults, by case; empty for the `axial` maps.
    pub faults: Vec<Record>,
    /// The healthy signature run, then the four faulty ones, all with the same excitation.
    pub signature: Vec<Record>,
    /// The same with another excitation, from which the isolating residuals are learned.
    pub signature_teaching: Vec<Record>,
    /// The load reductions of the machine on the mains.
    pub load_reduction: Vec<Record>,
}

/// The number of groups of records.
const GROUPS: usize = 6;

fn plan(
    name: String,
    map_set: MapSet,
    profile: &str,
    duration_s: f64,
    seed: u64,
    run_index: u64,
) -> Result<Plan, CampaignError> {
    let scenario = Scenario {
        map_set,
        duration_s,
        profile: Profile::named(Variant::Prototype, profile).during(&name)?,
        noise: NoiseLevel::None.into(),
        seed,
        run_index,
        ..Scenario::default()
    };
    Ok(Plan { name, scenario })
}

/// A fault that is at its full size within a second.
fn at_once(case: FaultCase, size: f64) -> Fault {
    Fault::growing(case, SIGNATURE_ONSET_S, size * 3600.0, Some(size))
}

fn plans(map_set: MapSet, seed: u64) -> Result<[Vec<Plan>; GROUPS], CampaignError> {
    // Run indices: 0..2 identification, 10.. healthy, 20.. nominal faults, 30 signature, 31 what
    // teaches its isolating residuals; the effects of the faults take theirs from 40 on.
    let identification = ["identification", "validation1", "validation2"]
        .iter()
        .zip(0..)
        .map(|(name, index)| {
            plan(
                format!("{map_set}_{name}"),
                map_set,
                IDENTIFICATION_PROFILE,
                IDENTIFICATION_S,
                seed,
                index,
            )
        })
        .collect::<Result<_, _>>()?;
    let mut healthy = Vec::new();
    let mut faults = Vec::new();
    if map_set == MapSet::Paper {
        for index in 0..=HEALTHY_RECORDS {
            let name = if index < HEALTHY_RECORDS {
                format!("{map_set}_healthy{}", index + 1)
            } else {
                format!("{map_set}_healthy_test")
            };
            let run_index = 10 + index as u64;
            healthy.push(plan(
                name,
                map_set,
                IDENTIFICATION_PROFILE,
                HEALTHY_S,
                seed,
                run_index,
            )?);
        }
        for (case, run_index) in CASES.into_iter().zip(20..) {
            let mut plan = plan(
                format!("{map_set}_case{}_nominal", case.number()),
                map_set,
                IDENTIFICATION_PROFILE,
                FAULT_RUN_S,
                seed,
                run_index,
            )?;
            plan.scenario.faults = vec![Fault::nominal(case, ONSET_S)];
            faults.push(plan);
        }
    }
    let signature_plans = |kind: &str, run_index: u64| {
        let one = |name: String, faults: Vec<Fault>| {
            let profile = SIGNATURE_PROFILE;
            let mut plan = plan(name, map_set, profile, SIGNATURE_S, seed, run_index)?;
            plan.scenario.faults = faults;
            Ok::<_, CampaignError>(plan)
        };
        let mut plans = vec![one(format!("{map_set}_{kind}_healthy"), vec![])?];
        for (case, size) in CASES.into_iter().zip(SIGNATURE_SIZES) {
            let name = format!("{map_set}_{kind}_case{}", case.number());
            plans.push(one(name, vec![at_once(case, size)])?);
        }
        Ok::<_, CampaignError>(plans)
    };
    let load_reduction = LOAD_REDUCTIONS
        .into_iter()
        .map(|profile| load_reduction(map_set, profile, seed))
        .collect::<Result<_, _>>()?;
    Ok([
        identification,
        healthy,
        faults,
        signature_plans("signature", 30)?,
        signature_plans("signature_teaching", 31)?,
        load_reduction,
    ])
}

fn load_reduction(map_set: MapSet, profile: &str, seed: u64) -> Result<Plan, CampaignError> {
    let name = format!("{map_set}_{profile}");
    let scenario = Scenario {
        map_set,
        duration_s: LOAD_REDUCTION_S,
        profile: Profile::named(Variant::Cogeneration, profile).during(&name)?,
        noise: NoiseLevel::None.into(),
        seed,
        ..Scenario::of(Variant::Cogeneration)
    };
    Ok(Plan { name, scenario })
}

/// Simulates everything, on all cores; the order of completion does not matter to any result.
pub fn simulate_all(
    map_sets: &[MapSet],
    seed: u64,
    progress: &dyn Progress,
) -> Result<Vec<Records>, CampaignError> {
    let groups: Vec<[Vec<Plan>; GROUPS]> = map_sets
        .iter()
        .map(|map_set| plans(*map_set, seed))
        .collect::<Result<_, _>>()?;
    let total = groups.iter().flatten().map(Vec::len).sum();
    let done = AtomicUsize::new(0);
    let record = |plan: &Plan| {
        let run = simulate(&plan.scenario).during(&plan.name)?;
        // A shorter record would give other numbers under the same definitions.
        if let Some(reason) = run.ended.clone() {
            return Err(reason).during(&plan.name);
        }
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        report_or_stop(progress, &plan.name, done, total)?;
        Ok::<_, CampaignError>(Record {
            plan: plan.clone(),
            run,
        })
    };
    // One flat list, longest runs first, keeps both cores busy to the end.
    let mut flat: Vec<(usize, &Plan)> = groups.iter().flatten().flatten().enumerate().collect();
    flat.sort_by(|a, b| b.1.scenario.duration_s.total_cmp(&a.1.scenario.duration_s));
    let mut finished: Vec<(usize, Record)> = parallel::map(&flat, |&(index, plan)| {
        Ok::<_, CampaignError>((index, record(plan)?))
    })?;
    finished.sort_by_key(|(index, _)| *index);
    let mut records = finished.into_iter().map(|(_, record)| record);
    let mut take = |plans: &[Plan]| records.by_ref().take(plans.len()).collect::<Vec<_>>();
    Ok(groups
        .iter()
        .map(
            |[
                identification,
                healthy,
                faults,
                signature,
                teaching,
                load_reduction,
            ]| Records {
                identification: take(identification),
                healthy: take(healthy),
                faults: take(faults),
                signature: take(signature),
                signature_teaching: take(teaching),
                load_reduction: take(load_reduction),
            },
        )
        .collect())
}
