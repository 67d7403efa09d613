use std::f64::consts::TAU;

use super::*;

/// Reproducible numbers in −0.5…0.5.
fn noise(samples: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    let next = |_| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / 9007199254740992.0 - 0.5
    };
    (0..samples).map(next).collect()
}

fn rectangular(segment_samples: usize) -> WelchSettings {
    WelchSettings {
        overlap_ratio: 0.0,
        window: Window::Rectangular,
        detrend: Detrend::None,
        ..WelchSettings::new(1000.0, segment_samples)
    }
}

#[test]
fn one_two_and_three_threads_give_the_same_bits() {
    let x = noise(50_000, 1);
    let y = noise(50_000, 2);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| CrossSpectra::welch(&[&x, &y], &WelchSettings::new(1.0, 256)).expect("good"))
    };
    let one = with(1);
    assert!(one.segments() > 2 * 32, "several segments a stretch");
    assert_eq!(one, with(2));
    assert_eq!(one, with(3));
}

#[test]
fn densities_sum_to_the_mean_square() {
    for n in [64, 63] {
        let x = noise(10 * n, 3);
        let psd = CrossSpectra::welch(&[&x], &rectangular(n)).expect("good").psd(0).expect("there");
        let expected = (x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64).sqrt();
        let found = [
            psd.band_rms(0.0, 500.0).expect("whole").value,
            psd.cumulative_rms_from_low()[n / 2],
            psd.cumulative_rms_from_high()[0],
        ];
        for rms in found {
            assert!((rms - expected).abs() < 1e-12, "{n} samples: {rms} against {expected}");
        }
    }
}

#[test]
fn bands_add_up_and_a_tone_lies_in_its_own() {
    let x: Vec<f64> = (0..4000).map(|k| 3.0 * (TAU * 0.1 * f64::from(k)).sin()).collect();
    let spectra = CrossSpectra::welch(&[&x], &WelchSettings::new(1000.0, 400)).expect("good");
    let psd = spectra.psd(0).expect("there");
    let rms = |low: f64, high: f64| psd.band_rms(low, high).expect("a band").value;
    assert!((rms(90.0, 110.0) - 4.5_f64.sqrt()).abs() < 1e-9);
    assert!(rms(120.0, 500.0) < 1e-9);
    let parts = rms(0.0, 101.3).hypot(rms(101.3, 500.0));
    assert!((parts - rms(0.0, 500.0)).abs() < 1e-12, "a line at the border is shared");
    let low = psd.cumulative_rms_from_low();
    assert!(low.windows(2).all(|r| r[0] <= r[1]) && low[20] < 1e-9);
}

/// Rms of a band of Gaussian noise scatters by 1/(2√(B·T)), whatever the window: Bendat & Piersol, eq. 8.51.
#[test]
fn uncertainty_of_a_band_is_that_of_its_time_and_width() {
    let x = noise(100_000, 4);
    let spectra = CrossSpectra::welch(&[&x], &WelchSettings::new(1000.0, 500)).expect("good");
    let rms = spectra.psd(0).expect("there").band_rms(100.0, 300.0).expect("a band");
    let expected = 0.5 / (200.0 * 100.0_f64).sqrt();
    assert!((rms.u / rms.value / expected - 1.0).abs() < 0.05, "{}", rms.u / rms.value / expected);
    assert!((rms.dof / (2.0 * 200.0 * 100.0) - 1.0).abs() < 0.1);
}

/// χ²(40) has its 2.5 % and 97.5 % points at 40/1.63713 and 40/0.674062.
#[test]
fn interval_of_twenty_averages_is_the_tabulated_one() {
    let x = noise(20 * 64, 5);
    let psd = CrossSpectra::welch(&[&x], &rectangular(64)).expect("good").psd(0).expect("there");
    assert!((psd.dof[5] - 40.0).abs() < 1e-12 && (psd.dof[0] - 20.0).abs() < 1e-12);
    let interval = psd.interval(0.95).expect("a probability")[5].map(|b| b / psd.density[5]);
    assert!((interval[0] - 0.6740621718801201).abs() < 1e-6, "{interval:?}");
    assert!((interval[1] - 1.6371274862846865).abs() < 1e-6, "{interval:?}");
    assert_eq!(psd.interval(1.0), Err(SpectraError::Probability { found: 1.0 }));
}

/// y follows x by three samples, doubled.
#[test]
fn a_delay_without_noise_is_found_with_its_sign_and_almost_no_variance() {
    let x = noise(40_003, 6);
    let y: Vec<f64> = x.iter().map(|v| 2.0 * v).collect();
    let spectra =
        CrossSpectra::welch(&[&x[3..], &y[..40_000]], &WelchSettings::new(1000.0, 1000)).expect("good");
    let response = spectra.h1(0, 1).expect("averaged");
    assert_eq!(response.len(), 499);
    for line in &response[2..100] {
        let truth = C64::from_polar(2.0, -TAU * line.frequency_hz * 0.003);
        assert!((line.value - truth).norm() < 0.05, "{line:?}");
        assert!((line.value - truth).norm() < 5.0 * line.variance.sqrt(), "{line:?}");
        assert!(line.coherence.expect("it has one") > 0.99);
    }
}

#[test]
fn hv_lies_between_and_goes_over_into_h1_and_h2() {
    let x = noise(8192, 7);
    let n = noise(8192, 8);
    let y: Vec<f64> = x.iter().zip(&n).map(|(x, n)| 3.0 * x + 2.0 * n).collect();
    let spectra = CrossSpectra::welch(&[&x, &y], &WelchSettings::new(1.0, 256)).expect("good");
    let h1 = spectra.h1(0, 1).expect("averaged");
    let h2 = spectra.h2(0, 1).expect("averaged");
    let hv = |ratio: f64| spectra.hv(0, 1, ratio).expect("averaged");
    let low = hv(1e-10);
    let middle = hv(9.0);
    let high = hv(1e12);
    for k in 0..h1.len() {
        assert!((high[k].value - h1[k].value).norm() < 1e-8 * h1[k].value.norm());
        assert!((low[k].value - h2[k].value).norm() < 1e-8 * h2[k].value.norm());
        let gains = [h1[k], middle[k], h2[k]].map(|l| l.value.norm());
        assert!(gains[0] <= gains[1] && gains[1] <= gains[2], "{gains:?}");
        let coherence = spectra.coherence(0, 1).expect("averaged")[k + 1];
        assert!((gains[0] / gains[2] - coherence.raw).abs() < 1e-12);
        assert!(coherence.corrected <= coherence.raw);
    }
    assert_eq!(spectra.hv(0, 1, 0.0), Err(SpectraError::NoiseRatio { found: 0.0 }));
}

/// The smallest eigenvector of the spectral matrix, found by nalgebra, is normal to (1, H).
#[test]
fn hv_is_the_smallest_eigenvector() {
    let x = noise(8192, 9);
    let n = noise(8192, 10);
    let y: Vec<f64> = (0..8192).map(|k| x[k] + 0.5 * x[(k + 8190) % 8192] + n[k]).collect();
    let spectra = CrossSpectra::welch(&[&x, &y], &WelchSettings::new(1.0, 256)).expect("good");
    let hv = spectra.hv(0, 1, 1.0).expect("averaged");
    for k in [1, 40, 90, 127] {
        let s = |i: usize, j: usize| spectra.cross_at(i, j, k);
        // E{Z·Zᴴ} of Z = (X, Y): entry (i, j) is X_i·conj(X_j) = S_ji.
        let matrix = nalgebra::Matrix2::new(s(0, 0), s(1, 0), s(0, 1), s(1, 1));
        let eigen = matrix.symmetric_eigen();
        let largest = eigen.eigenvectors.column(eigen.eigenvalues.imax());
        let expected = largest[1] / largest[0];
        assert!((hv[k - 1].value - expected).norm() < 1e-9, "{} against {expected}", hv[k - 1].value);
    }
}

#[test]
fn through_the_input_itself_the_joint_estimate_is_the_direct_one() {
    let x = noise(8192, 11);
    let n = noise(8192, 12);
    let y: Vec<f64> = x.iter().zip(&n).map(|(x, n)| 3.0 * x + n).collect();
    let spectra = CrossSpectra::welch(&[&x, &y], &WelchSettings::new(1.0, 256)).expect("good");
    let joint = spectra.joint(0, 0, 1).expect("good");
    let direct = spectra.h1(0, 1).expect("good");
    for (j, d) in joint.iter().zip(&direct) {
        assert!((j.value - d.value).norm() < 1e-12);
        assert!((j.variance / d.variance - 1.0).abs() < 1e-9);
        assert!((j.coherence.expect("one") - d.coherence.expect("one")).abs() < 1e-9);
    }
    let bias = spectra.direct_bias(0, 0, 1).expect("good").over(0.0, 0.5).expect("lines");
    assert!(!bias.warns && bias.outside_ratio == 0.0, "{bias:?}");
}

#[test]
fn lines_that_nothing_drives_are_left_out() {
    let tone = |k: usize| (TAU * 5.0 * k as f64 / 64.0).sin() + (TAU * 9.0 * k as f64 / 64.0).cos();
    let x: Vec<f64> = (0..640).map(tone).collect();
    let y: Vec<f64> = x.iter().zip(noise(640, 13)).map(|(x, n)| x + 0.1 * n).collect();
    let response =
        CrossSpectra::welch(&[&x, &y], &rectangular(64)).expect("good").h1(0, 1).expect("averaged");
    let at: Vec<f64> = response.iter().map(|l| l.frequency_hz).collect();
    assert_eq!(at, [5.0 * 15.625, 9.0 * 15.625]);
}

#[test]
fn plateaus_count_and_what_lies_between_does_not() {
    let x = noise(4000, 14);
    let y = noise(4000, 15);
    let settings = WelchSettings::new(1000.0, 256);
    let starts = [0, 128, 256, 1500, 1628, 3000];
    let clean = CrossSpectra::of_segments(&[&x, &y], &starts, &settings).expect("good");
    let mut turned = x.clone();
    turned[512..1500].fill(f64::NAN);
    turned[1884..3000].fill(1e9);
    assert_eq!(CrossSpectra::of_segments(&[&turned, &y], &starts, &settings), Ok(clean.clone()));
    assert_eq!(clean.segments(), 6);
    let expected = 36.0 / (6.0 + 2.0 * 3.0 / 36.0);
    assert!((clean.averages() - expected).abs() < 1e-9, "three pairs are neighbours");
    let every: Vec<usize> = (0..30).map(|k| 128 * k).collect();
    let whole = CrossSpectra::welch(&[&x, &y], &settings);
    assert!(whole.is_ok());
    assert_eq!(CrossSpectra::of_segments(&[&x, &y], &every, &settings), whole);
}

#[test]
fn a_segment_beyond_the_record_is_named() {
    let x = noise(1000, 16);
    let found = CrossSpectra::of_segments(&[&x], &[0, 800], &WelchSettings::new(1.0, 256));
    assert_eq!(found, Err(SpectraError::SegmentOutside { segment: 1, start: 800, length: 256, found: 1000 }));
    let far = CrossSpectra::of_segments(&[&x], &[usize::MAX], &WelchSettings::new(1.0, 256));
    assert!(matches!(far, Err(SpectraError::SegmentOutside { .. })));
}

#[test]
fn records_that_cannot_be_used_are_named_with_channel_and_place() {
    let x = noise(1000, 17);
    let settings = WelchSettings::new(1000.0, 256);
    let welch = |channels: &[&[f64]]| CrossSpectra::welch(channels, &settings);
    let too_short = SpectraError::TooShort { channel: 0, expected: 256, found: 255 };
    assert_eq!(welch(&[&x[..255]]), Err(too_short));
    let unequal = SpectraError::UnequalLengths { channel: 1, expected: 1000, found: 999 };
    assert_eq!(welch(&[&x, &x[1..]]), Err(unequal));
    assert_eq!(welch(&[]), Err(SpectraError::NoChannels));
    for index in [0, 400, 895, 896, 999] {
        let mut hole = x.clone();
        hole[index] = f64::INFINITY;
        hole[999] = f64::INFINITY;
        let found = SpectraError::NotFinite { channel: 1, index, found: f64::INFINITY };
        assert_eq!(welch(&[&x, &hole]), Err(found));
    }
    let mut huge = x;
    huge[10] = 1e200;
    assert_eq!(welch(&[&huge]), Err(SpectraError::TooLarge { channel: 0 }));
}

#[test]
fn settings_without_meaning_are_refused() {
    let x = noise(1000, 18);
    let with = |change: fn(&mut WelchSettings)| {
        let mut settings = WelchSettings::new(1000.0, 256);
        change(&mut settings);
        CrossSpectra::welch(&[&x], &settings).expect_err("refused")
    };
    assert_eq!(with(|s| s.sample_rate_hz = 0.0), SpectraError::SampleRate { found: 0.0 });
    assert!(matches!(with(|s| s.sample_rate_hz = f64::NAN), SpectraError::SampleRate { .. }));
    assert_eq!(with(|s| s.overlap_ratio = 1.0), SpectraError::Overlap { found: 1.0 });
    assert_eq!(with(|s| s.overlap_ratio = -0.1), SpectraError::Overlap { found: -0.1 });
    assert_eq!(with(|s| s.segment_samples = 7), SpectraError::Segment { found: 7 });
}

#[test]
fn no_response_from_one_average_or_a_channel_that_stands_still() {
    let x = noise(1000, 19);
    let still = vec![0.1; 1000];
    let one = CrossSpectra::welch(&[&x[..300], &x[300..600]], &WelchSettings::new(1.0, 256)).expect("a psd");
    assert_eq!(one.h1(0, 1), Err(SpectraError::TooFewAverages { segments: 1, averages: 1.0 }));
    assert!(matches!(one.coherence(0, 1), Err(SpectraError::TooFewAverages { .. })));
    for detrend in [Detrend::Constant, Detrend::None] {
        let settings = WelchSettings { detrend, ..WelchSettings::new(1.0, 256) };
        let spectra = CrossSpectra::welch(&[&x, &still], &settings).expect("a psd");
        assert_eq!(spectra.h1(1, 0), Err(SpectraError::Constant { channel: 1 }));
        assert_eq!(spectra.joint(0, 1, 0), Err(SpectraError::Constant { channel: 1 }));
        assert_eq!(spectra.h1(0, 2), Err(SpectraError::NoSuchChannel { channel: 2, found: 2 }));
    }
}

#[test]
fn a_band_outside_half_the_rate_is_refused() {
    let x = noise(1000, 20);
    let psd =
        CrossSpectra::welch(&[&x], &WelchSettings::new(1000.0, 100)).expect("good").psd(0).expect("there");
    for (low_hz, high_hz) in [(10.0, 10.0), (20.0, 10.0), (-1.0, 10.0), (0.0, 501.0), (f64::NAN, 1.0)] {
        assert!(matches!(psd.band_rms(low_hz, high_hz), Err(SpectraError::Band { .. })));
    }
}

/// Squares of densities of 10⁻¹⁶⁰ and less leave the range of a double.
#[test]
fn the_uncertainty_of_a_band_does_not_depend_on_the_unit() {
    let values = noise(4000, 8);
    let band = |unit: f64| {
        let scaled: Vec<f64> = values.iter().map(|v| unit * v).collect();
        let spectra = CrossSpectra::welch(&[&scaled], &WelchSettings::new(100.0, 200)).expect("a record");
        spectra.psd(0).and_then(|p| p.band_rms(5.0, 20.0)).expect("a band")
    };
    let one = band(1.0);
    let small = band(1e-90);
    assert!((small.u / one.u / 1e-90 - 1.0).abs() < 1e-9 && (small.dof / one.dof - 1.0).abs() < 1e-9);
}
