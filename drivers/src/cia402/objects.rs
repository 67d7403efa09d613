//! The object dictionary as far as the bench uses it: one row per object, named constants to reach them.
//!
//! Indices, types and units follow CiA 301 and CiA 402 (IEC 61800-7-201). Where the profile leaves the unit to the
//! drive ("user units") the unit of this dictionary is stated: positions in encoder counts, velocities in counts/s. Objects of
//! one vendor alone stand in the profiles of drive types ([`super::profile`]).

use Access::{ReadOnly, ReadWrite};
use DataType::{I8, I16, I32, Text, U8, U16, U32};

/// How an object is coded; all numbers are little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataType {
    /// INTEGER8.
    I8,
    /// UNSIGNED8.
    U8,
    /// INTEGER16.
    I16,
    /// UNSIGNED16.
    U16,
    /// INTEGER32.
    I32,
    /// UNSIGNED32.
    U32,
    /// VISIBLE_STRING of any length.
    Text,
}

impl DataType {
    /// Width in bytes; a text has none of its own.
    pub const fn bytes(self) -> Option<usize> {
        match self {
            Self::I8 | Self::U8 => Some(1),
            Self::I16 | Self::U16 => Some(2),
            Self::I32 | Self::U32 => Some(4),
            Self::Text => None,
        }
    }

    /// Smallest and largest value; a text has neither.
    pub const fn range(self) -> Option<(i64, i64)> {
        match self {
            Self::I8 => Some((i8::MIN as i64, i8::MAX as i64)),
            Self::U8 => Some((0, u8::MAX as i64)),
            Self::I16 => Some((i16::MIN as i64, i16::MAX as i64)),
            Self::U16 => Some((0, u16::MAX as i64)),
            Self::I32 => Some((i32::MIN as i64, i32::MAX as i64)),
            Self::U32 => Some((0, u32::MAX as i64)),
            Self::Text => None,
        }
    }
}

/// What SDO access an object allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Only upload.
    ReadOnly,
    /// Upload and download.
    ReadWrite,
}

/// One object of the dictionary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Object {
    /// Index.
    pub index: u16,
    /// Sub-index.
    pub sub: u8,
    /// Name for errors.
    pub name: &'static str,
    /// Coding.
    pub data_type: DataType,
    /// SDO access.
    pub access: Access,
    /// Unit of one count, empty for codes and counts.
    pub unit: &'static str,
    /// One sentence.
    pub doc: &'static str,
}

/// Finds an object in the table.
pub const fn find(index: u16, sub: u8) -> Option<Object> {
    let mut k = 0;
    while k < OBJECTS.len() {
        if OBJECTS[k].index == index && OBJECTS[k].sub == sub {
            return Some(OBJECTS[k]);
        }
        k += 1;
    }
    None
}

/// A row of the table; evaluated at compile time for the constants below, so a missing row does not compile.
const fn row(index: u16, sub: u8) -> Object {
    match find(index, sub) {
        Some(object) => object,
        None => panic!("object is not in the table"),
    }
}

/// Device type.
pub const DEVICE_TYPE: Object = row(0x1000, 0);
/// Device name.
pub const DEVICE_NAME: Object = row(0x1008, 0);
/// Firmware.
pub const FIRMWARE: Object = row(0x100A, 0);
/// Vendor.
pub const VENDOR: Object = row(0x1018, 1);
/// Product.
pub const PRODUCT: Object = row(0x1018, 2);
/// Revision.
pub const REVISION: Object = row(0x1018, 3);
/// Serial number.
pub const SERIAL: Object = row(0x1018, 4);
/// Mapping of the outputs, count; the entries are its sub-indices.
pub const RX_MAPPING: Object = row(0x1600, 0);
/// Mapping of the inputs, count; the entries are its sub-indices.
pub const TX_MAPPING: Object = row(0x1A00, 0);
/// Assignment of output PDOs, count; the entries are its sub-indices.
pub const RX_ASSIGNMENT: Object = row(0x1C12, 0);
/// Assignment of input PDOs, count; the entries are its sub-indices.
pub const TX_ASSIGNMENT: Object = row(0x1C13, 0);
/// Abort connection option.
pub const ABORT_CONNECTION_OPTION: Object = row(0x6007, 0);
/// Error code.
pub const ERROR_CODE: Object = row(0x603F, 0);
/// Controlword.
pub const CONTROLWORD: Object = row(0x6040, 0);
/// Statusword.
pub const STATUSWORD: Object = row(0x6041, 0);
/// Quick stop option.
pub const QUICK_STOP_OPTION: Object = row(0x605A, 0);
/// Fault reaction option.
pub const FAULT_REACTION_OPTION: Object = row(0x605E, 0);
/// Mode asked for.
pub const MODE: Object = row(0x6060, 0);
/// Mode in force.
pub const MODE_DISPLAY: Object = row(0x6061, 0);
/// Position.
pub const POSITION: Object = row(0x6064, 0);
/// Following error window.
pub const FOLLOWING_ERROR_WINDOW: Object = row(0x6065, 0);
/// Following error time.
pub const FOLLOWING_ERROR_TIME: Object = row(0x6066, 0);
/// Velocity.
pub const VELOCITY: Object = row(0x606C, 0);
/// Torque asked for.
pub const TARGET_TORQUE: Object = row(0x6071, 0);
/// Torque limit.
pub const MAX_TORQUE: Object = row(0x6072, 0);
/// Current limit.
pub const MAX_CURRENT: Object = row(0x6073, 0);
/// Rated current.
pub const RATED_CURRENT: Object = row(0x6075, 0);
/// Rated torque.
pub const RATED_TORQUE: Object = row(0x6076, 0);
/// Torque.
pub const TORQUE: Object = row(0x6077, 0);
/// Current.
pub const CURRENT: Object = row(0x6078, 0);
/// DC link.
pub const DC_LINK: Object = row(0x6079, 0);
/// Lower soft limit.
pub const SOFT_LIMIT_MIN: Object = row(0x607D, 1);
/// Upper soft limit.
pub const SOFT_LIMIT_MAX: Object = row(0x607D, 2);
/// Speed limit.
pub const MAX_SPEED: Object = row(0x6080, 0);
/// Quick stop deceleration.
pub const QUICK_STOP_DECELERATION: Object = row(0x6085, 0);
/// Encoder counts of 608F.
pub const ENCODER_COUNTS: Object = row(0x608F, 1);
/// Revolutions of 608F.
pub const ENCODER_REVOLUTIONS: Object = row(0x608F, 2);
/// Interpolation period, mantissa.
pub const INTERPOLATION_PERIOD: Object = row(0x60C2, 1);
/// Interpolation period, exponent.
pub const INTERPOLATION_EXPONENT: Object = row(0x60C2, 2);
/// Digital inputs.
pub const DIGITAL_INPUTS: Object = row(0x60FD, 0);
/// Target velocity.
pub const TARGET_VELOCITY: Object = row(0x60FF, 0);
/// Supported modes.
pub const SUPPORTED_MODES: Object = row(0x6502, 0);

/// Every object of the standards that the bench reads, writes or maps, in order of index and sub-index.
#[rustfmt::skip]
pub const OBJECTS: &[Object] = &[
    object(0x1000, 0, "device type", U32, ReadOnly, "", "Low word 402 (0192h): the drive speaks CiA 402."),
    object(0x1008, 0, "device name", Text, ReadOnly, "", "Name of the drive type."),
    object(0x100A, 0, "software version", Text, ReadOnly, "", "Firmware."),
    object(0x1018, 1, "vendor id", U32, ReadOnly, "", "Vendor."),
    object(0x1018, 2, "product code", U32, ReadOnly, "", "Product."),
    object(0x1018, 3, "revision number", U32, ReadOnly, "", "Revision."),
    object(0x1018, 4, "serial number", U32, ReadOnly, "", "Serial number."),
    object(0x1600, 0, "RxPDO 1 mapping, count", U8, ReadWrite, "", "Number of entries in force; 0 while entries change."),
    object(0x1600, 1, "RxPDO 1 mapping, entry 1", U32, ReadWrite, "", MAPPED),
    object(0x1600, 2, "RxPDO 1 mapping, entry 2", U32, ReadWrite, "", MAPPED),
    object(0x1600, 3, "RxPDO 1 mapping, entry 3", U32, ReadWrite, "", MAPPED),
    object(0x1600, 4, "RxPDO 1 mapping, entry 4", U32, ReadWrite, "", MAPPED),
    object(0x1600, 5, "RxPDO 1 mapping, entry 5", U32, ReadWrite, "", MAPPED),
    object(0x1A00, 0, "TxPDO 1 mapping, count", U8, ReadWrite, "", "Number of entries in force; 0 while entries change."),
    object(0x1A00, 1, "TxPDO 1 mapping, entry 1", U32, ReadWrite, "", MAPPED),
    object(0x1A00, 2, "TxPDO 1 mapping, entry 2", U32, ReadWrite, "", MAPPED),
    object(0x1A00, 3, "TxPDO 1 mapping, entry 3", U32, ReadWrite, "", MAPPED),
    object(0x1A00, 4, "TxPDO 1 mapping, entry 4", U32, ReadWrite, "", MAPPED),
    object(0x1A00, 5, "TxPDO 1 mapping, entry 5", U32, ReadWrite, "", MAPPED),
    object(0x1A00, 6, "TxPDO 1 mapping, entry 6", U32, ReadWrite, "", MAPPED),
    object(0x1A00, 7, "TxPDO 1 mapping, entry 7", U32, ReadWrite, "", MAPPED),
    object(0x1A00, 8, "TxPDO 1 mapping, entry 8", U32, ReadWrite, "", MAPPED),
    object(0x1A00, 9, "TxPDO 1 mapping, entry 9", U32, ReadWrite, "", MAPPED),
    object(0x1A00, 10, "TxPDO 1 mapping, entry 10", U32, ReadWrite, "", MAPPED),
    object(0x1A00, 11, "TxPDO 1 mapping, entry 11", U32, ReadWrite, "", MAPPED),
    object(0x1C12, 0, "RxPDO assignment, count", U8, ReadWrite, "", "Number of assigned PDOs; 0 while the list changes."),
    object(0x1C12, 1, "RxPDO assignment, entry 1", U16, ReadWrite, "", "1600h."),
    object(0x1C13, 0, "TxPDO assignment, count", U8, ReadWrite, "", "Number of assigned PDOs; 0 while the list changes."),
    object(0x1C13, 1, "TxPDO assignment, entry 1", U16, ReadWrite, "", "1A00h."),
    object(0x6007, 0, "abort connection option code", I16, ReadWrite, "", "Reaction of the drive when the process data stop: 0 nothing, 1 fault, 2 disable voltage, 3 quick stop."),
    object(0x603F, 0, "error code", U16, ReadOnly, "", "Code of the last fault."),
    object(0x6040, 0, "controlword", U16, ReadWrite, "", "Commands of the power state machine."),
    object(0x6041, 0, "statusword", U16, ReadOnly, "", "Power state and flags."),
    object(0x605A, 0, "quick stop option code", I16, ReadWrite, "", "0 disable, 1 slow down, 2 quick stop ramp, 3 current limit, then disabled; 5 to 7 the same and stay in quick stop."),
    object(0x605E, 0, "fault reaction option code", I16, ReadWrite, "", "0 disable at once, 1 slow down, 2 quick stop ramp, 3 current limit; then fault."),
    object(0x6060, 0, "mode of operation", I8, ReadWrite, "", "9 CSV, 10 CST."),
    object(0x6061, 0, "mode of operation display", I8, ReadOnly, "", "Mode in force."),
    object(0x6064, 0, "position actual value", I32, ReadOnly, "count", "Single-turn encoder counts; they wrap at the counts per revolution."),
    object(0x6065, 0, "following error window", U32, ReadWrite, "count", "FFFF_FFFFh switches the drive's own supervision off (no position demand in CST and CSV)."),
    object(0x6066, 0, "following error time out", U16, ReadWrite, "ms", "Time outside the window before the drive reacts."),
    object(0x606C, 0, "velocity actual value", I32, ReadOnly, "count/s", "Velocity."),
    object(0x6071, 0, "target torque", I16, ReadWrite, "0.001 of 6076h", "Torque demand in CST."),
    object(0x6072, 0, "max torque", U16, ReadWrite, "0.001 of 6076h", "Torque limit, both directions."),
    object(0x6073, 0, "max current", U16, ReadWrite, "0.001 of 6075h", "Commissioned current limit: read, never raised."),
    object(0x6075, 0, "motor rated current", U32, ReadOnly, "mA", "Reference of the current objects; a property of the commissioned drive."),
    object(0x6076, 0, "motor rated torque", U32, ReadOnly, "mN*m", "Reference of the torque objects; a property of the commissioned drive."),
    object(0x6077, 0, "torque actual value", I16, ReadOnly, "0.001 of 6076h", "Torque."),
    object(0x6078, 0, "current actual value", I16, ReadOnly, "0.001 of 6075h", "Current."),
    object(0x6079, 0, "DC link circuit voltage", U32, ReadOnly, "mV", "DC link voltage."),
    object(0x607D, 1, "min position limit", I32, ReadWrite, "count", "Lower soft limit; the drive compares its count taken into [-N/2, N/2), N = counts per revolution."),
    object(0x607D, 2, "max position limit", I32, ReadWrite, "count", "Upper soft limit, as the lower."),
    object(0x6080, 0, "max motor speed", U32, ReadWrite, "count/s", "Speed limit (some drives use r/min: 10 r/min would be too coarse for a director)."),
    object(0x6085, 0, "quick stop deceleration", U32, ReadWrite, "count/s^2", "Deceleration of the quick stop ramp."),
    object(0x608F, 1, "encoder increments", U32, ReadOnly, "count", "Encoder counts per 608Fh:2 revolutions."),
    object(0x608F, 2, "motor revolutions", U32, ReadOnly, "rev", "Revolutions that 608Fh:1 refers to."),
    object(0x60C2, 1, "interpolation time period", U8, ReadWrite, "10^(60C2h:2) s", "Mantissa of the cycle time."),
    object(0x60C2, 2, "interpolation time index", I8, ReadWrite, "", "Power of ten of the cycle time, e.g. 25 and -5 for 250 us."),
    object(0x60FD, 0, "digital inputs", U32, ReadOnly, "", "Bit 0 and 1 limit switches, bit 3 interlock (emergency stop open), bits 16 to 31 of the manufacturer."),
    object(0x60FF, 0, "target velocity", I32, ReadWrite, "count/s", "Velocity demand in CSV."),
    object(0x6502, 0, "supported drive modes", U32, ReadOnly, "", "Bit 8 CSV, bit 9 CST."),
];

const MAPPED: &str = "Mapped object: index << 16 | sub << 8 | bits; index 0 is padding.";

#[allow(clippy::too_many_arguments, reason = "one row of the table above")]
const fn object(
    index: u16,
    sub: u8,
    name: &'static str,
    data_type: DataType,
    access: Access,
    unit: &'static str,
    doc: &'static str,
) -> Object {
    Object { index, sub, name, data_type, access, unit, doc }
}
