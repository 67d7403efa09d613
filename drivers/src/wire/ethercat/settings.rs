//! What an EtherCAT bus must be told.

use std::time::Duration;

use crate::device::DeviceError;

/// Longest wait for a reply to a cyclic frame: below the time after which ethercrab would send it again.
const MOST_REPLY_S: f64 = 0.02;
/// Resolution of the process-data watchdog with the divider that is written: 2498 + 2 periods of 25 MHz.
pub(super) const WATCHDOG_STEP_S: f64 = 100e-6;

/// Settings of an EtherCAT bus. SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct EtherCatSettings {
    /// Name for errors, e.g. `bus 0`.
    pub name: String,
    /// Time from one exchange to the next.
    pub cycle_s: f64,
    /// Longest wait for the reply to a cyclic frame; an exchange without a reply has working counter 0.
    pub reply_timeout_s: f64,
    /// Process-data watchdog of every station with outputs, in steps of 100 µs.
    pub watchdog_s: f64,
    /// Distributed clocks; `None` for stations that run freely or by frames.
    pub distributed_clocks: Option<DistributedClocks>,
    /// The stations that must be there, and no others, in any order; empty takes every line as it is.
    pub stations: Vec<ExpectedStation>,
    /// Whether the bus may be opened while a station is in SAFE-OP or OP. Opening takes all stations through INIT, where a drive
    /// that holds its axis lets go of it.
    pub may_let_go: bool,
}

/// Distributed clocks of a bus.
#[derive(Clone, Debug, PartialEq)]
pub struct DistributedClocks {
    /// Stations that get SYNC0; empty gives it to every station that can have it.
    pub sync0_stations: Vec<u16>,
    /// Period of SYNC0.
    pub sync0_period_s: f64,
    /// When a frame should pass the reference clock, after SYNC0.
    pub sync0_shift_s: f64,
    /// From the configuration to the first SYNC0.
    pub start_delay_s: f64,
    /// Frames that bring the clocks together when the bus is opened.
    pub static_sync_iterations: u32,
}

/// A station that must be on the bus.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ExpectedStation {
    /// Station, as in [`StationInfo::station`](super::StationInfo::station).
    pub station: u16,
    /// Who needs it, for messages, e.g. `az`.
    pub name: String,
    /// Vendor; `None` takes any.
    pub vendor: Option<u32>,
    /// Product code; `None` takes any.
    pub product: Option<u32>,
    /// Lowest and highest revision; `None` takes any.
    pub revisions: Option<[u32; 2]>,
    /// Serial number; `None` takes any.
    pub serial: Option<u32>,
}

impl EtherCatSettings {
    /// The usual settings for a cycle time: replies within half a cycle, a watchdog of 20 ms, SYNC0 once a cycle and frames
    /// half-way between, any stations, none of which may hold an axis.
    pub fn usual(name: &str, cycle_s: f64) -> Self {
        Self {
            name: name.to_owned(),
            cycle_s,
            reply_timeout_s: (cycle_s / 2.0).min(MOST_REPLY_S),
            watchdog_s: 0.02,
            distributed_clocks: Some(DistributedClocks {
                sync0_stations: Vec::new(),
                sync0_period_s: cycle_s,
                sync0_shift_s: cycle_s / 2.0,
                start_delay_s: 0.1,
                static_sync_iterations: 1000,
            }),
            stations: Vec::new(),
            may_let_go: false,
        }
    }

    /// Refuses values that no bus can be given.
    pub(super) fn check(&self) -> Result<(), DeviceError> {
        self.check_one("cycle_s", self.cycle_s, [50e-6, 1.0])?;
        self.check_one("reply_timeout_s", self.reply_timeout_s, [10e-6, MOST_REPLY_S])?;
        self.check_one("watchdog_s", self.watchdog_s, [WATCHDOG_STEP_S, 6.5])?;
        if let Some(clocks) = &self.distributed_clocks {
            self.check_one("sync0_period_s", clocks.sync0_period_s, [50e-6, 4.0])?;
            self.check_one("sync0_shift_s", clocks.sync0_shift_s, [0.0, clocks.sync0_period_s])?;
            self.check_one("start_delay_s", clocks.start_delay_s, [0.0, 4.0])?;
        }
        Ok(())
    }

    fn check_one(
        &self,
        setting: &'static str,
        value: f64,
        [least, most]: [f64; 2],
    ) -> Result<(), DeviceError> {
        if (least..=most).contains(&value) {
            return Ok(());
        }
        let allowed = format!("it must be from {least} to {most} s");
        Err(DeviceError::Setting { device: self.name.clone(), setting, value, allowed })
    }

    pub(super) fn reply_timeout(&self) -> Duration {
        Duration::from_secs_f64(self.reply_timeout_s)
    }

    /// The watchdog as its register counts it.
    pub(super) fn watchdog_steps(&self) -> u16 {
        (self.watchdog_s / WATCHDOG_STEP_S).round() as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_usual_settings_are_allowed_and_others_are_refused_by_name() {
        let usual = EtherCatSettings::usual("bus 0", 250e-6);
        assert_eq!(usual.check(), Ok(()));
        assert_eq!(usual.watchdog_steps(), 200);
        let slow = EtherCatSettings { reply_timeout_s: 0.05, ..usual.clone() };
        let text = slow.check().expect_err("it would be sent again").to_string();
        assert_eq!(text, "bus 0: setting reply_timeout_s is 0.05; it must be from 0.00001 to 0.02 s");
        assert!(EtherCatSettings { watchdog_s: f64::NAN, ..usual }.check().is_err());
    }
}
