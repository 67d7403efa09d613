//! How one setting is spread over the units of a family.

use procedures::population::truncated_normal::TruncatedNormal;
use procedures::quantity::QuantityKind;
use procedures::table::TableReader;

/// Distribution of one setting; values are SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Distribution {
    /// All values within the half-width of the nominal one are equally likely.
    Rectangular { nominal_si: f64, half_width_si: f64 },
    /// The nominal value and so many steps to either side, all equally likely.
    Steps { nominal_si: f64, step_si: f64, most_count: u32 },
    /// Normal, within limits.
    Normal(TruncatedNormal),
    /// The natural logarithm of the value is normal, within limits.
    LogNormal(TruncatedNormal),
}

impl Distribution {
    /// The value below which a share of 0 to 1 of the units lies.
    pub(super) fn quantile_si(&self, share: f64) -> f64 {
        match self {
            Self::Rectangular { nominal_si, half_width_si } => {
                nominal_si + half_width_si * (2.0 * share - 1.0)
            }
            Self::Steps { nominal_si, step_si, most_count } => {
                let count = f64::from(2 * most_count + 1);
                let step = (share * count).floor().min(count - 1.0) - f64::from(*most_count);
                nominal_si + step_si * step
            }
            Self::Normal(normal) => normal.quantile(share),
            Self::LogNormal(normal) => normal.quantile(share).exp(),
        }
    }

    /// How many values are equally likely, where the distribution has steps.
    pub(super) fn steps_count(&self) -> Option<u64> {
        match self {
            Self::Steps { most_count, .. } => Some(2 * u64::from(*most_count) + 1),
            _ => None,
        }
    }
}

/// What is spread: a setting, or the factor of a mode.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spread<'a> {
    /// Its name in messages.
    pub(super) key: &'a str,
    pub(super) kind: QuantityKind,
    pub(super) nominal_si: f64,
    /// Values that it may have.
    pub(super) range_si: [f64; 2],
}

/// Keys that say how far a distribution reaches, each with the distributions that it belongs to.
const KEYS: [(&str, &[&str]); 6] = [
    ("half-width", &["rectangular"]),
    ("step", &["steps"]),
    ("steps", &["steps"]),
    ("standard-deviation", &["normal"]),
    ("geometric-deviation", &["log-normal"]),
    ("limits", &["normal", "log-normal"]),
];
/// More steps than any setting has.
const MOST_STEPS: i64 = 1_000_000;
/// What a limit of a distribution may lie beyond the range of its setting, relative to that: the rounding of decimal digits.
const ROUNDING: f64 = 1e-9;

/// What a table says of a distribution, not yet applied to a setting.
#[derive(Debug)]
pub(super) struct Shape {
    name: String,
    half_width: Option<String>,
    step: Option<String>,
    steps_count: Option<u32>,
    standard_deviation: Option<String>,
    geometric_deviation_ratio: Option<f64>,
    limits: Option<String>,
}

impl Shape {
    /// Reads the keys; those of another distribution, and missing ones, are mistakes.
    pub(super) fn read(t: &mut TableReader<'_>) -> Option<Self> {
        let found = t.mistakes();
        let name = t.text("distribution");
        let shape = Self {
            half_width: t.text("half-width"),
            step: t.text("step"),
            steps_count: steps(t),
            standard_deviation: t.text("standard-deviation"),
            geometric_deviation_ratio: geometric_deviation(t),
            limits: t.text("limits"),
            name: name?,
        };
        for (key, distributions) in KEYS {
            let belongs = distributions.contains(&shape.name.as_str());
            match (t.has(key), belongs) {
                (true, false) => {
                    let message = format!("`{key}` does not belong to the distribution `{}`", shape.name);
                    let help = format!("remove it, or write `distribution = \"{}\"`", distributions[0]);
                    t.mistake(key, message, Some(help));
                }
                (false, true) if key != "limits" => {
                    let message = format!("`{key}` is missing for the distribution `{}`", shape.name);
                    t.mistake_at(t.place(), message, Some(format!("add `{key}`")));
                }
                _ => {}
            }
        }
        (t.mistakes() == found).then_some(shape)
    }

    /// The distribution of one setting. A value that does not fit it is a mistake at its key.
    pub(super) fn of_setting(&self, t: &mut TableReader<'_>, spread: &Spread<'_>) -> Option<Distribution> {
        match self.name.as_str() {
            "steps" => self.in_steps(t, spread),
            "normal" => self.normal(t, spread),
            "log-normal" => self.log_normal(t, spread),
            _ => self.rectangular(t, spread),
        }
    }

    fn rectangular(&self, t: &mut TableReader<'_>, spread: &Spread<'_>) -> Option<Distribution> {
        let key = "half-width";
        let half_width_si = spread.scale(t, key, self.half_width.as_deref()?)?;
        spread.check_reach(t, key, half_width_si)?;
        Some(Distribution::Rectangular { nominal_si: spread.nominal_si, half_width_si })
    }

    fn in_steps(&self, t: &mut TableReader<'_>, spread: &Spread<'_>) -> Option<Distribution> {
        let step_si = spread.scale(t, "step", self.step.as_deref()?)?;
        let most_count = self.steps_count?;
        spread.check_reach(t, "steps", step_si * f64::from(most_count))?;
        Some(Distribution::Steps { nominal_si: spread.nominal_si, step_si, most_count })
    }

    fn normal(&self, t: &mut TableReader<'_>, spread: &Spread<'_>) -> Option<Distribution> {
        let key = "standard-deviation";
        let deviation_si = spread.scale(t, key, self.standard_deviation.as_deref()?)?;
        let limits_si = spread.limits(t, self.limits.as_deref())?;
        let found = TruncatedNormal::new(spread.nominal_si, deviation_si, limits_si);
        spread.or_nothing_left(t, found.ok()).map(Distribution::Normal)
    }

    fn log_normal(&self, t: &mut TableReader<'_>, spread: &Spread<'_>) -> Option<Distribution> {
        if spread.nominal_si <= 0.0 {
            let nominal = spread.kind.format(spread.nominal_si);
            let message =
                format!("`{}` is {nominal}; a log-normal distribution needs a value above zero", spread.key);
            t.mistake("distribution", message, Some("use `normal` or `rectangular`".to_owned()));
            return None;
        }
        let limits_si = spread.limits(t, self.limits.as_deref())?;
        // The logarithm of zero is no limit at all.
        let limits = limits_si.map(|limit_si| limit_si.max(0.0).ln());
        let deviation = self.geometric_deviation_ratio?.ln();
        let found = TruncatedNormal::new(spread.nominal_si.ln(), deviation, limits);
        spread.or_nothing_left(t, found.ok()).map(Distribution::LogNormal)
    }
}

fn steps(t: &mut TableReader<'_>) -> Option<u32> {
    let key = "steps";
    let steps = t.has(key).then(|| t.integer(key, 1)).flatten()?;
    if steps > MOST_STEPS {
        t.mistake(key, format!("`{key}` must be at most {MOST_STEPS}, found {steps}"), None);
        return None;
    }
    u32::try_from(steps).ok()
}

fn geometric_deviation(t: &mut TableReader<'_>) -> Option<f64> {
    let key = "geometric-deviation";
    let ratio = t.quantity(key)?;
    if ratio <= 1.0 {
        let help = "write the factor by which two units of three differ at most, e.g. `1.2`".to_owned();
        t.mistake(key, format!("`{key}` must be above 1, found {ratio}"), Some(help));
        return None;
    }
    Some(ratio)
}

impl Spread<'_> {
    /// A half-width, step or deviation: above zero, in the unit of the setting or as a share of its nominal value.
    fn scale(&self, t: &mut TableReader<'_>, key: &str, text: &str) -> Option<f64> {
        const OF_NOMINAL: &str = "of nominal";
        let share = text.trim().strip_suffix(OF_NOMINAL);
        let parsed = match share {
            Some(share) => QuantityKind::Ratio.parse(share).map(|share| share * self.nominal_si.abs()),
            None => self.kind.parse(text),
        };
        let scale_si = match parsed {
            Ok(scale_si) => scale_si,
            Err(error) => {
                let example = self.kind.example();
                let help =
                    format!("write a share, `5 % {OF_NOMINAL}`, or an absolute value such as `{example}`");
                t.mistake(key, format!("`{key}` of `{}`: {error}", self.key), Some(help));
                return None;
            }
        };
        if scale_si > 0.0 {
            return Some(scale_si);
        }
        let (message, help) = match share {
            Some(_) if self.nominal_si == 0.0 => (
                format!("`{key}` is a share of nominal, but `{}` of the base is zero", self.key),
                Some(format!("write an absolute value such as `{}`", self.kind.example())),
            ),
            _ => (format!("`{key}` must be above zero, found `{text}`"), None),
        };
        t.mistake(key, message, help);
        None
    }

    /// Both ends of a bounded distribution must be allowed.
    fn check_reach(&self, t: &mut TableReader<'_>, key: &str, reach_si: f64) -> Option<()> {
        let [least_si, most_si] = self.range_si;
        let ends_si = [self.nominal_si - reach_si, self.nominal_si + reach_si];
        let slack_si = ROUNDING * (most_si.abs().min(f64::MAX) + least_si.abs().min(f64::MAX));
        if ends_si[0] >= least_si - slack_si && ends_si[1] <= most_si + slack_si {
            return Some(());
        }
        let format = |si: f64| self.kind.format(si);
        let room_si = (self.nominal_si - least_si).min(most_si - self.nominal_si).max(0.0);
        let message = format!(
            "`{}` would be {} to {}; it must be {} to {}",
            self.key,
            format(ends_si[0]),
            format(ends_si[1]),
            format(least_si),
            format(most_si)
        );
        let nominal = format(self.nominal_si);
        let help = format!("it may differ from its nominal value {nominal} by at most {}", format(room_si));
        t.mistake(key, message, Some(help));
        None
    }

    /// Limits of a normal distribution within the range of the setting.
    fn limits(&self, t: &mut TableReader<'_>, text: Option<&str>) -> Option<[f64; 2]> {
        let Some(text) = text else { return Some(self.range_si) };
        match self.kind.parse_range(text) {
            Ok([low_si, high_si]) => Some([low_si.max(self.range_si[0]), high_si.min(self.range_si[1])]),
            Err(error) => {
                t.mistake("limits", format!("`limits` of `{}`: {error}", self.key), error.help());
                None
            }
        }
    }

    /// Says so where the limits leave nothing of a distribution.
    fn or_nothing_left<T>(&self, t: &mut TableReader<'_>, found: Option<T>) -> Option<T> {
        if found.is_none() {
            let [least, most] = self.range_si.map(|limit_si| self.kind.format(limit_si));
            let nominal = self.kind.format(self.nominal_si);
            let message = format!(
                "nothing is left of the distribution of `{}` about {nominal} between its limits",
                self.key
            );
            let help = format!("the setting must be {least} to {most}: widen `limits` or the distribution");
            t.mistake("limits", message, Some(help));
        }
        found
    }
}
