//! How fast the inertial measurement unit and the encoder are: items per second are messages and angles.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use drivers::kvh::{Format, KvhSettings, Opening, Synchronisation};
use sim_devices::kvh::{Kvh, KvhLine};
use sim_devices::motion::Motion;
use sim_devices::physics::encoder::Encoder;
use sim_devices::rig::SeedAddress;
use sim_devices::unit::UnitSettings;

const RATE_HZ: f64 = 4000.0;
const TICKS: u64 = 4000;

fn main() {
    divan::main();
}

/// A slow scan with both axes.
fn motion(tick: u64) -> Motion {
    let t = tick as f64 / RATE_HZ;
    Motion { frame_rad: [0.3 + 0.2 * t, 0.6 + 0.01 * t], frame_rad_per_s: [0.2, 0.01], ..Motion::default() }
}

fn opened() -> (Rc<RefCell<Kvh>>, KvhLine, drivers::kvh::Kvh) {
    let address = SeedAddress { seed: 1, procedure: "BENCH".into(), point: "1".into() };
    let unit = Rc::new(RefCell::new(Kvh::new(&UnitSettings::default().imu, &address, RATE_HZ)));
    let mut line = KvhLine(Rc::clone(&unit));
    let mut opening = Opening::new(KvhSettings {
        name: "imu".into(),
        baud: 4_147_200,
        format: Format::A,
        synchronisation: Synchronisation::External,
        message_rate_hz: RATE_HZ,
        rate_output: true,
        answer_timeout_s: 0.1,
    })
    .expect("the messages fit");
    for millisecond in 0..1000 {
        if let Some(driver) = opening.poll(&mut line, Duration::from_millis(millisecond)).expect("it opens") {
            return (unit, line, driver);
        }
    }
    panic!("the twin answers within a second");
}

/// Unit, line and driver: what one tick of the rig pays.
#[divan::bench]
fn messages_through_the_driver(bencher: Bencher<'_, '_>) {
    let (unit, mut line, mut driver) = opened();
    let mut tick = 4000;
    bencher.counter(ItemsCount::new(TICKS)).bench_local(|| {
        for _ in 0..TICKS {
            tick += 1;
            driver.poll(&mut line, Duration::from_micros(250 * tick)).expect("the line is there");
            unit.borrow_mut().pulse(tick, black_box(&motion(tick)));
        }
    });
}

/// The unit alone, nobody reads: six noisy sensors, geometry, frame.
#[divan::bench]
fn messages_of_the_unit(bencher: Bencher<'_, '_>) {
    let (unit, ..) = opened();
    let mut unit = unit.borrow_mut();
    let mut tick = 4000;
    bencher.counter(ItemsCount::new(TICKS)).bench_local(|| {
        for _ in 0..TICKS {
            tick += 1;
            unit.pulse(tick, black_box(&motion(tick)));
        }
    });
}

/// The nominal encoder with its scale error at 20 kHz while the axis moves.
#[divan::bench]
fn encoder_angles(bencher: Bencher<'_, '_>) {
    let mut encoder = Encoder::new(&UnitSettings::default().az);
    bencher.counter(ItemsCount::new(TICKS)).bench_local(|| {
        (0..TICKS).map(|k| encoder.unwrapped_counts(black_box(0.3 + 1e-5 * k as f64))).sum::<i64>()
    });
}
