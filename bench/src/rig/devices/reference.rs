//! External angle reference in the tick: autocollimators at polygons on the axes, on analog inputs.

use std::f64::consts::TAU;
use std::time::Duration;

use drivers::device::{Channel, DeviceError, Width};
use drivers::wire::AnalogPort;
use procedures::axis::AngleReference;
use procedures::device::DeviceRole;
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape};

use super::on_card::{CardChannels, OnCard};
use super::reader;
use crate::model::device::DeviceEntry;
use crate::rig::device::Group;
use crate::rig::driver::{Driver, Made, Misfit, PortField, no_channels, not_above_zero};

/// Driver of polygons and their autocollimators.
pub const DRIVER: Driver = Driver {
    name: "polygons",
    doc: "Polygons on two axes and the autocollimators that read them.",
    role: Some(DeviceRole::AngleReference),
    certified_as: Some("reference"),
    rate_range_rad_per_s: None,
    ports: &[PortField::card("Analog card with both autocollimators.")],
    has_profile: false,
    fields: &[
        Field::required(
            "scale",
            Shape::Quantity(K::AngleScale),
            "Angle per volt of the autocollimators; +10 V where no face is in view.",
        ),
        Field::required(
            "range",
            Shape::Quantity(K::Angle),
            "Largest deviation from a face that can be read.",
        ),
        Field::required(
            "uncertainty",
            Shape::Quantity(K::Angle),
            "Standard uncertainty of a face angle: calibration table, autocollimator and mounting.",
        ),
        Field::required(
            FACES[0],
            Shape::Quantities(K::Angle),
            "Calibration of the polygon on the first axis of the rig: deviation of each face from its \
             nominal angle; faces are equally spaced from 0.",
        ),
        Field::required(
            FACES[1],
            Shape::Quantities(K::Angle),
            "Calibration of the polygon on the second axis.",
        ),
        Field::default(
            INPUTS[0],
            Shape::Integer,
            "5",
            "Analog input of the autocollimator at the first axis.",
        ),
        Field::default(
            INPUTS[1],
            Shape::Integer,
            "6",
            "Analog input of the autocollimator at the second axis.",
        ),
    ],
    check,
    make: |entry, _| Made::InTheTick(Box::new(OnCard::closed(Reference::new(settings(entry)), entry))),
};

pub(super) const FACES: [&str; 2] = ["azimuth-faces", "elevation-faces"];
const INPUTS: [&str; 2] = ["azimuth-input", "elevation-input"];
/// Fewer faces are no polygon.
pub(super) const LEAST_FACES: usize = 3;

fn check(entry: &DeviceEntry) -> Vec<Misfit> {
    let mut all = not_above_zero(entry, &["scale", "range", "uncertainty"]);
    all.extend(no_channels(entry, &INPUTS));
    for key in FACES {
        let faces = entry.numbers(key).len();
        if faces < LEAST_FACES {
            let help = Some(format!("a polygon has at least {LEAST_FACES}"));
            all.push(Misfit { key, message: format!("{faces} faces"), help });
        }
    }
    all
}

/// What the polygons are to the first two axes of a rig; `None` for an axis that nobody looks at.
pub fn angle_references(entry: &DeviceEntry) -> [Option<AngleReference>; 2] {
    if let Some(profile) = &entry.profile {
        return reader::angle_references(entry, profile);
    }
    FACES.map(|key| {
        let faces_rad = places_rad(entry.numbers(key));
        Some(AngleReference {
            faces_rad,
            range_rad: entry.number("range"),
            u_rad: entry.number("uncertainty"),
        })
    })
}

/// Angles of the faces of a polygon whose calibration gives so much for each off its nominal angle.
pub(super) fn places_rad(off_rad: &[f64]) -> Vec<f64> {
    let part_rad = TAU / off_rad.len() as f64;
    let places = off_rad.iter().enumerate().map(|(face, off_rad)| {
        let angle_rad = part_rad * face as f64 + off_rad;
        angle_rad - (angle_rad / TAU).round() * TAU
    });
    places.collect()
}

/// Where the autocollimators hang on the analog card.
#[derive(Clone, Debug, PartialEq)]
struct ReferenceSettings {
    /// Angle per volt.
    scale_rad_per_v: f64,
    /// Inputs: first axis, second axis.
    inputs: [usize; 2],
}

fn settings(entry: &DeviceEntry) -> ReferenceSettings {
    ReferenceSettings { scale_rad_per_v: entry.number("scale"), inputs: INPUTS.map(|key| entry.channel(key)) }
}

/// From this voltage on no face is in sight: the instruments' range ends well below.
const NO_FACE_V: f64 = 9.5;

/// Both autocollimators as they were read last.
#[derive(Clone, Debug)]
pub(super) struct Reference {
    settings: ReferenceSettings,
    deviation_rad: [f64; 2],
    sees_face: [bool; 2],
}

impl Reference {
    /// Channels of their topic.
    pub(super) const CHANNELS: &'static [Channel] = &[
        Channel { name: "deviation_az_rad", unit: "rad", width: Width::F64 },
        Channel { name: "deviation_el_rad", unit: "rad", width: Width::F64 },
        Channel { name: "sees_face_az", unit: "1", width: Width::U16 },
        Channel { name: "sees_face_el", unit: "1", width: Width::U16 },
    ];

    /// Nothing was read yet.
    fn new(settings: ReferenceSettings) -> Self {
        Self { settings, deviation_rad: [0.0; 2], sees_face: [false; 2] }
    }
}

impl CardChannels for Reference {
    const GROUP: Group = Group { topic: "reference", message: "Reference", channels: Self::CHANNELS };

    fn read(&mut self, analog: &mut dyn AnalogPort, now: Duration) -> Result<(), DeviceError> {
        for (axis, &input) in self.settings.inputs.iter().enumerate() {
            let volts = analog.read_v(now, input)?;
            self.sees_face[axis] = volts.abs() < NO_FACE_V;
            self.deviation_rad[axis] =
                if self.sees_face[axis] { self.settings.scale_rad_per_v * volts } else { 0.0 };
        }
        Ok(())
    }

    fn values(&mut self) -> impl AsRef<[f64]> {
        let [az, el] = self.deviation_rad;
        let [sees_az, sees_el] = self.sees_face.map(|sees| f64::from(u8::from(sees)));
        [az, el, sees_az, sees_el]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::devices::on_card::TestCard;

    #[test]
    fn a_deviation_is_read_where_a_face_is_in_sight_and_none_elsewhere() {
        let mut reference = Reference::new(ReferenceSettings { scale_rad_per_v: 50e-6, inputs: [5, 6] });
        let mut card = TestCard(|input| [0.0, 0.0, 0.0, 0.0, 0.0, -2.0, 10.0][input]);
        reference.read(&mut card, Duration::ZERO).expect("both channels are there");
        assert_eq!(reference.values().as_ref(), [-1e-4, 0.0, 1.0, 0.0]);
    }
}
