//! The error queue (SCPI-1999, 21.8): `<code>,"<text>"`, code 0 where it is empty.

use super::FormatError;

/// What asks for its oldest entry.
pub(super) const QUERY: &str = ":SYST:ERR?";
/// What an entry must be.
const EXPECTED: &str = "an error entry `<code>,\"<text>\"`";

/// The oldest entry, `None` if there is none.
pub(super) fn entry(bytes: &[u8]) -> Result<Option<(i32, String)>, FormatError> {
    let text = std::str::from_utf8(bytes).ok();
    let read = text.and_then(|text| {
        let (code, rest) = text.split_once(',').unwrap_or((text, ""));
        Some((code.trim().parse::<i32>().ok()?, rest))
    });
    match read {
        None => {
            let found = String::from_utf8_lossy(bytes).into_owned();
            Err(FormatError::Text { expected: EXPECTED, found })
        }
        Some((0, _)) => Ok(None),
        Some((code, text)) => Ok(Some((code, text.trim().trim_matches('"').to_owned()))),
    }
}
