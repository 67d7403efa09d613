//! What foreign MainDevices sent, sent again: the same working counters come back, and OP is reached.

use std::collections::BTreeSet;
use std::time::Duration;

use super::super::line::EtherCatLine;
use super::bench::answers;
use super::faults::unnumbered;

const SLAVEINFO: &str = include_str!("../../../tests/data/ethercat/soem-slaveinfo.txt");
const EC_SAMPLE: &str = include_str!("../../../tests/data/ethercat/soem-ec_sample.txt");
const KICKCAT: &str = include_str!("../../../tests/data/ethercat/kickcat.txt");
const KICKCAT_DC: &str = include_str!("../../../tests/data/ethercat/kickcat-dc.txt");

/// A frame of a record.
struct Sent {
    at: Duration,
    counters: Vec<u16>,
    frame: Vec<u8>,
}

fn parse(line: &str) -> Sent {
    let fields: Vec<&str> = line.split(' ').collect();
    let [at_us, counters, body] = fields[..] else { panic!("expected three fields: {line}") };
    let mut frame = vec![0xFF; 6];
    frame.extend([0x02; 6]);
    frame.extend([0x88, 0xA4]);
    let mut rest = body;
    while !rest.is_empty() {
        if let Some(zeros) = rest.strip_prefix('z') {
            let (count, behind) = zeros.split_once('.').expect("a point behind the number of zeros");
            frame.resize(frame.len() + count.parse::<usize>().expect("a number"), 0);
            rest = behind;
        } else {
            let (byte, behind) = rest.split_at(2);
            frame.push(u8::from_str_radix(byte, 16).expect("two digits"));
            rest = behind;
        }
    }
    frame.resize(frame.len().max(60), 0);
    Sent {
        at: Duration::from_micros(at_us.parse().expect("a number")),
        counters: counters.split(',').map(|counter| counter.parse().expect("a counter")).collect(),
        frame,
    }
}

/// What a record showed when it was sent again.
#[derive(Debug, Default, PartialEq, Eq)]
struct Seen {
    /// AL states that were read, of one device or of all.
    states: BTreeSet<u8>,
    /// Working counters of LRW, LRD and LWR, and how many frames had each command.
    cyclic: BTreeSet<(u8, u16)>,
    frames: usize,
}

fn send_again(record: &str) -> Seen {
    let mut line = unnumbered().1;
    let mut seen = Seen::default();
    for (k, sent) in record.lines().map(parse).enumerate() {
        let mut frame = sent.frame.clone();
        // Somebody looks at the line each millisecond, as the process in front of it does.
        line.advance(sent.at.saturating_sub(Duration::from_micros(50)));
        let passage = line.pass(sent.at, &mut frame);
        assert_eq!((passage.answers, passage.bytes), (1, frame.len()), "frame {k}");
        let answers = answers(&frame);
        let counters: Vec<u16> = answers.iter().map(|answer| answer.counter).collect();
        assert_eq!(counters, sent.counters, "frame {k}");
        let mut at = 16;
        for answer in answers {
            let command = frame[at];
            if (frame[at + 4], frame[at + 5]) == (0x30, 0x01) && answer.counter > 0 {
                seen.states.insert(answer.data[0]);
            }
            if (10..=12).contains(&command) {
                seen.cyclic.insert((command, answer.counter));
            }
            at += 12 + answer.data.len();
        }
        seen.frames += 1;
    }
    seen
}

#[test]
fn slaveinfo_of_soem_reads_all_devices_and_brings_them_to_safe_op() {
    let seen = send_again(SLAVEINFO);
    assert!(seen.states.contains(&4), "{:?}", seen.states);
    assert!(seen.frames > 500);
}

#[test]
fn ec_sample_of_soem_reaches_op_and_every_cycle_counts_9() {
    let seen = send_again(EC_SAMPLE);
    assert!(seen.states.is_superset(&BTreeSet::from([2, 4, 8])), "{:?}", seen.states);
    // Three devices with outputs and inputs; the mailbox states are inputs of the same drives.
    assert_eq!(seen.cyclic, BTreeSet::from([(12, 9)]));
}

#[test]
fn kickcat_reaches_op_with_mailbox_states_in_single_bits() {
    let seen = send_again(KICKCAT);
    assert!(seen.states.is_superset(&BTreeSet::from([2, 4, 8])), "{:?}", seen.states);
    assert!(seen.cyclic.contains(&(12, 9)), "{:?}", seen.cyclic);
}

#[test]
fn kickcat_reaches_op_with_sync0() {
    let seen = send_again(KICKCAT_DC);
    assert!(seen.states.is_superset(&BTreeSet::from([2, 4, 8])), "{:?}", seen.states);
    assert_eq!(seen.cyclic, BTreeSet::from([(10, 3), (11, 3)]));
    assert!(!seen.states.contains(&0x14), "no device leaves OP");
}
