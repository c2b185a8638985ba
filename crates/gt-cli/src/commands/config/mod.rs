//! `gtfdi config`: the files that users write.

mod check;
mod init;
mod schema;

pub use check::check;
pub use init::init;
pub use schema::schema;
