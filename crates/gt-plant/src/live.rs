//! A plant that runs on and on, sample by sample, with faults that come and go.

use crate::dynamics::derivative;
use crate::faults::{Fault, FaultCourse};
use crate::operation::Operation;
use crate::scenario::Scenario;
use crate::sensors::{Deviations, Sensor};
use crate::simulate::{noise_basis, time_s};
use crate::state::STATES;
use crate::{Channel, ChannelRow, PlantError, PlantParameters, Variant, rk4, simulate_with};

/// What the sensors say at one time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LiveSample {
    /// Time in seconds since the start.
    pub time_s: f64,
    /// The inputs (nu), in the order of the records of the variant.
    pub u: Vec<f64>,
    /// The outputs (ny), in the order of the records of the variant.
    pub y: Vec<f64>,
}

/// A plant at work: [`simulate`](crate::simulate()) without an end, a sample at a time, in the same
/// bits; its faults can be changed as it runs.
#[derive(Debug, Clone)]
pub struct LivePlant {
    plant: PlantParameters,
    scenario: Scenario,
    operation: Operation,
    /// Of the inputs, then of the outputs.
    sensors: [Vec<Sensor>; 2],
    x: [f64; STATES],
    sample: LiveSample,
}

impl LivePlant {
    /// A plant before its first sample. The duration of the scenario says only how long a healthy
    /// record the noise is scaled by, where it is a share of what signals do.
    ///
    /// # Errors
    /// As [`simulate`](crate::simulate()).
    pub fn start(scenario: &Scenario) -> Result<Self, PlantError> {
        let plant = scenario.parameters();
        scenario.validate_with(&plant)?;
        let healthy = Scenario {
            noise: crate::Noise::default(),
            faults: Vec::new(),
            ..scenario.clone()
        };
        let mut reference = None;
        if scenario.noise.is_share_of_signals() && scenario.excites() {
            let run = simulate_with(&plant, &healthy)?;
            if let Some(reason) = run.ended {
                return Err(reason);
            }
            reference = Some(Deviations::of(run.truth.u(), run.truth.y()));
        }
        let basis = noise_basis(&plant, scenario, || {
            reference.unwrap_or_else(Deviations::zero)
        })?;
        let key = [scenario.seed, scenario.run_index];
        let sensor = |channel| Sensor::new(channel, &scenario.faults, &scenario.noise, &basis, key);
        let channels = Channel::of(scenario.variant);
        let (inputs, outputs): (Vec<_>, Vec<_>) =
            channels.partition(|channel| matches!(channel.row(), ChannelRow::Input(_)));
        let (operation, x) = Operation::start(&plant, scenario, &scenario.faults)?;
        Ok(Self {
            sensors: [inputs, outputs].map(|own| own.into_iter().map(sensor).collect()),
            plant,
            scenario: scenario.clone(),
            operation,
            x,
            sample: LiveSample::default(),
        })
    }

    /// Which machine it is.
    pub fn variant(&self) -> Variant {
        self.scenario.variant
    }

    /// Time of the next sample in seconds since the start.
    pub fn next_time_s(&self) -> f64 {
        time_s(self.operation.read())
    }

    /// The faults, past ones among them.
    pub fn faults(&self) -> &[Fault] {
        &self.scenario.faults
    }

    /// Puts other faults in the place of those there are, from the next sample on; their onsets are
    /// in seconds since the start. Noise and excitation go on as they would have.
    ///
    /// # Errors
    /// [`PlantError`] when a fault makes no sense; the faults are then as they were.
    pub fn set_faults(&mut self, faults: Vec<Fault>) -> Result<(), PlantError> {
        Fault::validate_each(&faults, |_| Ok(()))?;
        Fault::validate_together(&faults)?;
        self.scenario.validate_places_of(&faults)?;
        let key @ [seed, run_index] = [self.scenario.seed, self.scenario.run_index];
        self.operation
            .set_faults(FaultCourse::new(&faults, seed, run_index));
        for sensor in self.sensors.iter_mut().flatten() {
            sensor.set_faults(&faults, key);
        }
        self.scenario.faults = faults;
        Ok(())
    }

    /// The next sample, the first of which is at 0 s. Nothing is allocated after the first.
    ///
    /// # Errors
    /// [`PlantError`] when the plant has left the range in which the model means something; so from
    /// then on, until it is started again.
    pub fn sample(&mut self) -> Result<&LiveSample, PlantError> {
        let k = self.operation.read();
        let truth = self.operation.sample(&self.plant, &self.x)?;
        let start_s = time_s(k);
        let values = [
            (&mut self.sample.u, &truth.u[..]),
            (&mut self.sample.y, &truth.y[..]),
        ];
        for ((readings, values), sensors) in values.into_iter().zip(&mut self.sensors) {
            readings.clear();
            let read = sensors.iter_mut().zip(values);
            readings.extend(read.map(|(sensor, value)| sensor.read(start_s, *value)));
        }
        self.sample.time_s = start_s;
        let step_s = self.scenario.step_s();
        for substep in 0..self.scenario.substeps {
            let operation = &self.operation;
            let rates = |t: f64, x: &[f64; STATES]| {
                derivative(&self.plant, operation.inputs(), &operation.sizes(t), x)
            };
            self.x = rk4::step(rates, start_s + substep as f64 * step_s, &self.x, step_s);
        }
        Ok(&self.sample)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::faults::{FaultCase, Mode, Shape, Step};
    use crate::{Noise, NoiseLevel, Profile, simulate};

    fn scenario(variant: Variant) -> Scenario {
        let t3 = Channel::named("t3").unwrap();
        let of = |size| Shape::Step(Step { size });
        Scenario {
            duration_s: 20.0,
            profile: Profile::standard(variant),
            noise: Noise::from(NoiseLevel::Table8),
            faults: vec![
                Fault::growing(FaultCase::TurbineDamage, 5.0, 3600.0, Some(1.0)),
                Fault::sensor(t3, Mode::Lag, 2.0, of(2.0)),
                Fault::sensor(t3, Mode::Stuck, 12.0, of(1.0)).until(13.0),
            ],
            seed: 4,
            ..Scenario::of(variant)
        }
    }

    /// The bits of a whole record, NaN included.
    fn bits(values: &[f64]) -> Vec<u64> {
        values.iter().map(|value| value.to_bits()).collect()
    }

    #[test]
    fn a_live_plant_is_a_run_without_an_end() {
        for variant in [Variant::Prototype, Variant::Cogeneration] {
            let scenario = scenario(variant);
            let run = simulate(&scenario).unwrap();
            assert!(run.ended.is_none());
            let mut live = LivePlant::start(&scenario).unwrap();
            for k in 0..run.measured.len() {
                let sample = live.sample().unwrap();
                assert_eq!(sample.time_s.to_bits(), run.measured.time_s(k).to_bits());
                let recorded = |values: &nalgebra::DMatrix<f64>| bits(values.column(k).as_slice());
                assert_eq!(
                    bits(&sample.u),
                    recorded(run.measured.u()),
                    "{variant}, {k}"
                );
                assert_eq!(
                    bits(&sample.y),
                    recorded(run.measured.y()),
                    "{variant}, {k}"
                );
            }
            live.sample().unwrap();
        }
    }

    /// Faults that are put in before their onset are as if they had been there from the start.
    #[test]
    fn faults_come_as_it_runs() {
        let faulty = scenario(Variant::Prototype);
        let run = simulate(&faulty).unwrap();
        let mut live = LivePlant::start(&Scenario {
            faults: Vec::new(),
            ..faulty.clone()
        })
        .unwrap();
        for k in 0..run.measured.len() {
            if k == 20 {
                live.set_faults(faulty.faults.clone()).unwrap();
            }
            let sample = live.sample().unwrap();
            let expected = run.measured.y().column(k);
            assert_eq!(bits(&sample.y), bits(expected.as_slice()), "{k}");
        }
        assert_eq!(live.faults(), faulty.faults);
    }

    #[test]
    fn faults_that_make_no_sense_change_nothing() {
        let mut live = LivePlant::start(&scenario(Variant::Prototype)).unwrap();
        let before = live.faults().to_vec();
        let vanes = Fault::actuator(
            crate::ActuatorId::GuideVanes,
            Mode::Bias,
            0.0,
            Shape::Step(Step { size: 1.0 }),
        );
        let error = live.set_faults(vec![vanes]).unwrap_err().to_string();
        assert!(error.contains("IGV"), "{error}");
        let endless = Fault::growing(FaultCase::TurbineDamage, f64::NAN, 1.0, None);
        assert!(live.set_faults(vec![endless]).is_err());
        assert_eq!(live.faults(), before);
    }
}
