//! One point: parameters of the standards from its visits.

use analysis::estimate::Estimate;
use analysis::positioning::{POSE_CYCLES, Positioning, Target, pose, positioning};

use super::keys::Keys;
use super::pictures::picture;
use super::plan::POSES;
use super::visits::{REFERENCE, Visits, visits};
use super::{ACCURACY, MEAN_RANGE, REPEATABILITY, REVERSAL, SERVO, SYSTEMATIC, named};
use crate::axis::Axes;
use crate::case::Case;
use crate::device::MIRROR_AXES;
use crate::log::Window;
use crate::measurement::{Evidence, Measurement, PointResult};
use crate::trace::Plot;

pub(super) const ESTIMATOR: &str = "positioning/1";
/// What a mean of the encoder leaves uncertain of a place: a count.
const ENCODER_COUNTS: f64 = 1.0;
/// What the autocollimator leaves uncertain from run to run at one face, as a part of its whole uncertainty: the table is
/// the same in every run.
const SAME_FACE_RATIO: f64 = 0.3;

type Found = Result<(Estimate, Vec<String>), String>;

pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> Result<PointResult, String> {
    let limits = axes.limits(&case.axis)?;
    let poses = keys.poses_rad.as_deref().filter(|_| case.point == POSES);
    let seen = visits(keys, poses.unwrap_or(&keys.targets_rad), case, window, axes)?;
    let u_rad = limits.reference.as_ref().map_or(0.0, |r| r.u_rad);
    let counts_rad = ENCODER_COUNTS * limits.encoder_quantum_rad;
    let (values, plots) = match poses {
        Some(_) => (of_poses(&seen, u_rad, counts_rad), Vec::new()),
        None => of_targets(&seen, u_rad, counts_rad, case)?,
    };
    let evidence = evidence(case, window, axes);
    let measured = named(case).iter().zip(values).map(|((name, kind), found)| {
        let base = match found {
            Ok((estimate, flags)) => {
                Measurement { flags, ..Measurement::new(name, &case.axis, *kind, Some(estimate), ESTIMATOR) }
            }
            Err(reason) => Measurement::inconclusive(name, &case.axis, *kind, ESTIMATOR, reason),
        };
        Measurement { point: Some(case.point.clone()), evidence: evidence.clone(), ..base }
    });
    Ok(PointResult {
        point: case.point.clone(),
        measurements: measured.collect(),
        plots,
        ..PointResult::default()
    })
}

fn of_targets(
    seen: &Visits,
    u_rad: f64,
    counts_rad: f64,
    case: &Case,
) -> Result<(Vec<Found>, Vec<Plot>), String> {
    let servo = positioning(&seen.by_encoder).map_err(|e| e.to_string())?;
    let outside = seen.by_reference.as_ref().map_err(Clone::clone);
    let outside = outside.and_then(|all| positioning(all).map_err(|e| e.to_string()));
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
            vec!["encoder alone: no statement of where the axis is".to_owned()],
        )),
        other => Err(format!("{other} is not measured here")),
    });
    let values = values.collect();
    let mut plots = vec![picture(case, ("servo-error", "Encoder less target"), &seen.by_encoder, &servo)];
    if let (Ok(runs), Ok(found)) = (&seen.by_reference, &outside) {
        plots.insert(0, picture(case, ("positioning", "Reference less target"), runs, found));
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
            let found = pose(target.target_rad, &off, u_rad).map_err(|e| e.to_string())?;
            let one = if accuracy { found.accuracy } else { found.repeatability };
            if worst.is_none_or(|other| one.value > other.value) {
                worst = Some(one);
            }
        }
        let worst = worst.ok_or("no pose was recorded")?;
        let flags = match worst.n {
            n if n < POSE_CYCLES => vec![format!("{n} cycles, ISO 9283 asks for {POSE_CYCLES}")],
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
