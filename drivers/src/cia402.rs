//! Drives that speak CiA 402 over a fieldbus.

mod change;
mod configure;
mod error_code;
mod frame;
pub(crate) mod frames;
mod heat_sink;
pub mod objects;
pub mod pdo;
mod power;
pub mod profile;
mod scale;
mod sdo;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::time::Duration;

pub use self::change::DriveLimits;
pub use self::configure::{check_cycle, is_drive};
pub use self::error_code::error_code_meaning;
pub use self::power::{PowerRules, PowerSequence, PowerState, PowerTarget};
pub(crate) use self::sdo::Dictionary;
pub use self::sdo::{Waiting, abort_meaning};

use self::change::Change;
use self::frame::{InputPlaces, Inputs, OutputPlaces, Outputs};
use self::heat_sink::SdoHeatSink;
use self::profile::{DriveProfile, ReadBy};
use self::scale::Scale;
use crate::device::{Channel, DeviceError, Width};
use crate::wire::{SdoWire, Slot};

/// What a drive must be told and checked against before it is armed. SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveSettings {
    /// Name in errors and topics, e.g. `az`.
    pub name: String,
    /// Station on the bus.
    pub station: u16,
    /// Type of the drive.
    pub profile: Arc<DriveProfile>,
    /// Torque constant, N·m per A.
    pub torque_constant_nm_per_a: f64,
    /// Expected rated current (6075).
    pub rated_current_a: f64,
    /// Expected rated torque (6076).
    pub rated_torque_nm: f64,
    /// Torque limit (6072).
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
    /// Process-data watchdog of the drive itself, where its type has one.
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
    /// Heat sink; not a number where the type of the drive does not tell it, and where a drive that tells it by SDO has been
    /// silent for too long.
    pub heat_sink_degc: f64,
    /// Raw 60FD; 0 where it is not in the process data.
    pub digital_inputs: u32,
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

impl CyclicMode {
    /// Value of 6060h and 6061h.
    pub const fn code(self) -> i8 {
        match self {
            Self::Torque => 10,
            Self::Velocity => 9,
        }
    }
}

/// A drive that was identified and configured; it can be commanded only through a process image.
#[derive(Clone, Debug)]
pub struct Cia402 {
    settings: DriveSettings,
    /// Current limit that the drive was commissioned to (6073); `None` for a type that lacks it.
    max_current_a: Option<f64>,
    scale: Scale,
    inputs: InputPlaces,
    outputs: OutputPlaces,
    slot: Slot,
    power: PowerSequence,
    /// Unwrapped count of the last exchange, in the sense of the angle.
    unwrapped: Option<i64>,
    last: Actuals,
    /// Other limits that the drive is being given.
    change: Option<Change>,
    /// The temperature of the heat sink, where it is read by SDO.
    heat_sink: Option<SdoHeatSink>,
}

/// Name of the temperature of the heat sink in messages.
const HEAT_SINK: &str = "heat sink temperature";

impl Cia402 {
    /// What the driver publishes each tick, in the order of [`Actuals::row`].
    pub const CHANNELS: &'static [Channel] = &[
        channel("position_rad", "rad", Width::F64),
        channel("velocity_rad_per_s", "rad/s", Width::F32),
        channel("current_a", "A", Width::F32),
        channel("torque_nm", "N*m", Width::F32),
        channel("bus_v", "V", Width::F32),
        channel("heat_sink_degc", "degC", Width::F32),
        channel("position_counts", "count", Width::I32),
        channel("digital_inputs", "", Width::U32),
        channel("statusword", "", Width::U16),
        channel("error_code", "", Width::U16),
        channel("mode", "", Width::I8),
    ];

    /// Identifies, configures and reads back everything over SDO (bus in PRE-OP; nothing can move).
    ///
    /// # Errors
    /// Device, object, expected and found, on the first mismatch or abort; a setting that the drive cannot be given.
    pub fn open(
        wire: &mut dyn SdoWire,
        settings: DriveSettings,
        waiting: &mut Waiting<'_>,
    ) -> Result<(Self, Identity), DeviceError> {
        let scale = Scale::new(&settings)?;
        let profile = &*settings.profile;
        let mut drive = Dictionary { wire, waiting, device: &settings.name, station: settings.station };
        let identity = configure::identify(&mut drive, profile)?;
        configure::start_up(&mut drive, &profile.start_up)?;
        configure::check_scales(&mut drive, &settings)?;
        let max_current_a = configure::commissioned_current_a(&mut drive, &settings)?;
        let of_outputs = [objects::RX_ASSIGNMENT, objects::RX_MAPPING];
        let of_inputs = [objects::TX_ASSIGNMENT, objects::TX_MAPPING];
        let output_layout = configure::map(&mut drive, &profile.outputs, of_outputs)?;
        let input_layout = configure::map(&mut drive, &profile.inputs, of_inputs)?;
        let outputs = OutputPlaces::new(&drive, &output_layout)?;
        let inputs = InputPlaces::new(&drive, &input_layout, profile)?;
        configure::configure(&mut drive, &settings, &scale)?;
        let heat_sink = match profile.heat_sink.filter(|own| own.by == ReadBy::Sdo) {
            Some(own) => Some(SdoHeatSink::read(&mut drive, own)?),
            None => None,
        };
        let (slot, power, last) = Default::default();
        let (unwrapped, change) = (None, None);
        let opened = Self {
            settings,
            max_current_a,
            scale,
            inputs,
            outputs,
            slot,
            power,
            unwrapped,
            last,
            change,
            heat_sink,
        };
        Ok((opened, identity))
    }

    /// Torque that the drive can give at the most, N·m: its torque limit, or what its commissioned current limit (6073h)
    /// leaves of it.
    pub fn available_torque_nm(&self) -> f64 {
        let by_current = |limit_a: f64| limit_a * self.settings.torque_constant_nm_per_a;
        self.settings.max_torque_nm.min(self.max_current_a.map_or(f64::INFINITY, by_current))
    }

    /// Tells the driver where its data lie in the process image of its bus, and forgets the wrap count.
    pub fn attach(&mut self, slot: Slot) {
        self.slot = slot;
        self.unwrapped = None;
    }

    /// Whether the process data hold the digital inputs (60FDh).
    pub fn sends_digital_inputs(&self) -> bool {
        self.inputs.sends_digital_inputs()
    }

    /// The settings it was opened with.
    pub fn settings(&self) -> &DriveSettings {
        &self.settings
    }

    /// Decodes the drive's inputs out of the inputs of its bus. Keeps the wrap count of the single-turn position:
    /// the first sample lies within half a turn of the encoder offset, (−π, π], the next ones nearest to the last.
    ///
    /// If the image does not hold the drive's slot, the last values stand with statusword 0 ("not ready"), which
    /// no interlock takes for an enabled drive.
    pub fn decode(&mut self, inputs: &[u8]) -> Actuals {
        let slot = inputs.get(self.slot.inputs.clone());
        let decoded = slot.and_then(|slot| Inputs::read(slot, &self.inputs));
        self.last = match decoded {
            Some(inputs) => self.convert(inputs),
            None => Actuals { statusword: 0, ..self.last },
        };
        self.last
    }

    fn convert(&mut self, inputs: Inputs) -> Actuals {
        let heat_sink_degc = match (self.settings.profile.heat_sink, inputs.heat_sink_counts, &self.heat_sink)
        {
            (Some(own), Some(counts), _) => counts as f64 / own.counts_per_degc,
            (_, _, Some(by_sdo)) => by_sdo.degc(),
            _ => f64::NAN,
        };
        let unwrapped = self.scale.unwrap(inputs.position_counts, self.unwrapped);
        self.unwrapped = Some(unwrapped);
        Actuals {
            position_rad: self.scale.angle_rad(unwrapped),
            velocity_rad_per_s: self.scale.velocity_rad_per_s(inputs.velocity_counts_per_s),
            current_a: self.scale.current_a(inputs.current_permille),
            torque_nm: self.scale.torque_nm(inputs.torque_permille),
            bus_v: f64::from(inputs.dc_link_mv) / 1e3,
            heat_sink_degc,
            digital_inputs: inputs.digital_inputs,
            position_counts: inputs.position_counts,
            statusword: inputs.statusword,
            error_code: inputs.error_code,
            mode: inputs.mode,
        }
    }

    /// Encodes a command into the drive's outputs within the outputs of its bus, saturating at its limits; returns
    /// the torque really sent (after rounding to ‰), N·m. Not a number is sent as 0; without the drive's slot
    /// nothing is sent.
    pub fn encode(&self, command: &DriveCommand, outputs: &mut [u8]) -> f64 {
        let torque_permille = self.scale.torque_permille(command.torque_nm);
        let words = Outputs {
            controlword: command.controlword,
            torque_permille,
            velocity_counts_per_s: self.scale.velocity_counts(command.velocity_rad_per_s),
            mode: command.mode.code(),
        };
        match outputs.get_mut(self.slot.outputs.clone()).and_then(|slot| words.write(slot, &self.outputs)) {
            Some(()) => self.scale.torque_nm(torque_permille),
            None => 0.0,
        }
    }

    /// The controlword of this tick on the way to `target`, or an error if a transition takes too long.
    /// `now` is the time since the start of the run; calling with another target restarts the timeout.
    ///
    /// One transition per call: the next word waits for the state that the last one leads to. A fault is reset by a
    /// rising edge of bit 7: once 0000h, then 0080h until the fault is left.
    ///
    /// # Errors
    /// [`DeviceError::StateTimeout`]; [`DeviceError::Fault`] at once on a fault unless `target` is `FaultReset` or
    /// `Disabled`.
    pub fn controlword(
        &mut self,
        target: PowerTarget,
        statusword: u16,
        error_code: u16,
        now: Duration,
    ) -> Result<u16, DeviceError> {
        let rules = PowerRules {
            device: &self.settings.name,
            quick_stop_option: self.settings.quick_stop_option,
            timeout_s: self.settings.transition_timeout_s,
        };
        self.power.controlword(&rules, target, statusword, error_code, now)
    }
}

impl Actuals {
    /// The values in the order of [`Cia402::CHANNELS`].
    pub fn row(&self) -> [f64; 11] {
        [
            self.position_rad,
            self.velocity_rad_per_s,
            self.current_a,
            self.torque_nm,
            self.bus_v,
            self.heat_sink_degc,
            f64::from(self.position_counts),
            f64::from(self.digital_inputs),
            f64::from(self.statusword),
            f64::from(self.error_code),
            f64::from(self.mode),
        ]
    }
}

const fn channel(name: &'static str, unit: &'static str, width: Width) -> Channel {
    Channel { name, unit, width }
}
