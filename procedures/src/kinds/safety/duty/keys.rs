//! What a procedure says.

use crate::device::MIRROR_AXES;
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

/// Keys of `[slew]`: outer and inner axis.
pub(super) const AXIS_KEYS: [&str; 2] = ["azimuth", "elevation"];
/// What files called them in older versions, and procedures in their logs still do.
const OLD_KEYS: [&str; 2] = MIRROR_AXES;

const SLEW: &[Field] = &[
    Field::optional(
        AXIS_KEYS[0],
        Shape::Range(Q::Angle),
        "From and to, of the axis that carries the other one, or of the only axis of a rig.",
    ),
    Field::optional(AXIS_KEYS[1], Shape::Range(Q::Angle), "From and to, of the axis that is carried."),
    Field::optional(OLD_KEYS[0], Shape::Range(Q::Angle), "What older files call `azimuth`."),
    Field::optional(OLD_KEYS[1], Shape::Range(Q::Angle), "What older files call `elevation`."),
];

pub(super) const FIELDS: &[Field] = &[
    Field::required(
        "slew",
        Shape::Table(SLEW),
        "Ends of the slews: one axis alone, or both at once; the procedure's own axis is among them.",
    ),
    Field::default("rate", Shape::Quantity(Q::AngularVelocity), "60 deg/s", "Rate of the slews."),
    Field::default(
        "acceleration",
        Shape::Quantity(Q::AngularAcceleration),
        "80 deg/s^2",
        "Their acceleration; the cycle's requirement names none (E17, E22), and the largest takes all of the torque.",
    ),
    Field::default("track", Shape::Quantity(Q::Time), "6 s", "Time between two slews."),
    Field::default(
        "track-rate",
        Shape::Quantity(Q::AngularVelocity),
        "0.674 deg/s",
        "Rate in it, out and back; rest for less than 0.001 deg/s.",
    ),
    Field::default("cycles", Shape::Integer, "10", "Cycles without a pause."),
    Field::default(
        "continuous-current-az",
        Shape::Quantity(Q::Current),
        "14.2 A",
        "Current that azimuth bears without end.",
    ),
    Field::default("continuous-current-el", Shape::Quantity(Q::Current), "16.8 A", "The same of elevation."),
    Field::default(
        "longest-heat-sink-time",
        Shape::Quantity(Q::Time),
        "30 min",
        "No heat sink has a longer time constant.",
    ),
    Field::default(
        "current-uncertainty",
        Shape::Quantity(Q::Ratio),
        "0.5 %",
        "Standard uncertainty of the scale of currents, drives and clamps.",
    ),
    Field::default(
        "voltage-uncertainty",
        Shape::Quantity(Q::Voltage),
        "1 V",
        "Standard uncertainty of the voltage of the DC link.",
    ),
    Field::default(
        "temperature-uncertainty",
        Shape::Quantity(Q::Temperature),
        "1 degC",
        "Standard uncertainty of the sensors of the heat sinks.",
    ),
];

/// Slower than this there is nothing to track.
const REST_RAD_PER_S: f64 = 0.001 * std::f64::consts::PI / 180.0;

/// The keys, read. SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    /// Azimuth, elevation; `None` where the axis rests.
    pub(super) slew_rad: [Option<[f64; 2]>; 2],
    pub(super) rate_rad_per_s: f64,
    pub(super) acceleration_rad_per_s2: f64,
    pub(super) track_s: f64,
    /// `None` for rest.
    pub(super) track_rad_per_s: Option<f64>,
    pub(super) cycles: u32,
    pub(super) continuous_a: [f64; 2],
    pub(super) longest_s: f64,
    pub(super) current_u_ratio: f64,
    pub(super) voltage_u_v: f64,
    pub(super) temperature_u_degc: f64,
}

impl Keys {
    /// Reads them; mistakes stay in the reader.
    pub(super) fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let slew_rad = table.table("slew", |t| {
            let mut span = |index: usize| {
                let written = [AXIS_KEYS[index], OLD_KEYS[index]].into_iter().find(|key| t.has(key));
                written.map_or(Some(None), |key| t.range(key).map(Some))
            };
            Some([span(0)?, span(1)?])
        });
        if slew_rad == Some([None, None]) {
            let help = "name the axes that slew, e.g. `azimuth = \"-90 deg .. 90 deg\"`".to_owned();
            table.mistake("slew", "no axis slews", Some(help));
        }
        let slew_rate = table.positive("rate");
        let acceleration = table.positive("acceleration");
        let track_s = table.positive("track");
        let rate = table.quantity("track-rate");
        let cycles = table.count("cycles", 1);
        let continuous = [table.positive("continuous-current-az"), table.positive("continuous-current-el")];
        let longest_s = table.positive("longest-heat-sink-time");
        let current_u = table.positive("current-uncertainty");
        let voltage_u = table.positive("voltage-uncertainty");
        let temperature_u = table.positive("temperature-uncertainty");
        table.check_steps("cycles", &[cycles? as usize, 4]);
        Some(Self {
            slew_rad: slew_rad.filter(|slew| *slew != [None, None])?,
            rate_rad_per_s: slew_rate?,
            acceleration_rad_per_s2: acceleration?,
            track_s: track_s?,
            track_rad_per_s: Some(rate?.abs()).filter(|rate| *rate >= REST_RAD_PER_S),
            cycles: cycles?,
            continuous_a: [continuous[0]?, continuous[1]?],
            longest_s: longest_s?,
            current_u_ratio: current_u?,
            voltage_u_v: voltage_u?,
            temperature_u_degc: temperature_u?,
        })
    }

    /// Indices of the axes that slew.
    pub(super) fn axes(&self) -> impl Iterator<Item = usize> {
        let slews = self.slew_rad.map(|slew| slew.is_some());
        (0..2).filter(move |&axis| slews[axis])
    }
}
