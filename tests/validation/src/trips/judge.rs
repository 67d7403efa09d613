//! What a trial proves: the command changed in time, the axis stopped where it was computed to.

use bench::model::axis::AxisGuard;
use bench::model::stopping::StopModel;

use super::cause::{Braking, CAUSES, Cause};
use super::draw::Plan;
use super::run::{Witnessed, undisturbed};
use super::tap::Sample;
use super::{Bed, Pose, Trial};

/// Slower than this is standing still (safety.md: standstill).
const STANDSTILL_RAD_PER_S: f64 = 0.05 * std::f64::consts::PI / 180.0;
/// Faster than this an axis that loses its torque coasts; slower it is let go at rest.
const COASTS_RAD_PER_S: f64 = 0.2 * std::f64::consts::PI / 180.0;
/// A predicted contact may be faster by this much: unbalance and spring between travel and stop, cogging.
const IMPACT_RATIO: f64 = 1.01;
const IMPACT_RAD_PER_S: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// Ticks that may pass between the inputs that show a cause and the command that answers it.
const ANSWER_TICKS: u64 = 1;
/// Statuswords (bits 0 to 3, 5, 6) with torque: operation enabled, quick stop, fault reaction.
const WITH_TORQUE: [u16; 3] = [0x27, 0x07, 0x0F];

pub(super) fn judge(bed: &Bed, plan: Plan, witnessed: &Witnessed) -> Trial {
    let guard = &plan.variation.guard(&bed.rig.axes[plan.axis].guard);
    let cause = &CAUSES[plan.cause];
    let samples = &witnessed.samples;
    let caused = witnessed.caused_s.map_or(0, |s| first(samples, |x| x.time_s >= s));
    // A weak motor or a full DC link may have ended the motion before its cause had its turn.
    let began = witnessed
        .outcome
        .stops
        .iter()
        .find(|stop| stop.axis() == plan.axis)
        .map(|stop| first(samples, |sample| sample.time_s >= stop.began().as_secs_f64()));
    let early =
        began.filter(|began| *began < caused || witnessed.caused_s.is_none_or(|s| not_reached(samples, s)));
    let caused = early.unwrap_or(caused);
    let answer = match early {
        Some(tick) => Answer { seen: Some(tick), command: Some(tick) },
        None => Answer::find(bed, &plan, witnessed, cause, guard, caused),
    };
    let seen = answer.seen.unwrap_or(caused);
    // From the first of these on friction alone brakes at the worst: the drive is dead, or the link takes nothing.
    let dead = without_torque(samples, plan.axis, caused);
    let full = (caused..samples.len()).find(|&k| samples[k].bus_v > guard.safety.bus_voltage_v[1]);
    let moves = |k: &usize| pose(samples, plan.axis, *k).rate_rad_per_s.abs() > COASTS_RAD_PER_S;
    let lost = dead.into_iter().chain(full).filter(moves).min();
    // What an axis does that was stopped before it was let go is a swing, not a part of its stop.
    let end = if lost.is_some() { samples.len() } else { dead.unwrap_or(samples.len()).max(seen + 1) };
    let stop = &guard.stop;
    let mut trial = Trial {
        caused: pose(samples, plan.axis, caused),
        seen: pose(samples, plan.axis, seen),
        hidden_ticks: (seen - caused) as u64,
        answered_ticks: answer.command.map(|tick| (tick - seen) as u64),
        first_out: first_out(witnessed),
        lost_torque: lost.is_some(),
        computed_rad: 0.0,
        reached_rad: 0.0,
        computed_s: None,
        reached_s: 0.0,
        room_rad: 0.0,
        predicted: None,
        impact_rad_per_s: None,
        breaches: Vec::new(),
        plan,
    };
    trial.measure(stop, &samples[..end.min(samples.len())], lost.unwrap_or(seen));
    trial.impact(witnessed, bed);
    let excuses = Excuses {
        torque: early.is_some() || full.is_some(),
        time: early.is_some() && cause.falsifies_gyro(trial.plan.axis),
    };
    trial.rules(cause, stop, witnessed, samples, excuses);
    trial.record(witnessed);
    trial
}

/// Rules that a trial need not keep.
#[derive(Clone, Copy)]
struct Excuses {
    /// A weak motor ended the motion before its cause, or a full link took away the torque.
    torque: bool,
    /// The gyro began to lie while a stop was under way: the bench believes that the axis still moves, and waits for it.
    time: bool,
}

/// Whether a run was over before this time.
fn not_reached(samples: &[Sample], time_s: f64) -> bool {
    samples.last().is_none_or(|last| last.time_s < time_s)
}

/// When the cause could be seen, and when the command changed.
struct Answer {
    seen: Option<usize>,
    command: Option<usize>,
}

impl Answer {
    fn find(
        bed: &Bed,
        plan: &Plan,
        witnessed: &Witnessed,
        cause: &Cause,
        guard: &AxisGuard,
        caused: usize,
    ) -> Self {
        let samples = &witnessed.samples;
        // The command of a tick goes out with the next exchange.
        let left_operation = |from: usize| {
            (from..samples.len().saturating_sub(1)).find(|&k| samples[k + 1].controlword[plan.axis] != 0x0F)
        };
        let Some(shows) = cause.seen else {
            // Only the interlocks can tell: what they saw is seen in the tick in which they act.
            let enabled = |k: &usize| samples[*k].controlword[plan.axis] == 0x0F;
            let from = (caused..samples.len()).find(enabled).unwrap_or(caused);
            // A rate that does not come any more is missed when its age is over, not before.
            let stale_s = guard.safety.watchdog_s + 0.5 / bed.rig.loop_rate_hz;
            let missed = witnessed.outcome.trip.is_some_and(|trip| trip.interlock == "rate feedback");
            let over_s = samples[from].time_s + stale_s;
            let from = if missed { first(samples, |x| x.time_s > over_s) } else { from };
            let until = left_operation(from).unwrap_or(samples.len() - 1);
            let command = Self::changed(bed, plan, samples, from, until);
            let command =
                if witnessed.outcome.trip.is_some_and(|trip| trip.steerable) { command } else { Some(until) };
            return Self { seen: command, command };
        };
        let Some(seen) = (caused..samples.len()).find(|&k| shows(&samples[k], plan.axis, guard)) else {
            return Self { seen: None, command: None };
        };
        let out = left_operation(seen);
        let soon = out.filter(|&k| k <= seen + ANSWER_TICKS as usize);
        let command = soon.or_else(|| Self::changed(bed, plan, samples, seen, seen + 40)).or(out);
        Self { seen: Some(seen), command }
    }

    /// The first tick whose command is not what it would have been without the cause.
    fn changed(bed: &Bed, plan: &Plan, samples: &[Sample], from: usize, until: usize) -> Option<usize> {
        let without = undisturbed(bed, plan, until + 2);
        let differs = |k: &usize| {
            let with = samples.get(k + 1);
            let without = without.get(k + 1);
            with.zip(without).is_some_and(|(a, b)| {
                a.torque_permille != b.torque_permille || a.controlword != b.controlword
            })
        };
        (from..=until).find(differs)
    }
}

impl Trial {
    /// Angles and times from sample `from` on.
    fn measure(&mut self, stop: &StopModel, samples: &[Sample], from: usize) {
        let axis = self.plan.axis;
        // Torque may have gone at any time since the sample before.
        let from = if self.lost_torque { from.saturating_sub(1) } else { from };
        let begun = pose(samples, axis, from);
        let ahead = if begun.rate_rad_per_s >= 0.0 { 1.0 } else { -1.0 };
        let farthest = samples[from..].iter().map(|s| ahead * (s.truth.angle_rad[axis] - begun.angle_rad));
        self.reached_rad = farthest.fold(0.0, f64::max);
        let moving = samples.iter().rposition(|s| s.truth.rate_rad_per_s[axis].abs() >= STANDSTILL_RAD_PER_S);
        self.reached_s = moving.map_or(0.0, |k| (samples[k].time_s - samples[from].time_s).max(0.0));
        // Soft limits are angles of the encoder.
        let shown_rad = begun.angle_rad - self.plan.variation.zero_rad[axis];
        self.room_rad = stop.room_rad(shown_rad, begun.rate_rad_per_s) - self.reached_rad;
        let hidden_s = CAUSES[self.plan.cause].hidden_s;
        let rate = begun.rate_rad_per_s;
        let hardest = stop.deceleration_rad_per_s2;
        // While nobody can tell, a loop on a broken sensor may speed the axis up with all that it has.
        let hidden_rad = rate.abs() * hidden_s + 0.5 * hardest * hidden_s * hidden_s;
        let told = rate + ahead * hardest * hidden_s;
        let acceleration = (ahead * acceleration_rad_per_s2(samples, axis, from)).max(0.0);
        let controlled = stop.controlled_from(told, acceleration, hardest);
        // A drive that does not see the axis, or does not obey, brakes nothing, whatever its state says.
        if self.lost_torque || CAUSES[self.plan.cause].braking == Braking::Friction {
            let told = if self.lost_torque { rate } else { told };
            let coast = stop.coast(begun.angle_rad, told);
            self.computed_rad = ahead * (coast.end_rad - begun.angle_rad);
            // What the drive still did between the cause and its end may have been worse than nothing.
            let from_cause = stop.coast(self.caused.angle_rad, self.caused.rate_rad_per_s).impact;
            let unbraked = CAUSES[self.plan.cause].braking == Braking::Friction;
            // With a drive that does not see the axis the bench brakes on the gyro, or settles on it.
            if !self.lost_torque {
                self.computed_rad = (self.computed_rad + hidden_rad).max(controlled.angle_rad + hidden_rad);
            }
            let both = coast.impact.into_iter().chain(from_cause.filter(|_| unbraked));
            self.predicted = both.max_by(|a, b| a.energy_j.total_cmp(&b.energy_j));
        } else {
            self.computed_rad = controlled.angle_rad + hidden_rad;
            self.computed_s = Some(controlled.time_s + hidden_s);
        }
    }

    fn impact(&mut self, witnessed: &Witnessed, bed: &Bed) {
        let name = &bed.rig.axes[self.plan.axis].name;
        let contact = witnessed.world.crashes.iter().find(|(axis, ..)| axis == name);
        self.impact_rad_per_s = contact.map(|(_, _, speed)| *speed);
        if let Some((axis, _, speed)) = witnessed.world.crashes.iter().find(|(axis, ..)| axis != name) {
            self.breach(format!(
                "{axis}, which was at rest, met its stop at {:.2} deg/s",
                speed.to_degrees()
            ));
        }
    }

    fn rules(
        &mut self,
        cause: &Cause,
        stop: &StopModel,
        witnessed: &Witnessed,
        samples: &[Sample],
        excuses: Excuses,
    ) {
        let moved = self.seen.rate_rad_per_s.abs() > STANDSTILL_RAD_PER_S;
        if witnessed.caused_s.is_none() {
            self.breach("the drives never came into operation".to_owned());
        }
        match self.answered_ticks {
            None if witnessed.outcome.trip.is_none() && witnessed.outcome.signal.is_none() => {
                self.breach("nothing tripped".to_owned());
            }
            Some(ticks) if ticks <= ANSWER_TICKS => {}
            ticks => self.breach(format!("the command changed after {ticks:?} ticks")),
        }
        if cause.braking == Braking::Torque && self.lost_torque && moved && !excuses.torque {
            self.breach("torque was lost that should have braked".to_owned());
        }
        if self.computed_s.is_some() && self.room_rad < 0.0 {
            self.breach(format!("{:.3} deg beyond the soft limit", -self.room_rad.to_degrees()));
        }
        if self.reached_rad > self.computed_rad && self.predicted.is_none() {
            let reached = self.reached_rad.to_degrees();
            let computed = self.computed_rad.to_degrees();
            self.breach(format!("{reached:.3} deg instead of {computed:.3} deg at the worst"));
        }
        if let Some(limit_s) = self.computed_s.filter(|limit_s| self.reached_s > *limit_s && !excuses.time) {
            self.breach(format!("{:.3} s instead of {limit_s:.3} s at the worst", self.reached_s));
        }
        self.contacts(stop);
        let axis = self.plan.axis;
        let moves =
            samples.last().is_some_and(|s| s.truth.rate_rad_per_s[axis].abs() >= STANDSTILL_RAD_PER_S);
        if moves && witnessed.outcome.safe.standstill {
            self.breach("called standstill, but it moves".to_owned());
        }
    }

    /// What the record of the stop says is compared with the world: it must not read well where it was not.
    fn record(&mut self, witnessed: &Witnessed) {
        let outcome = &witnessed.outcome;
        let Some(stop) = outcome.stops.iter().find(|stop| stop.axis() == self.plan.axis) else {
            if self.impact_rad_per_s.is_some() {
                self.breach("met its stop, and no stop is on record".to_owned());
            }
            return;
        };
        if self.impact_rad_per_s.is_some() && stop.room_rad() >= 0.0 && stop.standstill() {
            let room_deg = stop.room_rad().to_degrees();
            self.breach(format!("met its stop, and the record says that {room_deg:.3} deg were left"));
        }
    }

    fn contacts(&mut self, stop: &StopModel) {
        let Some(speed) = self.impact_rad_per_s else { return };
        let deg_per_s = speed.to_degrees();
        match self.predicted {
            None => self.breach(format!("met its stop at {deg_per_s:.2} deg/s, which nobody had predicted")),
            Some(p) if speed > IMPACT_RATIO * p.speed_rad_per_s + IMPACT_RAD_PER_S => {
                let energy_j = 0.5 * stop.inertia_kg_m2 * speed * speed;
                let predicted = p.speed_rad_per_s.to_degrees();
                let by_energy = p.energy_j;
                self.breach(format!(
                    "met its stop at {deg_per_s:.2} deg/s ({energy_j:.0} J), predicted {predicted:.2} deg/s ({by_energy:.0} J)"
                ));
            }
            Some(_) => {}
        }
    }

    fn breach(&mut self, text: String) {
        self.breaches.push(text);
    }
}

fn first(samples: &[Sample], is: impl Fn(&Sample) -> bool) -> usize {
    samples.iter().position(is).unwrap_or_else(|| samples.len().saturating_sub(1))
}

fn pose(samples: &[Sample], axis: usize, at: usize) -> Pose {
    samples.get(at).map_or(Pose::default(), |s| Pose {
        angle_rad: s.truth.angle_rad[axis],
        rate_rad_per_s: s.truth.rate_rad_per_s[axis],
    })
}

/// True acceleration over the last 4 ms before a sample.
fn acceleration_rad_per_s2(samples: &[Sample], axis: usize, at: usize) -> f64 {
    const TICKS: usize = 16;
    let before = samples[at.saturating_sub(TICKS)];
    let now = samples[at];
    let lasts_s = now.time_s - before.time_s;
    if lasts_s > 0.0 {
        (now.truth.rate_rad_per_s[axis] - before.truth.rate_rad_per_s[axis]) / lasts_s
    } else {
        0.0
    }
}

/// The first sample after the cause in which the drive says that it has no torque.
fn without_torque(samples: &[Sample], axis: usize, caused: usize) -> Option<usize> {
    (caused..samples.len())
        .find(|&k| samples[k].bad_in_row == 0 && !WITH_TORQUE.contains(&(samples[k].statusword[axis] & 0x6F)))
}

fn first_out(witnessed: &Witnessed) -> String {
    let outcome = &witnessed.outcome;
    match (&outcome.trip, outcome.signal, &outcome.error) {
        (Some(trip), ..) => trip.interlock.to_owned(),
        (None, Some(code), _) => format!("signal {code}"),
        (None, None, Some(error)) => error.to_string(),
        (None, None, None) => "nothing".to_owned(),
    }
}
