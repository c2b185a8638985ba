//! What operators cannot do, and options that make no sense.

/// A request that cannot be met.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum AlarmError {
    /// There is no such open alarm.
    #[error("alarm {id}: expected the number of an open alarm")]
    Unknown {
        /// The number asked for.
        id: u64,
    },
    /// A field of the request makes no sense.
    #[error("{field}: expected {expected}, found {found}")]
    Field {
        /// The field.
        field: &'static str,
        /// What it may be.
        expected: String,
        /// What it is.
        found: String,
    },
}
