//! Faults on a line that gives back what it is given.

use std::collections::VecDeque;
use std::io;
use std::sync::Arc;
use std::time::Duration;

use proptest::prelude::*;

use super::super::{EthernetLink, MAX_FRAME_BYTES, Way};
use super::{FaultControl, FaultCounts, FaultKind, FaultPlan, FaultyLink, FrameFault, Occurrence};

const TICK: Duration = Duration::from_micros(250);

/// A line that gives back what it is given, at once. Time passes while somebody waits.
#[derive(Default)]
struct Echo {
    sent: Vec<Vec<u8>>,
    arriving: VecDeque<Vec<u8>>,
    now: Duration,
    /// Frames that are refused before the next one is taken.
    full: usize,
}

impl EthernetLink for &mut Echo {
    fn name(&self) -> &str {
        "echo"
    }

    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        if self.full > 0 {
            self.full -= 1;
            return Err(io::ErrorKind::WouldBlock.into());
        }
        self.sent.push(frame.to_vec());
        self.arriving.push_back(frame.to_vec());
        Ok(())
    }

    fn receive(&mut self, into: &mut [u8]) -> io::Result<Option<usize>> {
        let Some(frame) = self.arriving.pop_front() else { return Ok(None) };
        into[..frame.len()].copy_from_slice(&frame);
        Ok(Some(frame.len()))
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn wait(&mut self, until: Duration) -> io::Result<()> {
        self.now = self.now.max(until);
        Ok(())
    }
}

/// What a faulty line has done to frames.
#[derive(Debug, PartialEq, Eq)]
struct Passed {
    sent: Vec<Vec<u8>>,
    received: Vec<Vec<u8>>,
    out: FaultCounts,
    back: FaultCounts,
}

/// Sends a frame each tick and takes what comes back; then as many ticks more without one.
fn passed(plan: &FaultPlan, frames: &[Vec<u8>]) -> Passed {
    let mut echo = Echo::default();
    let control = Arc::new(FaultControl::default());
    control.begin();
    let mut received = Vec::new();
    {
        let mut link = FaultyLink::new(&mut echo, plan.clone(), Arc::clone(&control));
        let mut bytes = [0; MAX_FRAME_BYTES];
        for tick in 1..=(2 * frames.len() + 100) as u32 {
            if let Some(frame) = frames.get(tick as usize - 1) {
                link.send(frame).expect("the line takes every frame");
            }
            while link.now() < TICK * tick {
                link.wait(TICK * tick).expect("the line is there");
                while let Some(count) = link.receive(&mut bytes).expect("the line is there") {
                    received.push(bytes[..count].to_vec());
                }
            }
        }
    }
    Passed { sent: echo.sent, received, out: control.counts(Way::Out), back: control.counts(Way::Back) }
}

/// Frames that differ from each other.
fn numbered(count: u32) -> Vec<Vec<u8>> {
    (1..=count).map(|number| [&[0x55; 20][..], &number.to_be_bytes()].concat()).collect()
}

fn one(way: Way, kind: FaultKind, when: Occurrence) -> FaultPlan {
    FaultPlan { seed: 5, faults: vec![FrameFault { way, kind, when }] }
}

/// Numbers of the frames of `all` that are in `found`, in its order.
fn numbers(found: &[Vec<u8>], all: &[Vec<u8>]) -> Vec<usize> {
    found.iter().filter_map(|frame| Some(all.iter().position(|own| own == frame)? + 1)).collect()
}

fn is_subsequence(part: &[Vec<u8>], whole: &[Vec<u8>]) -> bool {
    let mut rest = whole.iter();
    part.iter().all(|frame| rest.any(|own| own == frame))
}

#[test]
fn nothing_is_touched_before_the_faults_begin() {
    let mut echo = Echo::default();
    let control = Arc::new(FaultControl::default());
    let plan = one(Way::Out, FaultKind::Drop, Occurrence::Chance(1.0));
    let mut link = FaultyLink::new(&mut echo, plan, Arc::clone(&control));
    link.send(&[1; 20]).expect("taken");
    assert_eq!(link.receive(&mut [0; 64]).expect("there"), Some(20));
    control.begin();
    link.send(&[2; 20]).expect("taken");
    assert_eq!(link.receive(&mut [0; 64]).expect("there"), None);
    assert_eq!(control.counts(Way::Out), FaultCounts { frames: 1, dropped: 1, ..FaultCounts::default() });
}

#[test]
fn a_fault_befalls_exactly_the_frames_that_it_names() {
    let all = numbered(12);
    let lost = |way, when| {
        let passed = passed(&one(way, FaultKind::Drop, when), &all);
        (numbers(&passed.sent, &all), numbers(&passed.received, &all))
    };
    let every_third = [1, 2, 4, 5, 7, 8, 10, 11].to_vec();
    assert_eq!(lost(Way::Out, Occurrence::Every(3)), (every_third.clone(), every_third.clone()));
    assert_eq!(lost(Way::Back, Occurrence::Every(3)), ((1..=12).collect(), every_third));
    let some = [1, 2, 3, 4, 8, 9, 10, 11, 12].to_vec();
    assert_eq!(lost(Way::Back, Occurrence::At { first: 5, count: 3 }), ((1..=12).collect(), some));
}

#[test]
fn a_late_frame_comes_when_it_is_due_and_overtaken_by_others() {
    let all = numbered(6);
    let late = FaultKind::Delay { by: TICK * 5 / 2 };
    let when = Occurrence::At { first: 2, count: 1 };
    assert_eq!(numbers(&passed(&one(Way::Back, late, when), &all).received, &all), [1, 3, 4, 2, 5, 6]);
    let out = passed(&one(Way::Out, late, when), &all);
    assert_eq!(numbers(&out.sent, &all), [1, 3, 4, 2, 5, 6]);
    assert_eq!(out.out.delayed, 1);
}

#[test]
fn frames_are_doubled_and_change_places() {
    let all = numbered(5);
    let at = Occurrence::At { first: 2, count: 1 };
    for way in [Way::Out, Way::Back] {
        let doubled = passed(&one(way, FaultKind::Duplicate, at), &all);
        assert_eq!(numbers(&doubled.received, &all), [1, 2, 2, 3, 4, 5], "{way:?}");
        let swapped = passed(&one(way, FaultKind::Reorder, at), &all);
        assert_eq!(numbers(&swapped.received, &all), [1, 3, 2, 4, 5], "{way:?}");
    }
}

#[test]
fn damage_is_one_bit_and_a_cut_leaves_the_ethernet_header() {
    let all = numbered(20);
    let at = Occurrence::Chance(1.0);
    let found = passed(&one(Way::Back, FaultKind::Corrupt { byte: Some(999) }, at), &all).received;
    for (frame, own) in found.iter().zip(&all) {
        assert_eq!(frame[..23], own[..23], "only the last byte");
        assert_eq!((frame[23] ^ own[23]).count_ones(), 1);
    }
    let found = passed(&one(Way::Back, FaultKind::Truncate { bytes: 3 }, at), &all).received;
    assert!(found.iter().all(|frame| frame.len() == 14) && found.len() == 20);
}

#[test]
fn chances_are_kept() {
    let lost = passed(&one(Way::Back, FaultKind::Drop, Occurrence::Chance(0.1)), &numbered(5000));
    assert!((400..600).contains(&lost.back.dropped), "{:?}", lost.back);
    assert_eq!(lost.received.len() as u64, 5000 - lost.back.dropped);
}

#[test]
fn too_many_waiting_frames_are_lost_and_counted() {
    let late = FaultKind::Delay { by: Duration::from_secs(1) };
    let lost = passed(&one(Way::Back, late, Occurrence::Chance(1.0)), &numbered(2100));
    assert!(lost.back.overflowed > 0);
    assert_eq!(lost.back.overflowed, 2100 - lost.received.len() as u64);
}

#[test]
fn a_frame_that_the_interface_refuses_keeps_its_number() {
    let mut echo = Echo { full: 3, ..Echo::default() };
    let control = Arc::new(FaultControl::default());
    control.begin();
    let plan = one(Way::Out, FaultKind::Drop, Occurrence::At { first: 2, count: 1 });
    let mut link = FaultyLink::new(&mut echo, plan, control);
    for _ in 0..3 {
        assert!(link.send(&[1; 20]).is_err());
    }
    for number in 1..=3 {
        link.send(&[number; 20]).expect("the queue has room again");
    }
    assert_eq!(echo.sent, [[1; 20], [3; 20]]);
}

fn kinds() -> impl Strategy<Value = FaultKind> {
    prop_oneof![
        Just(FaultKind::Drop),
        (0_u64..3_000_000).prop_map(|ns| FaultKind::Delay { by: Duration::from_nanos(ns) }),
        Just(FaultKind::Duplicate),
        prop::option::of(0_usize..2000).prop_map(|byte| FaultKind::Corrupt { byte }),
        (0_usize..2000).prop_map(|bytes| FaultKind::Truncate { bytes }),
        Just(FaultKind::Reorder),
    ]
}

fn occurrences() -> impl Strategy<Value = Occurrence> {
    prop_oneof![
        (0.0..=1.0).prop_map(Occurrence::Chance),
        any::<u64>().prop_map(Occurrence::Every),
        (1_u64..5).prop_map(Occurrence::Every),
        (any::<u64>(), any::<u64>()).prop_map(|(first, count)| Occurrence::At { first, count }),
        (0_u64..40, 0_u64..9).prop_map(|(first, count)| Occurrence::At { first, count }),
    ]
}

fn plans() -> impl Strategy<Value = FaultPlan> {
    let ways = prop_oneof![Just(Way::Out), Just(Way::Back)];
    let fault = (ways, kinds(), occurrences()).prop_map(|(way, kind, when)| FrameFault { way, kind, when });
    (any::<u64>(), prop::collection::vec(fault, 0..5)).prop_map(|(seed, faults)| FaultPlan { seed, faults })
}

fn frames() -> impl Strategy<Value = Vec<Vec<u8>>> {
    let frame = prop_oneof![
        4 => prop::collection::vec(any::<u8>(), 0..80),
        1 => prop::collection::vec(any::<u8>(), MAX_FRAME_BYTES),
    ];
    prop::collection::vec(frame, 0..40)
}

proptest! {
    #[test]
    fn no_fault_panics_and_the_same_seed_gives_the_same_faults(plan in plans(), frames in frames()) {
        let first = passed(&plan, &frames);
        prop_assert_eq!(&first, &passed(&plan, &frames));
        prop_assert_eq!(first.out.frames, frames.len() as u64);
        prop_assert!(first.received.len() <= 4 * frames.len());
    }

    #[test]
    fn without_faults_bytes_pass_unchanged(seed in any::<u64>(), frames in frames()) {
        let passed = passed(&FaultPlan { seed, faults: Vec::new() }, &frames);
        prop_assert_eq!(&passed.sent, &frames);
        prop_assert_eq!(&passed.received, &frames);
    }

    #[test]
    fn with_drops_what_arrives_is_a_subsequence(
        seed in any::<u64>(), frames in frames(), chances in [0.0..=1.0, 0.0..=1.0]
    ) {
        let drop = |way, chance| FrameFault { way, kind: FaultKind::Drop, when: Occurrence::Chance(chance) };
        let faults = vec![drop(Way::Out, chances[0]), drop(Way::Back, chances[1])];
        let passed = passed(&FaultPlan { seed, faults }, &frames);
        prop_assert!(is_subsequence(&passed.sent, &frames));
        prop_assert!(is_subsequence(&passed.received, &passed.sent));
    }

    #[test]
    fn whole_frames_stay_whole_whatever_their_order(plan in plans(), frames in frames()) {
        let is_whole = |kind| !matches!(kind, FaultKind::Corrupt { .. } | FaultKind::Truncate { .. });
        let faults = plan.faults.iter().copied().filter(|fault| is_whole(fault.kind)).collect();
        let passed = passed(&FaultPlan { faults, ..plan }, &frames);
        prop_assert!(passed.received.iter().all(|frame| frames.contains(frame)));
    }
}
