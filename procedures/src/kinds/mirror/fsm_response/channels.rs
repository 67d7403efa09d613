//! How far the two command channels of an axis differ: the largest of a smooth difference, and what single lines depart
//! from it.
//!
//! The largest of many lines is larger than what is true by what chance adds to it, and the more so the more lines there are.
//! Channels differ by scale, delay and lags, which are smooth over frequency, so all lines together tell the difference: ln of
//! the gain is even in frequency, the phase odd. From its largest value is taken what chance adds to a square. A line that lies
//! far off the smooth difference is none of chance and counts by itself.

use std::f64::consts::{PI, SQRT_2, TAU};

use analysis::frf::{C64, Line, unwrapped_rad};
use analysis::goodness::Goodness;
use analysis::least_squares::LinearFit;
use analysis::peaks::PER_MEDIAN;
use analysis::uncertainty::{Component, combine};

use super::conclude::Planned;
use super::keys::Keys;
use super::response::{Reading, complete_without_channel, decibel, measurement};
use super::spectra::MirrorLine;
use crate::case::{Case, MirrorChannel};
use crate::measurement::Measurement;
use crate::quantity::QuantityKind as Q;
use crate::reason::{MirrorReason, Reason};

pub(super) const LEVEL_DIFFERENCE: &str = "channel-level-difference";
pub(super) const PHASE_DIFFERENCE: &str = "channel-phase-difference";

/// Share of the lines up to the highest frequency that is compared that must count in both channels: a few that are left
/// say nothing of a response.
const LEAST_SHARE: f64 = 0.8;
/// Fewest lines of a smooth difference.
const FEWEST: usize = 8;
/// Places at which the smooth difference is looked at.
const PLACES: u32 = 64;
/// Standard deviations off the smooth difference from which on a line is none of chance.
const APART: f64 = 6.0;

/// Differences of the two channels of one axis at one level; nothing where that level was not planned.
pub(super) fn differences(keys: &Keys, responses: &[Planned<'_>], level_v: f64) -> Vec<Measurement> {
    let by_channel = |channel: MirrorChannel| {
        let planned = |case: &Case| {
            case.mirror_channel == Some(channel)
                && case.requested("level").is_some_and(|level| crate::condition::same(level, level_v))
        };
        responses.iter().find(|p| planned(p.case))
    };
    let Some(analog) = by_channel(MirrorChannel::Analog) else { return Vec::new() };
    let Some(serial) = by_channel(MirrorChannel::Serial) else { return Vec::new() };
    let pairs = pairs(keys, analog, serial);
    let largest = |difference: fn(&[Pair]) -> Result<Smooth, Reason>, delays_u_s: f64| {
        let pairs = pairs.as_ref().map_err(Clone::clone)?;
        Ok(difference(pairs)?.largest(pairs, delays_u_s))
    };
    let level = largest(Smooth::of_level, 0.0);
    let phase = largest(Smooth::of_phase, keys.delays.u_s * SQRT_2);
    let of = |measurand: &str, kind: Q, found: Result<Largest, Reason>| {
        let flags = found.as_ref().map_or_else(|_| Vec::new(), |largest| largest.flags.clone());
        let reading = found.map(|largest| largest.reading);
        let mut m = measurement(measurand, kind, analog.case, reading);
        complete_without_channel(&mut m, keys, analog.case, analog.point());
        m.point = None;
        m.flags.push(format!("up to {}", Q::Frequency.format(keys.delays.compared_to_hz)));
        m.flags.extend(flags);
        m
    };
    let in_decibel = level.map(|mut largest| {
        largest.reading.value = decibel(largest.reading.value);
        largest.reading.u = decibel(largest.reading.u);
        largest
    });
    vec![of(LEVEL_DIFFERENCE, Q::Decibel, in_decibel), of(PHASE_DIFFERENCE, Q::Angle, phase)]
}

/// Two lines at one frequency, as a ratio.
struct Pair {
    frequency_hz: f64,
    ratio: C64,
    relative_u: f64,
    dof: f64,
}

impl Pair {
    fn new(analog: &Line, serial: &Line) -> Self {
        Self {
            frequency_hz: analog.frequency_hz,
            ratio: serial.value / analog.value,
            relative_u: analog.relative_sd().hypot(serial.relative_sd()),
            // Each complex degree of freedom is two real ones.
            dof: 2.0 * analog.dof.min(serial.dof),
        }
    }
}

fn pairs(keys: &Keys, analog: &Planned<'_>, serial: &Planned<'_>) -> Result<Vec<Pair>, Reason> {
    let analog = gauge_lines(analog)?;
    let serial = gauge_lines(serial)?;
    let inside = |l: &MirrorLine| l.line.frequency_hz <= keys.delays.compared_to_hz * (1.0 + 1e-9);
    let pairs: Vec<Pair> = analog
        .iter()
        .zip(serial)
        .filter(|(a, s)| a.counts() && s.counts() && inside(a))
        .map(|(a, s)| Pair::new(&a.line, &s.line))
        .collect();
    let planned = analog.iter().filter(|l| inside(l)).count();
    covered(&pairs, planned, keys.delays.compared_to_hz).map(|()| pairs)
}

/// Lines of the strain gauge at a point.
fn gauge_lines<'a>(planned: &Planned<'a>) -> Result<&'a [MirrorLine], Reason> {
    if let Some(reason) = &planned.result.inconclusive {
        return Err(Reason::of_point(&planned.case.point, reason));
    }
    let response = planned.point().and_then(|point| point.response.as_ref());
    let response = response.ok_or_else(|| MirrorReason::NoLines { point: planned.case.point.clone() })?;
    Ok(&response.gauge)
}

/// Whether enough is left to compare, up to the top; `planned` lines were excited there.
fn covered(pairs: &[Pair], planned: usize, compared_to_hz: f64) -> Result<(), Reason> {
    if (pairs.len() as f64) < LEAST_SHARE * planned as f64 || pairs.is_empty() {
        return Err(MirrorReason::TooFewCommon {
            common: pairs.len(),
            planned,
            up_to_hz: compared_to_hz,
            least_percent: 100.0 * LEAST_SHARE,
        }
        .into());
    }
    // A third of an octave below: where a difference in delay shows most.
    let top_hz = compared_to_hz / 2.0_f64.cbrt();
    if pairs.iter().all(|p| p.frequency_hz < top_hz) {
        return Err(MirrorReason::NoneNearTop { from_hz: top_hz, up_to_hz: compared_to_hz }.into());
    }
    if pairs.len() < FEWEST {
        return Err(MirrorReason::TooFewForDifference { found: pairs.len(), least: FEWEST }.into());
    }
    Ok(())
}

/// A smooth difference over frequency: a constant, and even or odd powers.
struct Smooth {
    constant: f64,
    powers: &'static [i32],
    fit: LinearFit,
    goodness: Goodness,
    /// Standard deviation of a line about it, outliers not counted.
    line_sd: f64,
}

/// The largest difference, and what is said of it.
#[derive(Clone)]
struct Largest {
    reading: Reading,
    flags: Vec<String>,
}

impl Smooth {
    /// ln of the ratio of gains.
    fn of_level(pairs: &[Pair]) -> Result<Self, Reason> {
        let values: Vec<f64> = pairs.iter().map(|p| p.ratio.norm().ln()).collect();
        Self::new(pairs, &values, 0.0, &[0, 2, 4])
    }

    /// Difference in phase: at 0 Hz it is 0, or half a turn where a channel has the other sign.
    fn of_phase(pairs: &[Pair]) -> Result<Self, Reason> {
        let lines: Vec<Line> = pairs.iter().map(|p| Line::exact(p.frequency_hz, p.ratio)).collect();
        let phases = unwrapped_rad(&lines);
        let lowest = &phases[..FEWEST / 2];
        let constant = PI * (lowest.iter().sum::<f64>() / lowest.len() as f64 / PI).round();
        let values: Vec<f64> = phases.iter().map(|phase| phase - constant).collect();
        Self::new(pairs, &values, constant, &[1, 3])
    }

    fn new(pairs: &[Pair], values: &[f64], constant: f64, powers: &'static [i32]) -> Result<Self, Reason> {
        let top_hz = pairs[pairs.len() - 1].frequency_hz;
        let column =
            |power: &i32| pairs.iter().map(|p| (p.frequency_hz / top_hz).powi(*power)).collect::<Vec<f64>>();
        let columns: Vec<Vec<f64>> = powers.iter().map(column).collect();
        // The variances of the lines come from few periods: as weights they would favour what came out low.
        let n = pairs.len() as f64;
        let variance = pairs.iter().map(|p| p.relative_u * p.relative_u).sum::<f64>() / n;
        let mut fit = LinearFit::new(&columns, values, None)?;
        let goodness = if variance > 0.0 {
            Goodness::of_known(fit.residual_variance / variance, fit.dof)
                .stated_with(pairs.iter().map(|p| p.dof).sum())
                .with_share(fit.residual_variance.sqrt())
        } else {
            Goodness::by_scatter(1.0, fit.dof)
        };
        goodness.check()?;
        let mut sizes: Vec<f64> = fit.residuals.iter().map(|r| r.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let line_sd = (PER_MEDIAN * sizes[sizes.len() / 2]).max(variance.sqrt());
        if variance > 0.0 {
            fit.residual_variance = variance * goodness.variance_factor();
        }
        Ok(Self { constant, powers, fit, goodness, line_sd })
    }

    /// The largest difference up to the highest line; `delays_u_s` is what the known delays may be off by.
    fn largest(&self, pairs: &[Pair], delays_u_s: f64) -> Largest {
        let top_hz = pairs[pairs.len() - 1].frequency_hz;
        let low = pairs[0].frequency_hz / top_hz;
        let mut best = Square { value: f64::NEG_INFINITY, u: 0.0, frequency_hz: top_hz };
        for k in 0..=PLACES {
            let x = low + (1.0 - low) * f64::from(k) / f64::from(PLACES);
            let row: Vec<f64> = self.powers.iter().map(|power| x.powi(*power)).collect();
            let there = Square::new(self.constant + self.fit.at(&row), self.fit.u_at(&row), x * top_hz);
            if there.value > best.value {
                best = there;
            }
        }
        let mut dof = self.goodness.dof();
        let mut flags: Vec<String> = self.goodness.flag().into_iter().collect();
        let apart = pairs.iter().zip(&self.fit.residuals).filter(|(_, r)| r.abs() > APART * self.line_sd);
        for (pair, residual) in apart {
            let x = pair.frequency_hz / top_hz;
            let row: Vec<f64> = self.powers.iter().map(|power| x.powi(*power)).collect();
            let value = self.constant + self.fit.at(&row) + residual;
            let there = Square::new(value, self.line_sd, pair.frequency_hz);
            flags.push(format!(
                "the line at {} deviates from the others",
                Q::Frequency.format(pair.frequency_hz)
            ));
            if there.value > best.value {
                dof = pair.dof;
                best = there;
            }
        }
        let of_delays = Component::known(TAU * best.frequency_hz * delays_u_s);
        let spread = combine(&[Component { u: best.u, dof }, of_delays]);
        let reading = Reading { value: best.root(), u: spread.u, dof: spread.dof, n: pairs.len() };
        Largest { reading, flags }
    }
}

/// A difference by its square, less what chance adds to that: the mean of (d + noise)² is d² + u².
#[derive(Clone, Copy)]
struct Square {
    value: f64,
    u: f64,
    frequency_hz: f64,
}

impl Square {
    fn new(difference: f64, u: f64, frequency_hz: f64) -> Self {
        Self { value: difference * difference - u * u, u, frequency_hz }
    }

    fn root(&self) -> f64 {
        self.value.max(0.0).sqrt()
    }
}
