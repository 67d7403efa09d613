//! What an encoder loses of the turns of its axis, by gyros that turn with the axis: play at reversals, and slip.
//!
//! Between samples the encoder shows `ΔE = (1 + s)·ΔG + τ·Δω + c·Δα + e·Δ(α·θ) − b·Δd/2 − r·ΔF` of the angle G by the gyros:
//! their scale, their delay, what the structure bends (by more at one end of the travel), the play b at reversals (d = ±1 is the
//! direction) and the share r of the travel F towards larger angles that slips away. Rate ω and acceleration α are the encoder's, which
//! has less noise: over so few steps that of gyros would make the delay too small, and over more steps the acceleration at a reversal,
//! which friction changes within 50 ms, would be another one. Increments, not angles: the noise of gyros adds up along the angle and is
//! white in its increments. Travel F grows at a constant speed as time does, so that a bias of the gyros reads as slip:
//! it is taken from a rest before.

use crate::estimate::Estimate;
use crate::least_squares::{FitError, LinearFit};
use crate::uncertainty::{Component, combine};

/// Travel after a reversal that is stepped over as a whole: the encoder may stand meanwhile. It bounds the play that is found.
const CLEAR_RAD: f64 = 2e-3;
/// Strokes shorter than this are none.
const LEAST_STROKE_RAD: f64 = 0.05;
/// Stretches into which a rest is cut.
const BLOCKS: usize = 20;
/// Half of the steps over which rate and acceleration are differences.
const HALF_WINDOW: usize = 3;
/// Columns: scale, delay, bending, its change along the travel, play, slip.
const COLUMNS: usize = 6;
const PLAY: usize = 4;
const SLIP: usize = 5;

/// An axis by its encoder and by gyros, at equal steps of time.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
    /// Rate by the encoder, mean over each step.
    pub encoder_rad_per_s: &'a [f64],
    /// Rate about the axis by the gyros, mean over each step.
    pub gyro_rad_per_s: &'a [f64],
    /// Length of a step.
    pub period_s: f64,
}

/// What the coupling of an encoder loses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LostMotion {
    /// Play b: how far the axis turns after a reversal before the encoder follows.
    pub play_rad: Estimate,
    /// Share r of the travel towards larger angles that the encoder does not show.
    pub slip_ratio: Estimate,
}

/// Why there is no lost motion.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoLostMotion {
    /// Rates of different length, or too few of them.
    #[error("{found} samples of both rates, at least {least} are needed")]
    TooFew {
        /// Samples that both have.
        found: usize,
        /// Samples needed.
        least: usize,
    },
    /// The axis turned one way only.
    #[error("the axis made {strokes} strokes of at least 3 deg, but two in opposite directions are needed")]
    OneWay {
        /// Strokes found.
        strokes: usize,
    },
    /// The motion does not determine it.
    #[error(transparent)]
    Fit(#[from] FitError),
}

/// Rate of the gyros at rest less that of the encoder: their bias, with what is left of the Earth. Uncertainty from the means of
/// [`BLOCKS`] stretches, along which the noise of the encoder cancels and what the axis still moves is in both. `None` for a
/// rest of fewer than two samples a stretch.
pub fn bias_at_rest(rest: Motion<'_>) -> Option<Estimate> {
    let both = rest.gyro_rad_per_s.iter().zip(rest.encoder_rad_per_s);
    let difference: Vec<f64> = both.map(|(gyro, encoder)| gyro - encoder).collect();
    let length = difference.len() / BLOCKS;
    if length < 2 {
        return None;
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let blocks: Vec<f64> = difference.chunks_exact(length).map(mean).collect();
    let count = blocks.len() as f64;
    let value = mean(&blocks);
    let square = blocks.iter().map(|block| (block - value).powi(2)).sum::<f64>() / (count - 1.0);
    Some(Estimate { value, u: (square / count).sqrt(), dof: count - 1.0, n: difference.len() })
}

impl LostMotion {
    /// Of an axis that goes back and forth, the bias of its gyros known.
    ///
    /// # Errors
    /// See [`NoLostMotion`].
    pub fn new(motion: Motion<'_>, bias: &Estimate) -> Result<Self, NoLostMotion> {
        let found = fitted(motion, bias.value)?;
        let shifted = fitted(motion, bias.value + bias.u)?;
        let n = motion.gyro_rad_per_s.len();
        let estimate = |column: usize| {
            let by_bias = shifted.coefficients[column] - found.coefficients[column];
            let own = Component { u: found.u(column), dof: found.dof as f64 };
            let spread = combine(&[own, Component { u: by_bias.abs(), dof: bias.dof }]);
            Estimate { value: found.coefficients[column], u: spread.u, dof: spread.dof, n }
        };
        Ok(Self { play_rad: estimate(PLAY), slip_ratio: estimate(SLIP) })
    }
}

/// Angles and rates at the ends of the steps, from the start on.
struct Course {
    encoder_rad: Vec<f64>,
    gyro_rad: Vec<f64>,
    rate_rad_per_s: Vec<f64>,
    acceleration_rad_per_s2: Vec<f64>,
    /// Acceleration times angle from the middle of the travel: what bends changes with elevation.
    acceleration_along: Vec<f64>,
    /// Travel towards larger angles.
    forward_rad: Vec<f64>,
}

impl Course {
    fn new(motion: Motion<'_>, bias_rad_per_s: f64) -> Self {
        let period_s = motion.period_s;
        let gyro: Vec<f64> = motion.gyro_rad_per_s.iter().map(|rate| rate - bias_rad_per_s).collect();
        let summed = |steps: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
            let mut sum = 0.0;
            let sums = steps.map(|step| {
                sum += step;
                sum
            });
            [0.0].into_iter().chain(sums.collect::<Vec<_>>()).collect()
        };
        // Over a few steps: the noise of single ones would make delay and bending too small.
        let slope = |course: &[f64]| -> Vec<f64> {
            let slope = |k: usize| {
                let from = k.saturating_sub(HALF_WINDOW);
                let to = (k + HALF_WINDOW).min(course.len() - 1);
                (course[to] - course[from]) / ((to - from) as f64 * period_s)
            };
            (0..course.len()).map(slope).collect()
        };
        let encoder_rad = summed(&mut motion.encoder_rad_per_s.iter().map(|rate| rate * period_s));
        let gyro_rad = summed(&mut gyro.iter().map(|rate| rate * period_s));
        let rate_rad_per_s = slope(&encoder_rad);
        let acceleration_rad_per_s2 = slope(&rate_rad_per_s);
        let ends_rad = encoder_rad.iter().fold([0.0_f64; 2], |[low, high], at| [low.min(*at), high.max(*at)]);
        let middle_rad = 0.5 * (ends_rad[0] + ends_rad[1]);
        let along = acceleration_rad_per_s2.iter().zip(&encoder_rad);
        Self {
            acceleration_along: along.map(|(acceleration, at)| acceleration * (at - middle_rad)).collect(),
            encoder_rad,
            acceleration_rad_per_s2,
            gyro_rad,
            rate_rad_per_s,
            forward_rad: summed(&mut gyro.iter().map(|rate| (rate * period_s).max(0.0))),
        }
    }

    /// Ends of the strokes: first sample, last sample, and the direction between them.
    fn strokes(&self) -> Vec<Stroke> {
        let angle = &self.gyro_rad;
        let mut turns = vec![0];
        let mut farthest = 0;
        let mut direction = 0.0;
        for (k, at) in angle.iter().enumerate() {
            let beyond = at - angle[farthest];
            if direction == 0.0 {
                if beyond.abs() > CLEAR_RAD {
                    (direction, farthest) = (beyond.signum(), k);
                }
            } else if beyond * direction >= 0.0 {
                farthest = k;
            } else if beyond.abs() > CLEAR_RAD {
                turns.push(farthest);
                (direction, farthest) = (-direction, k);
            }
        }
        turns.push(farthest);
        let stroke = |ends: &[usize]| Stroke {
            from: ends[0],
            to: ends[1],
            direction: (angle[ends[1]] - angle[ends[0]]).signum(),
        };
        let long = |s: &Stroke| (angle[s.to] - angle[s.from]).abs() >= LEAST_STROKE_RAD;
        turns.windows(2).map(stroke).filter(long).collect()
    }
}

/// One way of the axis.
struct Stroke {
    from: usize,
    to: usize,
    direction: f64,
}

fn fitted(motion: Motion<'_>, bias_rad_per_s: f64) -> Result<LinearFit, NoLostMotion> {
    const LEAST: usize = 100;
    let n = motion.gyro_rad_per_s.len();
    if n != motion.encoder_rad_per_s.len() || n < LEAST {
        return Err(NoLostMotion::TooFew { found: n.min(motion.encoder_rad_per_s.len()), least: LEAST });
    }
    let course = Course::new(motion, bias_rad_per_s);
    let strokes = course.strokes();
    if !strokes.windows(2).any(|pair| pair[0].direction * pair[1].direction < 0.0) {
        return Err(NoLostMotion::OneWay { strokes: strokes.len() });
    }
    let mut kept: Vec<(usize, f64)> = Vec::new();
    for stroke in &strokes {
        let clear = |k: &usize| (course.gyro_rad[*k] - course.gyro_rad[stroke.from]).abs() >= CLEAR_RAD;
        kept.extend((stroke.from..=stroke.to).filter(clear).map(|k| (k, stroke.direction)));
    }
    let mut columns = vec![Vec::new(); COLUMNS];
    let mut encoder = Vec::with_capacity(kept.len());
    let mut weights = Vec::with_capacity(kept.len());
    for pair in kept.windows(2) {
        let [(i, before), (k, after)] = [pair[0], pair[1]];
        if k <= i {
            continue;
        }
        let change = |course: &[f64]| course[k] - course[i];
        let row = [
            change(&course.gyro_rad),
            change(&course.rate_rad_per_s),
            change(&course.acceleration_rad_per_s2),
            change(&course.acceleration_along),
            0.5 * (before - after),
            -change(&course.forward_rad),
        ];
        columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
        encoder.push(change(&course.encoder_rad));
        weights.push(1.0 / (k - i) as f64);
    }
    Ok(LinearFit::new(&columns, &encoder, Some(&weights))?)
}

#[cfg(test)]
mod tests;
