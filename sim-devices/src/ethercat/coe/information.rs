//! SDO information (ETG.1000.6, 5.6.3): which objects there are.

use super::super::application::Application;
use super::SDO_INFORMATION;

const LIST_REQUEST: u8 = 1;
const LIST_RESPONSE: u8 = 2;
const DESCRIPTION_REQUEST: u8 = 3;
const DESCRIPTION_RESPONSE: u8 = 4;
const ENTRY_REQUEST: u8 = 5;
const ENTRY_RESPONSE: u8 = 6;
const ERROR: u8 = 7;
/// More fragments follow.
const INCOMPLETE: u8 = 1 << 7;
/// CoE header, opcode, fragments left.
const HEADER_BYTES: usize = 6;
const NO_OBJECT: u32 = 0x0602_0000;
const NO_SUB_INDEX: u32 = 0x0609_0011;
const UNSUPPORTED: u32 = 0x0601_0000;
/// All objects.
const ALL: u16 = 1;

/// Answers a request; a list may need several messages.
pub(super) fn answer(application: &mut dyn Application, request: &[u8], room: usize) -> Vec<Vec<u8>> {
    let word = |at: usize| {
        let byte = |k: usize| request.get(k).copied().unwrap_or(0);
        u16::from_le_bytes([byte(at), byte(at + 1)])
    };
    match request.first().map(|opcode| opcode & !INCOMPLETE) {
        Some(LIST_REQUEST) => list(application, word(4), room),
        Some(DESCRIPTION_REQUEST) => vec![described(application, word(4))],
        Some(ENTRY_REQUEST) => vec![entry(application, word(4), request.get(6).copied().unwrap_or(0))],
        _ => vec![error(UNSUPPORTED)],
    }
}

fn message(opcode: u8, fragments_left: u16, data: &[u8]) -> Vec<u8> {
    let [low, high] = fragments_left.to_le_bytes();
    let mut bytes = vec![0, SDO_INFORMATION << 4, opcode, 0, low, high];
    bytes.extend(data);
    bytes
}

fn error(code: u32) -> Vec<u8> {
    message(ERROR, 0, &code.to_le_bytes())
}

/// List 0 are the lengths of the five lists, list 1 is all objects; the others (mappable one way or the other, to be stored,
/// for replacement) are empty here.
fn list(application: &mut dyn Application, kind: u16, room: usize) -> Vec<Vec<u8>> {
    let indices = application.indices();
    let words = match kind {
        0 => vec![0, indices.len() as u16, 0, 0, 0, 0],
        ALL => [vec![ALL], indices].concat(),
        2..=5 => vec![kind],
        _ => return vec![error(UNSUPPORTED)],
    };
    let data: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let fragment = (room.saturating_sub(HEADER_BYTES) & !1).max(2);
    let count = data.len().div_ceil(fragment);
    let messages = data.chunks(fragment).enumerate().map(|(k, part)| {
        let left = (count - 1 - k) as u16;
        message(LIST_RESPONSE | if left > 0 { INCOMPLETE } else { 0 }, left, part)
    });
    messages.collect()
}

/// Data type by width: 5, 6, 7 are unsigned numbers of 8, 16 and 32 bits, 9 is a text.
fn data_type(bytes: usize) -> u16 {
    match bytes {
        1 => 5,
        2 => 6,
        4 => 7,
        _ => 9,
    }
}

fn described(application: &mut dyn Application, index: u16) -> Vec<u8> {
    let Ok(value) = application.upload(index, 0) else { return error(NO_OBJECT) };
    // Sub-index 0 of a list says how many there are; whether it is one shows in sub-index 1.
    let is_list = value.len() == 1 && application.upload(index, 1) != Err(NO_SUB_INDEX);
    let last = if is_list { value[0] } else { 0 };
    const VARIABLE: u8 = 7;
    const RECORD: u8 = 9;
    let ([i0, i1], [t0, t1]) = (index.to_le_bytes(), data_type(value.len()).to_le_bytes());
    let mut data = vec![i0, i1, t0, t1, last, if is_list { RECORD } else { VARIABLE }];
    data.extend(format!("Object {index:04X}h").as_bytes());
    message(DESCRIPTION_RESPONSE, 0, &data)
}

fn entry(application: &mut dyn Application, index: u16, sub: u8) -> Vec<u8> {
    let value = match application.upload(index, sub) {
        Ok(value) => value,
        Err(code) => return error(code),
    };
    let bits = (value.len() * 8) as u16;
    let ([i0, i1], [t0, t1], [b0, b1]) =
        (index.to_le_bytes(), data_type(value.len()).to_le_bytes(), bits.to_le_bytes());
    // Readable in PRE-OP, SAFE-OP and OP.
    const READABLE: u8 = 0b111;
    let mut data = vec![i0, i1, sub, 0, t0, t1, b0, b1, READABLE, 0];
    data.extend(format!("Sub-index {sub}").as_bytes());
    message(ENTRY_RESPONSE, 0, &data)
}
