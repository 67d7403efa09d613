use super::*;
use crate::unit::UnitSettings;

fn cases() -> [AtmosphereSettings; 2] {
    let greenwood_8_hz = UnitSettings::default().atmosphere;
    let measured = AtmosphereSettings {
        wind_speed_m_per_s: 25.0,
        strength_m_pow: 5e-14,
        ..UnitSettings::default().atmosphere
    };
    [greenwood_8_hz, measured]
}

fn address(seed: u64) -> SeedAddress {
    SeedAddress { seed, procedure: "TEST".into(), point: "1".into() }
}

fn record(settings: &AtmosphereSettings, seed: u64, count: u32) -> Vec<[f64; 2]> {
    let mut tilt = TipTilt::new(settings, &address(seed));
    (0..count).map(|k| tilt.at(Duration::from_micros(500 * u64::from(k)))).collect()
}

#[test]
fn the_knee_is_at_8_and_10_hz_in_the_study_s_two_cases() {
    let [first, second] = cases();
    assert!((knee_hz(&first) - 8.0).abs() < 1e-12 && (knee_hz(&second) - 10.0).abs() < 1e-12);
}

/// r0 and σ computed apart from the formulae above: 0.185·(6.52864e-13/3.1875e-13)^0.6 m, and five times the
/// turbulence shrinks r0 by 5^0.6 and multiplies the variance by 5.
#[test]
fn fried_parameter_and_variance_follow_from_path_and_strength() {
    let [first, second] = cases();
    assert!((fried_parameter_m(&first) - 0.2845).abs() < 1e-4, "{}", fried_parameter_m(&first));
    assert!((fried_parameter_m(&first) / fried_parameter_m(&second) - 5.0_f64.powf(0.6)).abs() < 1e-9);
    let [one, two] = [&first, &second].map(|case| tilt_variance_rad2(case).sqrt());
    assert!((one - 1.031e-6).abs() < 2e-9, "{one}");
    assert!((two / one - 5.0_f64.sqrt()).abs() < 1e-9);
}

#[test]
fn the_psd_integrates_to_the_variance_and_has_both_slopes() {
    for case in cases() {
        let psd = |f: f64| tilt_psd_rad2_per_hz(&case, f);
        let slope = |f: f64| (psd(1.01 * f) / psd(f)).ln() / 1.01_f64.ln();
        assert!((slope(0.01) + 2.0 / 3.0).abs() < 1e-3 && (slope(800.0) + 11.0 / 3.0).abs() < 1e-3);
        // ∫S df = ∫S·f d(ln f), by the trapezoid rule over 1e-12 to 1e4 of the knee.
        let step = 1e-3;
        let integral: f64 = (0..37_000)
            .map(|k| knee_hz(&case) * (-27.6 + step * f64::from(k)).exp())
            .map(|f| psd(f) * f * step)
            .sum();
        let expected = tilt_variance_rad2(&case);
        assert!((integral / expected - 1.0).abs() < 1e-3, "{}", integral / expected);
    }
}

/// The start is drawn from the stationary process: over many seeds the first value and one 20 s later have the same
/// variance, and that of the formula less what lies below 5 mHz.
#[test]
fn turbulence_does_not_begin_with_the_run() {
    let [case, _] = cases();
    let mut first = 0.0;
    let mut later = 0.0;
    let count = 300;
    for seed in 0..count {
        let mut tilt = TipTilt::new(&case, &address(seed));
        first += tilt.at(Duration::ZERO).iter().map(|x| x * x).sum::<f64>();
        later += tilt.at(Duration::from_secs(1)).iter().map(|x| x * x).sum::<f64>();
    }
    let expected = tilt_variance_rad2(&case) * 2.0 * count as f64;
    for share in [first / expected, later / expected] {
        assert!((0.75..1.1).contains(&share), "{share}");
    }
}

#[test]
fn vacuum_is_still_and_seeds_differ() {
    let vacuum = AtmosphereSettings { strength_m_pow: 0.0, ..UnitSettings::default().atmosphere };
    assert!(record(&vacuum, 1, 100).iter().flatten().all(|x| *x == 0.0));
    let [case, _] = cases();
    assert_eq!(record(&case, 1, 50), record(&case, 1, 50));
    assert_ne!(record(&case, 1, 50), record(&case, 2, 50));
    let mut sparse = TipTilt::new(&case, &address(1));
    assert_eq!(sparse.at(Duration::from_micros(500 * 49)), record(&case, 1, 50)[49]);
}

#[test]
fn every_allowed_wind_and_aperture_gives_finite_turbulence() {
    for (wind_speed_m_per_s, aperture_m) in [(0.1, 10.0), (200.0, 0.01), (0.1, 0.01), (200.0, 10.0)] {
        let case =
            AtmosphereSettings { wind_speed_m_per_s, aperture_m, ..UnitSettings::default().atmosphere };
        let largest = record(&case, 1, 2000).iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
        let deviation = tilt_variance_rad2(&case).sqrt();
        assert!(largest.is_finite() && largest < 10.0 * deviation, "{largest} of {deviation}");
    }
}
