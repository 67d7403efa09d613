//! Damage is found, named and placed; what is whole is still read; nothing panics.

use std::cell::RefCell;
use std::io::{self, BufWriter, Cursor, Seek, Write};
use std::path::Path;
use std::rc::Rc;

use proptest::prelude::*;

use super::{MS, axis_row, finished, open, plan, started, topics, two_points, windows};
use crate::log::{Event, LogError, LogReader, LogWriter, PointStatus, Window};

/// A sink that others see while it is written, and that is full after a while.
#[derive(Clone)]
struct Disk {
    bytes: Rc<RefCell<Vec<u8>>>,
    free: usize,
}

impl Disk {
    fn new(free: usize) -> Self {
        Self { bytes: Rc::default(), free }
    }
}

impl Write for Disk {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        let mut bytes = self.bytes.borrow_mut();
        if bytes.len() + data.len() > self.free {
            return Err(io::Error::from(io::ErrorKind::StorageFull));
        }
        bytes.extend_from_slice(data);
        Ok(data.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Disk {
    fn seek(&mut self, _: io::SeekFrom) -> io::Result<u64> {
        Err(io::Error::other("a log is written from front to back"))
    }
}

/// Rows every millisecond of a point that never ends.
fn write_rows<W: Write + Seek>(log: &mut LogWriter<W>, rows: u64) -> Result<(), LogError> {
    log.event(0, &Event::PointStarted { point: 0 })?;
    (0..rows).try_for_each(|k| log.row(0, k * MS, &axis_row(0)))
}

#[test]
fn a_killed_writer_leaves_all_but_the_last_quarter_second() {
    let disk = Disk::new(usize::MAX);
    let sink = BufWriter::with_capacity(1 << 20, disk.clone());
    let mut log = LogWriter::new(sink, &plan(), &topics(), &[]).expect("memory takes everything");
    write_rows(&mut log, 600).expect("memory takes everything");
    let killed = disk.bytes.borrow().clone();
    log.flush().expect("memory takes everything");
    let flushed = disk.bytes.borrow().clone();
    std::mem::forget(log);
    for (bytes, rows) in [(killed, 500), (flushed, 600)] {
        let (windows, damage) = windows(&bytes);
        assert_eq!((windows.len(), windows[0].status), (1, PointStatus::Lost));
        assert_eq!(windows[0].topics[0].time_s.len(), rows);
        let size = bytes.len();
        let expected = format!(
            "a.mcap: damaged: cut off: expected 9 more bytes, found 0 (record at byte {size} of {size})"
        );
        assert_eq!(damage, Some(expected));
    }
}

#[test]
fn a_full_disk_is_an_error_and_what_was_written_is_read() {
    let disk = Disk::new(20_000);
    let mut log = LogWriter::new(disk.clone(), &plan(), &topics(), &[]).expect("the front fits");
    let error = write_rows(&mut log, 100_000).expect_err("the rows do not fit").to_string();
    assert_eq!(error, format!("AZ-FRICTION.mcap: {}", io::Error::from(io::ErrorKind::StorageFull)));
    assert!(log.row(0, 1 << 50, &axis_row(0)).is_err());
    assert!(log.finish().is_err());
    let (windows, damage) = windows(&disk.bytes.borrow());
    assert_eq!(windows[0].status, PointStatus::Lost);
    assert!(windows[0].topics[0].time_s.len() >= 250);
    assert!(damage.is_some());
}

#[test]
fn a_chunk_that_breaks_off_gives_none_of_its_rows() {
    let bytes = two_points(600);
    let summary = mcap::Summary::read(&bytes).expect("the summary is whole").expect("there is a summary");
    let third = usize::try_from(summary.chunk_indexes[2].chunk_start_offset).expect("a small file");
    let (windows, damage) = windows(&bytes[..third + 40]);
    assert_eq!(windows[0].topics[0].time_s.len(), 500);
    insta::assert_snapshot!(damage.expect("the file breaks off"), @r"
    a.mcap: damaged: cut off: expected 3167 more bytes, found 31 (record at byte 38649 of 38689)
    ");
}

#[test]
fn files_open_by_their_path() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/log");
    let log = LogReader::open(&here.join("snapshots/procedures__log__tests__written.snap.mcap"));
    assert_eq!(log.expect("the snapshot is whole").plan(), &plan());
    assert!(matches!(LogReader::open(&here.join("nowhere.mcap")), Err(LogError::Io { .. })));
    assert!(matches!(LogReader::open(&here), Err(LogError::Io { .. })));
    assert!(matches!(LogReader::open(&here.join("tests.rs")), Err(LogError::Foreign { .. })));
}

#[test]
fn a_dropped_writer_leaves_a_lost_point() {
    let mut sink = Cursor::new(Vec::new());
    let mut log = LogWriter::new(&mut sink, &plan(), &topics(), &[]).expect("memory takes everything");
    log.event(0, &Event::PointStarted { point: 3 }).expect("memory takes everything");
    log.row(0, MS, &axis_row(0)).expect("memory takes everything");
    drop(log);
    let (windows, damage) = windows(&sink.into_inner());
    assert_eq!(
        (windows[0].point, windows[0].status, windows[0].topics[0].time_s.len()),
        (3, PointStatus::Lost, 1)
    );
    insta::assert_snapshot!(damage.expect("the point has no end"), @r"
    a.mcap: damaged: ends inside point 3, without its point-ended event (record at byte 7884 of 7892)
    ");
}

#[test]
fn a_flipped_bit_in_a_chunk_loses_its_rows_and_says_where() {
    let mut bytes = two_points(600);
    let summary = mcap::Summary::read(&bytes).expect("the summary is whole").expect("there is a summary");
    let fourth = &summary.chunk_indexes[4];
    let middle = usize::try_from(fourth.chunk_start_offset + fourth.chunk_length / 2).expect("a small file");
    bytes[middle] ^= 0x10;
    let (windows, damage) = windows(&bytes);
    assert_eq!(
        windows.iter().map(|w| w.status).collect::<Vec<_>>(),
        [PointStatus::Completed, PointStatus::Lost]
    );
    assert_eq!(windows[1].topics[0].time_s.len(), 250);
    insta::assert_snapshot!(damage.expect("the checksum differs"), @r"
    a.mcap: damaged: checksum of a chunk: expected 0837c861, found c9565f81 (record at byte 61264 of 85462)
    ");
}

#[test]
fn files_of_others_are_refused_with_what_was_expected() {
    let refused = |bytes: &[u8]| open(bytes).expect_err("this is no log of ours").to_string();
    let python = refused(include_bytes!("../../../../tests/data/log/foreign.mcap"));
    let mut later = plan();
    later.schema = 9;
    let later =
        LogWriter::new(Cursor::new(Vec::new()), &later, &topics(), &[]).expect("memory takes everything");
    let messages = [
        refused(b""),
        refused(b"time,x\n0,1\n"),
        refused(&two_points(10)[..40]),
        python,
        refused(&finished(later)),
    ];
    insta::assert_snapshot!(messages.join("\n"), @r"
    a.mcap: not an MCAP file: expected `\x89MCAP0\r\n` at its start, found ``
    a.mcap: not an MCAP file: expected `\x89MCAP0\r\n` at its start, found `time,x\n0`
    a.mcap: damaged: cut off: expected 9 more bytes, found 6 (record at byte 34 of 40)
    a.mcap: expected a log with attachment `plan.json`, found an MCAP file of `mcap-python/1.6.0` without it
    a.mcap: `plan.json`: expected schema 1, found 9
    ");
}

#[test]
fn events_out_of_order_end_the_reading() {
    let mut log = started();
    log.event(0, &Event::PointStarted { point: 0 }).expect("memory takes everything");
    log.event(MS, &Event::PointEnded { point: 1, status: PointStatus::Completed })
        .expect("memory takes everything");
    let (windows, damage) = windows(&finished(log));
    assert_eq!(windows.iter().map(|w| (w.point, w.status)).collect::<Vec<_>>(), [(0, PointStatus::Lost)]);
    insta::assert_snapshot!(damage.expect("the events do not match"), @r"
    a.mcap: damaged: event out of order inside point 0: PointEnded { point: 1, status: Completed } (record at byte 6557 of 8042)
    ");
}

#[test]
fn a_chunk_that_no_longer_looks_like_one_is_missed_at_its_place() {
    let bytes = two_points(600);
    let summary = mcap::Summary::read(&bytes).expect("the summary is whole").expect("there is a summary");
    let second = usize::try_from(summary.chunk_indexes[1].chunk_start_offset).expect("a small file");
    for opcode in (0..=255).filter(|&o| o != mcap::records::op::CHUNK) {
        let mut damaged = bytes.clone();
        damaged[second] = opcode;
        let (windows, damage) = windows(&damaged);
        assert_eq!((windows.len(), windows[0].status), (1, PointStatus::Lost), "type {opcode}");
        assert_eq!(windows[0].topics[0].time_s.len(), 250);
        assert!(damage.expect("a chunk is missing").contains(&format!("byte {second} of")));
    }
}

/// What a reader gives: all windows and the damage, or the reason why it does not open.
fn outcome(bytes: &[u8]) -> Result<(Vec<Window>, Option<String>), String> {
    open(bytes).map_err(|e| e.to_string()).map(|mut log| {
        let windows = std::iter::from_fn(|| log.next_window()).collect();
        (windows, log.damage().map(ToString::to_string))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn every_flipped_byte_is_found_and_no_row_is_wrong(at: prop::sample::Index, flip in 1_u8..) {
        let mut bytes = two_points(300);
        let (whole, _) = windows(&bytes);
        let rows_at = bytes.windows(4).position(|w| w == b"zstd").expect("there is a chunk");
        let at = at.index(bytes.len());
        bytes[at] ^= flip;
        let found = outcome(&bytes);
        prop_assert!(found.is_ok() || at < rows_at + 8, "byte {at}: {:?}", found.err());
        if let Ok((found, damage)) = found {
            prop_assert!(damage.is_some(), "byte {at} went unnoticed");
            for (window, original) in found.iter().zip(&whole) {
                prop_assert!(window.status == PointStatus::Lost || window == original);
                for (rows, all) in window.topics.iter().zip(&original.topics) {
                    prop_assert_eq!(&rows.time_s[..], &all.time_s[..rows.time_s.len()]);
                    prop_assert_eq!(&rows.columns[0][..], &all.columns[0][..rows.time_s.len()]);
                }
            }
        }
    }

    #[test]
    fn every_cut_is_found(at: prop::sample::Index) {
        let bytes = two_points(300);
        let at = at.index(bytes.len());
        if let Ok((windows, damage)) = outcome(&bytes[..at]) {
            prop_assert!(damage.is_some());
            prop_assert!(windows.len() <= 2);
        }
    }

    #[test]
    fn nonsense_neither_panics_nor_eats_memory(
        at: prop::sample::Index,
        nonsense in prop::collection::vec(prop_oneof![Just(0xff_u8), any::<u8>()], 1..40),
    ) {
        let mut bytes = two_points(20);
        let at = at.index(bytes.len());
        let end = (at + nonsense.len()).min(bytes.len());
        bytes.splice(at..end, nonsense);
        let tail = outcome(&bytes[at.min(bytes.len())..]);
        prop_assert!(at == 0 || tail.is_err(), "a log without its beginning");
        if let Ok((windows, damage)) = outcome(&bytes) {
            prop_assert!(damage.is_some() || bytes == two_points(20));
            prop_assert!(windows.iter().all(|w| w.topics[0].time_s.len() <= 20));
        }
    }
}
