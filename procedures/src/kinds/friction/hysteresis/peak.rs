//! Peak of the cogging ripple: the largest magnitude that all lines make together.

use analysis::cogging::{Harmonic, LEAST_SHARE, Line, Peak};
use analysis::estimate::Estimate;
use analysis::uncertainty::{Component, combine};

use super::cogging::WithSpectrum;
use super::{PEAK, PEAK_CURRENT};
use crate::axis::AxisLimits;
use crate::measurement::Measurement;
use crate::quantity::QuantityKind as Q;
use crate::reason::FrictionReason;

/// Estimator and version.
pub(super) const ESTIMATOR: &str = "cogging-peak/1";

impl WithSpectrum<'_> {
    /// Largest magnitude of the sum of all harmonics over the travel.
    pub(super) fn peak(&self, axis: &str, limits: &AxisLimits) -> Measurement {
        let kind = self.point.kind;
        let name = if kind == Q::Torque { PEAK } else { PEAK_CURRENT };
        let harmonics = &self.cogging.spectrum.harmonics;
        let lines: Vec<Line> = harmonics.iter().map(|h| self.line_of_sum(h)).collect();
        let Some(peak) = Peak::new(&lines, limits.travel_rad, self.cogging.spectrum.middle_rad) else {
            let to = self.cogging.spectrum.order_per_rev.last().copied().unwrap_or(0.0);
            let reason = FrictionReason::NoLine { from: 0.0, to };
            return self.described(Measurement::inconclusive(name, axis, kind, ESTIMATOR, reason));
        };
        let estimate = self.estimate_of_peak(&peak, &lines);
        let mut m = self.described(Measurement::new(name, axis, kind, Some(estimate), ESTIMATOR));
        let count = lines.len();
        let sum = if count == 1 { "one line".to_owned() } else { format!("sum of {count} lines") };
        m.flags.push(format!("{sum}, largest at {}", Q::Angle.format(peak.angle_rad)));
        m
    }

    /// A harmonic freed of friction, with its noise alone.
    fn line_of_sum(&self, harmonic: &Harmonic) -> Line {
        let order_per_rev = harmonic.at_order_per_rev;
        let is_whole = order_per_rev.fract() == 0.0;
        let order_u_per_rev = if is_whole { 0.0 } else { harmonic.order_u_per_rev };
        Line { order_per_rev, order_u_per_rev, amplitude: self.freed_of_friction(harmonic).0 }
    }

    /// What the slope of friction may be off is one error in all lines, so their shares add up. A line below the share that is
    /// looked at may be missing (half-width). The largest value of a noisy sum is too large by `excess` at the most (half-width).
    fn estimate_of_peak(&self, peak: &Peak, lines: &[Line]) -> Estimate {
        let root = 3_f64.sqrt();
        let harmonics = self.cogging.spectrum.harmonics.iter();
        let of_slope: f64 = harmonics.map(|h| self.freed_of_friction(h).1.u).sum();
        let largest = lines.iter().map(|line| line.amplitude.amplitude).fold(0.0, f64::max);
        let spread = combine(&[
            peak.spread,
            Component::known(of_slope),
            Component::known(LEAST_SHARE * largest / root),
            Component::known(peak.excess / root),
            self.point.scale.share(peak.value, self.point.friction_nm()),
            Component::known(self.cogging.gain_error_ratio * peak.value / root),
        ]);
        Estimate { value: peak.value, u: spread.u, dof: spread.dof, n: self.cogging.points_count }
    }
}
