//! Scalar settings of which a range does not say it all: switches, signs, whole numbers, whole steps, lists, and pairs in order.
//!
//! Checked once a unit lies over its bases, and pointed at in the file that brought it about.

use std::ops::Range;

use procedures::diagnostic::{Diagnostic, SourceFile};
use sim_devices::kvh::BAUDS;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::files::settings::{self, Described};

/// What a setting may be within its range.
#[derive(Clone, Copy, Debug)]
pub(super) enum Allowed {
    /// One of these, in ascending order.
    OneOf(&'static [f64]),
    /// A whole number.
    Whole,
    /// A time of whole steps of the simulation: what lies between would be rounded.
    Steps,
}

/// What the decimal digits of a time may be off a whole number of steps.
const STEPS_ROUNDING: f64 = 1e-6;
const SIGN: Allowed = Allowed::OneOf(&[-1.0, 1.0]);
const SWITCH: Allowed = Allowed::OneOf(&[0.0, 1.0]);
static BIT_RATES: [f64; BAUDS.len()] = {
    let mut rates = [0.0; BAUDS.len()];
    let mut k = 0;
    while k < rates.len() {
        rates[k] = BAUDS[k] as f64;
        k += 1;
    }
    rates
};

/// What the settings of a file must keep beyond their ranges.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rules {
    /// Settings that may not take every value of their range.
    pub(super) allowed: &'static [(&'static str, Allowed)],
    /// Pairs in order.
    pub(super) ordered: &'static [Ordered],
}

/// Rules for the director.
pub(super) const OF_DIRECTOR: Rules = Rules { allowed: ALLOWED, ordered: &ORDERED };

/// Rules for what belongs to no axis of a table.
pub(super) const OF_TABLE: Rules = Rules { allowed: &[("wiring.vendor", Allowed::Whole)], ordered: &[] };

/// Rules for an axis of a table.
pub(super) const OF_TABLE_AXIS: Rules = Rules {
    allowed: &[
        ("command-delay", Allowed::Steps),
        ("sensor-delay", Allowed::Steps),
        ("encoder-bits", Allowed::Whole),
        ("encoder-sign", SIGN),
        ("motor-sign", SIGN),
        ("soft-limits-enforced", SWITCH),
    ],
    ordered: &[
        Ordered { keys: ["lower-stop", "upper-stop"], equal_too: false, reason: STOPS },
        Ordered { keys: ["coulomb-torque", "static-torque"], equal_too: true, reason: BREAKAWAY },
    ],
};

const ALLOWED: &[(&str, Allowed)] = &[
    ("az.encoder-bits", Allowed::Whole),
    ("el.encoder-bits", Allowed::Whole),
    ("az.command-delay", Allowed::Steps),
    ("el.command-delay", Allowed::Steps),
    ("az.sensor-delay", Allowed::Steps),
    ("el.sensor-delay", Allowed::Steps),
    ("az.encoder-sign", SIGN),
    ("el.encoder-sign", SIGN),
    ("az.motor-sign", SIGN),
    ("el.motor-sign", SIGN),
    ("imu.gyro-sign-x", SIGN),
    ("imu.gyro-sign-y", SIGN),
    ("imu.gyro-sign-z", SIGN),
    ("imu.baud", Allowed::OneOf(&BIT_RATES)),
    ("mirror.notch", SWITCH),
    ("mirror.strain-gauge-loop", SWITCH),
    ("mirror.analog-only", SWITCH),
    ("target.kind", Allowed::OneOf(&[0.0, 1.0, 2.0, 3.0])),
    ("wiring.axes-swapped", SWITCH),
    ("wiring.az-soft-limits-enforced", SWITCH),
    ("wiring.el-soft-limits-enforced", SWITCH),
    ("wiring.vendor", Allowed::Whole),
];

/// Two settings of which the first is at most the second.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ordered {
    /// The smaller one, then the larger one.
    pub(super) keys: [&'static str; 2],
    equal_too: bool,
    reason: &'static str,
}

const STOPS: &str = "the lower stop must lie below the upper stop";
const BREAKAWAY: &str = "static friction is never below sliding friction";

const ORDERED: [Ordered; 4] = [
    Ordered { keys: ["az.lower-stop", "az.upper-stop"], equal_too: false, reason: STOPS },
    Ordered { keys: ["el.lower-stop", "el.upper-stop"], equal_too: false, reason: STOPS },
    Ordered { keys: ["az.coulomb-torque", "az.static-torque"], equal_too: true, reason: BREAKAWAY },
    Ordered { keys: ["el.coulomb-torque", "el.static-torque"], equal_too: true, reason: BREAKAWAY },
];

/// Scalar settings as they came out, and what each file gives of them.
pub(super) struct Values<'a> {
    /// What is known of each setting.
    pub(super) described: &'a [Described],
    /// What came out, in the same order.
    pub(super) values_si: Vec<f64>,
    /// The unit first, its last base last; places in `described` with their values.
    pub(super) files: Vec<(&'a SourceFile, &'a [(usize, f64)])>,
    /// Tables around the keys, outermost first.
    pub(super) within: Vec<&'a str>,
    /// Steps of the simulation, 1/s.
    pub(super) step_rate_hz: f64,
}

/// A mistake and where it stands: file, and byte in it.
pub(super) type Placed = ((usize, usize), Diagnostic);

/// Mistakes in the order of their places.
pub(super) fn in_order(mut found: Vec<Placed>) -> Vec<Diagnostic> {
    found.sort_by_key(|(place, _)| *place);
    found.into_iter().map(|(_, mistake)| mistake).collect()
}

impl Values<'_> {
    /// All mistakes of the settings that came out.
    pub(super) fn check(&self, rules: &Rules) -> Vec<Placed> {
        let single = rules.allowed.iter().filter_map(|(key, allowed)| self.check_value(key, *allowed));
        let pairs = rules.ordered.iter().filter_map(|pair| self.check_order(pair));
        single.chain(pairs).collect()
    }

    fn check_value(&self, key: &str, allowed: Allowed) -> Option<Placed> {
        let index = self.index(key)?;
        let value = self.values_si[index];
        let text = |value_si: f64| settings::text(&self.described[index], value_si);
        let (good, expected, found) = match allowed {
            Allowed::OneOf(values) => (values.contains(&value), listed(values), value.to_string()),
            Allowed::Whole => (value.fract() == 0.0, "a whole number".to_owned(), value.to_string()),
            Allowed::Steps => {
                let steps = value * self.step_rate_hz;
                let nearest = text(steps.round() / self.step_rate_hz);
                let step = text(1.0 / self.step_rate_hz);
                let expected = format!("a whole number of steps of {step} (`step-rate`), such as {nearest}");
                ((steps - steps.round()).abs() < STEPS_ROUNDING, expected, text(value))
            }
        };
        let message = format!("`{}` must be {expected}, found {found}", own_key(key));
        let layer = self.layer(index).filter(|_| !good)?;
        Some(self.mistake(layer, key, message, self.described[index].doc.to_owned()))
    }

    /// Of a pair the one in the file nearest to the unit itself is wrong.
    fn check_order(&self, pair: &Ordered) -> Option<Placed> {
        let [less, more] = [self.index(pair.keys[0])?, self.index(pair.keys[1])?];
        let [low, high] = [less, more].map(|k| self.values_si[k]);
        if low < high || pair.equal_too && low == high {
            return None;
        }
        let layers = [self.layer(less), self.layer(more)];
        let wrong = usize::from(layers[1].unwrap_or(usize::MAX) < layers[0].unwrap_or(usize::MAX));
        let other = 1 - wrong;
        let text = |k: usize| settings::text(&self.described[[less, more][k]], [low, high][k]);
        let relation = match (wrong, pair.equal_too) {
            (0, false) => "below",
            (0, true) => "at most",
            (_, false) => "above",
            (_, true) => "at least",
        };
        let [key, other_key] = [wrong, other].map(|k| own_key(pair.keys[k]));
        let origin = layers[other].map_or("the built-in unit", |layer| self.files[layer].0.name.as_str());
        let message = format!(
            "`{key}` must be {relation} `{other_key}`, {} in {origin}; found {}",
            text(other),
            text(wrong)
        );
        Some(self.mistake(layers[wrong]?, pair.keys[wrong], message, pair.reason.to_owned()))
    }

    /// The file nearest to the unit itself that gives a setting.
    fn layer(&self, index: usize) -> Option<usize> {
        self.files.iter().position(|(_, values)| values.iter().any(|(given, _)| *given == index))
    }

    fn mistake(&self, layer: usize, key: &str, message: String, help: String) -> Placed {
        let source = self.files[layer].0;
        let path: Vec<&str> = self.within.iter().copied().chain(key.split('.')).collect();
        let span = place(source, &path);
        ((layer, span.start), Diagnostic::new(message).help(help).at(source, span))
    }

    fn index(&self, key: &str) -> Option<usize> {
        self.described.iter().position(|d| d.key == key)
    }
}

/// The key as it stands in its table.
fn own_key(key: &str) -> &str {
    key.split_once('.').map_or(key, |(_, own)| own)
}

/// `-1 or 1`; `0, 1 or 2`.
fn listed(values: &[f64]) -> String {
    let texts: Vec<String> = values.iter().map(f64::to_string).collect();
    match texts.split_last() {
        Some((last, before)) if !before.is_empty() => format!("{} or {last}", before.join(", ")),
        _ => texts.concat(),
    }
}

/// Where the value of a key in nested tables stands.
fn place(source: &SourceFile, path: &[&str]) -> Range<usize> {
    let (root, _) = DeTable::parse_recoverable(&source.text);
    let Some((own, tables)) = path.split_last() else { return 0..0 };
    let mut entries = root.get_ref();
    for table in tables {
        match entries.get(*table).map(Spanned::get_ref) {
            Some(DeValue::Table(below)) => entries = below,
            _ => return 0..0,
        }
    }
    entries.get(*own).map_or(0..0, Spanned::span)
}
