//! Over all points: numbers per axis, faults in plain sentences, and what they prove.

use analysis::estimate::Estimate;
use analysis::goodness::BY_SCATTER;
use analysis::uncertainty::{Component, combine};

use super::plan::{PULSES, RAMPS};
use super::record::{Record, Seen, direction, evidence};
use crate::axis::Axes;
use crate::case::Case;
use crate::measurement::{Conclusion, Condition, Measurement, PointResult, Proof};
use crate::quantity::QuantityKind as Q;

const ESTIMATOR: &str = "polarity/4";

/// Inertia that the pulses show, if the torque constant of the rig file holds.
pub(super) const SMALL_MOTION_INERTIA: &str = "small-motion-inertia";

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
    /// Torque that acts over torque that is reported, by encoder and by gyros.
    pub(super) scale: Option<Estimate>,
    pub(super) scale_by_gyro: Option<Estimate>,
    /// Why some of it was not run to its end.
    pub(super) unfinished: Option<String>,
    /// Where its encoder says that it is at rest, and where the plan wants it; then the same of the other axis.
    pub(super) rest: Option<[f64; 2]>,
    pub(super) other_rest: Option<[f64; 2]>,
    /// How far the two may be apart.
    pub(super) zero_tolerance_rad: f64,
    /// Relative standard uncertainty of the torque constant in the rig file.
    pub(super) constant_u_ratio: f64,
    /// Inertia in the rig file.
    pub(super) inertia_kg_m2: f64,
    /// Elevation of the plan, for an axis of a gimbal.
    pub(super) elevation_rad: Option<f64>,
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

    /// Expanded uncertainty of a torque scale that the axis may have, with that of the torque constant in the rig file.
    fn scale_expanded_u(&self, scale: Estimate) -> f64 {
        COVERAGE * scale.u.hypot(self.constant_u_ratio * scale.value)
    }

    /// The torque scale, if its sign is beyond doubt. Under a load a contact creeps, which can hide what the pulses do, but nothing
    /// creeps as fast as the periodic torque.
    fn proven_scale(&self) -> Option<Estimate> {
        self.scale.filter(|scale| scale.value.abs() > SIGNIFICANT * scale.u)
    }

    /// Inertia by the encoder. Over motions of a few tens of microradians play and errors of the encoder count, which the gyros do not
    /// have: what both differ by is the half-width of a rectangular distribution.
    fn inertia(&self) -> Option<Estimate> {
        let by_encoder = inverse(self.scale?, self.inertia_kg_m2)?;
        let by_gyro = self.scale_by_gyro.and_then(|scale| inverse(scale, self.inertia_kg_m2));
        let apart = by_gyro.map_or(0.0, |gyro| (gyro.value - by_encoder.value).abs());
        let own = Component { u: by_encoder.u, dof: by_encoder.dof };
        let spread = combine(&[own, Component::rectangular(apart)]);
        Some(Estimate { u: spread.u, dof: spread.dof, ..by_encoder })
    }

    /// Whether a torque scale is beyond what is allowed.
    fn is_off(&self, scale: Estimate) -> bool {
        (scale.value.abs() - 1.0).abs() > TORQUE_RATIO + self.scale_expanded_u(scale)
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
                "{name} did not move by 1.5 z_ss up to the torque limit of this check: its scales are not proven beyond the \
                 pulses."
            ));
        }
        if !axis.has_gyro {
            conclusion.remarks.push(format!(
                "No gyro measures {name}: its signs and torque scale are proven by its encoder alone, its \
                 counts per turn are not."
            ));
        }
        all.extend(faults(&axis));
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
        constant_u_ratio: axes.get(name).map_or(0.0, |limits| limits.torque_constant_u_ratio),
        inertia_kg_m2: axes.get(name).map_or(0.0, |limits| limits.inertia_kg_m2),
        elevation_rad: axes.gimbal_index(name).map(|_| elevation_rad(pulses, axes)),
        scale: seen(pulses).and_then(|seen| seen.scale),
        scale_by_gyro: seen(pulses).and_then(|seen| seen.scale_by_gyro),
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
        (SMALL_MOTION_INERTIA, axis.inertia(), pulses),
    ];
    rows.into_iter()
        .map(|(measurand, value, point)| {
            let kind = if measurand == SMALL_MOTION_INERTIA { Q::Inertia } else { Q::Ratio };
            let mut m = match value {
                Some(_) => Measurement {
                    flags: vec![BY_SCATTER.to_owned()],
                    ..Measurement::new(measurand, &axis.name, kind, value, ESTIMATOR)
                },
                None => {
                    let reason = axis.why(if axis.has_gyro {
                        "nothing could be evaluated"
                    } else {
                        "no gyro measures this axis"
                    });
                    Measurement::inconclusive(measurand, &axis.name, kind, ESTIMATOR, reason)
                }
            };
            if measurand == SMALL_MOTION_INERTIA {
                m.conditions.extend(axis.elevation_rad.map(at_elevation));
            }
            m.point = point.map(|(case, _)| case.point.clone());
            m.evidence = point.map_or(Vec::new(), |(_, result)| evidence(&axis.name, axis.has_gyro, result));
            m
        })
        .collect()
}

/// The pose at which an inertia was measured.
fn at_elevation(planned_rad: f64) -> Condition {
    Condition { name: "elevation".to_owned(), requested: planned_rad, achieved: None, kind: Q::Angle }
}

/// Something over an estimate; `None` for one that is no positive number.
fn inverse(estimate: Estimate, numerator: f64) -> Option<Estimate> {
    let value = numerator / estimate.value;
    let u = value * estimate.u / estimate.value;
    (value.is_finite() && value > 0.0).then_some(Estimate { value, u, ..estimate })
}

/// Displacement over what is expected; friction of any size stays inside, a factor of ten does not.
const PRESLIDING: [f64; 2] = [0.25, 4.0];
/// Counts per turn against the gyro integral.
const TURN_RATIO: f64 = 0.02;
/// Torque against inertia and acceleration.
const TORQUE_RATIO: f64 = 0.2;
/// The motion is about the axis that is meant, or about the other one.
const SAME: f64 = 0.9;
/// A number counts where it is this many standard uncertainties from zero.
const SIGNIFICANT: f64 = 5.0;
/// Coverage of expanded uncertainties.
const COVERAGE: f64 = 2.0;
/// Within this of an angle, an encoder shows that angle with a wrong sign or scale, or that of the other axis.
const LIKELY_RAD: f64 = 5.0 * std::f64::consts::TAU / 360.0;
/// Less of the expected displacement than this is none.
const STILL: f64 = 0.02;
/// Less of the motion than this is none.
const SILENT: f64 = 0.1;

/// Every fault of one axis, the cause first.
pub(super) fn faults(axis: &Axis) -> Vec<String> {
    let name = &axis.name;
    let Some(pulses) = &axis.pulses else {
        let unproven = format!("{name} is not proven: {}", axis.why("no pulse was evaluated"));
        return pose(axis).into_iter().chain([unproven]).collect();
    };
    let mut all = Vec::new();
    let moved = pulses.presliding;
    if moved.0.abs() < STILL {
        all.push(format!(
            "no response of {name}: its encoder shows {:.3} of the expected motion under torque; possible \
             causes: motor without current, brake or lock engaged, or encoder of another axis",
            moved.0.abs()
        ));
        return all;
    }
    let by_torque = axis.proven_scale().map_or(moved.0, |scale| scale.value);
    match &pulses.gyro {
        Some(gyro) => {
            if !motion(axis, gyro, &mut all) {
                return all;
            }
            if gyro.own.abs() >= SAME {
                let was_cut_short = axis.unfinished.is_some() && axis.proven_scale().is_none();
                all.extend(sign(name, by_torque, gyro.own, was_cut_short));
            }
        }
        None => all.extend(sign_by_encoder(name, by_torque)),
    }
    match small_motions(axis) {
        Some(fault) => all.push(fault),
        None => {
            let miscounts = turns(axis, &mut all);
            scale(axis, moved, if miscounts { axis.turned() } else { 1.0 }, &mut all);
        }
    }
    if all.is_empty() {
        all.extend(pose(axis));
    }
    if let Some(unfinished) = &axis.unfinished {
        all.push(format!("{name} is not proven: {unfinished}"));
    }
    all
}

/// Whether the gyros see the motion about the axis that is meant; false where axes are swapped, which explains all else.
fn motion(axis: &Axis, gyro: &ByGyro, all: &mut Vec<String>) -> bool {
    let name = &axis.name;
    let own = gyro.own;
    let other = gyro.other;
    if gyro.size.0 < SILENT || gyro.size.0 < SIGNIFICANT * gyro.size.1 {
        all.push(format!(
            "gyros silent on {name}: they show {:.2} of the motion of its encoder, expected 1",
            gyro.size.0
        ));
    } else if other.abs() > SAME && own.abs() < 1.0 - SAME {
        all.push(format!(
            "axes swapped: torque on {name} turns {} (gyros see {:.2} of the motion about it, expected 0); \
             motor and encoder cables of the two drives exchanged",
            axis.other,
            other.abs()
        ));
        return false;
    } else if own.abs() < SAME {
        all.push(format!(
            "gyro mounting: motion of {name} appears along [{:.2}, {:.2}, {:.2}] (left, up, ahead), \
             expected [{:.2}, {:.2}, {:.2}]; sign of one gyro or mounting angle wrong, or {name} not at \
             the pose of the plan",
            gyro.along[0], gyro.along[1], gyro.along[2], axis.expected[0], axis.expected[1], axis.expected[2]
        ));
    }
    true
}

/// Without a gyro nobody can tell the sign of the torque from that of the encoder.
fn sign_by_encoder(name: &str, by_torque: f64) -> Option<String> {
    (by_torque < 0.0).then(|| {
        format!(
            "torque or encoder sign of {name}: the encoder moves against the torque (torque to encoder: \
             expected +, found -); motor phases exchanged, or the encoder mounted or configured the other \
             way round"
        )
    })
}

/// An encoder that is not where the plan wants its axis, before anything moves: gates refuse an angle outside the travel,
/// and then this is all there is.
fn pose(axis: &Axis) -> Option<String> {
    let [shown, wanted] = axis.rest?;
    let near = |a: f64, b: f64| (a - b).abs() <= LIKELY_RAD;
    if (shown - wanted).abs() <= axis.zero_tolerance_rad {
        return None;
    }
    let turn = std::f64::consts::TAU;
    let crossed = axis
        .other_rest
        .is_some_and(|[other_shown, other_wanted]| near(shown, other_wanted) && near(other_shown, wanted));
    let likely = if near(shown, wanted) {
        format!("encoder zero of {}: ", axis.name)
    } else if crossed {
        "axes swapped: ".to_owned()
    } else if near(shown, -wanted) {
        format!("encoder sign of {}: ", axis.name)
    } else if near(shown, wanted.rem_euclid(turn) / 2.0) {
        format!("encoder modulus of {}: ", axis.name)
    } else {
        format!("pose of {}: ", axis.name)
    };
    Some(format!(
        "{likely}at rest the encoder of {} shows {}, but the plan expects {} within {} (`zero-tolerance`); \
         sign, zero, counts per turn or cabling of the encoder wrong, or the axis was not brought to that \
         pose",
        axis.name,
        Q::Angle.format(shown),
        Q::Angle.format(wanted),
        Q::Angle.format(axis.zero_tolerance_rad)
    ))
}

/// Which of the three is the odd one out. Pulses that were cut short cannot tell a torque of the wrong sign from a load.
fn sign(name: &str, by_torque: f64, by_gyro: f64, was_cut_short: bool) -> Option<String> {
    let [torque_encoder, encoder_gyro] = [by_torque, by_gyro].map(|v| if v > 0.0 { "+" } else { "-" });
    let (what, why) = match (torque_encoder, encoder_gyro) {
        ("+", "+") => return None,
        ("-", "+") if was_cut_short => (
            "torque sign or load",
            "it moved against the torque until the check was cut short: motor phases exchanged, or a load that friction hardly \
             holds at this pose (look for the load, or choose a pose where it is less)",
        ),
        ("-", "+") => ("torque sign", "encoder and gyro agree but oppose the torque: motor phases exchanged"),
        ("-", _) => (
            "encoder sign",
            "the encoder opposes torque and gyro: it is mounted or configured the other way round",
        ),
        _ => {
            ("gyro sign", "the gyro opposes torque and encoder: wrong sign or mounting of the inertial unit")
        }
    };
    Some(format!(
        "{what} of {name}: {why} (torque to encoder: expected +, found {torque_encoder}; encoder to gyro: expected +, \
         found {encoder_gyro})"
    ))
}

/// Whether gyro and encoder disagree on the angle.
fn turns(axis: &Axis, all: &mut Vec<String>) -> bool {
    let Some((ratio, u)) = axis.best_size() else { return false };
    let wrong = (ratio - 1.0).abs() > TURN_RATIO + COVERAGE * u && ratio > SILENT;
    if wrong {
        all.push(format!(
            "encoder modulus of {}: the gyros show {ratio:.3} times the angle of the encoder (expected 1 \
             within {TURN_RATIO}); the real counts per turn are {:.3} of the value in the drive (608Fh)",
            axis.name,
            1.0 / ratio
        ));
    }
    wrong
}

/// Torque scale by inertia, or by presliding where nothing is known of that; `turned` makes true angles of encoder angles.
fn scale(axis: &Axis, moved: (f64, f64), turned: f64, all: &mut Vec<String>) {
    let name = &axis.name;
    let ratio = moved.0.abs() * turned;
    if axis.proven_scale().is_none() && !(PRESLIDING[0]..=PRESLIDING[1]).contains(&ratio) {
        all.push(format!(
            "torque scale of {name}: a small torque moves the axis {ratio:.2} times as far as its \
             presliding stiffness allows (expected {} to {}); wrong torque constant or scaling of the \
             drive (6075h, 6076h)",
            PRESLIDING[0], PRESLIDING[1]
        ));
        return;
    }
    let Some(found) = axis.scale.map(|scale| times(scale, turned)) else { return };
    if axis.is_off(found) {
        all.push(format!(
            "torque scale of {name}: the axis accelerates as if {:.2} of the reported torque acted on it \
             (expected 1 within {TORQUE_RATIO}, U = {:.2}); wrong torque constant, scaling of the drive \
             (6075h, 6076h) or inertia",
            found.value.abs(),
            axis.scale_expanded_u(found)
        ));
    }
}

/// An estimate of something that is so many times as large.
fn times(estimate: Estimate, factor: f64) -> Estimate {
    Estimate { value: factor * estimate.value, u: (factor * estimate.u).abs(), ..estimate }
}

/// An encoder that errs over small motions: by the gyros the torque scale is right, by the encoder it is not, counts per
/// turn considered.
fn small_motions(axis: &Axis) -> Option<String> {
    let encoder = times(axis.scale?, axis.turned());
    let gyros = axis.scale_by_gyro?;
    // Too little motion leaves the gyros as uncertain as the encoder: then the torque may be at fault.
    let is_proven = (gyros.value.abs() - 1.0).abs() + axis.scale_expanded_u(gyros) <= TORQUE_RATIO;
    (axis.is_off(encoder) && is_proven).then(|| {
        format!(
            "encoder of {}: by its encoder the axis accelerates as if {:.2} of the reported torque acted on \
             it, by the gyros as if {:.2} did (expected 1 within {TORQUE_RATIO}, U = {:.2}); the encoder \
             is wrong over small motions: play of its coupling, interpolation within its pitches, signal \
             levels or mounting of the head",
            axis.name,
            encoder.value.abs(),
            gyros.value.abs(),
            axis.scale_expanded_u(encoder)
        )
    })
}
