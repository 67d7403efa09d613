//! What the drive does about controlwords, faults and a silent bus.

use super::dictionary::at;
use super::motion::Ramp;
use super::power::{Command, Reaction, State, react};
use super::{Actuation, After, Drive, SUPERVISION_S, steps};
use crate::physics::encoder::{EncoderFault, read_word};
use drivers::wire::BusState;

/// Fault reset bit of the controlword.
const FAULT_RESET: u16 = 0x0080;

/// Drive over-temperature.
pub(super) const OVER_TEMPERATURE: u16 = 0x4310;
/// DC link over-voltage.
pub(super) const OVER_VOLTAGE: u16 = 0x3110;
/// DC link under-voltage.
pub(super) const UNDER_VOLTAGE: u16 = 0x3120;
/// The encoder says that its position cannot be trusted.
pub(super) const ENCODER: u16 = 0x7305;
/// The frame of the encoder is damaged.
pub(super) const ENCODER_FRAME: u16 = 0x7306;
/// Process data stopped.
pub(super) const COMMUNICATION: u16 = 0x7500;

impl Drive {
    /// Whatever is due at or before this step.
    pub(super) fn serve_events(&mut self, step: u64) {
        self.act_on_outputs(step);
        if let Some((state, due)) = self.pending
            && step >= due
        {
            self.enter(state);
        }
        if self.watchdog_step().is_some_and(|due| step > due) {
            self.bus_state = BusState::SafeOp;
            self.deferred.clear();
            self.lose_connection();
        }
        if step >= self.supervision_step {
            self.supervision_step += steps(SUPERVISION_S, self.step_s).max(1);
            self.supervise();
        }
        self.schedule();
    }

    /// The last step at which the watchdog is still content.
    fn watchdog_step(&self) -> Option<u64> {
        let armed = self.bus_state == BusState::Op && self.limits.watchdog_steps > 0;
        armed.then_some(self.fed_step + self.limits.watchdog_steps)
    }

    pub(super) fn schedule(&mut self) {
        let pending = self.pending.map_or(u64::MAX, |(_, due)| due);
        let watchdog = self.watchdog_step().map_or(u64::MAX, |due| due + 1);
        let outputs = self.deferred.next_due().unwrap_or(u64::MAX);
        self.next_event_step = self.supervision_step.min(pending).min(watchdog).min(outputs);
    }

    /// Heat sink and DC link.
    fn supervise(&mut self) {
        let count = std::mem::take(&mut self.squares_count);
        let sum_a2 = std::mem::take(&mut self.square_sum_a2);
        self.heat_sink.advance(if count == 0 { 0.0 } else { sum_a2 / f64::from(count) });
        if let Some(code) = self.cause_of_fault() {
            self.fault(code);
        }
    }

    fn cause_of_fault(&self) -> Option<u16> {
        let needs_voltage = self.state.has_torque() || self.state == State::SwitchedOn;
        if self.heat_sink.temperature_degc() >= self.settings.heat_sink_shutdown_degc {
            Some(OVER_TEMPERATURE)
        } else if self.dc_link_v > self.settings.over_voltage_v {
            Some(OVER_VOLTAGE)
        } else if needs_voltage && self.dc_link_v < self.settings.under_voltage_v {
            Some(UNDER_VOLTAGE)
        } else {
            match self.encoder.fault() {
                Some(EncoderFault::Error) => Some(ENCODER),
                Some(EncoderFault::Crc) => Some(ENCODER_FRAME),
                Some(EncoderFault::Warning) | None => None,
            }
        }
    }

    /// What the drive finds in the encoder's frame at this angle, and whether there is a position in it; only looked at where
    /// something is wrong with it.
    pub(super) fn read_encoder(&mut self, angle_rad: f64) -> bool {
        self.encoder_warns = false;
        if self.encoder.fault().is_none() {
            return true;
        }
        let bits = self.encoder.counts_per_rev().ilog2();
        match read_word(self.encoder.word(angle_rad), bits) {
            None => self.fault(ENCODER_FRAME),
            Some(reading) if reading.error => self.fault(ENCODER),
            Some(reading) => {
                self.encoder_warns = reading.warning;
                return true;
            }
        }
        false
    }

    /// A fault: by the fault reaction option where there is torque and a DC link to brake with.
    pub(super) fn fault(&mut self, code: u16) {
        // Without a position there is no velocity to brake by.
        let blind = code == ENCODER || code == ENCODER_FRAME;
        if self.state == State::Fault || self.state == State::FaultReactionActive && !blind {
            return;
        }
        self.dictionary.put(at::ERROR_CODE, i64::from(code));
        let option = self.dictionary.get(at::FAULT_REACTION);
        // Nor is there a brake without a DC link or with a broken power stage (2xxxh current, 5xxxh hardware).
        let stage = matches!(code >> 12, 2 | 5) || code == UNDER_VOLTAGE || code == OVER_VOLTAGE;
        let can_brake = self.state.has_torque() && !stage && !self.gates_blocked;
        if can_brake && !blind && option != 0 {
            self.pending = None;
            self.state = State::FaultReactionActive;
            self.stop(option, After::Off(State::Fault));
        } else {
            self.enter(State::Fault);
        }
    }

    /// Changes the state of this end of the bus as the host asked; with torque on, leaving OP is a lost connection.
    pub(crate) fn set_bus_state(&mut self, state: BusState) {
        let left = self.bus_state == BusState::Op && state != BusState::Op;
        self.bus_state = state;
        if left {
            self.deferred.clear();
        }
        if left && self.state.has_torque() {
            self.lose_connection();
        }
        self.schedule();
    }

    /// Its end of an EtherCAT wire has left SAFE-OP downwards: nothing supervises the drive there, and its power stage is off
    /// (ETG.6010).
    pub(crate) fn leave_safe_op(&mut self) {
        if self.state.has_torque() {
            self.enter(State::SwitchOnDisabled);
            self.schedule();
        }
    }

    /// The process-data watchdog counts from `step`: its end of the bus has entered OP, and outputs come with the next SYNC0.
    pub(crate) fn start_watchdog(&mut self, step: u64) {
        self.fed_step = self.fed_step.max(step);
        self.schedule();
    }

    /// Abort connection option 6007h. Without torque there is nothing to stop, but option 1 is a fault all the same.
    fn lose_connection(&mut self) {
        let torque = self.state.has_torque();
        match self.dictionary.get(at::ABORT_CONNECTION) {
            1 => return self.fault(COMMUNICATION),
            2 if torque => self.enter(State::SwitchOnDisabled),
            3 if torque => self.quick_stop(),
            _ => return,
        }
        self.dictionary.put(at::ERROR_CODE, i64::from(COMMUNICATION));
    }

    /// Commands of the outputs that were just taken.
    pub(super) fn obey(&mut self, step: u64) {
        let controlword = self.dictionary.get(at::CONTROLWORD) as u16;
        let reset = controlword & FAULT_RESET != 0 && self.last_controlword & FAULT_RESET == 0;
        self.last_controlword = controlword;
        if self.state == State::Fault {
            if reset && self.cause_of_fault().is_none() {
                self.pend(State::SwitchOnDisabled, step);
            }
        } else {
            let stays = self.dictionary.get(at::QUICK_STOP) >= 5;
            match react(self.state, Command::of(controlword), stays) {
                Reaction::Stay => self.pending = None,
                Reaction::Later(state) => self.pend(state, step),
                Reaction::Now(state) => self.enter(state),
                Reaction::ShutDown => self.leave_operation(at::SHUTDOWN, State::ReadyToSwitchOn),
                Reaction::Disable => self.leave_operation(at::DISABLE, State::SwitchedOn),
                Reaction::QuickStop => self.quick_stop(),
            }
        }
        self.follow();
        self.schedule();
    }

    fn pend(&mut self, state: State, step: u64) {
        if self.gates_blocked && state != State::SwitchOnDisabled {
            return;
        }
        if self.pending.is_none_or(|(pending, _)| pending != state) {
            self.pending = Some((state, step + steps(self.settings.transition_delay_s, self.step_s)));
        }
    }

    /// Takes the targets over while in operation and not on the way out of it.
    fn follow(&mut self) {
        let leaving = matches!(self.actuation, Actuation::Stopping(..));
        if self.state != State::OperationEnabled || leaving {
            return;
        }
        let mode = self.dictionary.get(at::MODE);
        self.dictionary.put(at::MODE_DISPLAY, mode);
        self.actuation = if mode == 9 {
            if !matches!(self.actuation, Actuation::Velocity(_)) {
                self.velocity_loop.reset(self.current_loop.current_a() * self.limits.torque_nm_per_a);
            }
            let sum = self.dictionary.get(at::TARGET_VELOCITY) + self.dictionary.get(at::VELOCITY_OFFSET);
            let target = sum as f64 * self.rad_per_count;
            let fastest = self.limits.speed_rad_per_s;
            self.limiting |= target.abs() > fastest;
            Actuation::Velocity(target.clamp(-fastest, fastest))
        } else {
            let sum = self.dictionary.get(at::TARGET_TORQUE) + self.dictionary.get(at::TORQUE_OFFSET);
            let permille = sum.clamp(i64::from(i16::MIN), i64::from(i16::MAX));
            self.dictionary.put(at::TORQUE_DEMAND, permille);
            let torque_nm = permille as f64 * self.dictionary.get(at::RATED_TORQUE) as f64 / 1e6;
            Actuation::Current(torque_nm / self.limits.torque_nm_per_a)
        };
    }

    /// Goes to a state without a stop of its own.
    pub(super) fn enter(&mut self, state: State) {
        self.pending = None;
        if self.state == State::Fault || state == State::OperationEnabled {
            self.dictionary.put(at::ERROR_CODE, 0);
        }
        self.state = state;
        self.actuation = Actuation::Idle;
        if state == State::OperationEnabled {
            self.velocity_loop.reset(0.0);
            self.follow();
        }
    }

    /// Out of operation by option 0 (at once) or 1 (slow down first); the state changes when the axis stands.
    fn leave_operation(&mut self, option: usize, state: State) {
        if matches!(self.actuation, Actuation::Stopping(..)) {
            return;
        }
        match self.dictionary.get(option) {
            0 => self.enter(state),
            _ => self.stop(1, After::Off(state)),
        }
    }

    /// Quick stop by 605Ah.
    fn quick_stop(&mut self) {
        let option = self.dictionary.get(at::QUICK_STOP);
        if option == 0 {
            return self.enter(State::SwitchOnDisabled);
        }
        self.pending = None;
        self.state = State::QuickStopActive;
        let after = if option >= 5 { After::Hold } else { After::Off(State::SwitchOnDisabled) };
        self.stop(if option >= 5 { option - 4 } else { option }, after);
    }

    /// Stops along the slow-down ramp (1), the quick stop ramp (2) or at the current limit (3).
    fn stop(&mut self, option: i64, after: After) {
        let deceleration = match option {
            1 => self.dictionary.get(at::SLOW_DOWN_DECELERATION) as f64 * self.rad_per_count,
            2 => self.dictionary.get(at::QUICK_STOP_DECELERATION) as f64 * self.rad_per_count,
            _ => f64::INFINITY,
        };
        self.velocity_loop.reset(0.0);
        let ramp = Ramp::new(self.velocity_rad_per_s, deceleration, self.step_s);
        self.actuation = Actuation::Stopping(ramp, after);
    }
}
