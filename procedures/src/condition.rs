//! Conditions under which something is measured: the names that procedures, campaigns and requirements share.

use std::ops::Range;

use crate::diagnostic::Diagnostic;
use crate::measurement::Condition;
use crate::quantity::{Limit, QuantityKind};
use crate::table::{MapEntry, TableReader, suggestion};

/// Every condition with the kind of its quantity.
pub const CONDITIONS: &[(&str, QuantityKind)] = &[
    ("velocity", QuantityKind::AngularVelocity),
    ("pose", QuantityKind::Angle),
    ("elevation", QuantityKind::Angle),
    ("target", QuantityKind::Angle),
    ("rate", QuantityKind::CurrentRate),
    ("dwell", QuantityKind::Time),
    ("level", QuantityKind::Voltage),
    ("frequency", QuantityKind::Frequency),
    ("step", QuantityKind::Angle),
    ("frame-rate", QuantityKind::Frequency),
    ("amplitude", QuantityKind::Angle),
    (MOVING_AXES, QuantityKind::Count),
];

/// How many axes move at once.
pub(crate) const MOVING_AXES: &str = "moving-axes";

/// Two requested values are the same if they differ by less than this part of the larger one: both were parsed from
/// text, perhaps in different units.
const SAME_RATIO: f64 = 1e-9;

/// The kind of quantity of the condition of this name.
pub fn kind_of(condition: &str) -> Option<QuantityKind> {
    CONDITIONS.iter().find(|(name, _)| *name == condition).map(|(_, kind)| *kind)
}

/// Names of all conditions.
pub fn names() -> impl Iterator<Item = &'static str> + Clone {
    CONDITIONS.iter().map(|(name, _)| *name)
}

/// Whether two SI values stand for the same requested value.
pub fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_RATIO * a.abs().max(b.abs())
}

/// The value by which a condition is compared: velocities and rates by magnitude, all else with its sign.
pub(crate) fn compared(kind: QuantityKind, value_si: f64) -> f64 {
    match kind {
        QuantityKind::AngularVelocity | QuantityKind::CurrentRate => value_si.abs(),
        _ => value_si,
    }
}

/// What a condition must meet.
#[derive(Clone, Debug, PartialEq)]
pub enum Meets {
    /// A limit. Velocities and rates are compared by magnitude: `<= 10 deg/s` is about speed, not direction.
    Limit(Limit),
    /// One of these SI values.
    OneOf {
        /// The values, SI.
        values: Vec<f64>,
        /// As a person wrote them, separated by commas.
        text: String,
    },
}

impl Meets {
    /// Whether a measurement's condition meets it, by the value that was asked for.
    pub fn holds(&self, condition: &Condition) -> bool {
        let requested = condition.requested;
        match self {
            Self::OneOf { values, .. } => values.iter().any(|&value| same(value, requested)),
            Self::Limit(limit) => {
                let value = compared(condition.kind, requested);
                // On a bound up to rounding counts as on the bound.
                let bound = [limit.low, limit.high].into_iter().flatten().find(|&bound| same(bound, value));
                limit.holds(bound.unwrap_or(value))
            }
        }
    }

    /// As a person wrote it, e.g. `<= 10 deg/s` or `20 deg, 40 deg`.
    pub fn text(&self) -> &str {
        match self {
            Self::Limit(limit) => &limit.text,
            Self::OneOf { text, .. } => text,
        }
    }
}

/// Reads an entry of a map whose keys are conditions; unknown names and wrong values are left as mistakes.
pub(crate) fn read_meets(table: &mut TableReader<'_>, entry: &MapEntry) -> Option<Meets> {
    let kind = known(table, entry)?;
    if let [(text, span)] = entry.texts.as_slice()
        && (text.trim_start().starts_with(['<', '>', '≤', '≥']) || text.contains(".."))
    {
        let limit = kind.parse_limit(text);
        return limit.map(Meets::Limit).map_err(|e| quantity_mistake(table, &entry.key, &e, span)).ok();
    }
    let values = values_of(table, entry, kind)?;
    let text = entry.texts.iter().map(|(text, _)| text.trim()).collect::<Vec<_>>().join(", ");
    Some(Meets::OneOf { values, text })
}

/// Reads an entry of a map from conditions to values, SI.
pub(crate) fn read_values(table: &mut TableReader<'_>, entry: &MapEntry) -> Option<Vec<f64>> {
    let kind = known(table, entry)?;
    values_of(table, entry, kind)
}

fn known(table: &mut TableReader<'_>, entry: &MapEntry) -> Option<QuantityKind> {
    let kind = kind_of(&entry.key);
    if kind.is_none() {
        let message = format!("unknown condition `{}`", entry.key);
        table.mistake_at(entry.key_span.clone(), message, Some(suggestion(&entry.key, names())));
    }
    kind
}

fn values_of(table: &mut TableReader<'_>, entry: &MapEntry, kind: QuantityKind) -> Option<Vec<f64>> {
    if entry.texts.is_empty() {
        let message = format!("`{}` is an empty list", entry.key);
        let help = format!("write at least one, e.g. `[\"{}\"]`", kind.example());
        table.mistake_at(entry.key_span.clone(), message, Some(help));
        return None;
    }
    let mut values = Vec::with_capacity(entry.texts.len());
    for (text, span) in &entry.texts {
        match kind.parse(text) {
            Ok(value) => values.push(value),
            Err(error) => quantity_mistake(table, &entry.key, &error, span),
        }
    }
    (values.len() == entry.texts.len()).then_some(values)
}

fn quantity_mistake(
    table: &mut TableReader<'_>,
    key: &str,
    error: &crate::quantity::QuantityError,
    span: &Range<usize>,
) {
    table.mistake_at(span.clone(), format!("`{key}`: {error}"), error.help());
}

/// `velocity=10 deg/s` for messages.
pub(crate) fn shown(name: &str, value: f64) -> String {
    kind_of(name).map_or_else(|| value.to_string(), |kind| kind.format(value))
}

/// A mistake about a value that a sweep does not have.
pub(crate) fn not_in_sweep(name: &str, value: f64, has: &[f64]) -> Diagnostic {
    let has: Vec<String> = has.iter().map(|&value| shown(name, value)).collect();
    Diagnostic::new(format!("there is no point with `{name}` = {}", shown(name, value)))
        .help(format!("the sweep has {}", has.join(", ")))
}
