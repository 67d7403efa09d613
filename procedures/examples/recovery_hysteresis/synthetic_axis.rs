//! An axis made of formulas, for recovery: it follows every setpoint exactly and the motor pays for it.
//!
//! J·α = T_m − T_f + A_u·cos θ − K_s·(θ − θ_0), friction by LuGre along the given motion, cogging in harmonics; white
//! torque noise, drive quantum and encoder quantum on top. No loop, no bus: it tests the estimators, not the plant.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::procedures::axis::{Axes, AxisLimits};
use super::procedures::case::Case;
use super::procedures::log::{Channel, EndedBy, Rows, SegmentSpan, Topic, Width, Window};

/// What is true of the axis.
#[derive(Clone, Debug)]
pub(crate) struct Truth {
    pub(crate) name: &'static str,
    pub(crate) coulomb_nm: f64,
    pub(crate) static_nm: f64,
    pub(crate) stribeck_rad_per_s: f64,
    pub(crate) viscous_nm_s_per_rad: f64,
    pub(crate) shape_ratio: f64,
    pub(crate) bristle_nm_per_rad: f64,
    pub(crate) inertia_kg_m2: f64,
    pub(crate) unbalance_nm: f64,
    pub(crate) spring_nm_per_rad: f64,
    pub(crate) rest_rad: f64,
    /// Order per revolution, amplitude, phase.
    pub(crate) cogging: Vec<[f64; 3]>,
    pub(crate) torque_constant_nm_per_a: f64,
    pub(crate) torque_quantum_nm: f64,
    pub(crate) noise_nm: f64,
}

/// Azimuth of the director.
pub(crate) fn azimuth() -> Truth {
    Truth {
        name: "az",
        coulomb_nm: 167.75,
        static_nm: 210.0,
        stribeck_rad_per_s: 0.12,
        viscous_nm_s_per_rad: 273.6,
        shape_ratio: 2.5,
        bristle_nm_per_rad: 90_000.0,
        inertia_kg_m2: 1200.0,
        unbalance_nm: 0.0,
        spring_nm_per_rad: 0.0,
        rest_rad: 0.0,
        cogging: vec![[144.0, 8.45, 0.4], [288.0, 0.85, -1.1]],
        torque_constant_nm_per_a: 60.0,
        torque_quantum_nm: 0.12,
        noise_nm: 1.6775,
    }
}

/// Elevation of the director as measured.
pub(crate) fn elevation() -> Truth {
    Truth {
        name: "el",
        coulomb_nm: 34.5,
        static_nm: 43.125,
        stribeck_rad_per_s: 0.012,
        viscous_nm_s_per_rad: 68.4,
        shape_ratio: 0.85,
        bristle_nm_per_rad: 50_000.0,
        inertia_kg_m2: 975.0,
        unbalance_nm: 14.0,
        spring_nm_per_rad: 54.0,
        rest_rad: 40_f64.to_radians(),
        cogging: vec![[108.0, 5.07, 1.0], [216.0, 0.5, 0.3]],
        torque_constant_nm_per_a: 52.0,
        torque_quantum_nm: 0.104,
        noise_nm: 0.345,
    }
}

/// Gaussian numbers by Box and Muller from a seeded stream.
pub(crate) struct Gauss(ChaCha8Rng);

impl Gauss {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub(crate) fn next(&mut self) -> f64 {
        let mut uniform = || (f64::from(self.0.next_u32()) + 0.5) / 4_294_967_296.0;
        (-2.0 * uniform().ln()).sqrt() * (TAU * uniform()).cos()
    }
}

impl Truth {
    /// Friction in steady sliding.
    pub(crate) fn friction_nm(&self, velocity_rad_per_s: f64) -> f64 {
        self.sliding_nm(velocity_rad_per_s) + self.viscous_nm_s_per_rad * velocity_rad_per_s
    }

    fn sliding_nm(&self, velocity_rad_per_s: f64) -> f64 {
        let fall = (-(velocity_rad_per_s.abs() / self.stribeck_rad_per_s).powf(self.shape_ratio)).exp();
        self.coulomb_nm + (self.static_nm - self.coulomb_nm) * fall
    }

    /// Cogging torque that the motor must add.
    pub(crate) fn cogging_nm(&self, angle_rad: f64) -> f64 {
        self.cogging
            .iter()
            .map(|[order, amplitude, phase]| amplitude * (order * angle_rad + phase).cos())
            .sum()
    }

    /// Unbalance and spring torque that the motor must add.
    pub(crate) fn load_nm(&self, angle_rad: f64) -> f64 {
        self.spring_nm_per_rad * (angle_rad - self.rest_rad) - self.unbalance_nm * angle_rad.cos()
    }

    /// What the rig file says of the axis.
    pub(crate) fn limits(&self) -> AxisLimits {
        let travel_deg: [f64; 2] = if self.name == "az" { [-160.0, 160.0] } else { [-10.0, 90.0] };
        AxisLimits {
            travel_rad: travel_deg.map(f64::to_radians),
            soft_limits_rad: [travel_deg[0] + 0.5, travel_deg[1] - 0.5].map(f64::to_radians),
            max_velocity_rad_per_s: 60_f64.to_radians(),
            max_acceleration_rad_per_s2: 90_f64.to_radians(),
            max_jerk_rad_per_s3: 900_f64.to_radians(),
            max_torque_nm: 42.0 * self.torque_constant_nm_per_a,
            torque_constant_nm_per_a: Some(self.torque_constant_nm_per_a),
            torque_constant_u_ratio: 0.002,
            measured_constant: None,
            inertia_kg_m2: self.inertia_kg_m2,
            inertia_u_ratio: 0.0,
            torque_quantum_nm: self.torque_quantum_nm,
            encoder_quantum_rad: TAU / 67_108_864.0,
            expected_static_friction_nm: self.static_nm,
            expected_presliding_stiffness_nm_per_rad: 0.0,
            polarity_torque_nm: 0.0,
            zero_tolerance_rad: 0.0,
            loop_rate_hz: 0.0,
            log_rate_hz: 0.0,
            cogging_orders_per_rev: self.cogging[0][0],
            reference: None,
        }
    }

    /// What the log would hold of a point, at `rate_hz`, noise from `seed`.
    pub(crate) fn run(&self, case: &Case, rate_hz: f64, seed: u64) -> Window {
        let mut motion = Motion { random: Gauss::new(seed), bristle_rad: 0.0, time_s: 0.0, rows: Vec::new() };
        let mut at_rad = case.start_pose_rad.get(&case.axis).copied().unwrap_or(0.0);
        let mut segments = Vec::new();
        for (index, segment) in case.segments.iter().enumerate() {
            let stimulus = segment.stimulus.prepare(at_rad);
            let duration_s = segment.stimulus.duration_s(at_rad).unwrap_or(0.0);
            let start_s = motion.time_s;
            let start_rad = at_rad;
            for k in 0..(duration_s * rate_hz).ceil() as u64 {
                let setpoint = stimulus.at(k as f64 / rate_hz);
                at_rad = setpoint.position_rad;
                motion.step(
                    self,
                    at_rad,
                    setpoint.velocity_rad_per_s,
                    setpoint.acceleration_rad_per_s2,
                    1.0 / rate_hz,
                );
            }
            segments.push(SegmentSpan {
                segment: index,
                start_s,
                end_s: motion.time_s,
                start_position_rad: start_rad,
                ended_by: EndedBy::Completed,
            });
        }
        window(&case.axis, segments, &motion.rows)
    }
}

struct Motion {
    random: Gauss,
    bristle_rad: f64,
    time_s: f64,
    /// Time, position, current.
    rows: Vec<[f64; 3]>,
}

impl Motion {
    fn step(&mut self, truth: &Truth, angle: f64, velocity: f64, acceleration: f64, dt: f64) {
        let steady = truth.sliding_nm(velocity) / truth.bristle_nm_per_rad;
        let keep = (-velocity.abs() * dt / steady).exp();
        self.bristle_rad = velocity.signum() * steady * (1.0 - keep) + self.bristle_rad * keep;
        let friction = truth.bristle_nm_per_rad * self.bristle_rad + truth.viscous_nm_s_per_rad * velocity;
        let torque =
            truth.inertia_kg_m2 * acceleration + friction + truth.cogging_nm(angle) + truth.load_nm(angle);
        let noisy = torque + truth.noise_nm * self.random.next();
        let counted = (noisy / truth.torque_quantum_nm).round() * truth.torque_quantum_nm;
        let count_rad = TAU / 67_108_864.0;
        let position = (angle / count_rad).round() * count_rad;
        self.rows.push([self.time_s, position, counted / truth.torque_constant_nm_per_a]);
        self.time_s += dt;
    }
}

/// A completed window of one axis from rows of time, position and current.
pub(crate) fn window(axis: &str, segments: Vec<SegmentSpan>, rows: &[[f64; 3]]) -> Window {
    let channel =
        |name: &str, unit: &str| Channel { name: name.into(), unit: unit.into(), width: Width::F64 };
    let topic = Topic {
        name: format!("/{axis}"),
        message: "bench_msgs/msg/Axis".to_owned(),
        channels: vec![channel("position_rad", "rad"), channel("current_a", "A")],
    };
    let column = |k: usize| rows.iter().map(|row| row[k]).collect::<Vec<f64>>();
    let rows = Rows { topic, time_s: column(0), columns: vec![column(1), column(2)] };
    Window::completed(vec![rows], segments)
}

/// Both axes as a rig.
pub(crate) fn rig(truths: &[&Truth]) -> Axes {
    Axes::stacked(truths.iter().map(|t| (t.name.to_owned(), t.limits())))
}
