//! Kind `fsm-impedance`: modes, capacitance and coupling of the steering mirror from its terminals.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::mirror;
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;

mod keys;
mod measure;
#[cfg(test)]
mod tests;

use keys::Keys;

const DOC: &str = "\
# What it finds
For each axis of the mirror its mechanical mode (`mirror-mode`) and how far it is from the expected one
(`mirror-mode-departure`), damping (`mirror-mode-damping`) and electromechanical coupling k² (`mirror-coupling`) of the
bare mechanism, and the capacitance of its stacks (`mirror-capacitance`).

# How it excites
The gimbal holds its pose, the mirror's amplifier is disconnected. The impedance analyser steps a small sine (1 V peak to
peak) through log-spaced frequencies (20 Hz to 2 kHz).

# How it computes
Butterworth-Van Dyke circuit with a dielectric of constant loss angle, by complex nonlinear least squares over all points.
The mode is the series resonance f_s, at which the mechanism rings with its terminals short-circuited. The coupling is the
effective one of IEEE Std 176, k² = (f_p² - f_s²)/f_p² = C_1/(C_0 + C_1) with f_p the parallel resonance: C_0 is the
clamped capacitance at f_s, some 3 % less than at 20 Hz by the loss of the dielectric, so k² is larger by the same share
than the ratio of motional to total capacitance at 20 Hz. The uncertainty comes from the inverse Fisher information and
the residuals of the fit. The level is that of the source, 2√2·I·|Z + 25 Ω| from the current of each point, where it
departs most from the requested level; at the terminals, behind those 25 Ω, it falls with |Z| (the flags say to what). The
closed strain gauge loop (damping ratio 0.36, |G| peaks at 277 and 301 Hz) does not show here: it is a different system
from the bare mechanism (0.02).

# Fails when
No analyser in the log; too few points, or over other frequencies than `range`; no capacitance; no resonance stands out of the noise: inconclusive with reason.

# Source
director.md §2 (FSM-MODE), §4.4, E6 (which axis has which mode), E25; IEEE Std 176-1987.
";

const MEASURANDS: &[Measurand] = &[
    Measurand::new(
        measure::DEPARTURE,
        Q::Ratio,
        "Frequency of the mode over the expected frequency, less 1.",
    ),
    Measurand::new(
        measure::MODE,
        Q::Frequency,
        "Frequency of the mode: series resonance of the bare mechanism.",
    ),
    Measurand::new(measure::DAMPING, Q::Ratio, "Damping ratio of the bare mechanism."),
    Measurand::new(
        measure::COUPLING,
        Q::Ratio,
        "Effective coupling k² = 1 − (series/parallel resonance)² (IEEE Std 176), dielectric as at the series resonance.",
    ),
    Measurand::new(
        measure::CAPACITANCE,
        Q::Capacitance,
        "Capacitance of the stacks at the lowest frequency, motion included.",
    ),
];

pub(in crate::kinds) const KIND: Kind = Kind::new::<Keys>("fsm-impedance", DOC, keys::FIELDS, MEASURANDS);

impl Experiment for Keys {
    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        keys::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, _axes: &Axes) -> PointResult {
        measure::analyse(self, case, window)
    }

    fn conclude(&self, _cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
        mirror::on_gimbal(Conclusion::collected(points), axes)
    }
}
