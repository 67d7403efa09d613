//! Faults on a line that gives back what it is given.

use proptest::prelude::*;

use super::*;

#[derive(Default)]
struct Echo {
    sent: Vec<u8>,
    arriving: VecDeque<u8>,
    /// Whether it fails once everything was read.
    is_gone: bool,
}

impl ByteLine for Echo {
    fn name(&self) -> &str {
        "echo"
    }

    fn read(&mut self, _: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        if self.is_gone && self.arriving.is_empty() {
            return Err(DeviceError::Bus { device: "echo".to_owned(), reason: "unplugged".to_owned() });
        }
        let count = self.arriving.len().min(into.len());
        into.iter_mut().zip(self.arriving.drain(..count)).for_each(|(place, byte)| *place = byte);
        Ok(count)
    }

    fn write(&mut self, _: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        self.sent.extend(bytes);
        self.arriving.extend(bytes);
        Ok(())
    }
}

fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

fn faulty(seed: u64, faults: &[ByteLineFault]) -> FaultyByteLine<Echo> {
    let control = Arc::new(ByteFaultControl::default());
    control.begin();
    FaultyByteLine::new(Echo::default(), ByteLineFaultPlan { seed, faults: faults.to_vec() }, control)
}

fn fault(way: Way, kind: ByteFaultKind, when: Occurrence) -> ByteLineFault {
    ByteLineFault { way, kind, when }
}

/// Everything that can be read, in pieces of this size.
fn read_all(line: &mut FaultyByteLine<Echo>, now: Duration, piece_bytes: usize) -> Vec<u8> {
    let mut all = Vec::new();
    let mut piece = vec![0; piece_bytes];
    loop {
        let count = line.read(now, &mut piece).expect("the line is there");
        all.extend(&piece[..count]);
        // A buffer that was not filled means that nothing more is waiting.
        if count < piece_bytes {
            return all;
        }
    }
}

#[test]
fn nothing_is_touched_before_the_faults_begin() {
    let control = Arc::new(ByteFaultControl::default());
    let faults = vec![fault(Way::Back, ByteFaultKind::Drop, Occurrence::Chance(1.0))];
    let plan = ByteLineFaultPlan { seed: 1, faults };
    let mut line = FaultyByteLine::new(Echo::default(), plan, Arc::clone(&control));
    line.write(ms(0), b"abc").expect("taken");
    assert_eq!(read_all(&mut line, ms(0), 8), b"abc");
    control.begin();
    line.write(ms(0), b"abc").expect("taken");
    assert_eq!(read_all(&mut line, ms(0), 8), b"");
    let all_lost = ByteFaultCounts { bytes: 3, dropped: 3, ..ByteFaultCounts::default() };
    assert_eq!(control.counts(Way::Back), all_lost);
}

#[test]
fn half_a_frame_is_lost_and_the_rest_comes() {
    let when = Occurrence::At { first: 4, count: 3 };
    let mut line = faulty(1, &[fault(Way::Back, ByteFaultKind::Drop, when)]);
    line.write(ms(0), b"frame1frame2").expect("taken");
    assert_eq!(read_all(&mut line, ms(0), 5), b"fraframe2".as_slice());
    let mut line = faulty(1, &[fault(Way::Out, ByteFaultKind::Drop, when)]);
    line.write(ms(0), b"frame1frame2").expect("taken");
    assert_eq!(line.line.sent, b"fraframe2");
    assert_eq!(
        line.control.counts(Way::Out),
        ByteFaultCounts { bytes: 12, dropped: 3, corrupted: 0, inserted: 0 }
    );
}

#[test]
fn garbage_comes_before_the_byte_that_it_is_planted_at() {
    let kind = ByteFaultKind::Insert { bytes: 300 };
    let mut line = faulty(1, &[fault(Way::Back, kind, Occurrence::At { first: 3, count: 1 })]);
    line.write(ms(0), b"abcd").expect("taken");
    let all = read_all(&mut line, ms(0), 7);
    assert_eq!((all.len(), &all[..2], &all[302..]), (304, b"ab".as_slice(), b"cd".as_slice()));
    let garbage = &all[2..302];
    let values_count = (0..=u8::MAX).filter(|value| garbage.contains(value)).count();
    assert!(values_count > 100, "{values_count} values in 300 bytes");
    assert_eq!(line.control.counts(Way::Back).inserted, 300);
}

#[test]
fn silence_ends_after_its_time() {
    let kind = ByteFaultKind::Silence { lasts: ms(10) };
    let mut line = faulty(1, &[fault(Way::Back, kind, Occurrence::At { first: 2, count: 1 })]);
    let mut heard = Vec::new();
    for (k, byte) in (0_u64..).zip(*b"abcdefgh") {
        line.write(ms(4 * k), &[byte]).expect("taken");
        heard.extend(read_all(&mut line, ms(4 * k), 8));
    }
    assert_eq!(heard, b"aefgh", "b, c, d at 4, 8 and 12 ms");
}

#[test]
fn an_error_behind_bytes_is_told_after_them() {
    let mut line = faulty(1, &[fault(Way::Back, ByteFaultKind::Drop, Occurrence::Every(2))]);
    line.write(ms(0), b"abcd").expect("taken");
    line.line.is_gone = true;
    let mut bytes = [0; 8];
    assert_eq!(line.read(ms(0), &mut bytes), Ok(2));
    assert!(line.read(ms(0), &mut bytes).is_err() && line.read(ms(0), &mut bytes).is_err());
}

#[test]
fn chance_hits_as_many_bytes_as_it_says() {
    let mut line = faulty(7, &[fault(Way::Out, ByteFaultKind::Corrupt, Occurrence::Chance(0.1))]);
    line.write(ms(0), &[0; 100_000]).expect("taken");
    let wrong: Vec<u8> = line.line.sent.iter().copied().filter(|&byte| byte != 0).collect();
    // Four standard deviations of a binomial distribution.
    assert!(
        (wrong.len() as f64 - 10_000.0).abs() < 4.0 * (100_000.0_f64 * 0.1 * 0.9).sqrt(),
        "{}",
        wrong.len()
    );
    assert!(wrong.iter().all(|byte| byte.count_ones() == 1));
    assert_eq!(line.control.counts(Way::Out).corrupted, wrong.len() as u64);
}

proptest! {
    /// However the stream is cut, the same bytes have the same faults.
    #[test]
    fn faults_do_not_depend_on_how_the_stream_is_cut(
        seed in any::<u64>(),
        bytes in prop::collection::vec(any::<u8>(), 0..400),
        cut in 1_usize..90,
        room_bytes in 1_usize..90,
    ) {
        let faults = [
            fault(Way::Back, ByteFaultKind::Drop, Occurrence::Chance(0.1)),
            fault(Way::Back, ByteFaultKind::Corrupt, Occurrence::Every(5)),
            fault(Way::Back, ByteFaultKind::Insert { bytes: 3 }, Occurrence::Chance(0.05)),
            fault(Way::Out, ByteFaultKind::Drop, Occurrence::Every(7)),
        ];
        let mut whole = faulty(seed, &faults);
        whole.write(ms(0), &bytes).expect("taken");
        let mut pieces = faulty(seed, &faults);
        let mut heard = Vec::new();
        for piece in bytes.chunks(cut) {
            pieces.write(ms(0), piece).expect("taken");
            heard.extend(read_all(&mut pieces, ms(0), room_bytes));
        }
        prop_assert_eq!(&pieces.line.sent, &whole.line.sent);
        prop_assert_eq!(heard, read_all(&mut whole, ms(0), 1000));
        prop_assert_eq!(pieces.control.counts(Way::Back), whole.control.counts(Way::Back));
    }
}
