//! CANopen over EtherCAT (ETG.1000.6, 5.6): the SDO server of a SubDevice, and its list of objects.

mod information;

use super::application::{Application, Shape};

/// Service: emergency.
pub(crate) const EMERGENCY: u8 = 1;
/// Service: SDO request.
const SDO_REQUEST: u8 = 2;
/// Service: SDO response.
const SDO_RESPONSE: u8 = 3;
/// Service: SDO information.
const SDO_INFORMATION: u8 = 8;

/// Mailbox error: the header says nothing that is known.
const INVALID_HEADER: u16 = 0x0005;
/// Mailbox error: there is no whole header.
const TOO_SHORT: u16 = 0x0006;

/// SDO abort codes of the protocol itself.
mod abort {
    pub(super) const TOGGLE: u32 = 0x0503_0000;
    pub(super) const COMMAND: u32 = 0x0504_0001;
    pub(super) const NO_COMPLETE_ACCESS: u32 = 0x0601_0004;
    pub(super) const READ_ONLY: u32 = 0x0601_0002;
    pub(super) const LENGTH: u32 = 0x0607_0010;
    pub(super) const NO_SUB_INDEX: u32 = 0x0609_0011;
}

/// Bytes of a CoE header and the fixed part of an SDO.
const SDO_BYTES: usize = 10;
/// Data of an expedited transfer.
const EXPEDITED_BYTES: usize = 4;
/// Bytes that a segment holds at least.
const SEGMENT_BYTES: usize = 7;
/// Bit of the command: an object as a whole.
const COMPLETE: u8 = 1 << 4;
/// Most bytes that a segmented download may announce.
const LONGEST_DOWNLOAD: usize = 64 * 1024;

/// The transfer that goes on from one segment to the next.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Transfer {
    /// Bytes that are still to be sent, and the toggle bit of the next segment.
    Upload { left: Vec<u8>, toggle: bool, address: Address },
    /// Bytes that came so far, how many there will be, and the toggle bit of the next segment.
    Download { got: Vec<u8>, size: usize, toggle: bool, address: Address },
}

/// What an SDO is about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Address {
    index: u16,
    sub: u8,
    complete: bool,
}

/// SDO server.
#[derive(Clone, Debug, Default)]
pub(crate) struct SdoServer {
    transfer: Option<Transfer>,
    /// Every transfer is answered by this abort code, for tests of MainDevices.
    pub(crate) refuses: Option<u32>,
}

impl SdoServer {
    /// A new mailbox: no transfer is under way.
    pub(crate) fn reset(&mut self) {
        self.transfer = None;
    }

    /// Answers a CoE message; both without mailbox header. `room` is what the mailbox holds beside its header. Nothing is
    /// answered to what is no request; the error is the detail of a mailbox error.
    pub(crate) fn answer(
        &mut self,
        application: &mut dyn Application,
        message: &[u8],
        room: usize,
    ) -> Result<Vec<Vec<u8>>, u16> {
        let &[_, high, ref rest @ ..] = message else { return Err(TOO_SHORT) };
        Ok(match high >> 4 {
            SDO_REQUEST => {
                let mut request = [0; SDO_BYTES - 2];
                let count = rest.len().min(request.len());
                request[..count].copy_from_slice(&rest[..count]);
                let data = rest.get(SDO_BYTES - 2..).unwrap_or(&[]);
                self.sdo(application, &request, data, rest, room).into_iter().collect()
            }
            SDO_INFORMATION => information::answer(application, rest, room),
            EMERGENCY | SDO_RESPONSE => Vec::new(),
            _ => return Err(INVALID_HEADER),
        })
    }

    /// Answers an SDO: its fixed part, what follows that, and both together for segments.
    fn sdo(
        &mut self,
        application: &mut dyn Application,
        request: &[u8; 8],
        data: &[u8],
        whole: &[u8],
        room: usize,
    ) -> Option<Vec<u8>> {
        let command = request[0];
        let address = Address {
            index: u16::from_le_bytes([request[1], request[2]]),
            sub: request[3],
            complete: command & COMPLETE != 0,
        };
        let answered = match command >> 5 {
            0 => self.download_segment(application, whole),
            1 => self.start_download(application, address, request, data),
            2 => self.start_upload(application, address, room),
            3 => self.upload_segment(command, room),
            // The other side gave up.
            4 => {
                self.transfer = None;
                return None;
            }
            _ => Err((address, abort::COMMAND)),
        };
        Some(answered.unwrap_or_else(|(address, code)| {
            self.transfer = None;
            aborted(address, code)
        }))
    }

    fn start_upload(&mut self, application: &mut dyn Application, address: Address, room: usize) -> Answer {
        self.transfer = None;
        let failed = |code| (address, code);
        if let Some(code) = self.refuses {
            return Err(failed(code));
        }
        let data = if address.complete {
            upload_complete(application, address).map_err(failed)?
        } else {
            application.upload(address.index, address.sub).map_err(failed)?
        };
        let complete = if address.complete { COMPLETE } else { 0 };
        if data.len() <= EXPEDITED_BYTES && !data.is_empty() {
            let unused = (EXPEDITED_BYTES - data.len()) as u8;
            let mut bytes = [0; EXPEDITED_BYTES];
            bytes[..data.len()].copy_from_slice(&data);
            return Ok(response(0x43 | unused << 2 | complete, address, &bytes, &[]));
        }
        let first = data.len().min(room.saturating_sub(SDO_BYTES));
        let size = (data.len() as u32).to_le_bytes();
        let answer = response(0x41 | complete, address, &size, &data[..first]);
        if first < data.len() {
            self.transfer = Some(Transfer::Upload { left: data[first..].to_vec(), toggle: false, address });
        }
        Ok(answer)
    }

    fn upload_segment(&mut self, command: u8, room: usize) -> Answer {
        let Some(Transfer::Upload { left, toggle, address }) = &mut self.transfer else {
            return Err((Address::default(), abort::COMMAND));
        };
        if (command & COMPLETE != 0) != *toggle {
            return Err((*address, abort::TOGGLE));
        }
        let count = left.len().min(room.saturating_sub(3).max(1));
        let sent: Vec<u8> = left.drain(..count).collect();
        let is_last = left.is_empty();
        let unused = SEGMENT_BYTES.saturating_sub(sent.len()) as u8;
        let command = u8::from(*toggle) << 4 | unused << 1 | u8::from(is_last);
        *toggle = !*toggle;
        if is_last {
            self.transfer = None;
        }
        let mut answer = vec![0, SDO_RESPONSE << 4, command];
        answer.extend(&sent);
        answer.extend(std::iter::repeat_n(0, usize::from(unused)));
        Ok(answer)
    }

    fn start_download(
        &mut self,
        application: &mut dyn Application,
        address: Address,
        request: &[u8; 8],
        data: &[u8],
    ) -> Answer {
        self.transfer = None;
        let failed = |code| (address, code);
        if let Some(code) = self.refuses {
            return Err(failed(code));
        }
        let command = request[0];
        let (is_expedited, has_size) = (command & 2 != 0, command & 1 != 0);
        if is_expedited {
            let unused = if has_size { usize::from(command >> 2 & 3) } else { 0 };
            let data = &request[4..8 - unused];
            download(application, address, data, !has_size).map_err(failed)?;
        } else {
            let size = u32::from_le_bytes([request[4], request[5], request[6], request[7]]) as usize;
            if size > LONGEST_DOWNLOAD {
                return Err(failed(abort::LENGTH));
            }
            if data.len() >= size {
                download(application, address, &data[..size], false).map_err(failed)?;
            } else {
                let got = data.to_vec();
                self.transfer = Some(Transfer::Download { got, size, toggle: false, address });
            }
        }
        Ok(response(0x60, Address { complete: false, ..address }, &[0; 4], &[]))
    }

    fn download_segment(&mut self, application: &mut dyn Application, whole: &[u8]) -> Answer {
        let Some(Transfer::Download { got, size, toggle, address }) = &mut self.transfer else {
            return Err((Address::default(), abort::COMMAND));
        };
        let address = *address;
        let Some((&command, data)) = whole.split_first() else { return Err((address, abort::COMMAND)) };
        if (command & COMPLETE != 0) != *toggle {
            return Err((address, abort::TOGGLE));
        }
        // Up to seven bytes the unused ones are counted in the command.
        let unused = if data.len() <= SEGMENT_BYTES { usize::from(command >> 1 & 7) } else { 0 };
        got.extend(&data[..data.len().saturating_sub(unused)]);
        let answer = vec![0, SDO_RESPONSE << 4, 0x20 | u8::from(*toggle) << 4, 0, 0, 0, 0, 0, 0, 0];
        *toggle = !*toggle;
        if got.len() > *size {
            return Err((address, abort::LENGTH));
        }
        if command & 1 != 0 {
            let (got, size) = (std::mem::take(got), *size);
            if got.len() != size {
                return Err((address, abort::LENGTH));
            }
            self.transfer = None;
            download(application, address, &got, false).map_err(|code| (address, code))?;
        }
        Ok(answer)
    }
}

type Answer = Result<Vec<u8>, (Address, u32)>;

fn response(command: u8, address: Address, four: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let [low, high] = address.index.to_le_bytes();
    let mut bytes = vec![0, SDO_RESPONSE << 4, command, low, high, address.sub];
    bytes.extend(four);
    bytes.extend(data);
    bytes
}

/// An abort goes out with service 2 and nothing but the command in its first byte.
fn aborted(address: Address, code: u32) -> Vec<u8> {
    let [low, high] = address.index.to_le_bytes();
    let mut bytes = vec![0, SDO_REQUEST << 4, 0x80, low, high, address.sub];
    bytes.extend(code.to_le_bytes());
    bytes
}

/// Whether an object is one value or several: as the application has it, or by what it answers.
fn shape(application: &mut dyn Application, index: u16, count: &[u8]) -> Shape {
    if let Some(object) = application.object_info(index) {
        return object.shape;
    }
    // Sub-index 0 of a list says how many there are; whether it is one shows in sub-index 1.
    match count {
        [_] if application.upload(index, 1) != Err(abort::NO_SUB_INDEX) => Shape::Record,
        _ => Shape::Variable,
    }
}

/// An object as a whole: sub-index 0 takes two bytes, all others that there are follow without gaps.
fn upload_complete(application: &mut dyn Application, address: Address) -> Result<Vec<u8>, u32> {
    let count = sub_indices(application, address)?;
    let mut data = Vec::new();
    if address.sub == 0 {
        data.extend([count, 0]);
    }
    for sub in 1..=count {
        match application.upload(address.index, sub) {
            Ok(entry) => data.extend(entry),
            Err(abort::NO_SUB_INDEX) => {}
            Err(code) => return Err(code),
        }
    }
    Ok(data)
}

/// Highest sub-index of an object that has more than one.
fn sub_indices(application: &mut dyn Application, address: Address) -> Result<u8, u32> {
    if address.sub > 1 {
        return Err(abort::NO_COMPLETE_ACCESS);
    }
    let count = application.upload(address.index, 0)?;
    match (shape(application, address.index, &count), &count[..]) {
        (Shape::Array | Shape::Record, &[count]) => Ok(count),
        _ => Err(abort::NO_COMPLETE_ACCESS),
    }
}

/// Writes an object; a transfer that states no size has as many bytes as the object.
fn download(
    application: &mut dyn Application,
    address: Address,
    data: &[u8],
    any_size: bool,
) -> Result<(), u32> {
    if address.complete {
        return download_complete(application, address, data);
    }
    if any_size {
        let width = application.upload(address.index, address.sub)?.len();
        return application.download(address.index, address.sub, data.get(..width).unwrap_or(data));
    }
    application.download(address.index, address.sub, data)
}

/// Writes all sub-indices of a list. One that can be resized is written as it must be: its count to 0, the entries, the count.
fn download_complete(application: &mut dyn Application, address: Address, data: &[u8]) -> Result<(), u32> {
    let present = sub_indices(application, address)?;
    let index = address.index;
    if address.sub == 1 {
        return download_entries(application, index, present, data);
    }
    let Some(&count) = data.first() else { return Err(abort::LENGTH) };
    let entries = data.get(2..).unwrap_or(&[]);
    match application.download(index, 0, &[0]) {
        Ok(()) => {}
        Err(abort::READ_ONLY) if count == present => {
            return download_entries(application, index, count, entries);
        }
        Err(code) => return Err(code),
    }
    if count > 0 {
        let width = entries.len() / usize::from(count);
        if width == 0 || entries.len() != width * usize::from(count) {
            return Err(abort::LENGTH);
        }
        for (sub, entry) in (1..=count).zip(entries.chunks(width)) {
            application.download(index, sub, entry)?;
        }
    }
    application.download(index, 0, &[count])
}

/// Writes the entries that there are, each as long as it is.
fn download_entries(
    application: &mut dyn Application,
    index: u16,
    count: u8,
    data: &[u8],
) -> Result<(), u32> {
    let mut rest = data;
    for sub in 1..=count {
        let width = match application.upload(index, sub) {
            Ok(value) => value.len(),
            Err(abort::NO_SUB_INDEX) => continue,
            Err(code) => return Err(code),
        };
        let Some((entry, behind)) = rest.split_at_checked(width) else { return Err(abort::LENGTH) };
        application.download(index, sub, entry)?;
        rest = behind;
    }
    if rest.is_empty() { Ok(()) } else { Err(abort::LENGTH) }
}

#[cfg(test)]
mod tests;
