//! Mean and spread of runs that come from one side.

/// Runs at one target from one side; rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// Mean deviation x̄.
    pub mean_rad: f64,
    /// Standard deviation s of the runs, with n − 1.
    pub deviation_rad: f64,
    /// Runs.
    pub runs: usize,
}

impl Direction {
    pub(super) fn of(runs_rad: &[f64]) -> Self {
        let (mean_rad, deviation_rad) = deviation(runs_rad);
        Self { mean_rad, deviation_rad, runs: runs_rad.len() }
    }

    /// Unidirectional repeatability 4s.
    pub fn repeatability_rad(&self) -> f64 {
        4.0 * self.deviation_rad
    }

    /// x̄ + 2s.
    pub fn high_rad(&self) -> f64 {
        self.mean_rad + 2.0 * self.deviation_rad
    }

    /// x̄ − 2s.
    pub fn low_rad(&self) -> f64 {
        self.mean_rad - 2.0 * self.deviation_rad
    }
}

/// Mean and standard deviation (with n − 1); the latter is 0 for fewer than two values, both for none.
pub fn deviation(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    if values.is_empty() {
        return (0.0, 0.0);
    }
    let mean = values.iter().sum::<f64>() / n;
    let sum: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (mean, if values.len() > 1 { (sum / (n - 1.0)).sqrt() } else { 0.0 })
}
