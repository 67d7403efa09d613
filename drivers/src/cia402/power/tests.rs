use super::PowerState::{
    Fault, FaultReactionActive, NotReady, OperationEnabled, QuickStopActive, ReadyToSwitchOn,
    SwitchOnDisabled, SwitchedOn, Unknown,
};
use super::PowerTarget::{Disabled, Enabled, FaultReset, QuickStop};
use super::*;

const RULES: PowerRules = PowerRules { device: "el", quick_stop_option: 6, timeout_s: 2.0 };

/// Statuswords of the states with the bits around them set as a drive would.
const STATES: [(u16, PowerState); 8] = [
    (0x0200, NotReady),
    (0x0250, SwitchOnDisabled),
    (0x0231, ReadyToSwitchOn),
    (0x1633, SwitchedOn),
    (0x1637, OperationEnabled),
    (0x0617, QuickStopActive),
    (0x020F, FaultReactionActive),
    (0x0218, Fault),
];

/// A drive as the transition table of CiA 402 has it, one transition per exchange; `option` is 605A.
struct Drive {
    state: PowerState,
    option: i16,
    fault_persists: bool,
    last_word: u16,
}

impl Drive {
    fn in_state(state: PowerState) -> Self {
        Self { state, option: 6, fault_persists: false, last_word: 0 }
    }

    fn statusword(&self) -> u16 {
        let found = STATES.iter().find(|(_, state)| *state == self.state);
        found.expect("every state has a statusword").0
    }

    fn take(&mut self, word: u16) {
        let bit = |n: u16| word & (1 << n) != 0;
        let rising_reset = bit(7) && self.last_word & 0x80 == 0;
        let no_voltage = !bit(1);
        let quick_stop = bit(1) && !bit(2);
        self.last_word = word;
        self.state = match self.state {
            NotReady => SwitchOnDisabled,
            FaultReactionActive => Fault,
            Fault if rising_reset && !self.fault_persists => SwitchOnDisabled,
            Fault => Fault,
            _ if no_voltage => SwitchOnDisabled,
            QuickStopActive if self.option < 5 => SwitchOnDisabled,
            QuickStopActive if word & 0x0F == 0x0F => OperationEnabled,
            QuickStopActive => QuickStopActive,
            OperationEnabled if quick_stop => QuickStopActive,
            _ if quick_stop => SwitchOnDisabled,
            SwitchOnDisabled if word & 0x87 == 0x06 => ReadyToSwitchOn,
            ReadyToSwitchOn if word & 0x8F == 0x07 => SwitchedOn,
            SwitchedOn if word & 0x8F == 0x0F => OperationEnabled,
            SwitchedOn | OperationEnabled if word & 0x87 == 0x06 => ReadyToSwitchOn,
            OperationEnabled if word & 0x8F == 0x07 => SwitchedOn,
            same => same,
        };
    }
}

/// Runs until the target is reached; the words sent on the way.
fn run(drive: &mut Drive, target: PowerTarget) -> Result<Vec<u16>, DeviceError> {
    let mut sequence = PowerSequence::default();
    let rules = PowerRules { quick_stop_option: drive.option, ..RULES };
    let mut words = Vec::new();
    for tick in 0..10_000 {
        let now = Duration::from_micros(250 * tick);
        let word = sequence.controlword(&rules, target, drive.statusword(), 0x4310, now)?;
        if target.is_reached(drive.state) {
            return Ok(words);
        }
        words.push(word);
        drive.take(word);
    }
    panic!("neither reached nor timed out in {:?}", drive.state)
}

#[test]
fn statuswords_decode_by_the_masks_whatever_the_other_bits() {
    let patterns: [(u16, u16, PowerState); 8] = [
        (0x4F, 0x00, NotReady),
        (0x4F, 0x40, SwitchOnDisabled),
        (0x6F, 0x21, ReadyToSwitchOn),
        (0x6F, 0x23, SwitchedOn),
        (0x6F, 0x27, OperationEnabled),
        (0x6F, 0x07, QuickStopActive),
        (0x4F, 0x0F, FaultReactionActive),
        (0x4F, 0x08, Fault),
    ];
    for statusword in 0..=u16::MAX {
        let mut matching = patterns.iter().filter(|(mask, value, _)| statusword & mask == *value);
        let expected = matching.next().map_or(Unknown(statusword), |(_, _, state)| *state);
        assert!(matching.next().is_none());
        assert_eq!(PowerState::of(statusword), expected, "{statusword:04X}h");
    }
}

#[test]
fn switch_on_disabled_is_40h_not_20h() {
    assert_eq!(PowerState::of(0x0240), SwitchOnDisabled);
    assert_eq!(PowerState::of(0x0220), NotReady, "bit 5 does not count here");
}

#[test]
fn words_follow_the_transition_table() {
    let table = [
        (NotReady, [0x00, 0x00, 0x02]),
        (SwitchOnDisabled, [0x00, 0x06, 0x02]),
        (ReadyToSwitchOn, [0x00, 0x07, 0x02]),
        (SwitchedOn, [0x00, 0x0F, 0x02]),
        (OperationEnabled, [0x00, 0x0F, 0x02]),
        (QuickStopActive, [0x00, 0x0F, 0x02]),
    ];
    for (state, words) in table {
        let statusword = Drive::in_state(state).statusword();
        for (target, expected) in [Disabled, Enabled, QuickStop].into_iter().zip(words) {
            let word = PowerSequence::default().controlword(&RULES, target, statusword, 0, Duration::ZERO);
            assert_eq!(word, Ok(expected), "{state:?} → {target:?}");
        }
    }
}

#[test]
fn enabling_takes_three_transitions_one_at_a_time() {
    let words = run(&mut Drive::in_state(NotReady), Enabled).expect("no fault");
    assert_eq!(words, [0x00, 0x06, 0x07, 0x0F]);
}

#[test]
fn every_state_reaches_disabled() {
    for (_, state) in STATES {
        let mut drive = Drive::in_state(state);
        let words = run(&mut drive, Disabled).expect("disabling never fails");
        assert!(words.iter().all(|word| *word == 0), "{state:?}: {words:?}");
    }
}

#[test]
fn quick_stop_that_holds_is_left_with_torque_on() {
    let mut drive = Drive::in_state(OperationEnabled);
    assert_eq!(run(&mut drive, QuickStop), Ok(vec![0x02]));
    assert_eq!(drive.state, QuickStopActive);
    assert_eq!(run(&mut drive, Enabled), Ok(vec![0x0F]));
}

#[test]
fn quick_stop_ramp_that_ends_disabled_is_not_cut_short() {
    let mut drive = Drive { option: 2, ..Drive::in_state(QuickStopActive) };
    assert_eq!(run(&mut drive, Enabled), Ok(vec![0x02, 0x06, 0x07, 0x0F]));
}

#[test]
fn fault_is_reset_by_a_rising_edge() {
    let mut drive = Drive { last_word: 0x80, ..Drive::in_state(FaultReactionActive) };
    let words = run(&mut drive, FaultReset).expect("the cause is gone");
    assert_eq!(words, [0x00, 0x00, 0x80]);
    assert_eq!(drive.state, SwitchOnDisabled);
}

#[test]
fn second_fault_gets_its_own_edge() {
    let mut sequence = PowerSequence::default();
    let mut word = |state| {
        let statusword = Drive::in_state(state).statusword();
        sequence.controlword(&RULES, FaultReset, statusword, 0, Duration::ZERO).expect("resetting")
    };
    assert_eq!([word(Fault), word(Fault), word(Fault)], [0x00, 0x80, 0x80]);
    assert_eq!(word(SwitchOnDisabled), 0x00);
    assert_eq!([word(Fault), word(Fault)], [0x00, 0x80]);
}

#[test]
fn fault_that_persists_times_out_with_its_code() {
    let mut drive = Drive { fault_persists: true, ..Drive::in_state(Fault) };
    let error = run(&mut drive, FaultReset).expect_err("the cause is not gone");
    assert_eq!(
        error.to_string(),
        "el: fault → fault reset not reached within 2 s (statusword 0218h, error code 4310h)"
    );
}

#[test]
fn enabling_never_passes_through_a_fault() {
    for state in [Fault, FaultReactionActive] {
        for target in [Enabled, QuickStop] {
            match run(&mut Drive::in_state(state), target) {
                Err(DeviceError::Fault { meaning, error_code: 0x4310, .. }) => {
                    assert_eq!(meaning, "drive over-temperature");
                }
                other => panic!("{state:?} → {target:?}: {other:?}"),
            }
        }
    }
}

#[test]
fn only_switched_on_enabled_or_holding_drives_are_sent_enable_operation() {
    for statusword in 0..=u16::MAX {
        for target in [Disabled, Enabled, QuickStop, FaultReset] {
            let word = PowerSequence::default().controlword(&RULES, target, statusword, 0, Duration::ZERO);
            if word.is_ok_and(|word| word & 0x08 != 0) {
                let state = PowerState::of(statusword);
                assert!(
                    matches!(state, SwitchedOn | OperationEnabled | QuickStopActive),
                    "{statusword:04X}h"
                );
                assert_eq!(target, Enabled);
            }
        }
    }
}

#[test]
fn each_transition_has_its_own_time() {
    let mut sequence = PowerSequence::default();
    let mut at = |seconds, statusword, target| {
        sequence.controlword(&RULES, target, statusword, 0, Duration::from_secs_f64(seconds))
    };
    assert_eq!(at(10.0, 0x0250, Enabled), Ok(0x06));
    assert_eq!(at(12.0, 0x0250, Enabled), Ok(0x06), "exactly at the limit");
    assert_eq!(at(12.1, 0x0231, Enabled), Ok(0x07), "the next state starts anew");
    assert_eq!(at(14.0, 0x0231, Enabled), Ok(0x07));
    let error = at(14.2, 0x0231, Enabled).expect_err("2.1 s in the same state");
    assert!(
        matches!(error, DeviceError::StateTimeout { from: "ready to switch on", to: "enabled", .. }),
        "{error}"
    );
    assert_eq!(at(14.3, 0x0231, Disabled), Ok(0x00), "another target starts anew");
    assert_eq!(at(99.0, 0x0250, Disabled), Ok(0x00), "a target that is reached never times out");
    assert_eq!(at(999.0, 0x0250, Disabled), Ok(0x00));
}

#[test]
fn unknown_pattern_is_never_answered_with_more_torque() {
    assert_eq!(PowerState::of(0x0225), Unknown(0x0225));
    let word = PowerSequence::default().controlword(&RULES, Enabled, 0x0225, 0, Duration::ZERO);
    assert_eq!(word, Ok(0x02));
}
