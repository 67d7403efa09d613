use super::*;

const RATE_HZ: f64 = 4000.0;

fn sine(frequency_hz: f64) -> Vec<f64> {
    (0..4000).map(|i| 1.0e3 + (TAU * frequency_hz * f64::from(i) / RATE_HZ).sin()).collect()
}

/// Amplitude of the in-phase part over whole periods away from the ends.
fn in_phase(y: &[f64], frequency_hz: f64, shape: impl Fn(f64) -> f64) -> f64 {
    let middle = 1000..3000;
    let wave = |i: usize| shape(TAU * frequency_hz * i as f64 / RATE_HZ);
    let power: f64 = middle.clone().map(|i| wave(i).powi(2)).sum();
    middle.map(|i| wave(i) * y[i]).sum::<f64>() / power
}

#[test]
fn gains_are_flat_to_one_percent_at_the_stated_frequency_and_zero_phase() {
    let f = 20.0;
    let d = Differentiator::new(RATE_HZ, f).expect("a fast record");
    let w = TAU * f;
    let velocity = d.velocity(&sine(f)).expect("a long record");
    let acceleration = d.acceleration(&sine(f)).expect("a long record");
    let smooth: Vec<f64> = d.smooth(&sine(f)).expect("a long record").iter().map(|p| p - 1e3).collect();
    assert!((in_phase(&velocity, f, f64::cos) / w - 1.0).abs() < 0.01);
    assert!((in_phase(&smooth, f, f64::sin) - 1.0).abs() < 0.01);
    let gain = in_phase(&acceleration, f, f64::sin) / (-w * w);
    assert!((gain - d.acceleration_gain_ratio(f)).abs() < 1e-6, "{gain}");
    assert!(gain > 0.989 && gain < 0.995, "{gain}");
    assert!(in_phase(&acceleration, f, f64::cos).abs() < 1e-6 * w * w);
    assert!(d.acceleration_gain_ratio(f / 2.0) > 0.999);
}

#[test]
fn a_quartic_is_exact_up_to_its_ends() {
    let d = Differentiator::new(100.0, 5.0).expect("a fast record");
    let t = |i: usize| i as f64 / 100.0;
    let p: Vec<f64> = (0..200).map(|i| 2.0 - t(i) + 3.0 * t(i).powi(2) - t(i).powi(4)).collect();
    let v = d.velocity(&p).expect("a long record");
    let a = d.acceleration(&p).expect("a long record");
    for i in 0..200 {
        assert!((v[i] - (-1.0 + 6.0 * t(i) - 4.0 * t(i).powi(3))).abs() < 1e-8, "velocity at {i}");
        assert!((a[i] - (6.0 - 12.0 * t(i).powi(2))).abs() < 1e-6, "acceleration at {i}");
    }
}

#[test]
fn records_too_short_or_too_slow_are_none() {
    assert!(Differentiator::new(100.0, 10.0).is_none());
    assert!(Differentiator::new(f64::NAN, 10.0).is_none());
    let d = Differentiator::new(4000.0, 20.0).expect("a fast record");
    assert!(d.velocity(&vec![0.0; d.window() - 1]).is_none());
}
