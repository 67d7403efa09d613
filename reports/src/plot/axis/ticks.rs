//! Where ticks stand and what they say.

use super::{Label, Tick};
use crate::number;

/// No scale has more ticks, whatever its extent.
const MOST_TICKS: i64 = 40;
/// Parts of a turn at which a scale in degrees has ticks.
const TURN_PARTS_DEG: [f64; 6] = [15.0, 30.0, 45.0, 90.0, 180.0, 360.0];

/// Step of 1, 2 or 5 times a power of ten that divides `span` into about `count` parts, with its exponent.
/// A step up to 15 % too small is better than the next, twice as large.
fn step(span: f64, count: usize) -> (f64, i32) {
    let raw = span / count.max(1) as f64;
    let exponent = raw.log10().floor() as i32;
    let unit = 10f64.powi(exponent);
    let factor = [1.0, 2.0, 5.0].into_iter().find(|f| f * unit >= raw * 0.85);
    match factor {
        Some(factor) => (factor * unit, exponent),
        None => (10.0 * unit, exponent + 1),
    }
}

/// Ticks of a scale in degrees at parts of a turn; decimal ones where it spans less than an eighth of one, or many.
pub(super) fn degree_ticks([low, high]: [f64; 2], count: usize) -> (Vec<Tick>, i32) {
    let raw = (high - low) / count.max(1) as f64;
    let part = TURN_PARTS_DEG.into_iter().find(|&part| part >= 0.85 * raw);
    match part {
        Some(part) if high - low >= 45.0 => (multiples([low, high], part, 0, 0), 0),
        _ => linear_ticks([low, high], count),
    }
}

pub(super) fn linear_ticks([low, high]: [f64; 2], count: usize) -> (Vec<Tick>, i32) {
    let (mut step, mut exponent) = step(high - low, count);
    // One tick is no scale: a smaller step then, which has two.
    if (high / step).floor() - (low / step).ceil() < 1.0 {
        (step, exponent) = finer(step, exponent);
    }
    let largest = low.abs().max(high.abs());
    let power = if (1e-2..1e5).contains(&largest) { 0 } else { largest.log10().floor() as i32 };
    let places = (power - exponent).max(0) as usize;
    (multiples([low, high], step, power, places), power)
}

/// The next smaller one of the steps: half of 1 and 2, two fifths of 5.
fn finer(step: f64, exponent: i32) -> (f64, i32) {
    match (step / 10f64.powi(exponent)).round() as i64 {
        1 => (0.5 * step, exponent - 1),
        5 => (0.4 * step, exponent),
        _ => (0.5 * step, exponent),
    }
}

/// Ticks at the multiples of `step`, in units of ten to `power`.
fn multiples([low, high]: [f64; 2], step: f64, power: i32, places: usize) -> Vec<Tick> {
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    let tick = |i: i64| {
        let at = i as f64 * step;
        let text = format!("{:.places$}", at / 10f64.powi(power));
        let text = if i == 0 { "0".to_owned() } else { number::typeset(&text) };
        Tick { at, label: Some(Label::Plain(text)) }
    };
    (first..=last.min(first.saturating_add(MOST_TICKS))).map(tick).collect()
}

pub(super) fn log_ticks([low, high]: [f64; 2], count: usize) -> Vec<Tick> {
    let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
    let span = (high / low).log10();
    // One way of writing in one picture: powers of ten as soon as a decade needs them.
    let powers = low < 1e-3 || high > 9.99e4;
    let every = ((span / count.max(1) as f64).ceil() as i32).max(1);
    let mut ticks = Vec::new();
    for decade in decades {
        for digit in 1..10 {
            let at = f64::from(digit) * 10f64.powi(decade);
            if !(low..=high).contains(&at) {
                continue;
            }
            let labelled = match digit {
                1 => decade.rem_euclid(every) == 0,
                2 | 5 => span < 2.5,
                _ => span < 0.7,
            };
            if every == 1 || digit == 1 {
                ticks.push(Tick { at, label: labelled.then(|| log_label(at, powers && digit == 1)) });
            }
        }
    }
    if ticks.iter().filter(|t| t.label.is_some()).count() < 2 {
        return linear_ticks([low, high], count).0;
    }
    ticks
}

fn log_label(at: f64, power: bool) -> Label {
    if power { Label::Power(at.log10().round() as i32) } else { Label::Plain(number::short(at, 2)) }
}
