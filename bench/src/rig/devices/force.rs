//! Force gauge on a lever arm, on an analog input: what somebody pulls with.

use std::time::Duration;

use drivers::device::{Channel, DeviceError, Width};
use drivers::wire::AnalogPort;
use procedures::device::DeviceRole;
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape};

use super::on_card::{CardChannels, FULL_SCALE_V, OnCard};
use crate::model::device::DeviceEntry;
use crate::rig::device::{Group, LookedAt};
use crate::rig::driver::{Driver, Made, PortField, no_channels, not_above_zero};

/// Driver of force gauges.
pub(super) const DRIVER: Driver = Driver {
    name: "force-gauge",
    doc: "Force gauge on a lever arm, for external pulls.",
    role: Some(DeviceRole::ForceGauge),
    certified_as: Some("force"),
    rate_range_rad_per_s: None,
    ports: &[PortField::card("Analog card with the gauge.")],
    has_profile: false,
    fields: &[
        Field::default(
            "range",
            Shape::Quantity(K::Force),
            "2000 N",
            "Force at which the gauge outputs 10 V.",
        ),
        Field::default("input", Shape::Integer, "9", "Analog input of the gauge."),
    ],
    check: |entry| [not_above_zero(entry, &["range"]), no_channels(entry, &["input"])].concat(),
    make: |entry, _| Made::InTheTick(Box::new(OnCard::closed(Force::new(settings(entry)), entry))),
};

/// Where the gauge hangs on the analog card.
#[derive(Clone, Debug, PartialEq)]
struct ForceSettings {
    /// Input.
    input: usize,
    /// Force per volt.
    scale_n_per_v: f64,
}

fn settings(entry: &DeviceEntry) -> ForceSettings {
    ForceSettings { input: entry.channel("input"), scale_n_per_v: entry.number("range") / FULL_SCALE_V }
}

/// The gauge and what it showed since the last row.
#[derive(Clone, Debug)]
pub(super) struct Force {
    settings: ForceSettings,
    sum_n: f64,
    count: u32,
    last_n: f64,
}

impl Force {
    /// Channels of its topic: the mean since the row before.
    pub(super) const CHANNELS: &'static [Channel] =
        &[Channel { name: "force_n", unit: "N", width: Width::F64 }];

    /// Nothing was read yet.
    fn new(settings: ForceSettings) -> Self {
        Self { settings, sum_n: 0.0, count: 0, last_n: 0.0 }
    }
}

impl CardChannels for Force {
    const GROUP: Group = Group { topic: "force", message: "Force", channels: Self::CHANNELS };

    fn read(&mut self, analog: &mut dyn AnalogPort, now: Duration) -> Result<(), DeviceError> {
        self.last_n = self.settings.scale_n_per_v * analog.read_v(now, self.settings.input)?;
        self.sum_n += self.last_n;
        self.count += 1;
        Ok(())
    }

    fn values(&mut self) -> impl AsRef<[f64]> {
        let mean_n = if self.count > 0 { self.sum_n / f64::from(self.count) } else { self.last_n };
        (self.sum_n, self.count) = (0.0, 0);
        [mean_n]
    }

    fn is_looked_at(looked_at: LookedAt) -> bool {
        looked_at.force
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::devices::on_card::TestCard;

    #[test]
    fn a_row_is_the_mean_pull_since_the_row_before_and_the_last_one_where_nothing_came() {
        let mut force = Force::new(ForceSettings { input: 9, scale_n_per_v: 200.0 });
        let mut volts = 0.0;
        let mut card = TestCard(|input| {
            volts += f64::from(u8::from(input == 9));
            volts
        });
        for _ in 0..3 {
            force.read(&mut card, Duration::ZERO).expect("a card that answers");
        }
        assert_eq!(force.values().as_ref(), [400.0]);
        assert_eq!(force.values().as_ref(), [600.0]);
    }
}
