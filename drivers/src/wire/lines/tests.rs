//! Lines against far ends of the operating system: ptys and sockets on the loopback interface.

mod serial;
mod tcp;
mod udp;

use std::time::Duration;

use rustix::thread::{ClockId, clock_nanosleep_relative};
use rustix::time::{Timespec, clock_gettime};

use super::super::{ByteLine, DatagramPort};
use super::*;

/// Longest wait for something that comes at once on an idle computer.
const PATIENCE: Duration = Duration::from_secs(5);

fn now() -> Duration {
    let now = clock_gettime(ClockId::Monotonic);
    Duration::new(now.tv_sec.unsigned_abs(), u32::try_from(now.tv_nsec).expect("less than a second"))
}

fn nap(time: Duration) {
    let time = Timespec { tv_sec: 0, tv_nsec: time.subsec_nanos().into() };
    let _ = clock_nanosleep_relative(ClockId::Monotonic, &time);
}

/// Waits until there is something.
fn wait_for<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let begun = now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(now() - begun < PATIENCE, "{what} did not come");
        nap(Duration::from_micros(200));
    }
}

fn start() -> Lines {
    Lines::start(Box::new(now)).expect("a thread")
}

fn address(text: &str) -> LineAddress {
    LineAddress::parse(text).expect("an address")
}

/// Reads until so many bytes are there.
fn read_count(line: &mut HostLine, count: usize) -> Vec<u8> {
    let mut all = Vec::new();
    wait_for("the rest of the bytes", || {
        let mut piece = [0; 700];
        let count_now = line.read(now(), &mut piece).expect("the line is open");
        all.extend(&piece[..count_now]);
        (all.len() >= count).then_some(())
    });
    all
}

/// Reads until the line fails: what came before, and the error.
fn read_to_failure(line: &mut HostLine) -> (Vec<u8>, String) {
    let mut all = Vec::new();
    let text = wait_for("the failure", || {
        let mut piece = [0; 700];
        match line.read(now(), &mut piece) {
            Ok(count) => {
                all.extend(&piece[..count]);
                None
            }
            Err(error) => Some(error.to_string()),
        }
    });
    (all, text)
}

/// Numbers from 0 on, modulo a prime: a byte that is missing or in another place shows.
fn pattern(count: usize) -> Vec<u8> {
    (0..count).map(|k| (k % 251) as u8).collect()
}

#[test]
fn closing_the_lines_takes_a_bounded_time_and_every_host_end_says_so() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("bound");
    let port = listener.local_addr().expect("bound").port();
    let mut lines = start();
    let mut line = lines.open_line(&address(&format!("tcp:127.0.0.1:{port}"))).expect("connects");
    // More than the far end, which reads nothing, and the kernel take.
    let piece = pattern(32 << 10);
    while line.write(now(), &piece).is_ok() {}
    let begun = now();
    drop(lines);
    let took = now() - begun;
    assert!(took < PATIENCE, "{took:?}");
    let text = line.write(now(), b"x").expect_err("closed").to_string();
    assert!(
        text.ends_with("expected an open line, found one that this program closed; open it again"),
        "{text}"
    );
}

#[test]
fn a_line_is_no_port_and_a_port_is_no_line() {
    let mut lines = start();
    let udp = address("udp:127.0.0.1:6000?bind=127.0.0.1:0");
    let text = lines.open_line(&udp).err().expect("refused").to_string();
    assert!(text.contains("expected a line of bytes, found a port of datagrams"), "{text}");
    let tcp = address("tcp:127.0.0.1:6000");
    let text = lines.open_port(&tcp).err().expect("refused").to_string();
    assert!(text.contains("expected a port of datagrams, found a line of bytes"), "{text}");
}
