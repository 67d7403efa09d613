//! TCP connections to a listener on the loopback interface.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};

use super::*;

/// A connection: the host's end, and the device's.
fn connected(lines: &mut Lines) -> (HostLine, TcpStream) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("bound");
    let port = listener.local_addr().expect("bound").port();
    let line = lines.open_line(&address(&format!("tcp:127.0.0.1:{port}"))).expect("connects");
    let (far, _) = listener.accept().expect("connected");
    (line, far)
}

#[test]
fn bytes_go_both_ways() {
    let mut lines = start();
    let (mut line, mut far) = connected(&mut lines);
    line.write(now(), b"*IDN?\n").expect("room");
    let mut heard = [0; 6];
    far.read_exact(&mut heard).expect("sent");
    assert_eq!(&heard, b"*IDN?\n");
    far.write_all(b"maker,model,1,2\n").expect("taken");
    assert_eq!(read_count(&mut line, 16), b"maker,model,1,2\n");
}

#[test]
fn a_host_that_does_not_read_holds_the_device_up_and_loses_nothing() {
    let mut lines = start();
    let (mut line, mut far) = connected(&mut lines);
    let sent = pattern(3 << 20);
    let sending = std::thread::spawn({
        let sent = sent.clone();
        move || far.write_all(&sent).map(|()| far)
    });
    nap(Duration::from_millis(50));
    assert!(read_count(&mut line, sent.len()) == sent, "in order");
    assert_eq!(line.lost_count(), 0);
    assert!(sending.join().expect("no panic").is_ok());
}

#[test]
fn a_device_that_closes_gives_its_last_bytes_and_then_the_reason() {
    let mut lines = start();
    let (mut line, mut far) = connected(&mut lines);
    far.write_all(b"last").expect("taken");
    drop(far);
    let (before, text) = read_to_failure(&mut line);
    assert_eq!(before, b"last");
    assert!(
        text.starts_with("tcp:127.0.0.1:")
            && text.contains("found one that the device closed; check whether"),
        "{text}"
    );
}

#[test]
fn a_connection_that_is_reset_says_so() {
    let mut lines = start();
    let (mut line, far) = connected(&mut lines);
    // Closing with a linger time of 0 resets the connection (socket(7), SO_LINGER).
    rustix::net::sockopt::set_socket_linger(&far, Some(Duration::ZERO)).expect("set");
    drop(far);
    let (_, text) = read_to_failure(&mut line);
    assert!(text.contains("found one that the device reset (Connection reset by peer"), "{text}");
}

#[test]
fn a_host_that_takes_no_connection_is_named_and_told_what_to_do() {
    let free = TcpListener::bind("127.0.0.1:0").and_then(|free| free.local_addr()).expect("bound").port();
    let mut lines = start();
    let text =
        lines.open_line(&address(&format!("tcp:127.0.0.1:{free}"))).err().expect("refused").to_string();
    assert!(text.starts_with(&format!("tcp:127.0.0.1:{free}: connection: expected a device")), "{text}");
    assert!(text.contains("nobody listens: check the port"), "{text}");
}
