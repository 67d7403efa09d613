//! Both ends on virtual CAN interfaces of Linux, in real time. `tests/vcan/run` runs these tests where the kernel of this computer
//! has no CAN; each test has an interface of its own.

use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::bench::{Bench, Clock, reading, rig, settings};
use drivers::cia402::{PowerState, PowerTarget};
use drivers::wire::can::{CanEvent, CanFrame, CanLink, SocketCan};
use drivers::wire::canopen::{CanOpenBus, CanOpenSettings};
use drivers::wire::{BusState, Fieldbus, SdoAbort, SdoRequest};
use sim_devices::canopen::{NodeFault, serve};
use socketcan::{
    CanDataFrame, CanErrorFrame, CanInterface, CanRemoteFrame, CanSocket, EmbeddedFrame, ExtendedId, Socket,
    StandardId,
};

#[expect(clippy::disallowed_methods, reason = "these tests run in real time")]
fn clock() -> Clock {
    let start = Instant::now();
    Box::new(move || start.elapsed())
}

/// Heartbeats that survive the stalls of a guest kernel on a busy computer: a node is lost after 0.9 s.
fn patient() -> CanOpenSettings {
    CanOpenSettings { heartbeat_s: 0.3, ..settings() }
}

/// A virtual CAN interface with simulated nodes on it.
struct Network {
    name: &'static str,
    orders: Option<Sender<NodeFault>>,
    server: Option<JoinHandle<()>>,
}

impl Network {
    /// `None` where the kernel has no CAN.
    fn new(name: &'static str) -> Option<Self> {
        let mut network = Self::without_nodes(name)?;
        let (orders, received) = channel();
        network.orders = Some(orders);
        network.server = Some(std::thread::spawn(move || serve_nodes(name, &received)));
        Some(network)
    }

    #[expect(clippy::print_stdout, reason = "whoever reads the log must see what was not tested")]
    fn without_nodes(name: &'static str) -> Option<Self> {
        if let Err(error) = CanSocket::open_iface(0) {
            println!("skipped: this kernel has no CAN: {error} (vcan)");
            return None;
        }
        match CanInterface::create_vcan(name, None).map(|interface| interface.bring_up()) {
            Ok(Ok(())) => Some(Self { name, orders: None, server: None }),
            Ok(Err(error)) | Err(error) => {
                println!("skipped: no right to create CAN interfaces: {error} (vcan)");
                None
            }
        }
    }

    fn interface(&self) -> CanInterface {
        CanInterface::open(self.name).expect("it was created")
    }

    fn link(&self) -> SocketCan {
        SocketCan::open(self.name, clock()).expect("the interface is up")
    }

    /// A socket of somebody else.
    fn raw(&self) -> CanSocket {
        CanSocket::open(self.name).expect("the interface is up")
    }

    fn bench(&self) -> Bench {
        let start = clock();
        let shared = std::rc::Rc::new(start);
        let other = std::rc::Rc::clone(&shared);
        let link = SocketCan::open(self.name, Box::new(move || other())).expect("the interface is up");
        Bench::open(Box::new(link), Box::new(move || shared()), patient()).expect("two nodes answer")
    }

    fn inject(&self, fault: NodeFault) {
        self.orders.as_ref().expect("there are nodes").send(fault).expect("the nodes are served");
        // Until it has been taken.
        let mut link = self.link();
        let until = link.now() + Duration::from_millis(20);
        while link.now() < until {
            link.wait(until).expect("the interface is up");
            while link.receive().expect("the interface is up").is_some() {}
        }
    }
}

impl Drop for Network {
    fn drop(&mut self) {
        self.orders = None;
        if let Some(server) = self.server.take() {
            let served = server.join();
            assert!(served.is_ok() || std::thread::panicking(), "the server failed");
        }
        if let Ok(interface) = CanInterface::open(self.name) {
            let _ = interface.delete();
        }
    }
}

/// Serves two nodes until nobody gives orders any more.
fn serve_nodes(name: &str, orders: &Receiver<NodeFault>) {
    let mut link = SocketCan::open(name, clock()).expect("the interface is up");
    let mut line = rig().canopen_line();
    loop {
        match orders.try_recv() {
            Ok(fault) => line.inject(link.now(), fault).expect("there is such a node"),
            Err(TryRecvError::Empty) => {}
            Err(TryRecvError::Disconnected) => return,
        }
        let until = link.now() + Duration::from_millis(5);
        // A test takes the interface down: the nodes are then gone as well.
        if serve(&mut link, &mut *line, until).is_err() {
            return;
        }
    }
}

/// Frames that come in a while.
fn heard(link: &mut SocketCan, lasting: Duration) -> Vec<CanFrame> {
    let until = link.now() + lasting;
    let mut frames = Vec::new();
    while link.now() < until {
        link.wait(until).expect("the interface is up");
        while let Some(event) = link.receive().expect("the interface is up") {
            if let CanEvent::Frame(frame) = event {
                frames.push(frame);
            }
        }
    }
    frames
}

#[test]
fn nodes_boot_and_send_heartbeats() {
    let Some(network) = Network::without_nodes("vboot") else { return };
    let mut link = network.link();
    let (orders, received) = channel();
    let server = std::thread::spawn(move || serve_nodes("vboot", &received));
    let frames = heard(&mut link, Duration::from_millis(200));
    assert_eq!(frames, [CanFrame::of(0x701, [0]), CanFrame::of(0x702, [0])]);
    // Producer heartbeat time of node 2: 20 ms.
    link.send(&CanFrame::of(0x602, [0x2B, 0x17, 0x10, 0, 20, 0, 0, 0])).expect("sent");
    let frames = heard(&mut link, Duration::from_millis(210));
    assert_eq!(frames[0], CanFrame::of(0x582, [0x60, 0x17, 0x10, 0, 0, 0, 0, 0]));
    let beats = frames.iter().filter(|frame| **frame == CanFrame::of(0x702, [0x7F])).count();
    assert!((8..=11).contains(&beats), "{beats} heartbeats in 210 ms");
    drop(orders);
    server.join().expect("the server ends");
}

#[test]
fn the_bus_takes_nodes_through_network_management() {
    let Some(network) = Network::new("vnmt") else { return };
    let (ready, is_ready) = channel();
    // Meanwhile more frames pass than a socket keeps.
    let observer = std::thread::spawn(move || {
        let mut link = SocketCan::open("vnmt", clock()).expect("the interface is up");
        ready.send(()).expect("the test waits");
        heard(&mut link, Duration::from_secs(3))
    });
    is_ready.recv().expect("the observer listens");
    let bench = network.bench();
    assert_eq!(bench.bus.name(), "bus 0 (vnmt)");
    assert_eq!(bench.bus.state(), BusState::SafeOp);
    drop(bench);
    let frames = observer.join().expect("the observer ends");
    let commands = frames.iter().filter(|frame| frame.id() == 0).map(|frame| frame.data().to_vec());
    let expected = [[0x82, 1], [0x82, 2], [0x80, 1], [0x80, 2], [0x01, 1], [0x01, 2], [0x80, 1], [0x80, 2]]
        .map(Vec::from);
    assert_eq!(commands.collect::<Vec<_>>(), expected);
    let mut states: Vec<_> =
        frames.iter().filter(|frame| frame.id() == 0x701).map(|frame| frame.data()[0]).collect();
    states.dedup();
    assert!(states.ends_with(&[0x00, 0x7F, 0x05, 0x7F]), "{states:02X?}");
}

#[test]
fn expedited_transfers_read_and_write() {
    let Some(network) = Network::new("vexpedited") else { return };
    let mut bench = network.bench();
    assert_eq!(bench.sdo(&reading(1, 0x1018, 1)).0, Ok(0x0053_494D_u32.to_le_bytes().to_vec()));
    let torque = 500_u16.to_le_bytes();
    let write = SdoRequest { station: 2, index: 0x6072, sub: 0, write: Some(&torque) };
    assert_eq!(bench.sdo(&write).0, Ok(Vec::new()));
    assert_eq!(bench.sdo(&reading(2, 0x6072, 0)).0, Ok(torque.to_vec()));
}

#[test]
fn segmented_transfers_read_and_write() {
    let Some(network) = Network::new("vsegmented") else { return };
    let mut bench = network.bench();
    assert_eq!(bench.sdo(&reading(1, 0x1008, 0)).0, Ok(b"SIM servo drive".to_vec()));
    let long = SdoRequest { station: 1, index: 0x6065, sub: 0, write: Some(b"ten bytes.") };
    assert_eq!(bench.sdo(&long).0, Err(SdoAbort(0x0607_0010)), "all segments arrived and are too many bytes");
}

#[test]
fn an_abort_has_the_code_of_the_node() {
    let Some(network) = Network::new("vabort") else { return };
    let mut bench = network.bench();
    assert_eq!(bench.sdo(&reading(1, 0x5555, 0)).0, Err(SdoAbort(0x0602_0000)));
    assert_eq!(bench.sdo(&reading(1, 0x1018, 9)).0, Err(SdoAbort(0x0609_0011)));
    network.inject(NodeFault::RefusesSdo { node: 1, code: Some(0x0800_0021) });
    assert_eq!(bench.sdo(&reading(1, 0x1018, 1)).0, Err(SdoAbort(0x0800_0021)));
}

#[test]
fn a_wrong_toggle_bit_ends_a_transfer_and_the_next_one_works() {
    let Some(network) = Network::new("vtoggle") else { return };
    let mut bench = network.bench();
    network.inject(NodeFault::WrongToggle { node: 1 });
    assert_eq!(bench.sdo(&reading(1, 0x1008, 0)).0, Err(SdoAbort(0x0503_0000)));
    assert!(bench.sdo(&reading(1, 0x1008, 0)).0.is_ok());
}

#[test]
fn a_mute_server_is_given_up_after_a_second() {
    let Some(network) = Network::new("vmute") else { return };
    let mut bench = network.bench();
    network.inject(NodeFault::SdoMute { node: 2, is_mute: true });
    let begun = bench.now;
    assert_eq!(bench.sdo(&reading(2, 0x1018, 1)).0, Err(SdoAbort(0x0504_0000)));
    let lasting = bench.now - begun;
    assert!((1000..1100).contains(&lasting.as_millis()), "{lasting:?}");
    network.inject(NodeFault::SdoMute { node: 2, is_mute: false });
    assert!(bench.sdo(&reading(2, 0x1018, 1)).0.is_ok());
}

#[test]
fn an_emergency_is_told_with_its_node() {
    let Some(network) = Network::new("vemergency") else { return };
    let mut bench = network.bench();
    network.inject(NodeFault::Emergency { node: 2, code: 0x4310, register: 9 });
    bench.exchange().expect("the wire works");
    assert_eq!(bench.notices(), ["2: emergency 4310h, drive over-temperature (error register 09h)"]);
}

#[test]
fn a_heartbeat_that_stays_out_costs_the_node() {
    let Some(network) = Network::new("vheartbeat") else { return };
    let mut bench = network.bench();
    bench.enter_op();
    network.inject(NodeFault::HeartbeatStopped { node: 1, is_stopped: true });
    let begun = bench.now;
    while bench.bus.state() == BusState::Op && bench.now - begun < Duration::from_secs(3) {
        bench.tick(PowerTarget::Disabled, 0.0);
    }
    let silent = bench.now - begun;
    assert!((550..1500).contains(&silent.as_millis()), "{silent:?}");
    let notices = bench.notices();
    assert!(notices.iter().any(|notice| notice.starts_with("1: no heartbeat for ")), "{notices:?}");
    network.inject(NodeFault::HeartbeatStopped { node: 1, is_stopped: false });
    bench.bus.request(BusState::Op);
    for _ in 0..50 {
        bench.exchange().expect("the wire works");
    }
    assert_eq!(bench.bus.state(), BusState::PreOp, "nothing restarts by itself");
}

#[test]
fn drives_are_enabled_and_moved_by_pdos_with_sync() {
    let Some(network) = Network::new("vmove") else { return };
    let mut bench = network.bench();
    bench.enable();
    bench.move_for(250, 0.2);
    let (before_rad, begun) = (bench.actuals[0].position_rad, bench.now);
    let mut missing_count = 0;
    for _ in 0..500 {
        let exchange = bench.tick(PowerTarget::Enabled, 0.2);
        missing_count += usize::from(exchange.working_counter != exchange.expected);
    }
    let moved_rad = bench.actuals[0].position_rad - before_rad;
    let expected_rad = 0.2 * (bench.now - begun).as_secs_f64();
    assert!((moved_rad - expected_rad).abs() < 0.05, "{moved_rad} rad instead of {expected_rad}");
    assert_eq!(bench.states(), [PowerState::OperationEnabled; 2]);
    // The far end runs beside this test, on the same processor.
    assert!(missing_count < 125, "{missing_count} of 500");
}

#[test]
fn the_mapping_is_read_back_as_it_was_written() {
    let Some(network) = Network::new("vmapping") else { return };
    let mut bench = network.bench();
    let rows = [
        (0x1600, 1, 0x6040_0010_u32),
        (0x1A01, 1, 0x6064_0020),
        (0x1400, 1, 0x0202),
        (0x1802, 1, 0x0382),
        (0x1402, 1, 0x8000_0402),
    ];
    for (index, sub, value) in rows {
        assert_eq!(
            bench.sdo(&reading(2, index, sub)).0,
            Ok(value.to_le_bytes().to_vec()),
            "{index:04X}h:{sub}"
        );
    }
}

#[test]
fn bus_off_fails_every_exchange_and_nothing_restarts_by_itself() {
    let Some(network) = Network::new("vbusoff") else { return };
    let mut bench = network.bench();
    bench.enter_op();
    let controller = network.raw();
    let error_frame = |class| CanErrorFrame::new_error(class, &[]).expect("an error frame");
    controller.write_frame(&error_frame(0x40)).expect("sent");
    let error = bench.exchange().expect_err("bus-off").to_string();
    assert!(error.starts_with("bus 0 (vbusoff): the CAN controller of the bench is off the bus"), "{error}");
    controller.write_frame(&error_frame(0x100)).expect("sent");
    bench.bus.request(BusState::Op);
    for _ in 0..20 {
        assert_eq!(bench.exchange().expect_err("for good").to_string(), error);
    }
    assert_eq!(bench.bus.state(), BusState::PreOp);
    let told = ["0: the CAN controller is off the bus", "0: the CAN controller was restarted"];
    assert_eq!(bench.notices(), told);
}

#[test]
fn an_error_passive_controller_is_told_and_the_exchanges_go_on() {
    let Some(network) = Network::new("vpassive") else { return };
    let mut bench = network.bench();
    let passive = CanErrorFrame::new_error(0x24, &[0, 0x20]).expect("an error frame");
    network.raw().write_frame(&passive).expect("sent");
    bench.exchange().expect("the wire works");
    assert_eq!(
        bench.notices(),
        ["0: the CAN controller is error passive, no other node acknowledges frames"]
    );
}

#[test]
fn an_interface_that_goes_down_fails_every_exchange_by_its_name() {
    let Some(network) = Network::new("vdown") else { return };
    let mut bench = network.bench();
    bench.enter_op();
    network.interface().bring_down().expect("root");
    let error = bench.exchange().expect_err("it is down").to_string();
    assert!(error.starts_with("bus 0 (vdown): the CAN interface failed: "), "{error}");
    network.interface().bring_up().expect("root");
    assert_eq!(bench.exchange().expect_err("for good").to_string(), error);
}

#[test]
fn an_interface_that_is_not_there_or_down_is_refused_with_what_to_do() {
    let Some(network) = Network::without_nodes("vrefused") else { return };
    let refused = |name: &str| SocketCan::open(name, clock()).err().expect("it must be refused").to_string();
    let missing = refused("nosuchcan0");
    assert!(
        missing.starts_with("nosuchcan0: the CAN interface cannot be used: ") && missing.contains("rig file"),
        "{missing}"
    );
    network.interface().bring_down().expect("root");
    let down = refused("vrefused");
    assert!(down.contains("run `ip link set vrefused up type can bitrate"), "{down}");
    assert!(refused("lo").contains("cannot be used"), "no CAN interface");
}

#[test]
fn frames_of_other_kinds_are_skipped() {
    let Some(network) = Network::without_nodes("vkinds") else { return };
    let mut link = network.link();
    let other = network.raw();
    let extended = ExtendedId::new(0x1234_5678).expect("29 bits");
    other.write_frame(&CanDataFrame::new(extended, &[1, 2, 3]).expect("a frame")).expect("sent");
    let standard = StandardId::new(0x702).expect("11 bits");
    other.write_frame(&CanRemoteFrame::new_remote(standard, 1).expect("a frame")).expect("sent");
    other.write_frame(&CanDataFrame::new(standard, &[0x05]).expect("a frame")).expect("sent");
    assert_eq!(heard(&mut link, Duration::from_millis(50)), [CanFrame::of(0x702, [0x05])]);
}

#[test]
fn a_bus_without_nodes_says_which_are_missing() {
    let Some(network) = Network::without_nodes("vempty") else { return };
    let settings = CanOpenSettings::usual("bus 0", 2e-3, &[1, 2]);
    let error =
        CanOpenBus::open(Box::new(network.link()), settings).err().expect("nobody is there").to_string();
    assert!(error.contains("expected boot-up within 2 s of node 1, 2, found none"), "{error}");
}
