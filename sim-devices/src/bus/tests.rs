use super::*;
use crate::physics::lugre::LuGre;
use crate::rig::SimulatedRig;
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
    host.run(80); // 20 ms less one tick after the command was taken
    assert_eq!(host.pattern(0), 0x40);
    host.run(2);
    assert_eq!(host.pattern(0), 0x21);
    host.set(0, 0x07, 500, 0, 10);
    host.run(90);
    assert_eq!((host.pattern(0), host.word(0, STATUSWORD) & 1 << 12), (0x23, 0));
    host.set(0, 0x0F, 500, 0, 10);
    host.run(90);
    assert_eq!((host.pattern(0), host.word(0, STATUSWORD) & 1 << 12), (0x27, 1 << 12));
    assert!((host.torque_permille(0) - 500).abs() < 30, "{}", host.torque_permille(0));
}

#[test]
fn a_command_acts_from_its_exchange_on() {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.enable(0, 10);
    host.set(0, 0x0F, 1000, 0, 10);
    host.tick();
    assert!(host.torque_permille(0).abs() < 50, "sampled before the command was taken");
    host.tick();
    assert!((host.torque_permille(0) - 1000).abs() < 50);
}

/// Torque per disturbance of the loop below at a frequency, friction slope neglected (0.2 %):
/// (Kp·s + Ki)/(J·s² + Kp·s + Ki).
fn torque_per_disturbance(hz: f64) -> f64 {
    let w = std::f64::consts::TAU * hz;
    (23_600.0 * w).hypot(447_500.0) / (23_600.0 * w).hypot(447_500.0 - 1200.0 * w * w)
}

/// 2 °/s by a PI in the host (the director's gains, torque over the wire): the velocity settles and the torque shows
/// the cogging at 144 periods per revolution, fundamental and second harmonic, as large as the loop makes them.
#[test]
fn a_plain_pi_tracks_2_deg_per_s_and_its_torque_shows_the_cogging() {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.enable(0, 10);
    let (mut integral, mut permille) = (0.0_f64, 0_i16);
    let mut samples = Vec::new();
    while host.now < Duration::from_secs(8) {
        host.set(0, 0x0F, permille, 0, 10);
        host.tick();
        let error = (2.0 - host.velocity_deg_per_s(0)).to_radians();
        integral += 447_500.0 * 250e-6 * error;
        permille = ((23_600.0 * error + integral) / 0.12).round() as i16;
        if host.now >= Duration::from_secs(3) {
            let torque = f64::from(host.torque_permille(0)) * 0.12;
            samples.push((host.angle_deg(0), torque, host.velocity_deg_per_s(0)));
        }
    }
    assert!(samples.iter().all(|(_, _, velocity)| (velocity - 2.0).abs() < 0.1));
    let span = samples[samples.len() - 1].0 - samples[0].0;
    assert!((span - 10.0).abs() < 0.01, "four cogging periods in 5 s: {span}");
    let count = samples.len() as f64;
    let mean = samples.iter().map(|(_, torque, _)| torque).sum::<f64>() / count;
    let friction = LuGre::new(&UnitSettings::default().az, 50e-6).steady_torque_nm(2.0_f64.to_radians());
    assert!((mean - friction).abs() < 0.5, "{mean} instead of {friction}");
    let amplitude = [144.0, 288.0, 72.0].map(|order: f64| {
        let part = |f: fn(f64) -> f64| -> f64 {
            samples.iter().map(|(angle, torque, _)| (torque - mean) * f((order * angle).to_radians())).sum()
        };
        2.0 * part(f64::sin).hypot(part(f64::cos)) / count
    });
    let expected = [8.45 * torque_per_disturbance(0.8), 0.845 * torque_per_disturbance(1.6)];
    assert!((amplitude[0] / expected[0] - 1.0).abs() < 0.02, "{amplitude:?} instead of {expected:?}");
    assert!((amplitude[1] / expected[1] - 1.0).abs() < 0.05, "{amplitude:?} instead of {expected:?}");
    assert!(amplitude[2] < 0.1, "nothing at an order that the motor lacks: {amplitude:?}");
}

#[test]
fn csv_reaches_its_target_and_respects_speed_and_soft_limits() {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.write(0, 0x6080, 0, &counts_per_s(20.0).to_le_bytes());
    host.write(0, 0x607D, 1, &counts_per_s(-30.0).to_le_bytes());
    host.write(0, 0x607D, 2, &counts_per_s(30.0).to_le_bytes());
    host.enable(0, 9);
    host.set(0, 0x0F, 0, counts_per_s(50.0), 9);
    host.run(4000);
    assert!((host.velocity_deg_per_s(0) - 20.0).abs() < 0.2, "{}", host.velocity_deg_per_s(0));
    let mut furthest = 0.0_f64;
    for _ in 0..16_000 {
        host.tick();
        furthest = furthest.max(host.angle_deg(0));
    }
    assert!(host.velocity_deg_per_s(0).abs() < 0.02);
    assert!(furthest > 29.0 && furthest < 30.01, "{furthest}");
    assert_ne!(host.word(0, STATUSWORD) & 1 << 11, 0, "the limit is reported");
}

#[test]
fn cst_passes_a_soft_limit_but_reports_it() {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.write(0, 0x607D, 1, &counts_per_s(-5.0).to_le_bytes());
    host.write(0, 0x607D, 2, &counts_per_s(5.0).to_le_bytes());
    host.enable(0, 10);
    host.set(0, 0x0F, 4000, 0, 10);
    host.run(8000);
    assert!(host.angle_deg(0) > 5.0);
    assert_ne!(host.word(0, STATUSWORD) & 1 << 11, 0);
}

/// Spun to about 20 °/s in CST, then a quick stop with option 6 at 90 °/s²: angle v²/2a, plus the ramp's lag.
#[test]
fn quick_stop_ends_within_the_computed_angle_and_holds() {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.write(0, 0x605A, 0, &6_i16.to_le_bytes());
    host.enable(0, 10);
    while host.velocity_deg_per_s(0) < 20.0 {
        host.set(0, 0x0F, 12_000, 0, 10);
        host.tick();
    }
    let (from, speed) = (host.angle_deg(0), host.velocity_deg_per_s(0));
    host.set(0, 0x02, 12_000, 0, 10);
    host.run(4000);
    assert_eq!(host.pattern(0), 0x07);
    assert_ne!(host.word(0, STATUSWORD) & 1 << 10, 0, "stopped");
    let travelled = host.angle_deg(0) - from;
    let computed = speed * speed / (2.0 * 90.0);
    assert!((travelled - computed).abs() < 0.1 * computed + 0.05, "{travelled} instead of {computed}");
    let rest = host.angle_deg(0);
    host.run(4000);
    assert!((host.angle_deg(0) - rest).abs() < 0.01);
    host.set(0, 0x0F, 0, 0, 10);
    host.run(90);
    assert_eq!(host.pattern(0), 0x27, "option 6 lets operation be enabled again");
}

#[test]
fn quick_stop_option_2_ends_with_torque_off() {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.enable(0, 9);
    host.set(0, 0x0F, 0, counts_per_s(10.0), 9);
    host.run(4000);
    host.set(0, 0x02, 0, counts_per_s(10.0), 9);
    host.run(40);
    assert_eq!(host.pattern(0), 0x07);
    host.run(4000);
    assert_eq!(host.word(0, STATUSWORD) & 0x4F, 0x40);
    assert!(host.torque_permille(0).abs() < 30);
}

/// From 20 °/s without torque azimuth coasts 18° (safety.md §1): option 0 does that, option 3 stops far shorter.
#[test]
fn options_0_and_3_are_as_far_apart_as_coasting_and_braking() {
    let travelled = [0_i16, 3].map(|option| {
        let mut host = Host::new(&UnitSettings::default(), start());
        host.write(0, 0x605A, 0, &option.to_le_bytes());
        host.enable(0, 9);
        host.set(0, 0x0F, 0, counts_per_s(20.0), 9);
        host.run(8000);
        let from = host.angle_deg(0);
        host.set(0, 0x02, 0, 0, 9);
        host.run(16_000);
        assert_eq!(host.word(0, STATUSWORD) & 0x4F, 0x40);
        host.angle_deg(0) - from
    });
    assert!((travelled[0] - 18.0).abs() < 2.0, "{travelled:?}");
    assert!(travelled[1] < 2.0, "{travelled:?}");
}

/// Turns azimuth at 10 °/s, falls silent, comes back after `silence`.
fn after_silence(option: i16, silence: Duration) -> Host {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.write(0, 0x6007, 0, &option.to_le_bytes());
    host.write(0, 0x2F00, 0, &200_u16.to_le_bytes());
    host.write(1, 0x2F00, 0, &0_u16.to_le_bytes());
    host.enable(0, 9);
    host.set(0, 0x0F, 0, counts_per_s(10.0), 9);
    host.run(4000);
    host.now += silence;
    host.tick();
    host
}

#[test]
fn the_watchdog_is_content_with_20_ms_and_trips_after() {
    let host = after_silence(1, Duration::from_micros(19_750));
    assert_eq!((host.bus.state(), host.pattern(0)), (BusState::Op, 0x27));
    let mut host = after_silence(1, Duration::from_millis(22));
    assert_eq!((host.bus.state(), host.word(0, STATUSWORD) & 0x4F), (BusState::SafeOp, 0x0F));
    assert_eq!(host.word(0, ERROR_CODE), 0x7500);
    host.run(4000);
    assert_eq!(host.word(0, STATUSWORD) & 0x4F, 0x08);
    assert!(host.velocity_deg_per_s(0).abs() < 0.1, "braked by the fault reaction");
}

#[test]
fn abort_connection_options_do_nothing_disable_or_stop() {
    let silence = Duration::from_millis(400);
    let host = after_silence(0, silence);
    assert_eq!(host.pattern(0), 0x27);
    assert!((host.velocity_deg_per_s(0) - 10.0).abs() < 0.3, "a hung host is not noticed with option 0");
    let host = after_silence(2, silence);
    assert_eq!((host.word(0, STATUSWORD) & 0x4F, host.word(0, ERROR_CODE)), (0x40, 0x7500));
    let host = after_silence(3, silence);
    assert_eq!((host.word(0, STATUSWORD) & 0x4F, host.word(0, ERROR_CODE)), (0x40, 0x7500));
    let mut host = host;
    host.run(8000); // the bristles relax once torque is off
    assert!(host.velocity_deg_per_s(0).abs() < 0.1);
}

#[test]
fn a_fault_is_left_by_a_rising_edge_only_and_after_its_cause_is_gone() {
    let mut host = after_silence(1, Duration::from_millis(22));
    host.run(4000);
    host.bus.request(BusState::Op);
    host.set(0, 0x0F, 0, 0, 10);
    host.run(200);
    assert_eq!(host.word(0, STATUSWORD) & 0x4F, 0x08, "enabling does not leave a fault");
    host.set(0, 0x80, 0, 0, 10);
    host.run(200);
    assert_eq!((host.word(0, STATUSWORD) & 0x4F, host.word(0, ERROR_CODE)), (0x40, 0));
}

#[test]
fn a_hot_heat_sink_warns_then_trips_and_stays_tripped_while_hot() {
    let mut unit = UnitSettings::default();
    (unit.az.heat_sink_warning_degc, unit.az.heat_sink_shutdown_degc) = (39.0, 41.0);
    unit.az.heat_sink_time_s = 1.0;
    (unit.az.loss_power_w, unit.az.ambient_degc) = (400.0, 40.0);
    let mut host = Host::new(&unit, start());
    host.enable(0, 10);
    assert_ne!(host.word(0, STATUSWORD) & 1 << 7, 0, "warning");
    let mut sign = 1;
    while host.now < Duration::from_secs(3) {
        sign = -sign; // ±14.2 A, no motion
        host.set(0, 0x0F, 7100 * sign, 0, 10);
        host.tick();
    }
    assert_eq!((host.word(0, STATUSWORD) & 0x4F, host.word(0, ERROR_CODE)), (0x08, 0x4310));
    assert_eq!(host.torque_permille(0) / 100, 0);
    let mut hot = Host::new(&UnitSettings::default(), StartState { heat_sink_degc: 87.0, ..start() });
    hot.bus.request(BusState::Op);
    hot.run(400);
    hot.set(0, 0x80, 0, 0, 10);
    hot.run(400);
    assert_eq!((hot.word(0, STATUSWORD) & 0x4F, hot.word(0, ERROR_CODE)), (0x08, 0x4310));
}

#[test]
fn a_dc_link_out_of_range_trips() {
    for (voltage, code) in [(300.0, 0x3120), (800.0, 0x3110)] {
        let mut unit = UnitSettings::default();
        unit.az.bus_voltage_v = voltage;
        let mut host = Host::new(&unit, start());
        host.bus.request(BusState::Op);
        for controlword in [0x06, 0x07] {
            host.set(0, controlword, 0, 0, 10);
            host.run(200);
        }
        assert_eq!((host.word(0, STATUSWORD) & 0x4F, host.word(0, ERROR_CODE)), (0x08, code));
    }
}

#[test]
fn torque_is_limited_by_6072_and_6073_and_the_limit_is_reported() {
    for index in [0x6072, 0x6073] {
        let mut host = Host::new(&UnitSettings::default(), start());
        host.write(0, index, 0, &800_u16.to_le_bytes());
        host.enable(0, 10);
        host.set(0, 0x0F, i16::MIN, 0, 10);
        host.run(3);
        assert!((host.torque_permille(0) + 800).abs() < 40, "{}", host.torque_permille(0));
        assert_ne!(host.word(0, STATUSWORD) & 1 << 11, 0);
    }
}

#[test]
fn above_6080_torque_may_only_brake() {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.write(0, 0x6080, 0, &counts_per_s(5.0).to_le_bytes());
    host.enable(0, 10);
    host.set(0, 0x0F, 6000, 0, 10);
    let mut fastest = 0.0_f64;
    for _ in 0..8000 {
        host.tick();
        fastest = fastest.max(host.velocity_deg_per_s(0));
    }
    assert!(fastest > 4.9 && fastest < 5.2, "{fastest}");
}

/// Everything the bus says over two seconds of motion.
fn transcript(seed: u64) -> Vec<u8> {
    let rig = SimulatedRig::new(&UnitSettings::default(), &address(seed), start());
    let mut bus = rig.bus();
    let (mut image, slots) = bus.map().expect("the default mapping is valid");
    bus.request(BusState::SafeOp);
    bus.request(BusState::Op);
    let mut bytes = Vec::new();
    for k in 0..8000_u32 {
        for (_, slot) in &slots {
            let word: u16 = if k < 100 {
                6
            } else if k < 200 {
                7
            } else {
                15
            };
            let torque = (4000.0 * (f64::from(k) * 1e-3).sin()) as i16;
            image.outputs[slot.outputs.start..][..2].copy_from_slice(&word.to_le_bytes());
            image.outputs[slot.outputs.start + 2..][..2].copy_from_slice(&torque.to_le_bytes());
            image.outputs[slot.outputs.start + 8] = 10;
        }
        bus.exchange(TICK * k, &mut image).expect("mapped");
        bytes.extend_from_slice(&image.inputs);
    }
    bytes
}

#[test]
fn the_same_address_gives_the_same_bytes_and_another_seed_others() {
    let first = transcript(7);
    assert!(first == transcript(7));
    assert!(first != transcript(8));
}

#[test]
fn a_crash_reaches_the_record() {
    let mut host = Host::new(&UnitSettings::default(), StartState { az_rad: 2.7, ..start() });
    host.enable(0, 10);
    host.set(0, 0x0F, 5000, 0, 10);
    host.run(8000);
    let crashes = host.rig.record().crashes;
    assert_eq!(crashes.len(), 1, "{crashes:?}");
    assert_eq!(crashes[0].0, "az");
    assert!(crashes[0].2 > 0.1);
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
