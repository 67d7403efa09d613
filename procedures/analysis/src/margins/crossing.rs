//! All frequencies where L crosses the unit circle or the negative real axis.

use std::f64::consts::TAU;

use super::curve::{Curve, Errors};
use super::local::{Reading, WINNER, WINNER_OF_MANY, choose, curves};
use super::{C64, GainCrossing, Line, PhaseCrossing};

/// Points of the search between two lines.
const POINTS: usize = 12;
/// Bisections of a crossing.
const HALVINGS: usize = 45;
/// A line this near to a crossing (in ln|L| or rad), nearer than its neighbours, may hide two crossings beside it.
const NEAR: f64 = 0.12;
/// dB per unit of ln.
const DB: f64 = 20.0 * std::f64::consts::LOG10_E;

/// What is crossed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// 0 dB.
    Gain,
    /// −180°.
    Phase,
    /// −3 dB below the static gain.
    Level,
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Gain => "0 dB",
            Self::Phase => "−180°",
            Self::Level => "−3 dB",
        })
    }
}

/// There is no crossing, so there is no number.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("no {kind} crossing between {from_hz} and {to_hz} Hz")]
pub struct NoCrossing {
    /// What was looked for.
    pub kind: Kind,
    /// First line, Hz.
    pub from_hz: f64,
    /// Last line, Hz.
    pub to_hz: f64,
}

/// A place to look at: between which frequencies, near which, in which direction.
struct Place {
    near_hz: f64,
    range_hz: [f64; 2],
    upwards: bool,
}

impl Kind {
    /// What changes its sign: ln|L|, or Im L.
    fn level(self, value: C64) -> f64 {
        match self {
            Self::Gain | Self::Level => value.norm().ln(),
            Self::Phase => value.im,
        }
    }

    /// Distance from the crossing in ln|L| or rad.
    fn distance(self, value: C64) -> f64 {
        match self {
            Self::Gain | Self::Level => value.norm().ln().abs(),
            Self::Phase => (-value).arg().abs(),
        }
    }

    /// The positive real axis is no crossing.
    fn counts(self, value: C64) -> bool {
        self != Self::Phase || value.re < 0.0
    }
}

/// All 0 dB crossings, ascending.
pub(super) fn gain(lines: &[Line]) -> Vec<GainCrossing> {
    let found = all(lines, Kind::Gain);
    found.into_iter().map(|(upwards, reading, at)| gain_crossing(&reading, &at, !upwards)).collect()
}

fn gain_crossing(reading: &Reading, at: &Parts, falling: bool) -> GainCrossing {
    let frequency_hz = reading.ln_f.exp();
    let omega = TAU * frequency_hz;
    let turned = if reading.value < 0.0 { reading.value + TAU } else { reading.value };
    // δω/ω = −e/s and δPM = φ − (dφ/dln|L|)·e for errors e of ln|L| and φ of the phase, with their covariance.
    let by_gain = (turned - reading.slope.im) / reading.slope.re / omega;
    let Errors { gain, phase, both } = at.random;
    let square = phase / (omega * omega) + by_gain * by_gain * gain + 2.0 * by_gain * both / omega;
    let random = square.max(0.0).sqrt();
    let systematic = (at.systematic.hypot(turned * at.systematic_ln_f)) / omega;
    GainCrossing {
        frequency_hz,
        frequency_u_hz: reading.u_ln_f * frequency_hz,
        phase_margin_rad: reading.value,
        phase_margin_u_rad: reading.u,
        delay_margin_s: turned / omega,
        delay_margin_u_s: random.hypot(systematic),
        slope: reading.slope.re,
        falling,
    }
}

/// All −180° crossings, ascending.
pub(super) fn phase(lines: &[Line]) -> Vec<PhaseCrossing> {
    let crossing = |(upwards, reading, _): (bool, Reading, Parts)| {
        let frequency_hz = reading.ln_f.exp();
        PhaseCrossing {
            frequency_hz,
            frequency_u_hz: reading.u_ln_f * frequency_hz,
            gain_margin_db: reading.value,
            gain_margin_u_db: reading.u,
            upwards,
        }
    };
    all(lines, Kind::Phase).into_iter().map(crossing).collect()
}

/// Parts of the uncertainty of a reading.
struct Parts {
    /// Errors of ln|L| and phase.
    random: Errors,
    /// What the choice of curve adds to the value.
    systematic: f64,
    /// Systematic component of ln f.
    systematic_ln_f: f64,
}

/// Crossings with their direction, merged where several brackets lead to one.
fn all(lines: &[Line], kind: Kind) -> Vec<(bool, Reading, Parts)> {
    let mut found: Vec<(bool, Reading, Parts)> = Vec::new();
    let mut fitted: Option<(f64, Vec<Curve>)> = None;
    for place in places(lines, kind) {
        let known = fitted.take().filter(|(hz, _)| (hz - place.near_hz).abs() <= 1e-12 * hz);
        let (hz, curves) = known.unwrap_or_else(|| (place.near_hz, curves(lines, place.near_hz, false)));
        if let Some((reading, errors)) = read_all(&curves, kind, &place) {
            let same =
                |r: &Reading| (r.ln_f - reading.ln_f).abs() < 4.0 * r.u_ln_f.hypot(reading.u_ln_f).max(1e-9);
            match found.iter_mut().find(|(up, r, _)| *up == place.upwards && same(r)) {
                Some(known) if reading.u < known.1.u => *known = (place.upwards, reading, errors),
                Some(_) => {}
                None => found.push((place.upwards, reading, errors)),
            }
        }
        fitted = Some((hz, curves));
    }
    found.sort_by(|a, b| a.1.ln_f.total_cmp(&b.1.ln_f));
    found
}

/// Where lines lie on two sides of the crossing, or nearly touch it.
fn places(lines: &[Line], kind: Kind) -> Vec<Place> {
    let hz = |k: usize| lines[k.min(lines.len() - 1)].frequency_hz;
    let mut places = Vec::new();
    for k in 0..lines.len() - 1 {
        let [low, high] = [lines[k].value, lines[k + 1].value].map(|v| kind.level(v));
        let part = low / (low - high);
        let between = lines[k].value + (lines[k + 1].value - lines[k].value) * part;
        if (low > 0.0) != (high > 0.0) && kind.counts(between) {
            let near_hz = hz(k) + part * (hz(k + 1) - hz(k));
            places.push(Place {
                near_hz,
                range_hz: [hz(k.saturating_sub(1)), hz(k + 2)],
                upwards: high > low,
            });
        }
        let distance = |k: usize| kind.distance(lines[k].value);
        let nearest = k > 0 && distance(k) <= distance(k - 1) && distance(k) <= distance(k + 1);
        if nearest && distance(k) < NEAR.max(3.0 * lines[k].relative_sd()) {
            for upwards in [true, false] {
                places.push(Place { near_hz: hz(k), range_hz: [hz(k - 1), hz(k + 1)], upwards });
            }
        }
    }
    places
}

/// Reads all curves; a crossing that most of them do not have is none.
fn read_all(curves: &[Curve], kind: Kind, place: &Place) -> Option<(Reading, Parts)> {
    let read: Vec<(Reading, Errors)> = curves.iter().filter_map(|c| read(c, kind, place)).collect();
    if 2 * read.len() < curves.len() {
        return None;
    }
    let winner = if kind == Kind::Phase { WINNER } else { WINNER_OF_MANY };
    let chosen = choose(read.iter().map(|(r, _)| *r).collect(), winner)?;
    let (raw, random) = read.iter().find(|(r, _)| (r.value, r.ln_f) == (chosen.value, chosen.ln_f))?;
    let beyond = |u: f64, random: f64| (u * u - random * random).max(0.0).sqrt();
    let errors = Parts {
        random: *random,
        systematic: beyond(chosen.u, raw.u),
        systematic_ln_f: beyond(chosen.u_ln_f, raw.u_ln_f),
    };
    Some((chosen, errors))
}

/// Crossing of one curve nearest to where the lines have it, with the errors there.
fn read(curve: &Curve, kind: Kind, place: &Place) -> Option<(Reading, Errors)> {
    let hz = root(curve, kind, place)?;
    let value = curve.value(hz);
    let errors = curve.errors(hz);
    let slope = curve.slope(hz);
    // What is read, its slope by ln f and its variance, and those of what places the crossing.
    let (read, [along, own], [across, placing], unit) = match kind {
        Kind::Gain | Kind::Level => ((-value).arg(), [slope.im, errors.phase], [slope.re, errors.gain], 1.0),
        Kind::Phase => (-DB * value.norm().ln(), [slope.re, errors.gain], [slope.im, errors.phase], DB),
    };
    let ratio = along / across;
    let square = own + ratio * ratio * placing - 2.0 * ratio * errors.both;
    let u_ln_f = placing.sqrt() / across.abs();
    let reading = Reading { value: read, u: unit * square.max(0.0).sqrt(), ln_f: hz.ln(), u_ln_f, slope };
    Some((reading, errors))
}

fn root(curve: &Curve, kind: Kind, place: &Place) -> Option<f64> {
    let [from, to] = place.range_hz;
    let abscissa = |i: usize| from + (to - from) * i as f64 / (3 * POINTS) as f64;
    let level = |hz: f64| kind.level(curve.value(hz));
    let levels: Vec<f64> = (0..=3 * POINTS).map(|i| level(abscissa(i))).collect();
    (0..3 * POINTS)
        .filter(|&i| {
            (levels[i] > 0.0) != (levels[i + 1] > 0.0) && (levels[i + 1] > levels[i]) == place.upwards
        })
        .map(|i| bisect([abscissa(i), abscissa(i + 1)], place.upwards, &level))
        .filter(|hz| kind.counts(curve.value(*hz)))
        .min_by(|a, b| (a - place.near_hz).abs().total_cmp(&(b - place.near_hz).abs()))
}

fn bisect([mut low, mut high]: [f64; 2], upwards: bool, level: &impl Fn(f64) -> f64) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if (level(middle) > 0.0) == upwards { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}
