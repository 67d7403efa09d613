//! EtherCAT commands (ETG.1000.4, 5.4): which SubDevice a datagram is for, what it does there, and what it adds to the
//! working counter.

use std::time::Duration;

use super::esc::{Direction, Esc};
use super::frame::Datagram;

/// How a datagram chooses its SubDevices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Selection {
    /// By position in the line.
    Position,
    /// By configured station address.
    Station,
    /// All of them.
    All,
}

/// Longest datagram.
const LONGEST: usize = 0x7FF;

/// A datagram passes a SubDevice.
pub(crate) fn pass(esc: &mut Esc, datagram: &mut Datagram<'_>, now: Duration) {
    use Selection::{All, Position, Station};
    let (both, reads, writes) = ([true, true], [true, false], [false, true]);
    match datagram.command() {
        1 => address(esc, datagram, Position, reads, now),
        2 => address(esc, datagram, Position, writes, now),
        3 => address(esc, datagram, Position, both, now),
        4 => address(esc, datagram, Station, reads, now),
        5 => address(esc, datagram, Station, writes, now),
        6 => address(esc, datagram, Station, both, now),
        7 => address(esc, datagram, All, reads, now),
        8 => address(esc, datagram, All, writes, now),
        9 => address(esc, datagram, All, both, now),
        10 => logical(esc, datagram, reads, now),
        11 => logical(esc, datagram, writes, now),
        12 => logical(esc, datagram, both, now),
        13 => read_multiple_write(esc, datagram, Position, now),
        14 => read_multiple_write(esc, datagram, Station, now),
        // NOP and what no standard knows pass unchanged.
        _ => return,
    }
    let events = esc.events();
    datagram.raise(events);
}

/// Whether the datagram is for this SubDevice. A position counts up at every SubDevice, whether it is meant or not.
fn is_meant(esc: &Esc, datagram: &mut Datagram<'_>, selection: Selection) -> bool {
    match selection {
        Selection::Position => {
            let is_meant = datagram.adp() == 0;
            datagram.pass_position();
            is_meant
        }
        Selection::Station => esc.has_station(datagram.adp()),
        Selection::All => {
            datagram.pass_position();
            true
        }
    }
}

/// Reading adds 1, writing 1, both 3.
fn address(
    esc: &mut Esc,
    datagram: &mut Datagram<'_>,
    selection: Selection,
    [reads, writes]: [bool; 2],
    now: Duration,
) {
    if !is_meant(esc, datagram, selection) {
        return;
    }
    let first = datagram.ado();
    let count = datagram.data.len();
    let is_collected = selection == Selection::All;
    let mut read = [0; LONGEST];
    let read = &mut read[..count];
    if !is_collected {
        // What a sync manager refuses stays as it was sent.
        read.copy_from_slice(datagram.data);
    }
    let is_read = reads && esc.read(first, read, now);
    let is_written = writes && esc.write(first, datagram.data, now);
    if is_read {
        for (byte, found) in datagram.data.iter_mut().zip(read.iter()) {
            *byte = if is_collected { *byte | found } else { *found };
        }
    }
    let for_writing = if reads { 2 } else { 1 };
    datagram.count(u16::from(is_read) + if is_written { for_writing } else { 0 });
}

fn logical(esc: &mut Esc, datagram: &mut Datagram<'_>, [reads, writes]: [bool; 2], now: Duration) {
    let first = datagram.logical();
    let hits = esc.exchange(first, datagram.data, Direction { reads, writes }, now);
    let for_writing = if reads { 2 } else { 1 };
    datagram.count(u16::from(hits.read) + if hits.written { for_writing } else { 0 });
}

/// The SubDevice that is addressed reads, all others write.
fn read_multiple_write(esc: &mut Esc, datagram: &mut Datagram<'_>, selection: Selection, now: Duration) {
    let first = datagram.ado();
    let is_done = if is_meant(esc, datagram, selection) {
        esc.read(first, datagram.data, now)
    } else {
        esc.write(first, datagram.data, now)
    };
    datagram.count(u16::from(is_done));
}
