//! The faults of one run along its time, as the plant feels them.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;

use super::{ActuatorId, Fault, FaultCase, FaultSizes, Mode, Target};
use crate::SAMPLE_TIME_S;
use crate::excitation::standard_normal;
use crate::random::{Purpose, stream};

/// Where the actuators are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActuatorPositions {
    /// Fuel, kg/s.
    pub fuel_kg_s: f64,
    /// Opening angle of the pressurising valve, degrees.
    pub valve_deg: f64,
    /// Angle of the inlet guide vanes, degrees.
    pub guide_vanes_deg: f64,
}

impl ActuatorPositions {
    fn of(&self, actuator: ActuatorId) -> f64 {
        match actuator {
            ActuatorId::Fuel => self.fuel_kg_s,
            ActuatorId::Valve => self.valve_deg,
            ActuatorId::GuideVanes => self.guide_vanes_deg,
        }
    }
}

/// Where the magnitude of a fault that is continuous in time goes.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Place {
    FlowLoss,
    EfficiencyLoss,
    Gain(ActuatorId),
    Offset(ActuatorId),
    Lag(ActuatorId),
}

impl Place {
    /// The size for a magnitude, which is in percent where sizes are shares.
    fn size(self, magnitude: f64) -> f64 {
        match self {
            Self::FlowLoss | Self::EfficiencyLoss | Self::Gain(_) => magnitude / 100.0,
            Self::Offset(_) | Self::Lag(_) => magnitude,
        }
    }

    /// Where it is among the sizes.
    #[inline(always)]
    pub fn of<R>(self, sizes: &mut FaultSizes<R>) -> &mut R {
        match self {
            Self::FlowLoss => &mut sizes.compressor_flow_loss,
            Self::EfficiencyLoss => &mut sizes.turbine_efficiency_loss,
            Self::Gain(actuator) => &mut sizes.actuator_mut(actuator).gain_error,
            Self::Offset(actuator) => &mut sizes.actuator_mut(actuator).offset,
            Self::Lag(actuator) => &mut sizes.actuator_mut(actuator).lag_s,
        }
    }
}

/// What a fault that changes at samples only does.
#[derive(Debug, Clone)]
enum Held {
    Stick { sticks: bool },
    Spike { share: f64, generator: ChaCha12Rng },
    Noise { generator: ChaCha12Rng },
}

/// The faults of one run that reach the plant. Neither method allocates.
///
/// At every sample [`FaultCourse::begin_sample`] is called once, in order; then
/// [`FaultCourse::sizes`] as often as needed, for times until the next sample.
#[derive(Debug, Clone)]
pub struct FaultCourse {
    continuous: Vec<(Place, Fault)>,
    sampled: Vec<(ActuatorId, Held, Fault)>,
    /// The part of the sizes that holds until the next sample.
    held: FaultSizes,
}

impl FaultCourse {
    /// The course of those of `faults` that reach the plant, in the run `run_index` of `seed`.
    ///
    /// Spikes and noise of the n-th fault of a mode on an actuator draw from a stream of their own,
    /// so that no other fault changes them.
    pub fn new(faults: &[Fault], seed: u64, run_index: u64) -> Self {
        let mut course = Self {
            continuous: Vec::new(),
            sampled: Vec::new(),
            held: FaultSizes::HEALTHY,
        };
        for (index, fault) in faults.iter().enumerate() {
            let place = match fault.target {
                Target::Case(FaultCase::CompressorFouling) => Place::FlowLoss,
                Target::Case(FaultCase::TurbineDamage) => Place::EfficiencyLoss,
                Target::Case(FaultCase::FuelActuatorLag) => Place::Lag(ActuatorId::Fuel),
                Target::Case(FaultCase::ThermocoupleDrift) | Target::Sensor { .. } => continue,
                Target::Actuator { actuator, mode } => {
                    let generator = || {
                        let purpose = Purpose::ActuatorFault {
                            actuator: actuator.index(),
                            spikes: matches!(mode, Mode::Spike { .. }),
                            repeat: repeats(&faults[..index], fault),
                        };
                        stream(seed, run_index, purpose)
                    };
                    let held = match mode {
                        Mode::Bias | Mode::Drift => Err(Place::Offset(actuator)),
                        Mode::Gain => Err(Place::Gain(actuator)),
                        Mode::Lag => Err(Place::Lag(actuator)),
                        Mode::Stuck | Mode::Dropout => Ok(Held::Stick { sticks: false }),
                        Mode::Spike { spikes_per_h } => Ok(Held::Spike {
                            share: spike_share(spikes_per_h),
                            generator: generator(),
                        }),
                        Mode::Noise => Ok(Held::Noise {
                            generator: generator(),
                        }),
                    };
                    match held {
                        Ok(held) => {
                            course.sampled.push((actuator, held, fault.clone()));
                            continue;
                        }
                        Err(place) => place,
                    }
                }
            };
            course.continuous.push((place, fault.clone()));
        }
        course
    }

    /// Begins the sample at `t_s`: draws spikes and noise, and notes where an actuator sticks.
    ///
    /// `positions` are those of the moment before the sample, as they reach the plant: there an
    /// actuator stays that sticks now.
    pub fn begin_sample(&mut self, t_s: f64, positions: &ActuatorPositions) {
        if self.sampled.is_empty() {
            return;
        }
        let before = self.held;
        let mut held = FaultSizes::HEALTHY;
        for (actuator, kind, fault) in &mut self.sampled {
            let magnitude = fault.magnitude(t_s);
            let now = held.actuator_mut(*actuator);
            match kind {
                Held::Stick { sticks } => {
                    let stuck_at = if *sticks {
                        before.actuator(*actuator).stuck_at
                    } else {
                        positions.of(*actuator)
                    };
                    *sticks = magnitude != 0.0;
                    if *sticks {
                        (now.stuck, now.stuck_at) = (1.0, stuck_at);
                    }
                }
                // Drawn whether it is active or not, so that the onset shifts no draw.
                Held::Spike { share, generator } => {
                    if generator.random::<f64>() < *share {
                        now.offset += magnitude;
                    }
                }
                Held::Noise { generator } => now.offset += magnitude * standard_normal(generator),
            }
        }
        self.held = held;
    }

    /// The sizes at a time of the current sample.
    #[inline]
    pub fn sizes(&self, t_s: f64) -> FaultSizes {
        let mut sizes = self.held;
        self.each_continuous(t_s, |place, size| *place.of(&mut sizes) += size);
        sizes
    }

    /// The part of [`Self::sizes`] that holds during a sample.
    pub(crate) fn held(&self) -> &FaultSizes {
        &self.held
    }

    /// What [`Self::sizes`] adds to that part, and where.
    #[inline]
    pub(crate) fn each_continuous(&self, t_s: f64, mut add: impl FnMut(Place, f64)) {
        for (place, fault) in &self.continuous {
            add(*place, place.size(fault.magnitude(t_s)));
        }
    }

    /// Whether [`Self::begin_sample`] has anything to do.
    pub(crate) fn is_sampled(&self) -> bool {
        !self.sampled.is_empty()
    }

    /// Whether nothing ever reaches the plant.
    pub fn is_healthy(&self) -> bool {
        self.continuous.is_empty() && self.sampled.is_empty()
    }
}

/// Share of the samples that have a spike.
pub(crate) fn spike_share(spikes_per_h: f64) -> f64 {
    spikes_per_h * SAMPLE_TIME_S / 3600.0
}

/// How many of `earlier` faults have the name of `fault`.
pub(crate) fn repeats(earlier: &[Fault], fault: &Fault) -> u32 {
    let name = fault.target.name();
    let count = earlier
        .iter()
        .filter(|earlier| earlier.target.name() == name)
        .count();
    // Nobody writes 2^32 faults; those beyond would share a stream.
    u32::try_from(count).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "these values are exact")]

    use super::*;
    use crate::faults::{Ramp, Shape, Step};

    const POSITIONS: ActuatorPositions = ActuatorPositions {
        fuel_kg_s: 0.25,
        valve_deg: 49.0,
        guide_vanes_deg: -3.0,
    };

    fn step(actuator: ActuatorId, mode: Mode, onset_s: f64, size: f64) -> Fault {
        Fault::actuator(actuator, mode, onset_s, Shape::Step(Step { size }))
    }

    #[test]
    fn continuous_faults_go_where_they_belong_and_add_up() {
        let mut faults: Vec<Fault> = FaultCase::ALL
            .into_iter()
            .map(|case| Fault::growing(case, 0.0, 3600.0, None))
            .collect();
        faults.push(Fault::growing(FaultCase::TurbineDamage, 1.0, 3600.0, None));
        faults.push(step(ActuatorId::Fuel, Mode::Lag, 1.0, 0.5));
        faults.push(step(ActuatorId::Valve, Mode::Gain, 1.0, 10.0));
        faults.push(step(ActuatorId::Valve, Mode::Drift, 1.0, 2.0));
        faults.push(step(ActuatorId::Valve, Mode::Bias, 1.0, 1.0));
        faults.push(step(ActuatorId::GuideVanes, Mode::Lag, 1.0, 0.75));
        let course = FaultCourse::new(&faults, 0, 0);
        assert!(!course.is_healthy());
        let sizes = course.sizes(2.0);
        assert_eq!(sizes.compressor_flow_loss, 0.02);
        assert_eq!(sizes.turbine_efficiency_loss, 0.03);
        assert_eq!(sizes.fuel.lag_s, 2.5);
        assert_eq!((sizes.valve.gain_error, sizes.valve.offset), (0.1, 3.0));
        assert_eq!(sizes.guide_vanes.lag_s, 0.75);
        assert_eq!(
            sizes.valve.position(50.0),
            50.0 * 1.1 + 3.0,
            "gain before bias"
        );
        assert_eq!(course.sizes(0.0), FaultSizes::HEALTHY);
    }

    #[test]
    fn a_stuck_actuator_holds_the_position_of_the_moment_before() {
        let faults = [
            step(ActuatorId::Valve, Mode::Stuck, 1.0, 1.0).until(2.0),
            step(ActuatorId::Valve, Mode::Bias, 0.0, 0.5),
            step(ActuatorId::GuideVanes, Mode::Dropout, 0.0, 1.0),
        ];
        let mut course = FaultCourse::new(&faults, 0, 0);
        for k in 0..30_u32 {
            let t_s = f64::from(k) * SAMPLE_TIME_S;
            let positions = ActuatorPositions {
                valve_deg: 40.0 + f64::from(k),
                guide_vanes_deg: f64::from(k),
                ..POSITIONS
            };
            course.begin_sample(t_s, &positions);
            // 1 s is between the samples 12 and 13; 2 s is sample 25.
            let expected = match k {
                13..25 => 40.0 + 13.0,
                _ => 70.0 + 0.5,
            };
            let sizes = course.sizes(t_s + 0.03);
            assert_eq!(sizes.valve.position(70.0), expected, "{k}");
            assert_eq!(sizes.guide_vanes.position(70.0), 0.0, "{k}");
            assert_eq!(sizes.fuel.position(0.3), 0.3);
        }
    }

    #[test]
    fn spikes_and_noise_are_drawn_a_sample_and_by_no_other_fault() {
        let spikes_per_h = 9000.0;
        let spike = step(ActuatorId::Fuel, Mode::Spike { spikes_per_h }, 0.0, 0.5);
        let noise = step(ActuatorId::Fuel, Mode::Noise, 0.0, 2.0);
        let offsets = |faults: &[Fault], seed| -> Vec<f64> {
            let mut course = FaultCourse::new(faults, seed, 0);
            (0..20_000)
                .map(|k| {
                    let t_s = f64::from(k) * SAMPLE_TIME_S;
                    course.begin_sample(t_s, &POSITIONS);
                    assert_eq!(course.sizes(t_s), course.sizes(t_s + 0.07));
                    course.sizes(t_s).fuel.offset
                })
                .collect()
        };
        let spikes = offsets(std::slice::from_ref(&spike), 1);
        let count = spikes.iter().filter(|offset| **offset == 0.5).count();
        assert!(spikes.iter().all(|offset| [0.0, 0.5].contains(offset)));
        // A fifth of 20 000; standard deviation sqrt(20 000 0.2 0.8) = 57, five of them.
        assert!(count.abs_diff(4000) < 283, "{count}");
        let noises = offsets(std::slice::from_ref(&noise), 1);
        let square = noises.iter().map(|v| v * v).sum::<f64>() / 2e4;
        // Standard error of a deviation 1 / sqrt(2 N) = 0.5 %; five of them.
        assert!((square.sqrt() / 2.0 - 1.0).abs() < 0.025, "{square}");
        // Together they are the sum, in whatever order, beside other faults.
        let other = step(ActuatorId::Valve, Mode::Noise, 0.0, 1.0);
        let both = offsets(&[other, noise.clone(), spike.clone()], 1);
        for k in 0..20_000 {
            assert_eq!(both[k], noises[k] + spikes[k]);
        }
        let second = offsets(&[noise.clone(), noise], 1);
        assert!((0..20_000).all(|k| second[k] != 2.0 * noises[k]));
        assert_ne!(spikes, offsets(std::slice::from_ref(&spike), 2));
        // A later onset shifts no draw.
        let late = Fault {
            onset_s: 80.0,
            ..spike
        };
        assert_eq!(offsets(&[late], 1)[1000..], spikes[1000..]);
    }

    #[test]
    fn sensors_reach_no_plant() {
        let t3 = crate::Channel::named("t3").unwrap();
        let ramp = Shape::Ramp(Ramp {
            rate_per_h: 1.0,
            limit: None,
        });
        let faults = [
            Fault::sensor(t3, Mode::Bias, 0.0, ramp),
            Fault::nominal(FaultCase::ThermocoupleDrift, 0.0),
        ];
        assert!(FaultCourse::new(&faults, 0, 0).is_healthy());
        assert!(faults.iter().all(|fault| !fault.target.reaches_plant()));
    }
}
