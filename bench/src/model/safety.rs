//! What the safety of an axis rests on: the figures that the interlocks and the computation of stops use, and for each of
//! them its key in a rig file, its range and its reason.
//!
//! A further limit is a field of [`Safety`] and a row of [`SAFETY_PARAMETERS`]. Reading, range check, schema and `bench
//! explain rig` come from the row; interlocks find the field in the guard of their axis.

use procedures::quantity::QuantityKind as K;

use super::stopping::{LeastFriction, Loads};

/// How an axis is left when nothing commands it any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SafeState {
    /// Torque on, standing still (quick stop active).
    Hold,
    /// Torque off.
    Release,
}

/// What interlocks and stops of one axis rely on, SI units; [`SAFETY_PARAMETERS`] says what each is.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct Safety {
    pub trip_velocity_rad_per_s: f64,
    pub trip_acceleration_rad_per_s2: f64,
    pub braking_deceleration_rad_per_s2: f64,
    pub stop_jerk_rad_per_s3: f64,
    pub continuous_torque_nm: f64,
    pub thermal_time_s: f64,
    pub max_following_error_rad: f64,
    pub max_rate_disagreement_rad_per_s: f64,
    pub max_heat_sink_degc: f64,
    pub bus_voltage_v: [f64; 2],
    pub watchdog_s: f64,
    pub friction: LeastFriction,
    pub loads: Loads,
    pub brake_nm: f64,
    pub end_stop_energy_j: f64,
    pub polarity_torque_nm: f64,
    pub zero_tolerance_rad: f64,
    pub presliding_stiffness_nm_per_rad: f64,
    pub safe_state: SafeState,
    pub safe_pose_rad: Option<f64>,
}

impl Safety {
    /// Every figure NaN, to be filled in by the reader of the file.
    pub(crate) fn blank() -> Self {
        let nan = f64::NAN;
        Self {
            trip_velocity_rad_per_s: nan,
            trip_acceleration_rad_per_s2: nan,
            braking_deceleration_rad_per_s2: nan,
            stop_jerk_rad_per_s3: nan,
            continuous_torque_nm: nan,
            thermal_time_s: nan,
            max_following_error_rad: nan,
            max_rate_disagreement_rad_per_s: nan,
            max_heat_sink_degc: nan,
            bus_voltage_v: [nan; 2],
            watchdog_s: nan,
            friction: LeastFriction { static_nm: nan, coulomb_nm: nan, viscous_nm_s_per_rad: nan },
            loads: Loads { unbalance_nm: nan, spring_nm_per_rad: nan, spring_rest_rad: nan },
            brake_nm: nan,
            end_stop_energy_j: nan,
            polarity_torque_nm: nan,
            zero_tolerance_rad: nan,
            presliding_stiffness_nm_per_rad: nan,
            safe_state: SafeState::Hold,
            safe_pose_rad: None,
        }
    }
}

/// What a key of the table holds, and where it goes.
#[derive(Clone, Copy)]
pub(crate) enum Holds {
    /// One quantity.
    Quantity(K, fn(&mut Safety) -> &mut f64),
    /// A band.
    Band(K, fn(&mut Safety) -> &mut [f64; 2]),
    /// `hold` or `release`.
    SafeState,
    /// An angle that may be left out.
    Pose,
}

/// One safety parameter of an axis: a key of `[axis.<name>.safety]`.
pub struct SafetyParameter {
    /// Key in the rig file.
    pub key: &'static str,
    pub(crate) holds: Holds,
    /// What it is, one sentence.
    pub doc: &'static str,
    /// What to start from: a value, or a rule in words where every rig has its own.
    pub recommended: &'static str,
    /// Least value, as a person would write it; empty where there is none.
    pub least: &'static str,
    /// Largest value.
    pub most: &'static str,
    /// Why that value, and why that range.
    pub reason: &'static str,
}

/// Every key of `[axis.<name>.safety]`.
pub const SAFETY_PARAMETERS: &[SafetyParameter] = &[
    SafetyParameter {
        key: "trip-velocity",
        holds: Holds::Quantity(K::AngularVelocity, |s| &mut s.trip_velocity_rad_per_s),
        doc: "Rate at which the bench trips; also the drive's own speed limit (6080h).",
        recommended: "66 deg/s",
        least: "0.1 deg/s",
        most: "200 deg/s",
        reason: "moves of 60 deg/s (MOT-VEL) overshoot by a few percent, and every further degree per \
                 second lengthens the stopping distance",
    },
    SafetyParameter {
        key: "trip-acceleration",
        holds: Holds::Quantity(K::AngularAcceleration, |s| &mut s.trip_acceleration_rad_per_s2),
        doc: "Acceleration at which the bench trips (from the encoder's rate, smoothed over 4 ms).",
        recommended: "200 deg/s^2",
        least: "1 deg/s^2",
        most: "2000 deg/s^2",
        reason: "full torque accelerates the rigid axis at about 120 deg/s^2 and structural ringing adds \
                 to it; anything faster is an impact or a jumping encoder",
    },
    SafetyParameter {
        key: "braking-deceleration",
        holds: Holds::Quantity(K::AngularAcceleration, |s| &mut s.braking_deceleration_rad_per_s2),
        doc: "Deceleration that a stop can rely on (6085h).",
        recommended: "100 deg/s^2",
        least: "1 deg/s^2",
        most: "1000 deg/s^2",
        reason: "it must exceed the acceleration of profiles (93 deg/s^2 to show the 90 of MOT-ACC) and \
                 stay below what the motor delivers without the help of friction",
    },
    SafetyParameter {
        key: "stop-jerk",
        holds: Holds::Quantity(K::AngularJerk, |s| &mut s.stop_jerk_rad_per_s3),
        doc: "Jerk at the start of a controlled stop.",
        recommended: "9000 deg/s^3",
        least: "50 deg/s^3",
        most: "1e6 deg/s^3",
        reason: "full braking within 11 ms costs little angle (0.3 deg at 60 deg/s) and excites the \
                 structure less than a step",
    },
    SafetyParameter {
        key: "continuous-torque",
        holds: Holds::Quantity(K::Torque, |s| &mut s.continuous_torque_nm),
        doc: "Torque that motor and drive can sustain (root mean square over thermal-time).",
        recommended: "1.5 times torque-constant times the RMS current of MOT-CUR (1278 N*m azimuth, 1310 N*m elevation)",
        least: "1 N*m",
        most: "10000 N*m",
        reason: "above the requirement, so that a run can fail it; beyond this value the winding overheats \
                 in the long run, however cool the heat sink is",
    },
    SafetyParameter {
        key: "thermal-time",
        holds: Holds::Quantity(K::Time, |s| &mut s.thermal_time_s),
        doc: "Time constant of the mean of torque squared (I2t).",
        recommended: "60 s",
        least: "1 s",
        most: "3600 s",
        reason: "shorter than the winding of a direct drive: a few seconds of full torque (PWR-BUS allows 3 s) pass, a \
                 minute of it does not",
    },
    SafetyParameter {
        key: "max-following-error",
        holds: Holds::Quantity(K::Angle, |s| &mut s.max_following_error_rad),
        doc: "Difference of position reference and position at which the bench trips.",
        recommended: "3 deg",
        least: "10 urad",
        most: "10 deg",
        reason: "an axis at its torque limit lags by 1.5 deg on the way to 60 deg/s; with twice that error \
                 it is no longer under control",
    },
    SafetyParameter {
        key: "max-rate-disagreement",
        holds: Holds::Quantity(K::AngularVelocity, |s| &mut s.max_rate_disagreement_rad_per_s),
        doc: "Difference of gyro rate and encoder rate, smoothed over 20 ms, at which the bench trips.",
        recommended: "2.3 deg/s",
        least: "0 deg/s",
        most: "20 deg/s",
        reason: "ten times what bending and the difference of their delays cause; with a wrong sign it is \
                 exceeded within a degree",
    },
    SafetyParameter {
        key: "max-heat-sink",
        holds: Holds::Quantity(K::Temperature, |s| &mut s.max_heat_sink_degc),
        doc: "Heat sink temperature at which the bench trips.",
        recommended: "83 degC",
        least: "30 degC",
        most: "85 degC",
        reason: "above the requirement (80 degC, THM-SINK), so that a run can fail it, and below 86 degC, \
                 where the drive shuts down by itself and the axis coasts",
    },
    SafetyParameter {
        key: "bus-voltage",
        holds: Holds::Band(K::Voltage, |s| &mut s.bus_voltage_v),
        doc: "Voltage band of the DC link; the bench trips outside it.",
        recommended: "450 V .. 680 V",
        least: "300 V",
        most: "800 V",
        reason: "outside the requirement (480 V .. 620 V, PWR-BUS), so that a run can fail it, and inside \
                 the drive's own trips, after which no torque is left to stop with",
    },
    SafetyParameter {
        key: "process-data-watchdog",
        holds: Holds::Quantity(K::Time, |s| &mut s.watchdog_s),
        doc: "Watchdog time written to the drive (2F00h); also the age at which data count as stale.",
        recommended: "20 ms",
        least: "0.1 ms",
        most: "50 ms",
        reason: "an axis at 60 deg/s turns 1.2 deg uncontrolled in that time; the drive's own 100 ms would be 6 deg",
    },
    SafetyParameter {
        key: "least-static-friction",
        holds: Holds::Quantity(K::Torque, |s| &mut s.friction.static_nm),
        doc: "Guaranteed minimum of static friction.",
        recommended: "0.9 times the smallest breakaway torque measured",
        least: "0 N*m",
        most: "5000 N*m",
        reason: "it decides where an axis may be released; with less friction than assumed the axis swings",
    },
    SafetyParameter {
        key: "least-running-friction",
        holds: Holds::Quantity(K::Torque, |s| &mut s.friction.coulomb_nm),
        doc: "Guaranteed minimum of running friction.",
        recommended: "0.9 times the smallest friction measured at 2 deg/s",
        least: "0 N*m",
        most: "5000 N*m",
        reason: "it alone slows down an axis without torque; 0 is always safe",
    },
    SafetyParameter {
        key: "least-viscous-friction",
        holds: Holds::Quantity(K::Damping, |s| &mut s.friction.viscous_nm_s_per_rad),
        doc: "Guaranteed minimum of viscous friction.",
        recommended: "0.9 times the slope of friction over rate measured",
        least: "0 N*m*s/rad",
        most: "5000 N*m*s/rad",
        reason: "it contributes most to slowing down a fast axis without torque; 0 is always safe",
    },
    SafetyParameter {
        key: "unbalance",
        holds: Holds::Quantity(K::Torque, |s| &mut s.loads.unbalance_nm),
        doc: "Unbalance at angle 0, with the sign of the torque that it exerts.",
        recommended: "as measured (UNB); 0 N*m for a levelled azimuth",
        least: "-1000 N*m",
        most: "1000 N*m",
        reason: "it moves a released axis, and it reduces the torque that is left for braking",
    },
    SafetyParameter {
        key: "spring-rate",
        holds: Holds::Quantity(K::Stiffness, |s| &mut s.loads.spring_nm_per_rad),
        doc: "Rate of the cable spring.",
        recommended: "the stiffest measured (SPR); 54 N*m/rad for elevation",
        least: "0 N*m/rad",
        most: "5000 N*m/rad",
        reason: "at an end of the travel it can exceed static friction: the axis then swings back when it \
                 is released",
    },
    SafetyParameter {
        key: "spring-rest",
        holds: Holds::Quantity(K::Angle, |s| &mut s.loads.spring_rest_rad),
        doc: "Rest angle of the cable spring.",
        recommended: "as measured; 40 deg for elevation",
        least: "-360 deg",
        most: "360 deg",
        reason: "it decides at which end of the travel the spring pulls hardest",
    },
    SafetyParameter {
        key: "brake-torque",
        holds: Holds::Quantity(K::Torque, |s| &mut s.brake_nm),
        doc: "Torque of a brake that engages without power; 0 without a brake.",
        recommended: "0 N*m",
        least: "0 N*m",
        most: "20000 N*m",
        reason: "only a tested brake may be relied on",
    },
    SafetyParameter {
        key: "end-stop-energy",
        holds: Holds::Quantity(K::Energy, |s| &mut s.end_stop_energy_j),
        doc: "Energy that the end stops absorb without damage; 0 for bare stops.",
        recommended: "0 J unless the stops are buffers with a data sheet",
        least: "0 J",
        most: "20000 J",
        reason: "it decides how fast an axis may approach an end that it would hit without torque",
    },
    SafetyParameter {
        key: "zero-tolerance",
        holds: Holds::Quantity(K::Angle, |s| &mut s.zero_tolerance_rad),
        doc: "Largest difference between the encoder and the angle read from the axis' own scale before \
              the first motion; the encoder zero is verified to this tolerance.",
        recommended: "0.25 deg",
        least: "0.01 deg",
        most: "2 deg",
        reason: "everything that keeps an axis inside its travel is computed from the encoder, so the soft \
                 limits must lie farther inside than its zero may be wrong; a scale can be read to a \
                 quarter of a degree",
    },
    SafetyParameter {
        key: "polarity-torque",
        holds: Holds::Quantity(K::Torque, |s| &mut s.polarity_torque_nm),
        doc: "Largest torque of the polarity check.",
        recommended: "1.2 times the largest breakaway torque that the axis may have",
        least: "1 N*m",
        most: "5000 N*m",
        reason: "signs are not proven yet, so it must just break the axis away and not accelerate it",
    },
    SafetyParameter {
        key: "presliding-stiffness",
        holds: Holds::Quantity(K::Stiffness, |s| &mut s.presliding_stiffness_nm_per_rad),
        doc: "Expected stiffness of the axis at rest under a small torque.",
        recommended: "as identified (90000 N*m/rad azimuth, 50000 N*m/rad elevation)",
        least: "100 N*m/rad",
        most: "1e7 N*m/rad",
        reason: "it determines how far the first pulses of the polarity check move an axis that does not slide yet",
    },
    SafetyParameter {
        key: "safe-state",
        holds: Holds::SafeState,
        doc: "State in which the axis is left.",
        recommended: "hold",
        least: "",
        most: "",
        reason: "an axis that is held stays in place; a disabled axis may move",
    },
    SafetyParameter {
        key: "safe-pose",
        holds: Holds::Pose,
        doc: "Where the axis is parked before it is released; may be left out.",
        recommended: "an angle at which unbalance and spring cancel",
        least: "-360 deg",
        most: "360 deg",
        reason: "where friction does not hold the axis everywhere, it must be parked where friction holds it",
    },
];
