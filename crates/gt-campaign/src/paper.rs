//! Numbers printed in S. Simani, C. Fantuzzi, *Dynamic system identification and model-based fault
//! diagnosis of an industrial gas turbine prototype*, Mechatronics 16 (2006) 341-363.
//!
//! The scan lost some labels; `p7`, `t7` and the choice of stations for the four monitored
//! outputs are decoded from the values and the fault rates, as the plant's documentation explains.

/// Table 3: steady state of the monitored prototype, in SI units (speed also in rpm).
pub const TABLE3: [(&str, f64); 30] = [
    ("p1", 102_066.235_6),
    ("p2", 101_845.664_8),
    ("p3", 1_014_989.503_4),
    ("p4", 978_218.311_8),
    ("p5", 929_453.228_6),
    ("p7", 206_408.631_2),
    ("p8", 100_900.0),
    ("m1", 8.130_2),
    ("m3", 16.686_8),
    ("m4", 16.835_5),
    ("m5", 13.149_1),
    ("m6", 1.974_8),
    ("m8", 15.444),
    ("m9", 13.668),
    ("m10", 1.461_7),
    ("t1", 291.846_5),
    ("t2", 277.235_6),
    ("t3", 577.543),
    ("t4", 577.202_4),
    ("t5", 1_139.797_6),
    ("t6", 1_139.797_6),
    ("t7", 838.419_1),
    ("q_c", 3_096.742_1),
    ("q_t", 3_081.133_2),
    ("P_c", 5_141_363.216),
    ("P_t", 5_100_672.251),
    ("w_t", 1_660.249_1),
    ("N_t", 15_854.210_7),
    ("e_c", 0.876_73),
    ("e_t", 0.793_53),
];

/// A monitored output: the paper's label, the tag chosen for it, and what the paper says of it.
#[derive(Debug, Clone, Copy)]
pub struct Monitored {
    /// The paper's label.
    pub label: &'static str,
    /// The tag of the simulated turbine that plays it.
    pub tag: &'static str,
    /// Table 6: bounds on the identification record and the two validation records.
    pub sse: [f64; 3],
    /// Sections 5.3 to 5.6: reconstruction error of the model behind the observer.
    pub reconstruction_error: Option<f64>,
    /// Sections 5.3 to 5.6: where the observer's poles were placed.
    pub observer_pole: Option<f64>,
}

/// Tables 5 and 6 and sections 5.3 to 5.6, in the order of the fault cases; speed comes last and
/// has no observer.
pub const MONITORED: [Monitored; 5] = [
    Monitored {
        label: "q_l",
        tag: "q_c",
        sse: [0.01, 0.07, 0.1],
        reconstruction_error: Some(0.009),
        observer_pole: Some(0.7),
    },
    Monitored {
        label: "t_k",
        tag: "t3",
        sse: [0.01, 0.09, 0.1],
        reconstruction_error: Some(0.007),
        observer_pole: Some(0.3),
    },
    Monitored {
        label: "p_h",
        tag: "p7",
        sse: [0.01, 0.04, 0.01],
        reconstruction_error: Some(0.008),
        observer_pole: Some(0.4),
    },
    Monitored {
        label: "m_j",
        tag: "m9",
        sse: [0.01, 0.05, 0.01],
        reconstruction_error: Some(0.006),
        observer_pole: Some(0.4),
    },
    Monitored {
        label: "w_t",
        tag: "w_t",
        sse: [0.01, 0.07, 0.1],
        reconstruction_error: None,
        observer_pole: None,
    },
];

/// The model order of sections 5.1 to 5.6.
pub const ORDER: usize = 8;

/// An output of Tables 7 and 8.
#[derive(Debug, Clone, Copy)]
pub struct EivOutput {
    /// The tag of the simulated turbine that plays it.
    pub tag: &'static str,
    /// The paper's label.
    pub label: &'static str,
    /// Table 7: reconstruction error of its errors-in-variables model.
    pub error: f64,
    /// Table 8: standard deviation of its noise over that of the output.
    pub noise: f64,
}

/// Tables 7 and 8, in the order of the fault cases.
pub const EIV_OUTPUTS: [EivOutput; 4] = [
    EivOutput {
        tag: "q_c",
        label: "q_l",
        error: 0.0042,
        noise: 0.2909,
    },
    EivOutput {
        tag: "t3",
        label: "t_k",
        error: 0.0031,
        noise: 0.0941,
    },
    EivOutput {
        tag: "p7",
        label: "p_h",
        error: 0.0054,
        noise: 0.2497,
    },
    EivOutput {
        tag: "m9",
        label: "m_i",
        error: 0.0049,
        noise: 0.2345,
    },
];

/// Table 8: standard deviations of the noise of [`INPUTS`] over those of the inputs, shared by all
/// four models.
pub const EIV_INPUT_NOISE: [f64; 2] = [0.1417, 0.2623];

/// A row of Table 10: a minimal detectable fault, in percent of the signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MinimalFault {
    /// The tag of the output that is watched.
    pub tag: &'static str,
    /// The paper's name of it.
    pub output: &'static str,
    /// Without noise.
    pub noise_free_percent: f64,
    /// With noise.
    pub noisy_percent: f64,
    /// The delay allowed, in seconds.
    pub delay_s: f64,
}

/// Table 10, by case.
pub const TABLE10: [MinimalFault; 4] = [
    MinimalFault {
        tag: "q_c",
        output: "q_l",
        noise_free_percent: 0.5,
        noisy_percent: 13.0,
        delay_s: 30.0,
    },
    MinimalFault {
        tag: "t3",
        output: "t_k",
        noise_free_percent: 10.0,
        noisy_percent: 13.0,
        delay_s: 30.0,
    },
    MinimalFault {
        tag: "p7",
        output: "p_h",
        noise_free_percent: 5.0,
        noisy_percent: 17.0,
        delay_s: 60.0,
    },
    MinimalFault {
        tag: "m9",
        output: "m_j",
        noise_free_percent: 1.0,
        noisy_percent: 14.0,
        delay_s: 10.0,
    },
];

/// The inputs of all models: valve angle and (demanded) fuel flow.
pub const INPUTS: [&str; 2] = ["a_v", "M_f"];

/// The tags that are watched for faults, in the order of the fault cases.
pub fn watched() -> impl Iterator<Item = &'static Monitored> {
    MONITORED
        .iter()
        .filter(|output| output.observer_pole.is_some())
}

/// The pole at which the paper placed the observer of `tag`, if it is one of the watched outputs.
pub fn observer_pole(tag: &str) -> Option<f64> {
    MONITORED
        .iter()
        .find(|output| output.tag == tag)?
        .observer_pole
}

/// The pole of every state of an observer where nobody says one: the paper's for the outputs that it
/// watches, halfway between dead beat and no correction for any other tag.
pub fn default_pole(tag: &str) -> f64 {
    observer_pole(tag).unwrap_or(0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_table3_is_consistent_with_itself() {
        let value = |name: &str| {
            TABLE3
                .iter()
                .find(|(variable, _)| *variable == name)
                .map(|(_, value)| *value)
                .unwrap()
        };
        // P_c = q_c w to the printed digits; N = 30 w / pi likewise.
        assert!((value("q_c") * value("w_t") / value("P_c") - 1.0).abs() < 1e-7);
        let rpm = value("w_t") * 30.0 / std::f64::consts::PI;
        assert!((rpm / value("N_t") - 1.0).abs() < 1e-7);
    }

    #[test]
    fn the_four_watched_outputs_follow_the_fault_cases() {
        let tags: Vec<&str> = watched().map(|output| output.tag).collect();
        assert_eq!(tags, ["q_c", "t3", "p7", "m9"]);
        assert_eq!(observer_pole("w_t"), None);
    }
}
