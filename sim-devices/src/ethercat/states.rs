//! AL state machine (ETG.1000.6, 6.4): which states may follow each other, and why one is refused.

/// A state of the application layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum State {
    /// No communication of the application.
    Init = 1,
    /// Mailbox.
    PreOp = 2,
    /// Firmware update.
    Boot = 3,
    /// Mailbox and inputs.
    SafeOp = 4,
    /// Mailbox, inputs and outputs.
    Op = 8,
}

/// Bit of AL control and status: error, and its acknowledgement.
pub(crate) const ERROR: u16 = 1 << 4;
/// State bits of AL control and status.
pub(crate) const STATE: u16 = 0x0F;

/// AL status codes.
pub(crate) mod code {
    pub(crate) const INVALID_TRANSITION: u16 = 0x0011;
    pub(crate) const UNKNOWN_STATE: u16 = 0x0012;
    pub(crate) const NO_BOOTSTRAP: u16 = 0x0013;
    pub(crate) const MAILBOX: u16 = 0x0016;
    pub(crate) const NO_VALID_OUTPUTS: u16 = 0x0019;
    pub(crate) const WATCHDOG: u16 = 0x001B;
    pub(crate) const OUTPUTS: u16 = 0x001D;
    pub(crate) const INPUTS: u16 = 0x001E;
    pub(crate) const MAPPING: u16 = 0x0025;
    pub(crate) const SYNC_LOST: u16 = 0x002C;
    pub(crate) const NO_SYNC: u16 = 0x002D;
    pub(crate) const SYNC_CYCLE: u16 = 0x0036;
}

impl State {
    /// A state from the bits of AL control.
    pub(crate) fn decode(control: u16) -> Option<Self> {
        match control & STATE {
            1 => Some(Self::Init),
            2 => Some(Self::PreOp),
            3 => Some(Self::Boot),
            4 => Some(Self::SafeOp),
            8 => Some(Self::Op),
            _ => None,
        }
    }

    /// Whether a state may follow this one, or the code why not.
    pub(crate) fn may_become(self, next: Self) -> Result<(), u16> {
        use State::{Boot, Init, Op, PreOp, SafeOp};
        match (self, next) {
            (_, Boot) => Err(code::NO_BOOTSTRAP),
            (from, to) if from == to => Ok(()),
            (Init, PreOp) | (PreOp, SafeOp) | (SafeOp, Op) => Ok(()),
            (Op, SafeOp | PreOp | Init) | (SafeOp, PreOp | Init) | (PreOp, Init) | (Boot, Init) => Ok(()),
            _ => Err(code::INVALID_TRANSITION),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_go_up_step_by_step_and_down_at_once() {
        use State::{Boot, Init, Op, PreOp, SafeOp};
        let up = [(Init, PreOp), (PreOp, SafeOp), (SafeOp, Op)];
        let down = [(Op, SafeOp), (Op, PreOp), (Op, Init), (SafeOp, PreOp), (SafeOp, Init), (PreOp, Init)];
        let states = [Init, PreOp, SafeOp, Op];
        for from in states {
            assert_eq!(from.may_become(Boot), Err(code::NO_BOOTSTRAP));
            for to in states {
                let is_legal = from == to || up.contains(&(from, to)) || down.contains(&(from, to));
                assert_eq!(from.may_become(to).is_ok(), is_legal, "{from:?} to {to:?}");
            }
        }
    }

    #[test]
    fn numbers_that_are_no_state_are_unknown() {
        let known: Vec<u16> = (0..16).filter(|&n| State::decode(n).is_some()).collect();
        assert_eq!(known, [1, 2, 3, 4, 8]);
    }
}
