//! A tap and faults between the production bus and emulated SubDevices.

use std::cell::RefCell;
use std::ops::Range;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use drivers::cia402::PowerTarget;
use drivers::wire::fault::{FaultControl, FaultKind, FaultPlan, FaultyLink, FrameFault, Occurrence};
use drivers::wire::{BusState, Exchange, Fieldbus, FrameSink, StoredFrame, Tap, TappedFrame, Way};

use crate::bench::{Bench, TICK, settings};

/// Command of a logical exchange.
const LRW: u8 = 12;
const HEADERS_BYTES: usize = 16;
const DATAGRAM_HEADER_BYTES: usize = 10;
const WORKING_COUNTER_BYTES: usize = 2;

/// Frames that passed a tap since somebody looked.
#[derive(Clone, Default)]
struct Captured(Rc<RefCell<Vec<(Way, StoredFrame)>>>);

impl Captured {
    fn take(&self) -> Vec<(Way, StoredFrame)> {
        std::mem::take(&mut *self.0.borrow_mut())
    }
}

impl FrameSink for Captured {
    fn take(&mut self, frame: &TappedFrame) {
        self.0.borrow_mut().push((frame.way, frame.frame));
    }
}

/// Place of the data of a frame's logical exchange.
fn process_data(frame: &[u8]) -> Option<Range<usize>> {
    let mut at = HEADERS_BYTES;
    loop {
        let header = frame.get(at..at + DATAGRAM_HEADER_BYTES)?;
        let length = u16::from_le_bytes([header[6], header[7]]);
        let data = at + DATAGRAM_HEADER_BYTES;
        let end = data + usize::from(length & 0x07FF);
        if header[0] == LRW {
            return Some(data..end);
        }
        at = end + WORKING_COUNTER_BYTES;
        if length & 0x8000 == 0 {
            return None;
        }
    }
}

/// Number that a frame and its reply share.
fn tag(frame: &StoredFrame) -> [u8; 4] {
    frame.bytes()[8..12].try_into().expect("four bytes")
}

/// A bench with faults between a tap at the bus and a tap at the wire.
struct Disturbed {
    bench: Bench,
    control: Arc<FaultControl>,
    at_bus: Captured,
    at_wire: Captured,
}

impl Disturbed {
    /// In OP; the faults have not begun.
    fn new(seed: u64, faults: Vec<FrameFault>) -> Self {
        let [at_bus, at_wire] = [Captured::default(), Captured::default()];
        let control = Arc::new(FaultControl::default());
        let mut bench = Bench::through(settings(), |link| {
            let wire = Tap::new(link, at_wire.clone());
            let faulty = FaultyLink::new(wire, FaultPlan { seed, faults }, Arc::clone(&control));
            Box::new(Tap::new(faulty, at_bus.clone()))
        });
        bench.enter_op();
        let _ = (at_bus.take(), at_wire.take());
        Self { bench, control, at_bus, at_wire }
    }

    /// One exchange, with what the stations really answered to its frame.
    fn exchange(&mut self) -> (Exchange, Vec<StoredFrame>) {
        let exchange = self.bench.tick(PowerTarget::Disabled);
        let sent = self.at_bus.take();
        let cyclic =
            sent.iter().find(|(way, frame)| *way == Way::Out && process_data(frame.bytes()).is_some());
        let cyclic = tag(&cyclic.expect("every exchange sends one").1);
        let answers = self.at_wire.take().into_iter();
        let answers = answers.filter(|(way, frame)| *way == Way::Back && tag(frame) == cyclic);
        (exchange, answers.map(|(_, frame)| frame).collect())
    }

    /// Whether the inputs of the image are those of one of these answers.
    fn has_inputs_of(&self, answers: &[StoredFrame]) -> bool {
        let inputs = &self.bench.image.inputs;
        answers.iter().any(|answer| {
            let data = process_data(answer.bytes()).expect("the answer to a logical exchange");
            answer.bytes()[data][..inputs.len()] == inputs[..]
        })
    }

    /// Ticks until an exchange has carried an acyclic datagram: those after it carry none.
    fn reach_quiet(&mut self) {
        for _ in 0..1000 {
            self.bench.tick(PowerTarget::Disabled);
            self.at_wire.take();
            if self.at_bus.take().iter().filter(|(way, _)| *way == Way::Out).count() > 1 {
                return;
            }
        }
        panic!("the bus looks after emergencies");
    }
}

fn fault(way: Way, kind: FaultKind, when: Occurrence) -> FrameFault {
    FrameFault { way, kind, when }
}

/// Faults that EtherCAT can recognise: all that leave no wrong byte in process data.
const KINDS: [FaultKind; 9] = [
    FaultKind::Drop,
    FaultKind::Delay { by: Duration::from_micros(400) },
    FaultKind::Duplicate,
    FaultKind::Corrupt { byte: Some(9) },
    FaultKind::Corrupt { byte: Some(12) },
    FaultKind::Corrupt { byte: Some(14) },
    FaultKind::Corrupt { byte: Some(17) },
    FaultKind::Truncate { bytes: 40 },
    FaultKind::Reorder,
];

#[test]
fn a_captured_exchange_holds_the_inputs_and_outputs_of_the_image() {
    let captured = Captured::default();
    let mut bench = Bench::through(settings(), |link| Box::new(Tap::new(link, captured.clone())));
    bench.enter_op();
    let mut seen_inputs = Vec::new();
    for _ in 0..200 {
        captured.take();
        let outputs = bench.image.outputs.clone();
        bench.tick(PowerTarget::Enabled);
        let frames = captured.take();
        let of = |wanted: Way| {
            let found = frames
                .iter()
                .filter(|(way, _)| *way == wanted)
                .find_map(|(_, frame)| Some(frame.bytes()[process_data(frame.bytes())?].to_vec()));
            found.expect("every exchange passes one logical datagram")
        };
        let [sent, received] = [of(Way::Out), of(Way::Back)];
        for (station, slot) in &bench.slots {
            assert_eq!(received[slot.inputs.clone()], bench.image.inputs[slot.inputs.clone()], "{station}");
            let place =
                slot.outputs.start + bench.image.inputs.len()..slot.outputs.end + bench.image.inputs.len();
            assert_eq!(sent[place], outputs[slot.outputs.clone()], "{station}");
        }
        seen_inputs.push(bench.image.inputs.clone());
    }
    seen_inputs.dedup();
    assert!(seen_inputs.len() > 100, "the drives have something to tell: {}", seen_inputs.len());
}

#[test]
fn rare_faults_cost_exchanges_and_never_bring_a_wrong_actual() {
    for (k, kind) in KINDS.into_iter().enumerate() {
        for way in [Way::Out, Way::Back] {
            let rare = fault(way, kind, Occurrence::Chance(0.03));
            let mut disturbed = Disturbed::new(k as u64, vec![rare]);
            disturbed.control.begin();
            let (mut bad_count, mut inputs) = (0, disturbed.bench.image.inputs.clone());
            for tick in 0..2000 {
                let (exchange, answers) = disturbed.exchange();
                let what = format!("{kind:?} {way:?} in tick {tick}");
                if exchange.working_counter == 0 {
                    bad_count += 1;
                    assert_eq!(disturbed.bench.image.inputs, inputs, "{what}");
                } else {
                    assert_eq!(exchange.working_counter, exchange.expected, "{what}");
                    assert!(disturbed.has_inputs_of(&answers), "{what}");
                }
                assert_eq!(disturbed.bench.bus.state(), BusState::Op, "{what}");
                inputs.clone_from(&disturbed.bench.image.inputs);
            }
            let counts = disturbed.control.counts(way);
            assert!(counts.frames >= 1900, "{counts:?}");
            match kind {
                FaultKind::Duplicate => assert_eq!(bad_count, 0, "{way:?}"),
                _ => assert!((20..130).contains(&bad_count), "{kind:?} {way:?}: {bad_count}, {counts:?}"),
            }
        }
    }
}

#[test]
fn three_faults_in_a_row_are_three_exchanges_with_working_counter_0() {
    for kind in KINDS.into_iter().filter(|&kind| kind != FaultKind::Duplicate) {
        for way in [Way::Out, Way::Back] {
            let three = fault(way, kind, Occurrence::At { first: 1, count: 3 });
            let mut disturbed = Disturbed::new(1, vec![three]);
            disturbed.reach_quiet();
            disturbed.control.begin();
            let good: Vec<bool> = (0..5)
                .map(|_| {
                    let (exchange, _) = disturbed.exchange();
                    exchange.working_counter == exchange.expected
                })
                .collect();
            assert_eq!(good, [false, false, false, true, true], "{kind:?} {way:?}");
            assert_eq!(disturbed.bench.bus.state(), BusState::Op, "{kind:?} {way:?}");
        }
    }
}

#[test]
fn a_late_reply_within_the_tick_is_still_in_time() {
    let late = FaultKind::Delay { by: TICK / 10 };
    let mut disturbed = Disturbed::new(1, vec![fault(Way::Back, late, Occurrence::Chance(1.0))]);
    disturbed.control.begin();
    for _ in 0..400 {
        let (exchange, answers) = disturbed.exchange();
        assert_eq!(exchange.working_counter, exchange.expected);
        assert!(disturbed.has_inputs_of(&answers));
    }
}

#[test]
fn a_changed_byte_of_process_data_is_taken_for_only_the_frame_check_could_find_it() {
    let mut disturbed = Disturbed::new(1, Vec::new());
    let (_, answers) = disturbed.exchange();
    let data = process_data(answers[0].bytes()).expect("a logical exchange");
    let wrong = FaultKind::Corrupt { byte: Some(data.start + 2) };
    let mut disturbed =
        Disturbed::new(1, vec![fault(Way::Back, wrong, Occurrence::At { first: 1, count: 1 })]);
    disturbed.reach_quiet();
    disturbed.control.begin();
    let (exchange, answers) = disturbed.exchange();
    assert_eq!(exchange.working_counter, exchange.expected);
    assert!(!disturbed.has_inputs_of(&answers));
    let (_, answers) = disturbed.exchange();
    assert!(disturbed.has_inputs_of(&answers), "the next one is right again");
}
