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
    #[error("value {place}: expected a measured value, found {meaning}")]
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
    #[error("expected a block of definite length, found one of indefinite length (`#0`)")]
    Indefinite,
    /// A block that ends early.
    #[error("expected a block of {expected} bytes, found {found} of them")]
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
    #[error("expected at most {limit} bytes, found more")]
    TooLong {
        /// Room.
        limit: usize,
    },
    /// Bytes behind the end of the answer.
    #[error("expected nothing after the end of the answer, found {count} bytes")]
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

impl FormatError {
    /// What to do about it.
    pub(crate) fn help(&self) -> &'static str {
        match self {
            Self::NotValid { .. } => "check range, level and connections of the instrument",
            Self::Truncated { .. } | Self::Unterminated { .. } | Self::Trailing { .. } => {
                "check cable and network, and whether another program talks to the instrument; then start again"
            }
            Self::Count { .. } | Self::TooLong { .. } => {
                "check the settings of the instrument, and whether another program changes them; then start again"
            }
            Self::NotANumber { .. } | Self::NotABlock { .. } | Self::Indefinite | Self::Text { .. } => {
                "check model and command set of the instrument, and whether another program talks to it"
            }
        }
    }
}
