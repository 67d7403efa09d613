//! What a procedure says.

use crate::kinds::ReadKeys;
use crate::quantity::QuantityKind as Q;
use crate::stimulus::{Knot, knots};
use crate::table::{Field, Shape, TableReader};

const RAMP: &[Field] = &[
    Field::default(
        "velocity",
        Shape::Quantity(Q::AngularVelocity),
        "0.674 deg/s",
        "Rate of the ramp (POS-TRK).",
    ),
    Field::required(
        "span",
        Shape::Range(Q::Angle),
        "Start and end of the ramp; it is run in both directions.",
    ),
    Field::default(
        "acceleration",
        Shape::Quantity(Q::AngularAcceleration),
        "2 deg/s^2",
        "Acceleration at the beginning and end of the ramp.",
    ),
];

const SINE: &[Field] = &[
    Field::required("amplitude", Shape::Quantity(Q::Angle), "Amplitude."),
    Field::required("frequency", Shape::Quantity(Q::Frequency), "Frequency."),
    Field::default("middle", Shape::Quantity(Q::Angle), "0 deg", "Centre of the sine."),
    Field::default("cycles", Shape::Integer, "10", "Whole periods, including both fades."),
    Field::default("fade", Shape::Quantity(Q::Time), "2 s", "Duration of the fade at each end."),
];

const PATH: &[Field] = &[
    Field::required("time", Shape::Quantities(Q::Time), "Times of the path, ascending from 0 s."),
    Field::required(
        "position",
        Shape::Quantities(Q::Angle),
        "Position at each time; the axis rests at the first and the last.",
    ),
];

pub(super) const FIELDS: &[Field] = &[
    Field::default("elevation", Shape::Quantity(Q::Angle), "0 deg", "Elevation while azimuth moves."),
    Field::optional("ramp", Shape::Table(RAMP), "A ramp, run as its own point."),
    Field::optional("sine", Shape::Table(SINE), "A sine, run as its own point."),
    Field::optional(
        "path",
        Shape::Table(PATH),
        "A path through given positions at given times, run as its own point.",
    ),
];

/// A ramp there and back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ramp {
    pub(super) velocity_rad_per_s: f64,
    pub(super) span_rad: [f64; 2],
    pub(super) acceleration_rad_per_s2: f64,
}

/// A sine about a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sine {
    pub(super) amplitude_rad: f64,
    pub(super) frequency_hz: f64,
    pub(super) middle_rad: f64,
    pub(super) cycles: u32,
    pub(super) fade_s: f64,
}

/// The keys, read. SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) elevation_rad: f64,
    pub(super) ramp: Option<Ramp>,
    pub(super) sine: Option<Sine>,
    pub(super) path: Option<Vec<Knot>>,
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let elevation_rad = table.quantity("elevation");
        let has_ramp = table.has("ramp");
        let has_sine = table.has("sine");
        let has_path = table.has("path");
        if !(has_ramp || has_sine || has_path) {
            let help = "add `[ramp]`, `[sine]` or `[path]`".to_owned();
            table.mistake("ramp", "no reference to follow", Some(help));
        }
        let ramp = has_ramp.then(|| table.table("ramp", ramp));
        let sine = has_sine.then(|| table.table("sine", sine));
        let path = has_path.then(|| table.table("path", path));
        // A table that was written and is wrong leaves no keys.
        if matches!(ramp, Some(None)) || matches!(sine, Some(None)) || matches!(path, Some(None)) {
            return None;
        }
        let ramp = ramp.flatten();
        let sine = sine.flatten();
        let path = path.flatten();
        Some(Self { elevation_rad: elevation_rad?, ramp, sine, path })
    }
}

fn ramp(table: &mut TableReader<'_>) -> Option<Ramp> {
    let velocity = table.positive("velocity");
    let span = table.range("span");
    let acceleration = table.positive("acceleration");
    Some(Ramp { velocity_rad_per_s: velocity?, span_rad: span?, acceleration_rad_per_s2: acceleration? })
}

fn sine(table: &mut TableReader<'_>) -> Option<Sine> {
    let amplitude = table.positive("amplitude");
    let frequency = table.positive("frequency");
    let middle = table.quantity("middle");
    let cycles = table.count("cycles", 1);
    let fade = table.positive("fade");
    let frequency_hz = frequency?;
    let cycles = cycles?;
    let fade_s = fade?;
    if 2.0 * fade_s >= f64::from(cycles) / frequency_hz {
        let help = "use more `cycles` or a shorter `fade`".to_owned();
        table.mistake("fade", "the sine ends before both fades are complete", Some(help));
    }
    Some(Sine { amplitude_rad: amplitude?, frequency_hz, middle_rad: middle?, cycles, fade_s })
}

fn path(table: &mut TableReader<'_>) -> Option<Vec<Knot>> {
    let times = table.quantities("time");
    let places = table.quantities("position");
    match knots(&times?, &places?) {
        Ok(knots) => Some(knots),
        Err(error) => {
            table.mistake("time", error.to_string(), None);
            None
        }
    }
}
