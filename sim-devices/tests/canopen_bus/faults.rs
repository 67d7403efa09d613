//! What goes wrong on the wire and at the nodes, in one process.

use std::time::Duration;

use super::bench::{Bench, TICK, in_process, reading, settings};
use drivers::cia402::{PowerState, PowerTarget};
use drivers::wire::can::CanErrorFrame;
use drivers::wire::canopen::{CanOpenBus, CanOpenSettings};
use drivers::wire::{BusState, Exchange, Fieldbus, SdoAbort, SdoRequest};
use sim_devices::canopen::NodeFault;
use sim_devices::rig::Fault;

/// Exchanges without looking at the drives.
fn exchanges(bench: &mut Bench, count: u32) -> Vec<Exchange> {
    (0..count).map(|_| bench.exchange().expect("the wire works")).collect()
}

#[test]
fn a_wrong_toggle_bit_an_abort_and_a_mute_server_end_a_transfer_and_the_next_one_works() {
    let mut bench = in_process();
    bench.enter_op();
    let cases = [
        (NodeFault::WrongToggle { node: 1 }, SdoAbort(0x0503_0000), 1..20),
        (NodeFault::RefusesSdo { node: 1, code: Some(0x0800_0022) }, SdoAbort(0x0800_0022), 1..20),
        (NodeFault::SdoMute { node: 1, is_mute: true }, SdoAbort(0x0504_0000), 499..503),
    ];
    for (fault, abort, expected_ticks) in cases {
        bench.wire().inject(fault);
        let (outcome, ticks) = bench.sdo(&reading(1, 0x1008, 0));
        assert_eq!(outcome, Err(abort));
        assert!(expected_ticks.contains(&ticks), "{ticks} ticks of 2 ms");
        bench.wire().inject(NodeFault::RefusesSdo { node: 1, code: None });
        bench.wire().inject(NodeFault::SdoMute { node: 1, is_mute: false });
        assert!(bench.sdo(&reading(1, 0x1008, 0)).0.is_ok());
    }
    assert_eq!(bench.bus.state(), BusState::Op);
}

#[test]
fn an_emergency_is_told_with_code_and_meaning() {
    let mut bench = in_process();
    bench.enter_op();
    bench.wire().inject(NodeFault::Emergency { node: 2, code: 0x2310, register: 3 });
    exchanges(&mut bench, 2);
    assert_eq!(
        bench.notices(),
        ["2: emergency 2310h, continuous over-current at the output (error register 03h)"]
    );
    assert_eq!(bench.bus.state(), BusState::Op);
}

#[test]
fn a_fault_of_a_drive_comes_as_emergency_and_in_the_process_data() {
    let mut bench = in_process();
    bench.enable();
    let wire = bench.wire();
    wire.rig().schedule(Duration::ZERO, Fault::Drive { drive: 0, code: 0x4310 });
    exchanges(&mut bench, 4);
    bench.actuals[0] = bench.drives[0].decode(&bench.image.inputs);
    assert_eq!(bench.actuals[0].error_code, 0x4310);
    assert_eq!(bench.notices(), ["1: emergency 4310h, drive over-temperature (error register 09h)"]);
}

#[test]
fn a_node_without_heartbeat_is_lost_after_three_periods_and_stays_lost() {
    let mut bench = in_process();
    bench.enable();
    exchanges(&mut bench, 100);
    bench.wire().inject(NodeFault::HeartbeatStopped { node: 2, is_stopped: true });
    let begun = bench.now;
    while bench.bus.state() == BusState::Op {
        bench.tick(PowerTarget::Enabled, 0.0);
        assert!(bench.now - begun < Duration::from_secs(1), "it is never lost");
    }
    // The last heartbeat came at most one period before.
    let silent = bench.now - begun;
    assert!((100..=155).contains(&silent.as_millis()), "{silent:?}");
    assert!(bench.notices()[0].starts_with("2: no heartbeat for 0.15"));
    assert_eq!(bench.bus.state(), BusState::PreOp);
    bench.wire().inject(NodeFault::HeartbeatStopped { node: 2, is_stopped: false });
    bench.wire().sent();
    bench.bus.request(BusState::Op);
    let later = exchanges(&mut bench, 100);
    assert!(later.iter().all(|exchange| exchange.working_counter == 1 && exchange.expected == 2));
    let sent = bench.wire().sent();
    assert!(sent.iter().all(|frame| ![0x202, 0x302].contains(&frame.id())), "it is not commanded any more");
    assert!(!sent.iter().any(|frame| frame.id() == 0x000 && frame.data()[1] == 2), "nor started again");
}

#[test]
fn a_node_that_begins_anew_is_told_and_not_started_again() {
    let mut bench = in_process();
    bench.enable();
    bench.wire().inject(NodeFault::Restart { node: 1 });
    exchanges(&mut bench, 3);
    assert_eq!(bench.notices(), ["1: left the state operational by itself: it is begun anew (boot-up)"]);
    bench.wire().sent();
    let later = exchanges(&mut bench, 50);
    assert!(later.iter().all(|exchange| exchange.working_counter == 1));
    assert_eq!(bench.bus.state(), BusState::PreOp);
    assert!(bench.wire().sent().iter().all(|frame| frame.id() != 0x000));
}

#[test]
fn a_cable_that_breaks_costs_the_node_at_once_and_is_told_with_its_heartbeat() {
    let mut bench = in_process();
    bench.enable();
    let inputs = bench.image.inputs.clone();
    bench.wire().inject(NodeFault::Silent { node: 2, is_silent: true });
    let counters: Vec<_> = exchanges(&mut bench, 4).iter().map(|exchange| exchange.working_counter).collect();
    // What was on the wire when it broke still arrives.
    assert_eq!(counters[1..], [1, 1, 1]);
    assert_ne!(bench.image.inputs[..28], inputs[..28], "the other drive's inputs go on");
    exchanges(&mut bench, 100);
    assert!(bench.notices().iter().any(|notice| notice.starts_with("2: no heartbeat for 0.1")));
}

#[test]
fn a_lost_sync_costs_one_exchange_and_keeps_the_inputs() {
    let mut bench = in_process();
    bench.enable();
    bench.wire().rig().schedule(Duration::ZERO, Fault::FramesLost { count: 1 });
    let counters: Vec<_> = exchanges(&mut bench, 4).iter().map(|exchange| exchange.working_counter).collect();
    assert_eq!(counters.iter().filter(|&&counter| counter == 0).count(), 1, "{counters:?}");
    assert_eq!(counters[3], 2);
}

#[test]
fn bus_off_fails_every_exchange_and_nothing_restarts_by_itself() {
    let mut bench = in_process();
    bench.enable();
    bench.wire().inject(NodeFault::ControllerError(CanErrorFrame::BUS_OFF));
    let error = bench.exchange().expect_err("bus-off").to_string();
    assert!(
        error.starts_with(
            "bus 0 (simulated CAN): the CAN controller of the bench is off the bus; check wiring"
        ),
        "{error}"
    );
    assert_eq!(bench.notices(), ["0: the CAN controller is off the bus"]);
    let restarted = CanErrorFrame { classes: 0x100, detail: [0; 8] };
    bench.wire().inject(NodeFault::ControllerError(restarted));
    bench.wire().sent();
    bench.bus.request(BusState::Op);
    for _ in 0..50 {
        assert_eq!(bench.exchange().expect_err("for good").to_string(), error);
    }
    assert_eq!(bench.bus.state(), BusState::PreOp);
    let sent = bench.wire().sent();
    assert!(sent.iter().all(|frame| frame.id() == 0x000), "neither SYNC nor RPDOs: {sent:?}");
    assert_eq!(bench.notices(), ["0: the CAN controller was restarted"]);
}

#[test]
fn an_error_passive_controller_is_told_once_and_the_exchanges_go_on() {
    let mut bench = in_process();
    bench.enable();
    let passive = CanErrorFrame { classes: 0x04, detail: [0, 0x20, 0, 0, 0, 0, 0, 0] };
    for _ in 0..10 {
        bench.wire().inject(NodeFault::ControllerError(passive));
        let exchange = bench.tick(PowerTarget::Enabled, 0.0);
        assert_eq!(exchange.working_counter, 2);
    }
    assert_eq!(bench.notices(), ["0: the CAN controller is error passive"]);
}

#[test]
fn drives_stop_by_themselves_when_the_loop_hangs() {
    let mut bench = in_process();
    bench.enable();
    bench.move_for(500, 0.2);
    let mut wire = bench.wire();
    let emergencies = |wire: &mut super::bench::Wire, lasting| {
        let frames = wire.heard(lasting);
        frames
            .iter()
            .filter(|frame| frame.id() == 0x081)
            .map(|frame| frame.data()[..2].to_vec())
            .collect::<Vec<_>>()
    };
    // The process data watchdog: 100 ms.
    assert_eq!(emergencies(&mut wire, Duration::from_millis(90)), [] as [Vec<u8>; 0]);
    let first = emergencies(&mut wire, Duration::from_millis(110));
    // The heartbeat of the bench: 150 ms.
    assert_eq!(first, [vec![0x00, 0x75], vec![0x30, 0x81]]);
    let rate_rad_per_s = wire.truth().rate_rad_per_s[0];
    assert!(rate_rad_per_s < 0.2, "{rate_rad_per_s}");
    emergencies(&mut wire, Duration::from_secs(1));
    let rate_rad_per_s = wire.truth().rate_rad_per_s[0];
    assert!(rate_rad_per_s.abs() < 0.001, "{rate_rad_per_s}");
}

#[test]
fn rpdos_that_come_without_the_heartbeat_of_the_bench_stop_the_drive_too() {
    let mut bench = in_process();
    bench.enable();
    let mut wire = bench.wire();
    // The last frames of the bench, again and again: a sender that repeats them for a loop that hangs.
    wire.sent();
    bench.move_for(2, 0.1);
    let last: Vec<_> = wire.sent().into_iter().filter(|frame| frame.id() < 0x580).collect();
    let mut emergencies = Vec::new();
    for _ in 0..100 {
        use drivers::wire::can::CanLink;
        last.iter().for_each(|frame| wire.send(frame).expect("the wire works"));
        emergencies.extend(wire.heard(TICK).into_iter().filter(|frame| frame.id() == 0x081));
    }
    let codes: Vec<_> = emergencies.iter().map(|frame| frame.data()[..2].to_vec()).collect();
    assert_eq!(codes, [vec![0x30, 0x81], vec![0x00, 0x75]]);
}

#[test]
fn a_drive_in_fault_reads_as_such_after_its_connection_was_lost() {
    let mut bench = in_process();
    bench.enable();
    let mut wire = bench.wire();
    wire.heard(Duration::from_millis(400));
    bench.bus.request(BusState::Op);
    exchanges(&mut bench, 5);
    bench.actuals[0] = bench.drives[0].decode(&bench.image.inputs);
    assert_eq!(
        bench.states()[0],
        PowerState::OperationEnabled,
        "the last sample stands: the node has left operational"
    );
    assert_eq!(bench.bus.state(), BusState::PreOp);
}

/// What the bench writes to 6007h: after the bus is lost the drive stops by a ramp and, by 605Ah, keeps its torque on.
#[test]
fn a_drive_that_holds_an_axis_is_not_reset_until_the_axes_are_secured() {
    let mut bench = in_process();
    for station in [1, 2] {
        let write = Some(&[3, 0][..]);
        let request = SdoRequest { station, index: 0x6007, sub: 0, write };
        bench.wire().rig().bus().start(bench.now, &request);
    }
    bench.enable();
    let wire = bench.wire();
    wire.sent();
    let error = CanOpenBus::open(Box::new(wire.clone()), settings()).err().expect("it holds").to_string();
    assert!(
        error.contains("node 1: torque: expected a drive that holds nothing, found statusword"),
        "{error}"
    );
    assert!(error.contains("secure all axes mechanically"), "{error}");
    assert!(wire.sent().iter().all(|frame| frame.id() != 0x000), "no command of network management was sent");
    let secured = CanOpenSettings { may_let_go: true, ..settings() };
    CanOpenBus::open(Box::new(wire), secured).map(|_| ()).expect("somebody has secured the axes");
}
