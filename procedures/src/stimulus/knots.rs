//! A path through places at times: the cubic spline with rest at both ends.

use serde::{Deserialize, Serialize};

use super::{Envelope, Setpoint};

/// A place at a time, with the rate there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Knot {
    /// Since the start.
    pub time_s: f64,
    /// Where.
    pub position_rad: f64,
    /// Slope of the path.
    pub velocity_rad_per_s: f64,
}

/// Why places and times are no path.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum KnotsError {
    /// As many times as places, two at least.
    #[error("{times} times and {places} places: give each place its time, two at least")]
    Count {
        /// Times.
        times: usize,
        /// Places.
        places: usize,
    },
    /// Two places at one time.
    #[error(
        "the path jumps from {from_deg} deg to {to_deg} deg at {at_s} s: give the axis time to get there"
    )]
    Jump {
        /// When.
        at_s: f64,
        /// Where it is.
        from_deg: f64,
        /// Where it would be at once.
        to_deg: f64,
    },
    /// A time that does not follow the one before it, or no number.
    #[error("time goes from {from_s} s to {to_s} s: times begin at 0 s and ascend")]
    Order {
        /// Time before.
        from_s: f64,
        /// Time after.
        to_s: f64,
    },
}

/// Knots of the twice continuously differentiable cubic path through places at times that rests at both ends
/// (de Boor, *A Practical Guide to Splines*, 1978, chapter IV: complete spline).
///
/// # Errors
/// Lists of different length, times that do not begin at 0 and ascend, two different places at one time (a jump).
pub fn knots(time_s: &[f64], position_rad: &[f64]) -> Result<Vec<Knot>, KnotsError> {
    let n = time_s.len();
    if n != position_rad.len() || n < 2 {
        return Err(KnotsError::Count { times: n, places: position_rad.len() });
    }
    if time_s[0] != 0.0 {
        return Err(KnotsError::Order { from_s: 0.0, to_s: time_s[0] });
    }
    for k in 1..n {
        let [from_s, to_s] = [time_s[k - 1], time_s[k]];
        if to_s == from_s {
            let [from_deg, to_deg] = [position_rad[k - 1], position_rad[k]].map(f64::to_degrees);
            return Err(KnotsError::Jump { at_s: to_s, from_deg, to_deg });
        }
        let ordered = to_s > from_s && to_s.is_finite() && position_rad[k].is_finite();
        if !ordered {
            return Err(KnotsError::Order { from_s, to_s });
        }
    }
    let slopes = slopes(time_s, position_rad);
    let knot =
        |k: usize| Knot { time_s: time_s[k], position_rad: position_rad[k], velocity_rad_per_s: slopes[k] };
    Ok((0..n).map(knot).collect())
}

/// Slopes that make the acceleration continuous, 0 at both ends: a tridiagonal system, solved forwards and backwards.
fn slopes(t: &[f64], p: &[f64]) -> Vec<f64> {
    let n = t.len();
    let mut factor = vec![0.0; n];
    let mut right = vec![0.0; n];
    for k in 1..n - 1 {
        let before = t[k] - t[k - 1];
        let after = t[k + 1] - t[k];
        let wanted = 3.0 * ((p[k] - p[k - 1]) * after / before + (p[k + 1] - p[k]) * before / after);
        let pivot = 2.0 * (before + after) - after * factor[k - 1];
        factor[k] = before / pivot;
        right[k] = (wanted - after * right[k - 1]) / pivot;
    }
    for k in (1..n - 1).rev() {
        right[k] -= factor[k] * right[k + 1];
    }
    right
}

/// Position, velocity and acceleration at a time; at rest before and after.
pub(super) fn at(knots: &[Knot], t_s: f64) -> Setpoint {
    let after = knots.partition_point(|knot| knot.time_s <= t_s);
    let rest = |knot: Option<&Knot>| Setpoint {
        position_rad: knot.map_or(0.0, |knot| knot.position_rad),
        ..Setpoint::default()
    };
    let Some(pair) = after.checked_sub(1).and_then(|k| knots.get(k..k + 2)) else {
        return rest(if after == 0 { knots.first() } else { knots.last() });
    };
    let from = &pair[0];
    let to = &pair[1];
    let h = to.time_s - from.time_s;
    let x = (t_s - from.time_s) / h;
    let rise = to.position_rad - from.position_rad;
    let v0 = from.velocity_rad_per_s * h;
    let v1 = to.velocity_rad_per_s * h;
    let square = 3.0 * rise - 2.0 * v0 - v1;
    let cube = v0 + v1 - 2.0 * rise;
    Setpoint {
        position_rad: from.position_rad + x * (v0 + x * (square + x * cube)),
        velocity_rad_per_s: (v0 + x * (2.0 * square + 3.0 * x * cube)) / h,
        acceleration_rad_per_s2: (2.0 * square + 6.0 * x * cube) / (h * h),
        torque_nm: 0.0,
    }
}

/// What a path asks of an axis, from samples: between two of them a cubic differs from their largest by less than 0.1 %
/// of what it changes in its piece.
pub(super) fn reach(knots: &[Knot]) -> Envelope {
    const PARTS: u32 = 64;
    let mut reach = Envelope::at(knots.first().map_or(0.0, |knot| knot.position_rad));
    for pair in knots.windows(2) {
        for part in 0..=PARTS {
            // The last instant of a piece belongs to the next one, with the same values.
            let ratio = f64::from(part) / f64::from(PARTS) * (1.0 - 1e-12);
            let setpoint = at(pair, pair[0].time_s + ratio * (pair[1].time_s - pair[0].time_s));
            let mut here = Envelope::at(setpoint.position_rad);
            here.velocity_rad_per_s = setpoint.velocity_rad_per_s.abs();
            here.acceleration_rad_per_s2 = setpoint.acceleration_rad_per_s2.abs();
            reach.join(&here);
        }
    }
    reach
}
