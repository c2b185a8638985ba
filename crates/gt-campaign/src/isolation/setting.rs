//! The plant, its operation and its sensors, the same for every run of a study.

use gtfdi::core::Dataset;
use gtfdi::plant::{
    Boundary, Channel, ChannelNoise, Course, Fault, Fluctuation, MapSet, Noise, NoiseLevel,
    NoiseScale, PlantParameters, Profile, Scenario, Variant,
};

use crate::error::{CampaignError, During as _};
use crate::{paper, parallel};

/// Length of the noise-free record whose deviations scale the sensors' noise, in seconds.
const REFERENCE_S: f64 = 3600.0;
/// Its run index, apart from all others.
const REFERENCE_INDEX: u64 = 9;
/// The operating profile: +-1.5 deg of valve, +-1 % of speed, 2 % fuel dither.
pub const PROFILE: &str = "lively";
/// Time constant of the ambient conditions, in seconds.
const AMBIENT_TIME_S: f64 = 300.0;
/// Standard deviations that "+-" stands for.
const AMBIENT_SIGMAS: f64 = 2.0;

/// What the surroundings do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ambient {
    /// Temperature and pressure stay at their design values.
    Constant,
    /// Temperature varies by +-2 K and pressure by +-0.2 % (two standard deviations, correlated over
    /// 300 s); both are measured, without noise, and are inputs of the model.
    Measured,
}

/// A plant with its operation and sensors.
#[derive(Debug, Clone)]
pub struct Setting {
    /// Compressor maps.
    pub map_set: MapSet,
    /// Level of the sensors' noise.
    pub level: NoiseLevel,
    /// The surroundings.
    pub ambient: Ambient,
    /// Seed of all runs.
    pub seed: u64,
    noise: Noise,
}

impl Setting {
    /// A setting whose sensors have one noise in all runs: where the level is a share of what the
    /// signals do, of what they do in one noise-free hour.
    ///
    /// # Errors
    /// [`CampaignError`] when that hour cannot be simulated.
    pub fn new(
        map_set: MapSet,
        level: NoiseLevel,
        ambient: Ambient,
        seed: u64,
    ) -> Result<Self, CampaignError> {
        let mut setting = Self {
            map_set,
            level,
            ambient,
            seed,
            noise: NoiseLevel::None.into(),
        };
        let asked: Noise = level.into();
        if !asked.is_share_of_signals() {
            setting.noise = asked;
            return Ok(setting);
        }
        let healthy = [(REFERENCE_INDEX, Vec::new())];
        let reference = setting.records(&healthy, REFERENCE_S)?.remove(0);
        for tag in setting.inputs().iter().chain(&setting.outputs()) {
            let channel = Channel::named(tag).during("noise of the sensors")?;
            if let NoiseScale::SignalShare(share) = asked.scale(channel)
                && let Some(values) = values(&reference, tag)
            {
                let own = ChannelNoise {
                    deviation: Some(share * deviation(&values)),
                    ..ChannelNoise::default()
                };
                setting.noise.channels.insert(channel, own);
            }
        }
        Ok(setting)
    }

    /// Tags of the model's inputs.
    pub fn inputs(&self) -> Vec<&'static str> {
        let mut inputs = paper::INPUTS.to_vec();
        if self.ambient == Ambient::Measured {
            inputs.extend(["T_a", "p_a"]);
        }
        inputs
    }

    /// Tags of the watched outputs.
    pub fn outputs(&self) -> Vec<&'static str> {
        paper::watched().map(|output| output.tag).collect()
    }

    /// The same without noise.
    #[must_use]
    pub fn without_noise(&self) -> Self {
        Self {
            noise: NoiseLevel::None.into(),
            ..self.clone()
        }
    }

    /// Standard deviation of a channel's noise in its unit; `None` where it is a share of another
    /// kind.
    pub fn deviation(&self, tag: &str) -> Option<f64> {
        let channel = Channel::named(tag).ok()?;
        match self.noise.scale(channel) {
            NoiseScale::Unit(deviation) => Some(deviation),
            NoiseScale::SignalShare(_) | NoiseScale::DesignShare(_) => None,
        }
    }

    fn boundary(&self) -> Boundary {
        let fluctuating = |deviation: f64| Course {
            random: Some(Fluctuation {
                deviation: deviation / AMBIENT_SIGMAS,
                time_constant_s: AMBIENT_TIME_S,
            }),
            ..Course::default()
        };
        match self.ambient {
            Ambient::Constant => Boundary::default(),
            Ambient::Measured => Boundary {
                temperature_k: fluctuating(2.0),
                pressure_pa: fluctuating(0.002 * 101_325.0),
                ..Boundary::default()
            },
        }
    }

    /// The scenario of a run with given index and faults.
    ///
    /// # Errors
    /// [`CampaignError`] when there is no profile of its name.
    pub fn scenario(
        &self,
        run_index: u64,
        faults: &[Fault],
        duration_s: f64,
    ) -> Result<Scenario, CampaignError> {
        Ok(Scenario {
            map_set: self.map_set,
            duration_s,
            profile: Profile::named(Variant::Prototype, PROFILE).during("profile")?,
            boundary: self.boundary(),
            noise: self.noise.clone(),
            faults: faults.to_vec(),
            seed: self.seed,
            run_index,
            ..Scenario::default()
        })
    }

    /// The measured records of runs with given indices and faults, on all cores, in order.
    ///
    /// # Errors
    /// [`CampaignError`] when a run leaves the plant's validity.
    pub fn records(
        &self,
        runs: &[(u64, Vec<Fault>)],
        duration_s: f64,
    ) -> Result<Vec<Dataset>, CampaignError> {
        self.map(runs, duration_s, |_, record| Ok(record))
    }

    /// Simulates runs on all cores and gives what `take` makes of each record, in order; no more
    /// records are held than are being worked on.
    ///
    /// # Errors
    /// As [`Setting::records`], and as `take`.
    pub fn map<T: Send>(
        &self,
        runs: &[(u64, Vec<Fault>)],
        duration_s: f64,
        take: impl Fn(usize, Dataset) -> Result<T, CampaignError> + Sync,
    ) -> Result<Vec<T>, CampaignError> {
        let plant = PlantParameters::for_maps(self.map_set);
        let (inputs, outputs) = (self.inputs(), self.outputs());
        let scenarios = runs
            .iter()
            .map(|(run_index, faults)| self.scenario(*run_index, faults, duration_s))
            .collect::<Result<Vec<Scenario>, CampaignError>>()?;
        let what = |place: usize| format!("run {}", scenarios[place].run_index);
        parallel::simulate(&plant, &scenarios, what, |place, run| {
            let record = run.measured.select(&inputs, &outputs);
            take(place, record.during(&what(place))?)
        })
    }
}

fn values(record: &Dataset, tag: &str) -> Option<Vec<f64>> {
    let inputs = record.inputs().iter().zip(record.u().row_iter());
    let outputs = record.outputs().iter().zip(record.y().row_iter());
    let mut rows = inputs.chain(outputs);
    let (_, row) = rows.find(|(signal, _)| signal.name == tag)?;
    Some(row.iter().copied().collect())
}

fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let squares = values.iter().map(|value| (value - mean).powi(2));
    (squares.sum::<f64>() / values.len() as f64).sqrt()
}
