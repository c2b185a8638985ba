//! Units of measurement and what converts one into another.

/// What a unit measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dimension {
    Temperature,
    Pressure,
    GaugePressure,
    MassFlow,
    VolumeFlow,
    Length,
    Velocity,
    Voltage,
    Current,
    Power,
    Rotation,
    Angle,
    Fraction,
}

impl Dimension {
    /// The dimension in words.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Temperature => "a temperature",
            Self::Pressure => "a pressure",
            Self::GaugePressure => "a gauge pressure",
            Self::MassFlow => "a mass flow",
            Self::VolumeFlow => "a volume flow",
            Self::Length => "a length",
            Self::Velocity => "a velocity",
            Self::Voltage => "a voltage",
            Self::Current => "a current",
            Self::Power => "a power",
            Self::Rotation => "a speed of rotation",
            Self::Angle => "an angle",
            Self::Fraction => "a fraction",
        }
    }
}

/// A unit: value in SI = (value + `before`) `times` / `over`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unit {
    pub(super) dimension: Dimension,
    before: f64,
    times: f64,
    over: f64,
}

/// All units that are known, for messages.
pub(super) const KNOWN: &str = "temperatures K, degC, degF, degR; pressures Pa, bar, atm, psi, at, \
    mmHg, mmH2O, inH2O; mass flows of g, t, lb, volume flows of m3, L, gal, bbl, ft3 and \
    velocities of m, in, ft per s, min, h, d; lengths m, mil, in, ft; powers W, hp, PS; speeds of \
    rotation rpm, Hz, 1/s, 1/min, rad/s, deg/s; angles rad, deg, gon, turn; fractions 1, %, ppm; \
    voltages V; currents A; K, Pa, bar, g, L, m, W, V, A, Hz and rad with any SI prefix";

const PREFIXES: [(&str, f64, f64); 21] = [
    ("da", 1e1, 1.0),
    ("Y", 1e24, 1.0),
    ("Z", 1e21, 1.0),
    ("E", 1e18, 1.0),
    ("P", 1e15, 1.0),
    ("T", 1e12, 1.0),
    ("G", 1e9, 1.0),
    ("M", 1e6, 1.0),
    ("k", 1e3, 1.0),
    ("h", 1e2, 1.0),
    ("d", 1.0, 1e1),
    ("c", 1.0, 1e2),
    ("m", 1.0, 1e3),
    ("u", 1.0, 1e6),
    ("\u{b5}", 1.0, 1e6),
    ("\u{3bc}", 1.0, 1e6),
    ("n", 1.0, 1e9),
    ("p", 1.0, 1e12),
    ("f", 1.0, 1e15),
    ("a", 1.0, 1e18),
    ("z", 1.0, 1e21),
];

/// A pound of 0.453 592 37 kg and an inch of 25.4 mm under 9.806 65 m/s2 give 1 psi in Pa as this
/// over 645.16e-6 m2.
const POUND_FORCE_N: f64 = 4.448_221_615_260_5;
/// The international inch and foot.
const INCH_M: f64 = 0.025_4;
const FOOT_M: f64 = 0.304_8;
const CUBIC_FOOT_M3: f64 = 0.028_316_846_592;
/// The gallon of the United States, 231 cubic inches.
const GALLON_M3: f64 = 0.003_785_411_784;
/// The mechanical horsepower is 550 ft lbf/s.
const HORSEPOWER_W: f64 = 745.699_871_582_270_2;

impl Unit {
    /// The unit of a name, where it is known.
    pub(super) fn of(name: &str) -> Option<Self> {
        let name = name.trim();
        Self::plain(name)
            .or_else(|| Self::prefixed(name))
            .or_else(|| Self::rate(name))
    }

    fn plain(name: &str) -> Option<Self> {
        use Dimension::{Angle, Fraction, Length, Power, Pressure, Rotation, Temperature};
        use Dimension::{Velocity, VolumeFlow};
        use std::f64::consts::PI;
        let (dimension, before, times, over) = match name {
            "degC" | "\u{b0}C" | "C" | "celsius" | "Celsius" => (Temperature, 273.15, 1.0, 1.0),
            "degF" | "\u{b0}F" | "F" => (Temperature, 459.67, 5.0, 9.0),
            "degR" | "\u{b0}R" => (Temperature, 0.0, 5.0, 9.0),
            "atm" => (Pressure, 0.0, 101_325.0, 1.0),
            "psi" | "psia" => (Pressure, 0.0, POUND_FORCE_N, 645.16e-6),
            "at" | "kgf/cm2" | "kg/cm2" => (Pressure, 0.0, 98_066.5, 1.0),
            "mmHg" => (Pressure, 0.0, 133.322_387_415, 1.0),
            "mmH2O" => (Pressure, 0.0, 9.806_65, 1.0),
            "inH2O" => (Pressure, 0.0, 9.806_65 * 25.4, 1.0),
            "bara" | "bar(a)" => (Pressure, 0.0, 1e5, 1.0),
            "mbara" | "mbar(a)" => (Pressure, 0.0, 100.0, 1.0),
            "kPaa" | "kPa(a)" => (Pressure, 0.0, 1e3, 1.0),
            "in" => (Length, 0.0, INCH_M, 1.0),
            "mil" => (Length, 0.0, INCH_M, 1e3),
            "ft" => (Length, 0.0, FOOT_M, 1.0),
            "ips" => (Velocity, 0.0, INCH_M, 1.0),
            "fpm" => (Velocity, 0.0, FOOT_M, 60.0),
            "gpm" => (VolumeFlow, 0.0, GALLON_M3, 60.0),
            "cfm" => (VolumeFlow, 0.0, CUBIC_FOOT_M3, 60.0),
            "hp" => (Power, 0.0, HORSEPOWER_W, 1.0),
            "PS" => (Power, 0.0, 735.498_75, 1.0),
            "rpm" | "1/min" | "r/min" | "min-1" => (Rotation, 0.0, 2.0 * PI, 60.0),
            "1/s" | "rps" => (Rotation, 0.0, 2.0 * PI, 1.0),
            "rad/s" => (Rotation, 0.0, 1.0, 1.0),
            "deg/s" => (Rotation, 0.0, PI, 180.0),
            "deg" | "\u{b0}" => (Angle, 0.0, PI, 180.0),
            "gon" => (Angle, 0.0, PI, 200.0),
            "turn" | "rev" => (Angle, 0.0, 2.0 * PI, 1.0),
            "%" | "percent" => (Fraction, 0.0, 1.0, 100.0),
            "ppm" => (Fraction, 0.0, 1.0, 1e6),
            "1" => (Fraction, 0.0, 1.0, 1.0),
            _ if is_gauge(name) => (Dimension::GaugePressure, 0.0, 1.0, 1.0),
            _ => return None,
        };
        Some(Self {
            dimension,
            before,
            times,
            over,
        })
    }

    /// A unit that takes SI prefixes, with or without one.
    fn prefixed(name: &str) -> Option<Self> {
        use Dimension::{Angle, Current, Length, Power, Pressure, Rotation, Temperature, Voltage};
        let base = |name: &str| {
            let (dimension, times) = match name {
                "K" => (Temperature, 1.0),
                "Pa" => (Pressure, 1.0),
                "bar" => (Pressure, 1e5),
                "m" => (Length, 1.0),
                "W" => (Power, 1.0),
                "V" => (Voltage, 1.0),
                "A" => (Current, 1.0),
                "Hz" => (Rotation, 2.0 * std::f64::consts::PI),
                "rad" => (Angle, 1.0),
                _ => return None,
            };
            Some((dimension, times))
        };
        let ((dimension, factor), (up, down)) = with_prefix(name, base)?;
        Some(Self {
            dimension,
            before: 0.0,
            times: factor * up,
            over: down,
        })
    }

    /// A mass, a volume or a length per time.
    fn rate(name: &str) -> Option<Self> {
        use Dimension::{MassFlow, Velocity, VolumeFlow};
        let (amount, time) = name.split_once('/')?;
        let base = |name: &str| match name {
            "g" => Some((MassFlow, 1e3)),
            "L" | "l" => Some((VolumeFlow, 1e3)),
            "m" => Some((Velocity, 1.0)),
            _ => None,
        };
        let (dimension, times, over) = match amount {
            "t" => (MassFlow, 1e3, 1.0),
            "lb" => (MassFlow, 0.453_592_37, 1.0),
            "m3" | "m^3" | "m\u{b3}" => (VolumeFlow, 1.0, 1.0),
            "ft3" | "ft^3" | "ft\u{b3}" => (VolumeFlow, CUBIC_FOOT_M3, 1.0),
            "gal" => (VolumeFlow, GALLON_M3, 1.0),
            "bbl" => (VolumeFlow, 42.0 * GALLON_M3, 1.0),
            "in" => (Velocity, INCH_M, 1.0),
            "ft" => (Velocity, FOOT_M, 1.0),
            prefixed => {
                let ((dimension, parts), (up, down)) = with_prefix(prefixed, base)?;
                (dimension, up, down * parts)
            }
        };
        let seconds = match time {
            "s" => 1.0,
            "min" => 60.0,
            "h" | "hr" => 3600.0,
            "d" | "day" => 86_400.0,
            _ => return None,
        };
        Some(Self {
            dimension,
            before: 0.0,
            times,
            over: over * seconds,
        })
    }

    /// A value of this unit in another one of the same dimension.
    pub(super) fn convert(&self, value: f64, to: &Self) -> f64 {
        let (times, over) = (self.times * to.over, self.over * to.times);
        (value + self.before) * times / over - to.before
    }
}

/// What `base` knows a name as, with the prefix as two factors of which one is 1.
fn with_prefix<T>(name: &str, base: impl Fn(&str) -> Option<T>) -> Option<(T, (f64, f64))> {
    if let Some(found) = base(name) {
        return Some((found, (1.0, 1.0)));
    }
    PREFIXES.iter().find_map(|&(prefix, up, down)| {
        let found = base(name.strip_prefix(prefix)?)?;
        Some((found, (up, down)))
    })
}

/// Whether a name is that of a pressure above the ambient's.
fn is_gauge(name: &str) -> bool {
    let bare = name
        .strip_suffix("(g)")
        .or_else(|| name.strip_suffix("g"))
        .unwrap_or_default()
        .trim_end();
    bare == "psi" || matches!(Unit::prefixed(bare), Some(u) if u.dimension == Dimension::Pressure)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn converted(value: f64, from: &str, to: &str) -> f64 {
        Unit::of(from)
            .unwrap()
            .convert(value, &Unit::of(to).unwrap())
    }

    /// Definitions of the SI brochure and of NIST SP 811, appendix B.
    #[test]
    fn published_conversions() {
        let cases = [
            (100.0, "degC", "degF", 212.0),
            (32.0, "degF", "degC", 0.0),
            (0.0, "K", "degC", -273.15),
            (491.67, "degR", "K", 273.15),
            (1.0, "atm", "kPa", 101.325),
            (1.0, "psi", "Pa", 6894.757293168),
            (1.0, "bar", "MPa", 0.1),
            (1.0, "mbar", "hPa", 1.0),
            (1.0, "at", "bar", 0.980665),
            (1.0, "mmHg", "Pa", 133.322387415),
            (1.0, "mmH2O", "Pa", 9.80665),
            (1.0, "inH2O", "Pa", 249.08891),
            (3600.0, "kg/h", "kg/s", 1.0),
            (1.0, "t/h", "g/s", 277.777777777778),
            (1.0, "lb/min", "kg/s", 0.00755987283333333),
            (1.0, "t/d", "kg/h", 41.6666666666667),
            (1.0, "m3/h", "L/min", 16.6666666666667),
            (1.0, "gal/min", "m3/s", 6.30901964e-5),
            (1.0, "ft3/min", "m3/s", 4.719474432e-4),
            (1.0, "bbl/d", "gal/d", 42.0),
            (1.0, "cfm", "m\u{b3}/h", 1.69901079552),
            (1.0, "mL/s", "cL/s", 0.1),
            (25.4, "mm/s", "ips", 1.0),
            (1.0, "ft/min", "m/s", 5.08e-3),
            (1.0, "mil", "um", 25.4),
            (12.0, "in", "ft", 1.0),
            (6.6, "kV", "V", 6600.0),
            (20.0, "mA", "A", 0.02),
            (1.0, "MW", "kW", 1000.0),
            (1.0, "hp", "W", 745.6998715822702),
            (1.0, "PS", "W", 735.49875),
            (3000.0, "rpm", "Hz", 50.0),
            (60.0, "1/min", "1/s", 1.0),
            (1.0, "Hz", "rad/s", std::f64::consts::TAU),
            (180.0, "deg", "rad", std::f64::consts::PI),
            (400.0, "gon", "turn", 1.0),
            (50.0, "%", "1", 0.5),
            (1.0, "%", "ppm", 10_000.0),
        ];
        for (value, from, to, expected) in cases {
            let found = converted(value, from, to);
            let error = (found - expected).abs();
            // A conversion is five roundings; at zero they are of the absolute temperature.
            assert!(
                error <= 1e-12 * expected.abs().max(0.1),
                "{from} to {to}: {found}"
            );
            let back = converted(expected, to, from);
            assert!(
                (back - value).abs() <= 1e-12 * value.abs().max(500.0),
                "{to} to {from}: {back}"
            );
        }
        assert_eq!(
            converted(7200.0, "kg/h", "kg/s").to_bits(),
            2.0_f64.to_bits()
        );
        assert_eq!(
            converted(1500.0, "mbar", "bar").to_bits(),
            1.5_f64.to_bits()
        );
    }

    #[test]
    fn gauge_pressures_are_known_as_such_and_others_are_not_units() {
        for name in ["barg", "bar(g)", "psig", "kPag", "mbar(g)", "bar g"] {
            let unit = Unit::of(name);
            assert_eq!(
                unit.map(|u| u.dimension),
                Some(Dimension::GaugePressure),
                "{name}"
            );
        }
        for name in [
            "", "kgs", "kg", "m/", "Nm3/h", "mmm", "xbar", "kkPa", "kg/", "/s", "dd", "G", "g",
        ] {
            assert_eq!(Unit::of(name), None, "{name}");
        }
    }
}
