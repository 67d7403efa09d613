//! The virtual bus: both drives, the world they act on, and the frame that passes them.

use std::time::Duration;

use crate::analog_card::AnalogChannels;
use crate::analyser::Analyser;
use crate::cia402::Drive;
use crate::faults::{Agenda, Sight};
use crate::operator::{Operator, PullSettings};
use crate::payload::Payload;
use crate::physics::encoder::EncoderFault;
use crate::physics::noise::{Noise, SeedAddress};
use crate::physics::supply::Supply;
use crate::scene::SceneTruth;
use crate::scope::Scope;
use crate::unit::UnitSettings;
use crate::world::{AXIS_NAMES, World};
use crate::world::{AxesTruth, StartState, WorldRecord};
use drivers::device::DeviceError;
use drivers::wire::{BusState, Exchange, ProcessImage, SdoAbort, Slot};

mod suffer;

const NAME: &str = "simulated bus";
/// What each station adds to the working counter of a read-write frame: 1 for reading, 2 for writing.
const COUNT_PER_STATION: u16 = 3;

/// Steps between two looks at the DC link: 5 kHz at 20 kHz, against time constants of milliseconds.
const SUPPLY_STEPS: u64 = 4;

/// Instruments on the bench.
#[derive(Debug)]
pub(crate) struct Instruments {
    pub(crate) analyser: Analyser,
    pub(crate) scope: Scope,
    pub(crate) channels: AnalogChannels,
}

/// World, drives, supply, payload, instruments and frame.
#[derive(Debug)]
pub(crate) struct VirtualBus {
    world: World,
    pub(crate) payload: Payload,
    pub(crate) instruments: Instruments,
    drives: [Drive; 2],
    /// Somebody who pulls at an axis.
    operator: Option<Operator>,
    supply: Supply,
    drawn_w: f64,
    /// With the sign of the motor's phases.
    torque_constants_nm_per_a: [f64; 2],
    /// Which axis each drive turns.
    axis_of_drive: [usize; 2],
    dropped_ratio: f64,
    dropping: Noise,
    exchanges_count: u64,
    step_rate_hz: f64,
    now: Duration,
    steps_count: u64,
    /// Slots and image length, once mapped.
    slots: Option<[Slot; 2]>,
    /// OP was asked for; stations reach it with the first outputs.
    op_requested: bool,
    /// Faults to come.
    agenda: Agenda,
    /// What each drive's encoder makes of the angle.
    sights: [Sight; 2],
    /// Until then no exchange is answered.
    silent_until: Duration,
    frames_to_lose: u32,
}

impl VirtualBus {
    pub(crate) fn new(
        unit: &UnitSettings,
        address: &SeedAddress,
        start: StartState,
        sync_rate_hz: f64,
    ) -> Self {
        let step_s = 1.0 / unit.step_rate_hz;
        let world = World::new(unit, start);
        let axis_of_drive = if unit.wiring.axes_swapped() { [1, 0] } else { [0, 1] };
        let drives = [0, 1].map(|k| {
            let (settings, serial) = ([&unit.az, &unit.el][k], [1001, 1002][k]);
            let angle_rad = world.axes[axis_of_drive[k]].angle_rad();
            let heat_sink_degc = start.heat_sink_degc;
            let mut drive =
                Drive::new(AXIS_NAMES[k], serial, settings, address, angle_rad, heat_sink_degc, step_s);
            if !unit.wiring.soft_limits_enforced()[k] {
                drive.ignore_soft_limits();
            }
            if let Some(vendor) = unit.wiring.claimed_vendor() {
                drive.claim_vendor(vendor);
            }
            drive.set_dc_link_v(unit.supply.open_voltage_v);
            drive
        });
        let payload = Payload::new(unit, address, world.frame(), sync_rate_hz);
        Self {
            instruments: Instruments {
                analyser: Analyser::new(&unit.instruments, address, &payload.mirror),
                scope: Scope::new(unit, address),
                channels: AnalogChannels::new(&unit.instruments, address, sync_rate_hz),
            },
            payload,
            world,
            drives,
            operator: unit.pull.map(Operator::new),
            supply: Supply::new(unit, SUPPLY_STEPS as f64 * step_s),
            drawn_w: 0.0,
            axis_of_drive,
            dropped_ratio: unit.wiring.dropped_cycles_ratio,
            dropping: Noise::new(address, "bus.dropped", 1.0),
            exchanges_count: 0,
            torque_constants_nm_per_a: [&unit.az, &unit.el]
                .map(|axis| axis.motor_sign_factor.signum() * axis.torque_constant_nm_per_a),
            step_rate_hz: unit.step_rate_hz,
            now: Duration::ZERO,
            steps_count: 0,
            slots: None,
            op_requested: false,
            agenda: Agenda::default(),
            sights: [Sight::default(); 2],
            silent_until: Duration::ZERO,
            frames_to_lose: 0,
        }
    }

    pub(crate) fn record(&self) -> WorldRecord {
        self.world.record()
    }

    /// See [`crate::rig::SimulatedRig::bring`].
    pub(crate) fn bring(&mut self, unit: &UnitSettings, address: &SeedAddress) {
        let now_s = self.now.as_secs_f64();
        let pull = unit.pull.map(|pull| PullSettings { begins_s: now_s + pull.begins_s, ..pull });
        self.operator = pull.map(Operator::new);
        self.payload.scene.bring(unit, address, self.now);
    }

    /// Where both axes really are, at the last instant.
    pub(crate) fn truth_of_axes(&self) -> AxesTruth {
        self.world.truth()
    }

    /// What the cameras look at as it really is, and the true angles of the mirror, at the last instant.
    pub(crate) fn truth(&mut self) -> (SceneTruth, [f64; 2]) {
        let (motion, mirror_rad) = (self.world.motion(), self.payload.mirror.angle_rad());
        (self.payload.scene.truth(self.now, &motion, mirror_rad), mirror_rad)
    }

    /// Brings the world to `now`, with the commands in force and the faults that are due.
    pub(crate) fn advance_to(&mut self, now: Duration) {
        self.keep_agenda(now);
        self.integrate_to(now);
        self.payload.look(self.now);
    }

    /// Integrates the world up to the last step at or before `now`.
    fn integrate_to(&mut self, now: Duration) {
        let until = (now.as_secs_f64() * self.step_rate_hz + 1e-6) as u64;
        for step in self.steps_count..until {
            self.step(step);
        }
        self.steps_count = self.steps_count.max(until);
        self.now = self.now.max(now);
    }

    #[inline]
    fn step(&mut self, step: u64) {
        let mut motor_nm = [0.0; 2];
        for (k, drive) in self.drives.iter_mut().enumerate() {
            let axis = self.axis_of_drive[k];
            let turning = &self.world.axes[axis];
            let current_a = drive.current_a(step, self.sights[k].of(turning.angle_rad()));
            let torque_nm = self.torque_constants_nm_per_a[k] * current_a;
            motor_nm[axis] = torque_nm;
            self.drawn_w += self.supply.drive_w(k, torque_nm, turning.velocity_rad_per_s(), current_a);
        }
        if self.instruments.scope.observes() {
            self.instruments.scope.observe(step, [0, 1].map(|k| self.drives[k].current_course()));
        }
        if let Some(operator) = &mut self.operator {
            let axis = operator.axis();
            let turning = &self.world.axes[axis];
            let now_s = step as f64 / self.step_rate_hz;
            motor_nm[axis] += operator.pull_nm(now_s, turning.angle_rad(), turning.velocity_rad_per_s());
        }
        self.world.step(motor_nm);
        self.payload.step(step, self.world.frame());
        if step % SUPPLY_STEPS == SUPPLY_STEPS - 1 {
            let volts = self.supply.step(self.drawn_w / SUPPLY_STEPS as f64);
            self.drawn_w = 0.0;
            self.drives.iter_mut().for_each(|drive| drive.set_dc_link_v(volts));
        }
    }

    /// Currents in the leads of the DC link over the last step of the supply: supply, shunt.
    pub(crate) fn dc_link_a(&self) -> [f64; 2] {
        let shunt_a = self.supply.shunt_w() / self.supply.bus_v().max(1.0);
        [self.supply.supply_a(), shunt_a]
    }

    /// Torque with which somebody pulls now.
    pub(crate) fn pulled_nm(&self) -> f64 {
        self.operator.as_ref().map_or(0.0, Operator::torque_nm)
    }

    /// Whether the frame of this exchange is lost on its way.
    fn loses_frame(&mut self) -> bool {
        self.exchanges_count += 1;
        if self.frames_to_lose > 0 {
            self.frames_to_lose -= 1;
            return true;
        }
        if self.now < self.silent_until {
            return true;
        }
        self.dropped_ratio > 0.0 && self.dropping.uniform_at(self.exchanges_count) < self.dropped_ratio
    }

    pub(crate) fn map(&mut self) -> Result<(ProcessImage, Vec<(u16, Slot)>), DeviceError> {
        let mut image = ProcessImage::default();
        let mut slots = [Slot::default(), Slot::default()];
        for (k, drive) in self.drives.iter_mut().enumerate() {
            let (outputs, inputs) = drive.map().map_err(|code| {
                failure(format!("station {}: invalid process data mapping, abort code {code:08X}h", k + 1))
            })?;
            let (first_output, first_input) = (image.outputs.len(), image.inputs.len());
            slots[k] = Slot {
                outputs: first_output..first_output + outputs,
                inputs: first_input..first_input + inputs,
            };
            image.outputs.resize(first_output + outputs, 0);
            image.inputs.resize(first_input + inputs, 0);
        }
        let listed = (1..).zip(slots.iter().cloned()).collect();
        self.slots = Some(slots);
        Ok((image, listed))
    }

    pub(crate) fn request(&mut self, state: BusState) {
        self.op_requested = state == BusState::Op && self.slots.is_some();
        let reached = match state {
            _ if self.slots.is_none() => BusState::PreOp,
            BusState::Op => BusState::SafeOp,
            lower => lower,
        };
        for drive in &mut self.drives {
            if state != BusState::Op || drive.bus_state() < BusState::SafeOp {
                drive.set_bus_state(reached);
            }
        }
    }

    pub(crate) fn state(&self) -> BusState {
        self.drives[0].bus_state().min(self.drives[1].bus_state())
    }

    pub(crate) fn exchange(
        &mut self,
        now: Duration,
        image: &mut ProcessImage,
    ) -> Result<Exchange, DeviceError> {
        if now < self.now {
            return Err(failure(format!("time went back from {:?} to {now:?}", self.now)));
        }
        let Some(slots) = self.slots.clone() else {
            return Err(failure("exchange before the bus was mapped".to_owned()));
        };
        let needed = (slots[1].outputs.end, slots[1].inputs.end);
        let found = (image.outputs.len(), image.inputs.len());
        if found != needed {
            return Err(failure(format!("process image of {found:?} bytes, expected {needed:?}")));
        }
        self.advance_to(now);
        self.payload.pulse(now);
        let mut working_counter = 0;
        if self.loses_frame() {
            return Ok(Exchange { working_counter, expected: 2 * COUNT_PER_STATION });
        }
        for (k, slot) in slots.into_iter().enumerate() {
            let drive = &mut self.drives[k];
            if drive.bus_state() >= BusState::SafeOp {
                let angle_rad = self.sights[k].of(self.world.axes[self.axis_of_drive[k]].angle_rad());
                drive.send(self.steps_count, angle_rad, &mut image.inputs[slot.inputs]);
                working_counter += COUNT_PER_STATION;
                if self.op_requested {
                    drive.set_bus_state(BusState::Op);
                }
                drive.receive(self.steps_count, &image.outputs[slot.outputs]);
            }
        }
        self.op_requested = false;
        Ok(Exchange { working_counter, expected: 2 * COUNT_PER_STATION })
    }

    /// From now on the encoder of a drive suffers this, or nothing.
    pub(crate) fn suffer(&mut self, drive: usize, fault: Option<EncoderFault>) {
        self.drives[drive].suffer(fault);
    }

    pub(crate) fn upload(&self, station: u16, index: u16, sub: u8) -> Result<Vec<u8>, SdoAbort> {
        let drive = usize::from(station).checked_sub(1).and_then(|k| self.drives.get(k));
        drive.ok_or(NO_ANSWER)?.upload(index, sub).map_err(SdoAbort)
    }

    pub(crate) fn download(
        &mut self,
        station: u16,
        index: u16,
        sub: u8,
        data: &[u8],
    ) -> Result<(), SdoAbort> {
        let drive = usize::from(station).checked_sub(1).and_then(|k| self.drives.get_mut(k));
        let remapped = drive.ok_or(NO_ANSWER)?.download(index, sub, data).map_err(SdoAbort)?;
        if remapped {
            self.slots = None;
        }
        Ok(())
    }

    pub(crate) const fn name() -> &'static str {
        NAME
    }
}

/// SDO protocol timed out: nobody at this address.
const NO_ANSWER: SdoAbort = SdoAbort(0x0504_0000);

fn failure(reason: String) -> DeviceError {
    DeviceError::Bus { device: NAME.to_owned(), reason }
}

#[cfg(test)]
mod tests;
