//! How alarms come and go.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::AlarmError;

/// How alarms come and go.
///
/// | name | default | purpose | range |
/// |---|---|---|---|
/// | `on_delay_s` | 0 | how long a condition must hold before it is an alarm | 0 to 86400 |
/// | `off_delay_s` | 5 | how long it must be gone before the alarm returns | 0 to 86400 |
/// | `confirm_s` | 300 | after a gap or a restart: how long the detector judges before an alarm that it does not raise again returns | 0 to 86400 |
/// | `latch` | true | whether an alarm whose condition is gone waits for its acknowledgement | |
/// | `severity` | 500 | severity of an alarm without a name | 1 to 1000 |
/// | `severities` | none | severities by the names of faults and tests | 1 to 1000 |
/// | `longest_shelf_s` | 86400 | for how long an alarm can be set aside | 60 to 2592000 |
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AlarmOptions {
    /// How long a condition must hold before it is an alarm, in seconds.
    pub on_delay_s: f64,
    /// How long a condition must be gone before the alarm returns, in seconds.
    pub off_delay_s: f64,
    /// How long the detector judges after it started afresh before an alarm returns that it does
    /// not raise again, in seconds.
    pub confirm_s: f64,
    /// Whether an alarm whose condition is gone waits for its acknowledgement.
    pub latch: bool,
    /// Severity of an alarm without a name in `severities`.
    pub severity: u16,
    /// Severities by the names of faults and of tests.
    pub severities: BTreeMap<String, u16>,
    /// For how long an alarm can be set aside, in seconds.
    pub longest_shelf_s: f64,
}

impl Default for AlarmOptions {
    fn default() -> Self {
        Self {
            on_delay_s: 0.0,
            off_delay_s: 5.0,
            confirm_s: 300.0,
            latch: true,
            severity: 500,
            severities: BTreeMap::new(),
            longest_shelf_s: 86_400.0,
        }
    }
}

impl AlarmOptions {
    /// Refuses what makes no sense.
    ///
    /// # Errors
    /// [`AlarmError::Field`] with the first such option.
    pub fn check(&self) -> Result<(), AlarmError> {
        let ranges = [
            ("on_delay_s", self.on_delay_s, 0.0, 86_400.0),
            ("off_delay_s", self.off_delay_s, 0.0, 86_400.0),
            ("confirm_s", self.confirm_s, 0.0, 86_400.0),
            ("longest_shelf_s", self.longest_shelf_s, 60.0, 2_592_000.0),
        ];
        for (field, found, low, high) in ranges {
            if !(low..=high).contains(&found) {
                return Err(AlarmError::Field {
                    field,
                    expected: format!("{low} to {high}"),
                    found: found.to_string(),
                });
            }
        }
        let severities = self.severities.values().chain([&self.severity]);
        for found in severities {
            if !(1..=1000).contains(found) {
                return Err(AlarmError::Field {
                    field: "severity",
                    expected: "1 to 1000".to_owned(),
                    found: found.to_string(),
                });
            }
        }
        Ok(())
    }
}
