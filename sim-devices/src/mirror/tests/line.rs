//! The serial line, with the real driver at the other end.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use drivers::device::DeviceError;
use drivers::mirror as driver;
use drivers::wire::{AnalogPort, ByteLine};

use super::*;

/// A mirror and its own clock: the wires to it step it to the time of the call.
struct Bench {
    mirror: Mirror,
    steps: u64,
}

#[derive(Clone)]
struct Wires(Rc<RefCell<Bench>>);

impl Wires {
    fn new(settings: &MirrorSettings) -> Self {
        Self(Rc::new(RefCell::new(Bench { mirror: mirror(settings), steps: 0 })))
    }

    fn at<T>(&self, now: Duration, act: impl FnOnce(&mut Mirror) -> T) -> T {
        let mut bench = self.0.borrow_mut();
        while (bench.steps as f64) < (now.as_secs_f64() * STEPS_PER_S).round() {
            let steps = bench.steps;
            bench.mirror.step(steps);
            bench.steps += 1;
        }
        act(&mut bench.mirror)
    }
}

impl ByteLine for Wires {
    fn name(&self) -> &str {
        "mirror line"
    }

    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        Ok(self.at(now, |mirror| mirror.take_reply(into)))
    }

    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        self.at(now, |mirror| bytes.iter().for_each(|&byte| mirror.receive(byte)));
        Ok(())
    }
}

impl AnalogPort for Wires {
    fn name(&self) -> &str {
        "analog card"
    }

    fn write_v(&mut self, now: Duration, channel: usize, volts: f64) -> Result<(), DeviceError> {
        self.at(now, |mirror| mirror.command_analog_v(channel, volts));
        Ok(())
    }

    fn read_v(&mut self, now: Duration, channel: usize) -> Result<f64, DeviceError> {
        Ok(self.at(now, |mirror| mirror.gauge_v()[channel]))
    }
}

fn driver_over(path: driver::Path) -> driver::Mirror {
    driver::Mirror::new(driver::MirrorSettings {
        name: "fsm".into(),
        scale_rad_per_v: [500e-6; 2],
        stroke_rad: [1.05e-3; 2],
        command: path,
        feedback: path,
        command_outputs: [0, 1],
        feedback_inputs: [0, 1],
        reply_timeout_s: 0.01,
    })
    .expect("the settings are sound")
}

fn tick(k: u32) -> Duration {
    Duration::from_micros(250) * k
}

/// Configured at the end; the tick it took.
fn configured(wires: &Wires, driver: &mut driver::Mirror) -> (u32, driver::Identity) {
    let mut line = wires.clone();
    (0..200)
        .find_map(|k| driver.configure(&mut line, tick(k)).expect("the unit answers").map(|set| (k, set)))
        .expect("200 ticks are enough")
}

/// All characters that come back within `steps` of sending `text`, and when the last one came.
fn talk(mirror: &mut Mirror, text: &str, steps: u64) -> (Vec<u8>, u64) {
    text.bytes().for_each(|byte| mirror.receive(byte));
    let mut reply = Vec::new();
    let mut last = 0;
    for k in 0..steps {
        mirror.step(k);
        let mut byte = [0];
        while mirror.take_reply(&mut byte) == 1 {
            reply.push(byte[0]);
            last = k + 1;
        }
    }
    (reply, last)
}

#[test]
fn both_channels_reach_the_command_and_read_it_back() {
    for path in [driver::Path::Analog, driver::Path::Serial] {
        let wires = Wires::new(&MirrorSettings::default());
        let mut driver = driver_over(path);
        let (start, identity) = configured(&wires, &mut driver);
        assert_eq!(identity.map(|set| (set.filter, set.filter_hz[0])), [(2, 322), (2, 350)]);
        let mut line = wires.clone();
        let mut card = wires.clone();
        let mut actuals = driver::Actuals::default();
        for k in start..start + 1200 {
            actuals =
                driver.exchange(&mut line, &mut card, [300e-6, -700e-6], tick(k)).expect("the unit answers");
        }
        for (axis, expected) in [300e-6, -700e-6].into_iter().enumerate() {
            assert!((actuals.command_rad[axis] - expected).abs() < 3e-9, "{path:?} {actuals:?}");
            assert!((actuals.angle_rad[axis] - expected).abs() < 1.5e-6, "{path:?} {actuals:?}");
            let truth = wires.at(tick(start + 1200), |mirror| mirror.angle_rad()[axis]);
            assert!((truth - expected).abs() < 1.5e-6, "{path:?}: {truth}");
        }
    }
}

/// The manual's vector (CCBu40 v1.21): `Q2E` at -1.65 V is answered with FF FF EA E2, then `X`.
#[test]
fn the_unit_answers_in_the_bytes_of_the_manual() {
    let settings = MirrorSettings { gauge_departure_ratio: 0.0, ..linear() };
    let mut mirror = mirror(&settings);
    for order in ["V2E", "T1E", "Z-1.65E"] {
        assert_eq!(talk(&mut mirror, order, 4000).0, b"X", "{order}");
    }
    assert_eq!(
        talk(&mut mirror, "Q2E", 100).0[..4],
        (-5407_i32).to_be_bytes(),
        "rounded; the manual cuts it off"
    );
    assert_eq!(talk(&mut mirror, "Z-1.6498E", 4000).0, b"X");
    assert_eq!(talk(&mut mirror, "Q2E", 100).0, [0xFF, 0xFF, 0xEA, 0xE2, b'X']);
    let set = talk(&mut mirror, "R2E", 200).0;
    assert_eq!(set.len(), 61);
    let words: Vec<i32> =
        set[..60].as_chunks::<4>().0.iter().map(|bytes| i32::from_be_bytes(*bytes)).collect();
    // Digital, -1.6498 V, closed; gains over 65536; second-order notch at 350 Hz; +- 2.1 V; firmware 1.00; 15-002.
    assert_eq!((words[0], words[1], words[2]), (1, -5406, 1));
    assert_eq!(words[3..6], [5243, 500 << 16, 0]);
    assert_eq!(words[6..9], [2, 350, 0]);
    assert_eq!(words[9], -words[10]);
    assert_eq!(words[11..], [65_536, 100, 15_002, 0]);
}

#[test]
fn characters_take_their_time_on_the_line() {
    // 19 200 bit/s: 4 characters out and back in 8 · 10 / 19 200 s = 83.3 steps.
    let slow = MirrorSettings { serial_bit_rate_hz: 19_200.0, ..MirrorSettings::default() };
    let (reply, last) = talk(&mut mirror(&slow), "Q1E", 200);
    assert_eq!((reply.len(), reply[4]), (5, b'X'));
    assert!((83..=86).contains(&last), "{last} steps");
    // Register 1171 of `b` is 9599 bit/s; the acknowledge already goes at it.
    let mut changed = mirror(&slow);
    talk(&mut changed, "b1171E", 300);
    let (_, last) = talk(&mut changed, "V1E", 300);
    assert!((83..=86).contains(&last), "4 characters at half the rate: {last} steps");
}

#[test]
fn what_the_manual_does_not_allow_is_never_acknowledged() {
    for bad in ["Z1\rE", "V3E", "X", "Z11E", "ZE", "Z000000000000000000000001E"] {
        let mut mirror = mirror(&MirrorSettings::default());
        assert_eq!(talk(&mut mirror, bad, 100).0, b"", "{bad}");
        // The terminator ends the misery: the next command is heard. "X" had none, so it spoils one more.
        let next = talk(&mut mirror, "V2E", 100).0;
        assert_eq!(next, if bad.ends_with('E') { &b"X"[..] } else { b"" }, "{bad}");
    }
}

#[test]
fn a_second_command_before_the_acknowledge_is_lost() {
    let mut mirror = mirror(&MirrorSettings::default());
    assert_eq!(talk(&mut mirror, "W0.5EQ1E", 1000).0, b"X", "the query came while the order was stored");
    assert_eq!(talk(&mut mirror, "Q1E", 100).0.len(), 5);
}

#[test]
fn the_switch_keeps_the_unit_analog() {
    let settings = MirrorSettings { analog_only_switch: 1.0, ..MirrorSettings::default() };
    let mut mirror = mirror(&settings);
    assert_eq!(talk(&mut mirror, "T1E", 100).0, b"X", "acknowledged and ignored");
    talk(&mut mirror, "Z1E", 4000);
    assert!(mirror.angle_rad()[0].abs() < 2e-6);
}

/// Sum over 4000 steps of the angle that an order makes.
fn course_of(order: &str) -> f64 {
    let settings = MirrorSettings {
        gauge_noise_rad: 0.0,
        resolution_rad: 1e-12,
        hysteresis_ratio: 0.0,
        creep_per_decade_ratio: 0.0,
        ..MirrorSettings::default()
    };
    let mut mirror = mirror(&settings);
    talk(&mut mirror, "T1E", 100);
    order.bytes().for_each(|byte| mirror.receive(byte));
    let step = |k| {
        mirror.step(k);
        mirror.angle_rad()[0]
    };
    (1..4000).map(step).sum()
}

#[test]
fn the_sign_of_an_order_costs_the_time_of_a_character_and_not_a_whole_step() {
    // 10 bits at 937.5 kHz are 0.2133 steps of 50 us.
    let late_steps = (course_of("Z0.10000E") + course_of("Z-0.10000E")) / 50e-6;
    assert!((late_steps - 0.2133).abs() < 0.004, "{late_steps} steps");
}

#[test]
fn an_order_acts_its_delay_after_its_last_character() {
    let settings = MirrorSettings { gauge_noise_rad: 0.0, ..MirrorSettings::default() };
    let mut mirror = mirror(&settings);
    talk(&mut mirror, "T1E", 100);
    "Z1E".bytes().for_each(|byte| mirror.receive(byte));
    let first = (1..200).find(|&k| (mirror.step(k), mirror.angle_rad()[0] != 0.0).1);
    // Three characters are 32 µs, within the first step; then three steps of delay.
    assert_eq!(first, Some(4));
}
