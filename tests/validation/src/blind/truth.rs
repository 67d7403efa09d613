//! What is true of a drawn unit: findings whose truth is a setting, a closed function of settings, or what the linear model of
//! its loops says.

pub(super) mod drivetrain;
pub(super) mod inertial;
mod loops;
mod mirror;

use procedures::measurement::Measurement;
use sim_devices::unit::{AxisSettings, UnitSettings};

use crate::prediction::cogging_peak_nm;

/// A measurand with a truth.
#[derive(Clone, Copy)]
pub struct Known {
    /// The measurand.
    pub measurand: &'static str,
    /// What it is true for.
    truth: fn(&Measurement, &UnitSettings) -> Option<f64>,
    /// Where that comes from.
    pub why: &'static str,
}

const fn known(
    measurand: &'static str,
    truth: fn(&Measurement, &UnitSettings) -> Option<f64>,
    why: &'static str,
) -> Known {
    Known { measurand, truth, why }
}

/// Every measurand that is scored. What the linear model knows less well than the bench measures it is not: the mirror's bandwidth
/// and attenuation and the rejection of tip-tilt (its hysteresis answers a multisine, a sine and a few microradians each in its own
/// way), margins of the track loop (frames that wait for the law).
#[rustfmt::skip]
pub const KNOWN: &[Known] = &[
    known("friction-torque", drivetrain::friction_nm, "steady torque of the contact at the rate that was reached"),
    known("pulled-friction-torque", drivetrain::friction_nm, "as for friction-torque"),
    known("friction-unevenness", drivetrain::unevenness, "spot over a cogging period, less what it adds on average"),
    known("viscous-coefficient", |m, unit| Some(axis(m, unit)?.viscous_damping_nm_s_per_rad), "setting"),
    known("torque-constant", |m, unit| Some(axis(m, unit)?.torque_constant_nm_per_a), "setting"),
    known("torque-constant-error", drivetrain::torque_constant_error, "setting over what the rig file says"),
    known("unbalance-torque", drivetrain::unbalance_nm, "setting; of an axis that turns all around, its amplitude"),
    known("spring-stiffness", |m, unit| Some(axis(m, unit)?.spring_stiffness_nm_per_rad), "setting"),
    known("spring-torque", drivetrain::spring_torque_nm, "stiffness and rest, at the end of the travel that is farther from it"),
    known("cogging-amplitude", |m, unit| Some(axis(m, unit)?.cogging_amplitude_nm), "setting of the strongest line"),
    known("cogging-harmonic", drivetrain::cogging_harmonic_nm, "setting of the line of that order"),
    known("cogging-phase", drivetrain::cogging_phase_rad, "setting of the line of that order, as the encoder's zero shifts it"),
    known("cogging-peak", |m, unit| Some(cogging_peak_nm(axis(m, unit)?)), "largest sum of the lines over a turn"),
    known("cogging-order", |m, unit| Some(axis(m, unit)?.cogging_orders_per_rev), "setting"),
    known("bristle-stiffness", |m, unit| Some(axis(m, unit)?.bristle_stiffness_nm_per_rad), "setting"),
    known("presliding-damping", |m, unit| axis(m, unit).map(|axis| axis.bristle_damping_nm_s_per_rad + axis.viscous_damping_nm_s_per_rad), "sum of two settings, as the measurand is"),
    known("apparent-inertia", drivetrain::warm_apparent_inertia_kg_m2, "inertia over the rigid gain at the elevation, by what an ampere is worth in the rig file; the motor is warm"),
    known("small-motion-inertia", drivetrain::apparent_inertia_kg_m2, "as for apparent-inertia, before the motor is warm"),
    known("breakaway-torque", drivetrain::breakaway_nm, "largest torque of the contact on a ramp of this rate, axis rigid, azimuth alone: elevation has a load"),
    known("current-bandwidth", |m, unit| Some(axis(m, unit)?.current_bandwidth_hz), "setting"),
    known("transport-round-trip", drivetrain::round_trip_s, "delays of the drive and one exchange"),
    known("transport-jitter", drivetrain::transport_jitter_s, "deviation of a uniform distribution of that width, in whole steps"),
    known("encoder-pitch-error", |m, unit| Some(axis(m, unit)?.encoder_interpolation_rad), "setting"),
    known("encoder-bits", |m, unit| Some(axis(m, unit)?.encoder_bits_count), "setting"),
    known("encoder-resolution", |m, unit| Some(std::f64::consts::TAU / axis(m, unit)?.encoder_bits_count.exp2().round()), "a turn over the counts of it"),
    known("coarse-frames-missing", |_, unit| Some(unit.trackers.coarse.dropped_ratio).filter(|ratio| *ratio == 0.0), "setting, where no frame is lost: which ones are is chance"),
    known("fine-frames-missing", |_, unit| Some(unit.trackers.fine.dropped_ratio).filter(|ratio| *ratio == 0.0), "setting, where no frame is lost: which ones are is chance"),
    known("lost-motion", |m, unit| Some(axis(m, unit)?.encoder_backlash_rad), "setting"),
    known("encoder-slip", |m, unit| Some(axis(m, unit)?.encoder_slip_ratio), "setting"),
    known("angle-random-walk", |_, unit| Some(unit.imu.gyro_random_walk_rad_per_sqrt_s * unit.imu.gyro_noise_factor), "setting"),
    known("gyro-step", |_, unit| Some(unit.imu.gyro_quantum_rad_per_s), "setting"),
    known("gyro-encoder-delay", inertial::gyro_encoder_delay_s, "delays of both, and the exchange after which a message of the gyros is read"),
    known("gyro-scale-error", inertial::gyro_scale_error, "settings of scale and lean, along the axis that turned"),
    known("gyro-mapping-error", inertial::gyro_mapping_error_rad, "settings of mount, scale and lean, across the axis that turned"),
    known("elevation-zero-error", inertial::elevation_zero_rad, "zero of the encoder and lean of the inertial unit"),
    known("accelerometer-bias", inertial::accelerometer_bias_m_per_s2, "settings, along the directions"),
    known("first-mode-frequency", loops::mode_frequency_hz, "setting at the elevation"),
    known("second-mode-frequency", loops::mode_frequency_hz, "setting at the elevation"),
    known("third-mode-frequency", loops::mode_frequency_hz, "setting at the elevation"),
    known("fourth-mode-frequency", loops::mode_frequency_hz, "setting at the elevation"),
    known("mode-1-departure", loops::mode_departure, "setting at the elevation over the calculated frequency"),
    known("mode-2-departure", loops::mode_departure, "setting at the elevation over the calculated frequency"),
    known("mode-3-departure", loops::mode_departure, "setting at the elevation over the calculated frequency"),
    known("velocity-bandwidth", loops::velocity_bandwidth_hz, "linear model, mean over the strokes of elevation"),
    known("velocity-gain-margin", loops::velocity_gain_margin_db, "linear model, mean over the strokes of elevation"),
    known("velocity-phase-margin", loops::velocity_phase_margin_rad, "linear model, mean over the strokes of elevation"),
    known("track-bandwidth", loops::track_bandwidth_hz, "linear model"),
    known("tracker-latency", mirror::tracker_latency_s, "setting of the tracker that was looked at, and half the spread of its messages"),
    known("tracker-jitter", mirror::tracker_jitter_s, "deviation of a uniform distribution of that width"),
    known("tracker-scale-error", |_, unit| Some(unit.trackers.coarse.scale_ratio - 1.0), "setting"),
    known("optical-gain", |m, unit| Some([unit.trackers.optical_gain_cross_elevation_ratio, unit.trackers.optical_gain_elevation_ratio][place(m)?]), "setting"),
    known("optical-gain-departure", mirror::optical_gain_departure, "setting over what the fine loop believes, and what the mirror makes of its command"),
    known("mirror-mode", |m, unit| Some(unit.mirror.frequency_hz[place(m)?]), "setting"),
    known("mirror-mode-departure", mirror::mode_departure, "setting over the calculated frequency"),
    known("mirror-mode-damping", |_, unit| Some(unit.mirror.bare_damping_ratio), "setting"),
    known("mirror-coupling", mirror::coupling_ratio, "motional over whole capacitance at the series resonance, the dielectric as it is there"),
    known("mirror-capacitance", mirror::capacitance_f, "reactance of the circuit at 20 Hz"),
    known("mirror-stroke", mirror::stroke_rad, "range of the amplifier through the hysteresis, or the stop"),
];

/// Truth of a finding; `None` where no setting says it.
pub fn of(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let known = KNOWN.iter().find(|known| known.measurand == m.measurand)?;
    (known.truth)(m, unit).filter(|truth| truth.is_finite())
}

/// 0 azimuth, 1 elevation.
fn place(m: &Measurement) -> Option<usize> {
    ["az", "el"].iter().position(|name| *name == m.axis)
}

fn axis<'a>(m: &Measurement, unit: &'a UnitSettings) -> Option<&'a AxisSettings> {
    Some([&unit.az, &unit.el][place(m)?])
}

/// A condition as it was reached.
fn at(m: &Measurement, name: &str) -> Option<f64> {
    let condition = m.conditions.iter().find(|condition| condition.name == name)?;
    Some(condition.achieved.unwrap_or(condition.requested))
}
