//! Against other implementations: SciPy on the same record, and what an analyser stored of a real measurement.

use super::*;

const SCIPY: &str = include_str!("../../../../tests/data/spectra/scipy.csv");
const ANALYSER: &str = include_str!("../../../../tests/data/spectra/analyser.csv");
const SAMPLES: usize = 6007;
const RATE_HZ: f64 = 1000.0;

/// The record of the fixture, sum by sum as in its README: input and output with offsets.
fn record() -> [Vec<f64>; 2] {
    let mut state = 12345_u64;
    let mut uniform = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / 9007199254740992.0 - 0.5
    };
    let mut x = 0.0;
    let mut y = 0.0;
    let mut y_before = 0.0;
    let mut input = Vec::new();
    let mut output = Vec::new();
    for _ in 0..SAMPLES {
        let x_next = 0.6 * x + uniform();
        let y_next = 1.2 * y - 0.5 * y_before + 0.3 * x + 0.2 * uniform();
        (x, y_before, y) = (x_next, y, y_next);
        input.push(x + 3.0);
        output.push(y - 7.0);
    }
    [input, output]
}

fn numbers(row: &str) -> Vec<f64> {
    row.split(',').map(|v| v.parse().expect("a number")).collect()
}

fn rows_of(case: &str) -> Vec<Vec<f64>> {
    let rows: Vec<_> =
        SCIPY.lines().filter_map(|r| r.strip_prefix(case)?.strip_prefix(',')).map(numbers).collect();
    assert_eq!(rows.len(), 14, "lines of {case}");
    rows
}

fn assert_close(name: &str, line: usize, found: C64, expected: C64) {
    let off = (found - expected).norm();
    assert!(off <= 1e-10 * expected.norm(), "{name} at line {line}: {found} against {expected}");
}

fn assert_agrees_with_scipy(case: &str, settings: &WelchSettings) {
    let [x, y] = record();
    let spectra = CrossSpectra::welch(&[&x, &y], settings).expect("a good record");
    let psd_x = spectra.psd(0).expect("there");
    let psd_y = spectra.psd(1).expect("there");
    let csd = spectra.csd(0, 1).expect("there");
    let back = spectra.csd(1, 0).expect("there");
    let coherence = spectra.coherence(0, 1).expect("averaged");
    let h1 = spectra.h1(0, 1).expect("averaged");
    for row in rows_of(case) {
        let k = row[0] as usize;
        let real = |value: f64| C64::new(value, 0.0);
        assert_close("frequency", k, real(spectra.frequency_hz()[k]), real(row[1]));
        assert_close("psd of x", k, real(psd_x.density[k]), real(row[2]));
        assert_close("psd of y", k, real(psd_y.density[k]), real(row[3]));
        assert_close("csd", k, csd[k], C64::new(row[4], row[5]));
        assert_eq!(back[k], csd[k].conj());
        assert_close("coherence", k, real(coherence[k].raw), real(row[10]));
        // Responses have no line at 0 Hz and half the rate.
        if !spectra.complex_lines().contains(&k) {
            continue;
        }
        assert_eq!(h1[k - 1].frequency_hz, spectra.frequency_hz()[k]);
        assert_close("H1", k, h1[k - 1].value, C64::new(row[6], row[7]));
    }
}

#[test]
fn scipy_finds_the_same_with_hann_and_the_mean_taken_off() {
    assert_agrees_with_scipy("hann", &WelchSettings::new(RATE_HZ, 512));
}

#[test]
fn scipy_finds_the_same_with_odd_segments_that_overlap_by_three_quarters() {
    let settings = WelchSettings {
        overlap_ratio: 0.75,
        window: Window::Rectangular,
        detrend: Detrend::None,
        ..WelchSettings::new(RATE_HZ, 375)
    };
    assert_agrees_with_scipy("rectangular", &settings);
}

/// The analyser's convention is ours: conj(input)·output over input.
#[test]
fn response_of_an_analyser_is_its_cross_over_its_auto_spectrum() {
    for row in ANALYSER.lines().skip(1).map(numbers) {
        let two = response::Two { xx: row[4], yy: row[5], xy: C64::new(row[6], row[7]) };
        let stored = C64::new(row[1], row[2]);
        assert!((two.xy / two.xx - stored).norm() < 3e-7 * stored.norm(), "{} Hz", row[0]);
    }
}
