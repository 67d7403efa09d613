//! Gyros against an encoder while one axis turns: direction, scale and delay.

use std::ops::Range;

use super::least_squares::{FitError, LinearFit};
use super::uncertainty::correlation_factor;

#[cfg(test)]
mod tests;

/// Fewest samples.
const LEAST_SAMPLES: usize = 100;
/// Columns of the fit: rate, acceleration, jerk, constant, angle, its square.
const COLUMNS: usize = 6;
/// Half of the time over which the jerk is taken. Over single samples the noise of an encoder hides it, and so does the
/// ringing of the first structural mode (10 Hz and more), which follows another law.
const JERK_S: f64 = 40e-3;

/// What gyros show of a turning axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turning {
    /// Rate along each direction over the rate of the axis.
    pub along: [f64; 3],
    /// Standard uncertainty of `along`, correlation of the residuals considered.
    pub u: [f64; 3],
    /// How much later the gyros show it than the encoder, s.
    pub delay_s: f64,
    /// Standard uncertainty of `delay_s`.
    pub delay_u_s: f64,
    /// Samples.
    pub n: usize,
    /// Degrees of freedom.
    pub dof: f64,
}

/// Why there is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TurningError {
    /// Arrays of different length.
    #[error("expected {expected} samples, found {found}")]
    Length {
        /// Samples of the axis.
        expected: usize,
        /// Samples of what does not fit them.
        found: usize,
    },
    /// Too few samples.
    #[error("{found} samples, at least {least} are needed")]
    TooFew {
        /// Samples found.
        found: usize,
        /// Samples needed.
        least: usize,
    },
    /// The gyros show nothing.
    #[error("the gyros show no motion of the axis")]
    Nothing,
    /// The motion does not determine it: it needs both directions and accelerations.
    #[error("{0}: the axis must turn in both directions")]
    Fit(#[from] FitError),
}

impl Turning {
    /// Fits each of three rates (rad/s, `period_s` apart) by g·Ω(t − τ) + j·d²Ω/dt² + constant + parabola of the angle,
    /// Ω the rate of the axis (rad/s) and `angle_rad` its angle; all means over the same periods.
    ///
    /// τ comes out of the part that follows the acceleration, −g·τ·dΩ/dt, right to (ωτ)²/6 for motion at ω. The part
    /// that follows the jerk takes what a structure between encoder and gyros adds below its first natural frequency
    /// ω₁, g·Ω·(ω/ω₁)², which would read as scale otherwise. The parabola takes the Earth's rate, which changes with
    /// the angle and not with the direction of the motion.
    ///
    /// # Errors
    /// See [`TurningError`].
    pub fn new(
        along: [&[f64]; 3],
        rate_rad_per_s: &[f64],
        angle_rad: &[f64],
        period_s: f64,
    ) -> Result<Self, TurningError> {
        let n = rate_rad_per_s.len();
        let lengths = along.iter().map(|a| a.len()).chain([angle_rad.len()]);
        if let Some(found) = lengths.into_iter().find(|found| *found != n) {
            return Err(TurningError::Length { expected: n, found });
        }
        let lag = ((JERK_S / period_s).round() as usize).max(1);
        let least = LEAST_SAMPLES.max(4 * lag);
        if n < least {
            return Err(TurningError::TooFew { found: n, least });
        }
        let inner = lag..n - lag;
        let columns = columns(rate_rad_per_s, angle_rad, &inner, period_s);
        let mut fits = Vec::with_capacity(3);
        for rate in along {
            let fit = LinearFit::new(&columns, &rate[inner.clone()], None)?;
            let wide = correlation_factor(&fit.residuals).sqrt();
            fits.push([fit.coefficients[0], fit.u(0) * wide, fit.coefficients[1], fit.u(1) * wide]);
        }
        let square: f64 = fits.iter().map(|f| f[0] * f[0]).sum();
        let u2: f64 = fits.iter().map(|f| f[1] * f[1]).sum();
        if square <= 9.0 * u2 {
            return Err(TurningError::Nothing);
        }
        let delay_s = -fits.iter().map(|f| f[0] * f[2]).sum::<f64>() / square;
        let delay_u_s = fits.iter().map(|f| (f[0] * f[3]).powi(2)).sum::<f64>().sqrt() / square;
        Ok(Self {
            along: std::array::from_fn(|k| fits[k][0]),
            u: std::array::from_fn(|k| fits[k][1]),
            delay_s,
            delay_u_s,
            n,
            dof: (inner.len() - COLUMNS) as f64,
        })
    }

    /// Size of the rate over that of the axis, less 1, with its standard uncertainty.
    pub fn scale_error(&self) -> (f64, f64) {
        let size = self.size();
        let u2: f64 = self.along.iter().zip(self.u).map(|(a, u)| (a / size * u).powi(2)).sum();
        (size - 1.0, u2.sqrt())
    }

    /// Angle between the direction found and an expected unit vector, rad (π: the opposite sign), with its standard
    /// uncertainty.
    pub fn angle_from_rad(&self, expected: [f64; 3]) -> (f64, f64) {
        let size = self.size();
        let own: f64 = self.along.iter().zip(expected).map(|(a, e)| a * e).sum();
        let across: [f64; 3] = std::array::from_fn(|k| self.along[k] - own * expected[k]);
        let off = across.iter().map(|a| a * a).sum::<f64>().sqrt();
        let along_error = |k: usize| if off > 0.0 { across[k] / off } else { 1.0 };
        let u2: f64 = (0..3).map(|k| (along_error(k) * self.u[k] / size).powi(2)).sum();
        (off.atan2(own), u2.sqrt())
    }

    fn size(&self) -> f64 {
        self.along.iter().map(|a| a * a).sum::<f64>().sqrt()
    }
}

/// Columns of the samples `inner`, which leaves the lag of the jerk out at both ends.
fn columns(rate: &[f64], angle: &[f64], inner: &Range<usize>, period_s: f64) -> Vec<Vec<f64>> {
    let lag = inner.start;
    let lag_s = lag as f64 * period_s;
    let middle = angle.iter().sum::<f64>() / angle.len() as f64;
    let column = |value: &dyn Fn(usize) -> f64| inner.clone().map(value).collect::<Vec<f64>>();
    vec![
        column(&|k| rate[k]),
        column(&|k| (rate[k + 1] - rate[k - 1]) / (2.0 * period_s)),
        column(&|k| (rate[k + lag] - 2.0 * rate[k] + rate[k - lag]) / (lag_s * lag_s)),
        column(&|_| 1.0),
        column(&|k| angle[k] - middle),
        column(&|k| (angle[k] - middle).powi(2)),
    ]
}
