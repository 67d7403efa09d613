//! Addresses of the registers of an EtherCAT SubDevice controller (ETG.1000.4, 6), and which bytes exist.

use std::ops::Range;

/// ESC type; revision, build, number of FMMUs and sync managers, RAM size, ports and features follow.
pub(crate) const TYPE: u16 = 0x0000;
/// Configured station address.
pub(crate) const STATION: u16 = 0x0010;
/// Configured station alias, from the SII.
pub(crate) const ALIAS: u16 = 0x0012;
/// DL control; bit 0 of byte 0103h lets the alias be used as station address.
pub(crate) const DL_CONTROL: u16 = 0x0100;
/// DL status: links and loops of the ports.
pub(crate) const DL_STATUS: u16 = 0x0110;
/// AL control: the state that the MainDevice asks for.
pub(crate) const AL_CONTROL: u16 = 0x0120;
/// AL status: the state that the SubDevice is in.
pub(crate) const AL_STATUS: u16 = 0x0130;
/// AL status code: why a state was refused or left.
pub(crate) const AL_STATUS_CODE: u16 = 0x0134;
/// PDI control.
pub(crate) const PDI_CONTROL: u16 = 0x0140;
/// ECAT event mask.
pub(crate) const EVENT_MASK: u16 = 0x0200;
/// ECAT event request.
pub(crate) const EVENT_REQUEST: u16 = 0x0210;
/// Error counters of the ports.
pub(crate) const ERROR_COUNTERS: u16 = 0x0300;
/// Counter of frames with errors in their EtherCAT part.
pub(crate) const PROCESSING_ERRORS: u16 = 0x030C;
/// Counter of errors of the PDI.
pub(crate) const PDI_ERRORS: u16 = 0x030D;
/// Counters of lost links, one for each port.
pub(crate) const LOST_LINKS: u16 = 0x0310;
/// Watchdog divider, in 40 ns less 2.
pub(crate) const WATCHDOG_DIVIDER: u16 = 0x0400;
/// PDI watchdog, in units of the divided clock.
pub(crate) const PDI_WATCHDOG: u16 = 0x0410;
/// Process data watchdog, in units of the divided clock.
pub(crate) const DATA_WATCHDOG: u16 = 0x0420;
/// Bit 0: the process data watchdog is content.
pub(crate) const WATCHDOG_STATUS: u16 = 0x0440;
/// Number of times that the process data watchdog expired.
pub(crate) const DATA_WATCHDOG_COUNTER: u16 = 0x0442;
/// SII access: who owns it.
pub(crate) const SII_OWNER: u16 = 0x0500;
/// SII control and status.
pub(crate) const SII_CONTROL: u16 = 0x0502;
/// SII word address.
pub(crate) const SII_ADDRESS: u16 = 0x0504;
/// SII data.
pub(crate) const SII_DATA: u16 = 0x0508;
/// First FMMU.
pub(crate) const FMMU: u16 = 0x0600;
/// Bytes of one FMMU.
pub(crate) const FMMU_BYTES: usize = 16;
/// FMMUs of this controller.
pub(crate) const FMMUS: usize = 8;
/// First sync manager.
pub(crate) const SYNC_MANAGER: u16 = 0x0800;
/// Bytes of one sync manager.
pub(crate) const SYNC_MANAGER_BYTES: usize = 8;
/// Sync managers of this controller.
pub(crate) const SYNC_MANAGERS: usize = 8;
/// Receive times of the ports; a write latches all of them.
pub(crate) const PORT_TIMES: u16 = 0x0900;
/// System time.
pub(crate) const SYSTEM_TIME: u16 = 0x0910;
/// Receive time of the processing unit.
pub(crate) const RECEIVE_TIME: u16 = 0x0918;
/// Offset between local and system time.
pub(crate) const TIME_OFFSET: u16 = 0x0920;
/// Propagation delay from the reference clock.
pub(crate) const TIME_DELAY: u16 = 0x0928;
/// Difference between the local copy of the system time and the received one; bit 31 set: the local one is smaller.
pub(crate) const TIME_DIFFERENCE: u16 = 0x092C;
/// Start value of the speed counter; a write resets the difference.
pub(crate) const SPEED_START: u16 = 0x0930;
/// Activation of the SYNC outputs.
pub(crate) const SYNC_ACTIVATION: u16 = 0x0981;
/// Start time of cyclic operation.
pub(crate) const SYNC_START: u16 = 0x0990;
/// Cycle of SYNC0, ns.
pub(crate) const SYNC0_CYCLE: u16 = 0x09A0;
/// First byte of the RAM for mailboxes and process data.
pub(crate) const RAM: u16 = 0x1000;
/// RAM, bytes: 8 KiB.
pub(crate) const RAM_BYTES: u16 = 0x2000;

/// Who may write a register from the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    /// Nobody.
    Read,
    /// The MainDevice.
    ReadWrite,
    /// A write to any byte clears all of them.
    Clear,
}

/// First byte, number of bytes, access; in ascending order.
const MAP: &[(u16, u16, Access)] = &[
    (TYPE, 10, Access::Read),
    (STATION, 2, Access::ReadWrite),
    (ALIAS, 2, Access::Read),
    (DL_CONTROL, 4, Access::ReadWrite),
    (0x0108, 2, Access::ReadWrite),
    (DL_STATUS, 2, Access::Read),
    (AL_CONTROL, 2, Access::ReadWrite),
    (AL_STATUS, 6, Access::Read),
    (PDI_CONTROL, 2, Access::Read),
    (0x0150, 4, Access::Read),
    (EVENT_MASK, 2, Access::ReadWrite),
    (EVENT_REQUEST, 2, Access::Read),
    (ERROR_COUNTERS, 12, Access::Clear),
    (PROCESSING_ERRORS, 1, Access::Clear),
    (PDI_ERRORS, 1, Access::Clear),
    (LOST_LINKS, 4, Access::Clear),
    (WATCHDOG_DIVIDER, 2, Access::ReadWrite),
    (PDI_WATCHDOG, 2, Access::ReadWrite),
    (DATA_WATCHDOG, 2, Access::ReadWrite),
    (WATCHDOG_STATUS, 2, Access::Read),
    (DATA_WATCHDOG_COUNTER, 2, Access::Clear),
    (SII_OWNER, 16, Access::ReadWrite),
    (FMMU, (FMMUS * FMMU_BYTES) as u16, Access::ReadWrite),
    (SYNC_MANAGER, (SYNC_MANAGERS * SYNC_MANAGER_BYTES) as u16, Access::ReadWrite),
    (PORT_TIMES, 16, Access::Read),
    (SYSTEM_TIME, 8, Access::Read),
    (RECEIVE_TIME, 8, Access::Read),
    (TIME_OFFSET, 8, Access::ReadWrite),
    (TIME_DELAY, 4, Access::ReadWrite),
    (TIME_DIFFERENCE, 4, Access::Read),
    (SPEED_START, 6, Access::ReadWrite),
    (0x0980, 2, Access::ReadWrite),
    (SYNC_START, 8, Access::ReadWrite),
    (SYNC0_CYCLE, 8, Access::ReadWrite),
    (RAM, RAM_BYTES, Access::ReadWrite),
];

/// Access to a byte; `None` where nothing is.
pub(crate) fn access(address: u16) -> Option<Access> {
    entry(address).map(|(.., access)| *access)
}

/// The bytes that belong together with this one.
pub(crate) fn group(address: u16) -> Range<usize> {
    entry(address).map_or(0..0, |(first, count, _)| usize::from(*first)..usize::from(first + count))
}

fn entry(address: u16) -> Option<&'static (u16, u16, Access)> {
    let after = MAP.partition_point(|(first, ..)| *first <= address);
    let entry = MAP.get(after.checked_sub(1)?)?;
    (address - entry.0 < entry.1).then_some(entry)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_is_in_order_and_nothing_overlaps() {
        for pair in MAP.windows(2) {
            let [(first, count, _), (next, ..)] = pair else { unreachable!("windows of two") };
            assert!(first + count <= *next, "{first:04X}h and {next:04X}h");
        }
        assert_eq!(access(0x0000), Some(Access::Read));
        assert_eq!(access(0x000A), None);
        assert_eq!(access(0x0010), Some(Access::ReadWrite));
        assert_eq!(access(0x0680), None, "only eight FMMUs");
        assert_eq!(access(0x2FFF), Some(Access::ReadWrite));
        assert_eq!(access(0x3000), None);
        assert_eq!(access(0xFFFF), None);
    }
}
