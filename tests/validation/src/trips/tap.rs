//! A tap on the bus: what goes over the wire in each exchange, and where the axes really are then.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicU16, Ordering};
use std::time::Duration;

use bench::files::profile;
use drivers::cia402::profile::{DriveProfile, ObjectPlace};
use drivers::wire::{Fieldbus, ProcessImage, Slot};
use sim_devices::rig::{AxesTruth, SimulatedRig};

use super::cause::Act;
use crate::intercepted::{Intercepted, Interceptor};

/// One exchange.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) time_s: f64,
    /// What the host sent: the commands of the tick before.
    pub(super) controlword: [u16; 2],
    pub(super) torque_permille: [i16; 2],
    /// What it got: the sample of this tick, or the last good one.
    pub(super) statusword: [u16; 2],
    pub(super) bus_v: f64,
    pub(super) heat_sink_degc: [f64; 2],
    /// Of the first drive.
    pub(super) digital_inputs: u32,
    pub(super) bad_in_row: u32,
    /// The operator has ordered a stop.
    pub(super) ordered: bool,
    /// Where the axes really are.
    pub(super) truth: AxesTruth,
}

/// What the tap does and has seen.
pub(super) struct Record {
    pub(super) samples: Vec<Sample>,
    /// The first sample with both drives in operation, and the one after which the cause acts.
    pub(super) enabled: Option<usize>,
    /// When the cause acts.
    pub(super) caused: Option<Duration>,
    after: Duration,
    act: Act,
    /// The sample at which the operator orders a quick stop at once, to end a run for comparison.
    end_at: Option<usize>,
}

/// The tap, in the place of the bus.
pub(super) struct Tap {
    rig: SimulatedRig,
    slots: Vec<Slot>,
    profile: Arc<DriveProfile>,
    stop: Arc<AtomicU16>,
    record: Rc<RefCell<Record>>,
}

impl Record {
    /// Acts `after` the motion began; `end_at` ends the run at a sample.
    pub(super) fn new(act: Act, after: Duration, end_at: Option<usize>) -> Rc<RefCell<Self>> {
        let samples = Vec::with_capacity(65_536);
        Rc::new(RefCell::new(Self { samples, enabled: None, caused: None, after, act, end_at }))
    }
}

impl Tap {
    pub(super) fn on(
        rig: &SimulatedRig,
        stop: Arc<AtomicU16>,
        record: Rc<RefCell<Record>>,
    ) -> Box<dyn Fieldbus> {
        Intercepted::boxed(
            rig.bus(),
            Self { rig: rig.clone(), slots: Vec::new(), profile: profile::simulated(), stop, record },
        )
    }

    fn take(&mut self, now: Duration, image: &ProcessImage, good: bool) {
        let mut record = self.record.borrow_mut();
        let bad_before = record.samples.last().map_or(0, |last| last.bad_in_row);
        let index = record.samples.len();
        let sample = Sample {
            time_s: now.as_secs_f64(),
            controlword: self.both(|k| word(self.output(image, k, 0x6040))),
            torque_permille: self.both(|k| word(self.output(image, k, 0x6071)) as i16),
            statusword: self.both(|k| word(self.input(image, k, 0x6041))),
            bus_v: f64::from(long(self.input(image, 0, 0x6079))) / 1e3,
            heat_sink_degc: self.both(|k| f64::from(word(self.input(image, k, 0x22A3)) as i16) / 10.0),
            digital_inputs: long(self.input(image, 0, 0x60FD)),
            bad_in_row: if good { 0 } else { bad_before + 1 },
            ordered: self.order(&mut record, now, index),
            truth: self.rig.truth_of_axes(),
        };
        if record.enabled.is_none() && sample.statusword.iter().all(|word| word & 0x6F == 0x27) {
            record.enabled = Some(index);
            let at = now + record.after;
            record.caused = Some(at);
            if let Act::Fault(fault) = record.act {
                self.rig.schedule(at, fault);
            }
        }
        record.samples.push(sample);
    }

    /// Gives the operator's order when it is due.
    fn order(&self, record: &mut Record, now: Duration, index: usize) -> bool {
        let due = matches!(record.act, Act::Order) && record.caused.is_some_and(|at| now >= at);
        if due {
            self.stop.store(u16::from(bench::exit::SIGINT), Ordering::Relaxed);
        }
        if record.end_at == Some(index) {
            self.stop
                .store(u16::from(bench::exit::SIGINT) | bench::cycle::run::STOP_AT_ONCE, Ordering::Relaxed);
        }
        due
    }

    fn both<T>(&self, of: impl Fn(usize) -> T) -> [T; 2] {
        [of(0), of(1)]
    }

    fn output<'i>(&self, image: &'i ProcessImage, drive: usize, index: u16) -> &'i [u8] {
        let offset = self.profile.outputs.offset_of(ObjectPlace { index, sub: 0 }).expect("it is mapped");
        &image.outputs[self.slots[drive].outputs.start + offset..]
    }

    fn input<'i>(&self, image: &'i ProcessImage, drive: usize, index: u16) -> &'i [u8] {
        let offset = self.profile.inputs.offset_of(ObjectPlace { index, sub: 0 }).expect("it is mapped");
        &image.inputs[self.slots[drive].inputs.start + offset..]
    }
}

fn word(bytes: &[u8]) -> u16 {
    u16::from_le_bytes([bytes[0], bytes[1]])
}

fn long(bytes: &[u8]) -> u32 {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}

impl Interceptor for Tap {
    fn mapped(&mut self, slots: &[(u16, Slot)]) {
        self.slots = slots.iter().map(|(_, slot)| slot.clone()).collect();
    }

    fn after_exchange(&mut self, now: Duration, image: &ProcessImage, is_whole: bool) {
        self.take(now, image, is_whole);
    }
}
