//! What a rig file says about stopping: the table `[axis.*.safety]`. None of it may be left out.

use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape, TableReader};

use super::SafeState;
use crate::stopping::{LeastFriction, Loads};

const fn quantity(key: &'static str, kind: K, doc: &'static str) -> Field {
    Field::required(key, Shape::Quantity(kind), doc)
}

/// Keys of `[axis.az.safety]` and `[axis.el.safety]`.
pub const SAFETY_FIELDS: &[Field] = &[
    quantity(
        "trip-velocity",
        K::AngularVelocity,
        "Rate that trips; also the drive's own speed limit (6080h).",
    ),
    quantity("trip-acceleration", K::AngularAcceleration, "Acceleration that trips."),
    quantity("braking-deceleration", K::AngularAcceleration, "Deceleration that a stop can rely on (6085h)."),
    quantity("stop-jerk", K::AngularJerk, "Jerk with which a controlled stop sets in."),
    quantity("continuous-torque", K::Torque, "Torque that motor and drive bear for good."),
    quantity("thermal-time", K::Time, "Time constant of the mean of torque squared (I2t)."),
    quantity("max-following-error", K::Angle, "Position reference less position that trips."),
    quantity("max-rate-disagreement", K::AngularVelocity, "Gyro rate less encoder rate that trips."),
    quantity("max-heat-sink", K::Temperature, "Heat sink temperature that trips."),
    Field::required("bus-voltage", Shape::Range(K::Voltage), "Band of the DC link; outside it trips."),
    quantity(
        "process-data-watchdog",
        K::Time,
        "Written to the drive (2F00h); also the age at which data are stale.",
    ),
    quantity("least-static-friction", K::Torque, "Static friction that the axis has at the very least."),
    quantity("least-running-friction", K::Torque, "Running friction that it has at the very least."),
    quantity("least-viscous-friction", K::Damping, "Viscous friction that it has at the very least."),
    quantity("unbalance", K::Torque, "Unbalance at angle 0."),
    quantity("spring-rate", K::Stiffness, "Rate of the cable spring."),
    quantity("spring-rest", K::Angle, "Angle at which the cable spring rests."),
    quantity("brake-torque", K::Torque, "Torque of a brake that falls in without power; 0 without one."),
    quantity(
        "end-stop-energy",
        K::Energy,
        "Energy that the end stops take without damage; 0 for bare stops.",
    ),
    quantity("polarity-torque", K::Torque, "Largest torque of the check of polarity."),
    quantity("presliding-stiffness", K::Stiffness, "Expected stiffness against a small torque from rest."),
    Field::required("safe-state", Shape::Choice(&["hold", "release"]), "How the axis is left."),
    Field::optional(
        "safe-pose",
        Shape::Quantity(K::Angle),
        "Where the axis is parked before it is released.",
    ),
];

/// The table of one axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Safety {
    pub(super) trip_velocity_rad_per_s: f64,
    pub(super) trip_acceleration_rad_per_s2: f64,
    pub(super) braking_deceleration_rad_per_s2: f64,
    pub(super) stop_jerk_rad_per_s3: f64,
    pub(super) continuous_torque_nm: f64,
    pub(super) thermal_time_s: f64,
    pub(super) max_following_error_rad: f64,
    pub(super) max_rate_disagreement_rad_per_s: f64,
    pub(super) max_heat_sink_degc: f64,
    pub(super) bus_voltage_v: [f64; 2],
    pub(super) watchdog_s: f64,
    pub(super) friction: LeastFriction,
    pub(super) loads: Loads,
    pub(super) brake_nm: f64,
    pub(super) end_stop_energy_j: f64,
    pub(super) polarity_torque_nm: f64,
    pub(super) presliding_stiffness_nm_per_rad: f64,
    pub(super) safe_state: SafeState,
    pub(super) safe_pose_rad: Option<f64>,
}

pub(super) fn read(t: &mut TableReader<'_>) -> Option<Safety> {
    let friction = read_friction(t);
    let loads = read_loads(t);
    let safe_state = match t.text("safe-state").as_deref() {
        Some("release") => SafeState::Release,
        _ => SafeState::Hold,
    };
    Some(Safety {
        trip_velocity_rad_per_s: t.positive("trip-velocity")?,
        trip_acceleration_rad_per_s2: t.positive("trip-acceleration")?,
        braking_deceleration_rad_per_s2: t.positive("braking-deceleration")?,
        stop_jerk_rad_per_s3: t.positive("stop-jerk")?,
        continuous_torque_nm: t.positive("continuous-torque")?,
        thermal_time_s: t.positive("thermal-time")?,
        max_following_error_rad: t.positive("max-following-error")?,
        max_rate_disagreement_rad_per_s: t.positive("max-rate-disagreement")?,
        max_heat_sink_degc: t.quantity("max-heat-sink")?,
        bus_voltage_v: t.range("bus-voltage")?,
        watchdog_s: t.positive("process-data-watchdog")?,
        friction: friction?,
        loads: loads?,
        brake_nm: t.quantity("brake-torque")?,
        end_stop_energy_j: t.quantity("end-stop-energy")?,
        polarity_torque_nm: t.positive("polarity-torque")?,
        presliding_stiffness_nm_per_rad: t.positive("presliding-stiffness")?,
        safe_state,
        safe_pose_rad: t.quantity("safe-pose"),
    })
}

fn read_friction(t: &mut TableReader<'_>) -> Option<LeastFriction> {
    Some(LeastFriction {
        static_nm: t.quantity("least-static-friction")?,
        coulomb_nm: t.quantity("least-running-friction")?,
        viscous_nm_s_per_rad: t.quantity("least-viscous-friction")?,
    })
}

fn read_loads(t: &mut TableReader<'_>) -> Option<Loads> {
    Some(Loads {
        unbalance_nm: t.quantity("unbalance")?,
        spring_nm_per_rad: t.quantity("spring-rate")?,
        spring_rest_rad: t.quantity("spring-rest")?,
    })
}
