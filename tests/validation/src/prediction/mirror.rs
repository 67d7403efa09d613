//! Fast steering mirror: its closed loop as a frequency response, its stroke, its channels, the optical gains.

use std::f64::consts::TAU;

use num_complex::Complex64;
use sim_devices::physics::piezo::Hysteresis;
use sim_devices::unit::{MirrorSettings, UnitSettings};

use super::{Expected, Subject, row};
use crate::linear::margins;

/// Level of acceptance: 1 V peak to peak.
const LEVEL_RAD: f64 = 250e-6;
/// Largest amplitudes of the optical gain's sines.
const SINES_RAD: [f64; 2] = [100e-6, 500e-6];
/// Frequency of that sine: several points per period at the slower camera rate.
const SINE_HZ: f64 = 2.0;
/// Optical gains of the study: cross-elevation, elevation.
const OPTICAL_GAINS: [f64; 2] = [3.535_533_9, 2.5];
/// Modes of the study, azimuth and elevation (E6).
pub const MODES_HZ: [f64; 2] = [322.0, 350.0];
/// Delays of the channels as their maker states them.
const KNOWN_ANALOG_S: f64 = 0.05e-3;
const KNOWN_SERIAL_S: f64 = 0.15e-3;
/// Where the channels are compared up to.
const CHANNEL_HZ: f64 = 100.0;

/// Fit of a response at 40 dB (row 9, bandwidth) and its level near 100 Hz.
const BANDWIDTH_U: f64 = 0.01;
const LEVEL_U_DB: f64 = 0.1;
/// Autocollimator scale 0.2 % and noise.
const STROKE_U: f64 = 3e-3;
/// Row 7 on the impedance.
const MODE_U: f64 = 2e-3;
/// Two responses at 40 dB, divided.
const PHASE_U_RAD: f64 = 0.5 * std::f64::consts::PI / 180.0;
/// Half a pixel of jitter on a sine of 14 pixels over some seconds.
const OPTICAL_U: f64 = 5e-3;

pub(super) fn rows(subject: &Subject<'_>) -> Vec<Expected> {
    let settings = &subject.unit.mirror;
    let mut rows = Vec::new();
    for (axis, mode_hz) in MODES_HZ.into_iter().enumerate() {
        let mirror = Mirror::new(subject.unit, axis, LEVEL_RAD);
        let (bandwidth_hz, at_100_db) = if mirror.is_stable() {
            (mirror.bandwidth_hz(), mirror.level_db(100.0))
        } else {
            (f64::NAN, f64::NAN)
        };
        rows.push(row("FSM-BW", axis, "bandwidth", "", bandwidth_hz, BANDWIDTH_U * bandwidth_hz));
        rows.push(row("FSM-BW", axis, "attenuation-100-hz", "", -at_100_db, LEVEL_U_DB));
        let stroke_rad = if mirror.is_stable() { stroke_rad(settings, axis) } else { f64::NAN };
        rows.push(row("FSM-STR", axis, "stroke", "", stroke_rad, STROKE_U * stroke_rad));
        let departure = settings.frequency_hz[axis] / mode_hz - 1.0;
        rows.push(row("FSM-MODE", axis, "frequency-departure", "impedance", departure, MODE_U));
        rows.extend(channels(settings, axis, mirror.is_stable()));
        rows.extend(optical(subject.unit, axis));
    }
    rows
}

/// Open loop of the servo of one axis (0 azimuth, 1 elevation) behind its gauge, as a function of Hz, for motion of this
/// amplitude.
pub fn open_loop(unit: &UnitSettings, axis: usize, amplitude_rad: f64) -> impl Fn(f64) -> Complex64 {
    let mirror = Mirror::new(unit, axis, amplitude_rad);
    move |hz| mirror.loop_gain(hz)
}

/// Differences of the channels, known delays taken off.
fn channels(settings: &MirrorSettings, axis: usize, stable: bool) -> [Expected; 2] {
    let late_s = (settings.serial_delay_s - KNOWN_SERIAL_S) - (settings.analog_delay_s - KNOWN_ANALOG_S);
    let answers = stable && settings.analog_only_switch < 0.5;
    let or_nothing = |value: f64| if answers { value } else { f64::NAN };
    let phase = or_nothing((TAU * CHANNEL_HZ * late_s).abs());
    [
        row("FSM-CH", axis, "channel-level", "up to 100 Hz", or_nothing(0.0), LEVEL_U_DB),
        row("FSM-CH", axis, "channel-phase", "up to 100 Hz", phase, PHASE_U_RAD),
    ]
}

/// Commanded mirror sine over what the fine camera sees of it, against the study's gains.
fn optical(unit: &UnitSettings, axis: usize) -> Vec<Expected> {
    SINES_RAD
        .iter()
        .map(|amplitude| {
            let condition = format!("{:.0} urad", amplitude * 1e6);
            let departure = optical_gain_departure(unit, axis, *amplitude);
            row("OPT-GAIN", axis, "gain-departure", condition, departure, OPTICAL_U)
        })
        .collect()
}

/// That ratio less 1 for a sine of an amplitude; not a number where the mirror swings.
pub fn optical_gain_departure(unit: &UnitSettings, axis: usize, amplitude_rad: f64) -> f64 {
    let trackers = &unit.trackers;
    let real = [trackers.optical_gain_cross_elevation_ratio, trackers.optical_gain_elevation_ratio][axis];
    let mirror = Mirror::new(unit, axis, amplitude_rad);
    let followed = mirror.closed(SINE_HZ).norm() * trackers.fine.scale_ratio;
    let seen = if mirror.is_stable() { real / followed } else { f64::NAN };
    seen / OPTICAL_GAINS[axis] - 1.0
}

/// What the amplifier's range reaches, up to the end of the stroke.
pub fn stroke_rad(settings: &MirrorSettings, axis: usize) -> f64 {
    let limit_rad = 0.5 * settings.amplifier_voltage_v * settings.actuator_gain_rad_per_v;
    let least_rad = settings.stroke_rad[axis] * (1.0 - settings.stroke_asymmetry_ratio[axis].max(0.0));
    (limit_rad * secant_gain(settings, limit_rad)).min(least_rad)
}

/// Gain of the hysteretic actuator for a cycle of an amplitude, out of its own law.
fn secant_gain(settings: &MirrorSettings, amplitude_rad: f64) -> f64 {
    const QUARTER: u32 = 50;
    let full_scale = 0.5 * settings.amplifier_voltage_v * settings.actuator_gain_rad_per_v;
    let mut law = Hysteresis::new(full_scale, settings.hysteresis_ratio, LEVEL_RAD);
    let mut most: f64 = 0.0;
    // Up, down and up again: the second peak lies on the closed loop.
    for (from, to) in [(0.0, 1.0), (1.0, -1.0), (-1.0, 1.0)] {
        for k in 0..=QUARTER {
            let input = amplitude_rad * (from + (to - from) * f64::from(k) / f64::from(QUARTER));
            most = law.update(input);
        }
    }
    most / amplitude_rad
}

/// One axis of the mirror for small motion around an amplitude.
pub(super) struct Mirror<'a> {
    settings: &'a MirrorSettings,
    axis: usize,
    period_s: f64,
    actuator_gain: f64,
}

impl<'a> Mirror<'a> {
    pub(super) fn new(unit: &'a UnitSettings, axis: usize, amplitude_rad: f64) -> Self {
        let settings = &unit.mirror;
        let actuator_gain = secant_gain(settings, amplitude_rad);
        Self { settings, axis, period_s: 1.0 / unit.step_rate_hz, actuator_gain }
    }

    /// Command to tilt, command channel not counted.
    pub(super) fn closed(&self, hz: f64) -> Complex64 {
        let s = Complex64::new(0.0, TAU * hz);
        let (travel, [tilt, _]) = (self.travel(s), self.mechanism(s));
        if self.is_open() {
            return travel * tilt;
        }
        self.controller(s) * travel * tilt / (1.0 + self.loop_gain(hz))
    }

    pub(super) fn is_stable(&self) -> bool {
        let least = |m: crate::linear::Margins| m.gain_margin_db.min(m.phase_margin_deg);
        self.is_open() || margins(|hz| self.loop_gain(hz), 5.0, 5000.0).is_some_and(|m| least(m) > 0.0)
    }

    /// Mean delay of what is slow.
    pub(super) fn delay_s(&self) -> f64 {
        const SLOW_HZ: f64 = 8.0;
        -self.closed(SLOW_HZ).arg() / (TAU * SLOW_HZ)
    }

    fn is_open(&self) -> bool {
        self.settings.strain_gauge_loop_switch < 0.5
    }

    fn loop_gain(&self, hz: f64) -> Complex64 {
        let s = Complex64::new(0.0, TAU * hz);
        let departure = self.settings.gauge_departure_ratio;
        let gauge = departure + (1.0 - departure) * self.mechanism(s)[1];
        self.controller(s) * self.travel(s) * gauge / (1.0 + s / (TAU * self.settings.gauge_cutoff_hz))
    }

    /// PI + I² by backward Euler, notch, delay inside the loop.
    fn controller(&self, s: Complex64) -> Complex64 {
        let m = self.settings;
        let sum = self.period_s / (1.0 - (-s * self.period_s).exp());
        let law = m.proportional_gain_ratio
            + m.integral_gain_per_s * sum
            + m.double_integral_gain_per_s2 * sum * sum;
        let notch_omega = TAU * m.notch_frequency_hz[self.axis];
        let second = |damping: f64| s * s + 2.0 * damping * notch_omega * s + notch_omega * notch_omega;
        let notch = if m.notch_switch >= 0.5 {
            second(m.notch_numerator_damping_ratio) / second(m.notch_denominator_damping_ratio)
        } else {
            Complex64::new(1.0, 0.0)
        };
        law * notch * (-s * m.loop_delay_s).exp()
    }

    /// Demand to travel of the stacks: hold, amplifier, hysteresis.
    fn travel(&self, s: Complex64) -> Complex64 {
        let held = (-s * 0.5 * self.period_s).exp();
        held * self.actuator_gain / (1.0 + s / (TAU * self.settings.amplifier_cutoff_hz))
    }

    /// Travel to tilt, absolute and relative to the support (the equations of the simulated mechanism).
    fn mechanism(&self, s: Complex64) -> [Complex64; 2] {
        let m = self.settings;
        let omega = TAU * m.frequency_hz[self.axis];
        let support = TAU * m.support_frequency_hz;
        let stand = s * s + 2.0 * m.support_damping_ratio * support * s + support * support;
        let moved = m.support_coupling_ratio * s * s / stand;
        let share = 1.0 + moved;
        let stiff = omega * omega + 2.0 * m.damping_ratio[self.axis] * omega * s;
        let relative = share * omega * omega / (s * s + share * stiff);
        [relative * (1.0 - moved / share), relative]
    }

    fn level_db(&self, hz: f64) -> f64 {
        20.0 * self.closed(hz).norm().log10()
    }

    /// First frequency 3 dB below the command, within a microhertz.
    fn bandwidth_hz(&self) -> f64 {
        const HIGHEST_HZ: u32 = 2000;
        const HALVINGS: u32 = 20;
        let is_below = |hz: f64| self.level_db(hz) < -3.0;
        let Some(below) = (1..=HIGHEST_HZ).map(f64::from).find(|hz| is_below(*hz)) else {
            return f64::from(HIGHEST_HZ);
        };
        let halved = |[above, below]: [f64; 2], _| {
            let middle = 0.5 * (above + below);
            if is_below(middle) { [above, middle] } else { [middle, below] }
        };
        (0..HALVINGS).fold([below - 1.0, below], halved)[1]
    }
}
