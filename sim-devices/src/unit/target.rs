//! What the director points at.

use super::UnitSettings;
use drivers::parameter::Parameter;

/// What the director points at.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetSettings {
    /// 0 fixed like a star, 1 rail, 2 drone.
    pub kind_count: f64,
    /// Azimuth at which the target stands at first.
    pub azimuth_rad: f64,
    /// Elevation at which the target stands at first.
    pub elevation_rad: f64,
    /// Horizontal distance of its track from the director, at the nearest point.
    pub distance_m: f64,
    /// Time before it begins to move.
    pub standing_s: f64,
    /// Speed along the rails: 0.674 deg/s seen from 85 m.
    pub rail_speed_m_per_s: f64,
    /// Length of one rail; there is a joint after each.
    pub rail_length_m: f64,
    /// Rails in line.
    pub rail_count: f64,
    /// Time a reversal by hand takes.
    pub rail_reversal_s: f64,
    /// Amplitude of the heave that a joint sets off.
    pub rail_jerk_m: f64,
    /// Frequency of that heave.
    pub rail_jerk_hz: f64,
    /// Time in which it dies to 2 %.
    pub rail_jerk_s: f64,
    /// Unevenness of the speed along the rails, standard deviation.
    pub rail_ripple_ratio: f64,
    /// How far it comes down from the hover.
    pub drone_descent_m: f64,
    /// Speed down and up.
    pub drone_descent_m_per_s: f64,
    /// How far it flies along the rails and back.
    pub drone_run_m: f64,
    /// Speed along the rails.
    pub drone_run_m_per_s: f64,
    /// Time in which its velocity changes.
    pub drone_rise_s: f64,
    /// Time it hovers between two legs.
    pub drone_hover_s: f64,
    /// Amplitude of its heave.
    pub drone_heave_m: f64,
    /// Frequency of its heave.
    pub drone_heave_hz: f64,
    /// Lateral velocity in gusts, standard deviation.
    pub drone_gust_m_per_s: f64,
    /// Fastest gusts; the slowest are ten times slower.
    pub drone_gust_hz: f64,
}

impl Default for TargetSettings {
    /// The unit `nominal`.
    fn default() -> Self {
        Self {
            kind_count: 0.0,
            azimuth_rad: 0.0 * DEG,
            elevation_rad: 0.0 * DEG,
            distance_m: 85.0,
            standing_s: 5.0,
            rail_speed_m_per_s: 1.0,
            rail_length_m: 7.0,
            rail_count: 6.0,
            rail_reversal_s: 0.9,
            rail_jerk_m: 20.0 * 1e-3,
            rail_jerk_hz: 3.0,
            rail_jerk_s: 1.5,
            rail_ripple_ratio: 2.0 * 1e-2,
            drone_descent_m: 5.0,
            drone_descent_m_per_s: 0.25,
            drone_run_m: 20.0,
            drone_run_m_per_s: 1.0,
            drone_rise_s: 0.1,
            drone_hover_s: 8.0,
            drone_heave_m: 30.0 * 1e-3,
            drone_heave_hz: 0.5,
            drone_gust_m_per_s: 0.03,
            drone_gust_hz: 0.5,
        }
    }
}

const DEG: f64 = std::f64::consts::PI / 180.0;

pub(super) const TARGET: &[Parameter<UnitSettings>] = &[
    Parameter {
        key: "target.kind",
        quantity: "count",
        min_si: 0.0,
        max_si: 2.0,
        default: "0",
        doc: "0 fixed like a star, 1 rail, 2 drone.",
        source: "ours: set by what is tracked",
        set: |unit, value| unit.target.kind_count = value,
        get: |unit| unit.target.kind_count,
    },
    Parameter {
        key: "target.azimuth",
        quantity: "angle",
        min_si: -4.0,
        max_si: 4.0,
        default: "0 deg",
        doc: "Azimuth at which the target stands at first.",
        source: "ours",
        set: |unit, value| unit.target.azimuth_rad = value,
        get: |unit| unit.target.azimuth_rad,
    },
    Parameter {
        key: "target.elevation",
        quantity: "angle",
        min_si: -0.2,
        max_si: 1.5,
        default: "0 deg",
        doc: "Elevation at which the target stands at first.",
        source: "ours",
        set: |unit, value| unit.target.elevation_rad = value,
        get: |unit| unit.target.elevation_rad,
    },
    Parameter {
        key: "target.distance",
        quantity: "length",
        min_si: 1.0,
        max_si: 1.0e6,
        default: "85 m",
        doc: "Horizontal distance of its track from the director, at the nearest point.",
        source: "study 4.3",
        set: |unit, value| unit.target.distance_m = value,
        get: |unit| unit.target.distance_m,
    },
    Parameter {
        key: "target.standing",
        quantity: "time",
        min_si: 0.0,
        max_si: 1.0e5,
        default: "5 s",
        doc: "Time before it begins to move.",
        source: "ours",
        set: |unit, value| unit.target.standing_s = value,
        get: |unit| unit.target.standing_s,
    },
    Parameter {
        key: "target.rail-speed",
        quantity: "speed",
        min_si: 0.01,
        max_si: 2.0,
        default: "1 m/s",
        doc: "Speed along the rails: 0.674 deg/s seen from 85 m.",
        source: "study 4.3",
        set: |unit, value| unit.target.rail_speed_m_per_s = value,
        get: |unit| unit.target.rail_speed_m_per_s,
    },
    Parameter {
        key: "target.rail-length",
        quantity: "length",
        min_si: 3.0,
        max_si: 100.0,
        default: "7 m",
        doc: "Length of one rail; there is a joint after each.",
        source: "study 4.3",
        set: |unit, value| unit.target.rail_length_m = value,
        get: |unit| unit.target.rail_length_m,
    },
    Parameter {
        key: "target.rail-count",
        quantity: "count",
        min_si: 1.0,
        max_si: 100.0,
        default: "6",
        doc: "Rails in line.",
        source: "ours",
        set: |unit, value| unit.target.rail_count = value,
        get: |unit| unit.target.rail_count,
    },
    Parameter {
        key: "target.rail-reversal",
        quantity: "time",
        min_si: 0.01,
        max_si: 10.0,
        default: "0.9 s",
        doc: "Time a reversal by hand takes.",
        source: "ours: error peaks of 0.08 deg",
        set: |unit, value| unit.target.rail_reversal_s = value,
        get: |unit| unit.target.rail_reversal_s,
    },
    Parameter {
        key: "target.rail-jerk",
        quantity: "length",
        min_si: 0.0,
        max_si: 0.5,
        default: "20 mm",
        doc: "Amplitude of the heave that a joint sets off.",
        source: "ours: elevation error of the study",
        set: |unit, value| unit.target.rail_jerk_m = value,
        get: |unit| unit.target.rail_jerk_m,
    },
    Parameter {
        key: "target.rail-jerk-frequency",
        quantity: "frequency",
        min_si: 0.1,
        max_si: 20.0,
        default: "3 Hz",
        doc: "Frequency of that heave.",
        source: "study 4.3",
        set: |unit, value| unit.target.rail_jerk_hz = value,
        get: |unit| unit.target.rail_jerk_hz,
    },
    Parameter {
        key: "target.rail-jerk-duration",
        quantity: "time",
        min_si: 0.1,
        max_si: 3.0,
        default: "1.5 s",
        doc: "Time in which it dies to 2 %.",
        source: "study 4.3",
        set: |unit, value| unit.target.rail_jerk_s = value,
        get: |unit| unit.target.rail_jerk_s,
    },
    Parameter {
        key: "target.rail-ripple",
        quantity: "ratio",
        min_si: 0.0,
        max_si: 0.5,
        default: "2 %",
        doc: "Unevenness of the speed along the rails, standard deviation.",
        source: "ours: azimuth error of the study",
        set: |unit, value| unit.target.rail_ripple_ratio = value,
        get: |unit| unit.target.rail_ripple_ratio,
    },
    Parameter {
        key: "target.drone-descent",
        quantity: "length",
        min_si: 0.0,
        max_si: 1000.0,
        default: "5 m",
        doc: "How far it comes down from the hover.",
        source: "ours",
        set: |unit, value| unit.target.drone_descent_m = value,
        get: |unit| unit.target.drone_descent_m,
    },
    Parameter {
        key: "target.drone-descent-speed",
        quantity: "speed",
        min_si: 0.01,
        max_si: 20.0,
        default: "0.25 m/s",
        doc: "Speed down and up.",
        source: "ours: largest elevation error of the study",
        set: |unit, value| unit.target.drone_descent_m_per_s = value,
        get: |unit| unit.target.drone_descent_m_per_s,
    },
    Parameter {
        key: "target.drone-run",
        quantity: "length",
        min_si: 0.0,
        max_si: 1000.0,
        default: "20 m",
        doc: "How far it flies along the rails and back.",
        source: "ours",
        set: |unit, value| unit.target.drone_run_m = value,
        get: |unit| unit.target.drone_run_m,
    },
    Parameter {
        key: "target.drone-run-speed",
        quantity: "speed",
        min_si: 0.01,
        max_si: 20.0,
        default: "1 m/s",
        doc: "Speed along the rails.",
        source: "ours: as the rail",
        set: |unit, value| unit.target.drone_run_m_per_s = value,
        get: |unit| unit.target.drone_run_m_per_s,
    },
    Parameter {
        key: "target.drone-rise",
        quantity: "time",
        min_si: 0.01,
        max_si: 10.0,
        default: "0.1 s",
        doc: "Time in which its velocity changes.",
        source: "study 4.3: fastest",
        set: |unit, value| unit.target.drone_rise_s = value,
        get: |unit| unit.target.drone_rise_s,
    },
    Parameter {
        key: "target.drone-hover",
        quantity: "time",
        min_si: 0.0,
        max_si: 1.0e4,
        default: "8 s",
        doc: "Time it hovers between two legs.",
        source: "ours",
        set: |unit, value| unit.target.drone_hover_s = value,
        get: |unit| unit.target.drone_hover_s,
    },
    Parameter {
        key: "target.drone-heave",
        quantity: "length",
        min_si: 0.0,
        max_si: 10.0,
        default: "30 mm",
        doc: "Amplitude of its heave.",
        source: "ours: elevation error of the study",
        set: |unit, value| unit.target.drone_heave_m = value,
        get: |unit| unit.target.drone_heave_m,
    },
    Parameter {
        key: "target.drone-heave-frequency",
        quantity: "frequency",
        min_si: 0.01,
        max_si: 5.0,
        default: "0.5 Hz",
        doc: "Frequency of its heave.",
        source: "study 4.3",
        set: |unit, value| unit.target.drone_heave_hz = value,
        get: |unit| unit.target.drone_heave_hz,
    },
    Parameter {
        key: "target.drone-gust",
        quantity: "speed",
        min_si: 0.0,
        max_si: 10.0,
        default: "0.03 m/s",
        doc: "Lateral velocity in gusts, standard deviation.",
        source: "ours: azimuth error of the study",
        set: |unit, value| unit.target.drone_gust_m_per_s = value,
        get: |unit| unit.target.drone_gust_m_per_s,
    },
    Parameter {
        key: "target.drone-gust-frequency",
        quantity: "frequency",
        min_si: 0.02,
        max_si: 5.0,
        default: "0.5 Hz",
        doc: "Fastest gusts; the slowest are ten times slower.",
        source: "ours",
        set: |unit, value| unit.target.drone_gust_hz = value,
        get: |unit| unit.target.drone_gust_hz,
    },
];
