//! A simulated person who pulls an axis by a rope with a force gauge. The hand moves at a constant rate; the rope is a
//! spring and a damper that can only pull.

/// A pull at one axis, SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PullSettings {
    /// Index of the axis.
    pub axis: usize,
    /// Rate of the hand about the axis. Its sign is the direction of the pull.
    pub rate_rad_per_s: f64,
    /// Time at which the pull begins. [`Operator`] takes it on the clock of `now_s`: the director adds the present time.
    pub begins_s: f64,
    /// Angle after which the hand lets go, positive in the direction of the pull.
    pub way_rad: f64,
    /// Largest torque of the pull, positive.
    pub at_most_nm: f64,
}

/// Stiffness of rope and arm: 220 N·m stretch them by 0.6° (ours).
const STIFFNESS_NM_PER_RAD: f64 = 20_000.0;
/// Damping of rope and arm: half of critical for an axis of 1200 kg·m² (ours).
const DAMPING_NM_S_PER_RAD: f64 = 5_000.0;
/// Time in which the hand accelerates to its rate, and in which it lets go (ours).
const FADE_S: f64 = 0.5;

/// The simulated person. Times are on the clock of `now_s`.
#[derive(Clone, Debug)]
pub struct Operator {
    settings: PullSettings,
    /// Angle of the axis when the pull began.
    from_rad: Option<f64>,
    /// Time at which the axis had turned by `way_rad`.
    over_s: Option<f64>,
    torque_nm: f64,
}

impl Operator {
    /// Somebody who has not begun yet.
    pub fn new(settings: PullSettings) -> Self {
        Self { settings, from_rad: None, over_s: None, torque_nm: 0.0 }
    }

    /// The axis that is pulled.
    pub fn axis(&self) -> usize {
        self.settings.axis
    }

    /// Torque on the axis in the last step, N·m, with the sign of `rate_rad_per_s`.
    pub fn torque_nm(&self) -> f64 {
        self.torque_nm
    }

    /// Torque on the axis at this time, angle and rate, N·m. A rope pulls and never pushes: the torque is 0 or has the sign
    /// of the pull. To be called with ascending times.
    pub fn pull_nm(&mut self, now_s: f64, angle_rad: f64, rate_rad_per_s: f64) -> f64 {
        let PullSettings { rate_rad_per_s: hand_rad_per_s, begins_s, way_rad, at_most_nm, .. } =
            self.settings;
        if now_s < begins_s {
            return 0.0;
        }
        let direction = hand_rad_per_s.signum();
        let from_rad = *self.from_rad.get_or_insert(angle_rad);
        if (angle_rad - from_rad) * direction >= way_rad {
            self.over_s.get_or_insert(now_s);
        }
        let elapsed_s = now_s - begins_s;
        // The hand accelerates uniformly for FADE_S, then keeps its rate.
        let rate_share = (elapsed_s / FADE_S).min(1.0);
        let full_rate_s =
            if elapsed_s < FADE_S { 0.5 * elapsed_s * rate_share } else { elapsed_s - 0.5 * FADE_S };
        let hand_rad = from_rad + hand_rad_per_s * full_rate_s;
        let grip_share = self.over_s.map_or(1.0, |over_s| (1.0 - (now_s - over_s) / FADE_S).max(0.0));
        let rope_nm = STIFFNESS_NM_PER_RAD * (hand_rad - angle_rad)
            + DAMPING_NM_S_PER_RAD * (rate_share * hand_rad_per_s - rate_rad_per_s);
        self.torque_nm = grip_share * (rope_nm * direction).clamp(0.0, at_most_nm) * direction;
        self.torque_nm
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit::UnitSettings;
    use crate::world::{StartState, World};

    const RATE: f64 = 0.035;

    /// Azimuth under a pull that begins at 1 s: mean torque (N·m) and mean rate (rad/s) from 5 s to 7 s, and the angle (rad)
    /// at 20 s.
    fn pulled(sign: f64) -> (f64, f64, f64) {
        let unit = UnitSettings::default();
        let start = StartState { az_rad: 0.0, el_rad: 0.7, heat_sink_degc: 40.0 };
        let mut world = World::new(&unit, start);
        let step_s = 1.0 / unit.step_rate_hz;
        let mut operator = Operator::new(PullSettings {
            axis: 0,
            rate_rad_per_s: sign * RATE,
            begins_s: 1.0,
            way_rad: 0.25,
            at_most_nm: 400.0,
        });
        let mut torque_nm = 0.0;
        let mut from_rad = 0.0;
        let mut to_rad = 0.0;
        for step in 0..20 * 20_000_u32 {
            let axis = &world.axes[0];
            let now_s = f64::from(step) * step_s;
            let pull_nm = operator.pull_nm(now_s, axis.angle_rad(), axis.velocity_rad_per_s());
            if (5 * 20_000..7 * 20_000).contains(&step) {
                torque_nm += pull_nm / 40_000.0;
                to_rad = axis.angle_rad();
            } else if step < 5 * 20_000 {
                from_rad = axis.angle_rad();
            }
            world.step([pull_nm, 0.0]);
        }
        (torque_nm, (to_rad - from_rad) / 2.0, world.axes[0].angle_rad())
    }

    #[test]
    fn a_pull_at_constant_rate_is_the_friction_of_the_axis_either_way_and_ends_where_it_should() {
        for sign in [1.0, -1.0] {
            let (torque_nm, rate, end_rad) = pulled(sign);
            // 208 N·m of Coulomb and Stribeck, 10 N·m viscous; cogging over less than two periods leaves a little.
            assert!((torque_nm * sign - 217.7).abs() < 4.0, "{torque_nm} N·m");
            assert!((rate / (sign * RATE) - 1.0).abs() < 0.03, "{rate} rad/s");
            assert!((end_rad * sign - 0.25).abs() < 0.03, "{end_rad} rad");
        }
    }

    #[test]
    fn before_it_begins_and_against_its_direction_nobody_pulls() {
        let settings =
            PullSettings { axis: 1, rate_rad_per_s: RATE, begins_s: 1.0, way_rad: 0.2, at_most_nm: 400.0 };
        let mut operator = Operator::new(settings);
        assert_eq!(operator.pull_nm(0.5, 0.0, 0.0), 0.0);
        assert_eq!(operator.pull_nm(1.0, 0.0, 0.1), 0.0, "a rope does not push");
        assert_eq!(operator.pull_nm(60.0, 0.0, 0.0), 400.0, "no harder than this");
    }
}
