//! What reaches a drive by other ways than the bus: safe torque off, digital inputs, faults of its own parts.

use super::Drive;
use super::power::State;

/// Interlock input of CiA 402: 1 while the emergency stop chain is open.
pub(crate) const EMERGENCY_STOP: u32 = 1 << 3;
/// First input of the manufacturer: 1 while the enabling switch is held. After power-up somebody holds it until a fault says
/// otherwise.
pub(crate) const ENABLING_SWITCH: u32 = 1 << 16;

impl Drive {
    /// Safe torque off (IEC 61800-5-2, 4.2.3.2): no gate signal reaches the power stage, whatever the drive wants.
    ///
    /// The drive reads it back and takes the way of a local signal to "switch on disabled" (IEC 61800-7-201, transitions
    /// 7, 9, 10 and 12), which it cannot leave before the gates are free again. A fault stays a fault.
    pub(crate) fn block_gates(&mut self, blocked: bool) {
        self.gates_blocked = blocked;
        if blocked && self.state != State::Fault {
            let disabled =
                if self.state == State::FaultReactionActive { State::Fault } else { State::SwitchOnDisabled };
            self.enter(disabled);
        }
        self.schedule();
    }

    /// A digital input of 60FDh.
    pub(crate) fn set_input(&mut self, bit: u32, on: bool) {
        self.digital_inputs = if on { self.digital_inputs | bit } else { self.digital_inputs & !bit };
    }

    /// The drive finds something wrong with itself.
    pub(crate) fn find_fault(&mut self, code: u16) {
        self.fault(code);
        self.schedule();
    }

    /// Its control electronics begin anew: no torque, no fault; the settings stay.
    pub(crate) fn restart(&mut self) {
        self.deferred.clear();
        self.enter(State::SwitchOnDisabled);
        self.dictionary.put(super::at::ERROR_CODE, 0);
        self.last_controlword = 0;
        self.schedule();
    }

    /// From now on the power stage gives this current while it is on, A.
    pub(crate) fn stick(&mut self, current_a: f64) {
        self.stuck_current_a = Some(current_a);
    }

    /// How hot the heat sink is, °C.
    pub(crate) fn heat_sink_degc(&self) -> f64 {
        self.heat_sink.temperature_degc()
    }

    /// The heat sink is this hot now, °C.
    pub(crate) fn heat_to(&mut self, degc: f64) {
        self.heat_sink.set_temperature_degc(degc);
    }
}
