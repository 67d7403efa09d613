//! Orders to a running `bench sim`, one JSON object a line: faults, scenery, stop.

use std::time::Duration;

use procedures::case::Case;
use serde::{Deserialize, Serialize};
use sim_devices::canopen;
use sim_devices::ethercat::{Emergency, LineFault};
use sim_devices::rig::{EncoderFault, Fault};

/// What a client asks for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Order {
    /// Something goes wrong on an EtherCAT wire, or is put right.
    Wire(WireFault),
    /// Something goes wrong at a node of a CAN bus, or is put right.
    Node(NodeFault),
    /// Something goes wrong in the world behind it, or is put right.
    World(WorldFault),
    /// The surroundings change as a point asks for: target, frame rate, pull.
    Bring(Box<Case>),
    /// How the simulator is.
    Status,
    /// The simulator ends.
    Stop,
}

/// Faults of frames and SubDevices; `device` counts from 0 in the order of the line. Times are in seconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[allow(missing_docs)]
pub enum WireFault {
    Drop { frames: u32 },
    Delay { frames: u32, by_s: f64 },
    Duplicate { frames: u32 },
    Corrupt { frames: u32, byte: usize },
    Truncate { frames: u32, bytes: usize },
    WorkingCounter { frames: u32, by: i16 },
    Unplugged { device: usize, is_gone: bool },
    AlError { device: usize, code: u16 },
    RefusesTransitions { device: usize, code: Option<u16> },
    SlowTransitions { device: usize, take_s: f64 },
    Watchdog { device: usize },
    Mute { device: usize, is_mute: bool },
    SlowMailbox { device: usize, take_s: f64 },
    RefusesSdo { device: usize, code: Option<u32> },
    Emergency { device: usize, code: u16, register: u8 },
    ClockStep { device: usize, by_ns: i64 },
    ClockDrift { device: usize, rate_ppm: f64 },
    Sync0Lost { device: usize, is_lost: bool },
}

/// Faults of nodes on a CAN bus, by node-ID.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[allow(missing_docs)]
pub enum NodeFault {
    Silent { node: u8, is_silent: bool },
    HeartbeatStopped { node: u8, is_stopped: bool },
    SdoMute { node: u8, is_mute: bool },
    WrongToggle { node: u8 },
    RefusesSdo { node: u8, code: Option<u32> },
    Emergency { node: u8, code: u16, register: u8 },
    Restart { node: u8 },
}

/// Faults of drives and of the world; `drive` is 0 for station 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[allow(missing_docs)]
pub enum WorldFault {
    EncoderError { drive: usize, is_wrong: bool },
    EncoderFrozen { drive: usize },
    EncoderJump { drive: usize, by_rad: f64 },
    Drive { drive: usize, code: u16 },
    CurrentStuck { drive: usize, current_a: f64 },
    SafeTorqueOff { drive: usize, active: bool },
    EmergencyStop { pressed: bool },
    EnablingSwitch { held: bool },
    SupplyLost,
    HeatSink { drive: usize, degc: f64 },
}

/// What a client is told.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Answer {
    /// It is done.
    Done(String),
    /// It is not, and why.
    Refused(String),
}

/// A time of an order; one that is no time is none.
fn time(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or_default()
}

impl From<WireFault> for LineFault {
    fn from(fault: WireFault) -> Self {
        match fault {
            WireFault::Drop { frames } => Self::Drop { frames },
            WireFault::Delay { frames, by_s } => Self::Delay { frames, by: time(by_s) },
            WireFault::Duplicate { frames } => Self::Duplicate { frames },
            WireFault::Corrupt { frames, byte } => Self::Corrupt { frames, byte },
            WireFault::Truncate { frames, bytes } => Self::Truncate { frames, bytes },
            WireFault::WorkingCounter { frames, by } => Self::WorkingCounter { frames, by },
            WireFault::Unplugged { device, is_gone } => Self::Unplugged { device, is_gone },
            WireFault::AlError { device, code } => Self::AlError { device, code },
            WireFault::RefusesTransitions { device, code } => Self::RefusesTransitions { device, code },
            WireFault::SlowTransitions { device, take_s } => {
                Self::SlowTransitions { device, take: time(take_s) }
            }
            WireFault::Watchdog { device } => Self::Watchdog { device },
            WireFault::Mute { device, is_mute } => Self::Mute { device, is_mute },
            WireFault::SlowMailbox { device, take_s } => Self::SlowMailbox { device, take: time(take_s) },
            WireFault::RefusesSdo { device, code } => Self::RefusesSdo { device, code },
            WireFault::Emergency { device, code, register } => {
                Self::Emergency { device, emergency: Emergency { code, register, vendor: [0; 5] } }
            }
            WireFault::ClockStep { device, by_ns } => Self::ClockStep { device, by_ns },
            WireFault::ClockDrift { device, rate_ppm } => Self::ClockDrift { device, rate_ppm },
            WireFault::Sync0Lost { device, is_lost } => Self::Sync0Lost { device, is_lost },
        }
    }
}

impl From<NodeFault> for canopen::NodeFault {
    fn from(fault: NodeFault) -> Self {
        match fault {
            NodeFault::Silent { node, is_silent } => Self::Silent { node, is_silent },
            NodeFault::HeartbeatStopped { node, is_stopped } => Self::HeartbeatStopped { node, is_stopped },
            NodeFault::SdoMute { node, is_mute } => Self::SdoMute { node, is_mute },
            NodeFault::WrongToggle { node } => Self::WrongToggle { node },
            NodeFault::RefusesSdo { node, code } => Self::RefusesSdo { node, code },
            NodeFault::Emergency { node, code, register } => Self::Emergency { node, code, register },
            NodeFault::Restart { node } => Self::Restart { node },
        }
    }
}

impl From<WorldFault> for Fault {
    fn from(fault: WorldFault) -> Self {
        match fault {
            WorldFault::EncoderError { drive, is_wrong } => {
                Self::Encoder { drive, fault: is_wrong.then_some(EncoderFault::Error) }
            }
            WorldFault::EncoderFrozen { drive } => Self::EncoderFrozen { drive },
            WorldFault::EncoderJump { drive, by_rad } => Self::EncoderJump { drive, by_rad },
            WorldFault::Drive { drive, code } => Self::Drive { drive, code },
            WorldFault::CurrentStuck { drive, current_a } => Self::CurrentStuck { drive, current_a },
            WorldFault::SafeTorqueOff { drive, active } => Self::SafeTorqueOff { drive, active },
            WorldFault::EmergencyStop { pressed } => Self::EmergencyStop { pressed },
            WorldFault::EnablingSwitch { held } => Self::EnablingSwitch { held },
            WorldFault::SupplyLost => Self::SupplyLost,
            WorldFault::HeatSink { drive, degc } => Self::HeatSink { drive, degc },
        }
    }
}

/// Reads an order.
///
/// # Errors
/// What is wrong with it, in words.
pub fn read(line: &str) -> Result<Order, String> {
    serde_json::from_str(line).map_err(|error| {
        format!(
            "{error}; an order is one JSON object or word, e.g. \"stop\", {{\"wire\":{{\"drop\":{{\"frames\":3}}}}}}"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_one_line_of_json() {
        let rows = [
            (r#""stop""#, Order::Stop),
            (r#"{"wire":{"drop":{"frames":3}}}"#, Order::Wire(WireFault::Drop { frames: 3 })),
            (
                r#"{"wire":{"delay":{"frames":1,"by_s":0.3}}}"#,
                Order::Wire(WireFault::Delay { frames: 1, by_s: 0.3 }),
            ),
            (
                r#"{"node":{"silent":{"node":2,"is_silent":true}}}"#,
                Order::Node(NodeFault::Silent { node: 2, is_silent: true }),
            ),
            (r#"{"world":"supply-lost"}"#, Order::World(WorldFault::SupplyLost)),
        ];
        for (line, order) in rows {
            assert_eq!(read(line), Ok(order.clone()), "{line}");
            assert_eq!(serde_json::to_string(&order).expect("plain data"), line);
        }
    }

    #[test]
    fn a_misspelt_order_names_what_there_is() {
        let error = read(r#"{"wire":{"dropp":{"frames":3}}}"#).expect_err("misspelt");
        assert!(error.contains("dropp") && error.contains("drop"), "{error}");
        assert!(read("nonsense").is_err());
        assert!(read(r#"{"wire":{"drop":{"frames":3,"x":1}}}"#).is_err(), "unknown key");
    }

    #[test]
    fn a_time_that_is_no_number_delays_nothing() {
        let fault = LineFault::from(WireFault::Delay { frames: 1, by_s: -1.0 });
        assert_eq!(fault, LineFault::Delay { frames: 1, by: Duration::ZERO });
    }
}
