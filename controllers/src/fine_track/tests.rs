use std::collections::VecDeque;
use std::f64::consts::TAU;

use super::*;
use crate::complex::Complex;
use crate::linearise::{Probe, frequency_response};
use crate::parameter::tests::shipped_gains;

/// Of the simulation.
const STEP_S: f64 = 0.1e-3;
/// From light to mirror, half a frame of hold apart or not: see the tests.
const TOTAL_DELAY_S: f64 = 11e-3;

fn gains() -> FineTrackGains {
    shipped_gains().fine
}

/// What is left of a disturbance: a camera that takes a frame every `frame` steps, the mirror `delay` steps later.
struct SampledLoop {
    tracker: FineTracker,
    optical_gain: f64,
    frame: usize,
    tick: usize,
    on_the_way: VecDeque<Option<Frame>>,
    mirror_rad: f64,
}

impl SampledLoop {
    fn new(frame_rate_hz: f64, delay_s: f64, optical_gain: f64) -> Self {
        let frame_s = 1.0 / frame_rate_hz;
        let stroke = FineTrackGains { stroke_rad: 1.0, ..gains() };
        Self {
            tracker: FineTracker::new(&stroke, optical_gain, frame_s, STEP_S),
            optical_gain,
            frame: (frame_s / STEP_S).round() as usize,
            tick: 0,
            on_the_way: std::iter::repeat_n(None, (delay_s / STEP_S).round() as usize).collect(),
            mirror_rad: 0.0,
        }
    }

    /// One step: the line of sight's disturbance in, the residual out.
    fn step(&mut self, disturbance_rad: f64) -> f64 {
        let frame = self.on_the_way.pop_front().expect("as many as the delay has steps");
        self.mirror_rad = self.tracker.update(frame);
        let residual_rad = disturbance_rad - self.mirror_rad / self.optical_gain;
        let exposed = self.tick.is_multiple_of(self.frame);
        self.on_the_way
            .push_back(exposed.then_some(Frame { error_rad: Some(residual_rad), age_s: TOTAL_DELAY_S }));
        self.tick += 1;
        residual_rad
    }
}

/// Error rejection 1/(1 + L) in dB at a frequency, measured on the sampled loop between the frames, too.
fn rejection_db(frame_rate_hz: f64, delay_s: f64, frequency_hz: f64) -> f64 {
    let mut sampled = SampledLoop::new(frame_rate_hz, delay_s, 2.5);
    let probe =
        Probe { period_s: STEP_S, operating_point: 0.0, amplitude: 1e-6, settle_s: 1.0, measure_s: 5.0 };
    let response = frequency_response(|d| sampled.step(d), &probe, frequency_hz).expect("finite");
    20.0 * response.magnitude().log10()
}

/// Frequency above which disturbances are amplified.
fn zero_db_hz(frame_rate_hz: f64, delay_s: f64) -> f64 {
    let mut low = 4.0;
    let mut high = 12.0;
    for _ in 0..12 {
        let middle = (low + high) / 2.0;
        if rejection_db(frame_rate_hz, delay_s, middle) < 0.0 { low = middle } else { high = middle }
    }
    low
}

/// Rejection of the sampled loop by its exact series: the camera samples `E*`, the mirror holds.
fn exact_rejection_db(frame_rate_hz: f64, delay_s: f64, frequency_hz: f64) -> f64 {
    let frame_s = 1.0 / frame_rate_hz;
    let omega = TAU * frequency_hz;
    let z = Complex::unit(omega * frame_s);
    let frames_late = (delay_s / frame_s - 1e-9).ceil();
    let integral = z / (z - Complex::ONE) * (gains().gain_per_s * frame_s);
    let sampled = Complex::ONE / (Complex::ONE + integral * Complex::unit(-omega * frame_s * frames_late));
    let hold = (Complex::ONE - Complex::unit(-omega * frame_s)) / Complex::new(0.0, omega * frame_s);
    let seen = Complex::ONE - hold * Complex::unit(-omega * delay_s) * integral * sampled;
    20.0 * seen.magnitude().log10()
}

#[test]
fn sampled_loop_runs_as_its_exact_series_says() {
    for (frame_rate_hz, delay_s) in [(200.0, 8.5e-3), (200.0, 11e-3), (100.0, 6e-3), (100.0, 11e-3)] {
        for frequency_hz in [1.0, 3.0, 7.0, 13.0, 23.0] {
            let measured_db = rejection_db(frame_rate_hz, delay_s, frequency_hz);
            let exact_db = exact_rejection_db(frame_rate_hz, delay_s, frequency_hz);
            // The simulation's step of 0.1 ms holds what is continuous in the series.
            assert!((measured_db - exact_db).abs() < 0.05, "{frequency_hz} Hz: {measured_db} {exact_db}");
        }
    }
}

#[test]
fn error_rejection_crosses_0_db_above_7_6_hz_with_11_ms_in_all() {
    // 11 ms with the hold's half frame, and on top of them.
    for (frame_rate_hz, delay_s, expected_hz) in [
        (200.0, TOTAL_DELAY_S - 2.5e-3, 8.65),
        (200.0, TOTAL_DELAY_S, 7.62),
        (100.0, TOTAL_DELAY_S - 5e-3, 10.37),
        (100.0, TOTAL_DELAY_S, 7.55),
    ] {
        let crossing_hz = zero_db_hz(frame_rate_hz, delay_s);
        assert!((crossing_hz - expected_hz).abs() < 0.05, "{frame_rate_hz} Hz {delay_s} s: {crossing_hz}");
    }
}

#[test]
fn rejection_holds_15_db_at_1_hz_and_6_db_at_3_hz_and_amplifies_by_less_than_6_db() {
    for frame_rate_hz in [100.0, 200.0] {
        for delay_s in [TOTAL_DELAY_S - 0.5 / frame_rate_hz, TOTAL_DELAY_S] {
            assert!(rejection_db(frame_rate_hz, delay_s, 1.0) < -17.0);
            assert!(rejection_db(frame_rate_hz, delay_s, 3.0) < -7.5);
            for frequency_hz in [10.0, 12.0, 14.0, 16.0, 18.0, 20.0, 22.0, 24.0, 26.0, 30.0, 40.0] {
                let amplified_db = exact_rejection_db(frame_rate_hz, delay_s, frequency_hz);
                assert!(amplified_db < 5.8, "{frame_rate_hz} Hz at {frequency_hz} Hz: {amplified_db}");
            }
        }
    }
}

#[test]
fn mirror_turns_by_the_optical_gain_with_its_sign() {
    for optical_gain in [2.5, 3.535_533_9, -2.5] {
        let mut sampled = SampledLoop::new(200.0, 8.5e-3, optical_gain);
        let left_rad = (0..20_000).map(|_| sampled.step(20e-6)).last().expect("20 000 steps");
        assert!(left_rad.abs() < 1e-12);
        assert!((sampled.mirror_rad - optical_gain * 20e-6).abs() < 1e-12);
    }
}

#[test]
fn wrong_sign_of_the_optical_gain_runs_away_to_the_stroke() {
    let mut sampled = SampledLoop::new(200.0, 8.5e-3, 2.5);
    sampled.optical_gain = -2.5;
    (0..20_000).for_each(|_| _ = sampled.step(20e-6));
    assert!(sampled.tracker.is_saturated());
}

const FRAME_S: f64 = 5e-3;

fn frame(error_rad: f64) -> Option<Frame> {
    Some(Frame { error_rad: Some(error_rad), age_s: 7.5e-3 })
}

fn tracker() -> FineTracker {
    FineTracker::new(&gains(), 2.5, FRAME_S, STEP_S)
}

#[test]
fn command_stays_at_the_stroke_and_leaves_it_at_once() {
    let mut tracker = tracker();
    for _ in 0..1000 {
        assert!(tracker.update(frame(1e-3)) <= gains().stroke_rad);
    }
    assert!(tracker.is_saturated());
    let expected = gains().stroke_rad - 2.5 * 48.0 * FRAME_S * 10e-6;
    assert!((tracker.update(frame(-10e-6)) - expected).abs() < 1e-15);
}

#[test]
fn lost_target_is_held_then_the_mirror_goes_home_without_a_jump() {
    let mut tracker = tracker();
    let mut last_rad = tracker.update(frame(1e-3));
    let held_rad = last_rad;
    assert_eq!(tracker.state(), TrackState::Tracking);
    let mut states = std::vec::Vec::new();
    for _ in 0..6000 {
        let command_rad = tracker.update(None);
        assert!((command_rad - last_rad).abs() <= 5e-3 * STEP_S + 1e-15, "return rate");
        last_rad = command_rad;
        states.push(tracker.state());
        assert!(states.last() == Some(&TrackState::Lost) || command_rad == held_rad);
    }
    assert_eq!(states.iter().filter(|s| **s == TrackState::Tracking).count(), 300, "30 ms");
    assert_eq!(states.iter().filter(|s| **s == TrackState::Holding).count(), 1700, "to 200 ms");
    assert_eq!(last_rad, 0.0);
    assert_eq!(tracker.update(frame(0.0)), 0.0);
    assert_eq!(tracker.state(), TrackState::Tracking);
}

#[test]
fn broken_frame_is_one_without_a_target() {
    let mut tracker = tracker();
    let before = tracker.update(frame(1e-5));
    assert_eq!(tracker.update(frame(f64::NAN)), before);
    assert_eq!(tracker.state(), TrackState::Holding);
    tracker.reset(f64::NAN);
    assert_eq!(tracker.update(None), 0.0);
}
