//! What drives a run: excitation, boundary conditions and disturbances, sample by sample.

use crate::SAMPLE_TIME_S;
use crate::boundary::{Boundary, CourseValues, Fluctuation, OrnsteinUhlenbeck};
use crate::disturbance::Disturbance;
use crate::excitation::{Dither, Profile, SteppedLevel, schedule};
use crate::random::{Purpose, stream};

/// Deviations from the design inputs during one sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Deviation {
    /// Of the valve angle, degrees.
    pub valve_deg: f64,
    /// Of the speed reference or the grid's frequency, share of design speed.
    pub speed_fraction: f64,
    /// Of the fuel flow, schedule and levels without dither, share of design fuel flow. Zero in
    /// the prototype.
    pub fuel_fraction: f64,
    /// Fuel dither, share of design fuel flow.
    pub dither_fraction: f64,
    /// Of the ambient temperature, K.
    pub ambient_k: f64,
    /// Of the ambient pressure, Pa.
    pub ambient_pa: f64,
    /// Of the lower heating value, share of the design value.
    pub heating_value_fraction: f64,
    /// Disturbance of the heat release, share of what the fuel gives.
    pub heat_release_fraction: f64,
    /// Disturbing torque on the shaft, N m; positive accelerates.
    pub torque_n_m: f64,
}

/// What drives one run; it depends on profile, boundary, disturbance, seed and run index only, and
/// every quantity has its own stream of random numbers.
#[derive(Debug, Clone)]
pub struct Drive {
    start: Deviation,
    valve: SteppedLevel,
    speed: SteppedLevel,
    fuel: SteppedLevel,
    fuel_schedule: Vec<[f64; 2]>,
    dither: Dither,
    temperature: CourseValues,
    pressure: CourseValues,
    heating_value: CourseValues,
    heat_release: Option<OrnsteinUhlenbeck>,
    torque: Option<OrnsteinUhlenbeck>,
    sample: u64,
}

impl Drive {
    /// The drive of the run `run_index` of `seed`, before its first sample.
    pub fn new(
        profile: &Profile,
        boundary: &Boundary,
        disturbance: &Disturbance,
        seed: u64,
        run_index: u64,
    ) -> Self {
        let generator = |purpose| stream(seed, run_index, purpose);
        let process = |fluctuation: Option<Fluctuation>, purpose| {
            fluctuation.map(|fluctuation| OrnsteinUhlenbeck::new(fluctuation, generator(purpose)))
        };
        let course = |course, purpose| CourseValues::new(course, generator(purpose));
        let mut drive = Self {
            start: Deviation::default(),
            valve: SteppedLevel::new(
                profile.valve_amplitude_deg,
                profile.valve_hold_s,
                profile.valve_slew_deg_s,
                generator(Purpose::Valve),
            ),
            speed: SteppedLevel::new(
                profile.speed_amplitude_fraction,
                profile.speed_hold_s,
                profile.speed_slew_fraction_s,
                generator(Purpose::Speed),
            ),
            fuel: SteppedLevel::new(
                profile.fuel_amplitude_fraction,
                profile.fuel_hold_s,
                profile.fuel_slew_fraction_s,
                generator(Purpose::Fuel),
            ),
            fuel_schedule: profile.fuel_schedule.clone(),
            dither: Dither::new(
                profile.dither_fraction,
                profile.dither_pole,
                generator(Purpose::Dither),
            ),
            temperature: course(boundary.temperature_k, Purpose::AmbientTemperature),
            pressure: course(boundary.pressure_pa, Purpose::AmbientPressure),
            heating_value: course(boundary.heating_value_fraction, Purpose::HeatingValue),
            heat_release: process(disturbance.heat_release_fraction, Purpose::HeatRelease),
            torque: process(disturbance.torque_n_m, Purpose::Torque),
            sample: 0,
        };
        drive.start = drive.without_levels();
        drive
    }

    /// The deviations at which the plant is in equilibrium before the first sample: schedule,
    /// boundary conditions and disturbances as they are at t = 0, no levels and no dither.
    pub fn start(&self) -> Deviation {
        self.start
    }

    /// The deviations of the next sample, the first of which is at t = 0. Nothing is allocated.
    pub fn step(&mut self) -> Deviation {
        let mut deviation = self.without_levels();
        deviation.valve_deg = self.valve.step();
        deviation.speed_fraction = self.speed.step();
        deviation.fuel_fraction += self.fuel.step();
        deviation.dither_fraction = self.dither.step();
        for course in [
            &mut self.temperature,
            &mut self.pressure,
            &mut self.heating_value,
        ] {
            course.advance();
        }
        for process in [&mut self.heat_release, &mut self.torque]
            .into_iter()
            .flatten()
        {
            process.advance();
        }
        self.sample += 1;
        deviation
    }

    /// Schedule, boundary conditions and disturbances of the coming sample.
    fn without_levels(&self) -> Deviation {
        let time_s = self.sample as f64 * SAMPLE_TIME_S;
        let value = |process: &Option<OrnsteinUhlenbeck>| {
            process.as_ref().map_or(0.0, OrnsteinUhlenbeck::value)
        };
        Deviation {
            fuel_fraction: schedule::share_at(&self.fuel_schedule, time_s) - 1.0,
            ambient_k: self.temperature.at(time_s),
            ambient_pa: self.pressure.at(time_s),
            heating_value_fraction: self.heating_value.at(time_s),
            heat_release_fraction: value(&self.heat_release),
            torque_n_m: value(&self.torque),
            ..Deviation::default()
        }
    }
}
