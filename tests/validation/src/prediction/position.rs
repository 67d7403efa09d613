//! Positioning: accuracy, repeatability, ramp tracking, overshoot, resolution.

use num_complex::Complex64;
use sim_devices::unit::AxisSettings;

use super::{Expected, Subject, rig_limits, row, servo};

const DEG: f64 = std::f64::consts::PI / 180.0;
/// Ramp of POS-TRK.
const RAMP_RAD_PER_S: f64 = 0.674 * DEG;
/// Polygon and autocollimator (director.md, POS-ACC: U ≤ 6 µrad).
const REFERENCE_U_RAD: f64 = 6e-6;
/// Encoder against itself: counts, their noise, and five runs.
const ENCODER_U_RAD: f64 = 1e-6;
/// Gyros over a stroke of some ten seconds, random walk 3 µrad/√s.
const PITCH_U_RAD: f64 = 0.05e-6;
/// Mean over a record that the cogging does not divide.
const RAMP_U_RAD: f64 = 3e-6;
/// Spread of ISO 230-2: four standard deviations of the runs.
const SPREAD: f64 = 4.0;

pub(super) fn rows(subject: &Subject<'_>) -> Vec<Expected> {
    (0..2).flat_map(|axis| axis_rows(subject, axis)).collect()
}

fn axis_rows(subject: &Subject<'_>, axis: usize) -> Vec<Expected> {
    let settings = subject.axis(axis);
    let repeat_rad = SPREAD * deviation_rad(subject, axis);
    let accuracy_rad = scale_error_range_rad(settings, rig_limits::SOFT_RAD[axis]) + repeat_rad;
    let count_rad = std::f64::consts::TAU / settings.encoder_bits_count.exp2().round();
    vec![
        row("POS-ACC", axis, "accuracy", "against the external reference", accuracy_rad, REFERENCE_U_RAD),
        row("POS-REP", axis, "repeatability", "", repeat_rad, ENCODER_U_RAD),
        row("POS-TRK", axis, "ramp-error", "0.674 deg/s", ramp_error_rad(subject, axis), RAMP_U_RAD),
        row("POS-OVS", axis, "overshoot", "", servo::overshoot_rad(subject, axis), 0.3 * ENCODER_U_RAD),
        row("ENC-RES", axis, "resolution", "", count_rad, 0.0),
        row("ENC-PITCH", axis, "encoder-pitch-error", "", settings.encoder_interpolation_rad, PITCH_U_RAD),
    ]
}

/// Range of the scale's error over the travel: once and twice a turn, and both ends of the interpolation error.
fn scale_error_range_rad(axis: &AxisSettings, [low, high]: [f64; 2]) -> f64 {
    let errors = (0..=400).map(|k| encoder_error_rad(axis, low + (high - low) * f64::from(k) / 400.0));
    let (least, most) =
        errors.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), e| (low.min(e), high.max(e)));
    most - least + 2.0 * axis.encoder_interpolation_rad
}

/// What an encoder shows too much at an angle, but for its zero and its pitches.
pub(crate) fn encoder_error_rad(axis: &AxisSettings, angle_rad: f64) -> f64 {
    axis.encoder_eccentricity_rad * (angle_rad + axis.encoder_eccentricity_phase_rad).sin()
        + axis.encoder_second_order_rad * (2.0 * angle_rad + axis.encoder_second_order_phase_rad).sin()
}

/// Standard deviation of where moves end: the gyro's angle random walk under the position gain, `N/√(2k)`, the bias that
/// the Earth-rate compensation does not know, over k, and the quantum of the torque on the bristles.
fn deviation_rad(subject: &Subject<'_>, axis: usize) -> f64 {
    let settings = subject.axis(axis);
    let imu = &subject.unit.imu;
    let gain = subject.gains(axis).position_gain_per_s;
    let walk = imu.gyro_random_walk_rad_per_sqrt_s * imu.gyro_noise_factor / (2.0 * gain).sqrt();
    let bias = imu.gyro_bias_rad_per_s.iter().fold(0.0, |most: f64, b| most.max(b.abs())) / gain;
    let quantum_rad = 1e-3 * settings.rated_torque_nm / settings.bristle_stiffness_nm_per_rad;
    walk.hypot(bias).hypot(quantum_rad / 12.0_f64.sqrt())
}

/// Error of a ramp with velocity feed-forward against the true angle: the encoder's age, the gyro's scale error over the
/// position gain, and the cogging that the velocity loop lets through.
fn ramp_error_rad(subject: &Subject<'_>, axis: usize) -> f64 {
    let settings = subject.axis(axis);
    let age_s = settings.sensor_delay_s + 0.5 * settings.velocity_window_s;
    let scale = subject.unit.imu.gyro_scale_error_ratio.iter().fold(0.0, |most: f64, e| most.max(e.abs()));
    let steady = RAMP_RAD_PER_S * (age_s + scale / subject.gains(axis).position_gain_per_s);
    let lines = [(1.0, settings.cogging_amplitude_nm), (2.0, settings.cogging_second_amplitude_nm)];
    let cogging = lines.map(|(harmonic, torque_nm)| {
        let hz = harmonic * settings.cogging_orders_per_rev * RAMP_RAD_PER_S / std::f64::consts::TAU;
        torque_nm * compliance_rad_per_nm(subject, axis, hz)
    });
    steady + cogging[0] + cogging[1]
}

/// Torque on the shaft to its angle, both loops closed.
fn compliance_rad_per_nm(subject: &Subject<'_>, axis: usize, hz: f64) -> f64 {
    let velocity = servo::velocity(subject, axis, 0.0);
    let s = Complex64::new(0.0, std::f64::consts::TAU * hz);
    let rate = velocity.plant.shaft(s) / (1.0 + velocity.open(hz));
    let aged = (-s * subject.axis(axis).sensor_delay_s).exp();
    let gain = subject.gains(axis).position_gain_per_s;
    (rate / (s + gain * velocity.command_to_shaft(hz) * aged)).norm()
}
