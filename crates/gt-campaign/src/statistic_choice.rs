//! A statistic by its name and options, as the command line and Python give it.

use gtfdi::fdi::{FdiError, Glr, StatisticError, StatisticKind, ThresholdRule, Waveform};

/// Ten seconds of the paper's sample time.
const AVERAGE_WINDOW: usize = 125;
/// Two seconds of it.
const SQUARES_WINDOW: usize = 25;
/// A minute and a half of it, and the correlations that are looked at: as many as the model's order
/// is likely to be.
const WHITENESS: (usize, usize) = (1125, 8);
/// The mean time between false alarms where nobody asks for another, in hours.
const DEFAULT_ARL0_HOURS: f64 = 24.0;

/// A statistic's name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StatisticName {
    /// The modulus of the residual against a limit.
    Threshold,
    /// The mean over a window.
    MovingAverage,
    /// The cumulative sum.
    Cusum,
    /// The generalised likelihood ratio.
    Glr,
    /// The sum of squares over a window.
    Chi2,
    /// The Shiryaev-Roberts procedure.
    ShiryaevRoberts,
    /// The variance over a window.
    Variance,
    /// The correlations over a window.
    Whiteness,
}

impl StatisticName {
    /// All of them, as they are spelled.
    pub const ALL: [(&'static str, Self); 8] = [
        ("threshold", Self::Threshold),
        ("moving-average", Self::MovingAverage),
        ("cusum", Self::Cusum),
        ("glr", Self::Glr),
        ("chi2", Self::Chi2),
        ("shiryaev-roberts", Self::ShiryaevRoberts),
        ("variance", Self::Variance),
        ("whiteness", Self::Whiteness),
    ];

    /// As it is spelled.
    pub fn text(self) -> &'static str {
        let all = Self::ALL.iter();
        all.clone()
            .find(|(_, name)| *name == self)
            .map_or("", |(text, _)| text)
    }

    /// The options that it has.
    fn options(self) -> &'static [&'static str] {
        match self {
            Self::Threshold => &[],
            Self::MovingAverage | Self::Chi2 | Self::Variance | Self::Whiteness => &["window"],
            Self::Cusum | Self::ShiryaevRoberts => &["allowance"],
            Self::Glr => &["window", "waveform", "sizes"],
        }
    }

    /// The rule for its limit where nobody gives one: a margin for a plain threshold, one false
    /// alarm in a day for what is calibrated.
    pub fn default_rule(self, consecutive: usize) -> ThresholdRule {
        match self {
            Self::Threshold => ThresholdRule::Margin {
                factor: ThresholdRule::DEFAULT_MARGIN,
                consecutive,
            },
            _ => ThresholdRule::MeanTimeBetweenFalseAlarms {
                hours: DEFAULT_ARL0_HOURS,
                consecutive,
            },
        }
    }
}

/// A name with its options; what is left out has a default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatisticChoice {
    /// The name.
    pub name: StatisticName,
    /// Samples: 125 of a moving average or a variance, 25 of a sum of squares, 1125 of correlations
    /// (of 8 lags); the longest window of a likelihood ratio, 4096.
    pub window: Option<usize>,
    /// Of a cumulative sum, half the deviation to be found in standard deviations: 0.5; twice that is
    /// the shift of the Shiryaev-Roberts procedure.
    pub allowance: Option<f64>,
    /// The fault that a likelihood ratio looks for: a ramp.
    pub waveform: Option<Waveform>,
    /// Its smallest and largest size: 1e-4 to 1e-2 standard deviations a sample of ramps, 0.1 to 10
    /// standard deviations of steps.
    pub sizes: Option<(f64, f64)>,
}

/// An option that does not fit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OptionRefusal {
    /// The option's name.
    pub option: &'static str,
    /// What was expected and what was found.
    pub reason: String,
}

impl StatisticChoice {
    /// The statistic.
    ///
    /// # Errors
    /// An option that the statistic does not have, or one out of its range.
    pub fn kind(&self) -> Result<StatisticKind, OptionRefusal> {
        let given = [
            ("window", self.window.is_some()),
            ("allowance", self.allowance.is_some()),
            ("waveform", self.waveform.is_some()),
            ("sizes", self.sizes.is_some()),
        ];
        let own = self.name.options();
        if let Some((option, _)) = given
            .into_iter()
            .find(|(option, given)| *given && !own.contains(option))
        {
            let all = StatisticName::ALL.iter();
            let owners = all.filter(|(_, name)| name.options().contains(&option));
            let owners: Vec<&str> = owners.map(|(text, _)| *text).collect();
            let found = self.name.text();
            let reason = format!(
                "expected with the statistic {}, found {found}",
                owners.join(" or ")
            );
            return Err(OptionRefusal { option, reason });
        }
        let kind = self.unchecked();
        kind.validate().map_err(|error| OptionRefusal {
            option: match error {
                FdiError::Statistic(
                    StatisticError::Window { .. }
                    | StatisticError::WindowRange { .. }
                    | StatisticError::Lags { .. },
                ) => "window",
                FdiError::Statistic(
                    StatisticError::Allowance { .. } | StatisticError::Option { .. },
                ) => "allowance",
                _ => "sizes",
            },
            reason: error.to_string(),
        })?;
        Ok(kind)
    }

    fn unchecked(&self) -> StatisticKind {
        let window = |default: usize| self.window.unwrap_or(default);
        let allowance = self.allowance.unwrap_or(StatisticKind::DEFAULT_ALLOWANCE);
        match self.name {
            StatisticName::Threshold => StatisticKind::Modulus,
            StatisticName::MovingAverage => StatisticKind::MovingAverage {
                window: window(AVERAGE_WINDOW),
            },
            StatisticName::Chi2 => StatisticKind::ChiSquare {
                window: window(SQUARES_WINDOW),
            },
            StatisticName::Variance => StatisticKind::Variance {
                window: window(AVERAGE_WINDOW),
            },
            StatisticName::Whiteness => StatisticKind::Whiteness {
                window: window(WHITENESS.0),
                lags: WHITENESS.1,
            },
            StatisticName::Cusum => StatisticKind::Cusum { allowance },
            StatisticName::ShiryaevRoberts => StatisticKind::ShiryaevRoberts {
                shift: 2.0 * allowance,
            },
            StatisticName::Glr => {
                let waveform = self.waveform.unwrap_or(Waveform::Ramp);
                let default = match waveform {
                    Waveform::Step => StatisticKind::DEFAULT_STEPS,
                    Waveform::Ramp => StatisticKind::DEFAULT_SLOPES,
                };
                let (smallest, largest) = self.sizes.unwrap_or(default);
                StatisticKind::Glr {
                    waveform,
                    smallest,
                    largest,
                    longest: window(Glr::DEFAULT_LONGEST),
                }
            }
        }
    }
}
