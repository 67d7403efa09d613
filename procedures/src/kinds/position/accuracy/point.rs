//! One point: parameters of the standards from its visits, and the graph of ISO 230-2.

use analysis::estimate::Estimate;
use analysis::positioning::{AtTarget, Direction, POSE_CYCLES, Positioning, Target, pose, positioning};

use super::plan::{Keys, Sequence};
use super::visits::{REFERENCE, Visits, visits};
use super::{ACCURACY, MEAN_RANGE, REPEATABILITY, REVERSAL, SERVO, SYSTEMATIC, named};
use crate::axis::Axes;
use crate::case::Case;
use crate::device::MIRROR_AXES;
use crate::log::Window;
use crate::measurement::{Condition, Evidence, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{PositionReason, Reason};
use crate::trace::{Note, Plot, Scale, Series, Style};

pub(super) const ESTIMATOR: &str = "positioning/1";
/// What a mean of the encoder leaves uncertain of a place: a count.
const ENCODER_COUNTS: f64 = 1.0;
/// What the autocollimator leaves uncertain from run to run at one face, as a part of its whole uncertainty: the table is
/// the same in every run.
const SAME_FACE_RATIO: f64 = 0.3;

type Found = Result<(Estimate, Vec<String>), Reason>;

pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> Result<PointResult, Reason> {
    let limits = axes.limits(&case.axis)?;
    let poses = keys.poses_rad.as_deref().filter(|_| Sequence::of(case) == Sequence::Poses);
    let seen = visits(keys, poses.unwrap_or(&keys.targets_rad), case, window, axes)?;
    let u_rad = limits.reference.as_ref().map_or(0.0, |r| r.u_rad);
    let counts_rad = ENCODER_COUNTS * limits.encoder_quantum_rad;
    let (values, plots) = match poses {
        Some(_) => (of_poses(&seen, u_rad, counts_rad), Vec::new()),
        None => of_targets(&seen, u_rad, counts_rad, case)?,
    };
    let evidence = evidence(case, window, axes);
    let conditions = if poses.is_some() { Vec::new() } else { targets(&seen) };
    let measured = named(case).iter().zip(values).map(|((name, kind), found)| {
        let base = match found {
            Ok((estimate, flags)) => {
                Measurement { flags, ..Measurement::new(name, &case.axis, *kind, Some(estimate), ESTIMATOR) }
            }
            Err(reason) => Measurement::inconclusive(name, &case.axis, *kind, ESTIMATOR, reason),
        };
        let conditions = conditions.clone();
        Measurement { point: Some(case.point.clone()), conditions, evidence: evidence.clone(), ..base }
    });
    Ok(PointResult {
        point: case.point.clone(),
        measurements: measured.collect(),
        plots,
        ..PointResult::default()
    })
}

/// The targets, as asked for and as reached by the encoder: an accuracy holds for the travel that they cover.
fn targets(seen: &Visits) -> Vec<Condition> {
    let condition = |target: &Target| {
        let visits = target.up_rad.iter().chain(&target.down_rad);
        let count = target.up_rad.len() + target.down_rad.len();
        let achieved = (count > 0).then(|| target.target_rad + visits.sum::<f64>() / count as f64);
        Condition { name: "target".to_owned(), requested: target.target_rad, achieved, kind: Q::Angle }
    };
    seen.by_encoder.iter().map(condition).collect()
}

fn of_targets(
    seen: &Visits,
    u_rad: f64,
    counts_rad: f64,
    case: &Case,
) -> Result<(Vec<Found>, Vec<Plot>), Reason> {
    let servo = positioning(&seen.by_encoder)?;
    let outside = seen.by_reference.as_ref().map_err(Clone::clone);
    let outside = outside.and_then(|all| positioning(all).map_err(Reason::from));
    let by_reference = |estimate: fn(&Positioning, f64) -> Estimate| -> Found {
        let found = outside.as_ref().map_err(Clone::clone)?;
        Ok((estimate(found, u_rad), vec![format!("reference U {:.1} urad (k = 2)", 2e6 * u_rad)]))
    };
    // What does not need an absolute place is had from the encoder where nothing better is there.
    let (best, instrument_rad, flag) = match &outside {
        Ok(found) => (found, SAME_FACE_RATIO * u_rad, "by the reference".to_owned()),
        Err(reason) => (&servo, counts_rad, format!("by the encoder: {reason}")),
    };
    let worst_reversal = best.repeatability(instrument_rad);
    let mean_range = |p: &Positioning, u: f64| Estimate { value: p.mean_range_rad, ..p.systematic(u) };
    let values = named(case).iter().map(|(name, _)| match *name {
        ACCURACY => by_reference(Positioning::accuracy),
        SYSTEMATIC => by_reference(Positioning::systematic),
        MEAN_RANGE => by_reference(mean_range),
        REPEATABILITY => Ok((best.repeatability(instrument_rad), vec![flag.clone()])),
        REVERSAL => Ok((Estimate { value: best.reversal_rad, ..worst_reversal }, vec![flag.clone()])),
        SERVO => Ok((
            servo.accuracy(counts_rad),
            vec!["encoder alone: not a statement about the true position of the axis".to_owned()],
        )),
        other => Err(PositionReason::NotMeasured { name: other.to_string() }.into()),
    });
    let values = values.collect();
    let mut plots = vec![picture(case, "servo-error", "Encoder less target", &seen.by_encoder, &servo)];
    if let (Ok(runs), Ok(found)) = (&seen.by_reference, &outside) {
        plots.insert(0, picture(case, "positioning", "Reference less target", runs, found));
    }
    Ok((values, plots))
}

/// The worst pose of each parameter.
fn of_poses(seen: &Visits, u_rad: f64, counts_rad: f64) -> Vec<Found> {
    let zero_rad = zero(seen);
    let worst = |targets: &[Target], u_rad: f64, zero_rad: f64, accuracy: bool| -> Found {
        let mut worst: Option<Estimate> = None;
        for target in targets {
            let off: Vec<f64> = target.up_rad.iter().map(|x| x - zero_rad).collect();
            let found = pose(target.target_rad, &off, u_rad)?;
            let one = if accuracy { found.accuracy } else { found.repeatability };
            if worst.is_none_or(|other| one.value > other.value) {
                worst = Some(one);
            }
        }
        let worst = worst.ok_or(PositionReason::NoPose)?;
        let flags = match worst.n {
            n if n < POSE_CYCLES => vec![format!("{n} cycles, but ISO 9283 requires {POSE_CYCLES}")],
            n => vec![format!("{n} cycles")],
        };
        Ok((worst, flags))
    };
    let accuracy = seen.by_reference.as_ref().map_err(Clone::clone);
    let accuracy = accuracy.and_then(|all| worst(all, u_rad, zero_rad, true));
    let repeatability = match &seen.by_reference {
        Ok(all) => worst(all, u_rad, 0.0, false),
        Err(reason) => worst(&seen.by_encoder, counts_rad, 0.0, false).map(|(estimate, mut flags)| {
            flags.push(format!("by the encoder: {reason}"));
            (estimate, flags)
        }),
    };
    vec![accuracy, repeatability]
}

/// Zero of the reference against the encoder: their difference at the first visit.
fn zero(seen: &Visits) -> f64 {
    let first = |all: &[Target]| all.first().and_then(|t| t.up_rad.first()).copied();
    let reference = seen.by_reference.as_ref().ok().and_then(|all| first(all));
    match (reference, first(&seen.by_encoder)) {
        (Some(reference), Some(encoder)) => reference - encoder,
        _ => 0.0,
    }
}

fn evidence(case: &Case, window: &Window, axes: &Axes) -> Vec<Evidence> {
    let axis = format!("/{}", case.axis);
    let times = window.rows(&axis).map(|rows| rows.time_s.as_slice());
    let Some((&[t0_s, ..], &[.., t1_s])) = times.map(|t| (t, t)) else { return Vec::new() };
    let mut channels = vec![format!("{axis} position_rad")];
    let place = axes.pair().iter().position(|own| own.is_some_and(|own| own.name == case.axis));
    if let Some(place) = place.filter(|_| window.rows(REFERENCE).is_some()) {
        channels.push(format!("{REFERENCE} deviation_{}_rad", MIRROR_AXES[place]));
    }
    vec![Evidence::new(channels, [t0_s, t1_s])]
}

const URAD: f64 = 1e6;

/// One picture; `runs` are the single deviations of which `found` was made.
fn picture(case: &Case, id: &str, title: &str, runs: &[Target], found: &Positioning) -> Plot {
    let mut series: Vec<Series> = Vec::new();
    for (label, upwards) in [("from below", true), ("from above", false)] {
        series.extend(direction(label, upwards, runs, found));
    }
    series.push(Series::new("mean of both", Style::Fit, degrees(found), over(found, |t| t.mean_rad)));
    series.extend(extent(found));
    let title = format!("{title}, {} (ISO 230-2): {}", case.axis, parameters(found));
    let plot = Plot::new(id, title, Scale::linear("target", "deg"), Scale::linear("deviation", "urad"));
    Plot { series, notes: widest(found).into_iter().collect(), ..plot }
}

fn degrees(found: &Positioning) -> Vec<f64> {
    found.targets.iter().map(|t| Q::Angle.to_display(t.target_rad)).collect()
}

fn over(found: &Positioning, value: impl Fn(&AtTarget) -> f64) -> Vec<f64> {
    found.targets.iter().map(|t| URAD * value(t)).collect()
}

/// Two standard deviations around the means of a direction, the means, and the single deviations.
fn direction(label: &str, upwards: bool, runs: &[Target], found: &Positioning) -> [Series; 3] {
    let direction = |t: &AtTarget| -> Direction { if upwards { t.up } else { t.down } };
    let mean = over(found, |t| direction(t).mean_rad);
    let spread = over(found, |t| 2.0 * direction(t).deviation_rad);
    let single = |t: &Target| -> Vec<(f64, f64)> {
        let all = if upwards { &t.up_rad } else { &t.down_rad };
        all.iter().map(|d| (Q::Angle.to_display(t.target_rad), URAD * d)).collect()
    };
    let (x, y) = runs.iter().flat_map(single).unzip();
    [
        Series::new(format!("{label}, mean ± 2 s"), Style::Band, degrees(found), mean.clone()).with_u(spread),
        Series::new(format!("{label}, mean"), Style::Line, degrees(found), mean),
        Series::new(format!("{label}, each run"), Style::Markers, x, y),
    ]
}

/// Both ends of the accuracy A: the largest mean + 2s and the smallest mean − 2s.
fn extent(found: &Positioning) -> [Series; 2] {
    let ways = || found.targets.iter().flat_map(|t| [t.up, t.down]);
    let high = ways().map(|d| d.mean_rad + 2.0 * d.deviation_rad).fold(f64::NEG_INFINITY, f64::max);
    let low = ways().map(|d| d.mean_rad - 2.0 * d.deviation_rad).fold(f64::INFINITY, f64::min);
    let x = degrees(found);
    let ends = [x.first().copied().unwrap_or(0.0), x.last().copied().unwrap_or(0.0)];
    [high, low].map(|at| {
        let label = format!("A = {:.1} µrad, from end to end", URAD * found.accuracy_rad);
        Series::new(label, Style::Fit, ends.into(), vec![URAD * at; 2])
    })
}

fn parameters(found: &Positioning) -> String {
    let all = [
        ("A", found.accuracy_rad),
        ("R", found.repeatability_rad),
        ("E", found.systematic_rad),
        ("M", found.mean_range_rad),
        ("B", found.reversal_rad),
    ];
    all.map(|(name, rad)| format!("{name} {:.1}", URAD * rad)).join(", ") + " µrad"
}

/// Names the target whose bidirectional repeatability is the axis' R.
fn widest(found: &Positioning) -> Option<Note> {
    let worst = found.targets.iter().max_by(|a, b| a.repeatability_rad.total_cmp(&b.repeatability_rad))?;
    let label = format!("R {:.1} µrad", URAD * worst.repeatability_rad);
    Some(Note { label, at: [Q::Angle.to_display(worst.target_rad), URAD * worst.mean_rad] })
}
