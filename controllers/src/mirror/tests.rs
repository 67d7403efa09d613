use std::collections::VecDeque;
use std::f64::consts::TAU;

use super::*;
use crate::complex::Complex;
use crate::linearise::{Probe, frequency_response};
use crate::parameter::tests::shipped_gains;

const RATE_HZ: f64 = 20_000.0;
const AXES_HZ: [f64; 2] = [322.0, 350.0];
/// Of the closed strain-gauge unit.
const DAMPING: f64 = 0.36;

fn controller(mode_hz: f64) -> MirrorController {
    MirrorController::new(&shipped_gains().mirror, mode_hz, RATE_HZ)
        .expect("modes are far below half the rate")
}

/// `ω0²/(s² + 2ζω0 s + ω0²)` behind a hold: exact by rotation and decay of its two states.
struct Mode {
    omega: f64,
    angle: f64,
    rate: f64,
}

impl Mode {
    fn new(mode_hz: f64) -> Self {
        Self { omega: TAU * mode_hz, angle: 0.0, rate: 0.0 }
    }

    fn step(&mut self, drive: f64) {
        let sigma = DAMPING * self.omega;
        let t = 1.0 / RATE_HZ;
        let damped = self.omega * (1.0 - DAMPING * DAMPING).sqrt();
        let x = self.angle - drive;
        let v = self.rate;
        let decay = (-sigma * t).exp();
        let sine = (damped * t).sin();
        let cosine = (damped * t).cos();
        self.angle = drive + decay * (x * cosine + (v + sigma * x) / damped * sine);
        self.rate = decay * (v * cosine - (self.omega * self.omega * x + sigma * v) / damped * sine);
    }
}

/// The analytic loop: `C(s)·N(s)·G(s)·e^{−sτ}`.
fn open_loop(frequency_hz: f64, mode_hz: f64, delay_s: f64) -> Complex {
    let s = Complex::new(0.0, TAU * frequency_hz);
    let omega = TAU * mode_hz;
    let second = |zeta: f64| s * s + s * (2.0 * zeta * omega) + Complex::real(omega * omega);
    let law = Complex::real(0.08) + Complex::real(500.0) / s + Complex::real(100_000.0) / (s * s);
    let notch = second(0.36) / second(1.0);
    let plant = Complex::real(omega * omega) / second(DAMPING);
    law * notch * plant * Complex::unit(-TAU * frequency_hz * delay_s)
}

/// Measured loop: the law by [`frequency_response`], the plant with a hold, run together at 20 kHz, open.
fn measured_loop(frequency_hz: f64, mode_hz: f64, delay_ticks: usize) -> Complex {
    let mut law = controller(mode_hz);
    let mut mode = Mode::new(mode_hz);
    let mut delay: VecDeque<f64> = std::iter::repeat_n(0.0, delay_ticks).collect();
    let open = |error: f64| {
        let answer = mode.angle;
        delay.push_back(law.update(error, 0.0));
        mode.step(delay.pop_front().expect("just pushed"));
        answer
    };
    let probe = Probe {
        period_s: 1.0 / RATE_HZ,
        operating_point: 0.0,
        amplitude: 1e-6,
        settle_s: 0.05,
        measure_s: 0.1,
    };
    frequency_response(open, &probe, frequency_hz).expect("finite")
}

/// Frequency where the loop's gain falls through 1, and its phase margin in degrees.
fn crossover(gain: impl Fn(f64) -> Complex) -> (f64, f64) {
    let mut low = 20.0;
    let mut high = 200.0;
    for _ in 0..30 {
        let middle = (low + high) / 2.0;
        if gain(middle).magnitude() > 1.0 { low = middle } else { high = middle }
    }
    let margin_deg = 180.0 + gain(low).phase_rad().to_degrees();
    (low, if margin_deg > 180.0 { margin_deg - 360.0 } else { margin_deg })
}

#[test]
fn law_is_pi_plus_double_integral_behind_the_notch() {
    for mode_hz in AXES_HZ {
        for frequency_hz in [5.0, 80.0, mode_hz, 1000.0] {
            let mut law = controller(mode_hz);
            let probe = Probe {
                period_s: 1.0 / RATE_HZ,
                operating_point: 0.0,
                amplitude: 1e-7,
                settle_s: 0.1,
                measure_s: 0.4,
            };
            let measured = frequency_response(|e| law.update(e, 0.0), &probe, frequency_hz).expect("finite");
            let z = Complex::unit(TAU * frequency_hz / RATE_HZ);
            let integral = z / (z - Complex::ONE) * (1.0 / RATE_HZ);
            let pi2 = Complex::real(0.08) + integral * 500.0 + integral * integral * 100_000.0;
            let x = (TAU * frequency_hz / RATE_HZ / 2.0).tan() / (TAU * mode_hz / RATE_HZ / 2.0).tan();
            let second = |zeta: f64| Complex::new(1.0 - x * x, 2.0 * zeta * x);
            let expected = pi2 * (second(0.36) / second(1.0));
            let error = (measured - expected).magnitude() / expected.magnitude();
            assert!(error < 1e-6, "{mode_hz} Hz mode at {frequency_hz} Hz: {error}");
        }
    }
}

#[test]
fn phase_margin_is_44_to_47_degrees_without_delay_and_30_to_32_with_half_a_millisecond() {
    for (mode_hz, without_deg, with_deg) in [(322.0, 44.5, 30.3), (350.0, 46.6, 32.3)] {
        for (delay_s, expected_deg) in [(0.0, without_deg), (0.5e-3, with_deg)] {
            let (_, margin_deg) = crossover(|f| open_loop(f, mode_hz, delay_s));
            assert!((margin_deg - expected_deg).abs() < 0.06, "{mode_hz} Hz {delay_s} s: {margin_deg}");
        }
    }
}

#[test]
fn sampled_loop_has_the_analytic_margin() {
    for mode_hz in AXES_HZ {
        for delay_ticks in [0, 9] {
            // The hold costs half a period; the backward Euler integrals, which rule at crossover, give it back.
            let delay_s = delay_ticks as f64 / RATE_HZ;
            let (analytic_hz, analytic_deg) = crossover(|f| open_loop(f, mode_hz, delay_s));
            let (measured_hz, measured_deg) = crossover(|f| measured_loop(f, mode_hz, delay_ticks));
            assert!((measured_hz - analytic_hz).abs() < 0.5, "{measured_hz} {analytic_hz}");
            assert!((measured_deg - analytic_deg).abs() < 0.2, "{measured_deg} {analytic_deg}");
        }
    }
}

/// Angles of the closed loop, one per tick.
fn run(
    law: &mut MirrorController,
    mode_hz: f64,
    ticks: usize,
    command: impl Fn(f64) -> f64,
) -> std::vec::Vec<f64> {
    let mut mode = Mode::new(mode_hz);
    (0..ticks)
        .map(|k| {
            let angle = mode.angle;
            mode.step(law.update(command(k as f64 / RATE_HZ), angle));
            angle
        })
        .collect()
}

fn closed_loop_db(frequency_hz: f64, mode_hz: f64) -> f64 {
    let mut law = controller(mode_hz);
    let mut mode = Mode::new(mode_hz);
    let closed = |command: f64| {
        let angle = mode.angle;
        mode.step(law.update(command, angle));
        angle
    };
    let probe = Probe {
        period_s: 1.0 / RATE_HZ,
        operating_point: 0.0,
        amplitude: 1e-5,
        settle_s: 0.2,
        measure_s: 0.2,
    };
    20.0 * frequency_response(closed, &probe, frequency_hz).expect("finite").magnitude().log10()
}

#[test]
fn closed_loop_bandwidth_is_138_hz_and_100_hz_is_not_attenuated_by_3_db() {
    for mode_hz in AXES_HZ {
        for frequency_hz in [10.0, 50.0, 80.0, 100.0, 130.0] {
            assert!(closed_loop_db(frequency_hz, mode_hz) > -3.0, "{frequency_hz} Hz");
            // Peak of the complementary sensitivity with 45° of phase margin.
            assert!(closed_loop_db(frequency_hz, mode_hz) < 3.4, "{frequency_hz} Hz");
        }
        assert!(closed_loop_db(138.0, mode_hz) > -3.3 && closed_loop_db(142.0, mode_hz) < -3.0);
    }
}

#[test]
fn ramp_is_followed_without_error_and_acceleration_with_a_over_i2() {
    for mode_hz in AXES_HZ {
        let angles = run(&mut controller(mode_hz), mode_hz, 10_000, |t| 1e-3 * t);
        assert!((angles[9999] - 1e-3 * 9999.0 / RATE_HZ).abs() < 1e-12, "{}", angles[9999]);
        let angles = run(&mut controller(mode_hz), mode_hz, 10_000, |t| 2e-3 * t * t / 2.0);
        let t = 9999.0 / RATE_HZ;
        let lag = 2e-3 * t * t / 2.0 - angles[9999];
        assert!((lag / (2e-3 / 100_000.0) - 1.0).abs() < 1e-3, "{lag}");
    }
}

#[test]
fn stroke_is_left_without_windup() {
    let mut law = controller(322.0);
    let command = |t: f64| if t < 0.5 { 3e-3 } else { 0.5e-3 };
    let angles = run(&mut law, 322.0, 11_000, command);
    assert!((angles[9999] - 1.3e-3).abs() < 1e-9, "at the drive's limit");
    // 50 ms after the command is back within reach.
    assert!((angles[10_999] - 0.5e-3).abs() < 0.02e-3, "{}", angles[10_999]);
    let undershoot = angles[10_000..].iter().fold(0.5e-3, |least: f64, angle| least.min(*angle));
    let step = run(&mut controller(322.0), 322.0, 1000, |_| 0.8e-3);
    let overshoot = step.iter().fold(0.0, |most: f64, angle| most.max(*angle)) - 0.8e-3;
    assert!(0.5e-3 - undershoot < 1.2 * overshoot, "{undershoot} {overshoot}");
}

#[test]
fn notch_off_is_equal_damping_and_raises_the_gain_at_the_mode() {
    let gains = shipped_gains().mirror;
    let off = MirrorGains { notch_numerator_damping: gains.notch_denominator_damping, ..gains };
    let mut law = MirrorController::new(&off, 322.0, RATE_HZ).expect("valid");
    let plain = 0.08 + 500.0 / RATE_HZ + 100_000.0 / RATE_HZ / RATE_HZ;
    assert!((law.update(1e-6, 0.0) - plain * 1e-6).abs() < 1e-18);
}

#[test]
fn reset_is_bumpless_and_broken_samples_are_no_error() {
    let mut law = controller(350.0);
    law.update(1e-3, 0.0);
    law.reset(0.4e-3);
    for broken in [f64::NAN, f64::INFINITY] {
        assert_eq!(law.update(broken, 0.0), 0.4e-3);
        assert_eq!(law.update(0.0, broken), 0.4e-3);
    }
    assert_eq!(law.update(0.2e-3, 0.2e-3), 0.4e-3);
}

#[test]
fn notch_above_half_the_rate_is_refused() {
    assert_eq!(MirrorController::new(&shipped_gains().mirror, 350.0, 600.0), None);
}
