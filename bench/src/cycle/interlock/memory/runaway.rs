//! Whether an axis does the opposite of what its torque says.

use super::Seen;
use super::spell::Spell;

/// Static friction that a torque must exceed before it says anything: the rig file's least, and 20 %.
const BREAKAWAY_MARGIN: f64 = 1.2;
/// Share of the predicted acceleration that the opposite one must have: friction and inertia are not known better.
const SHARE: f64 = 0.25;
/// Less acceleration than this is no motion of the axis but its structure and the noise of its rate.
const FLOOR_RAD_PER_S2: f64 = 0.05;

/// The structure of an axis that was stopped hard rings with less than this (18 Hz: half a period is more than 20 ms).
const RINGING_RAD_PER_S: f64 = 1.0 * std::f64::consts::PI / 180.0;

#[derive(Clone, Copy, Debug)]
pub(super) struct Runaway {
    spell: Spell,
}

impl Runaway {
    /// None seen; samples come at this period.
    pub(super) fn new(period_s: f64) -> Self {
        Self { spell: Spell::new(period_s) }
    }

    /// A fresh sample, `span_s` after the one before. The drive samples torque and rate together, so that transport delays do not matter here.
    pub(super) fn take(
        &mut self,
        seen: &Seen<'_>,
        operates: bool,
        acceleration_rad_per_s2: f64,
        span_s: f64,
    ) {
        let stop = &seen.guard.stop;
        let actuals = seen.actuals;
        let breakaway_nm =
            BREAKAWAY_MARGIN * stop.friction.static_nm + stop.loads.at(actuals.position_rad).abs();
        let excess_nm = actuals.torque_nm.abs() - breakaway_nm;
        let against = -acceleration_rad_per_s2 * actuals.torque_nm.signum();
        let least = (SHARE * excess_nm / stop.inertia_kg_m2).max(FLOOR_RAD_PER_S2);
        // An axis that becomes slower against its torque may only have more friction than the rig file says.
        let rate = actuals.velocity_rad_per_s;
        let faster = acceleration_rad_per_s2 * rate > 0.0 && rate.abs() > RINGING_RAD_PER_S;
        let opposite = operates && excess_nm > 0.0 && against > least && faster;
        self.spell.take(opposite, span_s);
    }

    /// How long without a break.
    pub(super) fn lasted_s(&self) -> f64 {
        self.spell.lasted_s()
    }
}
