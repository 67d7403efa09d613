//! The same strokes for kinds that hold them against something else: how they run, and what each direction shows.

use std::f64::consts::TAU;

use super::record::Record;
use super::sweep::{Reach, Sweep};
use super::{dynamic, plan};
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::log::Window;
use crate::measurement::{Evidence, Exclusion};
use crate::quantity::QuantityKind as Q;

/// Strokes at one velocity between two limits, each kind's own keys apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::kinds) struct Strokes {
    pub(in crate::kinds) velocity_rad_per_s: f64,
    pub(in crate::kinds) span_rad: [f64; 2],
    pub(in crate::kinds) cycles: u32,
    /// At the turns; the axis' own without one.
    pub(in crate::kinds) acceleration_rad_per_s2: Option<f64>,
}

/// Motor torque less inertia over angle, one branch a direction, on the same whole cogging periods.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::kinds) struct Branches {
    /// Middles of the bins, ascending.
    pub(in crate::kinds) angle_rad: Vec<f64>,
    /// Torque of each bin with growing and with falling angle, N·m.
    pub(in crate::kinds) torque_nm: [Vec<f64>; 2],
    pub(in crate::kinds) bins_per_period: usize,
    /// Mean rate of the plateaus, a magnitude.
    pub(in crate::kinds) achieved_rad_per_s: f64,
    /// Standard uncertainty that the drive's quantum leaves in a mean.
    pub(in crate::kinds) quantum_u_nm: f64,
    /// Relative standard uncertainty of the torque constant.
    pub(in crate::kinds) scale_u_ratio: f64,
    pub(in crate::kinds) flags: Vec<String>,
    pub(in crate::kinds) excluded: Vec<Exclusion>,
    pub(in crate::kinds) evidence: Vec<Evidence>,
}

/// Why strokes show nothing, and how fast the axis was, where that is known.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::kinds) struct NoBranches {
    pub(in crate::kinds) reason: String,
    pub(in crate::kinds) achieved_rad_per_s: Option<f64>,
}

impl Strokes {
    /// Their one point on an axis.
    pub(in crate::kinds) fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        let sweep = Sweep {
            velocities_rad_per_s: vec![self.velocity_rad_per_s],
            reach: Reach::Span(self.span_rad),
            opposite_span_rad: None,
            cycles: self.cycles,
            acceleration_rad_per_s2: self.acceleration_rad_per_s2,
            jerk_rad_per_s3: None,
            other_axis_pose_rad: None,
        };
        plan::plan(&sweep, axis, axes)
    }
}

impl Branches {
    /// What a point that [`Strokes::plan`] planned shows.
    pub(in crate::kinds) fn read(
        case: &Case,
        window: &Window,
        limits: &AxisLimits,
    ) -> Result<Self, NoBranches> {
        let nothing = |reason: String| NoBranches { reason, achieved_rad_per_s: None };
        let record = Record::new(&case.axis, window, limits).map_err(nothing)?;
        if record.kind != Q::Torque {
            return Err(nothing("no torque constant is known: the record is in ampere".to_owned()));
        }
        let found = dynamic::find(case, window, &record, limits);
        let achieved_rad_per_s = found.achieved_rad_per_s;
        if let Some(reason) = found.trouble {
            return Err(NoBranches { reason, achieved_rad_per_s });
        }
        let ([angle_rad, growing], [_, falling]) = (found.forward, found.reverse);
        let [first, second, ..] = angle_rad[..] else {
            return Err(nothing("the strokes share no whole cogging period".to_owned()));
        };
        let period_rad = TAU / limits.cogging_orders_per_rev;
        Ok(Self {
            bins_per_period: (period_rad / (second - first)).round() as usize,
            angle_rad,
            torque_nm: [growing, falling],
            achieved_rad_per_s: achieved_rad_per_s.unwrap_or(0.0),
            quantum_u_nm: found.quantum_u,
            scale_u_ratio: record.scale_u_ratio,
            flags: found.flags,
            excluded: found.excluded,
            evidence: found.evidence,
        })
    }
}
