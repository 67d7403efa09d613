//! Over all points: curve, gravity, cogging, pictures and remarks.

use super::curve::Curve;
use super::numbers::Valid;
use super::sweep::Sweep;
use super::{cogging, gravity, pictures};
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;

/// Velocities from which friction over velocity is worth a picture.
const LEAST_VELOCITIES: usize = 3;

/// What the procedure says in the end.
pub(super) fn conclude(sweep: &Sweep, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
    let mut whole = Conclusion::default();
    for point in points {
        whole.measurements.extend(point.measurements.iter().cloned());
        whole.plots.extend(point.plots.iter().cloned());
    }
    let Some((axis, limits)) = cases.first().and_then(|c| Some((c.axis.as_str(), axes.get(&c.axis)?))) else {
        return whole;
    };
    let valid: Vec<Valid<'_>> = points.iter().filter_map(Valid::of).collect();
    let on = On { axis, limits, valid: &valid };
    if let Some(curve) = Curve::new(&valid) {
        let planned = cases.iter().filter(|c| c.requested("pose").is_none_or(|pose| pose == 0.0)).count();
        on.add_curve(&mut whole, &curve, planned, points);
    }
    if sweep.gives_gravity() {
        on.add_gravity(&mut whole);
    }
    if sweep.gives_cogging() {
        whole.measurements.extend(cogging::measure(axis, limits, &valid));
        let slowest = cogging::slowest(&valid);
        whole.plots.extend(slowest.map(|(point, cogging)| pictures::spectrum(point, &cogging)));
    }
    for point in &valid {
        whole.remarks.extend(point.offset().map(|offset| {
            format!(
                "Half the sum of the means of both directions, {}: {}.",
                point.name,
                point.kind.format(offset)
            )
        }));
    }
    whole
}

/// The axis and the points that stand.
struct On<'a> {
    axis: &'a str,
    limits: &'a AxisLimits,
    valid: &'a [Valid<'a>],
}

impl On<'_> {
    fn add_curve(&self, whole: &mut Conclusion, curve: &Curve, planned: usize, points: &[PointResult]) {
        whole.measurements.extend(curve.measure(self.axis, planned));
        if planned >= LEAST_VELOCITIES {
            whole.remarks.extend(curve.remarks());
            whole.plots.extend(pictures::friction_curve(curve, points));
        }
    }

    fn add_gravity(&self, whole: &mut Conclusion) {
        let chosen = gravity::choose(self.valid);
        whole.measurements.extend(gravity::measure(self.axis, self.limits, chosen.as_ref()));
        whole.measurements.extend(gravity::measure_poses(self.axis, self.valid));
        let Some(chosen) = chosen else { return };
        whole.plots.push(pictures::half_sum(&chosen));
        let [stiffness, _] = chosen.fit.stiffness_nm_per_rad();
        let [torque, u] = chosen.fit.spring_nm(0.0);
        whole.remarks.push(format!(
            "Spring torque at 0 deg is {} (u {}), stiffness {}: its rest angle rests on the constant of the fit alone, so a torque offset of the drive would count as spring.",
            Q::Torque.format(torque),
            Q::Torque.format(u),
            Q::Stiffness.format(stiffness)
        ));
    }
}
