//! The exact command of a periodic record.

/// Departure from the other periods that counts, in parts of the rms.
const DIFFERS: f64 = 1e-6;
/// Share of samples that may differ before the reference counts as not periodic.
const MOST: f64 = 0.01;

/// One period of the reference over and over, and how many samples of the record differed from it.
///
/// `values` are whole periods of `length` samples; each place of the period takes the median over the periods.
///
/// # Errors
/// When it does not repeat, in words.
pub(super) fn repeated(name: &str, values: &[f64], length: usize) -> Result<(Vec<f64>, usize), String> {
    let periods = values.len() / length;
    if let Some(sample) = values.iter().position(|v| !v.is_finite()) {
        return Err(format!("channel `{name}`, sample {sample}: expected a finite number"));
    }
    let one: Vec<f64> = (0..length)
        .map(|i| {
            let mut at: Vec<f64> = (0..periods).map(|p| values[p * length + i]).collect();
            at.sort_by(f64::total_cmp);
            at[(periods - 1) / 2]
        })
        .collect();
    let rms = (one.iter().map(|v| v * v).sum::<f64>() / length as f64).sqrt();
    let differing =
        values.iter().enumerate().filter(|(i, v)| (**v - one[i % length]).abs() > DIFFERS * rms).count();
    if differing as f64 > MOST * values.len() as f64 {
        let share = 100.0 * differing as f64 / values.len() as f64;
        return Err(format!(
            "reference `{name}`: {share:.0} % of its samples differ from period to period, expected a command that repeats; check `period`"
        ));
    }
    Ok((one.iter().copied().cycle().take(values.len()).collect(), differing))
}
