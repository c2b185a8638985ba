//! Values of a table, and the types of a row that they come from.

/// A value of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Nothing.
    Null,
    /// An integer.
    Integer(i64),
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
    /// Yes or no.
    Truth(bool),
}

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// Integers.
    Integer,
    /// Numbers.
    Number,
    /// Texts.
    Text,
    /// Yes or no.
    Truth,
}

/// Between the types of a row and cells.
pub(super) trait Value: Sized {
    /// The kind of its column.
    const KIND: ColumnKind;
    /// Its cell.
    fn cell(&self) -> Cell;
    /// The value of a cell; `None` where it is none of this type.
    fn of(cell: Cell) -> Option<Self>;
}

impl Value for u64 {
    const KIND: ColumnKind = ColumnKind::Integer;
    fn cell(&self) -> Cell {
        i64::try_from(*self).map_or(Cell::Null, Cell::Integer)
    }
    fn of(cell: Cell) -> Option<Self> {
        match cell {
            Cell::Integer(value) => Self::try_from(value).ok(),
            _ => None,
        }
    }
}

impl Value for f64 {
    const KIND: ColumnKind = ColumnKind::Number;
    fn cell(&self) -> Cell {
        Cell::Number(*self)
    }
    fn of(cell: Cell) -> Option<Self> {
        match cell {
            Cell::Number(value) => Some(value),
            _ => None,
        }
    }
}

impl Value for String {
    const KIND: ColumnKind = ColumnKind::Text;
    fn cell(&self) -> Cell {
        Cell::Text(self.clone())
    }
    fn of(cell: Cell) -> Option<Self> {
        match cell {
            Cell::Text(value) => Some(value),
            _ => None,
        }
    }
}

impl Value for bool {
    const KIND: ColumnKind = ColumnKind::Truth;
    fn cell(&self) -> Cell {
        Cell::Truth(*self)
    }
    fn of(cell: Cell) -> Option<Self> {
        match cell {
            Cell::Truth(value) => Some(value),
            _ => None,
        }
    }
}

impl<T: Value> Value for Option<T> {
    const KIND: ColumnKind = T::KIND;
    fn cell(&self) -> Cell {
        self.as_ref().map_or(Cell::Null, Value::cell)
    }
    fn of(cell: Cell) -> Option<Self> {
        match cell {
            Cell::Null => Some(None),
            cell => T::of(cell).map(Some),
        }
    }
}
