//! What no software takes away: what remains when torque is lost.

use procedures::device::DeviceRole;
use procedures::quantity::QuantityKind as Q;

use super::ProcedureEnvelope;
use crate::model::axis::RigAxis;
use crate::model::rig::Rig;

/// Residual risks of a plan, one sentence each, with numbers.
pub(crate) fn risks(found: &[ProcedureEnvelope], rig: &Rig) -> Vec<String> {
    let mut all = Vec::new();
    if rig.emergency_stop_bit.is_none() && rig.emergency_stop_input.is_none() {
        let text = "emergency stop: the rig names no input for it; the bench notices it only when drives \
                    leave operation";
        all.push(text.to_owned());
    }
    for axis in &rig.axes {
        let stop = &axis.guard.stop;
        all.push(zero(axis));
        all.extend(drive_type(axis));
        let of_axis = || found.iter().filter(|f| f.axis == axis.name);
        let coasts = of_axis().filter_map(|f| Some((f, f.coast(axis)?)));
        let hit = coasts
            .filter_map(|(f, c)| Some((f, c, c.coast.impact?)))
            .max_by(|a, b| a.2.energy_j.total_cmp(&b.2.energy_j));
        if let Some((procedure, coast, impact)) = hit {
            all.push(format!(
                "{}: if torque is lost from {coast} ({}), it hits its end stop with {} at {}; the stops absorb {}",
                axis.name,
                procedure.procedure,
                Q::Energy.format(round(impact.energy_j)),
                Q::AngularVelocity.format(round(impact.speed_rad_per_s.to_degrees()).to_radians()),
                Q::Energy.format(stop.end_stop_energy_j),
            ));
        }
        let swings = found.iter().flat_map(|f| &f.swings).filter(|s| s.axis == axis.name);
        let way = |s: &&super::PlannedSwing| (s.swing.to_rad - s.from_rad).abs();
        if let Some(s) = swings.max_by(|a, b| way(a).total_cmp(&way(b))) {
            all.push(format!(
                "{}: if torque is lost at rest at {}, it swings to {:.1} deg, at up to {:.2} deg/s",
                axis.name,
                Q::Angle.format(s.from_rad),
                s.swing.to_rad.to_degrees(),
                s.swing.speed_rad_per_s.to_degrees(),
            ));
        }
    }
    if rig.device(DeviceRole::Mirror).is_some() {
        all.push(
            "mirror: it has no watchdog; if the bench program dies, it keeps its last position. A trip \
             sends it to 0 V within 100 ms"
                .to_owned(),
        );
    }
    all
}

/// What the type of a drive leaves to nobody.
fn drive_type(axis: &RigAxis) -> Vec<String> {
    let profile = &axis.drive.profile;
    let mut all = Vec::new();
    if profile.heat_sink.is_none() {
        all.push(format!(
            "{}: its drive (profile `{}`) tells no temperature of its heat sink; only the drive watches it",
            axis.name, profile.id
        ));
    }
    let lacking = |consequence| format!("{}: its drive (profile `{}`): {consequence}", axis.name, profile.id);
    all.extend(profile.consequences().into_iter().map(lacking));
    all
}

/// How far the zero of an encoder is proven, and what that leaves.
fn zero(axis: &RigAxis) -> String {
    let ([low, high], [soft_low, soft_high]) = (axis.limits.travel_rad, axis.limits.soft_limits_rad);
    let clear_rad = (soft_low - low).min(high - soft_high);
    let zero = Q::Angle.format(axis.limits.zero_tolerance_rad);
    format!(
        "{}: the zero of its encoder is verified to {zero} only, by reading the scale on the axis before \
         the first motion; the soft limits are {} inside the ends of travel, and an axis that creeps to \
         the very ends may be {zero} beyond them",
        axis.name,
        Q::Angle.format(clear_rad)
    )
}

/// To a tenth.
fn round(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}
