//! Drivers against simulated devices over real lines: ptys, TCP and UDP on the loopback interface, in real time.
#![cfg(target_os = "linux")]

#[path = "served/bench.rs"]
mod bench;

use std::time::Duration;

use bench::{Imu, MESSAGE_PERIOD, Opened, Timer, lines, nap, rig};
use drivers::kvh::KvhSettings;
use drivers::scope::{Capture, Scope, ScopeSettings};
use drivers::scpi::Instrument;
use drivers::tracker::{DeclaredDelay, Source, Tracker, TrackerSettings};
use drivers::wire::fault::{ByteFaultKind, ByteLineFault, ByteLineFaultPlan, Occurrence};
use drivers::wire::lines::{HostLine, LineAddress};
use drivers::wire::{ByteLine, Way};
use sim_devices::served::{LinePump, PortPump};

/// Longest time that anything here takes on an idle computer, many times over.
const PATIENCE: Duration = Duration::from_secs(20);

#[test]
fn the_inertial_unit_is_opened_over_a_pty_and_no_message_is_lost() {
    let mut imu = Imu::new(ByteLineFaultPlan::default());
    let Opened { mut driver, mut line } = imu.open();
    let mut messages_count = 0;
    for _ in 0..200 {
        imu.tick();
        messages_count += driver.poll(&mut line, imu.now()).expect("the line is there");
    }
    // Those of the last milliseconds are on their way.
    assert!((190..=210).contains(&messages_count), "{messages_count} messages in 200 ms");
    assert_eq!((driver.missed_count(), driver.tally().bad_checksums_count), (0, 0));
    assert_eq!(driver.sample().expect("messages came").status, 0x77);
    assert_eq!((imu.pump.counts().lost, line.lost_count()), (0, 0));
}

#[test]
fn garbage_half_a_frame_and_silence_on_the_line_cost_their_messages_and_no_more() {
    let fault =
        |kind, first, count| ByteLineFault { way: Way::Back, kind, when: Occurrence::At { first, count } };
    let faults = vec![
        fault(ByteFaultKind::Drop, 20 * 36 + 19, 18),
        fault(ByteFaultKind::Insert { bytes: 50 }, 40 * 36 + 10, 1),
        fault(ByteFaultKind::Silence { lasts: 30 * MESSAGE_PERIOD }, 60 * 36 + 1, 1),
    ];
    let mut imu = Imu::new(ByteLineFaultPlan { seed: 11, faults });
    let Opened { mut driver, mut line } = imu.open();
    imu.begin_faults();
    for _ in 0..200 {
        imu.tick();
        driver.poll(&mut line, imu.now()).expect("the line is there");
    }
    let missed_count = driver.missed_count();
    assert!((28..=45).contains(&missed_count), "{missed_count} messages missed");
    assert!(driver.tally().skipped_bytes_count >= 50);
    assert!(driver.age_ticks() < 20, "it goes on after the silence");
}

#[test]
fn a_unit_that_is_unplugged_is_an_error_that_names_the_port() {
    let mut imu = Imu::new(ByteLineFaultPlan::default());
    let Opened { mut driver, mut line } = imu.open();
    let address = imu.pump.address().to_owned();
    let timer = imu.unplug();
    let text = loop {
        match driver.poll(&mut line, timer.now()) {
            Ok(_) => assert!(timer.now() < PATIENCE, "it is not noticed"),
            Err(error) => break error.to_string(),
        }
        nap();
    };
    assert!(text.starts_with(&format!("{address}: line: expected an open line")), "{text}");
    assert!(text.contains("check plug and supply"), "{text}");
}

#[test]
fn a_silent_line_is_the_drivers_timeout_and_no_failure_of_the_line() {
    let mut imu = Imu::new(ByteLineFaultPlan::default());
    let settings = KvhSettings { answer_timeout_s: 0.02, ..Imu::settings() };
    let (_lines, mut line) = imu.connect();
    // Nobody moves bytes at the far end: the unit hears nothing and says nothing.
    let text = imu.open_without_pump(settings, &mut line);
    assert!(text.contains("found no answer to 3 commands; check power, wiring"), "{text}");
}

#[test]
fn a_pty_is_paced_at_its_bit_rate() {
    let mut imu = Imu::new(ByteLineFaultPlan::default());
    let (_lines, mut line) = imu.connect();
    let mut bytes = [0; 4096];
    assert_eq!(line.read(imu.now(), &mut bytes), Ok(0));
    // The far end looks every millisecond whether somebody has opened the line.
    for _ in 0..50 {
        imu.pump.pump(&mut bench::Burst::new(Vec::new()), imu.now()).expect("the line is there");
        nap();
    }
    // A burst that the simulated line hands over at once.
    let burst = vec![0x55; 1843];
    let mut burst_line = bench::Burst::new(burst.clone());
    let begun = imu.now();
    let mut heard_count = 0;
    while heard_count < burst.len() {
        imu.pump.pump(&mut burst_line, imu.now()).expect("the line is there");
        heard_count += line.read(imu.now(), &mut bytes).expect("the line is there");
        assert!(imu.now() - begun < PATIENCE, "{heard_count} bytes came");
        nap();
    }
    let took = imu.now() - begun;
    assert!(took >= Duration::from_micros(19_990), "1843 bytes at 921600 baud take 20 ms: {took:?}");
}

#[test]
fn an_oscilloscope_takes_a_record_over_tcp_and_serves_the_next_client() {
    let rig = rig();
    let timer = Timer::start();
    let mut far = rig.scope_line();
    let mut card = rig.analog_card();
    let mut pump = LinePump::tcp(0).expect("a free port");
    let address = LineAddress::parse(pump.address()).expect("an address");
    let mut lines = lines(timer);
    for client in 0..2 {
        let mut line = lines.open_line(&address).expect("connects");
        let mut scope = Scope::new(ScopeSettings {
            name: "scope".into(),
            current_channels: [1, 3],
            sync_channel: 2,
            current_range_a: 20.0,
            reply_timeout_s: 5.0,
        })
        .expect("good settings");
        let mut until = |what: &str, step: &mut dyn FnMut(&mut HostLine, Duration) -> bool| loop {
            let now = timer.now();
            pump.pump(&mut *far, now).expect("the line is there");
            if step(&mut line, now) {
                return;
            }
            assert!(now < PATIENCE, "{what} takes too long");
            nap();
        };
        until("the identity", &mut |line, now| scope.identify(line, now).expect("it answers").is_some());
        scope.prepare(&Capture { axis: 0, sample_rate_hz: 200e3, duration_s: 9e-3 }).expect("it can");
        let mut is_started = false;
        let mut is_triggered = false;
        until("the record", &mut |line, now| {
            if !is_started {
                scope.start(line, now).expect("the line is there");
                is_started = true;
            }
            if scope.is_armed() && !is_triggered {
                is_triggered = true;
                card.write_v(now, 2, 5.0).expect("an output");
            }
            scope.poll(line, now).expect("it answers")
        });
        assert!(scope.samples_count() >= 2000, "client {client}: {} samples", scope.samples_count());
        assert!(scope.row(scope.samples_count() - 1).expect("no hole")[2] > 4.0, "the edge is seen");
        card.write_v(timer.now(), 2, 0.0).expect("an output");
    }
    assert!(pump.counts().to_host > 8000);
}

#[test]
fn a_tracker_is_heard_over_udp_frame_by_frame() {
    let rig = rig();
    let timer = Timer::start();
    let mut far = rig.coarse_port();
    let free = std::net::UdpSocket::bind("127.0.0.1:0").and_then(|free| free.local_addr()).expect("bound");
    let mut pump = PortPump::udp("127.0.0.1:0".parse().expect("an address"), free).expect("a free port");
    let mut lines = lines(timer);
    let address = LineAddress::parse(pump.address()).expect("an address");
    let mut port = lines.open_port(&address).expect("opens");
    let mut tracker = Tracker::new(TrackerSettings {
        name: "coarse".to_owned(),
        source: Source::Coarse,
        ifov_rad: [27.27e-6, 36.36e-6],
        map: [[1.0, 0.0], [0.0, 1.0]],
        declared_delay: DeclaredDelay { delay_s: 0.02, u_s: 1e-3 },
        poll_period: Duration::from_millis(1),
    })
    .expect("good settings");
    let mut frames_count = 0;
    let mut last = None;
    while frames_count < 10 {
        let now = timer.now();
        pump.pump(&mut *far, now).expect("the port is there");
        let (actuals, is_fresh) = tracker.poll(&mut port, now).expect("the port is there");
        frames_count += u32::from(is_fresh);
        last = Some(actuals);
        assert!(now < PATIENCE, "{frames_count} frames came");
        nap();
    }
    let last = last.expect("ten frames came");
    assert_eq!((last.rejected, last.lost_frames, port.lost_count()), (0, 0, 0));
    assert!(last.age < Duration::from_millis(100), "{:?}", last.age);
    assert_eq!((pump.counts().to_host, pump.counts().lost), (10, 0));
}

#[test]
fn a_host_that_never_reads_does_not_hold_the_simulation_up() {
    let timer = Timer::start();
    let mut pumps = [LinePump::pty(921_600), LinePump::tcp(0)].map(|pump| pump.expect("a far end"));
    let mut lines = lines(timer);
    for pump in &mut pumps {
        let mut line =
            lines.open_line(&LineAddress::parse(pump.address()).expect("an address")).expect("opens");
        line.write(timer.now(), b"x").expect("room");
        for _ in 0..50 {
            pump.pump(&mut bench::Burst::new(Vec::new()), Duration::ZERO).expect("the line is there");
            nap();
        }
        let mut flood = bench::Burst::new(vec![0; 64 << 20]);
        let begun = timer.now();
        // An hour of simulated time, in which everything is due.
        for minute in 0..60 {
            pump.pump(&mut flood, Duration::from_secs(60 * minute)).expect("the line is there");
        }
        let took = timer.now() - begun;
        assert!(took < Duration::from_secs(2), "{}: {took:?}", pump.address());
    }
    let [pty, tcp] = pumps.each_ref().map(LinePump::counts);
    assert!(pty.lost > 0 && pty.to_host + pty.lost > 1_500_000, "{pty:?}: a receiver overruns");
    assert_eq!(tcp.lost, 0, "a connection holds the device back");
}

#[test]
fn a_pty_is_found_at_the_path_of_its_link_and_a_file_is_left_alone() {
    let folder = std::env::temp_dir().join(format!("served-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("made");
    let path = folder.join("imu");
    let first = LinePump::pty_at(&path, 9600).expect("made");
    assert_eq!(first.address(), format!("serial:{}?baud=9600", path.display()));
    let refused = LinePump::pty_at(&path, 9600).map(|_| ()).expect_err("another one serves it").to_string();
    assert!(refused.starts_with("another simulator serves "), "{refused}");
    lines(Timer::start())
        .open_line(&LineAddress::parse(first.address()).expect("an address"))
        .expect("opens");
    drop(first);
    assert!(!path.exists(), "a pump that ends takes its link along");
    std::fs::write(&path, "notes").expect("written");
    assert!(LinePump::pty_at(&path, 9600).is_err());
    assert_eq!(std::fs::read_to_string(&path).expect("still there"), "notes");
    let adapter = folder.join("usb-adapter");
    std::os::unix::fs::symlink("/dev/ttyUSB0", &adapter).expect("made");
    let error = LinePump::pty_at(&adapter, 9600).err().expect("refused").to_string();
    assert!(error.ends_with("exists and is no link to a pty; choose another path"), "{error}");
    std::fs::remove_dir_all(&folder).expect("removed");
}

#[test]
fn a_port_is_served_on_the_loopback_interface_alone() {
    let own = "127.0.0.1:0".parse().expect("an address");
    let error = PortPump::udp(own, "192.0.2.1:6000".parse().expect("an address")).err().expect("refused");
    assert!(error.to_string().starts_with("192.0.2.1:6000 is no loopback address"), "{error}");
}
