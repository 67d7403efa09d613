//! Definite-length arbitrary blocks (IEEE 488.2, 8.7.9): `#`, the number of digits, the length, the bytes.

use super::FormatError;

/// Where the content of a block lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    /// First byte of the content.
    pub start: usize,
    /// Length of the block.
    pub length: usize,
}

impl Block {
    /// One past the last byte of the content.
    pub fn end(&self) -> usize {
        self.start + self.length
    }
}

/// Characters that are shown of something that is no block.
const SHOWN: usize = 16;

/// Reads the header; `None` while it is not complete.
///
/// # Errors
/// [`FormatError::NotABlock`], [`FormatError::Indefinite`].
pub fn read(bytes: &[u8]) -> Result<Option<Block>, FormatError> {
    let (Some(&mark), digits) = (bytes.first(), bytes.get(1)) else { return Ok(None) };
    if mark != b'#' {
        return Err(not_a_block(bytes));
    }
    let Some(&digits) = digits else { return Ok(None) };
    let count = match digits {
        b'0' => return Err(FormatError::Indefinite),
        b'1'..=b'9' => usize::from(digits - b'0'),
        _ => return Err(not_a_block(bytes)),
    };
    let there = &bytes[2..bytes.len().min(2 + count)];
    if !there.iter().all(u8::is_ascii_digit) {
        return Err(not_a_block(bytes));
    }
    if there.len() < count {
        return Ok(None);
    }
    // Nine digits at most: no overflow.
    let length = there.iter().fold(0, |sum, digit| 10 * sum + usize::from(digit - b'0'));
    Ok(Some(Block { start: 2 + count, length }))
}

/// Whether a block and its line feed are there, and nothing else.
///
/// # Errors
/// As [`read`]; a block that does not fit into `limit` bytes; bytes where its end must be.
pub fn is_whole(bytes: &[u8], limit: usize) -> Result<bool, FormatError> {
    let Some(block) = read(bytes)? else { return Ok(false) };
    if block.end() >= limit {
        return Err(FormatError::TooLong { limit });
    }
    match bytes.get(block.end()..) {
        None | Some([] | [b'\r']) => Ok(false),
        Some([b'\n'] | [b'\r', b'\n']) => Ok(true),
        Some([b'\n', rest @ ..] | [b'\r', b'\n', rest @ ..]) => {
            Err(FormatError::Trailing { count: rest.len() })
        }
        Some([found, ..]) => Err(FormatError::Unterminated { expected: block.length, found: *found }),
    }
}

/// What is missing of a block that has begun.
pub fn truncation(bytes: &[u8]) -> Option<FormatError> {
    let block = read(bytes).ok()??;
    let found = bytes.len().saturating_sub(block.start).min(block.length);
    Some(FormatError::Truncated { expected: block.length, found })
}

fn not_a_block(bytes: &[u8]) -> FormatError {
    let shown = &bytes[..bytes.len().min(SHOWN)];
    FormatError::NotABlock { found: String::from_utf8_lossy(shown).trim_end().to_owned() }
}
