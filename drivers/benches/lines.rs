//! What the tick pays for a call of the host's end of a line. The aim for a read that finds nothing is 200 ns.

use std::io::Write;
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::time::Duration;

use divan::{Bencher, black_box};
use drivers::wire::lines::{HostLine, HostPort, LineAddress, Lines};
use drivers::wire::{ByteLine, DatagramPort};
use rustix::thread::{ClockId, clock_nanosleep_relative};
use rustix::time::{Timespec, clock_gettime};

/// Time in which the thread that moves bytes falls asleep.
const ASLEEP: Timespec = Timespec { tv_sec: 0, tv_nsec: 200_000 };
/// A message of an inertial unit.
const MESSAGE: [u8; 36] = [7; 36];

fn main() {
    divan::main();
}

fn now() -> Duration {
    let now = clock_gettime(ClockId::Monotonic);
    Duration::new(now.tv_sec.unsigned_abs(), u32::try_from(now.tv_nsec).expect("less than a second"))
}

fn rest() {
    let _ = clock_nanosleep_relative(ClockId::Monotonic, &ASLEEP);
}

fn line() -> (Lines, HostLine, TcpStream) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("bound");
    let port = listener.local_addr().expect("bound").port();
    let mut lines = Lines::start(Box::new(now)).expect("a thread");
    let address = LineAddress::Tcp { host: "127.0.0.1".to_owned(), port };
    let line = lines.open_line(&address).expect("connects");
    let (far, _) = listener.accept().expect("connected");
    far.set_nodelay(true).expect("set");
    (lines, line, far)
}

fn port() -> (Lines, HostPort, UdpSocket) {
    let far = UdpSocket::bind("127.0.0.1:0").expect("bound");
    let port = far.local_addr().expect("bound").port();
    let mut lines = Lines::start(Box::new(now)).expect("a thread");
    let bind = "127.0.0.1:0".parse().expect("an address");
    let address = LineAddress::Udp { host: "127.0.0.1".to_owned(), port, bind };
    let port = lines.open_port(&address).expect("opens");
    (lines, port, far)
}

#[divan::bench]
fn read_that_finds_nothing(bencher: Bencher<'_, '_>) {
    let (_lines, mut line, _far) = line();
    let mut bytes = [0; 128];
    bencher.bench_local(|| line.read(black_box(Duration::MAX), black_box(&mut bytes)));
}

#[divan::bench]
fn receive_that_finds_nothing(bencher: Bencher<'_, '_>) {
    let (_lines, mut port, _far) = port();
    let mut bytes = [0; 33];
    bencher.bench_local(|| port.receive(black_box(Duration::MAX), black_box(&mut bytes)));
}

#[divan::bench]
fn read_of_a_message(bencher: Bencher<'_, '_>) {
    let (_lines, mut line, mut far) = line();
    let mut bytes = [0; 128];
    let send = || {
        far.write_all(&MESSAGE).expect("taken");
        rest();
    };
    bencher.with_inputs(send).bench_local_values(|()| line.read(Duration::MAX, black_box(&mut bytes)));
}

/// With the call that wakes the thread, which has fallen asleep.
#[divan::bench]
fn write_of_a_message(bencher: Bencher<'_, '_>) {
    let (_lines, mut port, _far) = port();
    bencher.with_inputs(rest).bench_local_values(|()| port.send(Duration::ZERO, black_box(&MESSAGE)));
}
