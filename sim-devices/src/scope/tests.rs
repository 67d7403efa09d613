use drivers::device::DeviceError;
use drivers::scope::{Capture, Scope as Driver, ScopeSettings};
use drivers::scpi::Instrument;
use drivers::wire::ByteLine;

use super::*;

const STEP: Duration = Duration::from_micros(50);
const BANDWIDTH_HZ: f64 = 1000.0;

/// The instrument as a line, and a current loop that it looks at.
struct Line {
    scope: Scope,
    steps: u32,
    current: crate::physics::current_loop::CurrentLoop,
    command_a: f64,
}

impl Line {
    fn new(unit: &UnitSettings) -> Self {
        let address = SeedAddress { seed: 1, procedure: "P".into(), point: "1".into() };
        let current = crate::physics::current_loop::CurrentLoop::new(BANDWIDTH_HZ, 50e-6);
        Self { scope: Scope::new(unit, &address), steps: 0, current, command_a: 0.0 }
    }

    fn advance(&mut self, now: Duration) {
        while (self.steps + 1) * STEP <= now {
            self.current.step(self.command_a);
            let step = u64::from(self.steps);
            if self.scope.observes() {
                self.scope.observe(step, [self.current.lag(), Lag::default()]);
            }
            self.steps += 1;
        }
    }
}

impl ByteLine for Line {
    fn name(&self) -> &str {
        "scope line"
    }

    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        self.advance(now);
        Ok(self.scope.take(now, into))
    }

    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        self.advance(now);
        self.scope.receive(now, bytes);
        Ok(())
    }
}

fn unit() -> UnitSettings {
    let mut unit = UnitSettings::default();
    unit.az.current_bandwidth_hz = BANDWIDTH_HZ;
    unit
}

/// Takes a record of a current step of `step_a` that begins `late` after the edge; its rows.
fn taken(
    unit: &UnitSettings,
    range_a: f64,
    step_a: f64,
    late: Duration,
) -> Result<Vec<[f64; 3]>, DeviceError> {
    let mut line = Line::new(unit);
    let mut driver = Driver::new(ScopeSettings {
        name: "scope".into(),
        current_channels: [1, 3],
        sync_channel: 2,
        current_range_a: range_a,
        reply_timeout_s: 1.0,
    })?;
    driver.prepare(&Capture { axis: 0, sample_rate_hz: 200e3, duration_s: 9e-3 })?;
    driver.start(&mut line, Duration::ZERO)?;
    let mut edge = None;
    for tick in 0..4000 {
        let now = tick * Duration::from_micros(250);
        line.advance(now);
        if driver.poll(&mut line, now)? {
            return Ok((0..driver.samples_count()).filter_map(|k| driver.row(k)).collect());
        }
        if driver.is_armed() && edge.is_none() {
            edge = Some(now);
            line.scope.sync(now, 5.0);
        }
        if edge.is_some_and(|edge| now >= edge + late) {
            line.command_a = step_a;
        }
    }
    panic!("it never ends")
}

#[test]
fn a_current_step_is_seen_as_the_exponential_that_it_is_at_a_rate_of_its_own() {
    let late = Duration::from_millis(2);
    let rows = taken(&unit(), 20.0, 10.0, late).expect("a healthy instrument");
    let probe = |a: f64| 1.01 * a + 0.02;
    let mut squares = 0.0;
    for [time_s, current_a, sync_v] in &rows {
        let since_s = time_s - late.as_secs_f64();
        let rising = 1.0 - (-std::f64::consts::TAU * BANDWIDTH_HZ * since_s).exp();
        let expected = probe(if since_s > 0.0 { 10.0 * rising } else { 0.0 });
        squares += (current_a - expected).powi(2) / rows.len() as f64;
        let level = if *time_s >= 0.0 { 5.0 } else { 0.0 };
        assert!((sync_v - level).abs() < 0.05, "{sync_v} V at {time_s} s");
    }
    // Probe 20 mA, converter 0.03 % of 40 A, steps of 40 A/4096.
    let noise_a = (0.02_f64.powi(2) + 0.012_f64.powi(2) + (40.0 / 4096.0_f64).powi(2) / 12.0).sqrt();
    assert!((squares.sqrt() / noise_a - 1.0).abs() < 0.1, "{} A, expected {noise_a} A", squares.sqrt());
    assert_eq!(rows.len(), 2000, "10 ms at 200 kHz");
    assert!((rows[0][0] + 1e-3).abs() < 6e-6, "a ninth of the record lies before: {}", rows[0][0]);
}

#[test]
fn a_current_off_the_screen_is_an_overload() {
    let error = taken(&unit(), 5.0, 10.0, Duration::ZERO).expect_err("10 A on 5 A").to_string();
    assert!(error.contains("off the screen"), "{error}");
}

#[test]
fn without_an_edge_it_runs_until_it_is_stopped() {
    let mut line = Line::new(&unit());
    line.scope.receive(Duration::ZERO, b":TRIG:EDGE:SOUR CHAN2;LEV 1;:SING\n");
    line.scope.sync(Duration::ZERO, 5.0);
    assert!(
        line.scope.record.as_ref().is_some_and(|r| r.runs(Duration::from_secs(9))),
        "the edge came too early"
    );
    line.scope.receive(Duration::from_secs(9), b":STOP\n:WAV:PRE?\n:SYST:ERR?\n");
    let mut into = [0; 100];
    let count = line.scope.take(Duration::from_secs(10), &mut into);
    assert_eq!(&into[..count], b"-221,\"Settings conflict\"\n");
}

/// What the instrument answers to a message, read a millisecond later.
fn answered(line: &mut Line, at_ms: u64, message: &str) -> String {
    let at = Duration::from_millis(at_ms);
    line.write(at, format!("{message}\n").as_bytes()).expect("a line");
    let mut into = [0; 256];
    let count = line.read(at + Duration::from_millis(1), &mut into).expect("a line");
    String::from_utf8_lossy(&into[..count]).trim_end().to_owned()
}

#[test]
fn what_was_set_is_answered_in_short_forms() {
    let mut line = Line::new(&UnitSettings::default());
    answered(
        &mut line,
        1,
        ":CHAN3:SCAL 12.5;UNIT AMP;DISP 1;:TRIG:EDGE:SOUR CHAN2;:TIM:RANG 2E-3;REF LEFT;:WAV:FORM WORD",
    );
    for (query, expected) in [
        (":CHAN3:SCAL?;UNIT?;DISP?", "+1.250E+01;AMP;1"),
        (":TRIG:EDGE:SOUR?", "CHAN2"),
        (":TIM:RANG?;REF?", "+2.000E-03;LEFT"),
        (":WAV:FORM?;POIN?", "WORD;+1000"),
        (":CHAN5:SCAL?", ""),
        (":SYST:ERR?", "-113,\"Undefined header\""),
    ] {
        assert_eq!(answered(&mut line, 10, query), expected, "{query}");
    }
}

#[test]
fn a_forced_trigger_ends_a_record_without_an_edge() {
    let mut line = Line::new(&UnitSettings::default());
    answered(&mut line, 1, "*RST;:TIM:RANG 1E-3;:SING");
    assert_eq!(answered(&mut line, 10, ":OPER:COND?"), "+8");
    answered(&mut line, 20, ":TRIG:FORC");
    assert_eq!(answered(&mut line, 30, ":OPER:COND?"), "+0");
    assert_eq!(answered(&mut line, 40, ":SYST:ERR?"), "+0,\"No error\"");
}
