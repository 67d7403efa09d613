//! Kind `breakaway`: torque ramps, small periodic torque and release show how the contact holds and lets go.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand, experiment};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;

mod conclude;
mod hold;
mod keys;
mod plan;
mod plots;
mod point;
mod ramps;
#[cfg(test)]
mod tests;

use keys::Keys;

const DOC: &str = "\
# What it finds
The torque at which an axis at rest breaks away (`breakaway-torque`, per ramp and per rate and dwell), how it grows
with the time at rest (`dwell-slope`), the stiffness and damping of the contact before it slides (`bristle-stiffness`,
`presliding-damping`), and by how much static friction exceeds unbalance and spring where the axis must hold itself
without torque (`hold-margin`).

# How it excites
A slow stroke back and forth around the pose first. Each ramp: approach from below by more than 8 z_ss, settle, dwell
at constant torque, then motor torque at a constant rate, dithered by half a quantum, until the axis has moved by
`displacement`. The multisine stays at or below 0.1 of static friction. Hold points let go for a while, then ramp both
ways.

# How it computes
F̂ = Kt·i − J·α. Half the sum of both directions of the stroke is cogging, unbalance and spring near the pose; it is
taken off every ramp and the multisine. Bristle stiffness σ0 and plateau T_∞ come from an exponential fit with free
initial bristle state and rate term, z_ss = T_∞/σ0 (mean over the ramps). Breakaway is the maximum over 3…8 z_ss of F̂
smoothed by one polynomial of degree 6 over 2.5…9 z_ss. The dwell counts from the last motion to 3 z_ss. The dwell law
T = T0 + slope·ln(1 + t/τ_d) is that of this maximum, which lies where the contact has mostly renewed itself: its slope
is smaller than the growth of static friction itself. Multisine: T + Jω²X = (σ0 + jω(σ1 + σ2))·Z on the excited
lines, Z the bristle along the measured path. Hold: the smaller of the two breakaway torques with the load left in;
where the axis slides off on its own, minus the torque that accelerates it.

# Fails when
No breakaway within the time; less than 8 z_ss of displacement; torque at its limit; fit not converged; map missing;
the axis slides during the dwell.

# Source
estimators.md §1.5; Canudas de Wit et al. 1995 (LuGre); director.md §3, §8, E23, E24.
";

const MEASURANDS: &[Measurand] = &[
    Measurand {
        name: "breakaway-torque",
        kind: Q::Torque,
        doc: "Largest friction torque over 3…8 z_ss of a torque ramp from rest.",
    },
    Measurand {
        name: "bristle-stiffness",
        kind: Q::Stiffness,
        doc: "Initial slope σ0 of friction torque over displacement from rest.",
    },
    Measurand {
        name: "presliding-damping",
        kind: Q::Damping,
        doc: "Sum of bristle damping σ1 and viscous coefficient σ2 in presliding.",
    },
    Measurand {
        name: "dwell-slope",
        kind: Q::Torque,
        doc: "Growth of the breakaway torque per unit of ln(1 + t/τ_d) of the time at rest.",
    },
    Measurand {
        name: "hold-margin",
        kind: Q::Torque,
        doc: "Torque by which static friction exceeds unbalance and spring at a pose; negative where the axis slides.",
    },
];

pub(in crate::kinds) const KIND: Kind = Kind {
    name: "breakaway",
    doc: DOC,
    fields: keys::FIELDS,
    measurands: MEASURANDS,
    read: |table| experiment(Keys::read(table)),
};

impl Experiment for Keys {
    fn yields(&self) -> Vec<&'static str> {
        let mut names = Vec::new();
        if !self.ramps.is_empty() {
            names.push("breakaway-torque");
        }
        if !self.ramps.is_empty() || self.multisine.is_some() {
            names.push("bristle-stiffness");
        }
        if self.multisine.is_some() {
            names.push("presliding-damping");
        }
        if conclude::asks_for_dwell_law(self) {
            names.push("dwell-slope");
        }
        if self.hold.is_some() {
            names.push("hold-margin");
        }
        names
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        point::analyse(case, window, axes, self.displacement_rad)
    }

    fn conclude(&self, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
        conclude::conclude(self, cases, points, axes)
    }
}

/// Direction of a ramp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Direction {
    Positive,
    Negative,
}

impl Direction {
    /// Both, in the order in which they are run.
    const BOTH: [Self; 2] = [Self::Positive, Self::Negative];

    /// Direction of a number by its sign.
    fn from_ratio(ratio: f64) -> Self {
        if ratio < 0.0 { Self::Negative } else { Self::Positive }
    }

    /// Direction that a ramp point asks for; `None` for all other points.
    fn requested(case: &Case) -> Option<Self> {
        case.requested("direction").map(Self::from_ratio)
    }

    /// +1 or −1.
    fn ratio(self) -> f64 {
        match self {
            Self::Positive => 1.0,
            Self::Negative => -1.0,
        }
    }

    /// The direction in words.
    fn word(self) -> &'static str {
        match self {
            Self::Positive => "positive",
            Self::Negative => "negative",
        }
    }

    fn sign(self) -> char {
        match self {
            Self::Positive => '+',
            Self::Negative => '-',
        }
    }

    /// Label of a ramp's segment.
    fn ramp_label(self) -> String {
        format!("ramp{}", self.sign())
    }

    /// Label of the dwell before a ramp.
    fn dwell_label(self) -> String {
        format!("dwell{}", self.sign())
    }
}
