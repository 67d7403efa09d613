//! One row a quantity: bias, rms, the limit, coverage of 95 % intervals.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// Estimates of one quantity over all seeds.
pub(crate) struct Row {
    name: String,
    truth: f64,
    limit_ratio: f64,
    errors: Vec<f64>,
    covered: usize,
    intervals: usize,
    missed: usize,
}

impl Row {
    /// A quantity with its true value and the largest rms error, relative to it (absolute where it is 0).
    pub(crate) fn new(name: String, truth: f64, limit_ratio: f64) -> Self {
        Self { name, truth, limit_ratio, errors: Vec::new(), covered: 0, intervals: 0, missed: 0 }
    }

    /// An estimate; without u it has no interval.
    pub(crate) fn add(&mut self, value: f64, u: f64, dof: f64) {
        let error = value - self.truth;
        self.errors.push(if self.truth == 0.0 { error } else { error / self.truth });
        if u > 0.0 {
            let k = StudentsT::new(0.0, 1.0, dof.min(1e6)).map_or(2.0, |t| t.inverse_cdf(0.975));
            self.intervals += 1;
            self.covered += usize::from(error.abs() <= k * u);
        }
    }

    /// A seed without estimate.
    pub(crate) fn miss(&mut self) {
        self.missed += 1;
    }
}

/// Prints all rows; a line that misses its demand ends in `<<<`.
pub(crate) fn print(rows: &[Row], seeds: u64) {
    println!("{seeds} seeds; errors relative to the truth; coverage of 95 % intervals, demanded 90 … 98 %\n");
    println!(
        "{:<40} {:>12} {:>10} {:>10} {:>10} {:>10} {:>7}",
        "quantity", "truth", "bias %", "rms %", "limit %", "cover %", "missed"
    );
    for row in rows {
        let n = row.errors.len().max(1) as f64;
        let bias = row.errors.iter().sum::<f64>() / n;
        let rms = (row.errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt();
        let cover = 100.0 * row.covered as f64 / row.intervals.max(1) as f64;
        let fine = rms <= row.limit_ratio
            && row.missed == 0
            && (row.intervals == 0 || (90.0..=98.0).contains(&cover));
        let cover = if row.intervals > 0 { format!("{cover:.1}") } else { "-".to_owned() };
        println!(
            "{:<40} {:>12.5} {:>10.4} {:>10.4} {:>10.4} {cover:>10} {:>7} {}",
            row.name,
            row.truth,
            100.0 * bias,
            100.0 * rms,
            100.0 * row.limit_ratio,
            row.missed,
            if fine { "" } else { "<<<" }
        );
    }
}
