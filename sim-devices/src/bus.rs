//! The virtual bus: drives, the plant that they act on, and the frame that passes them.
//!
//! What is moved (a director, a rotary table) is a [`Plant`]. Process image, states, SDO, lost frames and faults are the
//! same for every plant.

use std::time::Duration;

use crate::faults::FaultSchedule;
use crate::payload::Imu;
use crate::physics::encoder::EncoderFault;
use crate::physics::noise::SeedAddress;
use drivers::device::DeviceError;
use drivers::wire::{BusState, Exchange, ProcessImage, SdoAbort, Slot};

#[cfg(test)]
pub(crate) mod at_once;
mod befall;
mod dc_link;
mod frames;
mod station;
mod sync0;
mod terminal;
mod wired;

pub(crate) use dc_link::DcLink;
use frames::LostFrames;
pub(crate) use station::Station;
use sync0::Sync0;
use terminal::Terminal;

const NAME: &str = "simulated bus";
/// What each station adds to the working counter of a read-write frame: 1 for reading, 2 for writing.
const COUNT_PER_STATION: u16 = 3;

/// What the drives of a bus move, and what feeds them.
pub(crate) trait Plant {
    /// The drives, first station first.
    type Stations: AsRef<[Station]> + AsMut<[Station]>;

    /// One step of the world with the commands in force.
    fn step(&mut self, step: u64, stations: &mut Self::Stations);

    /// True angle of the shaft that a drive turns.
    fn shaft_rad(&self, drive: usize) -> f64;

    /// The world has been brought to `now`, with no exchange yet.
    fn reach(&mut self, _now: Duration) {}

    /// An exchange in this process passes at `now`.
    fn pulse(&mut self, _now: Duration) {}

    /// The trigger input of the inertial unit gets a pulse at `now`: from SYNC0, or from a frame on a wire.
    fn trigger(&mut self, _now: Duration) {}

    /// The mains are gone.
    fn lose_mains(&mut self);

    /// The inertial unit; `None` where there is none.
    fn imu(&mut self) -> Option<&mut Imu> {
        None
    }

    /// An analog output of the bench takes a voltage; false where there is no such output.
    fn write_v(&mut self, _now: Duration, _output: usize, _volts: f64) -> bool {
        false
    }

    /// Voltage at an analog input of the bench; `None` where there is no such input.
    fn read_v(&mut self, _now: Duration, _input: usize) -> Option<f64> {
        None
    }
}

/// Plant, drives and frame.
pub(crate) struct VirtualBus<P: Plant> {
    pub(crate) plant: P,
    stations: P::Stations,
    step_rate_hz: f64,
    now: Duration,
    steps_count: u64,
    /// Every station has its slot.
    mapped: bool,
    /// OP was asked for; stations reach it with the first outputs.
    op_requested: bool,
    lost_frames: LostFrames,
    /// Pulses that the drives follow; without them a drive samples and acts when the frame passes.
    sync0: Option<Sync0>,
    /// Behind the drives; `None` where the analog card is no terminal.
    terminal: Option<Terminal>,
    /// Faults to come.
    schedule: FaultSchedule,
    /// The emergency stop chain is open.
    emergency_stop: bool,
}

/// How often the world steps, and how many frames its bus loses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BusSettings {
    pub(crate) step_rate_hz: f64,
    pub(crate) dropped_cycles_ratio: f64,
}

impl<P: Plant> VirtualBus<P> {
    pub(crate) fn new(plant: P, stations: P::Stations, settings: BusSettings, address: &SeedAddress) -> Self {
        Self {
            plant,
            stations,
            step_rate_hz: settings.step_rate_hz,
            now: Duration::ZERO,
            steps_count: 0,
            mapped: false,
            op_requested: false,
            lost_frames: LostFrames::new(settings.dropped_cycles_ratio, address),
            sync0: None,
            terminal: None,
            schedule: FaultSchedule::default(),
            emergency_stop: false,
        }
    }

    /// The last instant that anybody looked at.
    pub(crate) fn now(&self) -> Duration {
        self.now
    }

    /// Whether the emergency stop chain is open.
    pub(crate) fn emergency_stop_is_pressed(&self) -> bool {
        self.emergency_stop
    }

    /// Brings the world to `now`, with the commands in force and the faults that are due.
    pub(crate) fn advance_to(&mut self, now: Duration) {
        self.keep_schedule(now);
        self.integrate_to(now);
        self.plant.reach(self.now);
    }

    /// Integrates the world up to the last step at or before `now`, through all pulses on the way.
    fn integrate_to(&mut self, now: Duration) {
        while let Some(pulse) = self.sync0.as_mut().and_then(|sync0| sync0.next_by(now)) {
            self.step_to(pulse);
            self.plant.trigger(pulse);
            self.give_sync0();
            self.pulse_terminal();
        }
        self.step_to(now);
    }

    fn step_to(&mut self, now: Duration) {
        let until = (now.as_secs_f64() * self.step_rate_hz + 1e-6) as u64;
        for step in self.steps_count..until {
            self.plant.step(step, &mut self.stations);
        }
        self.steps_count = self.steps_count.max(until);
        self.now = self.now.max(now);
    }

    /// Number of drives.
    pub(crate) fn stations_count(&self) -> usize {
        self.stations.as_ref().len()
    }

    pub(crate) fn map(&mut self) -> Result<(ProcessImage, Vec<(u16, Slot)>), DeviceError> {
        let mut image = ProcessImage::default();
        for (address, station) in (1..).zip(self.stations.as_mut()) {
            station.map(&mut image).map_err(|code| {
                failure(format!("station {address}: invalid process data mapping, abort code {code:08X}h"))
            })?;
        }
        self.mapped = true;
        if let Some(sync0) = &mut self.sync0 {
            sync0.lay_out(&image);
        }
        let slots = self.stations.as_ref().iter().map(|station| station.slot.clone());
        Ok((image, (1..).zip(slots).collect()))
    }

    pub(crate) fn request(&mut self, state: BusState) {
        self.op_requested = state == BusState::Op && self.mapped;
        let reached = match state {
            _ if !self.mapped => BusState::PreOp,
            BusState::Op => BusState::SafeOp,
            lower => lower,
        };
        for station in self.stations.as_mut() {
            if state != BusState::Op || station.drive.bus_state() < BusState::SafeOp {
                station.drive.set_bus_state(reached);
                if reached < BusState::SafeOp {
                    station.drive.leave_safe_op();
                }
            }
        }
        if reached == BusState::SafeOp {
            // The first frame must find inputs, even before the first pulse.
            self.give_sync0();
        }
    }

    /// State of the station that is the least far.
    pub(crate) fn state(&self) -> BusState {
        let states = self.stations.as_ref().iter().map(|station| station.drive.bus_state());
        states.min().unwrap_or(BusState::PreOp)
    }

    pub(crate) fn exchange(
        &mut self,
        now: Duration,
        image: &mut ProcessImage,
    ) -> Result<Exchange, DeviceError> {
        if now < self.now {
            return Err(failure(format!("time went back from {:?} to {now:?}", self.now)));
        }
        if !self.mapped {
            return Err(failure("exchange before the bus was mapped".to_owned()));
        }
        let last = self.stations.as_ref().last();
        let needed = last.map_or((0, 0), |last| (last.slot.outputs.end, last.slot.inputs.end));
        let found = (image.outputs.len(), image.inputs.len());
        if found != needed {
            return Err(failure(format!("process image of {found:?} bytes, expected {needed:?}")));
        }
        self.advance_to(now);
        if self.sync0.is_none() {
            self.plant.pulse(now);
        }
        let expected = self.stations.as_ref().iter().map(|_| COUNT_PER_STATION).sum();
        let mut working_counter = 0;
        if self.lost_frames.takes_next(self.now) {
            return Ok(Exchange { working_counter, expected });
        }
        self.pass_terminal();
        if let Some(stations_count) = self.pass_between_pulses(image) {
            self.op_requested = false;
            return Ok(Exchange { working_counter: stations_count * COUNT_PER_STATION, expected });
        }
        for (k, station) in self.stations.as_mut().iter_mut().enumerate() {
            if station.drive.bus_state() >= BusState::SafeOp {
                station.exchange(self.steps_count, self.plant.shaft_rad(k), self.op_requested, image);
                working_counter += COUNT_PER_STATION;
            }
        }
        self.op_requested = false;
        Ok(Exchange { working_counter, expected })
    }

    /// From now on the encoder of a drive has this fault, or none.
    pub(crate) fn inject_encoder_fault(&mut self, drive: usize, fault: Option<EncoderFault>) {
        self.stations.as_mut()[drive].drive.inject_encoder_fault(fault);
    }

    pub(crate) fn upload(&self, station: u16, index: u16, sub: u8) -> Result<Vec<u8>, SdoAbort> {
        let found = usize::from(station).checked_sub(1).and_then(|k| self.stations.as_ref().get(k));
        found.ok_or(NO_ANSWER)?.drive.upload(index, sub).map_err(SdoAbort)
    }

    pub(crate) fn download(
        &mut self,
        station: u16,
        index: u16,
        sub: u8,
        data: &[u8],
    ) -> Result<(), SdoAbort> {
        let found = usize::from(station).checked_sub(1).and_then(|k| self.stations.as_mut().get_mut(k));
        let remapped = found.ok_or(NO_ANSWER)?.drive.download(index, sub, data).map_err(SdoAbort)?;
        if remapped {
            self.mapped = false;
        }
        Ok(())
    }
}

/// Name of the bus in messages and reports.
pub(crate) const fn name() -> &'static str {
    NAME
}

/// SDO protocol timed out: nobody at this address.
const NO_ANSWER: SdoAbort = SdoAbort(0x0504_0000);

pub(crate) fn failure(reason: String) -> DeviceError {
    DeviceError::Bus { device: NAME.to_owned(), reason }
}

#[cfg(test)]
mod tests;
