//! The models and observers of the paper: ARX of order 8, all poles at one place.

use gtfdi::core::Dataset;
use gtfdi::fdi::ResidualGenerator;
use gtfdi::ident::{Arx, ArxModel, OrderKind};

use crate::error::{CampaignError, During as _};
use crate::paper;

/// The smallest lags of [`paper::INPUTS`]: the valve angle is held from its sample on, the demanded
/// fuel acts at once, and so do further inputs.
const DELAYS: [usize; 2] = [1, 0];

/// The MISO ARX model of order 8 of the output `tag`, from a record of the paper's inputs, perhaps
/// others, and it.
pub fn model(tag: &str, data: &Dataset) -> Result<ArxModel, CampaignError> {
    let what = format!("ARX model of {tag}");
    let mut nk = DELAYS.to_vec();
    nk.resize(data.inputs().len(), 0);
    let structure = OrderKind::Diagonal { nk }
        .structure(paper::ORDER, 1)
        .during(&what)?;
    Arx::new(structure).fit(data).during(&what)
}

/// The output observer with all poles at the paper's place for this output.
pub fn observer(tag: &str, model: &ArxModel) -> Result<ResidualGenerator, CampaignError> {
    let what = format!("observer of {tag}");
    let part = model.output_model(0).during(&what)?;
    let poles = vec![paper::default_pole(tag); part.model.nx()];
    ResidualGenerator::observer(part.model, part.point, &poles).during(&what)
}
