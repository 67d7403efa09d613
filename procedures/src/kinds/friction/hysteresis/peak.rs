//! Peak of the cogging ripple: the largest magnitude that all lines make together.

use analysis::cogging::{Amplitude, Harmonic, LEAST_SHARE, Line, Peak};
use analysis::estimate::Estimate;
use analysis::uncertainty::{Component, combine};

use super::cogging::WithSpectrum;
use super::{PEAK, PEAK_CURRENT};
use crate::axis::AxisLimits;
use crate::measurement::Measurement;
use crate::quantity::QuantityKind as Q;
use crate::reason::FrictionReason;

/// Estimator and version.
pub(super) const ESTIMATOR: &str = "cogging-peak/2";

impl WithSpectrum<'_> {
    /// Largest magnitude of the sum of all harmonics over the travel.
    pub(super) fn peak(&self, axis: &str, limits: &AxisLimits) -> Measurement {
        let kind = self.point.kind;
        let name = if kind == Q::Torque { PEAK } else { PEAK_CURRENT };
        let harmonics = &self.cogging.spectrum.harmonics;
        let freed: Vec<(Amplitude, Component)> =
            harmonics.iter().map(|h| self.freed_of_friction(h)).collect();
        let lines: Vec<Line> =
            harmonics.iter().zip(&freed).map(|(harmonic, (left, _))| line_of_sum(harmonic, *left)).collect();
        let Some(peak) = Peak::new(&lines, limits.travel_rad, self.middle_rad()) else {
            let to = self.cogging.spectrum.order_per_rev.last().copied().unwrap_or(0.0);
            let reason = FrictionReason::NoLine { from: 0.0, to };
            return self.described(Measurement::inconclusive(name, axis, kind, ESTIMATOR, reason));
        };
        // What the slope of friction may be off is one error in all lines, so their shares add up.
        let of_slope = freed.iter().map(|(_, of_slope)| of_slope.u).sum();
        let of_spot = if self.cogging.has_spot { of_spot(&lines, limits, self.middle_rad()) } else { 0.0 };
        let estimate = self.estimate_of_peak(&peak, &lines, of_slope, of_spot);
        let mut m = self.described(Measurement::new(name, axis, kind, Some(estimate), ESTIMATOR));
        let count = lines.len();
        let sum = if count == 1 { "one line".to_owned() } else { format!("sum of {count} lines") };
        m.flags.push(format!("{sum}, largest at {}", Q::Angle.format(peak.angle_rad)));
        if of_spot > 0.0 {
            let most = kind.format(of_spot);
            m.flags.push(format!(
                "friction has a spot: up to {most} in lines beside the cogging may be friction"
            ));
        }
        m
    }

    fn middle_rad(&self) -> f64 {
        self.cogging.spectrum.middle_rad
    }

    /// A line below the share that is looked at may be missing (half-width). The largest value of a noisy sum is too large by
    /// `excess` at the most (half-width), and by what a spot of friction leaves in it (half-width).
    fn estimate_of_peak(&self, peak: &Peak, lines: &[Line], of_slope: f64, of_spot: f64) -> Estimate {
        let root = 3_f64.sqrt();
        let largest = lines.iter().map(|line| line.amplitude.amplitude).fold(0.0, f64::max);
        let spread = combine(&[
            peak.spread,
            Component::known(of_slope),
            Component::known(LEAST_SHARE * largest / root),
            Component::known(peak.excess / root),
            Component::known(of_spot / root),
            self.point.scale.share(peak.value, self.point.friction_nm()),
            Component::known(self.cogging.gain_error_ratio * peak.value / root),
        ]);
        Estimate { value: peak.value, u: spread.u, dof: spread.dof, n: self.cogging.points_count }
    }
}

/// Farthest order of a line of cogging from a multiple of the expected order, as a share of it.
const OF_COGGING: f64 = 0.1;

/// Largest magnitude of the lines that are not those of cogging.
fn of_spot(lines: &[Line], limits: &AxisLimits, middle_rad: f64) -> f64 {
    let is_beside = |line: &&Line| {
        let multiple = line.order_per_rev / limits.cogging_orders_per_rev;
        multiple < 1.0 - OF_COGGING || (multiple - multiple.round()).abs() > OF_COGGING
    };
    let beside: Vec<Line> = lines.iter().filter(is_beside).copied().collect();
    Peak::new(&beside, limits.travel_rad, middle_rad).map_or(0.0, |peak| peak.value)
}

/// A harmonic with what is left of it without friction.
fn line_of_sum(harmonic: &Harmonic, left: Amplitude) -> Line {
    let order_per_rev = harmonic.at_order_per_rev;
    let is_whole = order_per_rev.fract() == 0.0;
    let order_u_per_rev = if is_whole { 0.0 } else { harmonic.order_u_per_rev };
    Line { order_per_rev, order_u_per_rev, amplitude: left }
}
