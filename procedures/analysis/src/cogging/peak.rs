//! The largest value that all lines make together.

use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

use nalgebra::Complex;
use statrs::function::erf::erfc;

use super::Amplitude;
use crate::uncertainty::{Component, combine};

/// Points of the grid in a period of the highest order.
const POINTS: f64 = 16.0;
/// Steps of refinement.
const NEWTON_STEPS: usize = 8;
/// Local maxima this many u below the largest are rivals of it.
const RIVAL: f64 = 4.0;
/// Rivals whose difference is better known than this part of u are one.
const SAME: f64 = 0.05;

/// A line of the sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Order.
    pub order_per_rev: f64,
    /// Standard uncertainty of the order; 0 where it is a whole number.
    pub order_u_per_rev: f64,
    /// Amplitude and phase.
    pub amplitude: Amplitude,
}

/// Largest magnitude of a sum of lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// The magnitude, in the unit of the amplitudes.
    pub value: f64,
    /// Angle at which it lies.
    pub angle_rad: f64,
    /// From what the lines are uncertain by.
    pub spread: Component,
    /// By how much the noise of the lines raises the largest value on average, at the most.
    pub excess: f64,
}

impl Peak {
    /// Largest magnitude of `Σ a·cos(order·θ + φ)` over a range, but not over more than a turn about the middle of the record that
    /// the lines come from; `None` without lines or range.
    ///
    /// To first order the largest value follows the sum at its own angle. A line whose cosine and sine parts are uncertain by u each
    /// is uncertain by u at every angle, whatever its phase, so the variances add up.
    pub fn new(lines: &[Line], range_rad: [f64; 2], middle_rad: f64) -> Option<Self> {
        let from_rad = range_rad[0].max(middle_rad - PI);
        let span_rad = range_rad[1].min(middle_rad + PI) - from_rad;
        let highest = lines.iter().map(|line| line.order_per_rev).fold(0.0, f64::max);
        let is_range = range_rad[1] > range_rad[0] && span_rad > 0.0;
        if !(is_range && highest > 0.0 && highest.is_finite()) {
            return None;
        }
        let sum = Sum(lines);
        let u = combine(&lines.iter().map(Line::noise).collect::<Vec<_>>()).u;
        let tops = sum.tops(from_rad, span_rad, (POINTS * highest * span_rad / TAU).ceil(), RIVAL * u);
        let best = *tops.first()?;
        let components: Vec<Component> = lines
            .iter()
            .flat_map(|line| [line.noise(), Component::known(line.of_order(best.angle_rad, middle_rad))])
            .collect();
        Some(Self {
            value: best.value,
            angle_rad: best.angle_rad,
            spread: combine(&components),
            excess: sum.shifted(&best).min(u) + sum.chosen(&tops, u),
        })
    }
}

impl Line {
    fn noise(&self) -> Component {
        Component { u: self.amplitude.u, dof: self.amplitude.dof }
    }

    fn phasor(&self, angle_rad: f64) -> Complex<f64> {
        Complex::from_polar(1.0, self.order_per_rev * angle_rad + self.amplitude.phase_rad)
    }

    /// What the order leaves open so far from the middle of the record.
    fn of_order(&self, angle_rad: f64, middle_rad: f64) -> f64 {
        let slope = self.amplitude.amplitude * self.phasor(angle_rad).im;
        (slope * self.order_u_per_rev * (angle_rad - middle_rad)).abs()
    }
}

/// A local maximum of the magnitude.
#[derive(Clone, Copy)]
struct Top {
    angle_rad: f64,
    value: f64,
    /// Sign of the sum there.
    sign: f64,
}

struct Sum<'a>(&'a [Line]);

impl Sum<'_> {
    /// The sum and its first two derivatives over the angle.
    fn at(&self, angle_rad: f64) -> [f64; 3] {
        let mut found = [0.0; 3];
        for line in self.0 {
            let part = line.phasor(angle_rad) * line.amplitude.amplitude;
            let order = line.order_per_rev;
            found[0] += part.re;
            found[1] -= order * part.im;
            found[2] -= order * order * part.re;
        }
        found
    }

    /// Local maxima of the magnitude that are at most `within` below the largest, largest first.
    fn tops(&self, from_rad: f64, span_rad: f64, steps: f64, within: f64) -> Vec<Top> {
        let step_rad = span_rad / steps;
        let top = |angle_rad: f64| {
            let value = self.at(angle_rad)[0];
            Top { angle_rad, value: value.abs(), sign: value.signum() }
        };
        let grid: Vec<Top> = (0..=steps as usize).map(|k| top(from_rad + k as f64 * step_rad)).collect();
        let largest = grid.iter().map(|t| t.value).fold(0.0, f64::max);
        // A maximum is at most half a step from a point of the grid.
        let bend: f64 = self.0.iter().map(|l| l.amplitude.amplitude * l.order_per_rev.powi(2)).sum();
        let least = largest - within - bend * step_rad * step_rad / 8.0;
        let value = |k: usize| grid.get(k).map_or(0.0, |t| t.value);
        let is_top = |k: &usize| {
            let here = value(*k);
            here >= least && here >= value(k + 1) && (*k == 0 || here > value(k - 1))
        };
        let end_rad = from_rad + span_rad;
        let refined = |k: usize| {
            let mut angle_rad = grid[k].angle_rad;
            for _ in 0..NEWTON_STEPS {
                let [_, slope, bend] = self.at(angle_rad);
                let way_rad = if bend == 0.0 { 0.0 } else { -slope / bend };
                angle_rad = (angle_rad + way_rad.clamp(-step_rad, step_rad)).clamp(from_rad, end_rad);
            }
            let found = top(angle_rad);
            if found.value > grid[k].value { found } else { grid[k] }
        };
        let mut tops: Vec<Top> = (0..grid.len()).filter(is_top).map(refined).collect();
        tops.sort_by(|a, b| b.value.total_cmp(&a.value).then(a.angle_rad.total_cmp(&b.angle_rad)));
        let best = tops.first().map_or(0.0, |t| t.value);
        tops.retain(|t| t.value >= best - within);
        tops
    }

    /// Standard uncertainty of the difference between two maxima.
    fn apart(&self, a: &Top, b: &Top) -> f64 {
        let difference = |l: &Line| l.phasor(a.angle_rad) * a.sign - l.phasor(b.angle_rad) * b.sign;
        self.0.iter().map(|l| difference(l).norm_sqr() * l.amplitude.u.powi(2)).sum::<f64>().sqrt()
    }

    /// What the largest value gains on average because noise shifts its angle.
    fn shifted(&self, best: &Top) -> f64 {
        let bend = self.at(best.angle_rad)[2].abs();
        let slope: f64 = self.0.iter().map(|l| (l.order_per_rev * l.amplitude.u).powi(2)).sum();
        if bend > 0.0 { 0.5 * slope / bend } else { f64::INFINITY }
    }

    /// What it gains at the most because noise chooses among rivals: the mean of the larger of two (Clark, *Operations Research* 9,
    /// 145, 1961), summed over the rivals, or the bound σ·√(2·ln n) for n of them where that is less.
    fn chosen(&self, tops: &[Top], u: f64) -> f64 {
        let Some((best, others)) = tops.split_first() else { return 0.0 };
        let mut rivals: Vec<&Top> = vec![best];
        let mut sum = 0.0;
        let mut widest = 0.0_f64;
        for other in others {
            if rivals.iter().any(|rival| self.apart(rival, other) <= SAME * u) {
                continue;
            }
            let sigma = self.apart(best, other);
            let below = (best.value - other.value) / sigma;
            let density = (-0.5 * below * below).exp() / TAU.sqrt();
            sum += sigma * (density - 0.5 * below * erfc(below * FRAC_1_SQRT_2));
            widest = widest.max(sigma);
            rivals.push(other);
        }
        sum.min(widest * (2.0 * (rivals.len() as f64).ln()).sqrt())
    }
}

#[cfg(test)]
mod tests;
