//! The worst cases of a plan, as they go into its log: what judges it later must not compute them again, with other
//! mathematics perhaps than the run relied on.

use procedures::case::Case;
use reports::record::ComputedWorst;

use super::{envelopes_of, risks};
use crate::model::rig::Rig;

/// The worst cases of the points of a procedure; `None` where it moves nothing on its axis.
pub fn computed_worst(procedure: &str, axis: &str, cases: &[Case], rig: &Rig) -> Option<ComputedWorst> {
    let all = envelopes_of(procedure, axis, cases, rig);
    let found = all.first().filter(|found| found.axis == axis)?;
    let of_axis = rig.axes.iter().find(|a| a.name == axis)?;
    let (longest, nearest) = (found.longest_stop()?, found.nearest_stop()?);
    let coast = found.coast(of_axis).map(|c| c.coast);
    let impact = coast.and_then(|c| c.impact);
    Some(ComputedWorst {
        stop_angle_rad: longest.angle_rad,
        stop_s: longest.time_s,
        room_rad: nearest.room_rad,
        coast_to_rad: coast.map(|c| c.end_rad),
        impact_energy_j: impact.map(|i| i.energy_j),
        impact_rad_per_s: impact.map(|i| i.speed_rad_per_s),
        risks: risks(&all, rig),
    })
}
