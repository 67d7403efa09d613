//! The production EtherCAT bus against emulated SubDevices, in one process and in simulated time.

#[path = "ethercat_bus/bench.rs"]
mod bench;
#[path = "ethercat_bus/elmo.rs"]
mod elmo;
#[path = "ethercat_bus/mailbox.rs"]
mod mailbox;
#[path = "ethercat_bus/profile.rs"]
mod profile;
#[path = "ethercat_bus/wire.rs"]
mod wire;

use std::time::Duration;

use bench::{Bench, SharedLink, TICK, drive_settings, reading, settings};
use drivers::cia402::{PowerState, PowerTarget};
use drivers::wire::ethercat::terminal::{AnalogTerminal, TerminalChannel};
use drivers::wire::ethercat::{DistributedClocks, EtherCatBus, EtherCatSettings, ExpectedStation};
use drivers::wire::{BusState, EthernetLink, Fieldbus, SdoAbort, SdoRequest, SdoWire};
use sim_devices::ethercat::{Emergency, LineFault};

#[test]
fn stations_are_found_with_name_identity_and_number() {
    let bench = Bench::new();
    let infos = bench.bus.station_infos();
    assert_eq!(bench.bus.stations(), [1, 2, 3]);
    assert_eq!(infos[1].configured_address, 0x1001);
    assert_eq!([infos[0].has_mailbox, infos[2].has_mailbox], [true, false]);
    for (info, identity) in infos.iter().zip(&bench.identities) {
        assert_eq!(info.name, identity.device_name);
        assert_eq!((info.vendor, info.product), (identity.vendor, identity.product));
        assert_eq!((info.revision, info.serial), (identity.revision, identity.serial));
    }
    assert_eq!(bench.slots[0].1.outputs, 0..10);
    assert_eq!(bench.slots[1].1.inputs, 28..56);
    assert_eq!(bench.bus.state(), BusState::SafeOp);
}

#[test]
fn two_drives_run_20_000_cycles_in_op_without_a_wrong_working_counter() {
    let mut bench = Bench::new();
    bench.enter_op();
    let before = bench.bus.link_counts();
    for _ in 0..20_000 {
        let exchange = bench.tick(PowerTarget::Enabled);
        assert_eq!(exchange.working_counter, exchange.expected);
        assert_eq!(exchange.expected, 9);
    }
    assert_eq!(bench.states(), [PowerState::OperationEnabled; 2]);
    assert_eq!(bench.bus.al_errors().count(), 0);
    let after = bench.bus.link_counts();
    assert_eq!((after.late, after.foreign, after.own), (0, 0, 0));
    assert!(after.sent - before.sent >= 20_000);
    let clock = bench.bus.dc_status().expect("distributed clocks are on");
    assert!(clock.after_sync0 < TICK);
    assert_eq!(clock.at, bench.now);
}

/// Whoever opens it anew sets the clocks and the start of SYNC0 again.
#[test]
fn a_bus_that_is_opened_a_second_time_runs_as_it_did_the_first_time() {
    let mut first = Bench::new();
    first.enter_op();
    for _ in 0..500 {
        first.tick(PowerTarget::Enabled);
    }
    let link = first.link.clone();
    drop(first);
    let let_go = EtherCatSettings { may_let_go: true, ..settings() };
    let bus = EtherCatBus::open(Box::new(link.clone()), let_go).expect("the same stations answer");
    let mut second = Bench::on(link, bus, profile::simulated());
    second.enter_op();
    for _ in 0..4000 {
        let exchange = second.tick(PowerTarget::Enabled);
        assert_eq!(exchange.working_counter, exchange.expected);
    }
    assert_eq!(second.states(), [PowerState::OperationEnabled; 2]);
}

/// A clock that leaps to just after a later pulse: that pulse was, by the world, before the one that was worked on last.
#[test]
fn a_clock_that_leaps_between_pulses_panics_nobody() {
    let mut bench = Bench::new();
    bench.enter_op();
    for k in 0..400 {
        bench.link.inject(LineFault::ClockStep { device: k % 2, by_ns: 20_100_000 + 7_300 * k as i64 });
        bench.exchange();
    }
}

#[test]
fn a_bus_without_distributed_clocks_runs_by_its_frames() {
    let mut bench = Bench::with(EtherCatSettings { distributed_clocks: None, ..settings() });
    bench.enter_op();
    for _ in 0..4000 {
        let exchange = bench.tick(PowerTarget::Enabled);
        assert_eq!(exchange.working_counter, exchange.expected);
    }
    assert_eq!(bench.bus.dc_status(), None);
    assert_eq!(bench.states(), [PowerState::OperationEnabled; 2]);
}

#[test]
fn lost_late_repeated_and_damaged_replies_do_no_harm() {
    let mut bench = Bench::new();
    bench.enter_op();
    let faults = [
        LineFault::Drop { frames: 3 },
        LineFault::Delay { frames: 3, by: Duration::from_millis(1) },
        LineFault::Duplicate { frames: 3 },
        LineFault::Corrupt { frames: 3, byte: 17 },
        LineFault::Truncate { frames: 3, bytes: 40 },
    ];
    for fault in faults {
        bench.link.inject(fault);
        let mut lost_count = 0;
        for _ in 0..40 {
            let exchange = bench.tick(PowerTarget::Disabled);
            assert!([0, exchange.expected].contains(&exchange.working_counter), "{fault:?}");
            lost_count += usize::from(exchange.working_counter == 0);
        }
        assert!(lost_count <= 3, "{fault:?}: {lost_count}");
        assert_eq!(bench.bus.state(), BusState::Op, "{fault:?}");
    }
    let counts = bench.bus.link_counts();
    assert!(counts.late >= 5 && counts.foreign >= 4, "{counts:?}");
}

#[test]
fn a_reply_of_an_older_tick_is_never_taken_for_a_newer_one() {
    let mut bench = Bench::new();
    bench.enter_op();
    // The one-byte indices of datagrams come round after some 50 ticks.
    for ticks_late in 1..80 {
        let inputs = bench.image.inputs.clone();
        bench.link.inject(LineFault::Delay { frames: 2, by: TICK * ticks_late });
        let exchange = bench.exchange();
        assert_eq!(exchange.working_counter, 0);
        assert_eq!(bench.image.inputs, inputs, "the inputs stay as they were");
        bench.link.inject(LineFault::Delay { frames: 0, by: Duration::ZERO });
        for _ in 0..ticks_late + 1 {
            bench.exchange();
        }
    }
    assert!(bench.bus.link_counts().late >= 79);
}

#[test]
fn sdo_transfers_go_beside_the_exchanges() {
    let mut bench = Bench::new();
    bench.enter_op();
    let (name, ticks) = bench.sdo(&reading(1, 0x1008, 0));
    assert_eq!(name.as_deref(), Ok(bench.identities[0].device_name.as_bytes()));
    assert!(ticks < 20, "{ticks} ticks");
    let torque = 500_u16.to_le_bytes();
    let write = SdoRequest { station: 2, index: 0x6072, sub: 0, write: Some(&torque) };
    assert_eq!(bench.sdo(&write).0, Ok(Vec::new()));
    assert_eq!(bench.sdo(&reading(2, 0x6072, 0)).0, Ok(torque.to_vec()));
    assert_eq!(bench.sdo(&reading(1, 0x5555, 0)).0, Err(SdoAbort(0x0602_0000)));
    assert_eq!(bench.sdo(&reading(3, 0x1008, 0)).0, Err(SdoAbort(0x0504_0000)), "no mailbox");
    assert_eq!(bench.sdo(&reading(77, 0x1008, 0)).0, Err(SdoAbort(0x0504_0000)), "no such station");
}

#[test]
fn a_mute_mailbox_times_out_after_100_ms_and_the_next_transfer_works() {
    let mut bench = Bench::new();
    bench.enter_op();
    bench.link.inject(LineFault::Mute { device: 0, is_mute: true });
    let (outcome, ticks) = bench.sdo(&reading(1, 0x1018, 1));
    assert_eq!(outcome, Err(SdoAbort(0x0504_0000)));
    assert!((400..=410).contains(&ticks), "{ticks} ticks of 250 µs");
    bench.link.inject(LineFault::Mute { device: 0, is_mute: false });
    assert!(bench.sdo(&reading(1, 0x1018, 2)).0.is_ok());
    assert_eq!(bench.bus.state(), BusState::Op);
}

#[test]
fn sdo_transfers_survive_lost_frames() {
    let mut bench = Bench::new();
    bench.enter_op();
    let serial = bench.identities[0].serial.to_le_bytes().to_vec();
    for lost_after in 0..12 {
        bench.bus.start(bench.now, &reading(1, 0x1018, 4));
        for _ in 0..lost_after {
            bench.exchange();
        }
        bench.link.inject(LineFault::Drop { frames: 2 });
        let mut read = Vec::new();
        let done = (0..400).find(|_| {
            bench.exchange();
            bench.bus.poll(bench.now, &mut read).expect("the transfer survives")
        });
        assert!(done.is_some() || !read.is_empty(), "lost after {lost_after}");
        assert_eq!(read, serial, "lost after {lost_after}");
    }
}

#[test]
fn emergencies_are_seen_without_a_transfer_and_during_one() {
    let mut bench = Bench::new();
    bench.enter_op();
    let emergency = Emergency { code: 0x7320, register: 0x20, vendor: [1, 2, 3, 4, 5] };
    bench.link.inject(LineFault::Emergency { device: 1, emergency });
    for _ in 0..130 {
        bench.exchange();
    }
    let seen: Vec<_> = bench.bus.emergencies().collect();
    assert_eq!(seen.len(), 1);
    assert_eq!((seen[0].station, seen[0].code, seen[0].register), (2, 0x7320, 0x20));
    assert_eq!(seen[0].vendor, [1, 2, 3, 4, 5]);
    bench.bus.start(bench.now, &reading(1, 0x1018, 4));
    bench.link.inject(LineFault::Emergency { device: 0, emergency: Emergency { code: 0x2310, ..emergency } });
    let mut read = Vec::new();
    let is_done = (0..100).any(|_| {
        bench.exchange();
        bench.bus.poll(bench.now, &mut read).expect("an emergency does not end a transfer")
    });
    assert!(is_done);
    for _ in 0..130 {
        bench.exchange();
    }
    assert_eq!(bench.bus.emergencies().map(|seen| seen.code).collect::<Vec<_>>(), [0x2310]);
}

#[test]
fn a_station_that_leaves_op_is_named_with_its_reason_and_stays_there() {
    let mut bench = Bench::new();
    bench.enter_op();
    bench.link.inject(LineFault::Watchdog { device: 1 });
    for _ in 0..400 {
        bench.exchange();
    }
    assert_eq!(bench.bus.state(), BusState::SafeOp);
    let errors: Vec<_> = bench.bus.al_errors().map(|error| error.to_string()).collect();
    assert_eq!(
        errors,
        [
            "station 2 is in SAFE-OP: AL status code 001Bh, process-data watchdog expired: outputs came too late or not at all"
        ]
    );
    bench.enter_op();
}

#[test]
fn a_refused_state_is_explained() {
    let mut bench = Bench::new();
    bench.link.inject(LineFault::RefusesTransitions { device: 0, code: Some(0x0032) });
    bench.bus.request(BusState::Op);
    for _ in 0..800 {
        bench.exchange();
    }
    assert_eq!(bench.bus.state(), BusState::SafeOp);
    let errors: Vec<_> = bench.bus.al_errors().map(|error| (error.station, error.code)).collect();
    assert_eq!(errors, [(1, 0x0032)]);
}

#[test]
fn silence_makes_the_stations_stop_and_asking_for_op_brings_them_back() {
    let mut bench = Bench::new();
    bench.enter_op();
    bench.link.inject(LineFault::Unplugged { device: 0, is_gone: true });
    for _ in 0..400 {
        assert_eq!(bench.exchange().working_counter, 0);
    }
    bench.link.inject(LineFault::Unplugged { device: 0, is_gone: false });
    for _ in 0..400 {
        bench.exchange();
    }
    assert_eq!(bench.bus.state(), BusState::SafeOp, "the watchdogs have acted");
    assert!(bench.bus.al_errors().all(|error| error.code == 0x001B));
    bench.enter_op();
}

#[test]
fn a_missing_station_is_told_by_working_counter_and_count() {
    let mut bench = Bench::new();
    bench.enter_op();
    bench.link.inject(LineFault::Unplugged { device: 1, is_gone: true });
    let exchange = bench.exchange();
    assert_eq!((exchange.working_counter, exchange.expected), (3, 9));
    assert_eq!([1, 2, 3].map(|station| bench.bus.took_part(station)), [true, false, false]);
}

#[test]
fn a_station_that_stays_out_does_not_hide_the_others() {
    let mut bench = Bench::new();
    bench.enter_op();
    bench.exchange();
    assert_eq!([1, 2, 3].map(|station| bench.bus.took_part(station)), [true; 3]);
    bench.link.inject(LineFault::Unplugged { device: 2, is_gone: true });
    let exchange = bench.exchange();
    assert_eq!((exchange.working_counter, exchange.expected), (6, 9));
    assert_eq!([1, 2, 3].map(|station| bench.bus.took_part(station)), [true, true, false]);
    bench.link.inject(LineFault::WorkingCounter { frames: 1, by: -1 });
    bench.exchange();
    assert_eq!(
        [1, 2, 3].map(|station| bench.bus.took_part(station)),
        [false; 3],
        "whose count it is, nobody knows"
    );
    bench.link.inject(LineFault::Drop { frames: 2 });
    bench.exchange();
    assert_eq!([1, 2, 3].map(|station| bench.bus.took_part(station)), [false; 3]);
}

#[test]
fn nobody_and_other_stations_than_expected_are_errors_that_say_what_to_do() {
    let link = SharedLink::new();
    link.inject(LineFault::Unplugged { device: 0, is_gone: true });
    let error = EtherCatBus::open(Box::new(link), settings()).err().map(|error| error.to_string());
    let error = error.unwrap_or_default();
    assert!(error.starts_with("bus 0 (wire): SubDevices: expected 1 to 16 SubDevices, found"), "{error}");
    assert!(error.contains("check that the cable"), "{error}");
    let expected =
        |station, name: &str| ExpectedStation { station, name: name.to_owned(), ..Default::default() };
    let refusal = |stations| {
        let settings = EtherCatSettings { stations, ..settings() };
        let error =
            EtherCatBus::open(Box::new(SharedLink::new()), settings).err().map(|error| error.to_string());
        error.unwrap_or_default()
    };
    assert_eq!(
        refusal(vec![expected(1, "az"), expected(2, "el")]),
        "bus 0 (wire): stations: expected no other station, found station 3 (SIM analog terminal, vendor 0053494Dh, \
         product 00000A04h, serial 00000001h); take it off the line, or add it to the rig file as a `[[terminal]]`"
    );
    let all = [expected(1, "az"), expected(2, "el"), expected(3, "card")];
    let error = refusal([&all[..], &[expected(4, "inputs")]].concat());
    assert!(
        error.contains("expected station 4 (inputs) on the line, found stations 1, 2, 3 alone"),
        "{error}"
    );
    let swapped = [all[0].clone(), expected(3, "el"), expected(2, "card")];
    let swapped = swapped.map(|station| ExpectedStation {
        product: if station.name == "card" { Some(0x0A04) } else { Some(0x402) },
        ..station
    });
    let error = refusal(swapped.to_vec());
    assert!(
        error.contains("expected product code 00000A04h at station 2 (card), found 00000402h"),
        "{error}"
    );
    assert_eq!(refusal(all.to_vec()), "");
}

#[test]
fn closing_brings_the_stations_down_to_init() {
    let mut bench = Bench::new();
    bench.enter_op();
    let link = bench.link.clone();
    bench.bus.close().expect("the stations follow");
    let mut again = EtherCatBus::open(Box::new(link.clone()), settings()).expect("the line is free again");
    assert_eq!(again.state(), BusState::PreOp);
    again.request(BusState::Op);
    assert_eq!(again.state(), BusState::PreOp, "not mapped");
    let before = link.now();
    link.inject(LineFault::Unplugged { device: 0, is_gone: true });
    drop(again);
    assert!(link.now() - before < Duration::from_secs(2), "bounded without anybody");
}

#[test]
fn a_line_whose_drives_may_hold_axes_is_opened_only_by_somebody_who_may_let_go() {
    let mut bench = Bench::new();
    bench.enter_op();
    let link = bench.link.clone();
    drop(bench);
    let error = EtherCatBus::open(Box::new(link.clone()), settings()).err().map(|error| error.to_string());
    let error = error.expect("the drives were left in SAFE-OP, in which they may hold");
    assert!(
        error.starts_with(
            "bus 0 (wire): state: expected all stations in INIT or PRE-OP, found position 1 in SAFE-OP; its drive"
        ),
        "{error}"
    );
    assert!(error.contains("`bench devices --let-go`"), "{error}");
    let secured = EtherCatSettings { may_let_go: true, ..settings() };
    let bus = EtherCatBus::open(Box::new(link), secured).expect("somebody has secured the axes");
    assert_eq!(bus.state(), BusState::PreOp);
}

#[test]
fn a_line_that_another_program_drives_is_not_opened() {
    let mut bench = Bench::new();
    bench.enter_op();
    let link = bench.link.clone();
    let error = EtherCatBus::open(Box::new(link), settings()).err().map(|error| error.to_string());
    let error = error.expect("the drives are in OP");
    assert!(error.contains("found position 1 in OP; another program drives this line"), "{error}");
}

#[test]
fn a_bus_that_holds_nothing_any_more_is_left_in_init() {
    let mut bench = Bench::new();
    bench.enter_op();
    let link = bench.link.clone();
    bench.bus.let_go();
    drop(bench);
    let again = EtherCatBus::open(Box::new(link), settings()).expect("nothing was held");
    assert_eq!(again.state(), BusState::PreOp);
}

#[test]
fn closing_goes_on_behind_a_station_that_does_not_follow() {
    let mut bench = Bench::new();
    bench.enter_op();
    let link = bench.link.clone();
    link.inject(LineFault::Unplugged { device: 2, is_gone: true });
    let before = link.now();
    let error = bench.bus.close().expect_err("the terminal is gone").to_string();
    assert!(error.contains("address 1002h: the station does not answer"), "{error}");
    assert!(link.now() - before < Duration::from_secs(2));
}

#[test]
fn channels_of_the_analog_terminal_are_read_and_written_in_its_slot() {
    let mut bench = Bench::new();
    bench.enter_op();
    let channel = |byte| TerminalChannel { byte, v_per_step: 10.0 / 32_767.0 };
    let (station, slot) = bench.slots[2].clone();
    assert_eq!(station, 3);
    let inputs = (0..10).map(|k| channel(2 * k)).collect();
    let outputs = (0..4).map(|k| channel(2 * k)).collect();
    let terminal = AnalogTerminal::new("terminal", slot, inputs, outputs).expect("the channels fit the slot");
    let sent_v = terminal.write_v(&mut bench.image, 3, 2.5).expect("there are four outputs");
    for _ in 0..40 {
        bench.exchange();
    }
    let looped_v = terminal.read_v(&bench.image, 4).expect("there are ten inputs");
    assert!((looped_v - sent_v).abs() < 0.05, "output 3 is looped to input 4: {looped_v} V");
}

#[test]
fn sync0_goes_to_the_stations_that_are_named() {
    let clocks = |sync0_stations| {
        let usual = settings().distributed_clocks.expect("they are on as a rule");
        EtherCatSettings {
            distributed_clocks: Some(DistributedClocks { sync0_stations, ..usual }),
            ..settings()
        }
    };
    let mut bench = Bench::with(clocks(vec![1, 2]));
    bench.enter_op();
    let mut other =
        EtherCatBus::open(Box::new(SharedLink::new()), clocks(vec![7])).expect("stations are there");
    let error = other.map().expect_err("no station 7").to_string();
    assert_eq!(
        error,
        "bus 0 (wire): distributed clocks: expected a station 7 that can make SYNC0, found none; correct the stations with SYNC0 in the rig file"
    );
}

#[test]
fn the_watchdog_of_the_drive_is_the_one_that_was_set() {
    let mut bench = Bench::new();
    bench.enter_op();
    assert_eq!(drive_settings(1).watchdog_s, 0.02);
    bench.link.inject(LineFault::Drop { frames: 10_000 });
    for _ in 0..84 {
        bench.exchange();
    }
    bench.link.inject(LineFault::Drop { frames: 0 });
    bench.exchange();
    assert_eq!(bench.bus.state(), BusState::SafeOp, "21 ms without outputs");
}
