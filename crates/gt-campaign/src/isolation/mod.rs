//! How small a fault can be found, and whether it is called by its name: seeded Monte-Carlo on the
//! turbine with an isolator that was made from records of the same sensors.

mod limit;
mod naming;
mod paper_scheme;
mod preparation;
mod recipe;
mod setting;
mod verdict;

pub use limit::{DetectionLimit, LimitSearch, Watcher};
pub use naming::{NamingRow, NamingStudy, NamingSummary};
pub use paper_scheme::PaperScheme;
pub use preparation::{Preparation, Prepared};
pub(crate) use recipe::{IsolatorRecipe, TEACHING_S};
pub use setting::{Ambient, Setting};
pub(crate) use verdict::SIZE_TOLERANCE;
pub use verdict::{FaultVerdict, Found};
