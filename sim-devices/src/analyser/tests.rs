use drivers::analyser::{Analyser as Driver, AnalyserSettings, Point, Sweep as Order};
use drivers::device::DeviceError;
use drivers::scpi::{FormatError, Instrument};
use drivers::wire::ByteLine;

use super::*;
use crate::unit::UnitSettings;

/// The instrument as a line.
struct Line(Analyser);

impl ByteLine for Line {
    fn name(&self) -> &str {
        "analyser line"
    }

    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        Ok(self.0.take(now, into))
    }

    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        self.0.receive(now, bytes);
        Ok(())
    }
}

fn bed(unit: &UnitSettings) -> (Line, Mirror) {
    let address = SeedAddress { seed: 1, procedure: "P".into(), point: "1".into() };
    let mirror = Mirror::new(&unit.mirror, &address, 50e-6);
    (Line(Analyser::new(&unit.instruments, &address, &mirror)), mirror)
}

fn order(axis: usize) -> Order {
    Order { axis, level_v_ptp: 1.0, from_hz: 20.0, to_hz: 2000.0, points: 201 }
}

/// Calls every quarter of a millisecond until something comes of it; when that was.
fn until<T>(
    from: Duration,
    mut call: impl FnMut(Duration) -> Result<Option<T>, DeviceError>,
) -> Result<(T, Duration), DeviceError> {
    for tick in 0..400_000 {
        let now = from + tick * Duration::from_micros(250);
        if let Some(done) = call(now)? {
            return Ok((done, now));
        }
    }
    panic!("it neither ends nor gives up")
}

fn sweep(line: &mut Line, relay: [u8; 2], order: &Order) -> Result<(Vec<Point>, f64), DeviceError> {
    let settings = AnalyserSettings { name: "analyser".into(), relay, reply_timeout_s: 1.0 };
    let mut driver = Driver::new(settings)?;
    let (_, now) = until(Duration::ZERO, |now| driver.identify(line, now))?;
    driver.prepare(order)?;
    driver.start(line, now)?;
    let ((), end) = until(now, |now| Ok(driver.poll(line, now)?.then_some(())))?;
    Ok((driver.points().to_vec(), (end - now).as_secs_f64()))
}

#[test]
fn the_driver_reads_the_impedance_of_each_axis_of_the_mirror() {
    let (mut line, mirror) = bed(&UnitSettings::default());
    for axis in [0, 1] {
        let (points, lasted_s) = sweep(&mut line, [1, 2], &order(axis)).expect("a healthy instrument");
        assert_eq!(points.len(), 201);
        let mut squares = 0.0;
        for point in &points {
            let truth = mirror.circuit(axis).impedance(point.frequency_hz);
            let off = (point.resistance_ohm - truth.resistance_ohm)
                .hypot(point.reactance_ohm - truth.reactance_ohm);
            squares += (off / truth.magnitude_ohm()).powi(2) / 201.0;
            let behind = (point.level_v / point.current_a / truth.magnitude_ohm() - 1.0).abs();
            assert!(behind < 1e-9 && point.level_v < 0.354, "{point:?}");
        }
        // 0.1 % in each of two parts; 201 points of it scatter by 1/√402 = 5 %.
        let ratio = squares.sqrt() / (0.001 * 2.0_f64.sqrt());
        assert!((ratio - 1.0).abs() < 0.2, "{ratio}");
        // Two periods of each frequency and 3 ms.
        let expected_s: f64 = points.iter().map(|p| 0.003 + 2.0 / p.frequency_hz).sum();
        assert!((lasted_s - expected_s).abs() < 0.1, "{lasted_s} s, expected {expected_s} s");
    }
}

#[test]
fn an_axis_that_is_not_connected_is_an_overload() {
    let (mut line, _) = bed(&UnitSettings::default());
    let error = sweep(&mut line, [0, 3], &order(0)).expect_err("open terminals");
    let DeviceError::Answer { source: FormatError::NotValid { place: 1, .. }, .. } = error else {
        panic!("{error}")
    };
}

#[test]
fn an_instrument_that_is_slower_than_it_may_be_is_given_up() {
    let mut unit = UnitSettings::default();
    unit.instruments.analyser_point_time_s = 10.0;
    let (mut line, _) = bed(&unit);
    let error = sweep(&mut line, [1, 2], &Order { points: 2, ..order(0) }).expect_err("20 s for two points");
    assert!(error.to_string().contains("expected a whole one to *OPC?, found none within"), "{error}");
}

/// Says something to it and gives the answer.
fn told(line: &mut Line, message: &str, now: Duration) -> String {
    line.0.receive(now, format!("{message}\n").as_bytes());
    let mut into = [0; 4096];
    let count = line.0.take(now + Duration::from_secs(1), &mut into);
    String::from_utf8_lossy(&into[..count]).trim_end().to_owned()
}

#[test]
fn what_it_cannot_do_stands_in_its_error_queue() {
    let (mut line, _) = bed(&UnitSettings::default());
    let cases = [
        (":SENS1:FREQ:STAR 19", "-222,\"Data out of range\""),
        (":SOUR1:VOLT 1.2", "-222,\"Data out of range\""),
        (":SENS1:SWE:TYPE CUBIC", "-224,\"Illegal parameter value\""),
        (":SENS1:SWE:POIN", "-109,\"Missing parameter\""),
        (":SENS1:SWE:POIN 3,4", "-108,\"Parameter not allowed\""),
        (":SENS1:FREQ:CENT 20", "-113,\"Undefined header\""),
        (":TRIG:SING", "-211,\"Trigger ignored\""),
        (":CALC1:DATA:FDAT?", "-230,\"Data corrupt or stale\""),
        (":CALC1:PAR4:SEL;:CALC1:DATA:FDAT?", "-221,\"Settings conflict\""),
        (":SENS1:FREQ:STAR 30", "+0,\"No error\""),
    ];
    for (k, (message, expected)) in (0..).zip(cases) {
        let now = Duration::from_secs(10 * k);
        assert_eq!(told(&mut line, message, now), "", "{message}");
        assert_eq!(told(&mut line, ":SYST:ERR?", now + Duration::from_secs(5)), expected, "{message}");
    }
}

#[test]
fn a_sweep_that_was_aborted_leaves_an_instrument_that_sweeps_again() {
    let (mut line, _) = bed(&UnitSettings::default());
    let settings = AnalyserSettings { name: "analyser".into(), relay: [1, 2], reply_timeout_s: 1.0 };
    let mut driver = Driver::new(settings).expect("sound settings");
    let (_, now) = until(Duration::ZERO, |now| driver.identify(&mut line, now)).expect("it answers");
    driver.prepare(&order(0)).expect("a sweep it can do");
    driver.start(&mut line, now).expect("a line");
    let middle = now + Duration::from_secs(1);
    let mut at = now;
    while at < middle {
        assert_eq!(driver.poll(&mut line, at), Ok(false));
        at += Duration::from_millis(1);
    }
    assert!(line.0.sweeps(at), "in the middle of it");
    driver.abort(&mut line, at).expect("a line");
    assert!(!line.0.sweeps(at) && !driver.is_running() && line.0.relay == 0);
    driver.start(&mut line, at).expect("a line");
    let again = until(at, |now| Ok(driver.poll(&mut line, now)?.then_some(())));
    assert!(again.is_ok(), "{again:?}");
}

#[test]
fn what_was_set_is_answered_in_short_forms() {
    let (mut line, _) = bed(&UnitSettings::default());
    let mut ask = |at_s: u64, message: &str| {
        let at = Duration::from_secs(at_s);
        line.write(at, format!("{message}\n").as_bytes()).expect("a line");
        let mut into = [0; 256];
        let count = line.read(at + Duration::from_millis(100), &mut into).expect("a line");
        String::from_utf8_lossy(&into[..count]).trim_end().to_owned()
    };
    ask(
        1,
        ":SENS1:FREQ:STAR 20;STOP 2000;:SENS1:SWE:TYPE LOG;POIN 21;:TRIG:SOUR BUS;:CALC1:PAR2:DEF X;:CONT:HAND:A 1",
    );
    for (query, expected) in [
        (":SENS1:FREQ:STAR?;STOP?", "+2.00000000000E+01;+2.00000000000E+03"),
        (":SENS:SWE:TYPE?;POIN?", "LOG;+21"),
        (":TRIG:SOUR?;:INIT:CONT?", "BUS;1"),
        (":CALC1:PAR2:DEF?", "X"),
        (":CONT:HAND:A?;:STAT:OPER:COND?", "+1;+0"),
        (":CALC1:PAR7:DEF?", ""),
        (":SYST:ERR?", "-113,\"Undefined header\""),
    ] {
        assert_eq!(ask(10, query), expected, "{query}");
    }
    ask(20, ":TRIG:SING");
    assert_eq!(ask(20, ":STAT:OPER:COND?"), "+16");
}
