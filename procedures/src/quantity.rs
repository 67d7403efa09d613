//! Physical quantities with kinds: text in, SI numbers out, and back.

use serde::{Deserialize, Serialize};

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
    Temperature,
    Voltage,
    Power,
    Length,
    /// Plain ratio; `%` and `ppm` too.
    Ratio,
    /// Ratio in dB (stored in dB).
    Decibel,
    /// A pure count.
    Count,
    AngleRandomWalk,
}

impl QuantityKind {
    /// Unit symbol of the SI value, e.g. `rad/s`.
    pub fn si_unit(self) -> &'static str {
        todo!()
    }

    /// Unit symbol people read it in, e.g. `deg/s`.
    pub fn display_unit(self) -> &'static str {
        todo!()
    }

    /// The SI value in the display unit.
    pub fn to_display(self, si: f64) -> f64 {
        let _ = si;
        todo!()
    }

    /// The SI value as text with its display unit and a few significant digits, e.g. `10 deg/s`.
    pub fn format(self, si: f64) -> String {
        let _ = si;
        todo!()
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
    /// Whether a value meets the limit, without uncertainty.
    pub fn holds(&self, value: f64) -> bool {
        let _ = value;
        todo!()
    }
}
