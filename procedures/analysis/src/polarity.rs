//! Signs and scales of the paths from torque to sensor, from small motions about rest.

use std::f64::consts::TAU;

use super::least_squares::{FitError, LinearFit};
use super::uncertainty::{correlation_factor, mean_of_repeats};
use crate::estimate::Estimate;

#[cfg(test)]
mod tests;

/// Angle that an axis gives way under torque, rad per N·m, signed: `θ = c·T + drift`, for whole pulses there and back.
///
/// `time_s`, `torque_nm` and `angle_rad` are samples in order, equally long. The drift is a straight line: a contact that
/// bears a load creeps under it.
///
/// # Errors
/// Too few samples, or a torque that does not change.
pub fn compliance(time_s: &[f64], torque_nm: &[f64], angle_rad: &[f64]) -> Result<Estimate, FitError> {
    let start_s = time_s.first().copied().unwrap_or(0.0);
    let since: Vec<f64> = time_s.iter().map(|t| t - start_s).collect();
    let columns = [torque_nm.to_vec(), vec![1.0; since.len()], since];
    coefficient(&LinearFit::new(&columns, angle_rad, None)?, 0)
}

/// Compliance from a pulse that was cut short, of which a drift cannot be told from the answer: `θ − θ_rest = c·T` where the
/// torque was near its largest, so that what the axis lags behind counts least.
///
/// `rest_rad` is the angle before the pulse.
///
/// # Errors
/// Too few samples, or no torque.
pub fn compliance_cut_short(
    torque_nm: &[f64],
    angle_rad: &[f64],
    rest_rad: f64,
) -> Result<Estimate, FitError> {
    let most_nm = torque_nm.iter().fold(0.0_f64, |most, t| most.max(t.abs()));
    let near = torque_nm.iter().zip(angle_rad).filter(|(t, _)| t.abs() >= NEAR_RATIO * most_nm);
    let (torque, moved): (Vec<f64>, Vec<f64>) = near.map(|(&t, angle)| (t, angle - rest_rad)).unzip();
    coefficient(&LinearFit::new(&[torque], &moved, None)?, 0)
}

/// What counts as near the largest torque.
const NEAR_RATIO: f64 = 0.8;

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

/// Answer of an axis to periodic torque about rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmallMotion {
    /// Inertia over the torque scale, kg·m².
    pub inertia_kg_m2: Estimate,
    /// Damping over the torque scale, N·m·s/rad.
    pub damping_nm_s_per_rad: f64,
}

/// Inertia and damping that an axis shows under periodic torque about rest.
///
/// A contact that does not break away is a spring with a damper, so on each line `T = (−J·ω² + jω·b + k)·X`: three
/// unknowns, of which only the first grows with ω². Fitted for each period of the record by itself; the answer is the mean,
/// its uncertainty their scatter. What creeps meanwhile is a polynomial over the whole record.
///
/// All multiples of 1/period up to `highest_order` are fitted, excited or not. A contact that bears a load yields more in
/// one direction, so the axis moves on lines between the excited ones, where no torque acts. With those, spring and damper are
/// the ones of the motion as it was: on integrated LuGre contacts under a load of 0.5 and 0.7 of their static friction J is off
/// by less than 1 %, and by 4 % and 22 % on the excited lines alone.
///
/// `time_s`, `torque_nm` and `angle_rad` are samples in order, whole periods of the stimulus without its fade-in.
/// Flexible modes well above the lines add (f/f_mode)² to J; an angle that is late by τ adds b·τ.
///
/// # Errors
/// Fewer than two periods, samples missing, or no answer to the torque.
pub fn small_motion(
    time_s: &[f64],
    torque_nm: &[f64],
    angle_rad: &[f64],
    (period_s, highest_order): (f64, u32),
) -> Result<SmallMotion, FitError> {
    let expected = time_s.len();
    if let Some(found) = [torque_nm.len(), angle_rad.len()].into_iter().find(|&n| n != expected) {
        return Err(FitError::Length { expected, found });
    }
    let start_s = time_s.first().copied().unwrap_or(0.0);
    let since: Vec<f64> = time_s.iter().map(|t| t - start_s).collect();
    let ends = (1..).map(|n| since.partition_point(|t| *t < f64::from(n) * period_s * (1.0 - ROUNDING)));
    let ends: Vec<usize> = ends.take_while(|&to| to < expected).collect();
    let whole = ends.last().copied().unwrap_or(0);
    let lines = Harmonics { period_s, highest_order };
    let moved = lines.without_drift(&since[..whole], &angle_rad[..whole])?;
    let mut inertias = Vec::new();
    let mut dampings = Vec::new();
    let mut from = 0;
    for to in ends {
        let rows = from..to;
        let torque = lines.amplitudes(&since[rows.clone()], &torque_nm[rows.clone()])?;
        let angle = lines.amplitudes(&since[rows.clone()], &moved[rows])?;
        let [inertia, damping] = lines.inertia_and_damping(&torque, &angle)?;
        inertias.push(inertia);
        dampings.push(damping);
        from = to;
    }
    let too_few = FitError::TooFew { observations: inertias.len(), coefficients: 1 };
    let (value, spread) = mean_of_repeats(&inertias).ok_or(too_few)?;
    let inertia_kg_m2 = Estimate { value, u: spread.u, dof: spread.dof, n: inertias.len() };
    let damping_nm_s_per_rad = dampings.iter().sum::<f64>() / dampings.len() as f64;
    Ok(SmallMotion { inertia_kg_m2, damping_nm_s_per_rad })
}

/// Part of a period that a sample may be early.
const ROUNDING: f64 = 1e-6;
/// Degree of what creeps over the record.
const DRIFT_DEGREE: i32 = 3;

/// All multiples of 1/period up to the highest.
struct Harmonics {
    period_s: f64,
    highest_order: u32,
}

impl Harmonics {
    fn omegas(&self) -> impl Iterator<Item = f64> {
        let period_s = self.period_s;
        (1..=self.highest_order).map(move |order| TAU * f64::from(order) / period_s)
    }

    /// Columns of cosine and sine of each line.
    fn columns(&self, time_s: &[f64]) -> Vec<Vec<f64>> {
        let pair = |omega: f64| {
            let wave = |f: fn(f64) -> f64| time_s.iter().map(|t| f(omega * t)).collect::<Vec<f64>>();
            [wave(f64::cos), wave(f64::sin)]
        };
        self.omegas().flat_map(pair).collect()
    }

    /// Values less a polynomial that is fitted with the lines. Over one period the lines would take its place.
    fn without_drift(&self, time_s: &[f64], values: &[f64]) -> Result<Vec<f64>, FitError> {
        let first = values.first().copied().unwrap_or(0.0);
        let about: Vec<f64> = values.iter().map(|v| v - first).collect();
        let lasts_s = time_s.last().copied().unwrap_or(1.0);
        let power = |k: i32| time_s.iter().map(|t| (t / lasts_s).powi(k)).collect::<Vec<f64>>();
        let drift: Vec<Vec<f64>> = (0..=DRIFT_DEGREE).map(power).collect();
        let columns: Vec<Vec<f64>> = drift.iter().cloned().chain(self.columns(time_s)).collect();
        let fit = LinearFit::new(&columns, &about, None)?;
        let drift_at =
            |k: usize| drift.iter().zip(fit.coefficients.iter()).map(|(c, b)| c[k] * b).sum::<f64>();
        Ok(about.iter().enumerate().map(|(k, v)| v - drift_at(k)).collect())
    }

    /// Amplitudes of cosine and sine on each line.
    fn amplitudes(&self, time_s: &[f64], values: &[f64]) -> Result<Vec<[f64; 2]>, FitError> {
        let mut columns = vec![vec![1.0; time_s.len()]];
        columns.extend(self.columns(time_s));
        let found = LinearFit::new(&columns, values, None)?.coefficients;
        Ok(found.as_slice()[1..].chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect())
    }

    /// J and b of `T = (−J·ω² + jω·b + k)·X` over all lines.
    fn inertia_and_damping(&self, torque: &[[f64; 2]], angle: &[[f64; 2]]) -> Result<[f64; 2], FitError> {
        let mut columns: [Vec<f64>; 3] = Default::default();
        let mut asked = Vec::new();
        for ((omega, t), &[cos, sin]) in self.omegas().zip(torque).zip(angle) {
            // d/dt of (cos, sin) amplitudes is ω·(sin, −cos).
            for (k, [of_cos, of_sin]) in
                [[-omega * omega * cos, -omega * omega * sin], [omega * sin, -omega * cos], [cos, sin]]
                    .into_iter()
                    .enumerate()
            {
                columns[k].extend([of_cos, of_sin]);
            }
            asked.extend(t);
        }
        let found = LinearFit::new(&columns, &asked, None)?.coefficients;
        Ok([found[0], found[1]])
    }
}

/// A coefficient whose residuals are correlated: modes and friction leave more than noise.
fn coefficient(fit: &LinearFit, k: usize) -> Result<Estimate, FitError> {
    let factor = correlation_factor(&fit.residuals);
    let dof = (fit.dof as f64 / factor).max(1.0);
    Ok(Estimate { value: fit.coefficients[k], u: fit.u(k) * factor.sqrt(), dof, n: fit.residuals.len() })
}
