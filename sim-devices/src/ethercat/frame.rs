//! Ethernet frames with EtherCAT datagrams (ETG.1000.4, 5.4): where each datagram lies, and what is in its header.

/// EtherType of EtherCAT.
const ETHERTYPE: u16 = 0x88A4;
/// Destination, source and EtherType.
const ETHERNET_BYTES: usize = 14;
/// Header of the EtherCAT frame.
const ETHERCAT_BYTES: usize = 2;
/// Header of a datagram: command, index, address, length, interrupt.
const DATAGRAM_BYTES: usize = 10;
/// Working counter behind the data of a datagram.
const COUNTER_BYTES: usize = 2;
/// EtherCAT frame type: datagrams.
const TYPE_DATAGRAMS: u16 = 1;
/// Length bits of frame and datagram headers.
const LENGTH_MASK: u16 = 0x07FF;
/// Another datagram follows.
const MORE: u16 = 1 << 15;
/// Bit of the source address that the first SubDevice sets, so that a MainDevice knows its own frames from answers.
const LOCALLY_ADMINISTERED: u8 = 0x02;

/// Commands with a logical address: read, write, both.
const LOGICAL: std::ops::RangeInclusive<u8> = 10..=12;

/// Why a frame is not processed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rejection {
    /// Not EtherCAT, or a type other than datagrams: passed on by a real device, of no interest to this one.
    Foreign,
    /// A length runs beyond the frame.
    Malformed,
}

/// One datagram of a frame.
pub(crate) struct Datagram<'a> {
    header: &'a mut [u8],
    /// What is read or written.
    pub(crate) data: &'a mut [u8],
    counter: &'a mut [u8],
}

impl Datagram<'_> {
    /// Command number.
    pub(crate) fn command(&self) -> u8 {
        self.header[0]
    }

    /// Position or station address.
    pub(crate) fn adp(&self) -> u16 {
        u16::from_le_bytes([self.header[2], self.header[3]])
    }

    /// Memory address in the SubDevice.
    pub(crate) fn ado(&self) -> u16 {
        u16::from_le_bytes([self.header[4], self.header[5]])
    }

    /// Logical address, in the place of both others.
    pub(crate) fn logical(&self) -> u32 {
        u32::from_le_bytes([self.header[2], self.header[3], self.header[4], self.header[5]])
    }

    /// Every SubDevice that a position-addressed or broadcast datagram passes adds 1 to its position.
    pub(crate) fn pass_position(&mut self) {
        let next = self.adp().wrapping_add(1).to_le_bytes();
        self.header[2..4].copy_from_slice(&next);
    }

    /// Adds the bits of an event request to the interrupt field.
    pub(crate) fn raise(&mut self, events: u16) {
        for (byte, bits) in self.header[8..10].iter_mut().zip(events.to_le_bytes()) {
            *byte |= bits;
        }
    }

    /// Adds to the working counter.
    pub(crate) fn count(&mut self, n: u16) {
        let counter = u16::from_le_bytes([self.counter[0], self.counter[1]]).wrapping_add(n);
        self.counter.copy_from_slice(&counter.to_le_bytes());
    }
}

/// Shows each datagram of a frame in order. A frame with a wrong length anywhere is rejected before anything is shown.
pub(crate) fn for_each_datagram(
    frame: &mut [u8],
    mut visit: impl FnMut(&mut Datagram<'_>),
) -> Result<(), Rejection> {
    check(frame)?;
    let mut rest = &mut frame[ETHERNET_BYTES + ETHERCAT_BYTES..];
    loop {
        let word = u16::from_le_bytes([rest[6], rest[7]]);
        let (header, behind) = rest.split_at_mut(DATAGRAM_BYTES);
        let (data, behind) = behind.split_at_mut(usize::from(word & LENGTH_MASK));
        let (counter, behind) = behind.split_at_mut(COUNTER_BYTES);
        visit(&mut Datagram { header, data, counter });
        if word & MORE == 0 {
            return Ok(());
        }
        rest = behind;
    }
}

/// Whether a frame carries process data: a datagram with a logical address.
pub(crate) fn has_process_data(frame: &mut [u8]) -> bool {
    let mut has_any = false;
    let is_whole = for_each_datagram(frame, |datagram| has_any |= LOGICAL.contains(&datagram.command()));
    is_whole.is_ok() && has_any
}

/// Marks a frame as one that has passed a SubDevice.
pub(crate) fn mark_as_answer(frame: &mut [u8]) {
    if let Some(first) = frame.get_mut(6) {
        *first |= LOCALLY_ADMINISTERED;
    }
}

/// The whole chain of datagrams lies inside of the length that the header states, and that inside of the frame.
fn check(frame: &[u8]) -> Result<(), Rejection> {
    let word = |at: usize| Some(u16::from_le_bytes([*frame.get(at)?, *frame.get(at + 1)?]));
    let ethertype = word(12).ok_or(Rejection::Malformed)?.swap_bytes();
    if ethertype != ETHERTYPE {
        return Err(Rejection::Foreign);
    }
    let header = word(ETHERNET_BYTES).ok_or(Rejection::Malformed)?;
    if header >> 12 != TYPE_DATAGRAMS {
        return Err(Rejection::Foreign);
    }
    let first = ETHERNET_BYTES + ETHERCAT_BYTES;
    let end = first + usize::from(header & LENGTH_MASK);
    if end > frame.len() {
        return Err(Rejection::Malformed);
    }
    let mut at = first;
    loop {
        if at + DATAGRAM_BYTES + COUNTER_BYTES > end {
            return Err(Rejection::Malformed);
        }
        let length = word(at + 6).ok_or(Rejection::Malformed)?;
        at += DATAGRAM_BYTES + usize::from(length & LENGTH_MASK) + COUNTER_BYTES;
        if at > end {
            return Err(Rejection::Malformed);
        }
        if length & MORE == 0 {
            return Ok(());
        }
    }
}
