//! How long the blocks of a bootstrap must be.

/// Correlations within ± this times √(log₁₀ n / n) count as none (Politis & White 2004).
const INSIGNIFICANT: f64 = 2.0;

/// Optimal length of circular blocks for the spread of a mean: `(2·G²/D)^⅓·n^⅓` with `G = Σ λ|k|R(k)` and
/// `D = 4/3·(Σ λR(k))²` over a flat-top window (Patton, Politis & White 2009). At least 1, at most a quarter of the record.
///
/// Blocks of length L cut off correlation: the variance that they show is too small by `G/(L·Σ λR(k))`, which is told, too,
/// 0 to ½.
pub(super) fn block_length(values: &[f64]) -> (usize, f64) {
    let n = values.len();
    if n < 8 {
        return (1, 0.0);
    }
    let mean = values.iter().sum::<f64>() / n as f64;
    let centred: Vec<f64> = values.iter().map(|v| v - mean).collect();
    let covariance =
        |lag: usize| centred[lag..].iter().zip(&centred).map(|(a, b)| a * b).sum::<f64>() / n as f64;
    let variance = covariance(0);
    if variance <= 0.0 {
        return (1, 0.0);
    }
    // So many small correlations in a row end the search; lags beyond a quarter of the record say nothing.
    let quiet = 5.max((n as f64).log10().sqrt() as usize);
    let bound = INSIGNIFICANT * ((n as f64).log10() / n as f64).sqrt();
    let mut lags = vec![variance];
    let mut small = 0;
    while small < quiet && lags.len() < n / 4 {
        let next = covariance(lags.len());
        small = if (next / variance).abs() < bound { small + 1 } else { 0 };
        lags.push(next);
    }
    let reach = (2 * (lags.len() - small)).max(1);
    let mut sum = variance;
    let mut weighted = 0.0;
    for lag in 1..reach.min(n / 4) {
        let share = lag as f64 / reach as f64;
        let window = (2.0 * (1.0 - share)).min(1.0);
        let r = window * lags.get(lag).copied().unwrap_or_else(|| covariance(lag));
        sum += 2.0 * r;
        weighted += 2.0 * lag as f64 * r;
    }
    let d = 4.0 / 3.0 * sum * sum;
    let length = if d > 0.0 { (2.0 * weighted * weighted / d * n as f64).cbrt() } else { 1.0 };
    let length = (length.ceil() as usize).clamp(1, n / 4);
    let missing = weighted / (length as f64 * sum);
    (length, if missing.is_finite() { missing.clamp(0.0, 0.5) } else { 0.0 })
}
