//! A velocity law without anti-windup, beside the same law with it: both in C, with a torque limit of their own that a step reaches.

use std::path::Path;

use bench::cycle::laws::Laws;
use controllers::AxisGains;
use sim_devices::unit::AxisSettings;

use crate::compiled;

/// Torque limit of both laws: a step of half a degree asks for three times as much.
pub(super) const LIMIT_NM: f64 = 300.0;
/// Height of the step of `regression/az-step.toml`.
const STEP_RAD: f64 = 0.5 * std::f64::consts::PI / 180.0;
/// Time that the model follows the step for.
const DURATION_S: f64 = 6.0;
const PERIOD_S: f64 = 250e-6;

/// The example in C with that limit; without anti-windup its integral goes on while the torque is limited.
const LAW: &str = "#define bench_law_create pi_create
#define bench_law_step pi_step
#include \"velocity_pi.c\"
#undef bench_law_create
#undef bench_law_step
void *bench_law_create(const bench_law_setup *setup, const double *values) {
    bench_law_setup own = *setup;
    own.torque_limit_nm = fmin(own.torque_limit_nm, LIMIT_NM);
    return pi_create(&own, values);
}
void bench_law_step(void *instance, const bench_law_input *input, bench_law_output *output) {
    pi_step(instance, input, output);
    pi_law *law = instance;
    const double step_nm =
        law->ki_step_nm_s_per_rad * finite_or_zero(input->reference_rad_per_s - input->rate_rad_per_s);
    if (WINDS_UP && output->saturated != 0.0 && step_nm * output->torque_nm >= 0.0) {
        law->integral_nm += step_nm;
    }
}
";

/// Azimuth by the law with (`false`) or without (`true`) anti-windup.
///
/// # Panics
/// Where there is no C compiler.
pub(super) fn laws(folder: &Path, winds_up: bool) -> Laws {
    let name = if winds_up { "winds-up" } else { "anti-windup" };
    let defined = format!("#define LIMIT_NM {LIMIT_NM:?}\n#define WINDS_UP {}\n", u8::from(winds_up));
    let library = compiled::c(folder, name, &format!("{defined}{LAW}"));
    let mut laws = Laws::default();
    assert!(laws.insert("az", compiled::in_process(&library)), "the only law");
    laws
}

/// Overshoot of the step beyond its target on a rigid axis with Coulomb and viscous friction, rad: the position loop, PI on the
/// rate, the torque after the current loop and the command delay.
pub(super) fn overshoot_rad(axis: &AxisSettings, gains: &AxisGains, winds_up: bool) -> f64 {
    let delayed_ticks = (axis.command_delay_s / PERIOD_S).round() as usize;
    let mut sent_nm = vec![0.0; delayed_ticks + 1];
    let lag = 1.0 - (-std::f64::consts::TAU * axis.current_bandwidth_hz * PERIOD_S).exp();
    let [mut position_rad, mut rate_rad_per_s, mut torque_nm, mut integral_nm] = [0.0; 4];
    let mut most_rad: f64 = 0.0;
    for tick in 0..(DURATION_S / PERIOD_S) as usize {
        let error = gains.position_gain_per_s * (STEP_RAD - position_rad) - rate_rad_per_s;
        let step_nm = gains.velocity_ki_nm_per_rad * PERIOD_S * error;
        let wanted_nm = gains.velocity_kp_nm_s_per_rad * error + integral_nm + step_nm;
        let limited_nm = wanted_nm.clamp(-LIMIT_NM, LIMIT_NM);
        if winds_up || limited_nm == wanted_nm || step_nm * wanted_nm < 0.0 {
            integral_nm += step_nm;
        }
        let place = tick % sent_nm.len();
        sent_nm[place] = limited_nm;
        // The oldest one stands behind the newest.
        torque_nm += lag * (sent_nm[(place + 1) % sent_nm.len()] - torque_nm);
        rate_rad_per_s = after_friction(axis, rate_rad_per_s, torque_nm);
        position_rad += PERIOD_S * rate_rad_per_s;
        most_rad = most_rad.max(position_rad);
    }
    (most_rad - STEP_RAD).max(0.0)
}

/// The rate after a period: friction stops the axis, but does not drive it.
fn after_friction(axis: &AxisSettings, rate_rad_per_s: f64, torque_nm: f64) -> f64 {
    let driven_nm = torque_nm - axis.viscous_damping_nm_s_per_rad * rate_rad_per_s;
    let free = rate_rad_per_s + PERIOD_S * driven_nm / axis.inertia_kg_m2;
    let friction = PERIOD_S * axis.coulomb_torque_nm / axis.inertia_kg_m2;
    free.signum() * (free.abs() - friction).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shipped;
    use sim_devices::unit::UnitSettings;

    #[test]
    fn only_the_law_without_anti_windup_overshoots() {
        let axis = UnitSettings::default().az;
        let gains = shipped::gains().az;
        let overshoot = |winds_up| overshoot_rad(&axis, &gains, winds_up);
        assert!(overshoot(false) < 1e-9, "{} rad", overshoot(false));
        assert!((1e-3..4e-3).contains(&overshoot(true)), "{} rad", overshoot(true));
    }
}
