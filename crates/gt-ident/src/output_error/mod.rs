//! Refinement of an ARX model on the error of its free run.
//!
//! Least squares on one step ahead is quick and convex, but noise on the outputs biases it, and it
//! hardly sees the slow poles that a free run lives on. Gauss-Newton on the free-run error has
//! neither fault, but needs a start, and over-fits a short record: a refined row is accepted only
//! where the free run of a second record agrees.

mod refinement;
mod run;
mod search;

pub use refinement::{InitialOutputs, OutputErrorRefinement, Refined, RefinedOutput};
