//! The course of a point: where the axis is and how fast, instant by instant, as far as that is planned.

use procedures::case::{Case, Mode, Segment};
use procedures::excitation::{Excitation, Injection, Sine};
use procedures::stimulus::{
    Profile, ProfileLimits, STEP_CROSSOVER_RAD_PER_S, STEP_GAIN_PER_S, STEP_OVERSHOOT_RATIO, Stimulus,
};

use super::torque_mode::{self, Bounded};
use crate::model::axis::RigAxis;

/// Step of the samples where the rate changes.
const STEP_S: f64 = 5e-3;

/// One instant of a plan, and how long it stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Instant {
    pub(super) for_s: f64,
    pub(super) position_rad: f64,
    pub(super) rate_rad_per_s: f64,
    pub(super) acceleration_rad_per_s2: f64,
    /// What an excitation has added to that at its peak, and its root mean square.
    pub(super) swing_rad_per_s2: [f64; 2],
}

/// A part of a point's course.
#[derive(Debug)]
pub(super) enum Stretch<'a> {
    /// From rest to rest in one direction; place and rate are planned. `repeats` times in the whole point.
    Stroke { instants: Vec<Instant>, repeats: u32 },
    /// Torque is planned, place and rate are only bounded.
    Torque { segment: &'a Segment, bounded: Bounded },
}

impl Stretch<'_> {
    /// Place and rate in the end, where they are planned.
    pub(super) fn end(&self) -> Option<(f64, f64)> {
        match self {
            Self::Stroke { instants, .. } => instants.last().map(|i| (i.position_rad, i.rate_rad_per_s)),
            Self::Torque { .. } => None,
        }
    }
}

/// The course of a point on its axis.
pub(super) fn stretches<'a>(case: &'a Case, axis: &RigAxis) -> Vec<Stretch<'a>> {
    let start_rad = case.start_pose_rad.get(&case.axis).copied().unwrap_or(0.0);
    let mut here = [start_rad, start_rad];
    let mut all = Vec::new();
    for segment in &case.segments {
        if segment.mode == Mode::Torque {
            let bounded = torque_mode::bounds(case, segment, axis, here);
            here = bounded.after_rad;
            all.push(Stretch::Torque { segment, bounded });
        } else {
            let first = all.len();
            if segment.mode == Mode::Track {
                let (stretch, after_rad) = followed(case, segment, axis);
                here = after_rad;
                all.push(stretch);
            } else {
                here = planned(segment, axis, here, &mut all);
            }
            if let Some(excitation) = segment.excited.and_then(|index| case.excitations.get(index)) {
                all[first..].iter_mut().for_each(|stretch| excite(stretch, excitation, axis));
            }
            if segment.gain_ratio.is_some() {
                all[first..].iter_mut().for_each(|stretch| detune(stretch, case, axis));
            }
        }
    }
    all
}

/// A segment in which an axis follows a target: nobody plans where that goes, the bounds of the point hold the axis. Gives the
/// ends of what these bounds allow, at the speed that they allow, both outwards; and where a stop from there may
/// end. Without bounds it is all of the travel at the rig's own limits, from where no stop fits.
fn followed<'a>(case: &Case, segment: &Segment, axis: &RigAxis) -> (Stretch<'a>, [f64; 2]) {
    let model = &axis.guard.stop;
    let start_rad = case.start_pose_rad.get(&axis.name).copied().unwrap_or(0.0);
    let (ends_rad, speed) = match case.bounds {
        Some(b) => ([start_rad - b.displacement_rad, start_rad + b.displacement_rad], b.speed_rad_per_s),
        None => (model.soft_limits_rad, axis.guard.safety.trip_velocity_rad_per_s),
    };
    let acceleration = case.target.map_or(0.0, |t| {
        let accelerations = t.course.accelerations_rad_per_s2();
        accelerations[usize::from(axis.carried_by.is_some())]
    });
    let instants = [(ends_rad[0], -1.0), (ends_rad[1], 1.0)].map(|(position_rad, outwards)| Instant {
        for_s: 0.5 * segment.at_most_s,
        position_rad,
        rate_rad_per_s: outwards * speed,
        acceleration_rad_per_s2: outwards * acceleration,
        ..Instant::default()
    });
    let stop_rad = model.controlled_from(speed, acceleration, model.deceleration_rad_per_s2).angle_rad;
    let after_rad = [ends_rad[0] - stop_rad, ends_rad[1] + stop_rad];
    (Stretch::Stroke { instants: instants.to_vec(), repeats: 1 }, after_rad)
}

/// Strokes of a segment with a planned place; gives where the next one may begin.
fn planned(segment: &Segment, axis: &RigAxis, here: [f64; 2], all: &mut Vec<Stretch<'_>>) -> [f64; 2] {
    let first = all.len();
    let end = match &segment.stimulus {
        Stimulus::Move { target_rad, limits } => {
            for from_rad in ends(here) {
                all.push(stroke(from_rad, *target_rad, limits, 1));
            }
            [*target_rad; 2]
        }
        Stimulus::Reversals { from_rad, to_rad, limits, cycles } => {
            all.push(stroke(*from_rad, *to_rad, limits, *cycles));
            all.push(stroke(*to_rad, *from_rad, limits, *cycles));
            [*from_rad; 2]
        }
        Stimulus::Cruise { from_rad_per_s, velocity_rad_per_s, acceleration_rad_per_s2 } => {
            let acceleration =
                if from_rad_per_s == velocity_rad_per_s { 0.0 } else { *acceleration_rad_per_s2 };
            let lasts_s = segment.moves_at_most_s();
            let rate = *velocity_rad_per_s;
            let way = velocity_rad_per_s * lasts_s;
            all.extend(ends(here).map(|from| cruise(from, rate, acceleration, lasts_s)));
            let model = &axis.guard.stop;
            let stop_rad = model.controlled_from(rate, 0.0, model.deceleration_rad_per_s2).angle_rad;
            let reach = way + stop_rad.copysign(rate);
            [here[0] + reach.min(0.0), here[1] + reach.max(0.0)]
        }
        Stimulus::Step { target_rad } => {
            all.extend(ends(here).map(|from| step(from, *target_rad, segment.at_most_s)));
            [*target_rad; 2]
        }
        Stimulus::Sine { .. } | Stimulus::Trajectory { .. } => {
            let sampled = ends(here).map(|from| sampled(&segment.stimulus, from, segment.at_most_s));
            let (strokes, ends): (Vec<_>, Vec<f64>) = sampled.unzip();
            all.extend(strokes);
            [ends[0], ends[ends.len() - 1]]
        }
        Stimulus::Hold { .. } | Stimulus::TorqueRamp { .. } | Stimulus::TorqueMultisine { .. } => {
            let rest =
                |position_rad| Instant { for_s: segment.at_most_s, position_rad, ..Instant::default() };
            all.extend(ends(here).map(|at| Stretch::Stroke { instants: vec![rest(at)], repeats: 1 }));
            here
        }
    };
    if segment.until.is_none() && lasts_s(segment, here) <= segment.at_most_s {
        return end;
    }
    cut_anywhere(&all[first..], [end[0].min(here[0]), end[1].max(here[1])], axis)
}

/// It may be cut at any instant: the next segment begins wherever a stop from there ends.
fn cut_anywhere(stretches: &[Stretch<'_>], mut anywhere: [f64; 2], axis: &RigAxis) -> [f64; 2] {
    for stretch in stretches {
        let Stretch::Stroke { instants, .. } = stretch else { continue };
        for i in instants {
            let model = &axis.guard.stop;
            let towards =
                (i.acceleration_rad_per_s2 * i.rate_rad_per_s.signum()).max(-model.deceleration_rad_per_s2);
            let stop_rad =
                model.controlled_from(i.rate_rad_per_s, towards, model.deceleration_rad_per_s2).angle_rad;
            anywhere[0] = anywhere[0].min(i.position_rad - stop_rad * f64::from(i.rate_rad_per_s < 0.0));
            anywhere[1] = anywhere[1].max(i.position_rad + stop_rad * f64::from(i.rate_rad_per_s > 0.0));
        }
    }
    anywhere
}

/// The answer of a position loop to a jump of its command, e^(-kt) with the largest gain that is planned for; the first
/// instant has all of the acceleration, the farthest place allows for an overshoot.
fn step<'a>(from_rad: f64, target_rad: f64, lasts_s: f64) -> Stretch<'a> {
    let height = target_rad - from_rad;
    let steps = (lasts_s / STEP_S).ceil().max(1.0);
    let step_s = lasts_s / steps;
    let instant = |k: u32| {
        let left = height * (-STEP_GAIN_PER_S * f64::from(k) * step_s).exp();
        let rate_rad_per_s = STEP_GAIN_PER_S * left;
        let acceleration = if k == 0 { STEP_CROSSOVER_RAD_PER_S } else { -STEP_GAIN_PER_S } * rate_rad_per_s;
        Instant {
            for_s: step_s,
            position_rad: target_rad - left,
            rate_rad_per_s,
            acceleration_rad_per_s2: acceleration,
            ..Instant::default()
        }
    };
    let mut instants: Vec<Instant> = (0..steps as u32).map(instant).collect();
    let beyond = Instant { position_rad: target_rad + STEP_OVERSHOOT_RATIO * height, ..Instant::default() };
    instants.extend([beyond, Instant { position_rad: target_rad, ..beyond }]);
    Stretch::Stroke { instants, repeats: 1 }
}

/// A smooth path, sampled, and where it ends.
fn sampled<'a>(stimulus: &Stimulus, from_rad: f64, at_most_s: f64) -> (Stretch<'a>, f64) {
    let prepared = stimulus.prepare(from_rad);
    let lasts_s = stimulus.duration_s(from_rad).unwrap_or(at_most_s).min(at_most_s);
    let steps = (lasts_s / STEP_S).ceil().max(1.0);
    let instant = |k: u32| {
        let wanted = prepared.at(lasts_s * f64::from(k) / steps);
        Instant {
            for_s: lasts_s / steps,
            position_rad: wanted.position_rad,
            rate_rad_per_s: wanted.velocity_rad_per_s,
            acceleration_rad_per_s2: wanted.acceleration_rad_per_s2,
            ..Instant::default()
        }
    };
    let instants: Vec<Instant> = (0..=steps as u32).map(instant).collect();
    let end_rad = instants[instants.len() - 1].position_rad;
    (Stretch::Stroke { instants, repeats: 1 }, end_rad)
}

/// A run up to a rate that is kept: its end is the worst of it, still accelerating for the sake of the torque.
fn cruise<'a>(from_rad: f64, rate: f64, acceleration: f64, lasts_s: f64) -> Stretch<'a> {
    let ramp_s = if acceleration > 0.0 { (rate.abs() / acceleration).min(lasts_s) } else { 0.0 };
    let instant = |t_s: f64, for_s, acceleration_rad_per_s2| Instant {
        for_s,
        position_rad: from_rad + rate * t_s,
        rate_rad_per_s: rate,
        acceleration_rad_per_s2,
        ..Instant::default()
    };
    let speeding_up = instant(0.5 * ramp_s, ramp_s, acceleration.copysign(rate));
    Stretch::Stroke { instants: vec![speeding_up, instant(lasts_s, lasts_s - ramp_s, 0.0)], repeats: 1 }
}

/// Adds what an excitation can do to every instant. A torque accelerates the inertia, its lines swing the rate. A rate is
/// followed up to the crossover of the velocity loop; above it the loop's gain makes a torque of it, J·ω_c times the rate.
fn excite(stretch: &mut Stretch<'_>, excitation: &Excitation, axis: &RigAxis) {
    /// The loops of the director cross over at 3.5 Hz or more (VEL-BW), and at 4.4 Hz at the most.
    const CROSSOVER_RAD_PER_S: f64 = std::f64::consts::TAU * 4.5;
    /// By how much a loop may add to its command near its crossover.
    const RESONANCE: f64 = 1.5;
    let Stretch::Stroke { instants, .. } = stretch else { return };
    let inertia = axis.limits.inertia_kg_m2;
    let signal = &excitation.signal;
    let [peak, rms] = [signal.peak(), signal.rms()];
    let (rate, per_unit) = match excitation.into {
        Injection::Torque => (signal.integral_peak() / inertia, 1.0 / inertia),
        Injection::Velocity => (peak, CROSSOVER_RAD_PER_S),
        Injection::MirrorAz | Injection::MirrorEl => return,
    };
    let way_rad = RESONANCE * swing_rad(excitation, inertia);
    let both = instants.iter().flat_map(|i| {
        [1.0, -1.0].map(|sign| {
            let swing = (per_unit * peak).copysign(sign);
            Instant {
                for_s: 0.5 * i.for_s,
                position_rad: i.position_rad + sign * way_rad,
                rate_rad_per_s: i.rate_rad_per_s + sign * RESONANCE * rate,
                acceleration_rad_per_s2: i.acceleration_rad_per_s2 + swing,
                swing_rad_per_s2: [swing, per_unit * rms],
            }
        })
    });
    *instants = both.collect();
}

/// How far an excitation swings the axis at the most.
fn swing_rad(excitation: &Excitation, inertia_kg_m2: f64) -> f64 {
    match excitation.into {
        Injection::Velocity => excitation.signal.integral_peak(),
        Injection::Torque => {
            let squared = |s: &Sine| {
                let omega = std::f64::consts::TAU * s.frequency_hz;
                s.amplitude.abs() / (inertia_kg_m2 * omega * omega)
            };
            excitation.signal.sines().iter().map(squared).sum()
        }
        Injection::MirrorAz | Injection::MirrorEl => 0.0,
    }
}

/// With a detuned velocity loop only the point's bounds hold the axis: it may be as fast as they allow, either way.
fn detune(stretch: &mut Stretch<'_>, case: &Case, axis: &RigAxis) {
    let Stretch::Stroke { instants, .. } = stretch else { return };
    let speed = case.bounds.map_or(axis.guard.safety.trip_velocity_rad_per_s, |b| b.speed_rad_per_s);
    let both = instants.iter().flat_map(|i| {
        [1.0, -1.0].map(|sign| Instant { for_s: 0.5 * i.for_s, rate_rad_per_s: sign * speed, ..*i })
    });
    *instants = both.collect();
}

/// Longest duration of the stimulus itself.
fn lasts_s(segment: &Segment, here: [f64; 2]) -> f64 {
    ends(here).filter_map(|from| segment.stimulus.duration_s(from)).fold(0.0, f64::max)
}

/// Both ends of a range, once where they are one.
fn ends([low, high]: [f64; 2]) -> impl Iterator<Item = f64> {
    std::iter::once(low).chain((high > low).then_some(high))
}

/// A jerk-limited stroke: dense where the rate changes, one sample for the cruise, for which its end is the worst.
fn stroke<'a>(from_rad: f64, to_rad: f64, limits: &ProfileLimits, repeats: u32) -> Stretch<'a> {
    let profile = Profile::new(to_rad - from_rad, limits);
    let whole_s = profile.duration_s();
    let cruise_s = profile.cruise_s();
    let ramp_s = (whole_s - cruise_s) / 2.0;
    let count = (ramp_s / STEP_S).ceil().max(1.0);
    let step_s = ramp_s / count;
    let mut instants = Vec::with_capacity(2 * count as usize + 2);
    let mut sample = |t_s: f64, for_s: f64| {
        let at = profile.at(t_s);
        instants.push(Instant {
            for_s,
            position_rad: from_rad + at.position_rad,
            rate_rad_per_s: at.velocity_rad_per_s,
            acceleration_rad_per_s2: at.acceleration_rad_per_s2,
            ..Instant::default()
        });
    };
    for k in 0..count as u32 {
        sample(f64::from(k) * step_s, step_s);
    }
    sample(ramp_s + cruise_s, cruise_s);
    for k in 1..=count as u32 {
        sample(ramp_s + cruise_s + f64::from(k) * step_s, step_s);
    }
    Stretch::Stroke { instants, repeats }
}
