//! What each measurand says of which settings: a line each.

use super::Finding;
use super::shown::{Shown, drivetrain, inertial, mirror};

/// A measurand, the settings that it depends on, and what a unit shows of it.
#[derive(Clone, Copy)]
pub(super) struct Relation {
    pub(super) measurand: &'static str,
    /// Keys; `*` stands for the axis of the finding.
    pub(super) settings: &'static [&'static str],
    /// What a unit with given settings would show; `None` where the finding says nothing of the settings.
    pub(super) shown: fn(&Shown<'_>) -> Option<f64>,
    /// Whether it is the magnitude of something with a sign or a direction: the solution next to the base is one of several.
    pub(super) is_magnitude: bool,
}

impl Relation {
    /// The relation of a measurand, if it says anything of a unit.
    pub(super) fn of(finding: &Finding<'_>) -> Option<&'static Self> {
        RELATIONS.iter().find(|relation| relation.measurand == finding.measurement.measurand)
    }
}

const fn relation(
    measurand: &'static str,
    settings: &'static [&'static str],
    shown: fn(&Shown<'_>) -> Option<f64>,
) -> Relation {
    Relation { measurand, settings, shown, is_magnitude: false }
}

const fn magnitude(
    measurand: &'static str,
    settings: &'static [&'static str],
    shown: fn(&Shown<'_>) -> Option<f64>,
) -> Relation {
    Relation { is_magnitude: true, ..relation(measurand, settings, shown) }
}

/// Every measurand that says something of a setting. Of values that are computed from the same data one stands for all: friction at
/// each velocity for the parameters of its curve, the lines of cogging for its amplitude, the torque constant for its error.
#[rustfmt::skip]
pub(super) const RELATIONS: &[Relation] = &[
    // Motor, friction, loads.
    relation("torque-constant", &["*.torque-constant"], |s| Some(s.axis()?.torque_constant_nm_per_a)),
    relation("friction-torque", &["*.coulomb-torque", "*.static-torque", "*.stribeck-velocity", "*.stribeck-shape", "*.viscous-damping"], drivetrain::friction_nm),
    relation("breakaway-torque", &["*.static-torque", "*.ageing"], drivetrain::breakaway_nm),
    relation("bristle-stiffness", &["*.bristle-stiffness"], |s| Some(s.axis()?.bristle_stiffness_nm_per_rad)),
    relation("presliding-damping", &["*.bristle-damping", "*.viscous-damping"], |s| Some(s.axis()?.bristle_damping_nm_s_per_rad + s.axis()?.viscous_damping_nm_s_per_rad)),
    relation("apparent-inertia", &["*.inertia", "*.torque-constant"], drivetrain::apparent_inertia_kg_m2),
    relation("small-motion-inertia", &["*.inertia", "*.torque-constant"], drivetrain::apparent_inertia_kg_m2),
    magnitude("unbalance-torque", &["*.unbalance"], |s| Some(s.axis()?.unbalance_nm.abs())),
    relation("spring-stiffness", &["*.spring-stiffness"], |s| Some(s.axis()?.spring_stiffness_nm_per_rad)),
    relation("spring-torque", &["*.spring-stiffness", "*.spring-rest"], drivetrain::spring_nm),
    relation("cogging-order", &["*.cogging-order"], |s| Some(s.axis()?.cogging_orders_per_rev)),
    relation("cogging-harmonic", &["*.cogging-amplitude", "*.cogging-second-amplitude"], drivetrain::cogging_nm),
    relation("cogging-phase", &["*.cogging-phase", "*.cogging-second-phase"], drivetrain::cogging_phase_rad),
    // Drive and encoder.
    relation("current-bandwidth", &["*.current-bandwidth"], |s| Some(s.axis()?.current_bandwidth_hz)),
    relation("current-noise", &["*.current-noise"], drivetrain::current_noise_a),
    relation("transport-round-trip", &["*.command-delay", "*.sensor-delay"], drivetrain::round_trip_s),
    relation("transport-out", &["*.command-delay"], drivetrain::out_s),
    relation("transport-jitter", &["*.delay-jitter"], drivetrain::jitter_s),
    relation("encoder-bits", &["*.encoder-bits"], |s| Some(s.axis()?.encoder_bits_count)),
    relation("encoder-pitch-error", &["*.encoder-interpolation"], |s| s.above_noise(s.axis()?.encoder_interpolation_rad)),
    relation("lost-motion", &["*.encoder-backlash"], |s| s.above_noise(s.axis()?.encoder_backlash_rad)),
    relation("encoder-slip", &["*.encoder-slip"], |s| s.above_noise(s.axis()?.encoder_slip_ratio)),
    relation("elevation-zero-error", &["el.encoder-zero", "imu.misalignment-x", "imu.misalignment-y", "imu.lean-zx", "imu.lean-zy"], inertial::elevation_zero_rad),
    // Inertial unit.
    relation("angle-random-walk", &["imu.gyro-random-walk"], |s| Some(s.unit.imu.gyro_random_walk_rad_per_sqrt_s * s.unit.imu.gyro_noise_factor)),
    relation("gyro-bias", &["imu.gyro-bias-x", "imu.gyro-bias-y", "imu.gyro-bias-z"], inertial::gyro_bias_rad_per_s),
    relation("gyro-encoder-delay", &["imu.delay", "*.sensor-delay"], inertial::gyro_encoder_delay_s),
    relation("gyro-scale-error", &["imu.gyro-scale-error-x", "imu.gyro-scale-error-y", "imu.gyro-scale-error-z", "imu.lean-yx", "imu.lean-zx", "imu.lean-zy"], inertial::gyro_scale_error_ratio),
    magnitude("gyro-mapping-error", &["imu.misalignment-x", "imu.misalignment-y", "imu.misalignment-z"], inertial::gyro_mapping_error_rad),
    relation("accelerometer-bias", &["imu.accelerometer-bias-x", "imu.accelerometer-bias-y", "imu.accelerometer-bias-z"], inertial::accelerometer_bias_m_per_s2),
    // Mirror and trackers.
    relation("mirror-mode", &["mirror.*-frequency"], |s| Some(s.unit.mirror.frequency_hz[s.place()?])),
    relation("mirror-mode-damping", &["mirror.bare-damping"], |s| Some(s.unit.mirror.bare_damping_ratio)),
    relation("mirror-coupling", &["mirror.coupling", "mirror.capacitance"], mirror::coupling_ratio),
    relation("mirror-capacitance", &["mirror.coupling", "mirror.capacitance"], mirror::capacitance_f),
    relation("reaction-resonance", &["mirror.support-frequency"], |s| Some(s.unit.mirror.support_frequency_hz)),
    relation("tracker-latency", &["trackers.coarse-latency", "trackers.fine-latency"], mirror::tracker_latency_s),
    relation("tracker-scale-error", &["trackers.coarse-scale"], |s| Some(s.unit.trackers.coarse.scale_ratio - 1.0)),
    relation("coarse-frames-missing", &["trackers.coarse-dropped"], |s| Some(s.unit.trackers.coarse.dropped_ratio)),
    relation("fine-frames-missing", &["trackers.fine-dropped"], |s| Some(s.unit.trackers.fine.dropped_ratio)),
    relation("optical-gain", &["trackers.optical-gain-cross-elevation", "trackers.optical-gain-elevation"], mirror::optical_gain_ratio),
];
