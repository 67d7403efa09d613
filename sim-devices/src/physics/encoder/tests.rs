use super::*;
use crate::unit::UnitSettings;
use proptest::prelude::*;

/// An axis whose scale has no error of its own.
fn ideal() -> AxisSettings {
    AxisSettings {
        encoder_eccentricity_rad: 0.0,
        encoder_second_order_rad: 0.0,
        encoder_interpolation_rad: 0.0,
        ..UnitSettings::default().az
    }
}

proptest! {
    #[test]
    fn a_count_is_the_nearest_one_in_one_turn(angle in -3.2..3.2f64) {
        let mut encoder = Encoder::new(&ideal());
        let counts = encoder.counts(angle);
        prop_assert!((0..1 << 26).contains(&counts));
        let back = encoder.unwrapped_counts(angle) as f64 * encoder.rad_per_count();
        // The bias that makes rounding a truncation costs 2⁻¹² of a count.
        prop_assert!((back - angle).abs() <= (0.5 + 1.0 / 4096.0) * encoder.rad_per_count());
    }

    #[test]
    fn an_eccentric_scale_reads_theta_plus_its_sines(angle in -3.2..3.2f64, from in -3.2..3.2f64) {
        let axis = AxisSettings {
            encoder_eccentricity_rad: 150e-6,
            encoder_eccentricity_phase_rad: 0.7,
            encoder_second_order_rad: 20e-6,
            encoder_second_order_phase_rad: -0.4,
            ..ideal()
        };
        let mut encoder = Encoder::new(&axis);
        encoder.counts(from);
        let read = encoder.unwrapped_counts(angle) as f64 * encoder.rad_per_count();
        let expected = angle + 150e-6 * (angle + 0.7).sin() + 20e-6 * (2.0 * angle - 0.4).sin();
        prop_assert!((read - expected).abs() <= (0.5 + 1.0 / 4096.0) * encoder.rad_per_count());
    }
}

#[test]
fn sign_and_zero_of_the_unit_are_obeyed() {
    let axis = AxisSettings { encoder_sign_factor: -1.0, encoder_zero_rad: 0.5, ..ideal() };
    let mut encoder = Encoder::new(&axis);
    assert_eq!(encoder.counts(0.5), 0);
    assert_eq!(encoder.counts(0.5 - std::f64::consts::FRAC_PI_2), 1 << 24);
}

/// Uniform angles: the error is uniform over one count, deviation 1/√12 count. 200 000 angles: 0.2 %; 1 % is five.
#[test]
fn quantisation_is_that_of_one_count() {
    let mut encoder = Encoder::new(&ideal());
    let lsb = std::f64::consts::TAU / 67_108_864.0;
    assert!((lsb - 0.0936e-6).abs() < 0.0001e-6, "director.md §1");
    let n = 200_000;
    let mut squares = 0.0;
    let mut largest = 0.0_f64;
    for k in 0..n {
        // Additive recurrence with the golden ratio: fills the counts evenly.
        let angle = (f64::from(k) * 0.618_033_988_749_895).fract();
        let error = encoder.unwrapped_counts(angle) as f64 * encoder.rad_per_count() - angle;
        squares += error * error;
        largest = largest.max(error.abs());
    }
    let deviation = (squares / f64::from(n)).sqrt();
    assert!((deviation / (lsb / 12.0_f64.sqrt()) - 1.0).abs() < 0.01, "{deviation:e}");
    assert!(largest > 0.49 * lsb && largest < 0.501 * lsb, "{largest:e}");
}

#[test]
fn interpolation_repeats_with_the_pitch_and_stays_small() {
    let axis = AxisSettings { encoder_interpolation_rad: 1e-6, encoder_pitches_per_rev: 1024.0, ..ideal() };
    let mut error = ScaleError::new(&axis);
    let pitch = std::f64::consts::TAU / 1024.0;
    for (fraction, expected) in [(0.0, 0.0), (0.25, 1e-6), (0.5, 0.0), (0.75, -1e-6), (3.25, 1e-6)] {
        assert!((error.at(fraction * pitch) - expected).abs() < 1e-15, "{fraction}");
    }
}

#[test]
fn the_nominal_scale_is_far_inside_the_positioning_limit() {
    let unit = UnitSettings::default();
    for axis in [&unit.az, &unit.el] {
        let mut encoder = Encoder::new(axis);
        let worst = (0..6284).fold(0.0_f64, |worst, k| {
            let angle = f64::from(k) * 1e-3 - std::f64::consts::PI;
            let read = encoder.unwrapped_counts(angle) as f64 * encoder.rad_per_count();
            worst.max((read - angle).abs())
        });
        assert!(worst > 2e-6 && worst < 5e-6, "{worst:e}");
    }
}

#[test]
fn an_injected_fault_goes_out_in_the_word() {
    let mut encoder = Encoder::new(&ideal());
    let healthy = read_word(encoder.word(0.25), 26).expect("healthy");
    assert_eq!(healthy.position_counts as i64, encoder.counts(0.25));
    assert!(!healthy.error && !healthy.warning);
    encoder.inject(Some(EncoderFault::Error));
    assert!(read_word(encoder.word(0.25), 26).expect("the checksum is right").error);
    encoder.inject(Some(EncoderFault::Warning));
    assert!(read_word(encoder.word(0.25), 26).expect("the checksum is right").warning);
    encoder.inject(Some(EncoderFault::Crc));
    assert_eq!(read_word(encoder.word(0.25), 26), None);
    encoder.inject(None);
    assert_eq!(read_word(encoder.word(0.25), 26), Some(healthy));
}
