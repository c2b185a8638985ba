//! Sections of the page that need more than a table.

mod cogeneration;
mod effects;
mod noise_models;

pub(super) use effects::SHARE_NOTE;
