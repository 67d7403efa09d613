//! The inertial measurement unit on its serial line.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::kvh::{Kvh, KvhSettings, Opening};

use crate::rig::device::{Device, Group, Ports};

/// The unit, and what it measured since the last row.
pub(super) struct Imu {
    settings: KvhSettings,
    port: String,
    line: usize,
    opening: Option<Opening>,
    unit: Option<Kvh>,
    /// Rates and accelerations since the last row, and how many messages they are.
    sums: [f64; 6],
    sums_count: u32,
}

impl Imu {
    /// On a line that is not open yet.
    pub(super) fn closed(settings: KvhSettings, port: &str) -> Self {
        let port = port.to_owned();
        Self { settings, port, line: 0, opening: None, unit: None, sums: [0.0; 6], sums_count: 0 }
    }
}

impl Device for Imu {
    fn name(&self) -> &str {
        &self.settings.name
    }

    fn open(&mut self, ports: &mut Ports, now: Duration) -> Result<Option<()>, DeviceError> {
        let opening = match &mut self.opening {
            Some(opening) => opening,
            None => {
                self.line = ports.find_line(&self.settings.name, &self.port)?;
                self.opening.insert(Opening::new(self.settings.clone())?)
            }
        };
        self.unit = opening.poll(ports.line(self.line), now)?;
        Ok(self.unit.is_some().then_some(()))
    }

    fn identity(&self) -> Option<String> {
        self.unit.as_ref().map(|unit| format!("KVH 1775, serial {}", unit.identity().serial))
    }

    fn poll(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError> {
        let Some(unit) = &mut self.unit else { return Ok(()) };
        let messages_count = unit.poll(ports.line(self.line), now)?;
        if let (true, Some(sample)) = (messages_count > 0, unit.sample()) {
            let values = sample.rate_rad_per_s.iter().chain(&sample.acceleration_m_per_s2);
            self.sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
            self.sums_count += 1;
        }
        Ok(())
    }

    fn group(&self) -> Group {
        Group { topic: "imu", message: "Imu", channels: Kvh::CHANNELS }
    }

    /// Rates and accelerations are means since the row before: picking every n-th message would fold its noise.
    fn row(&mut self, row: &mut [f64]) {
        let Some(unit) = &self.unit else { return };
        let mut values = unit.row();
        if self.sums_count > 0 {
            let count = f64::from(self.sums_count);
            values.iter_mut().zip(self.sums).for_each(|(value, sum)| *value = sum / count);
        }
        row[..values.len()].copy_from_slice(&values);
        (self.sums, self.sums_count) = ([0.0; 6], 0);
    }

    fn rate_sensor(&self) -> Option<&Kvh> {
        self.unit.as_ref()
    }
}
