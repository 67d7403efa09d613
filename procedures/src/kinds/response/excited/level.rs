//! How large the signal is: peak to peak, in the unit that the procedure file gives.

use std::fmt;

use crate::case::{Case, Request};
use crate::excitation::Injection;
use crate::quantity::QuantityKind as Q;
use crate::table::TableReader;

/// Condition of a point.
pub(in crate::kinds) const LEVEL: &str = "level";

/// Peak to peak of a signal. Volts are those of the analog reference input of the study's drives: 1 V is 1 deg/s of the
/// velocity command, or 1 A of motor current.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::kinds) struct Level {
    pub(in crate::kinds) kind: Q,
    /// SI.
    pub(in crate::kinds) value: f64,
}

impl Level {
    /// What a planned point asks for.
    pub(in crate::kinds) fn requested(case: &Case) -> Option<Self> {
        let request = case.requested.iter().find(|request| request.name == LEVEL)?;
        Some(Self { kind: request.kind, value: request.value })
    }

    pub(super) fn request(&self) -> Request {
        Request { name: LEVEL.to_owned(), value: self.value, kind: self.kind }
    }

    /// Volts of the reference input.
    pub(super) fn volts_v(&self) -> f64 {
        if self.kind == Q::AngularVelocity { self.value.to_degrees() } else { self.value }
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.kind.format(self.value))
    }
}

/// A level is positive, and of the unit of its place.
pub(super) fn check(table: &mut TableReader<'_>, levels: &[Level], into: Injection) {
    let (into, own, unit) = match into {
        Injection::Torque => ("torque", Q::Current, "a motor current in A, or volts"),
        _ => ("velocity", Q::AngularVelocity, "a rate such as `4 deg/s`, or volts"),
    };
    for level in levels {
        if level.kind != own && level.kind != Q::Voltage {
            let message = format!("level {level} cannot be added where the signal goes, `into = \"{into}\"`");
            table.mistake("level", message, Some(format!("write {unit}")));
        } else if level.value <= 0.0 {
            table.mistake("level", format!("level {level} must be above zero"), None);
        }
    }
}
