//! Drives with fixed PDOs on the wire, and a digital terminal behind them.

use std::sync::Arc;

use drivers::cia402::objects::DataType;
use drivers::cia402::profile::{
    DriveProfile, HeatSink, ObjectPlace, ProcessData, ProfileIdentity, ReadBy, StartUp, TorqueScale,
};
use drivers::cia402::{CyclicMode, DriveCommand, PowerState, PowerTarget};
use drivers::wire::ethercat::terminal::DigitalTerminal;
use drivers::wire::{BusState, EthernetLink, Fieldbus};
use sim_devices::ethercat::{LineFault, Terminals};
use sim_devices::rig::{DriveType, Fault, SimulatedRig};

use crate::bench::{Bench, SharedLink, reading};
use crate::profile;

/// Drives, then the digital terminal.
const DIGITAL: Terminals = Terminals { analog: false, digital: true };

/// As `drivers/profiles/elmo-gold.toml` has it.
fn elmo() -> Arc<DriveProfile> {
    let synchronised = |index| StartUp {
        place: ObjectPlace { index, sub: 1 },
        data_type: DataType::U16,
        value: 2,
        why: "SYNC0".to_owned(),
    };
    Arc::new(DriveProfile {
        id: "elmo-gold".to_owned(),
        identity: ProfileIdentity {
            vendor: Some(0x9A),
            product: Some(0x30924),
            revisions: Some([0x10420, 0x10420]),
        },
        outputs: ProcessData::Assigned(vec![0x1602, 0x161C, 0x160B]),
        inputs: ProcessData::Assigned(vec![0x1A02, 0x1A11, 0x1A18, 0x1A1C, 0x1A1F, 0x1A26]),
        torque_scale: TorqueScale::RatedCurrent,
        heat_sink: Some(HeatSink {
            place: ObjectPlace { index: 0x22A3, sub: 1 },
            data_type: DataType::I16,
            counts_per_degc: 1.0,
            by: ReadBy::Sdo,
        }),
        watchdog: None,
        start_up: [0x1C32, 0x1C33].map(synchronised).to_vec(),
        ..(*profile::simulated()).clone()
    })
}

fn line() -> (SharedLink, SimulatedRig) {
    SharedLink::with_line(DriveType::ElmoGold, DIGITAL)
}

#[test]
fn drives_with_fixed_pdos_and_padding_are_opened_enabled_and_move() {
    let (link, rig) = line();
    let mut bench = Bench::of_type(link, elmo());
    assert_eq!((bench.identities[0].vendor, bench.identities[0].product), (0x9A, 0x30924));
    assert_eq!((bench.slots[0].1.outputs.clone(), bench.slots[1].1.inputs.clone()), (0..10, 26..52));
    bench.enter_op();
    assert_eq!(bench.sdo(&reading(1, 0x1C32, 1)).0, Ok(vec![2, 0]), "the start-up list is in force");
    let before = rig.truth_of_axes();
    for _ in 0..2000 {
        bench.tick(PowerTarget::Enabled);
    }
    assert_eq!(bench.states(), [PowerState::OperationEnabled; 2]);
    assert!((bench.actuals[0].position_rad + 1.0).abs() < 1e-3, "{:?}", bench.actuals[0]);
    assert!((bench.actuals[0].bus_v - 560.0).abs() < 1.0);
    assert_eq!((bench.actuals[0].heat_sink_degc, bench.actuals[0].mode), (45.0, 10));
    for _ in 0..400 {
        bench.exchange();
        let actuals = bench.drives[0].decode(&bench.image.inputs);
        let controlword = bench.drives[0]
            .controlword(PowerTarget::Enabled, actuals.statusword, actuals.error_code, bench.now)
            .expect("it is enabled");
        let mode = CyclicMode::Torque;
        let command = DriveCommand { controlword, mode, torque_nm: 1200.0, velocity_rad_per_s: 0.0 };
        let sent_nm = bench.drives[0].encode(&command, &mut bench.image.outputs);
        assert_eq!(sent_nm, 1200.0, "10 000 ‰ of 2 A at 60 N·m/A");
        bench.actuals[0] = actuals;
    }
    assert!((bench.actuals[0].current_a - 20.0).abs() < 0.5, "{:?}", bench.actuals[0]);
    let moved_rad = rig.truth_of_axes().angle_rad[0] - before.angle_rad[0];
    assert!(moved_rad > 1e-3, "{moved_rad}");
}

#[test]
fn a_temperature_by_sdo_is_read_beside_the_exchanges_and_is_lost_when_the_mailbox_is_mute() {
    let (link, rig) = line();
    let mut bench = Bench::of_type(link.clone(), elmo());
    bench.enter_op();
    rig.schedule(link.now(), Fault::HeatSink { drive: 0, degc: 71.0 });
    let degc = |bench: &mut Bench, ticks: u32| {
        for _ in 0..ticks {
            let now = bench.now;
            bench.drives[0].poll_heat_sink(&mut bench.bus, now, true);
            bench.tick(PowerTarget::Disabled);
        }
        bench.actuals[0].heat_sink_degc
    };
    let seen = degc(&mut bench, 8000);
    assert!((seen - 71.0).abs() <= 1.0, "{seen} after 2 s");
    link.inject(LineFault::Mute { device: 0, is_mute: true });
    assert!(degc(&mut bench, 32_000).is_finite(), "8 s of silence");
    assert!(degc(&mut bench, 12_000).is_nan(), "11 s of silence");
    assert_eq!(bench.bus.state(), BusState::Op);
}

#[test]
fn a_drive_of_another_type_than_its_profile_is_refused() {
    let refusal = |drive_type, profile| Bench::refusal(SharedLink::with_line(drive_type, DIGITAL).0, profile);
    let error = refusal(DriveType::Simulated, elmo());
    assert!(error.contains("1018h:01 (vendor id): expected 0000009Ah (profile `elmo-gold`)"), "{error}");
    let error = refusal(DriveType::ElmoGold, profile::simulated());
    assert!(error.contains("1600h:00") && error.contains("no such object"), "{error}");
}

#[test]
fn the_input_of_a_digital_terminal_follows_the_emergency_stop_chain() {
    let (link, rig) = line();
    let mut bench = Bench::of_type(link.clone(), elmo());
    let (station, slot) = bench.slots[2].clone();
    assert_eq!((station, slot.inputs.len(), slot.outputs.len()), (3, 1, 0));
    let terminal = DigitalTerminal::new("inputs", &slot);
    bench.enter_op();
    let is_closed = |bench: &mut Bench| {
        for _ in 0..8 {
            bench.tick(PowerTarget::Disabled);
        }
        terminal.is_on(&bench.image, 0)
    };
    assert_eq!(is_closed(&mut bench), Ok(true));
    rig.schedule(link.now(), Fault::EmergencyStop { pressed: true });
    assert_eq!(is_closed(&mut bench), Ok(false));
    rig.schedule(link.now(), Fault::EmergencyStop { pressed: false });
    assert_eq!(is_closed(&mut bench), Ok(true));
    link.inject(LineFault::Unplugged { device: 2, is_gone: true });
    let exchange = bench.exchange();
    assert_eq!(
        (exchange.expected - exchange.working_counter, exchange.expected),
        (1, 7),
        "and the bus trips"
    );
}
