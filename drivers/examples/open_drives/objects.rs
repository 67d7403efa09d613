//! Objects of a station, before anything is exchanged.

use std::time::Duration;

use drivers::cia402::abort_meaning;
use drivers::cia402::objects::{OBJECTS, Object};
use drivers::wire::ethercat::EtherCatBus;
use drivers::wire::{SdoAbort, SdoRequest, SdoWire};

use super::arguments::Place;
use super::clock;

/// Longest wait for a transfer of the longest object.
const LIMIT: Duration = Duration::from_secs(2);
const TIMED_OUT: SdoAbort = SdoAbort(0x0504_0000);
/// The mappings, which the driver writes itself.
const MAPPINGS: std::ops::RangeInclusive<u16> = 0x1600..=0x1A00;

/// Passes one transfer; what was read.
pub(crate) fn transfer(bus: &mut EtherCatBus, request: &SdoRequest<'_>) -> Result<Vec<u8>, SdoAbort> {
    let begun = clock::now();
    bus.start(begun, request);
    let mut answer = Vec::new();
    loop {
        let now = clock::now();
        if bus.poll(now, &mut answer)? {
            return Ok(answer);
        }
        if now.saturating_sub(begun) > LIMIT {
            return Err(TIMED_OUT);
        }
    }
}

/// Reads an object.
pub(crate) fn read(bus: &mut EtherCatBus, station: u16, place: Place) -> Result<Vec<u8>, SdoAbort> {
    transfer(bus, &SdoRequest { station, index: place.index, sub: place.sub, write: None })
}

/// Reads a number of at most four bytes.
pub(crate) fn read_u32(bus: &mut EtherCatBus, station: u16, place: Place) -> Result<u32, String> {
    let bytes = read(bus, station, place).map_err(|abort| told(place, abort))?;
    if bytes.len() > 4 {
        let Place { index, sub } = place;
        return Err(format!("{index:04X}h:{sub:02X}: expected at most 4 bytes, found {}", bytes.len()));
    }
    Ok(bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte)))
}

/// An abort in words.
pub(crate) fn told(place: Place, SdoAbort(code): SdoAbort) -> String {
    let Place { index, sub } = place;
    format!("{index:04X}h:{sub:02X}: abort {code:08X}h, {}", abort_meaning(code))
}

/// Prints an object: a text where it is one, else its bytes.
pub(crate) fn print(bus: &mut EtherCatBus, station: u16, place: Place) {
    let Place { index, sub } = place;
    match read(bus, station, place) {
        Err(abort) => println!("  {}", told(place, abort)),
        Ok(bytes) => {
            let is_text =
                bytes.len() > 4 && bytes.iter().all(|byte| (0x20..0x7F).contains(byte) || *byte == 0);
            let shown = if is_text {
                format!("\"{}\"", String::from_utf8_lossy(&bytes).trim_end_matches('\0'))
            } else {
                let first: Vec<_> = bytes.iter().take(16).map(|byte| format!("{byte:02X}")).collect();
                format!("{}{}", first.join(" "), if bytes.len() > 16 { " ..." } else { "" })
            };
            println!("  {index:04X}h:{sub:02X}: {} bytes, {shown}", bytes.len());
        }
    }
}

/// Asks for what a drive must refuse.
pub(crate) fn probe(bus: &mut EtherCatBus, station: u16) {
    print(bus, station, Place { index: 0x7FFF, sub: 0 });
    let place = Place { index: 0x1000, sub: 0 };
    let request = SdoRequest { station, index: 0x1000, sub: 0, write: Some(&[0; 4]) };
    match transfer(bus, &request) {
        Ok(_) => println!("  1000h:00: was written, although a device type is read-only"),
        Err(abort) => println!("  written: {}", told(place, abort)),
    }
}

/// Objects that the driver `Cia402` needs and the station has not, or has in another width.
pub(crate) fn missing(bus: &mut EtherCatBus, station: u16) -> Vec<String> {
    let needed = OBJECTS.iter().filter(|object| !MAPPINGS.contains(&object.index));
    needed.filter_map(|object| why_not(bus, station, object)).collect()
}

fn why_not(bus: &mut EtherCatBus, station: u16, object: &Object) -> Option<String> {
    let Object { index, sub, name, data_type, .. } = *object;
    let place = Place { index, sub };
    match read(bus, station, place) {
        // An assignment may be empty before the driver writes it.
        Err(SdoAbort(0x0609_0011)) if matches!(index, 0x1C12 | 0x1C13) => None,
        Err(abort) => Some(format!("{name} {}", told(place, abort))),
        Ok(bytes) => match data_type.bytes() {
            Some(width) if width != bytes.len() => {
                Some(format!("{name} {index:04X}h:{sub:02X}: {} bytes instead of {width}", bytes.len()))
            }
            _ => None,
        },
    }
}
