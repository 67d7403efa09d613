//! The production controllers of one axis in cascade (position → velocity → torque), as the bench runs them each tick.

use controllers::position::PositionController;
use controllers::profile::{MotionLimits, ProfileGenerator, Reference};
use controllers::velocity::VelocityController;
use controllers::{AxisGains, DirectorGains};
use drivers::cia402::Actuals;
use drivers::device::DeviceError;
use external_law::rows::LawInput;
use procedures::axis::{INTERNAL_LIMIT, SATURATED_SHARE};
use procedures::case::{Mode, Segment};
use procedures::excitation::Injection;
use procedures::stimulus::Setpoint;

use crate::cycle::laws::Laws;
use crate::cycle::velocity_loop::{LawFault, VelocityLoop};
use crate::model::axis::RigAxis;
use crate::model::rig::Rig;

/// Below this speed an axis counts as being at standstill at the end of a stop.
const REST_RAD_PER_S: f64 = 1e-4;

/// Above this speed an axis whose position command is constant is still moving towards the command.
const CHASING_RAD_PER_S: f64 = 0.1 * std::f64::consts::PI / 180.0;

/// Velocity limit of an emergency stop: higher than any axis can turn, so that the initial speed is never cut.
const ANY_RAD_PER_S: f64 = 100.0;

/// Rate of homing and parking: slow enough to be watched, fast enough for a whole travel in a minute.
const SLOW_RAD_PER_S: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Share of the torque limit by which the torque must fall short of the command before a drive's limit flag counts.
const MISSING_SHARE: f64 = 0.05;

/// The measured motion of an axis, with a given acceleration, as a start for a reference.
fn motion_of(actuals: &Actuals, acceleration_rad_per_s2: f64) -> Reference {
    Reference {
        position_rad: actuals.position_rad,
        velocity_rad_per_s: actuals.velocity_rad_per_s,
        acceleration_rad_per_s2,
    }
}

/// Position and velocity loop of one axis.
///
/// The axis follows either the setpoint of a segment or its own reference from the profile generator
/// (`following_reference`): for a hold, a stop or a slow move. `sent_nm` is the torque that really went out last.
#[derive(Debug)]
pub struct AxisLoop {
    position: PositionController,
    velocity: VelocityLoop,
    reference: ProfileGenerator,
    mode: Mode,
    setpoint: Setpoint,
    following_reference: bool,
    sent_nm: f64,
    /// What a test added to that torque.
    sent_added_nm: f64,
    limits: MotionLimits,
    inertia_kg_m2: f64,
    cycle_s: f64,
    /// `[periods, steps]`: periods since the last tick, and steps of the velocity loop in this tick.
    passed: [u32; 2],
    /// Position command minus position in the last tick; `None` where no position loop was closed.
    following_error_rad: Option<f64>,
    /// Velocity loop with other than the production gains, while a segment asks for one.
    detuned: Option<VelocityController>,
    gains: AxisGains,
    max_torque_nm: f64,
    /// `[rad/s, N·m]`: excitation added in this tick to the velocity command and to the torque.
    added: [f64; 2],
    /// `[command, feedback]` of the velocity loop in the last tick.
    closed_on_rad_per_s: [f64; 2],
}

impl AxisLoop {
    /// The loops of a rig with the built-in laws, in the order of its axes.
    pub fn of_rig(rig: &Rig, gains: &DirectorGains) -> Vec<Self> {
        let cycle_s = 1.0 / rig.loop_rate_hz;
        rig.axes.iter().zip(&gains.axes).map(|(axis, own)| Self::new(own, axis, cycle_s)).collect()
    }

    /// The loops of a rig, with external laws where there are any. Processes of laws keep off the processor of the thread that
    /// ticks, where it has one.
    ///
    /// # Errors
    /// When a law cannot be started.
    pub fn of_rig_with(
        rig: &Rig,
        gains: &DirectorGains,
        laws: &Laws,
        ticks_on: Option<usize>,
    ) -> Result<Vec<Self>, DeviceError> {
        let mut loops = Self::of_rig(rig, gains);
        for ((axis, own), of_axis) in rig.axes.iter().zip(&gains.axes).zip(&mut loops) {
            if let Some(law) = laws.of(&axis.name) {
                of_axis.velocity.step_by(law.start(axis, own, of_axis.cycle_s, ticks_on)?);
            }
        }
        Ok(loops)
    }

    /// A loop with the production gains that saturates at the axis' torque limit.
    fn new(gains: &AxisGains, axis: &RigAxis, cycle_s: f64) -> Self {
        let limits = &axis.limits;
        let motion = MotionLimits {
            velocity_rad_per_s: limits.max_velocity_rad_per_s,
            acceleration_rad_per_s2: limits.max_acceleration_rad_per_s2,
            jerk_rad_per_s3: limits.max_jerk_rad_per_s3,
        };
        Self {
            position: PositionController::new(gains, limits.max_velocity_rad_per_s),
            velocity: VelocityLoop::new(VelocityController::new(gains, limits.max_torque_nm, cycle_s)),
            reference: ProfileGenerator::new(motion, 0.0)
                .expect("the rig file's reader accepts only positive, finite limits"),
            mode: Mode::Position,
            setpoint: Setpoint::default(),
            following_reference: true,
            sent_nm: 0.0,
            sent_added_nm: 0.0,
            limits: motion,
            inertia_kg_m2: limits.inertia_kg_m2,
            cycle_s,
            passed: [1; 2],
            following_error_rad: None,
            detuned: None,
            gains: *gains,
            max_torque_nm: limits.max_torque_nm,
            added: [0.0; 2],
            closed_on_rad_per_s: [0.0; 2],
        }
    }

    /// Holds the axis at its measured position, bumpless.
    pub fn hold_here(&mut self, actuals: &Actuals) {
        self.detuned = None;
        self.quiet();
        self.following_reference = true;
        self.mode = Mode::Position;
        self.take_limits(self.limits);
        self.reference.take_over(Reference { position_rad: actuals.position_rad, ..Reference::default() });
        self.velocity.take_over(self.sent_nm, 0.0, actuals.velocity_rad_per_s, 0.0);
    }

    /// Decelerates to rest within the axis' limits, then holds. `rate_rad_per_s` is the feedback of the velocity loop.
    ///
    /// The stop begins at the commanded motion if the axis follows a position command, otherwise at the measured motion.
    pub fn start_stop(&mut self, actuals: &Actuals, rate_rad_per_s: f64) {
        self.take_limits(self.limits);
        self.quiet();
        let follows_command =
            !self.following_reference && self.mode == Mode::Position && !self.moves_towards_setpoint(actuals);
        let setpoint = &self.setpoint;
        let motion = if follows_command {
            Reference {
                position_rad: setpoint.position_rad,
                velocity_rad_per_s: setpoint.velocity_rad_per_s,
                acceleration_rad_per_s2: setpoint.acceleration_rad_per_s2,
            }
        } else {
            motion_of(actuals, 0.0)
        };
        self.decelerate(motion, actuals, rate_rad_per_s);
    }

    /// Whether the axis still moves after a step of the position command. A stop must then not go on to the target of the
    /// step. (The direction of motion is not checked.)
    fn moves_towards_setpoint(&self, actuals: &Actuals) -> bool {
        let s = &self.setpoint;
        let is_constant = s.velocity_rad_per_s == 0.0 && s.acceleration_rad_per_s2 == 0.0;
        is_constant && actuals.velocity_rad_per_s.abs() > CHASING_RAD_PER_S
    }

    /// Lets the reference decelerate from this motion to rest, bumpless from the torque sent last.
    fn decelerate(&mut self, motion: Reference, actuals: &Actuals, rate_rad_per_s: f64) {
        self.detuned = None;
        let command_rad_per_s =
            self.position.update(motion.position_rad, actuals.position_rad, motion.velocity_rad_per_s);
        let feed_forward_nm = self.inertia_kg_m2 * motion.acceleration_rad_per_s2;
        self.velocity.take_over(self.sent_nm, command_rad_per_s, rate_rad_per_s, feed_forward_nm);
        self.reference.take_over(motion);
        self.following_reference = true;
        self.mode = Mode::Position;
    }

    /// Begins an ordered stop or the stop after a trip, with the given deceleration and jerk (both positive). The built-in
    /// law makes it.
    ///
    /// The stop begins at the believed angle and rate, which are also its feedback. It does not begin at the command: an
    /// axis that lags behind must not catch up first. `friction_nm` is the torque that overcomes sliding friction.
    pub fn start_emergency_stop(
        &mut self,
        believed: &Actuals,
        deceleration_rad_per_s2: f64,
        jerk_rad_per_s3: f64,
        friction_nm: f64,
    ) {
        let limits = MotionLimits {
            velocity_rad_per_s: ANY_RAD_PER_S,
            acceleration_rad_per_s2: deceleration_rad_per_s2,
            jerk_rad_per_s3,
        };
        self.velocity.leave_external();
        self.take_limits(limits);
        self.quiet();
        let ahead = believed.velocity_rad_per_s.signum();
        // Bumpless, but a driving torque above friction is cut at once: it would go on accelerating the axis.
        let along_nm = (ahead * self.sent_nm).min(friction_nm);
        self.sent_nm = ahead * along_nm;
        // The axis decelerates already by (T_f − T)/J, and the reference begins with that. From more than √(2·j·|v|) the
        // jerk limit could not end the deceleration before the axis turned back.
        let reversal_rad_per_s2 = (2.0 * jerk_rad_per_s3 * believed.velocity_rad_per_s.abs()).sqrt();
        let present_rad_per_s2 = ((friction_nm - along_nm) / self.inertia_kg_m2)
            .min(deceleration_rad_per_s2)
            .min(reversal_rad_per_s2);
        let start = motion_of(believed, -ahead * present_rad_per_s2);
        self.decelerate(start, believed, believed.velocity_rad_per_s);
    }

    /// One tick of an emergency stop: the torque, N·m.
    ///
    /// If the axis runs past the reference because the torque is limited, the reference restarts at the axis. The axis
    /// then stops where it can and does not come back. `braking_share` (0 to 1) scales torque against the motion: a full
    /// DC link takes no braking energy.
    pub fn brake(&mut self, believed: &Actuals, braking_share: f64) -> f64 {
        let reference = self.reference.reference();
        let past_rad =
            (believed.position_rad - reference.position_rad) * believed.velocity_rad_per_s.signum();
        let limited = braking_share < 1.0 || self.is_limited(believed);
        if limited && past_rad > 0.0 {
            self.reference.take_over(motion_of(believed, reference.acceleration_rad_per_s2));
        }
        let torque_nm = self.excited(None).torque(believed, believed.velocity_rad_per_s, None);
        if torque_nm * believed.velocity_rad_per_s < 0.0 { braking_share * torque_nm } else { torque_nm }
    }

    /// Whether the motor torque is limited: the command is at the torque limit, or the drive reports an internal limit and
    /// gives clearly less torque than commanded.
    fn is_limited(&self, actuals: &Actuals) -> bool {
        let drive_is_limited = INTERNAL_LIMIT & actuals.statusword != 0;
        let missing_nm = (self.sent_nm - actuals.torque_nm) * self.sent_nm.signum();
        self.sent_nm.abs() >= SATURATED_SHARE * self.max_torque_nm
            || drive_is_limited && missing_nm > MISSING_SHARE * self.max_torque_nm
    }

    /// Ratio of segment time to real time in this tick, 0 to 1: anti-windup of the position command.
    ///
    /// It is below 1 only where the axis falls behind the command with its torque at the limit. The command then advances
    /// no faster than the axis. Otherwise a following error would build up, to be worked off when the axis should stop.
    pub fn pace(&self, actuals: &Actuals) -> f64 {
        let commanded = self.setpoint.velocity_rad_per_s;
        let behind_rad = self.following_error_rad.unwrap_or(0.0) * commanded.signum();
        if behind_rad <= 0.0 || commanded == 0.0 || !self.is_limited(actuals) {
            return 1.0;
        }
        (actuals.velocity_rad_per_s / commanded).clamp(0.0, 1.0)
    }

    /// Ends an excitation and subtracts its torque from `sent_nm`: the next bumpless transfer must not take it over.
    fn quiet(&mut self) {
        self.sent_nm -= self.added[1];
        self.sent_added_nm = 0.0;
        self.added = [0.0; 2];
    }

    /// Starts a slow move to an angle, from rest.
    pub fn go_slowly(&mut self, actuals: &Actuals, target_rad: f64) {
        let limits = MotionLimits {
            velocity_rad_per_s: SLOW_RAD_PER_S.min(self.limits.velocity_rad_per_s),
            acceleration_rad_per_s2: SLOW_RAD_PER_S.min(self.limits.acceleration_rad_per_s2),
            jerk_rad_per_s3: (10.0 * SLOW_RAD_PER_S).min(self.limits.jerk_rad_per_s3),
        };
        self.quiet();
        let from_rad = self.reference_rad(actuals);
        self.take_limits(limits);
        self.reference.take_over(Reference { position_rad: from_rad, ..Reference::default() });
        self.reference.move_to(target_rad);
        self.following_reference = true;
        self.mode = Mode::Position;
    }

    /// Restarts the reference at rest at its present angle, with these limits. Invalid limits are ignored.
    fn take_limits(&mut self, limits: MotionLimits) {
        if let Some(reference) = ProfileGenerator::new(limits, self.reference.reference().position_rad) {
            self.reference = reference;
        }
    }

    /// Open-loop torque, N·m: that of the setpoint, or 0 without one.
    pub fn open(&mut self, wanted: Option<&Setpoint>) -> f64 {
        self.setpoint = wanted.copied().unwrap_or_default();
        self.mode = Mode::Torque;
        self.following_reference = false;
        self.setpoint.torque_nm
    }

    /// Whether a stop is complete: reference and axis are both at rest.
    pub fn stopped(&self, actuals: &Actuals) -> bool {
        self.following_reference
            && self.reference.is_at_rest()
            && actuals.velocity_rad_per_s.abs() < REST_RAD_PER_S
    }

    /// Present position command, rad, as the start of the next segment; the measured angle where no position is commanded.
    pub fn reference_rad(&self, actuals: &Actuals) -> f64 {
        if self.mode == Mode::Position && !self.following_reference {
            self.setpoint.position_rad
        } else if self.mode == Mode::Position {
            self.reference.reference().position_rad
        } else {
            actuals.position_rad
        }
    }

    /// Switches to the mode and gains of a segment, bumpless where the loop stays closed. `rate_rad_per_s` is the feedback
    /// of the velocity loop.
    pub fn enter(&mut self, segment: &Segment, rate_rad_per_s: f64) {
        self.quiet();
        let production_loop_was_idle =
            matches!(self.mode, Mode::Torque | Mode::DriveVelocity) || self.detuned.is_some();
        if production_loop_was_idle && segment.mode != Mode::Torque {
            self.velocity.reset(self.sent_nm);
        }
        self.detuned = segment.gain_ratio.map(|ratio| {
            let mut gains = self.gains;
            gains.velocity_kp_nm_s_per_rad *= ratio;
            gains.velocity_ki_nm_per_rad *= ratio;
            let mut detuned = VelocityController::new(&gains, self.max_torque_nm, self.cycle_s);
            let [command, _] = self.closed_on_rad_per_s;
            detuned.take_over(self.sent_nm, command, rate_rad_per_s, 0.0);
            detuned
        });
        self.mode = segment.mode;
        self.following_reference = false;
    }

    /// Tells the time since the last tick; to be called once a tick, before [`Self::torque`]. The reference advances by
    /// `periods`, the velocity loop (integral and filters) by `steps`. Both exceed 1 after missed periods.
    pub fn pass(&mut self, periods: u32, steps: u32) {
        self.passed = [periods, steps];
    }

    /// Sets the excitation of this tick, rad/s or N·m by its kind. A value that is not finite adds nothing.
    pub fn excited(&mut self, excitation: Option<(Injection, f64)>) -> &mut Self {
        self.added = match excitation {
            Some((Injection::Velocity, rad_per_s)) if rad_per_s.is_finite() => [rad_per_s, 0.0],
            Some((Injection::Torque, torque_nm)) if torque_nm.is_finite() => [0.0, torque_nm],
            _ => [0.0; 2],
        };
        self
    }

    /// `[command, feedback]` of the velocity loop in the last tick, for the log.
    pub fn closed_on_rad_per_s(&self) -> [f64; 2] {
        self.closed_on_rad_per_s
    }

    /// The torque for this tick, N·m. `rate_rad_per_s` is the feedback of the velocity loop. `wanted` is the setpoint of
    /// the segment; without one the axis follows its own reference.
    pub fn torque(&mut self, actuals: &Actuals, rate_rad_per_s: f64, wanted: Option<&Setpoint>) -> f64 {
        self.setpoint = match wanted {
            Some(setpoint) => *setpoint,
            None => self.follow_reference(),
        };
        self.following_error_rad = None;
        let [added_rate, added_nm] = self.added;
        self.closed_on_rad_per_s = [rate_rad_per_s; 2];
        if self.mode == Mode::Torque && wanted.is_some() {
            return self.setpoint.torque_nm + added_nm;
        }
        if self.mode == Mode::DriveVelocity && wanted.is_some() {
            // The drive's own velocity loop makes the torque. Its actual torque is the start of the next bumpless transfer.
            return actuals.torque_nm;
        }
        let wished = &self.setpoint;
        let command = match self.mode {
            Mode::Velocity | Mode::Track if wanted.is_some() => wished.velocity_rad_per_s,
            _ => {
                self.following_error_rad = Some(wished.position_rad - actuals.position_rad);
                self.position.update(wished.position_rad, actuals.position_rad, wished.velocity_rad_per_s)
            }
        };
        let feed_forward_nm = self.inertia_kg_m2 * wished.acceleration_rad_per_s2;
        let command = command + added_rate;
        self.closed_on_rad_per_s[0] = command;
        let input = LawInput {
            take_over: 0.0,
            reference_rad_per_s: command,
            rate_rad_per_s,
            feed_forward_nm,
            acceleration_rad_per_s2: wished.acceleration_rad_per_s2,
            sent_nm: self.sent_nm,
        };
        // Steps for missed periods, with the present values held; only the last one gives the torque.
        let steps = self.passed[1].max(1);
        let torque_nm = match (&mut self.detuned, wanted) {
            (Some(detuned), Some(_)) => {
                let step = |_| detuned.update(command, rate_rad_per_s, feed_forward_nm);
                (0..steps).map(step).last().unwrap_or(0.0)
            }
            _ => self.velocity.update(&input, self.sent_nm - self.sent_added_nm, steps),
        };
        let torque_nm = torque_nm + added_nm;
        torque_nm.clamp(-self.max_torque_nm, self.max_torque_nm)
    }

    /// What made the external law unusable, once.
    pub fn take_law_fault(&mut self) -> Option<LawFault> {
        self.velocity.take_fault()
    }

    /// Records the torque that really went out, N·m, for a bumpless change of mode: the last step of a tick.
    pub fn sent(&mut self, torque_nm: f64) {
        self.sent_nm = torque_nm;
        self.sent_added_nm = self.added[1];
        self.velocity.end_tick();
    }

    /// Torque that went out last.
    pub fn sent_nm(&self) -> f64 {
        self.sent_nm
    }

    /// Position command minus position in the last tick, rad; `None` where no position loop was closed.
    pub fn following_error_rad(&self) -> Option<f64> {
        self.following_error_rad
    }

    /// Setpoint of this tick, for the log.
    pub fn setpoint(&self) -> &Setpoint {
        &self.setpoint
    }

    /// Advances the axis' own reference to this tick.
    fn follow_reference(&mut self) -> Setpoint {
        self.following_reference = true;
        let at = self.reference.advance(f64::from(self.passed[0]) * self.cycle_s);
        Setpoint {
            position_rad: at.position_rad,
            velocity_rad_per_s: at.velocity_rad_per_s,
            acceleration_rad_per_s2: at.acceleration_rad_per_s2,
            torque_nm: 0.0,
        }
    }
}

#[cfg(test)]
mod tests;
