//! What a campaign may not ask for.

use std::fmt;

use gtfdi::plant::{Channel, Fault, Profile, SAMPLE_TIME_S, Scenario, Variant};

use super::bank_choice::{BankChoice, TestFamily};
use super::fault_plan::{FaultPlan, FaultShape, Sign};
use super::spec::{ModelPlan, Spec};

/// The most runs of a campaign: their indices have room in a column and beside the healthy records.
const MOST_RUNS: u64 = 1_000_000_000;
/// The most hours of healthy running for the limits; they are in memory at once.
const MOST_HOURS: f64 = 1000.0;
/// The shortest record that a model is identified from or noise measured by, in seconds.
const SHORTEST_MODEL_RECORD_S: f64 = 10.0;

/// What is wrong with a value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// The value's key.
    pub key: String,
    /// What was expected and what was found.
    pub reason: String,
}

impl Problem {
    /// A value that is not what was expected.
    pub(super) fn new(
        key: impl Into<String>,
        expected: impl fmt::Display,
        found: impl fmt::Display,
    ) -> Self {
        Self {
            key: key.into(),
            reason: format!("expected {expected}, found {found}"),
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: {}", self.key, self.reason)
    }
}

/// Refuses a value outside `low..=high`, NaN included.
fn within(key: &str, found: f64, [low, high]: [f64; 2], expected: &str) -> Result<(), Problem> {
    if found >= low && found <= high {
        return Ok(());
    }
    Err(Problem::new(key, expected, found))
}

/// Refuses what is not above 0 and finite.
fn positive(key: &str, found: f64) -> Result<(), Problem> {
    let range = [f64::MIN_POSITIVE, f64::MAX];
    within(key, found, range, "a finite number above 0")
}

impl Spec {
    /// Refuses what makes no sense, before anything is simulated.
    ///
    /// # Errors
    /// The first such value by its key.
    pub fn validate(&self) -> Result<(), Problem> {
        // A file has no larger integers.
        if i64::try_from(self.seed).is_err() {
            return Err(Problem::new(
                "seed",
                "at most 9223372036854775807",
                self.seed,
            ));
        }
        if self.runs == 0 || self.runs > MOST_RUNS {
            let expected = format!("from 1 to {MOST_RUNS}");
            return Err(Problem::new("runs", expected, self.runs));
        }
        let share = [0.0, 1.0];
        within(
            "healthy_share",
            self.healthy_share,
            share,
            "a share from 0 to 1",
        )?;
        let profile = self.profile()?;
        profile
            .validate_for(Variant::Prototype)
            .map_err(|error| plant_problem("plant", &error))?;
        let range = [SHORTEST_MODEL_RECORD_S, f64::MAX];
        let expected = format!("at least {SHORTEST_MODEL_RECORD_S} and finite");
        let noise_record_s = self.plant.noise_record_s;
        within("plant.noise_record_s", noise_record_s, range, &expected)?;
        self.validate_record()?;
        let healthy = Scenario {
            duration_s: self.record.duration_s,
            ..self
                .scenario(0, &self.plant.noise.into())
                .map_err(|error| plant_problem("plant", &error))?
        };
        healthy
            .validate()
            .map_err(|error| plant_problem("plant", &error))?;
        #[expect(clippy::float_cmp, reason = "a share of exactly 1 has no faults")]
        let all_healthy = self.healthy_share == 1.0;
        if self.faults.is_empty() && !all_healthy {
            return Err(Problem::new(
                "faults",
                "at least one, or healthy_share = 1",
                "none",
            ));
        }
        for (place, fault) in self.faults.iter().enumerate() {
            self.validate_fault(place, fault)?;
        }
        match (&self.bank, &self.model) {
            (BankChoice::File(_), Some(_)) => {
                let expected = "no model beside the bank of a file";
                return Err(Problem::new("model", expected, "one"));
            }
            (BankChoice::File(file), None) if file.as_os_str().is_empty() => {
                return Err(Problem::new("bank", "a file or a table", "an empty name"));
            }
            (BankChoice::File(_), None) => {}
            (BankChoice::Tests(family), _) => {
                let model = self.model();
                validate_model(&model)?;
                validate_family(family, &model)?;
            }
            (BankChoice::Isolator(family), _) => {
                let model = self.model();
                validate_model(&model)?;
                validate_hours(family.arl0_h, family.calibration_h)?;
                let actuator = crate::paper::INPUTS[1];
                if !model.inputs.iter().any(|tag| tag == actuator) {
                    let expected = format!("`{actuator}` among them, as an isolator tells its lag");
                    let found = model.inputs.join(", ");
                    return Err(Problem::new("model.inputs", expected, found));
                }
            }
        }
        Ok(())
    }

    /// The profile with its amplitude.
    ///
    /// # Errors
    /// An unknown name.
    pub(super) fn profile(&self) -> Result<Profile, Problem> {
        let mut profile = Profile::named(Variant::Prototype, &self.plant.profile)
            .map_err(|error| plant_problem("plant.profile", &error))?;
        if let Some(amplitude_deg) = self.plant.valve_amplitude_deg {
            let range = [0.0, 20.0];
            let key = "plant.valve_amplitude_deg";
            within(key, amplitude_deg, range, "from 0 to 20")?;
            profile.valve_amplitude_deg = amplitude_deg;
        }
        Ok(profile)
    }

    fn validate_record(&self) -> Result<(), Problem> {
        let record = &self.record;
        let duration = [SAMPLE_TIME_S, f64::MAX];
        let expected = "at least a sample time of 0.08 and finite";
        within("record.duration_s", record.duration_s, duration, expected)?;
        let [first, last] = record.onset_s;
        let inside = |key: &str, found, low: f64| {
            let high = record.duration_s;
            let expected = format!("from {low} to the duration of {high}");
            within(key, found, [low, high], &expected)
        };
        inside("record.onset_s[0]", first, 0.0)?;
        inside("record.onset_s[1]", last, first)?;
        if let Some(horizon_s) = record.horizon_s {
            let most = record.duration_s - last;
            let expected = format!("above 0 and at most {most}, from the last onset to the end");
            let range = [f64::MIN_POSITIVE, most];
            within("record.horizon_s", horizon_s, range, &expected)?;
        } else if last >= record.duration_s {
            let expected = format!("below the duration of {}", record.duration_s);
            return Err(Problem::new("record.onset_s[1]", expected, last));
        }
        Ok(())
    }

    fn validate_fault(&self, place: usize, plan: &FaultPlan) -> Result<(), Problem> {
        let key = |name: &str| format!("faults[{place}].{name}");
        let [low, high] = plan.size.ends();
        positive(&key("size"), low)?;
        let expected = format!("a largest size of at least the smallest, {low}");
        within(&key("size"), high, [low, f64::MAX], &expected)?;
        match plan.shape {
            FaultShape::Step => {}
            FaultShape::Ramp { rise_s } => positive(&key("shape.ramp.rise_s"), rise_s)?,
            FaultShape::Exponential { time_constant_s } => {
                positive(&key("shape.exponential.time_constant_s"), time_constant_s)?;
            }
            FaultShape::Intermittent { period_s, on_s } => {
                positive(&key("shape.intermittent.period_s"), period_s)?;
                positive(&key("shape.intermittent.on_s"), on_s)?;
            }
        }
        // What is left is for the plant to say: the largest fault of each sign, as early as it comes.
        let signs: &[f64] = match plan.sign {
            Sign::Positive => &[1.0],
            Sign::Negative => &[-1.0],
            Sign::Both => &[1.0, -1.0],
        };
        for sign in signs {
            let fault: Fault = plan.fault(self.record.onset_s[0], sign * high);
            let checked = fault
                .validate()
                .and_then(|()| fault.validate_by(self.record.duration_s));
            let name = if *sign < 0.0 { "sign" } else { "size" };
            checked.map_err(|error| plant_problem(&key(name), &error))?;
        }
        Ok(())
    }
}

fn validate_model(model: &ModelPlan) -> Result<(), Problem> {
    let range = [SHORTEST_MODEL_RECORD_S, f64::MAX];
    let expected = format!("at least {SHORTEST_MODEL_RECORD_S} and finite");
    within("model.record_s", model.record_s, range, &expected)?;
    if model.order == Some(0) {
        return Err(Problem::new("model.order", "at least 1", 0));
    }
    for (key, tags) in [
        ("model.inputs", &model.inputs),
        ("model.outputs", &model.outputs),
    ] {
        if tags.is_empty() {
            return Err(Problem::new(key, "at least one tag", "none"));
        }
        for (place, tag) in tags.iter().enumerate() {
            let known = Channel::named(tag).is_ok_and(|channel| channel.is_in(Variant::Prototype));
            if !known {
                let expected = "a channel of the prototype";
                return Err(Problem::new(key, expected, format!("`{tag}`")));
            }
            if tags[..place].contains(tag) {
                let found = format!("`{tag}` twice");
                return Err(Problem::new(key, "every tag once", found));
            }
        }
    }
    if let Some(nk) = &model.nk
        && nk.len() != model.inputs.len()
    {
        let expected = format!("{} lags, one an input", model.inputs.len());
        return Err(Problem::new("model.nk", expected, nk.len()));
    }
    Ok(())
}

fn validate_hours(arl0_h: f64, calibration_h: f64) -> Result<(), Problem> {
    positive("bank.arl0_h", arl0_h)?;
    positive("bank.calibration_h", calibration_h)?;
    let range = [0.0, MOST_HOURS];
    let expected = format!("at most {MOST_HOURS}");
    within("bank.calibration_h", calibration_h, range, &expected)
}

fn validate_family(family: &TestFamily, model: &ModelPlan) -> Result<(), Problem> {
    validate_hours(family.arl0_h, family.calibration_h)?;
    if family.tests.is_empty() {
        return Err(Problem::new("bank.tests", "at least one", "none"));
    }
    family.plans(model.outputs.len()).map(|_| ())
}

/// A refusal of the plant, under the key of the campaign.
fn plant_problem(key: &str, error: &gtfdi::plant::PlantError) -> Problem {
    Problem {
        key: key.to_owned(),
        reason: error.to_string(),
    }
}
