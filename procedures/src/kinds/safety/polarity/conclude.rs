//! Over all points: numbers per axis, and what they prove.

use analysis::estimate::Estimate;

use super::faults;
use super::plan::{PULSES, RAMPS};
use super::record::{Record, Seen, direction, evidence};
use crate::axis::Axes;
use crate::case::Case;
use crate::measurement::{Conclusion, Measurement, PointResult, Proof};
use crate::quantity::QuantityKind as Q;

const ESTIMATOR: &str = "polarity/1";

/// What the pulses or the ramps of an axis say.
#[derive(Clone, Debug)]
pub(super) struct Stage {
    /// Displacement over expected displacement, signed, with u.
    pub(super) presliding: (f64, f64),
    /// What the gyros say; `None` for an axis that no gyro sees.
    pub(super) gyro: Option<ByGyro>,
    n: usize,
}

/// What the gyros say of the pulses or the ramps of an axis.
#[derive(Clone, Debug)]
pub(super) struct ByGyro {
    /// Gyro angle over encoder angle, with u.
    pub(super) size: (f64, f64),
    /// Response of the gyros along left, up, ahead.
    pub(super) along: [f64; 3],
    /// Share of it about the axis itself, and about the other one.
    pub(super) own: f64,
    pub(super) other: f64,
}

/// All about one axis.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub(super) name: String,
    pub(super) other: String,
    /// Direction of its rate along left, up, ahead.
    pub(super) expected: [f64; 3],
    pub(super) pulses: Option<Stage>,
    pub(super) ramps: Option<Stage>,
    /// Torque that acts over torque that is reported.
    pub(super) scale: Option<Estimate>,
    /// Why some of it was not run to its end.
    pub(super) unfinished: Option<String>,
    /// Where its encoder says that it is at rest, and where the plan wants it; then the same of the other axis.
    pub(super) rest: Option<[f64; 2]>,
    pub(super) other_rest: Option<[f64; 2]>,
    /// How far the two may be apart.
    pub(super) zero_tolerance_rad: f64,
    unbroken: bool,
    /// Whether the inertial unit sees its rate.
    pub(super) has_gyro: bool,
}

impl Axis {
    /// Gyro angle over encoder angle where it is known best.
    pub(super) fn best_size(&self) -> Option<(f64, f64)> {
        let both = [&self.ramps, &self.pulses].into_iter().flatten();
        let both = both.filter_map(|stage| stage.gyro.as_ref()).map(|gyro| gyro.size);
        both.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Gyro angle over encoder angle where it is known best; 1 where it is unknown.
    pub(super) fn turned(&self) -> f64 {
        self.best_size().map_or(1.0, |size| size.0)
    }

    /// The reason why it was not finished, or this.
    pub(super) fn why(&self, otherwise: &str) -> String {
        self.unfinished.clone().unwrap_or_else(|| otherwise.to_owned())
    }
}

/// Numbers and proof.
pub(super) fn conclude(cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
    let mut conclusion = Conclusion::default();
    let mut all = Vec::new();
    for name in axes.names() {
        let point_of = |stage: &str| {
            let point = format!("{name} {stage}");
            cases.iter().zip(points).find(|(case, _)| case.point == point)
        };
        let rest = |axis: &str| cases.iter().zip(points).find_map(|(case, point)| rest(axis, case, point));
        let mut axis = axis(name, point_of(PULSES), point_of(RAMPS), axes);
        (axis.rest, axis.other_rest) = (rest(name), rest(&axis.other));
        conclusion.measurements.extend(measurements(&axis, point_of(PULSES), point_of(RAMPS)));
        if axis.unbroken {
            conclusion.remarks.push(format!(
                "{name} did not move by 1.5 z_ss up to the torque limit point_of this check: its scales are not proven beyond the \
                 pulses."
            ));
        }
        if !axis.has_gyro {
            conclusion.remarks.push(format!(
                "No gyro sees {name}: its signs and its torque scale are proven by its encoder alone, counts per turn are not."
            ));
        }
        all.extend(faults::faults(&axis));
    }
    // What was found comes before what was not looked at.
    all.sort_by_key(|fault| fault.contains(" is not proven: "));
    conclusion.proof = Some(Proof { gate: "polarity".to_owned(), faults: all });
    conclusion
}

type Point<'a> = Option<(&'a Case, &'a PointResult)>;

fn axis(name: &str, pulses: Point<'_>, ramps: Point<'_>, axes: &Axes) -> Axis {
    let other = axes.gimbal().ok().and_then(|gimbal| gimbal.other(name));
    let other = other.unwrap_or("no other axis").to_owned();
    Axis {
        name: name.to_owned(),
        expected: direction(is_elevation(name, axes), elevation_rad(pulses, axes)),
        pulses: stage(name, &other, pulses, axes),
        ramps: stage(name, &other, ramps, axes),
        other,
        rest: None,
        other_rest: None,
        zero_tolerance_rad: axes.get(name).map_or(0.0, |limits| limits.zero_tolerance_rad),
        scale: seen(pulses).and_then(|seen| seen.scale),
        unfinished: [(PULSES, pulses), (RAMPS, ramps)]
            .into_iter()
            .find_map(|(stage, p)| unfinished(stage, p)),
        unbroken: seen(ramps).is_some_and(|seen| seen.is_unbroken),
        has_gyro: axes.gimbal_index(name).is_some(),
    }
}

/// What was seen of the torque of a point.
fn seen(point: Point<'_>) -> Option<&Seen> {
    point.and_then(|(_, result)| result.reduced.get::<Record>()?.seen.as_ref())
}

fn rest(axis: &str, case: &Case, result: &PointResult) -> Option<[f64; 2]> {
    let shown_rad = *result.reduced.get::<Record>()?.at_rest_rad.get(axis)?;
    Some([shown_rad, *case.start_pose_rad.get(axis)?])
}

fn unfinished(stage: &str, point: Point<'_>) -> Option<String> {
    match point {
        None => Some(format!("its {stage} were not run")),
        Some((_, result)) => result.inconclusive.as_ref().map(|reason| format!("{stage}: {reason}")),
    }
}

/// Elevation that was planned: the encoder of elevation is on trial itself.
fn elevation_rad(point: Point<'_>, axes: &Axes) -> f64 {
    let inner = axes.gimbal().ok().map(|gimbal| gimbal.inner.name.as_str());
    point.and_then(|(case, _)| case.start_pose_rad.get(inner?).copied()).unwrap_or(0.0)
}

fn is_elevation(name: &str, axes: &Axes) -> bool {
    axes.gimbal_index(name) == Some(1)
}

fn stage(name: &str, other: &str, point: Point<'_>, axes: &Axes) -> Option<Stage> {
    let seen = seen(point)?;
    let stiffness = axes.get(name)?.expected_presliding_stiffness_nm_per_rad;
    let presliding = (seen.compliance.value * stiffness, seen.compliance.u * stiffness);
    let Some(gyro) = &seen.gyro else { return Some(Stage { presliding, gyro: None, n: seen.rows }) };
    let elevation = elevation_rad(point, axes);
    let by_gyro = ByGyro {
        size: (gyro.size(), gyro.size_u()),
        along: gyro.along,
        own: gyro.alignment(direction(is_elevation(name, axes), elevation)),
        other: gyro.alignment(direction(is_elevation(other, axes), elevation)),
    };
    Some(Stage { presliding, gyro: Some(by_gyro), n: gyro.n })
}

fn measurements(axis: &Axis, pulses: Point<'_>, ramps: Point<'_>) -> Vec<Measurement> {
    let estimate = |(value, u): (f64, f64), n: usize| Estimate { value, u, dof: (n.max(3) - 2) as f64, n };
    let best = if axis.ramps.is_some() { ramps } else { pulses };
    let seen = axis.ramps.as_ref().or(axis.pulses.as_ref());
    let seen = seen.and_then(|stage| Some((stage.gyro.as_ref()?, stage.n)));
    let rows = [
        ("presliding-ratio", axis.pulses.as_ref().map(|s| estimate(s.presliding, s.n)), pulses),
        ("gyro-encoder-ratio", seen.map(|(s, n)| estimate((s.size.0.copysign(s.own), s.size.1), n)), best),
        ("gyro-cross-ratio", seen.map(|(s, n)| estimate((s.other, s.size.1 / s.size.0.max(0.1)), n)), best),
        ("torque-scale-ratio", axis.scale, pulses),
    ];
    rows.into_iter()
        .map(|(measurand, value, point)| {
            let mut m = match value {
                Some(_) => Measurement::new(measurand, &axis.name, Q::Ratio, value, ESTIMATOR),
                None => {
                    let reason = axis.why(if axis.has_gyro {
                        "nothing could be evaluated"
                    } else {
                        "no gyro sees this axis"
                    });
                    Measurement::inconclusive(measurand, &axis.name, Q::Ratio, ESTIMATOR, reason)
                }
            };
            m.point = point.map(|(case, _)| case.point.clone());
            m.evidence = point.map_or(Vec::new(), |(_, result)| evidence(&axis.name, axis.has_gyro, result));
            m
        })
        .collect()
}
