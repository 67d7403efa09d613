//! What a station maps, read back from it and handed to the master.

use std::ops::Range;

use ethercat::{
    DomainIdx, Error, Idx, Master, PdoCfg, PdoEntryIdx, PdoEntryInfo, PdoEntryPos, PdoIdx, PdoPos, SdoIdx,
    SlaveAddr, SlavePos, SmCfg, SmIdx, SubIdx, SyncDirection, WatchdogMode,
};

use super::{Station, WATCHDOG_DIVIDER};

/// Sync managers of outputs and inputs, and the objects that assign their PDOs.
const OUTPUTS: SyncManager = SyncManager { index: 2, assignment: 0x1C12, is_outputs: true };
const INPUTS: SyncManager = SyncManager { index: 3, assignment: 0x1C13, is_outputs: false };

#[derive(Clone, Copy, Debug)]
struct SyncManager {
    index: u8,
    assignment: u16,
    is_outputs: bool,
}

/// Where the data of all stations go, and how long each of them may miss its outputs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    pub(super) domain: DomainIdx,
    pub(super) watchdog_steps: u16,
}

/// A station's process data.
pub(super) struct Mapping {
    managers: Vec<(SyncManager, Vec<PdoCfg>)>,
    /// Places in the domain, once they are known.
    pub(super) outputs: Vec<Range<usize>>,
    pub(super) inputs: Vec<Range<usize>>,
}

/// Reads the assignments and mappings of a station: from its dictionary, which the drivers have written to, or what the
/// master found in its SII where it has none.
pub(super) fn read(master: &mut Master, position: SlavePos) -> Result<Mapping, Error> {
    let mut managers = Vec::new();
    for manager in [OUTPUTS, INPUTS] {
        let pdos = match number(master, position, manager.assignment, 0) {
            Ok(count) => of_dictionary(master, position, manager, count)?,
            Err(_) => of_master(master, position, manager)?,
        };
        managers.push((manager, pdos));
    }
    Ok(Mapping { managers, outputs: Vec::new(), inputs: Vec::new() })
}

/// An object of at most four bytes.
fn number(master: &Master, position: SlavePos, index: u16, sub: u8) -> Result<u32, Error> {
    let mut bytes = [0; 4];
    master.sdo_upload(position, SdoIdx::new(index, sub), false, &mut bytes)?;
    Ok(u32::from_le_bytes(bytes))
}

fn of_dictionary(
    master: &Master,
    position: SlavePos,
    manager: SyncManager,
    count: u32,
) -> Result<Vec<PdoCfg>, Error> {
    let mut pdos = Vec::new();
    for place in 1..=count.min(u32::from(u8::MAX)) {
        let pdo = number(master, position, manager.assignment, place as u8)? as u16;
        let mut found = PdoCfg::new(PdoIdx::new(pdo));
        for sub in 1..=number(master, position, pdo, 0)?.min(u32::from(u8::MAX)) {
            let entry = number(master, position, pdo, sub as u8)?;
            found.entries.push(PdoEntryInfo {
                pos: PdoEntryPos::new(sub as u8 - 1),
                entry_idx: PdoEntryIdx::new((entry >> 16) as u16, (entry >> 8) as u8),
                bit_len: entry as u8,
                name: String::new(),
            });
        }
        pdos.push(found);
    }
    Ok(pdos)
}

fn of_master(master: &mut Master, position: SlavePos, manager: SyncManager) -> Result<Vec<PdoCfg>, Error> {
    let index = SmIdx::new(manager.index);
    let count = master.get_sync(position, index).map_or(0, |found| found.pdo_count);
    let mut pdos = Vec::new();
    for place in 0..count {
        let pdo = master.get_pdo(position, index, PdoPos::new(place))?;
        let mut found = PdoCfg::new(PdoIdx::new(u16::from(pdo.idx)));
        for entry in 0..pdo.entry_count {
            let entry = master.get_pdo_entry(position, index, PdoPos::new(place), PdoEntryPos::new(entry))?;
            found.entries.push(entry);
        }
        pdos.push(found);
    }
    Ok(pdos)
}

impl Mapping {
    /// Hands the mapping to the master, with the watchdog; finds the places in the domain.
    pub(super) fn place(
        &mut self,
        master: &mut Master,
        station: &Station,
        target: Target,
    ) -> Result<(), Error> {
        let address = SlaveAddr::ByPos(u16::from(station.position));
        let mut config = master.configure_slave(address, station.id)?;
        config.config_watchdog(WATCHDOG_DIVIDER, target.watchdog_steps)?;
        for (manager, pdos) in &self.managers {
            let Some(first) = first_entry(pdos) else { continue };
            let sync = SmCfg {
                idx: SmIdx::new(manager.index),
                watchdog_mode: if manager.is_outputs { WatchdogMode::Enable } else { WatchdogMode::Default },
                direction: if manager.is_outputs { SyncDirection::Output } else { SyncDirection::Input },
            };
            config.config_sm_pdos(sync, pdos)?;
            // A sync manager's entries stand together: the place of one is that of all.
            let found = config.register_pdo_entry(first.entry, target.domain)?;
            let begin = (8 * found.byte + found.bit as usize).saturating_sub(first.after_bits) / 8;
            let place = begin..begin + bits(pdos).div_ceil(8);
            if manager.is_outputs { self.outputs.push(place) } else { self.inputs.push(place) }
        }
        Ok(())
    }
}

/// The first entry that is no gap, and the bits before it.
struct First {
    entry: PdoEntryIdx,
    after_bits: usize,
}

fn first_entry(pdos: &[PdoCfg]) -> Option<First> {
    let mut after_bits = 0;
    for entry in pdos.iter().flat_map(|pdo| &pdo.entries) {
        if entry.entry_idx.idx != Idx::new(0) || entry.entry_idx.sub_idx != SubIdx::new(0) {
            return Some(First { entry: entry.entry_idx, after_bits });
        }
        after_bits += usize::from(entry.bit_len);
    }
    None
}

fn bits(pdos: &[PdoCfg]) -> usize {
    pdos.iter().flat_map(|pdo| &pdo.entries).map(|entry| usize::from(entry.bit_len)).sum()
}
