//! A power spectral density with its uncertainty.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::{SpectraError, WelchSettings, complex_lines};

/// One-sided power spectral density of a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Psd {
    /// Frequencies, Hz: 0 to half the sample rate.
    pub frequency_hz: Vec<f64>,
    /// Density at each, unit²/Hz.
    pub density: Vec<f64>,
    /// Degrees of freedom of each: 2·n_d; n_d at 0 Hz and half the sample rate, which are real.
    pub dof: Vec<f64>,
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
}
