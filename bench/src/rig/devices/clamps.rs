//! Current clamps on the leads of the DC link: what the supply gives and what the shunt burns no drive tells.

use std::time::Duration;

use drivers::device::{Channel, DeviceError, Width};
use drivers::wire::AnalogPort;
use procedures::device::DeviceRole;
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape};

use super::on_card::{CardChannels, FULL_SCALE_V, OnCard};
use crate::model::device::DeviceEntry;
use crate::rig::device::Group;
use crate::rig::driver::{Driver, Made, PortField, no_channels, not_above_zero};

/// Driver of current clamps.
pub(super) const DRIVER: Driver = Driver {
    name: "current-clamps",
    doc: "Current clamps on the leads of the DC link: supply and shunt.",
    role: Some(DeviceRole::LinkClamps),
    certified_as: Some("supply"),
    rate_range_rad_per_s: None,
    ports: &[PortField::card("Analog card with both clamps.")],
    has_profile: false,
    fields: &[
        Field::default(
            "clamp-range",
            Shape::Quantity(K::Current),
            "100 A",
            "Current at which a clamp outputs 10 V.",
        ),
        Field::default(INPUTS[0], Shape::Integer, "7", "Analog input of the clamp on the supply."),
        Field::default(INPUTS[1], Shape::Integer, "8", "Analog input of the clamp on the shunt."),
    ],
    check: |entry| [not_above_zero(entry, &["clamp-range"]), no_channels(entry, &INPUTS)].concat(),
    make: |entry, _| Made::InTheTick(Box::new(OnCard::closed(Clamps::new(settings(entry)), entry))),
};

/// Keys of the inputs: supply, shunt.
const INPUTS: [&str; 2] = ["supply-input", "shunt-input"];

/// Where the clamps hang on the analog card.
#[derive(Clone, Debug, PartialEq)]
struct ClampSettings {
    /// Inputs: supply, shunt.
    inputs: [usize; 2],
    /// Current per volt.
    scale_a_per_v: f64,
}

fn settings(entry: &DeviceEntry) -> ClampSettings {
    ClampSettings {
        inputs: INPUTS.map(|key| entry.channel(key)),
        scale_a_per_v: entry.number("clamp-range") / FULL_SCALE_V,
    }
}

/// The clamps and what they showed since the last row.
#[derive(Clone, Debug)]
pub(super) struct Clamps {
    settings: ClampSettings,
    sums_a: [f64; 2],
    count: u32,
    last_a: [f64; 2],
}

impl Clamps {
    /// Channels of their topic: means since the row before.
    pub(super) const CHANNELS: &'static [Channel] = &[
        Channel { name: "supply_a", unit: "A", width: Width::F32 },
        Channel { name: "shunt_a", unit: "A", width: Width::F32 },
    ];

    /// Nothing was read yet.
    fn new(settings: ClampSettings) -> Self {
        Self { settings, sums_a: [0.0; 2], count: 0, last_a: [0.0; 2] }
    }
}

impl CardChannels for Clamps {
    const GROUP: Group = Group { topic: "supply", message: "Supply", channels: Self::CHANNELS };

    fn read(&mut self, analog: &mut dyn AnalogPort, now: Duration) -> Result<(), DeviceError> {
        for (clamp, &input) in self.settings.inputs.iter().enumerate() {
            self.last_a[clamp] = self.settings.scale_a_per_v * analog.read_v(now, input)?;
            self.sums_a[clamp] += self.last_a[clamp];
        }
        self.count += 1;
        Ok(())
    }

    fn values(&mut self) -> impl AsRef<[f64]> {
        // Means of the ticks since the row before, so that no ripple is folded.
        let mean_a = match self.count {
            0 => self.last_a,
            count => self.sums_a.map(|sum| sum / f64::from(count)),
        };
        (self.sums_a, self.count) = ([0.0; 2], 0);
        mean_a
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::devices::on_card::TestCard;

    #[test]
    fn a_row_is_the_mean_since_the_row_before_and_the_last_value_where_nothing_came() {
        let settings = ClampSettings { inputs: [5, 6], scale_a_per_v: 10.0 };
        let mut clamps = Clamps::new(settings);
        let mut volts = 0.0;
        let mut card = TestCard(|input| {
            volts += f64::from(u8::from(input == 5));
            if input == 5 { volts } else { 0.0 }
        });
        for _ in 0..3 {
            clamps.read(&mut card, Duration::ZERO).expect("a card that answers");
        }
        assert_eq!(clamps.values().as_ref(), [20.0, 0.0]);
        assert_eq!(clamps.values().as_ref(), [30.0, 0.0]);
    }
}
