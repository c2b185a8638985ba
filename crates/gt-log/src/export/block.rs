//! Rows of a table that are in memory at a time.

use gt_core::Signal;
use serde_json::Value;

/// Cells of a block: 16 MB of numbers.
const CELLS: usize = 1 << 20;
/// Most rows of a block, which is a row group of Parquet.
const MOST_ROWS: usize = 1 << 17;

/// What the cells of a column are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Number,
    Integer,
    Truth,
    /// A text as it is.
    Text,
    /// JSON as text.
    Json,
}

impl Kind {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Number => "number",
            Self::Integer => "integer",
            Self::Truth => "truth",
            Self::Text | Self::Json => "text",
        }
    }
}

/// What a table is before its rows.
pub(super) struct Head {
    pub(super) topic: String,
    /// The name of the column of the time.
    pub(super) time: String,
    /// The time of the topic's first message.
    pub(super) first_ns: u64,
    /// The other columns.
    pub(super) columns: Vec<(Signal, Kind)>,
}

impl Head {
    /// Rows of a block.
    pub(super) fn block_rows(&self) -> usize {
        (CELLS / (self.columns.len() + 1)).clamp(1, MOST_ROWS)
    }
}

/// The cells of a column, all of one kind.
#[derive(Debug)]
pub(super) enum Cells {
    Numbers(Vec<Option<f64>>),
    Integers(Vec<Option<i64>>),
    Truths(Vec<Option<bool>>),
    Texts(Vec<Option<String>>),
}

impl Cells {
    fn new(kind: Kind) -> Self {
        match kind {
            Kind::Number => Self::Numbers(Vec::new()),
            Kind::Integer => Self::Integers(Vec::new()),
            Kind::Truth => Self::Truths(Vec::new()),
            Kind::Text | Kind::Json => Self::Texts(Vec::new()),
        }
    }

    fn clear(&mut self) {
        match self {
            Self::Numbers(cells) => cells.clear(),
            Self::Integers(cells) => cells.clear(),
            Self::Truths(cells) => cells.clear(),
            Self::Texts(cells) => cells.clear(),
        }
    }

    fn push_number(&mut self, value: Option<f64>) {
        if let Self::Numbers(cells) = self {
            cells.push(value);
        }
    }

    fn push_json(&mut self, kind: Kind, value: Option<&Value>) {
        match self {
            Self::Numbers(cells) => cells.push(value.and_then(Value::as_f64)),
            Self::Integers(cells) => cells.push(value.and_then(Value::as_i64)),
            Self::Truths(cells) => cells.push(value.and_then(Value::as_bool)),
            Self::Texts(cells) => cells.push(value.map(|own| match own {
                Value::String(text) if kind == Kind::Text => text.clone(),
                other => other.to_string(),
            })),
        }
    }
}

/// A cell of a row that is not yet in a column.
pub(super) enum Cell<'a> {
    Number(Option<f64>),
    Json(Option<&'a Value>),
}

/// Rows that follow each other.
pub(super) struct Block {
    /// The number of its first row.
    pub(super) first_row: usize,
    pub(super) times_ns: Vec<u64>,
    pub(super) columns: Vec<Cells>,
    kinds: Vec<Kind>,
    /// Cells without a value in each column, of all rows so far.
    pub(super) absent: Vec<usize>,
}

impl Block {
    /// No rows of a table.
    pub(super) fn new(head: &Head) -> Self {
        let kinds: Vec<Kind> = head.columns.iter().map(|own| own.1).collect();
        Self {
            first_row: 0,
            times_ns: Vec::new(),
            columns: kinds.iter().map(|kind| Cells::new(*kind)).collect(),
            absent: vec![0; kinds.len()],
            kinds,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.times_ns.len()
    }

    /// Adds a row with a cell for each column.
    pub(super) fn push<'a>(&mut self, time_ns: u64, cells: impl IntoIterator<Item = Cell<'a>>) {
        self.times_ns.push(time_ns);
        let places = self
            .columns
            .iter_mut()
            .zip(&self.kinds)
            .zip(&mut self.absent);
        for (((column, kind), absent), cell) in places.zip(cells) {
            let is_there = match cell {
                Cell::Number(value) => {
                    column.push_number(value);
                    value.is_some()
                }
                Cell::Json(value) => {
                    column.push_json(*kind, value);
                    value.is_some()
                }
            };
            *absent += usize::from(!is_there);
        }
    }

    /// Makes room for the rows that follow.
    pub(super) fn clear(&mut self) {
        self.first_row += self.times_ns.len();
        self.times_ns.clear();
        self.columns.iter_mut().for_each(Cells::clear);
    }
}
