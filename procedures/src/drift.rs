//! Drift of the bench: what two self-checks say of the same channel, and what it means for everything in between.
//!
//! Pure: from measurements to measurements, so that a run and its re-judgement agree (ISO/IEC 17025:2017, 7.7.1 and 7.10:
//! results that a check of the equipment has put into doubt are not reported as they are).

use crate::measurement::{Condition, Measurement};
use crate::quantity::QuantityKind;

#[cfg(test)]
mod tests;

/// Name of the kind of procedure that is compared.
pub const KIND: &str = "self-check";

/// Name of the condition that holds the allowed change of a measurement (`requested`) and the change that was found
/// (`achieved`), both in the SI unit of the measurement.
pub const CONDITION: &str = "drift";

/// A channel that a later self-check does not read as an earlier one did.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Drift {
    /// Topic and channel, as evidence names it, e.g. `/imu rate_x_rad_per_s`.
    pub channel: String,
    /// What was found, one sentence without its full stop.
    pub reason: String,
}

/// The condition of a measurement that may change by `most` (SI) between two self-checks.
pub fn allowed(most: f64, kind: QuantityKind) -> Condition {
    Condition { name: CONDITION.to_owned(), requested: most, achieved: None, kind }
}

/// Holds a later self-check against an earlier one, measurand by measurand, axis by axis and channel by channel.
///
/// What the later one allows counts. Each of its measurements that has a counterpart is given the change that was found. A channel
/// has drifted where a value has changed by more than is allowed, or where the later one has none and the earlier one
/// had, or the other way round: what lies between is vouched for on one side only. What neither of them read is not
/// compared.
pub fn compare(earlier: &[Measurement], later: &mut [Measurement]) -> Vec<Drift> {
    let mut drifts = Vec::new();
    for now in later {
        let Some(at) = now.conditions.iter().position(|c| c.name == CONDITION) else { continue };
        let most = now.conditions[at].requested;
        let Some(channel) = channel(now).map(str::to_owned) else { continue };
        let same = |m: &&Measurement| {
            m.measurand == now.measurand && m.axis == now.axis && self::channel(m) == Some(channel.as_str())
        };
        let Some(before) = earlier.iter().find(same) else { continue };
        let name = &now.measurand;
        let text = |value: f64| now.kind.format(value);
        let why = |m: &Measurement| m.inconclusive.clone().unwrap_or_else(|| "it has no value".to_owned());
        let reason = match (before.value, now.value) {
            (None, None) => continue,
            (None, Some(_)) => {
                format!("{channel} was not read by the self-check before: {name}: {}", why(before))
            }
            (Some(before), Some(value)) => {
                let change = (value - before).abs();
                now.conditions[at].achieved = Some(change);
                // Written so that what is no number is a drift.
                if change <= most {
                    continue;
                }
                format!(
                    "{channel} drifted between the self-checks: {name} went from {} to {}, {} allowed",
                    text(before),
                    text(value),
                    text(most)
                )
            }
            (Some(_), None) => {
                format!(
                    "{channel} was read by the self-check before and is not any more: {name}: {}",
                    why(now)
                )
            }
        };
        drifts.push(Drift { channel, reason });
    }
    drifts
}

/// Takes the verdict from every measurement that rests on a channel that drifted: the value stays, with the reason.
/// Whether there was any.
pub fn put_in_doubt(measurements: &mut [Measurement], drifts: &[Drift]) -> bool {
    let mut any = false;
    for measurement in measurements {
        let rests_on = |drift: &&Drift| {
            measurement.evidence.iter().flat_map(|e| &e.channels).any(|used| is_told_by(used, &drift.channel))
        };
        let Some(drift) = drifts.iter().find(rests_on) else { continue };
        any = true;
        // What was inconclusive before has a reason that is nearer to the cause.
        measurement.inconclusive.get_or_insert_with(|| drift.reason.clone());
    }
    any
}

/// Whether a measurement is in units of torque and was told from the current of an axis.
pub fn rests_on_torque_constant(measurement: &Measurement, axis: &str) -> bool {
    let current = format!("/{axis} current_a");
    let told = |used: &String| is_told_by(used, &current);
    measurement.kind.is_of_torque() && measurement.evidence.iter().any(|e| e.channels.iter().any(told))
}

/// Channels that are told from another one of the same topic: a drive gives torque as its current times a constant, and
/// angle, counts and rate from one encoder.
const DERIVED: [(&str, &str); 4] = [
    ("torque_nm", "current_a"),
    ("position_counts", "position_rad"),
    ("velocity_rad_per_s", "position_rad"),
    ("velocity_feedback_rad_per_s", "position_rad"),
];

/// Whether a channel that a measurement used is this channel of the self-check, or is told from it. A rate that a loop is
/// closed on comes from the gyros, too, and which of them depends on the elevation.
fn is_told_by(used: &str, checked: &str) -> bool {
    let (Some((topic, own)), Some((source, channel))) = (used.split_once(' '), checked.split_once(' '))
    else {
        return used == checked;
    };
    let derived = DERIVED.iter().any(|(told, from)| *told == own && *from == channel);
    let by_gyro = own == "velocity_feedback_rad_per_s" && source == "/imu" && channel.starts_with("rate_");
    by_gyro || topic == source && (own == channel || derived)
}

/// The channel that a measurement of a self-check is about.
fn channel(measurement: &Measurement) -> Option<&str> {
    measurement.evidence.first()?.channels.first().map(String::as_str)
}
