//! Power spectral density by Welch's method (IEEE Trans. Audio Electroacoustics 15, 70, 1967).

use std::f64::consts::TAU;

/// One-sided PSD at equally spaced frequencies from 0 on.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Distance of two frequencies.
    pub width_hz: f64,
    /// Unit²/Hz at `k·width_hz`.
    pub psd: Vec<f64>,
}

impl Spectrum {
    /// Integral of the PSD times a power gain, from the first frequency above 0: a mean square.
    pub fn filtered(&self, power_gain: impl Fn(f64) -> f64) -> f64 {
        let weigh = |(k, psd): (usize, &f64)| psd * power_gain(k as f64 * self.width_hz);
        self.psd.iter().enumerate().skip(1).map(weigh).sum::<f64>() * self.width_hz
    }
}

/// Spectrum of samples taken at a rate: Hann windows of `length` samples (a power of two), half overlapping, the mean
/// of each removed. Empty where the record is shorter than one window.
pub fn welch(samples: &[f64], rate_hz: f64, length: usize) -> Spectrum {
    let width_hz = rate_hz / length as f64;
    if !length.is_power_of_two() || length < 2 || samples.len() < length {
        return Spectrum { width_hz, psd: vec![] };
    }
    let window: Vec<f64> = (0..length).map(|k| 0.5 - 0.5 * (TAU * k as f64 / length as f64).cos()).collect();
    let window_power: f64 = window.iter().map(|w| w * w).sum();
    let mut psd = vec![0.0; length / 2 + 1];
    let mut segments = 0.0;
    for start in (0..=samples.len() - length).step_by(length / 2) {
        let segment = &samples[start..start + length];
        let mean = segment.iter().sum::<f64>() / length as f64;
        let mut values: Vec<[f64; 2]> =
            segment.iter().zip(&window).map(|(x, w)| [(x - mean) * w, 0.0]).collect();
        fourier(&mut values);
        psd.iter_mut().zip(&values).for_each(|(sum, [re, im])| *sum += re * re + im * im);
        segments += 1.0;
    }
    let scale = 2.0 / (segments * window_power * rate_hz);
    psd.iter_mut().for_each(|value| *value *= scale);
    psd[0] *= 0.5;
    psd[length / 2] *= 0.5;
    Spectrum { width_hz, psd }
}

/// Discrete Fourier transform in place, radix 2 (Cooley and Tukey); the length is a power of two.
fn fourier(values: &mut [[f64; 2]]) {
    let count = values.len();
    let shift = usize::BITS - count.trailing_zeros();
    for k in 0..count {
        let mirrored = k.reverse_bits() >> shift;
        if k < mirrored {
            values.swap(k, mirrored);
        }
    }
    let twiddles: Vec<[f64; 2]> =
        (0..count / 2).map(|k| (-TAU * k as f64 / count as f64).sin_cos()).map(|(s, c)| [c, s]).collect();
    let mut half = 1;
    while half < count {
        let stride = count / (2 * half);
        for block in values.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for (k, (a, b)) in low.iter_mut().zip(high).enumerate() {
                let [c, s] = twiddles[k * stride];
                let turned = [b[0] * c - b[1] * s, b[0] * s + b[1] * c];
                (*a, *b) = ([a[0] + turned[0], a[1] + turned[1]], [a[0] - turned[0], a[1] - turned[1]]);
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use sim_devices::atmosphere::{TICK_RATE_HZ, TipTilt, tilt_psd_rad2_per_hz};
    use sim_devices::physics::noise::SeedAddress;
    use sim_devices::unit::{AtmosphereSettings, UnitSettings};

    use super::*;

    /// A sine of amplitude 3 at a bin: its power 4.5 lies within the three bins of the window.
    #[test]
    fn a_sine_shows_its_power_at_its_frequency() {
        let samples: Vec<f64> = (0..4096).map(|k| 3.0 * (TAU * 10.0 * f64::from(k) / 256.0).sin()).collect();
        let spectrum = welch(&samples, 256.0, 512);
        let power: f64 = spectrum.psd[19..=21].iter().sum::<f64>() * spectrum.width_hz;
        assert!((power - 4.5).abs() < 1e-9, "{power}");
        assert!((spectrum.filtered(|_| 1.0) - 4.5).abs() < 1e-9);
    }

    #[test]
    fn the_transform_is_the_sum_it_stands_for() {
        let input: Vec<[f64; 2]> = (0..16).map(|k| [f64::from(k * k % 7), f64::from(k % 3)]).collect();
        let mut values = input.clone();
        fourier(&mut values);
        for (n, value) in values.iter().enumerate() {
            let mut sum = [0.0; 2];
            for (k, x) in input.iter().enumerate() {
                let (s, c) = (-TAU * (n * k) as f64 / 16.0).sin_cos();
                sum = [sum[0] + x[0] * c - x[1] * s, sum[1] + x[0] * s + x[1] * c];
            }
            assert!((value[0] - sum[0]).abs() < 1e-12 && (value[1] - sum[1]).abs() < 1e-12);
        }
    }

    #[test]
    fn too_short_a_record_has_no_spectrum() {
        assert!(welch(&[1.0; 10], 1.0, 16).psd.is_empty());
    }

    /// The study's two cases of turbulence.
    fn turbulence() -> [AtmosphereSettings; 2] {
        let greenwood_8_hz = UnitSettings::default().atmosphere;
        let measured = AtmosphereSettings {
            wind_speed_m_per_s: 25.0,
            strength_m_pow: 5e-14,
            ..UnitSettings::default().atmosphere
        };
        [greenwood_8_hz, measured]
    }

    /// Tip and tilt over 400 s.
    fn tilt(settings: &AtmosphereSettings, seed: u64) -> Vec<[f64; 2]> {
        let address = SeedAddress { seed, procedure: "TEST".into(), point: "1".into() };
        let mut tilt = TipTilt::new(settings, &address);
        (0..800_000).map(|k| tilt.at(Duration::from_micros(500 * k))).collect()
    }

    /// Welch over 400 s of both axes and two seeds, in third octaves from 0.1 to 100 Hz: within 1.5 dB (0.4 dB ripple of
    /// the pole-zero chain, 5 % to 15 % of estimation).
    #[test]
    fn the_tilt_has_the_spectrum_of_both_branches() {
        for case in turbulence() {
            let mut mean: Vec<f64> = vec![];
            let mut width_hz = 0.0;
            for seed in [1, 2] {
                let values = tilt(&case, seed);
                for axis in 0..2 {
                    let one: Vec<f64> = values.iter().map(|pair| pair[axis]).collect();
                    let spectrum = welch(&one, TICK_RATE_HZ, 1 << 16);
                    width_hz = spectrum.width_hz;
                    mean.resize(spectrum.psd.len(), 0.0);
                    mean.iter_mut().zip(&spectrum.psd).for_each(|(sum, psd)| *sum += 0.25 * psd);
                }
            }
            for third in 0..30 {
                let centre_hz = 0.12 * 2.0_f64.powf(f64::from(third) / 3.0);
                let bins = (centre_hz / 1.1225 / width_hz).ceil() as usize
                    ..(centre_hz * 1.1225 / width_hz) as usize + 1;
                let wanted: f64 =
                    bins.clone().map(|k| tilt_psd_rad2_per_hz(&case, k as f64 * width_hz)).sum();
                let found: f64 = mean[bins].iter().sum();
                let error_db = 10.0 * (found / wanted).log10();
                assert!(error_db.abs() < 1.5, "{centre_hz:.2} Hz: {error_db:.2} dB");
            }
        }
    }
}
