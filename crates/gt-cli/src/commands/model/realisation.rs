//! A model in state space: stability, minimality, conditioning.

use gtfdi::ident::{
    ArxModel, CONDITION_WARNING, RealisationReport, RealisationWarning, realisation_report,
};

use crate::commands::finding::Finding;
use crate::output::number;

/// What is known of the realisation; `None` where it could not be computed, with a finding.
pub struct Realisation {
    pub spectral_radius: Option<f64>,
    pub report: Option<RealisationReport>,
    pub findings: Vec<Finding>,
}

impl Realisation {
    /// Judges a model.
    pub fn of(model: &ArxModel) -> Self {
        let mut findings = Vec::new();
        let space = model.state_space();
        let radius = match &space {
            Ok(space) => space.spectral_radius().map_err(|error| error.to_string()),
            Err(error) => Err(error.to_string()),
        };
        match &radius {
            Ok(radius) if *radius >= 1.0 => findings.push(Finding {
                kind: "not_stable",
                text: format!(
                    "the model is not stable: its largest pole has modulus {}",
                    number(Some(*radius))
                ),
                advice: "a free run grows without bound; identify with --stable, with another \
                         order, or on rows that show the plant settle",
            }),
            Ok(_) => {}
            Err(error) => findings.push(Finding {
                kind: "no_poles",
                text: format!("the poles could not be computed: {error}"),
                advice: "take fewer lags",
            }),
        }
        for (signal, condition) in model.outputs().iter().zip(model.condition()) {
            if *condition > CONDITION_WARNING {
                findings.push(Finding {
                    kind: "regressors_ill_conditioned",
                    text: format!(
                        "the equation of `{}` was fitted to nearly dependent regressors, condition \
                         {condition:.1e}",
                        signal.name
                    ),
                    advice: "half of the digits may be lost; take fewer lags, leave out channels \
                             that follow each other, or hold them with --ridge",
                });
            }
        }
        let report = realisation_report(model).ok();
        for warning in report.iter().flat_map(|report| &report.warnings) {
            findings.push(finding(warning));
        }
        Self {
            spectral_radius: radius.ok(),
            report,
            findings,
        }
    }

    /// Whether all poles lie inside the unit circle.
    pub fn stable(&self) -> Option<bool> {
        self.spectral_radius.map(|radius| radius < 1.0)
    }

    /// Stability and minimality in two sentences.
    pub fn text(&self) -> String {
        let stability = match (self.stable(), self.spectral_radius) {
            (Some(true), radius) => format!("stable, spectral radius {}", number(radius)),
            (Some(false), radius) => format!("not stable, spectral radius {}", number(radius)),
            (None, _) => "stability not known".to_owned(),
        };
        match &self.report {
            Some(report) => format!(
                "{stability}; {} states, {} of them in a minimal realisation; cond(M) {}\n",
                report.order,
                report.minimal_order,
                number(Some(report.m_condition))
            ),
            None => format!("{stability}\n"),
        }
    }
}

fn finding(warning: &RealisationWarning) -> Finding {
    match warning {
        RealisationWarning::IllConditioned { condition, limit } => Finding {
            kind: "realisation_ill_conditioned",
            text: format!(
                "the realisation is ill-conditioned: cond(M) {condition:.1e}, expected at most \
                 {limit:.0e}"
            ),
            advice: "half of the digits of B may be lost; take a lower order, or sample less often",
        },
        RealisationWarning::NotMinimal { order, minimal } => Finding {
            kind: "not_minimal",
            text: format!("the realisation is not minimal: {minimal} of {order} states count"),
            advice: "take a lower order, or leave out inputs without effect",
        },
    }
}
