//! Signs and scales of the paths from torque to sensor, from small motions about rest.

use super::least_squares::{FitError, LinearFit};
use super::uncertainty::correlation_factor;
use crate::measurement::Estimate;

#[cfg(test)]
mod tests;

/// Angle that an axis gives way under torque, rad per N·m, signed: `θ = c·T + drift`.
///
/// `time_s`, `torque_nm` and `angle_rad` are samples in order, equally long. The drift is a straight line: an axis that
/// still sags under its load.
///
/// # Errors
/// Too few samples, or a torque that does not change.
pub fn compliance(time_s: &[f64], torque_nm: &[f64], angle_rad: &[f64]) -> Result<Estimate, FitError> {
    let start_s = time_s.first().copied().unwrap_or(0.0);
    let since: Vec<f64> = time_s.iter().map(|t| t - start_s).collect();
    let columns = [torque_nm.to_vec(), vec![1.0; since.len()], since];
    coefficient(&LinearFit::new(&columns, angle_rad, None)?, 0)
}

/// Rates along three axes of the frame per rate of an encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateResponse {
    /// Along each axis, signed, dimensionless.
    pub along: [f64; 3],
    /// Standard uncertainty of each.
    pub u: [f64; 3],
    /// Means that went in.
    pub n: usize,
}

impl RateResponse {
    /// Length of the response: 1 where gyro and encoder agree about the angle.
    pub fn size(&self) -> f64 {
        self.along.iter().map(|g| g * g).sum::<f64>().sqrt()
    }

    /// Standard uncertainty of [`RateResponse::size`].
    pub fn size_u(&self) -> f64 {
        let size = self.size().max(f64::MIN_POSITIVE);
        self.along.iter().zip(&self.u).map(|(g, u)| (g * u / size).powi(2)).sum::<f64>().sqrt()
    }

    /// Part of it along a unit vector, over its size: 1 the same direction, −1 the opposite one.
    pub fn alignment(&self, direction: [f64; 3]) -> f64 {
        let dot: f64 = self.along.iter().zip(direction).map(|(g, d)| g * d).sum();
        dot / self.size().max(f64::MIN_POSITIVE)
    }
}

/// Fits `ω_k = g_k·dθ/dt + offset_k` for three rates over means of `mean_s`.
///
/// `gyro_s` are the times at which a mean rate since the sample before was taken, `rates_rad_per_s` the three rates at
/// these times, `angle_rad` the encoder's angle at these times. The offset holds bias and Earth rate. Means of 50 ms
/// make the noise of the encoder's difference (a tenth of a microradian) small against that of a fibre-optic gyro.
///
/// # Errors
/// Too few means, or an encoder that does not move.
pub fn rate_response(
    gyro_s: &[f64],
    rates_rad_per_s: [&[f64]; 3],
    angle_rad: &[f64],
    mean_s: f64,
) -> Result<RateResponse, FitError> {
    let expected = gyro_s.len();
    let lengths = rates_rad_per_s.iter().map(|r| r.len()).chain([angle_rad.len()]);
    if let Some(found) = lengths.into_iter().find(|&found| found != expected) {
        return Err(FitError::Length { expected, found });
    }
    let mut turned = Vec::new();
    let mut seen: [Vec<f64>; 3] = Default::default();
    let mut from = 0;
    for to in 1..expected {
        let lasted_s = gyro_s[to] - gyro_s[from];
        if lasted_s < mean_s {
            continue;
        }
        turned.push((angle_rad[to] - angle_rad[from]) / lasted_s);
        for (seen, rates) in seen.iter_mut().zip(rates_rad_per_s) {
            let integral: f64 = (from + 1..=to).map(|k| rates[k] * (gyro_s[k] - gyro_s[k - 1])).sum();
            seen.push(integral / lasted_s);
        }
        from = to;
    }
    let columns = [turned, vec![1.0; seen[0].len()]];
    let mut response = RateResponse { along: [0.0; 3], u: [0.0; 3], n: seen[0].len() };
    for (k, rates) in seen.iter().enumerate() {
        let fit = LinearFit::new(&columns, rates, None)?;
        (response.along[k], response.u[k]) = (fit.coefficients[0], fit.u(0));
    }
    Ok(response)
}

/// Torque that acts over torque that is said to act, from the change of acceleration when the torque is switched off.
///
/// Friction, load and what the bristles store are continuous there, so they cancel: over a short stretch about the
/// switch they follow angle and rate linearly. Twice integrated, `θ = s·∬T/J + a·∫θ + b·∬θ + c0 + c1·t + c2·t²`; `s` is
/// the answer. Integrals instead of derivatives: noise of the encoder is smoothed, flexible modes (10…80 Hz) average
/// out.
///
/// `time_s`, `torque_nm` (measured, so its delay is that of the angle) and `angle_rad` are samples in order; the axis
/// must not turn round inside.
///
/// # Errors
/// Too few samples, or nothing is switched.
pub fn torque_scale(
    time_s: &[f64],
    torque_nm: &[f64],
    angle_rad: &[f64],
    inertia_kg_m2: f64,
) -> Result<Estimate, FitError> {
    let expected = time_s.len();
    if let Some(found) = [torque_nm.len(), angle_rad.len()].into_iter().find(|&n| n != expected) {
        return Err(FitError::Length { expected, found });
    }
    let (start_s, start_rad) =
        (time_s.first().copied().unwrap_or(0.0), angle_rad.first().copied().unwrap_or(0.0));
    let since: Vec<f64> = time_s.iter().map(|t| t - start_s).collect();
    let turned: Vec<f64> = angle_rad.iter().map(|a| a - start_rad).collect();
    let push: Vec<f64> = torque_nm.iter().map(|t| t / inertia_kg_m2).collect();
    let pushed = integral(&since, &integral(&since, &push));
    let once = integral(&since, &turned);
    let twice = integral(&since, &once);
    let square = since.iter().map(|t| t * t).collect();
    let columns = [pushed, once, twice, vec![1.0; expected], since.clone(), square];
    coefficient(&LinearFit::new(&columns, &turned, None)?, 0)
}

/// Trapezoids from the first sample on.
fn integral(time_s: &[f64], values: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let mut all = Vec::with_capacity(values.len());
    for k in 0..values.len() {
        if k > 0 {
            sum += 0.5 * (values[k] + values[k - 1]) * (time_s[k] - time_s[k - 1]);
        }
        all.push(sum);
    }
    all
}

/// A coefficient whose residuals are correlated: modes and friction leave more than noise.
fn coefficient(fit: &LinearFit, k: usize) -> Result<Estimate, FitError> {
    let factor = correlation_factor(&fit.residuals);
    let dof = (fit.dof as f64 / factor).max(1.0);
    Ok(Estimate { value: fit.coefficients[k], u: fit.u(k) * factor.sqrt(), dof, n: fit.residuals.len() })
}
