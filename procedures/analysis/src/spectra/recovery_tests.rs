//! Truth in, estimates out, over seeds fixed beforehand; the full numbers come from the example
//! `recovery_spectra`.

#[path = "../../examples/recovery_spectra/truth.rs"]
mod truth;

use statrs::distribution::{ContinuousCDF, StudentsT};
use truth::{LOOP_RATE_HZ, Normal, closed_loop, direct_over_true, mixed, plant};

use super::super::frf::Line;
use super::*;

#[test]
fn scatter_of_a_density_is_that_of_the_averages_it_is_worth() {
    let (mut sum, mut square, mut count, mut averages) = (0.0, 0.0, 0.0, 0.0);
    for seed in 0..200 {
        let x = Normal::new(seed).take(1600);
        let spectra = CrossSpectra::welch(&[&x], &WelchSettings::new(2.0, 64)).expect("good");
        averages = spectra.averages();
        for density in &spectra.psd(0).expect("there").density[3..30] {
            sum += density;
            square += density * density;
            count += 1.0;
        }
    }
    let mean: f64 = sum / count;
    let found = mean * mean / (square / count - mean * mean);
    // White noise of variance 1 at 2 Hz has density 1. 5400 lines, each worth about half: 2.7 % spread.
    assert!((mean - 1.0).abs() < 0.01, "{mean}");
    assert!((found / averages - 1.0).abs() < 0.08, "{found} against {averages}");
}

#[test]
fn interval_of_a_density_covers() {
    let (mut covered, mut count) = (0, 0);
    for seed in 0..200 {
        let x = Normal::new(seed).take(700);
        let psd =
            CrossSpectra::welch(&[&x], &WelchSettings::new(2.0, 64)).expect("good").psd(0).expect("there");
        for interval in &psd.interval(0.95).expect("a probability")[3..30] {
            covered += usize::from((interval[0]..=interval[1]).contains(&1.0));
            count += 1;
        }
    }
    let ratio = f64::from(covered as u32) / f64::from(count);
    assert!((0.935..0.965).contains(&ratio), "{ratio}");
}

#[test]
fn circle_and_interval_of_h1_cover_at_every_coherence() {
    for coherence in [0.5, 0.8, 0.95, 0.99_f64] {
        let noise = (1.0 / coherence - 1.0).sqrt();
        let (mut circle, mut interval, mut count) = (0, 0, 0);
        for seed in 0..100 {
            let mut random = Normal::new(seed);
            let (x, n) = (random.take(2112), random.take(2112));
            let y = mixed(&x, 1.0, &n, noise);
            let spectra = CrossSpectra::welch(&[&x, &y], &WelchSettings::new(1.0, 128)).expect("good");
            let h1 = spectra.h1(0, 1).expect("averaged");
            let t = StudentsT::new(0.0, 1.0, 2.0 * h1[0].dof).expect("freedom").inverse_cdf(0.975);
            for line in &h1[2..61] {
                let gain = line.value.norm();
                circle += usize::from((line.value - 1.0).norm() <= line.circle_radius(0.95));
                interval += usize::from((gain - 1.0).abs() <= t * line.relative_sd() * gain);
                count += 1;
            }
        }
        for covered in [circle, interval] {
            let ratio = covered as f64 / f64::from(count);
            assert!((0.93..0.97).contains(&ratio), "coherence {coherence}: {ratio}");
        }
    }
}

/// Mean over a band of what a line says of G, over the truth.
fn mean_ratio(frf: &[Line], low_hz: f64, high_hz: f64, weight: impl Fn(&Line) -> f64) -> C64 {
    let band = frf.iter().filter(|l| (low_hz..=high_hz).contains(&l.frequency_hz));
    let (sum, weights) = band.fold((C64::ZERO, 0.0), |(sum, weights), l| {
        (sum + l.value / plant(l.frequency_hz) * weight(l), weights + weight(l))
    });
    sum / weights
}

#[test]
fn in_closed_loop_the_direct_estimate_is_off_and_the_joint_one_is_not() {
    let [r, u, y] = closed_loop(1, 600_000, 0.2);
    let spectra = CrossSpectra::welch(&[&r, &u, &y], &WelchSettings::new(LOOP_RATE_HZ, 8192)).expect("good");
    let (joint, direct) = (spectra.joint(0, 1, 2).expect("good"), spectra.h1(1, 2).expect("good"));
    let certainty = |l: &Line| plant(l.frequency_hz).norm_sqr() / l.variance;
    let found = mean_ratio(&joint, 2.0, 40.0, certainty);
    assert!((found - 1.0).norm() < 0.02, "{found}");
    let direct = mean_ratio(&direct, 20.0, 40.0, |_| 1.0).norm();
    let theory: C64 = (20..=40).map(|hz| direct_over_true(f64::from(hz), 0.2)).sum::<C64>() / 21.0;
    assert!((direct / theory.norm() - 1.0).abs() < 0.03, "{direct} against {}", theory.norm());
}

#[test]
fn circle_of_the_joint_estimate_covers() {
    let (mut covered, mut count) = (0, 0);
    for seed in 0..60 {
        let mut random = Normal::new(seed);
        let [r, v] = [0; 2].map(|_| random.take(4096));
        // Algebraic loop u = r − 0.5·y, y = 2·u + v: u = (r − 0.5·v)/2.
        let u = mixed(&r, 0.5, &v, -0.25);
        let y = mixed(&u, 2.0, &v, 1.0);
        let spectra = CrossSpectra::welch(&[&r, &u, &y], &WelchSettings::new(1.0, 128)).expect("good");
        for line in &spectra.joint(0, 1, 2).expect("good")[2..61] {
            covered += usize::from((line.value - 2.0).norm() <= line.circle_radius(0.95));
            count += 1;
        }
    }
    let ratio = f64::from(covered as u32) / f64::from(count);
    assert!((0.93..0.97).contains(&ratio), "{ratio}");
}
