//! Allan deviations and their relatives: from rates or phases, with intervals, and the five noises behind them.
//!
//! A *rate* is what a gyro (or a clock, as fractional frequency) reads, averaged over each sampling period; its
//! integral is the *phase* (angle, time). With N+1 phases x there are N rates. Deviations carry the unit of the rate,
//! the time deviations that times seconds.
//!
//! Source: W. J. Riley, *Handbook of Frequency Stability Analysis*, NIST SP 1065 (2008); for gyros IEEE Std 952,
//! annex C.

mod confidence;
mod factors;
mod fit;
mod freedom;
mod gram;
mod modified;
mod noise;
mod plain;
mod screen;
mod series;
mod steps;
#[cfg(test)]
mod tests;
mod theo;
mod total;

pub use confidence::{Bounded, bounded};
pub use factors::Spacing;
pub use fit::{FIT_TERMS, NoiseFit, NoiseTerm, fit};
pub use freedom::freedom;
pub use noise::{Noise, identify};
pub use screen::{Drift, drift, quantum_of};
pub use series::Series;
pub use steps::{OutputStep, output_step};

/// What is computed from the phases; "O" is overlapping, m the averaging factor, τ = m·τ0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statistic {
    /// Allan deviation of neighbouring averages without overlap.
    Adev,
    /// Allan deviation of all overlapping averages: what is meant by *the* Allan deviation.
    Oadev,
    /// Modified Allan deviation: tells white from flicker phase noise.
    Mdev,
    /// Time deviation, τ/√3 of the modified one; unit of the rate times s.
    Tdev,
    /// Hadamard deviation: blind to a constant drift of the rate.
    Hdev,
    /// Hadamard deviation of all overlapping averages.
    Ohdev,
    /// Total deviation: the phases continued by reflection; at long τ narrower than [`Statistic::Oadev`].
    Totdev,
    /// Modified total deviation, without correction of its bias ([`Statistic::bias_ratio`]).
    Mtotdev,
    /// Time total deviation, τ/√3 of the modified total; unit of the rate times s.
    Ttotdev,
    /// Hadamard total deviation, without correction of its bias.
    Htotdev,
    /// Thêo1, without correction of its bias; m is even, its τ is 0.75·m·τ0.
    Theo1,
    /// Parabolic deviation: averages weighted as by a least-squares slope of the phase.
    Pdev,
}

impl Statistic {
    /// Every statistic, in order of declaration.
    pub const ALL: [Self; 12] = [
        Self::Adev,
        Self::Oadev,
        Self::Mdev,
        Self::Tdev,
        Self::Hdev,
        Self::Ohdev,
        Self::Totdev,
        Self::Mtotdev,
        Self::Ttotdev,
        Self::Htotdev,
        Self::Theo1,
        Self::Pdev,
    ];

    /// Largest averaging factor that leaves one term of `rates` rates; 0 if there is none.
    pub fn largest_factor(self, rates: usize) -> usize {
        match self {
            Self::Adev | Self::Oadev | Self::Pdev => rates / 2,
            Self::Totdev => rates.saturating_sub(1),
            Self::Mdev | Self::Tdev | Self::Mtotdev | Self::Ttotdev => (rates + 1) / 3,
            Self::Hdev | Self::Ohdev | Self::Htotdev => rates / 3,
            Self::Theo1 => rates / 2 * 2,
        }
    }

    /// Averaging time of a factor, s.
    pub fn tau_s(self, factor: usize, period_s: f64) -> f64 {
        let stride = if self == Self::Theo1 { 0.75 } else { 1.0 };
        stride * factor as f64 * period_s
    }

    /// Mean of the uncorrected variance over the true (modified, Hadamard) Allan variance that it stands for; `None` where
    /// the statistic has no bias or the noise no published figure.
    ///
    /// Divide the deviation by its root. NIST SP 1065, tables of the total variances; the fall of `Totdev` towards the
    /// end of the record is 1 − a·m/rates.
    pub fn bias_ratio(self, noise: Noise, factor: usize, rates: usize) -> Option<f64> {
        use Noise as W;
        let part = factor as f64 / rates as f64;
        match (self, noise) {
            (Self::Totdev, W::WhiteRate) => Some(1.0),
            (Self::Totdev, W::FlickerRate) => Some(1.0 - part / (3.0 * std::f64::consts::LN_2)),
            (Self::Totdev, W::WalkRate) => Some(1.0 - 0.75 * part),
            (Self::Mtotdev | Self::Ttotdev, W::WhitePhase) => Some(0.94),
            (Self::Mtotdev | Self::Ttotdev, W::FlickerPhase) => Some(0.83),
            (Self::Mtotdev | Self::Ttotdev, W::WhiteRate) => Some(0.73),
            (Self::Mtotdev | Self::Ttotdev, W::FlickerRate) => Some(0.70),
            (Self::Mtotdev | Self::Ttotdev, W::WalkRate) => Some(0.69),
            (Self::Htotdev, _) if factor == 1 => None,
            (Self::Htotdev, W::WhiteRate) => Some(0.995),
            (Self::Htotdev, W::FlickerRate) => Some(0.851),
            (Self::Htotdev, W::WalkRate) => Some(0.771),
            (Self::Htotdev, W::FlickerWalk) => Some(0.717),
            (Self::Htotdev, W::RunRate) => Some(0.679),
            _ => None,
        }
    }
}

/// A deviation at one averaging time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Averaging factor m.
    pub factor: usize,
    /// Averaging time, s.
    pub tau_s: f64,
    /// The deviation; unit of the rate (times s for the time deviations).
    pub deviation: f64,
    /// Terms that went in; they overlap, so this is no count of degrees of freedom.
    pub terms: usize,
}

/// Why there is no deviation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AllanError {
    /// The record is too short.
    #[error("{found} rates, at least {least} are needed: use a longer record")]
    TooShort {
        /// Rates found.
        found: usize,
        /// Rates needed.
        least: usize,
    },
    /// A number is not finite.
    #[error("sample {index} is not a finite number: remove it and treat the rest as a record with a gap")]
    NotFinite {
        /// Index of the first one.
        index: usize,
    },
    /// All rates are the same.
    #[error("all rates are the same: the sensor is stuck, or its resolution is coarser than its noise")]
    Constant,
    /// The sampling period makes no sense.
    #[error("sampling period {period_s} s, expected a positive number")]
    Period {
        /// What was given.
        period_s: f64,
    },
    /// An averaging factor that the record or the statistic does not allow.
    #[error("averaging factor {factor}, expected 1 to {most} for {rates} rates (Thêo1: even, 10 or more)")]
    Factor {
        /// What was given.
        factor: usize,
        /// The largest.
        most: usize,
        /// Rates in the record.
        rates: usize,
    },
    /// Too few averaging times for the five noises.
    #[error(
        "{found} averaging times, at least {least} are needed to fit the noise processes: use a longer record"
    )]
    TooFewTimes {
        /// Averaging times found.
        found: usize,
        /// Averaging times needed.
        least: usize,
    },
    /// The deviations do not determine the noises.
    #[error("the deviations do not fit any sum of the five noise processes")]
    NoFit,
}

/// Deviations at averaging factors, in their order.
///
/// Deterministic for any number of threads. The plain and overlapping ones cost O(N) a factor, so do `Mdev` and
/// `Pdev`; `Mtotdev`, `Htotdev` and `Theo1` cost O(N·m).
///
/// # Errors
/// [`AllanError::Factor`] for a factor that leaves no term.
pub fn deviations(
    series: &Series,
    statistic: Statistic,
    factors: &[usize],
) -> Result<Vec<Deviation>, AllanError> {
    let most = statistic.largest_factor(series.rates());
    let allowed = |m: usize| match statistic {
        Statistic::Theo1 => (10..=most).contains(&m) && m.is_multiple_of(2),
        _ => (1..=most).contains(&m),
    };
    if let Some(&factor) = factors.iter().find(|m| !allowed(**m)) {
        return Err(AllanError::Factor { factor, most, rates: series.rates() });
    }
    let sums = match statistic {
        Statistic::Oadev => plain::overlapping::<2>(series.phase(), factors),
        Statistic::Ohdev => plain::overlapping::<3>(series.phase(), factors),
        _ => factors.iter().map(|&m| sum(series, statistic, m)).collect(),
    };
    let one = |(&factor, (sum, terms)): (&usize, (f64, usize))| {
        let tau_s = statistic.tau_s(factor, series.period_s());
        let deviation =
            series.unit() * (sum / terms as f64).sqrt() * scale(statistic, factor, series.period_s());
        Deviation { factor, tau_s, deviation, terms }
    };
    Ok(factors.iter().zip(sums).map(one).collect())
}

/// Sum of squares and its terms, in phases.
fn sum(series: &Series, statistic: Statistic, m: usize) -> (f64, usize) {
    let x = series.phase();
    match statistic {
        Statistic::Oadev | Statistic::Adev => plain::apart::<2>(x, m),
        Statistic::Ohdev | Statistic::Hdev => plain::apart::<3>(x, m),
        Statistic::Mdev | Statistic::Tdev => modified::modified(x, m),
        Statistic::Pdev => modified::parabolic(x, m),
        Statistic::Totdev => total::total(x, m),
        Statistic::Mtotdev | Statistic::Ttotdev => total::reflected(x, m),
        Statistic::Htotdev if m == 1 => plain::apart::<3>(x, 1),
        Statistic::Htotdev => total::reflected(&series.differences(), m),
        Statistic::Theo1 => theo::theo1(x, m),
    }
}

/// Factor between the root of the mean square of phase differences and the deviation.
fn scale(statistic: Statistic, m: usize, period_s: f64) -> f64 {
    let tau_s = m as f64 * period_s;
    match statistic {
        Statistic::Adev | Statistic::Oadev | Statistic::Totdev | Statistic::Mdev | Statistic::Mtotdev => {
            1.0 / (2.0_f64.sqrt() * tau_s)
        }
        Statistic::Tdev | Statistic::Ttotdev => 1.0 / 6.0_f64.sqrt(),
        Statistic::Hdev | Statistic::Ohdev => 1.0 / (6.0_f64.sqrt() * tau_s),
        // Of differences of phase, not of rates.
        Statistic::Htotdev => 1.0 / (6.0_f64.sqrt() * period_s),
        Statistic::Theo1 => 1.0 / (0.75_f64.sqrt() * tau_s),
        Statistic::Pdev => 72.0_f64.sqrt() / tau_s,
    }
}
