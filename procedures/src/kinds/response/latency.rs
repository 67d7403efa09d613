//! Kind `latency`: how long a torque command takes to the current, and the current to the bench; lag and hold apart.

#![allow(clippy::result_large_err, reason = "a plan is refused once, before anything runs")]

use crate::axis::Axes;
use crate::case::Case;
use crate::device::DeviceRole;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;

mod conclude;
mod fit;
mod onset;
mod plan;
#[cfg(test)]
mod tests;

use plan::{Keys, Stage};

const ROUND_TRIP: &str = "transport-round-trip";
const OUT: &str = "transport-out";
const BACK: &str = "transport-back";
const BY_ONSET: &str = "transport-by-onset";
const JITTER: &str = "transport-jitter";
const LAG: &str = "current-lag";
const HOLD: &str = "command-hold";
const ECHO: &str = "echo-delay";
const LEVELS: &str = "transport-level-difference";
const SLOW: &str = "transport-slow";
const RATES: &str = "transport-rate-difference";

const MEASURANDS: &[Measurand] = &[
    Measurand::new(
        ROUND_TRIP,
        Q::Time,
        "Round trip from command to feedback by fit, without the lag of the current loop and without the hold.",
    ),
    Measurand::new(
        OUT,
        Q::Time,
        "Delay from the command to the first rise of the current at the motor, by current probe.",
    ),
    Measurand::new(
        BACK,
        Q::Time,
        "Delay from the current at the motor to its value in the bench: round trip less outward delay.",
    ),
    Measurand::new(
        BY_ONSET,
        Q::Time,
        "Delay from the command to the first rise of the current that the drive reports, by onset of steps.",
    ),
    Measurand::new(
        JITTER,
        Q::Time,
        "Standard deviation of the onset of the reported current from step to step.",
    ),
    Measurand::new(LAG, Q::Time, "Delay of the current loop at low frequency, 1/(2 pi corner)."),
    Measurand::new(HOLD, Q::Time, "Delay of the zero-order hold of the command, half a period."),
    Measurand::new(
        ECHO,
        Q::Time,
        "Delay from analog output to analog input of the bench in whole exchanges, without hold.",
    ),
    Measurand::new(LEVELS, Q::Time, "Largest difference of the round trip between two levels."),
    Measurand::new(SLOW, Q::Time, "Round trip with a command only every `command-ticks` ticks."),
    Measurand::new(
        RATES,
        Q::Time,
        "Round trip with a command every `command-ticks` ticks, less that with a command in every tick.",
    ),
];

/// A value with its standard uncertainty, in one unit.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Value {
    value: f64,
    u: f64,
}

pub(in crate::kinds) const KIND: Kind =
    Kind::new::<Keys>("latency", include_str!("latency/doc.md"), plan::FIELDS, MEASURANDS);

impl Experiment for Keys {
    fn yields(&self) -> Option<Vec<&'static str>> {
        let mut all = Vec::new();
        for stage in &self.stages {
            match stage {
                Stage::Fit if self.levels_v.len() > 1 => all.extend([ROUND_TRIP, LAG, HOLD, LEVELS]),
                Stage::Fit => all.extend([ROUND_TRIP, LAG, HOLD]),
                Stage::Slow => all.extend([SLOW, RATES]),
                Stage::Onset => all.extend([BY_ONSET, JITTER]),
                Stage::Probe => all.extend([OUT, BACK]),
                Stage::Echo => all.push(ECHO),
            }
        }
        Some(all)
    }

    fn needs(&self) -> Vec<DeviceRole> {
        let echoes = self.stages.contains(&Stage::Echo);
        if echoes { vec![DeviceRole::Mirror] } else { Vec::new() }
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        let Some(stage) = Stage::of(case) else { return PointResult::default() };
        let limits = match axes.limits(&case.axis) {
            Ok(limits) => limits,
            Err(missing) => return conclude::without(case, stage, &missing.into()),
        };
        let found = match stage {
            Stage::Fit => fit::fit(case, window, limits),
            Stage::Slow => fit::slow(case, window, limits),
            Stage::Onset => onset::analyse_steps(case, window, limits),
            Stage::Probe => fit::probe(case, window, limits),
            Stage::Echo => onset::analyse_echo(case, window, limits),
        };
        found.unwrap_or_else(|reason| conclude::without(case, stage, &reason))
    }

    fn conclude(&self, cases: &[Case], points: &[PointResult], _axes: &Axes) -> Conclusion {
        conclude::conclude(self, cases, points)
    }
}
