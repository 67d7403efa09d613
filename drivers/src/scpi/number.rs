//! ASCII numbers of answers (IEEE 488.2, 8.7.2 … 8.7.4; SCPI-1999, 7.2.1.4 and 7.2.1.5 for those that are none).

use super::FormatError;

/// Positive and negative overload.
const INFINITY: f64 = 9.9e37;
/// Not a number.
const NOT_A_NUMBER: f64 = 9.91e37;
/// Characters that are shown of something that is no number.
const SHOWN: usize = 24;

/// A line without its end and without blanks around it.
pub fn trimmed(bytes: &[u8]) -> &[u8] {
    bytes.trim_ascii()
}

/// Whether a line and nothing behind it is there.
///
/// # Errors
/// [`FormatError::Trailing`].
pub(super) fn line_is_whole(bytes: &[u8]) -> Result<bool, FormatError> {
    match bytes.iter().position(|byte| *byte == b'\n') {
        None => Ok(false),
        Some(end) if end + 1 == bytes.len() => Ok(true),
        Some(end) => Err(FormatError::Trailing { count: bytes.len() - end - 1 }),
    }
}

/// Reads a list of exactly `expected` numbers, separated by commas, into `into`, which is emptied first.
///
/// # Errors
/// [`FormatError::NotANumber`], [`FormatError::NotValid`], [`FormatError::Count`].
pub fn list(bytes: &[u8], expected: usize, into: &mut Vec<f64>) -> Result<(), FormatError> {
    into.clear();
    let mut found = 0;
    for text in trimmed(bytes).split(|byte| *byte == b',') {
        found += 1;
        if found <= expected {
            into.push(number(text, found)?);
        }
    }
    if trimmed(bytes).is_empty() {
        found = 0;
    }
    if found == expected { Ok(()) } else { Err(FormatError::Count { expected, found }) }
}

/// Reads one number that stands at a place of a list, from 1.
///
/// # Errors
/// [`FormatError::NotANumber`], [`FormatError::NotValid`].
pub fn number(bytes: &[u8], place: usize) -> Result<f64, FormatError> {
    let text = trimmed(bytes);
    // `inf` and `nan` are words of Rust, not of SCPI.
    let plain = text.iter().all(|c| c.is_ascii_digit() || b"+-.eE".contains(c));
    let value = std::str::from_utf8(text).ok().filter(|_| plain).and_then(|text| text.parse::<f64>().ok());
    let Some(value) = value.filter(|value| value.is_finite()) else {
        let shown = &text[..text.len().min(SHOWN)];
        return Err(FormatError::NotANumber { place, found: String::from_utf8_lossy(shown).into_owned() });
    };
    match () {
        () if value == NOT_A_NUMBER => {
            Err(FormatError::NotValid { place, meaning: "not a number (9.91E37)" })
        }
        () if value.abs() >= INFINITY => {
            Err(FormatError::NotValid { place, meaning: "an overload (9.9E37)" })
        }
        () => Ok(value),
    }
}
