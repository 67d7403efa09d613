//! What a load that repeats asks of a drive and its supply: root mean square, peaks, the longest time above a level.

use super::uncertainty::{Component, combine, mean_of_repeats};

/// A value with standard uncertainty, degrees of freedom and count of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// In the unit of the samples.
    pub value: f64,
    /// Standard uncertainty, same unit.
    pub u: f64,
    /// Degrees of freedom of u.
    pub dof: f64,
    /// Samples.
    pub n: usize,
}

/// Root mean square over whole cycles, `rows` of each.
///
/// Uncertainty: the scale's (`scale_u_ratio`, known) and the scatter between cycles of their mean squares, where there
/// are two or more. `None` without samples, or where one is no number.
pub fn rms(values: &[f64], cycles: &[std::ops::Range<usize>], scale_u_ratio: f64) -> Option<Load> {
    let mean_square = |rows: &std::ops::Range<usize>| {
        let values = values.get(rows.clone()).filter(|values| !values.is_empty())?;
        Some(values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64)
    };
    let squares: Vec<f64> = cycles.iter().map(mean_square).collect::<Option<_>>()?;
    if squares.is_empty() || squares.iter().any(|square| !square.is_finite()) {
        return None;
    }
    let value = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    let scale = Component::known(scale_u_ratio * value);
    // d√m = dm / 2√m.
    let scatter = mean_of_repeats(&squares).filter(|_| value > 0.0);
    let all = match scatter {
        Some((_, c)) => combine(&[scale, Component { u: c.u / (2.0 * value), ..c }]),
        None => scale,
    };
    Some(Load {
        value,
        u: all.u,
        dof: all.dof,
        n: cycles.iter().map(std::iter::ExactSizeIterator::len).sum(),
    })
}

/// Smallest and largest sample; `None` without any, or where one is no number.
pub fn extremes(values: &[f64]) -> Option<[f64; 2]> {
    if values.is_empty() || values.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Some([low, high])
}

/// Longest time for which |value| stays above `level`, from the first sample above to the first that is not, s.
///
/// A gap of up to `bridge_s` does not end it: noise about the level is not a pause that cools anything. `None` without
/// samples, or where one is no number.
pub fn longest_above_s(time_s: &[f64], values: &[f64], level: f64, bridge_s: f64) -> Option<f64> {
    if time_s.is_empty() || time_s.len() != values.len() || values.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let (mut longest, mut since, mut last_above): (f64, Option<f64>, f64) = (0.0, None, 0.0);
    for (&t, value) in time_s.iter().zip(values) {
        if value.abs() > level {
            last_above = t;
            since = since.or(Some(t));
        } else if let Some(from) = since {
            longest = longest.max(last_above - from);
            since = since.filter(|_| t - last_above <= bridge_s);
        }
    }
    Some(since.map_or(longest, |from| longest.max(last_above - from)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_mean_square_of_a_square_wave_is_its_height_and_scatter_between_cycles_counts() {
        let values: Vec<f64> = (0..400).map(|k| if k % 2 == 0 { 3.0 } else { -3.0 }).collect();
        let even = rms(&values, &[0..200, 200..400], 0.01).expect("numbers");
        assert!((even.value - 3.0).abs() < 1e-12 && (even.u - 0.03).abs() < 1e-12, "{even:?}");
        let uneven: Vec<f64> =
            values.iter().enumerate().map(|(k, v)| if k < 200 { 2.0 * v } else { *v }).collect();
        let load = rms(&uneven, &[0..200, 200..400], 0.01).expect("numbers");
        // Mean squares 36 and 9: their mean has u 13.5, the root of 22.5 one of 13.5/(2·4.743).
        assert!((load.u - (13.5_f64 / (2.0 * 22.5_f64.sqrt())).hypot(0.01 * 22.5_f64.sqrt())).abs() < 1e-9);
        assert!(load.dof < 1.1, "two cycles: {load:?}");
    }

    #[test]
    fn a_load_above_its_level_is_timed_across_noise_and_not_across_a_pause() {
        let time: Vec<f64> = (0..100).map(|k| f64::from(k) * 0.01).collect();
        let above = |k: usize| matches!(k, 10..=29 | 32..=49 | 70..=79);
        let values: Vec<f64> = (0..100).map(|k| if above(k) { -5.0 } else { 1.0 }).collect();
        let seen = longest_above_s(&time, &values, 4.0, 0.05).expect("numbers");
        assert!((seen - 0.39).abs() < 1e-9, "{seen}");
        let strict = longest_above_s(&time, &values, 4.0, 0.0).expect("numbers");
        assert!((strict - 0.19).abs() < 1e-9, "{strict}");
    }

    #[test]
    fn nothing_and_what_is_no_number_give_nothing() {
        assert_eq!(rms(&[], &[], 0.01), None);
        assert_eq!(rms(&[1.0, f64::NAN], std::slice::from_ref(&(0..2)), 0.01), None);
        assert_eq!(extremes(&[1.0, f64::NAN]), None);
        assert_eq!(extremes(&[]), None);
        assert_eq!(longest_above_s(&[0.0], &[], 1.0, 0.0), None);
        assert_eq!(extremes(&[2.0, -1.0]), Some([-1.0, 2.0]));
    }
}
