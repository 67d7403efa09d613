//! Kind `profile`: references that move; how well the axis follows a ramp, a sine, a path.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::position::positioned::{self, Named};
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::PointResult;
use crate::quantity::QuantityKind as Q;

mod keys;
mod plan;
mod point;
#[cfg(test)]
mod tests;

use keys::Keys;

const DOC: &str = "\
Moving references under position control with velocity feed-forward.

# What it finds
Error of following a ramp, a sine, a path through given positions: root mean square, 99.9 % percentile and peak of its
magnitude, as it is and with a pure delay removed, and that delay.

# How it excites
A ramp between two positions, out and back, speeding up and braking within limits; whole periods of a sine, faded in and
out; a path with continuous acceleration through given positions at given times. Every reference begins where the axis
rests: a path that jumps is refused.

# How it computes
Error = position command less encoder angle of the same row: nothing is aligned. The loop is closed on the same sample, so
the age of that sample does not show: the axis itself is ahead of it by rate times age, 18 urad at 0.674 deg/s and 1.5 ms.
Ramp: rows of constant rate, from 1 s after its beginning. Sine: rows of full amplitude, from 1 s on. Path: all rows.
Aligned: the delay that explains most of the error (one parameter, least squares) is removed; on a ramp that is any
constant error. Uncertainty: bootstrap over circular blocks of 1 s.

# Fails when
Fewer than five blocks remain: inconclusive with the reason.

# Source
Study 4.5, 4.2; POS-TRK. Politis and Romano 1992 (circular block bootstrap).
";

const RAMP_ERROR: &str = "ramp-error";
const PATH_ERROR: &str = "path-error";

/// What a ramp yields, and in the same order what a sine or a path does.
const OF_RAMP: [Named; 5] = [
    (RAMP_ERROR, Q::Angle),
    ("ramp-error-rms", Q::Angle),
    ("ramp-error-peak", Q::Angle),
    ("ramp-error-aligned", Q::Angle),
    ("ramp-delay", Q::Time),
];
const OF_PATH: [Named; 5] = [
    (PATH_ERROR, Q::Angle),
    ("path-error-rms", Q::Angle),
    ("path-error-peak", Q::Angle),
    ("path-error-aligned", Q::Angle),
    ("path-delay", Q::Time),
];

const fn measurand(of: Named, doc: &'static str) -> Measurand {
    Measurand { name: of.0, kind: of.1, doc }
}

const MEASURANDS: &[Measurand] = &[
    measurand(
        OF_RAMP[0],
        "Following error on a ramp at constant rate, 99.9 % percentile of its magnitude, not aligned.",
    ),
    measurand(OF_RAMP[1], "Following error on a ramp at constant rate, root mean square, not aligned."),
    measurand(OF_RAMP[2], "Following error on a ramp at constant rate, largest magnitude, not aligned."),
    measurand(
        OF_RAMP[3],
        "Following error on a ramp, 99.9 % percentile, with a pure delay (here any constant error) removed.",
    ),
    measurand(OF_RAMP[4], "Pure delay that was removed from the following error."),
    measurand(
        OF_PATH[0],
        "Following error on a sine or path, 99.9 % percentile of its magnitude, not aligned.",
    ),
    measurand(OF_PATH[1], "Following error on a sine or path, root mean square, not aligned."),
    measurand(OF_PATH[2], "Following error on a sine or path, largest magnitude, not aligned."),
    measurand(OF_PATH[3], "Following error on a sine or path, 99.9 % percentile, with a pure delay removed."),
    measurand(OF_PATH[4], "Pure delay that was removed from the following error."),
];

pub(in crate::kinds) const KIND: Kind = Kind::new::<Keys>("profile", DOC, keys::FIELDS, MEASURANDS);

/// What a point yields.
fn named(case: &Case) -> &'static [Named; 5] {
    if plan::is_ramp(case) { &OF_RAMP } else { &OF_PATH }
}

impl Experiment for Keys {
    fn yields(&self) -> Option<Vec<&'static str>> {
        let of_path = self.sine.is_some() || self.path.is_some();
        let ramp = OF_RAMP.iter().filter(|_| self.ramp.is_some());
        Some(ramp.chain(OF_PATH.iter().filter(|_| of_path)).map(|(name, _)| *name).collect())
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        point::analyse(case, window, axes)
            .unwrap_or_else(|reason| positioned::without(case, named(case), point::ESTIMATOR, &reason))
    }
}
