//! A SubDevice: controller, state machine, mailbox and watchdog in front of an application.

use std::time::Duration;

use drivers::wire::BusState;

use super::application::{Application, Emergency, ProcessDataBytes};
use super::esc::{ClockError, Esc, Mode, Sync0Pulse, registers};
use super::mailbox::Mailbox;
use super::sii::{Description, MailboxPlace};
use super::states::{ERROR, State, code};

/// Sync managers of process data, of a device with a mailbox; a device without begins with its outputs.
const OUTPUTS: usize = 2;
/// How long the first outputs may take after OP was asked for.
const FIRST_OUTPUTS: Duration = Duration::from_millis(500);
/// Shortest SYNC0 cycle that a drive follows, ns.
const SHORTEST_CYCLE_NS: u32 = 62_500;

/// A transition that goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Asked {
    state: State,
    since: Duration,
}

/// What a SubDevice does wrong because a test wants it to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Misbehaviour {
    /// Every transition upwards is refused with this AL status code.
    pub(crate) refuses_with: Option<u16>,
    /// Every transition upwards takes this long.
    pub(crate) transitions_take: Duration,
}

/// Everything in front of an application.
#[derive(Clone, Debug)]
pub(crate) struct SubDevice {
    pub(crate) esc: Esc,
    pub(crate) mailbox: Mailbox,
    place: Option<MailboxPlace>,
    state: State,
    asked: Option<Asked>,
    /// The last SYNC0 pulse that was worked on.
    last_pulse: Option<Sync0Pulse>,
    /// Outputs that wait for SYNC0.
    outputs_wait: bool,
    /// OP was entered with SYNC0, and ends without it.
    needs_sync0: bool,
    /// Process data as they were mapped when SAFE-OP was entered.
    mapped: ProcessDataBytes,
    pub(crate) misbehaviour: Misbehaviour,
}

impl SubDevice {
    /// A SubDevice after power-up.
    pub(crate) fn new(description: &Description, error: ClockError) -> Self {
        Self {
            esc: Esc::new(description.words(), error),
            mailbox: Mailbox::default(),
            place: description.mailbox,
            state: State::Init,
            asked: None,
            last_pulse: None,
            outputs_wait: false,
            needs_sync0: false,
            mapped: ProcessDataBytes::default(),
            misbehaviour: Misbehaviour::default(),
        }
    }

    fn outputs(&self) -> usize {
        if self.place.is_some() { OUTPUTS } else { 0 }
    }

    fn inputs(&self) -> usize {
        self.outputs() + 1
    }

    /// Brings the application up to `now`: inputs, watchdog. Called before a frame arrives, and from time to time where none
    /// does; before that, [`Self::give_pulse`].
    pub(crate) fn advance(&mut self, application: &mut dyn Application, now: Duration) {
        if !self.follows_sync0() {
            self.sample(application, now);
        }
        self.supervise(application, now);
    }

    /// Whether the MainDevice has activated SYNC0, given or not.
    pub(crate) fn follows_sync0(&self) -> bool {
        self.esc.u8(registers::SYNC_ACTIVATION) & 3 == 3
    }

    /// With SYNC0 the inputs are those of the last pulse up to `now`, and outputs act at the first one after they came. Called
    /// while the world is no further than the last time that it was called. If the trigger cable of the inertial unit leads to
    /// this SubDevice, the unit gets every pulse.
    pub(crate) fn give_pulse(&mut self, application: &mut dyn Application, now: Duration, has_cable: bool) {
        let Some(pulse) = self.esc.last_sync0(now) else { return };
        // Pulses count from the start that the MainDevice set: one that opens the bus anew sets another.
        let last = self.last_pulse.filter(|last| last.start_ns == pulse.start_ns);
        if last.is_some_and(|last| pulse.number <= last.number) {
            return;
        }
        let first = last.map_or(pulse.at, |last| self.first_after(last.at, pulse.at));
        self.last_pulse = Some(pulse);
        if std::mem::take(&mut self.outputs_wait) {
            self.deliver(application, first);
        }
        if has_cable {
            self.trigger(application, first, pulse.at);
        }
        self.sample(application, pulse.at);
    }

    /// The pulses from the first to the last one.
    fn trigger(&self, application: &mut dyn Application, first: Duration, last: Duration) {
        let cycle = self.esc.clock.sync0_cycle();
        let mut at = first;
        while !cycle.is_zero() && at + cycle / 2 < last {
            application.trigger(at);
            at += cycle;
        }
        application.trigger(last);
    }

    /// The first pulse after one and up to another one; the clock may have been moved between them.
    fn first_after(&self, last: Duration, pulse: Duration) -> Duration {
        let cycle = self.esc.clock.sync0_cycle();
        let passed = pulse.saturating_sub(last).as_secs_f64() / cycle.as_secs_f64();
        let more = (passed.round() - 1.0).clamp(0.0, f64::from(u32::MAX)) as u32;
        pulse.saturating_sub(cycle.saturating_mul(more)).max(last)
    }

    fn sample(&mut self, application: &mut dyn Application, at: Duration) {
        if self.state >= State::SafeOp {
            let inputs = self.inputs();
            self.esc.sync_manager(inputs).device_writes(|bytes| application.sample(at, bytes));
        }
    }

    fn deliver(&mut self, application: &mut dyn Application, at: Duration) {
        let outputs = self.outputs();
        if let Some(bytes) = self.esc.sync_manager(outputs).device_takes() {
            application.take(at, bytes);
        }
    }

    /// Works on what a frame left behind: outputs, states, mailbox.
    pub(crate) fn serve(&mut self, application: &mut dyn Application, now: Duration) {
        if let Some(control) = self.esc.take_asked_state() {
            self.ask(application, control, now);
        }
        self.go_on(application, now);
        if self.state == State::Op {
            if self.esc.clock.gives_sync0() {
                let outputs = self.outputs();
                self.outputs_wait |= self.esc.sync_manager(outputs).is_full();
            } else {
                self.deliver(application, now);
            }
        }
        self.keep_configuration(application);
        if self.state >= State::PreOp && self.place.is_some() {
            self.mailbox.serve(&mut self.esc, application, now);
        }
    }

    /// A state whose sync managers were taken away ends.
    fn keep_configuration(&mut self, application: &mut dyn Application) {
        let ends = if self.state >= State::PreOp && self.check_mailbox().is_err() {
            Some((State::Init, code::MAILBOX))
        } else if self.state >= State::SafeOp {
            self.check_lengths(self.mapped).err().map(|code| (State::PreOp, code))
        } else {
            None
        };
        if let Some((state, code)) = ends {
            self.asked = None;
            self.leave(application, state);
            self.esc.set_state(state as u16 | ERROR, code);
        }
    }

    /// The process data watchdog, and an application that left OP by itself.
    fn supervise(&mut self, application: &mut dyn Application, now: Duration) {
        if self.state != State::Op {
            return;
        }
        let silent = self.esc.fed_at().map(|fed_at| now.saturating_sub(fed_at));
        let has_expired =
            matches!((silent, self.esc.watchdog()), (Some(silent), Some(limit)) if silent > limit);
        let is_unsynchronised = self.needs_sync0 && !self.esc.clock.gives_sync0() && self.misses_pulses(now);
        if has_expired {
            self.expire(application);
        } else if is_unsynchronised {
            self.fail(application, code::SYNC_LOST);
        } else if application.state() < BusState::Op {
            self.fall(State::SafeOp, code::WATCHDOG);
        }
    }

    /// Whether several pulses in a row did not come.
    fn misses_pulses(&self, now: Duration) -> bool {
        const MISSED: u32 = 3;
        let cycle = Duration::from_nanos(u64::from(self.cycle_ns()));
        self.last_pulse.is_none_or(|last| now.saturating_sub(last.at) > cycle.saturating_mul(MISSED))
    }

    fn cycle_ns(&self) -> u32 {
        let [low, high] = [0, 2].map(|k| self.esc.u16(registers::SYNC0_CYCLE + k));
        u32::from(low) | u32::from(high) << 16
    }

    /// The process data watchdog acts.
    pub(crate) fn expire(&mut self, application: &mut dyn Application) {
        let count = self.esc.u8(registers::DATA_WATCHDOG_COUNTER).saturating_add(1);
        self.esc.put_u8(registers::DATA_WATCHDOG_COUNTER, count);
        self.esc.put_u16(registers::WATCHDOG_STATUS, 0);
        if self.state == State::Op {
            application.enter(BusState::SafeOp);
            self.fall(State::SafeOp, code::WATCHDOG);
        }
    }

    /// The device finds an error: it falls to a lower state where it is above it.
    pub(crate) fn fail(&mut self, application: &mut dyn Application, code: u16) {
        let state = self.state.min(State::SafeOp);
        if state != self.state {
            application.enter(BusState::SafeOp);
        }
        self.fall(state, code);
    }

    fn fall(&mut self, state: State, code: u16) {
        self.asked = None;
        self.state = state;
        self.outputs_wait = false;
        self.esc.feed(None);
        self.esc.set_state(state as u16 | ERROR, code);
    }

    /// AL control was written.
    fn ask(&mut self, application: &mut dyn Application, control: u16, now: Duration) {
        let has_error = self.esc.u16(registers::AL_STATUS) & ERROR != 0;
        if has_error && control & ERROR == 0 {
            // An error stays until it is acknowledged.
            return;
        }
        self.esc.set_state(self.state as u16, 0);
        let Some(state) = State::decode(control) else { return self.refuse(code::UNKNOWN_STATE) };
        if let Err(code) = self.state.may_become(state) {
            return self.refuse(code);
        }
        if state <= self.state {
            self.asked = None;
            return self.leave(application, state);
        }
        match self.misbehaviour.refuses_with {
            Some(code) => self.refuse(code),
            None => {
                // Asking again does not begin anew.
                let before = self.asked.filter(|asked| asked.state == state);
                self.asked = Some(before.unwrap_or(Asked { state, since: now }));
            }
        }
    }

    fn refuse(&mut self, code: u16) {
        self.asked = None;
        self.esc.set_state(self.state as u16 | ERROR, code);
    }

    /// A transition upwards that was asked for.
    fn go_on(&mut self, application: &mut dyn Application, now: Duration) {
        let Some(Asked { state, since }) = self.asked else { return };
        let waited = now.saturating_sub(since);
        if waited < self.misbehaviour.transitions_take {
            return;
        }
        let checked = match state {
            State::PreOp => self.check_mailbox(),
            State::SafeOp => self.check_process_data(application),
            State::Op => match self.is_ready_for_op(waited) {
                Ok(true) => Ok(()),
                Ok(false) => return,
                Err(code) => Err(code),
            },
            State::Init | State::Boot => Ok(()),
        };
        match checked {
            Err(code) => self.refuse(code),
            Ok(()) => self.enter(application, state, now),
        }
    }

    fn enter(&mut self, application: &mut dyn Application, state: State, now: Duration) {
        self.asked = None;
        self.state = state;
        match state {
            State::PreOp => {
                self.mailbox.reset();
                if self.place.is_some() {
                    (0..2).for_each(|n| self.esc.sync_manager(n).empty());
                }
            }
            State::SafeOp => {
                application.enter(BusState::SafeOp);
                self.last_pulse = None;
                self.sample(application, now);
            }
            State::Op => {
                application.enter(BusState::Op);
                self.needs_sync0 = self.follows_sync0();
                let feeds = self.esc.configuration(self.outputs()).is_some_and(|c| c.feeds_watchdog);
                self.esc.feed(feeds.then_some(now));
                self.esc.put_u16(registers::WATCHDOG_STATUS, 1);
            }
            State::Init | State::Boot => {}
        }
        self.esc.set_state(state as u16, 0);
    }

    /// A transition downwards, or none.
    fn leave(&mut self, application: &mut dyn Application, state: State) {
        let was = self.state;
        self.state = state;
        self.outputs_wait = false;
        if state < State::Op {
            self.esc.feed(None);
        }
        if state < was {
            let bus_state = if state == State::SafeOp { BusState::SafeOp } else { BusState::PreOp };
            application.enter(bus_state);
        }
        if state == State::Init {
            self.mailbox.reset();
            (0..2).for_each(|n| self.esc.sync_manager(n).empty());
        }
        if state < State::SafeOp {
            let (outputs, inputs) = (self.outputs(), self.inputs());
            [outputs, inputs].into_iter().for_each(|n| self.esc.sync_manager(n).empty());
        }
        self.esc.set_state(state as u16, 0);
    }

    /// Both mailboxes stand where the SII says.
    fn check_mailbox(&self) -> Result<(), u16> {
        let Some(place) = self.place else { return Ok(()) };
        let is_as_said = |n: usize, start: u16, from_main: bool| {
            self.esc.configuration(n).is_some_and(|c| {
                (c.start, c.length, c.from_main, c.mode) == (start, place.length, from_main, Mode::Mailbox)
            })
        };
        let is_right = is_as_said(0, place.receive, true) && is_as_said(1, place.send, false);
        if is_right { Ok(()) } else { Err(code::MAILBOX) }
    }

    /// The sync managers of the process data are as long as the mapping.
    fn check_process_data(&mut self, application: &mut dyn Application) -> Result<(), u16> {
        self.mapped = application.map().map_err(|_| code::MAPPING)?;
        self.check_lengths(self.mapped)?;
        if self.esc.u8(registers::SYNC_ACTIVATION) & 2 != 0 && self.cycle_ns() < SHORTEST_CYCLE_NS {
            return Err(code::SYNC_CYCLE);
        }
        Ok(())
    }

    fn check_lengths(&self, mapped: ProcessDataBytes) -> Result<(), u16> {
        let length = |n: usize, from_main: bool| match self.esc.configuration(n) {
            None => Some(0),
            Some(c) if c.from_main == from_main && c.mode == Mode::Buffered => Some(usize::from(c.length)),
            Some(_) => None,
        };
        if length(self.outputs(), true) != Some(mapped.outputs) {
            return Err(code::OUTPUTS);
        }
        if length(self.inputs(), false) != Some(mapped.inputs) {
            return Err(code::INPUTS);
        }
        Ok(())
    }

    /// OP needs outputs, and SYNC0 where it was activated.
    fn is_ready_for_op(&mut self, waited: Duration) -> Result<bool, u16> {
        if self.follows_sync0() && !self.esc.clock.gives_sync0() {
            return Err(code::NO_SYNC);
        }
        let outputs = self.outputs();
        let needs_outputs = self.esc.configuration(outputs).is_some();
        if !needs_outputs || self.esc.sync_manager(outputs).was_written() {
            return Ok(true);
        }
        if waited > FIRST_OUTPUTS { Err(code::NO_VALID_OUTPUTS) } else { Ok(false) }
    }

    /// Sends an emergency message.
    pub(crate) fn send_emergency(&mut self, emergency: Emergency, now: Duration) {
        if self.place.is_some() {
            self.mailbox.send_emergency(emergency, now);
        }
    }
}
