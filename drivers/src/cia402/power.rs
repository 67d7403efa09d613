//! The power state machine of CiA 402: statusword in, one controlword out.

use std::time::Duration;

use super::error_code::error_code_meaning;
use crate::device::DeviceError;

/// Power states of CiA 402.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum PowerState {
    NotReady,
    SwitchOnDisabled,
    ReadyToSwitchOn,
    SwitchedOn,
    OperationEnabled,
    QuickStopActive,
    FaultReactionActive,
    Fault,
    /// A pattern that the profile does not know.
    Unknown(u16),
}

/// Where the power stage is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PowerTarget {
    /// No torque.
    Disabled,
    /// Torque on, following commands. Faults are not reset on the way.
    Enabled,
    /// Quick stop as configured.
    QuickStop,
    /// Out of a fault: disabled, the fault reset by a rising edge.
    FaultReset,
}

/// Controlwords. Bit 0 switch on, 1 enable voltage, 2 quick stop (active low), 3 enable operation, 7 fault reset
/// (rising edge).
mod word {
    pub(super) const DISABLE_VOLTAGE: u16 = 0x0000;
    /// Bit 2 low: stops where there is motion, leads to "switch on disabled" elsewhere.
    pub(super) const QUICK_STOP: u16 = 0x0002;
    pub(super) const SHUTDOWN: u16 = 0x0006;
    pub(super) const SWITCH_ON: u16 = 0x0007;
    pub(super) const ENABLE_OPERATION: u16 = 0x000F;
    pub(super) const FAULT_RESET: u16 = 0x0080;
}

impl PowerState {
    /// Whether the power stage gives no torque. A state that is not known may be moving.
    pub const fn is_without_torque(self) -> bool {
        matches!(self, Self::SwitchOnDisabled | Self::ReadyToSwitchOn | Self::SwitchedOn | Self::Fault)
    }

    /// Decodes a statusword by the masks of CiA 402. ("Switch on disabled" is 40h; 20h in an old header is wrong.)
    pub fn of(statusword: u16) -> Self {
        match (statusword & 0x4F, statusword & 0x6F) {
            (0x00, _) => Self::NotReady,
            (0x40, _) => Self::SwitchOnDisabled,
            (0x0F, _) => Self::FaultReactionActive,
            (0x08, _) => Self::Fault,
            (_, 0x21) => Self::ReadyToSwitchOn,
            (_, 0x23) => Self::SwitchedOn,
            (_, 0x27) => Self::OperationEnabled,
            (_, 0x07) => Self::QuickStopActive,
            _ => Self::Unknown(statusword),
        }
    }

    /// Name of the state in CiA 402.
    pub fn name(self) -> &'static str {
        match self {
            Self::NotReady => "not ready to switch on",
            Self::SwitchOnDisabled => "switch on disabled",
            Self::ReadyToSwitchOn => "ready to switch on",
            Self::SwitchedOn => "switched on",
            Self::OperationEnabled => "operation enabled",
            Self::QuickStopActive => "quick stop active",
            Self::FaultReactionActive => "fault reaction active",
            Self::Fault => "fault",
            Self::Unknown(_) => "unknown state",
        }
    }

    fn is_fault(self) -> bool {
        matches!(self, Self::Fault | Self::FaultReactionActive)
    }
}

impl PowerTarget {
    /// Whether a state is what the target asks for.
    pub fn is_reached(self, state: PowerState) -> bool {
        match self {
            Self::Disabled => matches!(state, PowerState::SwitchOnDisabled | PowerState::Fault),
            Self::Enabled => state == PowerState::OperationEnabled,
            Self::QuickStop => matches!(state, PowerState::QuickStopActive | PowerState::SwitchOnDisabled),
            Self::FaultReset => state == PowerState::SwitchOnDisabled,
        }
    }

    /// Name for errors.
    pub fn name(self) -> &'static str {
        match self {
            Self::Disabled => "disabled",
            Self::Enabled => "enabled",
            Self::QuickStop => "quick stop",
            Self::FaultReset => "fault reset",
        }
    }
}

/// Controlwords for one drive, and where it stands on the way to a target. [`Cia402`](super::Cia402) has one of its own; it
/// stands alone for drives whose dictionary is not the one that the bench needs.
#[derive(Clone, Debug, Default)]
pub struct PowerSequence {
    step: Option<Step>,
    /// Whether bit 7 was sent low since the fault was seen: the next high is an edge.
    reset_low_sent: bool,
}

/// The state that is to be left, and since when.
#[derive(Clone, Copy, Debug)]
struct Step {
    target: PowerTarget,
    state: PowerState,
    since: Duration,
}

/// What does not change from call to call.
#[derive(Clone, Copy, Debug)]
pub struct PowerRules<'a> {
    /// Name of the drive for errors.
    pub device: &'a str,
    /// Quick stop option code (605A); from 5 on the drive stays in quick stop.
    pub quick_stop_option: i16,
    /// Time allowed for each power state transition.
    pub timeout_s: f64,
}

impl PowerSequence {
    /// One controlword on the way to `target`, one transition at a time; as [`Cia402::controlword`](super::Cia402::controlword).
    /// The error code only explains a fault.
    ///
    /// # Errors
    /// [`DeviceError::StateTimeout`]; [`DeviceError::Fault`] on a fault unless `target` is `FaultReset` or `Disabled`.
    pub fn controlword(
        &mut self,
        rules: &PowerRules<'_>,
        target: PowerTarget,
        statusword: u16,
        error_code: u16,
        now: Duration,
    ) -> Result<u16, DeviceError> {
        let state = PowerState::of(statusword);
        if state.is_fault() && matches!(target, PowerTarget::Enabled | PowerTarget::QuickStop) {
            self.step = None;
            let device = rules.device.to_owned();
            let meaning = error_code_meaning(error_code);
            return Err(DeviceError::Fault { device, error_code, meaning, statusword });
        }
        if self.waited(target, state, now).as_secs_f64() > rules.timeout_s && !target.is_reached(state) {
            return Err(DeviceError::StateTimeout {
                device: rules.device.to_owned(),
                from: state.name(),
                to: target.name(),
                limit_s: rules.timeout_s,
                statusword,
                error_code,
            });
        }
        Ok(self.word(rules, target, state))
    }

    /// Time in this state on the way to this target; a change of either starts anew.
    fn waited(&mut self, target: PowerTarget, state: PowerState, now: Duration) -> Duration {
        let step = self.step.filter(|step| step.target == target && step.state == state);
        let step = *self.step.insert(step.unwrap_or(Step { target, state, since: now }));
        now.saturating_sub(step.since)
    }

    fn word(&mut self, rules: &PowerRules, target: PowerTarget, state: PowerState) -> u16 {
        let resetting = target == PowerTarget::FaultReset && state == PowerState::Fault;
        let edge = resetting && self.reset_low_sent;
        self.reset_low_sent = resetting;
        match target {
            PowerTarget::FaultReset if edge => word::FAULT_RESET,
            PowerTarget::FaultReset | PowerTarget::Disabled => word::DISABLE_VOLTAGE,
            PowerTarget::QuickStop => word::QUICK_STOP,
            PowerTarget::Enabled => enabling(state, rules.quick_stop_option),
        }
    }
}

/// The step towards "operation enabled" from a state without fault.
fn enabling(state: PowerState, quick_stop_option: i16) -> u16 {
    match state {
        PowerState::SwitchOnDisabled => word::SHUTDOWN,
        PowerState::ReadyToSwitchOn => word::SWITCH_ON,
        PowerState::SwitchedOn | PowerState::OperationEnabled => word::ENABLE_OPERATION,
        // Transition 16 keeps the torque of an axis that would fall; it exists where the drive stays in quick stop.
        PowerState::QuickStopActive if quick_stop_option >= 5 => word::ENABLE_OPERATION,
        // The ramp is not cut short: the drive disables itself at its end.
        PowerState::QuickStopActive => word::QUICK_STOP,
        // What is not understood must not run on.
        PowerState::Unknown(_) => word::QUICK_STOP,
        PowerState::NotReady | PowerState::FaultReactionActive | PowerState::Fault => word::DISABLE_VOLTAGE,
    }
}

#[cfg(test)]
mod tests;
