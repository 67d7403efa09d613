//! Runs planned cases on the plant and writes what a log would hold of them.
//!
//! In position mode the axis follows its setpoint exactly; in torque mode it is the plant's equation of motion.
//! The recorded torque is the one in force up to the sample, as a drive reports it.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::plant::{Plant, State};
use super::procedures::axis::AxisLimits;
use super::procedures::case::{Case, Condition, Mode, Segment};
use super::procedures::log::{Channel, EndedBy, Rows, SegmentSpan, Topic, Width, Window};
use super::procedures::stimulus::Stimulus;

/// Rows per second.
const RATE_HZ: f64 = 4000.0;
/// Plant steps a row.
const STEPS: usize = 5;
/// One encoder count of 26 bits.
pub(crate) const COUNT_RAD: f64 = TAU / 67_108_864.0;
/// Rest that is logged at the beginning and at the end of a dwell; nothing happens in between.
const LOGGED_REST_S: f64 = 3.0;

/// What the rig says of the axis of this plant.
pub(crate) fn limits(plant: &Plant, torque_constant: f64) -> AxisLimits {
    let degree = TAU / 360.0;
    AxisLimits {
        travel_rad: [-10.0 * degree, 90.0 * degree],
        soft_limits_rad: [-9.5 * degree, 89.5 * degree],
        max_velocity_rad_per_s: 60.0 * degree,
        max_acceleration_rad_per_s2: 90.0 * degree,
        max_jerk_rad_per_s3: 900.0 * degree,
        max_torque_nm: 1880.0,
        torque_constant_nm_per_a: Some(torque_constant),
        torque_constant_u_ratio: 0.0,
        measured_constant: None,
        inertia_kg_m2: plant.inertia,
        inertia_u_ratio: 0.0,
        torque_quantum_nm: 0.0,
        encoder_quantum_rad: COUNT_RAD,
        expected_static_friction_nm: plant.static_friction,
        expected_presliding_stiffness_nm_per_rad: 0.0,
        polarity_torque_nm: 0.0,
        zero_tolerance_rad: 0.0,
        loop_rate_hz: 0.0,
        log_rate_hz: 0.0,
        cogging_orders_per_rev: plant.cogging[1],
        reference: None,
    }
}

/// A point without noise: angle and torque as they are, and the true friction torque of every row.
#[derive(Clone, Debug)]
pub(crate) struct Clean {
    pub(crate) window: Window,
    pub(crate) friction_nm: Vec<f64>,
}

struct Run<'a> {
    plant: &'a Plant,
    state: State,
    time_s: f64,
    torque_nm: f64,
    rows: [Vec<f64>; 4],
}

/// Runs one case.
pub(crate) fn run(plant: &Plant, case: &Case, point: usize) -> Clean {
    let theta = case.start_pose_rad[&case.axis];
    let state = State { theta, omega: 0.0, z: 0.0, age: 1.0 };
    let mut run = Run { plant, state, time_s: 0.0, torque_nm: 0.0, rows: Default::default() };
    let mut segments = Vec::new();
    for (segment, planned) in case.segments.iter().enumerate() {
        let start_s = run.time_s;
        let start_position_rad = run.state.theta;
        let logged = ["transfer", "approach", "arrest", "return"].iter().all(|l| planned.label != *l);
        let ended_by = match planned.mode {
            Mode::Torque => run.torque(planned, logged),
            // Breakaway tracks nothing.
            Mode::Position | Mode::Velocity | Mode::Track | Mode::DriveVelocity => {
                run.position(planned, logged)
            }
        };
        segments.push(SegmentSpan { segment, start_s, end_s: run.time_s, start_position_rad, ended_by });
    }
    let [time_s, position, torque, friction_nm] = run.rows;
    let channel =
        |name: &str, unit: &str| Channel { name: name.into(), unit: unit.into(), width: Width::F64 };
    let topic = Topic {
        name: format!("/{}", case.axis),
        message: "bench_msgs/msg/Axis".into(),
        channels: vec![channel("position_rad", "rad"), channel("torque_nm", "N*m")],
    };
    let rows = Rows { topic, time_s, columns: vec![position, torque] };
    let window = Window { point, ..Window::completed(vec![rows], segments) };
    Clean { window, friction_nm }
}

impl Run<'_> {
    fn log(&mut self, friction: f64) {
        let row = [self.time_s, self.state.theta, self.torque_nm, friction];
        for (column, value) in self.rows.iter_mut().zip(row) {
            column.push(value);
        }
    }

    fn position(&mut self, segment: &Segment, logged: bool) -> EndedBy {
        let start_rad = self.state.theta;
        let prepared = segment.stimulus.prepare(start_rad);
        let settle = matches!(segment.until, Some(Condition::Settled { .. }));
        let own_s = segment.stimulus.duration_s(start_rad).unwrap_or(segment.at_most_s);
        let duration_s = if settle { 0.3 } else { own_s.min(segment.at_most_s) };
        for tick in 0..(duration_s * RATE_HZ).ceil() as usize {
            let setpoint = prepared.at(tick as f64 / RATE_HZ);
            self.state.theta = setpoint.position_rad;
            self.state.omega = setpoint.velocity_rad_per_s;
            let friction = self.plant.friction(&mut self.state, 1.0 / RATE_HZ);
            let inertial = self.plant.inertia * setpoint.acceleration_rad_per_s2;
            self.torque_nm = inertial + friction - self.plant.load(self.state.theta);
            if logged {
                self.log(friction);
            }
            self.time_s += 1.0 / RATE_HZ;
        }
        self.state.omega = 0.0;
        if settle { EndedBy::Condition } else { EndedBy::Completed }
    }

    fn torque(&mut self, segment: &Segment, logged: bool) -> EndedBy {
        let start_rad = self.state.theta;
        let prepared = segment.stimulus.prepare(start_rad);
        let ticks = (segment.at_most_s * RATE_HZ).round() as usize;
        let idle = (LOGGED_REST_S * RATE_HZ) as usize;
        let resting = matches!(segment.stimulus, Stimulus::Hold { .. });
        for tick in 0..ticks {
            let torque = prepared.at(tick as f64 / RATE_HZ).torque_nm;
            let mut friction = 0.0;
            for _ in 0..STEPS {
                friction = self.plant.step(&mut self.state, torque, 1.0 / RATE_HZ / STEPS as f64);
            }
            self.torque_nm = torque;
            self.time_s += 1.0 / RATE_HZ;
            if logged && (!resting || tick < idle || tick + idle >= ticks) {
                self.log(friction);
            }
            if let Some(Condition::Displacement { above_rad }) = segment.until
                && (self.state.theta - start_rad).abs() > above_rad
            {
                return EndedBy::Condition;
            }
        }
        if segment.until.is_some() { EndedBy::Timeout } else { EndedBy::Completed }
    }
}

/// The point as the bench would have measured it: white noise on the torque, the angle in whole encoder counts.
pub(crate) fn measured(clean: &Window, noise_nm: f64, seed: u64) -> Window {
    let mut window = clean.clone();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(clean.point as u64);
    let phase = f64::from(random.next_u32()) / 2.0_f64.powi(32);
    for rows in &mut window.topics {
        for angle in &mut rows.columns[0] {
            *angle = ((*angle / COUNT_RAD + phase).floor() + 0.5 - phase) * COUNT_RAD;
        }
        for pair in rows.columns[1].chunks_mut(2) {
            let normal = normal_pair(&mut random);
            for (torque, n) in pair.iter_mut().zip(normal) {
                *torque += noise_nm * n;
            }
        }
    }
    window
}

/// Two independent standard normal numbers (Box & Muller 1958).
fn normal_pair(random: &mut ChaCha8Rng) -> [f64; 2] {
    let scale = 2.0_f64.powi(-32);
    let radius = (-2.0 * ((f64::from(random.next_u32()) + 0.5) * scale).ln()).sqrt();
    let (sin, cos) = (TAU * f64::from(random.next_u32()) * scale).sin_cos();
    [radius * cos, radius * sin]
}
