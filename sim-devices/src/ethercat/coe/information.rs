//! SDO information (ETG.1000.6, 5.6.3): which objects there are.

use super::super::application::{Application, DataType, EntryInfo, ObjectInfo, Shape, Write};
use super::SDO_INFORMATION;
use crate::cia402::Mappable;

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
const UNSUPPORTED: u32 = 0x0601_0000;

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

/// List 0 are the lengths of the five lists, list 1 is all objects, 2 and 3 are those that outputs and inputs may hold; the
/// others (to be stored, for replacement) are empty here.
fn list(application: &mut dyn Application, kind: u16, room: usize) -> Vec<Vec<u8>> {
    let all = application.indices();
    let mappable = |wanted: Mappable| {
        let holds = |index: &u16| application.entry_info(*index, 0).is_some_and(|e| e.mappable == wanted);
        all.iter().copied().filter(holds).collect::<Vec<u16>>()
    };
    let lists = [all.clone(), mappable(Mappable::Output), mappable(Mappable::Input), Vec::new(), Vec::new()];
    let words = match kind {
        0 => vec![vec![0], lists.iter().map(|list| list.len() as u16).collect()],
        1..=5 => vec![vec![kind], lists[usize::from(kind) - 1].clone()],
        _ => return vec![error(UNSUPPORTED)],
    };
    let data: Vec<u8> = words.concat().iter().flat_map(|word| word.to_le_bytes()).collect();
    let fragment = (room.saturating_sub(HEADER_BYTES) & !1).max(2);
    let count = data.len().div_ceil(fragment);
    let messages = data.chunks(fragment).enumerate().map(|(k, part)| {
        let left = (count - 1 - k) as u16;
        message(LIST_RESPONSE | if left > 0 { INCOMPLETE } else { 0 }, left, part)
    });
    messages.collect()
}

/// Data type of an entry: as the application has it, or by its width.
fn data_type(application: &dyn Application, index: u16, sub: u8, bytes: usize) -> DataType {
    let by_width = match bytes {
        1 => DataType::Unsigned8,
        2 => DataType::Unsigned16,
        4 => DataType::Unsigned32,
        _ => DataType::VisibleString,
    };
    application.entry_info(index, sub).map_or(by_width, |entry| entry.data_type)
}

fn described(application: &mut dyn Application, index: u16) -> Vec<u8> {
    let Ok(value) = application.upload(index, 0) else { return error(NO_OBJECT) };
    let shape = super::shape(application, index, &value);
    let last = if shape == Shape::Variable { 0 } else { value.first().copied().unwrap_or(0) };
    let kind = match shape {
        Shape::Array => data_type(application, index, 1, 4),
        Shape::Variable | Shape::Record => data_type(application, index, 0, value.len()),
    };
    let ([i0, i1], [t0, t1]) = (index.to_le_bytes(), (kind as u16).to_le_bytes());
    let mut data = vec![i0, i1, t0, t1, last, shape as u8];
    let name = application.object_info(index).map(|object| object.name.to_owned());
    data.extend(name.unwrap_or_else(|| format!("Object {index:04X}h")).as_bytes());
    message(DESCRIPTION_RESPONSE, 0, &data)
}

fn entry(application: &mut dyn Application, index: u16, sub: u8) -> Vec<u8> {
    let value = match application.upload(index, sub) {
        Ok(value) => value,
        Err(code) => return error(code),
    };
    let bits = (value.len() * 8) as u16;
    let kind = data_type(application, index, sub, value.len()) as u16;
    let ([i0, i1], [t0, t1], [b0, b1]) = (index.to_le_bytes(), kind.to_le_bytes(), bits.to_le_bytes());
    let [a0, a1] = access(application.entry_info(index, sub)).to_le_bytes();
    let mut data = vec![i0, i1, sub, 0, t0, t1, b0, b1, a0, a1];
    data.extend(entry_name(application, index, sub).as_bytes());
    message(ENTRY_RESPONSE, 0, &data)
}

/// Bits 0 to 2: readable in PRE-OP, SAFE-OP, OP; bits 3 to 5: writable there; bits 6 and 7: mappable as output, as input.
fn access(entry: Option<EntryInfo>) -> u16 {
    const READABLE: u16 = 0b111;
    let Some(entry) = entry else { return READABLE };
    let write = match entry.write {
        Write::Never => 0,
        Write::InPreOp => 1 << 3,
        Write::Always => 0b111 << 3,
    };
    let mappable = match entry.mappable {
        Mappable::Neither => 0,
        Mappable::Output => 1 << 6,
        Mappable::Input => 1 << 7,
    };
    READABLE | write | mappable
}

fn entry_name(application: &dyn Application, index: u16, sub: u8) -> String {
    match application.object_info(index) {
        Some(ObjectInfo { shape: Shape::Variable, name }) => name.to_owned(),
        Some(_) if sub == 0 => "Number of entries".to_owned(),
        _ => format!("Sub-index {sub}"),
    }
}
