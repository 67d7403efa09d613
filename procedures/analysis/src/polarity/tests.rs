use super::*;
use crate::synthetic_noise::uniform as noise;

const PERIOD_S: f64 = 2.0 / 3.0;
const ORDERS: [u32; 3] = [2, 3, 4];
const HIGHEST: u32 = 5;
const RATE_HZ: f64 = 2000.0;

/// `J·ẍ = s·T − k·x − b·ẋ` under three sines, faded in over the settling: time, torque, angle.
fn shaken(inertia: f64, scale: f64, stiffness: f64, damping: f64) -> [Vec<f64>; 3] {
    let mut x = 0.0;
    let mut v = 0.0;
    let settle_s = 8.0 * PERIOD_S;
    let steps = 10;
    let mut all: [Vec<f64>; 3] = Default::default();
    let samples = ((settle_s + 6.0 * PERIOD_S) * RATE_HZ) as usize + 2;
    for k in 0..samples {
        let t = k as f64 / RATE_HZ;
        let torque = |t: f64| -> f64 {
            let line = |n: u32| 10.0 * (TAU * f64::from(n) / PERIOD_S * t + f64::from(n)).cos();
            (t / settle_s).min(1.0) * ORDERS.into_iter().map(line).sum::<f64>()
        };
        if t >= settle_s {
            all[0].push(t);
            all[1].push(torque(t) + noise(2 * k));
            all[2].push(x + 0.1e-6 * noise(2 * k + 1));
        }
        let step_s = 1.0 / RATE_HZ / f64::from(steps);
        for i in 0..steps {
            let pushed = scale * torque(t + (f64::from(i) + 0.5) * step_s);
            v += (pushed - stiffness * x - damping * v) / inertia * step_s;
            x += v * step_s;
        }
    }
    all
}

#[test]
fn the_torque_scale_is_found_whatever_friction_is() {
    for (stiffness, damping) in [(90_000.0, 16_354.0), (50_000.0, 8_322.0), (9_000.0, 500.0)] {
        for scale in [0.1, 0.75, 0.82, 1.0, 1.25, -1.0] {
            let [t, torque, angle] = shaken(1000.0, scale, stiffness, damping);
            let found = small_motion(&t, &torque, &angle, (PERIOD_S, HIGHEST)).expect("a fit");
            let found_scale = 1000.0 / found.inertia_kg_m2.value;
            assert!(
                (found_scale / scale - 1.0).abs() < 0.02,
                "{found:?} for {scale} with {stiffness} N·m/rad"
            );
            // Late by 1 ms, 100 N·m·s/rad are 0.1 kg·m².
            assert!((found.damping_nm_s_per_rad * scale - damping).abs() < 100.0, "{found:?}");
            assert_eq!(found.inertia_kg_m2.n, 6);
        }
    }
}

/// A LuGre contact (Canudas de Wit et al. 1995) that bears a load, in shares of its static friction of 43 N·m, under torque of 0.08
/// of it: time, torque, angle, after the transient.
fn shaken_under_load(load_ratio: f64) -> [Vec<f64>; 3] {
    let (inertia, static_nm, stiffness, damping) = (980.0, 43.0, 50_000.0, 8_322.0);
    let (period_s, step_s) = (4.0 / 3.0, 1e-4);
    let (mut deflection, mut v, mut x) = (load_ratio * static_nm / stiffness, 0.0_f64, 0.0);
    let mut all: [Vec<f64>; 3] = Default::default();
    for k in 0..(7.0 * period_s / step_s) as usize {
        let t = k as f64 * step_s;
        let line =
            |order: f64, phase: f64| 0.08 * static_nm / 3.0 * (TAU * order / period_s * t + phase).sin();
        let torque = (t / period_s).min(1.0) * (line(3.0, 0.0) + line(5.0, 2.0) + line(7.0, 4.5));
        let share = 1.0 - stiffness * deflection / static_nm * v.signum();
        let pushed = inertia * v / step_s + torque + load_ratio * static_nm - stiffness * deflection;
        v = pushed / (inertia / step_s + (damping + stiffness * step_s) * share);
        deflection += share * v * step_s;
        x += v * step_s;
        if t >= period_s && k % 10 == 0 {
            let reported = torque + 0.5 * noise(k);
            for (column, value) in all.iter_mut().zip([t, reported, x]) {
                column.push(value);
            }
        }
    }
    all
}

#[test]
fn inertia_is_found_under_a_load_of_seven_tenths_of_static_friction() {
    for load_ratio in [-0.5, 0.0, 0.2, 0.4, 0.5, 0.6, 0.7] {
        let [t, torque, angle] = shaken_under_load(load_ratio);
        let found = small_motion(&t, &torque, &angle, (4.0 / 3.0, 8)).expect("a fit");
        assert!((found.inertia_kg_m2.value / 980.0 - 1.0).abs() < 0.01, "{found:?} under {load_ratio}");
    }
}

#[test]
fn an_axis_that_does_not_answer_has_no_torque_scale() {
    let [t, torque, angle] = shaken(1000.0, 1.0, 9e4, 1.6e4);
    let still = vec![angle[0]; angle.len()];
    assert!(small_motion(&t, &torque, &still, (PERIOD_S, HIGHEST)).is_err());
    assert!(small_motion(&t[..100], &torque[..100], &angle[..100], (PERIOD_S, HIGHEST)).is_err());
}

#[test]
fn the_compliance_has_the_sign_of_the_path_and_bears_a_drift() {
    let time: Vec<f64> = (0..2000).map(|k| f64::from(k) * 1e-3).collect();
    let torque: Vec<f64> = time.iter().map(|t| 40.0 * (TAU * t / 2.0).sin()).collect();
    for gain in [1e-5, -1e-5, 1e-6] {
        let moved = |k: usize| gain * torque[k] + 1e-7 * noise(k);
        let angle: Vec<f64> = (0..2000).map(|k| 0.7 + 1e-4 * time[k] + moved(k)).collect();
        let whole = compliance(&time, &torque, &angle).expect("a fit");
        assert!((whole.value / gain - 1.0).abs() < 0.02, "{whole:?} for {gain}");
        // What a trip leaves of a pulse.
        let angle: Vec<f64> = (0..200).map(|k| 0.7 + moved(k)).collect();
        let cut = compliance_cut_short(&torque[..200], &angle, 0.7).expect("a fit");
        assert!((cut.value / gain - 1.0).abs() < 0.02, "{cut:?} for {gain}");
    }
    assert!(compliance(&time, &vec![1.0; 2000], &torque).is_err(), "a torque that does not change");
    assert!(compliance_cut_short(&[0.0; 50], &[0.1; 50], 0.1).is_err(), "no torque");
}

/// Rates at 500 Hz with the noise of a fibre-optic gyro (65 µrad/s) and Earth rate, motion of 0.2 mrad.
#[test]
fn the_gyros_give_size_and_direction_of_the_motion() {
    let time: Vec<f64> = (0..3000).map(|k| f64::from(k) * 2e-3).collect();
    let at = |t: f64| 2e-4 * (1.3 * t).sin().powi(3);
    let angle: Vec<f64> = time.iter().map(|&t| at(t)).collect();
    for along in [[-1.0, 0.0, 0.0], [0.0, 0.8, 0.6], [0.0, -1.6, -1.2]] {
        let rates: Vec<Vec<f64>> = along
            .iter()
            .enumerate()
            .map(|(axis, g)| {
                let mean = |k: usize| if k == 0 { 0.0 } else { (at(time[k]) - at(time[k - 1])) / 2e-3 };
                (0..time.len()).map(|k| g * mean(k) + 7e-5 + 2.2e-4 * noise(3 * k + axis)).collect()
            })
            .collect();
        let found = rate_response(&time, [&rates[0], &rates[1], &rates[2]], &angle, 0.05).expect("a fit");
        let size = along.iter().map(|g| g * g).sum::<f64>().sqrt();
        assert!((found.size() / size - 1.0).abs() < 0.05, "{found:?} for {along:?}");
        assert!(found.size_u() < 0.03, "{found:?}");
        assert!(found.alignment(along.map(|g| g / size)) > 0.99, "{found:?} for {along:?}");
    }
}
