//! Numbers of an identity that are accepted: vendor, product code, revision, serial number.

use std::fmt;

/// Lowest and highest number that is accepted. Shown as one number where both are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct IdentityRange(pub(crate) [u32; 2]);

impl IdentityRange {
    /// This number alone.
    pub(crate) const fn one(number: u32) -> Self {
        Self([number, number])
    }

    pub(crate) fn contains(self, number: u32) -> bool {
        let Self([low, high]) = self;
        (low..=high).contains(&number)
    }
}

impl fmt::Display for IdentityRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            [low, high] if low == high => write!(f, "{low:08X}h"),
            [low, high] => write!(f, "{low:08X}h to {high:08X}h"),
        }
    }
}
