//! What stands behind a SubDevice controller: a drive, a terminal.

use std::time::Duration;

use crate::cia402::Mappable;
use drivers::wire::BusState;

/// Bytes of process data each way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ProcessDataBytes {
    /// From MainDevice to SubDevice.
    pub(crate) outputs: usize,
    /// From SubDevice to MainDevice.
    pub(crate) inputs: usize,
}

/// Basic data types by their numbers in SDO information (ETG.1020).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub(crate) enum DataType {
    Integer8 = 2,
    Integer16 = 3,
    Integer32 = 4,
    Unsigned8 = 5,
    Unsigned16 = 6,
    Unsigned32 = 7,
    VisibleString = 9,
}

/// Object codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    /// One value.
    Variable = 7,
    /// A list of values of one type.
    Array = 8,
    /// A list of values of any types.
    Record = 9,
}

/// What an object is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ObjectInfo {
    /// One value or several.
    pub(crate) shape: Shape,
    /// Its name.
    pub(crate) name: &'static str,
}

/// When an entry may be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Write {
    /// It may only be read.
    Never,
    /// Only in PRE-OP.
    InPreOp,
    /// In PRE-OP, SAFE-OP and OP.
    Always,
}

/// What an entry of an object is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct EntryInfo {
    /// Coding.
    pub(crate) data_type: DataType,
    /// When it may be written.
    pub(crate) write: Write,
    /// Whether it may lie in the process data.
    pub(crate) mappable: Mappable,
}

/// The application of a SubDevice. Errors of its objects are SDO abort codes (CiA 301).
pub(crate) trait Application {
    /// Reads an object.
    fn upload(&mut self, index: u16, sub: u8) -> Result<Vec<u8>, u32>;

    /// Writes an object.
    fn download(&mut self, index: u16, sub: u8, data: &[u8]) -> Result<(), u32>;

    /// Indices of all objects, in ascending order.
    fn indices(&self) -> Vec<u16>;

    /// What an object is; `None` where nobody has said so.
    fn object_info(&self, _index: u16) -> Option<ObjectInfo> {
        None
    }

    /// What an entry of an object is; `None` where nobody has said so.
    fn entry_info(&self, _index: u16, _sub: u8) -> Option<EntryInfo> {
        None
    }

    /// Fixes the process data as they are mapped.
    fn map(&mut self) -> Result<ProcessDataBytes, u32>;

    /// The state that it believes to be in. It may leave OP by itself.
    fn state(&self) -> BusState;

    /// Its end of the bus enters a state.
    fn enter(&mut self, state: BusState);

    /// Samples its inputs at an instant of the world.
    fn sample(&mut self, now: Duration, inputs: &mut [u8]);

    /// The SYNC0 output of the SubDevice controller, to which the trigger cable of the inertial unit leads, gives a pulse.
    fn trigger(&mut self, now: Duration);

    /// Takes outputs.
    fn take(&mut self, now: Duration, outputs: &[u8]);

    /// An emergency message that it has to send, if any: error code, error register.
    fn emergency(&mut self) -> Option<Emergency> {
        None
    }
}

/// An emergency message (ETG.1000.6, 5.6.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Emergency {
    /// Error code as in 603Fh.
    pub code: u16,
    /// Error register as in 1001h.
    pub register: u8,
    /// Bytes of the vendor.
    pub vendor: [u8; 5],
}
