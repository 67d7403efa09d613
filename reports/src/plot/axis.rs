//! Scales and ticks of a picture: linear or logarithmic, in steps of 1, 2 and 5.

use crate::number;

/// Larger numbers are not drawn and smaller ones are zero: sums, ratios and steps of all others stay normal numbers.
const LARGEST: f64 = 1e150;
const SMALLEST: f64 = 1e-150;
/// No scale has more ticks, whatever its extent.
const MOST_TICKS: i64 = 40;

/// One tick.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    /// Where on the scale.
    pub(super) at: f64,
    /// Text; `None` for a minor tick.
    pub(super) label: Option<Label>,
}

/// Text of a tick.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Label {
    /// As it stands.
    Plain(String),
    /// Ten to this power.
    Power(i32),
}

/// Maps values to a stretch of the paper.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    /// Smallest and largest value shown.
    pub(super) range: [f64; 2],
    /// Where these lie, in units of the picture.
    pub(super) paper: [f64; 2],
    /// Logarithmic.
    pub(super) log: bool,
    /// Major and minor ticks in ascending order.
    pub(super) ticks: Vec<Tick>,
    /// Power of ten that was taken out of the labels.
    pub(super) power: i32,
}

impl Axis {
    /// A scale that shows all `values` (those not positive do not count on a logarithmic one), with about `count`
    /// major ticks.
    pub(super) fn new(values: impl Iterator<Item = f64>, log: bool, paper: [f64; 2], count: usize) -> Self {
        let shown = values.filter(|v| v.abs() <= LARGEST && (!log || *v >= SMALLEST));
        let range = padded(extent(shown.map(|v| if v.abs() < SMALLEST { 0.0 } else { v })), log);
        let (ticks, power) = if log { (log_ticks(range, count), 0) } else { linear_ticks(range, count) };
        Self { range, paper, log, ticks, power }
    }

    /// Place of a value on the paper; `None` for what the scale cannot show.
    pub(super) fn place(&self, value: f64) -> Option<f64> {
        if value.is_nan() || value.abs() > LARGEST || (self.log && value < SMALLEST) {
            return None;
        }
        let map = |v: f64| if self.log { v.log10() } else { v };
        let [low, high] = self.range.map(map);
        Some(self.paper[0] + (map(value) - low) / (high - low) * (self.paper[1] - self.paper[0]))
    }

    /// Place of a value, or of the end of the scale that is nearest to it.
    pub(super) fn clamped(&self, value: f64) -> f64 {
        self.place(value.clamp(self.range[0], self.range[1])).unwrap_or(self.paper[0])
    }
}

fn extent(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.fold(None, |range: Option<[f64; 2]>, v| {
        Some(range.map_or([v, v], |[low, high]| [low.min(v), high.max(v)]))
    })
}

/// The extent with 4 % of air; a single value gets room around it.
fn padded(extent: Option<[f64; 2]>, log: bool) -> [f64; 2] {
    let Some([low, high]) = extent else { return if log { [1.0, 10.0] } else { [0.0, 1.0] } };
    if log {
        let air = ((high / low).log10() * 0.04).max(if high / low < 1.01 { 0.3 } else { 0.02 });
        return [low / 10f64.powf(air), high * 10f64.powf(air)];
    }
    let span = high - low;
    if span <= 1e-12 * low.abs().max(high.abs()) {
        let room = if low == 0.0 { 1.0 } else { 0.1 * low.abs() };
        return [low - room, high + room];
    }
    [low - 0.04 * span, high + 0.04 * span]
}

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

fn linear_ticks([low, high]: [f64; 2], count: usize) -> (Vec<Tick>, i32) {
    let (step, exponent) = step(high - low, count);
    let largest = low.abs().max(high.abs());
    let power = if (1e-2..1e5).contains(&largest) { 0 } else { largest.log10().floor() as i32 };
    let places = (power - exponent).max(0) as usize;
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    let tick = |i: i64| {
        let at = i as f64 * step;
        let text = format!("{:.places$}", at / 10f64.powi(power));
        let text = if i == 0 { "0".to_owned() } else { number::typeset(&text) };
        Tick { at, label: Some(Label::Plain(text)) }
    };
    ((first..=last.min(first.saturating_add(MOST_TICKS))).map(tick).collect(), power)
}

fn log_ticks([low, high]: [f64; 2], count: usize) -> Vec<Tick> {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<String> {
        axis.ticks
            .iter()
            .filter_map(|t| match t.label.as_ref()? {
                Label::Plain(text) => Some(text.clone()),
                Label::Power(n) => Some(format!("10^{n}")),
            })
            .collect()
    }

    fn axis(values: &[f64], log: bool) -> Axis {
        Axis::new(values.iter().copied(), log, [0.0, 100.0], 6)
    }

    #[test]
    fn linear_ticks_stand_at_round_numbers() {
        assert_eq!(labels(&axis(&[-60.0, 60.0], false)), ["−60", "−40", "−20", "0", "20", "40", "60"]);
        assert_eq!(labels(&axis(&[0.0, 0.31], false)), ["0", "0.05", "0.10", "0.15", "0.20", "0.25", "0.30"]);
        let large = axis(&[0.0, 3.2e6], false);
        assert_eq!((labels(&large).join(" "), large.power), ("0 0.5 1.0 1.5 2.0 2.5 3.0".to_owned(), 6));
    }

    #[test]
    fn log_ticks_follow_the_span() {
        assert_eq!(
            labels(&axis(&[0.05, 60.0], true)),
            ["0.1", "1", "10"],
            "more than three decades: decades only"
        );
        assert_eq!(labels(&axis(&[2.0, 60.0], true)), ["2", "5", "10", "20", "50"]);
        assert_eq!(labels(&axis(&[1e-9, 1e9], true)), ["10^-8", "10^-4", "10^0", "10^4", "10^8"]);
        assert!(labels(&axis(&[3.1, 3.4], true)).len() >= 2, "less than one step of the digits");
    }

    #[test]
    fn every_extent_gives_a_scale_that_shows_it() {
        for values in [
            vec![],
            vec![0.0],
            vec![5.0, 5.0],
            vec![-3.0],
            vec![5e-324],
            vec![0.0, 5e-324],
            vec![1e-150, 1e150],
            vec![-1e150, 1e150],
        ] {
            for log in [false, true] {
                let axis = axis(&values, log);
                assert!(axis.range[0] < axis.range[1], "{values:?} {log} {:?}", axis.range);
                assert!(axis.ticks.len() < 4000, "{} ticks for {values:?}", axis.ticks.len());
                for &v in values.iter().filter(|v| !log || **v >= SMALLEST) {
                    let place = axis.place(v).expect("it is on the scale");
                    assert!((0.0..=100.0).contains(&place), "{v} lies at {place}");
                }
            }
        }
    }

    #[test]
    fn a_logarithmic_scale_does_not_show_zero() {
        assert_eq!(axis(&[0.0, 1.0, 10.0], true).place(0.0), None);
    }
}
