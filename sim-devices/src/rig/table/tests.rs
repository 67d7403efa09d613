use super::*;
use crate::bus::at_once::AtOnce;
use crate::rig::tests::{profile, torque_command};
use drivers::cia402::{Actuals, Cia402, DriveSettings, PowerState, PowerTarget, Waiting};
use drivers::wire::{BusState, ProcessImage, SdoAbort};

const TICK: Duration = Duration::from_millis(1);

fn drive_settings(name: &str, station: u16) -> DriveSettings {
    DriveSettings {
        name: name.to_owned(),
        station,
        profile: profile::simulated(),
        torque_constant_nm_per_a: 6.0,
        rated_current_a: 2.0,
        rated_torque_nm: 12.0,
        max_torque_nm: 120.0,
        encoder_counts_per_rev: 1 << 26,
        encoder_offset_rad: 0.0,
        encoder_sign: 1.0,
        soft_limits_rad: [-2.7, 2.7],
        max_velocity_rad_per_s: 2.0,
        quick_stop_deceleration_rad_per_s2: 5.0,
        quick_stop_option: 6,
        fault_reaction_option: 2,
        abort_connection_option: 1,
        watchdog_s: 0.02,
        cycle_s: 1e-3,
        transition_timeout_s: 2.0,
    }
}

fn address(seed: u64) -> SeedAddress {
    SeedAddress { seed, procedure: "TEST".into(), point: "1".into() }
}

const NAMES: [&str; 4] = ["yaw", "pitch", "roll", "lift"];

/// A table with as many axes, the first at 0.1 rad, the second at 0.2 rad and so on.
fn table(axes: usize) -> SimulatedTable {
    table_of(&TableSettings::with_axes(&NAMES[..axes]), 1)
}

fn table_of(settings: &TableSettings, seed: u64) -> SimulatedTable {
    let poses = settings.axes.iter().zip(1..).map(|(axis, k)| (axis.name.clone(), 0.1 * f64::from(k)));
    SimulatedTable::new(settings, &address(seed), &poses.collect())
}

/// All drives of a table behind the production driver.
struct Bench {
    bus: Box<dyn Fieldbus>,
    drives: Vec<Cia402>,
    image: ProcessImage,
    actuals: Vec<Actuals>,
    torque_nm: Vec<f64>,
    working_counters: Vec<u16>,
    now: Duration,
}

impl Bench {
    fn new(rig: &SimulatedTable) -> Self {
        let mut bus = rig.bus();
        let mut drives = Vec::new();
        for station in bus.stations() {
            let name = NAMES[usize::from(station) - 1];
            let (drive, _) = Cia402::open(
                &mut *bus,
                drive_settings(name, station),
                &mut Waiting { now: Duration::ZERO, pause: &mut || Duration::ZERO },
            )
            .expect("the twin answers");
            drives.push(drive);
        }
        let (image, slots) = bus.map().expect("the driver's mapping is valid");
        for (drive, (_, slot)) in drives.iter_mut().zip(&slots) {
            drive.attach(slot.clone());
        }
        bus.request(BusState::SafeOp);
        let count = drives.len();
        let actuals = vec![Actuals::default(); count];
        let mut bench = Self {
            bus,
            drives,
            image,
            actuals,
            torque_nm: vec![0.0; count],
            working_counters: Vec::new(),
            now: Duration::ZERO,
        };
        bench.tick(PowerTarget::Disabled);
        bench.bus.request(BusState::Op);
        bench
    }

    fn tick(&mut self, target: PowerTarget) {
        let exchange = self.bus.exchange(self.now, &mut self.image).expect("mapped");
        self.working_counters.push(exchange.working_counter);
        for (k, drive) in self.drives.iter_mut().enumerate() {
            let actuals = drive.decode(&self.image.inputs);
            let answer = drive.controlword(target, actuals.statusword, actuals.error_code, self.now);
            let controlword = answer.unwrap_or_else(|error| {
                assert!(actuals.error_code != 0, "the twin follows in time: {error}");
                0
            });
            drive.encode(&torque_command(controlword, self.torque_nm[k]), &mut self.image.outputs);
            self.actuals[k] = actuals;
        }
        self.now += TICK;
    }

    fn run(&mut self, target: PowerTarget, ticks: u32) {
        (0..ticks).for_each(|_| self.tick(target));
    }

    fn states(&self) -> Vec<PowerState> {
        self.actuals.iter().map(|actuals| PowerState::of(actuals.statusword)).collect()
    }

    /// All drives in operation.
    fn enabled(rig: &SimulatedTable) -> Self {
        let mut bench = Self::new(rig);
        bench.run(PowerTarget::Enabled, 200);
        assert_eq!(bench.states(), vec![PowerState::OperationEnabled; bench.drives.len()]);
        bench
    }
}

fn serial(bus: &mut dyn Fieldbus, station: u16) -> Result<u32, SdoAbort> {
    let bytes = bus.upload(station, 0x1018, 4)?;
    Ok(u32::from_le_bytes(bytes.try_into().expect("32 bits")))
}

#[test]
fn each_station_answers_for_itself_and_nobody_beyond_the_last() {
    let mut bus = table(3).bus();
    assert_eq!(bus.stations(), [1, 2, 3]);
    for station in 1..=3 {
        assert_eq!(serial(&mut *bus, station), Ok(2000 + u32::from(station)));
    }
    assert_eq!(serial(&mut *bus, 4), Err(SdoAbort(0x0504_0000)));
    assert_eq!(serial(&mut *bus, 0), Err(SdoAbort(0x0504_0000)));
    bus.download(2, 0x2F00, 0, &40_u16.to_le_bytes()).expect("the watchdog is writable");
    let watchdogs: Vec<Vec<u8>> =
        (1..=3).map(|station| bus.upload(station, 0x2F00, 0).expect("readable")).collect();
    assert_eq!(watchdogs[1], 40_u16.to_le_bytes());
    assert!(watchdogs[0] == watchdogs[2] && watchdogs[0] != watchdogs[1], "{watchdogs:?}");
}

#[test]
fn the_slots_of_all_stations_fill_the_process_image_in_their_order() {
    let rig = table(3);
    let bench = Bench::new(&rig);
    let mut bus = rig.bus();
    let (image, slots) = bus.map().expect("the mapping is valid");
    let mut outputs_end = 0;
    let mut inputs_end = 0;
    for (place, (station, slot)) in slots.iter().enumerate() {
        assert_eq!(usize::from(*station), place + 1);
        assert_eq!((slot.outputs.start, slot.inputs.start), (outputs_end, inputs_end));
        (outputs_end, inputs_end) = (slot.outputs.end, slot.inputs.end);
    }
    assert_eq!((image.outputs.len(), image.inputs.len()), (outputs_end, inputs_end));
    assert_eq!(bench.image.inputs.len(), inputs_end);
}

#[test]
fn every_encoder_reads_the_pose_in_which_its_axis_starts() {
    let rig = table(3);
    let bench = Bench::new(&rig);
    for (place, actuals) in bench.actuals.iter().enumerate() {
        let expected_rad = 0.1 * (place as f64 + 1.0);
        // The scale of the encoder is off by up to 3.6 µrad.
        assert!((actuals.position_rad - expected_rad).abs() < 3.7e-6, "{actuals:?}");
        assert!((actuals.heat_sink_degc - 25.0).abs() < 0.11, "ambient: {actuals:?}");
        assert!((actuals.bus_v - 560.0).abs() < 1e-9);
    }
    let unnamed = SimulatedTable::new(&TableSettings::with_axes(&["yaw"]), &address(1), &BTreeMap::new());
    assert_eq!(unnamed.truth_of_axes()[0].angle_rad, 0.0);
}

#[test]
fn the_production_driver_turns_four_axes_at_once_each_by_its_own_torque() {
    let rig = table(4);
    let mut bench = Bench::enabled(&rig);
    bench.torque_nm = vec![18.0, -18.0, 0.0, 30.0];
    bench.run(PowerTarget::Enabled, 500);
    let rates: Vec<f64> = rig.truth_of_axes().iter().map(|axis| axis.rate_rad_per_s).collect();
    // (T - friction)/J over half a second; friction is 5.3 N·m, and cogging averages out.
    for (rate, expected) in rates.iter().zip([0.52, -0.52, 0.0, 1.02]) {
        assert!((rate - expected).abs() < 0.04, "{rates:?}");
    }
    for (actuals, torque_nm) in bench.actuals.iter().zip([18.0, -18.0, 0.0, 30.0]) {
        assert!((actuals.torque_nm - torque_nm).abs() < 0.2, "{actuals:?}");
    }
    assert!(bench.working_counters[2..].iter().all(|count| *count == 12), "three per station");
    bench.run(PowerTarget::QuickStop, 1500);
    let axes = rig.truth_of_axes();
    assert!(axes.iter().all(|axis| axis.rate_rad_per_s.abs() < 1e-3), "{axes:?}");
    assert_eq!(rig.record(), WorldRecord::default());
}

/// Every byte of a second in which two axes are torqued back and forth.
fn bytes(seed: u64) -> Vec<u8> {
    let settings = TableSettings { dropped_cycles_ratio: 0.05, ..TableSettings::with_axes(&NAMES[..2]) };
    let mut bench = Bench::enabled(&table_of(&settings, seed));
    let mut all = Vec::new();
    for tick in 0..1000 {
        let torque_nm = 20.0 * (0.01 * f64::from(tick)).sin();
        bench.torque_nm = vec![torque_nm, -torque_nm];
        bench.tick(PowerTarget::Enabled);
        all.extend_from_slice(&bench.image.inputs);
    }
    all.extend(bench.working_counters.iter().flat_map(|count| count.to_le_bytes()));
    all
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_one_does_not() {
    assert!(bytes(1) == bytes(1));
    assert!(bytes(1) != bytes(2));
}

#[test]
fn an_axis_that_is_driven_into_its_stop_is_recorded_by_its_name() {
    let rig = table(2);
    let mut bench = Bench::enabled(&rig);
    bench.torque_nm = vec![0.0, 25.0];
    bench.run(PowerTarget::Enabled, 3000);
    let crashes = rig.record().crashes;
    assert!(!crashes.is_empty() && crashes.iter().all(|crash| crash.0 == "pitch"), "{crashes:?}");
}

#[test]
fn an_encoder_fault_stops_its_own_drive_only() {
    let rig = table(3);
    let mut bench = Bench::enabled(&rig);
    rig.inject_encoder_fault(1, Some(EncoderFault::Error)).expect("there is such a drive");
    bench.run(PowerTarget::Enabled, 50);
    let states = bench.states();
    assert_ne!(states[1], PowerState::OperationEnabled);
    assert_eq!((states[0], states[2]), (PowerState::OperationEnabled, PowerState::OperationEnabled));
    assert_eq!(bench.actuals[1].error_code, 0x7305);
}

#[test]
fn the_emergency_stop_takes_the_torque_from_every_drive() {
    let rig = table(4);
    let mut bench = Bench::enabled(&rig);
    rig.schedule(bench.now, Fault::EmergencyStop { pressed: true }).expect("every rig has one");
    bench.tick(PowerTarget::Enabled);
    bench.tick(PowerTarget::Enabled);
    assert!(
        bench.states().iter().all(|state| *state == PowerState::SwitchOnDisabled),
        "{:?}",
        bench.states()
    );
}

#[test]
fn an_encoder_that_slips_reads_wrong_while_the_axis_stands() {
    let rig = table(1);
    let mut bench = Bench::new(&rig);
    bench.run(PowerTarget::Disabled, 200);
    let before = bench.actuals[0].position_rad;
    rig.schedule(bench.now, Fault::EncoderJump { drive: 0, by_rad: 0.01 }).expect("there is such a drive");
    bench.run(PowerTarget::Disabled, 5);
    assert!((bench.actuals[0].position_rad - before - 0.01).abs() < 1e-6);
    // Cogging bends the bristles a little.
    assert!((rig.truth_of_axes()[0].angle_rad - 0.1).abs() < 2e-4);
}

#[test]
fn without_mains_the_moving_axes_live_on_the_capacitor_they_share() {
    let rig = table(2);
    let mut bench = Bench::enabled(&rig);
    bench.torque_nm = vec![60.0, 60.0];
    rig.schedule(bench.now, Fault::SupplyLost).expect("every rig has a supply");
    bench.run(PowerTarget::Enabled, 600);
    assert!(bench.actuals.iter().all(|actuals| actuals.bus_v < 540.0), "{:?}", bench.actuals);
    assert_eq!(bench.actuals[0].bus_v, bench.actuals[1].bus_v);
}

#[test]
fn a_silent_bus_ends_in_the_fault_of_every_drive() {
    let rig = table(3);
    let mut bench = Bench::enabled(&rig);
    let lasting = Some(Duration::from_millis(100));
    rig.schedule(bench.now, Fault::BusSilent { lasting }).expect("every rig has a bus");
    (0..100).for_each(|_| {
        bench.bus.exchange(bench.now, &mut bench.image).expect("mapped");
        bench.now += TICK;
    });
    bench.bus.exchange(bench.now, &mut bench.image).expect("mapped");
    bench.bus.request(BusState::SafeOp);
    bench.tick(PowerTarget::Disabled);
    assert!(bench.actuals.iter().all(|actuals| actuals.error_code == 0x7500), "{:?}", bench.actuals);
}

#[test]
fn a_fault_of_what_the_table_does_not_have_is_refused_in_words() {
    let rig = table(2);
    let refused = [
        rig.schedule(Duration::ZERO, Fault::Drive { drive: 2, code: 0x4310 }),
        rig.schedule(Duration::ZERO, Fault::ImuSilent),
        rig.inject_encoder_fault(7, None),
    ];
    let texts = refused.map(|result| result.expect_err("no such device").to_string());
    assert!(texts[0].contains("fault of drive 2: expected 0 to 1"), "{}", texts[0]);
    assert!(texts[1].contains("a table has no inertial unit"), "{}", texts[1]);
    assert!(texts[2].contains("fault of drive 7"), "{}", texts[2]);
}
