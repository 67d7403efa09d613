//! Rate and acceleration over a stretch of a record, by a polynomial through all of its samples.

use nalgebra::{DMatrix, DVector};

use crate::estimate::Estimate;
use crate::uncertainty::correlation_factor;

/// The derivative of this order (1 or 2) of a stretch: the highest coefficient of the polynomial of the same degree that
/// fits `values` best, so its mean over the stretch, per s or per s².
///
/// The uncertainty of the derivative follows from the residuals, counted as fewer where they follow each other (ripple, structure). `None` for
/// fewer than eight samples, times that do not ascend, or values that are no numbers.
pub fn derivative(time_s: &[f64], values: &[f64], order: usize) -> Option<Estimate> {
    let n = time_s.len();
    let ascends = time_s.windows(2).all(|pair| pair[1] > pair[0]);
    if n < 8 || values.len() != n || !(1..=2).contains(&order) || !ascends {
        return None;
    }
    if time_s.iter().chain(values).any(|v| !v.is_finite()) {
        return None;
    }
    let half_s = 0.5 * (time_s[n - 1] - time_s[0]);
    let middle_s = time_s[0] + half_s;
    let design =
        DMatrix::from_fn(n, order + 1, |k, power| ((time_s[k] - middle_s) / half_s).powi(power as i32));
    // The first value is taken off: large offsets cost no digits.
    let wanted = DVector::from_iterator(n, values.iter().map(|v| v - values[0]));
    let inverse = (design.transpose() * &design).try_inverse()?;
    let fit = &inverse * (design.transpose() * &wanted);
    let residuals = &wanted - &design * &fit;
    let factor = correlation_factor(residuals.as_slice());
    let freedom = n as f64 - (order + 1) as f64;
    let variance = residuals.norm_squared() / freedom * factor * inverse[(order, order)];
    let scale = if order == 1 { 1.0 / half_s } else { 2.0 / (half_s * half_s) };
    let dof = (freedom / factor).max(1.0);
    Some(Estimate { value: fit[order] * scale, u: variance.sqrt() * scale, dof, n })
}

/// The largest magnitude of that derivative over any window of this many samples, with its sign; `None` where none fits.
pub fn largest(time_s: &[f64], values: &[f64], order: usize, window: usize) -> Option<Estimate> {
    let step = (window / 4).max(1);
    let last = time_s.len().checked_sub(window)?;
    let slope = |k: usize| derivative(&time_s[k..k + window], &values[k..k + window], order);
    let all = (0..=last).step_by(step).filter_map(slope);
    all.max_by(|a, b| a.value.abs().total_cmp(&b.value.abs()))
}

#[cfg(test)]
mod tests;
