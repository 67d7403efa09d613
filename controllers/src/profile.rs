//! On-line jerk-limited references: towards a target, or to a stop, from whatever motion there is.

use crate::finite_or_zero;

/// Limits of a reference; all > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionLimits {
    /// Largest speed.
    pub velocity_rad_per_s: f64,
    /// Largest acceleration, also when braking.
    pub acceleration_rad_per_s2: f64,
    /// Largest jerk.
    pub jerk_rad_per_s3: f64,
}

/// A point of a reference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reference {
    /// Angle.
    pub position_rad: f64,
    /// Rate of the setpoint: the feed-forward of the position loop.
    pub velocity_rad_per_s: f64,
    /// Acceleration of the setpoint: times inertia the feed-forward of the velocity loop.
    pub acceleration_rad_per_s2: f64,
}

/// Bisections of the cruise velocity: down to the last bit of a double.
const HALVINGS: u32 = 64;

/// Constant jerk for some time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Phase {
    jerk: f64,
    duration_s: f64,
}

/// Makes a reference that stays within its limits.
///
/// Every change of the goal plans anew from the present position, velocity and acceleration: a change of velocity to
/// some cruise velocity, the cruise, and a change of velocity to rest, each with at most three phases of constant
/// jerk. The plan is exact in continuous time and sampled each tick, so it ends exactly at its target whatever the
/// sample period. It passes the target only if the motion it starts from cannot stop before it.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileGenerator {
    limits: MotionLimits,
    start: Reference,
    phases: [Phase; 7],
    elapsed_s: f64,
    /// Where the plan ends, at rest.
    end_rad: f64,
}

impl ProfileGenerator {
    /// A generator at rest; `None` unless all limits are finite and above 0.
    pub fn new(limits: MotionLimits, position_rad: f64) -> Option<Self> {
        let MotionLimits { velocity_rad_per_s: v, acceleration_rad_per_s2: a, jerk_rad_per_s3: j } = limits;
        let valid = [v, a, j].iter().all(|limit| limit.is_finite() && *limit > 0.0);
        let end_rad = finite_or_zero(position_rad);
        let start = Reference { position_rad: end_rad, ..Reference::default() };
        let phases = [Phase::default(); 7];
        valid.then_some(Self { limits, start, phases, elapsed_s: 0.0, end_rad })
    }

    /// Takes over a motion, e.g. a measured one, and stops it. Velocity and acceleration beyond the limits are cut.
    pub fn take_over(&mut self, motion: Reference) {
        let MotionLimits { velocity_rad_per_s: v, acceleration_rad_per_s2: a, jerk_rad_per_s3: j } =
            self.limits;
        let velocity = finite_or_zero(motion.velocity_rad_per_s).max(-v).min(v);
        // What acceleration adds to the speed while it is taken away must stay within the limit, too.
        let up = a.min(libm::sqrt(2.0 * j * (v - velocity)));
        let down = a.min(libm::sqrt(2.0 * j * (v + velocity)));
        let acceleration = finite_or_zero(motion.acceleration_rad_per_s2).max(-down).min(up);
        self.end_rad = finite_or_zero(motion.position_rad);
        let position_rad = self.end_rad;
        let velocity_rad_per_s = velocity;
        let acceleration_rad_per_s2 = acceleration;
        self.begin(Reference { position_rad, velocity_rad_per_s, acceleration_rad_per_s2 });
        self.plan_stop();
    }

    /// Heads for a target; one that is not finite is ignored.
    pub fn move_to(&mut self, target_rad: f64) {
        if target_rad.is_finite() {
            self.begin(self.reference());
            self.plan(target_rad - self.start.position_rad);
            self.end_rad = target_rad;
        }
    }

    /// Comes to rest as soon as the limits of acceleration and jerk allow.
    pub fn stop(&mut self) {
        self.begin(self.reference());
        self.plan_stop();
    }

    /// One tick on: the reference `period_s` later.
    pub fn advance(&mut self, period_s: f64) -> Reference {
        self.elapsed_s += finite_or_zero(period_s).max(0.0);
        self.reference()
    }

    /// The reference now.
    pub fn reference(&self) -> Reference {
        if self.is_at_rest() {
            return Reference { position_rad: self.end_rad, ..Reference::default() };
        }
        let mut now = self.start;
        let mut left_s = self.elapsed_s;
        for phase in &self.phases {
            let within_s = left_s.min(phase.duration_s);
            now = after(now, phase.jerk, within_s);
            left_s -= within_s;
        }
        now
    }

    /// Whether the end of the plan is reached: at the target, or stopped.
    pub fn is_at_rest(&self) -> bool {
        self.elapsed_s >= self.duration_s()
    }

    /// Time from the last change of the goal to rest.
    pub fn duration_s(&self) -> f64 {
        self.phases.iter().map(|phase| phase.duration_s).sum()
    }

    /// Where the plan comes to rest.
    pub fn end_rad(&self) -> f64 {
        self.end_rad
    }

    fn begin(&mut self, start: Reference) {
        self.start = start;
        self.elapsed_s = 0.0;
        self.phases = [Phase::default(); 7];
    }

    fn set_phases(&mut self, first: [Phase; 3], cruise: Phase, last: [Phase; 3]) {
        self.phases[..3].copy_from_slice(&first);
        self.phases[3] = cruise;
        self.phases[4..].copy_from_slice(&last);
    }

    fn plan_stop(&mut self) {
        let change = self.change(self.start, 0.0);
        self.set_phases(change, Phase::default(), [Phase::default(); 3]);
        self.end_rad = self.start.position_rad + displacement(self.start, &change);
    }

    /// Finds the cruise velocity for a displacement.
    ///
    /// Beyond the point where an immediate stop ends, the cruise velocity lies in [0, v], before it in [−v, 0]: the
    /// displacement without cruise time is continuous in it and equals the immediate stop at 0. If the largest
    /// velocity is not too much it is cruised at; otherwise bisection finds the velocity, and a short cruise
    /// takes up what its last bit leaves.
    fn plan(&mut self, distance_rad: f64) {
        let immediate_rad = displacement(self.start, &self.change(self.start, 0.0));
        let sign = if distance_rad < immediate_rad { -1.0 } else { 1.0 };
        let missing = |cruise: f64| sign * (distance_rad - self.without_cruise(sign * cruise));
        let mut low = 0.0;
        let mut high = self.limits.velocity_rad_per_s;
        if missing(high) >= 0.0 {
            low = high;
        }
        for _ in 0..HALVINGS {
            let middle = low + (high - low) / 2.0;
            if missing(middle) >= 0.0 { low = middle } else { high = middle }
        }
        let left_rad = missing(low).max(0.0);
        let cruise_s = if low > 0.0 { left_rad / low } else { 0.0 };
        let first = self.change(self.start, sign * low);
        let last = self.change(steady(sign * low), 0.0);
        self.set_phases(first, Phase { jerk: 0.0, duration_s: cruise_s }, last);
    }

    /// Displacement of going to a cruise velocity and at once on to rest.
    fn without_cruise(&self, cruise_rad_per_s: f64) -> f64 {
        let there = displacement(self.start, &self.change(self.start, cruise_rad_per_s));
        let cruise = steady(cruise_rad_per_s);
        there + displacement(cruise, &self.change(cruise, 0.0))
    }

    /// The quickest change to a velocity at zero acceleration.
    ///
    /// Acceleration goes from a0 to a peak ±A, stays, and goes to 0. With A unlimited, Δv = (2A² − a0²)/(2j) in the
    /// direction of the change.
    fn change(&self, from: Reference, to_rad_per_s: f64) -> [Phase; 3] {
        let j = self.limits.jerk_rad_per_s3;
        let limit = self.limits.acceleration_rad_per_s2;
        let a0 = from.acceleration_rad_per_s2;
        let coasting = from.velocity_rad_per_s + a0 * a0.abs() / (2.0 * j);
        let sign = if to_rad_per_s < coasting { -1.0 } else { 1.0 };
        let along = sign * a0;
        let wanted = sign * (to_rad_per_s - from.velocity_rad_per_s);
        let square = (j * wanted + along * along / 2.0).max(0.0);
        // Rounding must not let the peak fall below where the acceleration already is.
        let peak = libm::sqrt(square).min(limit).max(along).max(0.0);
        let constant_s = if peak > 0.0 { ((square - peak * peak) / (j * peak)).max(0.0) } else { 0.0 };
        [
            Phase { jerk: sign * j, duration_s: (peak - along) / j },
            Phase { jerk: 0.0, duration_s: constant_s },
            Phase { jerk: -sign * j, duration_s: peak / j },
        ]
    }
}

fn steady(velocity_rad_per_s: f64) -> Reference {
    Reference { velocity_rad_per_s, ..Reference::default() }
}

/// The motion after some time of constant jerk.
fn after(from: Reference, jerk: f64, t: f64) -> Reference {
    let Reference { position_rad: p, velocity_rad_per_s: v, acceleration_rad_per_s2: a } = from;
    Reference {
        position_rad: p + t * (v + t * (a / 2.0 + t * jerk / 6.0)),
        velocity_rad_per_s: v + t * (a + t * jerk / 2.0),
        acceleration_rad_per_s2: a + t * jerk,
    }
}

/// How far some phases lead.
fn displacement(from: Reference, phases: &[Phase]) -> f64 {
    let start = Reference { position_rad: 0.0, ..from };
    phases.iter().fold(start, |now, phase| after(now, phase.jerk, phase.duration_s)).position_rad
}

#[cfg(test)]
mod tests;
