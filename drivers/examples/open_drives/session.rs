//! Up, around and down.

use std::time::Duration;

use drivers::cia402::error_code_meaning;
use drivers::wire::ethercat::{EtherCatBus, EtherCatSettings, StationInfo};
use drivers::wire::{Fieldbus, PacketSocket};

use super::arguments::{Place, Plan};
use super::axis::Axis;
use super::cycles::Cycles;
use super::mapping::{self, Layout};
use super::{clock, objects};

/// Low word of the device type (1000h) of a drive.
const PROFILE_402: u32 = 402;

/// A drive that can be enabled.
struct Found {
    station: u16,
    layout: Layout,
    /// Whether the driver misses nothing.
    is_whole: bool,
}

/// Brings the line up, exchanges and takes it down; whether nothing was wrong.
pub(crate) fn pass(plan: &Plan) -> Result<bool, String> {
    let cycle = Duration::from_micros(plan.cycle_us.into());
    let usual = EtherCatSettings::usual("EtherCAT", cycle.as_secs_f64());
    let distributed_clocks = usual.distributed_clocks.clone().filter(|_| plan.has_sync0);
    let settings = EtherCatSettings { distributed_clocks, ..usual };
    let socket =
        PacketSocket::open(&plan.interface, Box::new(clock::now)).map_err(|error| error.to_string())?;
    let begun = clock::now();
    let mut bus = EtherCatBus::open(Box::new(socket), settings).map_err(|error| error.to_string())?;
    println!("{} in PRE-OP after {:.1} ms", bus.name(), (clock::now() - begun).as_secs_f64() * 1e3);
    let (drives, emergencies_count) = survey(&mut bus, plan);
    let mut axis = None;
    if plan.enables {
        let found = drives.into_iter().next().ok_or("there is no CiA 402 drive to be enabled")?;
        let opened = if found.is_whole {
            Axis::whole(&mut bus, found.station, cycle.as_secs_f64())
        } else {
            Axis::steps(&mut bus, found.station, found.layout)
        };
        axis = Some(opened?).map(|axis| (found.station, axis));
    }
    let (image, slots) = bus.map().map_err(|error| error.to_string())?;
    let mut axis = axis.map(|(station, mut axis)| {
        if let Some((_, slot)) = slots.iter().find(|(number, _)| *number == station) {
            axis.attach(slot.clone());
        }
        axis
    });
    println!("in SAFE-OP: {} bytes of outputs, {} of inputs", image.outputs.len(), image.inputs.len());
    let mut cycles = Cycles::new(&mut bus, image, axis.take(), cycle);
    let passed = cycles.pass(plan.cycles);
    let is_clean = cycles.seen.is_clean() && emergencies_count == 0;
    cycles.seen.print();
    println!("{:?}", bus.link_counts());
    let closed = bus.close().map_err(|error| error.to_string());
    passed?;
    closed?;
    println!("in INIT");
    Ok(is_clean)
}

/// Prints who is there; the CiA 402 drives, and how many emergencies there were.
fn survey(bus: &mut EtherCatBus, plan: &Plan) -> (Vec<Found>, u32) {
    let mut drives = Vec::new();
    let mut emergencies_count = 0;
    for info in bus.station_infos().to_vec() {
        let StationInfo { station, position, name, vendor, product, revision, serial, .. } = &info;
        println!(
            "station {station} at position {position}: {name}, vendor {vendor:08X}h, product {product:08X}h, \
             revision {revision:08X}h, serial {serial:08X}h, {}",
            if info.has_sync0 { "SYNC0" } else { "no SYNC0" }
        );
        if !info.has_mailbox {
            continue;
        }
        drives.extend(look_into(bus, *station));
        for place in &plan.reads {
            objects::print(bus, *station, *place);
        }
        if plan.probes {
            objects::probe(bus, *station);
        }
        for emergency in bus.emergencies() {
            let meaning = error_code_meaning(emergency.code);
            println!("  emergency {:04X}h, {meaning}", emergency.code);
            emergencies_count += 1;
        }
    }
    (drives, emergencies_count)
}

/// Prints what a station with a mailbox is; the drive that it is.
fn look_into(bus: &mut EtherCatBus, station: u16) -> Option<Found> {
    for index in [0x1008, 0x100A] {
        objects::print(bus, station, Place { index, sub: 0 });
    }
    let layout = match Layout::read(bus, station) {
        Ok(layout) => layout,
        Err(reason) => {
            println!("  mapping: {reason}");
            Layout::default()
        }
    };
    println!("  outputs {}", mapping::text(&layout.outputs));
    println!("  inputs {}", mapping::text(&layout.inputs));
    let device_type = objects::read_u32(bus, station, Place { index: 0x1000, sub: 0 });
    if !device_type.is_ok_and(|value| value & 0xFFFF == PROFILE_402) {
        println!("  no CiA 402 drive");
        return None;
    }
    for index in [0x6502, 0x6061, 0x6041] {
        objects::print(bus, station, Place { index, sub: 0 });
    }
    let missing = objects::missing(bus, station);
    for text in &missing {
        println!("  the driver misses {text}");
    }
    Some(Found { station, layout, is_whole: missing.is_empty() })
}
