//! One point: its moves, its ends, and what of them stands where an interlock broke it off.

use analysis::estimate::Estimate;
use analysis::load_cycle::extremes;

use super::motion::{self, End, Move, Part};
use super::plan::{Keys, Moves, SLEW};
use super::{EXCESS, FULL_OVERSHOOT, FULL_SETTLING, OVERSHOOT, SETTLING};
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::kinds::position::positioned::{self, Record};
use crate::log::{PointStatus, Window};
use crate::measurement::{Bound, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{PositionReason, Reason};
use crate::trace::{MAX_POINTS, Plot, Scale, Series, Style};

pub(super) const ESTIMATOR: &str = "slew/1";

/// Flag of a settling time that is only a lower bound.
const NOT_SETTLED: &str = "not settled: at least this long";

/// A value with what should be known of it, or why there is none.
type Found = Result<(Estimate, Vec<String>), Reason>;

pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> Result<PointResult, Reason> {
    let limits = axes.limits(&case.axis)?;
    let record = Record::new(&case.axis, window)?;
    let slews = |span: &&crate::log::SegmentSpan| {
        case.segments.get(span.segment).is_some_and(|s| s.label.starts_with(SLEW))
    };
    let moves: Vec<Move<'_>> = window
        .segments
        .iter()
        .filter(slews)
        .filter_map(|span| Move::new(&record, &case.segments[span.segment], span))
        .collect();
    let weak = broken_off(window, &moves, limits)?;
    let mut plots = vec![motion_picture(case, &record)];
    let mut cues_rad = None;
    let values = match keys.moves {
        Moves::Gentle => gentle(&moves, weak.as_ref()),
        Moves::Full => full(case, window, &record, &moves, weak.as_ref(), &mut plots),
        Moves::Cue => {
            let ends = ends(case, window, &record, weak.as_ref(), &mut plots);
            let reached_rad = |ends: &Vec<End>| ends.iter().map(|end| end.reached_rad).collect::<Vec<f64>>();
            cues_rad = ends.as_ref().ok().and_then(|ends| extremes(&reached_rad(ends)));
            [OVERSHOOT, EXCESS, SETTLING].map(|name| of_ends(name, &ends)).into()
        }
    };
    let span_s = [record.time_s[0], record.time_s[record.time_s.len() - 1]];
    let channels = ["position_rad", "velocity_feedback_rad_per_s", "torque_command_nm", "torque_nm"];
    let evidence = record.evidence(&channels, span_s);
    let conditions = positioned::conditions(case, window, axes);
    let measured = keys.named().iter().zip(values).map(|((name, kind), found)| {
        let base = match found {
            Ok((estimate, flags)) => {
                let is_bound = flags.iter().any(|flag| flag == NOT_SETTLED);
                let why = "it did not settle while it rested: wait longer";
                let bound = is_bound.then(|| Bound::AtLeast(why.to_owned()));
                let measured = Measurement::new(name, &case.axis, *kind, Some(estimate), ESTIMATOR);
                Measurement { flags, bound, ..measured }
            }
            Err(reason) => Measurement::inconclusive(name, &case.axis, *kind, ESTIMATOR, reason),
        };
        let point = Some(case.point.clone());
        let (conditions, evidence) = (conditions.clone(), evidence.clone());
        let mut measured = Measurement { point, conditions, evidence, ..base };
        cues_rad.into_iter().for_each(|angles_rad| measured.set_angles(angles_rad));
        measured
    });
    Ok(PointResult {
        point: case.point.clone(),
        measurements: measured.collect(),
        plots,
        ..PointResult::default()
    })
}

/// Whether an interlock ended the point because the motor was too weak; an error if it ended for another reason.
fn broken_off(
    window: &Window,
    moves: &[Move<'_>],
    limits: &AxisLimits,
) -> Result<Option<PositionReason>, Reason> {
    if window.status == PointStatus::Completed {
        return if moves.is_empty() { Err(PositionReason::NoMove.into()) } else { Ok(None) };
    }
    let trip = window.trips.first();
    let Some(trip) = trip.filter(|_| window.status == PointStatus::Aborted) else {
        return Err(PositionReason::BrokenOff.into());
    };
    let last = moves.last().filter(|last| last.is_cut());
    match last.and_then(|last| last.short_of_torque(limits)) {
        Some([told_nm, shown_nm]) => Ok(Some(PositionReason::Weak { shown_nm, told_nm, trip: trip.clone() })),
        None => Err(PositionReason::Aborted { trip: trip.clone() }.into()),
    }
}

/// The worst of all moves that give a value.
fn worst<'a>(found: impl Iterator<Item = (&'a Move<'a>, Found)>) -> Found {
    let mut worst: Option<(Estimate, Vec<String>)> = None;
    let mut reason = Reason::from(PositionReason::NoMove);
    for (of, value) in found {
        match value {
            Ok((estimate, mut flags)) => {
                flags.insert(0, of.direction().to_owned());
                if worst.as_ref().is_none_or(|(other, _)| estimate.value < other.value) {
                    worst = Some((estimate, flags));
                }
            }
            Err(why) => reason = why,
        }
    }
    worst.ok_or(reason)
}

fn largest(found: impl Iterator<Item = Result<Estimate, Reason>>) -> Found {
    let by = |a: &Estimate, b: &Estimate| a.value.total_cmp(&b.value);
    let most = found.flatten().max_by(by).ok_or(PositionReason::NoLongMove)?;
    Ok((most, Vec::new()))
}

fn gentle(moves: &[Move<'_>], weak: Option<&PositionReason>) -> Vec<Found> {
    let with = |estimate: Estimate| (estimate, weak.map(PositionReason::to_string).into_iter().collect());
    // A move that was cut says what the axis reaches; whole ones before it do not speak for it.
    let sustained = worst(moves.iter().map(|m| (m, m.velocity().map(with))));
    vec![sustained, largest(moves.iter().map(|m| m.peak(1)))]
}

fn full(
    case: &Case,
    window: &Window,
    record: &Record<'_>,
    moves: &[Move<'_>],
    weak: Option<&PositionReason>,
    plots: &mut Vec<Plot>,
) -> Vec<Found> {
    let flagged = |(estimate, by_gyro): (Estimate, f64)| {
        let mut flags = vec![format!("by gyro {}", Q::AngularAcceleration.format(by_gyro))];
        flags.extend(weak.map(PositionReason::to_string));
        (estimate, flags)
    };
    let sustained = |part: Part| worst(moves.iter().map(|m| (m, m.acceleration(part).map(flagged))));
    let peak = largest(moves.iter().map(|m| m.peak(2)));
    let ends = ends(case, window, record, weak, plots);
    let deceleration = match weak {
        Some(why) => Err(why.clone().into()),
        None => sustained(Part::Braking),
    };
    let overshoot = of_ends(FULL_OVERSHOOT, &ends);
    let settling = of_ends(FULL_SETTLING, &ends);
    vec![sustained(Part::SpeedingUp), deceleration, peak, overshoot, settling]
}

/// The ends of all slews, with a picture; or why there are none.
fn ends(
    case: &Case,
    window: &Window,
    record: &Record<'_>,
    weak: Option<&PositionReason>,
    plots: &mut Vec<Plot>,
) -> Result<Vec<End>, Reason> {
    let ends = match weak {
        Some(why) => return Err(why.clone().into()),
        None => motion::ends(case, window, record)?,
    };
    plots.push(end_picture(case, &ends));
    Ok(ends)
}

/// The worst end of all cues.
fn of_ends(name: &str, ends: &Result<Vec<End>, Reason>) -> Found {
    let ends = ends.as_ref().map_err(Clone::clone)?;
    let urad = |rad: f64| format!("{:.2} urad", 1e6 * rad);
    if [SETTLING, FULL_SETTLING].contains(&name) {
        let worst =
            ends.iter().max_by(|a, b| a.settling_s.total_cmp(&b.settling_s)).ok_or(PositionReason::NoEnd)?;
        let n = worst.response.map_or(1, |r| r.repeats);
        let estimate = Estimate { value: worst.settling_s, u: worst.settling_u_s, dof: f64::INFINITY, n };
        let mut flags = vec![format!("cue {}, band {}", worst.cue, urad(motion::BAND_RAD))];
        if ends.iter().any(|end| end.response.is_none()) {
            flags.push(NOT_SETTLED.to_owned());
        }
        return Ok((estimate, flags));
    }
    let mut worst: Option<(Estimate, Vec<String>)> = None;
    for end in ends {
        let r = end.response.ok_or(PositionReason::NotSettled { cue: end.cue })?;
        let value = if name == EXCESS { r.overshoot - r.threshold } else { r.overshoot };
        let estimate = Estimate { value, u: r.overshoot_u, dof: r.overshoot_dof(), n: r.repeats };
        let flags = vec![
            format!("cue {}", end.cue),
            format!(
                "noise {} (1 sigma) at rest; counts as overshoot above {}",
                urad(r.noise),
                urad(r.threshold)
            ),
        ];
        if worst.as_ref().is_none_or(|(other, _)| value > other.value) {
            worst = Some((estimate, flags));
        }
    }
    worst.ok_or_else(|| PositionReason::NoEnd.into())
}

fn motion_picture(case: &Case, record: &Record<'_>) -> Plot {
    let t0 = record.time_s.first().copied().unwrap_or(0.0);
    let time: Vec<f64> = record.time_s.iter().map(|t| t - t0).collect();
    let rate: Vec<f64> = record.rate_rad_per_s.iter().map(|r| Q::AngularVelocity.to_display(*r)).collect();
    Plot {
        series: vec![Series::thinned("rate", Style::Line, [&time, &rate], MAX_POINTS)],
        ..Plot::new(
            format!("slew-{}", case.point.split(' ').next().unwrap_or_default()),
            format!("Rate, {}", case.point),
            Scale::linear("time", "s"),
            Scale::linear("rate", Q::AngularVelocity.display_unit()),
        )
    }
}

fn end_picture(case: &Case, ends: &[End]) -> Plot {
    let series = ends.iter().map(|end| {
        let [time, off] = &end.course;
        let off: Vec<f64> = off.iter().map(|v| 1e6 * v).collect();
        Series::thinned(format!("cue {}", end.cue), Style::Line, [time, &off], MAX_POINTS)
    });
    Plot {
        series: series.collect(),
        y_range: Some([-300.0, 300.0]),
        ..Plot::new(
            "slew-ends",
            format!("End of the slews, {}", case.point),
            Scale::linear("time since the planned end", "s"),
            Scale::linear("position less cue", "urad"),
        )
    }
}
