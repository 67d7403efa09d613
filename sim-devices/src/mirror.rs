//! The fast steering mirror unit at the far end of its command channels.
//!
//! Per axis: command (analog or serial, each with its delay) → servo at the rate of the steps → amplifier (range,
//! current into capacitance, lag) → hysteresis and creep of the stacks → second-order mechanism on its support →
//! strain gauge (noise, conditioner, quantisation) → servo.
//!
//! Frame: index 0 is azimuth, 1 elevation. An angle is the mechanical tilt of the mirror about that axis; a positive
//! one turns the line of sight of the camera behind it towards larger azimuth or elevation, by the angle over the
//! optical gain (3.5355 and 2.5). Zero is mid-stroke. Functions that take an axis panic for anything but 0 and 1.

mod actuator;
mod gcs;
mod lag;
mod mechanism;
mod orders;
mod serial;
mod servo;
#[cfg(test)]
mod tests;

use controllers::mirror::MirrorController;

pub use self::gcs::{GcsLine, GcsMirror};

use self::actuator::Actuator;
use self::lag::{Delay, Lag};
use self::mechanism::Mechanism;
use self::serial::SerialLine;
use crate::physics::noise::{Noise, SeedAddress};
use crate::physics::piezo::{Circuit, CircuitValues};
use crate::unit::MirrorSettings;

/// Range of the analog inputs AIX and AIY.
const ANALOG_LIMIT_V: f64 = 10.0;
/// Adding and subtracting it rounds to the nearest whole number, ties to even, for magnitudes below 2⁵¹.
const ROUNDER: f64 = 6_755_399_441_055_744.0;
/// Steps for which a value of the gauge noise holds; the axes take turns.
const NOISE_STEPS: u64 = 8;

/// One axis of the unit.
#[derive(Clone, Debug)]
struct Axis {
    law: MirrorController,
    actuator: Actuator,
    mechanism: Mechanism,
    travel_rad: f64,
    conditioner: Lag,
    noise: Noise,
    noise_rad: f64,
    sensed_rad: f64,
    demand_rad: f64,
    analog_v: f64,
    order_v: f64,
    /// What the order that came in this step has not acted for, mean of the step.
    missed_v: f64,
    digital_source: bool,
    /// As last ordered and as read back; a broken loop is open all the same.
    close_ordered: bool,
    closed: bool,
}

/// Both axes, their servo and their command channels.
#[derive(Clone, Debug)]
pub struct Mirror {
    settings: MirrorSettings,
    step_s: f64,
    counts_per_rad: f64,
    axes: [Axis; 2],
    analog_channel: Delay,
    serial_channel: Delay,
    loop_delay: Delay,
    line: SerialLine,
    selected: usize,
}

impl Mirror {
    /// At rest in mid-stroke, loop closed, following its analog inputs at 0 V; stepped every `step_s`.
    pub fn new(settings: &MirrorSettings, address: &SeedAddress, step_s: f64) -> Self {
        Self {
            axes: [0, 1].map(|axis| Axis::new(settings, address, axis, step_s)),
            analog_channel: Delay::new(settings.analog_delay_s, step_s),
            serial_channel: Delay::new(settings.serial_delay_s, step_s),
            loop_delay: Delay::new(settings.loop_delay_s, step_s),
            line: SerialLine::new(settings.serial_bit_rate_hz, step_s),
            selected: 0,
            counts_per_rad: 1.0 / settings.resolution_rad,
            settings: settings.clone(),
            step_s,
        }
    }

    /// Voltage at the analog input of an axis (AIX, AIY), from now on. Not a number counts as 0.
    pub fn command_analog_v(&mut self, axis: usize, volts: f64) {
        let volts = if volts.is_finite() { volts } else { 0.0 };
        self.axes[axis].analog_v = volts.clamp(-ANALOG_LIMIT_V, ANALOG_LIMIT_V);
    }

    /// A character arrives on the serial line.
    pub fn receive(&mut self, byte: u8) {
        self.line.receive(byte);
    }

    /// Takes the characters that the unit has sent by now; how many.
    pub fn take_reply(&mut self, into: &mut [u8]) -> usize {
        self.line.take_reply(into)
    }

    /// One step of the servo and the mechanism; `step` counts from the start of the point and addresses the noise.
    pub fn step(&mut self, step: u64) {
        if let Some(arrival) = self.line.step() {
            self.execute(arrival);
        }
        let command_rad = self.commands_rad();
        let mut demand_rad = [0.0; 2];
        for (axis, demand) in demand_rad.iter_mut().enumerate() {
            *demand = self.axes[axis].servo(command_rad[axis]);
        }
        let demand_rad = self.loop_delay.update(demand_rad);
        for (axis, demand) in self.axes.iter_mut().zip(demand_rad) {
            axis.travel_rad = axis.actuator.step(demand);
        }
        let coupling = self.settings.cross_coupling_ratio;
        let az_rad = self.axes[0].travel_rad;
        let el_rad = self.axes[1].travel_rad;
        self.axes[0].mechanism.step(az_rad + coupling * el_rad);
        self.axes[1].mechanism.step(el_rad + coupling * az_rad);
        if step.is_multiple_of(NOISE_STEPS / 2) {
            let turn = &mut self.axes[usize::from(!step.is_multiple_of(NOISE_STEPS))];
            turn.noise_rad = turn.noise.at(step / NOISE_STEPS);
        }
        for axis in &mut self.axes {
            axis.sense(
                self.settings.gauge_departure_ratio,
                self.settings.resolution_rad,
                self.counts_per_rad,
            );
        }
    }

    /// Commands as they reach the servo, rad.
    #[inline]
    fn commands_rad(&mut self) -> [f64; 2] {
        let order_v = [0, 1].map(|axis| self.axes[axis].order_of_step_v());
        let [az, el] = &self.axes;
        let scale = self.settings.scale_rad_per_v;
        let analog = self.analog_channel.update([scale[0] * az.analog_v, scale[1] * el.analog_v]);
        let order = self.serial_channel.update([scale[0] * order_v[0], scale[1] * order_v[1]]);
        let pick = |axis: &Axis, k: usize| if axis.digital_source { order[k] } else { analog[k] };
        [pick(az, 0), pick(el, 1)]
    }

    /// True tilt of the mirror at the end of the last step, in the frame of the structure that carries its support.
    pub fn angle_rad(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.axes[axis].mechanism.absolute_rad())
    }

    /// What the strain gauges say, digitised.
    pub fn sensed_rad(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.axes[axis].sensed_rad)
    }

    /// The strain gauge monitor outputs, at the scale of the commands.
    pub fn gauge_v(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.axes[axis].sensed_rad / self.settings.scale_rad_per_v[axis])
    }

    /// Voltage of the amplifiers about their bias.
    pub fn drive_v(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.axes[axis].actuator.voltage_rad() / self.settings.actuator_gain_rad_per_v)
    }

    /// Torque that the accelerating mirror exerts on its support, mean of the last step.
    pub fn reaction_nm(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.axes[axis].mechanism.reaction_nm())
    }

    /// Equivalent circuit at the terminals of an axis, with the bare mechanism (ζ 0.02, not the published 0.36).
    pub fn circuit(&self, axis: usize) -> Circuit {
        let settings = &self.settings;
        Circuit::new(&CircuitValues {
            capacitance_f: settings.capacitance_f,
            coupling_ratio: settings.coupling_ratio,
            loss_tangent_ratio: settings.loss_tangent_ratio,
            frequency_hz: settings.frequency_hz[axis],
            damping_ratio: settings.bare_damping_ratio,
            series_ohm: settings.series_resistance_ohm,
            leak_ohm: settings.leak_resistance_ohm,
        })
    }
}

impl Axis {
    fn new(settings: &MirrorSettings, address: &SeedAddress, axis: usize, step_s: f64) -> Self {
        let source = ["mirror.az.gauge", "mirror.el.gauge"][axis];
        Self {
            law: servo::law(settings, axis, Actuator::limit_rad(settings), step_s),
            actuator: Actuator::new(settings, axis, step_s),
            mechanism: Mechanism::new(settings, axis, step_s),
            travel_rad: 0.0,
            conditioner: Lag::new(settings.gauge_cutoff_hz, step_s),
            noise: Noise::new(address, source, settings.gauge_noise_rad),
            noise_rad: 0.0,
            sensed_rad: 0.0,
            demand_rad: 0.0,
            analog_v: 0.0,
            order_v: 0.0,
            missed_v: 0.0,
            digital_source: false,
            close_ordered: true,
            closed: settings.strain_gauge_loop_switch >= 0.5,
        }
    }

    /// An order that comes when this share of the step is over.
    fn take_order(&mut self, volts: f64, into_step: f64) {
        self.missed_v = into_step * (volts - self.order_v);
        self.order_v = volts;
    }

    /// The order, mean of the step: the clocks of the line and of the servo are not one, an order does not come between
    /// two steps.
    #[inline]
    fn order_of_step_v(&mut self) -> f64 {
        self.order_v - std::mem::take(&mut self.missed_v)
    }

    #[inline]
    fn servo(&mut self, command_rad: f64) -> f64 {
        self.demand_rad =
            if self.closed { self.law.update(command_rad, self.sensed_rad) } else { command_rad };
        self.demand_rad
    }

    #[inline]
    fn sense(&mut self, departure: f64, resolution_rad: f64, counts_per_rad: f64) {
        let strain_rad = departure * self.travel_rad + self.noise_rad;
        let gauge_rad = strain_rad + (1.0 - departure) * self.mechanism.relative_rad();
        let conditioned_rad = self.conditioner.ramp(gauge_rad);
        self.sensed_rad = resolution_rad * ((conditioned_rad * counts_per_rad + ROUNDER) - ROUNDER);
    }
}
