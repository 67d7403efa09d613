//! From the demand of the servo to the travel of the stacks: amplifier, hysteresis, creep, end of stroke.

use super::lag::Lag;
use crate::physics::piezo::{Creep, Hysteresis};
use crate::unit::MirrorSettings;

/// Amplitude at which the actuator gain is exact: 1 V peak to peak = 500 µrad peak to peak, the level of acceptance.
/// The secant gain of a hysteretic actuator grows with amplitude: 0.94 for the smallest signals, 1.30 at full scale.
const UNITY_AMPLITUDE_RAD: f64 = 250e-6;

/// One axis; voltages are kept as the angle that they stand for at the nominal actuator gain.
#[derive(Clone, Debug)]
pub(super) struct Actuator {
    /// Half the amplifier's range.
    limit_rad: f64,
    /// Largest change in a step: the amplifier's current charges the capacitance, dV/dt = I/C.
    slew_rad: f64,
    slewed_rad: f64,
    amplifier: Lag,
    hysteresis: Hysteresis,
    creep: Creep,
    /// Travel towards negative and positive tilt.
    stroke_rad: [f64; 2],
}

impl Actuator {
    pub(super) fn new(settings: &MirrorSettings, axis: usize, step_s: f64) -> Self {
        let limit_rad = Self::limit_rad(settings);
        let stroke_rad = settings.stroke_rad[axis];
        let slew_v_per_s = settings.amplifier_current_a / settings.capacitance_f;
        Self {
            limit_rad,
            slew_rad: slew_v_per_s * settings.actuator_gain_rad_per_v * step_s,
            slewed_rad: 0.0,
            amplifier: Lag::new(settings.amplifier_cutoff_hz, step_s),
            hysteresis: Hysteresis::new(limit_rad, settings.hysteresis_ratio, UNITY_AMPLITUDE_RAD),
            creep: Creep::new(settings.creep_per_decade_ratio, step_s),
            stroke_rad: [-stroke_rad * (1.0 - settings.stroke_asymmetry_ratio[axis]), stroke_rad],
        }
    }

    /// Angle that half the amplifier's range stands for.
    pub(super) fn limit_rad(settings: &MirrorSettings) -> f64 {
        0.5 * settings.amplifier_voltage_v * settings.actuator_gain_rad_per_v
    }

    /// One step at a demand; returns the travel, rad at the mirror.
    #[inline]
    pub(super) fn step(&mut self, demand_rad: f64) -> f64 {
        let least_rad = (self.slewed_rad - self.slew_rad).max(-self.limit_rad);
        let most_rad = (self.slewed_rad + self.slew_rad).min(self.limit_rad);
        self.slewed_rad = demand_rad.clamp(least_rad, most_rad);
        let voltage_rad = self.amplifier.hold(self.slewed_rad);
        let strain_rad = self.creep.update(self.hysteresis.update(voltage_rad));
        strain_rad.clamp(self.stroke_rad[0], self.stroke_rad[1])
    }

    /// Output of the amplifier about its bias, in the angle that it stands for.
    pub(super) fn voltage_rad(&self) -> f64 {
        self.slewed_rad
    }
}
