//! A drive at the far end of its wire: CiA 402 power state machine, CST and CSV, quick stop, faults, SDO server.
//!
//! Commands that arrive at an exchange act after the unit's command delay, controlwords included; what is sent is as
//! old as its sensor delay, statusword and supervision excepted. The current loop is of first order.
//!
//! Enforced in every mode: torque limit 6072h, current limit 6073h, speed limit 6080h (above it torque may only
//! brake), process-data watchdog 2F00h, heat sink and DC link supervision. Enforced in CSV only: soft limits 607Dh.
//! Not enforced in CST: soft limits (reported in bit 11 of the statusword and in 60FDh), following error (6065h, 6066h:
//! there is no position demand), any acceleration limit. Halt (bit 8 of the controlword) is ignored.

mod commissioning;
mod deferred;
mod dictionary;
mod elmo;
mod mapping;
mod motion;
mod power;
mod react;
mod sample;
pub(crate) mod wiring;

use crate::physics::current_loop::{CurrentLoop, Lag};
use crate::physics::delay::DelayLine;
use crate::physics::encoder::{Encoder, EncoderFault};
use crate::physics::noise::Noise;
use crate::physics::noise::SeedAddress;
use crate::physics::thermal::HeatSink;
use crate::unit::AxisSettings;
use commissioning::{Limits, commissioned, limits, steps};
use deferred::Deferred;
use dictionary::{Dictionary, abort, at};
pub(crate) use dictionary::{Pdo as Mappable, Width, object};
use drivers::wire::BusState;
use mapping::Layout;
pub(crate) use mapping::Mapping;
use motion::{Ramp, Span, Speedometer, VelocityLoop};
pub use power::State;

/// Period of heat sink and DC link supervision.
const SUPERVISION_S: f64 = 0.01;

/// What a drive believes of its DC link until it is told.
const NOMINAL_DC_LINK_V: f64 = 560.0;

/// Approach to a soft limit in CSV: velocity per distance, well inside the velocity loop's bandwidth.
const SOFT_LIMIT_GAIN_PER_S: f64 = 3.0;

/// Where the current comes from.
#[derive(Clone, Debug)]
enum Actuation {
    /// Power stage off.
    Idle,
    /// A current, A.
    Current(f64),
    /// A velocity, rad/s in encoder sense.
    Velocity(f64),
    /// A stop, and what comes after it.
    Stopping(Ramp, After),
}

/// What follows a stop.
#[derive(Clone, Copy, Debug, PartialEq)]
enum After {
    /// Torque off, and this state.
    Off(State),
    /// Stays at zero velocity with torque.
    Hold,
}

/// Types of drives that the simulator has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DriveType {
    /// The simulator's own: a mapping that can be written, and its watchdog and temperature as objects.
    #[default]
    Simulated,
    /// As an Elmo Gold: fixed PDOs with bytes of padding, whole degrees of temperature by SDO, no watchdog of its own.
    ElmoGold,
}

/// One drive.
#[derive(Clone, Debug)]
pub struct Drive {
    settings: AxisSettings,
    drive_type: DriveType,
    step_s: f64,
    encoder: Encoder,
    rad_per_count: f64,
    current_noise: Noise,
    encoder_noise: Noise,
    heat_sink: HeatSink,
    dictionary: Dictionary,
    outputs: Mapping,
    inputs: Mapping,
    output_layout: Layout,
    input_layout: Layout,
    limits: Limits,
    bus_state: BusState,
    state: State,
    /// A transition under way, and the step at which it is over.
    pending: Option<(State, u64)>,
    last_controlword: u16,
    deferred: Deferred,
    actuation: Actuation,
    speedometer: Speedometer,
    velocity_rad_per_s: f64,
    /// What is sent of the encoder: without it the last good position, and no velocity.
    last_good_counts: i64,
    sent_counts_per_s: i64,
    dc_link_v: f64,
    encoder_warns: bool,
    keeps_soft_limits: bool,
    /// Safe torque off acts.
    gates_blocked: bool,
    /// What is wired to its inputs, as in 60FDh.
    digital_inputs: u32,
    /// What a broken power stage gives while it is on.
    stuck_current_a: Option<f64>,
    velocity_loop: VelocityLoop,
    current_loop: CurrentLoop,
    /// Currents at the ends of the last steps, as far back as what is sent.
    currents_a: DelayLine<f64>,
    /// Age of what is sent, in steps.
    sensor_delay: usize,
    /// Some limit held the drive back since the last sample.
    limiting: bool,
    square_sum_a2: f64,
    squares_count: u32,
    fed_step: u64,
    supervision_step: u64,
    next_event_step: u64,
}

impl Drive {
    /// A drive with its control supply on and its power stage off, on an axis that stands at `angle_rad`.
    ///
    /// `name` addresses its noise, `serial` goes into its identity.
    pub fn new(
        name: &str,
        serial: u32,
        settings: &AxisSettings,
        address: &SeedAddress,
        angle_rad: f64,
        heat_sink_degc: f64,
        step_s: f64,
    ) -> Self {
        let encoder = Encoder::new(settings);
        let dictionary = commissioned(settings, &encoder, serial);
        let limits = limits(&dictionary, settings, &encoder, step_s);
        let sensor_delay = crate::physics::delay::steps(settings.sensor_delay_s, step_s);
        let command_delay = steps(settings.command_delay_s, step_s);
        let jitter = Noise::new(address, &format!("{name}.delay"), 1.0);
        let mut drive = Self {
            rad_per_count: std::f64::consts::TAU / encoder.counts_per_rev() as f64,
            current_noise: Noise::new(address, &format!("{name}.current"), settings.current_noise_a),
            encoder_noise: Noise::new(address, &format!("{name}.encoder"), settings.encoder_noise_rad),
            heat_sink: HeatSink::new(settings, heat_sink_degc, SUPERVISION_S),
            outputs: Mapping::outputs(),
            inputs: Mapping::inputs(),
            output_layout: Layout::default(),
            input_layout: Layout::default(),
            bus_state: BusState::PreOp,
            state: State::SwitchOnDisabled,
            pending: None,
            last_controlword: 0,
            deferred: Deferred::new(command_delay, settings.delay_jitter_s / step_s, jitter),
            actuation: Actuation::Idle,
            speedometer: Speedometer::new(settings.velocity_window_s, step_s, sensor_delay, angle_rad),
            velocity_loop: VelocityLoop::new(settings, step_s),
            velocity_rad_per_s: 0.0,
            last_good_counts: 0,
            sent_counts_per_s: 0,
            dc_link_v: NOMINAL_DC_LINK_V,
            encoder_warns: false,
            keeps_soft_limits: true,
            gates_blocked: false,
            digital_inputs: wiring::ENABLING_SWITCH,
            stuck_current_a: None,
            current_loop: CurrentLoop::new(settings.current_bandwidth_hz, step_s),
            currents_a: DelayLine::new(sensor_delay + 1, 0.0),
            sensor_delay,
            limiting: false,
            square_sum_a2: 0.0,
            squares_count: 0,
            fed_step: 0,
            supervision_step: steps(SUPERVISION_S, step_s),
            next_event_step: 0,
            settings: settings.clone(),
            drive_type: DriveType::default(),
            step_s,
            encoder,
            dictionary,
            limits,
        };
        drive.refresh(0, angle_rad);
        drive
    }

    /// Mean current of a world step that begins at this angle, A.
    #[inline]
    pub fn current_a(&mut self, step: u64, angle_rad: f64) -> f64 {
        if step >= self.next_event_step {
            self.serve_events(step);
        }
        let span = self.speedometer.observe(angle_rad);
        let turned_rad = self.encoder.sign() * (span.now_rad - span.before_rad);
        let mut velocity = turned_rad * self.speedometer.per_s();
        let wanted_a = match self.actuation {
            Actuation::Idle => {
                self.current_loop.switch_off();
                0.0
            }
            Actuation::Current(current_a) => current_a,
            Actuation::Velocity(_) | Actuation::Stopping(..) => {
                let (counts, per_s) = self.counted(step, span);
                velocity = per_s * self.rad_per_count;
                self.own_loop_a(counts, velocity)
            }
        };
        self.velocity_rad_per_s = velocity;
        let mut command_a = self.limited(wanted_a, velocity);
        if let Some(stuck_a) = self.stuck_current_a.filter(|_| self.state.has_torque()) {
            command_a = stuck_a;
        }
        let mean_a = self.current_loop.step(command_a);
        self.currents_a.push(self.current_loop.current_a());
        self.square_sum_a2 += mean_a * mean_a;
        self.squares_count += 1;
        mean_a
    }

    /// True motor current during the last step of the world.
    #[inline]
    pub(crate) fn current_course(&self) -> Lag {
        self.current_loop.lag()
    }

    /// What the encoder makes of a window that ends at a step: counts at its end, and counts per second.
    fn counted(&mut self, step: u64, span: Span) -> (i64, f64) {
        let first = step.saturating_sub(self.speedometer.steps());
        let before = self.encoder.unwrapped_counts(span.before_rad + self.encoder_noise.at(first));
        let now = self.encoder.unwrapped_counts(span.now_rad + self.encoder_noise.at(step));
        (now, (now - before) as f64 * self.speedometer.per_s())
    }

    /// Torque and speed limits; above the speed limit current may only brake.
    #[inline]
    fn limited(&mut self, wanted_a: f64, velocity_rad_per_s: f64) -> f64 {
        let mut current_a = wanted_a.clamp(-self.limits.current_a, self.limits.current_a);
        if velocity_rad_per_s.abs() > self.limits.speed_rad_per_s && current_a * velocity_rad_per_s > 0.0 {
            current_a = 0.0;
        }
        self.limiting |= current_a != wanted_a;
        current_a
    }

    /// One step of CSV or of a stop.
    fn own_loop_a(&mut self, counts: i64, velocity: f64) -> f64 {
        let (setpoint, acceleration) = match &mut self.actuation {
            Actuation::Velocity(target) => (*target, 0.0),
            Actuation::Stopping(ramp, after) => {
                let next = ramp.next(velocity, self.step_s);
                if let (true, After::Off(state)) = (ramp.is_over(), *after) {
                    self.enter(state);
                    return 0.0;
                }
                next
            }
            Actuation::Idle | Actuation::Current(_) => return 0.0,
        };
        let setpoint = if matches!(self.actuation, Actuation::Velocity(_)) {
            self.inside_soft_limits(setpoint, counts)
        } else {
            setpoint
        };
        let feed_forward_nm = acceleration * self.settings.inertia_kg_m2;
        let limit_nm = self.limits.current_a * self.limits.torque_nm_per_a;
        let torque_nm = self.velocity_loop.torque_nm(setpoint - velocity, feed_forward_nm, limit_nm);
        torque_nm / self.limits.torque_nm_per_a
    }

    /// The fastest velocity towards `target` from which the soft limit can still be kept.
    fn inside_soft_limits(&mut self, target: f64, counts: i64) -> f64 {
        let room = self.limits.soft.room(counts).filter(|_| self.keeps_soft_limits);
        let Some([below, above]) = room else { return target };
        let fastest = |room: i64| {
            let room_rad = room.max(0) as f64 * self.rad_per_count;
            (2.0 * self.limits.braking_rad_per_s2 * room_rad).sqrt().min(SOFT_LIMIT_GAIN_PER_S * room_rad)
        };
        let kept = target.clamp(-fastest(below), fastest(above));
        self.limiting |= kept != target;
        kept
    }

    /// Voltage of the DC link that it shares with the other drives.
    pub fn set_dc_link_v(&mut self, volts: f64) {
        self.dc_link_v = volts;
    }

    /// From now on the encoder has this fault, or none.
    pub fn inject_encoder_fault(&mut self, fault: Option<EncoderFault>) {
        self.encoder.inject(fault);
    }

    /// A drive that takes soft limits and does not keep them.
    pub fn ignore_soft_limits(&mut self) {
        self.keeps_soft_limits = false;
    }

    /// A drive that says it was made by somebody else than the simulator.
    pub fn claim_vendor(&mut self, vendor: u32) {
        self.dictionary.put(at::VENDOR, i64::from(vendor));
    }

    /// Power state.
    pub fn state(&self) -> State {
        self.state
    }

    /// State of its end of the bus.
    pub(crate) fn bus_state(&self) -> BusState {
        self.bus_state
    }

    /// A drive of another type, commissioned for the same motor.
    pub(crate) fn become_type(&mut self, drive_type: DriveType) {
        self.drive_type = drive_type;
        if drive_type == DriveType::ElmoGold {
            self.become_elmo_gold();
        }
    }

    /// Fixes the process data layout; bytes of outputs and inputs, or the abort code of the mapping fault.
    pub(crate) fn map(&mut self) -> Result<(usize, usize), u32> {
        self.output_layout = self.outputs.layout()?;
        self.input_layout = self.inputs.layout()?;
        Ok((self.output_layout.bytes, self.input_layout.bytes))
    }

    /// Answers an SDO upload.
    pub(crate) fn upload(&self, index: u16, sub: u8) -> Result<Vec<u8>, u32> {
        if let Some(answer) = self.vendor_upload(index, sub) {
            return answer;
        }
        match self.mapping_of(index) {
            Some(mapping) => mapping.upload(index, sub),
            None => self.dictionary.upload(index, sub),
        }
    }

    /// Answers an SDO download; true if the mapping changed.
    pub(crate) fn download(&mut self, index: u16, sub: u8, data: &[u8]) -> Result<bool, u32> {
        // What the maker of another type adds can only be read.
        if let Some(answer) = self.vendor_upload(index, sub) {
            return answer.and(Err(abort::READ_ONLY));
        }
        if self.mapping_of(index).is_some() {
            if self.bus_state != BusState::PreOp {
                return Err(abort::DEVICE_STATE);
            }
            let mapping = if self.outputs.owns(index) { &mut self.outputs } else { &mut self.inputs };
            return mapping.download(index, sub, data).map(|()| true);
        }
        self.dictionary.download(index, sub, data)?;
        self.dictionary.put(at::MODE_DISPLAY, self.dictionary.get(at::MODE));
        self.limits = limits(&self.dictionary, &self.settings, &self.encoder, self.step_s);
        self.schedule();
        Ok(false)
    }

    /// Error code (603Fh) and error register (1001h).
    pub(crate) fn error(&self) -> [u16; 2] {
        let code = self.dictionary.get(at::ERROR_CODE) as u16;
        [code, sample::error_register(code) as u16]
    }

    /// Indices of all objects in ascending order.
    pub(crate) fn indices(&self) -> Vec<u16> {
        let lists = self.outputs.indices().chain(self.inputs.indices());
        let mut indices: Vec<u16> = Dictionary::indices().chain(lists).collect();
        indices.sort_unstable();
        indices
    }

    /// Process data as they are mapped now: outputs, inputs.
    pub(crate) fn mappings(&self) -> [&Mapping; 2] {
        [&self.outputs, &self.inputs]
    }

    fn mapping_of(&self, index: u16) -> Option<&Mapping> {
        [&self.outputs, &self.inputs].into_iter().find(|mapping| mapping.owns(index))
    }
}

#[cfg(test)]
mod tests;
