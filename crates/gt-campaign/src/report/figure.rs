//! A chart with what it shows, and the files that hold it alone.

use std::path::Path;

use gt_log::{LogError, write_atomically};

use super::chart::Chart;

/// A chart with the sentence beneath it.
#[derive(Debug, Clone)]
pub struct Figure {
    /// The drawing.
    pub chart: Chart,
    /// What it shows.
    pub caption: String,
}

impl Figure {
    /// A chart with the sentence beneath it.
    pub fn new(chart: Chart, caption: impl Into<String>) -> Self {
        Self {
            chart,
            caption: caption.into(),
        }
    }

    /// Writes the drawing as `ID.svg` and its numbers as `ID.csv` into a folder.
    ///
    /// # Errors
    /// [`LogError`] names the file.
    pub fn write(&self, folder: &Path) -> Result<(), LogError> {
        let chart = &self.chart;
        for (extension, text) in [("svg", chart.stand_alone()), ("csv", chart.csv())] {
            let path = folder.join(format!("{}.{extension}", chart.id));
            write_atomically(&path, text.as_bytes())?;
        }
        Ok(())
    }
}
