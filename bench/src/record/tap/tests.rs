//! Files of a tap, read back.

use std::path::Path;
use std::time::Duration;

use drivers::wire::ethercat::{EtherCatBus, EtherCatSettings};
use drivers::wire::{Fieldbus, FrameSink, StoredFrame, Tap, TappedFrame, Way};
use sim_devices::ethercat::{InProcessLink, Terminals};
use sim_devices::rig::{SeedAddress, SimulatedRig, StartState};
use sim_devices::unit::UnitSettings;

use super::{FRAMES, TapCounts, WireTap};
use crate::clock::Clock;

/// A frame of a capture.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Read {
    unix_ns: u64,
    way: Way,
    lost_before: u64,
    bytes: Vec<u8>,
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
}

/// Value of an option among those of a block.
fn option(mut options: &[u8], wanted: u16) -> Option<&[u8]> {
    loop {
        let head = word(options, 0);
        let [code, length] = [head as u16, (head >> 16) as u16];
        if code == 0 {
            return None;
        }
        let value = &options[4..4 + usize::from(length)];
        if code == wanted {
            return Some(value);
        }
        options = &options[4 + usize::from(length).next_multiple_of(4)..];
    }
}

/// All frames of a capture, the name of its interface, and the frames that its end says are missing.
fn pcapng(path: &Path) -> (String, Vec<Read>, Option<u64>) {
    let file = std::fs::read(path).expect("readable");
    let mut rest = &file[..];
    let (mut interface, mut frames, mut lost) = (String::new(), Vec::new(), None);
    let mut kinds = Vec::new();
    while !rest.is_empty() {
        let [kind, length] = [word(rest, 0), word(rest, 4)];
        let (block, behind) = rest.split_at(length as usize);
        assert_eq!(word(block, block.len() - 4), length, "the length stands at both ends");
        let body = &block[8..block.len() - 4];
        kinds.push(kind);
        match kind {
            0x0A0D_0D0A => assert_eq!(word(body, 0), 0x1A2B_3C4D),
            1 => {
                assert_eq!(option(&body[8..], 9), Some(&[9][..]), "nanoseconds");
                interface = String::from_utf8(option(&body[8..], 2).expect("named").to_vec()).expect("UTF-8");
            }
            6 => {
                let length = word(body, 12) as usize;
                assert_eq!(word(body, 16) as usize, length);
                let options = &body[20 + length.next_multiple_of(4)..];
                let way = match word(option(options, 2).expect("flags"), 0) {
                    1 => Way::Back,
                    2 => Way::Out,
                    other => panic!("direction {other}"),
                };
                let lost_before =
                    option(options, 4).map_or(0, |v| u64::from_le_bytes(v.try_into().expect("8")));
                frames.push(Read {
                    unix_ns: u64::from(word(body, 4)) << 32 | u64::from(word(body, 8)),
                    way,
                    lost_before,
                    bytes: body[20..20 + length].to_vec(),
                });
            }
            5 => lost = option(&body[12..], 5).map(|v| u64::from_le_bytes(v.try_into().expect("8"))),
            other => panic!("block {other:x}"),
        }
        rest = behind;
    }
    assert_eq!(kinds[..2], [0x0A0D_0D0A, 1]);
    (interface, frames, lost)
}

fn frame(at_ns: u64, way: Way, bytes: &[u8]) -> TappedFrame {
    let mut frame = StoredFrame::EMPTY;
    frame.keep(bytes);
    TappedFrame { at: Duration::from_nanos(at_ns), way, frame }
}

#[test]
fn both_files_hold_every_frame_as_it_was_with_time_and_direction() {
    let folder = tempfile::tempdir().expect("a folder");
    let paths = [folder.path().join("wire.pcapng"), folder.path().join("wire.mcap")];
    let tap = WireTap::create(&paths, "ecm7").expect("new files");
    let mut sink = tap.sink(&Clock::Virtual).expect("nobody else has it");
    assert!(tap.sink(&Clock::Virtual).is_none(), "one session at a time");
    let sizes = [14, 29, 60, 61, 62, 63, 1514];
    for (k, size) in sizes.into_iter().enumerate() {
        let way = if k % 2 == 0 { Way::Out } else { Way::Back };
        sink.take(&frame(1000 * k as u64 + 7, way, &vec![k as u8; size]));
    }
    drop(sink);
    assert!(tap.sink(&Clock::Virtual).is_some(), "the next session");
    assert_eq!(tap.finish(), Ok(TapCounts { frames: 7, lost: 0 }));
    let (interface, frames, lost) = pcapng(&paths[0]);
    assert_eq!((interface.as_str(), lost), ("ecm7", Some(0)));
    let start_ns = frames[0].unix_ns - 7;
    assert!(start_ns > 1_700_000_000_000_000_000, "after 2023: {start_ns}");
    for (k, found) in frames.iter().enumerate() {
        let way = if k % 2 == 0 { Way::Out } else { Way::Back };
        let expected = Read {
            unix_ns: start_ns + 1000 * k as u64 + 7,
            way,
            lost_before: 0,
            bytes: vec![k as u8; sizes[k]],
        };
        assert_eq!(*found, expected);
    }
    let bytes = std::fs::read(&paths[1]).expect("readable");
    let messages: Vec<mcap::Message<'_>> =
        mcap::MessageStream::new(&bytes).expect("MCAP").collect::<Result<_, _>>().expect("whole");
    assert_eq!(messages.len(), 7);
    for (message, found) in messages.iter().zip(&frames) {
        assert_eq!((message.channel.topic.as_str(), &message.data[..]), ("/wire", &found.bytes[..]));
        assert_eq!((message.log_time, message.publish_time), (found.unix_ns - start_ns, found.unix_ns));
        let direction = if found.way == Way::Out { "sent" } else { "received" };
        assert_eq!(message.channel.metadata["direction"], direction);
    }
}

#[test]
fn files_that_exist_are_left_alone_and_those_without_a_frame_are_taken_away() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("wire.pcapng");
    let empty = WireTap::create(std::slice::from_ref(&path), "ecm7").expect("a new file");
    assert!(path.exists());
    let error = WireTap::create(std::slice::from_ref(&path), "ecm7").err().expect("it exists");
    assert!(error.contains("wire.pcapng: "), "{error}");
    assert_eq!(empty.finish(), Ok(TapCounts::default()));
    assert!(!path.exists());
}

#[test]
fn a_full_ring_costs_frames_that_are_counted_and_never_waits() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("wire.pcapng");
    let tap = WireTap::create(std::slice::from_ref(&path), "ecm7").expect("a new file");
    let mut sink = tap.sink(&Clock::Virtual).expect("nobody else has it");
    let given = 8 * FRAMES as u64;
    for k in 0..given {
        sink.take(&frame(k, Way::Out, &[0; 1514]));
    }
    drop(sink);
    let counts = tap.finish().expect("written");
    assert_eq!(counts.frames + counts.lost, given);
    let (_, frames, lost) = pcapng(&path);
    assert_eq!((frames.len() as u64, lost), (counts.frames, Some(counts.lost)));
    assert!(frames.iter().map(|frame| frame.lost_before).sum::<u64>() <= counts.lost);
}

/// Data of the logical exchange in a frame.
fn process_data(frame: &[u8]) -> Option<&[u8]> {
    let mut at = 16;
    loop {
        let header = frame.get(at..at + 10)?;
        let length = u16::from_le_bytes([header[6], header[7]]);
        let end = at + 10 + usize::from(length & 0x07FF);
        match header[0] {
            12 => return frame.get(at + 10..end),
            _ if length & 0x8000 == 0 => return None,
            _ => at = end + 2,
        }
    }
}

#[test]
fn an_exchange_decoded_from_the_file_has_the_inputs_of_the_image() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("wire.pcapng");
    let tap = WireTap::create(std::slice::from_ref(&path), "wire").expect("a new file");
    let address = SeedAddress { seed: 3, procedure: "TEST".into(), point: "1".into() };
    let start = StartState { az_rad: -1.0, el_rad: 1.2, heat_sink_degc: 45.0 };
    let line = SimulatedRig::new(&UnitSettings::default(), &address, start)
        .ethercat_line(Terminals { analog: true, digital: false });
    let tapped = Tap::new(InProcessLink::new(line), tap.sink(&Clock::Virtual).expect("free"));
    let mut bus = EtherCatBus::open(Box::new(tapped), EtherCatSettings::usual("bus", 250e-6)).expect("there");
    let (mut image, slots) = bus.map().expect("the usual mapping");
    let mut images = Vec::new();
    for tick in 0..100_u32 {
        bus.exchange(Duration::from_secs(5) + Duration::from_micros(250) * tick, &mut image)
            .expect("a reply");
        images.push(image.inputs.clone());
    }
    drop(bus);
    assert_eq!(tap.finish().expect("written").lost, 0);
    let (_, frames, _) = pcapng(&path);
    let replies: Vec<&[u8]> =
        frames.iter().filter(|f| f.way == Way::Back).filter_map(|f| process_data(&f.bytes)).collect();
    assert_eq!(replies.len(), images.len());
    for (reply, image) in replies.iter().zip(&images) {
        for (station, slot) in &slots {
            assert_eq!(reply[slot.inputs.clone()], image[slot.inputs.clone()], "station {station}");
        }
    }
    assert!(images[99].iter().any(|&byte| byte != 0));
}
