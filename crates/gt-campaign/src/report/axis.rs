//! Axes of charts: from values to pixels, and the values that are printed beside them.

/// Ticks aimed at on an axis.
const TICKS: f64 = 6.0;
/// The most ticks.
const MOST_TICKS: usize = 50;
/// Decades from which on only powers of ten are ticks.
const MANY_DECADES: f64 = 2.5;

/// How values lie along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// By their logarithms; values that are not above 0 are not drawn.
    Logarithmic,
}

impl Scale {
    /// What lies evenly.
    fn even(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Logarithmic => value.ln(),
        }
    }
}

/// A map from data to pixels on one axis.
pub(super) struct Axis {
    /// How values lie along it.
    pub scale: Scale,
    /// Its ends as values.
    pub low: f64,
    pub high: f64,
    /// Its ends in pixels.
    pub from: f64,
    pub to: f64,
}

impl Axis {
    /// The axis that holds the finite values (above 0 of logarithmic ones), widened a little; of none
    /// or of a single value a visible band.
    pub(super) fn over(
        scale: Scale,
        values: impl Iterator<Item = f64>,
        margin: f64,
        [from, to]: [f64; 2],
    ) -> Self {
        let (low, high) = match scale {
            Scale::Linear => extent(values, margin),
            Scale::Logarithmic => {
                let (low, high) = extent(values.map(f64::ln), margin);
                (low.exp(), high.exp())
            }
        };
        Self {
            scale,
            low,
            high,
            from,
            to,
        }
    }

    /// How much of what lies evenly a pixel is.
    pub(super) fn per_pixel(&self) -> f64 {
        let [low, high] = [self.low, self.high].map(|own| self.scale.even(own));
        (high - low) / (self.to - self.from).abs()
    }

    /// Widens a linear axis on both sides until a pixel is `per_pixel`.
    pub(super) fn widen(&mut self, per_pixel: f64) {
        if self.scale != Scale::Linear {
            return;
        }
        let more = (per_pixel - self.per_pixel()) * (self.to - self.from).abs() / 2.0;
        self.low -= more;
        self.high += more;
    }

    /// Where a value lies; not a number where it lies nowhere.
    pub(super) fn pixel(&self, value: f64) -> f64 {
        let [low, high, value] = [self.low, self.high, value].map(|own| self.scale.even(own));
        self.from + (value - low) / (high - low) * (self.to - self.from)
    }

    /// Round values inside, with their labels.
    pub(super) fn ticks(&self) -> Vec<(f64, String)> {
        match self.scale {
            Scale::Linear => self.even_ticks(),
            Scale::Logarithmic => self.decade_ticks(),
        }
    }

    /// 1, 2 or 5 times a power of ten apart.
    fn even_ticks(&self) -> Vec<(f64, String)> {
        let raw = (self.high - self.low) / TICKS;
        let power = 10f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|factor| factor * power)
            .find(|step| *step >= raw)
            .unwrap_or(raw);
        let mut ticks = Vec::new();
        let mut index = (self.low / step).ceil();
        while index * step <= self.high + 1e-9 * step && ticks.len() < MOST_TICKS {
            ticks.push((index * step, label(index * step, step)));
            index += 1.0;
        }
        ticks
    }

    /// Powers of ten, and 2 and 5 times those where there are few.
    fn decade_ticks(&self) -> Vec<(f64, String)> {
        let [low, high] = [self.low, self.high].map(f64::log10);
        let factors: &[f64] = if high - low > MANY_DECADES {
            &[1.0]
        } else {
            &[1.0, 2.0, 5.0]
        };
        let mut ticks = Vec::new();
        let mut decade = low.floor();
        while decade <= high && ticks.len() < MOST_TICKS {
            let power = 10f64.powf(decade);
            let own = factors.iter().map(|factor| factor * power);
            let inside = own.filter(|tick| (self.low..=self.high).contains(tick));
            ticks.extend(inside.map(|tick| (tick, label(tick, power))));
            decade += 1.0;
        }
        ticks
    }
}

/// The extent of finite values, widened a little; a flat or empty extent becomes a visible band.
fn extent(values: impl Iterator<Item = f64>, margin: f64) -> (f64, f64) {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
    if low > high {
        return (0.0, 1.0);
    }
    let span = high - low;
    // Below this share of the value itself the curve is flat to the reader.
    if span <= 1e-9 * low.abs().max(high.abs()) {
        let band = low.abs().max(1.0) * 0.01;
        return (low - band, high + band);
    }
    (low - margin * span, high + margin * span)
}

/// A number as a tick label: as many digits as the spacing needs.
fn label(value: f64, step: f64) -> String {
    let magnitude = value.abs().max(step);
    if !(1e-3..1e6).contains(&magnitude) {
        if value == 0.0 {
            return "0".to_owned();
        }
        let digits = (value.abs().log10().floor() - step.log10().floor()).clamp(0.0, 12.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped to 0..=12
        return format!("{value:.*e}", digits as usize);
    }
    let decimals = (-step.log10().floor()).clamp(0.0, 12.0);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped to 0..=12
    let text = format!("{value:.*}", decimals as usize);
    if text
        .trim_start_matches('-')
        .chars()
        .all(|digit| digit == '0' || digit == '.')
    {
        "0".to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ticks(scale: Scale, ends: [f64; 2]) -> Vec<f64> {
        let axis = Axis::over(scale, ends.into_iter(), 0.0, [0.0, 1.0]);
        axis.ticks().into_iter().map(|(tick, _)| tick).collect()
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(
            ticks(Scale::Linear, [566.4, 588.1]),
            [570.0, 575.0, 580.0, 585.0]
        );
        assert_eq!(ticks(Scale::Logarithmic, [0.3, 7.0]), [0.5, 1.0, 2.0, 5.0]);
        assert_eq!(
            ticks(Scale::Logarithmic, [0.5, 2000.0]),
            [1.0, 10.0, 100.0, 1000.0]
        );
        assert_eq!(label(206000.0, 1000.0), "206000");
        assert_eq!(label(0.00012, 0.00002), "1.2e-4");
        assert_eq!(label(-1e-17, 0.5), "0");
    }

    /// Nothing to show, or nothing with a logarithm.
    #[test]
    fn an_axis_of_nothing_is_one_all_the_same() {
        for values in [vec![], vec![f64::NAN], vec![-1.0, 0.0]] {
            let axis = Axis::over(Scale::Logarithmic, values.into_iter(), 0.1, [0.0, 1.0]);
            assert!(
                axis.low < axis.high && axis.low > 0.0,
                "{} {}",
                axis.low,
                axis.high
            );
            assert!(axis.ticks().len() < MOST_TICKS);
        }
    }
}
