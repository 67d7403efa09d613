//! What differs from one type of drive to the next, as plain data. `drivers/profiles/*.toml` hold it; the bench reads them.

use super::objects::{self, Access, DataType, Object};
use super::pdo::Entry;

/// A type of drive.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveProfile {
    /// Name in messages, e.g. `elmo-gold`.
    pub id: String,
    /// Who such a drive says it is.
    pub identity: ProfileIdentity,
    /// Host to drive. Must hold [`OUTPUTS`] and nothing else but padding.
    pub outputs: ProcessData,
    /// Drive to host. Must hold [`INPUTS`].
    pub inputs: ProcessData,
    /// What 1000 of the torque objects (6071h, 6072h, 6077h) are.
    pub torque_scale: TorqueScale,
    /// How it follows the distributed clocks of an EtherCAT wire.
    pub clock: DriveClock,
    /// Where the temperature of the heat sink is read; `None` for a type that does not tell it.
    pub heat_sink: Option<HeatSink>,
    /// Object of a process-data watchdog that the drive itself has; `None` where only the bus has one.
    pub watchdog: Option<WatchdogObject>,
    /// Objects out of [`MAY_LACK`] that it does not have or cannot be given.
    pub lacks: Vec<ObjectPlace>,
    /// Objects that are written, and read back, before anything else is.
    pub start_up: Vec<StartUp>,
}

/// Identity of a drive type (1018h); `None` takes any.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProfileIdentity {
    /// Vendor.
    pub vendor: Option<u32>,
    /// Product code.
    pub product: Option<u32>,
    /// Lowest and highest revision.
    pub revisions: Option<[u32; 2]>,
}

/// Process data of one direction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ProcessData {
    /// Entries that are written into the first PDO (1600h or 1A00h), which is then the only one that is assigned.
    Mapped(Vec<Entry>),
    /// PDOs with a fixed mapping that are assigned in this order; their entries are read from the drive.
    Assigned(Vec<u16>),
}

/// What 1000 of the torque objects are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TorqueScale {
    /// The rated torque (6076h), as CiA 402 has it.
    RatedTorque,
    /// The torque of the rated current (6075h): torque objects are currents.
    RatedCurrent,
}

/// How a drive follows the distributed clocks of an EtherCAT wire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveClock {
    /// Whether it gets SYNC0 (AssignActivate 0300h of its ESI); otherwise it runs by the frames.
    pub has_sync0: bool,
    /// When a frame should pass after SYNC0; `None` leaves it to the bus.
    pub sync0_shift_s: Option<f64>,
    /// Shortest cycle that it follows; `None` where that is not known.
    pub shortest_cycle_s: Option<f64>,
}

/// Where an object is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObjectPlace {
    /// Index.
    pub index: u16,
    /// Sub-index.
    pub sub: u8,
}

/// Where the temperature of the heat sink is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatSink {
    /// Object.
    pub place: ObjectPlace,
    /// Coding.
    pub data_type: DataType,
    /// Counts of 1 °C.
    pub counts_per_degc: f64,
    /// How it is read.
    pub by: ReadBy,
}

/// How an actual value comes from a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReadBy {
    /// In every exchange.
    ProcessData,
    /// By SDO, once a second.
    Sdo,
}

/// Object of a watchdog of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WatchdogObject {
    /// Object.
    pub place: ObjectPlace,
    /// Coding.
    pub data_type: DataType,
    /// Time of one count.
    pub step_s: f64,
}

/// An object that is written in PRE-OP and read back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StartUp {
    /// Object.
    pub place: ObjectPlace,
    /// Coding.
    pub data_type: DataType,
    /// Value; lies in the range of the coding.
    pub value: i64,
    /// Why it is written.
    pub why: String,
}

/// Objects that the outputs of every drive must hold.
pub const OUTPUTS: &[Object] =
    &[objects::CONTROLWORD, objects::TARGET_TORQUE, objects::TARGET_VELOCITY, objects::MODE];

/// Objects that the inputs of every drive must hold. 6078h may be missing where torque objects are currents, and 60FDh where
/// nothing is wired to the inputs of the drive.
pub const INPUTS: &[Object] = &[
    objects::STATUSWORD,
    objects::ERROR_CODE,
    objects::MODE_DISPLAY,
    objects::POSITION,
    objects::VELOCITY,
    objects::TORQUE,
    objects::DC_LINK,
];

/// An object that a type of drive may lack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MayLack {
    /// The object.
    pub object: Object,
    /// What nobody checks or enforces then, as a residual risk.
    pub consequence: &'static str,
}

/// All objects that a type of drive may lack. What keeps an axis safe without the bench (6007h, 605Ah, 605Eh, 6072h, 6085h) is
/// not among them.
pub const MAY_LACK: &[MayLack] = &[
    may_lack(objects::DEVICE_NAME, "the report does not name its type"),
    may_lack(objects::FIRMWARE, "the report does not name its firmware"),
    may_lack(
        objects::MAX_CURRENT,
        "stops rely on the torque limit, whatever current limit it was commissioned to",
    ),
    may_lack(
        objects::ENCODER_COUNTS,
        "only the check of polarity compares its encoder scale with the rig file",
    ),
    may_lack(
        objects::ENCODER_REVOLUTIONS,
        "only the check of polarity compares its encoder scale with the rig file",
    ),
    may_lack(objects::FOLLOWING_ERROR_WINDOW, "its own following-error supervision stays as commissioned"),
    may_lack(objects::FOLLOWING_ERROR_TIME, "its own following-error supervision stays as commissioned"),
    may_lack(objects::SOFT_LIMIT_MIN, "it keeps no soft limits; only the bench does"),
    may_lack(objects::SOFT_LIMIT_MAX, "it keeps no soft limits; only the bench does"),
    may_lack(objects::MAX_SPEED, "it limits no speed; only the bench does"),
    may_lack(objects::INTERPOLATION_PERIOD, "it is not told the cycle time"),
    may_lack(objects::INTERPOLATION_EXPONENT, "it is not told the cycle time"),
];

const fn may_lack(object: Object, consequence: &'static str) -> MayLack {
    MayLack { object, consequence }
}

impl DriveProfile {
    /// Whether drives of this type lack an object.
    pub fn lacks(&self, object: Object) -> bool {
        self.lacks.iter().any(|place| place.is_of(object))
    }

    /// What nobody checks or enforces because the type lacks objects, each sentence once.
    pub fn consequences(&self) -> Vec<&'static str> {
        let mut all: Vec<&'static str> = Vec::new();
        for may in MAY_LACK.iter().filter(|may| self.lacks(may.object)) {
            if !all.contains(&may.consequence) {
                all.push(may.consequence);
            }
        }
        all
    }
}

/// Objects that the driver writes itself, so that no start-up list may.
const WRITTEN: &[Object] = &[
    objects::CONTROLWORD,
    objects::QUICK_STOP_OPTION,
    objects::FAULT_REACTION_OPTION,
    objects::ABORT_CONNECTION_OPTION,
    objects::MODE,
    objects::FOLLOWING_ERROR_WINDOW,
    objects::FOLLOWING_ERROR_TIME,
    objects::TARGET_TORQUE,
    objects::MAX_TORQUE,
    objects::SOFT_LIMIT_MIN,
    objects::SOFT_LIMIT_MAX,
    objects::MAX_SPEED,
    objects::QUICK_STOP_DECELERATION,
    objects::INTERPOLATION_PERIOD,
    objects::INTERPOLATION_EXPONENT,
    objects::TARGET_VELOCITY,
];

impl DriveProfile {
    /// Whether the driver writes an object of such a drive itself: its settings, and what lays out its process data.
    pub fn writes(&self, place: ObjectPlace) -> bool {
        let is_pdo_list = matches!(place.index, 0x1600..=0x17FF | 0x1A00..=0x1BFF | 0x1C12 | 0x1C13);
        let is_setting = WRITTEN.iter().any(|object| place.is_of(*object) && !self.lacks(*object));
        is_pdo_list || is_setting || self.watchdog.is_some_and(|own| own.place == place)
    }
}

impl ObjectPlace {
    /// Whether an object is here.
    pub fn is_of(self, object: Object) -> bool {
        (self.index, self.sub) == (object.index, object.sub)
    }

    /// The object at this place, for transfers and messages.
    pub(super) const fn object(self, name: &'static str, data_type: DataType, unit: &'static str) -> Object {
        let Self { index, sub } = self;
        Object { index, sub, name, data_type, access: Access::ReadWrite, unit, doc: "" }
    }
}

impl ProcessData {
    /// First byte of an object in a mapping that is written; `None` where it is not in it, and for fixed PDOs, whose entries only
    /// the drive knows.
    pub fn offset_of(&self, place: ObjectPlace) -> Option<usize> {
        let Self::Mapped(entries) = self else { return None };
        let k = entries.iter().position(|entry| (entry.index, entry.sub) == (place.index, place.sub))?;
        let bits: usize = entries[..k].iter().map(|entry| usize::from(entry.bits)).sum();
        Some(bits / 8)
    }
}
