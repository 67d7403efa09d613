//! The units that people may write, and what one of each is worth.

use std::f64::consts::{PI, TAU};

use super::QuantityKind;

/// A unit of one kind.
#[derive(Debug)]
pub(super) struct Unit {
    /// As [`normalise`] leaves it.
    pub(super) symbol: &'static str,
    pub(super) kind: QuantityKind,
    /// SI value of one.
    pub(super) factor: f64,
}

const DEG: f64 = PI / 180.0;

const fn unit(symbol: &'static str, kind: QuantityKind, factor: f64) -> Unit {
    Unit { symbol, kind, factor }
}

use QuantityKind as K;

const UNITS: &[Unit] = &[
    unit("rad", K::Angle, 1.0),
    unit("mrad", K::Angle, 1e-3),
    unit("urad", K::Angle, 1e-6),
    unit("deg", K::Angle, DEG),
    unit("arcsec", K::Angle, DEG / 3600.0),
    unit("rad/s", K::AngularVelocity, 1.0),
    unit("mrad/s", K::AngularVelocity, 1e-3),
    unit("urad/s", K::AngularVelocity, 1e-6),
    unit("deg/s", K::AngularVelocity, DEG),
    unit("deg/h", K::AngularVelocity, DEG / 3600.0),
    unit("rpm", K::AngularVelocity, TAU / 60.0),
    unit("rad/s^2", K::AngularAcceleration, 1.0),
    unit("deg/s^2", K::AngularAcceleration, DEG),
    unit("rad/s^3", K::AngularJerk, 1.0),
    unit("deg/s^3", K::AngularJerk, DEG),
    unit("N*m", K::Torque, 1.0),
    unit("mN*m", K::Torque, 1e-3),
    unit("kN*m", K::Torque, 1e3),
    unit("N*m/s", K::TorqueRate, 1.0),
    unit("A", K::Current, 1.0),
    unit("mA", K::Current, 1e-3),
    unit("A/s", K::CurrentRate, 1.0),
    unit("mA/s", K::CurrentRate, 1e-3),
    unit("N*m/A", K::TorqueConstant, 1.0),
    unit("N*m/rad", K::Stiffness, 1.0),
    unit("N*m*s/rad", K::Damping, 1.0),
    unit("kg*m^2", K::Inertia, 1.0),
    unit("s", K::Time, 1.0),
    unit("ms", K::Time, 1e-3),
    unit("us", K::Time, 1e-6),
    unit("min", K::Time, 60.0),
    unit("h", K::Time, 3600.0),
    unit("Hz", K::Frequency, 1.0),
    unit("kHz", K::Frequency, 1e3),
    unit("1/rev", K::SpatialOrder, 1.0),
    unit("/rev", K::SpatialOrder, 1.0),
    unit("1/s", K::Gain, 1.0),
    unit("/s", K::Gain, 1.0),
    unit("degC", K::Temperature, 1.0),
    unit("V", K::Voltage, 1.0),
    unit("mV", K::Voltage, 1e-3),
    unit("W", K::Power, 1.0),
    unit("kW", K::Power, 1e3),
    unit("J", K::Energy, 1.0),
    unit("kJ", K::Energy, 1e3),
    unit("m", K::Length, 1.0),
    unit("mm", K::Length, 1e-3),
    unit("um", K::Length, 1e-6),
    unit("", K::Ratio, 1.0),
    unit("%", K::Ratio, 1e-2),
    unit("ppm", K::Ratio, 1e-6),
    unit("dB", K::Decibel, 1.0),
    unit("", K::Count, 1.0),
    unit("rad/sqrt(s)", K::AngleRandomWalk, 1.0),
    unit("deg/sqrt(h)", K::AngleRandomWalk, DEG / 60.0),
    unit("N", K::Force, 1.0),
    unit("kN", K::Force, 1e3),
    unit("kg", K::Mass, 1.0),
    unit("m/s", K::Speed, 1.0),
    unit("m/s^2", K::Acceleration, 1.0),
    unit("g", K::Acceleration, 9.806_65),
    unit("mg", K::Acceleration, 9.806_65e-3),
    unit("ug", K::Acceleration, 9.806_65e-6),
    unit("F", K::Capacitance, 1.0),
    unit("mF", K::Capacitance, 1e-3),
    unit("uF", K::Capacitance, 1e-6),
    unit("nF", K::Capacitance, 1e-9),
    unit("ohm", K::Resistance, 1.0),
    unit("kohm", K::Resistance, 1e3),
    unit("H", K::Inductance, 1.0),
    unit("mH", K::Inductance, 1e-3),
    unit("1/(kg*m^2)", K::InverseInertia, 1.0),
    unit("rad/V", K::AngleScale, 1.0),
    unit("urad/V", K::AngleScale, 1e-6),
    unit("1/s^2", K::GainPerSecond, 1.0),
    unit("m/s/sqrt(s)", K::VelocityRandomWalk, 1.0),
    unit("m/s/sqrt(h)", K::VelocityRandomWalk, 1.0 / 60.0),
    unit("rad/s/sqrt(s)", K::RateRandomWalk, 1.0),
    unit("deg/h/sqrt(h)", K::RateRandomWalk, DEG / 3600.0 / 60.0),
    unit("m^(-2/3)", K::TurbulenceStrength, 1.0),
];

/// All units of a kind.
pub(super) fn of_kind(kind: QuantityKind) -> impl Iterator<Item = &'static Unit> {
    UNITS.iter().filter(move |u| u.kind == kind)
}

/// The unit of this normalised symbol; the kind matters only where a symbol has several (no unit at all).
pub(super) fn find(symbol: &str, wanted: QuantityKind) -> Option<&'static Unit> {
    let same = || UNITS.iter().filter(|u| u.symbol == symbol);
    same().find(|u| u.kind == wanted).or_else(|| same().next())
}

/// One spelling for each unit: both code points of micro, degree signs, superscripts, products and blanks.
pub(super) fn normalise(unit: &str) -> String {
    let mut text = String::with_capacity(unit.len());
    for word in unit.split_whitespace() {
        // A blank between two symbols is a product (`N m`); never a longer symbol (`m s` is not `ms`).
        let joins = |c: char| matches!(c, '/' | '*' | '·' | '⋅');
        if !text.is_empty() && !text.ends_with(joins) && !word.starts_with(joins) {
            text.push('*');
        }
        text.push_str(word);
    }
    const SPELLINGS: [(&str, &str); 13] = [
        ("\u{b5}", "u"),
        ("\u{3bc}", "u"),
        ("·", "*"),
        ("⋅", "*"),
        ("²", "^2"),
        ("³", "^3"),
        ("°", "deg"),
        ("√h", "sqrt(h)"),
        ("√s", "sqrt(s)"),
        ("/s2", "/s^2"),
        ("/s3", "/s^3"),
        ("Nm", "N*m"),
        ("kg*m2", "kg*m^2"),
    ];
    SPELLINGS.iter().fold(text, |text, (from, to)| text.replace(from, to))
}
