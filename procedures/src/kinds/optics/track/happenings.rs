//! What explains peaks: turn-rounds, jumps, joints of rails, the end of the stroke, losses.

use analysis::tracking::{Cause, Happening, opened};

use super::keys::{Keys, Rails};
use super::sight::Sight;
use crate::log::Window;

/// Loops need so long after a loss or the end of the stroke until they follow again.
const RECOVERY_S: f64 = 0.5;
/// A joint may come so much earlier than the geometry says: rails are put down by hand.
const JOINT_EARLY_S: f64 = 0.2;
/// Rates of either sign of this share of their change belong to a turn-round.
const TURN_SHARE: f64 = 0.25;

/// A stretch of time in which something happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Event {
    pub(super) cause: Cause,
    pub(super) from_s: f64,
    pub(super) to_s: f64,
}

impl Event {
    fn new(cause: Cause, [from_s, to_s]: [f64; 2]) -> Self {
        Self { cause, from_s, to_s }
    }
}

/// Windows of an axis as declared: stretches opened by the acceleration of the target.
pub(super) fn windows(keys: &Keys, sight: &Sight, axis: usize) -> Vec<[f64; 2]> {
    let acceleration = &sight.acceleration_rad_per_s2[axis];
    opened(&sight.time_s, acceleration, keys.threshold_rad_per_s2, keys.before_s, keys.after_s)
}

/// Where the target's rate about an axis changed quickly: with its sign, or without.
pub(super) fn turns(keys: &Keys, sight: &Sight, axis: usize) -> Vec<Event> {
    let half_s = 0.5 * (keys.before_s + keys.after_s);
    let sides = |t_s: f64| [t_s - half_s, t_s + half_s].map(|at_s| sight.rate_at(axis, at_s));
    let changes: Vec<f64> = sight.time_s.iter().map(|&t_s| sides(t_s)).map(|[a, b]| b - a).collect();
    let stretches = opened(&sight.time_s, &changes, keys.cause_rad_per_s, keys.before_s, keys.after_s);
    let event = |stretch: [f64; 2]| {
        let within = |k: &usize| (stretch[0]..=stretch[1]).contains(&sight.time_s[*k]);
        let most =
            (0..changes.len()).filter(within).max_by(|&a, &b| changes[a].abs().total_cmp(&changes[b].abs()));
        let [before, after] = most.map_or([0.0; 2], |k| sides(sight.time_s[k]));
        let change = (after - before).abs();
        let turned = before * after < 0.0 && before.abs().min(after.abs()) > TURN_SHARE * change;
        Event::new(if turned { Cause::Reversal } else { Cause::Jump }, stretch)
    };
    stretches.into_iter().map(event).collect()
}

/// Joints that the target went over: where the geometry of the rails says, from where it stood at first.
pub(super) fn joints(keys: &Keys, rails: &Rails, sight: &Sight) -> Vec<Event> {
    let azimuth = &sight.angle_rad[0];
    let Some(&stood_rad) = azimuth.first() else { return Vec::new() };
    let [low, high] = keys.span_rad;
    let onward = if 0.5 * (low + high) < keys.azimuth_rad { -1.0 } else { 1.0 };
    let length_m = rails.rail_m * f64::from(rails.count);
    let end_rad = (0.5 * length_m / rails.distance_m).atan();
    // From the end at which it stood.
    let along = |az: f64| rails.distance_m * (onward * (az - stood_rad) - end_rad).tan() + 0.5 * length_m;
    let rail = |az: f64| (along(az) / rails.rail_m).floor();
    let crosses = |k: &usize| {
        let a = rail(azimuth[*k - 1]);
        let b = rail(azimuth[*k]);
        a != b && (1.0..f64::from(rails.count)).contains(&a.max(b))
    };
    (1..azimuth.len())
        .filter(crosses)
        .map(|k| [sight.time_s[k] - JOINT_EARLY_S, sight.time_s[k] + rails.jolt_s])
        .map(|stretch| Event::new(Cause::Joint, stretch))
        .collect()
}

/// Stretches in which the mirror stood at the end of its stroke, with the time that its loop needs afterwards.
pub(super) fn stroke_ends(window: &Window, axis: usize, [from_s, to_s]: [f64; 2]) -> Vec<Event> {
    let Some(rows) = window.rows("/track") else { return Vec::new() };
    let Some(saturated) = rows.column(["az_saturated", "el_saturated"][axis]) else { return Vec::new() };
    let within = rows.range(from_s, to_s);
    let stretches = opened(&rows.time_s[within.clone()], &saturated[within], 0.5, 0.0, RECOVERY_S);
    stretches.into_iter().map(|stretch| Event::new(Cause::Saturation, stretch)).collect()
}

/// Losses, with the time that loops need afterwards.
pub(super) fn losses(stretches: &[[f64; 2]]) -> Vec<Event> {
    stretches.iter().map(|&[from_s, to_s]| Event::new(Cause::Loss, [from_s, to_s + RECOVERY_S])).collect()
}

/// Events as samples of a record.
pub(super) fn among(events: &[Event], time_s: &[f64]) -> Vec<Happening> {
    let place = |t_s: f64| time_s.partition_point(|&t| t < t_s);
    events.iter().map(|e| Happening { cause: e.cause, from: place(e.from_s), to: place(e.to_s) }).collect()
}

/// The word for a cause.
pub(super) fn word(cause: Cause) -> &'static str {
    match cause {
        Cause::Loss => "loss",
        Cause::Saturation => "stroke",
        Cause::Reversal => "reversal",
        Cause::Jump => "jump",
        Cause::Joint => "rail joint",
        Cause::Unknown => "unknown",
    }
}
