//! Points: every move ends where the rig allows it to end, whether a limit holds or not.

use std::f64::consts::PI;

use super::keys::{Keys, Stage};
use crate::axis::{Axes, AxisLimits};
use crate::case::{Case, Condition, Fence, Mode, Request, Segment, Then, Zone};
use crate::diagnostic::Diagnostic;
use crate::kinds::position::positioned::limits_of;
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{ProfileLimits, Stimulus};

const DEG: f64 = PI / 180.0;

/// Label of the rest at an end.
pub(super) const LOW_END: &str = "low end";
pub(super) const HIGH_END: &str = "high end";
/// Label of the segment that is ordered past a limit.
pub(super) const PAST: &str = "past the limit";
/// Point in which the same move passes beside the zone.
pub(super) const BESIDE: &str = "beside";

/// Moves inside the soft limits stay this far from them.
const CLEARANCE_RAD: f64 = 0.5 * DEG;
/// Rate beyond the rig's own soft limits, and of the slow approaches to a fence.
const SLOW_RAD_PER_S: f64 = DEG;
/// The last stretch before an end of the travel, at a rate that every interlock takes for rest. They do so up to 1e-3 rad/s, and an
/// encoder of 26 bits counts in steps of 94 urad/s within a millisecond: 7 or 8 of them are driven, 11 would trip, because a
/// single tick above needs more room than is left.
const CRAWL_RAD: f64 = 0.1 * DEG;
const CRAWL_RAD_PER_S: f64 = 0.04 * DEG;
/// The axis is sent to an end less this: what it overshoots by in the crawl, and the noise of its encoder, would trip the limit
/// that stands at the end itself. A third of what MOT-RNG allows.
const END_ROOM_RAD: f64 = 25e-6;
/// Rest at an end.
const REST_S: f64 = 1.0;
/// A slow approach begins this far from its limit.
const NEAR_RAD: f64 = 3.0 * DEG;
/// A fast one begins this far inside the opposite limit.
const INSIDE_RAD: f64 = 2.0 * DEG;
/// A velocity leads this far past a drive's limit, slow and fast, before the bench stops the axis.
const LED_PAST_RAD: [f64; 2] = [DEG, 5.0 * DEG];
/// Time that a drive has for the last degrees.
const APPROACH_S: f64 = 4.0;
/// Share of the largest acceleration.
const ACCELERATION_SHARE: f64 = 0.9;
/// The other axis' part of a zone, to either side of where that axis stands; and where it stands beside the zone.
const ZONE_HALF_RAD: f64 = 10.0 * DEG;
const BESIDE_RAD: f64 = 20.0 * DEG;
/// Beyond the profile's own duration a segment may last this much longer.
const SPARE_S: f64 = 0.5;

/// The points of an axis.
pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    let limits = limits_of(axis, axes)?;
    let [low, high] = limits.soft_limits_rad;
    let [from, to] = keys.fence_rad;
    if from - keys.beyond_rad < low || to + keys.beyond_rad > high || to - from < 2.0 * NEAR_RAD {
        let message = format!(
            "`fence` {} .. {} with `beyond` {} does not fit into the soft limits {} .. {} of axis `{axis}`",
            Q::Angle.format(from),
            Q::Angle.format(to),
            Q::Angle.format(keys.beyond_rad),
            Q::Angle.format(low),
            Q::Angle.format(high)
        );
        return Err(vec![
            Diagnostic::new(message)
                .help("a move past a limit of the point must end where the rig allows it"),
        ]);
    }
    let pair = axes.gimbal().ok().and_then(|gimbal| {
        let own = gimbal.index_of(axis)?;
        Some(Pair { own, other: gimbal.other(axis)? })
    });
    if pair.is_none() && keys.stages.contains(&Stage::Zone) {
        let message =
            format!("a restricted zone needs two axes, one carrying the other; axis `{axis}` has none");
        return Err(vec![Diagnostic::new(message).help("leave `zone` out of `points`")]);
    }
    let planner = Planner { keys, axis, limits, axes, pair };
    Ok(keys.stages.iter().flat_map(|stage| planner.points(*stage)).collect())
}

struct Planner<'a> {
    keys: &'a Keys,
    axis: &'a str,
    limits: &'a AxisLimits,
    axes: &'a Axes,
    /// The axis in its gimbal; `None` without one.
    pair: Option<Pair<'a>>,
}

/// An axis of a gimbal and the other one.
#[derive(Clone, Copy)]
struct Pair<'a> {
    /// Index of the axis in pairs of azimuth and elevation.
    own: usize,
    other: &'a str,
}

impl Planner<'_> {
    fn points(&self, stage: Stage) -> Vec<Case> {
        let speeds = [SLOW_RAD_PER_S, self.keys.full_rad_per_s];
        let approaches = || speeds.into_iter().flat_map(|speed| [speed, -speed]);
        match stage {
            Stage::Ends => vec![self.ends()],
            Stage::FullSpeed => vec![self.full_speed()],
            Stage::SoftBench => approaches().map(|rate| self.soft_bench(rate)).collect(),
            Stage::SoftDrive => approaches().map(|rate| self.soft_drive(rate)).collect(),
            Stage::Zone => {
                let Some(pair) = self.pair else { return Vec::new() };
                let into = speeds.map(|rate| self.zone(pair, rate, false));
                into.into_iter().chain([self.zone(pair, self.keys.full_rad_per_s, true)]).collect()
            }
        }
    }

    /// A point that begins at rest somewhere.
    fn case(&self, point: String, start_rad: f64, segments: Vec<Segment>) -> Case {
        let mut start_pose_rad = self.axes.pose(|axis| rest_rad(&axis.limits));
        start_pose_rad.insert(self.axis.to_owned(), start_rad);
        Case { point, axis: self.axis.to_owned(), start_pose_rad, segments, ..Case::default() }
    }

    fn profile(&self, velocity_rad_per_s: f64) -> ProfileLimits {
        let limits = self.limits;
        ProfileLimits {
            velocity_rad_per_s,
            // Slow moves need no more than a tenth of a second to their rate.
            acceleration_rad_per_s2: (ACCELERATION_SHARE * limits.max_acceleration_rad_per_s2)
                .min(10.0 * velocity_rad_per_s),
            jerk_rad_per_s3: limits.max_jerk_rad_per_s3.min(100.0 * velocity_rad_per_s),
        }
    }

    fn go(&self, label: &str, from_rad: f64, target_rad: f64, rate: f64) -> Segment {
        let stimulus = Stimulus::Move { target_rad, limits: self.profile(rate) };
        let at_most_s = stimulus.duration_s(from_rad).unwrap_or(0.0) + SPARE_S;
        Segment { stimulus, ..Segment::hold(label, Mode::Position, at_most_s) }
    }

    /// From end to end of the travel.
    fn ends(&self) -> Case {
        let ([low, high], travel) = (self.limits.soft_limits_rad, self.limits.travel_rad);
        let inside = [low + CLEARANCE_RAD, high - CLEARANCE_RAD];
        let start_rad = rest_rad(self.limits);
        let mut here = start_rad;
        let mut segments = Vec::new();
        for (end, label, inward) in [(0, LOW_END, 1.0), (1, HIGH_END, -1.0)] {
            let slow = SLOW_RAD_PER_S.min(self.keys.creep_rad_per_s);
            let near = travel[end] + inward * CRAWL_RAD;
            let target = travel[end] + inward * END_ROOM_RAD;
            segments.extend([
                self.go("creep", here, inside[end], self.keys.creep_rad_per_s),
                self.go("slow", inside[end], near, slow),
                self.go("crawl", near, target, CRAWL_RAD_PER_S),
                Segment::hold(label, Mode::Position, REST_S),
                self.go("back", target, inside[end], slow),
            ]);
            here = inside[end];
        }
        stop_after_last(&mut segments);
        let fence = Fence { bench_rad: [(self.axis.to_owned(), travel)].into(), ..Fence::default() };
        Case { fence: Some(fence), ..self.case(Stage::Ends.name().to_owned(), start_rad, segments) }
    }

    /// Between the rig's soft limits.
    fn full_speed(&self) -> Case {
        let [low, high] = self.limits.soft_limits_rad;
        let from = low + CLEARANCE_RAD;
        let to = high - CLEARANCE_RAD;
        let rate = self.keys.full_rad_per_s;
        let mut segments = vec![
            self.go("out", from, to, rate),
            Segment::hold(HIGH_END, Mode::Position, REST_S),
            self.go("home", to, from, rate),
            Segment::hold(LOW_END, Mode::Position, REST_S),
        ];
        stop_after_last(&mut segments);
        let case = self.case(Stage::FullSpeed.name().to_owned(), from, segments);
        Case { requested: vec![requested(rate)], ..case }
    }

    /// Where an approach at a signed rate begins, the limit that it goes to, and its direction.
    fn approach(&self, rate: f64) -> (f64, f64, f64) {
        let [low, high] = self.keys.fence_rad;
        let (limit, opposite, ahead) = if rate > 0.0 { (high, low, 1.0) } else { (low, high, -1.0) };
        let slow = rate.abs() <= SLOW_RAD_PER_S;
        (if slow { limit - ahead * NEAR_RAD } else { opposite + ahead * INSIDE_RAD }, limit, ahead)
    }

    fn soft_bench(&self, rate: f64) -> Case {
        let (start_rad, limit_rad, ahead) = self.approach(rate);
        let target = limit_rad + ahead * self.keys.beyond_rad;
        let mut segments = vec![self.go(PAST, start_rad, target, rate.abs())];
        stop_after_last(&mut segments);
        let fence =
            Fence { bench_rad: [(self.axis.to_owned(), self.keys.fence_rad)].into(), ..Fence::default() };
        self.fenced(Stage::SoftBench, rate, fence, self.case(String::new(), start_rad, segments))
    }

    fn soft_drive(&self, rate: f64) -> Case {
        let (start_rad, limit_rad, ahead) = self.approach(rate);
        let past = if rate.abs() <= SLOW_RAD_PER_S { LED_PAST_RAD[0] } else { LED_PAST_RAD[1] };
        let limits = self.profile(rate.abs());
        let way = (limit_rad - start_rad).abs() + past;
        let acceleration = limits.acceleration_rad_per_s2;
        // Long enough for a drive to come to its limit as gently as it likes; one that keeps none ends it by its way.
        let at_most_s = way / rate.abs() + 0.5 * rate.abs() / acceleration + APPROACH_S;
        let until = Some(Condition::Displacement { above_rad: way });
        let stimulus = Stimulus::Cruise {
            from_rad_per_s: 0.0,
            velocity_rad_per_s: ahead * rate.abs(),
            acceleration_rad_per_s2: acceleration,
        };
        let past = Segment { stimulus, until, ..Segment::hold(PAST, Mode::DriveVelocity, at_most_s) };
        let mut segments = vec![past];
        stop_after_last(&mut segments);
        let fence =
            Fence { drive_rad: [(self.axis.to_owned(), self.keys.fence_rad)].into(), ..Fence::default() };
        self.fenced(Stage::SoftDrive, rate, fence, self.case(String::new(), start_rad, segments))
    }

    /// Behind the upper end of the fence, while the other axis points into the zone or beside it.
    fn zone(&self, pair: Pair<'_>, rate: f64, beside: bool) -> Case {
        let (start_rad, limit_rad, _) = self.approach(rate);
        let target = limit_rad + self.keys.beyond_rad;
        let mut segments = vec![self.go(PAST, start_rad, target, rate)];
        stop_after_last(&mut segments);
        let mut case = self.case(String::new(), start_rad, segments);
        let own = pair.own;
        let other = 1 - pair.own;
        let other_name = pair.other;
        let other_rad = case.start_pose_rad.get(other_name).copied().unwrap_or(0.0);
        let mut zone = Zone { lower_rad: [0.0; 2], upper_rad: [0.0; 2] };
        (zone.lower_rad[own], zone.upper_rad[own]) = (limit_rad, target + NEAR_RAD);
        (zone.lower_rad[other], zone.upper_rad[other]) =
            (other_rad - ZONE_HALF_RAD, other_rad + ZONE_HALF_RAD);
        if beside {
            case.start_pose_rad.insert(other_name.to_owned(), other_rad + BESIDE_RAD);
        }
        let fence = Fence { zones: vec![zone], ..Fence::default() };
        let case = self.fenced(Stage::Zone, rate, fence, case);
        if beside { Case { point: format!("{}, {BESIDE}", case.point), ..case } } else { case }
    }

    fn fenced(&self, stage: Stage, rate: f64, fence: Fence, case: Case) -> Case {
        let point = format!("{}, velocity={}", stage.name(), Q::AngularVelocity.format(rate));
        Case { point, requested: vec![requested(rate)], fence: Some(fence), ..case }
    }
}

fn requested(rate: f64) -> Request {
    Request { name: "velocity".to_owned(), value: rate, kind: Q::AngularVelocity }
}

fn stop_after_last(segments: &mut [Segment]) {
    if let Some(last) = segments.last_mut() {
        last.then = Then::Stop;
    }
}

/// 0, or the nearest place inside.
fn rest_rad(limits: &AxisLimits) -> f64 {
    let [low, high] = limits.soft_limits_rad;
    0.0_f64.max(low + CLEARANCE_RAD).min(high - CLEARANCE_RAD)
}
