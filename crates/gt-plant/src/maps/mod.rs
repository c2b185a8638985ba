//! Maps of compressor and turbine: analytic laws, or tables of speed lines.
//!
//! A [`SpeedLineTable`] holds lines of constant corrected speed, each with points of pressure
//! ratio, corrected flow and isentropic efficiency, and interpolates them to a function of speed
//! and pressure ratio with continuous first derivatives, which RK4 needs.
//!
//! ```toml
//! kind = "compressor"             # or "turbine"
//! extrapolation = "refuse"        # or "flag"
//!
//! [[line]]
//! speed = 0.95                    # corrected speed over its design value
//! pressure_ratio = [8.1, 8.6, 9.2]
//! flow = [16.9, 16.5, 15.6]
//! efficiency = [0.82, 0.83, 0.81]
//!
//! [[line]]
//! speed = 1.0
//! pressure_ratio = [9.2, 9.8, 10.5]
//! flow = [17.6, 17.2, 16.2]
//! efficiency = [0.83, 0.84, 0.82]
//! ```
//!
//! **Units.** The speed is `w / sqrt T` at the inlet over its design value. The pressure ratio is
//! the higher over the lower pressure: exit over inlet for a compressor, inlet over exit for a
//! turbine. The flow of a compressor is the corrected mass flow `m sqrt(T / 288.15 K) / (p / 101325
//! Pa)` in kg/s; that of a turbine is `m sqrt T / p` in kg sqrt(K) / (s Pa), both at the inlet.
//!
//! **Interpolation.** Each line becomes a function of its share `s = (PR - PRlow) / (PRhigh -
//! PRlow)`; the ends of the lines are interpolated over speed, so that an operating point lies at
//! one share of every line. On the union of all lines' shares stand value, both slopes and the
//! mixed derivative of flow and efficiency, and between them the bicubic Hermite polynomial. All
//! slopes are those of the parabola through three points, limited where the data are not smooth;
//! for smooth data the interpolant is of third order in the spacing.
//!
//! - *Flow* is monotone over the pressure ratio at every speed of the table, and on a line stays
//!   between its neighbouring points: slopes along a line keep inside the box of Fritsch and
//!   Carlson (1980, *Monotone piecewise cubic interpolation*), and slopes over speed leave them
//!   there.
//! - *Efficiency* has its maximum where it is wanted most, and there such limits would cost an
//!   order; it is limited as Huynh's M3 (1993, *Accurate monotone cubic interpolation*). Near a
//!   maximum it may pass a neighbouring point, but on a line it stays above 0 and at most 1.
//!
//! **Outside the table** the function continues linearly in speed and share, with the value and the
//! slopes of the border. So that it stays sane far away, every value passes a bend that is straight
//! from half the table's smallest to twice its largest flow and from half its smallest efficiency
//! to the middle between its largest and 1; beyond, flow tends to a quarter of the smallest and
//! four times the largest, efficiency to a quarter of the smallest and 1 (1.01 at most where the
//! table itself exceeds 0.99). The ends of the lines pass such a bend too, so that the pressure
//! ratio keeps a range above 1 at every speed. Far from the table's speeds flow need not be
//! monotone. [`SpeedLineTable::position`] tells which edge was left; whether that is an error is
//! the caller's choice, see [`Extrapolation`].

mod axis;
mod bend;
mod compressor;
mod grid;
mod line;
mod order;
mod position;
mod range;
mod rule;
mod slopes;
mod table;
mod tabulate;
mod turbine;

#[cfg(test)]
mod tests;

pub use compressor::{AnalyticCompressorMap, CompressorMap};
pub use grid::MapValue;
pub use line::SpeedLine;
pub use position::{MapEdge, MapExit, MapPosition};
pub use range::MapRange;
pub use rule::MapRule;
pub use table::{Extrapolation, MapKind, SpeedLineTable};
pub use turbine::{AnalyticTurbineMap, TurbineMap};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Tables that take the place of analytic maps.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Tables {
    /// Of the compressor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compressor: Option<SpeedLineTable>,
    /// Of the turbine.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turbine: Option<SpeedLineTable>,
}

impl Tables {
    /// Whether both maps are analytic.
    pub fn is_empty(&self) -> bool {
        self.compressor.is_none() && self.turbine.is_none()
    }
}
