//! Drives that speak CiA 402 over a fieldbus.

pub mod objects;
pub mod pdo;

use std::time::Duration;

use crate::device::{Channel, DeviceError};
use crate::wire::{SdoWire, Slot};

/// What a drive must be told and checked against before it is armed. SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveSettings {
    /// Name in errors and topics, e.g. `az`.
    pub name: String,
    /// Station on the bus.
    pub station: u16,
    /// Torque constant, N·m per A.
    pub torque_constant_nm_per_a: f64,
    /// Expected rated current (6075).
    pub rated_current_a: f64,
    /// Expected rated torque (6076).
    pub rated_torque_nm: f64,
    /// Torque limit (6072 and 6073).
    pub max_torque_nm: f64,
    /// Encoder counts per revolution (608F).
    pub encoder_counts_per_rev: u32,
    /// Angle of encoder count 0.
    pub encoder_offset_rad: f64,
    /// +1 or −1: whether counts grow with the angle.
    pub encoder_sign: f64,
    /// Soft limits (607D).
    pub soft_limits_rad: [f64; 2],
    /// Largest speed (6080).
    pub max_velocity_rad_per_s: f64,
    /// Quick stop deceleration (6085).
    pub quick_stop_deceleration_rad_per_s2: f64,
    /// Quick stop option code (605A).
    pub quick_stop_option: i16,
    /// Fault reaction option code (605E).
    pub fault_reaction_option: i16,
    /// Abort connection option code (6007).
    pub abort_connection_option: i16,
    /// Process-data watchdog.
    pub watchdog_s: f64,
    /// Cycle time (60C2).
    pub cycle_s: f64,
    /// Time allowed for each power state transition.
    pub transition_timeout_s: f64,
}

/// Identity as read from the drive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Device name (1008h).
    pub device_name: String,
    /// Vendor (1018h:1).
    pub vendor: u32,
    /// Product (1018h:2).
    pub product: u32,
    /// Revision (1018h:3).
    pub revision: u32,
    /// Serial number (1018h:4).
    pub serial: u32,
    /// Firmware (100Ah).
    pub firmware: String,
}

/// Power states of CiA 402.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum PowerState {
    NotReady,
    SwitchOnDisabled,
    ReadyToSwitchOn,
    SwitchedOn,
    OperationEnabled,
    QuickStopActive,
    FaultReactionActive,
    Fault,
    /// A pattern that the profile does not know.
    Unknown(u16),
}

/// Where the power stage is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PowerTarget {
    /// No torque.
    Disabled,
    /// Torque on, following commands. Faults are not reset on the way.
    Enabled,
    /// Quick stop as configured.
    QuickStop,
    /// Out of a fault: disabled, the fault reset by a rising edge.
    FaultReset,
}

/// Cyclic modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CyclicMode {
    /// CST, mode 10.
    Torque,
    /// CSV, mode 9.
    Velocity,
}

/// What the drive said in one exchange, in SI units; the raw words are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Actuals {
    /// Angle, unwrapped.
    pub position_rad: f64,
    /// Rate from 606C.
    pub velocity_rad_per_s: f64,
    /// Current from 6078.
    pub current_a: f64,
    /// Torque from 6077.
    pub torque_nm: f64,
    /// DC link from 6079.
    pub bus_v: f64,
    /// Heat sink.
    pub heat_sink_degc: f64,
    /// Raw 6064.
    pub position_counts: i32,
    /// Raw 6041.
    pub statusword: u16,
    /// Raw 603F.
    pub error_code: u16,
    /// Raw 6061.
    pub mode: i8,
}

/// What the drive is told in one exchange.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveCommand {
    /// Raw 6040, from [`Cia402::controlword`].
    pub controlword: u16,
    /// Mode for 6060.
    pub mode: CyclicMode,
    /// Torque target for CST.
    pub torque_nm: f64,
    /// Velocity target for CSV.
    pub velocity_rad_per_s: f64,
}

/// A drive that was identified and configured; it can be commanded only through a process image.
#[derive(Clone, Debug)]
pub struct Cia402 {
    settings: DriveSettings,
}

impl Cia402 {
    /// What the driver publishes each tick, in the order of [`Actuals::row`].
    pub const CHANNELS: &'static [Channel] = &[];

    /// Identifies, configures and reads back everything over SDO (bus in PRE-OP; nothing can move).
    ///
    /// # Errors
    /// Device, object, expected and found, on the first mismatch or abort.
    pub fn open(wire: &mut dyn SdoWire, settings: DriveSettings) -> Result<(Self, Identity), DeviceError> {
        let _ = wire;
        let _ = Self { settings };
        todo!()
    }

    /// Tells the driver where its data lie in the process image.
    pub fn attach(&mut self, slot: Slot) {
        let _ = (slot, &self.settings);
        todo!()
    }

    /// The settings it was opened with.
    pub fn settings(&self) -> &DriveSettings {
        &self.settings
    }

    /// Decodes the drive's inputs. Keeps the wrap count of the single-turn position.
    pub fn decode(&mut self, inputs: &[u8]) -> Actuals {
        let _ = inputs;
        todo!()
    }

    /// Encodes a command into the drive's outputs, saturating at its limits; returns the torque really sent
    /// (after rounding to ‰), N·m.
    pub fn encode(&self, command: &DriveCommand, outputs: &mut [u8]) -> f64 {
        let _ = (command, outputs);
        todo!()
    }

    /// The controlword of this tick on the way to `target`, or an error if a transition takes too long.
    /// `now` is the time since the start of the run; calling with another target restarts the timeout.
    ///
    /// # Errors
    /// [`DeviceError::StateTimeout`]; also at once on a fault unless `target` is `FaultReset` or `Disabled`.
    pub fn controlword(
        &mut self,
        target: PowerTarget,
        statusword: u16,
        error_code: u16,
        now: Duration,
    ) -> Result<u16, DeviceError> {
        let _ = (target, statusword, error_code, now);
        todo!()
    }
}

impl PowerState {
    /// Decodes a statusword by the masks of CiA 402.
    pub fn of(statusword: u16) -> Self {
        let _ = statusword;
        todo!()
    }
}

impl Actuals {
    /// The values in the order of [`Cia402::CHANNELS`].
    pub fn row(&self) -> [f64; 10] {
        todo!()
    }
}

/// What a CiA 402 error code means, e.g. 4310h drive over-temperature.
pub fn error_code_meaning(code: u16) -> &'static str {
    let _ = code;
    todo!()
}
