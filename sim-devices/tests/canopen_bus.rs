//! The production CANopen bus against simulated nodes: in one process and in simulated time, and over virtual CAN interfaces of
//! Linux (module `vcan`, skipped where the kernel has no CAN).

#[path = "canopen_bus/bench.rs"]
mod bench;
#[path = "canopen_bus/faults.rs"]
mod faults;
#[path = "ethercat_bus/profile.rs"]
mod profile;
#[cfg(target_os = "linux")]
#[path = "canopen_bus/vcan.rs"]
mod vcan;

use std::time::Duration;

use bench::{Bench, TICK, in_process, reading, settings, simulated};
use drivers::cia402::{PowerState, PowerTarget};
use drivers::wire::can::CanFrame;
use drivers::wire::canopen::{CanOpenBus, CanOpenSettings};
use drivers::wire::ethercat::ExpectedStation;
use drivers::wire::{BusState, Fieldbus, SdoAbort, SdoRequest};

#[test]
fn nodes_are_opened_mapped_and_started() {
    let bench = in_process();
    assert_eq!(bench.bus.stations(), [1, 2]);
    assert_eq!(bench.bus.name(), "bus 0 (simulated CAN)");
    assert_eq!(bench.slots[0].1.outputs, 0..10);
    assert_eq!(bench.slots[1].1.inputs, 28..56);
    assert_eq!(bench.bus.state(), BusState::SafeOp);
    assert_eq!(bench.identities[1].device_name, "SIM servo drive");
}

#[test]
fn two_drives_run_20_000_cycles_without_a_missing_node() {
    let mut bench = in_process();
    let first = bench.tick(PowerTarget::Disabled, 0.0);
    assert_eq!(
        (first.working_counter, first.expected),
        (2, 2),
        "inputs are there from the first exchange on"
    );
    bench.enable();
    for _ in 0..20_000 {
        let exchange = bench.tick(PowerTarget::Enabled, 0.0);
        assert_eq!(exchange.working_counter, exchange.expected);
    }
    assert_eq!(bench.states(), [PowerState::OperationEnabled; 2]);
    assert_eq!(bench.notices(), [] as [String; 0]);
}

#[test]
fn an_enabled_drive_moves_at_the_velocity_that_it_is_told() {
    let mut bench = in_process();
    bench.enable();
    bench.move_for(500, 0.2);
    let before_rad = bench.actuals[0].position_rad;
    bench.move_for(500, 0.2);
    let moved_rad = bench.actuals[0].position_rad - before_rad;
    assert!((moved_rad - 0.2).abs() < 0.01, "{moved_rad} rad in 1 s at 0.2 rad/s");
    let true_rad = bench.wire().truth().angle_rad[0];
    assert!((true_rad - bench.actuals[0].position_rad).abs() < 0.002, "{true_rad}");
}

#[test]
fn without_rpdos_nothing_is_commanded() {
    let mut bench = in_process();
    for _ in 0..500 {
        bench.tick(PowerTarget::Enabled, 0.0);
    }
    assert_eq!(bench.bus.state(), BusState::SafeOp);
    assert_eq!(bench.states(), [PowerState::SwitchOnDisabled; 2]);
}

#[test]
fn sdo_transfers_go_beside_the_exchanges() {
    let mut bench = in_process();
    bench.enter_op();
    assert_eq!(bench.sdo(&reading(1, 0x1008, 0)).0, Ok(b"SIM servo drive".to_vec()));
    let torque = 500_u16.to_le_bytes();
    let write = SdoRequest { station: 2, index: 0x6072, sub: 0, write: Some(&torque) };
    assert_eq!(bench.sdo(&write).0, Ok(Vec::new()));
    assert_eq!(bench.sdo(&reading(2, 0x6072, 0)).0, Ok(torque.to_vec()));
    assert_eq!(bench.sdo(&reading(1, 0x5555, 0)).0, Err(SdoAbort(0x0602_0000)));
    assert_eq!(bench.sdo(&reading(77, 0x1008, 0)).0, Err(SdoAbort(0x0504_0000)), "no such node");
    assert_eq!(bench.sdo(&reading(700, 0x1008, 0)).0, Err(SdoAbort(0x0504_0000)), "no node-ID");
    let long = SdoRequest { station: 1, index: 0x6065, sub: 0, write: Some(b"ten bytes.") };
    assert_eq!(bench.sdo(&long).0, Err(SdoAbort(0x0607_0010)), "segments arrive and are too many bytes");
}

#[test]
fn the_mapping_is_read_back_as_it_was_written() {
    let mut bench = in_process();
    let rows: [(u16, u8, u32); 10] = [
        (0x1600, 1, 0x6040_0010),
        (0x1601, 1, 0x6060_0008),
        (0x1A01, 2, 0x606C_0020),
        (0x1A03, 2, 0x60FD_0020),
        (0x1400, 1, 0x0000_0201),
        (0x1401, 1, 0x0000_0301),
        (0x1402, 1, 0x8000_0401),
        (0x1803, 1, 0x0000_0481),
        (0x1016, 1, 127 << 16 | 150),
        (0x1800, 2, 1),
    ];
    for (index, sub, value) in rows {
        let bytes = bench.sdo(&reading(1, index, sub)).0.expect("an object");
        let found = bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte));
        assert_eq!(found, value, "{index:04X}h:{sub}");
    }
}

fn refused(settings: CanOpenSettings) -> String {
    let (link, _) = simulated();
    CanOpenBus::open(Box::new(link), settings).err().expect("this bus must be refused").to_string()
}

#[test]
fn a_node_that_is_not_there_or_is_another_one_is_named() {
    let missing = refused(CanOpenSettings::usual("bus 0", TICK.as_secs_f64(), &[1, 2, 5]));
    assert!(
        missing
            .starts_with("bus 0 (simulated CAN): nodes: expected boot-up within 2 s of node 5, found none"),
        "{missing}"
    );
    let stranger = ExpectedStation { station: 2, vendor: Some(0x9A), ..ExpectedStation::default() };
    let other = refused(CanOpenSettings { nodes: vec![stranger], ..settings() });
    assert!(
        other.starts_with(
            "bus 0 (simulated CAN), node 2: object 1018h:01 (vendor id): expected 0000009Ah, found 0053494Dh"
        ),
        "{other}"
    );
}

#[test]
fn a_cycle_that_is_too_short_for_its_frames_is_refused() {
    let (link, clock) = simulated();
    let settings = CanOpenSettings::usual("bus 0", 1e-3, &[1, 2]);
    let error = Bench::open(Box::new(link), clock, settings).err().expect("1.4 ms of frames").to_string();
    assert!(
        error.contains("setting cycle_s is 0.001; the process data of 2 nodes need a cycle of at least 0.001639 s at 1000000 bit/s"),
        "{error}"
    );
    let (link, clock) = simulated();
    assert!(Bench::open(Box::new(link), clock, CanOpenSettings::usual("bus 0", 1e-3, &[1])).is_ok());
}

#[test]
fn a_second_main_device_is_refused_at_the_start_and_ends_every_exchange_later() {
    for id in [0x000, 0x080, 0x77F] {
        let mut bench = in_process();
        bench.enable();
        bench.wire().hear(CanFrame::new(id, &[0x05][..usize::from(id == 0x77F)]).expect("a frame"));
        bench.now += TICK * 2;
        let error = bench.exchange().expect_err("not alone").to_string();
        assert!(error.contains("another"), "{error}");
        assert_eq!(bench.exchange().expect_err("for good").to_string(), error);
        assert_eq!(bench.bus.state(), BusState::PreOp);
    }
    let (link, _) = simulated();
    link.hear(CanFrame::of(0x080, []));
    let error = CanOpenBus::open(Box::new(link.clone()), settings()).err().expect("not alone").to_string();
    assert!(error.contains("another main device sends on this bus (identifier 080h)"), "{error}");
    assert_eq!(link.sent(), [], "the other one's nodes are left alone");
}

#[test]
fn an_image_of_another_bus_is_refused() {
    let mut bench = in_process();
    bench.image.outputs.pop();
    let error = bench.exchange().expect_err("19 bytes").to_string();
    assert!(error.contains("19 bytes of outputs and 56 of inputs, expected 20 and 56"), "{error}");
}

#[test]
fn a_bus_that_is_dropped_leaves_the_nodes_pre_operational() {
    let mut bench = in_process();
    bench.enable();
    let mut wire = bench.wire();
    drop(bench);
    let beats: Vec<_> =
        wire.heard(Duration::from_millis(60)).into_iter().filter(|frame| frame.id() > 0x700).collect();
    assert_eq!(beats, [CanFrame::of(0x701, [0x7F]), CanFrame::of(0x702, [0x7F])]);
}
