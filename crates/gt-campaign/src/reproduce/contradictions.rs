//! Where Table 3 contradicts itself or physics, and what the calibration does about it.

use serde::Serialize;

/// A contradiction of Table 3, with what was done about it.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Contradiction {
    /// The entries concerned.
    pub entries: &'static [&'static str],
    /// What is wrong with them as printed.
    pub printed: &'static str,
    /// What the model does instead.
    pub model: &'static str,
}

/// All of them; the calibration of the plant says the same where the parameters are derived.
pub const CONTRADICTIONS: [Contradiction; 9] = [
    Contradiction {
        entries: &["m3", "m4", "m5", "m6", "m8", "m9", "m10"],
        printed: "the flows do not balance: m9 exceeds m5 + M_f by 2.3 %, m4 exceeds m3 by 0.9 %",
        model: "replaced by flows whose balances close, with the least squared relative changes",
    },
    Contradiction {
        entries: &["m1"],
        printed: "about half of m3, though nothing leaves or joins between them",
        model: "read as one of two parallel intake legs, whose share is taken from the table",
    },
    Contradiction {
        entries: &["P_c", "P_t"],
        printed: "the turbine gives 0.8 % less than the compressor takes: no equilibrium",
        model: "P_c follows from flow, t2 and t3; P_t is P_c and an assumed loss of 10 kW",
    },
    Contradiction {
        entries: &["q_t"],
        printed: "0.3 % beside P_t / w_t",
        model: "the two agree",
    },
    Contradiction {
        entries: &["t1", "t2"],
        printed: "t1 lies above ambient and t2 5 % below t1: impossible in an adiabatic duct",
        model: "constant factors reproduce both",
    },
    Contradiction {
        entries: &["p1", "p8"],
        printed: "p1 lies above ambient and p8 below, which no passive duct gives",
        model: "constant heads of a fan and a draught stand for both",
    },
    Contradiction {
        entries: &["e_c"],
        printed: "t2, t3 and p3 / p2 imply 0.839 with real heat capacities, 0.857 with a constant \
                  ratio of 1.4, not 0.877",
        model: "reported from ambient, since t2 is not physical",
    },
    Contradiction {
        entries: &["e_t"],
        printed: "0.794 does not give the printed power",
        model: "0.806 does; t7 is then 0.7 % below the table's",
    },
    Contradiction {
        entries: &["t5", "t6"],
        printed: "equal to all digits, though m6 cools the gas between them",
        model: "m6 mixes in upstream of station 5",
    },
];

#[cfg(test)]
mod tests {
    use super::CONTRADICTIONS;
    use crate::paper::TABLE3;

    fn printed(name: &str) -> f64 {
        let entry = TABLE3.iter().find(|(variable, _)| *variable == name);
        entry.expect("an entry of Table 3").1
    }

    #[test]
    fn published_contradictions_are_in_the_table_as_said() {
        for contradiction in CONTRADICTIONS {
            contradiction
                .entries
                .iter()
                .for_each(|name| assert!(printed(name) > 0.0));
        }
        let percent = |a: f64, b: f64| 100.0 * (a / b - 1.0);
        // The fuel flow, ambient temperature and pressure are inputs of Table 3.
        let (fuel, ambient_k, ambient_pa) = (0.212_24, 288.16, 101_325.0);
        let near = |found: f64, said: f64, digit: f64| {
            assert!((found - said).abs() <= 0.5 * digit, "{found}, said {said}");
        };
        near(percent(printed("m9"), printed("m5") + fuel), 2.3, 0.1);
        near(percent(printed("m4"), printed("m3")), 0.9, 0.1);
        near(printed("m1") / printed("m3"), 0.49, 0.01);
        near(percent(printed("P_t"), printed("P_c")), -0.8, 0.1);
        near(
            percent(printed("q_t"), printed("P_t") / printed("w_t")),
            0.3,
            0.1,
        );
        near(percent(printed("t2"), printed("t1")), -5.0, 0.1);
        assert!(printed("t1") > ambient_k);
        assert!(printed("p1") > ambient_pa && printed("p8") < ambient_pa);
        let ratio: f64 = printed("p3") / printed("p2");
        let rise = printed("t3") / printed("t2") - 1.0;
        near((ratio.powf(0.4 / 1.4) - 1.0) / rise, 0.857, 0.001);
        near(percent(printed("t6"), printed("t5")), 0.0, 1e-9);
    }
}
