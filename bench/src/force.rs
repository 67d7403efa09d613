//! Force gauge on a lever arm, on an analog input: what somebody pulls with.

use std::time::Duration;

use drivers::device::{Channel, DeviceError, Width};
use drivers::wire::AnalogPort;

use crate::model::device::ForceSettings;

/// The gauge and what it showed since the last row.
#[derive(Clone, Debug)]
pub struct Force {
    settings: ForceSettings,
    sum_n: f64,
    count: u32,
    last_n: f64,
}

impl Force {
    /// Channels of its topic: the mean since the row before.
    pub const CHANNELS: &'static [Channel] = &[Channel { name: "force_n", unit: "N", width: Width::F64 }];

    /// Nothing was seen yet.
    pub fn new(settings: ForceSettings) -> Self {
        Self { settings, sum_n: 0.0, count: 0, last_n: 0.0 }
    }

    /// One tick.
    ///
    /// # Errors
    /// When the card is gone or lacks the channel.
    pub fn exchange(&mut self, analog: &mut dyn AnalogPort, now: Duration) -> Result<(), DeviceError> {
        self.last_n = self.settings.scale_n_per_v * analog.read_v(now, self.settings.input)?;
        self.sum_n += self.last_n;
        self.count += 1;
        Ok(())
    }

    /// Its row.
    pub fn row(&mut self) -> [f64; 1] {
        let mean_n = if self.count > 0 { self.sum_n / f64::from(self.count) } else { self.last_n };
        (self.sum_n, self.count) = (0.0, 0);
        [mean_n]
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
        let mut force = Force::new(ForceSettings { input: 9, scale_n_per_v: 200.0 });
        let mut card = Card(0.0);
        for _ in 0..3 {
            force.exchange(&mut card, Duration::ZERO).expect("a card that answers");
        }
        assert_eq!(force.row(), [400.0]);
        assert_eq!(force.row(), [600.0]);
    }
}
