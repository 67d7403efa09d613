//! Commands over time: pure functions of the time since the segment's start.

use serde::{Deserialize, Serialize};

use crate::excitation::{Excitation, Injection};

mod knots;
mod profile;
#[cfg(test)]
mod tests;

pub use knots::{Knot, KnotsError, knots};
pub use profile::Profile;

/// Largest gain of the position loop that a step is planned for: the production one is 4.5 1/s on both axes, up to 4.76 by
/// elevation in the study.
pub const STEP_GAIN_PER_S: f64 = 5.0;
/// The velocity loops of the director cross over at 4.4 Hz at the most; their gain over inertia is 0.8 of that.
pub const STEP_CROSSOVER_RAD_PER_S: f64 = std::f64::consts::TAU * 4.5;
/// By how much a step may overshoot in a plan.
pub const STEP_OVERSHOOT_RATIO: f64 = 0.1;

/// What a stimulus asks for at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Setpoint {
    /// Position, for position mode.
    pub position_rad: f64,
    /// Velocity, for velocity mode, and feed-forward in position mode.
    pub velocity_rad_per_s: f64,
    /// Acceleration, feed-forward.
    pub acceleration_rad_per_s2: f64,
    /// Motor torque, for torque mode.
    pub torque_nm: f64,
}

/// Limits of a jerk-limited profile.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProfileLimits {
    /// Cruise velocity.
    pub velocity_rad_per_s: f64,
    /// Largest acceleration.
    pub acceleration_rad_per_s2: f64,
    /// Largest jerk.
    pub jerk_rad_per_s3: f64,
}

/// One line of a multisine in torque.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Frequency.
    pub frequency_hz: f64,
    /// Amplitude.
    pub amplitude_nm: f64,
    /// Phase of the cosine.
    pub phase_rad: f64,
}

/// A command over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Stimulus {
    /// Stay: position mode holds the place where the segment started, velocity mode zero, torque mode `torque_nm`.
    Hold {
        /// Torque in torque mode.
        torque_nm: f64,
    },
    /// A jerk-limited move from where the segment starts to a target; rests there once reached.
    Move {
        /// Where to.
        target_rad: f64,
        /// Limits on the way.
        limits: ProfileLimits,
    },
    /// Jerk-limited strokes between two limits, there and back, `cycles` times; starts at `from_rad`.
    Reversals {
        /// Where the first stroke starts.
        from_rad: f64,
        /// Where it turns.
        to_rad: f64,
        /// Limits of each stroke; `velocity_rad_per_s` is the plateau.
        limits: ProfileLimits,
        /// Full cycles (two strokes each).
        cycles: u32,
    },
    /// A velocity that grows to a constant one, for velocity mode.
    Cruise {
        /// Velocity at the start, of the same sign.
        from_rad_per_s: f64,
        /// Velocity in the end, signed.
        velocity_rad_per_s: f64,
        /// Acceleration until then, a magnitude.
        acceleration_rad_per_s2: f64,
    },
    /// The command jumps to a place at once: for the response of the position loop to a small step.
    Step {
        /// Where to.
        target_rad: f64,
    },
    /// Whole periods of a sine about the place where the segment starts, faded in and out without a jump of rate or
    /// acceleration.
    Sine {
        /// Amplitude.
        amplitude_rad: f64,
        /// Frequency.
        frequency_hz: f64,
        /// Whole periods, both fades included.
        cycles: u32,
        /// Time of the fade at either end.
        fade_s: f64,
    },
    /// A path through places at times, smooth up to the acceleration; see [`knots`]. It begins at its first place.
    Trajectory {
        /// Ascending in time, the first at 0.
        knots: Vec<Knot>,
    },
    /// A torque that grows from `from_nm` at a constant signed rate.
    TorqueRamp {
        /// Torque at the start.
        from_nm: f64,
        /// Rate, signed.
        rate_nm_per_s: f64,
    },
    /// A periodic sum of cosines in torque about an offset, faded in over the first period.
    TorqueMultisine {
        /// Mean torque.
        offset_nm: f64,
        /// Period that all lines share.
        period_s: f64,
        /// Lines, each a multiple of 1/period.
        lines: Vec<Line>,
    },
}

impl Stimulus {
    /// The setpoint `t_s` after a start at `start_rad`.
    ///
    /// `Move` and `Reversals` build their profile on every call; the loop uses [`Stimulus::prepare`] instead.
    pub fn at(&self, start_rad: f64, t_s: f64) -> Setpoint {
        self.prepare(start_rad).at(t_s)
    }

    /// This stimulus with everything computed that does not depend on time: no allocation in
    /// [`Prepared::at`].
    pub fn prepare(&self, start_rad: f64) -> Prepared<'_> {
        let stroke = match self {
            Self::Move { target_rad, limits } => Some(Profile::new(target_rad - start_rad, limits)),
            Self::Reversals { from_rad, to_rad, limits, .. } => Some(Profile::new(to_rad - from_rad, limits)),
            _ => None,
        };
        Prepared { stimulus: self, start_rad, stroke }
    }

    /// How long the stimulus lasts from `start_rad` on; `None` if it has no end of its own.
    pub fn duration_s(&self, start_rad: f64) -> Option<f64> {
        match self {
            Self::Move { target_rad, limits } => {
                Some(Profile::new(target_rad - start_rad, limits).duration_s())
            }
            Self::Reversals { from_rad, to_rad, limits, cycles } => {
                let stroke_s = Profile::new(to_rad - from_rad, limits).duration_s();
                Some(2.0 * f64::from(*cycles) * stroke_s)
            }
            Self::Sine { frequency_hz, cycles, .. } => Some(f64::from(*cycles) / frequency_hz),
            Self::Trajectory { knots } => Some(knots.last().map_or(0.0, |knot| knot.time_s)),
            Self::Hold { .. }
            | Self::Step { .. }
            | Self::Cruise { .. }
            | Self::TorqueRamp { .. }
            | Self::TorqueMultisine { .. } => None,
        }
    }

    /// What it can ask of the axis when it starts anywhere inside `before` and lasts `at_most_s`.
    pub fn envelope(&self, before: &Envelope, at_most_s: f64) -> Envelope {
        let mut reach = Envelope::at(before.position_rad[0]);
        reach.join(&Envelope::at(before.position_rad[1]));
        match self {
            Self::Hold { torque_nm } => reach.torque_nm = torque_nm.abs(),
            Self::Move { target_rad, limits } => {
                reach.join(&Envelope::at(*target_rad));
                reach.take_limits(limits);
            }
            Self::Reversals { from_rad, to_rad, limits, .. } => {
                reach = Envelope::at(*from_rad);
                reach.join(&Envelope::at(*to_rad));
                reach.take_limits(limits);
            }
            Self::Cruise { velocity_rad_per_s: rate, acceleration_rad_per_s2, .. } => {
                let [low, high] = before.position_rad;
                let way = rate * at_most_s;
                reach.join(&Envelope::at(low + way.min(0.0)));
                reach.join(&Envelope::at(high + way.max(0.0)));
                reach.velocity_rad_per_s = rate.abs();
                reach.acceleration_rad_per_s2 = *acceleration_rad_per_s2;
            }
            Self::Step { target_rad } => reach.step_to(*target_rad),
            Self::Sine { amplitude_rad, frequency_hz, fade_s, .. } => {
                reach.widen_position(amplitude_rad.abs());
                let [rate, acceleration] = profile::sine_peaks(*amplitude_rad, *frequency_hz, *fade_s);
                (reach.velocity_rad_per_s, reach.acceleration_rad_per_s2) = (rate, acceleration);
            }
            Self::Trajectory { knots } => reach.join(&knots::reach(knots)),
            Self::TorqueRamp { from_nm, rate_nm_per_s } => {
                reach.torque_nm = from_nm.abs().max((from_nm + rate_nm_per_s * at_most_s).abs());
            }
            Self::TorqueMultisine { offset_nm, lines, .. } => {
                reach.torque_nm = offset_nm.abs() + lines.iter().map(|l| l.amplitude_nm.abs()).sum::<f64>();
            }
        }
        reach
    }
}

/// A stimulus that is ready to be asked every tick.
#[derive(Clone, Debug)]
pub struct Prepared<'a> {
    stimulus: &'a Stimulus,
    start_rad: f64,
    stroke: Option<Profile>,
}

impl Prepared<'_> {
    /// The setpoint at `t_s` after the start; before the start and after the end the nearest instant counts.
    pub fn at(&self, t_s: f64) -> Setpoint {
        let t_s = t_s.max(0.0);
        match (self.stimulus, &self.stroke) {
            (Stimulus::Move { .. }, Some(stroke)) => stroke.at(t_s).shifted(self.start_rad),
            (Stimulus::Reversals { from_rad, to_rad, cycles, .. }, Some(stroke)) => {
                strokes(*from_rad, *to_rad, *cycles, stroke, t_s)
            }
            (Stimulus::Cruise { from_rad_per_s, velocity_rad_per_s, acceleration_rad_per_s2 }, _) => {
                cruise(self.start_rad, [*from_rad_per_s, *velocity_rad_per_s], *acceleration_rad_per_s2, t_s)
            }
            (Stimulus::Step { target_rad }, _) => {
                Setpoint { position_rad: *target_rad, ..Setpoint::default() }
            }
            (Stimulus::Sine { amplitude_rad, frequency_hz, cycles, fade_s }, _) => {
                let lasts_s = f64::from(*cycles) / frequency_hz;
                profile::sine_at(*amplitude_rad, *frequency_hz, [lasts_s, *fade_s], t_s)
                    .shifted(self.start_rad)
            }
            (Stimulus::Trajectory { knots }, _) => knots::at(knots, t_s),
            (Stimulus::TorqueRamp { from_nm, rate_nm_per_s }, _) => {
                self.torque(from_nm + rate_nm_per_s * t_s)
            }
            (Stimulus::TorqueMultisine { offset_nm, period_s, lines }, _) => {
                let fade = (t_s / period_s).min(1.0);
                let wave: f64 = lines
                    .iter()
                    .map(|l| {
                        l.amplitude_nm * (std::f64::consts::TAU * l.frequency_hz * t_s + l.phase_rad).cos()
                    })
                    .sum();
                self.torque(offset_nm + fade * wave)
            }
            (Stimulus::Hold { torque_nm }, _) => self.torque(*torque_nm),
            (Stimulus::Move { .. } | Stimulus::Reversals { .. }, None) => self.torque(0.0),
        }
    }

    fn torque(&self, torque_nm: f64) -> Setpoint {
        Setpoint { position_rad: self.start_rad, torque_nm, ..Setpoint::default() }
    }
}

fn cruise(start_rad: f64, [from, to]: [f64; 2], acceleration: f64, t_s: f64) -> Setpoint {
    let ramp_s = (to - from).abs() / acceleration;
    let ramping = t_s < ramp_s;
    let ramped_s = t_s.min(ramp_s);
    let rate = if ramping { from + acceleration.copysign(to - from) * t_s } else { to };
    Setpoint {
        position_rad: start_rad + 0.5 * (from + rate) * ramped_s + to * (t_s - ramped_s),
        velocity_rad_per_s: rate,
        acceleration_rad_per_s2: if ramping { acceleration.copysign(to - from) } else { 0.0 },
        torque_nm: 0.0,
    }
}

fn strokes(from_rad: f64, to_rad: f64, cycles: u32, stroke: &Profile, t_s: f64) -> Setpoint {
    let last = (2 * cycles).saturating_sub(1);
    let stroke_s = stroke.duration_s();
    let index = if stroke_s > 0.0 { ((t_s / stroke_s) as u32).min(last) } else { last };
    let along = stroke.at(t_s - f64::from(index) * stroke_s);
    if index % 2 == 0 { along.shifted(from_rad) } else { along.reversed().shifted(to_rad) }
}

impl Setpoint {
    fn shifted(self, by_rad: f64) -> Self {
        Self { position_rad: self.position_rad + by_rad, ..self }
    }

    fn reversed(self) -> Self {
        Self {
            position_rad: -self.position_rad,
            velocity_rad_per_s: -self.velocity_rad_per_s,
            acceleration_rad_per_s2: -self.acceleration_rad_per_s2,
            torque_nm: -self.torque_nm,
        }
    }
}

/// The most that something asks of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Envelope {
    /// Lowest and highest position.
    pub position_rad: [f64; 2],
    /// Largest speed.
    pub velocity_rad_per_s: f64,
    /// Largest acceleration.
    pub acceleration_rad_per_s2: f64,
    /// Largest commanded torque in torque mode.
    pub torque_nm: f64,
}

impl Envelope {
    /// Standing still at one place.
    pub fn at(position_rad: f64) -> Self {
        Self {
            position_rad: [position_rad, position_rad],
            velocity_rad_per_s: 0.0,
            acceleration_rad_per_s2: 0.0,
            torque_nm: 0.0,
        }
    }

    /// Widens to hold `other` too.
    pub fn join(&mut self, other: &Self) {
        self.position_rad[0] = self.position_rad[0].min(other.position_rad[0]);
        self.position_rad[1] = self.position_rad[1].max(other.position_rad[1]);
        self.velocity_rad_per_s = self.velocity_rad_per_s.max(other.velocity_rad_per_s);
        self.acceleration_rad_per_s2 = self.acceleration_rad_per_s2.max(other.acceleration_rad_per_s2);
        self.torque_nm = self.torque_nm.max(other.torque_nm);
    }

    /// Adds what an excitation can do at the most: a torque by accelerating the axis, a rate as it is, both half as much
    /// again where the loop resonates. What a torque moves depends on the inertia, which the rig knows: see pre-flight.
    pub fn excite(&mut self, excitation: &Excitation) {
        const RESONANCE: f64 = 1.5;
        match excitation.into {
            Injection::Torque => self.torque_nm += excitation.peak(),
            Injection::Velocity => {
                self.velocity_rad_per_s += RESONANCE * excitation.peak();
                self.widen_position(RESONANCE * excitation.signal.integral_peak());
            }
            Injection::MirrorAz | Injection::MirrorEl => {}
        }
    }

    /// Adds a margin on both sides of the position.
    pub fn widen_position(&mut self, by_rad: f64) {
        self.position_rad[0] -= by_rad;
        self.position_rad[1] += by_rad;
    }

    /// What the axis makes of a jump of its position command: the position loop answers with a rate of at most
    /// [`STEP_GAIN_PER_S`] times the step, the velocity loop follows that with its crossover.
    fn step_to(&mut self, target_rad: f64) {
        let height = self.position_rad.iter().map(|from| (target_rad - from).abs()).fold(0.0, f64::max);
        self.join(&Self::at(target_rad));
        self.widen_position(STEP_OVERSHOOT_RATIO * height);
        self.velocity_rad_per_s = STEP_GAIN_PER_S * height;
        self.acceleration_rad_per_s2 = STEP_CROSSOVER_RAD_PER_S * self.velocity_rad_per_s;
    }

    fn take_limits(&mut self, limits: &ProfileLimits) {
        self.velocity_rad_per_s = limits.velocity_rad_per_s;
        self.acceleration_rad_per_s2 = limits.acceleration_rad_per_s2;
    }
}
