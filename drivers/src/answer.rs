//! What may be wrong with the answer of an instrument.

/// Why an answer cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FormatError {
    /// Something else than a number in a list.
    #[error("value {place}: expected a number, found `{found}`")]
    NotANumber {
        /// Place in the list, from 1.
        place: usize,
        /// What stands there.
        found: String,
    },
    /// A value that the instrument marks as not valid.
    #[error("value {place} is {meaning}; check range, level and connections of the instrument")]
    NotValid {
        /// Place in the list, from 1.
        place: usize,
        /// What the mark means.
        meaning: &'static str,
    },
    /// Another number of values than asked for.
    #[error("expected {expected} values, found {found}")]
    Count {
        /// Values asked for.
        expected: usize,
        /// Values found.
        found: usize,
    },
    /// No block where one must be.
    #[error("expected a definite-length block `#<digits><length>`, found `{found}`")]
    NotABlock {
        /// How it begins.
        found: String,
    },
    /// A block of indefinite length.
    #[error("an indefinite-length block `#0`: only the end of the connection would end it")]
    Indefinite,
    /// A block that ends early.
    #[error("a block of {expected} bytes ends after {found}")]
    Truncated {
        /// Length by its header.
        expected: usize,
        /// Bytes that came.
        found: usize,
    },
    /// Something else than a line feed behind a block.
    #[error("expected a line feed after a block of {expected} bytes, found {found:02X}h")]
    Unterminated {
        /// Length by its header.
        expected: usize,
        /// First byte behind it.
        found: u8,
    },
    /// More bytes than there is room for.
    #[error("more than {limit} bytes")]
    TooLong {
        /// Room.
        limit: usize,
    },
    /// Bytes behind the end of the answer.
    #[error("{count} bytes after the end of the answer; check for another talker on the line")]
    Trailing {
        /// How many.
        count: usize,
    },
    /// Some other text than expected.
    #[error("expected {expected}, found `{found}`")]
    Text {
        /// What it must be.
        expected: &'static str,
        /// What it is.
        found: String,
    },
}
