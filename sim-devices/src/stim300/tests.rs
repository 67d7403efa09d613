mod console;
mod vectors;

use super::*;
use crate::unit::UnitSettings;
use drivers::stim300::{AccelerometerRange, Content, Input, Opening, SampleRate, Stim300Settings};

const RATE_HZ: f64 = 4000.0;

fn address() -> SeedAddress {
    SeedAddress { seed: 4, procedure: "IMU".into(), point: "1".into() }
}

/// A unit without any error, on a site that does not turn.
fn perfect() -> ImuSettings {
    ImuSettings {
        misalignment_rad: [0.0; 3],
        nonorthogonality_rad: [0.0; 3],
        gyro_noise_factor: 0.0,
        gyro_bias_instability_rad_per_s: 0.0,
        gyro_hourly_walk_rad_per_s: 0.0,
        gyro_bias_rad_per_s: [0.0; 3],
        gyro_scale_error_ratio: [0.0; 3],
        gyro_quantum_rad_per_s: 0.0,
        accelerometer_random_walk_m_per_s_per_sqrt_s: 0.0,
        accelerometer_bias_instability_m_per_s2: 0.0,
        accelerometer_bias_m_per_s2: [0.0; 3],
        accelerometer_scale_error_ratio: [0.0; 3],
        earth_rate_rad_per_s: 0.0,
        ..UnitSettings::default().imu
    }
}

const ALL: Content =
    Content { accelerometers: true, inclinometers: true, temperatures: true, input: Input::Pps };

fn driver_settings(setup: &Stim300Setup) -> Stim300Settings {
    Stim300Settings {
        name: "imu".into(),
        bit_rate: setup.bit_rate,
        content: setup.content,
        sample_rate: setup.sample_rate,
        gyro_unit: setup.gyro_unit,
        accelerometer_unit: setup.accelerometer_unit,
        may_change_unit: true,
        answer_timeout_s: 0.2,
    }
}

fn at(tick: u64) -> Duration {
    Duration::from_micros(250 * tick)
}

/// Steady rates of azimuth and elevation, so that the mean over any interval is the rate.
fn turning(tick: u64) -> Motion {
    let angle = 0.7 * tick as f64 / RATE_HZ;
    Motion { frame_rad: [angle, 0.5], frame_rad_per_s: [0.7, 0.0], ..Motion::default() }
}

fn standing() -> Motion {
    Motion { frame_rad: [0.3, 0.5], ..Motion::default() }
}

/// Unit and driver, with the pulse as the only clock.
struct Pair {
    unit: Rc<RefCell<Stim300>>,
    line: Stim300Line,
    driver: drivers::stim300::Stim300,
    tick: u64,
}

impl Pair {
    fn open(unit: Stim300, settings: Stim300Settings, motion: fn(u64) -> Motion) -> Self {
        let unit = Rc::new(RefCell::new(unit));
        let mut line = Stim300Line(Rc::clone(&unit));
        let mut opening = Opening::new(settings).expect("the measurements fit");
        for tick in 0..8000 {
            unit.borrow_mut().pulse(tick, &motion(tick));
            if let Some(driver) = opening.poll(&mut line, at(tick)).expect("it opens") {
                return Self { unit, line, driver, tick };
            }
        }
        panic!("not open after two seconds");
    }

    fn running(setup: Stim300Setup, motion: fn(u64) -> Motion) -> Self {
        let unit = Stim300::new(&perfect(), setup, &address(), RATE_HZ);
        Self::open(unit, driver_settings(&setup), motion)
    }

    /// One tick: the driver takes what arrived, then the pulse; the number of measurements taken.
    fn tick(&mut self, motion: fn(u64) -> Motion) -> u32 {
        self.tick += 1;
        let count = self.driver.poll(&mut self.line, at(self.tick)).expect("the line is there");
        self.unit.borrow_mut().pulse(self.tick, &motion(self.tick));
        count
    }

    fn ticks(&mut self, count: u32, motion: fn(u64) -> Motion) -> u32 {
        (0..count).map(|_| self.tick(motion)).sum()
    }
}

#[test]
fn every_unit_range_and_content_gives_the_driver_the_same_rates_and_forces() {
    let accelerometers = Content { inclinometers: false, temperatures: false, input: Input::None, ..ALL };
    for gyro_unit in
        [GyroUnit::Rate, GyroUnit::IncrementalAngle, GyroUnit::AverageRate, GyroUnit::IntegratedAngle]
    {
        for (accelerometer_unit, accelerometer_range, content, sample_rate) in [
            (ForceUnit::Acceleration, AccelerometerRange::G5, ALL, SampleRate::Internal(2000)),
            (
                ForceUnit::IncrementalVelocity,
                AccelerometerRange::G10,
                accelerometers,
                SampleRate::Internal(500),
            ),
            (ForceUnit::AverageAcceleration, AccelerometerRange::G30, ALL, SampleRate::Internal(125)),
            (ForceUnit::IncrementalVelocity, AccelerometerRange::G80, accelerometers, SampleRate::External),
        ] {
            let setup = Stim300Setup {
                gyro_unit,
                accelerometer_unit,
                accelerometer_range,
                content,
                sample_rate,
                ..Stim300Setup::default()
            };
            // Triggers of 1 kHz where the unit waits for them.
            let trigger = |tick: u64| sample_rate != SampleRate::External || tick.is_multiple_of(4);
            let mut pair = Pair::running(setup, turning);
            for _ in 0..200 {
                pair.tick += 1;
                pair.driver.poll(&mut pair.line, at(pair.tick)).expect("the line is there");
                if trigger(pair.tick) {
                    pair.unit.borrow_mut().pulse(pair.tick, &turning(pair.tick));
                }
            }
            let sample = pair.driver.valid_sample().expect("healthy");
            let [x, y, _] = sample.rate_rad_per_s;
            let expected = 0.7 * 0.5_f64.cos() * std::f64::consts::FRAC_1_SQRT_2;
            // Half a count of the coarsest: 2⁻²¹ ° a sample at 2 kHz.
            let quantum = 0.5_f64.exp2() * 2000.0 / 2_097_152.0_f64 * 1.0_f64.to_radians();
            let what = format!("{gyro_unit:?} {accelerometer_unit:?} {sample_rate:?}");
            assert!((x - expected).abs() < quantum && (y - expected).abs() < quantum, "{what}: {x} {y}");
            let size = sample.acceleration_m_per_s2.iter().map(|a| a * a).sum::<f64>().sqrt();
            assert!((size - 9.806_65).abs() < 0.2, "{what}: {size} m/s²");
            assert_eq!(sample.temperature_degc, content.temperatures.then_some(45.0));
            assert_eq!(pair.driver.missed_count(), 0, "{what}");
            assert_eq!(pair.driver.tally().bad_checksums_count, 0, "{what}");
        }
    }
}

#[test]
fn the_identity_says_that_the_unit_is_simulated() {
    let pair = Pair::running(Stim300Setup::default(), |_| standing());
    assert!(pair.driver.identity().serial.contains("SIM"), "{}", pair.driver.identity().serial);
    assert_eq!(pair.driver.identity().part_number, "00300-0000000-001 REV S");
}

/// At 0.3 s it says who it is; measurements are called not valid until 0.8 s.
#[test]
fn a_unit_that_is_switched_on_introduces_itself_and_settles() {
    let setup = Stim300Setup { sends_bias_trim: true, ..Stim300Setup::default() };
    let mut unit = Stim300::new(&perfect(), setup, &address(), RATE_HZ).powered_up();
    let mut parser = drivers::stim300::Parser::default();
    let mut kinds = Vec::new();
    let mut first_valid = None;
    for tick in 0..4000 {
        unit.pulse(tick, &standing());
        let mut bytes = [0; 512];
        let count = unit.read(at(tick), &mut bytes);
        assert!(count == 0 || tick >= 1200, "silent in Init mode");
        parser.push(&bytes[..count]);
        while let Some(found) = parser.next() {
            match found {
                drivers::stim300::Found::Special(special) => {
                    assert!(first_valid.is_none());
                    kinds.push(special.kind());
                }
                drivers::stim300::Found::Measurement(one) => {
                    assert_eq!(kinds.len(), 4, "identity comes first");
                    assert!(matches!(one.gyros.status, 0 | 0x40));
                    if one.gyros.status == 0 {
                        first_valid.get_or_insert(tick);
                    }
                }
            }
        }
    }
    let expected = [
        SpecialKind::PartNumber,
        SpecialKind::SerialNumber,
        SpecialKind::Configuration,
        SpecialKind::BiasTrim,
    ];
    assert_eq!(kinds, expected);
    assert!(first_valid.is_some_and(|tick| (3200..3204).contains(&tick)), "{first_valid:?}");
    assert_eq!(parser.tally(), drivers::stim300::Tally::default());
}

#[test]
fn an_opening_takes_the_identity_of_a_unit_that_is_just_switched_on() {
    let setup = Stim300Setup::default();
    let unit = Stim300::new(&perfect(), setup, &address(), RATE_HZ).powered_up();
    let mut pair = Pair::open(unit, driver_settings(&setup), |_| standing());
    assert!(pair.tick < 1300, "no command was needed: {}", pair.tick);
    pair.ticks(8, |_| standing());
    assert!(pair.driver.valid_sample().is_err(), "not settled yet");
    pair.ticks(2000, |_| standing());
    assert!(pair.driver.valid_sample().is_ok());
}

#[test]
fn an_opening_changes_in_service_mode_what_the_unit_is_set_to_otherwise() {
    let setup = Stim300Setup { bit_rate: 460_800, ..Stim300Setup::default() };
    let unit = Stim300::new(&perfect(), setup, &address(), RATE_HZ);
    let wanted = Stim300Settings {
        content: Content { inclinometers: false, ..setup.content },
        sample_rate: SampleRate::Internal(1000),
        gyro_unit: GyroUnit::AverageRate,
        accelerometer_unit: ForceUnit::IncrementalVelocity,
        ..driver_settings(&setup)
    };
    let mut pair = Pair::open(unit, wanted, turning);
    pair.ticks(20, turning);
    let taken = pair.ticks(4000, turning);
    assert!(taken.abs_diff(1000) <= 1, "{taken} in a second");
    let configuration = &pair.driver.identity().configuration;
    assert_eq!((configuration.content.id(), configuration.is_gyro_delayed), (0x91, true));
    assert_eq!((pair.driver.missed_count(), pair.driver.tally().bad_checksums_count), (0, 0));
    // What was not saved is gone with a reset, and the driver sees it.
    let now = at(pair.tick);
    pair.driver.reset(&mut pair.line, now).expect("the line is there");
    let error = (0..2000).find_map(|_| {
        pair.tick += 1;
        pair.unit.borrow_mut().pulse(pair.tick, &turning(pair.tick));
        pair.driver.poll(&mut pair.line, at(pair.tick)).err()
    });
    assert!(error.is_some_and(|error| error.to_string().contains("open it again")));
}

#[test]
fn special_datagrams_take_the_place_of_measurements() {
    let setup = Stim300Setup {
        bit_rate: 921_600,
        sample_rate: SampleRate::Internal(1000),
        ..Stim300Setup::default()
    };
    let mut pair = Pair::running(setup, |_| standing());
    pair.ticks(40, |_| standing());
    let before = pair.driver.replaced_count();
    for (k, kind) in [SpecialKind::BiasTrim, SpecialKind::ExtendedError, SpecialKind::Configuration]
        .into_iter()
        .enumerate()
    {
        pair.driver.request(&mut pair.line, kind, at(pair.tick)).expect("the line is there");
        let taken = pair.ticks(40, |_| standing());
        assert_eq!(taken, 9, "{kind:?}");
        assert_eq!(pair.driver.special().map(|special| special.kind()), Some(kind));
        assert_eq!(pair.driver.replaced_count(), before + k as u64 + 1);
    }
    assert_eq!(pair.driver.missed_count(), 0);
    assert_eq!(pair.driver.bias_trim().map(|trim| trim.saves_left_count), Some(10_000));
}

/// The unit varies its latency by 60 µs; less latency and wire, the samples lie on its clock.
#[test]
fn times_of_samples_do_not_depend_on_latency_and_wire() {
    for bit_rate in [460_800, 1_843_200] {
        let setup =
            Stim300Setup { bit_rate, sample_rate: SampleRate::Internal(500), ..Stim300Setup::default() };
        let mut pair = Pair::running(setup, |_| standing());
        let poll = Duration::from_micros(10);
        let mut latencies_s = Vec::new();
        for _ in 0..400 {
            pair.tick += 1;
            pair.unit.borrow_mut().pulse(pair.tick, &standing());
            for k in 0..25 {
                let now = at(pair.tick) + k * poll;
                if pair.driver.poll(&mut pair.line, now).expect("the line is there") == 1 {
                    let sample = pair.driver.sample().expect("one came");
                    let ns = sample.sampled_at.as_nanos() as u64 % 2_000_000;
                    assert!(ns < 10_100, "{ns} ns after the sample at {bit_rate} bit/s");
                    latencies_s.push(sample.latency_s);
                }
            }
        }
        latencies_s.sort_by(f64::total_cmp);
        assert!(latencies_s.last() > latencies_s.first().map(|least| least + 30e-6).as_ref());
    }
}

#[test]
fn faults_are_seen_by_the_driver_for_what_they_are() {
    let setup = Stim300Setup { sample_rate: SampleRate::Internal(1000), ..Stim300Setup::default() };
    let mut pair = Pair::running(setup, |_| standing());
    pair.ticks(40, |_| standing());
    pair.unit.borrow_mut().inject(MessageFault::Checksum, 2);
    assert_eq!(pair.ticks(40, |_| standing()), 8);
    assert_eq!((pair.driver.tally().bad_checksums_count >= 2, pair.driver.missed_count()), (true, 2));
    pair.unit.borrow_mut().inject(MessageFault::Dropped, 3);
    pair.ticks(40, |_| standing());
    assert_eq!(pair.driver.missed_count(), 5);
    pair.unit.borrow_mut().inject(MessageFault::InvalidStatus, 1);
    let invalid =
        (0..40).filter(|_| pair.tick(|_| standing()) == 1 && pair.driver.valid_sample().is_err()).count();
    assert_eq!(invalid, 1);
    pair.driver
        .request(&mut pair.line, SpecialKind::ExtendedError, at(pair.tick))
        .expect("the line is there");
    pair.ticks(40, |_| standing());
    let errors = pair.driver.extended_errors().expect("they came");
    assert_eq!(errors.numbers().collect::<Vec<_>>(), [65]);
    pair.unit.borrow_mut().shift_gyros(0.05);
    pair.ticks(8, |_| standing());
    assert!(pair.driver.valid_sample().is_ok_and(|sample| (sample.rate_rad_per_s[0] - 0.05).abs() < 1e-5));
    pair.unit.borrow_mut().freeze();
    pair.unit.borrow_mut().shift_gyros(0.05);
    assert_eq!(pair.ticks(40, |_| standing()), 10);
    assert!(pair.driver.valid_sample().is_ok_and(|sample| (sample.rate_rad_per_s[0] - 0.05).abs() < 1e-5));
    pair.unit.borrow_mut().fall_silent();
    pair.ticks(8, |_| standing());
    assert_eq!(pair.ticks(400, |_| standing()), 0);
    assert!(pair.driver.age_ticks() >= 400);
}

/// 63 bytes at 374400 bit/s take 1.68 ms: of 1000 measurements a second every second one is lost.
#[test]
fn a_line_that_is_too_slow_loses_measurements_and_the_unit_says_so() {
    let setup = Stim300Setup { bit_rate: 374_400, content: ALL, ..Stim300Setup::default() };
    let mut unit = Stim300::new(&perfect(), setup, &address(), RATE_HZ);
    let mut parser = drivers::stim300::Parser::default();
    let mut counters = Vec::new();
    for tick in 0..400 {
        unit.pulse(tick, &standing());
        let mut bytes = [0; 512];
        let count = unit.read(at(tick), &mut bytes);
        parser.push(&bytes[..count]);
        while let Some(drivers::stim300::Found::Measurement(one)) = parser.next() {
            counters.push(one.counter);
        }
    }
    assert!(
        counters.len() > 40 && counters.windows(2).all(|pair| pair[1].wrapping_sub(pair[0]) == 4),
        "{counters:?}"
    );
    assert_eq!(unit.errors >> UART_TOO_SLOW & 1, 1);
}

#[test]
fn beyond_the_range_the_unit_calls_the_axis_overloaded() {
    let setup = Stim300Setup { accelerometer_range: AccelerometerRange::G5, ..Stim300Setup::default() };
    let fast = |tick: u64| {
        let angle = 9.0 * tick as f64 / RATE_HZ;
        Motion { frame_rad: [angle, std::f64::consts::FRAC_PI_2], ..Motion::default() }
    };
    let mut pair = Pair::running(setup, fast);
    pair.ticks(8, fast);
    let sample = pair.driver.sample().expect("measurements run");
    assert_eq!((sample.gyro_status, &sample.valid[..3]), (0x14, &[true, true, false][..]));
    assert!((sample.rate_rad_per_s[2] - 400.0_f64.to_radians()).abs() < 1e-6);
}
