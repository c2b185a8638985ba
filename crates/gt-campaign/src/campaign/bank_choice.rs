//! What watches the records: a bank of a file, or tests that are still to be calibrated.

use std::borrow::Cow;
use std::fmt;
use std::path::PathBuf;

use gtfdi::fdi::ThresholdRule;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::check::Problem;
use super::spec::TestPlanText;
use crate::bank_design::{TestPlan, Watch};
use crate::statistic_choice::{StatisticChoice, StatisticName};

/// What watches the records; in a file a name or a table.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum BankChoice {
    /// A bank's file.
    File(PathBuf),
    /// Tests on the residuals of a model that is identified first.
    Tests(TestFamily),
    /// An isolator of the plant's four faults, from a model that is identified first.
    Isolator(IsolatorFamily),
}

/// An isolator that is still to be made: it knows all four faults, whichever the campaign draws.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct IsolatorFamily {
    /// Mean time between false alarms of all its statistics together, in hours.
    pub arl0_h: f64,
    /// Healthy running for whitening and limits, in hours.
    pub calibration_h: f64,
    /// True: what tells it from tests in a file.
    isolator: bool,
}

impl IsolatorFamily {
    /// One with a mean time between false alarms and healthy running, both in hours.
    pub fn new(arl0_h: f64, calibration_h: f64) -> Self {
        Self {
            arl0_h,
            calibration_h,
            isolator: true,
        }
    }
}

/// Tests that share a mean time between false alarms.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TestFamily {
    /// Mean time between false alarms of all tests together, in hours.
    pub arl0_h: f64,
    /// Healthy running for whitening and limits, in hours.
    pub calibration_h: f64,
    /// The tests.
    pub tests: Vec<TestPlanText>,
}

impl Default for TestFamily {
    fn default() -> Self {
        Self {
            arl0_h: 24.0,
            calibration_h: 24.0,
            tests: vec![TestPlanText {
                statistic: "cusum".to_owned(),
                watch: None,
                window: None,
                allowance: None,
                waveform: None,
                sizes: None,
            }],
        }
    }
}

/// The table of a file, before it is one or the other.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct BankTable {
    arl0_h: Option<f64>,
    calibration_h: Option<f64>,
    tests: Option<Vec<TestPlanText>>,
    #[serde(default)]
    isolator: bool,
}

impl BankTable {
    fn choice(self) -> Result<BankChoice, &'static str> {
        let usual = TestFamily::default();
        let arl0_h = self.arl0_h.unwrap_or(usual.arl0_h);
        let calibration_h = self.calibration_h.unwrap_or(usual.calibration_h);
        match self.tests {
            Some(_) if self.isolator => Err(
                "bank.tests: expected none with `isolator = true`, which has its own, found some",
            ),
            _ if self.isolator => Ok(BankChoice::Isolator(IsolatorFamily::new(
                arl0_h,
                calibration_h,
            ))),
            tests => Ok(BankChoice::Tests(TestFamily {
                arl0_h,
                calibration_h,
                tests: tests.unwrap_or(usual.tests),
            })),
        }
    }
}

impl Default for BankChoice {
    fn default() -> Self {
        Self::Tests(TestFamily::default())
    }
}

impl JsonSchema for BankChoice {
    fn schema_name() -> Cow<'static, str> {
        "BankChoice".into()
    }

    /// A file's name or a table.
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let table = generator.subschema_for::<BankTable>();
        json_schema!({"anyOf": [{"type": "string"}, table]})
    }
}

impl<'de> Deserialize<'de> for BankChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct FileOrTests;

        impl<'de> Visitor<'de> for FileOrTests {
            type Value = BankChoice;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a bank's file or a table of tests or of an isolator")
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<BankChoice, E> {
                Ok(BankChoice::File(PathBuf::from(name)))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<BankChoice, A::Error> {
                let table = BankTable::deserialize(MapAccessDeserializer::new(map))?;
                table.choice().map_err(A::Error::custom)
            }
        }

        deserializer.deserialize_any(FileOrTests)
    }
}

impl BankChoice {
    /// The mean time between false alarms that is asked for, in hours; `None` of a file.
    pub fn arl0_h(&self) -> Option<f64> {
        match self {
            Self::File(_) => None,
            Self::Tests(family) => Some(family.arl0_h),
            Self::Isolator(family) => Some(family.arl0_h),
        }
    }
}

impl TestFamily {
    /// The plans of the tests on `outputs` outputs, whose limits give each test its share of the
    /// family's false alarms.
    ///
    /// # Errors
    /// The key, what was expected there and what was found.
    pub fn plans(&self, outputs: usize) -> Result<Vec<TestPlan>, Problem> {
        let mut plans = Vec::with_capacity(self.tests.len());
        for (place, text) in self.tests.iter().enumerate() {
            plans.push(text.plan(place)?);
        }
        let count = |watch: Watch| match watch {
            Watch::Outputs => outputs,
            Watch::Joint => 1,
            Watch::Both => outputs + 1,
        };
        let all: usize = plans.iter().map(|(_, watch)| count(*watch)).sum();
        let plans = plans.into_iter().map(|(statistic, watch)| TestPlan {
            statistic,
            // A plan gives each of its own tests as many times its hours as it has tests.
            rule: ThresholdRule::MeanTimeBetweenFalseAlarms {
                hours: self.arl0_h * all as f64 / count(watch) as f64,
                consecutive: 1,
            },
            watch,
        });
        Ok(plans.collect())
    }
}

impl TestPlanText {
    /// The statistic and what it watches; `place` is that among the tests.
    fn plan(&self, place: usize) -> Result<(gtfdi::fdi::StatisticKind, Watch), Problem> {
        let key = |option: &str| format!("bank.tests[{place}].{option}");
        let mut names = StatisticName::ALL.iter();
        let Some((_, name)) = names.find(|(text, _)| *text == self.statistic) else {
            let names = StatisticName::ALL.map(|(text, _)| text).join(", ");
            return Err(Problem::new(
                key("statistic"),
                format!("one of {names}"),
                format!("`{}`", self.statistic),
            ));
        };
        let watch = match self.watch.as_deref() {
            None | Some("outputs") => Watch::Outputs,
            Some("joint") => Watch::Joint,
            Some("both") => Watch::Both,
            Some(other) => {
                let expected = "one of outputs, joint, both";
                return Err(Problem::new(key("watch"), expected, format!("`{other}`")));
            }
        };
        let choice = StatisticChoice {
            name: *name,
            window: self.window,
            allowance: self.allowance,
            waveform: self.waveform,
            sizes: self.sizes,
        };
        let kind = choice.kind().map_err(|refusal| Problem {
            key: key(refusal.option),
            reason: refusal.reason,
        })?;
        if watch != Watch::Outputs && !kind.takes_several() {
            let expected = "outputs, as the statistic is none of several residuals";
            let found = self.watch.clone().unwrap_or_default();
            return Err(Problem::new(key("watch"), expected, found));
        }
        Ok((kind, watch))
    }
}
