//! Which power law the noise follows at an averaging time.

use super::{AllanError, Series};

/// Fewest averages from which the lag-1 autocorrelation tells the noise: the Handbook allows 30, but then white noise
/// is taken for another one in ten times.
const LEAST_POINTS: usize = 100;
/// Differences that are taken at most: up to random run of the rate.
const MOST_DIFFERENCES: usize = 3;
/// By how much the exponent of steep noise comes out too low where the samples are means of many: flicker noise at
/// r₁ = (9·ln 3 − 16·ln 2)/(8·ln 2) instead of −⅓, a random walk at ¼ instead of 0.
const LOW_BY_AVERAGING: f64 = 0.4;

/// Power law of the noise: S_rate(f) ∝ f^α.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Noise {
    /// α = 2: white phase; of a gyro: quantisation of the angle.
    WhitePhase,
    /// α = 1.
    FlickerPhase,
    /// α = 0: white rate; of a gyro: angle random walk.
    WhiteRate,
    /// α = −1; of a gyro: bias instability.
    FlickerRate,
    /// α = −2; of a gyro: rate random walk.
    WalkRate,
    /// α = −3.
    FlickerWalk,
    /// α = −4: random run, or a drift.
    RunRate,
}

impl Noise {
    /// From the steepest spectrum of the phase down.
    const ALL: [Self; 7] = [
        Self::WhitePhase,
        Self::FlickerPhase,
        Self::WhiteRate,
        Self::FlickerRate,
        Self::WalkRate,
        Self::FlickerWalk,
        Self::RunRate,
    ];

    /// Exponent α of the rate's spectrum.
    pub fn exponent(self) -> i32 {
        2 - self as i32
    }

    fn of_exponent(exponent: f64) -> Self {
        let index = (2.0 - exponent).round().clamp(0.0, 6.0) as usize;
        Self::ALL[index]
    }
}

/// Noise at each averaging factor, by the lag-1 autocorrelation of the phases m apart (Riley & Greenhall, *Proc. 18th
/// EFTF*, 2004; NIST SP 1065, 5.5.3): differenced until δ = r₁/(1 + r₁) falls below ¼, α = 2 − 2·(δ + differences).
/// From m = 2 on 0.4 is added from two differences on: means of flicker noise would lie half way to a random walk.
///
/// Where fewer than 100 averages are left the noise of the last factor that had them stands in; a series too short for
/// any is taken as white rate.
///
/// # Errors
/// [`AllanError::Factor`] for a factor of 0.
pub fn identify(series: &Series, factors: &[usize]) -> Result<Vec<Noise>, AllanError> {
    let rates = series.rates();
    let mut last = Noise::WhiteRate;
    factors
        .iter()
        .map(|&m| {
            if m == 0 {
                return Err(AllanError::Factor { factor: 0, most: rates / 2, rates });
            }
            if rates / m >= LEAST_POINTS {
                last = at(series.phase().iter().copied().step_by(m).collect(), m > 1).unwrap_or(last);
            }
            Ok(last)
        })
        .collect()
}

fn at(mut phase: Vec<f64>, averaged: bool) -> Option<Noise> {
    for differences in 0..=MOST_DIFFERENCES {
        let r1 = lag_one(&phase)?;
        let delta = r1 / (1.0 + r1);
        if delta < 0.25 || differences == MOST_DIFFERENCES {
            let low_by = if averaged && differences > 1 { LOW_BY_AVERAGING } else { 0.0 };
            return Some(Noise::of_exponent(2.0 - 2.0 * (delta + differences as f64) + low_by));
        }
        phase = phase.windows(2).map(|z| z[1] - z[0]).collect();
    }
    None
}

/// Lag-1 autocorrelation; `None` for a constant.
fn lag_one(z: &[f64]) -> Option<f64> {
    let mean = z.iter().sum::<f64>() / z.len() as f64;
    let power: f64 = z.iter().map(|v| (v - mean).powi(2)).sum();
    let next: f64 = z.windows(2).map(|v| (v[0] - mean) * (v[1] - mean)).sum();
    // At −1 the ratio below has a pole.
    (power > 0.0).then(|| (next / power).max(-0.49))
}
