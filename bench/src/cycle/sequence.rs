//! The sequencer: what the loop does in each tick, from SAFE-OP to the end of a point.
//!
//! Enabling, homing, moving, holding, asking, parking, disabling and stopping are states inside the tick, all under the
//! interlocks.

use std::sync::Arc;
use std::time::Duration;

use drivers::device::DeviceError;
use procedures::case::{Case, Mode, Segment, Then};
use procedures::excitation::Injection;
use procedures::log::EndedBy;
use procedures::stimulus::Stimulus;

use crate::cycle::axis_loop::AxisLoop;
use crate::cycle::prompt::Question;
use crate::cycle::recorder::LoopEvent;
use crate::rig::ArmedRig;

mod command;
mod playback;
mod power_up;
mod segment;
mod state;
mod tracks;
mod wind_down;

use playback::Playback;
pub(crate) use power_up::HOMED_RAD;
use segment::{Along, Running};
pub use state::State;
use tracks::After;

/// The sequencer of one point.
pub struct Sequencer<'c> {
    case: &'c Case,
    point: usize,
    moving: usize,
    questions: Arc<[Question]>,
    /// Whether the axes are parked after this point, where the rig says so.
    parks: bool,
    state: State<'c>,
    since: Duration,
    /// Time spent in states that no plan can know: homing, questions, parking.
    off_plan_s: f64,
    cools: bool,
    refused: bool,
    /// Axes that are left without torque; decided once, so that nothing enables them again.
    releases: Vec<bool>,
    /// Speeds at which an ordered stop began.
    stop_begun_rad_per_s: Vec<f64>,
    /// Longest time that it may take under control.
    stop_limit_s: f64,
    loops: Vec<AxisLoop>,
    playbacks: Vec<Playback<'c>>,
    /// What is added in this tick, and where.
    excitation: Option<(Injection, f64)>,
    /// What the coarse tracker asks for in this tick: azimuth, elevation.
    tracked_rad_per_s: [f64; 2],
    /// Axes that are being brought to rest between two segments.
    arrests: Vec<bool>,
    /// Axis that moved along in the last segment.
    companion: Option<usize>,
}

/// What a sequencer needs to know of its point.
pub struct PointOrder<'c> {
    /// The plan.
    pub case: &'c Case,
    /// Index of the point in its procedure.
    pub point: usize,
    /// Index of the axis that the case moves.
    pub moving: usize,
    /// What the operator is asked.
    pub questions: Arc<[Question]>,
    /// Whether the axes are parked afterwards.
    pub parks: bool,
    /// Ticks per second.
    pub loop_rate_hz: f64,
}

impl<'c> Sequencer<'c> {
    /// A sequencer for a point; [`Sequencer::begin`] must be called before its first step.
    pub fn new(order: PointOrder<'c>, loops: Vec<AxisLoop>) -> Self {
        let PointOrder { case, point, moving, questions, parks, loop_rate_hz } = order;
        Self {
            case,
            point,
            moving,
            questions,
            parks,
            state: State::SafeOp,
            since: Duration::ZERO,
            off_plan_s: 0.0,
            cools: false,
            refused: false,
            releases: vec![false; loops.len()],
            arrests: vec![false; loops.len()],
            tracked_rad_per_s: [0.0; 2],
            stop_begun_rad_per_s: vec![0.0; loops.len()],
            stop_limit_s: 0.0,
            loops,
            playbacks: case.excitations.iter().map(|e| Playback::new(e, loop_rate_hz)).collect(),
            excitation: None,
            companion: None,
        }
    }

    /// The first tick is due at `start`.
    pub fn begin(&mut self, start: Duration) {
        self.since = start;
    }

    /// Where it is.
    pub fn state(&self) -> &State<'c> {
        &self.state
    }

    /// The axis' loop, for recording its setpoints.
    pub fn axis_loop(&self, axis: usize) -> &AxisLoop {
        &self.loops[axis]
    }

    /// The segment that runs, if something is added to its commands.
    pub fn excited_segment(&self) -> Option<usize> {
        match &self.state {
            State::Running(running) => running.segment.excited.map(|_| running.index),
            _ => None,
        }
    }

    /// Whether the drives must be in operation now.
    pub fn expects_operation(&self) -> bool {
        self.state.is_powered()
    }

    /// Whether a segment runs.
    pub fn runs_segment(&self) -> bool {
        matches!(self.state, State::Running(_))
    }

    /// Whether the point ran to its end, or was stopped as ordered.
    pub fn finished(&self) -> bool {
        matches!(self.state, State::Finished)
    }

    /// Whether no valid inputs have come yet.
    pub fn waits_for_inputs(&self) -> bool {
        matches!(self.state, State::SafeOp)
    }

    /// Whether inputs are valid and nothing can have moved yet: the time for gates.
    pub fn before_motion(&self) -> bool {
        matches!(self.state, State::OpRequest)
    }

    /// Keeps the point where it is before motion, or lets it go on.
    pub fn cool(&mut self, waits: bool, now: Duration) {
        if waits {
            self.off_plan_s += self.waited_s(now);
            self.since = now;
        }
        self.cools = waits;
    }

    /// Whether the operator said no.
    pub fn refused(&self) -> bool {
        self.refused
    }

    /// Time spent in cooling down, homing, questions and parking so far.
    pub fn off_plan_s(&self, now: Duration) -> f64 {
        let here_s = if self.state.is_off_plan() { (now - self.since).as_secs_f64() } else { 0.0 };
        self.off_plan_s + here_s
    }

    /// Position reference less position of an axis whose position loop is closed.
    pub fn following_error_rad(&self, axis: usize) -> Option<f64> {
        let closed = self.expects_operation() && !self.case.open_loop;
        closed.then(|| self.loops[axis].following_error_rad()).flatten()
    }

    /// Whether the velocity loops are closed on the gyro now: a stop is closed on the encoder.
    pub fn uses_feedback(&self) -> bool {
        self.expects_operation() && !self.case.open_loop && !matches!(self.state, State::Stopping)
    }

    /// Leaves at once: `make_safe` quick-stops.
    pub fn abandon(&mut self) {
        self.state = State::Finished;
    }

    /// Orders a controlled stop: the axes decelerate as fast as they may. Where nothing moves under control, it is over
    /// and `make_safe` does the rest.
    pub fn stop(
        &mut self,
        now: Duration,
        rig: &ArmedRig,
        deceleration: impl Fn(usize) -> f64,
    ) -> Option<LoopEvent> {
        let ended = match &self.state {
            State::Running(running) => Some(LoopEvent::SegmentEnded {
                point: self.point,
                segment: running.index,
                by: EndedBy::Stopped,
            }),
            _ => None,
        };
        if !self.expects_operation() || self.case.open_loop {
            self.go(State::Finished, now);
            return ended;
        }
        self.stop_limit_s = 0.0;
        // A stop is closed on the encoder, because the gyro may be what went wrong; on the gyro where it is the encoder.
        for (axis, axis_loop) in self.loops.iter_mut().enumerate() {
            let actuals = &rig.believed_actuals(axis);
            let model = &rig.axes()[axis].guard.stop;
            let speed = actuals.velocity_rad_per_s.abs();
            self.stop_begun_rad_per_s[axis] = speed;
            let limit_s = model.controlled_from(speed, 0.0, deceleration(axis)).time_s + SETTLING_S;
            self.stop_limit_s = self.stop_limit_s.max(limit_s);
            let friction_nm = model.friction.running_nm(speed);
            axis_loop.start_emergency_stop(actuals, deceleration(axis), model.jerk_rad_per_s3, friction_nm);
        }
        self.go(State::Stopping, now);
        ended
    }

    /// One tick: reads the newest samples, leaves a command for every axis in the image.
    ///
    /// # Errors
    /// When a drive does not follow through its power states, or the operator does not answer.
    pub fn step(
        &mut self,
        now: Duration,
        rig: &mut ArmedRig,
        dither: &mut dyn FnMut() -> f64,
        tell: &mut dyn FnMut(LoopEvent),
    ) -> Result<(), DeviceError> {
        let mut stepped = Ok(());
        match self.state {
            State::SafeOp | State::OpRequest | State::FaultReset | State::Enabling => {
                stepped = self.power_up(now, rig, tell);
            }
            State::Asking(class) => stepped = self.ask(class, now, rig, tell),
            State::Homing => stepped = self.home(now, rig, tell),
            State::Running(_) => self.run_segment(now, rig, tell),
            State::Arresting { next } => {
                if self.at_rest(rig) {
                    self.start_segment(next, now, rig, tell);
                }
            }
            State::Parking => self.park(now, rig),
            State::Disabling => self.disable(now, rig),
            State::Stopping => self.watch_stop(now, rig),
            State::Finished => {}
        }
        if let State::Running(running) = &self.state {
            rig.begin_task(running.index, now);
        }
        // A frame goes out with every tick, whatever went wrong, and it is never the last one again.
        let commanded = self.command(now, rig, dither);
        stepped.and(commanded)
    }

    fn go(&mut self, state: State<'c>, now: Duration) {
        if self.state.is_off_plan() {
            self.off_plan_s += (now - self.since).as_secs_f64();
        }
        self.state = state;
        self.since = now;
    }

    fn waited_s(&self, now: Duration) -> f64 {
        (now - self.since).as_secs_f64()
    }

    /// An axis that does not come to rest under control is left to the drive's own quick stop.
    fn watch_stop(&mut self, now: Duration, rig: &ArmedRig) {
        let runs_away = (0..self.loops.len()).any(|axis| {
            crate::cycle::safe::runs_away(rig.believed(axis).rate_rad_per_s, self.stop_begun_rad_per_s[axis])
        });
        let stands = |axis: usize| rig.believed(axis).stands();
        let stopped = (0..self.loops.len())
            .all(|axis| self.loops[axis].stopped(&rig.believed_actuals(axis)) && stands(axis));
        // Where the DC link takes nothing, friction brakes: that takes the time it takes.
        let link_limit_s = crate::cycle::safe::COASTING_AT_MOST.as_secs_f64();
        let limit_s = if rig.link_is_full() { link_limit_s } else { self.stop_limit_s };
        if stopped || runs_away || self.waited_s(now) > limit_s {
            self.go(State::Finished, now);
        }
    }

    fn start_segment(
        &mut self,
        index: usize,
        now: Duration,
        rig: &ArmedRig,
        tell: &mut dyn FnMut(LoopEvent),
    ) {
        let Some(segment) = self.case.segments.get(index) else {
            return self.wind_down(now, rig);
        };
        let actuals = rig.actuals(self.moving);
        // A position segment goes on from where the command stood, so that the command has no step.
        let start_rad = match segment.mode {
            Mode::Position => self.loops[self.moving].reference_rad(actuals),
            Mode::Torque | Mode::Velocity | Mode::DriveVelocity | Mode::Track => actuals.position_rad,
        };
        for (axis, axis_loop) in self.loops.iter_mut().enumerate() {
            if axis == self.moving || segment.is_tracked(false) {
                axis_loop.enter(segment, rig.feedback(axis).0);
            }
        }
        let from_rad = actuals.position_rad;
        let along = self.accompanied(segment, rig);
        let position_rad = start_rad;
        tell(LoopEvent::SegmentStarted { point: self.point, segment: index, position_rad });
        self.go(State::Running(Running::new(segment, index, start_rad, from_rad, along, now)), now);
    }

    /// What another axis does in a segment, its loop prepared for it.
    fn accompanied(&mut self, segment: &'c Segment, rig: &ArmedRig) -> Option<Along<'c>> {
        let companion = segment.companion.as_ref().filter(|_| !self.case.open_loop)?;
        let axis = rig.axes().iter().position(|a| a.name == companion.axis).filter(|&a| a != self.moving)?;
        let start_rad = self.loops[axis].reference_rad(rig.actuals(axis));
        self.loops[axis].enter(&Segment::default(), rig.feedback(axis).0);
        self.companion = Some(axis);
        Some(Along::new(axis, &companion.stimulus, start_rad))
    }

    /// An axis that moved along in the segment that is over rests from now on, without a step of its command.
    fn part(&mut self, companion: Option<usize>, rig: &ArmedRig) {
        self.companion = companion;
        if let Some(axis) = companion {
            self.loops[axis].start_stop(rig.actuals(axis), rig.feedback(axis).0);
        }
    }

    fn run_segment(&mut self, now: Duration, rig: &mut ArmedRig, tell: &mut dyn FnMut(LoopEvent)) {
        let State::Running(running) = &mut self.state else { return };
        let follows = |axis: usize| axis == self.moving || running.companion() == Some(axis);
        let paces = (0..self.loops.len()).filter(|axis| follows(*axis));
        let pace = paces.map(|axis| self.loops[axis].pace(rig.actuals(axis))).fold(1.0, f64::min);
        running.go_on(now, pace);
        let done = running.segment.task.is_some() && rig.instruments().is_done(running.index);
        if done {
            // The next record needs an edge again.
            rig.synchronise(now, false);
        }
        let by = if done { Some(EndedBy::Condition) } else { running.ends(now, rig, self.moving) };
        let Some(by) = by else { return };
        let index = running.index;
        let segment = running.segment;
        let companion = running.companion();
        self.part(companion, rig);
        tell(LoopEvent::SegmentEnded { point: self.point, segment: index, by });
        match segment.then {
            // What stops the axes from here on is `make_safe`: it quick-stops what may have torque.
            Then::QuickStop => return self.go(State::Finished, now),
            // An axis that was to rest, and does not, keeps its torque: nobody has computed where it would go.
            Then::TorqueOff
                if matches!(segment.stimulus, Stimulus::Hold { .. }) && moves(rig, self.moving) =>
            {
                return self.go(State::Finished, now);
            }
            Then::TorqueOff => {
                rig.forbid_torque(self.moving);
                return self.go(State::Finished, now);
            }
            Then::Next | Then::Hold | Then::Stop => {}
        }
        match self.after(index, segment, by) {
            After::Start(next) => self.start_segment(next, now, rig, tell),
            // Nothing may be held by a loop: friction holds it.
            After::Rest(next) if self.case.open_loop => self.start_segment(next, now, rig, tell),
            After::Rest(next) => self.arrest(segment, next, now, rig),
        }
    }
}

/// Beyond the computed time a stop is given this long to settle.
const SETTLING_S: f64 = 3.0;

/// Whether an axis is not at rest.
fn moves(rig: &ArmedRig, axis: usize) -> bool {
    !rig.believed(axis).stands()
}
