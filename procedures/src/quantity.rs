//! Physical quantities with kinds: text in, SI numbers out, and back.
//!
//! People write `"10 deg/s"`, `"-10 deg .. 90 deg"`, `"<= 45 N*m"`; the program keeps SI numbers and the kind. A unit
//! of another kind is a mistake even where the dimensions agree: deg/s, rad/s and Hz are not the same thing.

use serde::{Deserialize, Serialize};

mod parse;
mod pattern;
mod unit;

#[cfg(test)]
mod tests;

pub use parse::QuantityError;

/// What a number means. Kinds are checked, not only dimensions: deg/s and Hz differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum QuantityKind {
    Angle,
    AngularVelocity,
    AngularAcceleration,
    AngularJerk,
    Torque,
    TorqueRate,
    Current,
    CurrentRate,
    TorqueConstant,
    Stiffness,
    Damping,
    Inertia,
    Time,
    Frequency,
    /// Cycles per revolution, e.g. cogging.
    SpatialOrder,
    Gain,
    /// Stored in degrees Celsius, as every sensor of the bench gives it.
    Temperature,
    Voltage,
    Power,
    Energy,
    Length,
    /// Plain ratio; `%` and `ppm` too.
    Ratio,
    /// Ratio in dB (stored in dB).
    Decibel,
    /// A pure count.
    Count,
    AngleRandomWalk,
    Force,
    Mass,
    Speed,
    Acceleration,
    Capacitance,
    Resistance,
    Inductance,
    InverseInertia,
    /// Command scale of the mirror.
    AngleScale,
    /// Of a double integral, e.g. the mirror's I².
    GainPerSecond,
    VelocityRandomWalk,
    /// Of a gyro's bias.
    RateRandomWalk,
    /// Refractive index structure constant Cn².
    TurbulenceStrength,
}

/// What is known of a kind beside its units.
struct Traits {
    /// With its article, for sentences.
    noun: &'static str,
    si: &'static str,
    display: &'static str,
    example: &'static str,
}

const fn traits(
    noun: &'static str,
    si: &'static str,
    display: &'static str,
    example: &'static str,
) -> Traits {
    Traits { noun, si, display, example }
}

impl QuantityKind {
    /// Whether its unit is that of torque with angles and times: what is told from a torque goes with its scale.
    pub fn is_of_torque(self) -> bool {
        matches!(self, Self::Torque | Self::TorqueRate | Self::Stiffness | Self::Damping | Self::Inertia)
    }

    /// Every kind, in order of declaration.
    pub const ALL: [Self; 38] = [
        Self::Angle,
        Self::AngularVelocity,
        Self::AngularAcceleration,
        Self::AngularJerk,
        Self::Torque,
        Self::TorqueRate,
        Self::Current,
        Self::CurrentRate,
        Self::TorqueConstant,
        Self::Stiffness,
        Self::Damping,
        Self::Inertia,
        Self::Time,
        Self::Frequency,
        Self::SpatialOrder,
        Self::Gain,
        Self::Temperature,
        Self::Voltage,
        Self::Power,
        Self::Energy,
        Self::Length,
        Self::Ratio,
        Self::Decibel,
        Self::Count,
        Self::AngleRandomWalk,
        Self::Force,
        Self::Mass,
        Self::Speed,
        Self::Acceleration,
        Self::Capacitance,
        Self::Resistance,
        Self::Inductance,
        Self::InverseInertia,
        Self::AngleScale,
        Self::GainPerSecond,
        Self::VelocityRandomWalk,
        Self::RateRandomWalk,
        Self::TurbulenceStrength,
    ];

    const fn traits(self) -> Traits {
        match self {
            Self::Angle => traits("an angle", "rad", "deg", "10 deg"),
            Self::AngularVelocity => traits("an angular velocity", "rad/s", "deg/s", "10 deg/s"),
            Self::AngularAcceleration => {
                traits("an angular acceleration", "rad/s^2", "deg/s^2", "90 deg/s^2")
            }
            Self::AngularJerk => traits("an angular jerk", "rad/s^3", "deg/s^3", "900 deg/s^3"),
            Self::Torque => traits("a torque", "N*m", "N*m", "45 N*m"),
            Self::TorqueRate => traits("a torque rate", "N*m/s", "N*m/s", "60 N*m/s"),
            Self::Current => traits("a current", "A", "A", "1 A"),
            Self::CurrentRate => traits("a current rate", "A/s", "A/s", "0.1 A/s"),
            Self::TorqueConstant => traits("a torque constant", "N*m/A", "N*m/A", "60 N*m/A"),
            Self::Stiffness => traits("a stiffness", "N*m/rad", "N*m/rad", "54 N*m/rad"),
            Self::Damping => traits("a damping", "N*m*s/rad", "N*m*s/rad", "68 N*m*s/rad"),
            Self::Inertia => traits("an inertia", "kg*m^2", "kg*m^2", "1200 kg*m^2"),
            Self::Time => traits("a time", "s", "s", "5 s"),
            Self::Frequency => traits("a frequency", "Hz", "Hz", "10 Hz"),
            Self::SpatialOrder => traits("a spatial order", "1/rev", "1/rev", "144 1/rev"),
            Self::Gain => traits("a gain", "1/s", "1/s", "4.5 1/s"),
            Self::Temperature => traits("a temperature", "degC", "degC", "60 degC"),
            Self::Voltage => traits("a voltage", "V", "V", "560 V"),
            Self::Power => traits("a power", "W", "W", "600 W"),
            Self::Energy => traits("an energy", "J", "J", "800 J"),
            Self::Length => traits("a length", "m", "m", "0.5 m"),
            Self::Ratio => traits("a ratio", "1", "%", "5 %"),
            Self::Decibel => traits("a ratio in decibels", "dB", "dB", "6 dB"),
            Self::Count => traits("a count", "1", "", "3"),
            Self::AngleRandomWalk => {
                traits("an angle random walk", "rad/sqrt(s)", "deg/sqrt(h)", "0.015 deg/sqrt(h)")
            }
            Self::Force => traits("a force", "N", "N", "650 N"),
            Self::Mass => traits("a mass", "kg", "kg", "0.5 kg"),
            Self::Speed => traits("a speed", "m/s", "m/s", "1 m/s"),
            Self::Acceleration => traits("an acceleration", "m/s^2", "m/s^2", "9.81 m/s^2"),
            Self::Capacitance => traits("a capacitance", "F", "uF", "30.2 uF"),
            Self::Resistance => traits("a resistance", "ohm", "ohm", "10 ohm"),
            Self::Inductance => traits("an inductance", "H", "mH", "5 mH"),
            Self::InverseInertia => {
                traits("an inverse inertia", "1/(kg*m^2)", "1/(kg*m^2)", "1e-4 1/(kg*m^2)")
            }
            Self::AngleScale => traits("an angle per voltage", "rad/V", "urad/V", "500 urad/V"),
            Self::GainPerSecond => traits("a gain per second", "1/s^2", "1/s^2", "100000 1/s^2"),
            Self::VelocityRandomWalk => {
                traits("a velocity random walk", "m/s/sqrt(s)", "m/s/sqrt(h)", "0.07 m/s/sqrt(h)")
            }
            Self::RateRandomWalk => {
                traits("a rate random walk", "rad/s/sqrt(s)", "deg/h/sqrt(h)", "0.02 deg/h/sqrt(h)")
            }
            Self::TurbulenceStrength => {
                traits("a turbulence strength", "m^(-2/3)", "m^(-2/3)", "1e-14 m^(-2/3)")
            }
        }
    }

    /// Unit symbol of the SI value, e.g. `rad/s`; `1` for ratios and counts.
    pub const fn si_unit(self) -> &'static str {
        self.traits().si
    }

    /// Unit symbol people read it in, e.g. `deg/s`; empty for counts.
    pub const fn display_unit(self) -> &'static str {
        self.traits().display
    }

    /// The kind in words, with its article, e.g. `an angular velocity`.
    pub const fn noun(self) -> &'static str {
        self.traits().noun
    }

    /// How a person would write one, e.g. `10 deg/s`.
    pub const fn example(self) -> &'static str {
        self.traits().example
    }

    /// Symbols of all units that may be written.
    pub fn symbols(self) -> impl Iterator<Item = &'static str> {
        unit::of_kind(self).map(|unit| unit.symbol)
    }

    /// How a person would write a range, e.g. `0 .. 10 deg/s`.
    pub fn range_example(self) -> String {
        format!("0 .. {}", self.example())
    }

    /// The SI value in the display unit.
    pub fn to_display(self, si: f64) -> f64 {
        let scale = unit::of_kind(self).find(|u| u.symbol == self.display_unit());
        si / scale.map_or(1.0, |u| u.factor)
    }

    /// The SI value as text with its display unit and up to six significant digits, e.g. `10 deg/s`.
    pub fn format(self, si: f64) -> String {
        let number = significant(self.to_display(si));
        match self.display_unit() {
            "" => number,
            unit => format!("{number} {unit}"),
        }
    }

    /// The SI value of a text such as `10 deg/s`.
    ///
    /// # Errors
    /// Says what was expected and found: not a number, no unit, unknown unit, unit of another kind, too large.
    pub fn parse(self, text: &str) -> Result<f64, QuantityError> {
        parse::quantity(self, text)
    }

    /// The SI values `[low, high]` of a text such as `-10 deg .. 90 deg` or `-10 .. 90 deg`.
    ///
    /// # Errors
    /// As [`Self::parse`], and where `..` is missing or low is not below high.
    pub fn parse_range(self, text: &str) -> Result<[f64; 2], QuantityError> {
        parse::range(self, text)
    }

    /// The limit in a text such as `<= 45 N*m` or `34 Hz .. 43 Hz`.
    ///
    /// # Errors
    /// As [`Self::parse_range`], and where no comparator is found.
    pub fn parse_limit(self, text: &str) -> Result<Limit, QuantityError> {
        parse::limit(self, text)
    }
}

/// Six significant digits without trailing zeros; an exponent only where the number would be hard to read.
fn significant(x: f64) -> String {
    let text = format!("{x:.5e}");
    let Some((mantissa, exponent)) = text.split_once('e') else { return text };
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let trim = |s: &str| {
        let short = if s.contains('.') { s.trim_end_matches('0').trim_end_matches('.') } else { s };
        if short == "-0" { "0".to_owned() } else { short.to_owned() }
    };
    if (-5..=8).contains(&exponent) {
        let decimals = usize::try_from(5 - exponent).unwrap_or(0);
        trim(&format!("{x:.decimals$}"))
    } else {
        format!("{}e{exponent}", trim(mantissa))
    }
}

/// Comparator of a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum Comparator {
    Less,
    AtMost,
    Greater,
    AtLeast,
    /// Inside [low, high].
    Within,
}

/// A limit: comparator and bounds in SI units. `low` is set for Greater, AtLeast, Within; `high` for the rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limit {
    /// How to compare.
    pub comparator: Comparator,
    /// Lower bound.
    pub low: Option<f64>,
    /// Upper bound.
    pub high: Option<f64>,
    /// Kind of quantity of the bounds.
    pub kind: QuantityKind,
    /// As a person wrote it.
    pub text: String,
}

impl Limit {
    /// Whether a value meets the limit, without uncertainty; NaN never does.
    pub fn holds(&self, value: f64) -> bool {
        self.holds_with(value, self.low, self.high)
    }

    /// The same limit, met by what is nearer to it than `allowance`.
    pub(crate) fn met_within(self, allowance: f64) -> Self {
        let low = self.low.map(|low| low - allowance);
        let high = self.high.map(|high| high + allowance);
        Self { low, high, ..self }
    }

    /// Compares a value with other bounds, e.g. those of a guard band.
    pub(crate) fn holds_with(&self, value: f64, low: Option<f64>, high: Option<f64>) -> bool {
        let strict = matches!(self.comparator, Comparator::Less | Comparator::Greater);
        let above = low.is_none_or(|low| if strict { value > low } else { value >= low });
        let below = high.is_none_or(|high| if strict { value < high } else { value <= high });
        above && below && !value.is_nan()
    }
}
