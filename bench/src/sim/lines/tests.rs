//! A rig's devices on lines of the operating system, the simulated ones at the far end in a thread of their own.

use std::net::{TcpListener, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use procedures::diagnostic::SourceFile;

use super::*;
use crate::clock::{self, Clock};
use crate::files::profile::simulated;
use crate::files::rig::read_rig;
use crate::files::shipped;
use crate::files::unit::load_unit;
use crate::model::rig::{Rig, Tier};
use crate::rig::devices::{Devices, closed, converse};
use crate::rig::instruments::Instruments;
use crate::rig::wires::Ports;
use crate::site::{Purpose, Site, Units, VirtualSite};

/// Drives and terminal of the shipped wired rig with an inertial unit, both instruments and the fine tracker on these lines.
fn rig(imu: &str, analyser: &str, scope: &str, fine: &str) -> Rig {
    let devices = format!(
        "
[[device]]
name = \"imu\"
driver = \"kvh-1775\"
ports = {{ line = \"{imu}\" }}
baud = 4147200

[[device]]
name = \"fine\"
driver = \"fine-tracker\"
ports = {{ socket = \"{fine}\" }}
ifov-x = \"2.045 urad\"
ifov-y = \"2.045 urad\"
message-delay = \"7.5 ms\"
message-delay-uncertainty = \"0.2 ms\"

[[device]]
name = \"analyser\"
driver = \"e4990a\"
ports = {{ line = \"{analyser}\" }}

[[device]]
name = \"scope\"
driver = \"infiniivision\"
ports = {{ line = \"{scope}\" }}
"
    );
    let text = shipped::wired_without_lines() + &devices;
    let mut rig = read_rig(SourceFile::new("rig.toml", text)).expect("it parses");
    // Whatever hangs on the analog terminal needs the bus, which this test does without.
    rig.devices.retain(|entry| !entry.ports.contains_key("card"));
    rig
}

/// A TCP port that was free a moment ago.
fn free_tcp() -> String {
    let listener = TcpListener::bind("127.0.0.1:0").expect("bound");
    format!("tcp:{}", listener.local_addr().expect("bound"))
}

/// A pair of UDP ports that were free a moment ago.
fn free_udp() -> String {
    let [own, host] = [0, 1].map(|_| UdpSocket::bind("127.0.0.1:0").expect("bound"));
    format!("udp:{}?bind={}", own.local_addr().expect("bound"), host.local_addr().expect("bound"))
}

/// Serves the lines of a rig until it is told to stop; gives what was told of them.
fn serve_until(rig: &Rig, is_over: &AtomicBool, is_served: &AtomicBool) -> Vec<String> {
    let nominal = load_unit("nominal").expect("a shipped unit");
    let units = Units { unit: &nominal, built: &[] };
    let far_ends =
        units.far_ends(rig, &Purpose { procedure: "sim", ..Purpose::default() }).expect("far ends");
    let mut lines = ServedLines::open(far_ends.lines).expect("free addresses");
    is_served.store(true, Ordering::Release);
    let clock = Clock::real();
    while !is_over.load(Ordering::Acquire) {
        lines.pump(clock.now()).expect("the devices are there");
        clock::nap();
    }
    lines.names().map(|(address, device)| format!("{address}  {device}")).collect()
}

#[test]
fn the_devices_of_a_rig_are_opened_over_lines_of_the_operating_system() {
    let folder = tempfile::tempdir().expect("a folder");
    let imu = format!("serial:{}?baud=4147200", folder.path().join("imu").display());
    let [analyser, scope, fine] = [free_tcp(), free_tcp(), free_udp()];
    let rig = rig(&imu, &analyser, &scope, &fine);
    let [is_over, is_served] = [0, 1].map(|_| Arc::new(AtomicBool::new(false)));
    let serving = thread::spawn({
        let (rig, is_over, is_served) = (rig.clone(), Arc::clone(&is_over), Arc::clone(&is_served));
        move || serve_until(&rig, &is_over, &is_served)
    });
    while !is_served.load(Ordering::Acquire) {
        assert!(!serving.is_finished(), "nothing is served");
        clock::nap();
    }
    let clock = Clock::real();
    let (mut ports, grounds) =
        crate::site::lines::open(&rig, Ports::default(), &clock).expect("all are there");
    assert!(grounds.iter().all(|line| !line.is_physical), "{grounds:?}");
    let all = closed(&rig);
    let (mut devices, mut now) =
        Devices::open(all.devices, &mut ports, &clock, clock.now()).expect("they answer");
    let mut instruments = Instruments::closed(all.instruments);
    converse(&clock, &mut now, "instruments", |at| instruments.identify(&mut ports, at))
        .expect("they answer");
    let identities: Vec<_> =
        devices.identities().into_iter().chain(instruments.identities().to_vec()).collect();
    let names: Vec<&str> = identities.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["imu", "analyser", "scope"], "a tracker cannot say who it is");
    assert!(identities.iter().all(|(_, identity)| identity.contains("SIM")), "{identities:?}");
    let last = now + Duration::from_millis(300);
    while now < last {
        now = clock.wait_until(now + Duration::from_millis(1));
        devices.poll(&mut ports, now);
    }
    assert_eq!(devices.failure(), None);
    // The inertial unit sends nothing: its pulses come with exchanges of a bus, and here is none.
    assert!(!devices.trackers()[1].exposure.is_zero(), "datagrams of the fine tracker arrive");
    is_over.store(true, Ordering::Release);
    let told = serving.join().expect("served");
    let names = ["imu", "fine", "analyser", "scope"].into_iter();
    are_told_as_gone(&rig, &mut devices, &mut ports, &clock);
    let expected: Vec<String> = [imu, fine, analyser, scope]
        .iter()
        .zip(names)
        .map(|(line, device)| format!("{line}  {device}"))
        .collect();
    assert_eq!(told, expected);
}

/// Nobody serves the lines of the rig any more: each is told with its device and what to do.
fn are_told_as_gone(rig: &Rig, devices: &mut Devices, ports: &mut Ports, clock: &Clock) {
    let last = clock.now() + Duration::from_secs(5);
    let mut now = clock.now();
    while devices.failure().is_none() && now < last {
        now = clock.wait_until(now + Duration::from_millis(1));
        devices.poll(ports, now);
    }
    let gone = devices.failure().expect("the far end of the pty is closed").to_string();
    assert!(
        gone.starts_with("imu at serial:/") && gone.contains(": line: expected an open line, found one"),
        "{gone}"
    );
    assert!(gone.ends_with("check plug and supply of the adapter, then start again"), "{gone}");
    let mut instruments = Instruments::closed(closed(rig).instruments);
    let found = converse(clock, &mut now, "instruments", |at| instruments.identify(ports, at));
    let gone = found.expect_err("the connection is closed").to_string();
    assert!(
        gone.starts_with("analyser at tcp:127.0.0.1:") && gone.contains("expected an open line"),
        "{gone}"
    );
}

#[test]
fn a_rig_with_lines_is_rehearsed_in_process_and_opens_nothing_at_their_addresses() {
    // Nobody serves these addresses.
    let rig = rig("serial:/nowhere/imu?baud=4147200", &free_tcp(), &free_tcp(), &free_udp());
    let nominal = load_unit("nominal").expect("a shipped unit");
    let gains = crate::files::parameters::load(&rig).expect("shipped gains");
    let purpose = Purpose { procedure: "test", ..Purpose::default() };
    for rig in [rig.rehearsed_on(Tier::Virtual, &simulated()), rig] {
        let opened = VirtualSite::new(&nominal, &[]).open(&rig, &gains, &purpose).expect("it opens");
        let records = crate::rig::identities::records(&rig, &opened.rig, &opened.grounds);
        let names: Vec<&str> = records.iter().map(|device| device.name.as_str()).collect();
        assert_eq!(names, ["az-drive", "el-drive", "imu", "analyser", "scope"]);
        assert!(records.iter().all(|device| !device.may_be_real), "{records:?}");
    }
}

#[test]
fn a_simulator_serves_no_host_at_which_hardware_may_be() {
    let [tcp, udp] = [free_tcp(), free_udp()];
    for address in ["tcp:192.0.2.20:5025", "tcp:scope.lab:5025", "tcp:127.0.0.2:5025"] {
        let rig = rig("serial:/nowhere/imu?baud=4147200", &tcp, address, &udp);
        let scope = rig.devices.into_iter().find(|entry| entry.name == "scope").expect("a scope");
        let line = scope.lines().next().expect("a line");
        let end = FarEnd::Line(sim_devices::rig::SimulatedRig::scope_line(&director()));
        let error =
            serve(FarLine { device: scope.name, address: line, end }).err().expect("refused").to_string();
        assert!(
            error.starts_with(&format!("scope at {address}: address: expected a free address")),
            "{error}"
        );
        assert!(error.contains("a simulator must not answer where hardware may be"), "{error}");
    }
}

fn director() -> sim_devices::rig::SimulatedRig {
    use sim_devices::rig::{SeedAddress, SimulatedRig, StartState};
    let address = SeedAddress { seed: 1, procedure: "test".to_owned(), point: String::new() };
    let start = StartState { az_rad: 0.0, el_rad: 0.0, heat_sink_degc: 20.0 };
    SimulatedRig::new(&sim_devices::unit::UnitSettings::default(), &address, start)
}
