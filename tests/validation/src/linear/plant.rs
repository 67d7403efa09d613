//! Motor torque to sensed rate.

use num_complex::Complex64;
use sim_devices::physics::lugre::LuGre;
use sim_devices::unit::{AxisSettings, UnitSettings};

/// Where the rate comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensor {
    /// Gyro on the elevation frame.
    Gyro,
    /// Encoder on the shaft.
    Encoder,
}

#[derive(Clone, Copy, Debug)]
struct Mode {
    omega_rad_per_s: f64,
    damping_ratio: f64,
    gyro: f64,
    encoder: f64,
}

/// What the bristles of a sliding contact answer to small changes of a rate ω: with `ż = ω − σ0·|ω|·z/s(ω)` linearised about it,
/// `∂F/∂ω = s'·a·(1 + σ1/σ0·s)/(s + a)`, `a = σ0·|ω|/s(ω)`.
#[derive(Clone, Copy, Debug)]
struct Bristles {
    slope_nm_s_per_rad: f64,
    corner_rad_per_s: f64,
    damping_s: f64,
}

/// One axis at one elevation, sliding: commanded torque to rate.
#[derive(Clone, Debug)]
pub struct Plant {
    inertia_kg_m2: f64,
    viscous_nm_s_per_rad: f64,
    bristles: Option<Bristles>,
    modes: Vec<Mode>,
    sensor: Sensor,
    current_lag_s: f64,
    command_delay_s: f64,
    late: Vec<Late>,
    sensor_delay_s: f64,
    torque_ratio: f64,
}

/// A time by which commands act later than their delay, and the share of the commands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Late {
    /// The time.
    pub(crate) by_s: f64,
    /// Its probability.
    pub(crate) share: f64,
}

/// Jitter as the simulated drive has it: uniform, and rounded to whole steps. Up to a period of the loop, where no command waits for
/// the one before.
pub(crate) fn jitter(axis: &AxisSettings, step_rate_hz: f64) -> Vec<Late> {
    let widest = axis.delay_jitter_s * step_rate_hz;
    if widest <= 0.0 {
        return vec![Late { by_s: 0.0, share: 1.0 }];
    }
    let bound = |steps: f64| (steps / widest).clamp(0.0, 1.0);
    let steps = 0..=widest.round() as u32;
    let late = |k: f64| Late { by_s: k / step_rate_hz, share: bound(k + 0.5) - bound(k - 0.5) };
    steps.map(|k| late(f64::from(k))).collect()
}

/// By how much commands are late on average, and the standard deviation, s.
pub(crate) fn jitter_s(axis: &AxisSettings, step_rate_hz: f64) -> [f64; 2] {
    let law = jitter(axis, step_rate_hz);
    let mean_s: f64 = law.iter().map(|late| late.share * late.by_s).sum();
    let variance_s2: f64 = law.iter().map(|late| late.share * (late.by_s - mean_s).powi(2)).sum();
    [mean_s, variance_s2.sqrt()]
}

impl Plant {
    /// An axis (0 azimuth, 1 elevation) at an elevation, sampled with a period: the gyro's messages hold the mean over
    /// one and travel for up to another.
    pub fn new(unit: &UnitSettings, axis: usize, elevation_rad: f64, sensor: Sensor, period_s: f64) -> Self {
        let (settings, structure) =
            if axis == 0 { (&unit.az, &unit.az_structure) } else { (&unit.el, &unit.el_structure) };
        let at = |curve: &[f64]| structure.interpolate(curve, elevation_rad);
        let modes = structure.modes.iter().map(|mode| Mode {
            omega_rad_per_s: std::f64::consts::TAU * at(&mode.frequency_hz),
            damping_ratio: at(&mode.damping_ratio),
            gyro: at(&mode.gyro_per_kg_m2),
            encoder: at(&mode.encoder_per_kg_m2),
        });
        let bandwidth = std::f64::consts::TAU * settings.current_bandwidth_hz;
        Self {
            inertia_kg_m2: settings.inertia_kg_m2 / at(&structure.rigid_gain_ratio),
            viscous_nm_s_per_rad: settings.viscous_damping_nm_s_per_rad,
            bristles: None,
            modes: modes.collect(),
            sensor,
            current_lag_s: if bandwidth > 0.0 { 1.0 / bandwidth } else { 0.0 },
            command_delay_s: settings.command_delay_s,
            late: jitter(settings, unit.step_rate_hz),
            sensor_delay_s: match sensor {
                Sensor::Gyro => unit.imu.delay_s + 1.5 * period_s,
                Sensor::Encoder => settings.sensor_delay_s + 0.5 * settings.velocity_window_s,
            },
            // Late in a campaign, as the loops are measured.
            torque_ratio: settings.torque_constant_nm_per_a * settings.rated_current_a
                / settings.rated_torque_nm
                * (1.0 + settings.torque_constant_per_k_ratio * settings.warm_up_degc),
        }
    }

    /// The same with bristles that slide at a rate (a magnitude).
    pub fn sliding(mut self, axis: &AxisSettings, rate_rad_per_s: f64) -> Self {
        const STEP: f64 = 1e-4;
        let law = LuGre::new(axis, 1e-4);
        let age_s = axis.static_torque_nm / axis.bristle_stiffness_nm_per_rad / rate_rad_per_s;
        let torque_nm = |factor: f64| law.sliding_torque_nm(factor * rate_rad_per_s, age_s);
        self.bristles = Some(Bristles {
            slope_nm_s_per_rad: (torque_nm(1.0 + STEP) - torque_nm(1.0 - STEP))
                / (2.0 * STEP * rate_rad_per_s),
            corner_rad_per_s: axis.bristle_stiffness_nm_per_rad * rate_rad_per_s / torque_nm(1.0),
            damping_s: axis.bristle_damping_nm_s_per_rad / axis.bristle_stiffness_nm_per_rad,
        });
        self
    }

    /// Rate of the shaft to the torque of friction.
    fn friction(&self, s: Complex64) -> Complex64 {
        let of_bristles = |b: &Bristles| {
            b.slope_nm_s_per_rad * b.corner_rad_per_s * (1.0 + b.damping_s * s) / (s + b.corner_rad_per_s)
        };
        self.viscous_nm_s_per_rad + self.bristles.as_ref().map_or(Complex64::default(), of_bristles)
    }

    /// Torque at the shaft to its rate, without friction.
    fn free_shaft(&self, s: Complex64) -> Complex64 {
        self.modal(s, |mode| mode.encoder)
    }

    /// Motor torque to the rate of the shaft: friction acts there.
    pub fn shaft(&self, s: Complex64) -> Complex64 {
        let free = self.free_shaft(s);
        free / (1.0 + self.friction(s) * free)
    }

    /// Motor torque to the rate of the frame that carries the gyro.
    pub fn frame(&self, s: Complex64) -> Complex64 {
        self.modal(s, |mode| mode.gyro) / (1.0 + self.friction(s) * self.free_shaft(s))
    }

    /// Commanded torque to what the sensor reports, with current loop and delays.
    pub fn sensed(&self, s: Complex64) -> Complex64 {
        let rate = match self.sensor {
            Sensor::Gyro => self.frame(s),
            Sensor::Encoder => self.shaft(s),
        };
        self.actuated(s) * rate * (-s * self.sensor_delay_s).exp()
    }

    /// Age of what the sensor reports.
    pub fn sensor_delay_s(&self) -> f64 {
        self.sensor_delay_s
    }

    /// Commanded torque to motor torque: delay, current loop, and a torque constant other than what the drive believes.
    pub fn actuated(&self, s: Complex64) -> Complex64 {
        let late: Complex64 = self.late.iter().map(|late| late.share * (-s * late.by_s).exp()).sum();
        self.torque_ratio * late * (-s * self.command_delay_s).exp() / (1.0 + s * self.current_lag_s)
    }

    fn modal(&self, s: Complex64, participation: fn(&Mode) -> f64) -> Complex64 {
        let rigid = 1.0 / (self.inertia_kg_m2 * s);
        self.modes.iter().fold(rigid, |sum, mode| {
            let omega = mode.omega_rad_per_s;
            let resonance = s * s + 2.0 * mode.damping_ratio * omega * s + omega * omega;
            sum + participation(mode) * s / resonance
        })
    }
}
