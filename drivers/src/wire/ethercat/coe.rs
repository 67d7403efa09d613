//! Mailbox messages as bytes: CAN application protocol over EtherCAT (CoE), SDO services and emergencies (ETG.1000.6).

/// Header of a mailbox message.
pub(super) const HEADER_BYTES: usize = 6;
/// CoE header.
const COE_BYTES: usize = 2;
/// Command, index, sub-index and four bytes of data.
const SDO_BYTES: usize = 8;
/// Shortest SDO message.
pub(super) const SHORTEST_BYTES: usize = HEADER_BYTES + COE_BYTES + SDO_BYTES;
/// Where the data of an initiating message of full length begin.
const DATA_AT: usize = SHORTEST_BYTES;
/// Where the data of a segment begin.
const SEGMENT_DATA_AT: usize = HEADER_BYTES + COE_BYTES + 1;
/// Shortest data of a segment.
const SEGMENT_BYTES: usize = 7;

const TYPE_ERROR: u8 = 0;
const TYPE_COE: u8 = 3;
const SERVICE_EMERGENCY: u16 = 1;
const SERVICE_REQUEST: u16 = 2;
const SERVICE_RESPONSE: u16 = 3;

/// Place of an object: index and sub-index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) index: u16,
    pub(super) sub: u8,
}

/// What a host asks of an SDO server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Request<'a> {
    /// Begins to read.
    Upload(Place),
    /// Asks for the next segment.
    UploadSegment { toggle: bool },
    /// Begins to write `size` bytes, of which `data` are the first.
    Download { place: Place, size: usize, data: &'a [u8] },
    /// Sends a segment.
    DownloadSegment { toggle: bool, is_last: bool, data: &'a [u8] },
    /// Gives up.
    Abort { place: Place, code: u32 },
}

/// What an SDO server answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Answer<'a> {
    /// An object in one message, or its first part: `size` is that of the whole object.
    Upload { place: Place, size: usize, data: &'a [u8] },
    /// A segment of an object.
    UploadSegment { toggle: bool, is_last: bool, data: &'a [u8] },
    /// A write was begun, or is done.
    Download(Place),
    /// A segment was taken.
    DownloadSegment { toggle: bool },
    /// The server gave up.
    Abort { place: Place, code: u32 },
}

/// A message from a station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Message<'a> {
    /// An answer to an SDO request.
    Sdo(Answer<'a>),
    /// An emergency: error code, error register and the maker's five bytes.
    Emergency { code: u16, register: u8, vendor: [u8; 5] },
    /// The mailbox itself refused a message.
    MailboxError { detail: u16 },
    /// Something else.
    Other,
}

/// Data bytes that a message that begins a write can carry in a mailbox of `mailbox_bytes`.
pub(super) const fn first_capacity(mailbox_bytes: usize) -> usize {
    mailbox_bytes.saturating_sub(DATA_AT)
}

/// Data bytes that a segment can carry in a mailbox of `mailbox_bytes`.
pub(super) const fn segment_capacity(mailbox_bytes: usize) -> usize {
    mailbox_bytes.saturating_sub(SEGMENT_DATA_AT)
}

/// Writes a request into a mailbox message; the rest of `into` is zero. `counter` is 1 to 7 and differs from the last
/// message's. Gives `None` if `into` is too short.
pub(super) fn encode(request: &Request<'_>, counter: u8, into: &mut [u8]) -> Option<()> {
    into.fill(0);
    let parts = Parts::of(request);
    let message = into.get_mut(..SHORTEST_BYTES)?;
    message[8] = parts.command;
    if let Some(Place { index, sub }) = parts.place {
        message[9..11].copy_from_slice(&index.to_le_bytes());
        message[11] = sub;
        message[12..16].copy_from_slice(&parts.head.to_le_bytes());
    }
    let data_end = parts.data_at + parts.data.len();
    into.get_mut(parts.data_at..data_end)?.copy_from_slice(parts.data);
    let length = u16::try_from(data_end.max(SHORTEST_BYTES) - HEADER_BYTES).ok()?;
    into[..2].copy_from_slice(&length.to_le_bytes());
    into[5] = TYPE_COE | (counter & 7) << 4;
    into[6..8].copy_from_slice(&(SERVICE_REQUEST << 12).to_le_bytes());
    Some(())
}

/// A request as the fields of its message.
struct Parts<'a> {
    command: u8,
    place: Option<Place>,
    /// The four bytes after the place.
    head: u32,
    data: &'a [u8],
    data_at: usize,
}

impl<'a> Parts<'a> {
    fn of(request: &Request<'a>) -> Self {
        let whole =
            |command, place, head| Self { command, place: Some(place), head, data: &[], data_at: DATA_AT };
        match *request {
            Request::Upload(place) => whole(0x40, place, 0),
            Request::Abort { place, code } => whole(0x80, place, code),
            Request::Download { place, size, data } if (1..=4).contains(&size) && data.len() == size => {
                let command = 0x23 | (4 - size as u8) << 2;
                Self { data, data_at: DATA_AT - 4, ..whole(command, place, 0) }
            }
            Request::Download { place, size, data } => Self { data, ..whole(0x21, place, size as u32) },
            Request::UploadSegment { toggle } => {
                let command = 0x60 | u8::from(toggle) << 4;
                Self { command, place: None, head: 0, data: &[], data_at: SEGMENT_DATA_AT }
            }
            Request::DownloadSegment { toggle, is_last, data } => {
                let unused = SEGMENT_BYTES.saturating_sub(data.len()) as u8;
                let command = u8::from(toggle) << 4 | unused << 1 | u8::from(is_last);
                Self { command, place: None, head: 0, data, data_at: SEGMENT_DATA_AT }
            }
        }
    }
}

/// The counter of a message that [`encode`] has written.
#[cfg(test)]
pub(super) fn counter(message: &[u8]) -> u8 {
    message[5] >> 4 & 7
}

/// Reads a message that a station has put into its mailbox; `None` if it is damaged.
pub(super) fn decode(mailbox: &[u8]) -> Option<Message<'_>> {
    let length = usize::from(u16::from_le_bytes([*mailbox.first()?, *mailbox.get(1)?]));
    let body = mailbox.get(HEADER_BYTES..HEADER_BYTES + length)?;
    match mailbox[5] & 0x0F {
        TYPE_ERROR => Some(Message::MailboxError { detail: word(body, 2)? }),
        TYPE_COE => decode_coe(body),
        _ => Some(Message::Other),
    }
}

fn decode_coe(body: &[u8]) -> Option<Message<'_>> {
    let service = word(body, 0)? >> 12;
    let content = body.get(COE_BYTES..)?;
    match service {
        SERVICE_EMERGENCY => {
            let vendor = content.get(3..8)?.try_into().ok()?;
            Some(Message::Emergency { code: word(content, 0)?, register: content[2], vendor })
        }
        // Stations send aborts as requests or as responses.
        SERVICE_REQUEST if content.first()? >> 5 != 4 => Some(Message::Other),
        SERVICE_REQUEST | SERVICE_RESPONSE => decode_sdo(content).map(Message::Sdo),
        _ => Some(Message::Other),
    }
}

fn decode_sdo(content: &[u8]) -> Option<Answer<'_>> {
    let command = *content.first()?;
    let place = || Some(Place { index: word(content, 1)?, sub: *content.get(3)? });
    let toggle = command & 0x10 != 0;
    match command >> 5 {
        0 => {
            let data = content.get(1..)?;
            let unused = if data.len() == SEGMENT_BYTES { usize::from(command >> 1 & 7) } else { 0 };
            let data = data.get(..data.len() - unused.min(data.len()))?;
            Some(Answer::UploadSegment { toggle, is_last: command & 1 != 0, data })
        }
        1 => Some(Answer::DownloadSegment { toggle }),
        2 if command & 2 != 0 => {
            let size = if command & 1 != 0 { 4 - usize::from(command >> 2 & 3) } else { 4 };
            Some(Answer::Upload { place: place()?, size, data: content.get(4..4 + size)? })
        }
        2 => {
            let size = u32::from_le_bytes(content.get(4..8)?.try_into().ok()?) as usize;
            let data = content.get(8..)?;
            Some(Answer::Upload { place: place()?, size, data: data.get(..size).unwrap_or(data) })
        }
        3 => Some(Answer::Download(place()?)),
        4 => {
            let code = u32::from_le_bytes(content.get(4..8)?.try_into().ok()?);
            Some(Answer::Abort { place: place()?, code })
        }
        _ => None,
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u16> {
    let bytes = bytes.get(at..at + 2)?;
    Some(u16::from_le_bytes([bytes[0], bytes[1]]))
}

#[cfg(test)]
mod tests;
