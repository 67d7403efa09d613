use std::f64::consts::{FRAC_PI_3, TAU};

use super::*;
use crate::TrackGains;

const PERIOD_S: f64 = 250e-6;
const INERTIA_KG_M2: f64 = 1200.0;
const DAMPING_NM_S_PER_RAD: f64 = 273.6;
const AZIMUTH: AxisGains = AxisGains {
    velocity_law: VelocityLaw::DEFAULT,
    velocity_kp_nm_s_per_rad: 23_600.0,
    velocity_ki_nm_per_rad: 447_500.0,
    position_gain_per_s: 4.5,
    track: TrackGains { gain_per_s: 0.0, integral_time_s: 0.0, gyro_lead_s: 0.0 },
};

/// 1/(J s + b) behind a zero-order hold, solved exactly.
struct Plant {
    velocity_rad_per_s: f64,
}

impl Plant {
    fn decay() -> f64 {
        libm::exp(-DAMPING_NM_S_PER_RAD / INERTIA_KG_M2 * PERIOD_S)
    }

    fn step(&mut self, torque_nm: f64) {
        let end = torque_nm / DAMPING_NM_S_PER_RAD;
        self.velocity_rad_per_s = end + (self.velocity_rad_per_s - end) * Self::decay();
    }
}

/// Velocities of the closed loop that follows `reference`, one per tick.
fn run(
    controller: &mut VelocityController,
    ticks: usize,
    reference: impl Fn(usize) -> f64,
) -> std::vec::Vec<f64> {
    let mut plant = Plant { velocity_rad_per_s: 0.0 };
    (0..ticks)
        .map(|k| {
            let velocity = plant.velocity_rad_per_s;
            plant.step(controller.update(reference(k), velocity, 0.0));
            velocity
        })
        .collect()
}

type Complex = (f64, f64);

fn times(a: Complex, b: Complex) -> Complex {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

fn divided(a: Complex, b: Complex) -> Complex {
    let square = b.0 * b.0 + b.1 * b.1;
    times(a, (b.0 / square, -b.1 / square))
}

/// Closed loop L/(1 + L) with L(z) = (Kp + Ki·Ts·z/(z − 1))·P_zoh(z).
fn closed_loop(frequency_hz: f64) -> Complex {
    let angle = TAU * frequency_hz * PERIOD_S;
    let z = (libm::cos(angle), libm::sin(angle));
    let integral = divided(z, (z.0 - 1.0, z.1));
    let ki = AZIMUTH.velocity_ki_nm_per_rad * PERIOD_S;
    let pi = (AZIMUTH.velocity_kp_nm_s_per_rad + ki * integral.0, ki * integral.1);
    let gain = (1.0 - Plant::decay()) / DAMPING_NM_S_PER_RAD;
    let open = times(pi, divided((gain, 0.0), (z.0 - Plant::decay(), z.1)));
    divided(open, (1.0 + open.0, open.1))
}

#[test]
fn closed_loop_on_a_rigid_axis_has_the_analytic_frequency_response() {
    for frequency_hz in [0.5, 2.0, 4.0, 10.0, 50.0] {
        let mut controller = VelocityController::new(&AZIMUTH, 1e9, PERIOD_S);
        let per_period = (1.0 / (frequency_hz * PERIOD_S)) as usize;
        let phase = |k: usize| TAU * (k % per_period) as f64 / per_period as f64;
        let settled = 8000_usize.div_ceil(per_period) * per_period;
        let velocities = run(&mut controller, settled + per_period, |k| libm::sin(phase(k)));
        let mut re = 0.0;
        let mut im = 0.0;
        for (k, velocity) in velocities.iter().enumerate().skip(settled) {
            re += velocity * libm::sin(phase(k)) * 2.0 / per_period as f64;
            im += velocity * libm::cos(phase(k)) * 2.0 / per_period as f64;
        }
        let expected = closed_loop(frequency_hz);
        let error = libm::hypot(re - expected.0, im - expected.1) / libm::hypot(expected.0, expected.1);
        assert!(error < 1e-6, "{frequency_hz} Hz: {re} {im} against {expected:?}");
    }
}

#[test]
fn step_response_follows_the_second_order_closed_form() {
    let mut controller = VelocityController::new(&AZIMUTH, 1e9, PERIOD_S);
    let velocities = run(&mut controller, 4000, |_| 1.0);
    let kp = AZIMUTH.velocity_kp_nm_s_per_rad;
    let ki = AZIMUTH.velocity_ki_nm_per_rad;
    let sigma = (kp + DAMPING_NM_S_PER_RAD) / (2.0 * INERTIA_KG_M2);
    let omega = libm::sqrt(ki / INERTIA_KG_M2 - sigma * sigma);
    let slope = kp / INERTIA_KG_M2;
    for (k, velocity) in velocities.iter().enumerate() {
        // 1 − e^(−σt)(cos ωt + (σ − Kp/J)/ω sin ωt): initial slope Kp/J, final value 1.
        let t_s = k as f64 * PERIOD_S;
        let ringing = libm::cos(omega * t_s) + (sigma - slope) / omega * libm::sin(omega * t_s);
        let expected = 1.0 - libm::exp(-sigma * t_s) * ringing;
        // The hold delays by half a sample: Ts/2 · Kp/J = 0.25 %.
        assert!((velocity - expected).abs() < 0.003, "{t_s} s: {velocity} against {expected}");
    }
}

/// Largest velocity on a 60 °/s step from rest with 2556 N·m.
fn peak_of_a_saturated_step(velocities: &[f64]) -> f64 {
    velocities.iter().fold(0.0, |peak: f64, velocity| peak.max(*velocity))
}

#[test]
fn saturated_step_recovers_within_4_percent_where_plain_clamping_overshoots_by_a_third() {
    const STEP_RAD_PER_S: f64 = FRAC_PI_3;
    const LIMIT_NM: f64 = 2556.0;
    let mut controller = VelocityController::new(&AZIMUTH, LIMIT_NM, PERIOD_S);
    let velocities = run(&mut controller, 16_000, |_| STEP_RAD_PER_S);
    let peak = peak_of_a_saturated_step(&velocities);
    assert!(peak < 1.04 * STEP_RAD_PER_S, "{peak}");
    assert!((velocities[15_999] - STEP_RAD_PER_S).abs() < 1e-6);

    let mut plant = Plant { velocity_rad_per_s: 0.0 };
    let mut integral_nm = 0.0;
    let wound_up: std::vec::Vec<_> = (0..16_000)
        .map(|_| {
            let error = STEP_RAD_PER_S - plant.velocity_rad_per_s;
            integral_nm += AZIMUTH.velocity_ki_nm_per_rad * PERIOD_S * error;
            plant.step((AZIMUTH.velocity_kp_nm_s_per_rad * error + integral_nm).clamp(-LIMIT_NM, LIMIT_NM));
            plant.velocity_rad_per_s
        })
        .collect();
    let wound_up_peak = peak_of_a_saturated_step(&wound_up);
    assert!(wound_up_peak > 1.33 * STEP_RAD_PER_S, "{wound_up_peak}");
}

#[test]
fn blocked_axis_is_freed_without_a_wound_up_integral() {
    let mut controller = VelocityController::new(&AZIMUTH, 500.0, PERIOD_S);
    for _ in 0..40_000 {
        assert!(controller.update(0.01, 0.0, 0.0) <= 500.0);
    }
    assert!(controller.is_saturated());
    let released = controller.update(0.01, 0.03, 0.0);
    assert!(released < 500.0 && !controller.is_saturated(), "{released}");
}

#[test]
fn reset_is_bumpless_and_clears_the_past() {
    let mut controller = VelocityController::new(&AZIMUTH, 2556.0, PERIOD_S);
    controller.update(5.0, 0.0, 0.0);
    controller.reset(-123.0);
    assert_eq!(controller.update(0.2, 0.2, 0.0), -123.0);
    assert_eq!(controller.update(0.2, 0.2, 23.0), -100.0, "feed-forward adds");
    controller.reset(1e6);
    assert_eq!(controller.update(0.0, 0.0, 0.0), 2556.0);
}

#[test]
fn broken_sample_leaves_the_integral_alone() {
    let mut controller = VelocityController::new(&AZIMUTH, 2556.0, PERIOD_S);
    controller.reset(50.0);
    for broken in [f64::NAN, f64::INFINITY] {
        assert_eq!(controller.update(0.1, broken, 0.0), 50.0);
        assert_eq!(controller.update(broken, 0.1, broken), 50.0);
    }
    assert_eq!(controller.update(0.1, 0.1, 0.0), 50.0);
}

#[test]
fn taking_over_in_the_middle_of_a_braking_makes_no_torque_step() {
    let gains =
        AxisGains { velocity_kp_nm_s_per_rad: 20_000.0, velocity_ki_nm_per_rad: 0.0, ..AxisGains::default() };
    let mut controller = VelocityController::new(&gains, 2000.0, PERIOD_S);
    controller.take_over(-547.0, 1.0, 1.02, -1500.0);
    assert!((controller.update(1.0, 1.02, -1500.0) + 547.0).abs() < 1e-9);
    controller.take_over(f64::NAN, f64::NAN, 0.0, f64::NAN);
    assert_eq!(controller.update(0.0, 0.0, 0.0), 0.0);
}

#[test]
fn every_law_is_found_by_its_name_and_keeps_to_the_torque_limit() {
    assert_eq!((VelocityLaw::default(), VelocityLaw::DEFAULT.name()), (VelocityLaw::DEFAULT, "pi"));
    assert_eq!(VelocityLaw::named("no such law"), None);
    for law in LAWS {
        let velocity_law = VelocityLaw::named(law.name).expect("a law of the table");
        assert_eq!(velocity_law.name(), law.name);
        assert!(law.doc.ends_with('.'), "{}", law.name);
        let mut controller = VelocityController::new(&AxisGains { velocity_law, ..AZIMUTH }, 500.0, PERIOD_S);
        controller.reset(-123.0);
        assert!((-500.0..=500.0).contains(&controller.update(1e3, 0.0, 0.0)), "{}", law.name);
        controller.take_over(200.0, 0.1, 0.1, 0.0);
        assert!((controller.update(0.1, 0.1, 0.0) - 200.0).abs() < 1.0, "{}", law.name);
    }
}
