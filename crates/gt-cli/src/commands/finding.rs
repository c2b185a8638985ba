//! What is wrong with a model, and what to do about it.

use gtfdi::ident::{OutputVerdict, ResidualVerdict, Verdict};
use serde::Serialize;

use crate::output::number;

/// A finding in words.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// A short name that stays the same.
    pub kind: &'static str,
    /// What was found.
    pub text: String,
    /// What to do.
    pub advice: &'static str,
}

impl Finding {
    /// One line.
    pub fn line(&self) -> String {
        format!("{}: {}", self.text, self.advice)
    }
}

/// What the residual tests object to: one finding a test, with the outputs that it is about.
pub fn residual_findings(verdict: &ResidualVerdict) -> Vec<Finding> {
    let level = level(verdict);
    let rejected = |of: fn(&OutputVerdict) -> Verdict| -> Option<String> {
        let outputs = verdict.outputs.iter();
        let names: Vec<String> = outputs
            .filter(|output| of(output) == Verdict::Rejected)
            .map(|output| format!("`{}`", output.output))
            .collect();
        (!names.is_empty()).then(|| names.join(", "))
    };
    let mut findings = Vec::new();
    if let Some(names) = rejected(|output| output.whiteness) {
        findings.push(Finding {
            kind: "not_white",
            text: format!("the one-step errors of {names} are not white {level}"),
            advice: "the noise has dynamics that the equation has not; take more lags of the \
                     output (--na, --order), or --method eiv where the inputs are noisy too",
        });
    }
    if let Some(names) = rejected(|output| output.independence) {
        findings.push(Finding {
            kind: "inputs_not_used_up",
            text: format!("the one-step errors of {names} depend on past inputs {level}"),
            advice: "the record holds more about the way from the inputs; take more lags of them \
                     (--nb, --order), an earlier first lag (--nk) or an input left out",
        });
    }
    let alone = |verdict: &OutputVerdict| verdict.whiteness == Verdict::Rejected;
    if verdict.joint_whiteness == Verdict::Rejected && !verdict.outputs.iter().any(alone) {
        findings.push(Finding {
            kind: "not_white_together",
            text: format!("the one-step errors of all outputs together are not white {level}"),
            advice: "the error of one output foretells that of another; take lags of the other \
                     outputs (--structure full or canonical)",
        });
    }
    findings
}

/// What the residual tests do not object to, in one sentence; the findings say the rest.
pub fn residual_summary(verdict: &ResidualVerdict) -> String {
    let level = level(verdict);
    let count = |wanted: Verdict, of: fn(&OutputVerdict) -> Verdict| {
        let outputs = verdict.outputs.iter();
        outputs.filter(|output| of(output) == wanted).count()
    };
    let said = |of: fn(&OutputVerdict) -> Verdict, what: &str| {
        let (kept, untested) = (
            count(Verdict::NotRejected, of),
            count(Verdict::Untested, of),
        );
        let all = verdict.outputs.len();
        match (kept, untested) {
            (kept, _) if kept == all => what.to_owned(),
            (_, 0) => format!("{what} for {kept} of {all} outputs"),
            _ => format!("{what} for {kept} of {all} outputs, {untested} not tested"),
        }
    };
    format!(
        "one-step errors {level}: {}; {}",
        said(|output| output.whiteness, "white"),
        said(|output| output.independence, "independent of past inputs")
    )
}

fn level(verdict: &ResidualVerdict) -> String {
    let percent = number(Some(100.0 * verdict.significance));
    format!("(at {} %, {} lags)", shortened(&percent), verdict.lags)
}

/// A decimal number without zeros at its end.
fn shortened(number: &str) -> &str {
    if number.contains('.') && !number.contains('e') {
        number.trim_end_matches('0').trim_end_matches('.')
    } else {
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(joint: Verdict, outputs: &[(Verdict, Verdict)]) -> ResidualVerdict {
        let outputs = outputs.iter().enumerate();
        ResidualVerdict {
            lags: 20,
            significance: 0.01,
            joint_whiteness: joint,
            outputs: outputs
                .map(|(index, &(whiteness, independence))| OutputVerdict {
                    output: format!("y{index}"),
                    whiteness,
                    independence,
                })
                .collect(),
        }
    }

    #[test]
    fn each_test_is_one_finding_and_what_is_kept_is_said() {
        use Verdict::{NotRejected, Rejected, Untested};
        let kinds = |verdict: &ResidualVerdict| -> Vec<&str> {
            let findings = residual_findings(verdict);
            findings.iter().map(|finding| finding.kind).collect()
        };
        let sound = verdict(NotRejected, &[(NotRejected, NotRejected)]);
        assert_eq!(kinds(&sound), [""; 0]);
        assert_eq!(
            residual_summary(&sound),
            "one-step errors (at 1 %, 20 lags): white; independent of past inputs"
        );
        let poor = verdict(Rejected, &[(Rejected, Untested), (NotRejected, Rejected)]);
        assert_eq!(kinds(&poor), ["not_white", "inputs_not_used_up"]);
        let both = verdict(Rejected, &[(Rejected, NotRejected); 2]);
        assert_eq!(kinds(&both), ["not_white"]);
        assert_eq!(
            residual_findings(&both)[0].text,
            "the one-step errors of `y0`, `y1` are not white (at 1 %, 20 lags)"
        );
        assert_eq!(
            residual_summary(&poor),
            "one-step errors (at 1 %, 20 lags): white for 1 of 2 outputs; independent of past \
             inputs for 0 of 2 outputs, 1 not tested"
        );
        // Together only where no output says so by itself.
        let together = verdict(Rejected, &[(NotRejected, NotRejected); 2]);
        assert_eq!(kinds(&together), ["not_white_together"]);
    }
}
