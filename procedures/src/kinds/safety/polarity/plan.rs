//! What a polarity procedure says, and the points: pulses on every axis, then ramps on every axis.

use std::collections::BTreeMap;

use crate::axis::{Axes, Axis, AxisLimits};
use crate::case::{Bounds, Case, Condition, Mode, Request, Segment, Then};
use crate::diagnostic::Diagnostic;
use crate::kinds::ReadKeys;
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{Line, Stimulus};
use crate::table::{Field, Shape, TableReader};

/// Keys of the poses of azimuth and elevation.
const POSE_KEYS: [&str; 2] = ["pose-az", "pose-el"];

/// The kind's own keys.
pub(super) const FIELDS: &[Field] = &[
    Field::default(
        POSE_KEYS[0],
        Shape::Quantity(Q::Angle),
        "20 deg",
        "Azimuth, or the first axis of a rig without gimbal: at least 30 deg from its soft limits, and not \
         where the encoder counts zero. For an axis that no gyro measures, the encoder alone proves signs \
         and torque scale, but not counts per turn.",
    ),
    Field::default(
        POSE_KEYS[1],
        Shape::Quantity(Q::Angle),
        "40 deg",
        "Elevation: at least 30 deg from its soft limits, where friction holds the load (near the spring's rest).",
    ),
    Field::optional(
        "pose",
        Shape::Map(&Shape::Text),
        "Poses by name of axis, `{ roll = \"20 deg\" }`, which take precedence over the other two keys; \
         required for every axis beyond the second.",
    ),
];

/// A polarity procedure, SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    /// Poses by name of the axis.
    pub(super) poses_rad: BTreeMap<String, f64>,
    pub(super) pose_az_rad: f64,
    pub(super) pose_el_rad: f64,
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let pose_az_rad = table.quantity(POSE_KEYS[0]);
        let pose_el_rad = table.quantity(POSE_KEYS[1]);
        let mut poses_rad = BTreeMap::new();
        let written = if table.has("pose") { table.map("pose")? } else { Vec::new() };
        for (axis, text, span) in written {
            match Q::Angle.parse(&text) {
                Ok(pose_rad) => drop(poses_rad.insert(axis, pose_rad)),
                Err(error) => table.mistake_at(span, error.to_string(), None),
            }
        }
        Some(Self { poses_rad, pose_az_rad: pose_az_rad?, pose_el_rad: pose_el_rad? })
    }
}

impl Keys {
    /// Where azimuth and elevation stand.
    pub(super) fn gimbal_rad(&self) -> [f64; 2] {
        [self.pose_az_rad, self.pose_el_rad]
    }

    /// Where an axis stands, and the key that says it; `place` is its place in the pair of axes that have keys of their own.
    pub(super) fn pose(&self, name: &str, place: Option<usize>) -> Option<(String, f64)> {
        match (self.poses_rad.get(name), place) {
            (Some(&pose_rad), _) => Some((format!("pose.{name}"), pose_rad)),
            (None, Some(place)) => Some((POSE_KEYS[place].to_owned(), self.gimbal_rad()[place])),
            (None, None) => None,
        }
    }
}

const DEGREE: f64 = std::f64::consts::TAU / 360.0;
/// Room to every soft limit (safety.md §2, layer 3).
const ROOM_RAD: f64 = 30.0 * DEGREE;
/// Pulses over expected static friction: a contact in presliding (safety.md §2, layer 3).
const PULSE_RATIO: f64 = 0.2;
/// What the drive may give during the pulses, over expected static friction.
const PULSE_LIMIT_RATIO: f64 = 0.3;
/// Bounds of the pulses in z_ss: twelve times what is expected, because a contact that bears a load of 0.4 of its static
/// friction sags and creeps by 1.5 z_ss meanwhile. Far below the degree that safety.md allows.
const PULSE_BOUND_Z: f64 = 2.5;
const PULSE_BOUND_RAD_PER_S: f64 = 0.5 * DEGREE;
/// A pulse grows and falls this long: slow against the settling of the contact (σ1/σ0 = 0.18 s).
const PULSE_RAMP_S: f64 = 0.8;
const PULSE_HOLD_S: f64 = 0.4;
const REST_S: f64 = 0.6;
/// Before anything else: an axis whose drive was just enabled may still sag under its load.
const SETTLE_S: f64 = 1.5;
/// Periodic torque after the pulses: 2.25, 3.75 and 5.25 Hz. Inertia answers there more than the contact, and the first
/// flexible mode (17 Hz) is far. Odd multiples only: a contact that bears a load answers with sums and differences of
/// its lines, and those are even.
pub(super) const SINE_PERIOD_S: f64 = 4.0 / 3.0;
const SINE_ORDERS: [u32; 3] = [3, 5, 7];
/// Up to here the answer is looked at: one line above the excited ones. Noise of the gyros grows with ω in what inertia takes.
pub(super) const HIGHEST_ORDER: u32 = 8;
const SINE_PHASES_RAD: [f64; 3] = [0.0, 2.0, 4.5];
/// Peak of the sines over expected static friction: the smaller, the less a loaded contact creeps.
const SINE_RATIO: f64 = 0.08;
const SINE_PERIODS: f64 = 7.0;
/// Ramps reach the expected static friction in about a second: fast enough that the axis has a speed when they end,
/// slow enough that this speed stays far below 2 deg/s.
const RAMP_RATE_PER_S: f64 = 0.9;
/// Motion that ends a ramp, in z_ss.
const RAMP_Z: f64 = 1.5;
/// Bounds of the ramps: half of what safety.md allows, because an encoder may show half of the motion.
const RAMP_BOUND_Z: f64 = 5.0;
const RAMP_BOUND_RAD: f64 = 0.45 * DEGREE;
const RAMP_BOUND_RAD_PER_S: f64 = 0.9 * DEGREE;
const COAST_S: f64 = 1.2;

/// Points are named after the axis and this.
pub(super) const PULSES: &str = "pulses";
/// See [`PULSES`].
pub(super) const RAMPS: &str = "ramps";
/// Label of the periodic torque.
pub(super) const SINE: &str = "sine";
/// Label of the segments in which a ramp grows.
pub(super) const RAMP: &str = "ramp";

/// The points, `first` axis first.
pub(super) fn plan(keys: &Keys, first: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    let mut ordered: Vec<&Axis> = axes.all().iter().collect();
    ordered.sort_by_key(|axis| axis.name != first);
    let pair = axes.pair();
    let place = |axis: &Axis| pair.iter().position(|own| own.is_some_and(|own| own.name == axis.name));
    let stands = |axis: &Axis| keys.pose(&axis.name, place(axis));
    let refused: Vec<Diagnostic> = ordered
        .iter()
        .flat_map(|axis| match stands(axis) {
            Some((key, pose_rad)) => refusals(&key, pose_rad, axis),
            None => {
                let message = format!("the pose of axis `{}` is missing", axis.name);
                let help = format!("add `pose = {{ {} = \"20 deg\" }}`", axis.name);
                vec![Diagnostic::new(message).help(help)]
            }
        })
        .collect();
    if !refused.is_empty() {
        return Err(refused);
    }
    let pose = axes.pose(|axis| stands(axis).map_or(0.0, |(_, pose_rad)| pose_rad));
    let case = |axis: &Axis, stage: &str| {
        let name = &axis.name;
        let limits = &axis.limits;
        let value = pose.get(name).copied().unwrap_or(0.0);
        let empty = Case {
            point: format!("{name} {stage}"),
            axis: name.clone(),
            requested: vec![Request { name: "pose".into(), value, kind: Q::Angle }],
            start_pose_rad: pose.clone(),
            open_loop: true,
            ..Case::default()
        };
        if stage == PULSES { pulses(empty, limits) } else { ramps(empty, limits) }
    };
    Ok([PULSES, RAMPS]
        .into_iter()
        .flat_map(|stage| ordered.iter().map(move |axis| (*axis, stage)))
        .map(|(axis, stage)| case(axis, stage))
        .collect())
}

/// Motion in which a sound contact reaches 0.63 of its static friction.
fn z_ss_rad(limits: &AxisLimits) -> f64 {
    limits.expected_static_friction_nm / limits.expected_presliding_stiffness_nm_per_rad
}

fn pulses(empty: Case, limits: &AxisLimits) -> Case {
    let friction_nm = limits.expected_static_friction_nm;
    let top_nm = PULSE_RATIO * friction_nm;
    let rate = top_nm / PULSE_RAMP_S;
    let mut segments = vec![still("settle", SETTLE_S)];
    for (sign, mark) in [(1.0, '+'), (-1.0, '-')] {
        segments.push(torque(&format!("up{mark}"), 0.0, sign * rate, PULSE_RAMP_S));
        segments.push(torque(&format!("hold{mark}"), sign * top_nm, 0.0, PULSE_HOLD_S));
        segments.push(torque(&format!("down{mark}"), sign * top_nm, -sign * rate, PULSE_RAMP_S));
        segments.push(still("rest", REST_S));
    }
    segments.push(sine(SINE_RATIO * friction_nm));
    let bounds =
        Bounds { displacement_rad: PULSE_BOUND_Z * z_ss_rad(limits), speed_rad_per_s: PULSE_BOUND_RAD_PER_S };
    let torque_limit_nm = Some(limits.polarity_torque_nm.min(PULSE_LIMIT_RATIO * friction_nm));
    Case { segments: ended(segments), torque_limit_nm, bounds: Some(bounds), ..empty }
}

fn ramps(empty: Case, limits: &AxisLimits) -> Case {
    let rate = RAMP_RATE_PER_S * limits.expected_static_friction_nm;
    let at_most_s = limits.polarity_torque_nm / rate;
    let until = Some(Condition::Displacement { above_rad: RAMP_Z * z_ss_rad(limits) });
    let mut segments = vec![still("settle", SETTLE_S)];
    for (sign, mark) in [(1.0, '+'), (-1.0, '-')] {
        segments.push(Segment { until, ..torque(&format!("{RAMP}{mark}"), 0.0, sign * rate, at_most_s) });
        segments.push(still("coast", COAST_S));
    }
    let bounds = Bounds {
        displacement_rad: RAMP_BOUND_RAD.min(RAMP_BOUND_Z * z_ss_rad(limits)),
        speed_rad_per_s: RAMP_BOUND_RAD_PER_S,
    };
    let torque_limit_nm = Some(limits.polarity_torque_nm);
    Case { segments: ended(segments), torque_limit_nm, bounds: Some(bounds), ..empty }
}

/// Peak torque at the most this.
fn sine(top_nm: f64) -> Segment {
    let amplitude_nm = top_nm / SINE_ORDERS.len() as f64;
    let lines = SINE_ORDERS.iter().zip(SINE_PHASES_RAD).map(|(&order, phase_rad)| {
        let frequency_hz = f64::from(order) / SINE_PERIOD_S;
        Line { frequency_hz, amplitude_nm, phase_rad }
    });
    let stimulus =
        Stimulus::TorqueMultisine { offset_nm: 0.0, period_s: SINE_PERIOD_S, lines: lines.collect() };
    Segment { stimulus, ..torque(SINE, 0.0, 0.0, SINE_PERIODS * SINE_PERIOD_S) }
}

fn torque(label: &str, from_nm: f64, rate_nm_per_s: f64, at_most_s: f64) -> Segment {
    Segment {
        label: label.to_owned(),
        mode: Mode::Torque,
        stimulus: Stimulus::TorqueRamp { from_nm, rate_nm_per_s },
        until: None,
        at_most_s,
        then: Then::Next,
        dithered: false,
        ..Segment::default()
    }
}

fn still(label: &str, at_most_s: f64) -> Segment {
    Segment { stimulus: Stimulus::Hold { torque_nm: 0.0 }, ..torque(label, 0.0, 0.0, at_most_s) }
}

fn ended(mut segments: Vec<Segment>) -> Vec<Segment> {
    if let Some(last) = segments.last_mut() {
        last.then = Then::Stop;
    }
    segments
}

fn refusals(key: &str, pose: f64, axis: &Axis) -> Vec<Diagnostic> {
    let Axis { name, limits, .. } = axis;
    let mut found = Vec::new();
    let [low, high] = [limits.soft_limits_rad[0] + ROOM_RAD, limits.soft_limits_rad[1] - ROOM_RAD];
    if !(low..=high).contains(&pose) {
        let angle = |value| Q::Angle.format(value);
        let message = format!(
            "`{key}` = {} is closer than {} to a soft limit of axis `{name}`",
            angle(pose),
            angle(ROOM_RAD)
        );
        let help = format!("stay between {} and {}", angle(low), angle(high));
        found.push(Diagnostic::new(message).help(help));
    }
    for (value, key) in [
        (limits.expected_static_friction_nm, "expected-static-friction"),
        (limits.expected_presliding_stiffness_nm_per_rad, "safety.presliding-stiffness"),
        (limits.polarity_torque_nm, "safety.polarity-torque"),
    ] {
        if value <= 0.0 {
            let message = format!("axis `{name}` has no `{key}`: the first motion cannot be computed");
            found.push(Diagnostic::new(message).help(format!("give `axis.{name}.{key}` in the rig file")));
        }
    }
    found
}
