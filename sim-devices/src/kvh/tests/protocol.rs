use super::*;
use proptest::prelude::*;

fn standing() -> Motion {
    Motion { frame_rad: [0.3, 0.5], ..Motion::default() }
}

fn unit() -> Kvh {
    Kvh::new(&perfect(), &address(), RATE_HZ)
}

/// What arrives within a second of a command, as text.
fn reply(unit: &mut Kvh, command: &str) -> String {
    unit.write(at(0), command.as_bytes());
    let mut bytes = [0; 4096];
    let count = unit.read(at(4000), &mut bytes);
    String::from_utf8_lossy(&bytes[..count]).into_owned()
}

fn in_config_mode() -> Kvh {
    let mut unit = unit();
    assert_eq!(reply(&mut unit, "=config,1\r"), "CONFIG,1\r\n");
    unit
}

#[test]
fn normal_mode_ignores_what_it_does_not_know() {
    let mut unit = unit();
    for command in ["?DR\r\n", "=DR,3600\r\n", "nonsense\r\n", "=CONFIG,2\r\n", "\r\n\r\n", "=CONFIG,0\n"] {
        assert_eq!(reply(&mut unit, command), "", "{command}");
    }
    assert_eq!(reply(&mut in_config_mode(), "?DR\r\n"), "DR,1000\r\n", "nothing was set");
}

#[test]
fn config_mode_answers_every_command() {
    let mut unit = in_config_mode();
    for (command, answer) in [
        ("=dr,3600", "DR,3600"),
        ("?DR", "DR,3600"),
        ("=DR,4000", "USAGE: =DR,<1|5|10|25|50|100|250|500|750|1000|3600|5000>"),
        ("?ROTFMT", "ROTFMT,DELTA"),
        ("=ROTFMT,RATE", "ROTFMT,RATE"),
        ("=ROTFMT,RESET", "ROTFMT,RATE"),
        ("=ROTUNITS,DEG", "ROTUNITS,DEG"),
        ("=OUTPUTFMT,C", "OUTPUTFMT,C"),
        ("=TEMPUNITS,F_100", "TEMPUNITS,F_100"),
        ("=LINUNITS,FEET", "LINUNITS,FEET"),
        ("?LINFMT", "LINFMT,ACCEL"),
        ("?FILTTYPE,G", "FILTTYPE,G,BUTTER"),
        ("=MSYNC,EXT", "MSYNC,EXT"),
        ("?FILTTYPE,A", "FILTTYPE,A,AVE"),
        ("?FILTTYPE", "USAGE: ?FILTTYPE,<A|G>"),
        ("=AXES,0,1,0,-1,0,0,0,0,1", "AXES,0,1,0,-1,0,0,0,0,1"),
        ("=AXES,1,2", "USAGE: =AXES,x0,x1,x2,y0,y1,y2,z0,z1,z2"),
        ("?IS", "IS,SIM1775"),
        ("?BIT", "INVALID,BIT"),
        ("=IS,1", "INVALID,IS,1"),
        ("hello", "INVALID,HELLO"),
        ("?LOGS", "LOGS,Start of log entries!\r\nEnd of log entries!"),
        ("=RSTCFG", "RSTCFG"),
        ("?ROTFMT", "ROTFMT,DELTA"),
        ("?BAUD", "BAUD,4147200"),
        ("=BAUD,9600", "BAUD,9600"),
    ] {
        assert_eq!(reply(&mut unit, &format!("{command}\r\n")), format!("{answer}\r\n"), "{command}");
    }
    assert_eq!(reply(&mut unit, "=CONFIG,0\r\n"), "", "normal mode never answers");
}

/// 11 characters take 11.46 ms at 9600 baud and 27 µs at 4147200: the answer is already at the new rate.
#[test]
fn the_answer_to_baud_comes_at_the_new_rate() {
    let mut unit = in_config_mode();
    let start = Duration::from_secs(2);
    unit.write(start, b"=BAUD,9600\r\n");
    let mut bytes = [0; 64];
    assert_eq!(unit.read(start + Duration::from_micros(11_400), &mut bytes), 10);
    assert_eq!(unit.read(start + Duration::from_micros(11_460), &mut bytes), 1);
}

#[test]
fn messages_stop_in_config_mode_and_go_on_afterwards() {
    let mut pair = Pair::open(&perfect(), driver_settings(), &standing());
    (0..10).for_each(|_| {
        pair.tick(&standing());
    });
    let first = pair.driver.sample().expect("messages run").sequence;
    pair.unit.borrow_mut().write(at(pair.tick), b"=CONFIG,1\r\n");
    (0..20).for_each(|_| {
        pair.tick(&standing());
    });
    assert!(pair.driver.age_ticks() >= 18, "{}", pair.driver.age_ticks());
    pair.unit.borrow_mut().write(at(pair.tick), b"=CONFIG,0\r\n");
    (0..3).for_each(|_| {
        pair.tick(&standing());
    });
    assert_eq!(pair.driver.age_ticks(), 0);
    assert!(pair.driver.sample().expect("again").sequence > first);
    assert_eq!(pair.driver.missed_count(), 0);
}

/// 86.8 µs of wire: a message is not there before, and it is there a tick later.
#[test]
fn one_message_a_pulse_arrives_after_its_time_on_the_wire() {
    let mut pair = Pair::open(&perfect(), driver_settings(), &standing());
    (0..4).for_each(|_| {
        pair.tick(&standing());
    });
    assert!((0..1000).all(|_| pair.tick(&standing()) == 1));
    let now = at(pair.tick);
    let driver = &mut pair.driver;
    let early = driver.poll(&mut pair.line, now + Duration::from_nanos(86_700)).expect("there");
    let late = driver.poll(&mut pair.line, now + Duration::from_nanos(86_900)).expect("there");
    assert_eq!((early, late), (0, 1));
    assert_eq!((driver.missed_count(), driver.tally().bad_checksums_count), (0, 0));
}

#[test]
fn the_internal_data_rate_is_kept_on_average() {
    let settings = KvhSettings {
        synchronisation: Synchronisation::Internal(750),
        message_rate_hz: 750.0,
        ..driver_settings()
    };
    let mut pair = Pair::open(&perfect(), settings, &standing());
    let taken: u32 = (0..4000).map(|_| pair.tick(&standing())).sum();
    assert!(taken.abs_diff(750) <= 1, "{taken} in a second");
}

#[test]
fn every_format_and_quantity_gives_the_driver_the_same_sample() {
    let turning = |tick: u64| {
        let angle = 0.7 * tick as f64 / RATE_HZ;
        Motion { frame_rad: [angle, 0.5], frame_rad_per_s: [0.7, 0.0], ..Motion::default() }
    };
    for format in [Format::A, Format::B, Format::C] {
        for rate_output in [true, false] {
            let settings = KvhSettings { format, rate_output, ..driver_settings() };
            let mut pair = Pair::open(&perfect(), settings, &turning(0));
            for _ in 0..10 {
                let motion = turning(pair.tick + 1);
                pair.tick(&motion);
            }
            let sample = pair.driver.sample().expect("messages run");
            let [x, y, _] = sample.rate_rad_per_s;
            let expected = 0.7 * 0.5_f64.cos() * std::f64::consts::FRAC_1_SQRT_2;
            assert!((x - expected).abs() < 1e-6 && (y - expected).abs() < 1e-6, "{format:?}: {x} {y}");
            assert_eq!(sample.temperature_degc, 45.0);
            // The newest message taken belongs to the pulse of the tick before.
            let time_us = (format == Format::B).then_some(250 * (pair.tick as u32 - 1));
            assert_eq!(sample.timestamp_us, time_us);
        }
    }
}

#[test]
fn gyros_are_not_valid_until_the_unit_has_started() {
    let imu = ImuSettings { startup_s: 0.5, ..perfect() };
    let mut pair = Pair::open(&imu, driver_settings(), &standing());
    (0..10).for_each(|_| {
        pair.tick(&standing());
    });
    let sample = *pair.driver.sample().expect("messages run");
    assert_eq!(sample.status, 0x70);
    assert!(sample.rate_rad_per_s.iter().all(|rate| rate.abs() > 1e-3), "garbage, not zero: {sample:?}");
    assert!(pair.driver.valid_sample().is_err());
    while pair.tick < 2002 {
        pair.tick(&standing());
    }
    let sample = pair.driver.valid_sample().expect("started");
    assert!(sample.rate_rad_per_s.iter().all(|rate| rate.abs() < 1e-9));
}

#[test]
fn faults_are_seen_by_the_driver_for_what_they_are() {
    let mut pair = Pair::open(&perfect(), driver_settings(), &standing());
    (0..5).for_each(|_| {
        pair.tick(&standing());
    });
    pair.unit.borrow_mut().inject(MessageFault::Checksum, 2);
    assert_eq!((0..4).map(|_| pair.tick(&standing())).sum::<u32>(), 2);
    assert_eq!(pair.driver.tally().bad_checksums_count, 2);
    assert_eq!(pair.driver.missed_count(), 2);
    pair.unit.borrow_mut().inject(MessageFault::Dropped, 3);
    (0..5).for_each(|_| {
        pair.tick(&standing());
    });
    assert_eq!((pair.driver.tally().bad_checksums_count, pair.driver.missed_count()), (2, 5));
    pair.unit.borrow_mut().inject(MessageFault::InvalidStatus, 1);
    pair.tick(&standing());
    pair.tick(&standing());
    assert_eq!(pair.driver.sample().expect("messages run").status, 0x76);
    pair.tick(&standing());
    assert!(pair.driver.valid_sample().is_ok());
}

#[test]
fn a_built_in_test_is_reported_after_power_up_and_on_request() {
    let mut unit = unit();
    let mut bytes = [0; 256];
    unit.pulse(0, &standing());
    let count = unit.read(at(4), &mut bytes);
    assert_eq!(bytes[count - 11..count], [0xFE, 0x81, 0x00, 0xAA, 127, 127, 127, 127, 127, 127, 0x23]);
    let mut pair = Pair::open(&perfect(), driver_settings(), &standing());
    pair.driver.request_bit(&mut pair.line, at(pair.tick)).expect("the line is there");
    assert!(pair.driver.bit().is_none());
    (0..3).for_each(|_| {
        pair.tick(&standing());
    });
    let report = pair.driver.bit().expect("within 100 ms");
    assert!(report.passed() && report.bytes().len() == 8);
}

#[test]
fn a_line_that_is_too_slow_shows_as_gaps() {
    let mut unit = unit();
    reply(&mut unit, "=CONFIG,1\r=MSYNC,EXT\r=BAUD,921600\r=CONFIG,0\r");
    let mut bytes = [0; 4096];
    let mut received = 0;
    let mut newest = 0;
    for tick in 8000..8400 {
        unit.pulse(tick, &standing());
        received += unit.read(at(tick), &mut bytes);
        newest = unit.sequence;
    }
    let messages = received / 36;
    assert!((250..=260).contains(&messages), "{messages} of 400 in 100 ms: 2560 Hz is the most");
    assert_eq!(u32::from(newest), 400 % 128, "the numbers go on");
}

#[test]
fn a_line_that_begins_with_no_character_is_answered_like_any_other_unknown_one() {
    let mut unit = in_config_mode();
    unit.write(at(0), &[0x80, b'D', b'R', b'\r']);
    let mut bytes = [0; 64];
    let count = unit.read(at(4000), &mut bytes);
    assert_eq!(String::from_utf8_lossy(&bytes[..count]), "INVALID,\u{FFFD}DR\r\n");
}

proptest! {
    #[test]
    fn no_bytes_in_config_mode_bring_the_unit_down(
        lines in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..12), 1..20),
    ) {
        let mut unit = in_config_mode();
        for line in lines {
            unit.write(at(0), &line);
            unit.write(at(0), b"\r");
            unit.read(at(4000), &mut [0; 4096]);
        }
    }
}
