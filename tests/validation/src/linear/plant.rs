//! Motor torque to sensed rate.

use num_complex::Complex64;
use sim_devices::unit::UnitSettings;

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

/// One axis at one elevation, sliding: commanded torque to rate.
#[derive(Clone, Debug)]
pub struct Plant {
    inertia_kg_m2: f64,
    viscous_nm_s_per_rad: f64,
    modes: Vec<Mode>,
    sensor: Sensor,
    current_lag_s: f64,
    command_delay_s: f64,
    sensor_delay_s: f64,
    torque_ratio: f64,
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
            modes: modes.collect(),
            sensor,
            current_lag_s: if bandwidth > 0.0 { 1.0 / bandwidth } else { 0.0 },
            command_delay_s: settings.command_delay_s,
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

    /// Torque at the shaft to its rate, without friction.
    fn free_shaft(&self, s: Complex64) -> Complex64 {
        self.modal(s, |mode| mode.encoder)
    }

    /// Motor torque to the rate of the shaft: friction's viscous part acts there.
    pub fn shaft(&self, s: Complex64) -> Complex64 {
        let free = self.free_shaft(s);
        free / (1.0 + self.viscous_nm_s_per_rad * free)
    }

    /// Motor torque to the rate of the frame that carries the gyro.
    pub fn frame(&self, s: Complex64) -> Complex64 {
        self.modal(s, |mode| mode.gyro) / (1.0 + self.viscous_nm_s_per_rad * self.free_shaft(s))
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
        self.torque_ratio * (-s * self.command_delay_s).exp() / (1.0 + s * self.current_lag_s)
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
