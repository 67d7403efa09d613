//! The safety findings of a report as table rows and sentences, shared by all output formats.

use procedures::log::{FinalState, StopManner};

use crate::record::{Findings, ProcedureFindings, SafetyFindings, StopFinding, TripFinding};

/// Table headings. The last column of the stops has no cell in [`stops`]: each output format writes it.
pub(crate) const TRIP_HEAD: [&str; 4] = ["Procedure", "Point", "Order", "Interlock, seen, limit"];
pub(crate) const STOP_HEAD: [&str; 9] = [
    "Procedure",
    "Point",
    "Axis",
    "Manner",
    "From",
    "Angle, reached / computed",
    "Time, took / computed",
    "Room to end of travel",
    "Against computed",
];
pub(crate) const LEFT_HEAD: [&str; 5] = ["Procedure", "Axis", "State", "At", "If torque is lost there"];
pub(crate) const WORST_HEAD: [&str; 5] =
    ["Procedure", "Largest stop", "Longest stop", "Least room to a soft limit", "Worst coast without torque"];
pub(crate) const NOT_ENFORCED_HEAD: [&str; 3] = ["Not enforced by the drives", "Watched by interlock", "Why"];

/// Whether there is any safety finding to report.
pub(crate) fn is_known(findings: &Findings) -> bool {
    !findings.not_enforced.is_empty() || all(findings).next().is_some()
}

/// Procedures that have safety findings, each with these findings.
fn all(findings: &Findings) -> impl Iterator<Item = (&ProcedureFindings, &SafetyFindings)> {
    findings.procedures.iter().filter_map(|p| Some((p, p.safety.as_ref()?)))
}

/// Kinds of procedures that command an axis past a limit on purpose, to provoke the interlocks in `PROVOKED`.
const PROVOKING: [&str; 2] = ["range", "stop"];
const PROVOKED: [&str; 3] = ["braking curve", "position", "restricted zone"];

/// Whether the procedure provoked this trip on purpose. The reason of a trip begins with the interlock's name and a colon.
fn is_provoked(p: &ProcedureFindings, trip: &TripFinding) -> bool {
    let interlock = trip.reason.split(':').next().unwrap_or("");
    PROVOKING.contains(&p.kind.as_str()) && PROVOKED.contains(&interlock)
}

/// The warning on the front page, in one line. It names unprovoked trips, stops beyond the computed worst case and axes
/// that left their travel. `None` where there are none of these.
pub(crate) fn alarm(findings: &Findings) -> Option<String> {
    let unprovoked_trips = |p: &ProcedureFindings, s: &SafetyFindings| {
        s.trips.iter().filter(|t| t.first_out && !is_provoked(p, t)).count()
    };
    let trips: usize = all(findings).map(|(p, s)| unprovoked_trips(p, s)).sum();
    let exceeding: Vec<String> = all(findings)
        .flat_map(|(p, s)| s.stops.iter().filter(|stop| stop.exceeds()).map(move |stop| (p, stop)))
        .map(|(p, stop)| format!("{}, {}, {}", p.id, stop.point, stop.axis))
        .collect();
    let mut parts = Vec::new();
    if trips > 0 {
        let tripped: Vec<&str> =
            all(findings).filter(|(p, s)| unprovoked_trips(p, s) > 0).map(|(p, _)| p.id.as_str()).collect();
        let noun = if trips == 1 { "trip" } else { "trips" };
        parts.push(format!("{trips} {noun} ({})", tripped.join(", ")));
    }
    let outside: Vec<String> = all(findings)
        .flat_map(|(p, s)| s.stops.iter().filter(|stop| stop.left_the_travel()).map(move |stop| (p, stop)))
        .map(|(p, stop)| {
            let by_deg = -stop.room_rad.to_degrees();
            format!("{}, {}, {} by {by_deg:.2} deg", p.id, stop.point, stop.axis)
        })
        .collect();
    if !outside.is_empty() {
        parts.push(format!("FINDING: left its travel: {}", outside.join("; ")));
    }
    if !exceeding.is_empty() {
        parts.push(format!("FINDING: stopped beyond the computed worst case: {}", exceeding.join("; ")));
    }
    (!parts.is_empty()).then(|| parts.join(" · "))
}

/// One sentence that counts all trips and stops and compares the stops with their computed worst case.
pub(crate) fn summary(findings: &Findings) -> String {
    let trips: usize = all(findings).map(|(_, s)| s.trips.len()).sum();
    let stops: Vec<&StopFinding> = all(findings).flat_map(|(_, s)| &s.stops).collect();
    let exceeding = stops.iter().filter(|s| s.exceeds()).count();
    let used_share = |s: &&StopFinding| s.reached_angle_rad / s.computed_angle_rad;
    let largest_share =
        stops.iter().filter(|s| s.computed_angle_rad > 0.0).map(used_share).fold(0.0, f64::max);
    let counted = |n: usize, word: &str| if n == 1 { format!("1 {word}") } else { format!("{n} {word}s") };
    let of_stops = match (stops.len(), exceeding) {
        (0, _) => "no axis was moving when it was stopped".to_owned(),
        (n, 0) => format!(
            "{} in motion, within the computed worst case (the closest used {:.0} % of its computed angle)",
            counted(n, "stop"),
            100.0 * largest_share
        ),
        (n, beyond) => {
            format!("{} in motion, {beyond} of them BEYOND the computed worst case", counted(n, "stop"))
        }
    };
    let provoked: usize =
        all(findings).map(|(p, s)| s.trips.iter().filter(|t| is_provoked(p, t)).count()).sum();
    let of_trips = match provoked {
        0 => counted(trips, "trip"),
        n => format!("{}, {n} of them provoked deliberately by moves past a limit", counted(trips, "trip")),
    };
    format!("{of_trips}; {of_stops}.")
}

/// Rows of the trips table, under [`TRIP_HEAD`].
pub(crate) fn trips(findings: &Findings) -> Vec<[String; 4]> {
    let row = |p: &ProcedureFindings, t: &TripFinding| {
        let order = match (t.first_out, is_provoked(p, t)) {
            (true, false) => "first out",
            (true, true) => "first out, provoked",
            (false, _) => "after it",
        };
        [p.id.clone(), t.point.clone(), order.to_owned(), t.reason.clone()]
    };
    all(findings).flat_map(|(p, s)| s.trips.iter().map(move |t| row(p, t))).collect()
}

/// Rows of the stops table, each with its finding, from which the output format writes the last column of [`STOP_HEAD`].
pub(crate) fn stops(findings: &Findings) -> Vec<([String; 8], &StopFinding)> {
    let row = |p: &ProcedureFindings, s: &StopFinding| {
        let computed = s.computed_s.map_or("friction".to_owned(), |t| format!("{t:.2} s"));
        [
            p.id.clone(),
            s.point.clone(),
            s.axis.clone(),
            manner(s.manner).to_owned(),
            format!("{:.2} deg/s at {:.2} deg", s.from_rad_per_s.to_degrees(), s.from_rad.to_degrees()),
            format!("{:.2} / {:.2} deg", s.reached_angle_rad.to_degrees(), s.computed_angle_rad.to_degrees()),
            format!("{:.2} s / {computed}", s.took_s),
            format!("{:.2} deg", s.room_rad.to_degrees()),
        ]
    };
    all(findings).flat_map(|(p, s)| s.stops.iter().map(move |stop| (row(p, stop), stop))).collect()
}

fn manner(manner: StopManner) -> &'static str {
    match manner {
        StopManner::Controlled => "under control",
        StopManner::QuickStop => "drive's quick stop",
        StopManner::LinkLimited => "as far as the DC link allowed",
        StopManner::TorqueOff => "without torque",
    }
}

/// Rows under [`LEFT_HEAD`]: the state in which each axis was left, and where it would move without torque.
pub(crate) fn left(findings: &Findings) -> Vec<[String; 5]> {
    let row = |p: &ProcedureFindings, l: &FinalState| {
        let kept = if l.held { "held by torque" } else { "without torque" };
        let swing = match (l.swing_to_rad, l.swing_rad_per_s) {
            (Some(to), Some(speed)) => {
                format!("swings to {:.2} deg, up to {:.2} deg/s", to.to_degrees(), speed.to_degrees())
            }
            _ => "stays: friction holds it".to_owned(),
        };
        let state = format!("{}, {kept}", l.state);
        [p.id.clone(), l.axis.clone(), state, format!("{:.2} deg", l.position_rad.to_degrees()), swing]
    };
    all(findings).flat_map(|(p, s)| s.left.iter().map(move |l| row(p, l))).collect()
}

/// Rows under [`WORST_HEAD`]: the worst cases computed before the first motion. A missing stop time means that friction
/// alone stops the axis.
pub(crate) fn worst(findings: &Findings) -> Vec<[String; 5]> {
    all(findings)
        .filter_map(|(p, s)| {
            let c = s.computed.as_ref()?;
            let coast = match (c.coast_to_rad, c.impact_energy_j, c.impact_rad_per_s) {
                (_, Some(energy), Some(speed)) => {
                    format!("hits its end stop with {energy:.0} J at {:.1} deg/s", speed.to_degrees())
                }
                (Some(to), _, _) => format!("ends at {:.1} deg", to.to_degrees()),
                _ => "—".to_owned(),
            };
            Some([
                p.id.clone(),
                format!("{:.2} deg", c.stop_angle_rad.to_degrees()),
                c.stop_s.map_or("friction".to_owned(), |t| format!("{t:.2} s")),
                format!("{:.2} deg", c.room_rad.to_degrees()),
                coast,
            ])
        })
        .collect()
}

/// Rows under [`NOT_ENFORCED_HEAD`]: limits that the drives do not enforce, and the interlock that watches each.
pub(crate) fn not_enforced(findings: &Findings) -> Vec<[String; 3]> {
    let row = |n: &crate::record::NotEnforcedFinding| [n.what.clone(), n.watched_by.clone(), n.why.clone()];
    findings.not_enforced.iter().map(row).collect()
}

/// Residual risks of all procedures, in order of first appearance and without duplicates.
pub(crate) fn risks(findings: &Findings) -> Vec<&str> {
    let mut all_risks: Vec<&str> = Vec::new();
    for risk in all(findings).filter_map(|(_, s)| s.computed.as_ref()).flat_map(|c| &c.risks) {
        if !all_risks.contains(&risk.as_str()) {
            all_risks.push(risk);
        }
    }
    all_risks
}
