//! Tests of gt-fdi through its public interface.
// Exact where it says equal: limits are values of the record, bits are compared on purpose.
#![allow(clippy::float_cmp)]

#[cfg(test)]
mod architecture;
#[cfg(test)]
mod bank;
#[cfg(test)]
mod calibration;
#[cfg(test)]
mod detector;
#[cfg(test)]
mod false_alarm;
#[cfg(test)]
mod fixtures;
#[cfg(test)]
mod generator;
#[cfg(test)]
mod innovations;
#[cfg(test)]
mod kalman;
#[cfg(test)]
mod observer;
#[cfg(test)]
mod riccati;
#[cfg(test)]
mod signature;
