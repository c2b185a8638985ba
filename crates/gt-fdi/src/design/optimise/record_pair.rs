//! A healthy and a faulty record of the same operation.

use gt_core::Dataset;

/// A healthy record and one with a fault, of the same operation: the same excitation, noise and
/// number of samples, so that all they differ in is what the fault does.
#[derive(Debug, Clone, Copy)]
pub struct RecordPair<'a> {
    /// Without the fault.
    pub healthy: &'a Dataset,
    /// With the fault, as many samples.
    pub faulty: &'a Dataset,
}
