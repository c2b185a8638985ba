//! A finished report: its page and the files beside it.

use std::fs;
use std::path::Path;

use gt_log::write_atomically;

use super::figure::Figure;
use crate::error::CampaignError;

/// A page with the figures that it shows.
#[derive(Debug, Clone)]
pub struct Document {
    /// The self-contained page.
    pub html: String,
    /// The figures, in their order.
    pub figures: Vec<Figure>,
}

impl Document {
    /// Writes `figures/*.svg`, `figures/*.csv` and, last, `index.html` below `folder`, which is made
    /// where it is missing. Files appear under their names only when they are whole.
    ///
    /// # Errors
    /// [`CampaignError`] names the file or folder.
    pub fn write(&self, folder: &Path) -> Result<(), CampaignError> {
        let figures = folder.join("figures");
        fs::create_dir_all(&figures).map_err(|source| CampaignError::Folder {
            path: figures.clone(),
            source,
        })?;
        for figure in &self.figures {
            figure.write(&figures)?;
        }
        write_atomically(&folder.join("index.html"), self.html.as_bytes())?;
        Ok(())
    }
}
