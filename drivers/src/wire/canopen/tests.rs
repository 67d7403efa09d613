//! The bus on an interface that does what the test says.

use std::cell::RefCell;
use std::rc::Rc;

use super::*;
use proptest::prelude::*;

/// An interface in the hands of the test.
#[derive(Default)]
struct Interface {
    now: Duration,
    events: VecDeque<CanEvent>,
    sent: Vec<CanFrame>,
    /// How many frames its queue takes before it is full.
    room: Option<usize>,
    is_down: bool,
}

#[derive(Clone, Default)]
struct Link(Rc<RefCell<Interface>>);

impl CanLink for Link {
    fn name(&self) -> &str {
        "can0"
    }

    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        let mut interface = self.0.borrow_mut();
        if interface.is_down {
            return Err(io::ErrorKind::NetworkDown.into());
        }
        if interface.room == Some(0) {
            return Err(io::Error::from_raw_os_error(105));
        }
        interface.room = interface.room.map(|room| room - 1);
        interface.sent.push(*frame);
        Ok(())
    }

    fn receive(&mut self) -> io::Result<Option<CanEvent>> {
        let mut interface = self.0.borrow_mut();
        if interface.is_down {
            Err(io::ErrorKind::NetworkDown.into())
        } else {
            Ok(interface.events.pop_front())
        }
    }

    fn now(&self) -> Duration {
        self.0.borrow().now
    }

    fn wait(&mut self, until: Duration) -> io::Result<()> {
        self.0.borrow_mut().now = until;
        Ok(())
    }
}

/// A mapped bus of two nodes in operation, each with an RPDO of 2 bytes and a TPDO of 3.
fn operational() -> (CanOpenBus, Link, ProcessImage) {
    let link = Link::default();
    let settings = CanOpenSettings::usual("bus 0", 2e-3, &[1, 2]);
    let nodes = [1, 2].map(|id| {
        let k = usize::from(id - 1);
        let mut node = Node::new(id);
        (node.state, node.wanted) = (NmtState::Operational, NmtState::Operational);
        (node.rpdos, node.tpdos) = ([2, 0, 0, 0], [3, 0, 0, 0]);
        (node.has_booted, node.heard) = (true, Some(Duration::ZERO));
        node.slot = Slot { outputs: 2 * k..2 * k + 2, inputs: 3 * k..3 * k + 3 };
        node
    });
    let bus = CanOpenBus {
        name: "bus 0 (can0)".to_owned(),
        settings,
        link: Box::new(link.clone()),
        nodes: nodes.to_vec(),
        sdo: SdoClient::new(),
        mapped: Some([4, 6]),
        is_alone: true,
        commands: true,
        heartbeat_due: None,
        failure: None,
        notices: VecDeque::new(),
        last_error: None,
    };
    (bus, link, ProcessImage { outputs: vec![1, 2, 3, 4], inputs: vec![0; 6] })
}

fn sent(link: &Link) -> Vec<CanFrame> {
    std::mem::take(&mut link.0.borrow_mut().sent)
}

fn hear(link: &Link, id: u16, data: &[u8]) {
    let frame = CanFrame::new(id, data).expect("a classic frame");
    link.0.borrow_mut().events.push_back(CanEvent::Frame(frame));
}

#[test]
fn an_exchange_takes_tpdos_and_sends_rpdos_then_sync_then_a_heartbeat_when_it_is_due() {
    let (mut bus, link, mut image) = operational();
    hear(&link, 0x181, &[7, 8, 9]);
    let exchange = bus.exchange(Duration::from_millis(2), &mut image).expect("the interface works");
    assert_eq!(exchange, Exchange { working_counter: 1, expected: 2 });
    assert_eq!(image.inputs, [7, 8, 9, 0, 0, 0]);
    let outputs = [CanFrame::of(0x201, [1, 2]), CanFrame::of(0x202, [3, 4])];
    let [sync, heartbeat] = [CanFrame::of(0x080, []), CanFrame::of(0x77F, [0x05])];
    assert_eq!(sent(&link), [outputs[0], outputs[1], sync, heartbeat]);
    bus.exchange(Duration::from_millis(4), &mut image).expect("the interface works");
    assert_eq!(sent(&link), [outputs[0], outputs[1], sync]);
    bus.exchange(Duration::from_millis(52), &mut image).expect("the interface works");
    assert_eq!(sent(&link).last(), Some(&heartbeat));
    bus.request(BusState::SafeOp);
    sent(&link);
    bus.exchange(Duration::from_millis(54), &mut image).expect("the interface works");
    assert_eq!(sent(&link), [sync], "nothing is commanded");
}

#[test]
fn a_full_queue_fails_one_exchange_before_its_sync_and_the_next_one_works() {
    let (mut bus, link, mut image) = operational();
    link.0.borrow_mut().room = Some(1);
    let error = bus.exchange(Duration::from_millis(2), &mut image).expect_err("no room").to_string();
    assert!(
        error.starts_with("bus 0 (can0): frame 202h was not sent, the queue of the interface is full"),
        "{error}"
    );
    assert_eq!(sent(&link), [CanFrame::of(0x201, [1, 2])], "no SYNC after half of the outputs");
    link.0.borrow_mut().room = None;
    assert!(bus.exchange(Duration::from_millis(4), &mut image).is_ok());
}

#[test]
fn an_interface_that_fails_once_fails_for_good() {
    let (mut bus, link, mut image) = operational();
    link.0.borrow_mut().is_down = true;
    let error = bus.exchange(Duration::from_millis(2), &mut image).expect_err("down").to_string();
    assert!(error.starts_with("bus 0 (can0): the CAN interface failed: "), "{error}");
    link.0.borrow_mut().is_down = false;
    assert_eq!(bus.exchange(Duration::from_millis(4), &mut image).expect_err("for good").to_string(), error);
    assert_eq!((bus.state(), sent(&link)), (BusState::PreOp, Vec::new()));
    let mut read = Vec::new();
    bus.start(Duration::from_millis(4), &SdoRequest { station: 1, index: 0x1000, sub: 0, write: None });
    assert_eq!(bus.poll(Duration::from_millis(4), &mut read), Err(SdoAbort(0x0504_0000)));
}

#[test]
fn an_exchange_before_the_bus_was_mapped_is_an_error() {
    let (mut bus, _, mut image) = operational();
    bus.mapped = None;
    let error = bus.exchange(Duration::ZERO, &mut image).expect_err("not mapped").to_string();
    assert_eq!(error, "bus 0 (can0): exchange before the bus was mapped");
}

proptest! {
    #[test]
    fn no_frame_on_the_bus_is_too_strange(
        frames in prop::collection::vec((0_u16..0x800, prop::collection::vec(any::<u8>(), 0..=8)), 0..300),
        errors in prop::collection::vec((any::<u32>(), any::<[u8; 8]>()), 0..100),
    ) {
        let (mut bus, link, mut image) = operational();
        bus.start(Duration::ZERO, &SdoRequest { station: 1, index: 0x1008, sub: 0, write: None });
        for (id, data) in &frames {
            hear(&link, *id, data);
        }
        let errors = errors.into_iter().map(|(classes, detail)| CanEvent::Error(CanErrorFrame { classes, detail }));
        link.0.borrow_mut().events.extend(errors);
        for tick in 1..20 {
            if let Ok(exchange) = bus.exchange(Duration::from_millis(2 * tick), &mut image) {
                prop_assert!(exchange.working_counter <= exchange.expected);
            }
        }
        let mut notices_count = 0;
        bus.tell_notices(&mut |notice| {
            assert!(!notice.news.text().is_empty());
            notices_count += 1;
        });
        prop_assert!(notices_count <= MOST_NOTICES);
    }
}
