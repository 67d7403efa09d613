//! Faults on a port from which numbered messages of a tracker come.

use std::collections::VecDeque;

use super::super::super::Way;
use super::super::{FaultKind, FrameFault, Occurrence};
use super::*;
use crate::tracker::{LENGTH, Lock, Sample, Source, advance_counter, decode, encode};

/// Messages with the time at which they arrive, and what was sent.
#[derive(Default)]
struct Peer {
    arriving: VecDeque<(Duration, Vec<u8>)>,
    sent: Vec<Vec<u8>>,
}

impl DatagramPort for Peer {
    fn name(&self) -> &str {
        "peer"
    }

    fn receive(&mut self, now: Duration, into: &mut [u8]) -> Result<Option<usize>, DeviceError> {
        if self.arriving.front().is_none_or(|(due, _)| *due > now) {
            return Ok(None);
        }
        let Some((_, message)) = self.arriving.pop_front() else { return Ok(None) };
        let count = message.len().min(into.len());
        into[..count].copy_from_slice(&message[..count]);
        Ok(Some(count))
    }

    fn send(&mut self, _: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        if bytes == b"refuse" {
            return Err(DeviceError::Bus { device: "peer".to_owned(), reason: "refused".to_owned() });
        }
        self.sent.push(bytes.to_vec());
        Ok(())
    }
}

fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// Ten messages, one a millisecond, with counters from 1.
fn faulty(plan: PortFaultPlan) -> FaultyDatagramPort<Peer> {
    let message = |counter: u32| {
        let stamp = ms(counter.into());
        let sample = Sample { counter, stamp, x_px: 1.0, y_px: 2.0, quality: 1.0, lock: Lock::Tracking };
        (stamp, encode(Source::Coarse, &sample).to_vec())
    };
    let control = Arc::new(FaultControl::default());
    control.begin();
    let peer = Peer { arriving: (1..=10).map(message).collect(), sent: Vec::new() };
    FaultyDatagramPort::new(peer, plan, control)
}

/// Counters of the messages that are received in 30 ms, polled each millisecond; 0 for one that is not understood.
fn counters(port: &mut FaultyDatagramPort<Peer>) -> Vec<u32> {
    let mut found = Vec::new();
    for k in 0..30 {
        let mut bytes = [0; LENGTH + 1];
        while let Some(count) = port.receive(ms(k), &mut bytes).expect("the port is there") {
            found.push(decode(&bytes[..count]).map_or(0, |(_, sample)| sample.counter));
        }
    }
    found
}

fn of_datagrams(kind: FaultKind, when: Occurrence) -> PortFaultPlan {
    let faults = vec![FrameFault { way: Way::Back, kind, when }];
    PortFaultPlan { datagrams: FaultPlan { seed: 3, faults }, ..PortFaultPlan::default() }
}

#[test]
fn datagrams_are_lost_doubled_damaged_cut_late_and_out_of_order() {
    let third = Occurrence::At { first: 3, count: 1 };
    let received = |kind| counters(&mut faulty(of_datagrams(kind, third)));
    assert_eq!(received(FaultKind::Drop), [1, 2, 4, 5, 6, 7, 8, 9, 10]);
    assert_eq!(received(FaultKind::Duplicate), [1, 2, 3, 3, 4, 5, 6, 7, 8, 9, 10]);
    assert_eq!(received(FaultKind::Corrupt { byte: None }), [1, 2, 0, 4, 5, 6, 7, 8, 9, 10]);
    assert_eq!(received(FaultKind::Truncate { bytes: 20 }), [1, 2, 0, 4, 5, 6, 7, 8, 9, 10]);
    assert_eq!(
        received(FaultKind::Delay { by: Duration::from_micros(2500) }),
        [1, 2, 4, 5, 3, 6, 7, 8, 9, 10]
    );
    assert_eq!(received(FaultKind::Reorder), [1, 2, 4, 3, 5, 6, 7, 8, 9, 10]);
}

#[test]
fn a_counter_that_jumps_comes_with_a_right_checksum_and_stays_ahead() {
    let jumps = vec![CounterJump { first: 4, by: 100, add: advance_counter }];
    let mut port = faulty(PortFaultPlan { jumps, ..PortFaultPlan::default() });
    assert_eq!(counters(&mut port), [1, 2, 3, 104, 105, 106, 107, 108, 109, 110]);
}

#[test]
fn silence_ends_after_its_time() {
    let silences = vec![PortSilence { first: 3, lasts: ms(4) }];
    let mut port = faulty(PortFaultPlan { silences, ..PortFaultPlan::default() });
    assert_eq!(counters(&mut port), [1, 2, 7, 8, 9, 10]);
}

#[test]
fn what_is_sent_has_its_own_faults_and_the_port_its_own_errors() {
    let faults = vec![FrameFault { way: Way::Out, kind: FaultKind::Drop, when: Occurrence::Every(2) }];
    let datagrams = FaultPlan { seed: 3, faults };
    let mut port = faulty(PortFaultPlan { datagrams, ..PortFaultPlan::default() });
    for message in [b"one", b"two", b"six"] {
        port.send(ms(0), message).expect("taken");
    }
    assert_eq!(port.link.link.port.sent, [b"one", b"six"]);
    port.send(ms(0), b"lost").expect("taken");
    assert_eq!(port.send(ms(0), b"refuse").expect_err("refused").to_string(), "peer: refused");
}
