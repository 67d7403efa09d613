//! A mirror and a fine tracker before a target that the air moves, stepped in time, and what they leave in the log.

use std::f64::consts::TAU;

use super::*;
use crate::kinds::Experiment;
use crate::kinds::position::positioned::tests::with_elevation;
use crate::log::{EndedBy, SegmentSpan};
use crate::measurement::{Conclusion, PointResult};
use crate::synthetic::{Random, rows};

/// Step of the scene: that of the loop.
pub(in crate::kinds) const STEP_S: f64 = 250e-6;

/// What the scene declares of the delay of its messages.
pub(in crate::kinds) const DECLARED_U_S: f64 = 0.2e-3;
const FINE_CHANNELS: [&str; 8] = [
    READINGS[0],
    READINGS[1],
    "age_s",
    "counter",
    "lock",
    "exposure_u_s",
    "message_delay_u_s",
    "clock_drift_ratio",
];

/// What stands between the mirror and the log; pairs are azimuth, elevation.
#[derive(Clone, Debug)]
pub(in crate::kinds) struct Scene {
    /// Mirror angle per angle of the line of sight, as it is, and as the fine loop believes.
    pub(in crate::kinds) gains: [f64; 2],
    pub(in crate::kinds) believed: [f64; 2],
    /// Integrator of the fine loop.
    pub(in crate::kinds) gain_per_s: f64,
    pub(in crate::kinds) latency_s: f64,
    pub(in crate::kinds) mirror_delay_s: f64,
    /// Frame rate instead of the one that the point asks for.
    pub(in crate::kinds) frame_rate_hz: Option<f64>,
    /// Added to the exposures that the tracker states.
    pub(in crate::kinds) stamp_s: f64,
    /// Root mean square of the tip-tilt, and of the tracker's own noise in each frame.
    pub(in crate::kinds) tilt_rad: f64,
    pub(in crate::kinds) noise_rad: f64,
    /// Where the target stands off.
    pub(in crate::kinds) offset_rad: f64,
    /// Every so many frames one is lost; 0 for none.
    pub(in crate::kinds) loses_every: u32,
    /// Share of the command that is carried out.
    pub(in crate::kinds) commanded_ratio: f64,
    /// Steps from row to row.
    pub(in crate::kinds) row_steps: usize,
    pub(in crate::kinds) seed: u64,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            gains: [3.5355, 2.5],
            believed: [3.5355, 2.5],
            gain_per_s: 48.0,
            latency_s: 7.5e-3,
            mirror_delay_s: 0.75e-3,
            frame_rate_hz: None,
            stamp_s: 0.0,
            tilt_rad: 1e-6,
            noise_rad: 0.3e-6,
            offset_rad: 5e-6,
            loses_every: 0,
            commanded_ratio: 1.0,
            row_steps: 4,
            seed: 1,
        }
    }
}

/// Two low-passes of 3 and 30 Hz behind one another: nothing of it folds at 100 Hz.
#[derive(Clone, Copy, Default)]
struct Air([f64; 2]);

impl Air {
    fn step(&mut self, white: f64) -> f64 {
        for (state, corner_hz) in self.0.iter_mut().zip([3.0, 30.0]) {
            let share = 1.0 - (-TAU * corner_hz * STEP_S).exp();
            let input = if corner_hz < 10.0 { white / (0.5 * share).sqrt() } else { 0.0 };
            *state += share * (input - *state);
        }
        self.0[1] += (1.0 - (-TAU * 30.0 * STEP_S).exp()) * self.0[0];
        self.0[1]
    }
}

/// What happens from step to step.
#[derive(Default)]
struct State {
    command: [f64; 2],
    /// Commands on their way.
    sent: Vec<[f64; 2]>,
    /// Frames on their way: step of arrival, exposure, readings, number.
    frames: Vec<(usize, f64, [f64; 2], u32)>,
    newest: (f64, [f64; 2], u32),
    counter: u32,
}

impl Scene {
    /// What an experiment on azimuth concludes from a run of each of its cases.
    pub(in crate::kinds) fn conclusion(&self, experiment: &impl Experiment) -> Conclusion {
        let axes = with_elevation();
        let cases = experiment.plan("az", &axes).expect("the axis is there");
        let points: Vec<PointResult> =
            cases.iter().map(|case| experiment.analyse(case, &self.run(case), &axes)).collect();
        experiment.conclude(&cases, &points, &axes)
    }

    /// What a run of a case leaves.
    pub(in crate::kinds) fn run(&self, case: &Case) -> Window {
        let seed = self.seed + case.point.bytes().map(u64::from).sum::<u64>() * 1000;
        let mut normal = Random::new(seed);
        let mut air = [Air::default(); 2];
        let rate_hz = self.frame_rate_hz.or(case.fine_frame_rate_hz).unwrap_or(200.0);
        let frame_steps = (1.0 / rate_hz / STEP_S).round() as usize;
        let delay = (self.mirror_delay_s / STEP_S).round() as usize;
        let mut state = State { sent: vec![[0.0; 2]; delay + 1], ..State::default() };
        let mut time_s = Vec::new();
        let mut mirror = vec![vec![]; 4];
        let mut fine = vec![vec![]; 8];
        let mut segments = Vec::new();
        let mut step = 0_usize;
        for (index, segment) in case.segments.iter().enumerate() {
            let start = step;
            let steps = (segment.at_most_s / STEP_S).round() as usize;
            for k in 0..steps {
                let tilt = air.each_mut().map(|air| self.tilt_rad * air.step(normal.normal()));
                let excitation = segment.excited.map(|e| &case.excitations[e]);
                if let Some(excitation) = excitation {
                    let value = excitation.at(k as f64 * STEP_S);
                    state.command[usize::from(excitation.into == Injection::MirrorEl)] =
                        self.commanded_ratio * value;
                }
                let angle = state.sent[0];
                if step % frame_steps == 3 {
                    let read = [0, 1].map(|axis| {
                        let noise = self.noise_rad * normal.normal();
                        self.offset_rad + tilt[axis] - angle[axis] / self.gains[axis] + noise
                    });
                    self.expose(&mut state, step, read);
                }
                self.receive(&mut state, step, segment.is_fine(), 1.0 / rate_hz);
                state.sent.remove(0);
                state.sent.push(state.command);
                if step.is_multiple_of(self.row_steps) {
                    let now_s = step as f64 * STEP_S;
                    time_s.push(now_s);
                    let row = [state.command[0], state.command[1], angle[0], angle[1]];
                    mirror.iter_mut().zip(row).for_each(|(c, v): (&mut Vec<f64>, f64)| c.push(v));
                    let (exposure_s, read, counter) = state.newest;
                    let lock = if counter > 0 { 2.0 } else { 0.0 };
                    let told = [0.0, DECLARED_U_S, 0.0];
                    let row = [read[0], read[1], now_s - exposure_s, f64::from(counter), lock];
                    let row = row.into_iter().chain(told);
                    fine.iter_mut().zip(row).for_each(|(c, v): (&mut Vec<f64>, f64)| c.push(v));
                }
                step += 1;
            }
            let [start_s, end_s] = [start, step].map(|k| k as f64 * STEP_S);
            let ended_by = EndedBy::Completed;
            segments.push(SegmentSpan { segment: index, start_s, end_s, start_position_rad: 0.0, ended_by });
        }
        let names = ["command_az_rad", "command_el_rad", "angle_az_rad", "angle_el_rad"];
        let track = vec![vec![0.0; time_s.len()]; 2];
        let topics = vec![
            rows(MIRROR_TOPIC, &time_s, names.iter().copied().zip(mirror).collect()),
            rows(FINE_TOPIC, &time_s, FINE_CHANNELS.iter().copied().zip(fine).collect()),
            rows("/track", &time_s, ["az_saturated", "el_saturated"].iter().copied().zip(track).collect()),
        ];
        Window::completed(topics, segments)
    }

    fn expose(&self, state: &mut State, step: usize, read: [f64; 2]) {
        state.counter += 1;
        let lost = self.loses_every > 0 && state.counter.is_multiple_of(self.loses_every);
        if !lost {
            let arrives = step + (self.latency_s / STEP_S).round() as usize;
            let stated_s = step as f64 * STEP_S + self.stamp_s;
            state.frames.push((arrives, stated_s, read, state.counter));
        }
    }

    fn receive(&self, state: &mut State, step: usize, is_fine: bool, frame_s: f64) {
        if state.frames.first().is_none_or(|frame| frame.0 > step) {
            return;
        }
        let (_, exposure_s, read, counter) = state.frames.remove(0);
        state.newest = (exposure_s, read, counter);
        if is_fine {
            for (axis, error) in read.into_iter().enumerate() {
                state.command[axis] += self.believed[axis] * self.gain_per_s * frame_s * error;
            }
        }
    }
}

fn ramp() -> Course<'static> {
    Course { time_s: &[0.0, 1.0, 3.0], values: &[0.0, 2.0, 2.0] }
}

#[test]
fn a_course_runs_straight_between_its_rows_and_its_mean_is_that_of_its_lines() {
    assert_eq!(ramp().at(0.25), Some(0.5));
    assert_eq!((ramp().at(-1.0), ramp().at(9.0)), (Some(0.0), Some(2.0)));
    // Area of the triangle from 0.5 to 1: mean 1.5; then 2.
    let mean = ramp().mean(0.5, 2.0).expect("rows");
    assert!((mean - (0.5 * 1.5 + 2.0) / 1.5).abs() < 1e-12, "{mean}");
    assert_eq!(Course { time_s: &[], values: &[] }.at(1.0), None);
}

#[test]
fn frames_are_taken_once_with_their_exposures_and_what_was_lost_is_counted() {
    let hold = crate::case::Segment::hold("a", crate::case::Mode::Position, 2.0);
    let case = Case { segments: vec![hold], fine_frame_rate_hz: Some(100.0), ..Case::default() };
    let scene = Scene { loses_every: 4, ..Scene::default() };
    let log = scene.run(&case);
    let frames = Frames::read(&log, FINE_TOPIC, 0.0, 2.0).expect("frames");
    assert!((frames.rate_hz - 100.0).abs() < 1e-6 && frames.check_rate(100.0).is_ok());
    assert!((frames.lost_ratio() - 0.25).abs() < 0.01, "{}", frames.lost_ratio());
    let age_s = frames.received_s[7] - frames.exposure_s[7];
    assert!((7.5e-3..8.5e-3 + 1e-9).contains(&age_s), "{age_s}");
    let wrong = frames.check_rate(200.0).expect_err("the camera is set wrongly");
    assert!(wrong.to_string().contains("100.0 frames/s, expected 200.0"), "{wrong}");
}

#[test]
fn a_log_without_frames_or_channels_says_which() {
    let empty = Window::completed(Vec::new(), Vec::new());
    let told = Frames::read(&empty, FINE_TOPIC, 0.0, 1.0).expect_err("nothing there");
    assert!(told.to_string().contains("no topic /fine"), "{told}");
    let named = Window::completed(vec![rows(FINE_TOPIC, &[0.0], vec![("counter", vec![0.0])])], Vec::new());
    let told = Frames::read(&named, FINE_TOPIC, 0.0, 1.0).expect_err("no age");
    assert!(told.to_string().contains("no channel age_s"), "{told}");
    let hold = crate::case::Segment::hold("a", crate::case::Mode::Position, 0.05);
    let few = Scene::default().run(&Case { segments: vec![hold], ..Case::default() });
    let told = Frames::read(&few, FINE_TOPIC, 0.0, 0.05).expect_err("too few");
    assert!(told.to_string().contains("at least 20 are needed"), "{told}");
}
