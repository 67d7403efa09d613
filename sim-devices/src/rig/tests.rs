use super::*;
use drivers::cia402::{
    Actuals, Cia402, CyclicMode, DriveCommand, DriveSettings, PowerState, PowerTarget, Waiting,
};
use drivers::device::DeviceError;
use drivers::wire::{BusState, ProcessImage};
use std::time::Duration;

#[path = "../../tests/ethercat_bus/profile.rs"]
pub(super) mod profile;

const TICK: Duration = Duration::from_micros(250);

fn settings(station: u16) -> DriveSettings {
    let az = station == 1;
    DriveSettings {
        name: if az { "az" } else { "el" }.into(),
        station,
        profile: profile::simulated(),
        torque_constant_nm_per_a: if az { 60.0 } else { 52.0 },
        rated_current_a: 2.0,
        rated_torque_nm: if az { 120.0 } else { 104.0 },
        max_torque_nm: if az { 2556.0 } else { 1882.0 },
        encoder_counts_per_rev: 1 << 26,
        encoder_offset_rad: 0.0,
        encoder_sign: 1.0,
        soft_limits_rad: if az { [-2.75, 2.75] } else { [-0.15, 1.55] },
        max_velocity_rad_per_s: 1.2,
        quick_stop_deceleration_rad_per_s2: 1.5,
        quick_stop_option: 6,
        fault_reaction_option: 2,
        abort_connection_option: 1,
        watchdog_s: 0.02,
        cycle_s: 250e-6,
        transition_timeout_s: 2.0,
    }
}

/// Both drives behind the production driver.
struct Bench {
    bus: Box<dyn Fieldbus>,
    drives: Vec<Cia402>,
    image: ProcessImage,
    actuals: [Actuals; 2],
    torque_nm: [f64; 2],
    now: Duration,
}

/// A simulated mailbox answers at once.
fn at_once() -> Duration {
    unreachable!("nobody waits for it")
}

impl Bench {
    fn new(rig: &SimulatedRig) -> Self {
        let mut bus = rig.bus();
        let open = |station| {
            Cia402::open(
                &mut *bus,
                settings(station),
                &mut Waiting { now: Duration::ZERO, pause: &mut at_once },
            )
            .expect("the twin answers")
            .0
        };
        let mut drives: Vec<Cia402> = [1, 2].map(open).into();
        let (image, slots) = bus.map().expect("the driver's mapping is valid");
        for (drive, (_, slot)) in drives.iter_mut().zip(&slots) {
            drive.attach(slot.clone());
        }
        bus.request(BusState::SafeOp);
        let (actuals, torque_nm) = Default::default();
        Self { bus, drives, image, actuals, torque_nm, now: Duration::ZERO }
    }

    fn tick(&mut self, target: PowerTarget) {
        self.bus.exchange(self.now, &mut self.image).expect("mapped");
        for (k, drive) in self.drives.iter_mut().enumerate() {
            let actuals = drive.decode(&self.image.inputs);
            let controlword = drive
                .controlword(target, actuals.statusword, actuals.error_code, self.now)
                .expect("the twin follows in time");
            drive.encode(&torque_command(controlword, self.torque_nm[k]), &mut self.image.outputs);
            self.actuals[k] = actuals;
        }
        self.now += TICK;
    }

    fn states(&self) -> [PowerState; 2] {
        self.actuals.map(|actuals| PowerState::of(actuals.statusword))
    }

    fn reach(&mut self, target: PowerTarget, state: PowerState, within_s: f64) {
        let end = self.now + Duration::from_secs_f64(within_s);
        while self.states() != [state; 2] {
            assert!(self.now < end, "{:?} instead of {state:?}", self.states());
            self.tick(target);
        }
    }
}

fn rig() -> SimulatedRig {
    let address = SeedAddress { seed: 3, procedure: "TEST".into(), point: "1".into() };
    let start = StartState { az_rad: -1.0, el_rad: 1.2, heat_sink_degc: 45.0 };
    SimulatedRig::new(&UnitSettings::default(), &address, start)
}

#[test]
fn the_production_driver_opens_enables_moves_and_stops_both_twins() {
    let rig = rig();
    let mut bench = Bench::new(&rig);
    assert_eq!(bench.bus.state(), BusState::SafeOp);
    bench.tick(PowerTarget::Disabled);
    bench.bus.request(BusState::Op);
    bench.tick(PowerTarget::Disabled);
    assert_eq!(bench.bus.state(), BusState::Op);
    // The scale of the nominal encoder is off by up to 3.6 µrad.
    assert!((bench.actuals[0].position_rad + 1.0).abs() < 3.6e-6, "{:?}", bench.actuals[0]);
    assert!((bench.actuals[1].position_rad - 1.2).abs() < 1e-4);
    assert!((bench.actuals[0].bus_v - 560.0).abs() < 1e-9);
    assert!((bench.actuals[0].heat_sink_degc - 45.0).abs() < 0.1);

    bench.reach(PowerTarget::Enabled, PowerState::OperationEnabled, 0.2);
    bench.torque_nm = [600.0, -300.0];
    (0..2000).for_each(|_| bench.tick(PowerTarget::Enabled));
    assert!((bench.actuals[0].torque_nm - 600.0).abs() < 4.0, "{:?}", bench.actuals[0]);
    assert!((bench.actuals[1].torque_nm + 300.0).abs() < 2.0, "{:?}", bench.actuals[1]);
    assert!(bench.actuals[0].velocity_rad_per_s > 0.1 && bench.actuals[1].velocity_rad_per_s < -0.1);

    bench.reach(PowerTarget::QuickStop, PowerState::QuickStopActive, 0.1);
    (0..4000).for_each(|_| bench.tick(PowerTarget::QuickStop));
    assert!(bench.actuals.iter().all(|actuals| actuals.velocity_rad_per_s.abs() < 1e-3));
    bench.reach(PowerTarget::Disabled, PowerState::SwitchOnDisabled, 0.2);
    assert_eq!(rig.record(), WorldRecord::default());
}

#[test]
fn the_production_driver_resets_a_fault_that_a_silent_bus_left_behind() {
    let mut bench = Bench::new(&rig());
    bench.bus.request(BusState::Op);
    bench.reach(PowerTarget::Enabled, PowerState::OperationEnabled, 0.2);
    bench.now += Duration::from_millis(500);
    bench.bus.exchange(bench.now, &mut bench.image).expect("mapped");
    assert_eq!(bench.bus.state(), BusState::SafeOp);
    bench.tick(PowerTarget::Disabled);
    assert_eq!(bench.states(), [PowerState::Fault; 2]);
    assert_eq!(bench.actuals[0].error_code, 0x7500);
    bench.bus.request(BusState::Op);
    bench.reach(PowerTarget::FaultReset, PowerState::SwitchOnDisabled, 1.0);
    bench.reach(PowerTarget::Enabled, PowerState::OperationEnabled, 0.2);
}

/// Ticks from a command of torque until the drives report half of it.
fn ticks_to_torque(rig: &SimulatedRig) -> [u32; 2] {
    let mut bench = Bench::new(rig);
    bench.bus.request(BusState::Op);
    bench.reach(PowerTarget::Enabled, PowerState::OperationEnabled, 0.2);
    bench.torque_nm = [600.0, 300.0];
    let mut ticks = [0; 2];
    for tick in 0..40 {
        bench.tick(PowerTarget::Enabled);
        for (axis, wanted_nm) in [300.0, 150.0].into_iter().enumerate() {
            if ticks[axis] == 0 && bench.actuals[axis].torque_nm > wanted_nm {
                ticks[axis] = tick;
            }
        }
    }
    assert!(ticks.iter().all(|&tick| tick > 0), "the drives follow: {ticks:?}");
    ticks
}

#[test]
fn drives_that_follow_sync0_act_one_cycle_later_wherever_the_frames_pass() {
    let with_the_frame = ticks_to_torque(&rig());
    for shift_us in [50, 125, 200] {
        let synchronised = rig();
        synchronised.follow_sync0(TICK, Duration::from_micros(shift_us));
        let found = ticks_to_torque(&synchronised);
        assert_eq!(found, with_the_frame.map(|ticks| ticks + 1), "frames {shift_us} us after the pulse");
    }
}

#[test]
fn drives_that_follow_sync0_leave_op_on_a_silent_bus() {
    let synchronised = rig();
    synchronised.follow_sync0(TICK, TICK / 2);
    let mut bench = Bench::new(&synchronised);
    bench.bus.request(BusState::Op);
    bench.reach(PowerTarget::Enabled, PowerState::OperationEnabled, 0.2);
    bench.now += Duration::from_millis(500);
    bench.bus.exchange(bench.now, &mut bench.image).expect("mapped");
    assert_eq!(bench.bus.state(), BusState::SafeOp);
    assert_eq!(synchronised.record(), WorldRecord::default());
}

#[test]
fn what_the_unit_is_and_what_the_driver_expects_are_compared() {
    let mut unit = UnitSettings::default();
    unit.el.rated_torque_nm = 100.0;
    let address = SeedAddress { seed: 3, procedure: "TEST".into(), point: "1".into() };
    let start = StartState { az_rad: 0.0, el_rad: 0.0, heat_sink_degc: 40.0 };
    let mut bus = SimulatedRig::new(&unit, &address, start).bus();
    assert!(
        Cia402::open(&mut *bus, settings(1), &mut Waiting { now: Duration::ZERO, pause: &mut at_once })
            .is_ok()
    );
    let error =
        Cia402::open(&mut *bus, settings(2), &mut Waiting { now: Duration::ZERO, pause: &mut at_once })
            .expect_err("6076h differs");
    assert!(matches!(error, DeviceError::Mismatch { index: 0x6076, .. }), "{error}");
}

/// A command of torque.
pub(super) fn torque_command(controlword: u16, torque_nm: f64) -> DriveCommand {
    DriveCommand { controlword, mode: CyclicMode::Torque, torque_nm, velocity_rad_per_s: 0.0 }
}
