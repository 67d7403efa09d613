//! A power spectral density with its uncertainty, and root mean squares from it.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::{SpectraError, WelchSettings, Window, complex_lines};

/// One-sided power spectral density of a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Psd {
    /// Frequencies, Hz: 0 to half the sample rate.
    pub frequency_hz: Vec<f64>,
    /// Density at each, unit²/Hz.
    pub density: Vec<f64>,
    /// Degrees of freedom of each: 2·n_d; n_d at 0 Hz and half the sample rate, which are real.
    pub dof: Vec<f64>,
    spacing_hz: f64,
    half_rate_hz: f64,
    window: Window,
}

/// A root mean square with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rms {
    /// Value, in the unit of the channel.
    pub value: f64,
    /// Standard uncertainty of `value` from the finite record (Gaussian signal).
    pub u: f64,
    /// Degrees of freedom of the mean square.
    pub dof: f64,
}

impl Psd {
    pub(super) fn new(
        frequency_hz: &[f64],
        density: &[f64],
        settings: &WelchSettings,
        averages: f64,
    ) -> Self {
        let complex = complex_lines(settings.segment_samples);
        let dof_of = |k: usize| if complex.contains(&k) { 2.0 * averages } else { averages };
        Self {
            frequency_hz: frequency_hz.to_vec(),
            density: density.to_vec(),
            dof: (0..density.len()).map(dof_of).collect(),
            spacing_hz: settings.sample_rate_hz / settings.segment_samples as f64,
            half_rate_hz: 0.5 * settings.sample_rate_hz,
            window: settings.window,
        }
    }

    /// Interval of each density that holds the true one with this probability: dof·Ŝ/χ² at both tails (Bendat &
    /// Piersol, *Random Data*, 4th ed., eq. 8.159), unit²/Hz.
    ///
    /// # Errors
    /// [`SpectraError::Probability`] outside 0…1.
    pub fn interval(&self, probability: f64) -> Result<Vec<[f64; 2]>, SpectraError> {
        if !(probability > 0.0 && probability < 1.0) {
            return Err(SpectraError::Probability { found: probability });
        }
        let factors = |dof: f64| {
            let chi = ChiSquared::new(dof).expect("there is at least one average");
            let tail = 0.5 * (1.0 - probability);
            [dof / chi.inverse_cdf(1.0 - tail), dof / chi.inverse_cdf(tail)]
        };
        // Two values of dof at most: 0 Hz, line 1 and half the rate show them.
        let real = factors(self.dof[0]);
        let complex = factors(self.dof[1]);
        let uncertainty = |(density, dof): (&f64, &f64)| {
            if *dof == self.dof[1] { complex.map(|f| f * density) } else { real.map(|f| f * density) }
        };
        Ok(self.density.iter().zip(&self.dof).map(uncertainty).collect())
    }

    /// Root mean square of everything from 0 Hz up to and with each line, in the unit of the channel.
    pub fn cumulative_rms_from_low(&self) -> Vec<f64> {
        running_rms(self.density.iter().map(|d| d * self.spacing_hz))
    }

    /// Root mean square of everything from each line up to half the sample rate, in the unit of the channel.
    pub fn cumulative_rms_from_high(&self) -> Vec<f64> {
        let mut rms = running_rms(self.density.iter().rev().map(|d| d * self.spacing_hz));
        rms.reverse();
        rms
    }

    /// Root mean square within a band; lines at its ends count by the share of their width that lies within.
    ///
    /// Uncertainty: variances 2·S²/dof of the lines, with the correlation of neighbours that the window makes.
    ///
    /// # Errors
    /// [`SpectraError::Band`] if the band is empty or not within 0 … half the sample rate.
    pub fn band_rms(&self, low_hz: f64, high_hz: f64) -> Result<Rms, SpectraError> {
        let most_hz = self.half_rate_hz;
        if !(low_hz >= 0.0 && low_hz < high_hz && high_hz <= most_hz) {
            return Err(SpectraError::Band { low_hz, high_hz, most_hz });
        }
        let power: Vec<f64> =
            (0..self.density.len()).map(|k| self.line_power(k) * self.share(k, low_hz, high_hz)).collect();
        let square: f64 = power.iter().sum();
        if square <= 0.0 {
            return Ok(Rms { value: 0.0, u: 0.0, dof: f64::INFINITY });
        }
        // In parts of the whole, so that no unit is too small to be squared.
        let sd: Vec<f64> =
            power.iter().zip(&self.dof).map(|(p, dof)| p / square * (2.0 / dof).sqrt()).collect();
        let shared = |lag: usize| sd.iter().zip(&sd[lag.min(sd.len())..]).map(|(a, b)| a * b).sum::<f64>();
        let neighbours: f64 =
            self.window.line_correlation().iter().zip(1..).map(|(r, lag)| 2.0 * r * shared(lag)).sum();
        let relative = shared(0) + neighbours;
        let value = square.sqrt();
        Ok(Rms { value, u: 0.5 * value * relative.sqrt(), dof: 2.0 / relative })
    }

    fn line_power(&self, k: usize) -> f64 {
        self.density[k] * self.spacing_hz
    }

    /// Share of a line's width, half a spacing to each side within 0 … half the rate, that lies in a band.
    fn share(&self, k: usize, low_hz: f64, high_hz: f64) -> f64 {
        let half = 0.5 * self.spacing_hz;
        let from = (self.frequency_hz[k] - half).max(0.0);
        let to = (self.frequency_hz[k] + half).min(self.half_rate_hz);
        (to.min(high_hz) - from.max(low_hz)).max(0.0) / (to - from)
    }
}

fn running_rms(powers: impl Iterator<Item = f64>) -> Vec<f64> {
    powers
        .scan(0.0, |sum: &mut f64, power| {
            *sum += power;
            Some(sum.sqrt())
        })
        .collect()
}
