//! What a CANopen bus must be told.

use std::time::Duration;

use super::super::ethercat::ExpectedStation;
use crate::device::DeviceError;

/// Heartbeats that may stay out before a node is lost (safety.md: deadlines).
const HEARTBEATS: u32 = 3;
/// Largest node-ID.
const MOST_NODE: u16 = 127;

/// Settings of a CANopen bus. SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct CanOpenSettings {
    /// Name for errors, e.g. `bus 0`.
    pub name: String,
    /// Time from one SYNC to the next.
    pub cycle_s: f64,
    /// Bit rate that the interface was set to; with it the load of the bus is computed.
    pub bit_rate_hz: f64,
    /// Node-ID of the bench, whose heartbeat the drives supervise.
    pub own_node: u8,
    /// Period of the heartbeats of the nodes (1017h) and of the bench. Who is silent for three of them is lost (1016h).
    pub heartbeat_s: f64,
    /// The nodes that must be there, by their node-ID as station.
    pub nodes: Vec<ExpectedStation>,
    /// Whether drives may let go of what they hold when the bus is opened: somebody has secured the axes, or no drive is real.
    pub may_let_go: bool,
}

impl CanOpenSettings {
    /// The usual settings for a cycle time: 1 Mbit/s, heartbeats every 50 ms, the bench as node 127; nodes of any make.
    pub fn usual(name: &str, cycle_s: f64, nodes: &[u8]) -> Self {
        let node = |&node| ExpectedStation { station: u16::from(node), ..Default::default() };
        Self {
            name: name.to_owned(),
            cycle_s,
            bit_rate_hz: 1e6,
            own_node: 127,
            heartbeat_s: 0.05,
            nodes: nodes.iter().map(node).collect(),
            may_let_go: false,
        }
    }

    /// Refuses values that no bus can be given.
    pub(super) fn check(&self) -> Result<(), DeviceError> {
        self.check_one("cycle_s", self.cycle_s, [200e-6, 1.0], "s")?;
        self.check_one("bit_rate_hz", self.bit_rate_hz, [10e3, 1e6], "Hz")?;
        self.check_one("heartbeat_s", self.heartbeat_s, [0.005, 10.0], "s")?;
        self.check_one("own_node", f64::from(self.own_node), [1.0, f64::from(MOST_NODE)], "(node-ID)")?;
        let numbers: Vec<_> = self.nodes.iter().map(|node| node.station).collect();
        let is_wrong = |k: usize| {
            let node = numbers[k];
            node == 0 || node > MOST_NODE || node == u16::from(self.own_node) || numbers[..k].contains(&node)
        };
        if numbers.is_empty() || (0..numbers.len()).any(is_wrong) {
            return Err(DeviceError::Field {
                device: self.name.clone(),
                field: "nodes",
                expected: format!(
                    "at least one node-ID of 1 to {MOST_NODE}, each once, none of them {}",
                    self.own_node
                ),
                found: format!("{numbers:?}"),
                help: "correct the stations in the rig file",
            });
        }
        Ok(())
    }

    fn check_one(
        &self,
        setting: &'static str,
        value: f64,
        [least, most]: [f64; 2],
        unit: &str,
    ) -> Result<(), DeviceError> {
        if (least..=most).contains(&value) {
            return Ok(());
        }
        let allowed = format!("it must be from {least} to {most} {unit}");
        Err(DeviceError::Setting { device: self.name.clone(), setting, value, allowed })
    }

    /// Period of heartbeats, in whole milliseconds as 1017h has it.
    pub(super) fn heartbeat_ms(&self) -> u16 {
        (self.heartbeat_s * 1e3).round() as u16
    }

    /// Silence after which a node is lost, in whole milliseconds as 1016h has it.
    pub(super) fn silence_ms(&self) -> u16 {
        self.heartbeat_ms() * HEARTBEATS as u16
    }

    pub(super) fn heartbeat(&self) -> Duration {
        Duration::from_millis(u64::from(self.heartbeat_ms()))
    }

    pub(super) fn silence(&self) -> Duration {
        self.heartbeat() * HEARTBEATS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_usual_settings_are_allowed_and_others_are_refused_by_name() {
        let usual = CanOpenSettings::usual("bus 0", 2e-3, &[1, 2]);
        assert_eq!(usual.check(), Ok(()));
        assert_eq!((usual.heartbeat_ms(), usual.silence_ms()), (50, 150));
        let fast = CanOpenSettings { heartbeat_s: 0.001, ..usual.clone() };
        let text = fast.check().expect_err("it would fill the bus").to_string();
        assert_eq!(text, "bus 0: setting heartbeat_s is 0.001; it must be from 0.005 to 10 s");
        assert!(CanOpenSettings { bit_rate_hz: f64::NAN, ..usual }.check().is_err());
    }

    #[test]
    fn node_ids_must_differ_from_each_other_and_from_the_benchs_own() {
        for nodes in [&[][..], &[0], &[1, 1], &[128], &[3, 127]] {
            let error = CanOpenSettings::usual("bus 0", 2e-3, nodes).check().expect_err("no such bus");
            assert!(error.to_string().contains("none of them 127"), "{error}");
        }
    }
}
