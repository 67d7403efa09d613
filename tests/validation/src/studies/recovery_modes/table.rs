//! One row a quantity: bias, rms, the limit, stated uncertainty over scatter, coverage of 95 % intervals.

/// Estimates of one quantity over all seeds.
pub(crate) struct Row {
    name: String,
    limit: f64,
    /// Where the limit comes from, if it is not the demand.
    note: String,
    /// Demanded range of stated over true standard uncertainty.
    ratio: [f64; 2],
    errors: Vec<f64>,
    stated: Vec<f64>,
    missed: usize,
}

impl Row {
    /// A quantity with the largest rms error.
    pub(crate) fn new(name: String, limit: f64) -> Self {
        Self {
            name,
            limit,
            note: String::new(),
            ratio: [0.85, 1.15],
            errors: Vec::new(),
            stated: Vec::new(),
            missed: 0,
        }
    }

    /// With a word on the limit.
    pub(crate) fn noted(self, note: String) -> Self {
        Self { note, ..self }
    }

    /// An error and the standard uncertainty stated for it (0 if none is).
    pub(crate) fn add(&mut self, error: f64, u: f64) {
        self.errors.push(error);
        self.stated.push(u);
    }

    /// A seed without estimate.
    pub(crate) fn miss(&mut self) {
        self.missed += 1;
    }
}

/// Prints all rows; a line that misses its demand ends in `<<<`.
pub(crate) fn print(rows: &[Row], seeds: u64) {
    println!("{seeds} seeds; u/sd: mean stated variance over scatter, demanded 0.85 … 1.15;");
    println!("coverage of 95 % intervals, demanded 90 … 98 %\n");
    println!(
        "{:<46} {:>11} {:>11} {:>11} {:>7} {:>8} {:>7}",
        "quantity", "bias", "rms", "limit", "u/sd", "cover %", "missed"
    );
    for row in rows {
        let n = row.errors.len().max(1) as f64;
        let mean = |f: &dyn Fn(f64) -> f64, of: &[f64]| of.iter().map(|e| f(*e)).sum::<f64>() / n;
        let bias = mean(&|e| e, &row.errors);
        let rms = mean(&|e| e * e, &row.errors).sqrt();
        let stated = mean(&|u| u * u, &row.stated).sqrt();
        let within = row.errors.iter().zip(&row.stated).filter(|(e, u)| e.abs() <= 1.96 * **u).count();
        let ratio = stated / rms;
        let cover = 100.0 * within as f64 / n;
        let believed = stated > 0.0;
        let fine = rms <= row.limit
            && row.missed == 0
            && (!believed
                || ((row.ratio[0]..=row.ratio[1]).contains(&ratio) && (90.0..=98.0).contains(&cover)));
        let columns =
            if believed { format!("{ratio:>7.3} {cover:>8.1}") } else { format!("{:>7} {:>8}", "-", "-") };
        println!(
            "{:<46} {bias:>11.3e} {rms:>11.3e} {:>11.3e} {columns} {:>7} {}{}",
            row.name,
            row.limit,
            row.missed,
            row.note,
            if fine { "" } else { " <<<" }
        );
    }
}
