//! The host's ends of lines are called in the tick, so they allocate nothing.
#![cfg(target_os = "linux")]

use std::io::Write;
use std::net::{TcpListener, UdpSocket};
use std::time::Duration;

use drivers::wire::lines::{LineAddress, Lines};
use drivers::wire::{ByteLine, DatagramPort};
use rustix::thread::{ClockId, clock_nanosleep_relative};
use rustix::time::Timespec;

/// Time for bytes to cross the loopback interface.
const CROSSING: Timespec = Timespec { tv_sec: 0, tv_nsec: 30_000_000 };

#[test]
fn reading_and_writing_a_line_and_a_port_allocate_nothing() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("bound");
    let device = UdpSocket::bind("127.0.0.1:0").expect("bound");
    let own = UdpSocket::bind("127.0.0.1:0").and_then(|free| free.local_addr()).expect("bound");
    let peers = [listener.local_addr(), device.local_addr()].map(|address| address.expect("bound"));
    let mut lines = Lines::start(Box::new(|| Duration::ZERO)).expect("a thread");
    let tcp = LineAddress::parse(&format!("tcp:{}", peers[0])).expect("an address");
    let udp = LineAddress::parse(&format!("udp:{}?bind={own}", peers[1])).expect("an address");
    let mut line = lines.open_line(&tcp).expect("connects");
    let mut port = lines.open_port(&udp).expect("opens");
    let mut bytes = [0; 64];
    assert_eq!(port.receive(Duration::ZERO, &mut bytes), Ok(None));
    let (mut far, _) = listener.accept().expect("connected");
    far.write_all(b"answer").expect("taken");
    device.send_to(b"datagram", own).expect("sent");
    let _ = clock_nanosleep_relative(ClockId::Monotonic, &CROSSING);
    let mut found = None;
    let counted = allocation_counter::measure(|| {
        let read = line.read(Duration::ZERO, &mut bytes);
        let received = port.receive(Duration::ZERO, &mut bytes);
        let nothing = (line.read(Duration::ZERO, &mut bytes), port.receive(Duration::ZERO, &mut bytes));
        let written = (line.write(Duration::ZERO, b"*IDN?\n"), port.send(Duration::ZERO, b"datagram"));
        found = Some((read, received, nothing, written));
    });
    assert_eq!(found, Some((Ok(6), Ok(Some(8)), (Ok(0), Ok(None)), (Ok(()), Ok(())))));
    assert_eq!((counted.count_total, counted.count_current), (0, 0));
}
