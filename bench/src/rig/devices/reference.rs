//! External angle reference in the tick: autocollimators at polygons on the axes, on analog inputs.

use std::time::Duration;

use drivers::device::{Channel, DeviceError, Width};
use drivers::wire::AnalogPort;

use super::on_card::CardChannels;
use crate::model::device::ReferenceSettings;
use crate::rig::device::Group;

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
    pub(super) fn new(settings: ReferenceSettings) -> Self {
        Self { settings, deviation_rad: [0.0; 2], sees_face: [false; 2] }
    }

    /// Their row.
    fn values(&self) -> [f64; 4] {
        let [az, el] = self.deviation_rad;
        let [sees_az, sees_el] = self.sees_face.map(|sees| f64::from(u8::from(sees)));
        [az, el, sees_az, sees_el]
    }
}

impl CardChannels for Reference {
    const NAME: &'static str = "reference";
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

    fn put(&mut self, row: &mut [f64]) {
        let values = self.values();
        row[..values.len()].copy_from_slice(&values);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Card([f64; 7]);

    impl AnalogPort for Card {
        fn name(&self) -> &str {
            "card"
        }
        fn write_v(&mut self, _: Duration, _: usize, _: f64) -> Result<(), DeviceError> {
            Ok(())
        }
        fn read_v(&mut self, _: Duration, channel: usize) -> Result<f64, DeviceError> {
            Ok(self.0[channel])
        }
    }

    #[test]
    fn a_deviation_is_read_where_a_face_is_in_sight_and_none_elsewhere() {
        let mut reference = Reference::new(ReferenceSettings { scale_rad_per_v: 50e-6, inputs: [5, 6] });
        let mut card = Card([0.0, 0.0, 0.0, 0.0, 0.0, -2.0, 10.0]);
        reference.read(&mut card, Duration::ZERO).expect("both channels are there");
        assert_eq!(reference.values(), [-1e-4, 0.0, 1.0, 0.0]);
    }
}
