//! Whether the first window still holds a transient.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::error::{PeriodicError, within_range};
use super::fast::tail;
use super::ratio::{mean, rectangular};
use crate::frf::C64;

/// First window against the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transient {
    /// Probability of such a difference from the scatter of the rest alone.
    pub probability: f64,
    /// rms over the lines of the difference, over rms of the mean of the rest.
    pub difference_ratio: f64,
}

impl Transient {
    /// Whether the first window may be used with the rest (at 1 % of false alarms).
    pub fn is_settled(&self) -> bool {
        self.probability >= 0.01
    }
}

/// Tests the first window (in time) against the mean of all later ones (the last alone would throw away what the
/// others know): per line |X₁ − X̄|²/(var·(1 + 1/(P − 1))) follows F(2, 2(P − 2)), whose tail is a closed form; the
/// lines are joined by −2·Σ ln p, χ² with 2 a line (Fisher, *Statistical Methods for Research Workers*, §21.1).
/// Phases must refer to one time ([`super::spectra`], [`super::transfer`]).
///
/// # Errors
/// [`PeriodicError::TooFew`] below three windows or without a line; [`PeriodicError::Length`],
/// [`PeriodicError::NotFinite`], [`PeriodicError::TooLarge`].
pub fn transient(windows: &[Vec<C64>]) -> Result<Transient, PeriodicError> {
    if windows.len() < 3 {
        return Err(PeriodicError::TooFew { what: "windows", expected: 3, found: windows.len() });
    }
    let lines = windows[0].len();
    if lines == 0 {
        return Err(PeriodicError::TooFew { what: "lines", expected: 1, found: 0 });
    }
    rectangular("windows", lines, windows.len(), windows)?;
    let later = &windows[1..];
    let rest = later.len() as f64;
    let mut statistic = 0.0;
    let mut difference = 0.0;
    let mut power = 0.0;
    for l in 0..lines {
        let middle = mean(later, l);
        let spread = later.iter().map(|w| (w[l] - middle).norm_sqr()).sum::<f64>() / (rest - 1.0);
        let far = (windows[0][l] - middle).norm_sqr();
        // Noise-free records agree to rounding: that is no transient.
        let floor = 1e-24 * middle.norm_sqr();
        statistic -= 2.0 * tail(far, (spread + floor) * (1.0 + 1.0 / rest), rest - 1.0).max(1e-300).ln();
        difference += far;
        power += middle.norm_sqr();
    }
    within_range("amplitudes", difference + power)?;
    let probability = ChiSquared::new(2.0 * lines as f64).map_or(1.0, |c| c.sf(statistic));
    let difference_ratio = if power > 0.0 { (difference / power).sqrt() } else { 0.0 };
    Ok(Transient { probability, difference_ratio })
}
