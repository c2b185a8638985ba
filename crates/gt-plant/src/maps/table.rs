//! The table: checked, immutable, shared.

use std::cell::Cell;
use std::fmt;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::grid::{Grid, MapValue, ROUNDING};
use super::line::{LINES, SpeedLine};
use super::{MapEdge, MapExit, MapPosition};
use crate::PlantError;
use crate::real::Real;

/// What a map is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MapKind {
    /// A compressor: flow falls with the pressure ratio; corrected flow in kg/s.
    Compressor,
    /// A turbine: flow does not fall with the expansion ratio; `m sqrt T / p` in
    /// kg sqrt(K) / (s Pa).
    Turbine,
}

impl MapKind {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Compressor => "compressor",
            Self::Turbine => "turbine",
        }
    }
}

/// What to do at an operating point outside a map. The table only carries this wish; its values
/// are continued either way, and whoever reads them asks [`SpeedLineTable::position`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Extrapolation {
    /// An error.
    #[default]
    Refuse,
    /// A warning.
    Flag,
}

/// A map: 2 to 64 [`SpeedLine`]s of strictly rising speed. Format, units and interpolation stand in
/// the documentation of [`maps`](super). A clone is cheap; two tables are equal when their files
/// are.
#[derive(Clone, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Document", into = "Document")]
pub struct SpeedLineTable {
    extrapolation: Extrapolation,
    map: Arc<Map>,
}

struct Map {
    kind: MapKind,
    lines: Vec<SpeedLine>,
    grid: Grid,
}

/// The file.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Document {
    kind: MapKind,
    #[serde(default)]
    extrapolation: Extrapolation,
    line: Vec<SpeedLine>,
}

impl SpeedLineTable {
    /// The map through `lines`.
    ///
    /// # Errors
    ///
    /// [`PlantError::MapLines`], [`PlantError::MapSpeed`], [`PlantError::MapPoints`],
    /// [`PlantError::MapLength`] or [`PlantError::MapPoint`] for the first thing that is wrong.
    pub fn new(
        kind: MapKind,
        extrapolation: Extrapolation,
        lines: Vec<SpeedLine>,
    ) -> Result<Self, PlantError> {
        let [least, most] = LINES;
        if !(least..=most).contains(&lines.len()) {
            return Err(PlantError::MapLines {
                least,
                most,
                found: lines.len(),
            });
        }
        let mut before = None;
        for (index, line) in lines.iter().enumerate() {
            line.check(index + 1, before, kind)?;
            before = Some(line.speed);
        }
        if kind == MapKind::Compressor {
            for (index, pair) in lines.windows(2).enumerate() {
                pair[1].check_faster_than(&pair[0], index + 2)?;
            }
        }
        let grid = Grid::new(&lines);
        Ok(Self {
            extrapolation,
            map: Arc::new(Map { kind, lines, grid }),
        })
    }

    /// What the map is of.
    pub fn kind(&self) -> MapKind {
        self.map.kind
    }

    /// What the file wishes at a point outside the map.
    pub fn extrapolation(&self) -> Extrapolation {
        self.extrapolation
    }

    /// The same map with another wish.
    #[must_use]
    pub fn with_extrapolation(self, extrapolation: Extrapolation) -> Self {
        Self {
            extrapolation,
            ..self
        }
    }

    /// The lines.
    pub fn lines(&self) -> &[SpeedLine] {
        &self.map.lines
    }

    /// Lowest and highest speed.
    pub fn speed_range(&self) -> [f64; 2] {
        self.map.grid.speed_range()
    }

    /// Lowest and highest pressure ratio at a speed; outside the table's speeds continued.
    pub fn pressure_ratio_range(&self, speed: f64) -> [f64; 2] {
        self.map.grid.place(speed).range()
    }

    /// Flow and efficiency with their derivatives. Finite, with positive flow and efficiency, for
    /// all that is no NaN; does not allocate.
    pub fn evaluate(&self, speed: f64, pressure_ratio: f64) -> MapValue {
        let grid = &self.map.grid;
        grid.evaluate(&grid.place(speed), pressure_ratio)
    }

    /// Corrected flow.
    pub fn flow<R: Real>(&self, speed: R, pressure_ratio: R) -> R {
        speed.look_up(pressure_ratio, |speed, pressure_ratio| {
            self.evaluate(speed, pressure_ratio).flow
        })
    }

    /// Isentropic efficiency.
    pub fn efficiency<R: Real>(&self, speed: R, pressure_ratio: R) -> R {
        speed.look_up(pressure_ratio, |speed, pressure_ratio| {
            self.evaluate(speed, pressure_ratio).efficiency
        })
    }

    /// Corrected flow and isentropic efficiency. A plain or a dual number costs one evaluation,
    /// not the two of [`flow`](Self::flow) and [`efficiency`](Self::efficiency).
    pub fn flow_and_efficiency<R: Real>(&self, speed: R, pressure_ratio: R) -> [R; 2] {
        let key = |speed: f64, pressure_ratio: f64| [speed, pressure_ratio].map(f64::to_bits);
        // The second look-up of the same point reads what the first one found beside the flow.
        let last: Cell<Option<([u64; 2], [f64; 3])>> = Cell::new(None);
        let flow = speed.look_up(pressure_ratio, |speed, pressure_ratio| {
            let value = self.evaluate(speed, pressure_ratio);
            last.set(Some((key(speed, pressure_ratio), value.efficiency)));
            value.flow
        });
        let efficiency = speed.look_up(pressure_ratio, |speed, pressure_ratio| match last.get() {
            Some((point, efficiency)) if point == key(speed, pressure_ratio) => efficiency,
            _ => self.evaluate(speed, pressure_ratio).efficiency,
        });
        [flow, efficiency]
    }

    /// Whether a point lies on the map, the edges (but for rounding) included, and if not, over
    /// which edge it left.
    pub fn position(&self, speed: f64, pressure_ratio: f64) -> MapPosition {
        let exit = |edge, [low, high]: [f64; 2], value| {
            MapPosition::Outside(MapExit {
                edge,
                low,
                high,
                value,
            })
        };
        let grid = &self.map.grid;
        let speeds = grid.speed_range();
        if speed > speeds[1] {
            return exit(MapEdge::FastestLine, speeds, speed);
        }
        if speed < speeds[0] || speed.is_nan() {
            return exit(MapEdge::SlowestLine, speeds, speed);
        }
        let [least, most] = match self.map.kind {
            MapKind::Compressor => [MapEdge::ChokeSide, MapEdge::SurgeSide],
            MapKind::Turbine => [MapEdge::LowExpansion, MapEdge::HighExpansion],
        };
        let place = grid.place(speed);
        let share = place.share(pressure_ratio);
        if share > 1.0 + ROUNDING {
            return exit(most, place.range(), pressure_ratio);
        }
        if share < -ROUNDING || share.is_nan() {
            return exit(least, place.range(), pressure_ratio);
        }
        MapPosition::Inside
    }
}

impl PartialEq for SpeedLineTable {
    fn eq(&self, other: &Self) -> bool {
        self.extrapolation == other.extrapolation
            && (Arc::ptr_eq(&self.map, &other.map)
                || (self.kind() == other.kind() && self.lines() == other.lines()))
    }
}

impl fmt::Debug for SpeedLineTable {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("SpeedLineTable")
            .field("kind", &self.kind())
            .field("extrapolation", &self.extrapolation)
            .field("lines", &self.lines())
            .finish_non_exhaustive()
    }
}

impl TryFrom<Document> for SpeedLineTable {
    type Error = PlantError;

    fn try_from(document: Document) -> Result<Self, PlantError> {
        Self::new(document.kind, document.extrapolation, document.line)
    }
}

impl From<SpeedLineTable> for Document {
    fn from(table: SpeedLineTable) -> Self {
        Self {
            kind: table.kind(),
            extrapolation: table.extrapolation,
            line: table.lines().to_vec(),
        }
    }
}
