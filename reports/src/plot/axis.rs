//! Scales and ticks of a picture: linear or logarithmic, in steps of 1, 2 and 5.

use procedures::trace::Scale;

use crate::number;

mod ticks;

/// Larger numbers are not drawn and smaller ones are zero: sums, ratios and steps of all others stay normal numbers.
const LARGEST: f64 = 1e150;
const SMALLEST: f64 = 1e-150;

/// Places beyond it are far enough outside of any picture.
const FAR: f64 = 1e6;

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

impl Label {
    /// The text as wide as it is drawn.
    pub(super) fn text(&self) -> String {
        match self {
            Self::Plain(text) => text.clone(),
            Self::Power(power) => format!("10{power}"),
        }
    }
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

/// What a scale is divided into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Linear,
    Logarithmic,
    /// Linear, in degrees.
    Degrees,
}

impl Kind {
    pub(super) fn of(scale: &Scale) -> Self {
        match (scale.log, scale.unit.as_str()) {
            (true, _) => Self::Logarithmic,
            (false, "deg") => Self::Degrees,
            (false, _) => Self::Linear,
        }
    }
}

/// The range that shows all `values` (those not positive do not count on a logarithmic scale) with some air around
/// them, or `asked` as it is if a scale can show that.
pub(super) fn range(values: impl Iterator<Item = f64>, log: bool, asked: Option<[f64; 2]>) -> [f64; 2] {
    let fits = |v: &f64| v.abs() <= LARGEST && (!log || *v >= SMALLEST);
    let wide = |[low, high]: &[f64; 2]| high - low > 1e-9 * low.abs().max(high.abs()).max(SMALLEST);
    if let Some(asked) = asked.filter(|asked| asked.iter().all(fits) && wide(asked)) {
        return asked;
    }
    padded(extent(values.filter(fits).map(|v| if v.abs() < SMALLEST { 0.0 } else { v })), log)
}

impl Axis {
    /// A scale over `range` with about `count` major ticks.
    pub(super) fn new(range: [f64; 2], kind: Kind, paper: [f64; 2], count: usize) -> Self {
        let (ticks, power) = match kind {
            Kind::Linear => ticks::linear_ticks(range, count),
            Kind::Logarithmic => (ticks::log_ticks(range, count), 0),
            Kind::Degrees => ticks::degree_ticks(range, count),
        };
        Self { range, paper, log: kind == Kind::Logarithmic, ticks, power }
    }

    /// A list: its rows stand at 1, 2, …, from the first end of the paper to the other.
    pub(super) fn rows(names: &[String], paper: [f64; 2]) -> Self {
        let tick = |(i, name): (usize, &String)| Tick {
            at: (i + 1) as f64,
            label: Some(Label::Plain(number::typeset(name))),
        };
        let ticks = names.iter().enumerate().map(tick).collect();
        Self { range: [0.5, names.len() as f64 + 0.5], paper, log: false, ticks, power: 0 }
    }

    /// Place of a value on the paper; `None` for what the scale cannot show.
    pub(super) fn place(&self, value: f64) -> Option<f64> {
        if value.is_nan() || value.abs() > LARGEST || (self.log && value < SMALLEST) {
            return None;
        }
        let map = |v: f64| if self.log { v.log10() } else { v };
        let [low, high] = self.range.map(map);
        let at = self.paper[0] + (map(value) - low) / (high - low) * (self.paper[1] - self.paper[0]);
        Some(at.clamp(-FAR, FAR))
    }

    /// Whether a value lies within the scale.
    pub(super) fn shows(&self, value: f64) -> bool {
        (self.range[0]..=self.range[1]).contains(&value)
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
        let kind = if log { Kind::Logarithmic } else { Kind::Linear };
        Axis::new(range(values.iter().copied(), log, None), kind, [0.0, 100.0], 6)
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
    fn degrees_are_divided_into_parts_of_a_turn() {
        let phase =
            |low: f64, high: f64| labels(&Axis::new([low, high], Kind::Degrees, [0.0, 100.0], 3)).join(" ");
        assert_eq!(phase(-190.0, 10.0), "−180 −90 0");
        assert_eq!(phase(-100.0, 40.0), "−90 −45 0");
        assert_eq!(phase(-900.0, 0.0), "−720 −360 0");
        assert_eq!(phase(10.0, 85.0), "30 60");
        assert_eq!(phase(0.0, 3.0), "0 1 2 3", "no part of a turn is that small");
    }

    #[test]
    fn a_scale_has_two_ticks_at_least() {
        let count = |low: f64, high: f64| Axis::new([low, high], Kind::Linear, [0.0, 100.0], 3).ticks.len();
        for low in [0.0, 0.3, 3.0, 11.0, 49.0] {
            for span in [0.9, 1.4, 7.5, 21.0, 75.0] {
                assert!(count(low, low + span) >= 2, "from {low} to {}", low + span);
            }
        }
    }

    #[test]
    fn a_range_that_was_asked_for_is_taken_if_it_is_one() {
        let values = || [1.0, 2.0].into_iter();
        assert_eq!(range(values(), false, Some([-3.0, 3.0])), [-3.0, 3.0]);
        for no_range in [[3.0, -3.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
            assert_eq!(range(values(), false, Some(no_range)), range(values(), false, None), "{no_range:?}");
        }
        assert_eq!(range(values(), true, Some([0.0, 3.0])), range(values(), true, None), "no logarithm of 0");
    }

    #[test]
    fn a_logarithmic_scale_does_not_show_zero() {
        assert_eq!(axis(&[0.0, 1.0, 10.0], true).place(0.0), None);
    }
}
