//! What the director points at.

use super::UnitSettings;
use super::setting::{Field, Setting};

/// What the director points at.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetSettings {
    /// 0 fixed like a star, 1 rail, 2 drone, 3 a sweep about the first direction.
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
    /// Slope of the rails up and down, standard deviation.
    pub rail_waviness_ratio: f64,
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
    /// Azimuth rate of a sweep.
    pub sweep_azimuth_rate_rad_per_s: f64,
    /// Elevation rate of a sweep.
    pub sweep_elevation_rate_rad_per_s: f64,
    /// Time from one turn-round of a sweep to the next.
    pub sweep_leg_s: f64,
    /// Time that a turn-round takes.
    pub sweep_turn_s: f64,
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
            rail_reversal_s: 1.8,
            rail_waviness_ratio: 1.8 * 1e-2,
            rail_jerk_m: 4.0 * 1e-3,
            rail_jerk_hz: 3.0,
            rail_jerk_s: 1.5,
            rail_ripple_ratio: 2.5 * 1e-2,
            drone_descent_m: 6.0,
            drone_descent_m_per_s: 0.3,
            drone_run_m: 20.0,
            drone_run_m_per_s: 1.0,
            drone_rise_s: 0.1,
            drone_hover_s: 8.0,
            drone_heave_m: 25.0 * 1e-3,
            drone_heave_hz: 0.5,
            drone_gust_m_per_s: 0.065,
            drone_gust_hz: 0.5,
            sweep_azimuth_rate_rad_per_s: 0.3,
            sweep_elevation_rate_rad_per_s: 0.0,
            sweep_leg_s: 18.0,
            sweep_turn_s: 8.0,
        }
    }
}

const DEG: f64 = std::f64::consts::PI / 180.0;

pub(super) const TARGET: &[Setting<Field<UnitSettings>>] = &[
    Setting {
        key: "target.kind",
        quantity: "count",
        range_si: [0.0, 3.0],
        default: "0",
        doc: "0 fixed like a star, 1 rail, 2 drone, 3 a sweep about the first direction.",
        source: "ours: set by what is tracked",
        field: |unit| &mut unit.target.kind_count,
    },
    Setting {
        key: "target.azimuth",
        quantity: "angle",
        range_si: [-4.0, 4.0],
        default: "0 deg",
        doc: "Azimuth at which the target starts.",
        source: "ours",
        field: |unit| &mut unit.target.azimuth_rad,
    },
    Setting {
        key: "target.elevation",
        quantity: "angle",
        range_si: [-0.2, 1.5],
        default: "0 deg",
        doc: "Elevation at which the target starts.",
        source: "ours",
        field: |unit| &mut unit.target.elevation_rad,
    },
    Setting {
        key: "target.distance",
        quantity: "length",
        range_si: [1.0, 1.0e6],
        default: "85 m",
        doc: "Horizontal distance of its track from the director, at the nearest point.",
        source: "study 4.3",
        field: |unit| &mut unit.target.distance_m,
    },
    Setting {
        key: "target.standing",
        quantity: "time",
        range_si: [0.0, 1.0e5],
        default: "5 s",
        doc: "Time before it begins to move.",
        source: "ours",
        field: |unit| &mut unit.target.standing_s,
    },
    Setting {
        key: "target.rail-speed",
        quantity: "speed",
        range_si: [0.01, 2.0],
        default: "1 m/s",
        doc: "Speed along the rails: 0.674 deg/s seen from 85 m.",
        source: "study 4.3",
        field: |unit| &mut unit.target.rail_speed_m_per_s,
    },
    Setting {
        key: "target.rail-length",
        quantity: "length",
        range_si: [3.0, 100.0],
        default: "7 m",
        doc: "Length of one rail; there is a joint after each.",
        source: "study 4.3",
        field: |unit| &mut unit.target.rail_length_m,
    },
    Setting {
        key: "target.rail-count",
        quantity: "count",
        range_si: [1.0, 100.0],
        default: "6",
        doc: "Rails in line.",
        source: "ours",
        field: |unit| &mut unit.target.rail_count,
    },
    Setting {
        key: "target.rail-reversal",
        quantity: "time",
        range_si: [0.01, 10.0],
        default: "1.8 s",
        doc: "Duration of a reversal by hand.",
        source: "ours: error peaks of 0.08 deg",
        field: |unit| &mut unit.target.rail_reversal_s,
    },
    Setting {
        key: "target.rail-waviness",
        quantity: "ratio",
        range_si: [0.0, 0.5],
        default: "1.8 %",
        doc: "Slope of the rails, standard deviation.",
        source: "ours: elevation error of the study",
        field: |unit| &mut unit.target.rail_waviness_ratio,
    },
    Setting {
        key: "target.rail-jerk",
        quantity: "length",
        range_si: [0.0, 0.5],
        default: "4 mm",
        doc: "Amplitude of the heave caused by a joint.",
        source: "ours: elevation error of the study",
        field: |unit| &mut unit.target.rail_jerk_m,
    },
    Setting {
        key: "target.rail-jerk-frequency",
        quantity: "frequency",
        range_si: [0.1, 20.0],
        default: "3 Hz",
        doc: "Frequency of the heave caused by a joint.",
        source: "study 4.3",
        field: |unit| &mut unit.target.rail_jerk_hz,
    },
    Setting {
        key: "target.rail-jerk-duration",
        quantity: "time",
        range_si: [0.1, 3.0],
        default: "1.5 s",
        doc: "Time in which the heave decays to 2 %.",
        source: "study 4.3",
        field: |unit| &mut unit.target.rail_jerk_s,
    },
    Setting {
        key: "target.rail-ripple",
        quantity: "ratio",
        range_si: [0.0, 0.5],
        default: "2.5 %",
        doc: "Unevenness of the speed along the rails, standard deviation.",
        source: "ours: azimuth error of the study",
        field: |unit| &mut unit.target.rail_ripple_ratio,
    },
    Setting {
        key: "target.drone-descent",
        quantity: "length",
        range_si: [0.0, 1000.0],
        default: "6 m",
        doc: "Descent below the hover position.",
        source: "ours",
        field: |unit| &mut unit.target.drone_descent_m,
    },
    Setting {
        key: "target.drone-descent-speed",
        quantity: "speed",
        range_si: [0.01, 20.0],
        default: "0.3 m/s",
        doc: "Speed down and up.",
        source: "ours: largest elevation error of the study",
        field: |unit| &mut unit.target.drone_descent_m_per_s,
    },
    Setting {
        key: "target.drone-run",
        quantity: "length",
        range_si: [0.0, 1000.0],
        default: "20 m",
        doc: "Distance flown along the rails and back.",
        source: "ours",
        field: |unit| &mut unit.target.drone_run_m,
    },
    Setting {
        key: "target.drone-run-speed",
        quantity: "speed",
        range_si: [0.01, 20.0],
        default: "1 m/s",
        doc: "Speed along the rails.",
        source: "ours: as the rail",
        field: |unit| &mut unit.target.drone_run_m_per_s,
    },
    Setting {
        key: "target.drone-rise",
        quantity: "time",
        range_si: [0.01, 10.0],
        default: "0.1 s",
        doc: "Duration of a velocity change.",
        source: "study 4.3: fastest",
        field: |unit| &mut unit.target.drone_rise_s,
    },
    Setting {
        key: "target.drone-hover",
        quantity: "time",
        range_si: [0.0, 1.0e4],
        default: "8 s",
        doc: "Duration of the hover between two legs.",
        source: "ours",
        field: |unit| &mut unit.target.drone_hover_s,
    },
    Setting {
        key: "target.drone-heave",
        quantity: "length",
        range_si: [0.0, 10.0],
        default: "25 mm",
        doc: "Amplitude of its heave.",
        source: "ours: elevation error of the study",
        field: |unit| &mut unit.target.drone_heave_m,
    },
    Setting {
        key: "target.drone-heave-frequency",
        quantity: "frequency",
        range_si: [0.01, 5.0],
        default: "0.5 Hz",
        doc: "Frequency of its heave.",
        source: "study 4.3",
        field: |unit| &mut unit.target.drone_heave_hz,
    },
    Setting {
        key: "target.drone-gust",
        quantity: "speed",
        range_si: [0.0, 10.0],
        default: "0.065 m/s",
        doc: "Lateral velocity in gusts, standard deviation.",
        source: "ours: azimuth error of the study",
        field: |unit| &mut unit.target.drone_gust_m_per_s,
    },
    Setting {
        key: "target.drone-gust-frequency",
        quantity: "frequency",
        range_si: [0.02, 5.0],
        default: "0.5 Hz",
        doc: "Highest frequency of gusts; the lowest is ten times lower.",
        source: "ours",
        field: |unit| &mut unit.target.drone_gust_hz,
    },
    Setting {
        key: "target.sweep-azimuth-rate",
        quantity: "angular-velocity",
        range_si: [-1.0, 1.0],
        default: "0.3 rad/s",
        doc: "Azimuth rate of a sweep.",
        source: "ours: azimuth slides from 0.2 rad/s on",
        field: |unit| &mut unit.target.sweep_azimuth_rate_rad_per_s,
    },
    Setting {
        key: "target.sweep-elevation-rate",
        quantity: "angular-velocity",
        range_si: [-1.0, 1.0],
        default: "0 rad/s",
        doc: "Elevation rate of a sweep.",
        source: "ours: elevation slides from 0.03 rad/s on",
        field: |unit| &mut unit.target.sweep_elevation_rate_rad_per_s,
    },
    Setting {
        key: "target.sweep-leg",
        quantity: "time",
        range_si: [0.5, 1000.0],
        default: "18 s",
        doc: "Time between two reversals of a sweep.",
        source: "ours",
        field: |unit| &mut unit.target.sweep_leg_s,
    },
    Setting {
        key: "target.sweep-turn",
        quantity: "time",
        range_si: [0.1, 100.0],
        default: "8 s",
        doc: "Duration of a reversal.",
        source: "ours: the coarse camera keeps its target",
        field: |unit| &mut unit.target.sweep_turn_s,
    },
];
