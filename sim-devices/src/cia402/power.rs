//! Power state machine of CiA 402 (IEC 61800-7-201, 5.2): states, commands, transitions.

/// Power states. "Not ready to switch on" is missing, because the drive leaves it before the bus starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// No torque, nothing prepared.
    SwitchOnDisabled,
    /// No torque, DC link may be charged.
    ReadyToSwitchOn,
    /// No torque, power stage ready.
    SwitchedOn,
    /// Torque follows the commands.
    OperationEnabled,
    /// Torque on; braking, or held at standstill.
    QuickStopActive,
    /// Torque on; stopping because of a fault.
    FaultReactionActive,
    /// No torque.
    Fault,
}

/// What a controlword asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Command {
    DisableVoltage,
    QuickStop,
    Shutdown,
    SwitchOn,
    EnableOperation,
}

/// What the state machine does about a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reaction {
    /// No transition; a delayed transition that is still pending is cancelled.
    Stay,
    /// Enters this state after the transition delay.
    Later(State),
    /// Enters this state in this cycle.
    Now(State),
    /// Leaves "operation enabled" as the shutdown option code (605Bh) says.
    ShutDown,
    /// Leaves "operation enabled" as the disable operation option code (605Ch) says.
    Disable,
    /// Starts a quick stop as the quick stop option code (605Ah) says.
    QuickStop,
}

impl State {
    /// The state's bits of the statusword (bits 0–3, 5, 6).
    pub(crate) const fn pattern(self) -> u16 {
        match self {
            Self::SwitchOnDisabled => 0x0040,
            Self::ReadyToSwitchOn => 0x0021,
            Self::SwitchedOn => 0x0023,
            Self::OperationEnabled => 0x0027,
            Self::QuickStopActive => 0x0007,
            Self::FaultReactionActive => 0x000F,
            Self::Fault => 0x0008,
        }
    }

    /// Whether the power stage can give torque.
    pub(crate) const fn has_torque(self) -> bool {
        matches!(self, Self::OperationEnabled | Self::QuickStopActive | Self::FaultReactionActive)
    }
}

impl Command {
    /// Decodes bits 0 to 3 of the controlword. Fault reset, halt and the bits of the mode are ignored.
    pub(crate) const fn of(controlword: u16) -> Self {
        const SWITCH_ON: u16 = 1 << 0;
        const ENABLE_VOLTAGE: u16 = 1 << 1;
        /// Active low.
        const QUICK_STOP: u16 = 1 << 2;
        const ENABLE_OPERATION: u16 = 1 << 3;
        match controlword {
            word if word & ENABLE_VOLTAGE == 0 => Self::DisableVoltage,
            word if word & QUICK_STOP == 0 => Self::QuickStop,
            word if word & SWITCH_ON == 0 => Self::Shutdown,
            word if word & ENABLE_OPERATION == 0 => Self::SwitchOn,
            _ => Self::EnableOperation,
        }
    }
}

/// The transition table. The number behind each row is that of the transition in CiA 402.
///
/// `may_resume`: the quick stop option code holds the axis in "quick stop active", so that transition 16 is allowed.
pub(crate) const fn react(state: State, command: Command, may_resume: bool) -> Reaction {
    use Command::{DisableVoltage, EnableOperation, QuickStop, Shutdown, SwitchOn};
    use State::{OperationEnabled, QuickStopActive, ReadyToSwitchOn, SwitchOnDisabled, SwitchedOn};
    match (state, command) {
        (SwitchOnDisabled, Shutdown) => Reaction::Later(ReadyToSwitchOn), // 2
        (ReadyToSwitchOn, SwitchOn | EnableOperation) => Reaction::Later(SwitchedOn), // 3
        (SwitchedOn, EnableOperation) => Reaction::Later(OperationEnabled), // 4
        (OperationEnabled, SwitchOn) => Reaction::Disable,                // 5
        (SwitchedOn, Shutdown) => Reaction::Now(ReadyToSwitchOn),         // 6
        (ReadyToSwitchOn, DisableVoltage | QuickStop) => Reaction::Now(SwitchOnDisabled), // 7
        (OperationEnabled, Shutdown) => Reaction::ShutDown,               // 8
        (OperationEnabled, DisableVoltage) => Reaction::Now(SwitchOnDisabled), // 9
        (SwitchedOn, DisableVoltage | QuickStop) => Reaction::Now(SwitchOnDisabled), // 10
        (OperationEnabled, QuickStop) => Reaction::QuickStop,             // 11
        (QuickStopActive, DisableVoltage) => Reaction::Now(SwitchOnDisabled), // 12
        (QuickStopActive, EnableOperation) if may_resume => Reaction::Later(OperationEnabled), // 16
        _ => Reaction::Stay,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATES: [State; 7] = [
        State::SwitchOnDisabled,
        State::ReadyToSwitchOn,
        State::SwitchedOn,
        State::OperationEnabled,
        State::QuickStopActive,
        State::FaultReactionActive,
        State::Fault,
    ];

    #[test]
    fn controlwords_mean_what_the_profile_says() {
        let words = [
            (0x0006, Command::Shutdown),
            (0x0007, Command::SwitchOn),
            (0x000F, Command::EnableOperation),
            (0x0000, Command::DisableVoltage),
            (0x000D, Command::DisableVoltage),
            (0x0002, Command::QuickStop),
            (0x000B, Command::QuickStop),
            (0x0080, Command::DisableVoltage),
            (0x010F, Command::EnableOperation),
        ];
        words.iter().for_each(|&(word, command)| assert_eq!(Command::of(word), command, "{word:04X}"));
    }

    #[test]
    fn patterns_are_told_apart_by_the_masks_of_the_profile() {
        let masks = [0x4F, 0x6F, 0x6F, 0x6F, 0x6F, 0x4F, 0x4F];
        for (state, mask) in STATES.iter().zip(masks) {
            let matches_pattern = |other: &&State| other.pattern() & mask == state.pattern();
            assert_eq!(STATES.iter().filter(matches_pattern).count(), 1, "{state:?}");
        }
    }

    /// No command leaves "fault": only the rising edge of fault reset does. Torque comes on only after "switched on".
    #[test]
    fn torque_is_reached_step_by_step_and_never_out_of_a_fault() {
        for word in 0..=0x1FF {
            let command = Command::of(word);
            assert_eq!(react(State::Fault, command, true), Reaction::Stay);
            assert_eq!(react(State::FaultReactionActive, command, true), Reaction::Stay);
            for state in [State::SwitchOnDisabled, State::ReadyToSwitchOn] {
                let reaction = react(state, command, true);
                assert!(!matches!(reaction, Reaction::Later(to) | Reaction::Now(to) if to.has_torque()));
            }
        }
        assert_eq!(react(State::QuickStopActive, Command::EnableOperation, false), Reaction::Stay);
    }
}
