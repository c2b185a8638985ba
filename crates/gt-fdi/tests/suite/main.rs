//! Tests of gt-fdi through its public interface.
// Exact where it says equal: limits are values of the record, bits are compared on purpose.
#![allow(clippy::float_cmp)]

#[cfg(test)]
mod adaptive_threshold;
#[cfg(test)]
mod architecture;
#[cfg(test)]
mod bank;
#[cfg(test)]
mod calibration;
#[cfg(test)]
mod complex_poles;
#[cfg(test)]
mod data_bound;
#[cfg(test)]
mod delay_bound;
#[cfg(test)]
mod detector;
#[cfg(test)]
mod detector_state;
#[cfg(test)]
mod energy_ratio;
#[cfg(test)]
mod equation_error;
#[cfg(test)]
mod exceedance_run_length;
#[cfg(test)]
mod false_alarm;
#[cfg(test)]
mod false_alarm_times;
#[cfg(test)]
mod fixtures;
#[cfg(test)]
mod fleet;
#[cfg(test)]
mod generator;
#[cfg(test)]
mod growing_window;
#[cfg(test)]
mod innovations;
#[cfg(test)]
mod isolation;
#[cfg(test)]
mod joint_whitening;
#[cfg(test)]
mod kalman;
#[cfg(test)]
mod observer;
#[cfg(test)]
mod placement;
#[cfg(test)]
mod pole_search;
#[cfg(test)]
mod residual_test;
#[cfg(test)]
mod riccati;
#[cfg(test)]
mod run_length;
#[cfg(test)]
mod run_sum;
#[cfg(test)]
mod scheduled;
#[cfg(test)]
mod shiryaev_roberts;
#[cfg(test)]
mod signature;
#[cfg(test)]
mod simulation;
#[cfg(test)]
mod statistic_state;
#[cfg(test)]
mod statistics;
#[cfg(test)]
mod toys;
#[cfg(test)]
mod unified;
#[cfg(test)]
mod unknown_input;
#[cfg(test)]
mod whiteness;
#[cfg(test)]
mod whitening;
#[cfg(test)]
mod windowed_variance;
