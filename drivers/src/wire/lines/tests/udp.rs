//! Datagrams to and from sockets on the loopback interface.

use std::net::UdpSocket;

use super::*;

/// A port, listening, and the device's socket.
fn connected(lines: &mut Lines) -> (HostPort, UdpSocket) {
    let far = UdpSocket::bind("127.0.0.1:0").expect("bound");
    let free = UdpSocket::bind("127.0.0.1:0").and_then(|free| free.local_addr()).expect("bound");
    let peer = far.local_addr().expect("bound");
    let mut port = lines.open_port(&address(&format!("udp:{peer}?bind={free}"))).expect("opens");
    far.connect(free).expect("connected");
    assert_eq!(port.receive(now(), &mut [0; 8]), Ok(None));
    (port, far)
}

fn next(port: &mut HostPort, room_bytes: usize) -> Vec<u8> {
    let mut bytes = vec![0; room_bytes];
    let count = wait_for("a datagram", || port.receive(now(), &mut bytes).expect("open"));
    bytes.truncate(count);
    bytes
}

#[test]
fn datagrams_go_both_ways_whole_and_in_order() {
    let mut lines = start();
    let (mut port, far) = connected(&mut lines);
    for length in [1, 0, 32, 1472, 60_000] {
        far.send(&pattern(length)).expect("sent");
        assert_eq!(next(&mut port, 65_536), pattern(length));
        port.send(now(), &pattern(length)).expect("room");
        let mut heard = vec![0; 65_536];
        let count = far.recv(&mut heard).expect("sent");
        assert_eq!(heard[..count], pattern(length));
    }
    let text = port.send(now(), &[0; 65_508]).expect_err("too long").to_string();
    assert!(text.contains("expected at most 65507 bytes in a datagram, found 65508"), "{text}");
}

#[test]
fn what_is_longer_than_its_place_is_cut_off_and_the_next_one_is_whole() {
    let mut lines = start();
    let (mut port, far) = connected(&mut lines);
    far.send(&pattern(100)).expect("sent");
    far.send(b"next").expect("sent");
    assert_eq!(next(&mut port, 33), pattern(33));
    assert_eq!(next(&mut port, 33), b"next");
}

#[test]
fn datagrams_of_others_are_not_taken() {
    let mut lines = start();
    let (mut port, far) = connected(&mut lines);
    let own = far.peer_addr().expect("connected");
    let other = UdpSocket::bind("127.0.0.1:0").expect("bound");
    other.send_to(b"foreign", own).expect("sent");
    far.send(b"own").expect("sent");
    assert_eq!(next(&mut port, 64), b"own");
    nap(Duration::from_millis(20));
    assert_eq!(port.receive(now(), &mut [0; 64]), Ok(None));
}

#[test]
fn a_peer_that_does_not_listen_is_told_once_and_the_port_goes_on() {
    let mut lines = start();
    let (mut port, far) = connected(&mut lines);
    let (peer, own) = (far.local_addr().expect("bound"), far.peer_addr().expect("connected"));
    drop(far);
    port.send(now(), b"anybody?").expect("room");
    let text = wait_for("the refusal", || port.receive(now(), &mut [0; 8]).err()).to_string();
    assert!(text.contains("found no listener (ICMP port unreachable); check address and port"), "{text}");
    let far = UdpSocket::bind(peer).expect("bound again");
    far.connect(own).expect("connected");
    far.send(b"here").expect("sent");
    assert_eq!(next(&mut port, 8), b"here");
}

#[test]
fn a_full_ring_loses_datagrams_with_a_count_and_an_error() {
    let mut lines = start();
    let (mut port, far) = connected(&mut lines);
    // Slowly, so that the kernel's own buffer loses none.
    let most_count = SOCKET_RING.bytes / 4096 + 10;
    for _ in 0..most_count {
        far.send(&pattern(4096)).expect("sent");
        nap(Duration::from_millis(3));
    }
    wait_for("the losses", || (port.lost_count() == 10).then_some(()));
    let text = port.receive(now(), &mut [0; 8]).expect_err("lost").to_string();
    assert!(
        text.contains("found 10 lost because the ring of 262144 bytes was full, 10 since the start"),
        "{text}"
    );
    assert_eq!(next(&mut port, 4096), pattern(4096));
}

#[test]
fn an_own_address_that_is_taken_or_foreign_is_named() {
    let taken = UdpSocket::bind("127.0.0.1:0").expect("bound");
    let own = taken.local_addr().expect("bound");
    let mut lines = start();
    let mut refused = |bind: String| {
        let address = address(&format!("udp:127.0.0.1:6000?bind={bind}"));
        lines.open_port(&address).err().expect("refused").to_string()
    };
    let text = refused(own.to_string());
    assert!(
        text.contains(&format!("bind: expected {own} to be free, found Address already in use")),
        "{text}"
    );
    assert!(refused("192.0.2.1:6001".to_owned()).contains("`ip address` shows"));
    assert!(
        refused("[::1]:6001".to_owned()).contains("expected an address of the same IP version as [::1]:6001")
    );
}
