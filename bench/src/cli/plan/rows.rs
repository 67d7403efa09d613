//! Rows of the tables of `bench plan`.

use reports::printable::counted;

use crate::model::axis::{NOT_ENFORCED, RigAxis};
use crate::model::rig::Rig;
use crate::plan::preflight::{PlannedCoast, PlannedStop, PointEnvelope, ProcedureEnvelope};

fn head(cells: &[&str]) -> Vec<String> {
    cells.iter().map(|&cell| cell.to_owned()).collect()
}

/// What procedures and points ask of the axes.
pub(super) fn envelope(found: &[ProcedureEnvelope], points: bool) -> Vec<Vec<String>> {
    let mut rows =
        vec![head(&["procedure", "point", "duration", "position", "rate", "acceleration", "torque", "rms"])];
    for procedure in found {
        let count = counted(procedure.points.len(), "point");
        let mut row = asked(&procedure.procedure, &count, &whole(procedure));
        row.push(format!("{:.0} N*m", procedure.rms_torque_nm));
        rows.push(row);
        if points {
            rows.extend(procedure.points.iter().map(|p| asked("", &p.point, p)));
        }
    }
    rows
}

/// All points in one.
fn whole(procedure: &ProcedureEnvelope) -> PointEnvelope {
    let mut points = procedure.points.iter();
    let mut whole = points.next().cloned().unwrap_or_else(PointEnvelope::empty);
    for p in points {
        whole.duration_s += p.duration_s;
        whole.position_rad[0] = whole.position_rad[0].min(p.position_rad[0]);
        whole.position_rad[1] = whole.position_rad[1].max(p.position_rad[1]);
        whole.rate_rad_per_s = whole.rate_rad_per_s.max(p.rate_rad_per_s);
        whole.acceleration_rad_per_s2 = whole.acceleration_rad_per_s2.max(p.acceleration_rad_per_s2);
        whole.torque_nm = whole.torque_nm.max(p.torque_nm);
    }
    whole
}

fn asked(procedure: &str, point: &str, e: &PointEnvelope) -> Vec<String> {
    vec![
        procedure.to_owned(),
        point.to_owned(),
        format!("{:.0} s", e.duration_s),
        format!("{:.1} .. {:.1} deg", e.position_rad[0].to_degrees(), e.position_rad[1].to_degrees()),
        format!("{:.2} deg/s", e.rate_rad_per_s.to_degrees()),
        format!("{:.1} deg/s^2", e.acceleration_rad_per_s2.to_degrees()),
        format!("{:.0} N*m", e.torque_nm),
    ]
}

/// Stops and coasts from the worst instants.
pub(super) fn worst(found: &[ProcedureEnvelope], rig: &Rig, points: bool) -> Vec<Vec<String>> {
    let mut rows =
        vec![head(&["procedure", "point", "stop from", "angle", "time", "room", "coast from", "ends"])];
    for procedure in found {
        let Some(axis) = rig.axes.iter().find(|a| a.name == procedure.axis) else { continue };
        let longest = procedure.longest_stop();
        let nearest = procedure.nearest_stop();
        rows.push(ways_out(&procedure.procedure, "worst", longest, nearest, procedure.coast(axis), axis));
        if points {
            let row =
                |p: &PointEnvelope| ways_out("", &p.point, p.longest_stop, p.nearest_stop, p.coast, axis);
            rows.extend(procedure.points.iter().map(row));
        }
    }
    rows
}

fn ways_out(
    procedure: &str,
    point: &str,
    longest: Option<PlannedStop>,
    nearest: Option<PlannedStop>,
    coast: Option<PlannedCoast>,
    axis: &RigAxis,
) -> Vec<String> {
    let nothing = || "-".to_owned();
    vec![
        procedure.to_owned(),
        point.to_owned(),
        longest.map_or_else(nothing, |s| instant(s.from_rad, s.rate_rad_per_s)),
        longest.map_or_else(nothing, |s| format!("{:.2} deg", s.angle_rad.to_degrees())),
        longest.map_or_else(nothing, |s| s.time_s.map_or("friction".to_owned(), |t| format!("{t:.2} s"))),
        nearest.map_or_else(nothing, |s| format!("{:.2} deg", s.room_rad.to_degrees())),
        coast.map_or_else(nothing, |c| instant(c.from_rad, c.rate_rad_per_s)),
        coast.map_or_else(nothing, |c| coast_end(&c, axis)),
    ]
}

fn instant(at_rad: f64, rate_rad_per_s: f64) -> String {
    format!("{:.1} deg/s at {:.1} deg", rate_rad_per_s.to_degrees(), at_rad.to_degrees())
}

fn coast_end(c: &PlannedCoast, axis: &RigAxis) -> String {
    match c.coast.impact {
        None => format!("at {:.1} deg", c.coast.end_rad.to_degrees()),
        Some(impact) => format!(
            "IMPACT {:.0} J at {:.1} deg/s (stops absorb {:.0} J)",
            impact.energy_j,
            impact.speed_rad_per_s.to_degrees(),
            axis.guard.stop.end_stop_energy_j
        ),
    }
}

/// Segments without a planned position, the fastest of each label.
pub(super) fn bounded(found: &[ProcedureEnvelope]) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for procedure in found {
        let mut fastest: Vec<&crate::plan::preflight::BoundedSegment> = Vec::new();
        for segment in procedure.points.iter().flat_map(|p| &p.bounded) {
            match fastest.iter_mut().find(|other| other.segment == segment.segment) {
                Some(other) if other.rate_rad_per_s >= segment.rate_rad_per_s => {}
                Some(other) => *other = segment,
                None => fastest.push(segment),
            }
        }
        for (index, segment) in fastest.iter().enumerate() {
            let id = if index == 0 { procedure.procedure.as_str() } else { "" };
            let speed = match segment.rate_rad_per_s {
                0.0 => "does not move".to_owned(),
                rate => format!("up to {:.2} deg/s", rate.to_degrees()),
            };
            rows.push(vec![id.to_owned(), segment.segment.clone(), speed, format!("by {}", segment.by)]);
        }
    }
    if !rows.is_empty() {
        rows.insert(0, head(&["procedure", "segment", "speed", "bounded"]));
    }
    rows
}

/// What the drives leave to the bench.
pub(super) fn not_enforced() -> Vec<Vec<String>> {
    let mut rows = vec![head(&["what", "watched by interlock", "why"])];
    rows.extend(NOT_ENFORCED.iter().map(|n| head(&[n.what, n.watched_by, n.why])));
    rows
}
