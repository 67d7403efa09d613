mod drive_side;
mod faults;
mod injected;
mod limits;
mod motion;
mod stops;
mod trackers;

use super::*;
use crate::bus::at_once::AtOnce;
use crate::director::DirectorBus;
use crate::rig::SimulatedRig;
use crate::unit::UnitSettings;
use crate::world::StartState;
use drivers::wire::Fieldbus;

const TICK: Duration = Duration::from_micros(250);

/// A host of one bus that writes bytes itself: no driver in between.
struct Host {
    rig: SimulatedRig,
    bus: Box<dyn Fieldbus>,
    image: ProcessImage,
    slots: Vec<(u16, Slot)>,
    now: Duration,
}

const STATUSWORD: usize = 0;
const ERROR_CODE: usize = 2;
const POSITION: usize = 6;
const VELOCITY: usize = 10;
const TORQUE: usize = 14;

/// 6041, 603F, 6061, pad, 6064, 606C, 6077, 6078, 6079, 22A3.
const INPUTS: [u32; 10] = [
    0x6041_0010,
    0x603F_0010,
    0x6061_0008,
    0x0000_0008,
    0x6064_0020,
    0x606C_0020,
    0x6077_0010,
    0x6078_0010,
    0x6079_0020,
    0x22A3_0010,
];

fn address(seed: u64) -> SeedAddress {
    SeedAddress { seed, procedure: "TEST".into(), point: "1".into() }
}

/// The nominal unit without transport delay and with an ideal current loop.
fn undelayed() -> UnitSettings {
    let mut unit = UnitSettings::default();
    for axis in [&mut unit.az, &mut unit.el] {
        (axis.command_delay_s, axis.sensor_delay_s, axis.current_bandwidth_hz) = (0.0, 0.0, 0.0);
    }
    unit
}

fn start() -> StartState {
    StartState { az_rad: 0.0, el_rad: 60.0_f64.to_radians(), heat_sink_degc: 40.0 }
}

impl Host {
    fn new(unit: &UnitSettings, start: StartState) -> Self {
        let rig = SimulatedRig::new(unit, &address(1), start);
        let mut bus = rig.bus();
        for station in [1, 2] {
            bus.download(station, 0x1C13, 0, &[0]).expect("assignment is writable in PRE-OP");
            bus.download(station, 0x1A00, 0, &[0]).expect("mapping is writable in PRE-OP");
            for (sub, word) in (1..).zip(INPUTS) {
                bus.download(station, 0x1A00, sub, &word.to_le_bytes()).expect("objects are mappable");
            }
            bus.download(station, 0x1A00, 0, &[10]).expect("ten entries");
            bus.download(station, 0x1C13, 0, &[1]).expect("one PDO");
        }
        let (image, slots) = bus.map().expect("the mapping is valid");
        bus.request(BusState::SafeOp);
        Self { rig, bus, image, slots, now: Duration::ZERO }
    }

    fn set(&mut self, axis: usize, controlword: u16, torque_permille: i16, velocity: i32, mode: i8) {
        let outputs = &mut self.image.outputs[self.slots[axis].1.outputs.clone()];
        outputs[0..2].copy_from_slice(&controlword.to_le_bytes());
        outputs[2..4].copy_from_slice(&torque_permille.to_le_bytes());
        outputs[4..8].copy_from_slice(&velocity.to_le_bytes());
        outputs[8] = mode as u8;
    }

    fn tick(&mut self) {
        self.bus.exchange(self.now, &mut self.image).expect("the bus is mapped");
        self.now += TICK;
    }

    fn run(&mut self, ticks: u32) {
        (0..ticks).for_each(|_| self.tick());
    }

    fn input<const N: usize>(&self, axis: usize, offset: usize) -> [u8; N] {
        let first = self.slots[axis].1.inputs.start + offset;
        self.image.inputs[first..first + N].try_into().expect("N bytes were taken")
    }

    fn word(&self, axis: usize, offset: usize) -> u16 {
        u16::from_le_bytes(self.input(axis, offset))
    }

    fn torque_permille(&self, axis: usize) -> i16 {
        i16::from_le_bytes(self.input(axis, TORQUE))
    }

    fn velocity_deg_per_s(&self, axis: usize) -> f64 {
        f64::from(i32::from_le_bytes(self.input(axis, VELOCITY))) * 360.0 / f64::from(1 << 26)
    }

    fn angle_deg(&self, axis: usize) -> f64 {
        let counts = i32::from_le_bytes(self.input(axis, POSITION));
        let signed = if counts >= 1 << 25 { counts - (1 << 26) } else { counts };
        f64::from(signed) * 360.0 / f64::from(1 << 26)
    }

    fn pattern(&self, axis: usize) -> u16 {
        self.word(axis, STATUSWORD) & 0x6F
    }

    /// OP, and one axis through all states to operation enabled.
    fn enable(&mut self, axis: usize, mode: i8) {
        self.bus.request(BusState::Op);
        for (controlword, expected) in [(0x06, 0x21), (0x07, 0x23), (0x0F, 0x27)] {
            self.set(axis, controlword, 0, 0, mode);
            self.run(90);
            assert_eq!(self.pattern(axis), expected);
        }
    }

    fn write(&mut self, axis: u16, index: u16, sub: u8, data: &[u8]) {
        self.bus.download(axis + 1, index, sub, data).expect("a writable object");
    }
}

fn counts_per_s(deg_per_s: f64) -> i32 {
    (deg_per_s / 360.0 * f64::from(1 << 26)) as i32
}

#[test]
fn inputs_are_valid_in_safe_op_and_outputs_act_in_op_only() {
    let mut host = Host::new(&UnitSettings::default(), start());
    assert_eq!(host.bus.state(), BusState::SafeOp);
    host.set(0, 0x06, 0, 0, 10);
    host.run(200);
    assert_eq!(host.pattern(0), 0x40);
    assert!((host.angle_deg(1) - 60.0).abs() < 1e-2);
    host.bus.request(BusState::Op);
    assert_eq!(host.bus.state(), BusState::SafeOp, "the first outputs have not been seen yet");
    let exchange = host.bus.exchange(host.now, &mut host.image).expect("mapped");
    assert_eq!((exchange.working_counter, exchange.expected), (6, 6));
    assert_eq!(host.bus.state(), BusState::Op);
    host.now += TICK;
    host.run(90);
    assert_eq!(host.pattern(0), 0x21);
}

#[test]
fn transitions_take_their_time_and_bit_12_says_that_commands_are_followed() {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.bus.request(BusState::Op);
    host.set(0, 0x06, 500, 0, 10);
    host.run(83); // 0.85 ms of delay and 20 ms, less one tick after the command was taken
    assert_eq!(host.pattern(0), 0x40);
    host.run(2);
    assert_eq!(host.pattern(0), 0x21);
    host.set(0, 0x07, 500, 0, 10);
    host.run(100);
    assert_eq!((host.pattern(0), host.word(0, STATUSWORD) & 1 << 12), (0x23, 0));
    host.set(0, 0x0F, 500, 0, 10);
    host.run(100);
    assert_eq!((host.pattern(0), host.word(0, STATUSWORD) & 1 << 12), (0x27, 1 << 12));
    assert!((host.torque_permille(0) - 500).abs() < 30, "{}", host.torque_permille(0));
}

/// First tick, counted from the exchange that carries a torque command, whose sample shows more than half of it.
fn ticks_until_seen(unit: &UnitSettings) -> usize {
    let mut host = Host::new(unit, start());
    host.enable(0, 10);
    host.set(0, 0x0F, 1000, 0, 10);
    let seen = |_: &usize| {
        host.tick();
        host.torque_permille(0) > 500
    };
    (0..100).find(seen).expect("the command arrives")
}

#[test]
fn a_command_acts_from_its_exchange_on_where_there_is_no_delay() {
    assert_eq!(ticks_until_seen(&undelayed()), 1);
}

/// 0.85 ms out: the current has risen by 61 % at the end of the fourth tick, and that is seen 1.25 ms later.
#[test]
fn a_command_acts_after_the_command_delay_and_is_seen_after_the_sensor_delay() {
    assert_eq!(ticks_until_seen(&UnitSettings::default()), 4 + 5);
    let mut jittery = UnitSettings::default();
    jittery.az.delay_jitter_s = 2e-3;
    let seen = ticks_until_seen(&jittery);
    assert!((9..=17).contains(&seen), "{seen}");
}

/// Nothing that was under way when the bus left OP may act afterwards.
#[test]
fn commands_under_way_die_with_the_connection() {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.bus.request(BusState::Op);
    host.set(0, 0x06, 0, 0, 10);
    host.run(2);
    host.bus.request(BusState::SafeOp);
    host.run(200);
    assert_eq!(host.pattern(0), 0x40);
}

#[test]
fn misuse_is_an_error_and_no_panic() {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.now = Duration::from_secs(1);
    host.tick();
    assert!(host.bus.exchange(Duration::from_millis(5), &mut host.image).is_err(), "time going back");
    host.image.outputs.pop();
    assert!(host.bus.exchange(host.now, &mut host.image).is_err(), "short image");
    assert_eq!(host.bus.upload(3, 0x1000, 0), Err(NO_ANSWER));
    assert_eq!(host.bus.upload(0, 0x1000, 0), Err(NO_ANSWER));
    let mut fresh = SimulatedRig::new(&UnitSettings::default(), &address(1), start()).bus();
    assert!(fresh.exchange(Duration::ZERO, &mut ProcessImage::default()).is_err(), "not mapped");
    fresh.request(BusState::Op);
    assert_eq!(fresh.state(), BusState::PreOp);
}
