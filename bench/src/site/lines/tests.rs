//! Grounds of lines on made-up machines, and lines that are not there.

use procedures::diagnostic::SourceFile;
use sim_devices::served::LinePump;

use super::*;
use crate::files::rig::read_rig;
use crate::files::shipped;

/// Drives and terminal of the shipped wired rig with an oscilloscope at this address.
fn with_scope(address: &str) -> Rig {
    let scope = format!(
        "\n[[device]]\nname = \"scope\"\ndriver = \"infiniivision\"\nports = {{ line = \"{address}\" }}\n"
    );
    let text = shipped::wired_without_lines() + &scope;
    read_rig(SourceFile::new("rig.toml", text)).expect("it parses")
}

/// What is said when the scope of a rig is not at this address.
fn refusal(address: &str) -> String {
    open(&with_scope(address), Ports::default(), &Clock::real()).err().expect("refused").to_string()
}

#[test]
fn a_line_that_is_missing_or_refused_is_told_with_device_address_and_remedy() {
    let missing = refusal("serial:/nowhere/scope?baud=9600");
    assert!(missing.starts_with("scope at serial:/nowhere/scope?baud=9600: port: expected"), "{missing}");
    assert!(missing.ends_with("plug the adapter in, or correct the address in the rig file"), "{missing}");
    let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("bound");
    let port = listener.local_addr().expect("bound").port();
    drop(listener);
    let refused = refusal(&format!("tcp:127.0.0.1:{port}"));
    assert!(
        refused.starts_with(&format!("scope at tcp:127.0.0.1:{port}: connection: expected")),
        "{refused}"
    );
    assert!(refused.contains("check the port"), "{refused}");
}

#[test]
fn a_line_that_is_in_use_is_told_with_a_remedy() {
    let pump = LinePump::pty(9600).expect("a pty");
    let rig = with_scope(pump.address());
    let first = open(&rig, Ports::default(), &Clock::real()).expect("free");
    let second = refusal(pump.address());
    assert!(second.contains("another program has open") && second.contains("fuser"), "{second}");
    let (ports, grounds) = first;
    assert_eq!(ports.find_line("scope", pump.address()), Ok(0));
    assert!(!grounds[0].is_physical && grounds[0].text.contains("is a pseudoterminal"), "{grounds:?}");
}

#[test]
fn a_rig_without_lines_starts_nothing() {
    let rig = read_rig(SourceFile::new("rig.toml", shipped::wired_without_lines())).expect("it parses");
    let (_, grounds) = open(&rig, Ports::default(), &Clock::real()).expect("nothing is missing");
    assert_eq!(grounds, []);
}

#[test]
fn a_serial_port_is_physical_by_the_number_of_its_device_file_and_not_by_its_name() {
    // The character device 1:3 stands on every computer; on this made-up one it has hardware.
    let root = tempfile::tempdir().expect("a folder");
    let kernel = Kernel::at(root.path());
    let own_number = "/dev/null";
    assert_eq!(
        serial_grounds(&kernel, own_number),
        (false, "serial port /dev/null has no physical device".to_owned())
    );
    fs::create_dir_all(root.path().join("sys/dev/char/1:3/device")).expect("created");
    let link = root.path().join("usb-adapter");
    std::os::unix::fs::symlink(own_number, &link).expect("linked");
    let (is_physical, text) = serial_grounds(&kernel, &link.display().to_string());
    assert!(is_physical && text.ends_with("usb-adapter has a physical device"), "{text}");
    let (is_physical, text) = serial_grounds(&kernel, "/nowhere");
    assert!(!is_physical && text.contains("nothing proves"), "{text}");
}

#[test]
fn a_peer_on_this_computer_is_simulated_whatever_its_name() {
    let kernel = Kernel::default();
    for host in ["127.0.0.1", "127.3.2.1", "localhost", "::1"] {
        let (is_physical, text) = peer_grounds(&kernel, host, 5025);
        assert!(!is_physical && text.ends_with("is an address of this computer"), "{host}: {text}");
    }
}

#[test]
fn a_peer_behind_an_interface_is_as_physical_as_the_interface() {
    let card = Interface { name: "enp3s0".to_owned(), is_physical: true, peer: None, is_pair: false };
    let peer: IpAddr = "192.0.2.20".parse().expect("an address");
    let (is_physical, text) = through(Some(&card), peer);
    assert!(is_physical && text.contains("192.0.2.20 is behind interface enp3s0"), "{text}");
    let virtual_one = Interface { is_physical: false, ..card };
    assert!(!through(Some(&virtual_one), peer).0);
    assert!(!through(None, peer).0, "what is not provable is simulated");
}
