//! What the objects of a drive are called and made of, for SDO information.

use super::application::{DataType, EntryInfo, ObjectInfo, Shape, Write};
use crate::cia402::{self, Mappable, Width};
use Shape::{Array, Record, Variable};

/// Names as CiA 402 and ETG.1000 have them, in order of the index.
const NAMES: [(u16, Shape, &str); 49] = [
    (0x1000, Variable, "Device type"),
    (0x1001, Variable, "Error register"),
    (0x1008, Variable, "Device name"),
    (0x1009, Variable, "Hardware version"),
    (0x100A, Variable, "Software version"),
    (0x1018, Record, "Identity"),
    (0x1C00, Array, "Sync manager types"),
    (0x1C12, Array, "RxPDO assignment"),
    (0x1C13, Array, "TxPDO assignment"),
    (0x1C32, Record, "Output synchronisation"),
    (0x1C33, Record, "Input synchronisation"),
    (0x22A3, Variable, "Heat sink temperature"),
    (0x2F00, Variable, "Process data watchdog"),
    (0x6007, Variable, "Abort connection option code"),
    (0x603F, Variable, "Error code"),
    (0x6040, Variable, "Controlword"),
    (0x6041, Variable, "Statusword"),
    (0x605A, Variable, "Quick stop option code"),
    (0x605B, Variable, "Shutdown option code"),
    (0x605C, Variable, "Disable operation option code"),
    (0x605D, Variable, "Halt option code"),
    (0x605E, Variable, "Fault reaction option code"),
    (0x6060, Variable, "Modes of operation"),
    (0x6061, Variable, "Modes of operation display"),
    (0x6063, Variable, "Position actual internal value"),
    (0x6064, Variable, "Position actual value"),
    (0x6065, Variable, "Following error window"),
    (0x6066, Variable, "Following error time out"),
    (0x606C, Variable, "Velocity actual value"),
    (0x6071, Variable, "Target torque"),
    (0x6072, Variable, "Max torque"),
    (0x6073, Variable, "Max current"),
    (0x6074, Variable, "Torque demand"),
    (0x6075, Variable, "Motor rated current"),
    (0x6076, Variable, "Motor rated torque"),
    (0x6077, Variable, "Torque actual value"),
    (0x6078, Variable, "Current actual value"),
    (0x6079, Variable, "DC link circuit voltage"),
    (0x607D, Array, "Software position limit"),
    (0x6080, Variable, "Max motor speed"),
    (0x6084, Variable, "Profile deceleration"),
    (0x6085, Variable, "Quick stop deceleration"),
    (0x608F, Array, "Position encoder resolution"),
    (0x60B1, Variable, "Velocity offset"),
    (0x60B2, Variable, "Torque offset"),
    (0x60C2, Record, "Interpolation time period"),
    (0x60FD, Variable, "Digital inputs"),
    (0x60FF, Variable, "Target velocity"),
    (0x6502, Variable, "Supported drive modes"),
];

/// An object of a drive.
pub(super) fn object(index: u16) -> Option<ObjectInfo> {
    let (shape, name) = match index {
        0x1600..=0x17FF => (Record, "RxPDO mapping"),
        0x1A00..=0x1BFF => (Record, "TxPDO mapping"),
        _ => {
            let place = NAMES.binary_search_by_key(&index, |row| row.0).ok()?;
            (NAMES[place].1, NAMES[place].2)
        }
    };
    Some(ObjectInfo { shape, name })
}

/// An entry of an object of a drive; `None` where its bytes say what it is.
pub(super) fn entry(index: u16, sub: u8) -> Option<EntryInfo> {
    use DataType::{Unsigned8, Unsigned16, Unsigned32, VisibleString};
    let of_bus = |data_type, write| Some(EntryInfo { data_type, write, mappable: Mappable::Neither });
    match (index, sub) {
        (0x1008..=0x100A, 0) => of_bus(VisibleString, Write::Never),
        (0x1600..=0x17FF | 0x1A00..=0x1BFF | 0x1C12 | 0x1C13, 0) => of_bus(Unsigned8, Write::InPreOp),
        (0x1600..=0x17FF | 0x1A00..=0x1BFF, _) => of_bus(Unsigned32, Write::InPreOp),
        (0x1C12 | 0x1C13, _) => of_bus(Unsigned16, Write::InPreOp),
        (0x1C00, _) | (0x1C32 | 0x1C33, 0 | 0x20) => of_bus(Unsigned8, Write::Never),
        (0x1C32 | 0x1C33, 1) => of_bus(Unsigned16, Write::Always),
        (0x1C32 | 0x1C33, 2) => of_bus(Unsigned32, Write::Always),
        (0x1C32 | 0x1C33, 4 | 0x0B | 0x0C) => of_bus(Unsigned16, Write::Never),
        (0x1C32 | 0x1C33, _) => of_bus(Unsigned32, Write::Never),
        _ => {
            let object = cia402::object(index, sub)?;
            let data_type = match object.width {
                Width::I8 => DataType::Integer8,
                Width::I16 => DataType::Integer16,
                Width::I32 => DataType::Integer32,
                Width::U8 => Unsigned8,
                Width::U16 => Unsigned16,
                Width::U32 => Unsigned32,
            };
            let write = if object.is_writable() { Write::Always } else { Write::Never };
            Some(EntryInfo { data_type, write, mappable: object.pdo })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_in_order_of_the_index() {
        assert!(NAMES.is_sorted_by_key(|row| row.0));
        assert_eq!(object(0x6041).map(|o| o.name), Some("Statusword"));
        assert_eq!(object(0x1A03).map(|o| o.shape), Some(Record));
        assert_eq!(object(0x2000), None);
    }

    #[test]
    fn numbers_with_and_without_sign_are_told_apart() {
        let kind = |index, sub| entry(index, sub).map(|e| e.data_type as u16);
        let found =
            [(0x6060, 0), (0x6071, 0), (0x6064, 0), (0x1001, 0), (0x6040, 0), (0x6065, 0), (0x1008, 0)]
                .map(|(index, sub)| kind(index, sub));
        assert_eq!(found, [2, 3, 4, 5, 6, 7, 9].map(Some));
        assert_eq!(entry(0x6040, 1), None);
    }
}
