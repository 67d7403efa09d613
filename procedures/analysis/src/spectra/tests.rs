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
        let spacing_hz = psd.frequency_hz[1] - psd.frequency_hz[0];
        let rms = (psd.density.iter().sum::<f64>() * spacing_hz).sqrt();
        assert!((rms - expected).abs() < 1e-12, "{n} samples: {rms} against {expected}");
    }
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
