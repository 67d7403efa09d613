use super::*;
use crate::synthetic_noise::gaussian;

const PERIOD_S: f64 = 2e-3;
/// What a gyro of 0.01 °/√h has in a sample of 2 ms.
const NOISE_RAD_PER_S: f64 = 65e-6;

/// A gyro with noise, bias and delay beside an encoder with play and slip, strokes of 0.7 rad at 0.17 rad/s.
struct Plant {
    play_rad: f64,
    slip_ratio: f64,
    delay_s: f64,
    seed: u64,
}

const BIAS_RAD_PER_S: f64 = 50e-6;

impl Plant {
    /// Trapezoids of the rate: a second of turning round, four of cruise.
    fn rate(t_s: f64) -> f64 {
        let ramp = |x: f64| (0.34 * x).clamp(-0.17, 0.17);
        match t_s {
            t if t < 1.0 => 0.0,
            t if t < 5.0 => ramp(t - 1.0),
            t if t < 10.0 => ramp(5.5 - t),
            t => ramp(t - 10.5).min(0.0),
        }
    }

    fn found(&self) -> (LostMotion, Estimate) {
        let mut noise = gaussian(self.seed);
        let fine = 50;
        let (mut axis, mut encoder, mut lost) = (0.0_f64, 0.0_f64, 0.0_f64);
        let mut encoder_rates = Vec::new();
        let mut gyro_rates = Vec::new();
        for k in 0..5500 {
            let before = encoder;
            let mut turned = 0.0;
            for j in 0..fine {
                let t = (f64::from(k) + f64::from(j) / f64::from(fine)) * PERIOD_S;
                let step = Self::rate(t) * PERIOD_S / f64::from(fine);
                turned += Self::rate(t - self.delay_s) * PERIOD_S / f64::from(fine);
                axis += step;
                lost += self.slip_ratio * step.max(0.0);
                encoder = encoder.clamp(axis - lost - 0.5 * self.play_rad, axis - lost + 0.5 * self.play_rad);
            }
            encoder_rates.push((encoder - before) / PERIOD_S);
            gyro_rates.push(1.0003 * turned / PERIOD_S + BIAS_RAD_PER_S + NOISE_RAD_PER_S * noise());
        }
        let motion = |range: std::ops::Range<usize>| Motion {
            encoder_rad_per_s: &encoder_rates[range.clone()],
            gyro_rad_per_s: &gyro_rates[range],
            period_s: PERIOD_S,
        };
        let bias = bias_at_rest(motion(0..490)).expect("samples");
        (LostMotion::new(motion(490..5500), &bias).expect("two strokes"), bias)
    }
}

fn near(found: Estimate, expected: f64) {
    assert!((found.value - expected).abs() < 3.0 * found.u, "{found:?}, expected {expected}");
}

#[test]
fn play_and_slip_are_found_behind_scale_delay_and_bias() {
    for (seed, play_rad, slip_ratio, delay_s) in
        [(1, 0.0, 0.0, 0.0), (2, 100e-6, 0.0, 1e-3), (3, 0.0, 500e-6, -0.5e-3), (4, 800e-6, 200e-6, 2e-3)]
    {
        let (found, bias) = Plant { play_rad, slip_ratio, delay_s, seed }.found();
        near(bias, BIAS_RAD_PER_S);
        near(found.play_rad, play_rad);
        near(found.slip_ratio, slip_ratio);
        assert!(found.play_rad.u < 5e-6 && found.slip_ratio.u < 60e-6, "{found:?}");
    }
}

/// Errors over their uncertainty, 100 seeds: root mean square within four standard errors of 1.
#[test]
fn uncertainties_are_the_scatter_of_what_is_found() {
    let found: Vec<LostMotion> = (10..110)
        .map(|seed| Plant { play_rad: 60e-6, slip_ratio: 100e-6, delay_s: 0.3e-3, seed }.found().0)
        .collect();
    let rms = |error: &dyn Fn(&LostMotion) -> f64| {
        (found.iter().map(|f| error(f).powi(2)).sum::<f64>() / 100.0).sqrt()
    };
    let play = rms(&|f| (f.play_rad.value - 60e-6) / f.play_rad.u);
    let slip = rms(&|f| (f.slip_ratio.value - 100e-6) / f.slip_ratio.u);
    assert!((0.72..1.28).contains(&play) && (0.72..1.28).contains(&slip), "{play} {slip}");
}

#[test]
fn one_way_says_nothing() {
    let rates = vec![0.1; 2000];
    let motion = Motion { encoder_rad_per_s: &rates, gyro_rad_per_s: &rates, period_s: PERIOD_S };
    let bias = Estimate { value: 0.0, u: 0.0, dof: 1.0, n: 2 };
    assert_eq!(LostMotion::new(motion, &bias), Err(NoLostMotion::OneWay { strokes: 1 }));
    let short = Motion { encoder_rad_per_s: &rates[..50], gyro_rad_per_s: &rates[..50], ..motion };
    assert!(matches!(LostMotion::new(short, &bias), Err(NoLostMotion::TooFew { found: 50, .. })));
}

/// Accelerations of a stroke there and back: 0.17 rad/s, and a turn at which friction first helps to stop and then holds back.
/// Means of 30 ms, as a structure follows.
fn turning_rad_per_s2() -> Vec<f64> {
    let at = |t_s: f64| match t_s {
        t if !(1.0..10.0).contains(&t) => 0.0,
        t if t < 1.5 => 0.34,
        t if !(5.0..6.0).contains(&t) => 0.0,
        t if (5.5..5.56).contains(&t) => -0.05,
        t if (5.56..5.62).contains(&t) => -0.63,
        _ => -0.34,
    };
    let sharp: Vec<f64> = (0..5500_u32).map(|k| at(f64::from(k) * PERIOD_S)).collect();
    sharp.windows(15).map(|window| window.iter().sum::<f64>() / 15.0).collect()
}

/// Between encoder and gyros 20 µrad for each rad/s², half as much again at either end of the travel.
#[test]
fn a_structure_that_bends_at_a_turn_is_no_play() {
    let (mut rate, mut angle_rad, mut before_rad) = (0.0, 0.0, 0.0);
    let mut rates = [Vec::new(), Vec::new()];
    for acceleration in turning_rad_per_s2() {
        let turned_rad = (rate + 0.5 * acceleration * PERIOD_S) * PERIOD_S;
        rate += acceleration * PERIOD_S;
        angle_rad += turned_rad;
        let bent_rad = 20e-6 * (1.0 + 1.5 * (angle_rad - 0.35)) * acceleration;
        rates[0].push(turned_rad / PERIOD_S);
        rates[1].push((turned_rad + bent_rad - before_rad) / PERIOD_S);
        before_rad = bent_rad;
    }
    let motion = Motion { encoder_rad_per_s: &rates[0], gyro_rad_per_s: &rates[1], period_s: PERIOD_S };
    let still = Estimate { value: 0.0, u: 1e-9, dof: 20.0, n: 500 };
    let play_rad = LostMotion::new(motion, &still).expect("two strokes").play_rad.value;
    assert!(play_rad.abs() < 1.2e-6, "{play_rad}");
}
