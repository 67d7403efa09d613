//! Steps of the position loop: production position and velocity controllers around the simulated plant.

use controllers::AxisGains;
use controllers::position::PositionController;
use sim_devices::unit::UnitSettings;

use super::closed_loop::{ClosedLoop, TICK_RATE_HZ, bare};
use crate::linear::{StepResponse, step_figures};

/// How long a step is followed.
const FOLLOWED_S: f64 = 4.0;
const VELOCITY_LIMIT_RAD_PER_S: f64 = 1.08;

/// Step of the position command of an axis at an elevation, friction included; figures relative to the step.
pub fn measured_step(
    unit: &UnitSettings,
    axis: usize,
    elevation_rad: f64,
    gains: &AxisGains,
    step_rad: f64,
) -> StepResponse {
    let settings = unit.axis(axis);
    let torque_limit_nm = settings.torque_constant_nm_per_a * settings.current_limit_a;
    let unit = bare(unit, elevation_rad);
    let mut closed = ClosedLoop::new(&unit, axis, elevation_rad, gains, torque_limit_nm);
    let position = PositionController::new(gains, VELOCITY_LIMIT_RAD_PER_S);
    let start_rad = closed.motion().shaft_rad[axis];
    let mut samples = Vec::new();
    for _ in 0..(FOLLOWED_S * TICK_RATE_HZ) as u32 {
        let seen = closed.sensed_angle_rad();
        closed.tick(position.update(start_rad + step_rad, seen, 0.0));
        samples.push((closed.motion().shaft_rad[axis] - start_rad) / step_rad);
    }
    step_figures(&samples, 1.0 / TICK_RATE_HZ)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::probe::study_gains;

    /// modes.md §5 with LuGre: a 0.5° step rises in 0.464…0.468 s and settles in 0.894…0.901 s.
    #[test]
    fn a_half_degree_step_of_azimuth_rises_and_settles_as_computed_independently() {
        let gains = study_gains(0);
        let mut unit = UnitSettings::default();
        unit.az.current_limit_a = 1401.0 / 60.0;
        let found = measured_step(&unit, 0, 0.0, &gains, 0.5_f64.to_radians());
        assert!((found.rise_s - 0.466).abs() < 0.01, "{found:?}");
        assert!((found.settling_s - 0.8975).abs() < 0.02, "{found:?}");
        assert!(found.overshoot_ratio < 0.002, "{found:?}");
    }
}
