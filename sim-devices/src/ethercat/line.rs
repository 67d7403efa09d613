//! The line: SubDevices in the order in which a frame passes them, and what happens to a frame on its way.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use super::application::Application;
use super::command;
use super::digital::{self, DigitalEnd, WiredInputs};
use super::drive::{self, DriveEnd, WiredDrive};
use super::esc::{ClockError, registers};
use super::faults::{FrameFaults, LineFault};
use super::frame::{self, Rejection};
use super::subdevice::SubDevice;
use super::terminal::{self, TerminalEnd, WiredTerminal};
use crate::bus::{Plant, VirtualBus};

/// From one SubDevice to the next, ns (as measured on drives with two MII ports).
const HOP_NS: u32 = 300;

/// What the line is made of beside the drives of the bus.
#[derive(Clone, Debug, Default)]
pub(crate) struct LineSettings {
    /// Errors of the clocks of the drives, first station first; a drive that is not named has a perfect one.
    pub(crate) clocks: Vec<ClockError>,
    /// What follows the drives.
    pub(crate) terminals: Terminals,
}

/// The terminals behind the drives, in this order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Terminals {
    /// Ten analog inputs and four analog outputs of ±10 V.
    pub analog: bool,
    /// Eight digital inputs; input 0 is on while the emergency stop chain is closed.
    pub digital: bool,
}

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passage {
    /// How many answers there are: none for a frame that is lost.
    pub answers: u8,
    /// Length of the answer.
    pub bytes: usize,
    /// How long after the frame the answer comes.
    pub after: Duration,
}

const LOST: Passage = Passage { answers: 0, bytes: 0, after: Duration::ZERO };

/// A line of SubDevices at the far end of an Ethernet wire.
pub trait EtherCatLine {
    /// A frame passes all SubDevices and becomes its own answer.
    fn pass(&mut self, now: Duration, frame: &mut [u8]) -> Passage;

    /// Time passes without a frame: watchdogs act, the world moves on.
    fn advance(&mut self, now: Duration);

    /// Something goes wrong from now on.
    ///
    /// # Errors
    /// When there is no such device.
    fn inject(&mut self, now: Duration, fault: LineFault) -> Result<(), String>;

    /// Names of the SubDevices, the first one of the line first.
    fn names(&self) -> Vec<String>;

    /// A device has an alias from now on; 0 is none.
    ///
    /// # Errors
    /// When there is no such device.
    fn set_alias(&mut self, device: usize, alias: u16) -> Result<(), String>;
}

/// What stands behind a SubDevice.
enum End {
    Drive(DriveEnd, usize),
    Terminal(TerminalEnd),
    Inputs(DigitalEnd),
}

struct Place {
    name: String,
    device: SubDevice,
    end: End,
    /// The cable in front of it is broken.
    is_unplugged: bool,
}

/// SubDevices in front of the drives of a bus.
pub(crate) struct Line<P: Plant> {
    bus: Rc<RefCell<VirtualBus<P>>>,
    places: Vec<Place>,
    /// How many of them a frame reaches: up to the first broken cable.
    present: usize,
    faults: FrameFaults,
}

impl<P: Plant> Line<P> {
    /// One SubDevice for every drive of a bus, and the terminals behind them.
    pub(crate) fn new(bus: Rc<RefCell<VirtualBus<P>>>, settings: &LineSettings) -> Self {
        let count = bus.borrow().stations_count();
        let mut places = Vec::new();
        for k in 0..count {
            let description = drive::description(bus.borrow().drive(k));
            let error = settings.clocks.get(k).copied().unwrap_or_default();
            let device = SubDevice::new(&description, error);
            let end = End::Drive(DriveEnd::new(), k);
            places.push(Place { name: description.name, device, end, is_unplugged: false });
        }
        let Terminals { analog, digital } = settings.terminals;
        let analog = analog.then(|| (terminal::description(1), End::Terminal(TerminalEnd::new())));
        let digital = digital.then(|| (digital::description(2), End::Inputs(DigitalEnd::new())));
        for (description, end) in analog.into_iter().chain(digital) {
            let device = SubDevice::new(&description, ClockError::default());
            places.push(Place { name: description.name, device, end, is_unplugged: false });
        }
        let present = places.len();
        let mut line = Self { bus, places, present, faults: FrameFaults::default() };
        line.look_for_links();
        line
    }

    /// The cable in front of a SubDevice breaks or is mended. The one before it counts the lost link.
    fn plug(&mut self, device: usize, is_gone: bool) {
        let is_new = is_gone && !self.places[device].is_unplugged;
        self.places[device].is_unplugged = is_gone;
        if is_new && let Some(before) = device.checked_sub(1) {
            const AT_PORT_1: u16 = registers::LOST_LINKS + 1;
            let esc = &mut self.places[before].device.esc;
            let count = esc.u8(AT_PORT_1).saturating_add(1);
            esc.put_u8(AT_PORT_1, count);
        }
        self.look_for_links();
    }

    /// Finds out how far a frame comes.
    fn look_for_links(&mut self) {
        /// Links at ports 0 and 1, their loops open, ports 2 and 3 closed, PDI operational.
        const BETWEEN: u16 = 0x5A31;
        /// Nothing behind port 1.
        const LAST: u16 = 0x5611;
        let reached = self.places.iter().take_while(|place| !place.is_unplugged);
        self.present = reached.count();
        for (k, place) in self.places.iter_mut().take(self.present).enumerate() {
            let behind = (self.present - 1 - k) as u32;
            place.device.esc.behind_ns = 2 * HOP_NS * behind;
            place.device.esc.set_links(if behind > 0 { BETWEEN } else { LAST });
        }
    }

    /// Gives the pulses of SYNC0 that are due. The trigger cable of the inertial unit leads to the first SubDevice on which SYNC0 is
    /// active; false where there is none.
    fn give_pulses(&mut self, now: Duration) -> bool {
        let with_cable = self.places.iter().position(|place| place.device.follows_sync0());
        let mut place = 0;
        self.for_each(self.places.len(), |device, application| {
            device.give_pulse(application, now, with_cable == Some(place));
            place += 1;
        });
        with_cable.is_some()
    }

    /// Does something with every SubDevice and its application.
    fn for_each(&mut self, present: usize, mut act: impl FnMut(&mut SubDevice, &mut dyn Application)) {
        let mut bus = self.bus.borrow_mut();
        for place in self.places.iter_mut().take(present) {
            match &mut place.end {
                End::Drive(end, k) => {
                    act(&mut place.device, &mut WiredDrive { bus: &mut *bus, end, k: *k });
                }
                End::Terminal(end) => act(&mut place.device, &mut WiredTerminal { bus: &mut *bus, end }),
                End::Inputs(end) => act(&mut place.device, &mut WiredInputs { bus: &mut *bus, end }),
            }
        }
    }

    fn with_device(
        &mut self,
        wanted: usize,
        mut act: impl FnMut(&mut SubDevice, &mut dyn Application),
    ) -> Result<(), String> {
        let count = self.places.len();
        if wanted >= count {
            return Err(format!("no SubDevice {wanted}: expected 0 to {}", count.saturating_sub(1)));
        }
        let mut k = 0;
        self.for_each(count, |device, application| {
            if k == wanted {
                act(device, application);
            }
            k += 1;
        });
        Ok(())
    }

    /// The frame goes out and comes back.
    fn process(&mut self, now: Duration, frame: &mut [u8], counter_by: i16) -> Result<(), Rejection> {
        for (k, place) in self.places.iter_mut().take(self.present).enumerate() {
            let at = now.saturating_add(Duration::from_nanos(u64::from(HOP_NS) * k as u64));
            frame::for_each_datagram(frame, |datagram| command::pass(&mut place.device.esc, datagram, at))?;
        }
        if counter_by != 0 {
            frame::for_each_datagram(frame, |datagram| datagram.count(counter_by as u16))?;
        }
        frame::mark_as_answer(frame);
        Ok(())
    }
}

impl<P: Plant> EtherCatLine for Line<P> {
    fn pass(&mut self, now: Duration, frame: &mut [u8]) -> Passage {
        let count = self.places.len();
        let has_sync0 = self.give_pulses(now);
        if !has_sync0 && frame::has_process_data(frame) {
            self.bus.borrow_mut().trigger(now);
        }
        let is_lost = !self.bus.borrow_mut().frame_arrives(now);
        let fate = self.faults.next();
        if is_lost || fate.is_dropped || self.present == 0 {
            self.advance(now);
            return LOST;
        }
        self.for_each(count, |device, application| device.advance(application, now));
        match self.process(now, frame, fate.counter_by) {
            Ok(()) => {}
            Err(Rejection::Foreign) => return LOST,
            Err(Rejection::Malformed) => {
                let esc = &mut self.places[0].device.esc;
                let errors = esc.u8(registers::PROCESSING_ERRORS).saturating_add(1);
                esc.put_u8(registers::PROCESSING_ERRORS, errors);
                return LOST;
            }
        }
        self.for_each(count, |device, application| device.serve(application, now));
        if let Some(byte) = fate.corrupt_byte.map(|byte| byte.min(frame.len() - 1)) {
            frame[byte] ^= 0x55;
        }
        let bytes = fate.truncate_to.map_or(frame.len(), |bytes| bytes.min(frame.len()));
        Passage { answers: if fate.is_doubled { 2 } else { 1 }, bytes, after: fate.delay }
    }

    fn advance(&mut self, now: Duration) {
        let count = self.places.len();
        self.give_pulses(now);
        self.bus.borrow_mut().advance_to(now);
        self.for_each(count, |device, application| {
            device.advance(application, now);
            device.serve(application, now);
        });
    }

    fn inject(&mut self, now: Duration, fault: LineFault) -> Result<(), String> {
        if self.faults.add(fault) {
            return Ok(());
        }
        match fault {
            LineFault::Unplugged { device, is_gone } => {
                self.with_device(device, |_, _| {})?;
                self.plug(device, is_gone);
                Ok(())
            }
            LineFault::AlError { device, code } => self.with_device(device, |d, a| d.fail(a, code)),
            LineFault::RefusesTransitions { device, code } => {
                self.with_device(device, |d, _| d.misbehaviour.refuses_with = code)
            }
            LineFault::SlowTransitions { device, take } => {
                self.with_device(device, |d, _| d.misbehaviour.transitions_take = take)
            }
            LineFault::Watchdog { device } => self.with_device(device, |d, a| d.expire(a)),
            LineFault::Mute { device, is_mute } => {
                self.with_device(device, |d, _| d.mailbox.is_mute = is_mute)
            }
            LineFault::SlowMailbox { device, take } => {
                self.with_device(device, |d, _| d.mailbox.answers_after = take)
            }
            LineFault::RefusesSdo { device, code } => {
                self.with_device(device, |d, _| d.mailbox.sdo.refuses = code)
            }
            LineFault::Emergency { device, emergency } => {
                self.with_device(device, |d, _| d.send_emergency(emergency, now))
            }
            LineFault::ClockStep { device, by_ns } => {
                self.with_device(device, |d, _| d.esc.clock.step(by_ns))
            }
            LineFault::ClockDrift { device, rate_ppm } => {
                self.with_device(device, |d, _| d.esc.clock.drift(rate_ppm, now))
            }
            LineFault::Sync0Lost { device, is_lost } => {
                self.with_device(device, |d, _| d.esc.clock.lose_sync0(is_lost))
            }
            LineFault::Drop { .. }
            | LineFault::Delay { .. }
            | LineFault::Duplicate { .. }
            | LineFault::Corrupt { .. }
            | LineFault::Truncate { .. }
            | LineFault::WorkingCounter { .. } => Ok(()),
        }
    }

    fn set_alias(&mut self, device: usize, alias: u16) -> Result<(), String> {
        self.with_device(device, |device, _| device.esc.set_alias(alias))
    }

    fn names(&self) -> Vec<String> {
        self.places.iter().map(|place| place.name.clone()).collect()
    }
}
