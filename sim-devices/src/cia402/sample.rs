//! The process data of one exchange: inputs sampled, outputs taken.

use super::dictionary::at;
use super::power::State;
use super::{Actuation, After, Drive};
use crate::physics::thermal::HeatSink;
use drivers::wire::BusState;

const VOLTAGE_ENABLED: u16 = 1 << 4;
const WARNING: u16 = 1 << 7;
const REMOTE: u16 = 1 << 9;
const TARGET_REACHED: u16 = 1 << 10;
const INTERNAL_LIMIT: u16 = 1 << 11;
const FOLLOWS_COMMAND: u16 = 1 << 12;

impl Drive {
    /// Samples the axis at a step and writes the inputs in the mapped layout.
    pub(crate) fn send(&mut self, step: u64, angle_rad: f64, inputs: &mut [u8]) {
        if step >= self.next_event_step {
            self.serve_events(step);
        }
        self.refresh(step, angle_rad);
        for place in &self.input_layout.places {
            let value = self.dictionary.get(place.slot);
            place.width.encode(value, &mut inputs[place.offset..]);
        }
    }

    /// Takes the outputs of an exchange; they act after the command delay. Ignored unless in OP.
    pub(crate) fn receive(&mut self, step: u64, outputs: &[u8]) {
        if self.bus_state != BusState::Op {
            return;
        }
        self.fed_step = step;
        self.deferred.push(step, outputs);
        self.act_on_outputs(step);
        self.schedule();
    }

    /// Obeys all outputs that are due.
    pub(super) fn act_on_outputs(&mut self, step: u64) {
        while let Some(outputs) = self.deferred.pop(step) {
            self.act_on(step, &outputs);
            self.deferred.recycle(outputs);
        }
    }

    fn act_on(&mut self, step: u64, outputs: &[u8]) {
        for place in &self.output_layout.places {
            let bytes = &outputs[place.offset..place.offset + place.width.bytes()];
            let value = place.width.decode(bytes);
            // A mode that the drive lacks is not taken; the mode display goes on showing the one in force.
            if super::dictionary::OBJECTS[place.slot].check(value).is_ok() {
                self.dictionary.put(place.slot, value);
            }
        }
        self.obey(step);
    }

    /// Brings the actual values of the dictionary to this step.
    pub(super) fn refresh(&mut self, step: u64, angle_rad: f64) {
        if self.read_encoder(angle_rad) {
            let sampled = step.saturating_sub(self.sensor_delay as u64);
            let (counts, velocity) = self.counted(sampled, self.speedometer.sent(angle_rad));
            (self.last_good_counts, self.sent_counts_per_s) = (counts, velocity.round_ties_even() as i64);
        } else {
            self.sent_counts_per_s = 0;
        }
        let counts = self.last_good_counts;
        let sent_counts = self.encoder.wrapped(counts);
        let current_a = self.currents_a.ago(self.sensor_delay);
        let measured_a = current_a + self.current_noise.at(step);
        let rated_a = self.dictionary.get(at::RATED_CURRENT) as f64 / 1e3;
        let permille = (measured_a / rated_a * 1e3).round_ties_even() as i64;
        let heat_sink_degc = HeatSink::temperature_degc(&self.heat_sink);
        let error_code = self.dictionary.get(at::ERROR_CODE);
        let room = self.limits.soft.room(counts).filter(|_| self.keeps_soft_limits);
        let outside = room.map_or([false, false], |room| room.map(|counts| counts < 0));
        let actuals = [
            (at::POSITION, sent_counts),
            (at::POSITION_INTERNAL, sent_counts),
            (at::VELOCITY, self.sent_counts_per_s),
            (at::TORQUE, permille),
            (at::CURRENT, permille),
            (at::DC_LINK, (self.dc_link_v * 1e3).round_ties_even() as i64),
            (at::HEAT_SINK, (heat_sink_degc * 10.0).round_ties_even() as i64),
            (at::STATUSWORD, i64::from(self.statusword(outside != [false, false]))),
            (at::ERROR_REGISTER, error_register(error_code as u16)),
            (
                at::DIGITAL_INPUTS,
                i64::from(outside[0]) | i64::from(outside[1]) << 1 | i64::from(self.digital_inputs),
            ),
        ];
        actuals.into_iter().for_each(|(slot, value)| self.dictionary.put(slot, value));
        self.limiting = false;
    }

    fn statusword(&self, outside_soft_limits: bool) -> u16 {
        let flag = |condition: bool, bit: u16| if condition { bit } else { 0 };
        let settings = &self.settings;
        let stopped = matches!(&self.actuation, Actuation::Stopping(ramp, After::Hold) if ramp.is_over());
        let following = matches!(self.actuation, Actuation::Current(_) | Actuation::Velocity(_));
        self.state.pattern()
            | flag(self.dc_link_v >= settings.under_voltage_v, VOLTAGE_ENABLED)
            | flag(self.heat_sink.temperature_degc() >= settings.heat_sink_warning_degc, WARNING)
            | flag(self.encoder_warns, WARNING)
            | flag(self.bus_state == BusState::Op, REMOTE)
            | flag(stopped, TARGET_REACHED)
            | flag(self.limiting || outside_soft_limits, INTERNAL_LIMIT)
            | flag(following && self.state == State::OperationEnabled, FOLLOWS_COMMAND)
    }
}

/// Error register 1001h: generic, and the class of the error code.
pub(super) fn error_register(code: u16) -> i64 {
    match code >> 12 {
        0 => 0,
        2 => 1 | 1 << 1,
        3 => 1 | 1 << 2,
        4 => 1 | 1 << 3,
        7 if code == super::react::COMMUNICATION => 1 | 1 << 4,
        _ => 1,
    }
}
