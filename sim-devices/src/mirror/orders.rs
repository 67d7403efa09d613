//! Serial orders: what the unit does and answers.

use drivers::mirror::protocol::{
    ACKNOWLEDGE, BIT_RATE_CLOCK_HZ, Command, LONGEST_REPLY, ParameterSet, volts_to_word,
};

use super::Mirror;
use super::serial::Arrival;

/// Time to write an order into the memory of the unit; the manual only calls it slow.
const STORE_TIME_S: f64 = 0.02;
/// Firmware 1.00.
const FIRMWARE: i32 = 100;
/// Serial numbers of the two channels, year and running number.
const SERIAL_NUMBERS: [i32; 2] = [15_001, 15_002];
/// `filter` of the parameter set: second-order notch at the first frequency.
const SECOND_ORDER_NOTCH: i32 = 2;

impl Mirror {
    /// Carries out a command and starts its reply.
    pub(super) fn execute(&mut self, Arrival { command, into_step }: Arrival) {
        let selected = self.selected;
        let mut words = [0; LONGEST_REPLY];
        let mut length = 0;
        let mut busy_steps = 0;
        match command {
            Command::SelectAxis(axis) => self.selected = axis,
            Command::CloseLoop(closed) => self.close_loop(selected, closed),
            Command::DigitalSource(digital) => {
                self.axes[selected].digital_source = digital && self.settings.analog_only_switch < 0.5;
            }
            Command::Order(volts) => self.axes[selected].take_order(volts, into_step),
            Command::StoredOrder(volts) => {
                self.axes[selected].take_order(volts, into_step);
                busy_steps = (STORE_TIME_S / self.step_s) as u32;
            }
            Command::Feedback(axis) => {
                length = put_words(&mut words, &[volts_to_word(self.gauge_v()[axis])]);
            }
            Command::Parameters(axis) => {
                length = put_words(&mut words, &self.parameter_set(axis).to_words());
            }
            Command::BitRate(register) => {
                self.line.set_bit_rate(BIT_RATE_CLOCK_HZ / (f64::from(register) + 1.0), self.step_s);
            }
        }
        words[length] = ACKNOWLEDGE;
        self.line.answer(&words[..=length], busy_steps);
    }

    /// Closes the loop without a bump, from the actuator demand as it is; a broken one stays open.
    pub(super) fn close_loop(&mut self, axis: usize, closed: bool) {
        let works = self.settings.strain_gauge_loop_switch >= 0.5;
        let axis = &mut self.axes[axis];
        if closed && works && !axis.closed {
            axis.law.reset(axis.demand_rad);
        }
        axis.close_ordered = closed;
        axis.closed = closed && works;
    }

    fn parameter_set(&self, axis: usize) -> ParameterSet {
        let settings = &self.settings;
        let state = &self.axes[axis];
        let limit_v = settings.stroke_rad[axis] / settings.scale_rad_per_v[axis];
        let notch = settings.notch_switch >= 0.5;
        ParameterSet {
            digital_source: state.digital_source,
            order_v: state.order_v,
            closed_loop: state.close_ordered,
            proportional_gain: settings.proportional_gain_ratio,
            integral_gain: settings.integral_gain_per_s,
            // The set has no word for the double integral, and this unit no differential part.
            differential_gain: 0.0,
            filter: if notch { SECOND_ORDER_NOTCH } else { 0 },
            filter_hz: [settings.notch_frequency_hz[axis].round() as i32, 0],
            limits_v: [limit_v, -limit_v],
            sensor_gain: 1.0,
            firmware: FIRMWARE,
            serial_number: SERIAL_NUMBERS[axis],
        }
    }
}

/// Big-endian; how many bytes.
fn put_words(into: &mut [u8], words: &[i32]) -> usize {
    for (place, word) in into.chunks_exact_mut(4).zip(words) {
        place.copy_from_slice(&word.to_be_bytes());
    }
    4 * words.len()
}
