//! Serial ports, as the subordinate ends of ptys.

use std::os::fd::OwnedFd;
use std::sync::Mutex;

use proptest::prelude::*;
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::tcgetattr;

use super::*;

/// The far end of a pty, which never blocks, and the path of the host's.
fn pty() -> (OwnedFd, String) {
    let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
    let far = openpt(flags).expect("a pty");
    grantpt(&far).and_then(|()| unlockpt(&far)).expect("unlocked");
    rustix::io::ioctl_fionbio(&far, true).expect("does not block");
    let path = ptsname(&far, Vec::new()).expect("a name").into_string().expect("ASCII");
    (far, path)
}

fn at_baud(path: &str, baud: u32) -> LineAddress {
    LineAddress::Serial { path: path.to_owned(), baud }
}

/// Opens the host's end, and listens.
fn opened(lines: &mut Lines, path: &str, baud: u32) -> HostLine {
    let mut line = lines.open_line(&at_baud(path, baud)).expect("opens");
    assert_eq!(line.read(now(), &mut [0; 8]), Ok(0));
    line
}

/// Writes everything to the far end, as fast as it is taken.
fn write_far(far: &OwnedFd, mut bytes: &[u8]) {
    wait_for("room", || {
        match rustix::io::write(far, bytes) {
            Ok(count) => bytes = &bytes[count..],
            Err(Errno::AGAIN) => {}
            Err(error) => panic!("{error}"),
        }
        bytes.is_empty().then_some(())
    });
}

/// Reads so many bytes at the far end.
fn read_far(far: &OwnedFd, count: usize) -> Vec<u8> {
    let mut all = Vec::new();
    wait_for("bytes at the far end", || {
        let mut piece = [0; 512];
        match rustix::io::read(far, &mut piece) {
            Ok(count) => all.extend(&piece[..count]),
            Err(Errno::AGAIN) => {}
            Err(error) => panic!("{error}"),
        }
        (all.len() >= count).then_some(())
    });
    all
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_through_a_pty_come_out_equal_and_in_order(
        pieces in prop::collection::vec(prop::collection::vec(any::<u8>(), 1..600), 1..8),
    ) {
        let (far, path) = pty();
        let mut lines = start();
        let mut line = opened(&mut lines, &path, 921_600);
        for piece in &pieces {
            line.write(now(), piece).expect("room");
            write_far(&far, piece);
        }
        let all = pieces.concat();
        prop_assert_eq!(&read_count(&mut line, all.len()), &all);
        prop_assert_eq!(&read_far(&far, all.len()), &all);
        prop_assert_eq!(line.lost_count(), 0);
    }
}

#[test]
fn bit_rates_without_a_name_are_set_exactly() {
    for baud in [9600, 374_400, 921_600, 1_843_200, 4_147_200] {
        let (far, path) = pty();
        let mut lines = start();
        let _line = opened(&mut lines, &path, baud);
        // The settings of a pty are those of its host's end, whichever end is asked.
        let settings = tcgetattr(&far).expect("a terminal");
        assert_eq!((settings.input_speed(), settings.output_speed()), (baud, baud));
    }
}

#[test]
fn what_arrives_before_the_first_call_is_thrown_away() {
    let (far, path) = pty();
    let mut lines = start();
    let mut line = lines.open_line(&at_baud(&path, 921_600)).expect("opens");
    write_far(&far, &pattern(20_000));
    nap(Duration::from_millis(300));
    assert_eq!(line.read(now(), &mut [0; 8]), Ok(0));
    write_far(&far, b"heard");
    assert_eq!(read_count(&mut line, 5), b"heard");
    assert_eq!(line.lost_count(), 0);
}

#[test]
fn bytes_have_arrived_when_they_were_received_and_not_before() {
    let (far, path) = pty();
    let mut lines = start();
    let mut line = opened(&mut lines, &path, 921_600);
    let before = now();
    write_far(&far, b"abc");
    // Once the first byte is there the others are, too: the pty hands them over together.
    let first = wait_for("a byte", || line.read(now(), &mut [0; 1]).ok().filter(|&count| count > 0));
    assert_eq!(first, 1);
    assert_eq!(line.read(before, &mut [0; 8]), Ok(0));
    assert_eq!(line.read(now(), &mut [0; 8]), Ok(2));
}

#[test]
fn an_unplugged_port_gives_what_had_arrived_and_then_says_so() {
    let (far, path) = pty();
    let mut lines = start();
    let mut line = opened(&mut lines, &path, 921_600);
    write_far(&far, b"last words");
    // Once the first byte is there the others are, too: the pty hands them over together.
    let first = wait_for("a byte", || line.read(now(), &mut [0; 1]).ok().filter(|&count| count > 0));
    assert_eq!(first, 1);
    drop(far);
    let (rest, text) = read_to_failure(&mut line);
    assert_eq!(rest, b"ast words");
    let expected =
        format!("serial:{path}?baud=921600: line: expected an open line, found one that was unplugged");
    assert!(text.starts_with(&expected), "{text}");
    assert!(text.ends_with("check plug and supply of the adapter, then start again"), "{text}");
    assert_eq!(line.write(now(), b"x").expect_err("gone").to_string(), text);
}

#[test]
fn a_full_ring_is_an_error_that_counts_what_was_lost_and_the_line_goes_on() {
    let (far, path) = pty();
    let mut lines = start();
    let mut line = opened(&mut lines, &path, 9600);
    let sent = pattern(30_000);
    write_far(&far, &sent);
    wait_for("a loss", || (line.lost_count() > 0).then_some(()));
    let mut kept: Vec<u8> = Vec::new();
    let mut errors_count = 0;
    wait_for("every byte, kept or counted", || {
        let mut piece = [0; 700];
        let lost_count = line.lost_count();
        match line.read(now(), &mut piece) {
            Ok(0) => return (kept.len() as u64 + lost_count == sent.len() as u64).then_some(()),
            Ok(count) => kept.extend(&piece[..count]),
            Err(error) => {
                errors_count += 1;
                let text = error.to_string();
                assert!(text.contains("received: expected everything to be read in time, found "), "{text}");
                assert!(text.contains(" lost because the ring of 8192 bytes was full, "), "{text}");
            }
        }
        None
    });
    assert!(errors_count > 0);
    assert_eq!(kept[..4000], sent[..4000], "what came before the loss");
    write_far(&far, b"and on");
    assert_eq!(read_count(&mut line, 6), b"and on");
}

#[test]
fn after_a_stall_of_the_thread_a_read_longer_than_the_ring_keeps_what_fits() {
    let (far, path) = pty();
    let stall = Arc::new(Mutex::new(()));
    let clock = {
        let stall = Arc::clone(&stall);
        move || {
            drop(stall.lock());
            now()
        }
    };
    let mut lines = Lines::start(Box::new(clock)).expect("a thread");
    let mut line = opened(&mut lines, &path, 9600);
    let sent = pattern(14_000);
    let stalled = stall.lock().expect("nobody panicked");
    write_far(&far, &sent[..1]);
    nap(Duration::from_millis(20));
    write_far(&far, &sent[1..]);
    nap(Duration::from_millis(20));
    drop(stalled);
    let lost_count = (sent.len() - LEAST_SERIAL_BYTES) as u64;
    wait_for("what the ring does not hold", || (line.lost_count() == lost_count).then_some(()));
    line.read(now(), &mut [0; 8]).expect_err("a loss is told");
    assert_eq!(read_count(&mut line, LEAST_SERIAL_BYTES), sent[..LEAST_SERIAL_BYTES]);
}

#[test]
fn a_far_end_that_takes_nothing_is_an_error_and_no_write_is_sent_in_part() {
    let (far, path) = pty();
    let mut lines = start();
    let mut line = opened(&mut lines, &path, 921_600);
    let piece = pattern(4096);
    let mut pieces_count = 0;
    let text = loop {
        match line.write(now(), &piece) {
            Ok(()) => pieces_count += 1,
            Err(error) => break error.to_string(),
        }
        assert!(pieces_count < 1000, "a pty takes everything");
    };
    assert!(text.contains("to be sent: expected room for 4096 bytes, found"), "{text}");
    assert_eq!(read_far(&far, pieces_count * piece.len()), piece.repeat(pieces_count));
    line.write(now(), b"room again").expect("room");
    assert_eq!(read_far(&far, 10), b"room again");
}

#[test]
fn what_was_written_goes_out_before_the_port_is_closed() {
    let (far, path) = pty();
    let mut lines = start();
    let mut line = opened(&mut lines, &path, 921_600);
    line.write(now(), &pattern(1000)).expect("room");
    drop(line);
    let begun = now();
    drop(lines);
    let took = now() - begun;
    assert!(took < PATIENCE, "{took:?}");
    assert_eq!(read_far(&far, 1000), pattern(1000));
}

#[test]
fn a_port_that_is_in_use_is_not_opened_twice_and_is_free_again_afterwards() {
    let (_far, path) = pty();
    let mut lines = start();
    let line = opened(&mut lines, &path, 921_600);
    let mut others = start();
    let text = others.open_line(&at_baud(&path, 921_600)).err().expect("refused").to_string();
    assert!(
        text.starts_with(&format!("serial:{path}?baud=921600: port: expected a serial port that")),
        "{text}"
    );
    assert!(text.contains("one that another program has open") && text.contains("`fuser -v`"), "{text}");
    drop((line, lines));
    opened(&mut others, &path, 921_600);
}

#[test]
fn a_path_without_a_serial_port_is_named_and_told_what_to_do() {
    let mut lines = start();
    let mut refused = |path: &str| lines.open_line(&at_baud(path, 9600)).err().expect("refused").to_string();
    let text = refused("/dev/no-such-port");
    assert!(text.starts_with("serial:/dev/no-such-port?baud=9600: port: expected a serial port"), "{text}");
    assert!(text.contains("No such file") && text.ends_with("correct the address in the rig file"), "{text}");
    let text = refused("/dev/null");
    assert!(text.contains("found something that is no serial port"), "{text}");
}
