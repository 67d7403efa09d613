//! The production controllers of one axis in the tick: position → velocity → torque.

use controllers::position::PositionController;
use controllers::profile::{MotionLimits, ProfileGenerator, Reference};
use controllers::velocity::VelocityController;
use controllers::{AxisGains, DirectorGains};
use drivers::cia402::Actuals;
use procedures::axis::{INTERNAL_LIMIT, SATURATED_SHARE};
use procedures::case::{Mode, Segment};
use procedures::excitation::Injection;
use procedures::stimulus::Setpoint;

use crate::model::axis::RigAxis;
use crate::model::rig::Rig;

/// Below this rate an axis counts as standing at the end of a stop.
const REST_RAD_PER_S: f64 = 1e-4;

/// Above this rate an axis whose command stands is still on its way to it.
const CHASING_RAD_PER_S: f64 = 0.1 * std::f64::consts::PI / 180.0;

/// No axis turns as fast: a stop begins at whatever speed there is.
const ANY_RAD_PER_S: f64 = 100.0;

/// Rate of homing and parking: slow enough to be watched, fast enough for a whole travel in a minute.
const SLOW_RAD_PER_S: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Share of the largest torque that a drive at a limit of its own must leave out.
const MISSING_SHARE: f64 = 0.05;

/// Angle and rate of an axis as a reference to go on from.
fn motion_of(actuals: &Actuals, acceleration_rad_per_s2: f64) -> Reference {
    Reference {
        position_rad: actuals.position_rad,
        velocity_rad_per_s: actuals.velocity_rad_per_s,
        acceleration_rad_per_s2,
    }
}

/// One axis' loop.
#[derive(Clone, Debug)]
pub struct AxisLoop {
    position: PositionController,
    velocity: VelocityController,
    reference: ProfileGenerator,
    mode: Mode,
    setpoint: Setpoint,
    following_reference: bool,
    sent_nm: f64,
    limits: MotionLimits,
    inertia_kg_m2: f64,
    cycle_s: f64,
    /// Periods since the tick before, and steps that the velocity loop takes for them.
    passed: [u32; 2],
    /// Position reference less position in the last tick, where the position loop was closed.
    following_error_rad: Option<f64>,
    /// Velocity loop of a segment that asks for other gains than the production ones.
    detuned: Option<VelocityController>,
    gains: AxisGains,
    max_torque_nm: f64,
    /// Added in this tick to the command of the velocity loop and to its torque.
    added: [f64; 2],
    /// Command and rate that the velocity loop was closed on in the last tick.
    closed_on_rad_per_s: [f64; 2],
}

impl AxisLoop {
    /// The loops of a rig, in the order of its axes.
    pub fn of_rig(rig: &Rig, gains: &DirectorGains) -> Vec<Self> {
        let cycle_s = 1.0 / rig.loop_rate_hz;
        rig.axes.iter().zip(&gains.axes).map(|(axis, own)| Self::new(own, axis, cycle_s)).collect()
    }

    /// A loop with the production gains, saturating at the axis' torque limit.
    fn new(gains: &AxisGains, axis: &RigAxis, cycle_s: f64) -> Self {
        let limits = &axis.limits;
        let motion = MotionLimits {
            velocity_rad_per_s: limits.max_velocity_rad_per_s,
            acceleration_rad_per_s2: limits.max_acceleration_rad_per_s2,
            jerk_rad_per_s3: limits.max_jerk_rad_per_s3,
        };
        Self {
            position: PositionController::new(gains, limits.max_velocity_rad_per_s),
            velocity: VelocityController::new(gains, limits.max_torque_nm, cycle_s),
            reference: ProfileGenerator::new(motion, 0.0)
                .expect("the rig file's reader accepts only positive, finite limits"),
            mode: Mode::Position,
            setpoint: Setpoint::default(),
            following_reference: true,
            sent_nm: 0.0,
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

    /// Holds the axis where it is, without a torque step.
    pub fn hold_here(&mut self, actuals: &Actuals) {
        self.detuned = None;
        self.quiet();
        self.following_reference = true;
        self.mode = Mode::Position;
        self.take_limits(self.limits);
        self.reference.take_over(Reference { position_rad: actuals.position_rad, ..Reference::default() });
        self.velocity.take_over(self.sent_nm, 0.0, actuals.velocity_rad_per_s, 0.0);
    }

    /// Decelerates from the present rate to rest within the axis' limits, then holds. `rate_rad_per_s` is what the
    /// velocity loop will be closed on.
    pub fn start_stop(&mut self, actuals: &Actuals, rate_rad_per_s: f64) {
        self.take_limits(self.limits);
        self.quiet();
        let commanded =
            !self.following_reference && self.mode == Mode::Position && !self.moves_towards_setpoint(actuals);
        let setpoint = &self.setpoint;
        let motion = if commanded {
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

    /// Whether the command stands and the axis moves towards it, after a step: a stop must not go on to its target.
    fn moves_towards_setpoint(&self, actuals: &Actuals) -> bool {
        let s = &self.setpoint;
        let stands = s.velocity_rad_per_s == 0.0 && s.acceleration_rad_per_s2 == 0.0;
        stands && actuals.velocity_rad_per_s.abs() > CHASING_RAD_PER_S
    }

    /// Brings this motion to rest, without a torque step.
    fn decelerate(&mut self, motion: Reference, actuals: &Actuals, rate_rad_per_s: f64) {
        self.detuned = None;
        let commanded =
            self.position.update(motion.position_rad, actuals.position_rad, motion.velocity_rad_per_s);
        let feed_forward_nm = self.inertia_kg_m2 * motion.acceleration_rad_per_s2;
        self.velocity.take_over(self.sent_nm, commanded, rate_rad_per_s, feed_forward_nm);
        self.reference.take_over(motion);
        self.following_reference = true;
        self.mode = Mode::Position;
    }

    /// Stops as fast as the axis may, from the angle and the rate that are believed and closed on them: an ordered stop or
    /// a trip. Where the command had got to does not matter: an axis that lags behind it must not catch up first.
    /// `friction_nm` is what running takes.
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
        self.take_limits(limits);
        self.quiet();
        let ahead = believed.velocity_rad_per_s.signum();
        // Torque that drives the axis on is not taken over beyond what friction takes: a stop begins at once.
        let along_nm = (ahead * self.sent_nm).min(friction_nm);
        self.sent_nm = ahead * along_nm;
        // The rest of the torque brakes already, J·α = T − T_f; what is all but at rest is not braked into going back.
        let turns_back = (2.0 * jerk_rad_per_s3 * believed.velocity_rad_per_s.abs()).sqrt();
        let braking =
            ((friction_nm - along_nm) / self.inertia_kg_m2).min(deceleration_rad_per_s2).min(turns_back);
        self.decelerate(motion_of(believed, -ahead * braking), believed, believed.velocity_rad_per_s);
    }

    /// One tick of an emergency stop. The reference waits for a motor that gives all it has: it is taken back to an axis
    /// that has run past it, so that the axis stops where it can and does not come back. `braking_share` is how much of the
    /// torque against the motion may go out: a DC link that is full takes none.
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

    /// Whether more torque than the axis has now would not come: the command is at its limit, or the drive says that it
    /// is at one of its own and shows less than it was told.
    fn is_limited(&self, actuals: &Actuals) -> bool {
        let limited = INTERNAL_LIMIT & actuals.statusword != 0;
        let missing_nm = (self.sent_nm - actuals.torque_nm) * self.sent_nm.signum();
        self.sent_nm.abs() >= SATURATED_SHARE * self.max_torque_nm
            || limited && missing_nm > MISSING_SHARE * self.max_torque_nm
    }

    /// Share of the time that the position command of a segment may go on by in this tick: 1, or less where the motor
    /// gives all it has and the axis still falls behind. Then the command waits for the axis (anti-windup of the profile),
    /// instead of leaving behind it an angle that would be worked off when the axis is to stop.
    pub fn pace(&self, actuals: &Actuals) -> f64 {
        let commanded = self.setpoint.velocity_rad_per_s;
        let behind_rad = self.following_error_rad.unwrap_or(0.0) * commanded.signum();
        if behind_rad <= 0.0 || commanded == 0.0 || !self.is_limited(actuals) {
            return 1.0;
        }
        (actuals.velocity_rad_per_s / commanded).clamp(0.0, 1.0)
    }

    /// Ends an excitation: what it added to the torque is not taken over by whatever comes next.
    fn quiet(&mut self) {
        self.sent_nm -= self.added[1];
        self.added = [0.0; 2];
    }

    /// Moves slowly to a place, from rest.
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

    /// Limits for the next reference; those that are no limits leave it as it is.
    fn take_limits(&mut self, limits: MotionLimits) {
        if let Some(reference) = ProfileGenerator::new(limits, self.reference.reference().position_rad) {
            self.reference = reference;
        }
    }

    /// The torque of a point in which no loop is closed: what the segment says, or none.
    pub fn open(&mut self, wanted: Option<&Setpoint>) -> f64 {
        self.setpoint = wanted.copied().unwrap_or_default();
        self.mode = Mode::Torque;
        self.following_reference = false;
        self.setpoint.torque_nm
    }

    /// Whether a stop is over: the reference rests and so does the axis.
    pub fn stopped(&self, actuals: &Actuals) -> bool {
        self.following_reference
            && self.reference.is_at_rest()
            && actuals.velocity_rad_per_s.abs() < REST_RAD_PER_S
    }

    /// Where the position command stands, for a segment that goes on from there.
    pub fn reference_rad(&self, actuals: &Actuals) -> f64 {
        if self.mode == Mode::Position && !self.following_reference {
            self.setpoint.position_rad
        } else if self.mode == Mode::Position {
            self.reference.reference().position_rad
        } else {
            actuals.position_rad
        }
    }

    /// Prepares for a segment, without a torque step where the loop stays closed. `rate_rad_per_s` is what the velocity
    /// loop is closed on.
    pub fn enter(&mut self, segment: &Segment, rate_rad_per_s: f64) {
        self.quiet();
        let open = matches!(self.mode, Mode::Torque | Mode::DriveVelocity) || self.detuned.is_some();
        if open && segment.mode != Mode::Torque {
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

    /// Once a tick, before its torque is asked for: so many periods have passed since the tick before. The reference goes
    /// on by all of them, the integral of the velocity loop takes so many steps.
    pub fn pass(&mut self, periods: u32, steps: u32) {
        self.passed = [periods, steps];
    }

    /// What is added in this tick.
    pub fn excited(&mut self, excitation: Option<(Injection, f64)>) -> &mut Self {
        self.added = match excitation {
            Some((Injection::Velocity, rad_per_s)) if rad_per_s.is_finite() => [rad_per_s, 0.0],
            Some((Injection::Torque, torque_nm)) if torque_nm.is_finite() => [0.0, torque_nm],
            _ => [0.0; 2],
        };
        self
    }

    /// Command of the velocity loop and the rate that it was closed on in the last tick, for the log.
    pub fn closed_on_rad_per_s(&self) -> [f64; 2] {
        self.closed_on_rad_per_s
    }

    /// The torque for this tick. `rate_rad_per_s` is what the velocity loop is closed on; `wanted` is the segment's
    /// setpoint, without one the axis follows its own reference.
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
            // The drive's own loop makes the torque: what it shows is what goes on.
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
        let velocity = match (&mut self.detuned, wanted) {
            (Some(detuned), Some(_)) => detuned,
            _ => &mut self.velocity,
        };
        for _ in 1..self.passed[1] {
            velocity.update(command, rate_rad_per_s, feed_forward_nm);
        }
        let torque_nm = velocity.update(command, rate_rad_per_s, feed_forward_nm) + added_nm;
        torque_nm.clamp(-self.max_torque_nm, self.max_torque_nm)
    }

    /// What really went out, for a bumpless change of mode.
    pub fn sent(&mut self, torque_nm: f64) {
        self.sent_nm = torque_nm;
    }

    /// Torque that went out last.
    pub fn sent_nm(&self) -> f64 {
        self.sent_nm
    }

    /// Position reference less position in the last tick; `None` where no position loop was closed.
    pub fn following_error_rad(&self) -> Option<f64> {
        self.following_error_rad
    }

    /// Setpoint of this tick, for the log.
    pub fn setpoint(&self) -> &Setpoint {
        &self.setpoint
    }

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
mod tests {
    use super::*;
    use crate::files::parameters;
    use crate::files::rig::read_rig;
    use crate::files::shipped::{self, Folder};

    fn azimuth() -> AxisLoop {
        let source = shipped::find(Folder::Rigs, "sim", None).expect("shipped");
        let rig = read_rig(source).expect("a shipped rig parses");
        let gains = parameters::load(&rig).expect("shipped parameters");
        AxisLoop::of_rig(&rig, &gains).remove(0)
    }

    fn excited(into: Injection, value: f64, gain_ratio: Option<f64>) -> AxisLoop {
        let mut axis_loop = azimuth();
        let still = Actuals::default();
        let segment = Segment { gain_ratio, ..Segment::hold("excited", Mode::Velocity, 1.0) };
        axis_loop.enter(&segment, 0.0);
        let excitation = Some((into, value));
        let torque_nm = axis_loop.excited(excitation).torque(&still, 0.0, Some(&Setpoint::default()));
        axis_loop.sent(torque_nm);
        axis_loop
    }

    /// A stop that began in the middle of an excitation would push the axis on for as long as it lasts.
    #[test]
    fn nothing_of_an_excitation_is_left_in_an_emergency_stop() {
        for (into, value) in [(Injection::Torque, 300.0), (Injection::Velocity, 0.03)] {
            let mut axis_loop = excited(into, value, None);
            let still = Actuals::default();
            axis_loop.start_emergency_stop(&still, 1.7, 150.0, 0.0);
            for _ in 0..100 {
                let torque_nm = axis_loop.torque(&still, 0.0, None);
                assert!(torque_nm.abs() < 1.0, "{into:?}: {torque_nm} N*m");
                axis_loop.sent(torque_nm);
            }
        }
    }

    #[test]
    fn a_loosened_loop_does_not_keep_the_excitation_of_the_tick_in_which_it_began() {
        let mut axis_loop = excited(Injection::Torque, 300.0, None);
        let still = Actuals::default();
        let detuned = Segment { gain_ratio: Some(0.0), ..Segment::hold("detuned", Mode::Velocity, 1.0) };
        axis_loop.enter(&detuned, 0.0);
        let torque_nm = axis_loop.excited(None).torque(&still, 0.0, Some(&Setpoint::default()));
        assert!(torque_nm.abs() < 1e-9, "{torque_nm}");
    }

    /// Torque and reference after 100 periods of a move, with all ticks or with a gap of 33 periods.
    fn moved(ticks: &[u32]) -> (f64, Reference) {
        let mut axis_loop = azimuth();
        let still = Actuals::default();
        axis_loop.go_slowly(&still, 0.5);
        let mut torque_nm = 0.0;
        for &periods in ticks {
            axis_loop.pass(periods, periods);
            // An axis that follows its reference, a little too slowly.
            let position_rad = axis_loop.reference.reference().position_rad;
            let actuals = Actuals { position_rad, ..still };
            torque_nm = axis_loop.torque(&actuals, 0.9 * axis_loop.setpoint.velocity_rad_per_s, None);
            axis_loop.sent(torque_nm);
        }
        (torque_nm, axis_loop.reference.reference())
    }

    #[test]
    fn reference_and_integral_go_on_in_time_over_missed_periods() {
        let (whole_nm, whole) = moved(&[1; 100]);
        let (gap_nm, gap) = moved(&[&[1; 60][..], &[33], &[1; 7]].concat());
        assert!((gap.position_rad - whole.position_rad).abs() < 1e-12, "{gap:?} {whole:?}");
        assert!((gap_nm - whole_nm).abs() < 0.05 * whole_nm.abs(), "{gap_nm} N·m instead of {whole_nm}");
    }

    #[test]
    fn what_is_no_number_excites_nothing_and_nothing_exceeds_the_limit() {
        let still = Actuals::default();
        let mut axis_loop = azimuth();
        axis_loop.enter(&Segment::hold("excited", Mode::Velocity, 1.0), 0.0);
        let not_a_number = Some((Injection::Torque, f64::NAN));
        let torque_nm = axis_loop.excited(not_a_number).torque(&still, 0.0, Some(&Setpoint::default()));
        assert_eq!(torque_nm, 0.0);
        let too_much = Some((Injection::Torque, 1e9));
        let torque_nm = axis_loop.excited(too_much).torque(&still, 0.0, Some(&Setpoint::default()));
        assert_eq!(torque_nm, axis_loop.max_torque_nm);
    }
}
