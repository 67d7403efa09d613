//! The sequencer: what the loop does in each tick, from SAFE-OP to the end of a point.
//!
//! Enabling, moving, holding and stopping are states inside the tick, all under the interlocks.

use std::time::Duration;

use drivers::cia402::{PowerState, PowerTarget};
use drivers::device::DeviceError;
use drivers::wire::BusState;
use procedures::case::{Case, Mode, Then};
use procedures::log::EndedBy;

use crate::axis_loop::AxisLoop;
use crate::recorder::LoopEvent;
use crate::rig::ArmedRig;

mod segment;

use segment::Running;

/// Longest controlled stop: from the largest rate with the smallest deceleration of any rig, and 3 s.
const STOP_LIMIT_S: f64 = 6.0;
/// Longest wait for gyros that have just been powered.
const FEEDBACK_LIMIT_S: f64 = 20.0;
/// Longest wait for the bus to change its state.
const BUS_LIMIT_S: f64 = 5.0;

/// Where the sequencer is.
#[derive(Debug)]
pub enum State<'c> {
    /// Waiting for the first valid inputs; gates are checked.
    SafeOp,
    /// Asked for OP.
    OpRequest,
    /// Bringing all drives to operation enabled.
    Enabling,
    /// A segment runs.
    Running(Running<'c>),
    /// Bringing the axis to rest between segments; then the segment of this index starts.
    Arresting {
        /// Next segment.
        next: usize,
    },
    /// Controlled stop after a trip or an order to stop.
    Stopping,
    /// Nothing more to do here; `make_safe` takes over.
    Finished,
}

impl State<'_> {
    /// Number in the log's `state` channel.
    pub fn number(&self) -> u16 {
        match self {
            Self::SafeOp => 0,
            Self::OpRequest => 1,
            Self::Enabling => 2,
            Self::Running(_) => 3,
            Self::Arresting { .. } => 4,
            Self::Stopping => 5,
            Self::Finished => 6,
        }
    }
}

/// The sequencer of one point.
pub struct Sequencer<'c> {
    case: &'c Case,
    point: usize,
    moving: usize,
    state: State<'c>,
    since: Duration,
    /// Speeds at which an ordered stop began.
    stop_begun_rad_per_s: Vec<f64>,
    loops: Vec<AxisLoop>,
}

impl<'c> Sequencer<'c> {
    /// A sequencer for `case`, point `point` of its procedure; `moving` is the index of its axis.
    /// The first tick is at `start`.
    pub fn new(case: &'c Case, point: usize, moving: usize, loops: Vec<AxisLoop>, start: Duration) -> Self {
        let stop_begun_rad_per_s = vec![0.0; loops.len()];
        Self { case, point, moving, state: State::SafeOp, since: start, stop_begun_rad_per_s, loops }
    }

    /// Where it is.
    pub fn state(&self) -> &State<'c> {
        &self.state
    }

    /// The axis' loop, for recording its setpoints.
    pub fn axis_loop(&self, axis: usize) -> &AxisLoop {
        &self.loops[axis]
    }

    /// Whether the drives must be in operation now.
    pub fn expects_operation(&self) -> bool {
        matches!(self.state, State::Running(_) | State::Arresting { .. } | State::Stopping)
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

    /// Leaves at once: `make_safe` quick-stops.
    pub fn abandon(&mut self) {
        self.state = State::Finished;
    }

    /// Orders a controlled stop: the axes decelerate within their limits. Where nothing moves yet, it is over.
    pub fn stop(&mut self, now: Duration, rig: &ArmedRig) -> Option<LoopEvent> {
        let ended = match &self.state {
            State::Running(running) => Some(LoopEvent::SegmentEnded {
                point: self.point,
                segment: running.index,
                by: EndedBy::Stopped,
            }),
            _ => None,
        };
        if self.expects_operation() {
            for (axis, begun) in self.stop_begun_rad_per_s.iter_mut().enumerate() {
                *begun = rig.actuals(axis).velocity_rad_per_s.abs();
            }
            // A stop is closed on the encoder: the gyro may be what went wrong.
            for (axis, axis_loop) in self.loops.iter_mut().enumerate() {
                axis_loop.start_stop(rig.actuals(axis), rig.actuals(axis).velocity_rad_per_s);
            }
            self.go(State::Stopping, now);
        } else {
            self.go(State::Finished, now);
        }
        ended
    }

    /// One tick: reads the newest samples, leaves a command for every axis in the image.
    ///
    /// # Errors
    /// When a drive does not follow through its power states.
    pub fn step(
        &mut self,
        now: Duration,
        rig: &mut ArmedRig,
        dither: &mut dyn FnMut() -> f64,
        tell: &mut dyn FnMut(LoopEvent),
    ) -> Result<(), DeviceError> {
        match self.state {
            State::SafeOp | State::OpRequest | State::Enabling => self.power_up(now, rig, tell)?,
            State::Running(_) => self.run_segment(now, rig, tell),
            State::Arresting { next } => {
                if self.at_rest(rig) {
                    self.start_segment(next, now, rig, tell);
                }
            }
            State::Stopping => {
                let runs_away = (0..self.loops.len())
                    .any(|axis| crate::safe::runs_away(rig.actuals(axis), self.stop_begun_rad_per_s[axis]));
                let stopped = (0..self.loops.len()).all(|axis| self.loops[axis].stopped(rig.actuals(axis)));
                // An axis that does not come to rest under control is left to the drive's own quick stop.
                if stopped || runs_away || (now - self.since).as_secs_f64() > STOP_LIMIT_S {
                    self.go(State::Finished, now);
                }
            }
            State::Finished => {}
        }
        self.command(now, rig, dither)
    }

    fn go(&mut self, state: State<'c>, now: Duration) {
        self.state = state;
        self.since = now;
    }

    fn power_up(
        &mut self,
        now: Duration,
        rig: &mut ArmedRig,
        tell: &mut dyn FnMut(LoopEvent),
    ) -> Result<(), DeviceError> {
        let waited_s = (now - self.since).as_secs_f64();
        match self.state {
            State::SafeOp if rig.bus_state() >= BusState::SafeOp => {
                rig.request(BusState::Op);
                self.go(State::OpRequest, now);
            }
            State::OpRequest if rig.bus_state() == BusState::Op && rig.feedback_is_valid() => {
                self.go(State::Enabling, now);
            }
            State::OpRequest if rig.bus_state() == BusState::Op && waited_s > FEEDBACK_LIMIT_S => {
                let reason = format!("no valid rates from the gyros for {FEEDBACK_LIMIT_S} s");
                return Err(DeviceError::Bus { device: "imu".to_owned(), reason });
            }
            State::SafeOp | State::OpRequest if waited_s > BUS_LIMIT_S && rig.bus_state() < BusState::Op => {
                let reason = format!("bus state {:?} for more than {BUS_LIMIT_S} s", rig.bus_state());
                return Err(DeviceError::Bus { device: "bus".to_owned(), reason });
            }
            State::Enabling if self.all_enabled(rig) => {
                for (axis, axis_loop) in self.loops.iter_mut().enumerate() {
                    axis_loop.hold_here(rig.actuals(axis));
                }
                self.start_segment(0, now, rig, tell);
            }
            _ => {}
        }
        Ok(())
    }

    fn all_enabled(&self, rig: &ArmedRig) -> bool {
        (0..self.loops.len())
            .all(|axis| PowerState::of(rig.actuals(axis).statusword) == PowerState::OperationEnabled)
    }

    fn start_segment(
        &mut self,
        index: usize,
        now: Duration,
        rig: &ArmedRig,
        tell: &mut dyn FnMut(LoopEvent),
    ) {
        let Some(segment) = self.case.segments.get(index) else {
            return self.go(State::Finished, now);
        };
        let actuals = rig.actuals(self.moving);
        // A position segment goes on from where the command stood, so that the command has no step.
        let start_rad = match segment.mode {
            Mode::Position => self.loops[self.moving].reference_rad(actuals),
            Mode::Torque | Mode::Velocity => actuals.position_rad,
        };
        self.loops[self.moving].enter(segment.mode, actuals);
        let position_rad = start_rad;
        tell(LoopEvent::SegmentStarted { point: self.point, segment: index, position_rad });
        self.go(State::Running(Running::new(segment, index, start_rad, actuals.position_rad, now)), now);
    }

    fn run_segment(&mut self, now: Duration, rig: &ArmedRig, tell: &mut dyn FnMut(LoopEvent)) {
        let State::Running(running) = &mut self.state else { return };
        let Some(by) = running.ends(now, rig.actuals(self.moving)) else { return };
        let (index, then) = (running.index, running.segment.then);
        tell(LoopEvent::SegmentEnded { point: self.point, segment: index, by });
        match then {
            Then::Next => self.start_segment(index + 1, now, rig, tell),
            Then::Hold => {
                self.loops[self.moving].start_stop(rig.actuals(self.moving), rig.feedback(self.moving).0);
                self.go(State::Arresting { next: index + 1 }, now);
            }
            Then::Stop => {
                self.loops[self.moving].start_stop(rig.actuals(self.moving), rig.feedback(self.moving).0);
                self.go(State::Arresting { next: usize::MAX }, now);
            }
        }
    }

    fn at_rest(&self, rig: &ArmedRig) -> bool {
        self.loops[self.moving].stopped(rig.actuals(self.moving))
    }

    /// Leaves a command for every axis, whatever goes wrong with one of them; gives the first error.
    fn command(
        &mut self,
        now: Duration,
        rig: &mut ArmedRig,
        dither: &mut dyn FnMut() -> f64,
    ) -> Result<(), DeviceError> {
        let powered = self.expects_operation();
        let target = match self.state {
            State::SafeOp | State::OpRequest => PowerTarget::Disabled,
            _ => PowerTarget::Enabled,
        };
        let mut outcome = Ok(());
        for axis in 0..self.loops.len() {
            // Once finished nothing enables or moves any more: from here on it is `make_safe`'s command.
            if self.finished() {
                crate::safe::settle(rig, axis, now);
                self.loops[axis].sent(0.0);
                continue;
            }
            let controlword = match rig.controlword(axis, target, now) {
                Ok(controlword) => controlword,
                Err(error) => {
                    crate::safe::settle(rig, axis, now);
                    self.loops[axis].sent(0.0);
                    outcome = outcome.and(Err(error));
                    continue;
                }
            };
            let actuals = *rig.actuals(axis);
            let wanted = match &self.state {
                State::Running(running) if axis == self.moving => Some(running.setpoint(now)),
                _ => None,
            };
            let rate = match self.state {
                State::Stopping => actuals.velocity_rad_per_s,
                _ => rig.feedback(axis).0,
            };
            let mut torque_nm =
                if powered { self.loops[axis].torque(&actuals, rate, wanted.as_ref()) } else { 0.0 };
            if let State::Running(running) = &self.state
                && axis == self.moving
                && running.segment.dithered
            {
                torque_nm += dither();
            }
            let sent_nm = rig.command(axis, controlword, torque_nm);
            self.loops[axis].sent(sent_nm);
        }
        outcome
    }
}
