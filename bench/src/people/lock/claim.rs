//! Claims of lines: serial ports, instruments, datagram ports. A line alone moves no axis, so a claim leaves no mark behind when
//! its process dies; the operating system lets go of the lock.

use std::net::ToSocketAddrs;
use std::path::Path;

use drivers::wire::lines::LineAddress;

use super::{Holder, Lock, LockError, interfaces, locked, system_folder};
use crate::model::rig::Rig;

/// What a process has alone for as long as this lives.
#[derive(Debug, Default)]
pub(crate) struct Claim {
    _locks: Vec<Lock>,
}

/// Claims all resources, or none.
///
/// # Errors
/// When somebody else holds one.
pub(crate) fn claim(folder: &Path, resources: &[String], holder: &Holder) -> Result<Claim, LockError> {
    locked(folder, resources, holder).map(|locks| Claim { _locks: locks })
}

/// Claims interface and lines of a rig for a verb that is no run, system-wide.
///
/// # Errors
/// When somebody else holds one.
pub(crate) fn claim_wires(rig: &Rig, verb: &str) -> Result<Claim, LockError> {
    let wires = if rig.tier.is_wired() { [interfaces(rig), lines(rig)].concat() } else { Vec::new() };
    claim(&system_folder(), &wires, &Holder::verb(verb))
}

/// Lines that a rig opens, each under the one name that all its addresses lead to; none where devices are in this process.
pub(crate) fn lines(rig: &Rig) -> Vec<String> {
    let devices = rig.devices.iter().filter(|_| rig.tier.is_wired());
    devices.flat_map(|entry| entry.lines()).map(|line| name(&line)).collect()
}

/// The far ends of the lines of a rig, which a simulator has while the rig has the near ones.
pub(crate) fn far_ends(rig: &Rig) -> Vec<String> {
    let far_end = |line: LineAddress| match line {
        // A link is made when it is served; before that it leads nowhere, or to the port of an earlier simulator.
        LineAddress::Serial { path, .. } => format!("far end of serial port {path}"),
        line => format!("far end of {}", name(&line)),
    };
    rig.devices.iter().flat_map(|entry| entry.lines()).map(far_end).collect()
}

/// One name for a line, whatever its address: a port has several paths, a host several names, and a bit rate is none of them.
fn name(line: &LineAddress) -> String {
    match line {
        LineAddress::Serial { path, .. } => {
            let own =
                std::fs::canonicalize(path).map_or_else(|_| path.clone(), |own| own.display().to_string());
            format!("serial port {own}")
        }
        LineAddress::Tcp { host, port } => {
            let found = (host.as_str(), *port).to_socket_addrs().ok().and_then(|mut all| all.next());
            format!("instrument {}", found.map_or_else(|| format!("{host}:{port}"), |own| own.to_string()))
        }
        LineAddress::Udp { bind, .. } => format!("UDP port {bind}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> LineAddress {
        LineAddress::parse(text).expect("an address")
    }

    #[test]
    fn all_addresses_of_a_line_have_one_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let link = folder.path().join("imu");
        std::os::unix::fs::symlink("/dev/null", &link).expect("linked");
        let linked = parsed(&format!("serial:{}?baud=9600", link.display()));
        assert_eq!(name(&linked), "serial port /dev/null");
        assert_eq!(name(&parsed("serial:/dev/null?baud=115200")), name(&linked));
        assert_eq!(name(&parsed("serial:/nowhere/x?baud=9600")), "serial port /nowhere/x");
        assert_eq!(name(&parsed("tcp:127.0.0.1:5025")), "instrument 127.0.0.1:5025");
        let udp = "udp:127.0.0.1:6000?bind=127.0.0.1:6001";
        assert_eq!(name(&parsed(udp)), "UDP port 127.0.0.1:6001");
    }

    #[test]
    fn a_line_belongs_to_one_process_and_the_next_is_told_whose() {
        let folder = tempfile::tempdir().expect("a folder");
        let line = ["serial port /dev/ttyUSB0".to_owned()];
        let first = claim(folder.path(), &line, &Holder::verb("devices")).expect("free");
        let told =
            claim(folder.path(), &line, &Holder::run(Path::new("runs/2"))).expect_err("held").to_string();
        let pid = std::process::id();
        let expected =
            format!("serial port /dev/ttyUSB0 is in use by `bench devices` (process {pid}, since ");
        assert!(told.starts_with(&expected) && told.ends_with("wait until it ends or stop it"), "{told}");
        drop(first);
        claim(folder.path(), &line, &Holder::verb("sim")).expect("free again");
    }

    #[test]
    fn the_lock_of_a_process_that_is_dead_is_taken_over() {
        let folder = tempfile::tempdir().expect("a folder");
        let stale = r#"{"verb":"devices","run":"","pid":1,"utc":"2026-01-01T00:00:00Z"}"#;
        let file = folder.path().join("bench-instrument_127_0_0_1_5025.lock");
        std::fs::write(&file, stale).expect("written");
        let line = ["instrument 127.0.0.1:5025".to_owned()];
        let _own = claim(folder.path(), &line, &Holder::verb("sim")).expect("nobody holds it");
        let now = std::fs::read_to_string(&file).expect("readable");
        assert!(now.contains(&format!("\"pid\":{}", std::process::id())), "{now}");
    }

    #[test]
    fn one_line_that_is_held_leaves_all_others_free() {
        let folder = tempfile::tempdir().expect("a folder");
        let named = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
        let _held = claim(folder.path(), &named(&["b"]), &Holder::verb("sim")).expect("free");
        claim(folder.path(), &named(&["a", "b"]), &Holder::verb("devices")).expect_err("b is held");
        claim(folder.path(), &named(&["a"]), &Holder::verb("devices")).expect("a was let go");
    }
}
