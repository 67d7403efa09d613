//! The law by itself; with the velocity loop around it see `tests/loops.rs`.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use super::*;
use crate::Prediction;
use crate::complex::Complex;
use crate::linearise::{Probe, frequency_response};
use crate::parameter::tests::shipped_gains;

mod loops;

const PERIOD_S: f64 = 0.5e-3;
const ELEVATION: TrackGains = TrackGains { gain_per_s: 5.51, integral_time_s: 0.543, gyro_lead_s: 1e-3 };
const FAST: f64 = 10.0;

/// Here the plant sums its rates as the law does, so the line of sight is as old as the gyro sample: 3 ticks.
fn settings(prediction: Prediction) -> TrackSettings {
    TrackSettings { prediction, gyro_age_s: 3.0 * PERIOD_S, ..shipped_gains().track }
}

fn tracker(prediction: Prediction) -> CoarseTracker {
    CoarseTracker::new(&ELEVATION, &settings(prediction), FAST, PERIOD_S)
}

fn frame(error_rad: f64, age_s: f64) -> Option<Frame> {
    Some(Frame { error_rad: Some(error_rad), age_s })
}

/// A camera: exposes every so many ticks, delivers so many ticks later.
struct Camera {
    every: usize,
    tick: usize,
    on_the_way: VecDeque<Option<f64>>,
}

impl Camera {
    fn new(every: usize, late: usize) -> Self {
        Self { every, tick: 0, on_the_way: std::iter::repeat_n(None, late).collect() }
    }

    /// One tick: what it would see now; the frame that arrives now.
    fn update(&mut self, error_rad: f64) -> Option<Frame> {
        let age_s = self.on_the_way.len() as f64 * PERIOD_S;
        self.on_the_way.push_back(self.tick.is_multiple_of(self.every).then_some(error_rad));
        self.tick += 1;
        let arrived = self.on_the_way.pop_front().expect("just pushed")?;
        frame(arrived, age_s)
    }
}

/// Kt (1 + Ts/Tt · z/(z − 1)).
fn pi(frequency_hz: f64) -> Complex {
    let z = Complex::unit(TAU * frequency_hz * PERIOD_S);
    (Complex::ONE + z / (z - Complex::ONE) * (PERIOD_S / ELEVATION.integral_time_s)) * ELEVATION.gain_per_s
}

const PROBE: Probe =
    Probe { period_s: PERIOD_S, operating_point: 0.0, amplitude: 1e-4, settle_s: 2.0, measure_s: 8.0 };

#[test]
fn fresh_error_in_every_tick_goes_through_a_plain_pi() {
    for frequency_hz in [0.3, 1.0, 10.0, 300.0] {
        let mut law = tracker(Prediction::Off);
        let response = frequency_response(|e| law.update(frame(e, 0.0), 0.0), &PROBE, frequency_hz);
        let error = (response.expect("finite") - pi(frequency_hz)).magnitude() / pi(frequency_hz).magnitude();
        assert!(error < 1e-9, "{frequency_hz} Hz: {error}");
    }
}

/// −(1/s + Tp)-response to the true rate, the gyro 3 ticks (1.5 ms) late.
fn measured_from_rate(camera: &mut Camera, prediction: Prediction, frequency_hz: f64) -> Complex {
    let mut law = tracker(prediction);
    let mut line_of_sight_rad = 0.0;
    let mut late = VecDeque::from([0.0; 3]);
    let from_rate = |rate: f64| {
        line_of_sight_rad += rate * PERIOD_S;
        late.push_back(rate);
        let gyro = late.pop_front().expect("just pushed");
        law.update(camera.update(-line_of_sight_rad), gyro)
    };
    frequency_response(from_rate, &PROBE, frequency_hz).expect("finite")
}

#[test]
fn slow_late_camera_leaves_the_response_to_the_axis_that_of_the_gyro_alone() {
    for prediction in [Prediction::Off, Prediction::ConstantVelocity] {
        for frequency_hz in [0.3, 1.0, 5.3, 40.0] {
            let z = Complex::unit(TAU * frequency_hz * PERIOD_S);
            let gyro = Complex::unit(-TAU * frequency_hz * 3.0 * PERIOD_S);
            let angle = z / (z - Complex::ONE) * PERIOD_S + Complex::real(ELEVATION.gyro_lead_s);
            let expected = pi(frequency_hz) * angle * gyro * -1.0;
            // 50 Hz, 40 ms.
            let measured = measured_from_rate(&mut Camera::new(40, 80), prediction, frequency_hz);
            let error = (measured - expected).magnitude() / expected.magnitude();
            assert!(error < 1e-6, "{frequency_hz} Hz: {error}");
        }
    }
}

/// True errors while an axis that does what it is told follows a target.
fn errors(mut law: CoarseTracker, seconds: f64, target: impl Fn(f64) -> f64) -> std::vec::Vec<f64> {
    let mut camera = Camera::new(40, 80);
    let mut rate = 0.0;
    let mut line_of_sight_rad = 0.0;
    let mut late = VecDeque::from([0.0; 3]);
    (0..(seconds / PERIOD_S) as usize)
        .map(|k| {
            line_of_sight_rad += rate * PERIOD_S;
            late.push_back(rate);
            let error_rad = target(k as f64 * PERIOD_S) - line_of_sight_rad;
            let gyro = late.pop_front().expect("just pushed");
            rate = law.update(camera.update(error_rad), gyro);
            error_rad
        })
        .collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn with_own_lead(prediction: Prediction) -> CoarseTracker {
    let gains = TrackGains { gyro_lead_s: 2.5e-3, ..ELEVATION };
    CoarseTracker::new(&gains, &settings(prediction), FAST, PERIOD_S)
}

#[test]
fn target_rate_lags_by_latency_and_half_a_frame_without_prediction_and_not_with_it() {
    let rate = 0.674_f64.to_radians();
    // The lead on the gyro is more than the gyro's own age: 1 ms of it shows on a ramp, whole seconds after the start.
    let lead_rad = rate * 1e-3;
    let errors_rad = errors(with_own_lead(Prediction::Off), 12.0, |t| rate * t);
    let lag_rad = mean(&errors_rad[20_000..]) - lead_rad;
    assert!((lag_rad - rate * 0.05).abs() < 0.01 * rate * 0.05, "{lag_rad}");
    let errors_rad = errors(with_own_lead(Prediction::ConstantVelocity), 12.0, |t| rate * t);
    let lag_rad = mean(&errors_rad[20_000..]) - lead_rad;
    assert!(lag_rad.abs() < 1e-6, "{lag_rad}");
}

#[test]
fn rate_of_the_target_is_estimated() {
    let mut law = tracker(Prediction::ConstantVelocity);
    let mut camera = Camera::new(40, 80);
    (0..6000).for_each(|k| _ = law.update(camera.update(0.01 * f64::from(k) * PERIOD_S), 0.0));
    assert!((law.target_rate_rad_per_s() - 0.01).abs() < 1e-9);
}

#[test]
fn missing_target_is_held_with_the_integral_frozen_then_lost() {
    let mut law = tracker(Prediction::Off);
    assert_eq!(law.update(None, 0.0), 0.0);
    assert_eq!(law.state(), TrackState::Lost);
    for _ in 0..1000 {
        law.update(frame(1e-3, 0.0), 0.0);
    }
    let gone = law.update(Some(Frame { error_rad: None, age_s: 0.0 }), 0.0);
    assert_eq!(law.state(), TrackState::Holding);
    let held: std::vec::Vec<_> = (0..1200).map(|_| (law.update(None, 0.0), law.state())).collect();
    assert_eq!(held.iter().filter(|(_, state)| *state == TrackState::Holding).count(), 999, "0.5 s in all");
    assert!(held.iter().all(|(rate, state)| *rate == if *state == TrackState::Lost { 0.0 } else { gone }));
    assert_eq!(held[1199].1, TrackState::Lost);
}

#[test]
fn silent_camera_freezes_the_integral_after_the_dropout_time() {
    let mut law = tracker(Prediction::Off);
    (0..10).for_each(|_| _ = law.update(frame(1e-3, 0.0), 0.0));
    let states: std::vec::Vec<_> = (0..200)
        .map(|_| {
            let rate = law.update(None, 0.0);
            (rate, law.state())
        })
        .collect();
    assert_eq!(states[99].1, TrackState::Tracking, "50 ms");
    assert_eq!(states[100].1, TrackState::Holding);
    assert!(states[99].0 > states[50].0 && states[199].0 == states[100].0);
}

#[test]
fn target_is_taken_up_without_a_jump_and_without_overshoot() {
    for rate in [0.0, 0.012] {
        let mut law = tracker(Prediction::Off);
        law.reset(rate);
        let first = law.update(frame(5e-3, 0.0), rate);
        assert!((first - rate).abs() < 1e-12, "{first}");
        // Again after a gap, with the target elsewhere.
        let last = (0..400).map(|_| law.update(frame(4e-3, 0.0), rate)).last().expect("400 ticks");
        law.update(Some(Frame { error_rad: None, age_s: 0.0 }), rate);
        let held = law.update(None, rate);
        let again = law.update(frame(-3e-3, 0.0), rate);
        assert!((again - held).abs() < 1e-12, "{last} {held} {again}");
    }
    let errors_rad = errors(with_own_lead(Prediction::Off), 4.0, |_| 5e-3);
    let least_rad = errors_rad.iter().fold(5e-3, |least: f64, error| least.min(*error));
    assert!(least_rad > -0.05 * 5e-3, "{least_rad}");
    assert!(errors_rad[7999].abs() < 0.01 * 5e-3);
}

#[test]
fn limited_rate_does_not_wind_up() {
    let mut law = CoarseTracker::new(&ELEVATION, &settings(Prediction::Off), 0.1, PERIOD_S);
    law.update(frame(0.0, 0.0), 0.0);
    for _ in 0..20_000 {
        assert!(law.update(frame(0.2, 0.0), 0.0) <= 0.1);
    }
    assert!(law.update(frame(0.01, 0.0), 0.0) < 0.1 + 1e-12);
    assert!(law.update(frame(-0.01, 0.0), 0.0) < 0.05);
}

#[test]
fn faded_integral_stands() {
    let mut law = tracker(Prediction::Off);
    law.update(frame(1e-3, 0.0), 0.0);
    law.fade_integral(0.0);
    let first = law.update(frame(1e-3, 0.0), 0.0);
    let last = (0..1000).map(|_| law.update(frame(1e-3, 0.0), 0.0)).last();
    assert_eq!(last, Some(first));
    law.fade_integral(1.0);
    assert!(law.update(frame(1e-3, 0.0), 0.0) > first);
}

#[test]
fn frame_older_than_the_history_or_than_the_last_one_is_no_measurement() {
    let mut law = tracker(Prediction::Off);
    (0..1000).for_each(|_| _ = law.update(None, 0.0));
    law.update(frame(1e-3, 0.3), 0.0);
    assert_eq!(law.state(), TrackState::Lost);
    law.update(frame(1e-3, 0.25), 0.0);
    assert_eq!(law.state(), TrackState::Tracking);
    law.update(frame(1e-3, 0.256), 0.0);
    assert_eq!(law.state(), TrackState::Holding);
}

#[test]
fn broken_samples_move_nothing() {
    let mut law = tracker(Prediction::ConstantVelocity);
    (0..10).for_each(|_| _ = law.update(frame(0.0, 0.0), 0.0));
    for broken in [f64::NAN, f64::INFINITY] {
        assert_eq!(law.update(None, broken), 0.0);
        assert_eq!(law.update(frame(broken, 0.0), 0.0), 0.0);
        assert_eq!(law.update(frame(0.0, broken), 0.0), 0.0);
        assert_eq!(law.update(frame(0.0, -1.0), 0.0), 0.0);
    }
    assert!(law.update(frame(0.0, 0.0), 0.0).abs() < 1e-15);
}
