//! Force gauge on a lever arm, on an analog input: what somebody pulls with.

use std::time::Duration;

use drivers::device::{Channel, DeviceError, Width};
use drivers::wire::AnalogPort;

use crate::model::device::ForceSettings;
use crate::rig::device::{Device, Group, LookedAt, Ports};

/// The gauge and what it showed since the last row.
#[derive(Clone, Debug)]
pub(super) struct Force {
    settings: ForceSettings,
    port: String,
    card: usize,
    sum_n: f64,
    count: u32,
    last_n: f64,
}

impl Force {
    /// Channels of its topic: the mean since the row before.
    pub(super) const CHANNELS: &'static [Channel] =
        &[Channel { name: "force_n", unit: "N", width: Width::F64 }];

    /// On a card that is not open yet.
    pub(super) fn closed(settings: ForceSettings, port: &str) -> Self {
        Self { settings, port: port.to_owned(), card: 0, sum_n: 0.0, count: 0, last_n: 0.0 }
    }

    /// One tick.
    fn read(&mut self, analog: &mut dyn AnalogPort, now: Duration) -> Result<(), DeviceError> {
        self.last_n = self.settings.scale_n_per_v * analog.read_v(now, self.settings.input)?;
        self.sum_n += self.last_n;
        self.count += 1;
        Ok(())
    }

    /// Its row.
    fn values(&mut self) -> [f64; 1] {
        let mean_n = if self.count > 0 { self.sum_n / f64::from(self.count) } else { self.last_n };
        (self.sum_n, self.count) = (0.0, 0);
        [mean_n]
    }
}

impl Device for Force {
    fn name(&self) -> &str {
        "force-gauge"
    }

    fn open(&mut self, ports: &mut Ports, _now: Duration) -> Result<Option<()>, DeviceError> {
        self.card = ports.find_card(self.name(), &self.port)?;
        Ok(Some(()))
    }

    fn poll(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError> {
        self.read(ports.card(self.card), now)
    }

    fn group(&self) -> Group {
        Group { topic: "force", message: "Force", channels: Self::CHANNELS }
    }

    fn is_looked_at(&self, looked_at: LookedAt) -> bool {
        looked_at.force
    }

    fn row(&mut self, row: &mut [f64]) {
        let values = self.values();
        row[..values.len()].copy_from_slice(&values);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A card on which every look at input 9 sees a volt more.
    struct Card(f64);

    impl AnalogPort for Card {
        fn name(&self) -> &str {
            "card"
        }
        fn write_v(&mut self, _: Duration, _: usize, _: f64) -> Result<(), DeviceError> {
            Ok(())
        }
        fn read_v(&mut self, _: Duration, channel: usize) -> Result<f64, DeviceError> {
            self.0 += f64::from(u8::from(channel == 9));
            Ok(self.0)
        }
    }

    #[test]
    fn a_row_is_the_mean_pull_since_the_row_before_and_the_last_one_where_nothing_came() {
        let mut force = Force::closed(ForceSettings { input: 9, scale_n_per_v: 200.0 }, "card");
        let mut card = Card(0.0);
        for _ in 0..3 {
            force.read(&mut card, Duration::ZERO).expect("a card that answers");
        }
        assert_eq!(force.values(), [400.0]);
        assert_eq!(force.values(), [600.0]);
    }
}
