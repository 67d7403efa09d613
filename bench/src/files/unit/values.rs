//! Scalar settings of which a range does not say it all: switches, signs, whole numbers, lists, and pairs in order.
//!
//! Checked once a unit lies over its bases, and pointed at in the file that brought it about.

use std::ops::Range;

use procedures::diagnostic::{Diagnostic, SourceFile};
use sim_devices::kvh::BAUDS;
use sim_devices::unit::{PARAMETERS, UnitSettings};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::described;

/// What a setting may be within its range.
#[derive(Clone, Copy, Debug)]
pub(super) enum Allowed {
    /// One of these, in ascending order.
    OneOf(&'static [f64]),
    /// A whole number.
    Whole,
}

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

/// Settings that may not take every value of their range.
pub(super) const ALLOWED: &[(&str, Allowed)] = &[
    ("az.encoder-bits", Allowed::Whole),
    ("el.encoder-bits", Allowed::Whole),
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

const STOPS: &str = "the axis turns between its stops";
const BREAKAWAY: &str = "a contact at rest holds at least as much as one that slides";

/// Pairs in order.
pub(super) const ORDERED: [Ordered; 4] = [
    Ordered { keys: ["az.lower-stop", "az.upper-stop"], equal_too: false, reason: STOPS },
    Ordered { keys: ["el.lower-stop", "el.upper-stop"], equal_too: false, reason: STOPS },
    Ordered { keys: ["az.coulomb-torque", "az.static-torque"], equal_too: true, reason: BREAKAWAY },
    Ordered { keys: ["el.coulomb-torque", "el.static-torque"], equal_too: true, reason: BREAKAWAY },
];

/// Scalar settings that each file gives: the unit first, its last base last.
pub(super) struct Values<'a> {
    files: Vec<(&'a SourceFile, &'a [(usize, f64)])>,
}

/// A mistake and where it stands: file, and byte in it.
type Placed = ((usize, usize), Diagnostic);

impl<'a> Values<'a> {
    /// The unit first, its last base last.
    pub(super) fn new(files: Vec<(&'a SourceFile, &'a [(usize, f64)])>) -> Self {
        Self { files }
    }

    /// All mistakes of the settings that came out, in the order of their places.
    pub(super) fn check(&self, settings: &UnitSettings) -> Vec<Diagnostic> {
        let single = ALLOWED.iter().filter_map(|(key, allowed)| self.check_value(settings, key, *allowed));
        let pairs = ORDERED.iter().filter_map(|pair| self.check_order(settings, pair));
        let mut found: Vec<Placed> = single.chain(pairs).collect();
        found.sort_by_key(|(place, _)| *place);
        found.into_iter().map(|(_, mistake)| mistake).collect()
    }

    fn check_value(&self, settings: &UnitSettings, key: &str, allowed: Allowed) -> Option<Placed> {
        let index = index(key)?;
        let value = (PARAMETERS[index].get)(settings);
        let (good, expected) = match allowed {
            Allowed::OneOf(values) => (values.contains(&value), listed(values)),
            Allowed::Whole => (value.fract() == 0.0, "a whole number".to_owned()),
        };
        let message = format!("`{}` must be {expected}, found {value}", own_key(key));
        let layer = self.layer(index).filter(|_| !good)?;
        Some(self.mistake(layer, key, message, PARAMETERS[index].doc.to_owned()))
    }

    /// Of a pair the one in the file nearest to the unit itself is wrong.
    fn check_order(&self, settings: &UnitSettings, pair: &Ordered) -> Option<Placed> {
        let [less, more] = [index(pair.keys[0])?, index(pair.keys[1])?];
        let [low, high] = [less, more].map(|k| (PARAMETERS[k].get)(settings));
        if low < high || pair.equal_too && low == high {
            return None;
        }
        let layers = [self.layer(less), self.layer(more)];
        let wrong = usize::from(layers[1].unwrap_or(usize::MAX) < layers[0].unwrap_or(usize::MAX));
        let other = 1 - wrong;
        let text = |k: usize| described()[[less, more][k]].text([low, high][k]);
        let relation = match (wrong, pair.equal_too) {
            (0, false) => "below",
            (0, true) => "at most",
            (_, false) => "above",
            (_, true) => "at least",
        };
        let [key, other_key] = [wrong, other].map(|k| own_key(pair.keys[k]));
        let origin = layers[other].map_or("the unit built in", |layer| self.files[layer].0.name.as_str());
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
        let span = place(source, key);
        ((layer, span.start), Diagnostic::new(message).help(help).at(source, span))
    }
}

fn index(key: &str) -> Option<usize> {
    PARAMETERS.iter().position(|p| p.key == key)
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

/// Where the value of a dotted key stands.
fn place(source: &SourceFile, key: &str) -> Range<usize> {
    let (root, _) = DeTable::parse_recoverable(&source.text);
    let own = own_key(key);
    let table = key.strip_suffix(own).unwrap_or_default().trim_end_matches('.');
    let below = match root.get_ref().get(table).map(Spanned::get_ref) {
        Some(DeValue::Table(entries)) => entries.get(own),
        _ => root.get_ref().get(own),
    };
    below.map_or(0..0, Spanned::span)
}
