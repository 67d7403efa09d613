//! The points of a breakaway procedure: what the axis does, and why the rig may not allow it.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use analysis::multisine::Design;

use super::{Direction, HoldKeys, Keys, MapKeys, MultisineKeys};
use crate::axis::{Axes, AxisLimits};
use crate::case::{Case, Condition, Mode, Request, Segment, Then};
use crate::diagnostic::Diagnostic;
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{Line, Profile, ProfileLimits, Stimulus};

/// Label of the slow stroke over which the load is read.
pub(super) const STROKE: &str = "stroke";
/// Label of the stretch at rest under position control.
pub(super) const SETTLE: &str = "settle";
/// Label of the multisine.
pub(super) const MULTISINE: &str = "multisine";
/// Condition of a point at a judged pose: how far from it, a third of a cogging period or nothing.
const OFFSET: &str = "offset";
/// Label of the release at a pose that must hold.
pub(super) const RELEASE: &str = "release";
/// Label of the dwell before the multisine.
const DWELL: &str = "dwell";

/// The approach ends a ramp's length and more above where it starts: at least 9 z_ss from the same side.
const APPROACH_FACTOR: f64 = 1.25;
/// Speed below which the axis counts as settled, rad/s (0.05 °/s, safety.md §2), and for how long.
const SETTLED: Condition = Condition::Settled { below_rad_per_s: 8.7e-4, for_s: 0.3 };
/// Longest time to settle, s.
const SETTLE_S: f64 = 5.0;
/// Speed of moves between poses, rad/s, where the rig allows it: 20 °/s.
const TRANSFER_RAD_PER_S: f64 = 20.0 * TAU / 360.0;
/// Time without torque before the multisine and before the ramps of a hold point, s.
const RELAX_S: f64 = 2.0;
/// Torque at which a ramp is given up, in units of the expected static friction.
const GIVE_UP_RATIO: f64 = 2.0;
/// Time that a ramp gets on top of that in which it reaches the torque at which it is given up, s.
const GIVE_UP_S: f64 = 4.0;
/// Static friction over torque quantum, at least (director.md §8).
const QUANTA: f64 = 300.0;
/// Largest multisine, in units of static friction (estimators.md §1.5): above, the contact is no spring any more.
const LARGEST_LEVEL: f64 = 0.1;
/// Shortest time in which a ramp may reach the expected static friction: the presliding mode (1 to 2 Hz, damped)
/// must follow, else the ramp measures inertia.
const SHORTEST_RAMP_S: f64 = 0.2;

/// All points, or everything that the axis cannot do.
pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    let Some(limits) = axes.get(axis) else {
        let known = axes.names().collect::<Vec<_>>().join(", ");
        return Err(vec![Diagnostic::new(format!("the rig has no axis `{axis}`; it has {known}"))]);
    };
    let refusals = refusals(keys, axis, limits);
    let Some(constant_nm_per_a) = limits.torque_constant_nm_per_a.filter(|_| refusals.is_empty()) else {
        return Err(refusals);
    };
    let mut planner =
        Planner { keys, axis, axes, limits, constant_nm_per_a, at_rad: None, cases: Vec::new() };
    if let Some(map) = &keys.map {
        planner.map(map);
    }
    planner.ramps();
    if let Some(multisine) = &keys.multisine {
        planner.multisine(multisine);
    }
    if let Some(hold) = &keys.hold {
        for &pose_rad in &hold.poses_rad {
            for third in [-1.0, 0.0, 1.0] {
                planner.hold(hold, pose_rad, Some(third / 3.0 * TAU / planner.limits.cogging_orders_per_rev));
            }
        }
        for &pose_rad in &hold.further_poses_rad {
            planner.hold(hold, pose_rad, None);
        }
    }
    Ok(planner.cases)
}

struct Planner<'a> {
    keys: &'a Keys,
    axis: &'a str,
    axes: &'a Axes,
    limits: &'a AxisLimits,
    constant_nm_per_a: f64,
    /// Where the point before ends; `None` before the first.
    at_rad: Option<f64>,
    cases: Vec<Case>,
}

/// Rate and dwell of a ramp.
#[derive(Clone, Copy, PartialEq)]
struct Cell {
    rate_a_per_s: f64,
    dwell_s: f64,
}

fn request(name: &str, value: f64, kind: Q) -> Request {
    Request { name: name.to_owned(), value, kind }
}

impl Planner<'_> {
    fn map(&mut self, map: &MapKeys) {
        let pose_rad = self.keys.pose_rad;
        let reach_rad = f64::from(map.periods) * TAU / self.limits.cogging_orders_per_rev;
        let from_rad = pose_rad - reach_rad;
        let to_rad = pose_rad + reach_rad;
        let (start_rad, mut segments) = self.start(from_rad);
        let stimulus = Stimulus::Reversals {
            from_rad,
            to_rad,
            limits: self.profile(map.velocity_rad_per_s),
            cycles: map.cycles,
        };
        let at_most_s = 1.05 * stimulus.duration_s(from_rad).unwrap_or(0.0) + 1.0;
        segments.push(segment(STROKE, Mode::Position, stimulus, at_most_s));
        let requested = vec![
            request("pose", pose_rad, Q::Angle),
            request("velocity", map.velocity_rad_per_s, Q::AngularVelocity),
        ];
        self.push("map".to_owned(), requested, start_rad, segments);
    }

    fn ramps(&mut self) {
        let mut planned: Vec<Cell> = Vec::new();
        for block in &self.keys.ramps {
            for &rate in &block.rates_a_per_s {
                for &dwell_s in &block.dwells_s {
                    // The same rate and dwell may stand in two blocks: repeats are then counted on.
                    let cell = Cell { rate_a_per_s: rate, dwell_s };
                    let first = planned.iter().filter(|c| **c == cell).count();
                    for repeat in 0..block.repeats as usize {
                        planned.push(cell);
                        for direction in Direction::BOTH {
                            self.ramp(cell, direction, first + repeat + 1);
                        }
                    }
                }
            }
        }
    }

    fn ramp(&mut self, cell: Cell, direction: Direction, repeat: usize) {
        let pose_rad = self.keys.pose_rad;
        let (start_rad, mut segments) = self.start(self.below(pose_rad));
        segments.extend(self.arrive(pose_rad));
        segments.extend(self.dwell_and_ramp(self.keys.holding_torque_nm, direction, cell));
        segments.extend(self.leave(pose_rad));
        let name = format!(
            "ramp {}{} dwell {} #{repeat}",
            direction.sign(),
            Q::CurrentRate.format(cell.rate_a_per_s),
            Q::Time.format(cell.dwell_s)
        );
        let requested = vec![
            request("direction", direction.ratio(), Q::Ratio),
            request("rate", cell.rate_a_per_s, Q::CurrentRate),
            request("dwell", cell.dwell_s, Q::Time),
            request("pose", pose_rad, Q::Angle),
        ];
        self.push(name, requested, start_rad, segments);
    }

    fn multisine(&mut self, keys: &MultisineKeys) {
        let pose_rad = self.keys.pose_rad;
        let offset_nm = self.keys.holding_torque_nm;
        let design = design(keys);
        let amplitude_nm = keys.level_ratio * self.limits.expected_static_friction_nm / design.peak_ratio;
        let lines = design.orders.iter().zip(&design.phases_rad);
        let lines = lines
            .map(|(&k, &phase_rad)| Line {
                frequency_hz: f64::from(k) * keys.from_hz,
                amplitude_nm,
                phase_rad,
            })
            .collect();
        let period_s = 1.0 / keys.from_hz;
        let (start_rad, mut segments) = self.start(self.below(pose_rad));
        segments.extend(self.arrive(pose_rad));
        segments.push(segment(DWELL, Mode::Torque, Stimulus::Hold { torque_nm: offset_nm }, RELAX_S));
        segments.push(Segment {
            until: Some(Condition::Displacement { above_rad: self.keys.displacement_rad }),
            dithered: true,
            then: Then::Hold,
            ..segment(
                MULTISINE,
                Mode::Torque,
                Stimulus::TorqueMultisine { offset_nm, period_s, lines },
                f64::from(keys.periods) * period_s,
            )
        });
        segments.extend(self.leave(pose_rad));
        let requested =
            vec![request("level", keys.level_ratio, Q::Ratio), request("pose", pose_rad, Q::Angle)];
        self.push(MULTISINE.to_owned(), requested, start_rad, segments);
    }

    /// A point that is released at a pose, `offset_rad` away from the one that is asked for where that is judged.
    fn hold(&mut self, hold: &HoldKeys, asked_rad: f64, offset_rad: Option<f64>) {
        let pose_rad = asked_rad + offset_rad.unwrap_or(0.0);
        let until = Some(Condition::Displacement { above_rad: self.keys.displacement_rad });
        let (start_rad, mut segments) = self.start(self.below(pose_rad));
        segments.extend(self.arrive(pose_rad));
        segments.push(Segment {
            until,
            then: Then::Hold,
            ..segment(RELEASE, Mode::Torque, Stimulus::Hold { torque_nm: 0.0 }, hold.release_s)
        });
        segments.extend(self.leave(pose_rad));
        let cell = Cell { rate_a_per_s: hold.rate_a_per_s, dwell_s: RELAX_S };
        for direction in Direction::BOTH {
            segments.extend(self.arrive(pose_rad));
            segments.extend(self.dwell_and_ramp(0.0, direction, cell));
            segments.extend(self.leave(pose_rad));
        }
        let mut requested =
            vec![request("pose", asked_rad, Q::Angle), request("rate", hold.rate_a_per_s, Q::CurrentRate)];
        requested.extend(offset_rad.map(|offset| request(OFFSET, offset, Q::Angle)));
        self.push(format!("hold {}", Q::Angle.format(pose_rad)), requested, start_rad, segments);
    }

    /// Where the approach to a pose begins.
    fn below(&self, pose_rad: f64) -> f64 {
        pose_rad - APPROACH_FACTOR * self.keys.displacement_rad
    }

    /// From below up to the pose, and at rest there.
    fn arrive(&self, pose_rad: f64) -> [Segment; 2] {
        let approach = self.travel("approach", self.below(pose_rad), pose_rad, self.keys.approach_rad_per_s);
        let settle = segment(SETTLE, Mode::Position, Stimulus::Hold { torque_nm: 0.0 }, SETTLE_S);
        [approach, Segment { until: Some(SETTLED), ..settle }]
    }

    /// Back below the pose, so that the point ends where the next begins.
    fn leave(&self, pose_rad: f64) -> [Segment; 2] {
        let reach_rad = pose_rad + self.keys.displacement_rad;
        [
            segment("arrest", Mode::Position, Stimulus::Hold { torque_nm: 0.0 }, 0.5),
            self.travel("return", reach_rad, self.below(pose_rad), 2.0 * self.keys.approach_rad_per_s),
        ]
    }

    /// At rest under the torque from which the ramp then starts.
    fn dwell_and_ramp(&self, from_nm: f64, direction: Direction, cell: Cell) -> Vec<Segment> {
        let rate_nm_per_s = direction.ratio() * cell.rate_a_per_s * self.constant_nm_per_a;
        let given_up_nm = GIVE_UP_RATIO * self.limits.expected_static_friction_nm;
        let at_most_s = given_up_nm / rate_nm_per_s.abs() + GIVE_UP_S;
        let until = Some(Condition::Displacement { above_rad: self.keys.displacement_rad });
        let dwell = direction.dwell_label();
        let ramp = direction.ramp_label();
        vec![
            Segment {
                until,
                ..segment(&dwell, Mode::Torque, Stimulus::Hold { torque_nm: from_nm }, cell.dwell_s)
            },
            Segment {
                until,
                then: Then::Hold,
                dithered: true,
                ..segment(&ramp, Mode::Torque, Stimulus::TorqueRamp { from_nm, rate_nm_per_s }, at_most_s)
            },
        ]
    }

    /// Where the axis was left (or `place_rad`, for the first point), and the move from there to `place_rad`, where
    /// the point itself begins and ends.
    fn start(&mut self, place_rad: f64) -> (f64, Vec<Segment>) {
        let at_rad = self.at_rad.replace(place_rad).unwrap_or(place_rad);
        let speed = TRANSFER_RAD_PER_S.min(0.5 * self.limits.max_velocity_rad_per_s);
        let far = (at_rad - place_rad).abs() > 1e-9;
        (at_rad, far.then(|| self.travel("transfer", at_rad, place_rad, speed)).into_iter().collect())
    }

    fn travel(&self, label: &str, from_rad: f64, target_rad: f64, velocity_rad_per_s: f64) -> Segment {
        let limits = self.profile(velocity_rad_per_s.min(self.limits.max_velocity_rad_per_s));
        let at_most_s = 1.05 * Profile::new(target_rad - from_rad, &limits).duration_s() + 0.5;
        segment(label, Mode::Position, Stimulus::Move { target_rad, limits }, at_most_s)
    }

    /// Gentle limits: a fifth of a second to reach the velocity, a tenth to reach the acceleration.
    fn profile(&self, velocity_rad_per_s: f64) -> ProfileLimits {
        let acceleration_rad_per_s2 =
            (5.0 * velocity_rad_per_s).min(0.5 * self.limits.max_acceleration_rad_per_s2);
        ProfileLimits {
            velocity_rad_per_s,
            acceleration_rad_per_s2,
            jerk_rad_per_s3: (10.0 * acceleration_rad_per_s2).min(self.limits.max_jerk_rad_per_s3),
        }
    }

    fn push(&mut self, point: String, requested: Vec<Request>, start_rad: f64, segments: Vec<Segment>) {
        let mut start_pose_rad = BTreeMap::new();
        for name in self.axes.names() {
            // The other axes rest as asked, or at the nearest angle that their soft limits allow.
            let wanted_rad = self.keys.other_axis_pose_rad;
            let rest = |a: &AxisLimits| wanted_rad.max(a.soft_limits_rad[0]).min(a.soft_limits_rad[1]);
            start_pose_rad.insert(name.to_owned(), self.axes.get(name).map_or(0.0, rest));
        }
        start_pose_rad.insert(self.axis.to_owned(), start_rad);
        self.cases.push(Case {
            point,
            axis: self.axis.to_owned(),
            requested,
            start_pose_rad,
            segments,
            ..Case::default()
        });
    }
}

/// The multisine's lines as multiples of the lowest.
fn design(keys: &MultisineKeys) -> Design {
    Design::log_spaced((keys.to_hz / keys.from_hz).round() as u32, keys.lines as usize)
}

fn segment(label: &str, mode: Mode, stimulus: Stimulus, at_most_s: f64) -> Segment {
    Segment {
        label: label.to_owned(),
        mode,
        stimulus,
        until: None,
        at_most_s,
        then: Then::Next,
        dithered: false,
        ..Segment::default()
    }
}

/// Everything that keeps the procedure from running on this axis.
fn refusals(keys: &Keys, axis: &str, limits: &AxisLimits) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    found.extend(quantum(axis, limits));
    found.extend(multisine(keys, axis, limits));
    found.extend(
        reaches(keys, limits).into_iter().filter_map(|(what, reach)| travel(axis, &what, reach, limits)),
    );
    found.extend(stroke(keys, axis, limits));
    found.extend(velocities(keys, axis, limits));
    match limits.torque_constant_nm_per_a {
        Some(constant) => found.extend(rates(keys, axis, limits, constant)),
        None => found.push(
            Diagnostic::new(format!(
                "axis `{axis}` has no torque constant: a current rate gives no torque ramp"
            ))
            .help("give the rig's axis its `torque-constant`"),
        ),
    }
    found
}

fn quantum(axis: &str, limits: &AxisLimits) -> Option<Diagnostic> {
    let allowed = limits.expected_static_friction_nm / QUANTA;
    (limits.torque_quantum_nm > allowed).then(|| {
        Diagnostic::new(format!(
            "the torque quantum of axis `{axis}` is {}, at most {} is allowed: static friction ({} expected) over {QUANTA}",
            Q::Torque.format(limits.torque_quantum_nm),
            Q::Torque.format(allowed),
            Q::Torque.format(limits.expected_static_friction_nm),
        ))
        .help("lower the drive's torque scaling (object 6076)")
    })
}

fn multisine(keys: &Keys, axis: &str, limits: &AxisLimits) -> Option<Diagnostic> {
    let level = keys.multisine.as_ref()?.level_ratio;
    (level > LARGEST_LEVEL).then(|| {
        let torque = |ratio: f64| Q::Torque.format(ratio * limits.expected_static_friction_nm);
        Diagnostic::new(format!(
            "the multisine on axis `{axis}` peaks at {} of static friction ({}), at most {} ({}) is allowed",
            Q::Ratio.format(level),
            torque(level),
            Q::Ratio.format(LARGEST_LEVEL),
            torque(LARGEST_LEVEL),
        ))
        .help("set `level` in [multisine] to 0.1 or less: larger loops leave the presliding regime")
    })
}

/// What the procedure reaches, by name of what asks for it.
fn reaches(keys: &Keys, limits: &AxisLimits) -> Vec<(String, [f64; 2])> {
    let displacement = keys.displacement_rad;
    let around = |pose: f64| [pose - APPROACH_FACTOR * displacement, pose + displacement];
    let mut all = Vec::new();
    if !keys.ramps.is_empty() || keys.multisine.is_some() {
        all.push((format!("`pose` {}", Q::Angle.format(keys.pose_rad)), around(keys.pose_rad)));
    }
    if let Some(map) = &keys.map {
        let reach = f64::from(map.periods) * TAU / limits.cogging_orders_per_rev;
        all.push(("the stroke of [map]".to_owned(), [keys.pose_rad - reach, keys.pose_rad + reach]));
    }
    for pose in keys.hold.iter().flat_map(HoldKeys::all_poses_rad) {
        all.push((format!("`pose` {} of [hold]", Q::Angle.format(pose)), around(pose)));
    }
    all
}

/// After each turn of the stroke the contact renews itself over up to `displacement`; then a period must remain.
fn stroke(keys: &Keys, axis: &str, limits: &AxisLimits) -> Option<Diagnostic> {
    let period = TAU / limits.cogging_orders_per_rev;
    let length = 2.0 * f64::from(keys.map.as_ref()?.periods) * period;
    let needed = 2.0 * keys.displacement_rad + period;
    (length < needed).then(|| {
        Diagnostic::new(format!(
            "the stroke of [map] on axis `{axis}` is {} long, but at least {} is needed: twice \
             `displacement` plus a cogging period",
            Q::Angle.format(length),
            Q::Angle.format(needed)
        ))
        .help("use more `periods` in [map]")
    })
}

fn travel(axis: &str, what: &str, reach: [f64; 2], limits: &AxisLimits) -> Option<Diagnostic> {
    let [low, high] = limits.soft_limits_rad;
    (reach[0] < low || reach[1] > high).then(|| {
        let range = |[a, b]: [f64; 2]| format!("{} … {}", Q::Angle.format(a), Q::Angle.format(b));
        Diagnostic::new(format!(
            "{what} reaches {} on axis `{axis}`, the soft limits are {}",
            range(reach),
            range([low, high])
        ))
        .help("choose another pose or a smaller `displacement` (approach from below included)")
    })
}

fn velocities(keys: &Keys, axis: &str, limits: &AxisLimits) -> Vec<Diagnostic> {
    let map = keys.map.as_ref().map(|m| ("`velocity` of [map]", m.velocity_rad_per_s));
    [("`approach-velocity`", keys.approach_rad_per_s)]
        .into_iter()
        .chain(map)
        .filter(|(_, asked)| *asked > limits.max_velocity_rad_per_s)
        .map(|(what, asked)| {
            Diagnostic::new(format!(
                "{what} is {}, axis `{axis}` allows {}",
                Q::AngularVelocity.format(asked),
                Q::AngularVelocity.format(limits.max_velocity_rad_per_s)
            ))
        })
        .collect()
}

fn rates(keys: &Keys, axis: &str, limits: &AxisLimits, constant: f64) -> Vec<Diagnostic> {
    let expected = limits.expected_static_friction_nm;
    let fastest = expected / SHORTEST_RAMP_S / constant;
    let asked: Vec<f64> = keys
        .ramps
        .iter()
        .flat_map(|r| r.rates_a_per_s.iter().copied())
        .chain(keys.hold.as_ref().map(|h| h.rate_a_per_s))
        .collect();
    let mut found: Vec<Diagnostic> = asked
        .into_iter()
        .filter(|&rate| rate > fastest)
        .map(|rate| {
            Diagnostic::new(format!(
                "a ramp of {} on axis `{axis}` reaches static friction within {}, at most {} is allowed",
                Q::CurrentRate.format(rate),
                Q::Time.format(expected / constant / rate),
                Q::CurrentRate.format(fastest),
            ))
            .help("use a slower ramp: a faster one measures the inertia, not the contact")
        })
        .collect();
    if keys.holding_torque_nm.abs() >= expected {
        found.push(Diagnostic::new(format!(
            "`holding-torque` {} is no less than the static friction expected on axis `{axis}`, {}",
            Q::Torque.format(keys.holding_torque_nm),
            Q::Torque.format(expected)
        )));
    }
    found
}
