//! A step response in time: rise, settling, overshoot, final value.

use std::ops::Range;

use crate::positioning::deviation;

#[cfg(test)]
mod tests;

/// How a response is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSettings {
    /// The settling band is this part of the height of the step to either side of the final value.
    pub band_ratio: f64,
    /// The final value is the mean over this last time of the record.
    pub tail_s: f64,
    /// Below this, or below three standard deviations of the noise at the end, nothing is called an overshoot; in the unit
    /// of the values.
    pub floor: f64,
}

/// A step response. Times count from the step; values are in the unit of the record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepResponse {
    /// Time from 10 % to 90 % of the way to the final value, s.
    pub rise_s: f64,
    /// Standard uncertainty of it: noise over slope at both crossings, and the grid of the samples, s.
    pub rise_u_s: f64,
    /// Time from which on the response stays inside the band, s.
    pub settling_s: f64,
    /// Standard uncertainty of it, s.
    pub settling_u_s: f64,
    /// Mean over the tail, of all repeats.
    pub final_value: f64,
    /// Standard uncertainty of it from the scatter of the repeats, or of the tail where there is one.
    pub final_u: f64,
    /// Largest way beyond the final value of the mean of the repeats, 0 or more.
    pub overshoot: f64,
    /// Standard uncertainty of the overshoot: what the repeats scatter where the mean is highest, and no less than the noise;
    /// see [`Self::overshoot_dof`]. Of a single one that of the noise.
    pub overshoot_u: f64,
    /// Overshoot of the single repeats, the largest of all.
    pub largest_overshoot: f64,
    /// Standard deviation of a single response in the tail.
    pub noise: f64,
    /// What an overshoot is compared with: the larger of three standard deviations of the noise and the floor.
    pub threshold: f64,
    /// Repeats.
    pub repeats: usize,
}

impl StepResponse {
    /// Degrees of freedom of the uncertainty of the overshoot: one less than there are repeats. A single response says nothing of how
    /// far others scatter; it has one, which is too few for a verdict.
    pub fn overshoot_dof(&self) -> f64 {
        (self.repeats.max(2) - 1) as f64
    }
}

/// Why there is no step response.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StepError {
    /// The records do not fit each other, or are too short.
    #[error("{0} samples in a record of a step with {1} times: record the whole step")]
    Shape(usize, usize),
    /// Values that are no numbers.
    #[error("a step has values that are not numbers: look for gaps in the record")]
    NotANumber,
    /// The final value is where the step began.
    #[error("the axis moved by {found:.3e} of a step of {asked:.3e}: no step response visible")]
    NoStep {
        /// Final value less initial value.
        found: f64,
        /// Height as commanded.
        asked: f64,
    },
    /// A response that is still outside the band when the tail begins.
    #[error("not settled within {seconds:.2} s: wait longer after the step")]
    NotSettled {
        /// From the step to the tail.
        seconds: f64,
    },
}

/// A response that is smaller than this part of the command is none.
const LEAST_RATIO: f64 = 0.5;
/// The means of both halves of the tail differ by no more than this part of the band.
const CREEP_RATIO: f64 = 0.25;
/// Standard deviations of the noise that an overshoot must exceed (director.md, POS-OVS).
const NOISE_FACTOR: f64 = 3.0;

/// Reads repeats of one step.
///
/// `time_s` counts from the step, ascending; each of `repeats` has a value for every time, with the value before its step
/// taken off. `height` is the step as commanded, its sign the direction. Repeats are averaged before they are read: noise
/// falls with their number, an overshoot does not.
///
/// # Errors
/// See [`StepError`].
pub fn step_response(
    time_s: &[f64],
    repeats: &[&[f64]],
    height: f64,
    settings: &StepSettings,
) -> Result<StepResponse, StepError> {
    let n = time_s.len();
    let wrong = repeats.iter().find(|r| r.len() != n).map_or(0, |r| r.len());
    if n < 8 || repeats.is_empty() || repeats.iter().any(|r| r.len() != n) {
        return Err(StepError::Shape(wrong, n));
    }
    if repeats.iter().flat_map(|r| r.iter()).chain(time_s).any(|v| !v.is_finite()) || height == 0.0 {
        return Err(StepError::NotANumber);
    }
    let sign = height.signum();
    let mean: Vec<f64> =
        (0..n).map(|k| sign * repeats.iter().map(|r| r[k]).sum::<f64>() / repeats.len() as f64).collect();
    let tail = time_s.partition_point(|&t| t < time_s[n - 1] - settings.tail_s).min(n - 4);
    let ends: Vec<(f64, f64)> = repeats.iter().map(|r| deviation(&r[tail..])).collect();
    let (final_value, between) = deviation(&ends.iter().map(|e| sign * e.0).collect::<Vec<_>>());
    let noise = (ends.iter().map(|e| e.1 * e.1).sum::<f64>() / ends.len() as f64).sqrt();
    if final_value < LEAST_RATIO * height.abs() {
        return Err(StepError::NoStep { found: sign * final_value, asked: height });
    }
    let reader = Reader { time_s, mean: &mean, noise: noise / (repeats.len() as f64).sqrt() };
    let low = reader.first(0.1 * final_value);
    let high = reader.first(0.9 * final_value);
    let band = settings.band_ratio * height.abs();
    let settled = reader.last_outside(final_value, band);
    // A response that still creeps through its tail has no final value yet.
    let half = tail + (n - tail) / 2;
    let creep = deviation(&mean[half..]).0 - deviation(&mean[tail..half]).0;
    if settled.index >= tail || creep.abs() > CREEP_RATIO * band {
        return Err(StepError::NotSettled { seconds: time_s[tail] });
    }
    let arrived = high.index;
    let beyond =
        |values: &mut dyn Iterator<Item = f64>, end: f64| values.map(|v| v - end).fold(0.0, f64::max);
    let single = repeats
        .iter()
        .zip(&ends)
        .map(|(r, e)| beyond(&mut r[arrived..].iter().map(|v| sign * v), sign * e.0));
    let repeats_count = repeats.len() as f64;
    let final_u = if repeats.len() > 1 { between / repeats_count.sqrt() } else { noise };
    Ok(StepResponse {
        rise_s: high.time_s - low.time_s,
        rise_u_s: high.u_s.hypot(low.u_s),
        settling_s: settled.time_s,
        settling_u_s: settled.u_s,
        final_value: sign * final_value,
        final_u,
        overshoot: beyond(&mut mean[arrived..tail].iter().copied(), final_value),
        overshoot_u: scatter_at_peak(&mean, arrived..tail, repeats, &ends).max(noise) / repeats_count.sqrt(),
        largest_overshoot: single.fold(0.0, f64::max),
        noise,
        threshold: (NOISE_FACTOR * noise).max(settings.floor),
        repeats: repeats.len(),
    })
}

/// How far the repeats, each less its own end, scatter where their mean is highest; 0 of a single one.
fn scatter_at_peak(mean: &[f64], arrived: Range<usize>, repeats: &[&[f64]], ends: &[(f64, f64)]) -> f64 {
    let peak = arrived.max_by(|&a, &b| mean[a].total_cmp(&mean[b])).unwrap_or(0);
    let at_peak: Vec<f64> = repeats.iter().zip(ends).map(|(r, end)| r[peak] - end.0).collect();
    if at_peak.len() > 1 { deviation(&at_peak).1 } else { 0.0 }
}

struct Reader<'a> {
    time_s: &'a [f64],
    mean: &'a [f64],
    noise: f64,
}

/// An instant between two samples; `index` is the sample after it.
struct Instant {
    index: usize,
    time_s: f64,
    u_s: f64,
}

impl Reader<'_> {
    /// Where the response first reaches a level.
    fn first(&self, level: f64) -> Instant {
        let index = self.mean.iter().position(|&v| v >= level).unwrap_or(self.mean.len() - 1);
        self.between(index, level)
    }

    /// Where it is outside a band for the last time.
    fn last_outside(&self, centre: f64, band: f64) -> Instant {
        let last = self.mean.iter().rposition(|v| (v - centre).abs() > band);
        let Some(last) = last else { return Instant { index: 0, time_s: self.time_s[0], u_s: 0.0 } };
        let level = if self.mean[last] < centre { centre - band } else { centre + band };
        self.between((last + 1).min(self.mean.len() - 1), level)
    }

    /// The crossing of a level between a sample and the one before it, on a straight line.
    fn between(&self, index: usize, level: f64) -> Instant {
        let before = index.saturating_sub(1);
        let step_s = self.time_s[index] - self.time_s[before];
        let rise = self.mean[index] - self.mean[before];
        let ratio = if rise == 0.0 { 0.0 } else { ((level - self.mean[before]) / rise).clamp(0.0, 1.0) };
        let slope = self.slope(index);
        // On a slope that drowns in noise the crossing is known to nothing better than where it was found.
        let of_noise_s = if slope > 0.0 { self.noise / slope } else { self.time_s[index] };
        let u_s = of_noise_s.min(self.time_s[index].abs()).hypot(step_s / 12.0_f64.sqrt());
        Instant { index, time_s: self.time_s[before] + ratio * step_s, u_s }
    }

    /// Magnitude of the mean slope over some samples about a sample.
    fn slope(&self, index: usize) -> f64 {
        const HALF: usize = 5;
        let from = index.saturating_sub(HALF);
        let to = (index + HALF).min(self.mean.len() - 1);
        let span_s = self.time_s[to] - self.time_s[from];
        if span_s > 0.0 { ((self.mean[to] - self.mean[from]) / span_s).abs() } else { 0.0 }
    }
}
