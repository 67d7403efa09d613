//! From SAFE-OP to the first segment: bus, faults, questions, torque, the place where the plan begins.

use std::time::Duration;

use drivers::cia402::{PowerState, PowerTarget};
use drivers::device::DeviceError;
use drivers::wire::BusState;
use procedures::procedure::PromptClass;

use super::{Sequencer, State};
use crate::cycle::prompt::{self, Answer};
use crate::cycle::recorder::LoopEvent;
use crate::rig::ArmedRig;

/// Longest wait for gyros that have just been powered.
const FEEDBACK_LIMIT_S: f64 = 20.0;
/// Longest wait for the bus to change its state (safety.md: deadlines).
const BUS_LIMIT_S: f64 = 5.0;
/// An axis nearer to the plan's start than this (0.1°) is where it belongs, …
pub(crate) const HOMED_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// … and one nearer than this where the point looks at a target: the field of the fine camera ends 0.5 mrad from its middle.
const LOOKING_RAD: f64 = 50e-6;

impl Sequencer<'_> {
    pub(super) fn power_up(
        &mut self,
        now: Duration,
        rig: &mut ArmedRig,
        tell: &mut dyn FnMut(LoopEvent),
    ) -> Result<(), DeviceError> {
        let waited_s = self.waited_s(now);
        if self.cools {
            return Ok(());
        }
        match self.state {
            State::SafeOp if rig.bus_state() >= BusState::SafeOp => {
                rig.request(BusState::Op);
                self.go(State::OpRequest, now);
            }
            State::OpRequest if rig.bus_state() == BusState::Op && rig.feedback_is_valid() => {
                self.go(if faulty(rig) { State::FaultReset } else { self.before_torque() }, now);
            }
            State::OpRequest if rig.bus_state() == BusState::Op && waited_s > FEEDBACK_LIMIT_S => {
                let reason = format!(
                    "no valid rates from the gyros for {FEEDBACK_LIMIT_S} s; check power and line of the unit"
                );
                return Err(DeviceError::Bus { device: "imu".to_owned(), reason });
            }
            State::SafeOp | State::OpRequest if waited_s > BUS_LIMIT_S && rig.bus_state() < BusState::Op => {
                let reason = format!(
                    "bus state {:?} for more than {BUS_LIMIT_S} s, expected Op; check power and wiring of the drives",
                    rig.bus_state()
                );
                return Err(DeviceError::Bus { device: "bus".to_owned(), reason });
            }
            State::FaultReset if !faulty(rig) => self.go(self.before_torque(), now),
            State::Enabling if self.all_enabled(rig) => self.enabled(now, rig, tell),
            _ => {}
        }
        Ok(())
    }

    /// Where the power stage of an axis is wanted. One that its drive holds from the point before is not let go on the way
    /// to its torque.
    pub(super) fn power_target(&self, axis: usize, rig: &ArmedRig) -> PowerTarget {
        let is_held = PowerState::of(rig.actuals(axis).statusword) == PowerState::QuickStopActive;
        match self.state {
            State::SafeOp | State::OpRequest | State::FaultReset if is_held => PowerTarget::QuickStop,
            State::SafeOp | State::OpRequest | State::Asking(PromptClass::Safety) => PowerTarget::Disabled,
            State::FaultReset => PowerTarget::FaultReset,
            State::Disabling if self.releases[axis] => PowerTarget::Disabled,
            // One that is not released is held by its drive, as it will be afterwards.
            State::Disabling => PowerTarget::QuickStop,
            _ => PowerTarget::Enabled,
        }
    }

    /// Safety questions come before there is torque.
    fn before_torque(&self) -> State<'static> {
        if self.has(PromptClass::Safety) { State::Asking(PromptClass::Safety) } else { State::Enabling }
    }

    fn has(&self, class: PromptClass) -> bool {
        self.questions.iter().any(|q| q.class == class)
    }

    fn all_enabled(&self, rig: &ArmedRig) -> bool {
        (0..self.loops.len())
            .all(|axis| PowerState::of(rig.actuals(axis).statusword) == PowerState::OperationEnabled)
    }

    fn enabled(&mut self, now: Duration, rig: &ArmedRig, tell: &mut dyn FnMut(LoopEvent)) {
        if self.case.open_loop {
            return self.start_segment(0, now, rig, tell);
        }
        let near_rad = if self.case.target.is_some() { LOOKING_RAD } else { HOMED_RAD };
        let mut at_home = true;
        for (axis, axis_loop) in self.loops.iter_mut().enumerate() {
            let actuals = rig.actuals(axis);
            let rig_axis = &rig.axes()[axis];
            axis_loop.hold_here(actuals);
            let wanted = self.case.start_pose_rad.get(&rig_axis.name);
            let away = wanted.filter(|rad| (**rad - actuals.position_rad).abs() > near_rad);
            if let Some(&start_rad) = away {
                axis_loop.go_slowly(actuals, start_rad);
                at_home = false;
            }
        }
        if at_home { self.homed(now, rig, tell) } else { self.go(State::Homing, now) }
    }

    pub(super) fn home(
        &mut self,
        now: Duration,
        rig: &ArmedRig,
        tell: &mut dyn FnMut(LoopEvent),
    ) -> Result<(), DeviceError> {
        if (0..self.loops.len()).all(|axis| self.loops[axis].stopped(rig.actuals(axis))) {
            self.homed(now, rig, tell);
        } else if self.waited_s(now) > self.slow_move_limit_s() {
            let reason =
                format!("did not come to rest at its start pose within {:.0} s", self.slow_move_limit_s());
            return Err(DeviceError::Bus { device: self.case.axis.clone(), reason });
        }
        Ok(())
    }

    fn homed(&mut self, now: Duration, rig: &ArmedRig, tell: &mut dyn FnMut(LoopEvent)) {
        if self.has(PromptClass::Info) {
            self.go(State::Asking(PromptClass::Info), now);
        } else {
            self.start_segment(0, now, rig, tell);
        }
    }

    /// Asks one question after the other; a no ends the point before it moves.
    pub(super) fn ask(
        &mut self,
        class: PromptClass,
        now: Duration,
        rig: &ArmedRig,
        tell: &mut dyn FnMut(LoopEvent),
    ) -> Result<(), DeviceError> {
        let open = self.questions.iter().find(|q| q.class == class && q.answer() != Some(Answer::Confirmed));
        match open {
            None if class == PromptClass::Safety => self.go(State::Enabling, now),
            None => self.start_segment(0, now, rig, tell),
            Some(question) if question.answer() == Some(Answer::Refused) => self.refused = true,
            Some(_) if self.waited_s(now) > prompt::LIMIT_S => {
                let reason = format!("no answer from the operator for {} s", prompt::LIMIT_S);
                return Err(DeviceError::Bus { device: "prompt".to_owned(), reason });
            }
            Some(question) => question.ask(),
        }
        Ok(())
    }
}

fn faulty(rig: &ArmedRig) -> bool {
    (0..rig.axes().len()).any(|axis| {
        let state = PowerState::of(rig.actuals(axis).statusword);
        matches!(state, PowerState::Fault | PowerState::FaultReactionActive)
    })
}
